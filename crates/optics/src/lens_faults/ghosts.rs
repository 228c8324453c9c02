//! Ghosts: light that two faces of the lens mirror, one after the other, on its way to the sensor.

use std::f64::consts::PI;

use super::Optic;
use super::lamps::Lamp;
use crate::environment::{Rgb, of_colors};
use crate::maps::Pupil;
use crate::pyramid::Cells;

/// A face of a lens, from the front on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensFace {
    /// Radius, positive with its center behind it; infinity where it is flat. 0: it is the stop.
    pub radius: f64,
    /// Way to the next face; that of the last is not asked for.
    pub gap: f64,
    /// Refractive index of what is behind it.
    pub index: f64,
}

/// Images of the stop, thrown by lamps on the sensor by way of two faces.
///
/// Of rays that come from a direction θ and meet the front at height y the stop is met at A_s y + B_s θ, and the sensor at
/// A y + B θ, by matrices of the faces in their order on the way (\[Lee2013\]; paraxial). Of a lamp's light R_i R_j, times
/// what of the pupil comes through the stop this way, is spread over the image of the stop. Lengths are of any unit: they
/// are scaled to the focal length.
#[derive(Debug, Clone, PartialEq)]
pub struct Ghosts {
    /// Share of green light that each face mirrors.
    pub reflectance: f64,
    /// The faces and the stop, from the front on.
    pub faces: Vec<LensFace>,
}

/// One ghost of a lamp in a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ghost {
    /// Middle, in focal lengths per angle of the lamp: where it is on the sensor over where the lamp is.
    pub at: f64,
    /// Radius of the image of the stop, signed, in focal lengths.
    pub radius: f64,
    /// Share of the light of the pupil that comes through the stop this way, without what is mirrored.
    pub share: f64,
    /// Where its rays meet the front, over the angle.
    front: f64,
    /// How wide they are there, in focal lengths.
    front_radius: f64,
}

/// Radius of the front of the lens, in those of the pupil: nothing comes from beyond. FIT.
const FRONT: f64 = 1.3;

/// Farthest that a lamp may stand from the middle of the frame, in half diagonals: there a hood shades the lens. FIT.
pub(super) const FARTHEST: f64 = 1.5;

/// Radius from which a ghost is drawn in cells of [`CELL_PX`], px.
const LARGE_PX: f64 = 12.0;
const CELL_PX: u32 = 4;

/// A ghost that adds less than this to all pixels is not drawn.
const LEAST: f64 = 2e-5;

/// Light of red, green and blue that a face with a layer of a quarter of a green wavelength mirrors, over green: such a
/// layer leaves cos²(π/2 λ₀/λ) of what bare glass mirrors, here with a tenth of it left in green.
const COATED: Rgb = [1.21, 1.0, 1.72];

/// Slope and height of a ray.
#[derive(Debug, Clone, Copy)]
struct Ray {
    y: f64,
    u: f64,
}

impl Ghosts {
    /// Whether it changes nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.reflectance <= 0.0 || self.faces.len() < 2
    }

    /// Way from a face to the next; behind the last the sensor is where the lens makes its picture.
    fn gap(&self, face: usize) -> f64 {
        if face + 1 < self.faces.len() {
            self.faces[face].gap
        } else {
            0.0
        }
    }

    /// Index of what is before a face.
    fn before(&self, face: usize) -> f64 {
        match face {
            0 => 1.0,
            _ => self.faces[face - 1].index,
        }
    }

    /// A ray meets a face: n₂ u₂ = n₁ u₁ − y (n₂ − n₁)/R. Leftwards an index is negative.
    fn meets(&self, ray: Ray, face: usize, [before, behind]: [f64; 2]) -> Ray {
        let radius = self.faces[face].radius;
        if radius.abs() <= 0.0 {
            return ray;
        }
        Ray {
            u: (before * ray.u - ray.y * (behind - before) / radius) / behind,
            ..ray
        }
    }

    /// A ray through all faces, with the pairs of faces that mirror it, if any; calls with each meeting of the stop.
    fn trace(
        &self,
        mut ray: Ray,
        mirrors: Option<(usize, usize)>,
        mut at_stop: impl FnMut(Ray),
    ) -> Ray {
        let mut go = |ray: &mut Ray, faces: &mut dyn Iterator<Item = usize>, direction: f64| {
            for face in faces {
                let [before, behind] = [self.before(face), self.faces[face].index];
                if self.faces[face].radius.abs() <= 0.0 {
                    at_stop(*ray);
                }
                let (indices, gap) = if direction > 0.0 {
                    ([before, behind], self.gap(face))
                } else {
                    let gap = if face > 0 {
                        self.faces[face - 1].gap
                    } else {
                        0.0
                    };
                    ([-behind, -before], -gap)
                };
                *ray = self.meets(*ray, face, indices);
                ray.y += gap * ray.u;
            }
        };
        let last = self.faces.len();
        let Some((i, j)) = mirrors else {
            go(&mut ray, &mut (0..last), 1.0);
            return ray;
        };
        go(&mut ray, &mut (0..j), 1.0);
        let before = self.before(j);
        ray = self.meets(ray, j, [before, -before]);
        ray.y -= self.faces[j - 1].gap * ray.u;
        go(&mut ray, &mut (i + 1..j).rev(), -1.0);
        let behind = self.faces[i].index;
        ray = self.meets(ray, i, [-behind, behind]);
        ray.y += self.faces[i].gap * ray.u;
        go(&mut ray, &mut (i + 1..last), 1.0);
        ray
    }

    /// All ghosts of a lens of a focal ratio, in focal lengths, from those of the first face on.
    #[must_use]
    pub fn of_lens(&self, f_number: f64) -> Vec<Ghost> {
        let along = |mirrors, at_stop: &mut dyn FnMut(Ray)| {
            self.trace(Ray { y: 1.0, u: 0.0 }, mirrors, at_stop)
        };
        let across = |mirrors, at_stop: &mut dyn FnMut(Ray)| {
            self.trace(Ray { y: 0.0, u: 1.0 }, mirrors, at_stop)
        };
        // The lens as it works: y at the last face, from there to the focus, and the stop.
        let mut stop_height = 1.0;
        let parallel = along(None, &mut |ray| stop_height = ray.y);
        let focal = -1.0 / parallel.u;
        let to_sensor = -parallel.y / parallel.u;
        if !focal.is_finite() || focal.abs() <= 0.0 {
            return Vec::new();
        }
        let pupil = 0.5 * focal.abs() / f_number;
        let stop = pupil * stop_height.abs();
        let mirroring: Vec<usize> = (0..self.faces.len())
            .filter(|face| {
                let is_stop = self.faces[*face].radius.abs() <= 0.0;
                !is_stop && (self.before(*face) - self.faces[*face].index).abs() > 1e-6
            })
            .collect();
        let mut ghosts = Vec::new();
        for (k, i) in mirroring.iter().enumerate() {
            for j in &mirroring[k + 1..] {
                let mirrors = Some((*i, *j));
                let mut stops = Vec::new();
                let a = along(mirrors, &mut |ray| stops.push([ray.y, 0.0]));
                let mut k = 0;
                let b = across(mirrors, &mut |ray| {
                    stops[k][1] = ray.y;
                    k += 1;
                });
                let at_sensor = |ray: Ray| ray.y + to_sensor * ray.u;
                // The narrowest of its ways through the stop.
                let Some([a_s, b_s]) = stops
                    .into_iter()
                    .max_by(|one, other| one[0].abs().total_cmp(&other[0].abs()))
                else {
                    continue;
                };
                if a_s.abs() < 1e-9 {
                    continue;
                }
                let (front, front_radius) = (-b_s / a_s, (stop / a_s).abs().min(FRONT * pupil));
                ghosts.push(Ghost {
                    at: (at_sensor(a) * front + at_sensor(b)) / focal,
                    radius: at_sensor(a) * front_radius / focal,
                    share: (front_radius / pupil) * (front_radius / pupil),
                    front: front / focal,
                    front_radius: front_radius / focal.abs(),
                });
            }
        }
        ghosts
    }

    pub(super) fn over(&self, light: &mut [f32], n_colors: usize, optic: &Optic, lamps: &[Lamp]) {
        match n_colors {
            1 => self.colors_over::<1>(light, optic, lamps),
            _ => self.colors_over::<3>(light, optic, lamps),
        }
    }

    fn colors_over<const COLORS: usize>(&self, light: &mut [f32], optic: &Optic, lamps: &[Lamp]) {
        let ghosts = self.of_lens(optic.lens.f_number);
        let (width, height) = optic.size;
        let cells = (
            width.div_ceil(CELL_PX as usize),
            height.div_ceil(CELL_PX as usize),
        );
        let mut large = vec![0.0_f32; cells.0 * cells.1 * COLORS];
        let front = FRONT * 0.5 / optic.lens.f_number;
        let middle = optic.middle();
        for lamp in lamps {
            let from_middle = [0, 1].map(|k| lamp.at_px[k] - middle[k]);
            let angle = libm::hypot(from_middle[0], from_middle[1]) / optic.f_px;
            if angle * optic.f_px > FARTHEST * optic.half_diagonal_px() {
                continue;
            }
            for ghost in &ghosts {
                // Not from beside the front.
                if (ghost.front * angle).abs() > front + ghost.front_radius {
                    continue;
                }
                // As wide as the lamp's own image where that is larger.
                let radius_px = (ghost.radius * optic.f_px)
                    .abs()
                    .max(lamp.radius_px)
                    .max(1.0);
                let per_px = self.reflectance * self.reflectance * ghost.share
                    / (PI * radius_px * radius_px);
                let tint = of_colors::<COLORS>(std::array::from_fn(|k| {
                    COATED[k] * COATED[k] * lamp.light[k]
                }));
                #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
                let more = tint.map(|color| (per_px * f64::from(color)) as f32);
                if more.iter().all(|it| f64::from(*it) < LEAST) {
                    continue;
                }
                let at = [0, 1].map(|k| middle[k] + ghost.at * from_middle[k]);
                let is_large = radius_px >= LARGE_PX;
                let (buffer, size, per_cell) = if is_large {
                    (&mut large[..], cells, f64::from(CELL_PX))
                } else {
                    (&mut *light, optic.size, 1.0)
                };
                let disc = Disc {
                    at: at.map(|place| place / per_cell),
                    radius: (radius_px / per_cell).copysign(ghost.radius),
                    pupil: Pupil::of(&optic.lens),
                };
                disc.add::<COLORS>(buffer, size, more);
            }
        }
        if large.iter().any(|it| *it > 0.0) {
            let large = Cells::<COLORS>::of_cells(&large, cells, CELL_PX);
            large.add_to(light, width);
        }
    }
}

/// An image of the stop.
struct Disc {
    at: [f64; 2],
    /// Signed: below 0 it is upside down.
    radius: f64,
    pupil: Pupil,
}

impl Disc {
    /// Adds even light, with an edge of a cell.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "cells of a frame; below 0 is 0"
    )]
    fn add<const COLORS: usize>(
        &self,
        light: &mut [f32],
        size: (usize, usize),
        more: [f32; COLORS],
    ) {
        let corners = self.pupil.corners();
        let radius = self.radius.abs();
        let sign = self.radius.signum();
        let reach = 1.0
            + corners.iter().fold(radius, |most, [x, y]| {
                most.max(radius * libm::hypot(*x, *y))
            });
        let range = |k: usize, n: usize| {
            let from = (self.at[k] - reach).floor().max(0.0) as usize;
            let to = (self.at[k] + reach).ceil().max(0.0) as usize;
            from.min(n)..to.min(n)
        };
        // How far within each side, or within the circle.
        let sides: Vec<[f64; 3]> = (0..corners.len())
            .map(|k| {
                let ([x0, y0], [x1, y1]) = (corners[k], corners[(k + 1) % corners.len()]);
                let length = libm::hypot(x1 - x0, y1 - y0);
                let normal = [-(y1 - y0) / length, (x1 - x0) / length];
                [
                    sign * normal[0],
                    sign * normal[1],
                    -radius * (normal[0] * x0 + normal[1] * y0),
                ]
            })
            .collect();
        let columns = range(0, size.0);
        for y in range(1, size.1) {
            let dy = y as f64 + 0.5 - self.at[1];
            let within = |x: usize| {
                let dx = x as f64 + 0.5 - self.at[0];
                if sides.is_empty() {
                    return radius - libm::hypot(dx, dy);
                }
                (sides.iter())
                    .map(|[nx, ny, offset]| nx * dx + ny * dy + offset)
                    .fold(f64::INFINITY, f64::min)
            };
            let row = &mut light[y * size.0 * COLORS..][..size.0 * COLORS];
            let row = row.as_chunks_mut::<COLORS>().0;
            let mut edge = |x: usize| {
                let share = (within(x) + 0.5).clamp(0.0, 1.0) as f32;
                for c in 0..COLORS {
                    row[x][c] += share * more[c];
                }
                share
            };
            // Convex: from either side up to the first that is whole, and all between.
            let Some(first) = columns.clone().find(|x| edge(*x) >= 1.0) else {
                continue;
            };
            let last = (first + 1..columns.end).rev().find(|x| edge(*x) >= 1.0);
            for pixel in &mut row[first + 1..last.unwrap_or(first + 1)] {
                for c in 0..COLORS {
                    pixel[c] += more[c];
                }
            }
        }
    }
}
