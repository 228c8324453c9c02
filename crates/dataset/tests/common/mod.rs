//! Images and files made in memory, for the tests.
#![expect(dead_code, reason = "each test file uses its own part")]
#![expect(clippy::unwrap_used, reason = "a failure here is a broken test")]

use image::{DynamicImage, ImageBuffer, Luma, Pixel, Rgb, RgbImage};

/// A smooth picture with a little texture, in 16 bits so that no low byte is constant.
fn sample(x: u32, y: u32, channel: u32) -> u16 {
    let wave = x * 701 + y * 907 + channel * 9973 + (x * y * 37) % 600;
    u16::try_from(wave % 65_536).unwrap()
}

fn picture<P: Pixel>(
    width_px: u32,
    height_px: u32,
    convert: impl Fn(u16) -> P::Subpixel,
) -> ImageBuffer<P, Vec<P::Subpixel>> {
    ImageBuffer::from_fn(width_px, height_px, |x, y| {
        let channels: Vec<_> = (0..u32::from(P::CHANNEL_COUNT))
            .map(|channel| convert(sample(x, y, channel)))
            .collect();
        *P::from_slice(&channels)
    })
}

fn high_byte(sample: u16) -> u8 {
    sample.to_be_bytes()[0]
}

/// One picture in each of the eight modes that PNG can hold.
pub(crate) fn all_modes(width_px: u32, height_px: u32) -> Vec<DynamicImage> {
    let (w, h) = (width_px, height_px);
    vec![
        DynamicImage::ImageLuma8(picture(w, h, high_byte)),
        DynamicImage::ImageLumaA8(picture(w, h, high_byte)),
        DynamicImage::ImageRgb8(picture(w, h, high_byte)),
        DynamicImage::ImageRgba8(picture(w, h, high_byte)),
        DynamicImage::ImageLuma16(picture(w, h, |s| s)),
        DynamicImage::ImageLumaA16(picture(w, h, |s| s)),
        DynamicImage::ImageRgb16(picture(w, h, |s| s)),
        DynamicImage::ImageRgba16(picture(w, h, |s| s)),
    ]
}

pub(crate) fn rgb(width_px: u32, height_px: u32) -> RgbImage {
    picture::<Rgb<u8>>(width_px, height_px, high_byte)
}

/// A smooth ramp, which JPEG keeps well even with halved chroma.
pub(crate) fn ramp(width_px: u32, height_px: u32) -> RgbImage {
    let level = |value: u32, n: u32| u8::try_from(value * 255 / n).unwrap();
    RgbImage::from_fn(width_px, height_px, |x, y| {
        Rgb([
            level(x, width_px),
            level(y, height_px),
            level(x + y, width_px + height_px),
        ])
    })
}

pub(crate) fn gray_ramp(width_px: u32, height_px: u32) -> ImageBuffer<Luma<u8>, Vec<u8>> {
    ImageBuffer::from_fn(width_px, height_px, |x, _| {
        Luma([u8::try_from(x * 255 / width_px).unwrap()])
    })
}

/// A TIFF block, little endian, with nothing but the orientation.
pub(crate) fn exif(orientation: u8) -> Vec<u8> {
    let mut bytes = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    bytes.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
    bytes
}

pub(crate) fn png_with(info: png::Info<'_>, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = png::Encoder::with_info(&mut bytes, info).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    writer.finish().unwrap();
    bytes
}

pub(crate) fn png_info(
    size: (u32, u32),
    color: png::ColorType,
    depth: png::BitDepth,
) -> png::Info<'static> {
    let mut info = png::Info::with_size(size.0, size.1);
    info.color_type = color;
    info.bit_depth = depth;
    info
}

pub(crate) fn jpeg_with(
    image: &RgbImage,
    set_up: impl FnOnce(&mut jpeg_encoder::Encoder<&mut Vec<u8>>),
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = jpeg_encoder::Encoder::new(&mut bytes, 92);
    set_up(&mut encoder);
    let side = |n| u16::try_from(n).unwrap();
    let (w, h) = (side(image.width()), side(image.height()));
    encoder
        .encode(image, w, h, jpeg_encoder::ColorType::Rgb)
        .unwrap();
    bytes
}

/// Peak signal to noise ratio of 8-bit samples, in dB.
pub(crate) fn psnr_db(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len(), "images of one size");
    let sum: f64 = a
        .iter()
        .zip(b)
        .map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2))
        .sum();
    let n = f64::from(u32::try_from(a.len()).unwrap());
    10.0 * (255.0f64.powi(2) * n / sum.max(1e-9)).log10()
}

/// A file of the shared data, or `None` with a note on the error output.
pub(crate) fn shared_data(path: &str) -> Option<std::path::PathBuf> {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"))
        .join(path);
    if path.exists() {
        return Some(path);
    }
    #[expect(clippy::print_stderr, reason = "a skipped test must be seen")]
    {
        eprintln!("SKIPPED: {} is not there", path.display());
    }
    None
}
