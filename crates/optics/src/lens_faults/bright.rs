//! Bright pixels of a frame, and the regions that they make.

use std::ops::Range;

/// Light from which pixels beside clipped ones belong to their region.
pub(super) const BORDER: f32 = 0.9;

/// Light of which a sample is clipped: of 8 bits the last code alone.
pub(super) const CLIPPED: f32 = 0.995;

/// Light around a region from which on it is no lamp, and how far around, of the frame's diagonal: beside it and, at
/// corners, amid what is around. FIT.
const AMID: f32 = 0.5;
const AROUND: [f64; 2] = [0.01, 0.02];

/// A region of a frame.
#[derive(Clone, Copy, Default)]
pub(super) struct Region {
    pub(super) n_pixels: usize,
    /// Farthest from its border, in steps.
    pub(super) depth: u32,
    pub(super) is_clipped: bool,
    /// Sum of the light of some places around it that are not its own, and how many these are.
    around: (f32, u32),
}

impl Region {
    /// How much of a lamp it is by the light around it: 1 in the dark, 0 amid light that is half as bright.
    pub(super) fn stands_out(&self) -> f32 {
        let (sum, n) = self.around;
        if n == 0 {
            return 0.0;
        }
        #[expect(clippy::cast_precision_loss, reason = "some places")]
        let light = (sum / n as f32 / AMID).min(1.0);
        let rest = 1.0 - light * light;
        rest * rest
    }
}

/// Steps right and down to places around one.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "px of a frame"
)]
fn places_around(n_pixels: usize, width: usize) -> [[isize; 2]; 8] {
    let diagonal_px = libm::hypot(width as f64, (n_pixels / width) as f64);
    let [a, b] = AROUND.map(|part| (part * diagonal_px).ceil() as isize);
    [
        [-a, 0],
        [a, 0],
        [0, -a],
        [0, a],
        [-b, -b],
        [b, -b],
        [-b, b],
        [b, b],
    ]
}

/// Steps to a neighbor beside a pixel and at its corner; depths are in thirds of a px.
pub(super) const STEPS: [u32; 2] = [3, 4];

/// The light of a pixel's brightest color.
#[inline(always)]
pub(super) fn brightest<const COLORS: usize>(pixel: &[f32; COLORS]) -> f32 {
    pixel.iter().fold(0.0, |most, value| most.max(*value))
}

/// The pixels of which a color is so bright, in their order; those of a row that are side by side are together.
pub(super) fn runs_with<const COLORS: usize>(
    light: &[[f32; COLORS]],
    width: usize,
    is_bright: impl Fn(f32) -> bool,
) -> Vec<Range<usize>> {
    /// Pixels that are looked at together: most frames are dark but for some.
    const TOGETHER: usize = 32;
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (y, row) in light.chunks_exact(width).enumerate() {
        let mut start = y * width;
        // Where the last run may go on.
        let mut end = usize::MAX;
        for some in row.chunks(TOGETHER) {
            let values = some.as_flattened().iter();
            let is_any = values.fold(false, |any, value| any | is_bright(*value));
            if is_any {
                for (at, pixel) in (start..).zip(some) {
                    if !pixel.iter().any(|value| is_bright(*value)) {
                        continue;
                    }
                    match runs.last_mut() {
                        Some(run) if at == end => run.end += 1,
                        _ => runs.push(at..at + 1),
                    }
                    end = at + 1;
                }
            }
            start += some.len();
        }
    }
    runs
}

/// Bright pixels of a frame, those of a row that are side by side together, in their order.
pub(super) struct Bright {
    pub(super) runs: Vec<Range<usize>>,
    /// Of the frame, px.
    pub(super) size: (usize, usize),
}

/// Those of some values, one for each pixel of some runs, that are of each run.
pub(super) fn by_run<'a, T>(
    runs: &[Range<usize>],
    values: &'a [T],
) -> impl Iterator<Item = &'a [T]> {
    runs.iter().scan(values, |rest, run| {
        let (of_run, later) = rest.split_at(run.len());
        *rest = later;
        Some(of_run)
    })
}

/// Farther than any pixel is from another, in steps, and far from the largest number.
const FAR: u32 = 1 << 28;

impl Bright {
    /// How far each bright pixel is from the next that is not, in steps; beyond the frame it goes on.
    pub(super) fn depths(&self) -> Vec<u32> {
        let n = self.runs.iter().map(Range::len).sum();
        let mut depths = vec![FAR; n];
        self.lessen(&mut depths);
        // And from the other end.
        let n_pixels = self.size.0 * self.size.1;
        let mirrored = |run: &Range<usize>| n_pixels - run.end..n_pixels - run.start;
        let mirrored = Self {
            runs: self.runs.iter().rev().map(mirrored).collect(),
            ..*self
        };
        depths.reverse();
        mirrored.lessen(&mut depths);
        depths.reverse();
        depths
    }

    /// Lessens depths by those of neighbors that come before: one beside a pixel and three above it.
    fn lessen(&self, depths: &mut [u32]) {
        let [side, corner] = STEPS;
        let (width, height) = self.size;
        // Of a row, with a place beyond either end.
        let mut above = vec![FAR; width + 2];
        let mut here = above.clone();
        let (mut runs, mut depths) = (self.runs.iter().peekable(), depths);
        for start in (0..height).map(|y| y * width) {
            here[1..=width].fill(0);
            while let Some(run) = runs.next_if(|run| run.start < start + width) {
                let (of_run, rest) = depths.split_at_mut(run.len());
                depths = rest;
                let first = run.start - start;
                let mut beside = here[first];
                let above = above[first..].windows(3);
                let here = &mut here[first + 1..];
                for ((depth, here), above) in of_run.iter_mut().zip(here).zip(above) {
                    let of_above = (above[1] + side).min(above[0].min(above[2]) + corner);
                    beside = (beside + side).min(of_above).min(*depth);
                    *depth = beside;
                    *here = beside;
                }
            }
            std::mem::swap(&mut above, &mut here);
        }
    }

    /// The regions, and that of each run.
    pub(super) fn regions<const COLORS: usize>(
        &self,
        depths: &[u32],
        light: &[[f32; COLORS]],
    ) -> (Vec<Region>, Vec<usize>) {
        let of_runs = self.joined();
        let mut regions = vec![Region::default(); self.runs.len()];
        let runs = self.runs.iter().zip(by_run(&self.runs, depths));
        for ((run, depths), of) in runs.zip(&of_runs) {
            let region = &mut regions[*of];
            region.n_pixels += run.len();
            region.depth = depths.iter().fold(region.depth, |a, b| a.max(*b));
            let mut pixels = light[run.clone()].iter();
            region.is_clipped |= pixels.any(|pixel| brightest(pixel) >= CLIPPED);
        }
        self.look_around((depths, light), &of_runs, &mut regions);
        (regions, of_runs)
    }

    /// The first run of the region of each: that of runs that touch above or below.
    fn joined(&self) -> Vec<usize> {
        let width = self.size.0;
        let mut of: Vec<usize> = (0..self.runs.len()).collect();
        let mut above = 0;
        for (k, run) in self.runs.iter().enumerate() {
            while self.runs[above].end + width <= run.start {
                above += 1;
            }
            let touching = (above..k).take_while(|it| self.runs[*it].start + width < run.end);
            for other in touching {
                let ends = [other, k].map(|it| whole(&mut of, it));
                of[ends[0].max(ends[1])] = ends[0].min(ends[1]);
            }
        }
        (0..of.len()).map(|k| whole(&mut of, k)).collect()
    }

    /// Adds up the light around regions that are clipped: of places around their border that are not their own.
    fn look_around<const COLORS: usize>(
        &self,
        (depths, light): (&[u32], &[[f32; COLORS]]),
        of_runs: &[usize],
        regions: &mut [Region],
    ) {
        let (width, height) = self.size;
        let around = places_around(light.len(), width);
        // The first run of each row.
        let rows: Vec<usize> = (0..=height)
            .scan(0, |first, y| {
                let runs = self.runs[*first..].iter();
                *first += runs.take_while(|run| run.start < y * width).count();
                Some(*first)
            })
            .collect();
        let region_at = |at: usize, y: usize| {
            let runs = &self.runs[rows[y]..rows[y + 1]];
            let run = rows[y] + runs.partition_point(|run| run.end <= at);
            of_runs[run]
        };
        let runs = self.runs.iter().zip(by_run(&self.runs, depths));
        for ((run, depths), own) in runs.zip(of_runs) {
            if !regions[*own].is_clipped {
                continue;
            }
            let (left, y) = (run.start % width, run.start / width);
            let border = (left..).zip(depths).filter(|(_, it)| **it <= STEPS[0]);
            for (x, [right, down]) in border.flat_map(|(x, _)| around.map(|way| (x, way))) {
                let column = x.checked_add_signed(right).filter(|it| *it < width);
                let row = y.checked_add_signed(down).filter(|it| *it < height);
                let Some((column, row)) = column.zip(row) else {
                    continue;
                };
                let there = row * width + column;
                let light = brightest(&light[there]);
                if light < BORDER || region_at(there, row) != *own {
                    let around = &mut regions[*own].around;
                    around.0 += light;
                    around.1 += 1;
                }
            }
        }
    }
}

/// The first run of the region that one is part of in the end.
fn whole(of: &mut [usize], mut run: usize) -> usize {
    while of[run] != run {
        of[run] = of[of[run]];
        run = of[run];
    }
    run
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of 1 to 12 px a side, of which so many of eight pixels are bright.
    fn frames() -> impl Iterator<Item = (Vec<[f32; 1]>, usize)> {
        (0..1200_usize).map(|frame| {
            let (width, height) = (1 + frame % 12, 1 + frame / 12 % 12);
            let n_bright = 1 + frame / 144 % 8;
            let is_bright = |k: usize| (k + 7 * frame).wrapping_mul(2_654_435_761) >> 13 & 7;
            let light = |k| [if is_bright(k) < n_bright { 1.0 } else { 0.1 }];
            ((0..width * height).map(light).collect(), width)
        })
    }

    fn bright_of(light: &[[f32; 1]], width: usize) -> Bright {
        Bright {
            runs: runs_with(light, width, |value| value >= BORDER),
            size: (width, light.len() / width),
        }
    }

    #[test]
    fn depths_are_the_steps_to_the_next_dark_pixel() {
        for (light, width) in frames() {
            let bright = bright_of(&light, width);
            let places: Vec<usize> = bright.runs.iter().cloned().flatten().collect();
            let dark = |at: &usize| light[*at][0] < BORDER;
            let all: Vec<usize> = (0..light.len()).filter(|at| !dark(at)).collect();
            assert_eq!(places, all, "places of {light:?} in rows of {width}");
            let steps = |at: usize, to: usize| {
                let (dx, dy) = (
                    (at % width).abs_diff(to % width),
                    (at / width).abs_diff(to / width),
                );
                let corners = u32::try_from(dx.min(dy)).unwrap_or(FAR);
                let all = u32::try_from(dx.max(dy)).unwrap_or(FAR);
                STEPS[0] * (all - corners) + STEPS[1] * corners
            };
            let nearest = |at: usize| {
                let others = (0..light.len()).filter(dark).map(|to| steps(at, to));
                others.min().unwrap_or(FAR)
            };
            let wanted: Vec<u32> = all.iter().map(|at| nearest(*at)).collect();
            assert_eq!(bright.depths(), wanted, "{light:?} in rows of {width}");
        }
    }

    #[test]
    fn pixels_that_touch_by_their_sides_are_one_region() {
        for (light, width) in frames() {
            let bright = bright_of(&light, width);
            // Each bright pixel by itself, then the least of its neighbors until nothing changes.
            let mut of: Vec<usize> = (0..light.len()).collect();
            let is_bright = |at: usize| light[at][0] >= BORDER;
            for _ in 0..light.len() {
                for at in (0..light.len()).filter(|at| is_bright(*at)) {
                    let right = at + 1;
                    let beside = (right % width > 0).then_some(right);
                    let below = (at + width < light.len()).then_some(at + width);
                    for next in beside.into_iter().chain(below).filter(|at| is_bright(*at)) {
                        let least = of[at].min(of[next]);
                        (of[at], of[next]) = (least, least);
                    }
                }
            }
            let joined = bright.joined();
            let first = |run: usize| bright.runs[run].start;
            for (run, joined) in bright.runs.iter().zip(joined) {
                assert_eq!(first(joined), of[run.start], "{light:?} in rows of {width}");
            }
        }
    }
}
