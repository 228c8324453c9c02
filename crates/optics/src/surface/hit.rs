//! What a stone leaves where it hit: crushed glass, the shell that chips off, a film of air.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use starbreak_glass::{CrackNetwork, LengthUnit};
use starbreak_seed::{Seed, Stream};

use super::chains::Fallen;
use super::cracks::Facets;
use super::lobe::{HELD, LightFrom, Mirror, N_SHARES, SUN, Sent, into_glass};
use crate::surface::SurfaceParams;
use crate::vector::Vector;

/// Size of a grain over the radius of the crushed zone, and its bounds, mm. FIT to photographs:
/// powder under a stone, crumbs of about half of a ply under a heavy body.
const GRAIN: f64 = 0.14;
const GRAINS_MM: [f64; 2] = [0.12, 1.1];

/// Cells that stand for grains are no smaller than this, px, or this part of the radius of their
/// blur; one that stands for several is the mean of so many at most.
const LEAST_PX: f64 = 1.5;
const LEAST_OF_BLUR: f64 = 0.4;
const MOST_DRAWN: f64 = 6.0;

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

/// Faces of a grain that may mirror the sun, each of this share of it. FIT.
const N_SPARKS: u32 = 3;
const SPARK_SHARE: f64 = 0.1;

/// By how much the rim of a patch is nearer or farther, of its radius (one standard deviation). FIT.
const RAGGED: f64 = 0.13;

/// Waves around the rim of a patch.
const N_WAVES: u32 = 7;

/// Shells that may come off around a hit, and of which share one does. FIT.
const N_SHELLS: u32 = 5;
const CHIPPED: f64 = 0.55;

/// Shells and films reach so many thicknesses of the ply beyond the crushed zone at most.
const MOST_BEYOND: [f64; 2] = [1.0, 2.0];

/// Sectors and rings of a film, which has fringes; of a shell.
const FILM_CELLS: [u32; 2] = [30, 8];
const SHELL_CELLS: [u32; 2] = [8, 6];

/// Adds the surroundings of every hit that has crushed the glass at `time`: of which a crack has
/// begun to run.
pub(crate) fn hit_facets(
    from: &LightFrom<'_>,
    network: &CrackNetwork,
    time: f64,
    surface: &SurfaceParams,
    seed: Seed,
    facets: &mut Facets,
) {
    let data = network.data();
    if data.unit != LengthUnit::Mm {
        return;
    }
    let fallen = Fallen::of(network, time);
    for (k, impact) in (0_u64..).zip(&data.impacts) {
        let Some(crushed_mm) = impact.crushed_radius_mm.filter(|radius| *radius > 0.0) else {
            continue;
        };
        let reach = crushed_mm + data.pane.rim_tolerance();
        let has_begun = !time.is_finite()
            || network.grown_at(time).any(|(_, [x, y, ..])| {
                let (x, y) = (x - impact.x, y - impact.y);
                x * x + y * y <= 9.0 * reach * reach
            });
        if !has_begun {
            continue;
        }
        let mut patch = Patch {
            from,
            middle: [impact.x, impact.y],
            rng: seed.stream(Stream::CrackRelief, k),
            fallen: &fallen,
            facets,
        };
        let [low, high] = from.sheet.ply_mm(0);
        let beyond = |times: f64, most: f64| {
            crushed_mm + (crushed_mm * (times - 1.0)).min(most * (high - low))
        };
        let film_mm = beyond(surface.film, MOST_BEYOND[1]);
        patch.film([crushed_mm, film_mm], surface.film_um);
        let chip_mm = beyond(surface.chip, MOST_BEYOND[0]);
        patch.shells([crushed_mm, chip_mm], surface.chip_slope_deg.to_radians());
        patch.crushed(crushed_mm * surface.crushed_zone);
    }
}

/// Radius over the mean radius, all around: waves of falling size.
struct Ragged([[f64; 2]; N_WAVES as usize]);

impl Ragged {
    fn at(&self, angle: f64) -> f64 {
        let mut sum = 1.0;
        let mut order = 2.0;
        for [cosine, sine] in self.0 {
            let (sin, cos) = libm::sincos(order * angle);
            // The mean square of such a wave of even size is 1/6.
            sum += RAGGED * 2.2 / order.sqrt() * (cosine * cos + sine * sin);
            order += 1.0;
        }
        sum.max(0.3)
    }
}

/// A cell of a patch in polar coordinates: two directions, rad, and of each two radii, mm.
#[derive(Debug, Clone, Copy)]
struct PolarCell {
    radii: [[f64; 2]; 2],
    angles: [f64; 2],
}

/// A corner of grains, mm from the middle of a hit, and where it appears in the frame, px.
type Corner = ([f64; 2], Option<[f64; 2]>);

/// The surroundings of one hit.
struct Patch<'a, 'b> {
    from: &'a LightFrom<'b>,
    middle: [f64; 2],
    rng: ChaCha8Rng,
    fallen: &'a Fallen,
    facets: &'a mut Facets,
}

impl Patch<'_, '_> {
    /// Grains between the corners of a grid that is not regular.
    fn crushed(&mut self, radius: f64) {
        if radius <= 0.0 {
            return;
        }
        let sheet = self.from.sheet;
        let grain = (GRAIN * radius).clamp(GRAINS_MM[0], GRAINS_MM[1]);
        let px_per_mm = sheet.view().px_per_unit(self.middle).unwrap_or(0.0);
        let blur_px = sheet.blur_radius_px(self.middle, sheet.outer_mm());
        let least_px = (LEAST_OF_BLUR * blur_px.unwrap_or(0.0).abs()).max(LEAST_PX);
        let outermost = radius * (1.0 + 2.5 * RAGGED);
        let size = grain
            .max(least_px / px_per_mm.max(1e-9))
            .max(2.0 * outermost / MOST_CELLS)
            .min(radius);
        let in_grains = size / grain;
        let n_drawn = (in_grains * in_grains).clamp(1.0, MOST_DRAWN).round();
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
                    self.grain([a, b, c, d], middle, way, n_drawn);
                }
            }
            above = below;
            i += 1.0;
        }
    }

    /// How much shorter a way down the pane is seen than one across, at the hit: 1 or more.
    fn foreshortening(&self) -> f64 {
        let sheet = self.from.sheet;
        let seen = |by: [f64; 2]| {
            let at = [self.middle[0] + by[0], self.middle[1] + by[1]];
            let [u0, v0] = sheet.project(self.middle, sheet.outer_mm(), [0.0; 2])?;
            let [u, v] = sheet.project(at, sheet.outer_mm(), [0.0; 2])?;
            Some(((u - u0) * (u - u0) + (v - v0) * (v - v0)).sqrt())
        };
        match (seen([1.0, 0.0]), seen([0.0, 1.0])) {
            (Some(across), Some(down)) if down > 0.0 => (across / down).clamp(1.0, 3.0),
            _ => 1.0,
        }
    }

    /// A cell of the crushed zone, with its corners in the frame, a part of the way from its middle
    /// to its rim: the mean of some grains.
    fn grain(&mut self, corners: [[f64; 2]; 4], middle: [f64; 2], way: f64, n_drawn: f64) {
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
        let mut sent = Sent::default();
        let mut k = 0.0;
        while k < n_drawn {
            let one = self.one_grain(sight, way);
            sent.add(&one, 1.0 / n_drawn);
            k += 1.0;
        }
        let all = sent.lanes[..N_SHARES].iter().sum::<f64>();
        if all <= 0.0 {
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
            sent = self.from.mirror(&mirror);
            sent.tint = [0.0; 3];
        } else if kind < white + mirrors + turns {
            let normal = self.face(sight).normal;
            let inside = into_glass(sight, self.from.sheet.index);
            match out_of_glass(inside, normal, self.from.sheet.index) {
                Some(out) => {
                    let to = self.from.sheet.camera_from_sheet(out);
                    self.from.seen(&mut sent, to, 0.6 + 0.4 * strength);
                }
                None => sent.lanes[HELD] = 0.6 + 0.4 * strength,
            }
        } else if kind < white + mirrors + turns + holds {
            sent.lanes[HELD] = 0.5 + 0.5 * strength;
        }
        // All of them have some faces that may send the sun's light.
        for _ in 0..N_SPARKS {
            let spark = self.face(sight);
            sent.lanes[SUN] += SPARK_SHARE * self.from.sun_in(&spark);
        }
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

    /// Hollows like shells, whose sloping surface turns the line of sight outward, as the thicker
    /// side of a prism does.
    fn shells(&mut self, [inner, outer]: [f64; 2], slope_rad: f64) {
        let sheet = self.from.sheet;
        let depth = sheet.outer_mm();
        let n = sheet.index;
        for shell in 0..N_SHELLS {
            let is_chipped = self.uniform() < CHIPPED;
            let middle = (f64::from(shell) + self.uniform()) / f64::from(N_SHELLS) * TAU;
            let half = (0.3 + 0.5 * self.uniform()) * TAU / f64::from(N_SHELLS);
            let extent = (outer - inner) * (0.45 + 0.55 * self.uniform());
            if !is_chipped || extent <= 0.0 || slope_rad <= 0.0 {
                continue;
            }
            let [n_sectors, n_rings] = SHELL_CELLS;
            for sector in 0..n_sectors {
                let sides =
                    [sector, sector + 1].map(|k| 2.0 * f64::from(k) / f64::from(n_sectors) - 1.0);
                let angles = sides.map(|side| middle + half * side);
                // The outline of a shell is round.
                let bow = sides.map(|side| inner + extent * (1.0 - side * side).max(0.0).sqrt());
                for ring in 0..n_rings {
                    let way = [ring, ring + 1].map(|k| f64::from(k) / f64::from(n_rings));
                    let radii = bow.map(|far| way.map(|t| 0.7 * inner + (far - 0.7 * inner) * t));
                    let cell = PolarCell { radii, angles };
                    let (sin, cos) = libm::sincos(0.5 * (angles[0] + angles[1]));
                    let middle = self.place(cell.middle_mm(), (sin, cos));
                    let Some(sight) = sheet.sight(middle, [0.0; 2]) else {
                        continue;
                    };
                    let slope = slope_rad * (0.4 + 1.2 * 0.5 * (way[0] + way[1]));
                    let (across, up) = libm::sincos(slope);
                    // The surface falls towards the middle: its normal leans inward.
                    let normal = [-across * cos, -across * sin, up];
                    let Some(out) = out_of_glass(into_glass(sight, n), normal, n) else {
                        continue;
                    };
                    let mut sent = Sent::default();
                    self.from.seen(&mut sent, sheet.camera_from_sheet(out), 1.0);
                    self.add(cell, middle, depth, &sent);
                }
            }
        }
    }

    /// A film of air along the faces, thinning outward: it reflects the cabin, and rings of color
    /// run through it.
    fn film(&mut self, [inner, outer]: [f64; 2], thickest_um: f64) {
        if outer <= inner || thickest_um <= 0.0 {
            return;
        }
        // Somewhat below the face that was hit.
        let [low, high] = self.from.sheet.ply_mm(0);
        let depth = low + 0.8 * (high - low);
        let rim = self.ragged();
        let [n_sectors, n_rings] = FILM_CELLS;
        for sector in 0..n_sectors {
            let angles = [sector, sector + 1].map(|k| TAU * f64::from(k) / f64::from(n_sectors));
            let way_out = libm::sincos(0.5 * (angles[0] + angles[1]));
            let extents = angles
                .map(|angle| inner + (outer - inner) * (2.0 * rim.at(angle) - 1.2).clamp(0.0, 1.0));
            for ring in 0..n_rings {
                let way = [ring, ring + 1].map(|k| f64::from(k) / f64::from(n_rings));
                let radii = extents.map(|far| way.map(|t| inner + (far - inner) * t));
                let cell = PolarCell { radii, angles };
                let middle = self.place(cell.middle_mm(), way_out);
                let Some(sight) = self.from.sheet.sight(middle, [0.0; 2]) else {
                    continue;
                };
                let left = 1.0 - 0.5 * (way[0] + way[1]);
                let inside = into_glass(sight, self.from.sheet.index);
                let rgb = self
                    .from
                    .gaps
                    .rgb(inside[2], thickest_um * left * left.sqrt());
                let mean = (rgb[0] + rgb[1] + rgb[2]) / 3.0;
                let mut sent = Sent::default();
                self.from.before(sight).mirror_cabin(&mut sent, mean);
                sent.tint = rgb.map(|color| color - mean);
                self.add(cell, middle, depth, &sent);
            }
        }
    }

    /// A rim that is not round.
    fn ragged(&mut self) -> Ragged {
        let mut waves = [[0.0; 2]; N_WAVES as usize];
        for wave in &mut waves {
            let size = self.uniform();
            let (sin, cos) = libm::sincos(TAU * self.uniform());
            *wave = [size * cos, size * sin];
        }
        Ragged(waves)
    }

    /// A place so far from the middle, by the sine and the cosine of its direction.
    fn place(&self, radius: f64, (sin, cos): (f64, f64)) -> [f64; 2] {
        [self.middle[0] + radius * cos, self.middle[1] + radius * sin]
    }

    /// Adds a cell about a middle.
    fn add(&mut self, cell: PolarCell, middle: [f64; 2], depth_mm: f64, sent: &Sent) -> Option<()> {
        if self.fallen.is_at(middle) {
            return None;
        }
        let sheet = self.from.sheet;
        let ways = cell.angles.map(libm::sincos);
        let corner = |ring: usize, side: usize| {
            let place = self.place(cell.radii[side][ring], ways[side]);
            sheet.project(place, depth_mm, [0.0; 2])
        };
        let corners = [corner(0, 0)?, corner(1, 0)?, corner(1, 1)?, corner(0, 1)?];
        let radius_px = sheet.blur_radius_px(middle, depth_mm)?;
        self.facets.outlines.push(corners);
        // What is seen through a chip moves along with the place.
        self.facets
            .add(corners, radius_px, sent, [[1.0, 0.0], [0.0, 1.0]]);
        Some(())
    }

    /// A number in [0, 1).
    fn uniform(&mut self) -> f64 {
        f64::from(self.rng.next_u32()) / 4_294_967_296.0
    }
}

impl PolarCell {
    /// Mean of its radii, mm.
    fn middle_mm(&self) -> f64 {
        0.25 * self.radii.iter().flatten().sum::<f64>()
    }
}

/// A direction of the glass on its way in the air, through a surface with an outward normal.
fn out_of_glass(direction: [f64; 3], normal: [f64; 3], n: f64) -> Option<[f64; 3]> {
    crate::interface::fresnel::refract(direction, normal.map(|part| -part), n)
}
