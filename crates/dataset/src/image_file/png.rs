//! PNG, with the strictness that the `image` crate leaves out: checksums and the end chunk.

use std::io::{self, Cursor};

use image::metadata::Orientation;
use image::{DynamicImage, ImageBuffer, Pixel};
use png::{BitDepth, ColorType, DecodingError, Limits, Transformations};

use super::{Decoded, ImageFormat, ImageLimits};
use crate::error::{DatasetError, one_line};

/// Enough for any honest color profile; the pixels are not counted here.
const MAX_METADATA_BYTES: usize = 64 << 20;

pub(super) fn decode(
    name: &str,
    bytes: &[u8],
    limits: &ImageLimits,
) -> Result<Decoded, DatasetError> {
    let error = |error| dataset_error(name, bytes.len(), &error);
    let corrupt = |reason: &str| DatasetError::Corrupt {
        name: name.to_owned(),
        format: ImageFormat::Png,
        reason: reason.to_owned(),
    };

    let mut decoder = png::Decoder::new_with_limits(
        Cursor::new(bytes),
        Limits {
            bytes: MAX_METADATA_BYTES,
        },
    );
    decoder.ignore_checksums(false);
    decoder.set_ignore_text_chunk(true);
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(error)?;
    let (width_px, height_px) = (header.width, header.height);
    limits.check_size(name, width_px, height_px)?;

    let mut reader = decoder.read_info().map_err(error)?;
    let info = reader.info();
    let n_palette = info.palette.as_deref().map_or(0, <[u8]>::len);
    // On a color cut short the decoder panics (version 0.18.1).
    if info.color_type == ColorType::Indexed
        && !(n_palette.is_multiple_of(3) && (3..=3 * 256).contains(&n_palette))
    {
        return Err(corrupt(&format!(
            "its palette has {n_palette} bytes; expected three for each of 1 to 256 colors"
        )));
    }
    let n_bytes = reader
        .output_buffer_size()
        .ok_or_else(|| error(DecodingError::LimitsExceeded))?;
    let mut samples = vec![0; n_bytes];
    let frame = reader.next_frame(&mut samples).map_err(error)?;
    if (frame.width, frame.height) != (width_px, height_px) {
        return Err(corrupt("the default image does not fill the frame"));
    }
    // Without this the chunks after the pixels, and the lack of an end, would go unseen.
    reader.finish().map_err(error)?;

    let (w, h) = (width_px, height_px);
    let pixels = match (frame.color_type, frame.bit_depth) {
        (ColorType::Grayscale, BitDepth::Eight) => {
            buffer(w, h, samples).map(DynamicImage::ImageLuma8)
        }
        (ColorType::GrayscaleAlpha, BitDepth::Eight) => {
            buffer(w, h, samples).map(DynamicImage::ImageLumaA8)
        }
        (ColorType::Rgb, BitDepth::Eight) => buffer(w, h, samples).map(DynamicImage::ImageRgb8),
        (ColorType::Rgba, BitDepth::Eight) => buffer(w, h, samples).map(DynamicImage::ImageRgba8),
        (ColorType::Grayscale, BitDepth::Sixteen) => {
            buffer(w, h, u16_from_big_endian(&samples)).map(DynamicImage::ImageLuma16)
        }
        (ColorType::GrayscaleAlpha, BitDepth::Sixteen) => {
            buffer(w, h, u16_from_big_endian(&samples)).map(DynamicImage::ImageLumaA16)
        }
        (ColorType::Rgb, BitDepth::Sixteen) => {
            buffer(w, h, u16_from_big_endian(&samples)).map(DynamicImage::ImageRgb16)
        }
        (ColorType::Rgba, BitDepth::Sixteen) => {
            buffer(w, h, u16_from_big_endian(&samples)).map(DynamicImage::ImageRgba16)
        }
        _ => None,
    }
    .ok_or_else(|| corrupt("the pixels do not have the mode in the header"))?;

    // After `finish`: the EXIF chunk may follow the pixels.
    let info = reader.info();
    let orientation = info
        .exif_metadata
        .as_deref()
        .and_then(Orientation::from_exif_chunk)
        .unwrap_or(Orientation::NoTransforms);
    let icc_profile = info.icc_profile.as_deref().map(<[u8]>::to_vec);
    Ok(Decoded {
        pixels,
        orientation,
        icc_profile,
    })
}

fn buffer<P: Pixel>(
    width_px: u32,
    height_px: u32,
    samples: Vec<P::Subpixel>,
) -> Option<ImageBuffer<P, Vec<P::Subpixel>>> {
    ImageBuffer::from_raw(width_px, height_px, samples)
}

fn u16_from_big_endian(bytes: &[u8]) -> Vec<u16> {
    let (pairs, _) = bytes.as_chunks();
    pairs.iter().map(|&pair| u16::from_be_bytes(pair)).collect()
}

fn dataset_error(name: &str, n_bytes: usize, error: &DecodingError) -> DatasetError {
    let name = name.to_owned();
    let format = ImageFormat::Png;
    let corrupt = |reason| DatasetError::Corrupt {
        name: name.clone(),
        format,
        reason,
    };
    match error {
        DecodingError::IoError(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
            DatasetError::Truncated {
                name,
                format,
                n_bytes,
            }
        }
        DecodingError::LimitsExceeded => corrupt(format!(
            "its metadata need more than {MAX_METADATA_BYTES} bytes"
        )),
        other => corrupt(one_line(other)),
    }
}
