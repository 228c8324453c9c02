//! Drops of water on the outer face: lenses that show the scene small and upside down.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use starbreak_deposit::Cap;

use super::lobe::{Before, HELD, LANES, LightFrom, Sent};
use crate::interface::fresnel::{reflectance, reflectance_at};
use crate::maps::{Drawn, add_arrays, cells_per_px};
use crate::vector::{Vector, dot};

/// Refractive index of water in visible light.
const WATER: f64 = 1.333;

/// Times that light is followed within a drop, and the least share of it that is; what is left then is lost.
const MOST_BOUNCES: u32 = 5;
const LEAST_SHARE: f64 = 1e-3;

/// Farthest from the middle, of the radius, that light is followed.
const RIM: f64 = 0.995;

/// Least radius of a drop, px.
const LEAST_PX: f64 = 0.12;

/// Least radius of a drop along its shorter side, in rays: where cells are wider, several rays share one, so many along a
/// side at most.
const LEAST_RAYS: f64 = 0.75;
const MOST_OF_CELL: u32 = 64;

/// Such a radius from which on it does not show where the rays lie.
const FEW_RAYS: f64 = 3.0;

/// All drops that reach into the frame.
pub(crate) fn drops<'a>(
    from: &'a LightFrom<'a>,
    caps: &[Cap],
    reach_px: f64,
) -> Vec<DrawnDrop<'a>> {
    let view = from.sheet.view();
    let (width, height) = view.size();
    let frame = [f64::from(width), f64::from(height)];
    let around: [[f64; 2]; 16] = std::array::from_fn(|k| {
        #[expect(clippy::cast_precision_loss, reason = "some directions")]
        let (sin, cos) = libm::sincos(TAU * k as f64 / 16.0);
        [cos, sin]
    });
    let drawn = |cap: &Cap| {
        let middle = view.project(cap.at_mm)?;
        let [[px_per_mm, _], _] = view.jacobian(cap.at_mm)?;
        let radius_px = px_per_mm * cap.radius_mm;
        let beyond = reach_px + radius_px;
        let is_near = (0..2).all(|k| (-beyond..frame[k] + beyond).contains(&middle[k]));
        // Of a smaller one nothing is seen.
        if radius_px < LEAST_PX || !is_near {
            return None;
        }
        DrawnDrop::of(Drop::of(*cap, from)?, &around)
    };
    caps.iter().filter_map(drawn).collect()
}

/// A drop before a camera.
struct Drop<'a> {
    cap: Cap,
    from: &'a LightFrom<'a>,
    /// Where the ray of sight to its middle enters the pane, mm, and how this moves across it, mm per mm.
    enters_mm: [f64; 2],
    moves: [[f64; 2]; 2],
    /// Its radius, and how far its middle lies behind that of its sphere, of the radius of that.
    sphere: [f64; 2],
}

/// A direction of sight before the glass, and what is the same for all light that is seen along it.
#[derive(Clone, Copy)]
struct Sight {
    /// Its parts in the plane of the pane.
    along: [f64; 2],
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
        let (sin, cos) = libm::sincos(cap.contact_rad);
        Some(Self {
            cap,
            from,
            enters_mm,
            sphere: [sin, cos],
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

    /// Where a place of the outer face appears in the frame, px.
    fn appears(&self, at_mm: [f64; 2]) -> Option<[f64; 2]> {
        self.from.sheet.appears(self.enters_mm(at_mm), [0.0; 2])
    }

    /// What is seen through the drop at a place of the outer face, of its radius from its middle, as a share of what bare
    /// glass would show there; the shares sum to 1.
    fn seen(&self, place: [f64; 2], sight: &Sight) -> Sent {
        let [x, y] = sight.along.map(|part| part * (1.0 / WATER));
        let mut ray = [x, y, (1.0 - x * x - y * y).sqrt()];
        // From the middle of the sphere, of its radius, of which the face cuts off what is before `face`.
        let [wide, face] = self.sphere;
        let mut at = [wide * place[0], wide * place[1], face];
        let mut share = 1.0;
        let mut sent = Sent::default();
        for _ in 0..MOST_BOUNCES {
            // To the sphere, or before that to the glass.
            let along = dot(at, ray);
            let to_sphere = (along * along - dot(at, at) + 1.0).max(0.0).sqrt() - along;
            let to_glass = if ray[2] < 0.0 {
                (face - at[2]) / ray[2]
            } else {
                f64::INFINITY
            };
            if to_glass < to_sphere {
                self.enters_cabin(&mut sent, sight, ray, share);
                return sent;
            }
            at = std::array::from_fn(|k| at[k] + to_sphere * ray[k]);
            let cos = dot(ray, at).clamp(0.0, 1.0);
            let square = 1.0 - WATER * WATER * (1.0 - cos * cos);
            if square > 0.0 {
                let cos_out = square.sqrt();
                let mirrored = reflectance_at([cos, cos_out], 1.0 / WATER);
                let leaves =
                    std::array::from_fn(|k| WATER * ray[k] + (cos_out - WATER * cos) * at[k]);
                self.leaves(&mut sent, sight, leaves, share * (1.0 - mirrored));
                share *= mirrored;
            }
            if share < LEAST_SHARE {
                break;
            }
            ray = std::array::from_fn(|k| ray[k] - 2.0 * cos * at[k]);
        }
        sent.lanes[HELD] += share;
        sent
    }

    fn sight(&self, [x, y, z]: Vector) -> Sight {
        let n = self.from.sheet.index;
        let in_glass = (1.0 - (1.0 - z * z) / (n * n)).sqrt();
        Sight {
            along: [x, y],
            before: self.from.before([x, y, z]),
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
            let again = share * face * (1.0 - face);
            self.from.cabin(sent, [x, y, -z], share - again);
            self.leaves(sent, sight, [x, y, z], again);
        }
    }
}

/// A drop that is drawn cell by cell, each of which shows what the middle of what it covers shows, or the mean of several
/// rays.
pub(crate) struct DrawnDrop<'a> {
    drop: Drop<'a>,
    blur_px: f64,
    /// Rays along one side of a cell, and per px.
    of_cell: u32,
    rays_per_px: f64,
    /// Rays that may meet it.
    columns: Range<i32>,
    rows: Range<i32>,
    /// Its middle, in rays.
    middle: [f64; 2],
    /// Change of the place on the pane, of its radius, per ray along x and along y, and how far from the middle, by that
    /// alone, a ray may meet it.
    per_ray: [[f64; 2]; 2],
    reach: f64,
    /// Of a cell that a ray has which stands for a whole one.
    share: f64,
    /// Of one that is seen under a small angle.
    narrow: Option<Narrow>,
}

/// A drop that is seen under so small an angle that places and directions change evenly across it.
struct Narrow {
    /// To its middle.
    sight: Sight,
    /// Change of its direction per ray along x and along y.
    per_ray: [[f64; 2]; 2],
}

/// Greatest such angle, rad: of radii along the longer side.
const NARROW_RAD: f64 = 0.006;

impl<'a> DrawnDrop<'a> {
    /// As far as it lies in the frame or its blur reaches into it, by some directions around it; none beside the camera.
    fn of(drop: Drop<'a>, around: &[[f64; 2]]) -> Option<Self> {
        let sheet = drop.from.sheet;
        let blur_px = sheet.blur_radius_px(drop.cap.at_mm, sheet.outer_mm())?;
        let middle = drop.appears(drop.cap.at_mm)?;
        let behind = |px: [f64; 2]| sheet.behind(px, sheet.outer_mm());
        let (at_mm, sight) = behind(middle)?;
        let [along_x, along_y] = [
            behind([middle[0] + 1.0, middle[1]])?,
            behind([middle[0], middle[1] + 1.0])?,
        ];
        let per_px = [along_x, along_y]
            .map(|(at, _)| [0, 1].map(|k| (at[k] - at_mm[k]) / drop.cap.radius_mm));
        let cells_per_px = cells_per_px(blur_px);
        let radius_px = least_radius(per_px);
        let mut of_cell = 1;
        while f64::from(of_cell) * cells_per_px * radius_px < LEAST_RAYS && of_cell < MOST_OF_CELL {
            of_cell *= 2;
        }
        let rays_per_px = f64::from(of_cell) * cells_per_px;
        let per_ray = per_px.map(|place| place.map(|part| part / rays_per_px));
        let Outline {
            reach,
            widest_px,
            spans_px,
        } = Outline::of(&drop, around, (middle, &per_px));
        let rays = |low: f64, high: f64| {
            // Half a ray beyond its outline is still among what a ray stands for.
            let [low, high] = [low * rays_per_px - 0.5, high * rays_per_px + 0.5];
            #[expect(clippy::cast_possible_truncation, reason = "`as` clamps")]
            let rays = (low.floor() as i32)..(high.ceil() as i32);
            rays
        };
        let [columns, rows] = spans_px.map(|[low, high]| rays(low, high));
        let narrow = (widest_px < NARROW_RAD * sheet.f_px()).then(|| Narrow {
            sight: drop.sight(sight),
            per_ray: [along_x, along_y]
                .map(|(_, to)| [0, 1].map(|k| (to[k] - sight[k]) / rays_per_px)),
        });
        let mut drawn = Self {
            middle: middle.map(|px| rays_per_px * px),
            // With half a ray.
            reach: reach + 0.5 / least_radius(per_ray),
            share: 1.0 / f64::from(of_cell * of_cell),
            per_ray,
            narrow,
            drop,
            blur_px,
            of_cell,
            rays_per_px,
            columns,
            rows,
        };
        if least_radius(per_ray) < FEW_RAYS && drawn.narrow.is_some() {
            drawn.share *= drawn.rays_per_part();
        }
        let beyond_px = blur_px.abs() + 2.0 / cells_per_px;
        let (width, height) = sheet.view().size();
        let seen = |all: &Range<i32>, n: u32| {
            let most = rays(-beyond_px, f64::from(n) + beyond_px);
            all.start.max(most.start)..all.end.min(most.end)
        };
        drawn.columns = seen(&drawn.columns, width);
        drawn.rows = seen(&drawn.rows, height);
        Some(drawn)
    }

    /// The place that a ray looks at as far as that changes evenly; none of nearly all rays that do not meet the drop.
    fn place(&self, at: [i32; 2]) -> Option<[f64; 2]> {
        let place = straight(&self.per_ray, self.from_middle(at));
        let square = place[0] * place[0] + place[1] * place[1];
        (square < self.reach * self.reach).then_some(place)
    }

    fn from_middle(&self, at: [i32; 2]) -> [f64; 2] {
        [0, 1].map(|k| f64::from(at[k]) + 0.5 - self.middle[k])
    }

    /// The place that a ray looks at, of the drop's radius from its middle, and the direction of sight.
    fn behind(&self, at: [i32; 2]) -> Option<([f64; 2], Sight)> {
        let place = self.place(at)?;
        let (cap, sheet) = (&self.drop.cap, self.drop.from.sheet);
        match &self.narrow {
            Some(Narrow { sight, per_ray }) => {
                let [x, y] = straight(per_ray, self.from_middle(at));
                let along = [sight.along[0] + x, sight.along[1] + y];
                Some((place, Sight { along, ..*sight }))
            }
            None => {
                let px = at.map(|k| (f64::from(k) + 0.5) / self.rays_per_px);
                let (at_mm, sight) = sheet.behind(px, sheet.outer_mm())?;
                let place = [0, 1].map(|k| (at_mm[k] - cap.at_mm[k]) / cap.radius_mm);
                Some((place, self.drop.sight(sight)))
            }
        }
    }

    /// How much of its cell a ray stands for that looks at a place, and where the middle of that is, of the way to the place.
    fn part(&self, [right, down]: [f64; 2]) -> Option<[f64; 2]> {
        let away = (right * right + down * down).sqrt().max(1e-9);
        // The rim is as many rays away as it takes to come there by the fastest way. Over all places that the rays may have,
        // this covers π (ρ² + 1/12) of a circle of ρ rays, hence the smaller one.
        let [x, y] = self.per_ray.map(|[a, b]| (a * right + b * down) / away);
        let square = x * x + y * y;
        let (rim, of_ray) = ((1.0 - square / 12.0).max(0.0).sqrt(), square.sqrt());
        let part = ((rim - away) / of_ray + 0.5).min(1.0);
        let inside = away.min(1.0 - 0.5 * part * of_ray).min(RIM).max(0.0);
        (part > 0.0).then_some([part, inside / away])
    }

    /// How many rays it is large, over what they stand for together: where there are few, that is how their places have it.
    fn rays_per_part(&self) -> f64 {
        let rays = (self.rows.clone()).flat_map(|y| self.columns.clone().map(move |x| [x, y]));
        let parts = rays.filter_map(|at| {
            let [part, _] = self.part(self.place(at)?)?;
            Some(part)
        });
        let [[a, b], [c, d]] = self.per_ray;
        PI / (a * d - b * c).abs() / parts.sum::<f64>().max(1e-3)
    }

    /// What a ray shows; none where it stands for nothing of the drop.
    fn ray(&self, at: [i32; 2]) -> Option<[f32; LANES]> {
        let (place, sight) = self.behind(at)?;
        let [part, inside] = self.part(place)?;
        let sent = self.drop.seen(place.map(|k| inside * k), &sight);
        let share = self.share * part;
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let lanes = sent.lanes.map(|lane| (share * lane) as f32);
        Some(lanes)
    }

    /// The rays of a cell together.
    fn cell(&self, column: i32, row: i32) -> Option<[f32; LANES]> {
        if self.of_cell == 1 {
            return self.ray([column, row]);
        }
        let [columns, rows] = [(column, &self.columns), (row, &self.rows)].map(|(cell, all)| {
            let first = cell * self.of_cell.cast_signed();
            first.max(all.start)..(first + self.of_cell.cast_signed()).min(all.end)
        });
        let mut sum = None;
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            if let Some(lanes) = self.ray([x, y]) {
                sum = Some(add_arrays(sum.unwrap_or([0.0; LANES]), lanes));
            }
        }
        sum
    }

    /// The cells of some rays.
    fn cells(&self, rays: &Range<i32>) -> Range<i32> {
        let of_cell = self.of_cell.cast_signed();
        rays.start.div_euclid(of_cell)..(rays.end - 1).div_euclid(of_cell) + 1
    }
}

/// What a drop reaches to.
struct Outline {
    /// How far from its middle, of its radius, by the change of the place about its middle alone.
    reach: f64,
    /// The same in px, and from where to where across and down.
    widest_px: f64,
    spans_px: [[f64; 2]; 2],
}

impl Outline {
    /// By some directions around a drop, and its middle and the change of the place, of its radius, per px along x and
    /// along y.
    fn of(
        drop: &Drop<'_>,
        around: &[[f64; 2]],
        (middle, per_px): ([f64; 2], &[[f64; 2]; 2]),
    ) -> Self {
        let mut outline = Self {
            reach: 0.0,
            widest_px: 0.0,
            spans_px: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
        };
        // Beyond the sides between these places.
        let radius_mm = 1.1 * drop.cap.radius_mm;
        for to in around {
            let Some(at) = drop.appears([0, 1].map(|k| drop.cap.at_mm[k] + radius_mm * to[k]))
            else {
                // Some of it lies beside the camera: it may be everywhere.
                return Self {
                    reach: f64::INFINITY,
                    widest_px: f64::INFINITY,
                    spans_px: [[f64::NEG_INFINITY, f64::INFINITY]; 2],
                };
            };
            let px = [0, 1].map(|k| at[k] - middle[k]);
            let [away, px] = [straight(per_px, px), px].map(|[x, y]| libm::hypot(x, y));
            outline.reach = outline.reach.max(away);
            outline.widest_px = outline.widest_px.max(px);
            for (span, at) in outline.spans_px.iter_mut().zip(at) {
                *span = [span[0].min(at), span[1].max(at)];
            }
        }
        outline
    }
}

/// What is some steps away, by the change per step along x and along y.
fn straight([along_x, along_y]: &[[f64; 2]; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| x * along_x[k] + y * along_y[k])
}

/// Steps to the rim of a drop along its shorter side, by the change of the place, of its radius, per step.
fn least_radius([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    // The inverse of the larger singular value.
    let (sum, determinant) = (a * a + b * b + c * c + d * d, a * d - b * c);
    let root = (sum * sum - 4.0 * determinant * determinant)
        .max(0.0)
        .sqrt();
    1.0 / (0.5 * (sum + root)).sqrt()
}

impl Drawn<LANES> for DrawnDrop<'_> {
    fn radius_px(&self) -> f64 {
        self.blur_px
    }

    fn rows(&self) -> Range<i32> {
        self.cells(&self.rows)
    }

    fn row(&self, row: i32, add: &mut dyn FnMut(i32, [f32; LANES])) {
        for column in self.cells(&self.columns) {
            if let Some(lanes) = self.cell(column, row) {
                add(column, lanes);
            }
        }
    }
}
