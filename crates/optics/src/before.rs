//! What an image showed before a crack was put over it.

use std::borrow::Cow;

use image::{DynamicImage, GrayImage, ImageBuffer, Pixel};

use crate::contrast::check_sizes;
use crate::maps::CHUNK;
use crate::{Contrast, OpticsError};

/// An image as it was before a crack was put over it.
///
/// Most of an image stays as it is. So where it is known which runs of pixels a crack changes
/// ([`Overlay::before`](crate::physical::Overlay::before)), those alone are kept, and the rest is
/// looked up in the image with the crack.
#[derive(Debug, Clone)]
pub struct Before {
    size: (u32, u32),
    kept: Kept,
}

#[derive(Debug, Clone)]
enum Kept {
    Whole(DynamicImage),
    /// Runs of [`CHUNK`] pixels, in the order of rows, one below the other.
    Runs {
        /// First pixel and row of each.
        starts: Vec<(usize, usize)>,
        pixels: DynamicImage,
    },
}

impl Before {
    /// All of an image.
    #[must_use]
    pub fn whole(image: DynamicImage) -> Self {
        Self {
            size: (image.width(), image.height()),
            kept: Kept::Whole(image),
        }
    }

    /// The runs of an image that begin at these pixels and rows, in the order of rows; all of an
    /// image that is not 8-bit grey or RGB.
    pub(crate) fn of_runs(image: &DynamicImage, starts: Vec<(usize, usize)>) -> Self {
        let Some(pixels) = runs_of_image(image, &starts) else {
            return Self::whole(image.clone());
        };
        Self {
            size: (image.width(), image.height()),
            kept: Kept::Runs { starts, pixels },
        }
    }

    /// Width and height, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// How visible the crack is that made `after` of this image, over the pixels where the region
    /// is not 0: as [`Contrast::of`].
    ///
    /// # Errors
    /// As for [`Contrast::of`].
    pub fn contrast(
        &self,
        after: &DynamicImage,
        region: &GrayImage,
    ) -> Result<Contrast, OpticsError> {
        let (starts, pixels) = match &self.kept {
            Kept::Whole(before) => return Contrast::of(before, after, region),
            Kept::Runs { starts, pixels } => (starts, pixels),
        };
        check_sizes(self.size, after, region)?;
        let Some(after) = runs_of_image(after, starts) else {
            return Contrast::of(pixels, after, region);
        };
        Contrast::of(pixels, &after, &runs_of(region, starts))
    }

    /// What was kept, whatever it is a part of.
    pub(crate) fn kept(&self) -> &DynamicImage {
        match &self.kept {
            Kept::Whole(pixels) | Kept::Runs { pixels, .. } => pixels,
        }
    }

    /// The samples of a row from column `x`, out of what was kept and those after.
    pub(crate) fn row<'a, P: Pixel>(
        &self,
        kept: &'a ImageBuffer<P, Vec<P::Subpixel>>,
        (x, y): (usize, usize),
        after: &'a [P::Subpixel],
    ) -> Cow<'a, [P::Subpixel]> {
        let n_channels = usize::from(P::CHANNEL_COUNT);
        let stride = kept.width() as usize * n_channels;
        let columns = x * n_channels..x * n_channels + after.len();
        let starts = match &self.kept {
            Kept::Whole(_) => {
                return Cow::Borrowed(&kept.as_raw()[y * stride..(y + 1) * stride][columns]);
            }
            Kept::Runs { starts, .. } => starts,
        };
        let first = starts.partition_point(|start| start.1 < y);
        let mut row = Cow::Borrowed(after);
        let runs = starts.iter().zip(kept.as_raw().chunks_exact(stride));
        let of_row = runs.skip(first).take_while(|(start, _)| start.1 == y);
        for ((run_x, _), run) in of_row {
            let at = run_x * n_channels;
            let (from, to) = (at.max(columns.start), (at + stride).min(columns.end));
            if from < to {
                row.to_mut()[from - columns.start..to - columns.start]
                    .copy_from_slice(&run[from - at..to - at]);
            }
        }
        row
    }

    /// The image that shows a pixel as it was, and where.
    pub(crate) fn place<'a>(
        &'a self,
        after: &'a DynamicImage,
        (x, y): (u32, u32),
    ) -> (&'a DynamicImage, u32, u32) {
        let (starts, pixels) = match &self.kept {
            Kept::Whole(before) => return (before, x, y),
            Kept::Runs { starts, pixels } => (starts, pixels),
        };
        let start = (x as usize / CHUNK * CHUNK, y as usize);
        let by_row = |(x, y): (usize, usize)| (y, x);
        match starts.binary_search_by_key(&by_row(start), |start| by_row(*start)) {
            #[expect(clippy::cast_possible_truncation, reason = "places of a frame")]
            Ok(run) => (pixels, x - start.0 as u32, run as u32),
            Err(_) => (after, x, y),
        }
    }
}

/// Runs of an image, one below the other; none of one that is not 8-bit grey or RGB.
fn runs_of_image(image: &DynamicImage, starts: &[(usize, usize)]) -> Option<DynamicImage> {
    match image {
        DynamicImage::ImageLuma8(image) => Some(runs_of(image, starts).into()),
        DynamicImage::ImageRgb8(image) => Some(runs_of(image, starts).into()),
        _ => None,
    }
}

/// Beyond the frame there are zeros.
fn runs_of<P: Pixel>(
    image: &ImageBuffer<P, Vec<P::Subpixel>>,
    starts: &[(usize, usize)],
) -> ImageBuffer<P, Vec<P::Subpixel>> {
    let n_channels = usize::from(P::CHANNEL_COUNT);
    let stride = image.width() as usize * n_channels;
    #[expect(clippy::cast_possible_truncation, reason = "fewer than pixels")]
    let mut runs = ImageBuffer::new(CHUNK as u32, starts.len() as u32);
    let each = runs.as_mut().chunks_exact_mut(CHUNK * n_channels);
    for (run, (x, y)) in each.zip(starts) {
        let row = &image.as_raw()[y * stride..][..stride];
        let from = &row[x * n_channels..];
        let n = run.len().min(from.len());
        run[..n].copy_from_slice(&from[..n]);
    }
    runs
}

#[cfg(test)]
mod tests {
    #![expect(clippy::expect_used, reason = "a test may panic")]

    use super::*;
    use crate::DamageReader;
    use crate::environment::Environment;
    use crate::physical::{Overlay, PhysicalOptics};
    use image::{GenericImageView, RgbImage};
    use starbreak_seed::Seed;

    /// Stripes that darken the frame, also where its last run is cut off.
    fn stripes(size: (u32, u32)) -> Overlay {
        Overlay::of_pixels(
            (size, 800.0),
            &Environment::DAY,
            &PhysicalOptics::default(),
            |x, y| match (x / 8 + y) % 9 {
                0 => ([0.4, 0.5, 0.6], [0.2, 0.1, 0.0]),
                _ => ([1.0; 3], [0.0; 3]),
            },
        )
    }

    fn photo(size: (u32, u32)) -> RgbImage {
        RgbImage::from_fn(size.0, size.1, |x, y| {
            image::Rgb([x * 7, y * 11 + x, x * y].map(|code| u8::try_from(code % 200).unwrap_or(0)))
        })
    }

    #[test]
    fn runs_alone_say_of_a_crack_what_the_whole_image_says() {
        let size = (150, 40);
        let overlay = stripes(size);
        let rgb: DynamicImage = photo(size).into();
        for image in [rgb.clone(), rgb.to_luma8().into(), rgb.to_rgb16().into()] {
            let before = overlay.before(&image);
            let mut after = image.clone();
            overlay.apply(&mut after, Seed(1)).expect("of its size");
            let region = overlay.region();
            assert_eq!(
                before.contrast(&after, &region),
                Contrast::of(&image, &after, &region),
                "contrast"
            );
            let whole = Before::whole(image);
            let damage = [before, whole].map(|before| {
                DamageReader::of_overlay((&before, &after), &region, &overlay)
                    .in_box([3.0, 2.0, 149.0, 33.0])
                    .expect("a box in the frame")
            });
            assert_eq!(damage[0], damage[1], "damage");
            assert!(damage[0].contrast_lost > Some(0.01), "some");
        }
    }

    #[test]
    fn less_is_kept_than_the_image() {
        let size = (320, 300);
        let image: DynamicImage = photo(size).into();
        let kept = stripes(size).before(&image);
        assert!(
            kept.kept().as_bytes().len() < image.as_bytes().len(),
            "runs"
        );
        let intact = Overlay::of_pixels(
            (size, 800.0),
            stripes(size).environment(),
            &PhysicalOptics::default(),
            |_, _| ([1.0; 3], [0.0; 3]),
        );
        assert!(
            intact.before(&image).kept().as_bytes().is_empty(),
            "nothing"
        );
    }

    #[test]
    fn a_pixel_is_shown_as_it_was_whatever_the_mode_after() {
        let size = (70, 20);
        let overlay = stripes(size);
        let image: DynamicImage = photo(size).into();
        let before = overlay.before(&image);
        let mut after = image.clone();
        overlay.apply(&mut after, Seed(1)).expect("of its size");
        let after: DynamicImage = after.to_luma_alpha8().into();
        // In a stripe.
        let (shown, x, y) = before.place(&after, (64, 1));
        assert_eq!(shown.get_pixel(x, y), image.get_pixel(64, 1), "in a run");
    }
}
