//! What a camera with a fault makes of an image.

use std::ops::Range;
use std::sync::Arc;

use image::{ColorType, DynamicImage, GrayImage, ImageBuffer, Pixel};
use starbreak_optics::OpticsError;
use starbreak_optics::environment::{Environment, EnvironmentParams};
use starbreak_optics::lens_faults::{Lamp, LensOfFrames};
use starbreak_optics::physical::Overlay;
use starbreak_optics::screens::{LitScreen, Screen};
use starbreak_optics::srgb::{decode8, decode16, encode8, encode8_all, encode16};
use starbreak_sensor::{Code, Codes, Light, Moment, Sensor};

use crate::{CameraFaults, Error, OpticsSettings, Settings};

/// A sample of an image, with its light.
trait Sample: Code {
    fn light(self) -> f32;
    /// Of the light of a code it is that code.
    fn of_light(light: f32) -> Self;

    /// The codes of many lights.
    fn of_lights(lights: &[f32], codes: &mut [Self]) {
        for (code, light) in codes.iter_mut().zip(lights) {
            *code = Self::of_light(*light);
        }
    }

    /// From a code to that of so many times its light.
    fn times(gain: f32) -> impl Fn(Self) -> Self {
        move |code| Self::of_light(code.light() * gain)
    }
}

impl Sample for u8 {
    fn light(self) -> f32 {
        decode8(self)
    }

    fn of_light(light: f32) -> Self {
        encode8(light)
    }

    fn of_lights(lights: &[f32], codes: &mut [Self]) {
        encode8_all(lights, codes);
    }

    /// By a table: a row has more samples than there are codes.
    fn times(gain: f32) -> impl Fn(Self) -> Self {
        let table: [Self; 256] = std::array::from_fn(|k| {
            let code = Self::try_from(k).unwrap_or(Self::MAX);
            Self::of_light(code.light() * gain)
        });
        move |code| table[usize::from(code)]
    }
}

impl Sample for u16 {
    fn light(self) -> f32 {
        decode16(self)
    }

    fn of_light(light: f32) -> Self {
        encode16(light)
    }
}

/// What light meets beside broken glass and drops: coats on the glass, then the camera's faults.
#[derive(Debug, Clone)]
pub(super) struct Behind<'a> {
    screens: Vec<LitScreen<'a>>,
    /// The sun as the lens sees it, where it stands before the camera.
    sun: Option<Lamp>,
    pub(super) faults: Option<&'a CameraFaults>,
    /// The lens before such frames, which some optics know.
    lens: Option<&'a LensOfFrames>,
    /// Where less of the light than this share is changed by a coat, it does not count as affected.
    pub(super) least: f64,
}

impl<'a> Behind<'a> {
    /// Of some settings, and of their coats and lens, under a light.
    pub(super) fn of(
        settings: &'a Settings,
        screens: &'a [Arc<Screen>],
        lens: Option<&'a LensOfFrames>,
        light: Environment,
    ) -> Self {
        let params = match &settings.optics {
            OpticsSettings::Physical(optics) => optics.environment,
            OpticsSettings::Paper(_) => EnvironmentParams::default(),
        };
        let sun = lens.map(LensOfFrames::optic).and_then(|optic| {
            let height = u32::try_from(optic.size.1).unwrap_or(u32::MAX);
            let direction = params.sun(&params.horizon(height, optic.f_px));
            Lamp::of_sun(direction, light.sun_rgb, optic)
        });
        Self {
            screens: (screens.iter())
                .map(|screen| screen.under(&light, &params))
                .collect(),
            sun,
            faults: settings.faults.as_ref(),
            lens,
            least: match &settings.optics {
                OpticsSettings::Physical(optics) => optics.region_threshold,
                OpticsSettings::Paper(_) => 0.0,
            },
        }
    }

    /// Whether there is nothing.
    pub(super) fn is_nothing(&self) -> bool {
        self.screens.is_empty() && self.faults.is_none()
    }

    /// Whether there is nothing at a time of a clip, s.
    pub(super) fn is_nothing_at(&self, time_s: f64) -> bool {
        let faults = self.faults;
        !self.is_coated() && faults.is_none_or(|faults| faults.at(time_s).is_empty())
    }

    /// Whether a coat changes any light.
    fn is_coated(&self) -> bool {
        !self.screens.iter().all(|it| it.screen().is_nothing())
    }

    /// Whether what is clipped in an image is taken to have been brighter than white.
    pub(super) fn has_headroom(&self) -> bool {
        self.faults
            .is_some_and(|faults| faults.lens.headroom() > 1.0)
    }

    /// What all this makes of an image, in place. Glass that is given comes first, in the same light, which may be brighter
    /// than white; the image must be of its size. Samples whose light does not change keep their codes. Alpha stays, but a distortion
    /// moves it with what it cuts out.
    ///
    /// # Errors
    /// [`Error::Optics`] for an image of 32-bit samples, [`Error::Sensor`] for one that no codec takes.
    pub(super) fn over(
        &self,
        image: &mut DynamicImage,
        glass: Option<&Overlay>,
        at: Moment,
    ) -> Result<(), Error> {
        if self.is_nothing() {
            return Ok(());
        }
        let none = CameraFaults::default();
        let faults = self.faults.unwrap_or(&none).at(at.time_s);
        let now = (&*faults, self, glass);
        // A frame that does not arrive is not looked at.
        if !faults.sensor.frame_state(at).is_blank() {
            step(now, Step::Light, image, at)?;
            if let Some(overlay) = glass {
                overlay.apply_noise(image, at.frame)?;
            }
        }
        step(now, Step::Codes, image, at)
    }

    /// Takes from the share of an image's light that comes through at each pixel what coats do not let through.
    pub(super) fn let_through(&self, passing: &mut [f32]) {
        for screen in &self.screens {
            for (all, passes) in passing.iter_mut().zip(screen.screen().passing()) {
                *all *= passes;
            }
        }
    }

    /// Adds 255 where it reaches a frame of these colors to a region.
    pub(super) fn add_region(&self, region: &mut GrayImage, color: ColorType, at: Moment) {
        for screen in &self.screens {
            add(region, screen.screen().reaches(self.least));
        }
        if let Some(faults) = self.faults {
            add_faults(faults, region, color, at);
        }
    }
}

/// Adds 255 where something reaches.
fn add(region: &mut GrayImage, reached: Vec<bool>) {
    for (code, is_reached) in region.iter_mut().zip(reached) {
        if is_reached {
            *code = 255;
        }
    }
}

/// What a camera does to light, and then to codes of it.
#[derive(Clone, Copy, PartialEq)]
enum Step {
    Light,
    Codes,
}

/// The faults that there are now, what is behind the glass, and the glass where it meets the same light.
type Now<'a> = (&'a CameraFaults, &'a Behind<'a>, Option<&'a Overlay>);

fn step(now: Now<'_>, step: Step, image: &mut DynamicImage, at: Moment) -> Result<(), Error> {
    let at = (step, at);
    match image {
        DynamicImage::ImageLuma8(image) => samples(now, image, at),
        DynamicImage::ImageLumaA8(image) => samples(now, image, at),
        DynamicImage::ImageRgb8(image) => samples(now, image, at),
        DynamicImage::ImageRgba8(image) => samples(now, image, at),
        DynamicImage::ImageLuma16(image) => samples(now, image, at),
        DynamicImage::ImageLumaA16(image) => samples(now, image, at),
        DynamicImage::ImageRgb16(image) => samples(now, image, at),
        DynamicImage::ImageRgba16(image) => samples(now, image, at),
        other => Err(OpticsError::ImageMode {
            mode: format!("{:?}", other.color()),
        }
        .into()),
    }
}

fn samples<P>(
    (faults, behind, glass): Now<'_>,
    image: &mut ImageBuffer<P, Vec<P::Subpixel>>,
    (step, at): (Step, Moment),
) -> Result<(), Error>
where
    P: Pixel,
    P::Subpixel: Sample,
{
    let n_channels = usize::from(P::CHANNEL_COUNT);
    let size = (image.width() as usize, image.height() as usize);
    let samples: &mut [P::Subpixel] = image;
    let sensor = &faults.sensor;
    if step == Step::Codes {
        return match Codes::new(samples, size, n_channels) {
            Some(mut codes) => Ok(sensor.over_codes(&mut codes, Sample::light, at)?),
            // An image without pixels.
            None => Ok(()),
        };
    }
    if glass.is_some() || behind.is_coated() || !faults.lens.faults().is_empty() {
        let before = |light: &mut Vec<f32>, n_colors| {
            let brighter = faults.lens.unclip(light, n_colors, size.0);
            let optic = behind.lens.map(LensOfFrames::optic);
            let scattered = optic.map_or(0.0, |optic| faults.lens.scattered(optic));
            let unclipped = Unclipped::of(brighter, (light, n_colors), single(scattered));
            if let Some(glass) = glass {
                glass.over_light(light, n_colors);
            }
            for screen in &behind.screens {
                screen.over(light, n_colors);
            }
            if let Some(lens) = behind.lens {
                lens.over(light, n_colors, behind.sun, (at.time_s, at.frame));
            }
            unclipped
        };
        change_all(sensor, samples, (size, n_channels), at, before);
        if let Some(lens) = behind.lens.filter(|_| faults.lens.moves_labels()) {
            move_alpha(lens, samples, n_channels, at.time_s);
        }
    } else if sensor.changes_light() {
        change_light(sensor, samples, (size, n_channels), at);
    }
    Ok(())
}

/// Moves the alpha of a frame as its lens moves what it shows; where that is nothing, the frame is transparent.
fn move_alpha<S: Sample>(lens: &LensOfFrames, samples: &mut [S], n_channels: usize, time_s: f64) {
    if n_channels % 2 == 1 {
        return;
    }
    let of_pixel = |pixel: &[S]| single(pixel[n_channels - 1].share());
    let mut alpha: Vec<f32> = samples.chunks_exact(n_channels).map(of_pixel).collect();
    lens.move_values(&mut alpha, time_s);
    for (pixel, share) in samples.chunks_exact_mut(n_channels).zip(alpha) {
        pixel[n_channels - 1] = S::of_share(share.into());
    }
}

#[expect(clippy::cast_possible_truncation, reason = "a share")]
fn single(share: f64) -> f32 {
    share as f32
}

/// What the faults make of the light of a frame; samples whose light stays keep their codes.
fn change_light<S: Sample>(
    sensor: &Sensor,
    samples: &mut [S],
    (size, n_channels): ((usize, usize), usize),
    at: Moment,
) {
    let n_colors = if n_channels < 3 { 1 } else { 3 };
    if let Some(gains) = sensor.gains_of_rows(size.1, at) {
        // Rows of one gain go together.
        let mut rest = samples;
        for same in gains.chunk_by(|a, b| a.to_bits() == b.to_bits()) {
            let (rows, later) = rest.split_at_mut(same.len() * size.0 * n_channels);
            let times = S::times(same[0]);
            for pixel in rows.chunks_exact_mut(n_channels) {
                for code in &mut pixel[..n_colors] {
                    *code = times(*code);
                }
            }
            rest = later;
        }
        return;
    }
    let light_of = |at: usize, color: usize| samples[at * n_channels + color].light();
    if let Some(changes) = sensor.changes_of_defects(size, n_colors, light_of) {
        for (at, more) in changes {
            let pixel = &mut samples[at * n_channels..][..n_colors];
            for (code, more) in pixel.iter_mut().zip(more).filter(|(_, more)| *more != 0.0) {
                *code = S::of_light(code.light() + more);
            }
        }
        return;
    }
    change_all(sensor, samples, (size, n_channels), at, |_, _| {
        Unclipped::default()
    });
}

/// Pixels that are taken to have been brighter than their codes say, with that light.
#[derive(Default)]
struct Unclipped {
    /// Those side by side together.
    runs: Vec<Range<usize>>,
    /// Of one pixel after the other, with the colors of each side by side.
    light: Vec<f32>,
    /// How much of it at least is changed: what is scattered away, whatever comes instead.
    scattered: f32,
}

impl Unclipped {
    /// Of pixels of a frame's light of so many colors, of which such a share is scattered.
    fn of(runs: Vec<Range<usize>>, (light, n_colors): (&[f32], usize), scattered: f32) -> Self {
        Self {
            light: of_runs(&runs, light, n_colors).concat(),
            runs,
            scattered,
        }
    }

    /// The codes of these pixels after all that their light met, from those before it, their colors side by side.
    fn codes<S: Sample>(
        &self,
        samples: &[S],
        after: &[f32],
        (n_channels, n_colors): (usize, usize),
    ) -> Vec<S> {
        let pixels = of_runs(&self.runs, samples, n_channels);
        let pixels = pixels.iter().flat_map(|run| run.chunks_exact(n_channels));
        let mut codes = Vec::with_capacity(self.light.len());
        for pixel in pixels {
            codes.extend_from_slice(&pixel[..n_colors]);
        }
        let mut light: Vec<f32> = codes.iter().map(|code| code.light()).collect();
        let after = of_runs(&self.runs, after, n_colors).concat();
        for (light, (before, after)) in light.iter_mut().zip(self.light.iter().zip(&after)) {
            *light = clipped_again(*light, [*before, *after], self.scattered);
        }
        S::of_lights(&light, &mut codes);
        codes
    }
}

/// The values of a frame's pixels that are side by side, so many of each.
fn of_runs<'a, T>(runs: &[Range<usize>], values: &'a [T], n_per_pixel: usize) -> Vec<&'a [T]> {
    let of_run = |run: &Range<usize>| &values[run.start * n_per_pixel..run.end * n_per_pixel];
    runs.iter().map(of_run).collect()
}

/// What comes before the sensor, and the sensor, make of the light of a whole frame; samples whose light stays keep their
/// codes. What comes before tells which pixels it took to have been brighter than they are.
fn change_all<S: Sample>(
    sensor: &Sensor,
    samples: &mut [S],
    (size, n_channels): ((usize, usize), usize),
    at: Moment,
    before: impl Fn(&mut Vec<f32>, usize) -> Unclipped,
) {
    let n_colors = if n_channels < 3 { 1 } else { 3 };
    let mut values: Vec<f32> = match n_channels == n_colors {
        true => samples.iter().map(|code| code.light()).collect(),
        false => (samples.chunks_exact(n_channels))
            .flat_map(|pixel| pixel[..n_colors].iter().map(|code| code.light()))
            .collect(),
    };
    let unclipped = before(&mut values, n_colors);
    let Ok(mut light) = Light::new(size, n_colors, values) else {
        return;
    };
    sensor.over(&mut light, at);
    let light = light.values();
    let clipped = unclipped.codes(samples, light, (n_channels, n_colors));
    if n_channels == n_colors {
        S::of_lights(light, samples);
    } else {
        let pixels = samples.chunks_exact_mut(n_channels);
        for (pixel, after) in pixels.zip(light.chunks_exact(n_colors)) {
            for (code, after) in pixel.iter_mut().zip(after) {
                *code = S::of_light(*after);
            }
        }
    }
    let codes = clipped.chunks_exact(n_colors);
    for (at, codes) in unclipped.runs.into_iter().flatten().zip(codes) {
        samples[at * n_channels..][..n_colors].copy_from_slice(codes);
    }
}

/// A change of light by less than this share leaves a sample that was taken to be brighter than it is as it is.
const LEAST_CHANGE: f32 = 0.02;

/// The light of a sample that was taken to be brighter before all that light meets, and what it is after that. What meets
/// nothing is as it was.
fn clipped_again(was: f32, [before, after]: [f32; 2], scattered: f32) -> f32 {
    let change = ((after - before) / before).abs().max(scattered);
    let part = (change / LEAST_CHANGE).min(1.0);
    let same = after / before * was;
    let changed = same + part * (after - same);
    // Last, so that many are worked out side by side.
    if before <= was { after } else { changed }
}

/// 255 where a camera's faults reach a frame of these colors, added to a region.
fn add_faults(faults: &CameraFaults, region: &mut GrayImage, color: ColorType, at: Moment) {
    let size = (region.width() as usize, region.height() as usize);
    let n_channels = u32::from(color.channel_count());
    let n_colors = if color.has_color() { 3 } else { 1 };
    let n_bits = u32::from(color.bits_per_pixel()) / n_channels;
    if faults.lens.at(at.time_s).changes(n_colors) {
        region.fill(255);
        return;
    }
    add(region, faults.sensor.reach(size, (n_colors, n_bits), at));
}
