//! The size from the headers is that of the decoded pixels.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use std::path::Path;

use common::{all_modes, exif, jpeg_with, png, png_info, png_with, put, ramp, shared_data};
use starbreak_dataset::{Encoding, ImageLimits, encode_image, image_size, read_image};

fn check(path: &Path) {
    let pixels = read_image(path, &ImageLimits::default()).unwrap().pixels;
    let decoded = (pixels.width(), pixels.height());
    assert_eq!(image_size(path).unwrap(), decoded, "{path:?}");
}

#[test]
fn every_kind_and_orientation_has_the_size_of_its_pixels() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("image");
    for image in all_modes(7, 5) {
        put(
            dir.path(),
            "image",
            encode_image(&image, &Encoding::Png, None).unwrap(),
        );
        check(&path);
    }
    for orientation in 0..=9 {
        let turned = jpeg_with(&ramp(40, 24), |encoder| {
            let block = [b"Exif\0\0", exif(orientation).as_slice()].concat();
            encoder.add_app_segment(2, vec![0xff; 300]).unwrap();
            encoder.add_app_segment(1, block).unwrap();
            encoder.set_progressive(orientation % 2 == 0);
        });
        put(dir.path(), "image", turned);
        check(&path);
        let mut info = png_info((4, 3), png::ColorType::Grayscale, png::BitDepth::Eight);
        info.exif_metadata = Some(exif(orientation).into());
        put(dir.path(), "image", png_with(info, &[9; 12]));
        check(&path);
    }
}

#[test]
fn real_images_have_the_size_of_their_pixels() {
    for folder in ["kitti/image_2", "coco96/val2017", "bdd"] {
        let Some(folder) = shared_data(folder) else {
            continue;
        };
        let images = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path());
        images
            .filter(|path| path.extension().is_some_and(|e| e == "png" || e == "jpg"))
            .for_each(|path| check(&path));
    }
}

#[test]
fn a_file_without_a_whole_header_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("image");
    assert!(image_size(&path).is_err(), "no file");
    assert!(image_size(dir.path()).is_err(), "a folder");
    let png = png(7, 5);
    let jpeg = jpeg_with(&ramp(40, 24), |_| {});
    let start_of_scan = jpeg
        .windows(2)
        .position(|pair| pair == [0xff, 0xda])
        .unwrap();
    for (bytes, n_header) in [(&png, png.len()), (&jpeg, start_of_scan + 1)] {
        for n_bytes in 0..n_header {
            put(dir.path(), "image", &bytes[..n_bytes]);
            let size = image_size(&path);
            // The checksum of the last chunk is not looked at.
            let is_whole = bytes == &png && n_bytes + 4 >= png.len();
            assert!(size.is_err() || is_whole, "{n_bytes} bytes gave {size:?}");
        }
    }
}
