//! Far focus and short focus over any 8-bit or 16-bit image.

use image::{DynamicImage, GrayImage};
use starbreak_glass::CrackNetwork;

use super::params::{Focus, Light, PaperOptics};
use super::shading::crack_energies;
use crate::OpticsError;
use crate::bit_rows::BitRows;
use crate::blur::{Frame, Kernel, blur_pixels};
use crate::coverage::{Coverage, Line, gray_image};

/// Where a render changed the image, and where the cracks are.
#[derive(Debug, Clone, PartialEq)]
pub struct Masks {
    /// 255 where the image may differ from the input, 0 where it is the input to the byte.
    pub region: GrayImage,
    /// Coverage by cracks, 255 = in full.
    pub crack: GrayImage,
}

/// A sample of an image.
trait Sample: Copy {
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

/// Renders the full-grown network over the image, in place. See [`render_at`].
///
/// # Errors
/// As for [`render_at`].
pub fn render(
    image: &mut DynamicImage,
    network: &CrackNetwork,
    optics: &PaperOptics,
) -> Result<Masks, OpticsError> {
    render_at(image, network, f64::INFINITY, optics)
}

/// Renders the network as far as it has grown at `time` (in the unit of its arrival column) over
/// the image, in place: [`draw`], then [`composite`].
///
/// # Errors
/// As for [`composite`].
pub fn render_at(
    image: &mut DynamicImage,
    network: &CrackNetwork,
    time: f64,
    optics: &PaperOptics,
) -> Result<Masks, OpticsError> {
    optics.check()?;
    let drawn = draw(network, (image.width(), image.height()), time, optics);
    composite(image, &drawn, optics)
}

/// The cracks as far as they have grown at `time`, drawn over a frame of `width × height`
/// pixels: coverage M, and E(L_r)/S of each pixel as its weight. The pane is stretched to the
/// frame.
#[must_use]
pub fn draw(
    network: &CrackNetwork,
    (width, height): (u32, u32),
    time: f64,
    optics: &PaperOptics,
) -> Coverage {
    let pane = &network.data().pane;
    let scale = [
        f64::from(width) / pane.width,
        f64::from(height) / pane.height,
    ];
    let energies = crack_energies(network, scale, optics);
    let lines = network.grown_at(time).map(|(idx, [x0, y0, x1, y1])| Line {
        ends: [x0 * scale[0], y0 * scale[1], x1 * scale[0], y1 * scale[1]],
        weight: energies[idx],
    });
    Coverage::of_lines(width, height, optics.line_width_px, lines)
}

/// Blends drawn cracks into the image, in place.
///
/// Far focus: O = I(1 − M) + I_c·M, and G∗O replaces I wherever a crack pixel lies within half
/// the kernel; all else stays as it is, to the byte. Short focus: (G∗I)(1 − M) + I_c·M over the
/// whole frame. Where nothing is broken the image stays as it is. Alpha is never changed.
///
/// # Errors
/// [`OpticsError`] for a parameter out of range, an image without pixels or of another size than
/// the drawing, or one whose samples are floating point.
///
/// # Limits
/// Code values are mixed as the paper mixes them, without regard to the gamma of the image.
pub fn composite(
    image: &mut DynamicImage,
    drawn: &Coverage,
    optics: &PaperOptics,
) -> Result<Masks, OpticsError> {
    optics.check()?;
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        return Err(OpticsError::EmptyImage { width, height });
    }
    let size = (width as usize, height as usize);
    if drawn.size() != size {
        let (drawn_width, drawn_height) = drawn.size();
        return Err(OpticsError::SizeMismatch {
            width,
            height,
            drawn_width,
            drawn_height,
        });
    }
    let region = match image {
        DynamicImage::ImageLuma8(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [1, 0], drawn, optics)
        }
        DynamicImage::ImageLumaA8(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [1, 1], drawn, optics)
        }
        DynamicImage::ImageRgb8(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [3, 0], drawn, optics)
        }
        DynamicImage::ImageRgba8(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [3, 1], drawn, optics)
        }
        DynamicImage::ImageLuma16(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [1, 0], drawn, optics)
        }
        DynamicImage::ImageLumaA16(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [1, 1], drawn, optics)
        }
        DynamicImage::ImageRgb16(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [3, 0], drawn, optics)
        }
        DynamicImage::ImageRgba16(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [3, 1], drawn, optics)
        }
        other => {
            return Err(OpticsError::ImageMode {
                mode: format!("{:?}", other.color()),
            });
        }
    };
    let mut pixels = vec![0; size.0 * size.1];
    for y in 0..size.1 {
        for (start, end) in region.runs(y) {
            pixels[y * size.0 + start..y * size.0 + end].fill(255);
        }
    }
    Ok(Masks {
        region: gray_image(size.0, size.1, pixels),
        crack: drawn.to_mask(),
    })
}

/// Blends and blurs in place; the pixels that may have changed.
fn blend_and_blur<S: Sample>(
    samples: &mut [S],
    (width, height): (usize, usize),
    [colors, alphas]: [usize; 2],
    coverage: &Coverage,
    optics: &PaperOptics,
) -> BitRows {
    if coverage.is_empty() {
        return BitRows::new(width, height);
    }
    let channels = colors + alphas;
    let light = light_levels(samples, colors, channels, optics.light);
    let kernel = Kernel::gaussian(optics.blur_radius_px() as usize, optics.blur_sigma_px);
    let region = match optics.focus {
        Focus::Far => coverage.touched().dilated(kernel.radius()),
        Focus::Short => BitRows::full(width, height),
    };
    let mut canvas = Canvas {
        samples,
        width,
        colors,
        channels,
        coverage,
        light,
        focus: optics.focus,
    };
    blur_pixels(&region, (width, height), colors, &kernel, &mut canvas);
    region
}

/// The image under its cracks: blended before the blur (far focus) or after it (short focus).
struct Canvas<'a, S> {
    samples: &'a mut [S],
    width: usize,
    colors: usize,
    channels: usize,
    coverage: &'a Coverage,
    light: [f32; 3],
    focus: Focus,
}

impl<S: Sample> Frame for Canvas<'_, S> {
    fn load(&mut self, y: usize, start: usize, end: usize, row: &mut [f32]) {
        let at = |x: usize| (y * self.width + x) * self.channels;
        let samples = &self.samples[at(start)..at(end)];
        if self.colors == self.channels {
            for (to, from) in row.iter_mut().zip(samples) {
                *to = from.to_level();
            }
        } else {
            let pixels = samples.chunks_exact(self.channels);
            for (to, from) in row.chunks_exact_mut(self.colors).zip(pixels) {
                for (to, from) in to.iter_mut().zip(from) {
                    *to = from.to_level();
                }
            }
        }
        if self.focus == Focus::Far {
            for (x, covered, energy) in self.coverage.row_within(y, start, end) {
                blend(
                    &mut row[(x - start) * self.colors..][..self.colors],
                    &self.light,
                    covered,
                    energy,
                );
            }
        }
    }

    fn store(&mut self, y: usize, start: usize, end: usize, row: &[f32]) {
        let at = |x: usize| (y * self.width + x) * self.channels;
        let samples = &mut self.samples[at(start)..at(end)];
        if self.colors == self.channels {
            for (to, from) in samples.iter_mut().zip(row) {
                *to = S::from_level(*from);
            }
        } else {
            let pixels = samples.chunks_exact_mut(self.channels);
            for (to, from) in pixels.zip(row.chunks_exact(self.colors)) {
                for (to, from) in to.iter_mut().zip(from) {
                    *to = S::from_level(*from);
                }
            }
        }
        if self.focus == Focus::Short {
            for (x, covered, energy) in self.coverage.row_within(y, start, end) {
                let mut levels = [0.0_f32; 3];
                levels[..self.colors]
                    .copy_from_slice(&row[(x - start) * self.colors..][..self.colors]);
                blend(&mut levels[..self.colors], &self.light, covered, energy);
                for (to, from) in self.samples[at(x)..][..self.colors].iter_mut().zip(levels) {
                    *to = S::from_level(from);
                }
            }
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
