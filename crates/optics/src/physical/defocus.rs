//! A whole frame out of focus.

use crate::maps::{Kernel, Pupil};

/// Linear light of a frame spread by the image of the pupil, of signed radius, px; beyond the
/// frame it goes on mirrored.
///
/// Each row is scattered as steps and summed up along the row, as cracks are.
pub(super) fn defocus<const COLORS: usize>(
    light: &[f32],
    (width, height): (usize, usize),
    pupil: Pupil,
    radius_px: f64,
) -> Vec<f32> {
    let kernel = Kernel::new(pupil, radius_px);
    let reach = kernel.reach();
    // Room for discs that reach out of the rows.
    let stride = width + 4 * reach;
    let slots = 2 * reach + 1;
    let mut ring = vec![[0.0_f32; COLORS]; slots * stride];
    let mut out = vec![0.0; light.len()];
    let reach_signed = reach.cast_signed();
    for row in -reach_signed..height.cast_signed() + reach_signed {
        let source = &light[mirrored(row, height) * width * COLORS..][..width * COLORS];
        for (dy, dx, steps) in kernel.runs() {
            let y = row + dy as isize;
            if !(0..height.cast_signed()).contains(&y) {
                continue;
            }
            let line = &mut ring[y.cast_unsigned() % slots * stride..][..stride];
            for (dx, step) in (dx..).zip(steps) {
                // Sources from `reach` before the row to `reach` after it.
                let first = (reach_signed + dx as isize).cast_unsigned();
                let to = &mut line[first..first + width + 2 * reach];
                for (k, to) in to.iter_mut().enumerate() {
                    let x = mirrored(k.cast_signed() - reach_signed, width);
                    for (sum, light) in to.iter_mut().zip(&source[x * COLORS..][..COLORS]) {
                        *sum += step * light;
                    }
                }
            }
        }
        let Some(done) = (row - reach_signed)
            .try_into()
            .ok()
            .filter(|y: &usize| *y < height)
        else {
            continue;
        };
        let line = &mut ring[done % slots * stride..][..stride];
        let mut sum = [0.0_f32; COLORS];
        for (column, steps) in line.iter_mut().enumerate() {
            for (sum, step) in sum.iter_mut().zip(&*steps) {
                *sum += step;
            }
            *steps = [0.0; COLORS];
            if let Some(x) = column.checked_sub(2 * reach).filter(|x| *x < width) {
                out[(done * width + x) * COLORS..][..COLORS].copy_from_slice(&sum);
            }
        }
    }
    out
}

/// Index of a sample beyond the border, mirrored at the border's own edge.
fn mirrored(index: isize, n: usize) -> usize {
    let period = 2 * n.cast_signed();
    let folded = index.rem_euclid(period);
    folded.min(period - 1 - folded).cast_unsigned()
}
