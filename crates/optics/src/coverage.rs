//! Lines to pixels: how much of each pixel a set of thin strips covers.

use crate::bit_rows::BitRows;

/// A strip to draw: its ends in pixels (first pixel centre at 0.5) and a weight that is
/// averaged, by coverage, over all strips in a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// `[x0, y0, x1, y1]`, px.
    pub ends: [f64; 4],
    /// What the strip carries, e.g. its brightness.
    pub weight: f32,
}

/// Coverage of a frame by strips, and their mean weight per pixel.
///
/// Away from its ends a strip covers of each pixel exactly their common area; at an end that is
/// multiplied by the exact share of the pixel before the end, so that strips that follow each
/// other on a line join without seam. Overlapping strips add up to at most 1.
///
/// # Limits
/// Only pixels with a corner of a strip in them are not exact.
#[derive(Debug, Clone)]
pub struct Coverage {
    width: usize,
    height: usize,
    covered: Vec<f32>,
    weighted: Vec<f32>,
    touched: BitRows,
}

/// Coverage below half a step of an 8-bit mask is no coverage.
const LEAST: f32 = 0.5 / 255.0;

impl Coverage {
    /// The coverage of a `width × height` frame by strips of the given width, px.
    ///
    /// Work is in proportion to the pixels that the strips touch; what lies outside the frame
    /// costs nothing.
    pub fn of_lines(
        width: u32,
        height: u32,
        line_width_px: f64,
        lines: impl Iterator<Item = Line>,
    ) -> Self {
        let (width, height) = (width as usize, height as usize);
        let mut coverage = Self {
            width,
            height,
            covered: vec![0.0; width * height],
            weighted: vec![0.0; width * height],
            touched: BitRows::new(width, height),
        };
        for line in lines {
            coverage.add(&line, line_width_px);
        }
        coverage.settle();
        coverage
    }

    fn add(&mut self, line: &Line, line_width_px: f64) {
        let [x0, y0, x1, y1] = line.ends;
        let length = (x1 - x0).hypot(y1 - y0);
        if length <= 0.0 || !length.is_finite() {
            return;
        }
        let (ux, uy) = ((x1 - x0) / length, (y1 - y0) / length);
        let half = line_width_px * 0.5;
        let (side_along, side_across) = (HalfPlane::new(ux, uy), HalfPlane::new(uy, ux));
        // Half extents of the strip grown by half a pixel's diagonal extent all round.
        let (along, across) = (length * 0.5 + side_along.reach, half + side_across.reach);
        let reach_y = uy.abs() * along + ux.abs() * across;
        let (middle_x, middle_y) = ((x0 + x1) * 0.5, (y0 + y1) * 0.5);
        let rows = pixel_range(middle_y - reach_y, middle_y + reach_y, self.height);
        for y in rows {
            #[expect(clippy::cast_precision_loss, reason = "a pixel row")]
            let dy = y as f64 + 0.5 - middle_y;
            // |t| ≤ along with t = ux·dx + uy·dy, and |d| ≤ across with d = −uy·dx + ux·dy.
            let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
            clip(ux, uy * dy, along, &mut low, &mut high);
            clip(-uy, ux * dy, across, &mut low, &mut high);
            for x in pixel_range(middle_x + low, middle_x + high, self.width) {
                #[expect(clippy::cast_precision_loss, reason = "a pixel column")]
                let dx = x as f64 + 0.5 - middle_x;
                let (t, d) = (ux * dx + uy * dy, ux * dy - uy * dx);
                let share = side_along.strip(t, length * 0.5) * side_across.strip(d, half);
                if share > 0.0 {
                    #[expect(clippy::cast_possible_truncation, reason = "a share in 0..1 as f32")]
                    let share = share as f32;
                    self.covered[y * self.width + x] += share;
                    self.weighted[y * self.width + x] += share * line.weight;
                    self.touched.set(x, y);
                }
            }
        }
    }

    /// Sums to coverage in 0..=1 and mean weight; what no mask would show is dropped.
    fn settle(&mut self) {
        for y in 0..self.height {
            let xs: Vec<usize> = self.touched.ones(y).collect();
            for x in xs {
                let k = y * self.width + x;
                if self.covered[k] < LEAST {
                    self.touched.unset(x, y);
                    self.covered[k] = 0.0;
                    self.weighted[k] = 0.0;
                } else {
                    self.weighted[k] /= self.covered[k];
                    self.covered[k] = self.covered[k].min(1.0);
                }
            }
        }
    }

    /// The pixels of a row that are covered: column, coverage in (0, 1], mean weight.
    pub fn row(&self, y: usize) -> impl Iterator<Item = (usize, f32, f32)> + '_ {
        let at = y * self.width;
        self.touched
            .ones(y)
            .map(move |x| (x, self.covered[at + x], self.weighted[at + x]))
    }

    /// As [`Coverage::row`], for columns `start..end`.
    pub(crate) fn row_within(
        &self,
        y: usize,
        start: usize,
        end: usize,
    ) -> impl Iterator<Item = (usize, f32, f32)> + '_ {
        let at = y * self.width;
        self.touched
            .ones_within(y, start, end)
            .map(move |x| (x, self.covered[at + x], self.weighted[at + x]))
    }

    /// Width and height of the frame.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Whether no pixel is covered.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        (0..self.height).all(|y| self.touched.ones(y).next().is_none())
    }

    /// Number of covered pixels.
    #[must_use]
    pub fn n_pixels(&self) -> usize {
        (0..self.height).map(|y| self.touched.ones(y).count()).sum()
    }

    /// Sum of coverage over the frame, px².
    #[must_use]
    pub fn area_px2(&self) -> f64 {
        (0..self.height)
            .flat_map(|y| self.row(y))
            .map(|(_, covered, _)| f64::from(covered))
            .sum()
    }

    /// The coverage as an 8-bit mask, 255 = covered in full.
    #[must_use]
    pub fn to_mask(&self) -> image::GrayImage {
        let mut pixels = vec![0; self.width * self.height];
        for y in 0..self.height {
            for (x, covered, _) in self.row(y) {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "in 0..=255.5"
                )]
                let level = (covered * 255.0 + 0.5) as u8;
                pixels[y * self.width + x] = level;
            }
        }
        gray_image(self.width, self.height, pixels)
    }

    pub(crate) fn touched(&self) -> &BitRows {
        &self.touched
    }
}

/// A grey image of a frame whose size came from an image, so it fits.
pub(crate) fn gray_image(width: usize, height: usize, pixels: Vec<u8>) -> image::GrayImage {
    let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    image::GrayImage::from_raw(side(width), side(height), pixels).unwrap_or_default()
}

/// How much of a unit square a half plane covers, for one direction of its edge.
struct HalfPlane {
    /// Beyond this distance from the centre the edge misses the square.
    reach: f64,
    /// Up to this distance the edge cuts two opposite sides.
    inner: f64,
    /// The larger component of the edge's unit normal, and twice the product of both.
    larger: f64,
    twice_product: f64,
}

impl HalfPlane {
    fn new(nx: f64, ny: f64) -> Self {
        let (larger, smaller) = (nx.abs().max(ny.abs()), nx.abs().min(ny.abs()));
        Self {
            reach: (larger + smaller) * 0.5,
            inner: (larger - smaller) * 0.5,
            larger,
            twice_product: 2.0 * larger * smaller,
        }
    }

    /// Area of the unit square on the inner side of an edge `distance` beyond its centre.
    fn area(&self, distance: f64) -> f64 {
        let gone = distance.abs();
        let inside = if gone >= self.reach {
            1.0
        } else if gone <= self.inner {
            0.5 + gone / self.larger
        } else {
            // The edge cuts off a triangle; its legs exist, so both components are non-zero.
            1.0 - (self.reach - gone).powi(2) / self.twice_product
        };
        if distance >= 0.0 {
            inside
        } else {
            1.0 - inside
        }
    }

    /// Area of the unit square inside a strip of half width `half`, its centre `at` off the
    /// middle of the strip.
    fn strip(&self, at: f64, half: f64) -> f64 {
        self.area(at + half) - self.area(at - half)
    }
}

/// Narrows `low..high` to where |slope·v + offset| ≤ bound.
fn clip(slope: f64, offset: f64, bound: f64, low: &mut f64, high: &mut f64) {
    if slope.abs() < 1e-12 {
        if offset.abs() > bound {
            *high = f64::NEG_INFINITY;
        }
        return;
    }
    let (p, q) = ((-bound - offset) / slope, (bound - offset) / slope);
    *low = low.max(p.min(q));
    *high = high.min(p.max(q));
}

/// The pixels whose centres may lie in `low..=high`, inside a frame of `n` pixels.
fn pixel_range(low: f64, high: f64, n: usize) -> std::ops::Range<usize> {
    if low > high {
        return 0..0;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` saturates, then clamped"
    )]
    let (first, end) = (
        (low - 0.5).ceil().max(0.0) as usize,
        ((high + 0.5).floor().max(0.0) as usize).min(n),
    );
    first..end.max(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(ends: [f64; 4], line_width_px: f64) -> Coverage {
        Coverage::of_lines(
            64,
            64,
            line_width_px,
            std::iter::once(Line { ends, weight: 1.0 }),
        )
    }

    #[test]
    fn the_sum_of_coverage_is_the_area_of_the_strip() {
        for k in 0..24 {
            let angle = f64::from(k) * 0.2618;
            let (sin, cos) = angle.sin_cos();
            for width in [0.25, 1.0, 1.7, 4.0] {
                let (cx, cy, half) = (31.37, 32.61, 13.2);
                let area = single(
                    [
                        cx - cos * half,
                        cy - sin * half,
                        cx + cos * half,
                        cy + sin * half,
                    ],
                    width,
                )
                .area_px2();
                let error = (area / (2.0 * half * width) - 1.0).abs();
                assert!(
                    error < 0.02,
                    "angle {angle}, width {width}: area off by {error}"
                );
            }
        }
    }

    #[test]
    fn an_upright_strip_has_its_exact_area_in_every_pixel() {
        let coverage = single([10.0, 20.5, 14.5, 20.5], 1.0);
        let row: Vec<_> = coverage
            .row(20)
            .map(|(x, covered, _)| (x, covered))
            .collect();
        assert_eq!(
            row,
            vec![(10, 1.0), (11, 1.0), (12, 1.0), (13, 1.0), (14, 0.5)],
            "one row, half at the end"
        );
        assert_eq!(coverage.n_pixels(), 5, "nothing elsewhere");
    }

    #[test]
    fn pixels_agree_with_a_supersampled_strip() {
        let ends = [9.3, 11.2, 50.1, 37.9];
        let coverage = single(ends, 1.0);
        let mask = coverage.to_mask();
        let (length, n) = ((ends[2] - ends[0]).hypot(ends[3] - ends[1]), 16);
        let (ux, uy) = ((ends[2] - ends[0]) / length, (ends[3] - ends[1]) / length);
        let mut worst = 0.0_f64;
        for y in 0..64_u32 {
            for x in 0..64_u32 {
                let mut hits = 0;
                for k in 0..n * n {
                    let px = f64::from(x) + (f64::from(k % n) + 0.5) / f64::from(n) - ends[0];
                    let py = f64::from(y) + (f64::from(k / n) + 0.5) / f64::from(n) - ends[1];
                    let (t, d) = (ux * px + uy * py, ux * py - uy * px);
                    hits += i32::from((0.0..=length).contains(&t) && d.abs() <= 0.5);
                }
                // Pixels at the strip's ends hold its corners; see the limits.
                let end = |ex: f64, ey: f64| {
                    (f64::from(x) + 0.5 - ex).hypot(f64::from(y) + 0.5 - ey) < 1.5
                };
                if end(ends[0], ends[1]) || end(ends[2], ends[3]) {
                    continue;
                }
                let exact = f64::from(hits) / f64::from(n * n);
                worst = worst.max((f64::from(mask.get_pixel(x, y).0[0]) / 255.0 - exact).abs());
            }
        }
        assert!(worst < 0.02, "worst pixel is off by {worst}");
    }

    #[test]
    fn pieces_of_a_line_join_without_seam() {
        let whole = single([5.0, 7.0, 55.0, 40.0], 1.0).to_mask();
        let cut = [17.0 / 50.0, 18.3 / 50.0, 40.0 / 50.0];
        let at = |t: f64| [5.0 + 50.0 * t, 7.0 + 33.0 * t];
        let stops = [0.0, cut[0], cut[1], cut[2], 1.0];
        let pieces = stops.windows(2).map(|pair| {
            let ([x0, y0], [x1, y1]) = (at(pair[0]), at(pair[1]));
            Line {
                ends: [x0, y0, x1, y1],
                weight: 1.0,
            }
        });
        let joined = Coverage::of_lines(64, 64, 1.0, pieces).to_mask();
        let worst = whole
            .pixels()
            .zip(joined.pixels())
            .map(|(a, b)| a.0[0].abs_diff(b.0[0]))
            .max();
        assert!(worst <= Some(1), "a seam of {worst:?} levels");
    }

    #[test]
    fn what_lies_outside_the_frame_is_left_out() {
        for ends in [
            [-1e6, -5.0, 1e6, -5.0],
            [-1e12, 32.0, 1e12, 32.0],
            [70.0, 0.0, 90.0, 1e9],
        ] {
            let coverage = single(ends, 1.0);
            assert!(coverage.n_pixels() <= 128, "{ends:?}");
        }
        assert_eq!(
            single([5.0, 5.0, 5.0, 5.0], 1.0).n_pixels(),
            0,
            "a point has no area"
        );
    }
}
