//! A plain folder as a dataset.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::fs;
use std::path::Path;

use starbreak_dataset::{Source, SourceFormat, SourceSpec};

fn put(root: &Path, name: &str) {
    let path = root.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, b"x").unwrap();
}

fn open(root: &Path) -> Source {
    Source::open(&SourceSpec {
        format: SourceFormat::Folder,
        path: root.to_owned(),
    })
    .unwrap()
}

#[test]
fn images_come_in_the_order_of_the_bytes_of_their_names_and_hidden_files_do_not() {
    let dir = tempfile::tempdir().unwrap();
    for name in [
        "b.png",
        "a/z.JPG",
        "a.png",
        "a/été 1.jpeg",
        "a-b/x.png",
        "note.txt",
        ".hidden.png",
        ".starbreak-1.png",
        "a/.git/x.png",
        "new\nline.png",
    ] {
        put(dir.path(), name);
    }
    let source = open(dir.path());
    let names: Vec<_> = source.images().map(|image| image.unwrap().name).collect();
    let mut expected = vec![
        "b.png",
        "a/z.JPG",
        "a.png",
        "a/été 1.jpeg",
        "a-b/x.png",
        "new\nline.png",
    ];
    expected.sort_unstable();
    assert_eq!(names, expected, "images");
    let files: Vec<_> = source.files().map(|file| file.unwrap().name).collect();
    assert_eq!(files, ["note.txt"], "other files");
}
