//! A star through each lamp: light that the edges of the aperture diffract.

use std::f64::consts::{PI, TAU};

use super::Optic;
use super::bright::runs_with;
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
const MOST_SPIKES: usize = 12_000;

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
        let pixels = light.as_chunks_mut::<COLORS>().0;
        let lit = runs_with(pixels, optic.size.0, |value| value > 1.0);
        if lit.is_empty() {
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
        let lit = lit.into_iter().flatten();
        let lamps: Vec<_> = lit.map(|at| (at, pixels[at])).collect();
        for (at, lamp) in &lamps {
            for k in 0..COLORS {
                pixels[*at][k] -= shares[k] * lamp[k];
            }
        }
        let spikes = self.spikes();
        let per_spike = 1.0 / to_f32(spikes.len());
        let sends = |lamp: [f32; COLORS]| std::array::from_fn(|k| lamp[k] * shares[k] * per_spike);
        if lamps.len() * spikes.len() <= MOST_SPIKES {
            let lamps = lamps.into_iter().map(|(at, lamp)| (at, sends(lamp)));
            add_spikes(pixels, optic.size.0, lamps, (&spikes, 1));
            return;
        }
        let mut cells = Cells::<COLORS>::none(optic.size, 1);
        for (at, lamp) in lamps {
            cells.values_mut()[at] = lamp;
        }
        let is_lit = |light: &[f32; COLORS]| light.iter().any(|value| *value > 0.0);
        let n_lit = |cells: &Cells<COLORS>| cells.values().filter(|it| is_lit(it)).count();
        while n_lit(&cells) * spikes.len() > MOST_SPIKES && cells.size.0 > 8 {
            cells = cells.halved();
        }
        let mut star = Cells::<COLORS>::none(optic.size, cells.per_cell);
        let lamps = cells.values().copied().enumerate();
        let lamps = (lamps.filter(|(_, lamp)| is_lit(lamp))).map(|(at, lamp)| (at, sends(lamp)));
        let width = cells.size.0;
        add_spikes(star.values_mut(), width, lamps, (&spikes, cells.per_cell));
        // A cell holds the mean of its pixels, so that light stays what it is.
        star.add_to(light, optic.size.0);
    }
}

/// Adds the light that lamps send along each spike to cells of a width, px, in rows of so many.
fn add_spikes<const COLORS: usize>(
    cells: &mut [[f32; COLORS]],
    columns: usize,
    lamps: impl Iterator<Item = (usize, [f32; COLORS])>,
    (spikes, per_cell): (&[f64], u32),
) {
    let steps: Vec<Step> = (spikes.iter())
        .flat_map(|angle| steps(*angle, f64::from(per_cell)))
        .collect();
    let size = (columns, cells.len() / columns);
    for (at, light) in lamps {
        let at = [at % columns, at / columns].map(usize::cast_signed);
        for step in &steps {
            step.add(cells, size, (at, light));
        }
    }
}

/// Two cells side by side that a spike passes between.
struct Step {
    /// From the lamp, right and down.
    near: [isize; 2],
    far: [isize; 2],
    /// Their shares of the spike's light.
    shares: [f32; 2],
}

impl Step {
    /// Of a share of light, so many columns away (or rows, where the spike is steep) and so far across them, in cells.
    #[expect(clippy::cast_possible_truncation, reason = "cells; a share of light")]
    fn new(is_flat: bool, column: f64, across: f64, share: f64) -> Self {
        let (along, whole, part) = (column as isize, across.floor(), across - across.floor());
        let cell = |across: isize| match is_flat {
            true => [along, across],
            false => [across, along],
        };
        Self {
            near: cell(whole as isize),
            far: cell(whole as isize + 1),
            shares: [1.0 - part, part].map(|part| (share * part) as f32),
        }
    }

    /// Adds the light that a lamp sends along the spike; what is beyond the frame is lost.
    fn add<const COLORS: usize>(
        &self,
        star: &mut [[f32; COLORS]],
        (columns, rows): (usize, usize),
        (lamp, light): ([isize; 2], [f32; COLORS]),
    ) {
        for (away, share) in [self.near, self.far].into_iter().zip(self.shares) {
            let [x, y] = [0, 1].map(|k| (lamp[k] + away[k]).cast_unsigned());
            // Left of the frame or above it is far beyond its other end.
            if x < columns && y < rows {
                let cell = &mut star[y * columns + x];
                for c in 0..COLORS {
                    cell[c] += share * light[c];
                }
            }
        }
    }
}

/// Near the lamp, where light falls fast, a step is divided into so many, up to so many columns away.
const FINE: (u32, u32) = (4, 24);

/// The steps of a spike in a direction, rad, one or more for each column that it passes, or each row, of cells of a width,
/// px.
fn steps(angle: f64, per_cell: f64) -> Vec<Step> {
    let (sin, cos) = libm::sincos(angle);
    let most = cos.abs().max(sin.abs());
    let is_flat = cos.abs() >= sin.abs();
    let (main, other) = if is_flat { (cos, sin) } else { (sin, cos) };
    let beyond = |px: f64| 1.0 / px.clamp(FROM_PX, TO_PX);
    let all = beyond(FROM_PX) - beyond(TO_PX);
    let mut steps = Vec::new();
    let mut k = 0.0;
    while (k - 0.5) * per_cell / most < TO_PX {
        let n = if k < f64::from(FINE.1) { FINE.0 } else { 1 };
        for piece in 0..n {
            let [from, to] =
                [0.0, 1.0].map(|end| k - 0.5 + (f64::from(piece) + end) / f64::from(n));
            let [from_px, to_px] = [from, to].map(|cells| cells * per_cell / most);
            let share = (beyond(from_px) - beyond(to_px)) / all;
            if share > 0.0 {
                // On straight lines between cells along the spike, and between those across it.
                let along = 0.5 * (from + to);
                let across = along * other / most;
                for (column, part) in [(0.0, 1.0 - along.fract()), (1.0, along.fract())] {
                    if share * part > 0.0 {
                        let column = (along.floor() + column).copysign(main);
                        steps.push(Step::new(is_flat, column, across, share * part));
                    }
                }
            }
        }
        k += 1.0;
    }
    steps
}

#[expect(clippy::cast_precision_loss, reason = "some spikes")]
fn to_f32(k: usize) -> f32 {
    k as f32
}
