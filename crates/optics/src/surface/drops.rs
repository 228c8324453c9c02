//! Drops of water on the outer face: lenses that show the scene small and upside down.

use std::f64::consts::TAU;

use starbreak_deposit::Cap;

use super::cracks::Facets;
use super::lobe::{FRAME, FRAME_U, FRAME_V, HELD, LightFrom, Sent};
use crate::interface::fresnel::reflectance;
use crate::vector::{Vector, dot};

/// Refractive index of water in visible light.
const WATER: f64 = 1.333;

/// Times that light is followed within a drop; what is left then is lost.
const MOST_BOUNCES: u32 = 5;

/// Rings of facets per px of a drop's radius, and how many there are.
const RINGS_PER_PX: f64 = 0.7;
const RINGS: [f64; 2] = [1.0, 32.0];

/// Least radius of a drop, px, whose facets show the scene as it moves across them, not one place each.
const SHOWN_PX: f64 = 2.5;

/// Least radius of a drop, px.
const LEAST_PX: f64 = 0.12;

/// Most facets of all drops together: of more drops each has fewer.
const MOST_FACETS: f64 = 1e6;

/// The facets of all drops that reach into the frame.
pub(crate) fn drop_facets(from: &LightFrom<'_>, caps: &[Cap], reach_px: f64, facets: &mut Facets) {
    let (width, height) = from.sheet.view().size();
    let frame = [f64::from(width), f64::from(height)];
    let seen: Vec<(Cap, [f64; 2], f64)> = caps
        .iter()
        .filter_map(|cap| {
            let middle = from
                .sheet
                .project(cap.at_mm, from.sheet.outer_mm(), [0.0; 2])?;
            let rim = [cap.at_mm[0] + cap.radius_mm, cap.at_mm[1]];
            let rim = from.sheet.project(rim, from.sheet.outer_mm(), [0.0; 2])?;
            let radius_px = libm::hypot(rim[0] - middle[0], rim[1] - middle[1]);
            let beyond = reach_px + radius_px;
            // Of a smaller one nothing is seen.
            if radius_px < LEAST_PX {
                return None;
            }
            let is_near = (0..2).all(|k| (-beyond..frame[k] + beyond).contains(&middle[k]));
            is_near.then_some((*cap, middle, radius_px))
        })
        .collect();
    let rings = |radius_px: f64| (RINGS_PER_PX * radius_px).clamp(RINGS[0], RINGS[1]);
    let n_facets: f64 = seen
        .iter()
        .map(|(_, _, radius_px)| 4.0 * rings(*radius_px) * rings(*radius_px))
        .sum();
    let fewer = (MOST_FACETS / n_facets.max(1.0)).sqrt().min(1.0);
    for (cap, middle, radius_px) in seen {
        let Some(blur_px) = from.sheet.blur_radius_px(cap.at_mm, from.sheet.outer_mm()) else {
            continue;
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some rings"
        )]
        let n_rings = (fewer * rings(radius_px)).ceil().max(1.0) as u32;
        let drop = Drop { cap, from };
        let is_shown = radius_px >= SHOWN_PX;
        drop.add((middle, blur_px), (n_rings, is_shown), facets);
    }
}

/// A drop before a camera.
struct Drop<'a> {
    cap: Cap,
    from: &'a LightFrom<'a>,
}

impl Drop<'_> {
    /// Rings of facets about the middle, of which each sees what its own middle sees.
    fn add(
        &self,
        (middle, blur_px): ([f64; 2], f64),
        (n_rings, is_shown): (u32, bool),
        facets: &mut Facets,
    ) {
        let n_sectors = (4 * n_rings).max(6);
        let around: Vec<[f64; 2]> = (0..n_sectors)
            .map(|k| {
                let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(n_sectors));
                [cos, sin]
            })
            .collect();
        let half_step = libm::sincos(0.5 * TAU / f64::from(n_sectors));
        let place = |share: f64, [x, y]: [f64; 2]| {
            [
                self.cap.at_mm[0] + share * self.cap.radius_mm * x,
                self.cap.at_mm[1] + share * self.cap.radius_mm * y,
            ]
        };
        let outer_mm = self.from.sheet.outer_mm();
        let project = |point| self.from.sheet.project(point, outer_mm, [0.0; 2]);
        // Thinner rings towards the rim, where light bends most; one ends where light along the normal of the glass begins
        // to be reflected totally.
        let total = (1.0 / (WATER * libm::sin(self.cap.contact_rad))).min(1.0);
        let ring_at = |ring: u32| {
            let share = |ring: u32| libm::sin(0.25 * TAU * f64::from(ring) / f64::from(n_rings));
            let is_last = ring < n_rings && share(ring) <= total && total < share(ring + 1);
            if is_last && ring > 0 {
                total
            } else {
                share(ring)
            }
        };
        let mut inner: Vec<Option<[f64; 2]>> = vec![Some(middle); around.len()];
        for ring in 1..=n_rings {
            let [low, high] = [ring_at(ring - 1), ring_at(ring)];
            let outer: Vec<Option<[f64; 2]>> =
                around.iter().map(|to| project(place(high, *to))).collect();
            for k in 0..around.len() {
                let next = (k + 1) % around.len();
                let (Some(a), Some(b), Some(c), Some(d)) =
                    (inner[k], outer[k], outer[next], inner[next])
                else {
                    continue;
                };
                let [x, y] = around[k];
                let between = [
                    x * half_step.1 - y * half_step.0,
                    x * half_step.0 + y * half_step.1,
                ];
                let at = |share: f64, to: [f64; 2]| self.seen(place(share, to));
                // A facet that shows more than one place starts from the mean of its corners, of which
                // the innermost has two in the middle.
                let share = if ring == 1 && is_shown {
                    0.5 * high
                } else {
                    (0.5 * (low * low + high * high)).sqrt()
                };
                let Some(sent) = at(share, between) else {
                    continue;
                };
                // How the place that is seen moves across the facet.
                let within = [low.max(0.15 * high), 0.98 * high + 0.02 * low];
                let moves = is_shown.then(|| self.moves(within, between)).flatten();
                facets.add([a, b, c, d], blur_px, &sent, moves.unwrap_or_default());
            }
            inner = outer;
        }
    }

    /// How the place of the frame that is seen moves with the place of the frame where it is seen, from four places about
    /// the middle of a facet between two shares of the radius; none where any of them sees nothing of the frame.
    fn moves(&self, [low, high]: [f64; 2], along: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        let middle = 0.5 * (low + high);
        let step = 0.25 * (high - low);
        let at = |right: f64, down: f64| {
            let point = [
                self.cap.at_mm[0] + self.cap.radius_mm * (middle * along[0] + right),
                self.cap.at_mm[1] + self.cap.radius_mm * (middle * along[1] + down),
            ];
            let sent = self.seen(point)?;
            let share = sent.lanes[FRAME];
            let own = self
                .from
                .sheet
                .project(point, self.from.sheet.outer_mm(), [0.0; 2])?;
            (share > 0.5).then(|| {
                (
                    own,
                    [sent.lanes[FRAME_U] / share, sent.lanes[FRAME_V] / share],
                )
            })
        };
        let [left, right] = [at(-step, 0.0)?, at(step, 0.0)?];
        let [up, down] = [at(0.0, -step)?, at(0.0, step)?];
        let slope = |a: ([f64; 2], [f64; 2]), b: ([f64; 2], [f64; 2]), axis: usize, k: usize| {
            (b.1[k] - a.1[k]) / (b.0[axis] - a.0[axis])
        };
        Some([0, 1].map(|k| [slope(left, right, 0, k), slope(up, down, 1, k)]))
    }

    /// What is seen through the drop at a place of the outer face, as a share of what bare glass would show there; the
    /// shares sum to 1. None where the place is not before the camera.
    fn seen(&self, at_mm: [f64; 2]) -> Option<Sent> {
        let sheet = self.from.sheet;
        let entry = sheet.entry(at_mm, sheet.outer_mm(), [0.0; 2])?;
        let sight = sheet.sight(entry, [0.0; 2])?;
        let [x, y] = [sight[0] / WATER, sight[1] / WATER];
        let mut ray = [x, y, (1.0 - x * x - y * y).sqrt()];
        let sphere = self.cap.sphere_mm();
        let center = [
            self.cap.at_mm[0],
            self.cap.at_mm[1],
            -sphere * libm::cos(self.cap.contact_rad),
        ];
        let mut at = [at_mm[0], at_mm[1], 0.0];
        let mut share = 1.0;
        let mut sent = Sent::default();
        for _ in 0..MOST_BOUNCES {
            // To the sphere, or before that to the glass.
            let out: Vector = std::array::from_fn(|k| at[k] - center[k]);
            let along = dot(out, ray);
            let to_sphere = -along
                + (along * along - dot(out, out) + sphere * sphere)
                    .max(0.0)
                    .sqrt();
            let to_glass = if ray[2] < 0.0 {
                -at[2] / ray[2]
            } else {
                f64::INFINITY
            };
            if to_glass < to_sphere {
                self.enters_cabin(&mut sent, sight, ray, share);
                return Some(sent);
            }
            at = std::array::from_fn(|k| at[k] + to_sphere * ray[k]);
            let normal: Vector = std::array::from_fn(|k| (at[k] - center[k]) / sphere);
            let cos = dot(ray, normal).clamp(0.0, 1.0);
            let mirrored = reflectance(cos, 1.0 / WATER);
            if mirrored < 1.0 {
                let cos_out = (1.0 - WATER * WATER * (1.0 - cos * cos)).max(0.0).sqrt();
                let leaves =
                    std::array::from_fn(|k| WATER * ray[k] + (cos_out - WATER * cos) * normal[k]);
                self.leaves(&mut sent, sight, leaves, share * (1.0 - mirrored));
            }
            share *= mirrored;
            if share < 1e-3 {
                break;
            }
            ray = std::array::from_fn(|k| ray[k] - 2.0 * cos * normal[k]);
        }
        sent.lanes[HELD] += share;
        Some(sent)
    }

    /// Light from outside, seen along a direction in the air. Bare glass has taken its outer face's share of what an image
    /// shows, and given the cabin's light for it.
    fn leaves(&self, sent: &mut Sent, sight: Vector, direction: Vector, share: f64) {
        if direction[2] <= 0.0 {
            // Through the glass beside the drop.
            self.from.cabin(sent, direction, share);
        } else {
            let n = self.from.sheet.index;
            let in_glass = (1.0 - (1.0 - sight[2] * sight[2]) / (n * n)).sqrt();
            let seen =
                share * (1.0 + reflectance(sight[2], n)) * (1.0 - reflectance(in_glass, WATER / n));
            let direction = self.from.sheet.camera_from_sheet(direction);
            self.from.seen(sent, direction, seen);
            self.from.mirrored_cabin(sent, sight, share - seen);
        }
    }

    /// Light that comes through the glass, seen along a direction in the water.
    fn enters_cabin(&self, sent: &mut Sent, sight: Vector, [x, y, _]: Vector, share: f64) {
        let [x, y] = [WATER * x, WATER * y];
        let square = x * x + y * y;
        if square >= 1.0 {
            // The inner face holds it.
            sent.lanes[HELD] += share;
        } else {
            let z = (1.0 - square).sqrt();
            let face = reflectance(z, self.from.sheet.index);
            self.from.cabin(sent, [x, y, -z], share * (1.0 - face));
            self.leaves(sent, sight, [x, y, z], share * face * (1.0 - face));
            self.from.cabin(sent, [x, y, -z], share * face * face);
        }
    }
}
