//! What the tests of this crate share.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![allow(
    dead_code,
    clippy::allow_attributes,
    reason = "not every test uses all of it"
)]

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use starbreak_dataset::sha256_hex;

/// A file or folder of the reference cases; `data/pack.py` says what made them.
pub(crate) fn reference(name: &str) -> PathBuf {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(unpacked);
    let path = FOLDER.join(name);
    assert!(path.exists(), "the archive has no {name}");
    path
}

/// The archive, unpacked once for all tests.
fn unpacked() -> PathBuf {
    let archive = include_bytes!("../data/reference.zz");
    let entries = miniz_oxide::inflate::decompress_to_vec_zlib(archive).unwrap();
    let target = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = target.join(format!("reference-{}", sha256_hex(archive)));
    if folder.exists() {
        return folder;
    }
    let made = tempfile::tempdir_in(target).unwrap();
    let mut rest = entries.as_slice();
    while let Some((lengths, after)) = rest.split_first_chunk::<8>() {
        let length = |k: usize| u32::from_le_bytes(lengths[k..k + 4].try_into().unwrap()) as usize;
        let (name, after) = after.split_at(length(0));
        let (content, after) = after.split_at(length(4));
        let path = made.path().join(std::str::from_utf8(name).unwrap());
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
        rest = after;
    }
    // Another test may have been faster.
    let made = made.keep();
    if std::fs::rename(&made, &folder).is_err() {
        std::fs::remove_dir_all(&made).unwrap();
    }
    folder
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
