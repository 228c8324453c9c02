//! Resizing, against what OpenCV and Pillow made: tests/resize_reference/make.py.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot read its reference has failed"
)]

use image::{Rgb, RgbImage};
use starbreak_dataset::sha256_hex;
use starbreak_detect::{Interpolation, resize};

/// The same noise as in make.py.
fn pattern(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        Rgb([0_u32, 1, 2].map(|c| {
            let noise = x.wrapping_mul(73_856_093)
                ^ y.wrapping_mul(19_349_663)
                ^ c.wrapping_mul(83_492_791);
            u8::try_from((noise >> 7) & 255).unwrap()
        }))
    })
}

#[test]
fn every_size_up_and_down_is_that_of_opencv_or_pillow_to_the_bit() {
    let mut n = 0;
    for line in include_str!("resize_reference/digests.txt").lines() {
        if line.starts_with('#') {
            continue;
        }
        let words: Vec<&str> = line.split(' ').collect();
        let how = match words[0] {
            "linear" => Interpolation::Linear,
            "area" => Interpolation::Area,
            _ => Interpolation::Antialiased,
        };
        let sides: Vec<u32> = words[1..5]
            .iter()
            .map(|word| word.parse().unwrap())
            .collect();
        let resized = resize(&pattern(sides[0], sides[1]), sides[2], sides[3], how);
        let digest = sha256_hex(resized.as_raw());
        assert_eq!(digest.get(..16), Some(words[5]), "{line}");
        n += 1;
    }
    assert_eq!(n, 336, "all lines of the reference");
}
