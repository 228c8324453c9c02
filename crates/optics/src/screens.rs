//! Dew on the glass: a screen of drops too small to be seen, which spreads light about what it comes from.

use starbreak_deposit::{Condensation, Field};

use crate::View;
use crate::pyramid::Cells;

/// Refractive index of water in visible light.
const WATER: f64 = 1.333;

/// Wavelength of green light, m.
const WAVELENGTH_M: f64 = 0.55e-6;

/// Width of a cell of the map of what is covered, px: it changes slowly.
const CELL_PX: u32 = 4;

/// Dew before one camera, ready for any image of its size.
///
/// Of light that a share c of drops meets, drops without order leave (1 − c)² as it is; c(1 − c) is diffracted by the
/// gaps between them, and c refracted, which come from about the place that is seen (Babinet). The sum is 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Screen {
    size: (usize, usize),
    /// What is covered, in cells, by rows.
    covered: Vec<f32>,
    columns: usize,
    refracted_px: f64,
    diffracted_px: f64,
}

impl Screen {
    /// Of dew that is so many times the mean at each place of the pane.
    #[must_use]
    pub fn of(dew: &Condensation, times: &Field, view: &View, f_px: f64) -> Self {
        let (width, height) = view.size();
        let size = (width as usize, height as usize);
        let (columns, rows) = (
            size.0.div_ceil(CELL_PX as usize),
            size.1.div_ceil(CELL_PX as usize),
        );
        let mut covered = Vec::with_capacity(columns * rows);
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let middle = |k: usize| (k as f64 + 0.5) * f64::from(CELL_PX);
        for y in 0..rows {
            for x in 0..columns {
                let at = view.unproject([middle(x), middle(y)]);
                let here = at.map_or(0.0, |at| dew.drops(times.at(at)).covered);
                #[expect(clippy::cast_possible_truncation, reason = "a share of light")]
                covered.push(here as f32);
            }
        }
        let radius_m = dew.drops(1.0).radius_m;
        Self {
            size,
            covered,
            columns,
            refracted_px: f_px * dew.refracts_by_rad(WATER),
            // The core of a disc's diffraction as a Gaussian.
            diffracted_px: f_px * 0.42 * WAVELENGTH_M / (2.0 * radius_m).max(WAVELENGTH_M),
        }
    }

    /// Mean share of the frame that is covered.
    #[must_use]
    pub fn mean_covered(&self) -> f64 {
        let sum: f64 = self.covered.iter().map(|c| f64::from(*c)).sum();
        #[expect(clippy::cast_precision_loss, reason = "cells of a frame")]
        let n = self.covered.len().max(1) as f64;
        sum / n
    }

    /// Standard deviations of the light about a lamp, px: of what is refracted, and of what is diffracted.
    #[must_use]
    pub fn halos_px(&self) -> [f64; 2] {
        [self.refracted_px, self.diffracted_px]
    }

    /// Where more than a share of the light is not as it was, in rows of pixels.
    #[must_use]
    pub fn reaches(&self, least: f64) -> Vec<bool> {
        let (width, height) = self.size;
        let of = |x: usize, y: usize| {
            let c =
                f64::from(self.covered[y / CELL_PX as usize * self.columns + x / CELL_PX as usize]);
            1.0 - (1.0 - c) * (1.0 - c) >= least && c > 0.0
        };
        (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| of(x, y))
            .collect()
    }

    /// What the dew makes of the light of a frame, with 1 or 3 values per pixel, in place.
    pub fn over(&self, light: &mut [f32], n_colors: usize) {
        match n_colors {
            1 => self.colors_over::<1>(light),
            _ => self.colors_over::<3>(light),
        }
    }

    fn colors_over<const COLORS: usize>(&self, light: &mut [f32]) {
        let (width, _) = self.size;
        let pixels = Cells::<COLORS>::of(light, self.size);
        let refracted = pixels.spread(self.refracted_px);
        let diffracted = pixels.spread(self.diffracted_px);
        let map = Cells::<1>::of_cells(
            &self.covered,
            (self.columns, self.covered.len() / self.columns),
            CELL_PX,
        );
        let mut c = vec![0.0_f32; width];
        for (y, row) in light.chunks_exact_mut(width * COLORS).enumerate() {
            map.each_between(y, width, |x, [here]| c[x] = here);
            let row = row.as_chunks_mut::<COLORS>().0;
            refracted.each_between(y, width, |x, wide| {
                let c = c[x];
                for (value, wide) in row[x].iter_mut().zip(wide) {
                    *value = (1.0 - c) * (1.0 - c) * *value + c * wide;
                }
            });
            diffracted.each_between(y, width, |x, near| {
                let c = c[x];
                for (value, near) in row[x].iter_mut().zip(near) {
                    *value += c * (1.0 - c) * near;
                }
            });
        }
    }
}
