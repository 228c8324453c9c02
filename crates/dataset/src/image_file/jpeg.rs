//! JPEG. The decoder paints what is missing in gray; so the end is looked for before.

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::{DynamicImage, ImageDecoder, ImageError};

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
    let size_px = structure
        .size_px
        .filter(|_| structure.has_scan)
        .ok_or_else(|| corrupt("it holds no image"))?;

    let error = |error| dataset_error(name, &error);
    let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(error)?;
    // The limits were checked on the first frame header; the decoder must mean the same one.
    if decoder.dimensions() != size_px {
        return Err(corrupt("it has two frame headers that differ in size"));
    }
    let orientation = decoder.orientation().map_err(error)?;
    let icc_profile = decoder.icc_profile().map_err(error)?;
    let pixels = DynamicImage::from_decoder(decoder).map_err(error)?;
    Ok(Decoded {
        pixels,
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
    /// An end-of-image marker stands outside all segments (thumbnails lie inside of one).
    has_end: bool,
}

fn structure_of(bytes: &[u8]) -> Structure {
    let mut structure = Structure::default();
    let mut rest = bytes.get(2..).unwrap_or_default();
    loop {
        // Compressed data, fill bytes and stray bytes between segments: up to the next marker.
        let Some(start) = rest.iter().position(|&b| b == 0xff) else {
            return structure;
        };
        rest = &rest[start + 1..];
        let Some(&marker) = rest.first() else {
            return structure;
        };
        match marker {
            0xff => continue,
            0xd9 => {
                structure.has_end = true;
                return structure;
            }
            // An escaped 0xff, TEM, the restart markers and SOI have no segment.
            0x00 | 0x01 | 0xd0..=0xd8 => {
                rest = &rest[1..];
                continue;
            }
            _ => {}
        }
        let length = match rest {
            [_, high, low, ..] => usize::from(u16::from_be_bytes([*high, *low])),
            _ => return structure,
        };
        let Some(segment) = rest.get(1..1 + length) else {
            return structure;
        };
        match (marker, segment) {
            (0xda, _) => structure.has_scan = true,
            // All frame headers; the three others in the row are tables.
            (0xc0..=0xcf, [_, _, _, h0, h1, w0, w1, ..])
                if !matches!(marker, 0xc4 | 0xc8 | 0xcc) && structure.size_px.is_none() =>
            {
                let side = |high: &u8, low: &u8| u32::from(u16::from_be_bytes([*high, *low]));
                structure.size_px = Some((side(w0, w1), side(h0, h1)));
            }
            _ => {}
        }
        rest = &rest[1 + length..];
    }
}

fn dataset_error(name: &str, error: &ImageError) -> DatasetError {
    let name = name.to_owned();
    let format = ImageFormat::Jpeg;
    let reason = one_line(error);
    match error {
        ImageError::Unsupported(_) => DatasetError::UnsupportedFeature {
            name,
            format,
            reason,
        },
        _ => DatasetError::Corrupt {
            name,
            format,
            reason,
        },
    }
}

#[cfg(test)]
mod tests {
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
