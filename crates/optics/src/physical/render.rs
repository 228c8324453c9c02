//! An overlay over images: in place where only some pixels change, over the whole frame where
//! the scene is out of focus too.

use image::DynamicImage;
use starbreak_glass::CrackNetwork;
use starbreak_seed::Seed;

use super::defocus::defocus;
use super::noise::Noise;
use super::overlay::{Overlay, OverlayLayer, Run};
use super::samples::{Layout, Sample, per_color};
use super::{PhysicalOptics, bake};
use crate::environment::Environment;
use crate::maps::{CHUNK, Pupil};
use crate::{Before, Masks, OpticsError, View};

/// A scene blurred by less, px of radius, is sharp.
const SHARP_PX: f64 = 0.05;

/// What [`render`] leaves beside the image.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// Where the image changed, and where the cracks are.
    pub masks: Masks,
    /// What was done to each pixel, and under which light.
    pub overlay: Overlay,
}

/// Renders a network as far as it has grown at `time` over the image, in place: [`bake`], the
/// light of the image's own [environment](Environment::estimate), and [`Overlay::apply`].
///
/// Where nothing is broken the image stays as it is, to the byte, but for what the lens does to it:
/// a scene out of focus and veiling glare are the camera's, not the crack's.
///
/// # Errors
/// As for [`bake`] and [`Overlay::apply`].
pub fn render(
    image: &mut DynamicImage,
    network: &CrackNetwork,
    time: f64,
    view: &View,
    optics: &PhysicalOptics,
    seed: Seed,
) -> Result<Rendered, OpticsError> {
    let pattern = bake(network, time, view, optics, seed)?;
    let environment = Environment::estimate(image, &optics.environment, pattern.f_px());
    let overlay = pattern.light(&environment, optics);
    overlay.apply(image, seed)?;
    Ok(Rendered {
        masks: Masks {
            region: overlay.region(),
            crack: pattern.coverage(),
        },
        overlay,
    })
}

impl Overlay {
    /// Puts the crack over an image, in place.
    ///
    /// In linear light, I₁ = (1 − A) I₀ + β + Σ W I₀(x + d); the sum is clipped once, when it is
    /// encoded. Only pixels that the crack touches are read and written, unless the scene is out
    /// of focus or `veiling_glare` spreads light over the frame. Alpha is never changed; grey
    /// images get the luminance of what is added. The seed is that of the sensor's noise.
    ///
    /// # Errors
    /// [`OpticsError`] for an image without pixels or of another size than the overlay, or one
    /// whose samples are floating point.
    pub fn apply(&self, image: &mut DynamicImage, seed: Seed) -> Result<(), OpticsError> {
        self.change(image, (Part::All, seed))
    }

    /// What [`Overlay::apply`] does to linear light of 1 or 3 colors, in place, which may be brighter than white. Then
    /// [`Overlay::apply_noise`] adds what the sensor does.
    pub fn over_light(&self, light: &mut Vec<f32>, n_colors: usize) {
        match n_colors {
            1 => self.over_colors::<1>(light),
            _ => self.over_colors::<3>(light),
        }
    }

    /// The sensor's noise alone.
    ///
    /// # Errors
    /// As [`Overlay::apply`].
    pub fn apply_noise(&self, image: &mut DynamicImage, seed: Seed) -> Result<(), OpticsError> {
        self.change(image, (Part::Noise, seed))
    }

    /// Refuses an image that it cannot be put over.
    ///
    /// # Errors
    /// As [`Overlay::apply`], but for the kind of samples.
    pub fn check_size(&self, image: &DynamicImage) -> Result<(), OpticsError> {
        self.check_size_of((image.width(), image.height()))
    }

    pub(super) fn check_size_of(&self, (width, height): (u32, u32)) -> Result<(), OpticsError> {
        if width == 0 || height == 0 {
            return Err(OpticsError::EmptyImage { width, height });
        }
        if self.size != (width, height) {
            return Err(OpticsError::SizeMismatch {
                width,
                height,
                drawn_width: self.size.0 as usize,
                drawn_height: self.size.1 as usize,
            });
        }
        Ok(())
    }

    fn change(&self, image: &mut DynamicImage, part: (Part, Seed)) -> Result<(), OpticsError> {
        self.check_size(image)?;
        match image {
            DynamicImage::ImageLuma8(image) => self.over(Layout::<1, 0>, image.as_mut(), part),
            DynamicImage::ImageLumaA8(image) => self.over(Layout::<1, 1>, image.as_mut(), part),
            DynamicImage::ImageRgb8(image) => self.over(Layout::<3, 0>, image.as_mut(), part),
            DynamicImage::ImageRgba8(image) => self.over(Layout::<3, 1>, image.as_mut(), part),
            DynamicImage::ImageLuma16(image) => self.over(Layout::<1, 0>, image.as_mut(), part),
            DynamicImage::ImageLumaA16(image) => self.over(Layout::<1, 1>, image.as_mut(), part),
            DynamicImage::ImageRgb16(image) => self.over(Layout::<3, 0>, image.as_mut(), part),
            DynamicImage::ImageRgba16(image) => self.over(Layout::<3, 1>, image.as_mut(), part),
            other => {
                return Err(OpticsError::ImageMode {
                    mode: format!("{:?}", other.color()),
                });
            }
        }
        Ok(())
    }

    /// What an image shows before [`Overlay::apply`], as far as that changes it: most of it
    /// stays as it is, unless the scene is out of focus or `veiling_glare` spreads light over the
    /// frame.
    #[must_use]
    pub fn before(&self, image: &DynamicImage) -> Before {
        if self.size != (image.width(), image.height()) || !self.changes_runs_alone() {
            return Before::whole(image.clone());
        }
        let runs = self.layers.iter().flat_map(|layer| &layer.runs);
        let mut starts: Vec<(usize, usize)> = runs.map(|run| (run.x, run.y)).collect();
        // Those of each layer are sorted.
        if self.layers.len() > 1 {
            starts.sort_by_key(|(x, y)| (*y, *x));
            starts.dedup();
        }
        Before::of_runs(image, starts)
    }

    /// Whether pixels that the crack does not touch stay as they are.
    pub(super) fn changes_runs_alone(&self) -> bool {
        let is_sharp = self.scene_px().abs() < SHARP_PX;
        is_sharp && self.optics.veiling_glare <= 0.0
    }

    /// Radius, px, of the disc that a point of the scene becomes, below 0 where it is nearer than
    /// the focus.
    pub(super) fn scene_px(&self) -> f64 {
        let lens = &self.optics.lens;
        0.5 * lens.circle_of_confusion_px(self.f_px, lens.scene_m)
    }

    fn over<S: Sample, const COLORS: usize, const EXTRA: usize>(
        &self,
        layout: Layout<COLORS, EXTRA>,
        samples: &mut [S],
        (part, seed): (Part, Seed),
    ) {
        if part == Part::Noise {
            self.add_noise(layout, samples, seed);
        } else if self.changes_runs_alone() {
            let width = self.size.0 as usize;
            for layer in &self.layers {
                layer.over(layout, samples, width, self.noise(seed).as_ref());
            }
        } else {
            self.over_all(layout, samples, seed);
        }
    }

    /// Over a scene that is out of focus, or under glare: every pixel.
    fn over_all<S: Sample, const COLORS: usize, const EXTRA: usize>(
        &self,
        layout: Layout<COLORS, EXTRA>,
        samples: &mut [S],
        seed: Seed,
    ) {
        let stride = Layout::<COLORS, EXTRA>::STRIDE;
        let mut light: Vec<f32> = samples
            .chunks_exact(stride)
            .flat_map(|pixel| pixel[..COLORS].iter().map(|sample| sample.light()))
            .collect();
        self.over_colors::<COLORS>(&mut light);
        for (pixel, light) in samples
            .chunks_exact_mut(stride)
            .zip(light.chunks_exact(COLORS))
        {
            for (sample, light) in pixel.iter_mut().zip(light) {
                *sample = S::code(*light);
            }
        }
        self.add_noise(layout, samples, seed);
    }

    fn over_colors<const COLORS: usize>(&self, light: &mut Vec<f32>) {
        let size = (self.size.0 as usize, self.size.1 as usize);
        let scene_px = self.scene_px();
        if scene_px.abs() >= SHARP_PX {
            let pupil = Pupil::of(&self.optics.lens);
            *light = defocus::<COLORS>(light, size, pupil, scene_px);
        }
        for layer in &self.layers {
            layer.over(Layout::<COLORS, 0>, light, size.0, None);
        }
        if self.optics.veiling_glare > 0.0 {
            veil::<COLORS>(light, self.optics.veiling_glare);
        }
    }

    fn add_noise<S: Sample, const COLORS: usize, const EXTRA: usize>(
        &self,
        layout: Layout<COLORS, EXTRA>,
        samples: &mut [S],
        seed: Seed,
    ) {
        if let Some(noise) = self.noise(seed) {
            for layer in &self.layers {
                layer.add_noise(layout, samples, self.size.0 as usize, &noise);
            }
        }
    }

    pub(super) fn noise(&self, seed: Seed) -> Option<Noise> {
        let params = self.optics.noise?;
        (params.read > 0.0 || params.shot > 0.0).then_some(Noise { params, seed })
    }
}

/// What is done to an image.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    All,
    Noise,
}

impl OverlayLayer {
    /// Over the samples of an image, or its light, in place.
    fn over<S: Sample, const COLORS: usize, const EXTRA: usize>(
        &self,
        _: Layout<COLORS, EXTRA>,
        samples: &mut [S],
        width: usize,
        noise: Option<&Noise>,
    ) {
        let stride = Layout::<COLORS, EXTRA>::STRIDE;
        let height = samples.len() / (width * stride);
        // All of it before anything is changed: a place may lie anywhere in the frame.
        let mut elsewhere = Vec::new();
        let light = |x: usize, y: usize| {
            let pixel = &samples[(y * width + x) * stride..][..COLORS];
            std::array::from_fn(|c| pixel[c].light())
        };
        self.gather::<COLORS>((width, height), light, &mut elsewhere);
        pulp::Arch::new().dispatch(OverRuns::<S, COLORS, EXTRA> {
            layer: self,
            samples,
            width,
            elsewhere: &elsewhere,
            noise,
        });
    }

    /// Adds noise to samples that have been rendered without.
    fn add_noise<S: Sample, const COLORS: usize, const EXTRA: usize>(
        &self,
        _: Layout<COLORS, EXTRA>,
        samples: &mut [S],
        width: usize,
        noise: &Noise,
    ) {
        let stride = Layout::<COLORS, EXTRA>::STRIDE;
        for run in &self.runs {
            let units = noise.of_run::<COLORS>(run, width);
            let first = (run.y * width + run.x) * stride;
            for k in 0..CHUNK.min(width - run.x) {
                let (keep, _) = run.pixel::<COLORS>(k, self.keep(run), None);
                for c in 0..COLORS {
                    let sample = &mut samples[first + k * stride + c];
                    let light = sample.light();
                    let missing = noise.missing(keep[c], light, light);
                    *sample = S::code(light + missing * units[k][c]);
                }
            }
        }
    }
}

/// All runs of a layer over the samples of an image, compiled once more for processors with AVX2,
/// as far as it is inlined. No result depends on it: nothing is fused.
struct OverRuns<'a, S, const COLORS: usize, const EXTRA: usize> {
    layer: &'a OverlayLayer,
    samples: &'a mut [S],
    width: usize,
    elsewhere: &'a [[[f32; CHUNK]; COLORS]],
    noise: Option<&'a Noise>,
}

impl<S: Sample, const COLORS: usize, const EXTRA: usize> pulp::WithSimd
    for OverRuns<'_, S, COLORS, EXTRA>
{
    type Output = ();

    #[inline(always)]
    fn with_simd<V: pulp::Simd>(self, _: V) {
        let stride = Layout::<COLORS, EXTRA>::STRIDE;
        for run in &self.layer.runs {
            let n = CHUNK.min(self.width - run.x);
            let first = (run.y * self.width + run.x) * stride;
            let pixels = &mut self.samples[first..first + n * stride];
            let keep = self.layer.keep(run);
            let other = run.elsewhere.map(|place| &self.elsewhere[place]);
            match self.noise {
                None => run.over::<S, COLORS, EXTRA>(pixels, keep, other),
                Some(noise) => run.over_with_noise::<S, COLORS, EXTRA>(
                    pixels,
                    (keep, other),
                    noise,
                    self.width,
                ),
            }
        }
    }
}

/// What a run keeps of each color, and light from elsewhere.
type Behind<'a, const COLORS: usize> = ([&'a [f32; CHUNK]; 3], Option<&'a [[f32; CHUNK]; COLORS]>);

impl Run {
    /// What is kept and added of each color of a pixel, light from elsewhere included.
    #[inline]
    fn pixel<const COLORS: usize>(
        &self,
        k: usize,
        keep: [&[f32; CHUNK]; 3],
        other: Option<&[[f32; CHUNK]; COLORS]>,
    ) -> ([f32; COLORS], [f32; COLORS]) {
        let keep = per_color(keep.map(|keep| keep[k]));
        let mut add = per_color([self.add[0][k], self.add[1][k], self.add[2][k]]);
        if let Some(other) = other {
            for (sum, more) in add.iter_mut().zip(other) {
                *sum += more[k];
            }
        }
        (keep, add)
    }

    /// Light is looked up pixel by pixel, computed color by color, and looked up as codes pixel by
    /// pixel again.
    #[inline(always)]
    pub(super) fn over<S: Sample, const COLORS: usize, const EXTRA: usize>(
        &self,
        pixels: &mut [S],
        keep: [&[f32; CHUNK]; 3],
        other: Option<&[[f32; CHUNK]; COLORS]>,
    ) {
        let stride = Layout::<COLORS, EXTRA>::STRIDE;
        let mut light = [[0.0; CHUNK]; COLORS];
        for (k, pixel) in pixels.chunks_exact(stride).take(CHUNK).enumerate() {
            for (light, sample) in light.iter_mut().zip(pixel) {
                light[k] = sample.light();
            }
        }
        let keep: [_; COLORS] = planes(keep);
        let mut add: [_; COLORS] = planes(self.add.each_ref());
        if let Some(other) = other {
            for (add, other) in add.iter_mut().zip(other) {
                for (add, other) in add.iter_mut().zip(other) {
                    *add += other;
                }
            }
        }
        let mut bins = [[0; CHUNK]; COLORS];
        for c in 0..COLORS {
            for k in 0..CHUNK {
                light[c][k] = light[c][k] * keep[c][k] + add[c][k];
                bins[c][k] = S::bin(light[c][k]);
            }
        }
        let n = pixels.len() / stride;
        for k in self.touched_among(n) {
            let pixel = &mut pixels[k * stride..(k + 1) * stride];
            for c in 0..COLORS {
                pixel[c] = S::code_in(bins[c][k], light[c][k]);
            }
        }
    }

    pub(super) fn over_with_noise<S: Sample, const COLORS: usize, const EXTRA: usize>(
        &self,
        pixels: &mut [S],
        (keep, other): Behind<'_, COLORS>,
        noise: &Noise,
        width: usize,
    ) {
        let stride = Layout::<COLORS, EXTRA>::STRIDE;
        let units = noise.of_run::<COLORS>(self, width);
        for (k, pixel) in pixels.chunks_exact_mut(stride).enumerate() {
            let (keep, add) = self.pixel(k, keep, other);
            for c in 0..COLORS {
                let before = pixel[c].light();
                let after = before * keep[c] + add[c];
                let missing = noise.missing(keep[c], before, after);
                pixel[c] = S::code(after + missing * units[k][c]);
            }
        }
    }
}

/// The colors of a run, or their luminance.
#[inline(always)]
fn planes<const COLORS: usize>(rgb: [&[f32; CHUNK]; 3]) -> [[f32; CHUNK]; COLORS] {
    let mut planes = [[0.0; CHUNK]; COLORS];
    if COLORS == 3 {
        for (plane, color) in planes.iter_mut().zip(rgb) {
            *plane = *color;
        }
    } else {
        for k in 0..CHUNK {
            let colors: [f32; COLORS] = per_color(rgb.map(|color| color[k]));
            for (plane, color) in planes.iter_mut().zip(colors) {
                plane[k] = color;
            }
        }
    }
    planes
}

/// Spreads a share of all light evenly over the frame: I₂ = (1 − g) I₁ + g ⟨I₁⟩.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "light as f32; a number of pixels"
)]
fn veil<const COLORS: usize>(light: &mut [f32], glare: f64) {
    let mut sums = [0.0_f64; COLORS];
    for pixel in light.chunks_exact(COLORS) {
        for (sum, light) in sums.iter_mut().zip(pixel) {
            *sum += f64::from(*light);
        }
    }
    let n = (light.len() / COLORS) as f64;
    let means = sums.map(|sum| (glare * sum / n) as f32);
    let kept = (1.0 - glare) as f32;
    for pixel in light.chunks_exact_mut(COLORS) {
        for (light, mean) in pixel.iter_mut().zip(&means) {
            *light = *light * kept + mean;
        }
    }
}

#[cfg(test)]
#[path = "render_tests.rs"]
mod tests;
