//! Bank files: every kind of damage is found and named, and nothing else is read.
#![expect(clippy::unwrap_used, reason = "a test that cannot set up has failed")]

use std::fs;
use std::path::Path;
use std::thread;

use starbreak_dataset::{BankFault, BankFile, BankRecord, BankWriter, DatasetError, OutputBatch};

const HEADER: &[u8] = b"{\"schema\":\"test/1\"}";

/// Bytes that do and do not compress, and none at all.
fn records() -> Vec<Vec<u8>> {
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 24) as u8
    };
    vec![
        vec![7; 5000],
        (0..3000).map(|_| noise()).collect(),
        Vec::new(),
        b"the last one".to_vec(),
    ]
}

fn write(path: &Path, records: &[Vec<u8>]) -> String {
    let mut writer = BankWriter::create(OutputBatch::new().replacing(true), path, HEADER).unwrap();
    for record in records {
        writer.append(&BankRecord::new(record.clone())).unwrap();
    }
    let written = writer.finish().unwrap();
    let sha256 = written.sha256().to_owned();
    let n_bytes = written.n_bytes();
    written.commit(&[]).unwrap();
    assert_eq!(fs::metadata(path).unwrap().len(), n_bytes, "stated length");
    sha256
}

/// Opens a file and reads all of it, as `--check` does.
fn check(path: &Path) -> Result<(), DatasetError> {
    BankFile::open(path)?.check(|_, _| true)
}

fn fault(path: &Path) -> BankFault {
    match check(path) {
        Err(DatasetError::Bank { fault, .. }) => fault,
        other => panic!("expected a fault of the bank, not {other:?}"),
    }
}

#[test]
fn records_are_read_in_any_order_by_many_threads() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new").join("a.bank");
    let sha256 = write(&path, &records());
    let bank = BankFile::open(&path).unwrap();
    assert_eq!(bank.header(), HEADER, "the header as it was");
    assert_eq!(bank.n_records(), 4, "all records");
    assert_eq!(bank.sha256(), sha256, "the digest as written");
    assert!(bank.n_bytes() < 4000, "5000 equal bytes are compressed");
    thread::scope(|scope| {
        for start in 0..4 {
            let bank = &bank;
            scope.spawn(move || {
                for k in 0..400 {
                    let idx = (start * 3 + k) % 4;
                    assert!(bank.read(idx).unwrap() == records()[idx], "record {idx}");
                }
            });
        }
    });
    let missing = bank.read(4).unwrap_err().to_string();
    assert!(missing.contains("no record 4, only 4"), "{missing}");
    check(&path).unwrap();
}

#[test]
fn files_beside_a_bank_appear_with_it_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("new").join("a.bank");
    let mut writer = BankWriter::create(OutputBatch::new().replacing(true), &to, HEADER).unwrap();
    writer.append(&BankRecord::new(vec![1; 10])).unwrap();
    drop(writer);
    assert_eq!(
        folder.path().read_dir().unwrap().count(),
        0,
        "dropped while written"
    );
    let written = BankWriter::create(OutputBatch::new().replacing(true), &to, HEADER)
        .unwrap()
        .finish()
        .unwrap();
    let table = folder.path().join("new").join("table.csv");
    written
        .commit(&[(table.clone(), b"a,b\n".to_vec())])
        .unwrap();
    assert_eq!(fs::read(&table).unwrap(), b"a,b\n", "the table");
    assert_eq!(BankFile::open(&to).unwrap().n_records(), 0, "an empty bank");
    assert_eq!(
        to.parent().unwrap().read_dir().unwrap().count(),
        2,
        "nothing else"
    );
}

#[test]
fn a_flipped_byte_anywhere_is_found_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bank");
    write(&path, &records());
    let whole = fs::read(&path).unwrap();
    let stored: Vec<usize> = records()
        .into_iter()
        .map(|record| BankRecord::new(record).n_stored())
        .collect();
    let first = 16 + HEADER.len();
    let index = first + stored.iter().sum::<usize>();
    let tail = whole.len() - 36;
    for at in 0..whole.len() {
        // Either end of the byte, by turns.
        let mut damaged = whole.clone();
        damaged[at] ^= if at % 2 == 0 { 0x01 } else { 0x80 };
        fs::write(&path, &damaged).unwrap();
        let fault = fault(&path);
        let as_named = match at {
            0..8 => fault == BankFault::NotABank,
            8..12 => matches!(
                fault,
                BankFault::NewerVersion { .. } | BankFault::Inconsistent { part: "head", .. }
            ),
            12..16 => matches!(
                fault,
                BankFault::Damaged { part: "header" }
                    | BankFault::Inconsistent { part: "head", .. }
            ),
            _ if at < first => fault == BankFault::Damaged { part: "header" },
            _ if at < index => {
                let mut end = first;
                let idx = stored.iter().position(|n| {
                    end += n;
                    at < end
                });
                matches!(fault, BankFault::Record { idx: found, n_records: 4, why: "wrong checksum" } if Some(found) == idx)
            }
            _ if at < tail => fault == BankFault::Damaged { part: "index" },
            _ if at < tail + 28 => fault == BankFault::Damaged { part: "tail" },
            _ => fault == BankFault::NoEnd,
        };
        assert!(as_named, "byte {at} of {}: {fault}", whole.len());
    }
}

#[test]
fn a_file_cut_short_anywhere_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bank");
    write(&path, &records());
    let whole = fs::read(&path).unwrap();
    for n in 0..whole.len() {
        fs::write(&path, &whole[..n]).unwrap();
        let fault = fault(&path);
        let expected = if n < 8 {
            BankFault::NotABank
        } else {
            BankFault::NoEnd
        };
        assert_eq!(fault, expected, "{n} of {} bytes", whole.len());
    }
    let longer = [whole.as_slice(), b"more"].concat();
    fs::write(&path, longer).unwrap();
    assert_eq!(fault(&path), BankFault::NoEnd, "bytes behind the end");
}

#[test]
fn a_file_that_becomes_shorter_while_it_is_open_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bank");
    write(&path, &records());
    let bank = BankFile::open(&path).unwrap();
    fs::OpenOptions::new()
        .write(true)
        .open(&path)
        .unwrap()
        .set_len(200)
        .unwrap();
    let message = bank.read(1).unwrap_err().to_string();
    assert!(message.contains("record 1 of 4"), "{message}");
    assert!(message.contains("has become shorter"), "{message}");
}

#[test]
fn lengths_that_cannot_be_are_refused_though_their_checksums_fit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bank");
    write(&path, &records());
    let whole = fs::read(&path).unwrap();
    let tail = whole.len() - 36;
    let index = u64::from_le_bytes(whole[tail..tail + 8].try_into().unwrap());
    let index = usize::try_from(index).unwrap();
    let forged = |at: usize, bytes: &[u8]| {
        let mut forged = whole.clone();
        forged[at..at + bytes.len()].copy_from_slice(bytes);
        let crc = crc32fast::hash(&forged[index..tail]);
        forged[tail + 20..tail + 24].copy_from_slice(&crc.to_le_bytes());
        let crc = crc32fast::hash(&forged[tail..tail + 24]);
        forged[tail + 24..tail + 28].copy_from_slice(&crc.to_le_bytes());
        fs::write(&path, &forged).unwrap();
        fault(&path).to_string()
    };
    for (at, bytes, named) in [
        // Lengths of record 0, stored and not; the offset of record 1.
        (
            index + 8,
            &[0xff; 4][..],
            "record 0 of 4 is damaged: it is longer than",
        ),
        (
            index + 12,
            &[0xff; 4],
            "record 0 of 4 is damaged: it is longer than",
        ),
        (
            index + 12,
            &[0, 0, 0, 0x0f],
            "record 0 of 4 is damaged: its lengths",
        ),
        (
            index + 12,
            &[0x89, 0x13, 0, 0],
            "does not decompress to its length",
        ),
        (
            index + 20,
            &[0xff; 8],
            "record 1 of 4 is damaged: it does not begin",
        ),
        (tail, &[0xff; 8], "its tail is damaged: the index"),
        (tail + 8, &[0xff; 8], "its tail is damaged: the index"),
        (tail + 8, &[5], "its tail is damaged: the index"),
    ] {
        let message = forged(at, bytes);
        assert!(message.contains(named), "{at} {bytes:?}: {message}");
    }
    let mut swapped = whole.clone();
    swapped[index..tail].rotate_right(20);
    let crc = crc32fast::hash(&swapped[index..tail]);
    swapped[tail + 20..tail + 24].copy_from_slice(&crc.to_le_bytes());
    let crc = crc32fast::hash(&swapped[tail..tail + 24]);
    swapped[tail + 24..tail + 28].copy_from_slice(&crc.to_le_bytes());
    fs::write(&path, &swapped).unwrap();
    assert!(
        matches!(fault(&path), BankFault::Record { idx: 0, .. }),
        "a shifted index"
    );
}

#[test]
fn a_later_version_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bank");
    write(&path, &records());
    let mut bytes = fs::read(&path).unwrap();
    bytes[8] = 2;
    fs::write(&path, bytes).unwrap();
    let message = check(&path).unwrap_err().to_string();
    assert!(
        message.contains("format version 2; this program reads up to 1"),
        "{message}"
    );
    assert!(!message.contains('\n'), "{message}");
}

#[test]
fn other_files_are_no_banks() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bank");
    assert!(
        matches!(check(&path), Err(DatasetError::Read { .. })),
        "absent"
    );
    assert!(
        matches!(check(folder.path()), Err(DatasetError::NotAFile { .. })),
        "a folder"
    );
    for bytes in [
        &b""[..],
        b"hello",
        &[0; 500],
        b"\x89PNG\r\n\x1a\n0000000000000000000",
    ] {
        fs::write(&path, bytes).unwrap();
        assert_eq!(fault(&path), BankFault::NotABank, "{bytes:?}");
    }
}
