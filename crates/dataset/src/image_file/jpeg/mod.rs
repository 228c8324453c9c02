//! JPEG. The decoder paints what is missing in gray; so the end is looked for before, and the
//! blocks are counted after.

mod bits;
mod blocks;
mod segments;

use image::metadata::Orientation;
use image::{DynamicImage, GrayImage, RgbImage};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;

use segments::Segments;

use super::{Decoded, ImageFormat, ImageLimits};
use crate::error::{DatasetError, one_line};

pub(super) fn decode(
    name: &str,
    bytes: &[u8],
    limits: &ImageLimits,
) -> Result<Decoded, DatasetError> {
    let structure = structure_of(bytes);
    if let Some((width_px, height_px)) = structure.size_px {
        limits.check_size(name, width_px, height_px)?;
    }
    if !structure.has_end {
        return Err(DatasetError::Truncated {
            name: name.to_owned(),
            format: ImageFormat::Jpeg,
            n_bytes: bytes.len(),
        });
    }
    let corrupt = |reason: &str| DatasetError::Corrupt {
        name: name.to_owned(),
        format: ImageFormat::Jpeg,
        reason: reason.to_owned(),
    };
    if structure.is_arithmetic {
        return Err(DatasetError::UnsupportedFeature {
            name: name.to_owned(),
            format: ImageFormat::Jpeg,
            reason: "arithmetic coding, which hardly any program reads".to_owned(),
        });
    }
    let size_px = structure
        .size_px
        .filter(|_| structure.has_scan)
        .ok_or_else(|| corrupt("it holds no image"))?;

    let error = |error| dataset_error(name, &error);
    // The limits on sides and pixels are those above.
    let options = DecoderOptions::default()
        .set_strict_mode(false)
        .set_max_width(usize::MAX)
        .set_max_height(usize::MAX);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(error)?;
    // The limits were checked on the first frame header; the decoder must mean the same one.
    let (width_px, height_px) = size_px;
    if decoder.dimensions() != Some((width_px as usize, height_px as usize)) {
        return Err(corrupt("it has two frame headers that differ in size"));
    }
    let is_gray = decoder.input_colorspace() == Some(ColorSpace::Luma);
    decoder.set_options(options.jpeg_set_out_colorspace(if is_gray {
        ColorSpace::Luma
    } else {
        ColorSpace::RGB
    }));
    let orientation = decoder
        .exif()
        .and_then(|exif| Orientation::from_exif_chunk(exif))
        .unwrap_or(Orientation::NoTransforms);
    let icc_profile = decoder.icc_profile();
    let samples = decoder.decode().map_err(error)?;
    if let Some(what) = blocks::missing(bytes) {
        return Err(corrupt(&what));
    }
    let pixels = if is_gray {
        GrayImage::from_raw(width_px, height_px, samples).map(DynamicImage::ImageLuma8)
    } else {
        RgbImage::from_raw(width_px, height_px, samples).map(DynamicImage::ImageRgb8)
    };
    Ok(Decoded {
        pixels: pixels.ok_or_else(|| corrupt("it holds fewer pixels than its header says"))?,
        orientation,
        icc_profile,
    })
}

/// What the markers of a JPEG file say, without decoding.
#[derive(Debug, Default, PartialEq, Eq)]
struct Structure {
    /// Width and height in the first frame header.
    size_px: Option<(u32, u32)>,
    has_scan: bool,
    /// The frame is in arithmetic codes instead of Huffman's.
    is_arithmetic: bool,
    /// An end-of-image marker stands outside all segments (thumbnails lie inside of one).
    has_end: bool,
}

fn structure_of(bytes: &[u8]) -> Structure {
    let mut structure = Structure::default();
    for (marker, segment) in Segments::new(bytes) {
        match (marker, segment) {
            (0xd9, _) => {
                structure.has_end = true;
                break;
            }
            (0xda, _) => structure.has_scan = true,
            // All frame headers; the three others in the row are tables.
            (0xc0..=0xcf, [_, _, _, h0, h1, w0, w1, ..])
                if !matches!(marker, 0xc4 | 0xc8 | 0xcc) && structure.size_px.is_none() =>
            {
                let side = |high: &u8, low: &u8| u32::from(u16::from_be_bytes([*high, *low]));
                structure.size_px = Some((side(w0, w1), side(h0, h1)));
                structure.is_arithmetic = marker > 0xc8;
            }
            _ => {}
        }
    }
    structure
}

fn dataset_error(name: &str, error: &DecodeErrors) -> DatasetError {
    let name = name.to_owned();
    let format = ImageFormat::Jpeg;
    match error {
        DecodeErrors::Unsupported(feature) => DatasetError::UnsupportedFeature {
            name,
            format,
            reason: one_line(&format!("{feature:?}")),
        },
        other => DatasetError::Corrupt {
            name,
            format,
            reason: one_line(&format!("{other}")),
        },
    }
}

#[cfg(test)]
mod tests {
    use std::error::Error;

    use super::*;

    #[test]
    fn end_marker_inside_a_segment_is_not_the_end() {
        // SOI, APP1 of 6 bytes with a thumbnail's SOI and EOI, nothing more.
        let bytes = b"\xff\xd8\xff\xe1\x00\x06\xff\xd8\xff\xd9";
        assert_eq!(structure_of(bytes), Structure::default(), "thumbnail only");

        let whole = [&bytes[..], b"\xff\xd9"].concat();
        assert!(structure_of(&whole).has_end, "the end after the thumbnail");
    }

    #[test]
    fn escaped_bytes_and_restarts_belong_to_the_scan() {
        let bytes = b"\xff\xd8\xff\xc0\x00\x08\x08\x00\x07\x00\x05\x01\xff\xda\x00\x02\x12\xff\x00\x34\xff\xd0\x56\xff\xff\xd9";
        let expected = Structure {
            size_px: Some((5, 7)),
            has_scan: true,
            is_arithmetic: false,
            has_end: true,
        };
        assert_eq!(structure_of(bytes), expected, "5 x 7 px");
        for end in 0..bytes.len() {
            assert!(
                !structure_of(&bytes[..end]).has_end,
                "cut after {end} bytes"
            );
        }
    }

    #[test]
    fn decoded_pixels_do_not_depend_on_the_processors_instructions() -> Result<(), Box<dyn Error>> {
        let (width, height) = (150_u16, 90_u16);
        let samples: Vec<u8> = (0..usize::from(width) * usize::from(height))
            .flat_map(|k| [k % 251, k * k / 97 % 256, k / 3 % 256])
            .map(u8::try_from)
            .collect::<Result<_, _>>()?;
        for sampling in [
            jpeg_encoder::SamplingFactor::F_1_1,
            jpeg_encoder::SamplingFactor::F_2_1,
            jpeg_encoder::SamplingFactor::F_2_2,
        ] {
            let mut bytes = Vec::new();
            let mut encoder = jpeg_encoder::Encoder::new(&mut bytes, 85);
            encoder.set_sampling_factor(sampling);
            encoder.encode(&samples, width, height, jpeg_encoder::ColorType::Rgb)?;
            // No vector instructions.
            let plain = DecoderOptions::new_safe();
            let expected = JpegDecoder::new_with_options(ZCursor::new(&bytes), plain).decode()?;
            let decoded = decode("x", &bytes, &ImageLimits::default())?;
            let differing = decoded.pixels.as_bytes().iter().zip(&expected);
            let n_off = differing.filter(|(a, b)| a != b).count();
            assert_eq!(n_off, 0, "{sampling:?}: samples that differ");
        }
        Ok(())
    }

    #[test]
    fn second_start_marker_has_no_segment() {
        let structure = structure_of(b"\xff\xd8\xff\xd8\xff\xd9");
        assert!(structure.has_end, "the end after two starts");
    }

    #[test]
    fn zero_length_segment_ends() {
        assert_eq!(
            structure_of(b"\xff\xd8\xff\xe0\x00\x00"),
            Structure::default(),
            "a length below 2 must not loop"
        );
    }
}
