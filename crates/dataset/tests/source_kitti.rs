//! KITTI as a dataset.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

mod common;

use common::shared_data;
use starbreak_dataset::{FileRole, Source, SourceFormat, SourceSpec};

#[test]
fn real_frames_have_the_boxes_of_their_label_files() {
    let Some(path) = shared_data("kitti") else {
        return;
    };
    let source = Source::open(&SourceSpec {
        format: SourceFormat::Kitti,
        path,
    })
    .unwrap();
    let images: Vec<_> = source.images().map(Result::unwrap).collect();
    let names: Vec<_> = images.iter().map(|image| image.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "image_2/000000.png",
            "image_2/000001.png",
            "image_2/000002.png"
        ],
        "images"
    );
    let car = &images[2].objects[1];
    assert_eq!(car.record, "label_2/000002.txt:2", "place");
    assert_eq!(car.category, "Car", "class");
    assert!(
        car.box_px == [657.39, 190.13, 700.07, 223.39],
        "{:?}",
        car.box_px
    );
    assert!(
        images.iter().all(|image| image.problems.is_empty()),
        "problems"
    );
    let roles: Vec<_> = source.files().map(|file| file.unwrap().role).collect();
    let labels: Vec<_> = roles.iter().filter(|r| **r != FileRole::Other).collect();
    assert_eq!((roles.len(), labels.len()), (6, 3), "files and labels");
}
