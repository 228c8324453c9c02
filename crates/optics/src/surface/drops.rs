//! Drops of water on the outer face: lenses that show the scene small and upside down.

use std::f64::consts::TAU;
use std::ops::Range;

use starbreak_deposit::Cap;

use super::cracks::Facets;
use super::lobe::{Before, HELD, LANES, LightFrom, Sent};
use crate::interface::fresnel::reflectance;
use crate::maps::{Drawn, Speck, cells_per_px, has_specks};
use crate::vector::{Vector, dot};

/// Refractive index of water in visible light.
const WATER: f64 = 1.333;

/// Times that light is followed within a drop; what is left then is lost.
const MOST_BOUNCES: u32 = 5;

/// Least radius of a drop along its shorter side, in cells, for which it is drawn cell by cell: where it is smaller, and
/// where its blur is so wide that cells are coarse, it is made of facets, each of which shows one place.
const DRAWN_CELLS: f64 = 3.0;

/// Rings of facets per px of a drop's radius, and how many there are.
const RINGS_PER_PX: f64 = 0.7;
const RINGS: [f64; 2] = [1.0, 32.0];

/// Farthest from the middle, of the radius, that a cell at the rim looks.
const RIM: f64 = 0.995;

/// Least radius of a drop, px.
const LEAST_PX: f64 = 0.12;

/// Most facets of all drops that are made of them: of more drops each has fewer.
const MOST_FACETS: f64 = 1e6;

/// Drops before a camera: those that are drawn, those that are hardly larger than their blur, and facets of the others.
pub(crate) struct Drops<'a> {
    pub(crate) drawn: Vec<DrawnDrop<'a>>,
    pub(crate) specks: Vec<Speck<LANES>>,
    pub(crate) facets: Facets,
}

/// A drop that is to be made of facets.
struct Faceted<'a> {
    drop: Drop<'a>,
    /// Its middle in the frame and the radius of its blur, px.
    place: ([f64; 2], f64),
    radius_px: f64,
    is_speck: bool,
}

/// All drops that reach into the frame.
pub(crate) fn drops<'a>(from: &'a LightFrom<'a>, caps: &[Cap], reach_px: f64) -> Drops<'a> {
    let (width, height) = from.sheet.view().size();
    let frame = [f64::from(width), f64::from(height)];
    let seen: Vec<(Drop<'_>, [f64; 2], f64)> = caps
        .iter()
        .filter_map(|cap| {
            let drop = Drop::of(*cap, from)?;
            let middle = drop.appears(cap.at_mm)?;
            let rim = drop.appears([cap.at_mm[0] + cap.radius_mm, cap.at_mm[1]])?;
            let radius_px = libm::hypot(rim[0] - middle[0], rim[1] - middle[1]);
            let beyond = reach_px + radius_px;
            // Of a smaller one nothing is seen.
            if radius_px < LEAST_PX {
                return None;
            }
            let is_near = (0..2).all(|k| (-beyond..frame[k] + beyond).contains(&middle[k]));
            is_near.then_some((drop, middle, radius_px))
        })
        .collect();
    let (mut drawn, mut faceted) = (Vec::new(), Vec::new());
    for (drop, middle, radius_px) in seen {
        let outer_mm = from.sheet.outer_mm();
        let Some(blur_px) = from.sheet.blur_radius_px(drop.cap.at_mm, outer_mm) else {
            continue;
        };
        match drop.per_cell(cells_per_px(blur_px)) {
            Some(per_cell) if least_cells(per_cell) >= DRAWN_CELLS => {
                drawn.push(DrawnDrop::of(drop, blur_px, per_cell));
            }
            per_cell => faceted.push(Faceted {
                is_speck: per_cell.is_some() && has_specks(blur_px),
                drop,
                place: (middle, blur_px),
                radius_px,
            }),
        }
    }
    let rings = |radius_px: f64| (RINGS_PER_PX * radius_px).clamp(RINGS[0], RINGS[1]);
    let n_facets: f64 = faceted
        .iter()
        .map(|it| 4.0 * rings(it.radius_px) * rings(it.radius_px))
        .sum();
    let fewer = (MOST_FACETS / n_facets.max(1.0)).sqrt().min(1.0);
    let (mut specks, mut facets) = (Vec::new(), Facets::default());
    for it in faceted {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some rings"
        )]
        let n_rings = (fewer * rings(it.radius_px)).ceil().max(1.0) as u32;
        if it.is_speck {
            let mut own = Facets::default();
            it.drop.add(it.place, n_rings, &mut own);
            specks.push(own.light);
        } else {
            it.drop.add(it.place, n_rings, &mut facets);
        }
    }
    Drops {
        drawn,
        specks,
        facets,
    }
}

/// Radius of a drop along its shorter side, in cells, by [`Drop::per_cell`].
fn least_cells([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    // The inverse of the larger singular value.
    let (sum, determinant) = (a * a + b * b + c * c + d * d, a * d - b * c);
    let root = (sum * sum - 4.0 * determinant * determinant)
        .max(0.0)
        .sqrt();
    1.0 / (0.5 * (sum + root)).sqrt()
}

/// A drop before a camera.
struct Drop<'a> {
    cap: Cap,
    from: &'a LightFrom<'a>,
    /// Where the ray of sight to its middle enters the pane, mm, and how this moves across it, mm per mm.
    enters_mm: [f64; 2],
    moves: [[f64; 2]; 2],
    /// Radius of its sphere, and the middle of that, mm.
    sphere_mm: f64,
    center_mm: Vector,
}

/// What is the same for all light that is seen along a direction of sight before the glass.
struct Sight {
    /// The face towards the camera.
    before: Before,
    /// What passes from glass to water.
    passes: f64,
}

impl<'a> Drop<'a> {
    /// None where it is not before the camera.
    fn of(cap: Cap, from: &'a LightFrom<'a>) -> Option<Self> {
        let enters = |right_mm: f64, down_mm: f64| {
            let at = [cap.at_mm[0] + right_mm, cap.at_mm[1] + down_mm];
            from.sheet.entry(at, from.sheet.outer_mm(), [0.0; 2])
        };
        let enters_mm = enters(0.0, 0.0)?;
        let by = |other: [f64; 2]| [0, 1].map(|k| (other[k] - enters_mm[k]) / cap.radius_mm);
        let sphere_mm = cap.sphere_mm();
        let [x, y] = cap.at_mm;
        Some(Self {
            cap,
            from,
            enters_mm,
            sphere_mm,
            center_mm: [x, y, -sphere_mm * libm::cos(cap.contact_rad)],
            moves: [
                by(enters(cap.radius_mm, 0.0)?),
                by(enters(0.0, cap.radius_mm)?),
            ],
        })
    }

    /// Where the ray of sight to a place of the outer face enters the pane: a drop is so small that this is linear.
    fn enters_mm(&self, at_mm: [f64; 2]) -> [f64; 2] {
        let [x, y] = [0, 1].map(|k| at_mm[k] - self.cap.at_mm[k]);
        [0, 1].map(|k| self.enters_mm[k] + x * self.moves[0][k] + y * self.moves[1][k])
    }

    /// Change of the place on the pane, of its radius, per cell along x and along y; none beside the camera.
    fn per_cell(&self, per_px: f64) -> Option<[[f64; 2]; 2]> {
        let [[a, b], [c, d]] = self.from.sheet.view().jacobian(self.cap.at_mm)?;
        let per_px_of_pane = 1.0 / ((a * d - b * c) * per_px * self.cap.radius_mm);
        Some([[d, -c], [-b, a]].map(|row| row.map(|part| part * per_px_of_pane)))
    }

    /// Where a place of the outer face appears in the frame, px.
    fn appears(&self, at_mm: [f64; 2]) -> Option<[f64; 2]> {
        self.from.sheet.appears(self.enters_mm(at_mm), [0.0; 2])
    }

    /// Rings of facets about the middle, of which each sees what its own middle sees.
    fn add(&self, (middle, blur_px): ([f64; 2], f64), n_rings: u32, facets: &mut Facets) {
        let n_sectors = (4 * n_rings).max(6);
        let around: Vec<[f64; 2]> = (0..n_sectors)
            .map(|k| {
                let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(n_sectors));
                [cos, sin]
            })
            .collect();
        let half_step = libm::sincos(0.5 * TAU / f64::from(n_sectors));
        // So that a polygon has the area of its circle.
        let swell = (0.5 * TAU / f64::from(n_sectors) / (half_step.0 * half_step.1)).sqrt();
        let place = |share: f64, [x, y]: [f64; 2]| {
            [
                self.cap.at_mm[0] + share * self.cap.radius_mm * x,
                self.cap.at_mm[1] + share * self.cap.radius_mm * y,
            ]
        };
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
            let corner = |to: &[f64; 2]| self.appears(place(swell * high, *to));
            let outer: Vec<Option<[f64; 2]>> = around.iter().map(corner).collect();
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
                let share = (0.5 * (low * low + high * high)).sqrt();
                let at_mm = place(share, between);
                let sight = self.from.sheet.sight(self.enters_mm(at_mm), [0.0; 2]);
                if let Some(sight) = sight {
                    let sent = self.seen(at_mm, sight);
                    facets.add([a, b, c, d], blur_px, &sent, [[0.0; 2]; 2]);
                }
            }
            inner = outer;
        }
    }

    /// What is seen through the drop at a place of the outer face along a direction of sight before the glass, as a share
    /// of what bare glass would show there; the shares sum to 1.
    fn seen(&self, at_mm: [f64; 2], sight: Vector) -> Sent {
        let [x, y] = [sight[0] / WATER, sight[1] / WATER];
        let mut ray = [x, y, (1.0 - x * x - y * y).sqrt()];
        let (sphere, center) = (self.sphere_mm, self.center_mm);
        let sight = self.sight(sight);
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
                self.enters_cabin(&mut sent, &sight, ray, share);
                return sent;
            }
            at = std::array::from_fn(|k| at[k] + to_sphere * ray[k]);
            let normal: Vector = std::array::from_fn(|k| (at[k] - center[k]) / sphere);
            let cos = dot(ray, normal).clamp(0.0, 1.0);
            let mirrored = reflectance(cos, 1.0 / WATER);
            if mirrored < 1.0 {
                let cos_out = (1.0 - WATER * WATER * (1.0 - cos * cos)).max(0.0).sqrt();
                let leaves =
                    std::array::from_fn(|k| WATER * ray[k] + (cos_out - WATER * cos) * normal[k]);
                self.leaves(&mut sent, &sight, leaves, share * (1.0 - mirrored));
            }
            share *= mirrored;
            if share < 1e-3 {
                break;
            }
            ray = std::array::from_fn(|k| ray[k] - 2.0 * cos * normal[k]);
        }
        sent.lanes[HELD] += share;
        sent
    }

    fn sight(&self, sight: Vector) -> Sight {
        let n = self.from.sheet.index;
        let in_glass = (1.0 - (1.0 - sight[2] * sight[2]) / (n * n)).sqrt();
        Sight {
            before: self.from.before(sight),
            passes: 1.0 - reflectance(in_glass, WATER / n),
        }
    }

    /// Light from outside, seen along a direction in the air. Bare glass has taken its outer face's share of what an image
    /// shows, and given the cabin's light for it.
    fn leaves(&self, sent: &mut Sent, sight: &Sight, direction: Vector, share: f64) {
        if direction[2] <= 0.0 {
            // Through the glass beside the drop.
            self.from.cabin(sent, direction, share);
        } else {
            let seen = share * (1.0 + sight.before.reflects) * sight.passes;
            let direction = self.from.sheet.camera_from_sheet(direction);
            self.from.seen(sent, direction, seen);
            sight.before.mirror_cabin(sent, share - seen);
        }
    }

    /// Light that comes through the glass, seen along a direction in the water.
    fn enters_cabin(&self, sent: &mut Sent, sight: &Sight, [x, y, _]: Vector, share: f64) {
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

/// A drop that is drawn cell by cell, each of which shows what its middle shows.
pub(crate) struct DrawnDrop<'a> {
    drop: Drop<'a>,
    blur_px: f64,
    per_px: f64,
    columns: Range<i32>,
    rows: Range<i32>,
    /// As [`Drop::per_cell`].
    per_cell: [[f64; 2]; 2],
}

impl<'a> DrawnDrop<'a> {
    /// As far as it lies in the frame or its blur reaches into it.
    fn of(drop: Drop<'a>, blur_px: f64, per_cell: [[f64; 2]; 2]) -> Self {
        const AROUND: u32 = 16;
        let per_px = cells_per_px(blur_px);
        let view = drop.from.sheet.view();
        let outline = (0..AROUND).map(|k| {
            let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(AROUND));
            // Beyond the sides between these places.
            let radius_mm = 1.1 * drop.cap.radius_mm;
            drop.appears([0, 1].map(|k| drop.cap.at_mm[k] + radius_mm * [cos, sin][k]))
        });
        let none = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        let everywhere = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
        let spans = outline.fold(none, |spans, at| match at {
            Some(at) => [0, 1].map(|k| [spans[k][0].min(at[k]), spans[k][1].max(at[k])]),
            // Some of it lies beside the camera.
            None => everywhere,
        });
        let beyond_px = blur_px.abs() + 2.0 / per_px;
        let (width, height) = view.size();
        let [columns, rows] = [(0, width), (1, height)].map(|(k, n)| {
            let most = f64::from(n) + beyond_px;
            let [low, high] = spans[k].map(|px| per_px * px.clamp(-beyond_px, most));
            #[expect(clippy::cast_possible_truncation, reason = "cells of a frame")]
            let cells = (low.floor() as i32)..(high.ceil() as i32);
            cells
        });
        Self {
            drop,
            blur_px,
            per_px,
            columns,
            rows,
            per_cell,
        }
    }

    /// What a cell shows; none where it covers nothing of it.
    fn cell(&self, at: [i32; 2]) -> Option<[f32; LANES]> {
        let (sheet, cap) = (self.drop.from.sheet, &self.drop.cap);
        let px = at.map(|k| (f64::from(k) + 0.5) / self.per_px);
        let (at_mm, sight) = sheet.behind(px, sheet.outer_mm())?;
        let [right, down] = [0, 1].map(|k| (at_mm[k] - cap.at_mm[k]) / cap.radius_mm);
        let away = (right * right + down * down).sqrt();
        // The rim is as many cells away as it takes to come there by the fastest way; in the very middle the quotient is no
        // number, and all is covered.
        let [x, y] = self.per_cell.map(|[a, b]| (a * right + b * down) / away);
        let part = match (1.0 - away) / (x * x + y * y).sqrt() + 0.5 {
            part if part <= 0.0 => return None,
            part => part.min(1.0),
        };
        let inside_mm = (RIM / away).min(1.0) * cap.radius_mm;
        let at_mm = [
            cap.at_mm[0] + inside_mm * right,
            cap.at_mm[1] + inside_mm * down,
        ];
        let sent = self.drop.seen(at_mm, sight);
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let lanes = sent.lanes.map(|lane| (part * lane) as f32);
        Some(lanes)
    }
}

impl Drawn<LANES> for DrawnDrop<'_> {
    fn radius_px(&self) -> f64 {
        self.blur_px
    }

    fn rows(&self) -> Range<i32> {
        self.rows.clone()
    }

    fn row(&self, row: i32, add: &mut dyn FnMut(i32, [f32; LANES])) {
        for column in self.columns.clone() {
            if let Some(lanes) = self.cell([column, row]) {
                add(column, lanes);
            }
        }
    }
}
