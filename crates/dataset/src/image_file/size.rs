//! The size of an image from its headers.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use image::metadata::Orientation;

use super::{other, sniff};
use crate::error::{DatasetError, one_line};
use crate::formats::ImageFormat;
use crate::ordinary_file::open_file;

/// Longest EXIF block that is read, in bytes: in JPEG it is not longer, and of PNG's only the
/// beginning is needed.
const MAX_EXIF_BYTES: u64 = 1 << 16;

/// As [`image_size`], of an image that [`crate::read_image`] takes by its [`crate::ImageLimits::default`].
///
/// # Errors
/// As [`image_size`]; [`DatasetError::ImageTooLarge`], also for an image without pixels.
pub fn readable_size(path: &Path) -> Result<(u32, u32), DatasetError> {
    let (width_px, height_px) = image_size(path)?;
    let limits = super::ImageLimits::default();
    let name = path.to_string_lossy();
    limits.check_size(&name, width_px, height_px)?;
    if width_px == 0 || height_px == 0 {
        return Err(DatasetError::ImageTooLarge {
            name: name.into_owned(),
            width_px,
            height_px,
            max_side_px: limits.max_side_px,
            max_pixels: limits.max_pixels,
        });
    }
    Ok((width_px, height_px))
}

/// Width and height of the upright image in the file at `path`, in pixels.
///
/// The size that the pixels of [`crate::read_image`] have: sides are swapped where the EXIF
/// orientation says so. Only the headers are read.
///
/// # Errors
///
/// [`DatasetError::Read`], [`DatasetError::NotAFile`], [`DatasetError::EmptyFile`],
/// [`DatasetError::UnknownFormat`], and [`DatasetError::Truncated`] or [`DatasetError::Corrupt`]
/// where there is no header with a size.
///
/// # Limits
///
/// That the rest of the file is good is not known, nor that the size is within
/// [`crate::ImageLimits`].
pub fn image_size(path: &Path) -> Result<(u32, u32), DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: path.to_owned(),
        source,
    };
    let name = path.to_string_lossy();
    let file = open_file(path)?;
    let n_bytes = file.metadata().map_err(read_error)?.len();
    let mut reader = BufReader::with_capacity(1024, file);
    let mut head = Vec::new();
    (&mut reader)
        .take(512)
        .read_to_end(&mut head)
        .map_err(read_error)?;
    let format = sniff::format_from_bytes(&name, &head)?;
    let found = match format {
        ImageFormat::Png => png_size(&mut reader),
        ImageFormat::Jpeg => jpeg_size(&mut reader),
        ImageFormat::WebP | ImageFormat::Bmp => {
            reader.seek(SeekFrom::Start(0)).map_err(read_error)?;
            other::size(&mut reader, format)
        }
    };
    let (width_px, height_px) = match found {
        Ok(Some(size_px)) => size_px,
        Ok(None) => {
            return Err(DatasetError::Corrupt {
                name: name.into_owned(),
                format,
                reason: "it has no header with a size".to_owned(),
            });
        }
        Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            return Err(DatasetError::Truncated {
                name: name.into_owned(),
                format,
                n_bytes: usize::try_from(n_bytes).unwrap_or(usize::MAX),
            });
        }
        Err(error) => {
            return Err(DatasetError::Corrupt {
                name: name.into_owned(),
                format,
                reason: one_line(&error),
            });
        }
    };
    Ok((width_px, height_px))
}

/// Width and height as they are shown.
fn upright(size_px: (u32, u32), exif: Option<&[u8]>) -> (u32, u32) {
    match exif.and_then(Orientation::from_exif_chunk) {
        Some(orientation) => turned(size_px, orientation),
        None => size_px,
    }
}

/// Width and height once the orientation is applied.
pub(super) fn turned((w, h): (u32, u32), orientation: Orientation) -> (u32, u32) {
    match orientation {
        Orientation::Rotate90
        | Orientation::Rotate270
        | Orientation::Rotate90FlipH
        | Orientation::Rotate270FlipH => (h, w),
        _ => (w, h),
    }
}

fn png_size(file: &mut (impl Read + Seek)) -> std::io::Result<Option<(u32, u32)>> {
    file.seek(SeekFrom::Start(8))?;
    let mut size_px = None;
    let mut exif = None;
    loop {
        let [l0, l1, l2, l3, kind @ ..] = bytes::<8>(file)?;
        let length = u32::from_be_bytes([l0, l1, l2, l3]);
        let mut n_left = i64::from(length) + 4;
        match &kind {
            b"IHDR" => {
                let [w0, w1, w2, w3, h @ ..] = bytes::<8>(file)?;
                n_left -= 8;
                size_px = Some((u32::from_be_bytes([w0, w1, w2, w3]), u32::from_be_bytes(h)));
            }
            // It may follow the pixels.
            b"eXIf" => {
                let block = block(file, u64::from(length).min(MAX_EXIF_BYTES))?;
                n_left -= i64::try_from(block.len()).unwrap_or(i64::MAX);
                exif = Some(block);
            }
            b"IEND" => return Ok(size_px.map(|size_px| upright(size_px, exif.as_deref()))),
            _ => {}
        }
        file.seek_relative(n_left)?;
    }
}

fn jpeg_size(file: &mut (impl Read + Seek)) -> std::io::Result<Option<(u32, u32)>> {
    file.seek(SeekFrom::Start(2))?;
    let mut size_px = None;
    let mut exif = None;
    loop {
        // Fill and stray bytes: up to the next marker.
        let mut marker = 0;
        while marker == 0 || marker == 0xff {
            let [byte] = bytes::<1>(file)?;
            if byte == 0xff || marker == 0xff {
                marker = byte;
            }
        }
        match marker {
            // TEM, the restart markers and SOI have no segment.
            0x01 | 0xd0..=0xd8 => continue,
            // The pixels, or the end.
            0xda | 0xd9 => return Ok(size_px.map(|size_px| upright(size_px, exif.as_deref()))),
            _ => {}
        }
        let length = u16::from_be_bytes(bytes::<2>(file)?);
        let Some(n_bytes) = length.checked_sub(2) else {
            return Ok(None);
        };
        let is_frame = matches!(marker, 0xc0..=0xcf) && !matches!(marker, 0xc4 | 0xc8 | 0xcc);
        if is_frame && size_px.is_none() {
            let segment = block(file, u64::from(n_bytes))?;
            if let [_, h0, h1, w0, w1, ..] = segment[..] {
                let side = |high, low| u32::from(u16::from_be_bytes([high, low]));
                size_px = Some((side(w0, w1), side(h0, h1)));
            }
        } else if marker == 0xe1 && exif.is_none() {
            let segment = block(file, u64::from(n_bytes))?;
            exif = segment.strip_prefix(b"Exif\0\0").map(<[u8]>::to_vec);
        } else {
            file.seek_relative(i64::from(n_bytes))?;
        }
    }
}

fn bytes<const N: usize>(file: &mut impl Read) -> std::io::Result<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// So many bytes, no less.
fn block(file: &mut impl Read, n_bytes: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(n_bytes).read_to_end(&mut bytes)?;
    match u64::try_from(bytes.len()) {
        Ok(n_read) if n_read == n_bytes => Ok(bytes),
        _ => Err(std::io::ErrorKind::UnexpectedEof.into()),
    }
}
