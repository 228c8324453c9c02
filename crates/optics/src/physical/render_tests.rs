#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::RgbImage;

use super::*;
use crate::environment::{Rgb, luminance};
use crate::srgb::{decode8, decode16, encode8, encode16};

/// What is kept and added of each color of a pixel.
fn keep_and_add(x: usize, y: usize) -> (Rgb, Rgb) {
    match (x + 2 * y) % 3 {
        0 => ([1.0; 3], [0.0; 3]),
        1 => ([0.4, 0.5, 0.6], [0.2, 0.1, 0.0]),
        _ => ([0.9, 0.0, 0.3], [0.0, 1.5, 0.01]),
    }
}

/// Samples of `n_colors` and the rest of a pixel, by hand.
fn by_hand<S: Copy>(
    samples: &[S],
    (width, n_colors, stride): (usize, usize, usize),
    over: impl Fn(S, f32, f32) -> S,
) -> Vec<S> {
    let mut out = samples.to_vec();
    for (at, pixel) in out.chunks_exact_mut(stride).enumerate() {
        let (keep, add) = keep_and_add(at % width, at / width);
        for c in 0..n_colors {
            let of = |rgb: Rgb| {
                if n_colors == 1 {
                    luminance(rgb)
                } else {
                    rgb[c]
                }
            };
            pixel[c] = over(pixel[c], of(keep), of(add));
        }
    }
    out
}

#[test]
fn images_of_every_mode_and_width_get_the_light_of_each_pixel() {
    for width in [7_u32, 32, 45] {
        let size = (width, 5);
        let photo: DynamicImage = RgbImage::from_fn(width, 5, |x, y| {
            image::Rgb([x * 5, y * 40, x + y].map(|code| u8::try_from(code).unwrap()))
        })
        .into();
        let optics = PhysicalOptics::default();
        let overlay = Overlay::of_pixels((size, 800.0), &Environment::DAY, &optics, keep_and_add);
        for image in [
            DynamicImage::from(photo.to_luma8()),
            photo.to_luma_alpha8().into(),
            photo.to_rgb8().into(),
            photo.to_rgba8().into(),
            photo.to_luma16().into(),
            photo.to_luma_alpha16().into(),
            photo.to_rgb16().into(),
            photo.to_rgba16().into(),
        ] {
            let mode = image.color();
            let stride = usize::from(mode.channel_count());
            let of = (
                width as usize,
                stride - usize::from(mode.has_alpha()),
                stride,
            );
            let mut cracked = image.clone();
            overlay.apply(&mut cracked, Seed(1)).unwrap();
            if mode.bytes_per_pixel() == mode.channel_count() {
                let over = |code, keep, add| encode8(decode8(code) * keep + add);
                assert_eq!(
                    cracked.as_bytes(),
                    by_hand(image.as_bytes(), of, over),
                    "{mode:?}"
                );
            } else {
                let samples = |image: &DynamicImage| -> Vec<u16> {
                    let (pairs, _) = image.as_bytes().as_chunks();
                    pairs.iter().map(|pair| u16::from_ne_bytes(*pair)).collect()
                };
                let over = |code, keep, add| encode16(decode16(code) * keep + add);
                assert_eq!(
                    samples(&cracked),
                    by_hand(&samples(&image), of, over),
                    "{mode:?}"
                );
            }
        }
    }
}
