//! The region of an image that a crack influences, and how much of a box lies in it.

use std::path::Path;

use image::DynamicImage;
use starbreak_dataset::{ImageLimits, read_image};

use crate::protocol::exact;
use crate::{BoxPx, EvalError};

/// A region as counts of its pixels above and left of each pixel's corner.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RegionMask {
    width_px: u32,
    height_px: u32,
    /// Row by row, one more than the pixels in each direction.
    counts: Vec<u32>,
}

impl RegionMask {
    /// The region of the pixels that are not 0, row by row. Nothing unless there are as many as the
    /// sides say.
    #[must_use]
    pub fn of_pixels(width_px: u32, height_px: u32, pixels: &[u8]) -> Option<Self> {
        let width = usize::try_from(width_px).ok()?;
        let height = usize::try_from(height_px).ok()?;
        if pixels.len() != width.checked_mul(height)? {
            return None;
        }
        let mut counts = vec![0u32; width + 1];
        counts.reserve_exact((width + 1).checked_mul(height)?);
        let rows = pixels.chunks_exact(width.max(1));
        for row in rows.take(height) {
            let above = counts.len() - (width + 1);
            let mut n_in_row = 0;
            counts.push(0);
            for (idx, pixel) in row.iter().enumerate() {
                n_in_row += u32::from(*pixel != 0);
                let before = counts.get(above + idx + 1).copied().unwrap_or(0);
                counts.push(before + n_in_row);
            }
        }
        Some(Self {
            width_px,
            height_px,
            counts,
        })
    }

    /// The region in an 8-bit gray image, of which each pixel that is not 0 is inside.
    ///
    /// # Errors
    /// [`EvalError::Dataset`] where it cannot be read, [`EvalError::File`] where it is not 8-bit
    /// gray.
    pub fn read(path: &Path) -> Result<Self, EvalError> {
        let refuse = |reason: &str| EvalError::File {
            path: path.to_owned(),
            reason: reason.to_owned(),
        };
        let file = read_image(path, &ImageLimits::default())?;
        let DynamicImage::ImageLuma8(mask) = &file.pixels else {
            return Err(refuse(
                "it is not an 8-bit gray image; give the region masks that `generate` writes",
            ));
        };
        Self::of_pixels(mask.width(), mask.height(), mask.as_raw())
            .ok_or_else(|| refuse("its pixels are not as many as its sides say"))
    }

    /// Width, px.
    #[must_use]
    pub fn width_px(&self) -> u32 {
        self.width_px
    }

    /// Height, px.
    #[must_use]
    pub fn height_px(&self) -> u32 {
        self.height_px
    }

    /// Pixels inside of the region.
    #[must_use]
    pub fn n_pixels(&self) -> u64 {
        u64::from(self.counts.last().copied().unwrap_or(0))
    }

    /// The share of a box that lies in the region, 0 to 1: of the pixels whose centers are in the
    /// box and the image, how many are in the region. 0 where there are none.
    ///
    /// A pixel's center is in the box where `x <= j + 0.5 < x + width`.
    #[must_use]
    pub fn coverage(&self, box_px: &BoxPx) -> f64 {
        let (x0, x1) = first_and_end(box_px.x, box_px.width, self.width_px);
        let (y0, y1) = first_and_end(box_px.y, box_px.height, self.height_px);
        if x1 <= x0 || y1 <= y0 {
            return 0.0;
        }
        let n_pixels = u64::from(x1 - x0) * u64::from(y1 - y0);
        let stride = u64::from(self.width_px) + 1;
        let at = |x: u32, y: u32| {
            let idx = usize::try_from(u64::from(y) * stride + u64::from(x)).ok();
            let count = idx.and_then(|idx| self.counts.get(idx));
            i64::from(count.copied().unwrap_or(0))
        };
        let n_inside = at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
        exact(n_inside.unsigned_abs()) / exact(n_pixels)
    }
}

/// The first pixel whose center is in an interval, and the one behind the last, both in the image.
fn first_and_end(from: f64, length: f64, side_px: u32) -> (u32, u32) {
    let clipped = |edge: f64| {
        let pixel = (edge - 0.5).ceil().clamp(0.0, f64::from(side_px));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "it is whole and from 0 to the side; NaN becomes 0"
        )]
        let pixel = pixel as u32;
        pixel
    };
    (clipped(from), clipped(from + length))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    /// The rule as it stands in words, pixel by pixel.
    fn counted(pixels: &[u8], width: u32, height: u32, b: &BoxPx) -> f64 {
        let (mut n_inside, mut n_all) = (0u32, 0u32);
        for (i, j) in (0..height).flat_map(|i| (0..width).map(move |j| (i, j))) {
            let (x, y) = (f64::from(j) + 0.5, f64::from(i) + 0.5);
            if b.x <= x && x < b.x + b.width && b.y <= y && y < b.y + b.height {
                n_all += 1;
                n_inside += u32::from(pixels[usize::try_from(i * width + j).unwrap()] != 0);
            }
        }
        match n_all {
            0 => 0.0,
            n_all => f64::from(n_inside) / f64::from(n_all),
        }
    }

    #[test]
    fn coverage_is_the_share_of_pixel_centers() {
        let (width, height) = (13, 7);
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 16
        };
        let pixels: Vec<u8> = (0..width * height)
            .map(|_| (next() % 3 == 0).into())
            .collect();
        let mask = RegionMask::of_pixels(width, height, &pixels).unwrap();
        for _ in 0..2000 {
            // Quarters of pixels, so that edges fall on centers, too; also outside of the image.
            let mut quarter = |n: u32| f64::from(next() % n) / 4.0;
            let box_px = BoxPx {
                x: quarter(80) - 4.0,
                y: quarter(60) - 4.0,
                width: quarter(60),
                height: quarter(40),
            };
            let (ours, expected) = (
                mask.coverage(&box_px),
                counted(&pixels, width, height, &box_px),
            );
            assert!(
                (ours - expected).abs() < 1e-15,
                "{box_px:?}: {ours} {expected}"
            );
        }
    }

    #[test]
    fn boxes_beyond_all_numbers_do_no_harm() {
        let mask = RegionMask::of_pixels(2, 2, &[255; 4]).unwrap();
        for (x, width, expected) in [
            (-1e308, 1e308, 0.0),
            (-1e300, 1e301, 1.0),
            (1e300, 1.0, 0.0),
            (1.0, -5.0, 0.0),
            (f64::NAN, 1.0, 0.0),
        ] {
            let box_px = BoxPx {
                x,
                y: 0.0,
                width,
                height: 2.0,
            };
            let found = mask.coverage(&box_px);
            assert!((found - expected).abs() < 1e-15, "{box_px:?}: {found}");
        }
        assert_eq!(mask.n_pixels(), 4, "all of it");
        assert!(
            RegionMask::of_pixels(2, 2, &[0; 3]).is_none(),
            "one is missing"
        );
    }
}
