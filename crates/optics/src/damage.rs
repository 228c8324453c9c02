//! What a crack did to one box of an image, in figures that a study can plot failure over.

use image::{DynamicImage, GenericImageView, GrayImage, ImageBuffer, Pixel, Rgba};

use crate::Before;
use crate::paper::{FarFocusBlur, Focus, PaperOptics};
use crate::physical::Overlay;

/// Less variance of the codes, in squares of a step of 8 bits, is no picture to lose contrast in.
const LEAST_VARIANCE: f64 = 0.25;

/// What a crack did to one box of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damage {
    /// Share of the box inside the frame that the region covers, 0 to 1: its pixels are those
    /// whose centers lie in the box.
    pub region_share: f64,
    /// Mean distance that the image's own light in the box was moved, px: Σ W·|d| / Σ (K + W),
    /// with what a pixel keeps of its light K, and its share of light W from the place at d. 0 in
    /// the paper's optics, which move nothing.
    pub displacement_px: f64,
    /// Mean radius, px, of the disc that a point of the scene in the box became. The paper's
    /// Gaussian counts as the disc of the same variance, whose radius is 2σ.
    pub blur_radius_px: f64,
    /// Share of the picture's own contrast that is lost: 1 − cov(Y₀, Y)/var(Y₀) over the pixels
    /// of the box, with the luma codes Y₀ before and Y after. What the crack adds on its own
    /// does not count; it is below 0 where it happens to run along with the picture. None where
    /// the picture in the box is flat.
    pub contrast_lost: Option<f64>,
}

/// How the scene itself was blurred.
#[derive(Debug, Clone, Copy)]
enum SceneBlur<'a> {
    /// All of it, to discs of this radius, px.
    Everywhere(f64),
    /// Where a region is.
    Where(f64, &'a GrayImage),
}

/// An image before and after, from which [`Damage`] is read box by box.
#[derive(Debug)]
pub struct DamageReader<'a> {
    before: &'a Before,
    after: &'a DynamicImage,
    region: &'a GrayImage,
    overlay: Option<&'a Overlay>,
    blur: SceneBlur<'a>,
}

impl<'a> DamageReader<'a> {
    /// For an image that the physical optics changed. All four have the same size; what lies
    /// outside of one of them is not looked at.
    #[must_use]
    pub fn of_overlay(
        (before, after): (&'a Before, &'a DynamicImage),
        region: &'a GrayImage,
        overlay: &'a Overlay,
    ) -> Self {
        Self {
            before,
            after,
            region,
            overlay: Some(overlay),
            blur: SceneBlur::Everywhere(overlay.scene_blur_radius_px()),
        }
    }

    /// For an image that the paper's optics changed: where anything did, and where the glass.
    #[must_use]
    pub fn of_paper(
        (before, after): (&'a Before, &'a DynamicImage),
        [region, glass]: [&'a GrayImage; 2],
        optics: &PaperOptics,
    ) -> Self {
        let radius_px = 2.0 * optics.blur_sigma_px;
        let is_broken = glass.as_raw().iter().any(|code| *code > 0);
        let blur = match (optics.focus, optics.far_focus_blur) {
            (Focus::Short, _) if is_broken => SceneBlur::Everywhere(radius_px),
            (Focus::Far, FarFocusBlur::CrackAndScene) => SceneBlur::Where(radius_px, glass),
            (Focus::Short, _) | (Focus::Far, FarFocusBlur::Crack) => SceneBlur::Everywhere(0.0),
        };
        Self {
            before,
            after,
            region,
            overlay: None,
            blur,
        }
    }

    /// The damage in the box `[x₀, y₀, x₁, y₁]`, px; none where no pixel's center lies in it.
    #[must_use]
    pub fn in_box(&self, box_px: [f64; 4]) -> Option<Damage> {
        let [xs, ys] = self.pixels_in(box_px)?;
        let n = f64::from(xs[1] - xs[0]) * f64::from(ys[1] - ys[0]);
        let n_in_row = |row: &[u8]| row.iter().map(|code| u32::from(*code > 0)).sum::<u32>();
        let share_of = |region: &GrayImage| {
            let rows = rows_of(region, xs, ys).map(|row| f64::from(n_in_row(row)));
            rows.sum::<f64>() / n
        };
        let Moments {
            sum_before,
            sum_after,
            squares,
            products,
        } = moments(self.before, self.after, xs, ys);
        let variance = squares / n - (sum_before / n) * (sum_before / n);
        let covariance = products / n - (sum_before / n) * (sum_after / n);
        Some(Damage {
            region_share: share_of(self.region),
            displacement_px: self
                .overlay
                .map_or(0.0, |overlay| overlay.mean_displacement_px(xs, ys)),
            blur_radius_px: match self.blur {
                SceneBlur::Everywhere(radius_px) => radius_px,
                SceneBlur::Where(radius_px, region) => radius_px * share_of(region),
            },
            contrast_lost: (variance >= LEAST_VARIANCE).then(|| 1.0 - covariance / variance),
        })
    }

    /// The columns and rows of pixels whose centers lie in a box, each from the first to one
    /// after the last.
    fn pixels_in(&self, [x0, y0, x1, y1]: [f64; 4]) -> Option<[[u32; 2]; 2]> {
        let sizes = [
            self.before.size(),
            self.after.dimensions(),
            self.region.dimensions(),
        ];
        let width = sizes.iter().map(|size| size.0).min()?;
        let height = sizes.iter().map(|size| size.1).min()?;
        let xs = centers_in([x0, x1], width);
        let ys = centers_in([y0, y1], height);
        (xs[0] < xs[1] && ys[0] < ys[1]).then_some([xs, ys])
    }
}

/// The pixels of a line of `n` whose centers lie in [from, to): the first, and one after the last.
fn centers_in([from, to]: [f64; 2], n: u32) -> [u32; 2] {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to whole px of the frame; not a number becomes 0"
    )]
    let first_from = |edge: f64| (edge - 0.5).ceil().clamp(0.0, f64::from(n)) as u32;
    [first_from(from), first_from(to)]
}

/// Sums over the pixels of a box, of the luma codes before and after.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    sum_before: f64,
    sum_after: f64,
    squares: f64,
    products: f64,
}

/// Pixels that are compared as a whole: most of a box is as it was.
const BLOCK: usize = 64;

impl Moments {
    fn add(&mut self, before: f64, after: f64) {
        self.sum_before += before;
        self.sum_after += after;
        self.squares += before * before;
        self.products += before * after;
    }

    /// The rows of a box, whose pixels have `CHANNELS` samples.
    fn add_rows<P: Pixel<Subpixel = u8>, const CHANNELS: usize>(
        &mut self,
        (before, kept): (&Before, &ImageBuffer<P, Vec<u8>>),
        after: &ImageBuffer<P, Vec<u8>>,
        (xs, ys): ([u32; 2], [u32; 2]),
        luma: impl Fn(&[u8; CHANNELS]) -> u64,
    ) {
        for (y, after) in (ys[0] as usize..).zip(rows_of(after, xs, ys)) {
            let before = before.row(kept, (xs[0] as usize, y), after);
            self.add_row(&before, after, &luma);
        }
    }

    /// A row of pixels of `CHANNELS` samples, whose luma is a whole number of [`LUMA_STEPS`].
    fn add_row<const CHANNELS: usize>(
        &mut self,
        before: &[u8],
        after: &[u8],
        luma: impl Fn(&[u8; CHANNELS]) -> u64,
    ) {
        let blocks = before.chunks(BLOCK * CHANNELS);
        for (before, after) in blocks.zip(after.chunks(BLOCK * CHANNELS)) {
            let is_same = before == after;
            let (before, after) = (before.as_chunks().0, after.as_chunks().0);
            let [mut sum_before, mut sum_after, mut squares, mut products] = [0; 4];
            if is_same {
                for pixel in before {
                    let luma = luma(pixel);
                    sum_before += luma;
                    squares += luma * luma;
                }
                (sum_after, products) = (sum_before, squares);
            } else {
                for (before, after) in before.iter().zip(after) {
                    let (before, after) = (luma(before), luma(after));
                    sum_before += before;
                    sum_after += after;
                    squares += before * before;
                    products += before * after;
                }
            }
            #[expect(clippy::cast_precision_loss, reason = "less than 2^53")]
            let [sum_before, sum_after, squares, products] =
                [sum_before, sum_after, squares, products].map(|sum| sum as f64);
            self.sum_before += sum_before / LUMA_STEPS;
            self.sum_after += sum_after / LUMA_STEPS;
            self.squares += squares / (LUMA_STEPS * LUMA_STEPS);
            self.products += products / (LUMA_STEPS * LUMA_STEPS);
        }
    }
}

/// The moments of a box: samples as they lie for the usual modes, pixel by pixel for the others.
fn moments(before: &Before, after: &DynamicImage, xs: [u32; 2], ys: [u32; 2]) -> Moments {
    let mut moments = Moments::default();
    match (before.kept(), after) {
        (DynamicImage::ImageRgb8(kept), DynamicImage::ImageRgb8(after)) => {
            moments.add_rows((before, kept), after, (xs, ys), luma_of_rgb);
        }
        (DynamicImage::ImageLuma8(kept), DynamicImage::ImageLuma8(after)) => {
            let luma = |[code]: &[u8; 1]| luma_of_rgb(&[*code; 3]);
            moments.add_rows((before, kept), after, (xs, ys), luma);
        }
        _ => {
            for y in ys[0]..ys[1] {
                for x in xs[0]..xs[1] {
                    let (image, at_x, at_y) = before.place(after, (x, y));
                    moments.add(luma_code(image, at_x, at_y), luma_code(after, x, y));
                }
            }
        }
    }
    moments
}

/// The samples of some columns, row by row; the columns and rows lie in the image.
fn rows_of<P: Pixel<Subpixel = u8>>(
    image: &ImageBuffer<P, Vec<u8>>,
    xs: [u32; 2],
    ys: [u32; 2],
) -> impl Iterator<Item = &[u8]> {
    let n_channels = usize::from(P::CHANNEL_COUNT);
    let stride = image.width() as usize * n_channels;
    let [first, end] = xs.map(|x| x as usize * n_channels);
    let [top, bottom] = ys.map(|y| y as usize);
    let rows = image.as_raw().chunks_exact(stride.max(1));
    rows.skip(top)
        .take(bottom - top)
        .map(move |row| &row[first..end])
}

/// Steps of luma in one code.
const LUMA_STEPS: f64 = 1e4;

/// Luma by the weights of Rec. 709, in [`LUMA_STEPS`], without a remainder.
fn luma_of_rgb(pixel: &[u8; 3]) -> u64 {
    let [red, green, blue] = pixel.map(u32::from);
    u64::from(2126 * red + 7152 * green + 722 * blue)
}

/// Luma by the weights of Rec. 709.
fn luma([red, green, blue]: [f64; 3]) -> f64 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Luma of a pixel's codes, 0 to 255 (16-bit ones over 257).
fn luma_code(image: &DynamicImage, x: u32, y: u32) -> f64 {
    match image {
        DynamicImage::ImageLuma16(image) => f64::from(image.get_pixel(x, y).0[0]) / 257.0,
        DynamicImage::ImageRgb16(image) => luma(image.get_pixel(x, y).0.map(f64::from)) / 257.0,
        DynamicImage::ImageLumaA16(image) => f64::from(image.get_pixel(x, y).0[0]) / 257.0,
        DynamicImage::ImageRgba16(image) => {
            let [red, green, blue, _] = image.get_pixel(x, y).0.map(f64::from);
            luma([red, green, blue]) / 257.0
        }
        other => {
            let Rgba([red, green, blue, _]) = other.get_pixel(x, y);
            luma([red, green, blue].map(f64::from))
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::expect_used, reason = "a test may panic")]

    use super::*;
    use image::{GrayImage, Luma, Rgb, RgbImage};

    fn gradient(width: u32, height: u32) -> DynamicImage {
        DynamicImage::ImageRgb8(RgbImage::from_fn(width, height, |x, y| {
            let code = u8::try_from((x * 7 + y * 3) % 200).unwrap_or(0);
            Rgb([code; 3])
        }))
    }

    /// A reader of an image whose codes became gain · code + offset, half of it in the region.
    fn check(gain: f64, offset: f64, expected_lost: f64) {
        let before = gradient(20, 10);
        let mut after = before.to_rgb8();
        for sample in after.as_mut() {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a code"
            )]
            let code = (f64::from(*sample) * gain + offset).round() as u8;
            *sample = code;
        }
        let after = DynamicImage::ImageRgb8(after);
        let region = GrayImage::from_fn(20, 10, |x, _| Luma([if x < 10 { 255 } else { 0 }]));
        let optics = PaperOptics::default();
        let before = Before::whole(before);
        let reader = DamageReader::of_paper((&before, &after), [&region; 2], &optics);
        let damage = reader
            .in_box([5.0, 0.0, 15.0, 10.0])
            .expect("a box in the frame");
        assert!(
            (damage.region_share - 0.5).abs() < 1e-12,
            "half of the box: {damage:?}"
        );
        let lost = damage.contrast_lost.expect("a picture");
        assert!((lost - expected_lost).abs() < 5e-3, "{lost}");
        assert!(damage.blur_radius_px.abs() < 1e-12, "the scene is sharp");
    }

    #[test]
    fn contrast_lost_is_what_the_picture_was_scaled_by() {
        check(1.0, 0.0, 0.0);
        check(0.5, 40.0, 0.5);
        check(0.0, 90.0, 1.0);
    }

    #[test]
    fn all_modes_give_the_same_damage() {
        let before = gradient(20, 10);
        let after = DynamicImage::ImageRgb8(image::imageops::brighten(&before.to_rgb8(), 30));
        let region = GrayImage::from_pixel(20, 10, Luma([255]));
        let optics = PaperOptics::default();
        let of = |before: &DynamicImage, after: &DynamicImage| {
            let before = Before::whole(before.clone());
            let reader = DamageReader::of_paper((&before, after), [&region; 2], &optics);
            reader.in_box([2.0, 1.0, 17.0, 9.0]).expect("in the frame")
        };
        let expected = of(&before, &after).contrast_lost.expect("a picture");
        type Convert = fn(&DynamicImage) -> DynamicImage;
        let modes: [Convert; 7] = [
            |image| image.to_luma8().into(),
            |image| image.to_luma_alpha8().into(),
            |image| image.to_rgba8().into(),
            |image| image.to_luma16().into(),
            |image| image.to_luma_alpha16().into(),
            |image| image.to_rgb16().into(),
            |image| image.to_rgba16().into(),
        ];
        for mode in modes {
            let damage = of(&mode(&before), &mode(&after));
            let lost = damage.contrast_lost.expect("a picture");
            assert!((lost - expected).abs() < 1e-3, "{lost}, not {expected}");
            assert!((damage.region_share - 1.0).abs() < 1e-12, "all of it");
        }
    }

    #[test]
    fn blocks_that_stayed_as_they_were_count_as_all_others_do() {
        let before = RgbImage::from_fn(200, 3, |x, y| {
            Rgb([x, 3 * x + 50 * y, 255 - x].map(|code| u8::try_from(code % 256).unwrap_or(0)))
        });
        let mut after = before.clone();
        for x in 70..75 {
            after.put_pixel(x, 1, Rgb([0, 250, 9]));
        }
        // The definition, over the columns 3 to 196.
        let luma = |image: &RgbImage| -> Vec<f64> {
            let pixels = image.enumerate_pixels();
            let in_box = pixels.filter(|(x, _, _)| (3..197).contains(x));
            in_box.map(|(_, _, at)| luma(at.0.map(f64::from))).collect()
        };
        let (was, is) = (luma(&before), luma(&after));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / 582.0;
        let about = |a: &[f64], b: &[f64]| -> f64 {
            let (mean_a, mean_b) = (mean(a), mean(b));
            let products = a.iter().zip(b).map(|(a, b)| (a - mean_a) * (b - mean_b));
            products.sum()
        };
        let expected = 1.0 - about(&was, &is) / about(&was, &was);
        assert!(expected.abs() > 1e-3, "something is lost: {expected}");
        let [before, after] = [before, after].map(DynamicImage::ImageRgb8);
        let before = Before::whole(before);
        let region = GrayImage::new(200, 3);
        let optics = PaperOptics::default();
        let reader = DamageReader::of_paper((&before, &after), [&region; 2], &optics);
        let damage = reader.in_box([3.0, 0.0, 197.0, 3.0]).expect("in the frame");
        let lost = damage.contrast_lost.expect("a picture");
        assert!((lost - expected).abs() < 1e-12, "{lost}, not {expected}");
    }

    #[test]
    fn pixels_belong_to_the_box_that_their_centers_lie_in() {
        assert_eq!(centers_in([0.0, 3.0], 10), [0, 3]);
        assert_eq!(centers_in([0.5, 2.5], 10), [0, 2], "half open");
        assert_eq!(centers_in([-5.0, 99.0], 10), [0, 10], "cut to the frame");
        assert_eq!(centers_in([f64::NAN, 4.0], 10), [0, 4], "no panic");
        assert_eq!(centers_in([4.6, 5.4], 10), [5, 5], "no center, no pixel");
    }

    #[test]
    fn box_outside_the_frame_has_no_damage() {
        let image = gradient(20, 10);
        let region = GrayImage::new(20, 10);
        let optics = PaperOptics::default();
        let before = Before::whole(image.clone());
        let reader = DamageReader::of_paper((&before, &image), [&region; 2], &optics);
        for box_px in [
            [30.0, 0.0, 40.0, 5.0],
            [5.0, 5.0, 5.0, 9.0],
            [9.0, 9.0, 2.0, 2.0],
        ] {
            assert_eq!(reader.in_box(box_px), None, "{box_px:?}");
        }
        let flat = DynamicImage::new_rgb8(20, 10);
        let before = Before::whole(flat.clone());
        let reader = DamageReader::of_paper((&before, &flat), [&region; 2], &optics);
        let damage = reader.in_box([0.0, 0.0, 20.0, 10.0]).expect("the frame");
        assert_eq!(damage.contrast_lost, None, "nothing to lose");
    }

    #[test]
    fn short_focus_blurs_the_scene_everywhere_where_something_is_broken() {
        let image = gradient(20, 10);
        let optics = PaperOptics {
            focus: Focus::Short,
            ..PaperOptics::default()
        };
        let blur = |region: &GrayImage| {
            let before = Before::whole(image.clone());
            let reader = DamageReader::of_paper((&before, &image), [region; 2], &optics);
            reader
                .in_box([12.0, 2.0, 18.0, 8.0])
                .map(|damage| damage.blur_radius_px)
        };
        let mut region = GrayImage::new(20, 10);
        assert_eq!(blur(&region), Some(0.0), "intact glass blurs nothing");
        region.put_pixel(1, 1, Luma([255]));
        assert_eq!(blur(&region), Some(5.2), "2 sigma");
    }
}
