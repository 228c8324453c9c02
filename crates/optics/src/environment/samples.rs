//! A few pixels of an image, in linear light.

use std::ops::Range;

use image::{DynamicImage, GenericImageView};

use super::Rgb;
use crate::srgb::{decode8, decode16};

/// Pixels of a few rows at most.
const MOST: u32 = 2048;

/// A pixel: the middle of its square in the frame, px, and its light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) column_px: f64,
    pub(super) row_px: f64,
    pub(super) rgb: Rgb,
}

/// At most 2048 pixels of some rows, on a grid of nearly square cells.
///
/// Grey has three equal channels; opacity is ignored.
pub(super) fn samples(image: &DynamicImage, rows: Range<u32>) -> Vec<Sample> {
    match image {
        DynamicImage::ImageLuma8(pixels) => gather(pixels.as_raw(), 1, image, rows, decode8),
        DynamicImage::ImageLumaA8(pixels) => gather(pixels.as_raw(), 2, image, rows, decode8),
        DynamicImage::ImageRgb8(pixels) => gather(pixels.as_raw(), 3, image, rows, decode8),
        DynamicImage::ImageRgba8(pixels) => gather(pixels.as_raw(), 4, image, rows, decode8),
        DynamicImage::ImageLuma16(pixels) => gather(pixels.as_raw(), 1, image, rows, decode16),
        DynamicImage::ImageLumaA16(pixels) => gather(pixels.as_raw(), 2, image, rows, decode16),
        DynamicImage::ImageRgb16(pixels) => gather(pixels.as_raw(), 3, image, rows, decode16),
        DynamicImage::ImageRgba16(pixels) => gather(pixels.as_raw(), 4, image, rows, decode16),
        _ => over_grid(image.width(), rows, |x, y| {
            let [red, green, blue, _] = image.get_pixel(x, y).0;
            [decode8(red), decode8(green), decode8(blue)]
        }),
    }
}

/// The same of a frame of a width, px, whose pixels are asked for by column and row.
pub(super) fn samples_of(
    width: u32,
    rows: Range<u32>,
    codes: &dyn Fn(u32, u32) -> [u8; 3],
) -> Vec<Sample> {
    over_grid(width, rows, |x, y| codes(x, y).map(decode8))
}

fn gather<S: Copy>(
    raw: &[S],
    channels: usize,
    image: &DynamicImage,
    rows: Range<u32>,
    decode: impl Fn(S) -> f32,
) -> Vec<Sample> {
    let width = image.width() as usize;
    over_grid(image.width(), rows, |x, y| {
        let at = (y as usize * width + x as usize) * channels;
        if channels < 3 {
            [decode(raw[at]); 3]
        } else {
            [decode(raw[at]), decode(raw[at + 1]), decode(raw[at + 2])]
        }
    })
}

fn over_grid(width: u32, rows: Range<u32>, pixel: impl Fn(u32, u32) -> Rgb) -> Vec<Sample> {
    let height = rows.end.saturating_sub(rows.start);
    let (columns, lines) = grid(width, height);
    let mut samples = Vec::with_capacity((columns * lines) as usize);
    for line in 0..lines {
        let y = rows.start + middle(line, lines, height);
        for column in 0..columns {
            let x = middle(column, columns, width);
            samples.push(Sample {
                column_px: f64::from(x) + 0.5,
                row_px: f64::from(y) + 0.5,
                rgb: pixel(x, y),
            });
        }
    }
    samples
}

/// Columns and lines of a grid of at most [`MOST`] points.
fn grid(width: u32, height: u32) -> (u32, u32) {
    if width == 0 || height == 0 {
        return (0, 0);
    }
    let cell = (f64::from(width) * f64::from(height) / f64::from(MOST))
        .sqrt()
        .max(1.0);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "no more than the width"
    )]
    let columns = ((f64::from(width) / cell) as u32).clamp(1, MOST);
    (columns, height.min(MOST / columns))
}

/// The pixel in the middle of cell `i` of `n` over `length` pixels.
fn middle(i: u32, n: u32, length: u32) -> u32 {
    let at = (2 * u64::from(i) + 1) * u64::from(length) / (2 * u64::from(n));
    // Below length, as i is below n.
    u32::try_from(at).unwrap_or(length - 1)
}

#[cfg(test)]
mod tests {
    use image::{Luma, LumaA, Rgb as RgbPixel, Rgba};

    use super::*;

    #[test]
    fn the_grid_stays_in_its_budget_and_covers_the_rows() {
        for (width, height) in [
            (1, 1),
            (1, 100_000),
            (100_000, 1),
            (3, 2),
            (1242, 125),
            (1242, 1),
            (45, 46),
            (8192, 8192),
        ] {
            let (columns, lines) = grid(width, height);
            assert!(
                (1..=MOST).contains(&(columns * lines)),
                "{width} × {height}: {columns} × {lines}"
            );
            assert!(columns <= width && lines <= height, "{width} × {height}");
            let least = f64::from(MOST.min(width * height)) * 0.5;
            assert!(
                f64::from(columns * lines) >= least,
                "{width} × {height}: {columns} × {lines}"
            );
        }
    }

    #[test]
    fn the_middle_of_the_grid_is_that_of_the_rows() {
        let image = DynamicImage::ImageLuma8(image::GrayImage::new(1242, 375));
        let places = samples(&image, 100..200);
        let count = f64::from(u32::try_from(places.len()).unwrap_or(0));
        let column = places.iter().map(|sample| sample.column_px).sum::<f64>() / count;
        let row = places.iter().map(|sample| sample.row_px).sum::<f64>() / count;
        assert!((column - 621.0).abs() < 0.6, "column {column}");
        assert!((row - 150.0).abs() < 0.6, "row {row}");
    }

    #[test]
    fn every_pixel_of_a_small_image_is_taken_once() {
        let image = DynamicImage::ImageLuma8(image::GrayImage::new(7, 5));
        let places: Vec<_> = samples(&image, 1..4)
            .iter()
            .map(|sample| (sample.column_px, sample.row_px))
            .collect();
        let expected: Vec<_> = (1..4)
            .flat_map(|y| (0..7).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)))
            .collect();
        assert_eq!(places, expected);
        assert!(samples(&image, 3..3).is_empty(), "no rows, no samples");
    }

    #[test]
    fn every_mode_gives_the_same_light() {
        let (red, green, blue) = (200_u8, 90_u8, 30_u8);
        let wide = |code: u8| u16::from(code) * 257;
        let color = [
            DynamicImage::ImageRgb8(image::ImageBuffer::from_pixel(
                4,
                3,
                RgbPixel([red, green, blue]),
            )),
            DynamicImage::ImageRgba8(image::ImageBuffer::from_pixel(
                4,
                3,
                Rgba([red, green, blue, 10]),
            )),
            DynamicImage::ImageRgb16(image::ImageBuffer::from_pixel(
                4,
                3,
                RgbPixel([wide(red), wide(green), wide(blue)]),
            )),
            DynamicImage::ImageRgba16(image::ImageBuffer::from_pixel(
                4,
                3,
                Rgba([wide(red), wide(green), wide(blue), 99]),
            )),
        ];
        for image in color {
            for sample in samples(&image, 0..3) {
                let expected = [decode8(red), decode8(green), decode8(blue)];
                for (found, expected) in sample.rgb.into_iter().zip(expected) {
                    assert!((found - expected).abs() < 1e-7, "{:?}", image.color());
                }
            }
        }
        let grey = [
            DynamicImage::ImageLuma8(image::ImageBuffer::from_pixel(4, 3, Luma([red]))),
            DynamicImage::ImageLumaA8(image::ImageBuffer::from_pixel(4, 3, LumaA([red, 10]))),
            DynamicImage::ImageLuma16(image::ImageBuffer::from_pixel(4, 3, Luma([wide(red)]))),
            DynamicImage::ImageLumaA16(image::ImageBuffer::from_pixel(
                4,
                3,
                LumaA([wide(red), 99]),
            )),
        ];
        for image in grey {
            for sample in samples(&image, 0..3) {
                for found in sample.rgb {
                    assert!((found - decode8(red)).abs() < 1e-7, "{:?}", image.color());
                }
            }
        }
    }
}
