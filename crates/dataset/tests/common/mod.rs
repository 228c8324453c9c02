//! Images and files made in memory, for the tests.
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

/// Writes a file below a folder, with the folders above it.
pub(crate) fn put(root: &std::path::Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = root.join(name);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, bytes).unwrap();
}

/// A PNG of this size.
pub(crate) fn png(width_px: u32, height_px: u32) -> Vec<u8> {
    let image = DynamicImage::ImageRgb8(rgb(width_px, height_px));
    starbreak_dataset::encode_image(&image, &starbreak_dataset::Encoding::Png, None).unwrap()
}

/// The dataset that a word names, which must be good as a whole.
pub(crate) fn open(format: &str, path: &std::path::Path) -> starbreak_dataset::Source {
    try_open(format, path).unwrap()
}

/// The dataset that a word names.
pub(crate) fn try_open(
    format: &str,
    path: &std::path::Path,
) -> Result<starbreak_dataset::Source, starbreak_dataset::DatasetError> {
    let mut word = std::ffi::OsString::from(format!("{format}:"));
    word.push(path);
    starbreak_dataset::Source::open(&starbreak_dataset::SourceSpec::parse(&word)?)
}

/// What a dataset holds, as text: names of images, bad records, problems, other files.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Contents {
    pub(crate) images: Vec<String>,
    pub(crate) bad: Vec<String>,
    pub(crate) problems: Vec<String>,
    /// `record category kind x0 y0 x1 y1`.
    pub(crate) objects: Vec<String>,
    /// `name` or `name -> image` or `name (index)`.
    pub(crate) files: Vec<String>,
    pub(crate) bad_files: Vec<String>,
}

/// Walks a dataset twice, which must give the same.
pub(crate) fn contents(source: &starbreak_dataset::Source) -> Contents {
    let once = walked(source);
    assert_eq!(once, walked(source), "a second walk");
    let messages = once.bad.iter().chain(&once.problems).chain(&once.bad_files);
    for message in messages {
        assert!(!message.contains(char::is_control), "{message:?}");
    }
    assert!(once.images.is_sorted(), "{:?}", once.images);
    once
}

fn walked(source: &starbreak_dataset::Source) -> Contents {
    use starbreak_dataset::FileRole;
    let mut contents = Contents::default();
    for image in source.images() {
        let image = match image {
            Ok(image) => image,
            Err(bad) => {
                contents.bad.push(bad.to_string());
                continue;
            }
        };
        for problem in &image.problems {
            assert_eq!(problem.image.as_ref(), Some(&image.name), "{problem}");
            contents.problems.push(problem.to_string());
        }
        for object in &image.objects {
            let [x0, y0, x1, y1] = object.box_px;
            contents.objects.push(format!(
                "{} {} {:?} {x0} {y0} {x1} {y1}",
                object.record, object.category, object.kind
            ));
        }
        contents.images.push(image.name);
    }
    let names: Vec<String> = source.names().collect();
    assert_eq!(names, contents.images, "names alone");
    for file in source.files() {
        match file {
            Ok(file) => contents.files.push(match file.role {
                FileRole::LabelOf(image) => format!("{} -> {image}", file.name),
                FileRole::Index => format!("{} (index)", file.name),
                FileRole::Other => file.name,
            }),
            Err(bad) => contents.bad_files.push(bad.to_string()),
        }
    }
    contents
}

/// The index of this name for the images of these names.
pub(crate) fn subset(
    source: &starbreak_dataset::Source,
    index: &str,
    is_kept: impl Fn(&str) -> bool,
) -> String {
    let file = source.files().map(Result::unwrap).find(|f| f.name == index);
    let mut bytes = Vec::new();
    source
        .subset(&file.unwrap(), &mut |name| is_kept(name), &mut bytes)
        .unwrap();
    String::from_utf8(bytes).unwrap()
}
