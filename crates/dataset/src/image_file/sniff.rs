//! The format from the first bytes.

use super::ImageFormat;
use crate::error::DatasetError;

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG_SIGNATURE: &[u8] = b"\xff\xd8\xff";

pub(super) fn format_from_bytes(name: &str, bytes: &[u8]) -> Result<ImageFormat, DatasetError> {
    if bytes.is_empty() {
        return Err(DatasetError::EmptyFile {
            name: name.to_owned(),
        });
    }
    for (signature, format) in [
        (PNG_SIGNATURE, ImageFormat::Png),
        (JPEG_SIGNATURE, ImageFormat::Jpeg),
    ] {
        if bytes.starts_with(signature) {
            return Ok(format);
        }
        if signature.starts_with(bytes) {
            return Err(DatasetError::Truncated {
                name: name.to_owned(),
                format,
                n_bytes: bytes.len(),
            });
        }
    }
    let at =
        |offset: usize, magic: &[u8]| bytes.get(offset..).is_some_and(|b| b.starts_with(magic));
    if at(0, b"RIFF") && at(8, b"WEBP") {
        return Ok(ImageFormat::WebP);
    }
    // Two letters begin a text, too; four bytes are always zero in a bitmap.
    if at(0, b"BM") && at(6, &[0; 4]) {
        return Ok(ImageFormat::Bmp);
    }
    Err(DatasetError::UnknownFormat {
        name: name.to_owned(),
        looks_like: looks_like(bytes),
    })
}

fn looks_like(bytes: &[u8]) -> &'static str {
    let head = &bytes[..bytes.len().min(512)];
    let at = |offset: usize, magic: &[u8]| head.get(offset..).is_some_and(|b| b.starts_with(magic));
    if at(0, b"\x89PNG") {
        "a PNG file damaged by a transfer in text mode"
    } else if at(0, b"GIF8") {
        "a GIF image"
    } else if at(0, b"II*\0") || at(0, b"MM\0*") {
        "a TIFF or camera raw image"
    } else if at(4, b"ftyp") {
        "a HEIF or AVIF image or a video"
    } else if at(0, b"\xff\x0a") || at(4, b"JXL ") {
        "a JPEG XL image"
    } else if at(0, b"PK\x03\x04") || at(0, b"\x1f\x8b") {
        "an archive"
    } else if at(0, b"version https://git-lfs") {
        "a Git LFS pointer, not the file itself"
    } else if at(0, b"BM") && head.contains(&0) {
        "a BMP image"
    } else if head.iter().all(|&b| b == 0) {
        "zeros, as after an interrupted copy"
    } else if head
        .iter()
        .all(|&b| matches!(b, b'\t' | b'\n' | b'\r' | 0x0c | 0x20..=0x7e | 0x80..))
    {
        "text"
    } else {
        "unknown data"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guesses_name_what_users_really_have() {
        for (bytes, guess) in [
            (&b"GIF89a\0"[..], "a GIF image"),
            (
                b"\x89PNG\n\x1a\n",
                "a PNG file damaged by a transfer in text mode",
            ),
            (b"BM\x36\0\0\0\x01", "a BMP image"),
            (b"BMW and others", "text"),
            (b"<html>404</html>", "text"),
            (b"\0\0\0\0\0\0\0\0\0", "zeros, as after an interrupted copy"),
            (b"\x01\x02\x03", "unknown data"),
        ] {
            assert_eq!(looks_like(bytes), guess, "{bytes:?}");
        }
    }

    #[test]
    fn half_a_signature_is_a_cut_file() {
        for bytes in [&PNG_SIGNATURE[..7], &JPEG_SIGNATURE[..1]] {
            let result = format_from_bytes("x", bytes);
            assert!(
                matches!(result, Err(DatasetError::Truncated { .. })),
                "{result:?}"
            );
        }
    }
}
