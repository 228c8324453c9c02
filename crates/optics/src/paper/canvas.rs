//! The image under its cracks, blurred run by run.

use super::params::{FarFocusBlur, Focus, Light, PaperOptics};
use crate::bit_rows::BitRows;
use crate::blur::{Frame, Kernel, blur_pixels};
use crate::coverage::Coverage;

/// A sample of an image.
pub(super) trait Sample: Copy {
    /// Highest code value over 255.
    const SCALE: f32;
    fn to_level(self) -> f32;
    /// Rounded and clamped to the range of the type.
    fn from_level(level: f32) -> Self;
}

impl Sample for u8 {
    const SCALE: f32 = 1.0;
    fn to_level(self) -> f32 {
        f32::from(self)
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` clamps, which is meant"
    )]
    fn from_level(level: f32) -> Self {
        (level + 0.5) as Self
    }
}

impl Sample for u16 {
    const SCALE: f32 = 257.0;
    fn to_level(self) -> f32 {
        f32::from(self)
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` clamps, which is meant"
    )]
    fn from_level(level: f32) -> Self {
        (level + 0.5) as Self
    }
}

/// Blends and blurs in place; the pixels that may have changed.
pub(super) fn blend_and_blur<S: Sample>(
    samples: &mut [S],
    (width, height): (usize, usize),
    [colors, alphas]: [usize; 2],
    coverage: &Coverage,
    optics: &PaperOptics,
) -> BitRows {
    if coverage.is_empty() && optics.focus == Focus::Far {
        return BitRows::new(width, height);
    }
    let channels = colors + alphas;
    let light = light_levels(samples, colors, channels, optics.light);
    let kernel = Kernel::gaussian(optics.blur_radius_px() as usize, optics.blur_sigma_px);
    let region = match optics.focus {
        Focus::Far => coverage.touched().dilated(kernel.radius()),
        Focus::Short => BitRows::full(width, height),
    };
    let canvas = Canvas {
        samples,
        width,
        colors,
        channels,
        coverage,
        light,
    };
    let size = (width, height);
    match (optics.focus, optics.far_focus_blur) {
        (Focus::Far, FarFocusBlur::Crack) => {
            blur_pixels(
                &region,
                size,
                VEIL_CHANNELS,
                &kernel,
                &mut BlurredCrack(canvas),
            );
        }
        (Focus::Far, FarFocusBlur::CrackAndScene) => {
            blur_pixels(&region, size, colors, &kernel, &mut BlurredTogether(canvas));
        }
        (Focus::Short, _) => {
            blur_pixels(&region, size, colors, &kernel, &mut BlurredScene(canvas));
        }
    }
    if coverage.is_empty() {
        // The blur is the camera's.
        return BitRows::new(width, height);
    }
    region
}

/// The image and what is drawn over it.
struct Canvas<'a, S> {
    samples: &'a mut [S],
    width: usize,
    colors: usize,
    channels: usize,
    coverage: &'a Coverage,
    light: [f32; 3],
}

impl<S: Sample> Canvas<'_, S> {
    fn run(&mut self, y: usize, start: usize, end: usize) -> &mut [S] {
        let at = |x: usize| (y * self.width + x) * self.channels;
        &mut self.samples[at(start)..at(end)]
    }

    /// The color samples of a run as levels.
    fn read(&mut self, y: usize, start: usize, end: usize, row: &mut [f32]) {
        let (colors, channels) = (self.colors, self.channels);
        let samples = self.run(y, start, end);
        if colors == channels {
            for (to, from) in row.iter_mut().zip(samples) {
                *to = from.to_level();
            }
            return;
        }
        for (to, from) in row
            .chunks_exact_mut(colors)
            .zip(samples.chunks_exact(channels))
        {
            for (to, from) in to.iter_mut().zip(from) {
                *to = from.to_level();
            }
        }
    }

    /// Levels to the color samples of a run; alpha stays.
    fn write(&mut self, y: usize, start: usize, end: usize, row: &[f32]) {
        let (colors, channels) = (self.colors, self.channels);
        let samples = self.run(y, start, end);
        if colors == channels {
            for (to, from) in samples.iter_mut().zip(row) {
                *to = S::from_level(*from);
            }
            return;
        }
        for (to, from) in samples
            .chunks_exact_mut(channels)
            .zip(row.chunks_exact(colors))
        {
            for (to, from) in to.iter_mut().zip(from) {
                *to = S::from_level(*from);
            }
        }
    }
}

/// Channels of the blurred crack: M and M·E/S.
const VEIL_CHANNELS: usize = 2;

/// Far focus: I·(1 − G∗M) + G∗(M·I_c). I_c is the light times a number per crack, so two
/// channels carry the crack for any number of colors.
struct BlurredCrack<'a, S>(Canvas<'a, S>);

impl<S: Sample> Frame for BlurredCrack<'_, S> {
    fn load(&mut self, y: usize, start: usize, end: usize, row: &mut [f32]) {
        row.fill(0.0);
        for (x, covered, energy) in self.0.coverage.row_within(y, start, end) {
            let at = (x - start) * VEIL_CHANNELS;
            row[at..at + VEIL_CHANNELS].copy_from_slice(&[covered, covered * energy]);
        }
    }

    fn store(&mut self, y: usize, start: usize, end: usize, row: &[f32]) {
        let (light, colors, channels) = (self.0.light, self.0.colors, self.0.channels);
        let samples = self.0.run(y, start, end);
        for (pixel, veil) in samples
            .chunks_exact_mut(channels)
            .zip(row.chunks_exact(VEIL_CHANNELS))
        {
            let (clear, glow) = (1.0 - veil[0], veil[1]);
            for (sample, light) in pixel[..colors].iter_mut().zip(light) {
                *sample = S::from_level(sample.to_level() * clear + light * glow);
            }
        }
    }
}

/// Far focus as the paper's implementation has it: G∗(I·(1 − M) + M·I_c).
struct BlurredTogether<'a, S>(Canvas<'a, S>);

impl<S: Sample> Frame for BlurredTogether<'_, S> {
    fn load(&mut self, y: usize, start: usize, end: usize, row: &mut [f32]) {
        self.0.read(y, start, end, row);
        let (light, colors) = (self.0.light, self.0.colors);
        for (x, covered, energy) in self.0.coverage.row_within(y, start, end) {
            blend(
                &mut row[(x - start) * colors..][..colors],
                &light,
                covered,
                energy,
            );
        }
    }

    fn store(&mut self, y: usize, start: usize, end: usize, row: &[f32]) {
        self.0.write(y, start, end, row);
    }
}

/// Short focus: (G∗I)·(1 − M) + M·I_c.
struct BlurredScene<'a, S>(Canvas<'a, S>);

impl<S: Sample> Frame for BlurredScene<'_, S> {
    fn load(&mut self, y: usize, start: usize, end: usize, row: &mut [f32]) {
        self.0.read(y, start, end, row);
    }

    fn store(&mut self, y: usize, start: usize, end: usize, row: &[f32]) {
        self.0.write(y, start, end, row);
        let (light, colors) = (self.0.light, self.0.colors);
        for (x, covered, energy) in self.0.coverage.row_within(y, start, end) {
            let mut levels = [0.0_f32; 3];
            levels[..colors].copy_from_slice(&row[(x - start) * colors..][..colors]);
            blend(&mut levels[..colors], &light, covered, energy);
            self.0.write(y, x, x + 1, &levels[..colors]);
        }
    }
}

/// I(1 − M) + I_c·M, with I_c = light · energy.
fn blend(levels: &mut [f32], light: &[f32; 3], covered: f32, energy: f32) {
    for (level, light) in levels.iter_mut().zip(light) {
        *level = *level * (1.0 - covered) + light * energy * covered;
    }
}

/// The light's intensity in code values of the image; for grey images the mean of its channels.
fn light_levels<S: Sample>(
    samples: &[S],
    colors: usize,
    channels: usize,
    light: Light,
) -> [f32; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "a level as f32")]
    match light {
        Light::Rgb(levels) if colors == 1 => {
            [(levels.iter().sum::<f64>() / 3.0) as f32 * S::SCALE; 3]
        }
        Light::Rgb(levels) => levels.map(|level| level as f32 * S::SCALE),
        Light::ImageMean => {
            let mut sums = [0.0_f64; 3];
            for row in samples.chunks(channels * 4096) {
                let mut partial = [0.0_f32; 3];
                for pixel in row.chunks_exact(channels) {
                    for (sum, sample) in partial.iter_mut().zip(&pixel[..colors]) {
                        *sum += sample.to_level();
                    }
                }
                for (sum, partial) in sums.iter_mut().zip(partial) {
                    *sum += f64::from(partial);
                }
            }
            #[expect(clippy::cast_precision_loss, reason = "a count")]
            let n = (samples.len() / channels).max(1) as f64;
            sums.map(|sum| (sum / n) as f32)
        }
    }
}
