//! Reading: from a path or from bytes to pixels.

mod jpeg;
mod other;
mod png;
mod size;
mod sniff;

use std::path::Path;

use image::DynamicImage;
use image::metadata::Orientation;

use crate::error::DatasetError;
use crate::fence::fence;
use crate::formats::ImageFormat;
use crate::ordinary_file::{check_file_len, read_file};
use crate::provenance::blake3_hex;
pub use size::{image_size, readable_size};

/// A decoded image together with what is needed to write its like.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ImageFile {
    /// The pixels, upright: the EXIF orientation is already applied.
    ///
    /// Grey, grey with alpha, RGB or RGBA, in 8 or 16 bits as in the file; grey of 1, 2 or 4
    /// bits is scaled to 8, a palette is expanded to RGB or RGBA, CMYK is converted to RGB.
    pub pixels: DynamicImage,
    /// The format of the content, whatever the name says.
    pub format: ImageFormat,
    /// The embedded ICC color profile. The pixels are *not* converted with it.
    pub icc_profile: Option<Vec<u8>>,
    /// How the file's own pixels lie to the upright ones.
    pub orientation: Orientation,
    /// BLAKE3 of the bytes of the file, 64 lowercase hexadecimal digits.
    pub blake3: String,
}

/// How much an image may claim before its pixels are allocated.
///
/// A small file can announce a huge image; it is refused on its header alone. Decoding needs at
/// most 20 bytes per pixel on top of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageLimits {
    /// Largest width and largest height, in pixels. **Default** 32768.
    pub max_side_px: u32,
    /// Largest width times height, in pixels. **Default** 2^27 (134 217 728).
    pub max_pixels: u64,
    /// Largest file, in bytes. **Default** 2^31 (2 GiB).
    pub max_file_bytes: u64,
}

impl Default for ImageLimits {
    fn default() -> Self {
        Self {
            max_side_px: 32_768,
            max_pixels: 1 << 27,
            max_file_bytes: 1 << 31,
        }
    }
}

impl ImageLimits {
    fn check_size(&self, name: &str, width_px: u32, height_px: u32) -> Result<(), DatasetError> {
        let n_pixels = u64::from(width_px) * u64::from(height_px);
        if width_px > self.max_side_px || height_px > self.max_side_px || n_pixels > self.max_pixels
        {
            return Err(DatasetError::ImageTooLarge {
                name: name.to_owned(),
                width_px,
                height_px,
                max_side_px: self.max_side_px,
                max_pixels: self.max_pixels,
            });
        }
        Ok(())
    }
}

/// The image in the file at `path`, upright, in the bit depth of the file.
///
/// Symbolic links are followed. Pipes, sockets and devices are refused without opening them, so
/// that reading never waits for somebody else.
///
/// # Errors
///
/// [`DatasetError::Read`] and [`DatasetError::NotAFile`] where there is no file to be read, and
/// every error of [`decode_image`].
pub fn read_image(path: &Path, limits: &ImageLimits) -> Result<ImageFile, DatasetError> {
    let name = path.to_string_lossy();
    let bytes = read_file(path, &name, limits.max_file_bytes)?;
    decode_image(&name, &bytes, limits)
}

/// The image in the bytes of a file; the pure part of [`read_image`].
///
/// `name` serves only for messages. The format is found from the content.
///
/// # Errors
///
/// [`DatasetError::EmptyFile`], [`DatasetError::UnknownFormat`], [`DatasetError::FileTooLong`],
/// [`DatasetError::ImageTooLarge`] (from the header, before anything is allocated),
/// [`DatasetError::Truncated`] where the end of the image is missing, [`DatasetError::Corrupt`]
/// and [`DatasetError::UnsupportedFeature`].
///
/// # Limits
///
/// PNG checksums are verified, so that damage is always found. JPEG has none: a file that is cut
/// short, whatever stands behind the cut, is refused by the count of its blocks, but other damage
/// inside the compressed data may come out as wrong pixels, as it does from other readers. WebP and
/// BMP have none either.
pub fn decode_image(
    name: &str,
    bytes: &[u8],
    limits: &ImageLimits,
) -> Result<ImageFile, DatasetError> {
    check_file_len(name, bytes.len() as u64, limits.max_file_bytes)?;
    let format = sniff::format_from_bytes(name, bytes)?;
    let decoded = fence(|| match format {
        ImageFormat::Png => png::decode(name, bytes, limits),
        ImageFormat::Jpeg => jpeg::decode(name, bytes, limits),
        ImageFormat::WebP | ImageFormat::Bmp => other::decode(name, bytes, format, limits),
    });
    let decoded = decoded.unwrap_or_else(|| {
        Err(DatasetError::Corrupt {
            name: name.to_owned(),
            format,
            reason: "it breaks the decoder".to_owned(),
        })
    })?;
    let mut pixels = decoded.pixels;
    pixels.apply_orientation(decoded.orientation);
    Ok(ImageFile {
        pixels,
        format,
        // That of the four inks says nothing of the colors that they were converted to.
        icc_profile: decoded
            .icc_profile
            .filter(|profile| profile.get(16..20) != Some(b"CMYK")),
        orientation: decoded.orientation,
        blake3: blake3_hex(bytes),
    })
}

/// What all decoders deliver.
struct Decoded {
    pixels: DynamicImage,
    orientation: Orientation,
    icc_profile: Option<Vec<u8>>,
}
