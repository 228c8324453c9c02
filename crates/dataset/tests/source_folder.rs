//! A plain folder, a text list, and the words that name datasets.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use std::ffi::OsStr;

use common::{contents, open, png, put, subset, try_open};
use starbreak_dataset::SourceSpec;

#[test]
fn images_come_in_the_order_of_the_bytes_of_their_names_and_hidden_files_do_not() {
    let dir = tempfile::tempdir().unwrap();
    let mut names = [
        "b.png",
        "a/z.JPG",
        "a.png",
        "a/été 1.jpeg",
        "a-b/x.png",
        "new\nline.png",
    ];
    for name in names {
        put(dir.path(), name, "");
    }
    for name in [
        "note.txt",
        ".hidden.png",
        ".starbreak-1.png",
        "a/.git/x.png",
    ] {
        put(dir.path(), name, "");
    }
    names.sort_unstable();
    let found = contents(&open("folder", dir.path()));
    assert_eq!(found.images, names, "images");
    assert_eq!(found.files, ["note.txt"], "other files");
    assert_eq!(found.bad, [""; 0], "bad records");
}

#[test]
#[cfg(unix)]
fn links_within_are_followed_and_loops_and_ways_out_are_not() {
    use std::os::unix::fs::symlink;
    let dir = tempfile::tempdir().unwrap();
    let elsewhere = tempfile::tempdir().unwrap();
    put(elsewhere.path(), "deep/1.png", "");
    put(dir.path(), "a/0.png", "");
    symlink(elsewhere.path(), dir.path().join("linked")).unwrap();
    symlink("a/0.png", dir.path().join("file.png")).unwrap();
    symlink("..", dir.path().join("a/up")).unwrap();
    symlink("self", dir.path().join("self")).unwrap();
    symlink("gone.png", dir.path().join("nowhere.png")).unwrap();

    let found = contents(&open("folder", dir.path()));
    assert_eq!(found.images, ["a/0.png", "file.png"], "images");
    assert_eq!(
        found.bad,
        [
            "a/up: a link back to a folder that holds it; remove the link",
            "nowhere.png: a link that leads nowhere",
        ],
        "bad"
    );
    let [linked, own] = &found.bad_files[..] else {
        panic!("{:?}", found.bad_files);
    };
    assert!(
        linked.starts_with("linked: a link that leads out of the folder"),
        "{linked}"
    );
    assert!(own.starts_with("self: "), "{own}");
}

#[test]
fn a_list_names_images_inside_its_folder() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["b/1.png", "a b.jpg", "c.png", "C.png", "other.png"] {
        put(dir.path(), name, "");
    }
    let list = "# mine\r\nb/1.png\r\n\na b.jpg\n./c.png\nC.png\nc.png\n../x.png\n/etc/x.png\n\
                gone.png\nb\nd\\e.png\n";
    put(dir.path(), "list.txt", list);
    let source = open("list", &dir.path().join("list.txt"));
    let found = contents(&source);
    assert_eq!(found.images, ["C.png", "a b.jpg", "b/1.png"], "images");
    assert_eq!(found.files, ["list.txt (index)"], "the list alone");
    assert_eq!(
        found.bad,
        [
            r#"list.txt:8: the name "../x.png" leads out with '..'; make it relative to the dataset"#,
            r#"list.txt:9: the name "/etc/x.png" is absolute; make it relative to the dataset"#,
            r#"list.txt:11: "b" is neither PNG nor JPEG by its name"#,
            r#"list.txt:12: the name "d\\e.png" holds a backslash; write it with '/'"#,
            r#"list.txt:7: "c.png" is listed twice"#,
            r#"list.txt:5: "c.png": the name differs from "C.png" only in case; rename one of them"#,
            r#"list.txt:10: image "gone.png": there is no such file"#,
        ],
        "bad"
    );
    let text = subset(&source, "list.txt", |name| {
        name.starts_with('b') || name == "C.png"
    });
    assert_eq!(text, "# mine\r\nb/1.png\r\n\nC.png\n", "a part");
}

#[test]
fn a_list_with_lines_that_are_no_text_is_read_on() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "1.png", "");
    let mut list = b"\xef\xbb\xbf1.png\n\xff.png\n".to_vec();
    list.extend(vec![b'x'; 200_000]);
    list.extend(b"\n# end");
    put(dir.path(), "list.txt", list);
    let found = contents(&open("list", &dir.path().join("list.txt")));
    assert_eq!(found.images, ["1.png"], "images");
    assert_eq!(
        found.bad,
        [
            "list.txt:2: the line is not UTF-8 text",
            "list.txt:3: the line is longer than 65536 bytes",
        ],
        "bad"
    );
}

#[test]
fn a_word_without_a_format_is_refused_with_the_likely_one() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "training/image_2/0.png", png(2, 2));
    for (word, said) in [
        ("x".to_owned(), "expected kitti:DIR"),
        ("voc:x".to_owned(), "does not begin with the format"),
        ("coco:".to_owned(), "has no path after the colon"),
        (dir.path().display().to_string(), "did you mean \"kitti:"),
        (
            format!("kiti:{}", dir.path().display()),
            "did you mean \"kitti:",
        ),
    ] {
        let error = SourceSpec::parse(OsStr::new(&word))
            .unwrap_err()
            .to_string();
        assert!(error.contains(said), "{word}: {error}");
    }
    let spec = SourceSpec::parse(OsStr::new("folder:a:b")).unwrap();
    assert_eq!(spec.path.to_str(), Some("a:b"), "the first colon counts");
}

#[test]
fn a_path_that_is_not_of_the_format_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "file", "x");
    let file = dir.path().join("file");
    let gone = dir.path().join("gone");
    for format in ["kitti", "coco", "bdd", "yolo", "folder", "list"] {
        for path in [&gone, &file, &dir.path().to_owned()] {
            if (format == "folder" && path == dir.path()) || (format == "list" && path == &file) {
                continue;
            }
            let error = try_open(format, path).unwrap_err().to_string();
            assert!(!error.contains(char::is_control), "{error:?}");
        }
    }
}
