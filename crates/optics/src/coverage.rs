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
    window: Window,
    cells: Vec<Cell>,
    touched: BitRows,
}

/// Coverage below half a step of an 8-bit mask is no coverage.
pub(crate) const LEAST: f32 = 0.5 / 255.0;

/// Sum of coverage and of weighted coverage of one pixel; after settling, their ratio.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    covered: f32,
    weighted: f32,
}

/// Pixels of a row: the first one's column, the row, and coverage and weight of each, 0 where
/// nothing is.
pub(crate) type CoveredRun<const N: usize> = (usize, usize, [(f32, f32); N]);

/// The part of the frame that lines can touch; only this part has cells.
#[derive(Debug, Clone, Copy)]
struct Window {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

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
        let lines: Vec<Line> = lines.collect();
        let window = Window::around(&lines, line_width_px, (width, height));
        let mut coverage = Self {
            width,
            height,
            window,
            cells: vec![Cell::default(); window.width * window.height],
            touched: BitRows::new(width, height),
        };
        for line in &lines {
            coverage.add(line, line_width_px);
        }
        coverage.settle();
        coverage
    }

    /// The coverage of a frame by runs whose first pixels lie in it.
    pub(crate) fn of_runs<const N: usize>(
        (width, height): (usize, usize),
        runs: &[CoveredRun<N>],
    ) -> Self {
        let window = Window::of_runs(runs, width);
        let mut coverage = Self {
            width,
            height,
            window,
            cells: vec![Cell::default(); window.width * window.height],
            touched: BitRows::new(width, height),
        };
        for (x, y, pixels) in runs {
            let end = (x + N).min(width);
            let row = (y - window.y) * window.width;
            let cells = &mut coverage.cells[row + x - window.x..row + end - window.x];
            let mut start = *x;
            let mut touch = |start, end| {
                if start < end {
                    coverage.touched.set_run(*y, start, end);
                }
            };
            for (k, (cell, (covered, weighted))) in cells.iter_mut().zip(pixels).enumerate() {
                (cell.covered, cell.weighted) = (*covered, *weighted);
                if *covered <= 0.0 {
                    touch(start, x + k);
                    start = x + k + 1;
                }
            }
            touch(start, end);
        }
        coverage
    }

    fn add(&mut self, line: &Line, line_width_px: f64) {
        let [x0, y0, x1, y1] = line.ends;
        let length = ((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0)).sqrt();
        if length <= 0.0 || !length.is_finite() {
            return;
        }
        let (ux, uy) = ((x1 - x0) / length, (y1 - y0) / length);
        let (half_length, half_width) = (length * 0.5, line_width_px * 0.5);
        let (side_along, side_across) = (HalfPlane::new(ux, uy), HalfPlane::new(uy, ux));
        // Half extents of the strip grown by half a pixel's diagonal extent all round.
        let (along, across) = (
            half_length + side_along.reach,
            half_width + side_across.reach,
        );
        // Up to here a pixel lies between the two ends of the strip as a whole.
        let between_ends = half_length - side_along.reach;
        let reach_y = uy.abs() * along + ux.abs() * across;
        let (middle_x, middle_y) = ((x0 + x1) * 0.5, (y0 + y1) * 0.5);
        // |t| ≤ along with t = ux·dx + uy·dy, and |d| ≤ across with d = −uy·dx + ux·dy.
        let (t_band, d_band) = (Band::new(ux, along), Band::new(-uy, across));
        let Window {
            x: first_x,
            y: first_y,
            width,
            ..
        } = self.window;
        for y in pixel_range(middle_y - reach_y, middle_y + reach_y, self.height) {
            let dy = pixel_center(y) - middle_y;
            let (t_low, t_high) = t_band.interval(uy * dy);
            let (d_low, d_high) = d_band.interval(ux * dy);
            let (low, high) = (t_low.max(d_low), t_high.min(d_high));
            let xs = pixel_range(middle_x + low, middle_x + high, self.width);
            if xs.is_empty() {
                continue;
            }
            let row =
                &mut self.cells[(y - first_y) * width..][xs.start - first_x..xs.end - first_x];
            let mut next_dx = pixel_center(xs.start) - middle_x;
            for cell in row {
                let dx = next_dx;
                next_dx += 1.0;
                let (t, d) = (ux * dx + uy * dy, ux * dy - uy * dx);
                let mut share = side_across.strip(d, half_width);
                if t.abs() > between_ends {
                    share *= side_along.strip(t, half_length);
                }
                #[expect(clippy::cast_possible_truncation, reason = "a share in 0..1 as f32")]
                let share = share.max(0.0) as f32;
                cell.covered += share;
                cell.weighted += share * line.weight;
            }
            // What turns out not to be covered is taken out again when all lines are drawn.
            self.touched.set_run(y, xs.start, xs.end);
        }
    }

    /// Sums to coverage in 0..=1 and mean weight; what no mask would show is dropped.
    fn settle(&mut self) {
        let mut xs: Vec<usize> = Vec::new();
        for y in self.window.y..self.window.y + self.window.height {
            xs.clear();
            xs.extend(self.touched.ones(y));
            for &x in &xs {
                let cell =
                    &mut self.cells[(y - self.window.y) * self.window.width + (x - self.window.x)];
                if cell.covered < LEAST {
                    self.touched.unset(x, y);
                } else {
                    cell.weighted /= cell.covered;
                    cell.covered = cell.covered.min(1.0);
                }
            }
        }
    }

    fn at(&self, x: usize, y: usize) -> (usize, f32, f32) {
        let cell = self.cells[(y - self.window.y) * self.window.width + (x - self.window.x)];
        (x, cell.covered, cell.weighted)
    }

    /// The pixels of a row that are covered: column, coverage in (0, 1], mean weight.
    pub fn row(&self, y: usize) -> impl Iterator<Item = (usize, f32, f32)> + '_ {
        self.touched.ones(y).map(move |x| self.at(x, y))
    }

    /// As [`Coverage::row`], for columns `start..end`.
    pub(crate) fn row_within(
        &self,
        y: usize,
        start: usize,
        end: usize,
    ) -> impl Iterator<Item = (usize, f32, f32)> + '_ {
        self.touched
            .ones_within(y, start, end)
            .map(move |x| self.at(x, y))
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

impl Window {
    /// The least that holds some runs, as far as they lie in a frame of this width.
    fn of_runs<const N: usize>(runs: &[CoveredRun<N>], width: usize) -> Self {
        let (mut xs, mut ys) = ([usize::MAX, 0], [usize::MAX, 0]);
        for &(x, y, _) in runs {
            xs = [xs[0].min(x), xs[1].max((x + N).min(width))];
            ys = [ys[0].min(y), ys[1].max(y + 1)];
        }
        let [left, top] = [xs[0].min(xs[1]), ys[0].min(ys[1])];
        Self {
            x: left,
            y: top,
            width: xs[1] - left,
            height: ys[1] - top,
        }
    }

    fn around(lines: &[Line], line_width_px: f64, (width, height): (usize, usize)) -> Self {
        // A pixel reaches at most √½ beyond its centre, and a centre half a pixel beyond that.
        let margin = line_width_px * 0.5 + 2.0;
        let mut bounds = [
            f64::INFINITY,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NEG_INFINITY,
        ];
        for [x0, y0, x1, y1] in lines.iter().map(|line| line.ends) {
            bounds[0] = bounds[0].min(x0).min(x1);
            bounds[1] = bounds[1].min(y0).min(y1);
            bounds[2] = bounds[2].max(x0).max(x1);
            bounds[3] = bounds[3].max(y0).max(y1);
        }
        let (xs, ys) = (
            pixel_range(bounds[0] - margin, bounds[2] + margin, width),
            pixel_range(bounds[1] - margin, bounds[3] + margin, height),
        );
        Self {
            x: xs.start,
            y: ys.start,
            width: xs.len(),
            height: ys.len(),
        }
    }
}

/// How much of a unit square a half plane covers, for one direction of its edge.
///
/// The covered area over the distance of the edge is the convolution of two boxes as wide as the
/// components of the edge's normal, a ≥ b: a ramp with parabolic ends, here as a sum of four
/// one-sided parabolas, which needs no branch per pixel.
struct HalfPlane {
    /// Beyond this distance from the centre the edge misses the square: (a + b)/2.
    reach: f64,
    /// Up to this distance the edge cuts two opposite sides: (a − b)/2.
    inner: f64,
    /// 1/(2ab), or for an edge along an axis 0.
    per_area: f64,
    /// 1/a.
    per_larger: f64,
}

/// Below this the smaller component of a unit normal counts as zero; the area is then wrong by
/// less than half of it.
const AXIS: f64 = 1e-6;

impl HalfPlane {
    fn new(nx: f64, ny: f64) -> Self {
        let (larger, smaller) = (nx.abs().max(ny.abs()), nx.abs().min(ny.abs()));
        Self {
            reach: (larger + smaller) * 0.5,
            inner: (larger - smaller) * 0.5,
            per_area: if smaller < AXIS {
                0.0
            } else {
                0.5 / (larger * smaller)
            },
            per_larger: 1.0 / larger,
        }
    }

    /// Area of the unit square on the inner side of an edge `distance` beyond its centre.
    fn area(&self, distance: f64) -> f64 {
        if self.per_area > 0.0 {
            let parabola = |x: f64| x.max(0.0) * x;
            let ends = parabola(distance + self.reach) - parabola(distance + self.inner);
            let starts = parabola(distance - self.inner) - parabola(distance - self.reach);
            ((ends - starts) * self.per_area).min(1.0)
        } else {
            (0.5 + distance * self.per_larger).clamp(0.0, 1.0)
        }
    }

    /// Area of the unit square inside a strip of half width `half`, its centre `at` off the
    /// middle of the strip.
    fn strip(&self, at: f64, half: f64) -> f64 {
        self.area(at + half) - self.area(at - half)
    }
}

/// Where |slope·v + offset| ≤ bound, for one slope and many offsets.
struct Band {
    per_slope: Option<f64>,
    /// Half width of the interval.
    half: f64,
    bound: f64,
}

impl Band {
    fn new(slope: f64, bound: f64) -> Self {
        let per_slope = (slope.abs() >= 1e-12).then(|| 1.0 / slope);
        Self {
            per_slope,
            half: per_slope.map_or(f64::INFINITY, |per_slope| (bound * per_slope).abs()),
            bound,
        }
    }

    fn interval(&self, offset: f64) -> (f64, f64) {
        match self.per_slope {
            Some(per_slope) => (
                -offset * per_slope - self.half,
                -offset * per_slope + self.half,
            ),
            None if offset.abs() <= self.bound => (f64::NEG_INFINITY, f64::INFINITY),
            None => (f64::INFINITY, f64::NEG_INFINITY),
        }
    }
}

/// The pixels whose centres may lie in `low..=high`, inside a frame of `n` pixels.
fn pixel_range(low: f64, high: f64, n: usize) -> std::ops::Range<usize> {
    if low > high {
        return 0..0;
    }
    // `as` rounds towards zero and saturates; both ends are clamped to the frame. 32 bits are
    // plenty for a frame and much faster than 64.
    #[expect(clippy::cast_possible_truncation, reason = "clamped to the frame")]
    let at_most = |value: f64| (value.max(0.0) as i32).unsigned_abs() as usize;
    let first = at_most(low - 0.5);
    let first = first + usize::from(pixel_center(first) < low);
    let end = at_most(high + 0.5).min(n);
    first.min(end)..end
}

/// Coordinate of the centre of a pixel. Frames are far smaller than 2^31 pixels a side.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "a pixel of a frame"
)]
fn pixel_center(pixel: usize) -> f64 {
    f64::from(pixel as i32) + 0.5
}

#[cfg(test)]
#[path = "coverage_tests.rs"]
mod tests;
