//! WebP and BMP, by the decoders of the `image` crate.

use std::io::{BufRead, Cursor, Seek};

use image::codecs::bmp::BmpDecoder;
use image::codecs::webp::WebPDecoder;
use image::{DynamicImage, ImageDecoder, ImageError, ImageResult};

use super::size::turned;
use super::{Decoded, ImageFormat, ImageLimits};
use crate::error::{DatasetError, one_line};

pub(super) fn decode(
    name: &str,
    bytes: &[u8],
    format: ImageFormat,
    limits: &ImageLimits,
) -> Result<Decoded, DatasetError> {
    let error = |error: ImageError| dataset_error(name, format, bytes.len(), &error);
    // The decoder minds no pixels that are missing at the end.
    if let (ImageFormat::WebP, Some(&[a, b, c, d])) = (format, bytes.get(4..8))
        && u64::from(u32::from_le_bytes([a, b, c, d])) + 8 > bytes.len() as u64
    {
        return Err(DatasetError::Truncated {
            name: name.to_owned(),
            format,
            n_bytes: bytes.len(),
        });
    }
    if format == ImageFormat::Bmp {
        check_pixel_offset(name, bytes)?;
    }
    let mut decoder = decoder_of(Cursor::new(bytes), format).map_err(error)?;
    let (width_px, height_px) = decoder.dimensions();
    limits.check_size(name, width_px, height_px)?;
    let orientation = decoder.orientation().map_err(error)?;
    let icc_profile = decoder.icc_profile().map_err(error)?;
    Ok(Decoded {
        pixels: DynamicImage::from_decoder(decoder).map_err(error)?,
        orientation,
        icc_profile,
    })
}

/// The decoder takes pixels from where a bitmap says that they begin, be it its own header.
fn check_pixel_offset(name: &str, bytes: &[u8]) -> Result<(), DatasetError> {
    let Some(&[o0, o1, o2, o3, h0, h1, h2, h3]) = bytes.get(10..18) else {
        return Ok(());
    };
    let offset = u64::from(u32::from_le_bytes([o0, o1, o2, o3]));
    let end = 14 + u64::from(u32::from_le_bytes([h0, h1, h2, h3]));
    match offset >= end {
        true => Ok(()),
        false => Err(DatasetError::Corrupt {
            name: name.to_owned(),
            format: ImageFormat::Bmp,
            reason: format!("its pixels begin at byte {offset}, but its header ends at byte {end}"),
        }),
    }
}

/// Width and height of the upright image, px.
pub(super) fn size(
    reader: impl BufRead + Seek,
    format: ImageFormat,
) -> std::io::Result<Option<(u32, u32)>> {
    let upright = || -> ImageResult<(u32, u32)> {
        let mut decoder = decoder_of(reader, format)?;
        let orientation = decoder.orientation()?;
        Ok(turned(decoder.dimensions(), orientation))
    };
    upright().map(Some).map_err(|error| match error {
        ImageError::IoError(error) => error,
        error => std::io::Error::new(std::io::ErrorKind::InvalidData, error),
    })
}

fn decoder_of<'a>(
    reader: impl BufRead + Seek + 'a,
    format: ImageFormat,
) -> ImageResult<Box<dyn ImageDecoder + 'a>> {
    Ok(match format {
        ImageFormat::Bmp => Box::new(BmpDecoder::new(reader)?),
        _ => Box::new(WebPDecoder::new(reader)?),
    })
}

fn dataset_error(
    name: &str,
    format: ImageFormat,
    n_bytes: usize,
    error: &ImageError,
) -> DatasetError {
    let name = name.to_owned();
    match error {
        ImageError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            DatasetError::Truncated {
                name,
                format,
                n_bytes,
            }
        }
        ImageError::Unsupported(_) => DatasetError::UnsupportedFeature {
            name,
            format,
            reason: one_line(error),
        },
        other => DatasetError::Corrupt {
            name,
            format,
            reason: one_line(other),
        },
    }
}
