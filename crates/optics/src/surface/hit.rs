//! What a stone leaves where it hit: crushed glass, the shell that chips off, a film of air.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use starbreak_glass::{CrackNetwork, LengthUnit};
use starbreak_seed::{Seed, Stream};

use super::chains::Fallen;
use super::cracks::Facets;
use super::grains::{AllGrains, LEAST_OF_BLUR, LEAST_PX};
use super::lobe::{HELD, LightFrom, Sent, into_glass};
use crate::interface::fresnel::refract;
use crate::surface::SurfaceParams;
use crate::vector::Vector;

/// By how much the rim of a patch is nearer or farther, of its radius (one standard deviation). FIT.
pub(super) const RAGGED: f64 = 0.09;

/// Waves around the rim of a patch.
const N_WAVES: u32 = 7;

/// Shells that may come off around a hit, and of which share one does in the mean of all sides. FIT.
const N_SHELLS: u32 = 5;
const CHIPPED: f64 = 0.5;

/// Of the flakes of a shell these shares let no light out, and are white. FIT to photographs of pits, black beside white.
const FLAKES: [f64; 2] = [0.2, 0.25];

/// A film of air spreads to one side of a hit, by so much to either side of that, rad. FIT: photographs show a patch of
/// colors, no rings all around.
const FILM_HALF_RAD: [f64; 2] = [0.5, 1.2];

/// Shells and films reach so many thicknesses of the ply beyond the crushed zone at most.
const MOST_BEYOND: [f64; 2] = [1.0, 2.0];

/// Most and least sectors and rings of a film, which has fringes; of a shell. There are fewer where cells would be
/// smaller than those of grains.
const FILM_CELLS: [[f64; 2]; 2] = [[16.0, 8.0], [6.0, 3.0]];
const SHELL_CELLS: [[f64; 2]; 2] = [[8.0, 6.0], [3.0, 2.0]];

/// Adds the surroundings of every hit that has left a pit at `time`, of which a crack has begun to run, within `reach_px`
/// of the frame.
pub(crate) fn hit_facets(
    from: &LightFrom<'_>,
    network: &CrackNetwork,
    time: f64,
    (surface, reach_px): (&SurfaceParams, f64),
    seed: Seed,
    facets: &mut Facets,
) {
    let data = network.data();
    if data.unit != LengthUnit::Mm {
        return;
    }
    let fallen = Fallen::of(network, time);
    let mut known = Vec::new();
    for (k, impact) in (0_u64..).zip(&data.impacts) {
        let [low, high] = from.sheet.ply_mm(0);
        let pit_mm = impact.pit_radius_mm(high - low);
        if pit_mm <= 0.0 {
            continue;
        }
        let around = [surface.crushed_zone, surface.chip, surface.film];
        let widest_mm = 2.0 * pit_mm * around.into_iter().fold(1.0, f64::max);
        let (view, at) = (from.sheet.view(), [impact.x, impact.y]);
        let Some(px_per_mm) = view.px_per_unit(at) else {
            continue;
        };
        let [x, y] = at;
        if (view.visible([x, y, x, y], reach_px + widest_mm * px_per_mm)).is_none() {
            continue;
        }
        let reach = pit_mm + data.pane.rim_tolerance();
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
            all: (seed, &mut known),
        };
        let beyond =
            |times: f64, most: f64| pit_mm + (pit_mm * (times - 1.0)).min(most * (high - low));
        // Where nothing was crushed there are no lateral cracks, and nothing came off.
        if impact.crushed_radius_mm.is_some_and(|radius| radius > 0.0) {
            let film_mm = beyond(surface.film, MOST_BEYOND[1]);
            patch.film([pit_mm, film_mm], surface.film_um);
            let chip_mm = beyond(surface.chip, MOST_BEYOND[0]);
            patch.shells([pit_mm, chip_mm], surface.chip_slope_deg.to_radians());
        }
        patch.crushed(pit_mm * surface.crushed_zone);
    }
}

/// Radius over the mean radius, all around: waves of falling size.
pub(super) struct Ragged([[f64; 2]; N_WAVES as usize]);

impl Ragged {
    pub(super) fn at(&self, angle: f64) -> f64 {
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

/// The surroundings of one hit.
pub(super) struct Patch<'a, 'b> {
    pub(super) from: &'a LightFrom<'b>,
    pub(super) middle: [f64; 2],
    pub(super) rng: ChaCha8Rng,
    pub(super) fallen: &'a Fallen,
    pub(super) facets: &'a mut Facets,
    /// Seed of all grains, and their means as far as they are known.
    pub(super) all: (Seed, &'a mut Vec<AllGrains>),
}

impl Patch<'_, '_> {
    /// Least size of cells, mm.
    pub(super) fn least_mm(&self) -> f64 {
        let sheet = self.from.sheet;
        let px_per_mm = sheet.view().px_per_unit(self.middle).unwrap_or(0.0);
        let blur_px = sheet.blur_radius_px(self.middle, sheet.outer_mm());
        let least_px = (LEAST_OF_BLUR * blur_px.unwrap_or(0.0).abs()).max(LEAST_PX);
        least_px / px_per_mm.max(1e-9)
    }

    /// Sectors and rings of something so long around and so wide, mm.
    fn n_cells(&self, sides_mm: [f64; 2], [most, least]: [[f64; 2]; 2]) -> [u32; 2] {
        let least_mm = self.least_mm();
        std::array::from_fn(|k| {
            let n = (sides_mm[k] / least_mm).clamp(least[k], most[k]);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a few"
            )]
            let n = n as u32;
            n
        })
    }

    /// How much shorter a way down the pane is seen than one across, at the hit: 1 or more.
    pub(super) fn foreshortening(&self) -> f64 {
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

    /// Hollows like shells, more of them on one side. Their floor is broken: most flakes of it slope and turn the line of
    /// sight outward, as the thicker side of a prism does; some are white, some let no light out.
    fn shells(&mut self, [inner, outer]: [f64; 2], slope_rad: f64) {
        let sheet = self.from.sheet;
        let depth = sheet.outer_mm();
        let side = TAU * self.uniform();
        for shell in 0..N_SHELLS {
            let middle = (f64::from(shell) + self.uniform()) / f64::from(N_SHELLS) * TAU;
            let is_chipped = self.uniform() < CHIPPED * (1.0 + libm::cos(middle - side));
            let half = (0.3 + 0.5 * self.uniform()) * TAU / f64::from(N_SHELLS);
            let extent = (outer - inner) * (0.45 + 0.55 * self.uniform());
            if !is_chipped || extent <= 0.0 || slope_rad <= 0.0 {
                continue;
            }
            // It begins in the crushed zone, and no farther within than its extent.
            let from_mm = (0.7 * inner).max(inner - extent);
            let [n_sectors, n_rings] =
                self.n_cells([2.0 * half * (inner + extent), extent], SHELL_CELLS);
            let sectors = self.uneven(n_sectors);
            for sides in sectors.windows(2) {
                let sides = [sides[0], sides[1]].map(|at| 2.0 * at - 1.0);
                let angles = sides.map(|side| middle + half * side);
                // The outline of a shell is round.
                let bow = sides.map(|side| inner + extent * (1.0 - side * side).max(0.0).sqrt());
                let rings = self.uneven(n_rings);
                for way in rings.windows(2) {
                    let way = [way[0], way[1]];
                    let radii = bow.map(|far| way.map(|t| from_mm + (far - from_mm) * t));
                    let cell = PolarCell { radii, angles };
                    let toward = 0.5 * (angles[0] + angles[1]);
                    let middle = self.place(cell.middle_mm(), libm::sincos(toward));
                    let Some(sight) = sheet.sight(middle, [0.0; 2]) else {
                        continue;
                    };
                    let sent = self.flake(sight, toward, slope_rad);
                    self.add(cell, middle, depth, &sent);
                }
            }
        }
    }

    /// What a flake of a shell's floor sends that lies in a direction from the middle, rad.
    fn flake(&mut self, sight: Vector, toward: f64, slope_rad: f64) -> Sent {
        let mut sent = Sent::default();
        let kind = self.uniform();
        if kind < FLAKES[0] {
            sent.lanes[HELD] = 0.5 + 0.5 * self.uniform();
        } else if kind < FLAKES[0] + FLAKES[1] {
            let share = 0.4 + 0.5 * self.uniform();
            self.from.diffuse(&mut sent, share);
        } else {
            let slope = slope_rad * (0.2 + 1.6 * self.uniform());
            let (sin, cos) = libm::sincos(toward + 2.0 * (self.uniform() - 0.5));
            let (across, up) = libm::sincos(slope);
            // The surface falls towards the middle: its normal leans inward.
            sent = self.through(sight, [-across * cos, -across * sin, up], 1.0);
        }
        sent
    }

    /// Such a share of what is seen through a face that looks outside; of what the glass holds, where nothing is.
    pub(super) fn through(&self, sight: Vector, normal: Vector, share: f64) -> Sent {
        let sheet = self.from.sheet;
        let mut sent = Sent::default();
        match refract(into_glass(sight, sheet.index), normal, sheet.index) {
            Some(out) => {
                (self.from).seen(&mut sent.lanes, sheet.camera_from_sheet(out), share);
            }
            None => sent.lanes[HELD] = share,
        }
        sent
    }

    /// Uneven steps from 0 to 1.
    fn uneven(&mut self, n: u32) -> Vec<f64> {
        let steps: Vec<f64> = (0..n).map(|_| 0.3 + self.uniform()).collect();
        let whole: f64 = steps.iter().sum();
        let mut at = 0.0;
        let ends = steps.iter().map(|step| {
            at += step / whole;
            at
        });
        [0.0].into_iter().chain(ends).collect()
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
        let toward = TAU * self.uniform();
        let half = FILM_HALF_RAD[0] + (FILM_HALF_RAD[1] - FILM_HALF_RAD[0]) * self.uniform();
        let [n_sectors, n_rings] = self.n_cells([2.0 * half * outer, outer - inner], FILM_CELLS);
        for sector in 0..n_sectors {
            let sides =
                [sector, sector + 1].map(|k| 2.0 * f64::from(k) / f64::from(n_sectors) - 1.0);
            let angles = sides.map(|side| toward + half * side);
            let way_out = libm::sincos(0.5 * (angles[0] + angles[1]));
            let extents = sides.map(|side| {
                let round = (1.0 - side * side).max(0.0).sqrt();
                let far = (2.0 * rim.at(toward + half * side) - 1.2).clamp(0.0, 1.0);
                inner + (outer - inner) * round * far
            });
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
                self.from.before(sight).mirror_cabin(&mut sent.lanes, mean);
                sent.tint = rgb.map(|color| color - mean);
                self.add(cell, middle, depth, &sent);
            }
        }
    }

    /// A rim that is not round.
    pub(super) fn ragged(&mut self) -> Ragged {
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
    pub(super) fn uniform(&mut self) -> f64 {
        f64::from(self.rng.next_u32()) / 4_294_967_296.0
    }
}

impl PolarCell {
    /// Mean of its radii, mm.
    fn middle_mm(&self) -> f64 {
        0.25 * self.radii.iter().flatten().sum::<f64>()
    }
}
