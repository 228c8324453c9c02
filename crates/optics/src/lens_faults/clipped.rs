//! How bright what is clipped in a frame was.
//!
//! An image does not tell; this is what it is taken to have been. Pixels that are clipped and touch are one region,
//! with the border that the camera's lens and its compression made darker. A small region is a lamp, as bright as
//! the headroom says. A large one is a sky or a wall, and only a little brighter than white, or the camera would have
//! exposed less; nor are lamps so bright beside a sky, by day; and what is clipped amid light that is nearly as bright, as
//! of clouds and snow, is no lamp at all. A region is brightest in its middle: what is around that is light that a lens has
//! spread already.

/// Light from which pixels beside clipped ones belong to their region.
const BORDER: f32 = 0.9;

/// Light of which a sample is clipped: of 8 bits the last code alone.
const CLIPPED: f32 = 0.995;

/// Share of the frame that a lamp may have for all of the headroom, and px, if that is more. FIT.
const LAMP: f64 = 1e-4;
const LAMP_PX: f64 = 4.0;

/// How fast it falls with the area of a larger one, and of a smaller one, which may be a glint. FIT.
const FALLS: f64 = 0.5;

/// Share of a frame that may be clipped at night, and how fast the headroom falls where it is more: a camera by day exposes
/// so little that no lamp is much brighter than a white wall. FIT.
const NIGHT: f64 = 0.005;
const BY_DAY: f64 = 1.0;

/// Light around a region from which on it is no lamp, and how far around, of the frame's diagonal: beside it and, at
/// corners, amid what is around. FIT.
const AMID: f32 = 0.5;
const AROUND: [f64; 2] = [0.01, 0.02];

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
    /// Sum of the light of some places around it that are not its own, and how many these are.
    around: (f32, u32),
}

impl Region {
    /// How much of a lamp it is by the light around it: 1 in the dark, 0 amid light that is half as bright.
    fn stands_out(&self) -> f32 {
        let (sum, n) = self.around;
        if n == 0 {
            return 0.0;
        }
        #[expect(clippy::cast_precision_loss, reason = "some places")]
        let light = (sum / n as f32 / AMID).min(1.0);
        let rest = 1.0 - light * light;
        rest * rest
    }
}

/// Steps right and down to places around one.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    reason = "px of a frame"
)]
fn places_around(n_pixels: usize, width: usize) -> [[isize; 2]; 8] {
    let diagonal_px = libm::hypot(width as f64, (n_pixels / width) as f64);
    let [a, b] = AROUND.map(|part| (part * diagonal_px).ceil() as isize);
    [
        [-a, 0],
        [a, 0],
        [0, -a],
        [0, a],
        [-b, -b],
        [b, -b],
        [-b, b],
        [b, b],
    ]
}

/// Steps to a neighbor beside a pixel and at its corner; depths are in thirds of a px.
const STEPS: [u32; 2] = [3, 4];

/// Makes what is clipped in a frame of 1 or 3 colors as bright as it is taken to have been with a headroom; returns the
/// pixels that it makes brighter, in their order. Of a pixel with a clipped color the others are brighter, too, the more
/// so the nearer they are to it: a lamp that is nearly white stays so. A red one stays red, and is not so bright.
pub(super) fn unclip(
    light: &mut [f32],
    n_colors: usize,
    width: usize,
    headroom: f64,
) -> Vec<usize> {
    let bright = pixels_with(light, n_colors, |value| value >= BORDER);
    let of = |at: usize| brightest(&light[at * n_colors..][..n_colors]);
    let n_clipped = bright.iter().filter(|at| of(**at) >= CLIPPED).count();
    if n_clipped == 0 {
        return Vec::new();
    }
    let n_pixels = light.len() / n_colors;
    let depths = depths(&bright, n_pixels, width);
    let (labels, regions) = regions(&bright, &depths, (n_pixels, width), of);
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    let (n_px, n_clipped) = (n_pixels as f64, n_clipped as f64);
    let lamp_px = (LAMP * n_px).max(LAMP_PX);
    let by_day = libm::pow((NIGHT * n_px / n_clipped).min(1.0), BY_DAY);
    // Deeper than three lamps' radii all is alike: a sky has no ridge.
    let radii_px = 3.0 * (lamp_px / std::f64::consts::PI).sqrt();
    #[expect(clippy::cast_possible_truncation, reason = "some px")]
    let deepest = (f64::from(STEPS[0]) * radii_px) as f32;
    let gains: Vec<f32> = (regions.iter())
        .map(|region| {
            let share = lamp_px / f64::from(region.n_pixels);
            let share = libm::pow(share.min(1.0 / share), FALLS);
            #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
            let gain = ((headroom - 1.0) * by_day * share) as f32;
            gain * region.stands_out()
        })
        .collect();
    let mut brighter = bright;
    brighter.retain(|at| {
        let region = labels[*at] as usize - 1;
        if !regions[region].is_clipped || gains[region] <= 0.0 {
            return false;
        }
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let part = (depths[*at] as f32 / (regions[region].depth as f32).min(deepest)).min(1.0);
        let pixel = &mut light[at * n_colors..][..n_colors];
        brighten(pixel, gains[region] * part * part);
        true
    });
    brighter
}

/// The light of a pixel's brightest color.
fn brightest(pixel: &[f32]) -> f32 {
    pixel.iter().fold(0.0, |most, value| most.max(*value))
}

/// The pixels of which a color is so bright, in their order.
pub(super) fn pixels_with(
    light: &[f32],
    n_colors: usize,
    is_bright: impl Fn(f32) -> bool,
) -> Vec<usize> {
    /// Pixels that are looked at together: most frames are dark but for some.
    const TOGETHER: usize = 32;
    let mut bright = Vec::new();
    let starts = (0..).step_by(TOGETHER);
    for (start, some) in starts.zip(light.chunks(TOGETHER * n_colors)) {
        let is_any = (some.iter()).fold(false, |any, value| any | is_bright(*value));
        if is_any {
            let pixels = (start..).zip(some.chunks_exact(n_colors));
            let pixels = pixels.filter(|(_, pixel)| is_bright(brightest(pixel)));
            bright.extend(pixels.map(|(at, _)| at));
        }
    }
    bright
}

/// Makes a pixel brighter by a factor of at most 1 and so much more.
fn brighten(pixel: &mut [f32], more: f32) {
    let brightest = brightest(pixel).max(f32::MIN_POSITIVE);
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

/// How far each bright pixel is from the next that is not, in steps, 0 where none is bright; beyond the frame it goes on.
fn depths(bright: &[usize], n_pixels: usize, width: usize) -> Vec<u32> {
    // Farther than any, and far from the largest number.
    const FAR: u32 = 1 << 28;
    let mut depths = vec![0; n_pixels];
    for at in bright {
        depths[*at] = FAR;
    }
    for at in bright {
        lessen(&mut depths, *at, width, -1);
    }
    for at in bright.iter().rev() {
        lessen(&mut depths, *at, width, 1);
    }
    depths
}

/// Lessens the depth of a pixel by those of its neighbors that a way through the frame, on or back, comes to before it:
/// one beside it and three of a row.
fn lessen(depths: &mut [u32], at: usize, width: usize, back: isize) {
    let [side, corner] = STEPS;
    let x = at % width;
    let (has_left, has_right) = (x > 0, x + 1 < width);
    let (has_back, has_on) = if back < 0 {
        (has_left, has_right)
    } else {
        (has_right, has_left)
    };
    let of = |at: usize, by: isize| depths[at.wrapping_add_signed(by)];
    let mut least = depths[at];
    if has_back {
        least = least.min(of(at, back) + side);
    }
    let row = at.checked_add_signed(back * width.cast_signed());
    if let Some(row) = row.filter(|row| *row < depths.len()) {
        least = least.min(of(row, 0) + side);
        if has_back {
            least = least.min(of(row, back) + corner);
        }
        if has_on {
            least = least.min(of(row, -back) + corner);
        }
    }
    depths[at] = least;
}

/// The region of each pixel and 1, 0 where there is none, and all regions: those that are part of another have its numbers.
fn regions(
    bright: &[usize],
    depths: &[u32],
    (n_pixels, width): (usize, usize),
    brightest: impl Fn(usize) -> f32,
) -> (Vec<u32>, Vec<Region>) {
    let mut labels = vec![0_u32; n_pixels];
    let mut regions: Vec<Region> = Vec::new();
    for at in bright.iter().copied() {
        let x = at % width;
        let region_at = |at: usize| (labels[at] as usize).checked_sub(1);
        let left = if x > 0 { region_at(at - 1) } else { None };
        let above = if at >= width {
            region_at(at - width)
        } else {
            None
        };
        let region = match (left, above) {
            (Some(one), Some(other)) => join(&mut regions, one, other),
            (Some(one), None) | (None, Some(one)) => whole(&mut regions, one),
            (None, None) => {
                regions.push(Region {
                    of: regions.len(),
                    n_pixels: 0,
                    depth: 0,
                    is_clipped: false,
                    around: (0.0, 0),
                });
                regions.len() - 1
            }
        };
        labels[at] = u32::try_from(region + 1).unwrap_or(u32::MAX);
        let region = &mut regions[region];
        region.n_pixels += 1;
        region.depth = region.depth.max(depths[at]);
        region.is_clipped |= brightest(at) >= CLIPPED;
    }
    let whole: Vec<usize> = (0..regions.len()).map(|k| whole(&mut regions, k)).collect();
    look_around(
        (bright, depths, &labels),
        width,
        &whole,
        &mut regions,
        brightest,
    );
    let regions = whole.iter().map(|of| regions[*of]).collect();
    (labels, regions)
}

/// Adds up the light around regions that are clipped: of places around their border that are not their own.
fn look_around(
    (bright, depths, labels): (&[usize], &[u32], &[u32]),
    width: usize,
    whole: &[usize],
    regions: &mut [Region],
    brightest: impl Fn(usize) -> f32,
) {
    let around = places_around(labels.len(), width);
    let region_at = |at: usize| {
        let region = (labels[at] as usize).checked_sub(1)?;
        Some(whole[region])
    };
    for at in bright.iter().copied() {
        let Some(own) = region_at(at).filter(|own| regions[*own].is_clipped) else {
            continue;
        };
        if depths[at] > STEPS[0] {
            continue;
        }
        let x = at % width;
        for [right, down] in around {
            let is_inside = x
                .checked_add_signed(right)
                .is_some_and(|there| there < width);
            let there = at.checked_add_signed(down * width.cast_signed() + right);
            let there = there.filter(|there| is_inside && *there < labels.len());
            if let Some(there) = there.filter(|there| region_at(*there) != Some(own)) {
                let region = &mut regions[own];
                region.around.0 += brightest(there);
                region.around.1 += 1;
            }
        }
    }
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
