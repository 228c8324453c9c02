//! A whole frame out of focus.

use super::elsewhere::{between, side_by_side};
use crate::lit_runs::lit_runs;
use crate::maps::{Kernel, Pupil};
use crate::pyramid::{mirrored, vectorized};

/// Most cells per radius: larger discs are spread over a smaller frame.
const MOST_CELLS: f64 = 12.0;

/// What lies beyond the border of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Beyond {
    /// The frame once more, mirrored at its border.
    Mirrored,
    /// Nothing.
    Nothing,
}

/// Linear light of a frame spread by the image of the pupil, of signed radius, px; beyond the
/// frame it goes on mirrored.
pub(super) fn defocus<const COLORS: usize>(
    light: &[f32],
    size: (usize, usize),
    pupil: Pupil,
    radius_px: f64,
) -> Vec<f32> {
    let radii_px = vec![radius_px; size.1];
    defocus_rows::<COLORS>(light, size, pupil, &radii_px, Beyond::Mirrored)
}

/// The same for so many values per pixel, 1 or 3.
pub(crate) fn spread_evenly(
    light: &[f32],
    n_colors: usize,
    size: (usize, usize),
    pupil: Pupil,
    radius_px: f64,
) -> Vec<f32> {
    match n_colors {
        1 => defocus::<1>(light, size, pupil, radius_px),
        _ => defocus::<3>(light, size, pupil, radius_px),
    }
}

/// As [`defocus`], for `LANES` values per pixel and with a radius, px, for the light of each row.
///
/// A disc of more than 12 px of radius is band-limited enough to be spread over means of 2 × 2, 4 ×
/// 4, … px; their width and that of the straight lines back between them is taken off the disc's.
/// The largest disc decides for all rows, so that one of less than a tenth of it gets too large.
pub(crate) fn defocus_rows<const LANES: usize>(
    light: &[f32],
    (width, height): (usize, usize),
    pupil: Pupil,
    radii_px: &[f64],
    beyond: Beyond,
) -> Vec<f32> {
    let most_px = radii_px
        .iter()
        .fold(0.0_f64, |most, radius| most.max(radius.abs()));
    let mut per_cell = 1_u32;
    while most_px / f64::from(per_cell) > MOST_CELLS {
        per_cell *= 2;
    }
    if per_cell == 1 {
        return spread::<LANES>(light, (width, height), pupil, radii_px, beyond);
    }
    let cells = per_cell as usize;
    let size = (width.div_ceil(cells), height.div_ceil(cells));
    let radii: Vec<f64> = radii_px
        .iter()
        .skip(cells / 2)
        .step_by(cells)
        .chain(radii_px.last())
        .take(size.1)
        .map(|radius_px| {
            let radius = radius_px.abs() / f64::from(per_cell);
            // Variances per axis, cells²: means and kernel 1/12 each, lines 1/6; that of a disc is
            // ρ²/4.
            (radius * radius - 4.0 / 3.0)
                .max(0.0)
                .sqrt()
                .copysign(*radius_px)
        })
        .collect();
    let per_cell = cells;
    let small = spread::<LANES>(
        &means::<LANES>(light, (width, height), per_cell),
        size,
        pupil,
        &radii,
        beyond,
    );
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    let place = |k: usize| (k as f32 + 0.5) / per_cell as f32;
    let is_dark: Vec<bool> = small
        .chunks_exact(size.0 * LANES)
        .map(|row| row.iter().all(|light| light.abs() <= 0.0))
        .collect();
    let small = small.as_chunks::<LANES>().0;
    let mut out = vec![0.0; light.len()];
    for (y, row) in out.chunks_exact_mut(width * LANES).enumerate() {
        // Between this row of cells and one of its neighbors.
        let cell = y / per_cell;
        let around = cell.saturating_sub(1)..(cell + 2).min(size.1);
        if is_dark[around].iter().all(|is_dark| *is_dark) {
            continue;
        }
        for (x, pixel) in row.chunks_exact_mut(LANES).enumerate() {
            let light = between(size, [place(x), place(y)], |x, y| {
                side_by_side(&small[y * size.0 + x])
            });
            pixel.copy_from_slice(&light.to_array()[..LANES]);
        }
    }
    out
}

/// Means of square cells of a frame; those at its end are cut off by it.
fn means<const COLORS: usize>(
    light: &[f32],
    (width, height): (usize, usize),
    per_cell: usize,
) -> Vec<f32> {
    let mut means = Vec::new();
    for top in (0..height).step_by(per_cell) {
        for left in (0..width).step_by(per_cell) {
            let (bottom, right) = ((top + per_cell).min(height), (left + per_cell).min(width));
            let mut sum = [0.0_f32; COLORS];
            for y in top..bottom {
                for pixel in light[(y * width + left) * COLORS..(y * width + right) * COLORS]
                    .chunks_exact(COLORS)
                {
                    for (sum, light) in sum.iter_mut().zip(pixel) {
                        *sum += light;
                    }
                }
            }
            #[expect(clippy::cast_precision_loss, reason = "pixels of a cell")]
            let n = ((bottom - top) * (right - left)) as f32;
            means.extend(sum.map(|sum| sum / n));
        }
    }
    means
}

/// The same at full size: each row is scattered as steps and summed up along the row, as cracks
/// are.
fn spread<const LANES: usize>(
    light: &[f32],
    (width, height): (usize, usize),
    pupil: Pupil,
    radii: &[f64],
    beyond: Beyond,
) -> Vec<f32> {
    let mut kernels: Vec<(f64, Kernel)> = Vec::new();
    let kernel_of: Vec<usize> = radii
        .iter()
        .map(|radius| {
            let same = |(known, _): &(f64, Kernel)| known.to_bits() == radius.to_bits();
            kernels.iter().rposition(same).unwrap_or_else(|| {
                kernels.push((*radius, Kernel::new(pupil, *radius)));
                kernels.len() - 1
            })
        })
        .collect();
    let reach = kernels
        .iter()
        .map(|(_, kernel)| kernel.reach())
        .max()
        .unwrap_or(0);
    // Room for discs that reach out of the rows.
    let stride = width + 4 * reach;
    let slots = 2 * reach + 1;
    let mut ring = vec![[0.0_f32; LANES]; slots * stride];
    let mut out = vec![0.0; light.len()];
    let reach_signed = reach.cast_signed();
    // A row with `reach` more on either side.
    let mut sources = vec![[0.0_f32; LANES]; width + 2 * reach];
    for row in -reach_signed..height.cast_signed() + reach_signed {
        let source_row = mirrored(row, height);
        let source = light[source_row * width * LANES..][..width * LANES]
            .as_chunks::<LANES>()
            .0;
        let lit = match beyond {
            Beyond::Mirrored => {
                for (k, to) in (-reach_signed..).zip(&mut sources) {
                    *to = source[mirrored(k, width)];
                }
                std::iter::once(0..sources.len()).collect()
            }
            Beyond::Nothing if (0..height.cast_signed()).contains(&row) => {
                sources[reach..reach + width].copy_from_slice(source);
                lit_runs(&sources)
            }
            Beyond::Nothing => Vec::new(),
        };
        for stretch in kernels[kernel_of[source_row]].1.stretches() {
            let y = row + stretch.dy as isize;
            if lit.is_empty() || !(0..height.cast_signed()).contains(&y) {
                continue;
            }
            let line = &mut ring[y.cast_unsigned() % slots * stride..][..stride];
            let firsts = (stretch.ends).map(|end| (reach_signed + end.dx as isize).cast_unsigned());
            vectorized(
                #[inline(always)]
                || {
                    for (end, first) in stretch.ends.iter().zip(firsts) {
                        for run in &lit {
                            let line = &mut line[first + run.start..first + run.end + 1];
                            add_steps(line, &sources[run.clone()], end.steps);
                        }
                    }
                },
            );
        }
        let Some(done) = (row - reach_signed)
            .try_into()
            .ok()
            .filter(|y: &usize| *y < height)
        else {
            continue;
        };
        let line = &mut ring[done % slots * stride..][..stride];
        let mut sum = [0.0_f32; LANES];
        for (column, steps) in line.iter_mut().enumerate() {
            for (sum, step) in sum.iter_mut().zip(&*steps) {
                *sum += step;
            }
            *steps = [0.0; LANES];
            if let Some(x) = column.checked_sub(2 * reach).filter(|x| *x < width) {
                out[(done * width + x) * LANES..][..LANES].copy_from_slice(&sum);
            }
        }
    }
    out
}

/// Adds light times the first step to the cells of a line, and light times the second to the cells one further.
#[inline(always)]
fn add_steps<const LANES: usize>(
    line: &mut [[f32; LANES]],
    light: &[[f32; LANES]],
    steps: [f32; 2],
) {
    // Flat, or three colors are shuffled about.
    for (k, step) in steps.into_iter().enumerate() {
        let to = line[k..].as_flattened_mut();
        for (to, light) in to.iter_mut().zip(light.as_flattened()) {
            *to += step * light;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge along the columns, out of focus, against the share of a disc beyond it.
    fn edge_error(radius: f64) -> f64 {
        let (width, height) = (400, 40);
        let light: Vec<f32> = (0..width * height)
            .map(|k| if k % width < 200 { 0.0 } else { 1.0 })
            .collect();
        let blurred = defocus::<1>(&light, (width, height), Pupil::Round, radius);
        let mut worst = 0.0_f64;
        for x in 0..width {
            let u = ((x as f64 + 0.5 - 200.0) / radius).clamp(-1.0, 1.0);
            let share = 0.5 + (u * (1.0 - u * u).sqrt() + u.asin()) / std::f64::consts::PI;
            worst = worst.max((f64::from(blurred[20 * width + x]) - share).abs());
        }
        worst
    }

    #[test]
    fn an_edge_out_of_focus_is_the_share_of_the_disc() {
        for radius in [3.0, 11.0, 13.0, 20.0, 40.0, 90.0] {
            let worst = edge_error(radius);
            assert!(worst < 0.012, "R = {radius}: {worst}");
        }
    }

    #[test]
    fn an_even_frame_stays_even() {
        for radius in [2.0, 30.0] {
            let blurred = defocus::<3>(&[0.25; 3 * 31 * 17], (31, 17), Pupil::Round, radius);
            assert_eq!(blurred.len(), 3 * 31 * 17, "as large as before");
            assert!(
                blurred.iter().all(|light| (light - 0.25).abs() < 1e-4),
                "R = {radius}"
            );
        }
    }
}
