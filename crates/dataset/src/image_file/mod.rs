//! Reading: from a path or from bytes to pixels.

mod jpeg;
mod png;
mod size;
mod sniff;

use std::fmt;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use image::DynamicImage;
use image::metadata::Orientation;

use crate::error::DatasetError;
use crate::fence::fence;
use crate::provenance::blake3_hex;
pub use size::image_size;

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

/// The image formats which are read and written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ImageFormat {
    /// Portable Network Graphics. Of an animated PNG only the default image is read.
    Png,
    /// JPEG, baseline or progressive, 8 bits per channel.
    Jpeg,
}

impl ImageFormat {
    /// The usual extension of file names, without the dot: `png` or `jpg`.
    #[must_use]
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Jpeg => "jpg",
        }
    }
}

impl fmt::Display for ImageFormat {
    /// Writes `PNG` or `JPEG`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
        })
    }
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

/// The bytes of an ordinary file, as [`read_image`] reads them; the messages call it by its path.
///
/// # Errors
///
/// [`DatasetError::Read`], [`DatasetError::NotAFile`] and [`DatasetError::FileTooLong`].
pub fn read_bytes(path: &Path, max_bytes: u64) -> Result<Vec<u8>, DatasetError> {
    read_file(path, &path.to_string_lossy(), max_bytes)
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
/// inside the compressed data may come out as wrong pixels, as it does from other readers.
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

/// What both decoders deliver.
struct Decoded {
    pixels: DynamicImage,
    orientation: Orientation,
    icc_profile: Option<Vec<u8>>,
}

/// The bytes of an ordinary file; one more than `max_bytes` where it grew beyond that.
pub(crate) fn read_file(path: &Path, name: &str, max_bytes: u64) -> Result<Vec<u8>, DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: path.to_owned(),
        source,
    };
    let file = open_file(path)?;
    let n_bytes = file.metadata().map_err(read_error)?.len();
    check_file_len(name, n_bytes, max_bytes)?;

    let mut bytes = Vec::new();
    let n_expected = usize::try_from(n_bytes).unwrap_or(usize::MAX);
    bytes
        .try_reserve_exact(n_expected)
        .map_err(|_| read_error(io::ErrorKind::OutOfMemory.into()))?;
    // The file may grow while it is read.
    file.take(max_bytes.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(read_error)?;
    Ok(bytes)
}

/// A file is not longer than its limit.
pub(crate) fn check_file_len(name: &str, n_bytes: u64, max_bytes: u64) -> Result<(), DatasetError> {
    if n_bytes > max_bytes {
        return Err(DatasetError::FileTooLong {
            name: name.to_owned(),
            max_bytes,
        });
    }
    Ok(())
}

/// An ordinary file, open for reading.
pub(crate) fn open_file(path: &Path) -> Result<File, DatasetError> {
    refuse_no_file(path)?;
    File::open(path).map_err(|source| DatasetError::Read {
        path: path.to_owned(),
        source,
    })
}

/// Refuses what is there and no ordinary file, before it is opened: to open a pipe waits for its other end.
pub(crate) fn refuse_no_file(path: &Path) -> Result<(), DatasetError> {
    match fs::metadata(path).ok().as_ref().and_then(not_a_file) {
        None => Ok(()),
        Some(what) => Err(DatasetError::NotAFile {
            path: path.to_owned(),
            what,
        }),
    }
}

/// What the thing is when it is not an ordinary file, with its article.
pub(crate) fn not_a_file(metadata: &fs::Metadata) -> Option<&'static str> {
    let file_type = metadata.file_type();
    if file_type.is_file() {
        return None;
    }
    if file_type.is_dir() {
        return Some("a folder");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        if file_type.is_fifo() {
            return Some("a pipe");
        }
        if file_type.is_socket() {
            return Some("a socket");
        }
        if file_type.is_char_device() || file_type.is_block_device() {
            return Some("a device");
        }
    }
    Some("not an ordinary file")
}
