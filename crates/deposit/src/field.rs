//! How something changes from place to place over a pane.

use starbreak_seed::{Seed, Stream, uniform};

use crate::Area;

/// Numbers about 1 that change smoothly over a pane: two octaves of value noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    from_mm: [f64; 2],
    octaves: Vec<Octave>,
    contrast: f64,
}

#[derive(Debug, Clone, PartialEq)]
struct Octave {
    cell_mm: f64,
    size: [usize; 2],
    /// −1 to 1.
    values: Vec<f64>,
    weight: f64,
}

impl Field {
    /// Of a scale, mm, over an area; it differs from 1 by the contrast, 0 to 1, at most.
    #[must_use]
    pub fn over(
        area: &Area,
        (scale_mm, contrast): (f64, f64),
        (stream, seed): (Stream, Seed),
    ) -> Self {
        let octave = |k: u32, weight: f64| {
            let cell_mm = scale_mm / f64::from(1_u32 << k);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "cells of a pane"
            )]
            let size = area
                .sides_mm()
                .map(|side| ((side / cell_mm).ceil() as usize).min(MOST_CELLS) + 2);
            let mut rng = seed.stream(stream, k.into());
            let values = (0..size[0] * size[1])
                .map(|_| 2.0 * uniform(&mut rng) - 1.0)
                .collect();
            Octave {
                cell_mm,
                size,
                values,
                weight,
            }
        };
        Self {
            from_mm: area.from_mm,
            octaves: vec![octave(0, 0.7), octave(1, 0.3)],
            contrast,
        }
    }

    /// The number at a place, mm; beyond the area that of its border.
    #[must_use]
    pub fn at(&self, at_mm: [f64; 2]) -> f64 {
        let sum: f64 = self
            .octaves
            .iter()
            .map(|octave| octave.weight * octave.at([0, 1].map(|k| at_mm[k] - self.from_mm[k])))
            .sum();
        1.0 + self.contrast * sum
    }
}

/// Most cells of a side.
const MOST_CELLS: usize = 2000;

impl Octave {
    fn at(&self, from_corner_mm: [f64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|k| {
            let cells = from_corner_mm[k] / self.cell_mm;
            #[expect(clippy::cast_precision_loss, reason = "cells of a pane")]
            let last = (self.size[k] - 2) as f64;
            cells.clamp(0.0, last)
        });
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "cells of a pane"
        )]
        let (left, top) = (x as usize, y as usize);
        // Smoothly: 3t² − 2t³.
        let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
        #[expect(clippy::cast_precision_loss, reason = "cells of a pane")]
        let (s, t) = (smooth(x - left as f64), smooth(y - top as f64));
        let value = |dx: usize, dy: usize| self.values[(top + dy) * self.size[0] + left + dx];
        let high = value(0, 0) + s * (value(1, 0) - value(0, 0));
        let low = value(0, 1) + s * (value(1, 1) - value(0, 1));
        high + t * (low - high)
    }
}
