//! How visible a crack is: what it changed in the pixels that it influences.

use image::{DynamicImage, GrayImage};

use crate::OpticsError;
use crate::environment::luminance;
use crate::srgb::{decode8, decode16};

/// How visible a crack is in an image, over the pixels of a region.
///
/// With L the luminance of linear light, 1 for white, and L₀ that without the crack. All are 0
/// where the region is empty.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Contrast {
    /// Mean of |L − L₀|, 0 to 1.
    pub mean: f64,
    /// That mean over the mean of L₀: Weber contrast. 0 where L₀ is black all over.
    pub weber: f64,
    /// Share of the pixels that became brighter, 0 to 1.
    pub brighter: f64,
    /// Share of the pixels that became darker, 0 to 1.
    pub darker: f64,
    /// Root mean square of the change of code values, 0 to 255 (16-bit ones over 257), of all
    /// colors: what a detector gets.
    pub rms_code: f64,
}

impl Contrast {
    /// The contrast of an image with a crack to the one without it, where the region is not 0.
    ///
    /// # Limits
    /// What a scene out of focus, or glare, changed within the region counts as well.
    ///
    /// # Errors
    /// [`OpticsError::SizeMismatch`] for images or a region of another size,
    /// [`OpticsError::ImageMode`] for two images of different modes, or of floating point.
    pub fn of(
        before: &DynamicImage,
        after: &DynamicImage,
        region: &GrayImage,
    ) -> Result<Self, OpticsError> {
        check_sizes((before.width(), before.height()), after, region)?;
        let region = region.as_raw();
        let of_mode = match (before, after) {
            (DynamicImage::ImageLuma8(a), DynamicImage::ImageLuma8(b)) => over8::<1>(a, b, region),
            (DynamicImage::ImageLumaA8(a), DynamicImage::ImageLumaA8(b)) => {
                over8::<2>(a, b, region)
            }
            (DynamicImage::ImageRgb8(a), DynamicImage::ImageRgb8(b)) => over8::<3>(a, b, region),
            (DynamicImage::ImageRgba8(a), DynamicImage::ImageRgba8(b)) => over8::<4>(a, b, region),
            (DynamicImage::ImageLuma16(a), DynamicImage::ImageLuma16(b)) => {
                over16::<1>(a, b, region)
            }
            (DynamicImage::ImageLumaA16(a), DynamicImage::ImageLumaA16(b)) => {
                over16::<2>(a, b, region)
            }
            (DynamicImage::ImageRgb16(a), DynamicImage::ImageRgb16(b)) => over16::<3>(a, b, region),
            (DynamicImage::ImageRgba16(a), DynamicImage::ImageRgba16(b)) => {
                over16::<4>(a, b, region)
            }
            _ => {
                return Err(OpticsError::ImageMode {
                    mode: format!("{:?} and {:?}", before.color(), after.color()),
                });
            }
        };
        Ok(of_mode.contrast())
    }
}

/// Before and region have to have the size of the image with the crack.
pub(crate) fn check_sizes(
    before: (u32, u32),
    after: &DynamicImage,
    region: &GrayImage,
) -> Result<(), OpticsError> {
    let (width, height) = (after.width(), after.height());
    for (of_width, of_height) in [before, region.dimensions()] {
        if (of_width, of_height) != (width, height) {
            return Err(OpticsError::SizeMismatch {
                width: of_width,
                height: of_height,
                drawn_width: width as usize,
                drawn_height: height as usize,
            });
        }
    }
    Ok(())
}

/// Sums over the pixels of a region.
#[derive(Debug, Default)]
struct Sums {
    n: u32,
    n_colors: u32,
    n_brighter: u32,
    n_darker: u32,
    change: f64,
    before: f64,
    squares: f64,
}

impl Sums {
    fn contrast(&self) -> Contrast {
        let over = |sum: f64, n: f64| if n > 0.0 { sum / n } else { 0.0 };
        let [n, n_colors, n_brighter, n_darker] =
            [self.n, self.n_colors, self.n_brighter, self.n_darker].map(f64::from);
        Contrast {
            mean: over(self.change, n),
            weber: over(self.change, self.before),
            brighter: over(n_brighter, n),
            darker: over(n_darker, n),
            rms_code: over(self.squares, n * n_colors).sqrt(),
        }
    }
}

fn over8<const CHANNELS: usize>(before: &[u8], after: &[u8], region: &[u8]) -> Sums {
    over::<_, CHANNELS>(before, after, region, decode8, |sum, colors| {
        // Whole numbers, so that their order does not matter.
        let squares = colors.map(|(before, after)| {
            let change = i32::from(after) - i32::from(before);
            change * change
        });
        sum + f64::from(squares.sum::<i32>())
    })
}

fn over16<const CHANNELS: usize>(before: &[u16], after: &[u16], region: &[u8]) -> Sums {
    let code = |sample: u16| f64::from(sample) / 257.0;
    over::<_, CHANNELS>(before, after, region, decode16, |sum, colors| {
        colors.fold(sum, |sum, (before, after)| {
            let change = code(after) - code(before);
            sum + change * change
        })
    })
}

/// Pixels that are looked at together.
const BLOCK: usize = 32;

/// The colors of a pixel before and after.
type Colors<'a, S> = std::iter::Zip<
    std::iter::Copied<std::slice::Iter<'a, S>>,
    std::iter::Copied<std::slice::Iter<'a, S>>,
>;

fn over<S: Copy, const CHANNELS: usize>(
    before: &[S],
    after: &[S],
    region: &[u8],
    decode: impl Fn(S) -> f32,
    add_squares: impl Fn(f64, Colors<'_, S>) -> f64,
) -> Sums {
    let n_colors = if CHANNELS < 3 { 1 } else { 3 };
    let light = |pixel: &[S; CHANNELS]| {
        let of_color = |c: usize| decode(pixel[c.min(n_colors - 1)]);
        f64::from(luminance([of_color(0), of_color(1), of_color(2)]))
    };
    let mut sums = Sums {
        n_colors: if n_colors == 1 { 1 } else { 3 },
        ..Sums::default()
    };
    let pixels = before.as_chunks().0.chunks(BLOCK);
    let pixels = pixels.zip(after.as_chunks().0.chunks(BLOCK));
    for ((before, after), region) in pixels.zip(region.chunks(BLOCK)) {
        // Most blocks of a mask hold nothing, and are seen as a whole.
        if region.iter().fold(0, |any, code| any | code) == 0 {
            continue;
        }
        for ((before, after), influence) in before.iter().zip(after).zip(region) {
            if *influence == 0 {
                continue;
            }
            let (was, is) = (light(before), light(after));
            sums.n += 1;
            sums.n_brighter += u32::from(is > was);
            sums.n_darker += u32::from(is < was);
            sums.change += (is - was).abs();
            sums.before += was;
            let colors = before[..n_colors].iter().copied();
            let colors = colors.zip(after[..n_colors].iter().copied());
            sums.squares = add_squares(sums.squares, colors);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use image::{ImageBuffer, Luma, Rgb, RgbImage, Rgba};

    use super::*;

    fn gray(codes: [u8; 4]) -> DynamicImage {
        DynamicImage::ImageLuma8(GrayImage::from_raw(4, 1, codes.to_vec()).unwrap())
    }

    fn region(codes: [u8; 4]) -> GrayImage {
        GrayImage::from_raw(4, 1, codes.to_vec()).unwrap()
    }

    /// Codes 188 and 137 show 0.502886 and 0.250158 of white (IEC 61966-2-1, by hand).
    const LIGHT_188: f64 = 0.502_886;
    const LIGHT_137: f64 = 0.250_158;

    #[test]
    fn figures_are_those_of_the_region_alone() {
        let before = gray([188, 188, 0, 77]);
        let after = gray([137, 188, 255, 99]);
        let contrast = Contrast::of(&before, &after, &region([255, 255, 1, 0])).unwrap();
        let change = (LIGHT_188 - LIGHT_137) + 0.0 + 1.0;
        for (what, value, expected) in [
            ("mean", contrast.mean, change / 3.0),
            ("weber", contrast.weber, change / (2.0 * LIGHT_188)),
            ("brighter", contrast.brighter, 1.0 / 3.0),
            ("darker", contrast.darker, 1.0 / 3.0),
            (
                "codes",
                contrast.rms_code,
                ((51.0 * 51.0 + 255.0 * 255.0) / 3.0_f64).sqrt(),
            ),
        ] {
            assert!(
                (value - expected).abs() < 2e-5,
                "{what}: {value}, {expected}"
            );
        }
    }

    #[test]
    fn color_depth_and_alpha_make_no_difference_to_gray() {
        let codes = [([200, 10, 90, 3], [100, 12, 90, 255])];
        for (was, is) in codes {
            let all = region([255; 4]);
            let expected = Contrast::of(&gray(was), &gray(is), &all).unwrap();
            let rgb = |codes: [u8; 4]| {
                DynamicImage::ImageRgb8(RgbImage::from_fn(4, 1, |x, _| Rgb([codes[x as usize]; 3])))
            };
            let rgba = |codes: [u8; 4], alpha: u16| {
                DynamicImage::ImageRgba16(ImageBuffer::from_fn(4, 1, |x, _| {
                    let code = u16::from(codes[x as usize]) * 257;
                    Rgba([code, code, code, alpha])
                }))
            };
            let deep = |codes: [u8; 4]| {
                DynamicImage::ImageLuma16(ImageBuffer::from_fn(4, 1, |x, _| {
                    Luma([u16::from(codes[x as usize]) * 257])
                }))
            };
            for (name, before, after) in [
                ("RGB", rgb(was), rgb(is)),
                ("RGBA", rgba(was, 65535), rgba(is, 7)),
                ("16 bit", deep(was), deep(is)),
            ] {
                let found = Contrast::of(&before, &after, &all).unwrap();
                for (a, b) in [
                    (found.mean, expected.mean),
                    (found.weber, expected.weber),
                    (found.rms_code, expected.rms_code),
                    (found.brighter, expected.brighter),
                    (found.darker, expected.darker),
                ] {
                    assert!((a - b).abs() < 1e-6, "{name}: {found:?}, {expected:?}");
                }
            }
        }
    }

    #[test]
    fn nothing_changed_or_nowhere_is_no_contrast() {
        let image = gray([1, 2, 3, 4]);
        let none = Contrast::default();
        let same = Contrast::of(&image, &image, &region([255; 4])).unwrap();
        assert_eq!(same, none, "the same image");
        let nowhere = Contrast::of(&image, &gray([255; 4]), &region([0; 4])).unwrap();
        assert_eq!(nowhere, none, "an empty region");
        let black = Contrast::of(&gray([0; 4]), &gray([255; 4]), &region([255; 4])).unwrap();
        assert!(
            black.weber.abs() < 1e-12 && (black.mean - 1.0).abs() < 1e-6,
            "{black:?}"
        );
    }

    #[test]
    fn other_sizes_and_modes_are_refused() {
        let image = gray([0; 4]);
        let small = GrayImage::new(3, 1);
        assert!(
            Contrast::of(&image, &image, &small).is_err(),
            "a region of another size"
        );
        let color = DynamicImage::new_rgb8(4, 1);
        let error = Contrast::of(&image, &color, &region([0; 4])).unwrap_err();
        assert!(error.to_string().contains("L8 and Rgb8"), "{error}");
    }
}
