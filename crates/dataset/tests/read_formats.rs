//! What comes out of each kind of PNG, JPEG, WebP and BMP.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use common::{exif, jpeg_with, png_info, png_with, psnr_db, ramp};
use image::{DynamicImage, GrayImage, RgbImage};
use png::{BitDepth, ColorType};
use starbreak_dataset::{ImageFormat, ImageLimits, decode_image, image_size};

fn decode(bytes: &[u8]) -> DynamicImage {
    decode_image("test", bytes, &ImageLimits::default())
        .unwrap()
        .pixels
}

#[test]
fn gray_of_few_bits_is_scaled_to_eight() {
    for (depth, byte, expected) in [
        (BitDepth::One, 0b0110_0000, vec![0, 255, 255, 0]),
        (BitDepth::Two, 0b0001_1011, vec![0, 85, 170, 255]),
    ] {
        let bytes = png_with(png_info((4, 1), ColorType::Grayscale, depth), &[byte]);
        let expected = GrayImage::from_raw(4, 1, expected).unwrap();
        assert_eq!(
            decode(&bytes),
            DynamicImage::ImageLuma8(expected),
            "{depth:?}"
        );
    }
    let four = png_with(
        png_info((2, 1), ColorType::Grayscale, BitDepth::Four),
        &[0x1f],
    );
    let expected = GrayImage::from_raw(2, 1, vec![17, 255]).unwrap();
    assert_eq!(decode(&four), DynamicImage::ImageLuma8(expected), "4 bits");
}

#[test]
fn palette_is_expanded_with_its_transparency() {
    let mut info = png_info((3, 1), ColorType::Indexed, BitDepth::Eight);
    info.palette = Some(vec![1, 2, 3, 40, 50, 60].into());
    let opaque = decode(&png_with(info.clone(), &[1, 0, 1]));
    assert_eq!(
        opaque.as_rgb8().unwrap().as_raw(),
        &[40, 50, 60, 1, 2, 3, 40, 50, 60],
        "RGB"
    );

    info.trns = Some(vec![0, 128].into());
    let clear = decode(&png_with(info, &[1, 0, 1]));
    let expected = [40, 50, 60, 128, 1, 2, 3, 0, 40, 50, 60, 128];
    assert_eq!(clear.as_rgba8().unwrap().as_raw(), &expected, "RGBA");
}

#[test]
fn sixteen_bits_keep_every_bit() {
    let data = [0x12, 0x34, 0xff, 0x01];
    let bytes = png_with(
        png_info((2, 1), ColorType::Grayscale, BitDepth::Sixteen),
        &data,
    );
    assert_eq!(
        decode(&bytes).as_luma16().unwrap().as_raw(),
        &[0x1234, 0xff01],
        "L16"
    );
}

#[test]
fn all_eight_exif_orientations_come_out_upright() {
    // Where the stored pixels 1 2 3 / 4 5 6 go, by the EXIF standard.
    let expected = [
        (1, (3, 2), [1, 2, 3, 4, 5, 6]),
        (2, (3, 2), [3, 2, 1, 6, 5, 4]),
        (3, (3, 2), [6, 5, 4, 3, 2, 1]),
        (4, (3, 2), [4, 5, 6, 1, 2, 3]),
        (5, (2, 3), [1, 4, 2, 5, 3, 6]),
        (6, (2, 3), [4, 1, 5, 2, 6, 3]),
        (7, (2, 3), [6, 3, 5, 2, 4, 1]),
        (8, (2, 3), [3, 6, 2, 5, 1, 4]),
    ];
    for (orientation, (w, h), pixels) in expected {
        let mut info = png_info((3, 2), ColorType::Grayscale, BitDepth::Eight);
        info.exif_metadata = Some(exif(orientation).into());
        let image = decode(&png_with(info, &[1, 2, 3, 4, 5, 6]));
        let expected = GrayImage::from_raw(w, h, pixels.to_vec()).unwrap();
        assert_eq!(
            image,
            DynamicImage::ImageLuma8(expected),
            "PNG {orientation}"
        );
    }
    let stored = ramp(48, 32);
    let upright = decode(&jpeg_with(&stored, |e| {
        e.add_exif_metadata(&exif(6)).unwrap()
    }));
    let turned = image::imageops::rotate90(&stored);
    assert_eq!(
        (upright.width(), upright.height()),
        (32, 48),
        "JPEG 6 is turned"
    );
    assert!(
        psnr_db(upright.as_bytes(), turned.as_raw()) > 35.0,
        "JPEG 6 is turned right"
    );
}

#[test]
fn exif_after_the_pixels_counts_too() {
    let mut info = png_info((2, 1), ColorType::Grayscale, BitDepth::Eight);
    info.exif_metadata = Some(exif(2).into());
    let bytes = png_with(info, &[7, 9]);
    let find = |name: &[u8; 4]| bytes.windows(4).position(|w| w == name).unwrap() - 4;
    let (exif_at, idat, iend) = (find(b"eXIf"), find(b"IDAT"), find(b"IEND"));
    assert!(exif_at < idat, "the encoder writes it first");
    let moved = [
        &bytes[..exif_at],
        &bytes[idat..iend],
        &bytes[exif_at..idat],
        &bytes[iend..],
    ]
    .concat();
    assert_eq!(
        decode(&moved).as_luma8().unwrap().as_raw(),
        &[9, 7],
        "mirrored"
    );
}

#[test]
fn jpeg_modes() {
    let image = ramp(37, 23);
    let gray = GrayImage::from_fn(37, 23, |x, y| image::Luma([image.get_pixel(x, y)[2]]));
    let mut bytes = Vec::new();
    jpeg_encoder::Encoder::new(&mut bytes, 95)
        .encode(gray.as_raw(), 37, 23, jpeg_encoder::ColorType::Luma)
        .unwrap();
    assert!(
        psnr_db(decode(&bytes).as_luma8().unwrap(), &gray) > 40.0,
        "gray stays gray"
    );

    for progressive in [false, true] {
        let bytes = jpeg_with(&image, |e| e.set_progressive(progressive));
        assert!(
            psnr_db(decode(&bytes).as_rgb8().unwrap(), &image) > 33.0,
            "progressive {progressive}"
        );
    }

    let cmyk: Vec<u8> = image
        .pixels()
        .flat_map(|p| [255 - p[0], 255 - p[1], 255 - p[2], 0])
        .collect();
    let mut bytes = Vec::new();
    jpeg_encoder::Encoder::new(&mut bytes, 95)
        .encode(&cmyk, 37, 23, jpeg_encoder::ColorType::Cmyk)
        .unwrap();
    let psnr = psnr_db(decode(&bytes).as_rgb8().unwrap(), &image);
    assert!(psnr > 30.0, "CMYK becomes RGB, {psnr:.1} dB");
}

#[test]
fn format_comes_from_the_content_and_hash_from_the_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("lies.png");
    let bytes = jpeg_with(&RgbImage::new(8, 8), |_| {});
    std::fs::write(&path, &bytes).unwrap();
    let file = starbreak_dataset::read_image(&path, &ImageLimits::default()).unwrap();
    assert_eq!(file.format, ImageFormat::Jpeg, "by content");
    assert_eq!(
        file.blake3,
        starbreak_dataset::blake3_hex(&bytes),
        "of the file"
    );
}

#[test]
fn of_an_animation_the_default_image_is_read() {
    let frames = [10, 200].map(|level| GrayImage::from_pixel(5, 4, image::Luma([level])));
    let bytes = starbreak_dataset::encode_animation(
        frames.clone(),
        &starbreak_dataset::AnimationParams::default(),
    );
    assert_eq!(
        decode(&bytes.unwrap()).as_luma8().unwrap(),
        &frames[0],
        "frame 0"
    );
}

/// 6 x 4 px of WebP with loss, to be turned by 90°, as Pillow 12 writes it.
const TURNED_WEBP: &str = "\
     52494646aa00000057454250565038580a00000008000000050000030000565038206a0000009001009d012a06000400\
     00c01225b000035f12849800fefaa31dff920787028bce4410cf75ff53ff1db5d7ed01f5feb3aa3fffaf04f0efe8e4c5\
     47fc0fff8d2cbdbfd0fe9cd07fff22bc07f84efdfdb0ffc1bffff426beefff0456ff837fe2bff8facbdfed2cb0000000\
     455849461a0000004d4d002a00000008000101120003000000010006000000000000\
     ";

/// Its upright pixels by Pillow.
const BY_PILLOW: [[u8; 3]; 24] = [
    [33, 166, 201],
    [17, 118, 184],
    [18, 54, 185],
    [3, 6, 169],
    [56, 169, 190],
    [40, 120, 173],
    [41, 57, 172],
    [25, 8, 157],
    [97, 171, 162],
    [81, 123, 145],
    [82, 59, 144],
    [66, 11, 130],
    [136, 170, 129],
    [121, 122, 115],
    [119, 58, 113],
    [105, 11, 97],
    [175, 171, 100],
    [157, 120, 81],
    [162, 60, 85],
    [144, 9, 66],
    [201, 176, 89],
    [183, 126, 70],
    [187, 65, 74],
    [169, 14, 55],
];

fn turned_webp() -> Vec<u8> {
    let digits: Vec<char> = TURNED_WEBP.chars().collect();
    let byte = |pair: &[char]| u8::from_str_radix(&pair.iter().collect::<String>(), 16).unwrap();
    digits.chunks(2).map(byte).collect()
}

#[test]
fn webp_and_bitmaps_are_read_and_their_size_is_that_of_the_header() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("image");
    let image = DynamicImage::ImageRgb8(ramp(40, 24));
    let alpha = DynamicImage::ImageRgba8(image.to_rgba8());
    for (pixels, name) in [
        (&image, "webp"),
        (&alpha, "webp"),
        (&image, "bmp"),
        (&alpha, "bmp"),
    ] {
        let as_written = dir.path().join(format!("image.{name}"));
        pixels.save(&as_written).unwrap();
        let bytes = std::fs::read(&as_written).unwrap();
        let file = decode_image("test", &bytes, &ImageLimits::default()).unwrap();
        assert_eq!(file.format.extension(), name, "by its content");
        assert_eq!(
            file.pixels.to_rgba8(),
            pixels.to_rgba8(),
            "{name}: without loss"
        );
        std::fs::rename(&as_written, &path).unwrap();
        assert_eq!(image_size(&path).unwrap(), (40, 24), "{name}");
        for cut in [20, bytes.len() / 2, bytes.len() - 1] {
            let refused = decode_image("test", &bytes[..cut], &ImageLimits::default());
            assert!(refused.is_err(), "{name} of {cut} bytes: {refused:?}");
        }
        let small = ImageLimits {
            max_pixels: 40 * 23,
            ..ImageLimits::default()
        };
        let refused = decode_image("test", &bytes, &small)
            .unwrap_err()
            .to_string();
        assert!(refused.contains("40 x 24 px"), "{name}: {refused}");
    }
    std::fs::write(&path, turned_webp()).unwrap();
    assert_eq!(image_size(&path).unwrap(), (4, 6), "upright");
    let found = decode(&turned_webp()).into_rgb8();
    assert_eq!(found.dimensions(), (4, 6), "upright");
    for (own, theirs) in found.pixels().zip(BY_PILLOW) {
        let off = own.0.iter().zip(theirs).map(|(a, b)| a.abs_diff(b)).max();
        assert!(off < Some(4), "{own:?}, by Pillow {theirs:?}");
    }
}
