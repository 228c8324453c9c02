//! One record of an MCAP file: its kind, its length, and what it says.

use mcap::records::{Record, op};
use starbreak_dataset::fence;

/// What a record begins with: one byte of its kind and eight of its length.
pub(super) const HEAD: usize = 9;

/// Kind and length of a record.
pub(super) fn split(head: &[u8; HEAD]) -> (u8, u64) {
    let [opcode, length @ ..] = *head;
    (opcode, u64::from_le_bytes(length))
}

/// A record of a kind that is read here, by its content; what no record is like is told.
pub(super) fn parsed(opcode: u8, record: &[u8]) -> Result<Record<'_>, String> {
    let broken = || format!("a record of kind {opcode:#04x} is broken");
    if !texts_fit(opcode, record) {
        return Err(broken());
    }
    // Its reader indexes what it has not measured.
    match fence(|| mcap::parse_record(opcode, record)) {
        Some(Ok(record)) => Ok(record),
        Some(Err(_)) | None => Err(broken()),
    }
}

/// Whether every text of a record ends within it. The reader takes as much memory as a text claims to be long, up to
/// 4 GiB, before it looks.
fn texts_fit(opcode: u8, record: &[u8]) -> bool {
    // Bytes before the texts, texts, and whether a map of texts follows.
    let (n_before, n_texts, has_map) = match opcode {
        op::HEADER => (0, 2, false),
        op::SCHEMA => (2, 2, false),
        op::CHANNEL => (4, 2, true),
        op::CHUNK => (28, 1, false),
        op::ATTACHMENT => (16, 2, false),
        op::METADATA => (0, 1, true),
        op::FOOTER | op::MESSAGE | op::STATISTICS => return true,
        // Of no use here.
        _ => return false,
    };
    let texts = record.get(n_before..);
    let behind = texts.and_then(|texts| (0..n_texts).try_fold(texts, |rest, _| behind_text(rest)));
    behind
        .and_then(|rest| {
            if has_map {
                behind_map(rest)
            } else {
                Some(rest)
            }
        })
        .is_some()
}

/// What follows a text: four bytes say how long it is.
fn behind_text(record: &[u8]) -> Option<&[u8]> {
    let (n_bytes, rest) = record.split_first_chunk()?;
    rest.get(u32::from_le_bytes(*n_bytes) as usize..)
}

/// Most keys of a map; each takes many times the memory that it takes in the record.
const MOST_KEYS: usize = 100_000;

/// What follows a map: four bytes say how long it is, then its keys and values. None where those are too many.
fn behind_map(record: &[u8]) -> Option<&[u8]> {
    let (n_bytes, map) = record.split_first_chunk()?;
    let (mut rest, mut n_keys) = (map, 0);
    while map.len() - rest.len() < u32::from_le_bytes(*n_bytes) as usize {
        rest = behind_text(behind_text(rest)?)?;
        n_keys += 1;
    }
    (n_keys <= MOST_KEYS).then_some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Records of each kind that has texts, of length 1 or of none, and where the length of each text stands.
    const RECORDS: [(u8, &[u8], &[usize]); 6] = [
        (op::HEADER, b"\x01\0\0\0a\0\0\0\0", &[0, 5]),
        (op::SCHEMA, b"\x01\0\x01\0\0\0a\0\0\0\0\0\0\0\0", &[2, 7]),
        (
            op::CHANNEL,
            b"\0\0\0\0\x01\0\0\0a\0\0\0\0\x09\0\0\0\x01\0\0\0a\0\0\0\0",
            &[4, 9, 13, 17, 22],
        ),
        (
            op::CHUNK,
            b"0123456701234567012345670123\x01\0\0\0a\0\0\0\0\0\0\0\0",
            &[28],
        ),
        (
            op::ATTACHMENT,
            b"0123456701234567\x01\0\0\0a\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0",
            &[16, 21],
        ),
        (
            op::METADATA,
            b"\x01\0\0\0a\x09\0\0\0\x01\0\0\0a\0\0\0\0",
            &[0, 5, 9, 14],
        ),
    ];

    #[test]
    fn a_text_that_claims_more_than_its_record_is_refused_before_it_is_read() {
        for (opcode, record, texts) in RECORDS {
            assert!(texts_fit(opcode, record), "{opcode:#04x}");
            assert!(parsed(opcode, record).is_ok(), "{opcode:#04x}");
            for &at in texts {
                let mut broken = record.to_vec();
                broken[at + 3] = 0x70;
                assert!(parsed(opcode, &broken).is_err(), "{opcode:#04x} at {at}");
                assert!(!texts_fit(opcode, &broken), "{opcode:#04x} at {at}");
            }
        }
        assert!(parsed(op::METADATA_INDEX, &[0; 20]).is_err());
    }

    #[test]
    fn a_map_of_too_many_keys_is_refused() {
        let map_of = |n: u32| {
            let mut record = vec![0; 4];
            record.extend((14 * n).to_le_bytes());
            for k in 0..n {
                record.extend([6, 0, 0, 0]);
                record.extend(format!("{k:06}").bytes());
                record.extend([0; 4]);
            }
            record
        };
        assert!(parsed(op::METADATA, &map_of(100_000)).is_ok());
        assert!(parsed(op::METADATA, &map_of(100_001)).is_err());
    }
}
