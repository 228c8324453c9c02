//! A baked crack under the light of one environment.

use std::ops::Range;

use image::GrayImage;

use super::PhysicalOptics;
use super::elsewhere::{Averaged, Elsewhere};
use super::light::Colors;
use super::pattern::Pattern;
use crate::bit_rows::set_bits;
use crate::environment::{Environment, Rgb};
use crate::maps::CHUNK;
use crate::srgb::{code16_of_light, light_of_code16};

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
pub(crate) struct OverlayLayer {
    /// In the order of rows.
    pub(super) runs: Vec<Run>,
    /// What some runs keep of each color.
    pub(super) tinted: Vec<[[f32; CHUNK]; 3]>,
    pub(super) elsewhere: Vec<Elsewhere>,
    /// What of that is the mean over much of the frame.
    pub(super) averaged: Vec<Averaged>,
    /// Whether each lamp counts where light from elsewhere is averaged: that of drops.
    pub(super) has_drops: bool,
}

/// [`CHUNK`] pixels of a row.
#[derive(Debug, Clone)]
pub(super) struct Run {
    pub(super) x: usize,
    pub(super) y: usize,
    /// What is kept of every color, unless the run is tinted.
    pub(super) keep: [f32; CHUNK],
    /// What is added of each.
    pub(super) add: [[f32; CHUNK]; 3],
    /// Bit k is set where the crack does anything to pixel k; the others stay as they are.
    pub(super) touched: u32,
    /// Place among the runs that keep more of one color than of another.
    pub(super) tinted: Option<usize>,
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
pub(super) const LEAST_INFLUENCE: f32 = 2e-4;

/// A smaller share of light from elsewhere is taken from the pixel itself.
pub(crate) const LEAST_ELSEWHERE: f32 = 5e-4;

impl Overlay {
    pub(super) fn new(
        pattern: &Pattern,
        environment: &Environment,
        optics: &PhysicalOptics,
        memory: Option<Self>,
    ) -> Self {
        let colors = Colors::of(environment, &optics.glass);
        let layers = pattern.layers().iter().zip(layers_of(memory));
        let layers = layers.map(|(layer, memory)| OverlayLayer::lit(layer, colors, memory));
        let frame = (pattern.size(), pattern.f_px());
        Self::of_layers(frame, environment, optics, layers.collect())
    }

    pub(crate) fn of_layers(
        (size, f_px): ((u32, u32), f64),
        environment: &Environment,
        optics: &PhysicalOptics,
        layers: Vec<OverlayLayer>,
    ) -> Self {
        Self {
            size,
            layers,
            optics: *optics,
            f_px,
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
            let mut run = Run::untouched((x, y));
            let mut tinted = [[1.0; CHUNK]; 3];
            for k in 0..CHUNK.min(width - x) {
                let (keep, add) = pixel(x + k, y);
                let lost = keep.map(|keep| 1.0 - keep);
                if lost
                    .into_iter()
                    .chain(add)
                    .any(|share| share >= LEAST_INFLUENCE)
                {
                    run.touched |= 1 << k;
                    let lanes = tinted.iter_mut().zip(&mut run.add);
                    for ((kept, added), (keep, add)) in lanes.zip(keep.into_iter().zip(add)) {
                        (kept[k], added[k]) = (keep, add);
                    }
                }
            }
            if run.touched != 0 {
                run.tinted = Some(layer.tinted.len());
                layer.tinted.push(tinted);
                layer.runs.push(run);
            }
        }
        Self::of_layers((size, f_px), environment, optics, vec![layer])
    }

    /// Whether [`Overlay::apply`] leaves every image as it is: nothing is broken in the frame, and
    /// the lens adds nothing of its own.
    #[must_use]
    pub fn changes_nothing(&self) -> bool {
        self.layers.is_empty() && self.changes_runs_alone()
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
            let code = code16_of_light(ground[c].min(1.0));
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a code"
            )]
            let step = (threshold * 65535.0) as u16;
            match code.checked_add(step) {
                Some(raised) => {
                    (light_of_code16(raised) - light_of_code16(code)).max(LEAST_INFLUENCE)
                }
                // Brighter than white: what darkens it counts as much.
                None => light_of_code16(code) - light_of_code16(code.saturating_sub(step)),
            }
        });
        for layer in &self.layers {
            for run in &layer.runs {
                let row = &mut mask.as_mut()[run.y * width..(run.y + 1) * width];
                let codes = run.influence_codes(layer.keep(run), threshold, visible);
                for (pixel, code) in row.iter_mut().skip(run.x).zip(codes) {
                    *pixel |= code;
                }
            }
        }
        mask
    }

    /// Radius of the disc that a point of the scene becomes, px; 0 where it is in focus.
    #[must_use]
    pub fn scene_blur_radius_px(&self) -> f64 {
        self.scene_px().abs()
    }

    /// Mean distance, px, that the image's own light in some columns and rows (from the first to
    /// one after the last) was moved: Σ W·|d| / Σ (K + W), as in [`Damage`](crate::Damage).
    #[must_use]
    pub fn mean_displacement_px(&self, xs: [u32; 2], ys: [u32; 2]) -> f64 {
        let [xs, ys] = [xs, ys].map(|[from, to]| from as usize..to as usize);
        // A row of what [`Run::moved`] gives.
        let untouched = [1.0, 0.0, 0.0];
        let mut row = vec![untouched; xs.len()];
        let (mut light, mut moved) = (0.0, 0.0);
        for y in ys {
            let mut is_touched = false;
            for layer in &self.layers {
                for run in layer.runs_in(&xs, y) {
                    is_touched = true;
                    let keep = layer.keep(run);
                    let other = run.elsewhere.map(|place| &layer.elsewhere[place]);
                    let (first, end) = (xs.start.saturating_sub(run.x), xs.end - run.x);
                    for k in first..end.min(CHUNK) {
                        let pixel = &mut row[run.x + k - xs.start];
                        *pixel = run.moved(k, keep, other, *pixel);
                    }
                }
            }
            if is_touched {
                for [keep, share, distance] in &row {
                    light += keep + share;
                    moved += distance;
                }
                row.fill(untouched);
            } else {
                #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
                let n_untouched = xs.len() as f64;
                light += n_untouched;
            }
        }
        if moved > 0.0 { moved / light } else { 0.0 }
    }

    /// Share of an image's light that comes through at each pixel, from there or from another place.
    #[must_use]
    pub fn passing(&self) -> Vec<f32> {
        let maps = self.maps();
        let of = maps.attenuation.iter().zip(&maps.elsewhere);
        of.map(|(lost, elsewhere)| (1.0 - lost + elsewhere).min(1.0))
            .collect()
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
                let of_color = layer.keep(run);
                for k in 0..CHUNK.min(width - run.x) {
                    let at = run.y * width + run.x + k;
                    let kept = of_color.map(|keep| keep[k]);
                    let keep = (kept[0] + kept[1] + kept[2]) / 3.0;
                    maps.attenuation[at] = 1.0 - (1.0 - maps.attenuation[at]) * keep;
                    for (c, kept) in kept.into_iter().enumerate() {
                        maps.added[at][c] = maps.added[at][c] * kept + run.add[c][k];
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

/// The layers of an overlay that is no longer needed, for their memory, then empty ones.
pub(super) fn layers_of(memory: Option<Overlay>) -> impl Iterator<Item = OverlayLayer> {
    let known = memory.into_iter().flat_map(|overlay| overlay.layers);
    known.chain(std::iter::repeat_with(OverlayLayer::default))
}

impl OverlayLayer {
    /// What a run keeps of each color.
    pub(super) fn keep<'a>(&'a self, run: &'a Run) -> [&'a [f32; CHUNK]; 3] {
        match run.tinted {
            Some(place) => self.tinted[place].each_ref(),
            None => [&run.keep; 3],
        }
    }

    /// The runs of a row that reach into some columns.
    fn runs_in(&self, xs: &Range<usize>, y: usize) -> impl Iterator<Item = &Run> {
        let first = self.runs.partition_point(|run| run.y < y);
        let of_row = self.runs[first..].iter().take_while(move |run| run.y == y);
        of_row.filter(|run| run.x < xs.end && xs.start < run.x + CHUNK)
    }
}

impl Run {
    /// A run that changes nothing.
    pub(super) fn untouched((x, y): (usize, usize)) -> Self {
        Self {
            x,
            y,
            keep: [1.0; CHUNK],
            add: [[0.0; CHUNK]; 3],
            touched: 0,
            tinted: None,
            elsewhere: None,
        }
    }

    /// Behind this run too: what pixel k keeps of its light, its share of other light, and that
    /// times the distance, px, it comes from.
    fn moved(
        &self,
        k: usize,
        keep: [&[f32; CHUNK]; 3],
        other: Option<&Elsewhere>,
        pixel: [f64; 3],
    ) -> [f64; 3] {
        let keep = f64::from((keep[0][k] + keep[1][k] + keep[2][k]) / 3.0);
        let [kept, share, distance] = pixel.map(|before| before * keep);
        let Some(other) = other.filter(|other| other.share[k] > 0.0) else {
            return [kept, share, distance];
        };
        #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
        let own = [(self.x + k) as f64 + 0.5, self.y as f64 + 0.5];
        let du = f64::from(other.u[k]) - own[0];
        let dv = f64::from(other.v[k]) - own[1];
        let more = f64::from(other.share[k]);
        let distance = distance + more * (du * du + dv * dv).sqrt();
        [kept, share + more, distance]
    }

    /// The pixels that the crack does anything to, among the first `n`.
    pub(super) fn touched_among(&self, n: usize) -> impl Iterator<Item = usize> + use<> {
        set_bits(self.touched.into()).take_while(move |k| *k < n)
    }

    /// 255 where a pixel loses at least this share of its light, or visibly more or less is
    /// added, else 0.
    fn influence_codes(
        &self,
        keep: [&[f32; CHUNK]; 3],
        threshold: f32,
        visible: [f32; 3],
    ) -> [u8; CHUNK] {
        std::array::from_fn(|k| {
            let mut influences = false;
            for (c, visible) in visible.into_iter().enumerate() {
                influences |= (1.0 - keep[c][k]).abs() >= threshold;
                influences |= self.add[c][k].abs() >= visible;
            }
            u8::from(influences).wrapping_neg()
        })
    }
}
