//! All files of a sample or none.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]
#![expect(clippy::print_stderr, reason = "a skipped test must be seen")]

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;
use starbreak_dataset::{DatasetError, GeneratedSet, OutputBatch};
use tempfile::TempDir;

/// All that lies below the folder, sorted, relative to it.
fn tree(folder: &TempDir) -> Vec<String> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.is_symlink() {
                walk(&path, found);
            }
            found.push(path);
        }
    }
    let mut found = Vec::new();
    walk(folder.path(), &mut found);
    let relative = |path: PathBuf| {
        path.strip_prefix(folder.path())
            .unwrap()
            .to_string_lossy()
            .into_owned()
    };
    let mut tree: Vec<_> = found.into_iter().map(relative).collect();
    tree.sort();
    tree
}

fn stage_error(batch: &mut OutputBatch, path: &Path) -> String {
    let message = batch.stage(path, b"x").unwrap_err().to_string();
    assert!(
        !message.chars().any(char::is_control),
        "one line: {message:?}"
    );
    message
}

#[test]
fn files_appear_on_commit_and_not_before() {
    let dir = tempfile::tempdir().unwrap();
    let mut batch = OutputBatch::new();
    batch.stage(&dir.path().join("a/b/one.png"), b"1").unwrap();
    batch.stage(&dir.path().join("two.json"), b"2").unwrap();
    let staged = tree(&dir);
    assert_eq!(
        staged
            .iter()
            .filter(|name| name.contains(".starbreak-") && !name.ends_with(".lock"))
            .count(),
        2,
        "{staged:?}"
    );
    assert!(
        !staged.iter().any(|name| name.ends_with("one.png")),
        "{staged:?}"
    );
    batch.commit().unwrap();
    assert_eq!(
        tree(&dir),
        ["a", "a/b", "a/b/one.png", "two.json"],
        "in place"
    );
    assert_eq!(
        fs::read(dir.path().join("a/b/one.png")).unwrap(),
        b"1",
        "content"
    );
}

#[test]
fn dropped_batch_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("mine")).unwrap();
    let mut batch = OutputBatch::new();
    batch.stage(&dir.path().join("mine/x"), b"1").unwrap();
    batch.stage(&dir.path().join("new/deep/x"), b"1").unwrap();
    batch.stage(&dir.path().join("new/other/x"), b"1").unwrap();
    // What others put into a folder of ours meanwhile is to stay.
    fs::write(dir.path().join("new/other/foreign"), b"").unwrap();
    drop(batch);
    assert_eq!(
        tree(&dir),
        ["mine", "new", "new/other", "new/other/foreign"],
        "cleaned"
    );
}

#[test]
fn files_are_replaced_on_demand_and_links_not_followed() {
    let dir = tempfile::tempdir().unwrap();
    let (file, link) = (dir.path().join("file"), dir.path().join("link"));
    fs::write(&file, b"old").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(&file, &link).unwrap();
    let mut batch = OutputBatch::new().replacing(true);
    batch.stage(&link, b"new").unwrap();
    batch.commit().unwrap();
    assert_eq!(
        fs::read(&file).unwrap(),
        b"old",
        "the target of the link stays"
    );
    assert_eq!(fs::read(&link).unwrap(), b"new", "the link is replaced");

    let mut batch = OutputBatch::new().replacing(true);
    batch.stage(&file, b"new").unwrap();
    batch.commit().unwrap();
    assert_eq!(fs::read(&file).unwrap(), b"new", "replaced");
    assert_eq!(tree(&dir), ["file", "link"], "nothing else");
}

#[test]
fn failed_commit_takes_new_files_back_and_names_replaced_ones() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    fs::write(at("old"), b"old").unwrap();
    let mut batch = OutputBatch::new().replacing(true);
    for name in ["new/1", "old", "blocked", "never"] {
        batch.stage(&at(name), b"new").unwrap();
    }
    fs::create_dir(at("blocked")).unwrap();
    let error = batch.commit().unwrap_err();
    let message = error.to_string();
    let DatasetError::Commit { path, replaced, .. } = error else {
        panic!("{message}");
    };
    assert!(path.ends_with("blocked"), "{path:?}");
    assert_eq!(replaced.len(), 1, "{replaced:?}");
    assert!(
        message.contains("it is a folder; 1 existing files were already replaced"),
        "{message}"
    );
    assert_eq!(
        tree(&dir),
        ["blocked", "old"],
        "new/1 with its folder and all temporaries are gone"
    );
}

#[test]
fn same_destination_twice_in_any_spelling() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("sub")).unwrap();
    let mut batch = OutputBatch::new();
    batch.stage(&dir.path().join("x"), b"1").unwrap();
    for spelling in ["x", "./x", "sub/../x", "sub/.././x"] {
        let message = stage_error(&mut batch, &dir.path().join(spelling));
        assert!(
            message.contains("two outputs of one sample have the same path"),
            "{message}"
        );
    }
    batch.commit().unwrap();
    assert_eq!(
        fs::read(dir.path().join("x")).unwrap(),
        b"1",
        "the first is kept"
    );
    assert_eq!(tree(&dir), ["sub", "x"], "no temporaries");
}

#[test]
fn destinations_that_cannot_be_files() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("folder")).unwrap();
    fs::write(dir.path().join("file"), b"x").unwrap();
    let mut batch = OutputBatch::new();
    for (name, part) in [
        ("folder", "it is a folder; give the path of a file"),
        ("folder/", "it is the name of a folder"),
        ("new/", "it is the name of a folder"),
        ("new/.", "it is the name of a folder"),
        ("new/..", "it is the name of a folder"),
        ("file/x.png", "a part of the path is a file, not a folder"),
        (
            "file/deep/x.png",
            "a part of the path is a file, not a folder",
        ),
    ] {
        let message = stage_error(&mut batch, &dir.path().join(name));
        assert!(message.contains(part), "{name}: {message}");
    }
    let long = stage_error(&mut batch, &dir.path().join("n".repeat(300)).join("x"));
    assert!(long.contains("the file name is too long"), "{long}");
    let empty = stage_error(&mut batch, Path::new(""));
    assert!(empty.contains("it is the name of a folder"), "{empty}");
    #[cfg(unix)]
    {
        let device = stage_error(&mut batch, Path::new("/dev/null"));
        assert!(device.contains("it is a device"), "{device}");
    }
    drop(batch);
    assert_eq!(tree(&dir), ["file", "folder"], "nothing is left");
}

#[cfg(unix)]
#[test]
fn results_have_ordinary_permissions() {
    use std::os::unix::fs::PermissionsExt as _;
    let dir = tempfile::tempdir().unwrap();
    let mode = |name: &str| {
        fs::metadata(dir.path().join(name))
            .unwrap()
            .permissions()
            .mode()
    };
    fs::write(dir.path().join("plain"), b"").unwrap();
    let mut batch = OutputBatch::new();
    batch.stage(&dir.path().join("ours"), b"").unwrap();
    batch.commit().unwrap();
    assert_eq!(
        mode("ours"),
        mode("plain"),
        "as any new file, less the umask"
    );
}

#[cfg(unix)]
#[test]
fn folder_that_may_not_be_written() {
    use std::os::unix::fs::PermissionsExt as _;
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("locked");
    fs::create_dir(&folder).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(folder.join("probe"), b"").is_ok() {
        eprintln!("SKIPPED: this user may write everywhere");
        return;
    }
    let mut batch = OutputBatch::new();
    for name in ["x.png", "new/x.png"] {
        let message = stage_error(&mut batch, &folder.join(name));
        assert!(
            message.contains("permission denied; check the permissions"),
            "{message}"
        );
    }
}

/// On a small file system whose path is in `STARBREAK_SMALL_DISK` (64 KiB, say a tmpfs).
#[test]
fn full_disk() {
    let Some(disk) = std::env::var_os("STARBREAK_SMALL_DISK") else {
        eprintln!("SKIPPED: STARBREAK_SMALL_DISK is not set");
        return;
    };
    let dir = tempfile::tempdir_in(disk).unwrap();
    let mut batch = OutputBatch::new();
    batch.stage(&dir.path().join("a/small"), b"x").unwrap();
    let error = batch
        .stage(&dir.path().join("a/large"), &vec![1; 1 << 20])
        .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("no space left on the device; free some space"),
        "{error}"
    );
    assert_eq!(
        tree(&dir).len(),
        2,
        "the folder and the small file's temporary: {:?}",
        tree(&dir)
    );
    drop(batch);
    assert!(tree(&dir).is_empty(), "{:?}", tree(&dir));
}

#[test]
fn batches_that_share_new_folders_do_not_disturb_each_other() {
    let dir = tempfile::tempdir().unwrap();
    std::thread::scope(|scope| {
        for worker in 0..8 {
            let root = dir.path();
            scope.spawn(move || {
                for sample in 0..300 {
                    // Created and removed again all the time, by all.
                    let mut batch = OutputBatch::new_unsynced();
                    batch
                        .stage(&root.join("gone/x").join(format!("{worker}")), b"x")
                        .unwrap();
                    if sample % 10 == 0 {
                        let kept = root.join("kept").join(format!("{worker}-{sample}"));
                        let mut batch = OutputBatch::new_unsynced();
                        batch.stage(&kept, b"x").unwrap();
                        batch.commit().unwrap();
                    }
                }
            });
        }
    });
    let tree = tree(&dir);
    let n_kept = tree.iter().filter(|name| name.contains('-')).count();
    assert_eq!(
        n_kept,
        8 * 30,
        "the committed files, no temporaries: {tree:?}"
    );
    // Empty folders may stay, where their maker left while others were inside.
    assert!(
        tree.iter()
            .all(|name| name.starts_with("kept") || name.starts_with("gone")),
        "{tree:?}"
    );
}

#[test]
fn batches_of_a_set_find_folders_that_others_remove() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path();
    let set = GeneratedSet::begin(root, 1, &json!({})).unwrap();
    std::thread::scope(|scope| {
        for worker in 0..8 {
            let set = &set;
            scope.spawn(move || {
                for sample in 0..300 {
                    let mut dropped = set.batch();
                    let path = root.join("shared/x").join(format!("{worker}"));
                    dropped.stage(&path, b"x").unwrap();
                    drop(dropped);
                    if sample % 10 == 0 {
                        let kept = root.join("kept").join(format!("{worker}-{sample}"));
                        let mut batch = set.batch();
                        batch.stage(&kept, b"x").unwrap();
                        batch.commit().unwrap();
                        fs::remove_file(&kept).unwrap();
                        // Fails where another has a file in it.
                        let _ = fs::remove_dir(root.join("kept"));
                    }
                }
            });
        }
    });
    let left: Vec<String> = tree(&dir)
        .into_iter()
        .filter(|name| name.contains('-') || name.contains(".starbreak-"))
        .collect();
    assert!(left.is_empty(), "no file, no temporary: {left:?}");
}

#[test]
fn batch_of_a_set_refuses_what_every_batch_refuses() {
    let dir = tempfile::tempdir().unwrap();
    let set = GeneratedSet::begin(dir.path(), 1, &json!({})).unwrap();
    fs::create_dir(dir.path().join("folder")).unwrap();
    let mut first = set.batch();
    first.stage(&dir.path().join("sub/x"), b"1").unwrap();
    first.commit().unwrap();
    let mut batch = set.batch();
    batch.stage(&dir.path().join("sub/x"), b"2").unwrap();
    for (name, part) in [
        (
            "sub/../sub/x",
            "two outputs of one sample have the same path",
        ),
        ("folder", "it is a folder; give the path of a file"),
        ("sub/x/y", "a part of the path is a file, not a folder"),
    ] {
        let message = stage_error(&mut batch, &dir.path().join(name));
        assert!(message.contains(part), "{name}: {message}");
    }
    batch.commit().unwrap();
    assert_eq!(fs::read(dir.path().join("sub/x")).unwrap(), b"2", "put");
    fs::remove_dir_all(dir.path().join("sub")).unwrap();
    let mut batch = set.batch();
    batch.stage(&dir.path().join("sub/x"), b"3").unwrap();
    drop(batch);
    assert!(
        !dir.path().join("sub").exists(),
        "its own folder is removed"
    );
}
