//! How bright what is clipped in a frame was.
//!
//! An image does not tell; this is what it is taken to have been. Pixels that are clipped and touch are one region,
//! with the border that the camera's lens and its compression made darker. A small region is a lamp, as bright as
//! the headroom says. A large one is a sky or a wall, and only a little brighter than white, or the camera would have
//! exposed less; nor are lamps so bright beside a sky, by day. A region is brightest in its middle: what is around that is
//! light that a lens has spread already.

/// Light from which pixels beside clipped ones belong to their region.
const BORDER: f32 = 0.9;

/// Light of which a sample is clipped: of 8 bits the last code alone.
const CLIPPED: f32 = 0.995;

/// Share of the frame that a lamp may have for all of the headroom, and px, if that is more. FIT.
const LAMP: f64 = 1e-4;
const LAMP_PX: f64 = 4.0;

/// How fast it falls with the area of a larger one. FIT.
const FALLS: f64 = 0.5;

/// Share of a frame that may be clipped at night, and how fast the headroom falls where it is more: a camera by day exposes
/// so little that no lamp is much brighter than a white wall. FIT.
const NIGHT: f64 = 0.005;
const BY_DAY: f64 = 0.75;

/// How much brighter the brightest color of what is white may be than the second. FIT.
const PUREST: f32 = 1.5;

/// How much of the headroom lamps of one color have, as those of signals and the rear of cars. FIT.
const SIGNAL: f32 = 0.02;

/// A region of a frame.
#[derive(Clone, Copy)]
struct Region {
    /// The region that it is part of; itself where that is all.
    of: usize,
    n_pixels: u32,
    /// Farthest from its border, in steps.
    depth: u32,
    is_clipped: bool,
}

/// Steps to a neighbor beside a pixel and at its corner; depths are in thirds of a px.
const STEPS: [u32; 2] = [3, 4];

/// Not in a region.
const DARK: u32 = u32::MAX;

/// Makes what is clipped in a frame of 1 or 3 colors as bright as it is taken to have been with a headroom. Of a pixel with
/// a clipped color the others are brighter, too, the more so the nearer they are to it: a lamp that is nearly white stays
/// so. A red one stays red, and is not so bright.
pub(super) fn unclip(light: &mut [f32], n_colors: usize, width: usize, headroom: f64) {
    if light.iter().fold(0.0_f32, |most, value| most.max(*value)) < CLIPPED {
        return;
    }
    let brightest: Vec<f32> = match light.as_chunks::<3>() {
        (pixels, []) if n_colors == 3 => (pixels.iter())
            .map(|[red, green, blue]| red.max(*green).max(*blue))
            .collect(),
        _ => light.to_vec(),
    };
    let depths = depths(&brightest, width);
    let (labels, regions) = regions(&brightest, &depths, width);
    let n_clipped = brightest.iter().filter(|it| **it >= CLIPPED).count();
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    let (n_px, n_clipped) = (brightest.len() as f64, n_clipped as f64);
    let lamp_px = (LAMP * n_px).max(LAMP_PX);
    let by_day = libm::pow((NIGHT * n_px / n_clipped).min(1.0), BY_DAY);
    // Deeper than three lamps' radii all is alike: a sky has no ridge.
    let radii_px = 3.0 * (lamp_px / std::f64::consts::PI).sqrt();
    #[expect(clippy::cast_possible_truncation, reason = "some px")]
    let deepest = (f64::from(STEPS[0]) * radii_px) as f32;
    let gains: Vec<f32> = (regions.iter())
        .map(|region| {
            let share = (lamp_px / f64::from(region.n_pixels)).min(1.0);
            let of_clipped = if region.is_clipped {
                headroom - 1.0
            } else {
                0.0
            };
            #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
            let gain = (of_clipped * by_day * libm::pow(share, FALLS)) as f32;
            gain
        })
        .collect();
    for ((pixel, label), depth) in light.chunks_exact_mut(n_colors).zip(labels).zip(depths) {
        if label == DARK {
            continue;
        }
        let region = label as usize;
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let part = (depth as f32 / (regions[region].depth as f32).min(deepest)).min(1.0);
        brighten(pixel, gains[region] * part * part);
    }
}

/// Makes a pixel brighter by a factor of at most 1 and so much more.
fn brighten(pixel: &mut [f32], more: f32) {
    let brightest = pixel
        .iter()
        .fold(f32::MIN_POSITIVE, |most, value| most.max(*value));
    for value in &mut *pixel {
        let near = (*value / brightest).max(0.0);
        *value *= 1.0 + more * near * near;
    }
    if let [red, green, blue] = pixel {
        let [one, two, three] = [*red, *green, *blue];
        let second = one.max(two).min(one.min(two).max(three));
        // Of a lamp of one color its own light says little: it is a signal's.
        let most = (PUREST * second).max(1.0 + SIGNAL * more);
        for value in [red, green, blue] {
            *value = value.min(most);
        }
    }
}

/// How far each bright pixel is from the next that is not, in steps; beyond the frame it goes on.
fn depths(brightest: &[f32], width: usize) -> Vec<u32> {
    // Farther than any, and far from the largest number.
    const FAR: u32 = 1 << 28;
    let mut depths: Vec<u32> = (brightest.iter())
        .map(|value| if *value < BORDER { 0 } else { FAR })
        .collect();
    sweep(&mut depths, width);
    // The frame turned by half a turn.
    depths.reverse();
    sweep(&mut depths, width);
    depths.reverse();
    depths
}

/// Lessens depths down and right, by those of the neighbors that are before on the way.
fn sweep(depths: &mut [u32], width: usize) {
    let [side, corner] = STEPS;
    for at in 0..depths.len() {
        let mut least = depths[at];
        if least == 0 {
            continue;
        }
        let x = at % width;
        if x > 0 {
            least = least.min(depths[at - 1] + side);
        }
        if at >= width {
            least = least.min(depths[at - width] + side);
            if x > 0 {
                least = least.min(depths[at - width - 1] + corner);
            }
            if x + 1 < width {
                least = least.min(depths[at - width + 1] + corner);
            }
        }
        depths[at] = least;
    }
}

/// The region of each pixel, and all regions: those that are part of another have its numbers.
fn regions(brightest: &[f32], depths: &[u32], width: usize) -> (Vec<u32>, Vec<Region>) {
    let mut labels = vec![DARK; brightest.len()];
    let mut regions: Vec<Region> = Vec::new();
    let bright = depths.iter().enumerate().filter(|(_, depth)| **depth > 0);
    for (at, _) in bright {
        let x = at % width;
        let label_at = |at: usize| Some(labels[at]).filter(|label| *label != DARK);
        let left = if x > 0 { label_at(at - 1) } else { None };
        let above = if at >= width {
            label_at(at - width)
        } else {
            None
        };
        let region = match (left, above) {
            (Some(one), Some(other)) => join(&mut regions, one as usize, other as usize),
            (Some(one), None) | (None, Some(one)) => whole(&mut regions, one as usize),
            (None, None) => {
                regions.push(Region {
                    of: regions.len(),
                    n_pixels: 0,
                    depth: 0,
                    is_clipped: false,
                });
                regions.len() - 1
            }
        };
        labels[at] = u32::try_from(region).unwrap_or(DARK);
        let region = &mut regions[region];
        region.n_pixels += 1;
        region.depth = region.depth.max(depths[at]);
        region.is_clipped |= brightest[at] >= CLIPPED;
    }
    for k in 0..regions.len() {
        let of = whole(&mut regions, k);
        regions[k] = regions[of];
    }
    (labels, regions)
}

/// The region that one is part of in the end.
fn whole(regions: &mut [Region], mut region: usize) -> usize {
    while regions[region].of != region {
        let next = regions[region].of;
        regions[region].of = regions[next].of;
        region = next;
    }
    region
}

/// Makes one region of two.
fn join(regions: &mut [Region], one: usize, other: usize) -> usize {
    let (one, other) = (whole(regions, one), whole(regions, other));
    let (first, second) = (one.min(other), one.max(other));
    if first != second {
        let joined = regions[second];
        regions[second].of = first;
        let region = &mut regions[first];
        region.n_pixels += joined.n_pixels;
        region.depth = region.depth.max(joined.depth);
        region.is_clipped |= joined.is_clipped;
    }
    first
}
