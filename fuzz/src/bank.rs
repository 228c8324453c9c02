use starbreak::optics::Coverage;
use starbreak::optics::environment::Environment;
use starbreak::optics::physical::{PackedPattern, PhysicalOptics};
use starbreak_dataset::BankFile;

use crate::Vocabulary;

/// Bytes that mean something: long and short numbers, the magic words, widths.
pub(crate) const VOCABULARY: Vocabulary = &[
    "SBBANK\n",
    "SBBEND\n",
    "\u{0}\u{0}\u{0}\u{0}",
    "\u{0}\u{0}\u{0}\u{1}",
    "\u{1}",
    "\u{4}",
    "\u{7f}",
    "\u{7f}\u{7f}\u{7f}\u{7f}",
];

/// A pattern that is accepted survives being packed and unpacked, to the byte, and is lit as it is
/// read or refused, as when it is unpacked.
///
/// # Panics
/// If the input is a finding.
pub fn pattern(bytes: &[u8]) {
    let Ok(packed) = PackedPattern::new(bytes.to_vec()) else {
        return;
    };
    let optics = PhysicalOptics::default();
    let lit = packed.light(&LIGHT, &optics);
    let Ok(pattern) = packed.unpack() else {
        return;
    };
    let (width, height) = pattern.size();
    let is_small = width * height < 1 << 20;
    match lit {
        Ok(lit) if is_small => {
            let same = lit.maps() == pattern.light(&LIGHT, &optics).maps();
            assert!(same, "lit otherwise than unpacked");
        }
        Ok(_) => {}
        Err(error) => panic!("is unpacked, but not lit: {error}"),
    }
    let bytes = pattern.to_packed();
    let again = PackedPattern::new(bytes.clone()).and_then(|packed| packed.unpack());
    match again {
        Ok(again) => {
            assert!(again.to_packed() == bytes, "packed twice");
            if is_small {
                assert!(again.coverage() == pattern.coverage(), "another coverage");
            }
        }
        Err(error) => panic!("does not read what it wrote: {error}"),
    }
}

/// Some light.
const LIGHT: Environment = Environment {
    horizon_rgb: [0.5; 3],
    zenith_rgb: [0.4; 3],
    ground_rgb: [0.1; 3],
    cabin_low_rgb: [0.01; 3],
    cabin_high_rgb: [0.02; 3],
    sun_rgb: [1.0; 3],
};

/// A drawing that is accepted survives being packed and unpacked, to the byte.
///
/// # Panics
/// If the input is a finding.
pub fn coverage(bytes: &[u8]) {
    let Ok(coverage) = Coverage::from_packed(bytes) else {
        return;
    };
    let packed = coverage.to_packed();
    match Coverage::from_packed(&packed) {
        Ok(again) => assert!(again.to_packed() == packed, "packed twice"),
        Err(error) => panic!("does not read what it wrote: {error}"),
    }
}

/// A bank file is read or refused; what is read has the length that its index states. The
/// checksums of head, index and tail are set right first, or nothing behind them would be seen.
///
/// # Panics
/// If the input is a finding.
pub fn bank(bytes: &[u8]) {
    let mut bytes = bytes.to_vec();
    set_checksums(&mut bytes);
    let name = format!("starbreak-fuzz-{}.bank", std::process::id());
    let path = std::env::temp_dir().join(name);
    if std::fs::write(&path, &bytes).is_err() {
        return;
    }
    if let Ok(bank) = BankFile::open(&path) {
        let n_bytes: usize = (0..bank.n_records())
            .filter_map(|idx| bank.read(idx).ok())
            .map(|record| record.len())
            .sum();
        assert!(
            n_bytes <= 256 * bytes.len(),
            "{n_bytes} bytes out of {}",
            bytes.len()
        );
        let _ = bank.check(|_, _| true);
    }
    // What cannot be removed is written over by the next one.
    let _ = std::fs::remove_file(&path);
}

/// As far as the file has the parts that they are of.
fn set_checksums(bytes: &mut [u8]) -> Option<()> {
    let tail = bytes.len().checked_sub(36)?;
    let index = usize::try_from(u64::from_le_bytes(*bytes.get(tail..)?.first_chunk()?)).ok()?;
    let n_header = u32::from_le_bytes(*bytes.get(12..)?.first_chunk()?) as usize;
    let head_crc = crc(bytes.get(..n_header.checked_add(16)?)?);
    let index_crc = crc(bytes.get(index..tail)?);
    bytes
        .get_mut(tail + 16..tail + 20)?
        .copy_from_slice(&head_crc);
    bytes
        .get_mut(tail + 20..tail + 24)?
        .copy_from_slice(&index_crc);
    let tail_crc = crc(bytes.get(tail..tail + 24)?);
    bytes
        .get_mut(tail + 24..tail + 28)?
        .copy_from_slice(&tail_crc);
    Some(())
}

/// CRC-32 of IEEE 802.3.
fn crc(bytes: &[u8]) -> [u8; 4] {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0xedb8_8320 * (crc & 1));
        }
    }
    (!crc).to_le_bytes()
}
