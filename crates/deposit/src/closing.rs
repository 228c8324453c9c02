//! How ice closes in between branches.

use crate::raster::Raster;

/// Speed at which ice closes in between branches, over that of the front. FIT.
const SIDEWAYS: f64 = 0.02;

/// Lets ice close in from all cells that have some: each next cell is reached later by its distance over the speed. Sweeps
/// go down and right, then up and left, twice, so that they come around the edges of the tile. Only what arrives before the
/// front has gone its way is right.
pub(crate) fn close_in(arrives_mm: &mut Raster, front_mm: f32) {
    let [width, height] = arrives_mm.size;
    #[expect(clippy::cast_possible_truncation, reason = "a length")]
    let straight_mm = (arrives_mm.cell_mm / SIDEWAYS) as f32;
    let across_mm = straight_mm * std::f32::consts::SQRT_2;
    let mut beside = vec![0.0; width + 2];
    let mut along = Along::new(width, straight_mm, front_mm);
    let mut sweep = |y: usize, before: usize, is_back: bool| {
        // The row before, with what lies beyond its ends.
        let row_of = |y: usize| y * width..(y + 1) * width;
        beside[1..=width].copy_from_slice(&arrives_mm.values[row_of(before)]);
        (beside[0], beside[width + 1]) = (beside[width], beside[1]);
        let row = &mut arrives_mm.values[row_of(y)];
        for (value, near) in row.iter_mut().zip(beside.windows(3)) {
            let diagonal_mm = near[0].min(near[2]) + across_mm;
            *value = value.min(near[1] + straight_mm).min(diagonal_mm);
        }
        along.close(row, is_back);
    };
    for _ in 0..2 {
        (0..height).for_each(|y| sweep(y, (y + height - 1) % height, false));
        (0..height)
            .rev()
            .for_each(|y| sweep(y, (y + 1) % height, true));
    }
}

/// Ice that closes in along rows.
struct Along {
    straight_mm: f32,
    front_mm: f32,
    /// A row, with the cell beyond its one end at the other; and as it was.
    row: Vec<f32>,
    from: Vec<f32>,
}

impl Along {
    fn new(width: usize, straight_mm: f32, front_mm: f32) -> Self {
        Self {
            straight_mm,
            front_mm,
            row: vec![0.0; width + 1],
            from: vec![0.0; width + 1],
        }
    }

    /// From the first cell to the last, or back; once around the edge of the tile.
    ///
    /// Each cell has the least of itself and of the one before and a step, of that and its own one before, and so on.
    /// Steps keep an order, so that this is the same as the least of some cells side by side, then of twice as
    /// many, up to as many as the front reaches.
    fn close(&mut self, row: &mut [f32], is_back: bool) {
        let width = row.len();
        let (own, beyond, around) = if is_back {
            (0..width, width, row[0])
        } else {
            (1..width + 1, 0, row[width - 1])
        };
        self.row[own.clone()].copy_from_slice(row);
        self.row[beyond] = around;
        let (mut n, mut way_mm) = (1, self.straight_mm);
        while way_mm < self.front_mm && n <= width {
            let step = n.min(8);
            match step {
                1 => self.least::<1>(is_back),
                2 => self.least::<2>(is_back),
                4 => self.least::<4>(is_back),
                _ => self.least::<8>(is_back),
            }
            if step == 8 && self.row == self.from {
                // Nor will it change once more.
                break;
            }
            n += step;
            for _ in 0..step {
                way_mm += self.straight_mm;
            }
        }
        row.copy_from_slice(&self.row[own]);
    }

    /// Of each cell and that so many before it.
    fn least<const N: usize>(&mut self, is_back: bool) {
        self.from.copy_from_slice(&self.row);
        let n = self.row.len() - N;
        let (to, from) = if is_back {
            (&mut self.row[..n], &self.from[N..])
        } else {
            (&mut self.row[N..], &self.from[..n])
        };
        for (value, from) in to.iter_mut().zip(from) {
            let later = (0..N).fold(*from, |later, _| later + self.straight_mm);
            *value = value.min(later);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ice_closes_in_along_a_row_as_cell_by_cell() {
        const STEP_MM: f32 = 0.7;
        for (width, front_mm) in [(4, 9.0), (5, 0.5), (97, 9.0), (97, 100.0)] {
            let mut row = vec![f32::INFINITY; width];
            (row[width / 2], row[width - 2], row[1]) = (0.3, 1.1, 5.0);
            let mut along = Along::new(width, STEP_MM, front_mm);
            for is_back in [false, true] {
                let mut expected = row.clone();
                let close = |last: f32, value: &mut f32| {
                    *value = value.min(last + STEP_MM);
                    *value
                };
                if is_back {
                    expected.iter_mut().rev().fold(row[0], close);
                } else {
                    expected.iter_mut().fold(row[width - 1], close);
                }
                along.close(&mut row, is_back);
                let in_time = |row: &[f32]| -> Vec<u32> {
                    row.iter().map(|at| at.min(front_mm).to_bits()).collect()
                };
                assert_eq!(in_time(&row), in_time(&expected), "{width} cells");
            }
        }
    }
}
