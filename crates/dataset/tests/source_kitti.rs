//! KITTI as a dataset.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use common::{contents, open, png, put, shared_data};

const CAR: &str =
    "Car 0.00 0 -1.67 657.39 190.13 700.07 223.39 1.41 1.58 4.36 3.18 2.27 34.38 -1.58";

#[test]
fn real_frames_have_the_boxes_of_their_label_files() {
    let Some(path) = shared_data("kitti") else {
        return;
    };
    let found = contents(&open("kitti", &path));
    assert_eq!(
        found.images,
        [
            "image_2/000000.png",
            "image_2/000001.png",
            "image_2/000002.png"
        ],
        "images"
    );
    // One line per object.
    let n_lines: usize = ["000000", "000001", "000002"]
        .map(|frame| path.join(format!("label_2/{frame}.txt")))
        .map(|path| std::fs::read_to_string(path).unwrap().lines().count())
        .iter()
        .sum();
    assert_eq!(found.objects.len(), n_lines, "objects");
    assert_eq!(
        found.objects.last().unwrap(),
        "label_2/000002.txt:2 Car Regular 657.39 190.13 700.07 223.39",
        "the last"
    );
    assert!(
        found
            .objects
            .iter()
            .any(|o| o.contains(" DontCare Ignored ")),
        "{:?}",
        found.objects
    );
    assert_eq!(found.problems, [""; 0], "problems");
    assert_eq!(
        found.files[3..],
        [
            "label_2/000000.txt -> image_2/000000.png",
            "label_2/000001.txt -> image_2/000001.png",
            "label_2/000002.txt -> image_2/000002.png",
        ],
        "labels after three files of calib"
    );
}

#[test]
fn a_mark_of_utf_8_is_no_part_of_a_type() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "image_2/000000.png", png(8, 4));
    let label = format!("\u{feff}{CAR}\n");
    put(dir.path(), "label_2/000000.txt", label);
    let found = contents(&open("kitti", dir.path()));
    assert_eq!(
        found.objects,
        ["label_2/000000.txt:1 Car Regular 657.39 190.13 700.07 223.39"],
        "objects"
    );
    assert_eq!(found.problems, [""; 0], "problems");
}

#[test]
fn both_parts_and_all_cameras_are_read() {
    let dir = tempfile::tempdir().unwrap();
    for name in [
        "training/image_2/000000.png",
        "training/image_3/000000.png",
        "training/prev_2/000000_01.png",
        "testing/image_2/000000.PNG",
        "testing/image_2/more/x.png",
    ] {
        put(dir.path(), name, png(2, 2));
    }
    put(
        dir.path(),
        "training/label_2/000000.txt",
        format!("{CAR}\n"),
    );
    put(dir.path(), "training/calib/000000.txt", "P0: 1");
    put(dir.path(), "training/velodyne/000000.bin", "");
    put(dir.path(), "ImageSets/val.txt", "000000\n");
    let found = contents(&open("kitti", dir.path()));
    assert_eq!(
        found.images,
        [
            "testing/image_2/000000.PNG",
            "training/image_2/000000.png",
            "training/image_3/000000.png",
        ],
        "images"
    );
    assert_eq!(found.objects.len(), 1, "the labels are those of image_2");
    assert_eq!(found.problems, [""; 0], "testing has no labels");
    assert_eq!(
        found.files,
        [
            "ImageSets/val.txt",
            "testing/image_2/more/x.png",
            "training/calib/000000.txt",
            "training/label_2/000000.txt -> training/image_2/000000.png",
            "training/prev_2/000000_01.png",
            "training/velodyne/000000.bin",
        ],
        "others"
    );
}

#[test]
fn bad_labels_are_named_by_line_and_good_ones_stay() {
    let dir = tempfile::tempdir().unwrap();
    for frame in 0..4 {
        put(dir.path(), &format!("image_2/{frame}.png"), png(2, 2));
    }
    let with_score = format!("{CAR} 0.9");
    let dont_care = "DontCare -1 -1 -10 503.89 169.71 590.61 190.13 -1 -1 -1 -1000 -1000 -1000 -10";
    let short = CAR.rsplit_once(' ').unwrap().0;
    let not_a_number = CAR.replace("657.39", "6x");
    let infinite = CAR.replace("657.39", "inf");
    let reversed = CAR.replace("657.39", "757.39");
    let lines = [
        CAR,
        "",
        &with_score,
        dont_care,
        short,
        &not_a_number,
        &infinite,
        &reversed,
    ];
    put(dir.path(), "label_2/0.txt", lines.join("\r\n"));
    put(dir.path(), "label_2/1.txt", b"\xff\xfe");
    put(dir.path(), "label_2/2.txt", "");
    put(dir.path(), "label_2/9.txt", CAR);
    let found = contents(&open("kitti", dir.path()));
    assert_eq!(found.images.len(), 4, "images");
    assert_eq!(
        found.objects,
        [
            "label_2/0.txt:1 Car Regular 657.39 190.13 700.07 223.39",
            "label_2/0.txt:3 Car Regular 657.39 190.13 700.07 223.39",
            "label_2/0.txt:4 DontCare Ignored 503.89 169.71 590.61 190.13",
        ],
        "objects"
    );
    assert_eq!(
        found.problems,
        [
            "label_2/0.txt:5: 14 fields; expected 15, or 16 with a score",
            r#"label_2/0.txt:6: field 5 = "6x" is not a finite number within 1e9 of 0"#,
            r#"label_2/0.txt:7: field 5 = "inf" is not a finite number within 1e9 of 0"#,
            "label_2/0.txt:8: the box [757.39, 190.13, 700.07, 223.39] px ends before it begins",
            "label_2/1.txt: it is not UTF-8 text",
            "label_2/3.txt: there is no such file: the image has no label",
        ],
        "problems"
    );
    assert_eq!(
        found.bad,
        [r#"label_2/9.txt: there is no image "image_2/9.png" for this label"#],
        "a label without image"
    );
    assert!(
        found
            .files
            .contains(&"label_2/9.txt -> image_2/9.png".to_owned()),
        "{:?}",
        found.files
    );
}

#[test]
fn two_images_that_share_a_label_say_so() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "image_2/0.jpg", png(2, 2));
    put(dir.path(), "image_2/0.png", png(2, 2));
    put(dir.path(), "label_2/0.txt", CAR);
    let found = contents(&open("kitti", dir.path()));
    assert_eq!(
        found.problems,
        [r#"label_2/0.txt: it is the label of "image_2/0.jpg" as well"#],
        "problems"
    );
}

#[test]
fn second_frame_of_a_name_in_another_case_is_bad() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "image_2/000001.png", png(2, 2));
    put(dir.path(), "label_2/000001.txt", CAR);
    put(dir.path(), "image_2/000001.PNG", png(2, 2));
    let frames = std::fs::read_dir(dir.path().join("image_2")).unwrap();
    if frames.count() < 2 {
        // The file system takes both for one.
        return;
    }
    let found = contents(&open("kitti", dir.path()));
    assert_eq!(found.images, ["image_2/000001.PNG"], "the first");
    assert_eq!(
        found.bad,
        [
            "image_2/000001.png: the name differs from \"image_2/000001.PNG\" only in case; rename one of them"
        ],
        "the second"
    );
}

#[test]
fn areas_without_labels_are_known_in_any_case_of_letters() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "image_2/0.png", png(2, 2));
    let dont_care = "-1 -1 -10 503.89 169.71 590.61 190.13 -1 -1 -1 -1000 -1000 -1000 -10";
    let lines = ["dontcare", "DONTCARE", "DontCareful"].map(|name| format!("{name} {dont_care}"));
    put(dir.path(), "label_2/0.txt", lines.join("\n"));
    let found = contents(&open("kitti", dir.path()));
    let kinds = found.objects.iter().map(|o| o.contains(" Ignored "));
    assert_eq!(
        kinds.collect::<Vec<_>>(),
        [true, true, false],
        "{:?}",
        found.objects
    );
}
