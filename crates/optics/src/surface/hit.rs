//! What a stone leaves where it hit: crushed glass, the shell that chips off, a film of air.

use std::f64::consts::TAU;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use starbreak_glass::{CrackNetwork, LengthUnit, Seed, Stream};

use super::cracks::{Facets, add_tint};
use super::lobe::{CABIN, LANES, LightFrom, Sent, into_glass};
use crate::maps::Facet;
use crate::physical::SurfaceParams;

/// Sectors of a patch around a hit.
const N_SECTORS: u32 = 12;

/// Rings of the crushed zone, of the shell, and of the film, which has fringes.
const N_RINGS: [u32; 3] = [4, 3, 6];

/// Share of the crushed zone that is white at its middle, and at its rim. FIT.
const WHITE: [f64; 2] = [0.95, 0.35];

/// Share of the sectors of which the shell has come off. FIT.
const CHIPPED: f64 = 0.55;

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
            facets,
        };
        let crushed = crushed_mm * surface.crushed_zone;
        patch.film(crushed_mm, crushed_mm * surface.film, surface.film_um);
        patch.shell(
            crushed_mm,
            crushed_mm * surface.chip,
            surface.chip_slope_deg.to_radians(),
        );
        patch.crushed(crushed);
    }
}

/// A cell of a patch in polar coordinates: radii, mm, and directions, rad.
#[derive(Debug, Clone, Copy)]
struct PolarCell {
    radii: [f64; 2],
    angles: [f64; 2],
}

/// The surroundings of one hit.
struct Patch<'a, 'b> {
    from: &'a LightFrom<'b>,
    middle: [f64; 2],
    rng: ChaCha8Rng,
    facets: &'a mut Facets,
}

impl Patch<'_, '_> {
    /// White grains: light from both sides, scattered evenly to both.
    fn crushed(&mut self, radius: f64) {
        let n_rings = N_RINGS[0];
        for ring in 0..n_rings {
            let radii = [ring, ring + 1].map(|k| radius * f64::from(k) / f64::from(n_rings));
            let way = (f64::from(ring) + 0.5) / f64::from(n_rings);
            let white = WHITE[0] + (WHITE[1] - WHITE[0]) * way * way;
            for sector in 0..N_SECTORS {
                let grain = 0.6 + 0.8 * self.uniform();
                let share = (white * grain).min(1.0);
                let mut sent = Sent::default();
                self.from.diffuse(&mut sent, share);
                self.add(cell(radii, sector), self.from.sheet.thickness_mm, &sent);
            }
        }
    }

    /// Hollows like shells, whose sloping surface turns the line of sight outward, as the thicker
    /// side of a prism does.
    fn shell(&mut self, inner: f64, outer: f64, slope_rad: f64) {
        if outer <= inner || slope_rad <= 0.0 {
            return;
        }
        let depth = self.from.sheet.thickness_mm;
        let n = self.from.sheet.index;
        for sector in 0..N_SECTORS {
            let is_chipped = self.uniform() < CHIPPED;
            let extent = outer - (outer - inner) * 0.6 * self.uniform();
            if !is_chipped {
                continue;
            }
            for ring in 0..N_RINGS[1] {
                let way = [ring, ring + 1].map(|k| f64::from(k) / f64::from(N_RINGS[1]));
                let radii = way.map(|t| inner + (extent - inner) * t);
                let cell = cell(radii, sector);
                let Some(sight) = self.from.sheet.sight(self.place(cell.middle()), [0.0; 2]) else {
                    continue;
                };
                let slope = slope_rad * 0.5 * (way[0] + way[1]);
                let (sin, cos) = libm::sincos(0.5 * (cell.angles[0] + cell.angles[1]));
                let tangent = libm::tan(slope);
                // The surface falls towards the middle: its normal leans inward.
                let length = (1.0 + tangent * tangent).sqrt();
                let normal = [
                    -tangent * cos / length,
                    -tangent * sin / length,
                    1.0 / length,
                ];
                let Some(out) = out_of_glass(into_glass(sight, n), normal, n) else {
                    continue;
                };
                let mut sent = Sent::default();
                self.from
                    .seen(&mut sent, self.from.sheet.camera_from_sheet(out), 1.0);
                self.add(cell, depth, &sent);
            }
        }
    }

    /// A film of air along the faces, thinning outward: it reflects the cabin, and rings of color
    /// run through it.
    fn film(&mut self, inner: f64, outer: f64, thickest_um: f64) {
        if outer <= inner || thickest_um <= 0.0 {
            return;
        }
        // Somewhat below the face that was hit.
        let depth = 0.8 * self.from.sheet.thickness_mm;
        for sector in 0..N_SECTORS {
            let extent = outer - (outer - inner) * 0.5 * self.uniform();
            for ring in 0..N_RINGS[2] {
                let way = [ring, ring + 1].map(|k| f64::from(k) / f64::from(N_RINGS[2]));
                let cell = cell(way.map(|t| inner + (extent - inner) * t), sector);
                let Some(sight) = self.from.sheet.sight(self.place(cell.middle()), [0.0; 2]) else {
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
                sent.lanes[CABIN] = mean;
                sent.tint = rgb.map(|color| color - mean);
                self.add(cell, depth, &sent);
            }
        }
    }

    fn place(&self, [radius, angle]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(angle);
        [self.middle[0] + radius * cos, self.middle[1] + radius * sin]
    }

    fn add(&mut self, cell: PolarCell, depth_mm: f64, sent: &Sent) -> Option<()> {
        let sheet = self.from.sheet;
        let corner = |radius: usize, angle: usize| {
            let place = self.place([cell.radii[radius], cell.angles[angle]]);
            sheet.project(place, depth_mm, [0.0; 2])
        };
        let corners = [corner(0, 0)?, corner(1, 0)?, corner(1, 1)?, corner(0, 1)?];
        let radius_px = sheet.blur_radius_px(self.place(cell.middle()), depth_mm)?;
        let share = sent.lanes[super::lobe::FRAME];
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let (lanes, share): ([f32; LANES], f32) =
            (sent.lanes.map(|lane| lane as f32), share as f32);
        self.facets.outlines.push(corners);
        self.facets.light.push(Facet {
            corners,
            lanes,
            // What is seen through a chip moves along with the place.
            lean: [[share, 0.0], [0.0, share]],
            radius_px,
        });
        add_tint(self.facets, corners, radius_px, sent.tint, 1.0);
        Some(())
    }

    /// A number in [0, 1).
    fn uniform(&mut self) -> f64 {
        f64::from(self.rng.next_u32()) / 4_294_967_296.0
    }
}

impl PolarCell {
    fn middle(&self) -> [f64; 2] {
        [
            0.5 * (self.radii[0] + self.radii[1]),
            0.5 * (self.angles[0] + self.angles[1]),
        ]
    }
}

fn cell(radii: [f64; 2], sector: u32) -> PolarCell {
    PolarCell {
        radii,
        angles: [sector, sector + 1].map(|k| TAU * f64::from(k) / f64::from(N_SECTORS)),
    }
}

/// A direction of the glass on its way in the air, through a surface with an outward normal.
fn out_of_glass(direction: [f64; 3], normal: [f64; 3], n: f64) -> Option<[f64; 3]> {
    crate::interface::fresnel::refract(direction, normal.map(|part| -part), n)
}
