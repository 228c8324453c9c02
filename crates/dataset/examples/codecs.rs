//! Time and size of every codec over image files, on one thread: `codecs FILE...`.
//!
//! The first rows are what this crate uses, the others what it could: mean over the files of the
//! least of some rounds, in which all rows take turns, in ms, and mean bytes.
#![expect(clippy::print_stdout, reason = "a report is what this is for")]

use std::collections::BTreeMap;
use std::error::Error;
use std::hint::black_box;
use std::io::Cursor;
use std::path::Path;
use std::time::Instant;

use image::{DynamicImage, GrayImage, Luma};
use jpeg_encoder::SamplingFactor;
use png::{BitDepth, ColorType, Compression, Filter};
use starbreak_dataset::{
    Encoding, ImageFormat, ImageLimits, JpegQuality, decode_image, encode_image, encode_mask,
};

const ROUNDS: usize = 7;

const FILTERS: [Filter; 6] = [
    Filter::NoFilter,
    Filter::Sub,
    Filter::Up,
    Filter::Avg,
    Filter::Paeth,
    Filter::Adaptive,
];

/// Least time, ms, and bytes of each row.
type Rows = BTreeMap<String, (f64, usize)>;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let mut sums: BTreeMap<String, (f64, usize, usize)> = BTreeMap::new();
    for path in std::env::args_os().skip(1) {
        for (row, (ms, n_bytes)) in rows_of(Path::new(&path))? {
            let sum = sums.entry(row).or_default();
            *sum = (sum.0 + ms, sum.1 + n_bytes, sum.2 + 1);
        }
    }
    println!("{:36} {:>9} {:>9} {:>6}", "", "ms", "bytes", "files");
    for (row, (ms, n_bytes, n)) in sums {
        #[expect(clippy::cast_precision_loss, reason = "a number of files")]
        let mean_ms = ms / n as f64;
        println!("{row:36} {mean_ms:9.3} {:9} {n:6}", n_bytes / n);
    }
    Ok(())
}

fn rows_of(path: &Path) -> Outcome<Rows> {
    let bytes = std::fs::read(path)?;
    let limits = ImageLimits::default();
    let image = decode_image("file", &bytes, &limits)?;
    let mut rows = Rows::new();
    let DynamicImage::ImageRgb8(pixels) = &image.pixels else {
        return Ok(rows);
    };
    let mask = star(pixels.dimensions());
    for _ in 0..ROUNDS {
        timed(&mut rows, "used: decode_image", || {
            black_box(decode_image("file", &bytes, &limits)?);
            Ok(bytes.len())
        })?;
        timed(&mut rows, "used: encode_mask", || {
            Ok(encode_mask(&mask)?.len())
        })?;
        timed(&mut rows, "image.clone()", || {
            Ok(black_box(image.pixels.clone()).as_bytes().len())
        })?;
        for filter in FILTERS {
            let mode = ColorType::Grayscale;
            timed(&mut rows, &format!("mask {filter:?}"), || {
                png_of(mask.dimensions(), mode, &mask, Compression::Fast, filter)
            })?;
        }
        match image.format {
            ImageFormat::Png => png_rows(&mut rows, &bytes, &image.pixels)?,
            _ => jpeg_rows(&mut rows, &bytes, &image.pixels)?,
        }
    }
    Ok(rows)
}

fn png_rows(rows: &mut Rows, bytes: &[u8], image: &DynamicImage) -> Outcome<()> {
    let size = (image.width(), image.height());
    timed(rows, "used: encode_image PNG", || {
        Ok(encode_image(image, &Encoding::Png, None)?.len())
    })?;
    timed(rows, "png decode alone", || {
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info()?;
        let mut samples = vec![0; reader.output_buffer_size().unwrap_or(0)];
        reader.next_frame(&mut samples)?;
        Ok(black_box(samples).len())
    })?;
    for compression in [Compression::Fastest, Compression::Fast] {
        for filter in FILTERS {
            timed(rows, &format!("png {compression:?} {filter:?}"), || {
                png_of(size, ColorType::Rgb, image.as_bytes(), compression, filter)
            })?;
        }
    }
    Ok(())
}

fn jpeg_rows(rows: &mut Rows, bytes: &[u8], image: &DynamicImage) -> Outcome<()> {
    timed(rows, "jpeg decode by `image`", || {
        let image = image::load_from_memory_with_format(bytes, image::ImageFormat::Jpeg)?;
        Ok(black_box(image).as_bytes().len())
    })?;
    for quality in [75, 90, 95] {
        let encoding = Encoding::Jpeg {
            quality: JpegQuality::new(quality)?,
        };
        timed(rows, &format!("used: encode_image JPEG q{quality}"), || {
            Ok(encode_image(image, &encoding, None)?.len())
        })?;
        for sampling in [SamplingFactor::F_1_1, SamplingFactor::F_2_2] {
            timed(rows, &format!("jpeg q{quality} {sampling:?}"), || {
                let mut out = Vec::new();
                let mut encoder = jpeg_encoder::Encoder::new(&mut out, quality);
                encoder.set_sampling_factor(sampling);
                let (width, height) = (u16::try_from(image.width())?, image.height().try_into()?);
                encoder.encode(
                    image.as_bytes(),
                    width,
                    height,
                    jpeg_encoder::ColorType::Rgb,
                )?;
                Ok(out.len())
            })?;
        }
    }
    Ok(())
}

fn timed(rows: &mut Rows, row: &str, work: impl FnOnce() -> Outcome<usize>) -> Outcome<()> {
    let start = Instant::now();
    let n_bytes = work()?;
    let ms = start.elapsed().as_secs_f64() * 1e3;
    let entry = rows.entry(row.to_owned()).or_insert((ms, n_bytes));
    entry.0 = entry.0.min(ms);
    Ok(())
}

fn png_of(
    (width, height): (u32, u32),
    mode: ColorType,
    samples: &[u8],
    compression: Compression,
    filter: Filter,
) -> Outcome<usize> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(mode);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(compression);
    encoder.set_filter(filter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()?;
    Ok(out.len())
}

/// A mask like one of cracks: rays of 1 to 6 px, of some levels.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "px of a frame"
)]
fn star((width, height): (u32, u32)) -> GrayImage {
    let mut mask = GrayImage::new(width, height);
    for ray in 0..40_u32 {
        let (sin, cos) = (0.157 * f64::from(ray)).sin_cos();
        for along in 0..width / 4 {
            let x = (f64::from(width / 2) + cos * f64::from(along)) as u32;
            let y = (f64::from(height / 2) + sin * f64::from(along)) as u32;
            for x in x..(x + 1 + ray % 6).min(width) {
                if y < height {
                    mask.put_pixel(x, y, Luma([255 - 40 * (ray % 3) as u8]));
                }
            }
        }
    }
    mask
}
