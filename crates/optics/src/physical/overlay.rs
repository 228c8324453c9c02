//! A baked crack under the light of one environment.

use image::GrayImage;

use super::PhysicalOptics;
use super::elsewhere::Elsewhere;
use super::pattern::{Pattern, PatternLayer};
use crate::environment::{Environment, Rgb};
use crate::maps::CHUNK;
use crate::srgb::{decode16, encode16};
use crate::surface::{CABIN, FRAME, FRAME_U, FRAME_V, GROUND, HORIZON, N_SHARES, SUN, ZENITH};

/// A baked crack under the light of one environment: what to do to each pixel of an image.
///
/// Light out = `keep` · light in + `add` + share · light at another place of the frame.
#[derive(Debug, Clone)]
pub struct Overlay {
    pub(super) size: (u32, u32),
    pub(super) layers: Vec<OverlayLayer>,
    pub(super) optics: PhysicalOptics,
    pub(super) f_px: f64,
    environment: Environment,
}

/// One layer of it.
#[derive(Debug, Clone, Default)]
pub(super) struct OverlayLayer {
    pub(super) runs: Vec<Run>,
    pub(super) elsewhere: Vec<Elsewhere>,
}

/// [`CHUNK`] pixels of a row, per color.
#[derive(Debug, Clone)]
pub(super) struct Run {
    pub(super) x: usize,
    pub(super) y: usize,
    pub(super) keep: [[f32; CHUNK]; 3],
    pub(super) add: [[f32; CHUNK]; 3],
    /// Place among the runs that take light from elsewhere in the frame.
    pub(super) elsewhere: Option<usize>,
}

/// Per-pixel maps of an overlay, row by row.
///
/// With I the linear light of the image, 1 for white, the light that comes out is
/// I·(1 − `attenuation`) + `added` + `elsewhere` · I(at pixel + `displacement`).
#[derive(Debug, Clone, PartialEq)]
pub struct OpticalMaps {
    /// Width of the frame, px.
    pub width: u32,
    /// Height of the frame, px.
    pub height: u32,
    /// Share of the image's light that is lost, the mean of the colors.
    pub attenuation: Vec<f32>,
    /// Light that is added, linear, red, green and blue, without what comes from the image.
    pub added: Vec<[f32; 3]>,
    /// Share of light from another place of the image.
    pub elsewhere: Vec<f32>,
    /// From a pixel to that place, px, right and down; 0 where the share is 0.
    pub displacement: Vec<[f32; 2]>,
}

/// Less influence is none: below a step of an 8-bit image.
const LEAST_INFLUENCE: f32 = 2e-4;

/// A smaller share of light from elsewhere is taken from the pixel itself.
pub(crate) const LEAST_ELSEWHERE: f32 = 5e-4;

impl Overlay {
    pub(super) fn new(
        pattern: &Pattern,
        environment: &Environment,
        optics: &PhysicalOptics,
    ) -> Self {
        Self {
            size: pattern.size(),
            layers: pattern
                .layers()
                .iter()
                .map(|layer| OverlayLayer::new(layer, environment))
                .collect(),
            optics: *optics,
            f_px: pattern.f_px(),
            environment: *environment,
        }
    }

    /// Of what each pixel (x, y) keeps of its light and what is added, per color; pixels of no
    /// influence stay as they are.
    pub(crate) fn of_pixels(
        (size, f_px): ((u32, u32), f64),
        environment: &Environment,
        optics: &PhysicalOptics,
        pixel: impl Fn(usize, usize) -> (Rgb, Rgb),
    ) -> Self {
        let (width, height) = (size.0 as usize, size.1 as usize);
        let mut layer = OverlayLayer::default();
        for (x, y) in (0..height).flat_map(|y| (0..width).step_by(CHUNK).map(move |x| (x, y))) {
            let mut run = Run {
                x,
                y,
                keep: [[1.0; CHUNK]; 3],
                add: [[0.0; CHUNK]; 3],
                elsewhere: None,
            };
            let mut is_touched = false;
            for k in 0..CHUNK.min(width - x) {
                let (keep, add) = pixel(x + k, y);
                let lost = keep.map(|keep| 1.0 - keep);
                if lost
                    .into_iter()
                    .chain(add)
                    .any(|share| share >= LEAST_INFLUENCE)
                {
                    is_touched = true;
                    for c in 0..3 {
                        run.keep[c][k] = keep[c];
                        run.add[c][k] = add[c];
                    }
                }
            }
            if is_touched {
                layer.runs.push(run);
            }
        }
        Self {
            size,
            layers: vec![layer],
            optics: *optics,
            f_px,
            environment: *environment,
        }
    }

    /// The light it is under.
    #[must_use]
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Where the crack influences the image by at least `region_threshold`: 255, else 0.
    ///
    /// It is the greater of what a pixel loses of its own light and of what the added light
    /// changes, in codes over the greatest code, in a pixel as bright as the ground. It does not
    /// depend on what the image shows there, so that a crack before a scene of its own
    /// brightness counts as well.
    #[must_use]
    pub fn region(&self) -> GrayImage {
        #[expect(clippy::cast_possible_truncation, reason = "a threshold as f32")]
        let threshold = self.optics.region_threshold as f32;
        let (width, height) = self.size;
        let mut mask = GrayImage::new(width, height);
        let width = width as usize;
        // Light that raises the ground's code by the threshold.
        let ground = self.environment.ground_rgb;
        let visible: [f32; 3] = std::array::from_fn(|c| {
            let code = encode16(ground[c].min(1.0));
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a code"
            )]
            let step = (threshold * 65535.0) as u16;
            match code.checked_add(step) {
                Some(raised) => (decode16(raised) - decode16(code)).max(LEAST_INFLUENCE),
                // Brighter than white: what darkens it counts as much.
                None => decode16(code) - decode16(code.saturating_sub(step)),
            }
        });
        for run in self.layers.iter().flat_map(|layer| &layer.runs) {
            let row = &mut mask.as_mut()[run.y * width..(run.y + 1) * width];
            for (k, pixel) in row.iter_mut().skip(run.x).take(CHUNK).enumerate() {
                if run.influences(k, threshold, visible) {
                    *pixel = 255;
                }
            }
        }
        mask
    }

    /// Radius of the disc that a point of the scene becomes, px; 0 where it is in focus or
    /// nothing is broken.
    #[must_use]
    pub fn scene_blur_radius_px(&self) -> f64 {
        if self.layers.is_empty() {
            return 0.0;
        }
        let lens = &self.optics.lens;
        (0.5 * lens.circle_of_confusion_px(self.f_px, lens.scene_m)).abs()
    }

    /// Mean distance, px, that the image's own light in some columns and rows (from the first to
    /// one after the last) was moved: Σ W·|d| / Σ (K + W), as in [`Damage`](crate::Damage).
    #[must_use]
    pub fn mean_displacement_px(&self, xs: [u32; 2], ys: [u32; 2]) -> f64 {
        let [xs, ys] = [xs, ys].map(|[from, to]| from as usize..to as usize);
        // Of each pixel: what it keeps of its light, its share of other light, and that times the
        // distance it comes from.
        let mut pixels = vec![[1.0, 0.0, 0.0]; xs.len() * ys.len()];
        for layer in &self.layers {
            for run in layer.runs.iter().filter(|run| ys.contains(&run.y)) {
                let other = run.elsewhere.map(|place| &layer.elsewhere[place]);
                for k in (0..CHUNK).filter(|k| xs.contains(&(run.x + k))) {
                    let at = (run.y - ys.start) * xs.len() + run.x + k - xs.start;
                    let keep = f64::from((run.keep[0][k] + run.keep[1][k] + run.keep[2][k]) / 3.0);
                    pixels[at] = pixels[at].map(|before| before * keep);
                    if let Some(other) = other.filter(|other| other.share[k] > 0.0) {
                        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
                        let own = [(run.x + k) as f64 + 0.5, run.y as f64 + 0.5];
                        let du = f64::from(other.u[k]) - own[0];
                        let dv = f64::from(other.v[k]) - own[1];
                        let share = f64::from(other.share[k]);
                        pixels[at][1] += share;
                        pixels[at][2] += share * (du * du + dv * dv).sqrt();
                    }
                }
            }
        }
        let (light, moved) = pixels.iter().fold((0.0, 0.0), |(light, moved), pixel| {
            (light + pixel[0] + pixel[1], moved + pixel[2])
        });
        if moved > 0.0 { moved / light } else { 0.0 }
    }

    /// The maps, pixel by pixel.
    #[must_use]
    pub fn maps(&self) -> OpticalMaps {
        let (width, height) = self.size;
        let n = width as usize * height as usize;
        let mut maps = OpticalMaps {
            width,
            height,
            attenuation: vec![0.0; n],
            added: vec![[0.0; 3]; n],
            elsewhere: vec![0.0; n],
            displacement: vec![[0.0; 2]; n],
        };
        let width = width as usize;
        for layer in &self.layers {
            for run in &layer.runs {
                for k in 0..CHUNK.min(width - run.x) {
                    let at = run.y * width + run.x + k;
                    let keep = (run.keep[0][k] + run.keep[1][k] + run.keep[2][k]) / 3.0;
                    maps.attenuation[at] = 1.0 - (1.0 - maps.attenuation[at]) * keep;
                    for c in 0..3 {
                        maps.added[at][c] = maps.added[at][c] * run.keep[c][k] + run.add[c][k];
                    }
                    // What an earlier layer took from elsewhere this one attenuates, and may add
                    // to; the place is the mean of both.
                    let before = maps.elsewhere[at] * keep;
                    maps.elsewhere[at] = before;
                    let Some(place) = run.elsewhere else {
                        continue;
                    };
                    let other = &layer.elsewhere[place];
                    let sum = before + other.share[k];
                    if other.share[k] > 0.0 {
                        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
                        let own = [(run.x + k) as f32 + 0.5, run.y as f32 + 0.5];
                        let to = [other.u[k] - own[0], other.v[k] - own[1]];
                        for (mean, to) in maps.displacement[at].iter_mut().zip(to) {
                            *mean += (to - *mean) * other.share[k] / sum;
                        }
                        maps.elsewhere[at] = sum;
                    }
                }
            }
        }
        maps
    }
}

impl Run {
    /// Whether a pixel loses at least this share of its light, or visibly more or less is added.
    fn influences(&self, k: usize, threshold: f32, visible: [f32; 3]) -> bool {
        (0..3).any(|c| {
            (1.0 - self.keep[c][k]).abs() >= threshold || self.add[c][k].abs() >= visible[c]
        })
    }
}

/// By how much more than the mean a color is reflected, over that mean: −1 where none of it is,
/// 2 where all is of this color, and no more than there is to reflect.
fn tint_of(color: f32, lit_share: f32, share: f32) -> f32 {
    if lit_share <= LEAST_INFLUENCE {
        return 0.0;
    }
    let most = ((1.0 - share) / lit_share).clamp(0.0, 2.0);
    (color / lit_share).clamp(-1.0, most)
}

impl OverlayLayer {
    fn new(layer: &PatternLayer, environment: &Environment) -> Self {
        let mut overlay = Self {
            runs: Vec::with_capacity(layer.light.n_runs()),
            elsewhere: Vec::new(),
        };
        let lit: [(usize, Rgb); 5] = [
            (HORIZON, environment.horizon_rgb),
            (ZENITH, environment.zenith_rgb),
            (GROUND, environment.ground_rgb),
            (CABIN, environment.cabin_rgb),
            (SUN, environment.sun_rgb),
        ];
        let brightest = lit.map(|(lane, rgb)| (lane, rgb.into_iter().fold(1.0, f32::max)));
        for (x, y, pixels) in layer.light.iter() {
            let tint = layer.tint.run_at(x, y);
            let mut run = Run {
                x,
                y,
                keep: [[1.0; CHUNK]; 3],
                add: [[0.0; CHUNK]; 3],
                elsewhere: None,
            };
            let mut other = Elsewhere::new();
            let (mut is_touched, mut has_other) = (false, false);
            for (k, lanes) in pixels.iter().enumerate() {
                let mut lanes = *lanes;
                let most: f32 = brightest
                    .iter()
                    .map(|(lane, color)| lanes[*lane].abs() * color)
                    .sum();
                if most + lanes[FRAME].abs() < LEAST_INFLUENCE {
                    continue;
                }
                let mut share: f32 = lanes[..N_SHARES].iter().sum();
                if share > 1.0 {
                    // Facets of different blur over each other.
                    for lane in &mut lanes {
                        *lane /= share;
                    }
                    share = 1.0;
                }
                // The steps of a kernel leave a trace of less than nothing beside a glint; under the
                // sun it would be a black pixel.
                lanes[SUN] = lanes[SUN].max(0.0);
                let mut add = [0.0_f32; 3];
                for (lane, rgb) in &lit {
                    for (sum, color) in add.iter_mut().zip(rgb) {
                        *sum += lanes[*lane] * color;
                    }
                }
                let most = add
                    .iter()
                    .fold(share.abs(), |most, add| most.max(add.abs()));
                if most < LEAST_INFLUENCE {
                    continue;
                }
                is_touched = true;
                let lit_share = share - lanes[FRAME];
                let tints = match tint.map(|tint| tint[k]) {
                    Some([_, red, green, blue]) if red != 0.0 || green != 0.0 || blue != 0.0 => {
                        [red, green, blue].map(|color| tint_of(color, lit_share, share))
                    }
                    _ => [0.0; 3],
                };
                for (c, tint) in tints.into_iter().enumerate() {
                    // What is reflected more of one color is so at the expense of what passes,
                    // and by as much: nothing is lost.
                    run.keep[c][k] = 1.0 - share - lit_share * tint;
                    run.add[c][k] = add[c] * (1.0 + tint);
                }
                if lanes[FRAME] > LEAST_ELSEWHERE {
                    has_other = true;
                    other.set(k, [lanes[FRAME], lanes[FRAME_U], lanes[FRAME_V]]);
                    let beside = [(x + k + 1, y), (x + k, y + 1)].map(|(x, y)| {
                        let lanes = layer.light.pixel(x, y)?;
                        (lanes[FRAME] > LEAST_ELSEWHERE)
                            .then(|| [lanes[FRAME_U] / lanes[FRAME], lanes[FRAME_V] / lanes[FRAME]])
                    });
                    other.widen(k, beside, layer.blur_px);
                } else {
                    for keep in &mut run.keep {
                        keep[k] += lanes[FRAME];
                    }
                }
            }
            if has_other {
                run.elsewhere = Some(overlay.elsewhere.len());
                overlay.elsewhere.push(other);
            }
            if is_touched {
                overlay.runs.push(run);
            }
        }
        overlay
    }
}
