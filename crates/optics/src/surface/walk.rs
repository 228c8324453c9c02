//! Light on its way among several surfaces in the sheet.

use super::lobe::{Before, HELD, LightFrom, Mirror, Sent, into_glass};
use super::walls::Walls;
use crate::vector::{Vector, dot};

/// The walls around one of them.
#[derive(Debug)]
pub(super) struct Among<'a> {
    pub(super) walls: &'a Walls,
    /// Those within `reach_mm` of it.
    pub(super) near: Vec<u32>,
    pub(super) reach_mm: f64,
    /// Its crack and its place along that.
    pub(super) own: (u32, u32),
}

/// Light that walls and faces throw to and fro is followed for so many turns, and over this many
/// thicknesses of the sheet; what has not left by then is held.
const MOST_TURNS: u32 = 8;
const MOST_THICKNESSES: f64 = 4.0;

/// A face that mirrors less is taken to mirror nothing back to a wall.
const MUCH_MIRRORED: f64 = 0.1;

/// A smaller share of light is not followed.
const LEAST_FOLLOWED: f64 = 0.03;

impl LightFrom<'_> {
    /// What is seen in a surface whose light comes by way of other walls, as if all were smooth;
    /// none where it meets no other.
    pub(super) fn mirror_among(
        &self,
        mirror: &Mirror,
        (at, among): (Vector, &Among<'_>),
    ) -> Option<Sent> {
        let sight = into_glass(mirror.sight, self.sheet.index);
        let cos = dot(sight, mirror.normal);
        let direction: Vector = std::array::from_fn(|k| sight[k] - 2.0 * cos * mirror.normal[k]);
        self.meets_another((at, among), direction)?;
        let rgb = self.gaps.rgb(cos.abs(), mirror.gap_um);
        let mean = (rgb[0] + rgb[1] + rgb[2]) / 3.0;
        let mut sent = Sent {
            tint: rgb.map(|color| color - mean),
            ..Sent::default()
        };
        let before = self.before(mirror.sight);
        before.mirror_cabin(&mut sent.lanes, mean * before.reflects);
        let share = mean * (1.0 - before.reflects);
        self.trace(&mut sent, &before, (at, among), direction, share);
        Some(sent)
    }

    /// Whether a direction leads to a wall, or back to one by way of a face that holds it or
    /// mirrors much of it.
    fn meets_another(&self, (at, among): (Vector, &Among<'_>), direction: Vector) -> Option<()> {
        let [x, y, z] = direction;
        let outer_mm = self.sheet.outer_mm();
        let face_mm = if z > 0.0 { outer_mm } else { 0.0 };
        let to_face_mm = (face_mm - at[2]) / z;
        let most_mm = to_face_mm.min(MOST_THICKNESSES * outer_mm);
        let is_near = most_mm * (x * x + y * y).sqrt() <= among.reach_mm;
        let met = if is_near {
            among.walls.first_of(&among.near, at, direction, most_mm)
        } else {
            among.walls.first(at, direction, most_mm, Some(among.own))
        };
        if met.is_some() {
            return Some(());
        }
        if self.face_reflects(direction) < MUCH_MIRRORED {
            return None;
        }
        let at: Vector = std::array::from_fn(|k| at[k] + most_mm * direction[k]);
        let left_mm = MOST_THICKNESSES * outer_mm - most_mm;
        let most_mm = left_mm.min(outer_mm / z.abs());
        let met = among.walls.first(at, [x, y, -z], most_mm, None);
        met.map(|_| ())
    }

    /// The same among other walls.
    fn trace(
        &self,
        sent: &mut Sent,
        before: &Before,
        (at, among): (Vector, &Among<'_>),
        direction: Vector,
        share: f64,
    ) {
        let outer_mm = self.sheet.outer_mm();
        let mut rays = vec![Ray {
            at,
            direction,
            share,
            own: Some(among.own),
            n_turns: 0,
            left_mm: MOST_THICKNESSES * outer_mm,
        }];
        while let Some(mut ray) = rays.pop() {
            let face_mm = if ray.direction[2] > 0.0 {
                outer_mm
            } else {
                0.0
            };
            let to_face_mm = (face_mm - ray.at[2]) / ray.direction[2];
            let most_mm = to_face_mm.min(ray.left_mm);
            if ray.n_turns > MOST_TURNS || most_mm.is_nan() {
                sent.lanes[HELD] += ray.share;
                continue;
            }
            let met = among.walls.first(ray.at, ray.direction, most_mm, ray.own);
            let (turned, reflects) = if let Some(met) = met {
                let cos = dot(ray.direction, met.wall.normal);
                let reflects = self.gaps.mean(cos.abs(), met.wall.gap_um);
                ray.go(met.way_mm);
                ray.own = Some((met.wall.crack, met.wall.along));
                let share = (1.0 - reflects) * ray.share;
                if share > LEAST_FOLLOWED {
                    rays.push(Ray { share, ..ray });
                } else {
                    sent.lanes[HELD] += share;
                }
                let normal = met.wall.normal;
                let turned = std::array::from_fn(|k| ray.direction[k] - 2.0 * cos * normal[k]);
                (turned, reflects)
            } else if to_face_mm > ray.left_mm {
                sent.lanes[HELD] += ray.share;
                continue;
            } else {
                let reflects = self.face_reflects(ray.direction);
                if reflects < 1.0 {
                    self.exit(sent, before, ray.direction, (1.0 - reflects) * ray.share);
                }
                ray.go(to_face_mm);
                ray.own = None;
                let [x, y, z] = ray.direction;
                ([x, y, -z], reflects)
            };
            let share = reflects * ray.share;
            if share > LEAST_FOLLOWED {
                rays.push(Ray {
                    direction: turned,
                    share,
                    ..ray
                });
            } else if self.is_held(turned) {
                sent.lanes[HELD] += share;
            } else {
                self.exit(sent, before, turned, share);
            }
        }
    }
}

/// Light on its way back through the sheet.
#[derive(Debug, Clone, Copy)]
struct Ray {
    at: Vector,
    direction: Vector,
    share: f64,
    own: Option<(u32, u32)>,
    n_turns: u32,
    /// How much farther it is followed, mm.
    left_mm: f64,
}

impl Ray {
    fn go(&mut self, way_mm: f64) {
        for (at, direction) in self.at.iter_mut().zip(self.direction) {
            *at += way_mm * direction;
        }
        self.left_mm -= way_mm;
        self.n_turns += 1;
    }
}
