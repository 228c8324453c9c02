//! Which paths lead to the same file.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::fs;

use starbreak_dataset::same_file;

#[test]
fn spellings_links_and_missing_files() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    fs::create_dir_all(at("real/sub")).unwrap();
    fs::write(at("real/a"), b"same").unwrap();
    fs::write(at("real/b"), b"same").unwrap();
    let mut same = vec![
        ("real/a", "real/./sub/../a", true),
        ("real/a", "real/b", false),
        ("real/a", "real/missing", false),
        ("real/missing", "real/missing", true),
        ("real/missing", "real/sub/../missing", true),
        ("real/new/deep/x", "real/new/./deep/x", true),
        ("real/new/x", "real/new/y", false),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at("real"), at("link")).unwrap();
        std::os::unix::fs::symlink(at("real/a"), at("alias")).unwrap();
        std::os::unix::fs::symlink(at("real/sub"), at("down")).unwrap();
        fs::hard_link(at("real/a"), at("hard")).unwrap();
        same.extend([
            ("real/a", "link/a", true),
            ("real/a", "alias", true),
            ("real/a", "hard", true),
            ("alias", "hard", true),
            ("real/b", "hard", false),
            ("real/missing", "link/missing", true),
            ("real/new/x", "link/new/x", true),
            // The parent of the link's target, not of the link.
            ("real/missing", "down/../missing", true),
            ("missing", "down/../missing", false),
        ]);
    }
    for (a, b, expected) in same {
        assert_eq!(same_file(&at(a), &at(b)), expected, "{a} and {b}");
        assert_eq!(same_file(&at(b), &at(a)), expected, "{b} and {a}");
    }
}

#[test]
fn relative_and_absolute() {
    let relative = std::path::Path::new("Cargo.toml");
    let absolute = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    assert!(
        same_file(relative, &absolute),
        "tests run in the folder of the crate"
    );
}
