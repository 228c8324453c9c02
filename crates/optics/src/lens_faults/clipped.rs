//! How bright what is clipped in a frame was.
//!
//! An image does not tell; this is what it is taken to have been. Pixels that are clipped and touch are one region,
//! with the border that the camera's lens and its compression made darker. A small region is a lamp, as bright as
//! the headroom says. A large one is a sky or a wall, and only a little brighter than white, or the camera would have
//! exposed less; nor are lamps so bright beside a sky, by day; and what is clipped amid light that is nearly as bright, as
//! of clouds and snow, is no lamp at all. A region is brightest in its middle: what is around that is light that a lens has
//! spread already.

use std::ops::Range;

use super::bright::{BORDER, Bright, CLIPPED, Region, STEPS, brightest, by_run, runs_with};
use crate::pyramid::vectorized;

/// Share of the frame that a lamp may have for all of the headroom, and px, if that is more. FIT.
const LAMP: f64 = 1e-4;
const LAMP_PX: f64 = 4.0;

/// How fast it falls with the area of a larger one, and of a smaller one, which may be a glint. FIT.
const FALLS: f64 = 0.5;

/// Share of a frame that may be clipped at night, and how fast the headroom falls where it is more: a camera by day exposes
/// so little that no lamp is much brighter than a white wall. FIT.
const NIGHT: f64 = 0.005;
const BY_DAY: f64 = 1.0;

/// How much brighter the brightest color of what is white may be than the second. FIT.
const PUREST: f32 = 1.5;

/// How much of the headroom lamps of one color have, as those of signals and the rear of cars. FIT.
const SIGNAL: f32 = 0.02;

/// Makes what is clipped in a frame of 1 or 3 colors as bright as it is taken to have been with a headroom; returns the
/// pixels that it makes brighter, those of a row that are side by side together, in their order. Of a pixel with a clipped
/// color the others are brighter, too, the more so the nearer they are to it: a lamp that is nearly white stays so. A red
/// one stays red, and is not so bright.
pub(super) fn unclip(
    light: &mut [f32],
    n_colors: usize,
    width: usize,
    headroom: f64,
) -> Vec<Range<usize>> {
    match n_colors {
        1 => unclip_of::<1>(light.as_chunks_mut().0, width, headroom),
        _ => unclip_of::<3>(light.as_chunks_mut().0, width, headroom),
    }
}

fn unclip_of<const COLORS: usize>(
    light: &mut [[f32; COLORS]],
    width: usize,
    headroom: f64,
) -> Vec<Range<usize>> {
    let bright = Bright {
        runs: runs_with(light, width, |value| value >= BORDER),
        size: (width, light.len() / width),
    };
    let clipped = (bright.runs.iter().flat_map(|run| &light[run.clone()]))
        .filter(|pixel| brightest(pixel) >= CLIPPED);
    let n_clipped = clipped.count();
    if n_clipped == 0 {
        return Vec::new();
    }
    let depths = bright.depths();
    let (regions, of_runs) = bright.regions(&depths, light);
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    let (n_px, n_clipped) = (light.len() as f64, n_clipped as f64);
    let lamp_px = (LAMP * n_px).max(LAMP_PX);
    let by_day = libm::pow((NIGHT * n_px / n_clipped).min(1.0), BY_DAY);
    // Deeper than three lamps' radii all is alike: a sky has no ridge.
    let radii_px = 3.0 * (lamp_px / std::f64::consts::PI).sqrt();
    #[expect(clippy::cast_possible_truncation, reason = "some px")]
    let deepest = (f64::from(STEPS[0]) * radii_px) as f32;
    let gain_of = |region: &Region| {
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let share = lamp_px / region.n_pixels as f64;
        let share = libm::pow(share.min(1.0 / share), FALLS);
        #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
        let gain = ((headroom - 1.0) * by_day * share) as f32;
        gain * region.stands_out()
    };
    // None where nothing is clipped.
    let gains: Vec<f32> = (regions.iter())
        .map(|region| {
            if region.is_clipped {
                gain_of(region)
            } else {
                0.0
            }
        })
        .collect();
    let mut brighter = Vec::new();
    let runs = by_run(&bright.runs, &depths).zip(of_runs);
    for (run, (depths, region)) in bright.runs.iter().zip(runs) {
        if gains[region] > 0.0 {
            #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
            let deep = (regions[region].depth as f32).min(deepest);
            brighten(&mut light[run.clone()], (depths, deep), gains[region]);
            brighter.push(run.clone());
        }
    }
    brighter
}

/// Makes the pixels of a run brighter: by a factor of at most 1 and so much more, at a depth and beyond it.
fn brighten<const COLORS: usize>(
    pixels: &mut [[f32; COLORS]],
    (depths, deep): (&[u32], f32),
    most: f32,
) {
    /// Pixels that are looked at together.
    const TOGETHER: usize = 8;
    vectorized(
        #[inline(always)]
        || {
            let depths = depths.chunks(TOGETHER);
            for (pixels, depths) in pixels.chunks_mut(TOGETHER).zip(depths) {
                let mut colors = [[0.0; TOGETHER]; COLORS];
                let mut more = [0.0; TOGETHER];
                for (k, (pixel, depth)) in pixels.iter().zip(depths).enumerate() {
                    for c in 0..COLORS {
                        colors[c][k] = pixel[c];
                    }
                    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
                    let part = (*depth as f32 / deep).min(1.0);
                    more[k] = most * part * part;
                }
                brighten_side_by_side(&mut colors, &more);
                for (k, pixel) in pixels.iter_mut().enumerate() {
                    for c in 0..COLORS {
                        pixel[c] = colors[c][k];
                    }
                }
            }
        },
    );
}

/// Makes pixels, color by color, brighter by a factor of at most 1 and so much more.
#[inline(always)]
fn brighten_side_by_side<const N: usize, const COLORS: usize>(
    colors: &mut [[f32; N]; COLORS],
    more: &[f32; N],
) {
    let mut brightest = [f32::MIN_POSITIVE; N];
    for color in &*colors {
        for k in 0..N {
            brightest[k] = brightest[k].max(color[k]);
        }
    }
    for color in &mut *colors {
        for k in 0..N {
            let near = (color[k] / brightest[k]).max(0.0);
            color[k] *= 1.0 + more[k] * near * near;
        }
    }
    let Some([red, green, blue]) = colors.first_chunk_mut() else {
        return;
    };
    for k in 0..N {
        let [one, two, three] = [red[k], green[k], blue[k]];
        let second = one.max(two).min(one.min(two).max(three));
        // Of a lamp of one color its own light says little: it is a signal's.
        let most = (PUREST * second).max(1.0 + SIGNAL * more[k]);
        [red[k], green[k], blue[k]] = [one.min(most), two.min(most), three.min(most)];
    }
}
