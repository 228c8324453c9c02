//! YOLO as a dataset.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use common::{contents, exif, jpeg_with, open, png, put, ramp, subset, try_open};

const DATA: &str = "# mine\ntrain: images/train\nval: images/val  # small\nnames: [person, car]\n";

#[test]
fn labels_stand_in_the_same_tree_and_are_scaled_by_the_size() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "data.yaml", DATA);
    put(dir.path(), "images/train/sub/a.png", png(200, 100));
    // Upright it is 20 wide and 40 high.
    let turned = jpeg_with(&ramp(40, 20), |encoder| {
        let block = [b"Exif\0\0", exif(6).as_slice()].concat();
        encoder.add_app_segment(1, block).unwrap();
    });
    put(dir.path(), "images/val/b.jpg", turned);
    put(dir.path(), "images/val/background.png", png(2, 2));
    put(
        dir.path(),
        "labels/train/sub/a.txt",
        "0 0.5 0.5 0.25 0.5\n1 0 0 0.5 0 0.5 0.25\n",
    );
    put(dir.path(), "labels/val/b.txt", "1 0.5 0.5 1 1");
    put(dir.path(), "labels/classes.txt", "person\ncar\n");
    let source = open("yolo", dir.path());
    let found = contents(&source);
    assert_eq!(
        found.images,
        [
            "images/train/sub/a.png",
            "images/val/b.jpg",
            "images/val/background.png"
        ],
        "images"
    );
    assert_eq!(
        found.objects,
        [
            "labels/train/sub/a.txt:1 person Regular 75 25 125 75",
            "labels/train/sub/a.txt:2 car Regular 0 0 100 25",
            "labels/val/b.txt:1 car Regular 0 0 20 40",
        ],
        "objects"
    );
    assert_eq!((found.bad, found.problems), (vec![], vec![]), "bad");
    assert_eq!(
        found.files,
        [
            "data.yaml (index)",
            "labels/classes.txt",
            "labels/train/sub/a.txt -> images/train/sub/a.png",
            "labels/val/b.txt -> images/val/b.jpg",
        ],
        "files"
    );
    assert_eq!(
        subset(&source, "data.yaml", |_| true),
        DATA,
        "nothing to change"
    );
}

#[test]
fn a_number_of_classes_that_the_names_belie_is_refused() {
    for (nc, is_good) in [("2", true), ("3", false), ("two", false), ("[2]", false)] {
        let dir = tempfile::tempdir().unwrap();
        put(dir.path(), "data.yaml", format!("nc: {nc}\n{DATA}"));
        put(dir.path(), "images/train/a.png", png(10, 10));
        let opened = try_open("yolo", dir.path());
        assert_eq!(opened.is_ok(), is_good, "nc: {nc}");
        if let Err(error) = opened {
            assert!(error.to_string().contains("nc "), "{error}");
        }
    }
}

#[test]
fn bad_labels_are_named_by_line_and_good_ones_stay() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "data.yaml", DATA);
    put(dir.path(), "images/train/a.png", png(10, 10));
    put(
        dir.path(),
        "images/train/a.jpg",
        jpeg_with(&ramp(20, 20), |_| {}),
    );
    put(dir.path(), "images/train/broken.png", "no image");
    put(dir.path(), "images/val/c.png", png(10, 10));
    let lines = "0 0.5 0.5 1 1\n\n2 0.5 0.5 1 1\n0 0.5 0.5\n0 5 5 2 2\n\u{ff}\n";
    put(dir.path(), "labels/train/a.txt", lines);
    put(dir.path(), "labels/train/broken.txt", "0 0.5 0.5 1 1\n");
    put(dir.path(), "labels/train/gone.txt", "0 0.5 0.5 1 1\n");
    let found = contents(&open("yolo", dir.path()));
    assert_eq!(found.images.len(), 4, "images");
    assert_eq!(found.objects.len(), 2, "one good line for two images");
    assert_eq!(
        found.bad,
        [r#"labels/train/gone.txt: there is no image "images/train/gone.*" for this label"#],
        "bad"
    );
    let of_png: Vec<&String> = found.problems.iter().skip(4).take(5).collect();
    assert_eq!(
        of_png,
        [
            r#"labels/train/a.txt: it is the label of "images/train/a.jpg" as well"#,
            "labels/train/a.txt:3: the class 2 has no name",
            "labels/train/a.txt:4: 3 fields, expected class cx cy w h, or a class and 3 or more corners x y",
            "labels/train/a.txt:5: the share 5 is outside 0 to 1",
            "labels/train/a.txt:6: 1 fields, expected class cx cy w h, or a class and 3 or more corners x y",
        ],
        "problems"
    );
    let last = found.problems.last().unwrap();
    assert!(
        last.contains("labels/train/broken.txt:1: ") && last.contains("looks like text"),
        "{last}"
    );
}

#[test]
fn lists_with_absolute_paths_are_made_relative_and_those_that_lead_out_refused() {
    let dir = tempfile::tempdir().unwrap();
    let root = dir.path().display();
    let data =
        format!("path: {root}\ntrain: {root}/train.txt\nval: ../elsewhere\nnames: {{0: x}}\n");
    put(dir.path(), "data.yaml", data);
    for name in ["a", "b", "c d", "e"] {
        put(dir.path(), &format!("images/{name}.png"), png(2, 2));
        put(dir.path(), &format!("labels/{name}.txt"), "");
    }
    let list = format!(
        "{root}/images/a.png\r\n./images/b.png\nimages/c d.png\n{root}/../x.png\n/etc/x.png\n\
         ../x.png\n./images/b.png\nimages/gone.png\n"
    );
    put(dir.path(), "train.txt", list);
    let source = open("yolo", dir.path());
    let found = contents(&source);
    assert_eq!(
        found.images,
        ["images/a.png", "images/b.png", "images/c d.png"],
        "images"
    );
    assert_eq!(found.bad.len(), 6, "{:?}", found.bad);
    assert_eq!(
        found.bad[0], "data.yaml: val: there is no \"../elsewhere\"",
        "val"
    );
    assert!(
        found.bad[5].contains("images/gone.png: there is no such file"),
        "{:?}",
        found.bad
    );
    // It is there, in no part, and so is its label: both go along as they are.
    assert!(
        found.files.contains(&"images/e.png".to_owned()),
        "{:?}",
        found.files
    );
    assert!(
        found.files.contains(&"labels/e.txt".to_owned()),
        "{:?}",
        found.files
    );
    assert_eq!(
        subset(&source, "data.yaml", |_| true),
        "\ntrain: \"train.txt\"\nval: ../elsewhere\nnames: {0: x}\n",
        "data.yaml"
    );
    assert_eq!(
        subset(&source, "train.txt", |name| name != "images/c d.png"),
        "./images/a.png\r\n./images/b.png\nimages/gone.png\n",
        "the list"
    );
}

#[test]
fn data_that_stand_elsewhere_are_found_by_their_path() {
    let dir = tempfile::tempdir().unwrap();
    put(
        dir.path(),
        "cfg/mine.yaml",
        "path: ../data\ntrain: [images/a, images/b]\nnames:\n  - x\n",
    );
    put(dir.path(), "data/images/a/1.png", png(2, 2));
    put(dir.path(), "data/images/b/1.png", png(2, 2));
    let source = open("yolo", &dir.path().join("cfg/mine.yaml"));
    let found = contents(&source);
    assert_eq!(found.images, ["images/a/1.png", "images/b/1.png"], "images");
    assert_eq!(found.files, ["mine.yaml (index)"], "files");
    assert_eq!(
        subset(&source, "mine.yaml", |_| true),
        "\ntrain: [images/a, images/b]\nnames:\n  - x\n",
        "data.yaml"
    );
    // As a widespread export writes it.
    let dir = tempfile::tempdir().unwrap();
    put(
        dir.path(),
        "data.yaml",
        "train: ../train/images\nnames: [x]\nnc: 1\n",
    );
    put(dir.path(), "train/images/1.png", png(4, 4));
    put(dir.path(), "train/labels/1.txt", "0 0.5 0.5 1 1");
    let found = contents(&open("yolo", dir.path()));
    assert_eq!(
        found.objects,
        ["train/labels/1.txt:1 x Regular 0 0 4 4"],
        "objects"
    );
}

#[test]
fn data_without_classes_or_images_are_one_clear_error() {
    let dir = tempfile::tempdir().unwrap();
    for (text, said) in [
        ("train: images\n", "it has no names of classes"),
        (
            "names: [x]\n",
            "it has none of the keys train, val and test",
        ),
        (
            "train: images\nnames: [x]\n",
            "none of train, val and test is there",
        ),
        ("train: [\n", "data.yaml\" is not a valid yolo index"),
    ] {
        put(dir.path(), "data.yaml", text);
        let error = try_open("yolo", dir.path()).unwrap_err().to_string();
        assert!(error.contains(said), "{text:?}: {error}");
        assert!(!error.contains(char::is_control), "{error:?}");
    }
}
