//! A star through each lamp: light that the edges of the aperture diffract.

use std::f64::consts::{PI, TAU};

use super::Optic;
use crate::environment::Rgb;
use crate::pyramid::Cells;

/// Diffraction by the edges of a polygon.
///
/// Each straight edge sends light across itself, to both sides, as the square of one over the angle. Of all light
/// P λ/(2π² A θ) is beyond an angle θ, with P the perimeter and A the area of the aperture: of a polygon 2 λ/(π² D θ),
/// with D the diameter of the circle in it. An even number of blades makes as many spikes, for opposite edges share them,
/// and an odd number twice as many. A spike is as thin as λ/L of an edge's length L, which is less than a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Star {
    /// Blades of the diaphragm, 3 to 24.
    pub blades: u32,
    /// Direction of the first corner from +x towards +y (down), rad.
    pub angle_rad: f64,
}

/// Where a spike begins, px: nearer light stays where it is.
const FROM_PX: f64 = 1.5;

/// Where it ends, px.
const TO_PX: f64 = 400.0;

/// Wavelengths that stand for red, green and blue, µm.
const WAVELENGTHS_UM: [f64; 3] = [0.61, 0.55, 0.465];

/// Most pixels that throw a star, times their spikes: of more the light is gathered in cells.
const MOST_SPIKES: usize = 60_000;

impl Star {
    /// Whether it changes nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.blades < 3
    }

    /// Directions of the spikes, rad.
    fn spikes(&self) -> Vec<f64> {
        let n = if self.blades.is_multiple_of(2) {
            self.blades
        } else {
            2 * self.blades
        };
        // Across the first edge, which begins at the first corner.
        let first = self.angle_rad + PI / f64::from(self.blades);
        (0..n)
            .map(|k| first + TAU * f64::from(k) / f64::from(n))
            .collect()
    }

    /// Share of a lamp's light of each color that is farther than so many px.
    #[must_use]
    pub fn beyond(&self, px: f64, optic: &Optic) -> [f64; 3] {
        // The circle in the polygon, of the area of the round pupil.
        let n = f64::from(self.blades);
        let tan = libm::tan(PI / n);
        let diameter_m = optic.lens.aperture_m() * (PI / (n * tan)).sqrt();
        WAVELENGTHS_UM
            .map(|um| (2.0 * um * 1e-6 * optic.f_px / (PI * PI * diameter_m * px)).min(1.0))
    }

    pub(super) fn over(&self, light: &mut [f32], n_colors: usize, optic: &Optic) {
        match n_colors {
            1 => self.colors_over::<1>(light, optic),
            _ => self.colors_over::<3>(light, optic),
        }
    }

    /// What is brighter than white gives its share to its star; of the rest nobody sees it.
    fn colors_over<const COLORS: usize>(&self, light: &mut [f32], optic: &Optic) {
        let (width, _) = optic.size;
        let mut lamps = Cells::<COLORS>::of(light, optic.size);
        for pixel in lamps.values_mut() {
            if pixel.iter().all(|value| *value <= 1.0) {
                *pixel = [0.0; COLORS];
            }
        }
        let spikes = self.spikes();
        let n_lit = |cells: &Cells<COLORS>| {
            cells
                .values()
                .filter(|it| it.iter().any(|value| *value > 0.0))
                .count()
        };
        if n_lit(&lamps) == 0 {
            return;
        }
        let [from, to] = [FROM_PX, TO_PX].map(|px| self.beyond(px, optic));
        let shares: Rgb = std::array::from_fn(|k| {
            #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
            let share = (from[k] - to[k]) as f32;
            share
        });
        let shares: [f32; COLORS] =
            std::array::from_fn(|k| shares[if COLORS == 1 { 1 } else { k }]);
        for (pixel, lamp) in light
            .as_chunks_mut::<COLORS>()
            .0
            .iter_mut()
            .zip(lamps.values())
        {
            for (k, value) in pixel.iter_mut().enumerate() {
                *value -= shares[k] * lamp[k];
            }
        }
        while n_lit(&lamps) * spikes.len() > MOST_SPIKES && lamps.size.0 > 8 {
            lamps = lamps.halved();
        }
        let mut star = vec![[0.0_f32; COLORS]; lamps.size.0 * lamps.size.1];
        let steps = steps(f64::from(lamps.per_cell));
        let per_spike = 1.0 / to_f32(spikes.len());
        let (columns, rows) = lamps.size;
        for (at, lamp) in lamps.values().enumerate() {
            if lamp.iter().all(|value| *value <= 0.0) {
                continue;
            }
            let sends: [f32; COLORS] = std::array::from_fn(|k| lamp[k] * shares[k] * per_spike);
            for angle in &spikes {
                let (sin, cos) = libm::sincos(*angle);
                for (away, share) in &steps {
                    let x = to_f64(at % columns) + away * cos;
                    let y = to_f64(at / columns) + away * sin;
                    splat::<COLORS>(
                        &mut star,
                        (columns, rows),
                        [x, y],
                        sends.map(|it| it * share),
                    );
                }
            }
        }
        let star = Cells::<COLORS>::of_cells(star.as_flattened(), lamps.size, lamps.per_cell);
        // A cell holds the mean of its pixels, so that light stays what it is.
        star.add_to(light, width);
    }
}

/// Places along a spike, in cells of a width, px, each with its share of the spike's light.
fn steps(per_cell: f64) -> Vec<(f64, f32)> {
    let within = |px: f64| 1.0 / FROM_PX - 1.0 / px;
    let all = within(TO_PX);
    let mut steps = Vec::new();
    let mut from_px = FROM_PX;
    while from_px < TO_PX {
        let to_px = (from_px + per_cell.max(0.5)).min(TO_PX);
        #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
        let share = ((within(to_px) - within(from_px)) / all) as f32;
        steps.push((0.5 * (from_px + to_px) / per_cell, share));
        from_px = to_px;
    }
    steps
}

/// Adds light at a place between the middles of cells; what is beyond the frame is lost.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "cells of a frame"
)]
fn splat<const COLORS: usize>(
    star: &mut [[f32; COLORS]],
    (columns, rows): (usize, usize),
    [x, y]: [f64; 2],
    light: [f32; COLORS],
) {
    let (left, top) = (x.floor(), y.floor());
    let (s, t) = ((x - left) as f32, (y - top) as f32);
    for (dx, dy, share) in [
        (0.0, 0.0, (1.0 - s) * (1.0 - t)),
        (1.0, 0.0, s * (1.0 - t)),
        (0.0, 1.0, (1.0 - s) * t),
        (1.0, 1.0, s * t),
    ] {
        let (x, y) = (left + dx, top + dy);
        if x >= 0.0 && y >= 0.0 && x < to_f64(columns) && y < to_f64(rows) {
            let cell = &mut star[y as usize * columns + x as usize];
            for (value, more) in cell.iter_mut().zip(light) {
                *value += share * more;
            }
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
fn to_f64(k: usize) -> f64 {
    k as f64
}

#[expect(clippy::cast_precision_loss, reason = "some spikes")]
fn to_f32(k: usize) -> f32 {
    k as f32
}
