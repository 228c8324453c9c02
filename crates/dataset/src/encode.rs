use std::borrow::Cow;

use image::metadata::Orientation;
use image::{DynamicImage, ExtendedColorType, GrayImage, ImageBuffer, Pixel};
use jpeg_encoder::SamplingFactor;
use png::{BitDepth, ColorType, Compression, Filter};

use crate::error::{DatasetError, one_line};
use crate::formats::ImageFormat;
use crate::image_file::ImageFile;

/// JPEG has 16 bits for each side, PNG 31.
const MAX_JPEG_SIDE_PX: u32 = 65_535;
const MAX_PNG_SIDE_PX: u32 = i32::MAX.unsigned_abs();

/// The format of an output image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Encoding {
    /// Lossless, for all modes of 8 and 16 bits.
    Png,
    /// Lossy, for 8-bit grey and RGB. Chroma is halved in both directions below quality 90.
    Jpeg {
        /// From 1 (small) to 100 (good).
        quality: JpegQuality,
    },
}

impl Encoding {
    /// The format of the bytes that come out.
    #[must_use]
    pub const fn format(self) -> ImageFormat {
        match self {
            Self::Png => ImageFormat::Png,
            Self::Jpeg { .. } => ImageFormat::Jpeg,
        }
    }
}

/// A JPEG quality, 1 to 100.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JpegQuality(u8);

impl JpegQuality {
    /// The quality with this number.
    ///
    /// # Errors
    ///
    /// [`DatasetError::JpegQuality`] outside 1 to 100.
    pub const fn new(quality: u8) -> Result<Self, DatasetError> {
        match quality {
            1..=100 => Ok(Self(quality)),
            _ => Err(DatasetError::JpegQuality { quality }),
        }
    }

    /// The number, 1 to 100.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }
}

/// The bytes of an image file; equal images give equal bytes.
///
/// PNG keeps the mode and every bit. `icc_profile` is stored as it is; it should be the one of
/// the image that the pixels come from, for a profile of RGB has no place in a grey image.
///
/// # Errors
///
/// [`DatasetError::UnsupportedMode`] for 32-bit modes, and for JPEG also for alpha and 16 bits;
/// [`DatasetError::ImageSize`] for an image without pixels or, as JPEG, with a side above
/// 65535 px; [`DatasetError::Encode`] where the profile does not fit (16 MB in JPEG).
pub fn encode_image(
    pixels: &DynamicImage,
    encoding: &Encoding,
    icc_profile: Option<&[u8]>,
) -> Result<Vec<u8>, DatasetError> {
    encode_oriented(pixels, encoding, icc_profile, Orientation::NoTransforms)
}

/// The bytes of a PNG file: [`encode_image`] for those who need no codec of JPEG, as a page.
///
/// # Errors
///
/// As for [`encode_image`].
pub fn encode_png(
    pixels: &DynamicImage,
    icc_profile: Option<&[u8]>,
) -> Result<Vec<u8>, DatasetError> {
    png_of(pixels, icc_profile, None)
}

/// As [`encode_image`], with an orientation in the EXIF data unless it is the plain one.
fn encode_oriented(
    pixels: &DynamicImage,
    encoding: &Encoding,
    icc_profile: Option<&[u8]>,
    orientation: Orientation,
) -> Result<Vec<u8>, DatasetError> {
    let exif = (orientation != Orientation::NoTransforms).then(|| exif_of(orientation));
    let exif = exif.as_ref().map(<[u8; 26]>::as_slice);
    match encoding {
        Encoding::Png => png_of(pixels, icc_profile, exif),
        Encoding::Jpeg { quality } => {
            let size_px = (pixels.width(), pixels.height());
            check_size(encoding.format(), size_px, MAX_JPEG_SIDE_PX)?;
            let icc_profile = icc_profile.filter(|profile| !profile.is_empty());
            encode_jpeg(pixels, *quality, icc_profile, exif)
        }
    }
}

/// The bytes of an 8-bit grey PNG file for a mask: 255 is covered or influenced, 0 is not.
///
/// # Errors
///
/// [`DatasetError::ImageSize`] for a mask without pixels.
pub fn encode_mask(mask: &GrayImage) -> Result<Vec<u8>, DatasetError> {
    check_size(ImageFormat::Png, mask.dimensions(), MAX_PNG_SIDE_PX)?;
    let mode = (ColorType::Grayscale, BitDepth::Eight);
    // What lies above says as much of a mask as all neighbors do, and is looked up in less time.
    let samples = samples_of(mask);
    write_png(mask.dimensions(), mode, samples, Filter::Up, (None, None))
}

/// The bytes of an image file whose pixels lie as those of the file that `file` was read from:
/// turned back, with the same orientation in its EXIF data, and with its color profile.
///
/// So a reader sees what it would see of that file, whether it minds the orientation or not.
///
/// # Errors
///
/// As for [`encode_image`].
pub fn encode_image_as(file: &ImageFile, encoding: &Encoding) -> Result<Vec<u8>, DatasetError> {
    let icc_profile = file.icc_profile.as_deref();
    if file.orientation == Orientation::NoTransforms {
        return encode_image(&file.pixels, encoding, icc_profile);
    }
    let mut pixels = file.pixels.clone();
    pixels.apply_orientation(inverse(file.orientation));
    encode_oriented(&pixels, encoding, icc_profile, file.orientation)
}

/// The bytes of a mask of an upright image, whose pixels lie as those of its file, as in
/// [`encode_image_as`].
///
/// # Errors
///
/// As for [`encode_mask`].
pub fn encode_mask_as(mask: &GrayImage, file: &ImageFile) -> Result<Vec<u8>, DatasetError> {
    if file.orientation == Orientation::NoTransforms {
        return encode_mask(mask);
    }
    let mut pixels = DynamicImage::ImageLuma8(mask.clone());
    pixels.apply_orientation(inverse(file.orientation));
    encode_oriented(&pixels, &Encoding::Png, None, file.orientation)
}

/// The orientation that undoes another.
fn inverse(orientation: Orientation) -> Orientation {
    match orientation {
        Orientation::Rotate90 => Orientation::Rotate270,
        Orientation::Rotate270 => Orientation::Rotate90,
        // Half turns and mirrors undo themselves.
        other => other,
    }
}

/// EXIF data with nothing but an orientation: a TIFF header and one entry \[Exif2019\].
fn exif_of(orientation: Orientation) -> [u8; 26] {
    let mut exif = *b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\0\0\0\0\0\0\0\0";
    exif[18] = orientation.to_exif();
    exif
}

pub(crate) fn check_size(
    format: ImageFormat,
    (width_px, height_px): (u32, u32),
    max_side_px: u32,
) -> Result<(), DatasetError> {
    if (1..=max_side_px).contains(&width_px) && (1..=max_side_px).contains(&height_px) {
        return Ok(());
    }
    Err(DatasetError::ImageSize {
        format,
        width_px,
        height_px,
        max_side_px,
    })
}

fn png_of(
    pixels: &DynamicImage,
    icc_profile: Option<&[u8]>,
    exif: Option<&[u8]>,
) -> Result<Vec<u8>, DatasetError> {
    use BitDepth::{Eight, Sixteen};
    use ColorType::{Grayscale, GrayscaleAlpha, Rgb, Rgba};
    let size_px = (pixels.width(), pixels.height());
    check_size(ImageFormat::Png, size_px, MAX_PNG_SIDE_PX)?;
    let icc_profile = icc_profile.filter(|profile| !profile.is_empty());
    let (mode, samples) = match pixels {
        DynamicImage::ImageLuma8(i) => ((Grayscale, Eight), Cow::Borrowed(samples_of(i))),
        DynamicImage::ImageLumaA8(i) => ((GrayscaleAlpha, Eight), Cow::Borrowed(samples_of(i))),
        DynamicImage::ImageRgb8(i) => ((Rgb, Eight), Cow::Borrowed(samples_of(i))),
        DynamicImage::ImageRgba8(i) => ((Rgba, Eight), Cow::Borrowed(samples_of(i))),
        DynamicImage::ImageLuma16(i) => {
            ((Grayscale, Sixteen), Cow::Owned(big_endian(samples_of(i))))
        }
        DynamicImage::ImageLumaA16(i) => (
            (GrayscaleAlpha, Sixteen),
            Cow::Owned(big_endian(samples_of(i))),
        ),
        DynamicImage::ImageRgb16(i) => ((Rgb, Sixteen), Cow::Owned(big_endian(samples_of(i)))),
        DynamicImage::ImageRgba16(i) => ((Rgba, Sixteen), Cow::Owned(big_endian(samples_of(i)))),
        other => {
            return Err(DatasetError::UnsupportedMode {
                format: ImageFormat::Png,
                mode: mode_name(other),
                way_out: "convert them to 8 or 16 bits",
            });
        }
    };
    let chunks = (icc_profile, exif);
    write_png(size_px, mode, &samples, PICTURE_FILTER, chunks)
}

fn write_png(
    (width_px, height_px): (u32, u32),
    (color_type, bit_depth): (ColorType, BitDepth),
    samples: &[u8],
    filter: Filter,
    (icc_profile, exif): (Option<&[u8]>, Option<&[u8]>),
) -> Result<Vec<u8>, DatasetError> {
    let mut info = png::Info::with_size(width_px, height_px);
    info.color_type = color_type;
    info.bit_depth = bit_depth;
    info.icc_profile = icc_profile.map(Cow::Borrowed);
    info.exif_metadata = exif.map(Cow::Borrowed);

    // Room for all, or the last few bytes would have what is there copied once more. What is not
    // written to takes no memory.
    let mut bytes = Vec::with_capacity(samples.len());
    let mut encoder = png::Encoder::with_info(&mut bytes, info).map_err(png_error)?;
    use_fast_compression(&mut encoder);
    encoder.set_filter(filter);
    let mut writer = encoder.write_header().map_err(png_error)?;
    writer.write_image_data(samples).map_err(png_error)?;
    writer.finish().map_err(png_error)?;
    Ok(bytes)
}

/// The filter of all pictures but masks.
const PICTURE_FILTER: Filter = Filter::Paeth;

/// 35 times faster than the balanced setting on photographs, and hardly larger. The one filter takes
/// a tenth less time than to choose for each row, and is nearly always the choice
/// (docs/decisions/0017-codecs.md).
pub(crate) fn use_fast_compression<W: std::io::Write>(encoder: &mut png::Encoder<'_, W>) {
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(PICTURE_FILTER);
}

#[expect(clippy::needless_pass_by_value, reason = "the form that map_err wants")]
pub(crate) fn png_error(error: png::EncodingError) -> DatasetError {
    DatasetError::Encode {
        format: ImageFormat::Png,
        reason: one_line(&error),
    }
}

fn encode_jpeg(
    pixels: &DynamicImage,
    quality: JpegQuality,
    icc_profile: Option<&[u8]>,
    exif: Option<&[u8]>,
) -> Result<Vec<u8>, DatasetError> {
    let (color_type, samples) = match pixels {
        DynamicImage::ImageLuma8(i) => (jpeg_encoder::ColorType::Luma, samples_of(i)),
        DynamicImage::ImageRgb8(i) => (jpeg_encoder::ColorType::Rgb, samples_of(i)),
        other => {
            return Err(DatasetError::UnsupportedMode {
                format: ImageFormat::Jpeg,
                mode: mode_name(other),
                way_out: "use PNG for this image",
            });
        }
    };
    let error = |error: jpeg_encoder::EncodingError| DatasetError::Encode {
        format: ImageFormat::Jpeg,
        reason: one_line(&error),
    };
    let side = |side_px| {
        u16::try_from(side_px).map_err(|_| DatasetError::ImageSize {
            format: ImageFormat::Jpeg,
            width_px: pixels.width(),
            height_px: pixels.height(),
            max_side_px: MAX_JPEG_SIDE_PX,
        })
    };

    let mut bytes = Vec::new();
    let mut encoder = jpeg_encoder::Encoder::new(&mut bytes, quality.get());
    encoder.set_sampling_factor(if quality.get() >= 90 {
        SamplingFactor::F_1_1
    } else {
        SamplingFactor::F_2_2
    });
    if let Some(exif) = exif {
        encoder.add_exif_metadata(exif).map_err(error)?;
    }
    if let Some(profile) = icc_profile {
        encoder.add_icc_profile(profile).map_err(error)?;
    }
    encoder
        .encode(
            samples,
            side(pixels.width())?,
            side(pixels.height())?,
            color_type,
        )
        .map_err(error)?;
    Ok(bytes)
}

/// The samples of the pixels alone: the buffer behind an image may be longer.
pub(crate) fn samples_of<P: Pixel>(image: &ImageBuffer<P, Vec<P::Subpixel>>) -> &[P::Subpixel] {
    let samples = image.as_raw();
    let n_samples =
        image.width() as usize * image.height() as usize * usize::from(P::CHANNEL_COUNT);
    samples.get(..n_samples).unwrap_or(samples)
}

fn big_endian(samples: &[u16]) -> Vec<u8> {
    samples.iter().flat_map(|s| s.to_be_bytes()).collect()
}

fn mode_name(pixels: &DynamicImage) -> &'static str {
    match ExtendedColorType::from(pixels.color()) {
        ExtendedColorType::L8 => "L8",
        ExtendedColorType::La8 => "La8",
        ExtendedColorType::Rgb8 => "Rgb8",
        ExtendedColorType::Rgba8 => "Rgba8",
        ExtendedColorType::L16 => "L16",
        ExtendedColorType::La16 => "La16",
        ExtendedColorType::Rgb16 => "Rgb16",
        ExtendedColorType::Rgba16 => "Rgba16",
        ExtendedColorType::Rgb32F => "Rgb32F",
        ExtendedColorType::Rgba32F => "Rgba32F",
        _ => "such",
    }
}
