//! Round trips of every mode.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use common::{all_modes, gray_ramp, psnr_db, ramp, rgb};
use image::{DynamicImage, GrayImage, ImageBuffer, Rgb32FImage, RgbImage};
use proptest::prelude::*;
use starbreak_dataset::{
    DatasetError, Encoding, ImageFile, ImageFormat, ImageLimits, JpegQuality, decode_image,
    encode_image, encode_mask,
};

fn jpeg(quality: u8) -> Encoding {
    Encoding::Jpeg {
        quality: JpegQuality::new(quality).unwrap(),
    }
}

fn round_trip(image: &DynamicImage, encoding: Encoding, icc: Option<&[u8]>) -> ImageFile {
    let bytes = encode_image(image, &encoding, icc).unwrap();
    let file = decode_image("x", &bytes, &ImageLimits::default()).unwrap();
    assert_eq!(file.format, encoding.format(), "format");
    file
}

#[test]
fn png_is_exact_in_every_mode_and_size() {
    for size in [(1, 1), (1, 9), (9, 1), (33, 17)] {
        for image in all_modes(size.0, size.1) {
            let file = round_trip(&image, Encoding::Png, None);
            assert!(file.pixels == image, "{:?} {size:?}", image.color());
            assert_eq!(file.icc_profile, None, "no profile");
        }
    }
}

#[test]
fn jpeg_is_close() {
    for (quality, bound_db) in [(100, 45.0), (90, 36.0), (89, 33.0), (50, 28.0)] {
        let color = ramp(67, 45);
        let file = round_trip(&DynamicImage::ImageRgb8(color.clone()), jpeg(quality), None);
        let psnr = psnr_db(file.pixels.as_rgb8().unwrap(), &color);
        assert!(psnr > bound_db, "RGB at quality {quality}: {psnr:.1} dB");

        let gray = gray_ramp(67, 45);
        let file = round_trip(&DynamicImage::ImageLuma8(gray.clone()), jpeg(quality), None);
        let psnr = psnr_db(file.pixels.as_luma8().unwrap(), &gray);
        assert!(psnr > bound_db, "gray at quality {quality}: {psnr:.1} dB");
    }
}

#[test]
fn chroma_is_whole_from_quality_90() {
    for (quality, luma_sampling) in [(90, 0x11), (89, 0x22)] {
        let bytes =
            encode_image(&DynamicImage::ImageRgb8(ramp(32, 32)), &jpeg(quality), None).unwrap();
        let frame = bytes.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        // Marker, length, precision, height, width, number of components, then id and sampling.
        assert_eq!(bytes[frame + 11], luma_sampling, "quality {quality}");
    }
}

#[test]
fn color_profiles_survive() {
    // Longer than one JPEG segment.
    let profile: Vec<u8> = (0..=255).cycle().take(150_000).collect();
    let image = DynamicImage::ImageRgb8(rgb(16, 8));
    for encoding in [Encoding::Png, jpeg(90)] {
        let file = round_trip(&image, encoding, Some(&profile));
        assert!(file.icc_profile.as_ref() == Some(&profile), "{encoding:?}");
        let file = round_trip(&image, encoding, Some(&[]));
        assert_eq!(
            file.icc_profile, None,
            "an empty profile is none, {encoding:?}"
        );
    }
    let huge = vec![0; 17 << 20];
    let error = encode_image(&image, &jpeg(90), Some(&huge)).unwrap_err();
    assert!(matches!(error, DatasetError::Encode { .. }), "{error}");
}

#[test]
fn jpeg_names_the_modes_it_cannot_hold() {
    for image in all_modes(4, 4) {
        let result = encode_image(&image, &jpeg(90), None);
        let name = format!("{:?}", image.color());
        if ["L8", "Rgb8"].contains(&name.as_str()) {
            assert!(result.is_ok(), "{name}");
        } else {
            let message = result.unwrap_err().to_string();
            let expected = format!("JPEG cannot store {name} pixels; use PNG for this image");
            assert_eq!(message, expected, "{name}");
        }
    }
    let float = DynamicImage::ImageRgb32F(Rgb32FImage::new(2, 2));
    let message = encode_image(&float, &Encoding::Png, None)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("PNG cannot store Rgb32F pixels"),
        "{message}"
    );
}

#[test]
fn sizes_out_of_range() {
    let empty = DynamicImage::ImageRgb8(RgbImage::new(0, 3));
    let wide = DynamicImage::ImageLuma8(GrayImage::new(65_536, 1));
    for (image, encoding) in [
        (&empty, Encoding::Png),
        (&empty, jpeg(90)),
        (&wide, jpeg(90)),
    ] {
        let error = encode_image(image, &encoding, None).unwrap_err();
        assert!(matches!(error, DatasetError::ImageSize { .. }), "{error}");
    }
    assert!(
        encode_image(&wide, &Encoding::Png, None).is_ok(),
        "PNG is wider"
    );
    assert!(
        encode_mask(&GrayImage::new(0, 0)).is_err(),
        "a mask without pixels"
    );
}

#[test]
fn quality_range() {
    for quality in [0, 101, 255] {
        let message = JpegQuality::new(quality).unwrap_err().to_string();
        assert_eq!(
            message,
            format!("jpeg quality = {quality}; expected 1 to 100"),
            "text"
        );
    }
    assert_eq!(JpegQuality::new(1).unwrap().get(), 1, "lowest");
    assert_eq!(ImageFormat::Jpeg.extension(), "jpg", "extension");
}

#[test]
fn buffers_longer_than_the_image() {
    let image: GrayImage = ImageBuffer::from_raw(2, 2, vec![1, 2, 3, 4, 99, 99]).unwrap();
    let expected = GrayImage::from_raw(2, 2, vec![1, 2, 3, 4]).unwrap();
    for bytes in [
        encode_mask(&image),
        encode_image(
            &DynamicImage::ImageLuma8(image.clone()),
            &Encoding::Png,
            None,
        ),
    ] {
        let file = decode_image("x", &bytes.unwrap(), &ImageLimits::default()).unwrap();
        assert_eq!(file.pixels.as_luma8(), Some(&expected), "the pixels alone");
    }
}

proptest! {
    // Found cases become named tests, not files.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn masks_are_exact(width in 1..40u32, height in 1..40u32, seed in any::<u32>()) {
        let mask = GrayImage::from_fn(width, height, |x, y| {
            image::Luma([(seed.wrapping_mul(x * 31 + y * 17 + 1) >> 24).to_le_bytes()[0]])
        });
        let bytes = encode_mask(&mask).unwrap();
        let file = decode_image("x", &bytes, &ImageLimits::default()).unwrap();
        prop_assert_eq!(file.pixels.as_luma8(), Some(&mask));
    }
}
