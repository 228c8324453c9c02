//! What runs down from splats of mud.

use std::f64::consts::{PI, TAU};

use rand_chacha::ChaCha8Rng;
use starbreak_seed::uniform;

use super::splat::dried;
use crate::raster::Raster;

/// What is thicker runs down: τ/(ρ g sin α) of a slurry with a yield stress τ of 2 Pa and a density ρ of 1,600 kg/m³ on
/// glass at α = 30° from level, mm [LiuMei1989].
const STAYS_MM: f64 = 0.25;

/// Smaller splats do not run, mm of radius: their edge holds them. FIT.
const LEAST_RUNNING_MM: f64 = 1.8;

/// Narrowest and widest run, mm, and about how far apart two of one splat are. FIT, of the order of the capillary length.
const RUN_WIDTHS_MM: [f64; 2] = [0.9, 2.4];
const RUNS_APART_MM: f64 = 5.0;

/// Mud that has run down from a splat: a track that is as thick as what stays where it ended, and thinner above.
pub(super) struct Run {
    /// Where it began, within the splat.
    from_mm: [f64; 2],
    length_mm: f64,
    /// How much of that lies in the splat.
    hidden_mm: f64,
    width_mm: f64,
    /// Length, mm, and phase of the waves in which it sways.
    sways: [[f64; 2]; 2],
}

impl Run {
    /// How thick the track is where it begins, over what stays. FIT.
    const TRACK: f64 = 0.4;

    /// How wide it is where it begins, over its width. FIT.
    const WAIST: f64 = 0.7;

    /// How far below the splat it is wider, mm, and by how much of its width. FIT.
    const NECK: [f64; 2] = [1.5, 1.2];

    /// Radius of its round end over its width. FIT.
    const HEAD: f64 = 0.62;

    /// Mean over its width of what has dried, over its thickest.
    const ACROSS: f64 = 0.883;

    /// How far it sways, mm, over the square root of the length of a wave. FIT.
    const SWAY: f64 = 0.06;

    /// How thick a splat of a radius stays at most, mm.
    pub(super) fn stays_mm(radius_mm: f64) -> f64 {
        if radius_mm < LEAST_RUNNING_MM {
            f64::INFINITY
        } else {
            STAYS_MM
        }
    }

    /// What has run down from a splat that was so thick where it was thickest: as much as was thicker than what stays, or as
    /// the shortest run holds.
    pub(super) fn of_splat(
        (middle_mm, radius_mm): ([f64; 2], f64),
        most_mm: f64,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Self> {
        if most_mm <= Self::stays_mm(radius_mm) {
            return Vec::new();
        }
        let volume_mm3 = PI * radius_mm * radius_mm * excess_mm(most_mm);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some runs"
        )]
        let n_runs = 1 + (2.0 * radius_mm * uniform(rng) / RUNS_APART_MM) as usize;
        // A share of none would be a run of no length.
        let shares: Vec<f64> = (0..n_runs)
            .map(|_| 0.05 - libm::log(1.0 - uniform(rng)))
            .collect();
        let sum: f64 = shares.iter().sum();
        let run = |share: &f64| {
            let [least, most] = RUN_WIDTHS_MM;
            let width_mm = (least + (most - least) * uniform(rng)).min(1.2 * radius_mm);
            // Within the splat, which may be narrow.
            let aside = radius_mm * (0.9 * uniform(rng) - 0.45);
            let sways = [41.0, 16.0].map(|long_mm| [long_mm, TAU * uniform(rng)]);
            let mut run = Self {
                from_mm: [middle_mm[0] + aside, middle_mm[1]],
                length_mm: radius_mm,
                hidden_mm: (radius_mm * radius_mm - aside * aside).sqrt(),
                width_mm,
                sways,
            };
            run.reach(share / sum * volume_mm3);
            run
        };
        shares.iter().map(run).collect()
    }

    /// Makes it so long that below its splat it holds a volume, mm³.
    fn reach(&mut self, volume_mm3: f64) {
        let (mut least, mut most) = (self.hidden_mm, self.hidden_mm);
        while self.volume_mm3(most) < volume_mm3 {
            most += volume_mm3 / (self.width_mm * STAYS_MM * Self::TRACK);
        }
        for _ in 0..24 {
            let between = 0.5 * (least + most);
            if self.volume_mm3(between) < volume_mm3 {
                least = between;
            } else {
                most = between;
            }
        }
        self.length_mm = most;
    }

    /// What it holds below its splat, mm³, if it is so long.
    fn volume_mm3(&self, length_mm: f64) -> f64 {
        const N: u32 = 64;
        let below_mm = length_mm + Self::HEAD * self.width_mm - self.hidden_mm;
        let step_mm = below_mm / f64::from(N);
        let run = Self { length_mm, ..*self };
        let slices = (0..N).map(|k| run.section(self.hidden_mm + (f64::from(k) + 0.5) * step_mm));
        slices
            .map(|[half_mm, thick_mm]| 2.0 * Self::ACROSS * half_mm * thick_mm * step_mm)
            .sum()
    }

    /// Half of its width and its thickness so far below where it began, mm.
    fn section(&self, down_mm: f64) -> [f64; 2] {
        let part = (down_mm / self.length_mm).clamp(0.0, 1.0);
        let track_mm = if (0.0..=self.length_mm).contains(&down_mm) {
            let [neck_mm, wider] = Self::NECK;
            let neck = wider * libm::exp(-(down_mm - self.hidden_mm).abs() / neck_mm);
            0.5 * self.width_mm * (Self::WAIST + (1.0 - Self::WAIST) * part + neck)
        } else {
            0.0
        };
        let (head_mm, beyond_mm) = (Self::HEAD * self.width_mm, down_mm - self.length_mm);
        let head_mm = (head_mm * head_mm - beyond_mm * beyond_mm).max(0.0).sqrt();
        let thick_mm = STAYS_MM * (Self::TRACK + (1.0 - Self::TRACK) * part * part);
        [track_mm.max(head_mm), thick_mm]
    }

    /// How far a place on its middle line is aside of where it began, mm.
    fn aside_mm(&self, down_mm: f64) -> f64 {
        let sway = |[long_mm, phase]: [f64; 2]| {
            let at = |down_mm: f64| libm::sin(TAU * down_mm / long_mm + phase);
            Self::SWAY * long_mm.sqrt() * (at(down_mm) - at(0.0))
        };
        self.sways.into_iter().map(sway).sum()
    }

    /// Adds its thickness; returns how many cells it covers that were clean.
    pub(super) fn add(&self, thickness: &mut Raster) -> usize {
        let reach_mm = self.length_mm + self.width_mm;
        let [_, rows] = thickness.around(
            [self.from_mm[0], self.from_mm[1] + 0.5 * reach_mm],
            0.5 * reach_mm,
        );
        let mut n_new = 0;
        for y in rows {
            let down_mm = thickness.middle_mm(0, y)[1] - self.from_mm[1];
            let [half_mm, thick_mm] = self.section(down_mm);
            if half_mm <= 0.0 {
                continue;
            }
            let middle_mm = self.from_mm[0] + self.aside_mm(down_mm);
            // No narrower than cells, or it would be dashes.
            let wide_mm = half_mm.max(0.75 * thickness.cell_mm);
            let most_mm = thick_mm * half_mm / wide_mm;
            let [columns, _] = thickness.around([middle_mm, self.from_mm[1]], wide_mm);
            for x in thickness.within(&columns, y) {
                let off = (thickness.middle_mm(x, y)[0] - middle_mm) / wide_mm;
                #[expect(clippy::cast_possible_truncation, reason = "a length")]
                let more = (most_mm * dried(off * off, 0.0)) as f32;
                let cell = &mut thickness.values[y * thickness.size[0] + x];
                n_new += usize::from(*cell <= 0.0 && more > 0.0);
                *cell = cell.max(more);
            }
        }
        n_new
    }
}

/// By how much, on the mean over its disc, a splat of such a thickness is thicker than what stays, mm.
fn excess_mm(most_mm: f64) -> f64 {
    const N: u32 = 64;
    let squares = (0..N).map(|k| (f64::from(k) + 0.5) / f64::from(N));
    let over_mm = squares.map(|square| (most_mm * dried(square, 0.0) - STAYS_MM).max(0.0));
    over_mm.sum::<f64>() / f64::from(N)
}

#[cfg(test)]
mod tests {
    use starbreak_seed::{Seed, Stream};

    use super::*;
    use crate::Area;

    #[test]
    fn what_runs_down_is_what_was_too_thick_to_stay() {
        let area = Area::rectangle([-20.0, -10.0], [20.0, 600.0]);
        for (radius_mm, most_mm) in [(1.9, 0.6), (4.0, 0.35), (4.0, 0.6), (9.0, 0.5)] {
            let (mut below_mm3, mut excess_mm3) = (0.0, 0.0);
            for seed in 0..40 {
                let mut rng = Seed(seed).stream(Stream::Mud, 16);
                for run in Run::of_splat(([0.0; 2], radius_mm), most_mm, &mut rng) {
                    // Alone, for where two meet the thicker one counts.
                    let mut pane = Raster::over(&area, 0.2, 0.0);
                    _ = run.add(&mut pane);
                    for y in 0..pane.size[1] {
                        let down_mm = pane.middle_mm(0, y)[1];
                        let row = &pane.values[y * pane.size[0]..][..pane.size[0]];
                        let has_any = row.iter().any(|it| *it > 0.0);
                        assert!(!has_any || down_mm > -0.2, "nothing runs up: {down_mm} mm");
                        if down_mm > run.hidden_mm {
                            below_mm3 += row.iter().map(|it| f64::from(*it) * 0.04).sum::<f64>();
                        }
                    }
                }
                excess_mm3 += PI * radius_mm * radius_mm * excess_mm(most_mm);
            }
            let ratio = below_mm3 / excess_mm3;
            let of = format!("{radius_mm} mm, {most_mm} mm: {ratio} of it is found below");
            assert!((ratio - 1.0).abs() < 0.2, "{of}");
        }
    }

    #[test]
    fn thin_mud_and_small_splats_stay_where_they_are() {
        for (radius_mm, most_mm, does_run) in [
            (4.0, STAYS_MM, false),
            (1.5, 1.0, false),
            (4.0, 1.5 * STAYS_MM, true),
        ] {
            let mut rng = Seed(3).stream(Stream::Mud, 16);
            let runs = Run::of_splat(([0.0; 2], radius_mm), most_mm, &mut rng);
            assert_eq!(!runs.is_empty(), does_run, "{radius_mm}, {most_mm} mm");
        }
    }
}
