//! Crushed glass under a hit: grains, of which sight meets several layers.

use std::f64::consts::TAU;

use starbreak_seed::Stream;

use super::hit::{Patch, RAGGED};
use super::lobe::{HELD, Mirror, N_SHARES, SUN, Sent};
use super::roughness::Sampled;
use crate::vector::{Vector, unit};

/// Size of a grain over the radius of the crushed zone, and its bounds, mm. FIT to photographs:
/// powder, which under a heavy body is a milky disc.
const GRAIN: f64 = 0.14;
const GRAINS_MM: [f64; 2] = [0.12, 0.25];

/// Cells that stand for grains are no smaller than this, px, or this part of the radius of their
/// blur. One that stands for more grains than are drawn differs from the mean of all by as much less.
pub(super) const LEAST_PX: f64 = 1.5;
pub(super) const LEAST_OF_BLUR: f64 = 0.4;
const MOST_DRAWN: f64 = 2.0;

/// Most of what a cell sends that is its own, not the mean: sight goes through several layers of grains. FIT.
const MOST_OWN: f64 = 0.4;

/// Grains of which the mean of all is taken, at the middle and at the rim of a zone, and how far apart the directions of
/// sight are for which it is.
const N_OF_ALL: u32 = 40;
const ALIKE: f64 = 0.25;

/// Most cells along a side of a crushed zone.
const MOST_CELLS: f64 = 90.0;

/// How far corners of grains are from those of a regular grid, over their size. FIT.
const JITTER: f64 = 0.36;

/// Grains that are white powder, that mirror, that turn sight outside, and that let no light out;
/// the others are clear. At the middle and at the rim of the zone. FIT: photographs show gray and
/// white crumbs with dark and bright ones among them.
const GRAINS: [[f64; 4]; 2] = [[0.44, 0.30, 0.12, 0.10], [0.14, 0.22, 0.16, 0.06]];

/// How white powder is. FIT.
const WHITE: [f64; 2] = [0.35, 0.95];

/// Tilt of the faces of grains against the pane, rad, and their roughness as α of GGX. FIT: broken
/// faces are between mist and mirror.
const TILTS_RAD: [f64; 2] = [0.35, 1.4];
const GRAIN_ALPHA: f64 = 0.06;

/// Share of a grain that is one face more, which may mirror the sun. FIT.
const SPARK_SHARE: f64 = 0.3;

/// The mean of all grains at the middle of a zone and at its rim, by where they are seen from.
pub(super) type AllGrains = ([i16; 2], [Sent; 2]);

/// A corner of grains, mm from the middle of a hit, and where it appears in the frame, px.
type Corner = ([f64; 2], Option<[f64; 2]>);

impl Patch<'_, '_> {
    /// Grains between the corners of a grid that is not regular.
    pub(super) fn crushed(&mut self, radius: f64) {
        if radius <= 0.0 {
            return;
        }
        let sheet = self.from.sheet;
        let grain = (GRAIN * radius).clamp(GRAINS_MM[0], GRAINS_MM[1]);
        let outermost = radius * (1.0 + 2.5 * RAGGED);
        let size = grain
            .max(self.least_mm())
            .max(2.0 * outermost / MOST_CELLS)
            .min(radius);
        let in_grains = size / grain;
        let n_grains = (in_grains * in_grains).max(1.0);
        let all = self.all_grains();
        let rim = self.ragged();
        let n = (2.0 * outermost / size).ceil().max(2.0);
        // Grains are as deep as they are wide: a pane that is seen from the side does not make them
        // narrow.
        let long = self.foreshortening();
        let (sin, cos) = libm::sincos(TAU * self.uniform());
        let row = |patch: &mut Self, i: f64| -> Vec<Corner> {
            let mut corners = Vec::new();
            let mut k = 0.0;
            while k <= n {
                let [x, y] = [k, i].map(|at| {
                    let jitter = JITTER * (2.0 * patch.uniform() - 1.0);
                    (at + jitter - 0.5 * n) * size
                });
                let at = [x * cos - y * sin, (x * sin + y * cos) * long];
                let place = [patch.middle[0] + at[0], patch.middle[1] + at[1]];
                corners.push((at, sheet.project(place, sheet.outer_mm(), [0.0; 2])));
                k += 1.0;
            }
            corners
        };
        let mut above = row(self, 0.0);
        let mut i = 1.0;
        while i <= n {
            let below = row(self, i);
            for k in 1..above.len() {
                let corners = [above[k - 1], above[k], below[k], below[k - 1]];
                let middle =
                    [0, 1].map(|axis| corners.iter().map(|(c, _)| 0.25 * c[axis]).sum::<f64>());
                let far = (middle[0] * middle[0] + middle[1] * middle[1]).sqrt();
                let way = far / (radius * rim.at(libm::atan2(middle[1], middle[0])));
                if way < 1.0
                    && let [Some(a), Some(b), Some(c), Some(d)] = corners.map(|(_, seen)| seen)
                {
                    self.grain([a, b, c, d], (middle, way), (n_grains, &all));
                }
            }
            above = below;
            i += 1.0;
        }
    }

    /// The mean of all grains at the middle of the zone and at its rim, of directions of sight like its own: what other
    /// hits there are does not change it.
    fn all_grains(&mut self) -> Option<[Sent; 2]> {
        let sight = self.from.sheet.sight(self.middle, [0.0; 2])?;
        #[expect(clippy::cast_possible_truncation, reason = "some steps")]
        let steps = [0, 1].map(|k| (sight[k] / ALIKE).round() as i16);
        if let Some((_, known)) = self.all.1.iter().find(|(of, _)| *of == steps) {
            return Some(*known);
        }
        let [x, y] = steps.map(|step| ALIKE * f64::from(step));
        let sight = unit([x, y, (1.0 - x * x - y * y).max(0.01).sqrt()]);
        let [across, down] = steps.map(|step| u64::from(step.cast_unsigned()));
        let stream = (1 << 40) | (across << 16) | down;
        let own = std::mem::replace(
            &mut self.rng,
            self.all.0.stream(Stream::CrackRelief, stream),
        );
        let means = [0.0, 1.0].map(|way| self.some_grains((sight, way), N_OF_ALL));
        self.rng = own;
        self.all.1.push((steps, means));
        Some(means)
    }

    /// The mean of some grains a part of the way from the middle of the zone to its rim.
    fn some_grains(&mut self, (sight, way): (Vector, f64), n: u32) -> Sent {
        let mut sent = Sent::default();
        for _ in 0..n {
            let one = self.one_grain(sight, way);
            sent.add(&one, 1.0 / f64::from(n));
        }
        sent
    }

    /// A cell of the crushed zone, with its corners in the frame, its middle a part of the way from that of the zone
    /// to its rim: the mean of some grains.
    fn grain(
        &mut self,
        corners: [[f64; 2]; 4],
        (middle, way): ([f64; 2], f64),
        (n_grains, all): (f64, &Option<[Sent; 2]>),
    ) {
        let sheet = self.from.sheet;
        let depth = sheet.outer_mm();
        let place = [self.middle[0] + middle[0], self.middle[1] + middle[1]];
        if self.fallen.is_at(place) {
            return;
        }
        let (Some(sight), Some(radius_px)) = (
            sheet.sight(place, [0.0; 2]),
            sheet.blur_radius_px(place, depth),
        ) else {
            return;
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few"
        )]
        let n_drawn = n_grains.min(MOST_DRAWN).round() as u32;
        let mut sent = self.some_grains((sight, way), n_drawn);
        if let Some([at_middle, at_rim]) = all {
            let own = (MOST_DRAWN / n_grains).sqrt().min(MOST_OWN);
            sent = sent.scaled(own);
            sent.add(at_middle, (1.0 - own) * (1.0 - way * way));
            sent.add(at_rim, (1.0 - own) * way * way);
        }
        if sent.lanes[..N_SHARES].iter().sum::<f64>() <= 0.0 {
            return;
        }
        self.facets.outlines.push(corners);
        self.facets
            .add(corners, radius_px, &sent, [[1.0, 0.0], [0.0, 1.0]]);
    }

    /// What one grain sends.
    fn one_grain(&mut self, sight: Vector, way: f64) -> Sent {
        let [white, mirrors, turns, holds] =
            std::array::from_fn(|k| GRAINS[0][k] + (GRAINS[1][k] - GRAINS[0][k]) * way * way);
        let mut sent = Sent::default();
        let kind = self.uniform();
        let strength = self.uniform();
        if kind < white {
            let share = WHITE[0] + (WHITE[1] - WHITE[0]) * strength;
            self.from.diffuse(&mut sent, share);
        } else if kind < white + mirrors {
            let mirror = self.face(sight);
            sent = self.from.mirror(&mirror, Sampled::Cell(0));
            sent.tint = [0.0; 3];
        } else if kind < white + mirrors + turns {
            let normal = self.face(sight).normal;
            sent = self.through(sight, normal, 0.6 + 0.4 * strength);
        } else if kind < white + mirrors + turns + holds {
            sent.lanes[HELD] = 0.5 + 0.5 * strength;
        }
        // All of them have a face that may send the sun's light.
        let spark = self.face(sight);
        sent.lanes[SUN] += SPARK_SHARE * self.from.sun_in(&spark, Sampled::Cell(0));
        sent
    }

    /// A broken face of a grain, that looks any way.
    fn face(&mut self, sight: Vector) -> Mirror {
        let tilt = TILTS_RAD[0] + (TILTS_RAD[1] - TILTS_RAD[0]) * self.uniform();
        let (sin, cos) = libm::sincos(TAU * self.uniform());
        let (across, up) = libm::sincos(tilt);
        Mirror {
            sight,
            normal: [across * cos, across * sin, up],
            alpha: GRAIN_ALPHA,
            gap_um: 50.0,
        }
    }
}
