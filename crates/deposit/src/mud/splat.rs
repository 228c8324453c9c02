//! Splats of mud: discs with a ragged rim that has come apart into fingers.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use starbreak_seed::{normal, uniform};

use super::run::Run;
use crate::raster::Raster;
use crate::{Area, vectorized};

/// Farthest that a splat's outline is from its middle, in radii, and by how much it is longer at most the way it flew.
const MOST_OUTLINE: f64 = 2.5;
const MOST_LONGER: f64 = 1.7;

/// Farther than any drop of its spray reaches, in radii: the farthest begins 2.5 · 1.7 (1.1 + 1.2 ln 20) = 20 away.
pub(super) const MOST_REACH: f64 = 25.0;

/// Nearest that it is.
const LEAST_OUTLINE: f64 = 0.4;

/// Cells that are worked out side by side.
const TOGETHER: usize = 8;

/// Most drops of spray of a splat, their least radius over its own, and how far they fly from the way that it came, rad. FIT.
const MOST_SPRAY: f64 = 40.0;
const SPRAY_OF_SPLAT: f64 = 0.035;
const SPRAYS_RAD: f64 = 1.0;

/// Share of the spray that comes off the ends of fingers. FIT.
const OFF_FINGERS: f64 = 0.7;

/// Fingers around a splat of 1 mm of radius; others have as many more as the power ¾ of theirs. FIT. The rim of a drop that
/// spreads breaks into √We ⁴√Re/(4√3) of them \[AzizChandra2000\], at one speed the power ¾ of its own diameter, which is 0.6
/// of the splat's radius; neighbors grow together.
const FINGERS: f64 = 8.0;

/// Smaller splats have none, mm of radius. FIT.
const LEAST_FINGERED_MM: f64 = 1.0;

/// Greatest mean length of a splat's fingers over its radius, by how much more those ahead are longer and those behind are
/// shorter, and half of their width over the way to the next one, from and to. FIT.
const FINGER_LENGTH: f64 = 0.6;
const LONGER_AHEAD: f64 = 0.9;
const FINGER_WIDTHS: [f64; 2] = [0.2, 0.5];

/// Waves around the outline of a splat, and of a drop of spray.
const N_LOBES: usize = 14;
const SPRAY_LOBES: usize = 4;

/// Standard deviations of the shares of these waves: 0.16/k^1.1 of that of k times around, from k = 2 on. FIT.
pub(super) fn wave_sizes() -> [f64; N_LOBES] {
    let mut sizes = [0.0; N_LOBES];
    for (order, size) in (2_u32..).zip(&mut sizes) {
        *size = 0.16 / libm::pow(f64::from(order), 1.1);
    }
    sizes
}

/// How gently a splat ends, of 0 to 1, see [`dried`]: from and to on the mean of all directions, and by how much more behind
/// and less ahead, where it comes to rest. What is beyond 0 or 1 counts as that. FIT.
const GENTLE: [f64; 2] = [-0.2, 0.9];
const GENTLER_BEHIND: f64 = 0.5;

/// A finger of a splat's rim.
pub(super) struct Finger {
    /// Ahead, where the splat flew, and aside of that.
    towards: [f64; 2],
    /// How far it goes from the splat's middle, and half of its width, in radii.
    to: f64,
    half: f64,
}

impl Finger {
    /// Those of a splat.
    pub(super) fn of_splat(radius_mm: f64, rng: &mut ChaCha8Rng) -> Vec<Self> {
        if radius_mm < LEAST_FINGERED_MM {
            return Vec::new();
        }
        let n = (FINGERS * libm::pow(radius_mm, 0.75)).ceil();
        let apart_rad = TAU / n;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some fingers"
        )]
        let n = n as u32;
        // Few splats come apart so much, and most do less.
        let strength = uniform(rng);
        let longest = FINGER_LENGTH * strength * strength.sqrt();
        let finger = |k: u32| {
            let (sin, cos) = libm::sincos(apart_rad * (f64::from(k) + uniform(rng)));
            let mean = longest * (1.0 + LONGER_AHEAD * cos);
            // Many are short, few are long.
            let part = libm::log(1.0 - 0.92 * uniform(rng));
            let length = 0.5 * mean * part * part;
            let [least, most] = FINGER_WIDTHS;
            Self {
                towards: [cos, sin],
                to: (1.0 + length).min(MOST_OUTLINE),
                half: apart_rad * (least + (most - least) * uniform(rng)),
            }
        };
        (0..n).map(finger).collect()
    }

    /// One from whose end a drop of spray comes, if it comes from one: longer ones have more.
    fn one_of<'a>(all: &'a [Self], rng: &mut ChaCha8Rng) -> Option<&'a Self> {
        let at = uniform(rng) / OFF_FINGERS;
        let sum: f64 = all.iter().map(|it| it.to - 1.0).sum();
        let mut rest = at * sum;
        all.iter().find(|it| {
            rest -= it.to - 1.0;
            rest < 0.0
        })
    }

    /// How far a splat's outline is in a direction for it, in radii: it tapers to a round end.
    fn outline(&self, [cos, sin]: [f64; 2]) -> f64 {
        let [x, y] = self.towards;
        if cos * x + sin * y <= 0.0 {
            return 0.0;
        }
        let off = self.to * (sin * x - cos * y) / self.half;
        self.to * (1.0 - 0.35 * off * off)
    }
}

/// One splat: a disc with a ragged outline, longer than wide.
pub(super) struct Splat {
    middle_mm: [f64; 2],
    radius_mm: f64,
    /// Direction in which it flew, and by how much it is longer that way, and narrower.
    along: [f64; 2],
    longer: f64,
    /// How far its outline was before that, in radii, and how gently it ends there, in directions around it, the first once
    /// more at the end: see [`turn`].
    outline: Vec<[f64; 2]>,
}

/// Where a direction lies around, of 4 quarters: its place along a square that stands on its corner. Directions need no length.
#[inline(always)]
fn turn([x, y]: [f64; 2]) -> f64 {
    let along = y / (x.abs() + y.abs()).max(f64::MIN_POSITIVE);
    if x >= 0.0 { 1.0 + along } else { 3.0 - along }
}

/// A direction, by its place along that square.
fn turned(turn: f64) -> [f64; 2] {
    let [x, y] = match turn {
        ..2.0 => [1.0 - (turn - 1.0).abs(), turn - 1.0],
        _ => [(3.0 - turn).abs() - 1.0, 3.0 - turn],
    };
    let length = (x * x + y * y).sqrt();
    [x / length, y / length]
}

impl Splat {
    /// Outlines have eight directions for each cell that a splat's radius has, within these.
    const DIRECTIONS: [usize; 2] = [12, 400];

    /// Of a radius in cells of a width, mm.
    pub(super) fn new(
        (middle_mm, along): ([f64; 2], [f64; 2]),
        (radius_mm, cell_mm): (f64, f64),
        fingers: &[Finger],
        (waves, rng): (&[f64], &mut ChaCha8Rng),
    ) -> Self {
        let longer = 1.0 + (MOST_LONGER - 1.0) * uniform(rng) * uniform(rng);
        let mut lobes = [[0.0; 2]; N_LOBES];
        let lobes = &mut lobes[..waves.len()];
        let gentle = GENTLE[0] + (GENTLE[1] - GENTLE[0]) * uniform(rng);
        for (wave, lobe) in waves.iter().zip(&mut *lobes) {
            let size = wave * normal(rng);
            let (sin, cos) = libm::sincos(TAU * uniform(rng));
            *lobe = [size * cos, -size * sin];
        }
        let [least, most] = Self::DIRECTIONS;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some directions"
        )]
        let n = ((8.0 * radius_mm / cell_mm) as usize).clamp(least, most);
        #[expect(clippy::cast_precision_loss, reason = "some directions")]
        let mut outline: Vec<[f64; 2]> = (0..n)
            .map(|k| {
                let [cos, sin] = turned(4.0 * k as f64 / n as f64);
                // Cosines and sines of multiples of the angle, each from the one before.
                let ([mut c, mut s], mut sum) = ([cos, sin], 0.0);
                for [of_cos, of_sin] in &*lobes {
                    [c, s] = [c * cos - s * sin, s * cos + c * sin];
                    sum += of_cos * c + of_sin * s;
                }
                let disc = libm::exp(sum).max(LEAST_OUTLINE);
                let outlines = fingers.iter().map(|finger| finger.outline([cos, sin]));
                let gentle = (gentle - GENTLER_BEHIND * cos + sum).clamp(0.0, 1.0);
                [outlines.fold(disc, f64::max).min(MOST_OUTLINE), gentle]
            })
            .collect();
        outline.push(outline[0]);
        Self {
            middle_mm,
            radius_mm,
            along,
            longer,
            outline,
        }
    }

    /// Its spray over an area, most of it beyond the splat, as it was thrown: many small drops, few larger ones.
    pub(super) fn spray(
        &self,
        fingers: &[Finger],
        (area, cell_mm): (&Area, f64),
        (waves, rng): (&[f64], &mut ChaCha8Rng),
    ) -> Vec<Self> {
        let many = uniform(rng);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some drops"
        )]
        let n_drops = (MOST_SPRAY * many * many) as u32;
        let drop = |_| {
            let (sin, cos) = libm::sincos(SPRAYS_RAD * normal(rng));
            let finger = Finger::one_of(fingers, rng);
            let (towards, from) = finger.map_or(([cos, sin], 1.0), |it| (it.towards, it.to));
            let away = from * (1.1 - 1.2 * libm::log(1.0 - 0.95 * uniform(rng)));
            let way_mm = self.on_pane_mm(towards.map(|it| away * it));
            let at_mm = [0, 1].map(|k| self.middle_mm[k] + way_mm[k]);
            let far_mm = libm::hypot(way_mm[0], way_mm[1]);
            let ahead = (at_mm, way_mm.map(|it| it / far_mm));
            let larger = 1.0 / (0.03 + 0.97 * uniform(rng)).sqrt();
            let radius_mm = SPRAY_OF_SPLAT * self.radius_mm * larger;
            let is_near = area.is_near(at_mm, MOST_OUTLINE * MOST_LONGER * radius_mm);
            let waves = (&waves[..SPRAY_LOBES], &mut *rng);
            is_near.then(|| Self::new(ahead, (radius_mm, cell_mm), &[], waves))
        };
        (0..n_drops).filter_map(drop).collect()
    }

    /// Farthest that its outline is from its middle, in radii of the disc that it was.
    fn farthest(&self) -> f64 {
        self.outline.iter().fold(0.0, |most, [it, _]| most.max(*it))
    }

    /// A way from the middle, ahead and aside, in radii of the disc that it was, on the pane, mm.
    fn on_pane_mm(&self, [ahead, aside]: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.along;
        let ahead_mm = self.radius_mm * self.longer * ahead;
        let aside_mm = self.radius_mm / self.longer * aside;
        [
            cos * ahead_mm - sin * aside_mm,
            sin * ahead_mm + cos * aside_mm,
        ]
    }

    /// Of some places from the middle, mm, the squares of their distances from it in radii, and the directions to them.
    #[inline(always)]
    fn around(&self, from_middle_mm: [[f64; TOGETHER]; 2]) -> [[f64; TOGETHER]; 2] {
        let [along, across] = self.along;
        let [mut away_square, mut turns] = [[0.0; TOGETHER]; 2];
        for k in 0..TOGETHER {
            let [x, y] = from_middle_mm.map(|it| it[k]);
            let (x, y) = (
                (x * along + y * across) / self.longer,
                (y * along - x * across) * self.longer,
            );
            away_square[k] = (x * x + y * y) / (self.radius_mm * self.radius_mm);
            turns[k] = turn([x, y]);
        }
        [away_square, turns]
    }

    /// How far its outline is in a direction, in radii, and how gently it ends there.
    #[inline(always)]
    fn outline_at(&self, turn: f64) -> [f64; 2] {
        #[expect(clippy::cast_precision_loss, reason = "some directions")]
        let at = 0.25 * turn * (self.outline.len() - 1) as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some directions"
        )]
        let k = at as usize;
        match self.outline.get(k..k + 2) {
            #[expect(clippy::cast_precision_loss, reason = "some directions")]
            Some([one, other]) => [0, 1].map(|i| one[i] + (at - k as f64) * (other[i] - one[i])),
            _ => self.outline[0],
        }
    }

    /// Adds its thickness, of what runs down no more than stays; returns how many cells it covers that were clean. Where it
    /// lies over others the thinner of both adds 0.3 of its thickness (FIT).
    pub(super) fn add(&self, thickness: &mut Raster, most_mm: f64) -> usize {
        vectorized(
            #[inline(always)]
            || self.add_rows(thickness, most_mm),
        )
    }

    #[inline(always)]
    fn add_rows(&self, thickness: &mut Raster, most_mm: f64) -> usize {
        let farthest = self.farthest();
        let stays_mm = Run::stays_mm(self.radius_mm);
        // What runs is thick all over.
        let ends = if most_mm > stays_mm { 0.0 } else { 1.0 };
        let reach_mm = farthest * self.radius_mm;
        // A x² + 2 B x y + C y² is the square of the distance of a place before it was made longer; A C − B² is 1.
        let ([along, across], longer) = (self.along, self.longer * self.longer);
        let a = along * along / longer + across * across * longer;
        let b = along * across * (1.0 / longer - longer);
        let [_, rows] = thickness.around(self.middle_mm, reach_mm * a.sqrt());
        let mut n_new = 0;
        for y in rows {
            let down_mm = thickness.middle_mm(0, y)[1] - self.middle_mm[1];
            let half_mm = (a * reach_mm * reach_mm - down_mm * down_mm)
                .max(0.0)
                .sqrt()
                / a;
            let x_mm = self.middle_mm[0] - b / a * down_mm;
            let [columns, _] = thickness.around([x_mm, self.middle_mm[1]], half_mm);
            let columns = thickness.within(&columns, y);
            for left in columns.clone().step_by(TOGETHER) {
                let places = std::array::from_fn(|k| thickness.middle_mm(left + k, y));
                let from_middle_mm =
                    [0, 1].map(|axis| places.map(|at: [f64; 2]| at[axis] - self.middle_mm[axis]));
                let [away_square, turns] = self.around(from_middle_mm);
                let right = (left + TOGETHER).min(columns.end);
                let cells = &mut thickness.values[y * thickness.size[0]..][left..right];
                for ((cell, away_square), turn) in cells.iter_mut().zip(away_square).zip(turns) {
                    let [outline, gentle] = self.outline_at(turn);
                    let part_square = away_square / (outline * outline);
                    if part_square >= 1.0 {
                        continue;
                    }
                    n_new += usize::from(*cell <= 0.0);
                    #[expect(clippy::cast_possible_truncation, reason = "a length")]
                    let more = (most_mm * dried(part_square, ends * gentle)).min(stays_mm) as f32;
                    *cell = cell.max(more) + 0.3 * cell.min(more);
                }
            }
        }
        n_new
    }
}

/// How thick mud has dried over where it is thickest, by the square of the distance from its middle over that of its edge.
///
/// One that does not end gently is a little thicker all around than in the middle, for water leaves at the edge and takes earth
/// there with it \[Deegan1997\], and steep at its end; one that ends as gently as any has drawn back from its edge and is a
/// paraboloid. FIT.
#[inline(always)]
pub(super) fn dried(part_square: f64, gentle: f64) -> f64 {
    let sixth = part_square * part_square * part_square;
    let steep = (1.0 - sixth * sixth).max(0.0).sqrt() * (0.827 + 0.327 * part_square);
    steep + gentle * ((1.0 - part_square).max(0.0) - steep)
}

#[cfg(test)]
mod tests {
    use starbreak_seed::{Seed, Stream};

    use super::*;

    #[test]
    fn a_direction_is_found_where_it_lies_around() {
        for k in 0..1000 {
            let at = 0.004 * f64::from(k);
            let [x, y] = turned(at);
            assert!((x * x + y * y - 1.0).abs() < 1e-12, "{at}: {x}, {y}");
            let back = turn([3.0 * x, 3.0 * y]);
            assert!((back - at).abs() < 1e-9, "{at}: {back}");
        }
    }

    /// The cells that are covered are those within the outline, wherever it reaches, each once.
    #[test]
    fn a_splat_covers_what_is_within_its_outline() {
        let area = Area::rectangle([-30.0, -30.0], [30.0, 30.0]);
        let waves = wave_sizes();
        let (mut n_covered, mut n_far) = (0, 0);
        for seed in 0..20 {
            let mut rng = Seed(seed).stream(Stream::Mud, 16);
            let fingers = Finger::of_splat(6.0, &mut rng);
            let (sin, cos) = libm::sincos(TAU * uniform(&mut rng));
            let mut pane = Raster::over(&area, 0.25, 0.0);
            let ahead = ([1.3, -2.1], [cos, sin]);
            let splat = Splat::new(ahead, (6.0, 0.25), &fingers, (&waves, &mut rng));
            n_covered += splat.add(&mut pane, 0.1);
            for (k, value) in pane.values.iter().enumerate() {
                let [x, y] = pane.middle_mm(k % pane.size[0], k / pane.size[0]);
                let places = [[x - 1.3; TOGETHER], [y + 2.1; TOGETHER]];
                let [[away_square, ..], [turn, ..]] = splat.around(places);
                let [outline, _] = splat.outline_at(turn);
                assert_eq!(
                    *value > 0.0,
                    away_square < outline * outline,
                    "seed {seed}, {x} and {y} mm"
                );
                n_far += usize::from(*value > 0.0 && away_square > 2.0);
            }
            for turn_of in [0.1, 1.3, 2.2, 3.9] {
                let [x, y] = splat.on_pane_mm(turned(turn_of).map(|it| 1.5 * it));
                let [[square, ..], [back, ..]] = splat.around([[x; TOGETHER], [y; TOGETHER]]);
                assert!((square - 2.25).abs() < 1e-9, "{square}");
                assert!((back - turn_of).abs() < 1e-9, "{turn_of}: {back}");
            }
        }
        // Of some 20 × 1,800 cells, some in fingers.
        assert!(n_covered > 30_000 && n_far > 200, "{n_covered}, {n_far}");
    }

    /// Thin splats end gently, more so behind than ahead; what is too thick to stay ends steeply all around.
    #[test]
    fn thin_splats_end_more_gently_behind_than_ahead() {
        let area = Area::rectangle([-15.0, -15.0], [15.0, 15.0]);
        let waves = wave_sizes();
        // Over the thickest, near the edge ahead and behind.
        let near_edge = |thickness_mm: f64| {
            let [mut sums, mut counts] = [[0.0; 2]; 2];
            for seed in 0..100 {
                let mut rng = Seed(seed).stream(Stream::Mud, 16);
                let mut pane = Raster::over(&area, 0.25, 0.0);
                let ahead = ([0.0; 2], [0.6, 0.8]);
                let splat = Splat::new(ahead, (4.0, 0.25), &[], (&waves, &mut rng));
                _ = splat.add(&mut pane, thickness_mm);
                for (k, value) in pane.values.iter().enumerate() {
                    let [x, y] = pane.middle_mm(k % pane.size[0], k / pane.size[0]);
                    let ([[away_square, ..], [turn, ..]], along) = (
                        splat.around([[x; TOGETHER], [y; TOGETHER]]),
                        0.6 * x + 0.8 * y,
                    );
                    let [outline, _] = splat.outline_at(turn);
                    let part_square = away_square / (outline * outline);
                    if (0.6..0.9).contains(&part_square) && along.abs() > 1.5 {
                        let side = usize::from(along < 0.0);
                        sums[side] += f64::from(*value) / thickness_mm;
                        counts[side] += 1.0;
                    }
                }
            }
            [0, 1].map(|k| sums[k] / counts[k])
        };
        let [ahead, behind] = near_edge(0.1);
        assert!(ahead > behind + 0.2, "{ahead} ahead, {behind} behind");
        let [ahead, behind] = near_edge(0.26);
        assert!(
            (ahead - behind).abs() < 0.02 && behind > 0.85,
            "too thick to stay: {ahead}, {behind}"
        );
    }
}
