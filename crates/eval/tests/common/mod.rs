//! What the tests of this crate share.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![allow(
    dead_code,
    clippy::allow_attributes,
    reason = "not every test uses all of it"
)]

use std::path::{Path, PathBuf};

/// A file or folder of the reference cases, or `None` with a note on the error output.
pub(crate) fn reference(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/reference/eval"
    ))
    .join(name);
    if path.exists() {
        return Some(path);
    }
    #[expect(clippy::print_stderr, reason = "a skipped test must be seen")]
    {
        eprintln!("SKIPPED: {} is not there", path.display());
    }
    None
}

pub(crate) fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// The numbers of a NumPy file of 64-bit floats.
pub(crate) fn npy(path: &Path) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap();
    let (header, numbers) =
        bytes.split_at(10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]])));
    let header = String::from_utf8_lossy(&header[10..]).into_owned();
    assert!(
        header.contains("'<f8'") && header.contains("False"),
        "{header}"
    );
    let words = numbers.chunks_exact(8);
    words
        .map(|word| f64::from_le_bytes(word.try_into().unwrap()))
        .collect()
}

/// Both are the same to the last bit; 0 and -0 are the same.
pub(crate) fn assert_same(ours: &[f64], theirs: &[f64], what: &str) {
    assert_eq!(ours.len(), theirs.len(), "{what}: as many numbers");
    let differ = |(a, b): &(&f64, &f64)| (**a + 0.0).to_bits() != (**b + 0.0).to_bits();
    let pairs = || ours.iter().zip(theirs);
    let worst = pairs().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let n_differ = pairs().filter(differ).count();
    let first = pairs().enumerate().find(|(_, pair)| differ(pair));
    assert!(
        n_differ == 0,
        "{what}: {n_differ} of {} numbers differ, by {worst:e} at most, first {first:?}",
        ours.len()
    );
}
