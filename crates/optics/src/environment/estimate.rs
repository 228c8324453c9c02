//! The light around the camera from one image.

use std::f64::consts::PI;
use std::ops::Range;

use image::{DynamicImage, GenericImageView};

use super::samples::{Sample, samples, samples_of};
use super::sun::sun_color;
use super::{Environment, EnvironmentParams, HemisphereWeights, Horizon, Rgb, luminance};
use crate::FrameMut;
use crate::number::Number;

/// Share of the light that a road sends back: asphalt. FIT.
const ROAD_ALBEDO: f64 = 0.1;

/// Most radiance of a white sheet on the ground: no exposure clips it by more. A ground that
/// asks for more is lighter than a road. FIT.
const MOST_WHITE: f64 = 3.0;

/// Radiance of the dark side of the glass over that of the ground, straight down and straight up:
/// a dashboard of albedo 0.07 under 0.4 of the sky, through a screen that passes 0.7, sends 0.02 of the
/// sky's radiance, the ground a quarter of it; the roof is lighter, and lit by that. An estimate.
const CABIN_OVER_GROUND: [f32; 2] = [0.08, 0.1];

/// Most irradiance of the sun, on a plane that faces it, over that of the sky: a clear day. FIT.
const SUN_OVER_SKY: f64 = 10.0;

/// Radiance of a white sheet under the sky alone up to which it is night, and from which it is
/// day. FIT.
const DAYLIGHT: [f64; 2] = [0.02, 0.08];

/// Ranks, as shares, between which the luminance of a pixel counts as sky: below are trees and
/// houses, above are lamps and the sun. FIT.
const SKY_RANKS: [f64; 2] = [0.7, 0.95];

/// Rank, as a share, of the luminance that stands for ground in the sun: the rest may lie in
/// shade, and brighter are lines. FIT.
const SUNLIT_RANK: f64 = 0.75;

/// A pixel has lost its color if each channel is at least this, code 249 of 255. FIT.
const CLIPPED: f32 = 0.95;

/// Share of the sky that must have kept its color to tell what sky it is. FIT.
const ENOUGH_COLOR: f64 = 0.1;

/// Horizon over zenith of the overcast sky, L = Z (1 + 2 sin e)/3.
const OVERCAST: f64 = 1.0 / 3.0;

/// Horizon over zenith of the clear sky: the straight line in sin e with the mean radiance and
/// the irradiance of the gradation 1 − exp(−0.32/sin e).
const CLEAR: f64 = 5.946;

/// Blueness 1 − R/B of the sky from which it starts to be clear, and from which it is. FIT.
const BLUENESS: [f64; 2] = [0.1, 0.4];

impl Environment {
    /// The light around the camera, as far as `params` does not give it, from one image with a
    /// focal length of `f_px` (px, 1 or more).
    ///
    /// Two grids of up to 2048 pixels are read and decoded by [`crate::srgb`]: the upper third
    /// of the frame as far as it lies above the horizon, and the middle third of what lies below
    /// (the lowest rows often show the car), down to the highest row of a dashboard that is given. Then:
    ///
    /// - **Sky**: the mean of the pixels between the 70th and the 95th percentile of luminance,
    ///   with the mean s of the sines of their elevations. Its radiance is straight in sin e, so
    ///   the mean is that at s, Z (q + (1 − q) s), which gives the zenith Z and the horizon qZ.
    ///   q is 1/3 for the overcast sky \[MoonSpencer1942\] and 5.95 for the clear one, whose line
    ///   keeps mean and irradiance of the gradation of \[CIE2003\], type 12. The share of the clear
    ///   sky grows from 0 to 1 with the blueness 1 − R/B, from 0.1 to 0.4, of all bright pixels
    ///   whose color is not clipped; these also give the clear zenith its color.
    /// - **Ground**: the median of each channel.
    /// - **Cabin**: 0.08 of the ground straight down, 0.1 straight up.
    /// - **Sun**: what the sky cannot account for. A ground of albedo ρ = 0.1 that shows L, the
    ///   75th percentile as some of it may lie in shade, gets E = πL/ρ (3π at most); the sun brings max(0, E − `E_sky`)/sin e, 10 `E_sky` at most.
    ///   It is as strong as the sky is clear, none below the horizon, and none at night, when
    ///   `E_sky`/π is below 0.02 (whole from 0.08). Its color is that of sunlight through clean
    ///   air.
    ///
    /// A sky that is clipped to white all over, and an image without color, tell nothing about
    /// clouds: the law is then the overcast one, and the sun is what the balance says.
    /// A side of the horizon that the frame does not show follows from the other by the balance
    /// without a sun: E = `E_sky`.
    ///
    /// # Units
    /// Light in units of the image's white, at the camera: what the glass takes away is not put
    /// back.
    ///
    /// # Limits
    /// All of it is a guess that keeps the order of magnitude. A clipped pixel is taken to show
    /// 1, though it shows at least that. What a tone curve did is not undone: it makes the sky
    /// too bright against the road, and the sun too weak. Pale paving looks like sunlight, a blue
    /// wall in the upper third looks like sky. Give the values if they are known.
    #[must_use]
    pub fn estimate(image: &DynamicImage, params: &EnvironmentParams, f_px: f64) -> Self {
        let rows = |rows| samples(image, rows);
        Self::of_samples(image.dimensions(), &rows, params, f_px)
    }

    /// As [`Environment::estimate`], from a frame in somebody else's memory.
    #[must_use]
    pub fn estimate_of(frame: &FrameMut<'_>, params: &EnvironmentParams, f_px: f64) -> Self {
        let codes = |x, y| frame.rgb_at(x as usize, y as usize);
        Self::estimate_by(frame.size(), &codes, params, f_px)
    }

    /// As [`Environment::estimate`], from a frame of a width and height, px, of which a few pixels are asked for by column
    /// and row: their codes of red, green and blue, 8 bits each.
    #[must_use]
    pub fn estimate_by(
        size: (u32, u32),
        codes: &dyn Fn(u32, u32) -> [u8; 3],
        params: &EnvironmentParams,
        f_px: f64,
    ) -> Self {
        let rows = |rows| samples_of(size.0, rows, codes);
        Self::of_samples(size, &rows, params, f_px)
    }

    fn of_samples(
        size: (u32, u32),
        samples: &Samples<'_>,
        params: &EnvironmentParams,
        f_px: f64,
    ) -> Self {
        let frame = Frame::new(size, params, f_px);
        let seen_sky = frame.sky(samples);
        let seen_ground = match params.ground_rgb {
            Some(rgb) => Some(Ground::even(rgb)),
            None => frame.ground(samples),
        };
        let sky = seen_sky
            .or_else(|| seen_ground.map(|ground| Sky::over(ground.rgb)))
            .unwrap_or_default();
        let mut environment = Self {
            horizon_rgb: params.horizon_rgb.unwrap_or(sky.horizon_rgb),
            zenith_rgb: params.zenith_rgb.unwrap_or(sky.zenith_rgb),
            ground_rgb: [0.0; 3],
            cabin_low_rgb: [0.0; 3],
            cabin_high_rgb: [0.0; 3],
            sun_rgb: [0.0; 3],
        };
        let sky_white = HemisphereWeights::facing(1.0).mean_radiance(&environment);
        let ground = seen_ground.unwrap_or_else(|| Ground::even(scaled(sky_white, ROAD_ALBEDO)));
        environment.ground_rgb = ground.rgb;
        let cabin_rgb = params.cabin_rgb.unwrap_or_else(|| {
            CABIN_OVER_GROUND.map(|share| environment.ground_rgb.map(|light| light * share))
        });
        [environment.cabin_low_rgb, environment.cabin_high_rgb] = cabin_rgb;
        let irradiance = params.sun_irradiance.unwrap_or_else(|| {
            let balance = sun_irradiance(
                f64::from(ground.sunlit),
                f64::from(luminance(sky_white)),
                libm::sin(params.sun_elevation_rad),
            );
            balance * sky.open
        });
        let color = if environment.has_color() {
            sun_color(params.sun_elevation_rad)
        } else {
            [1.0; 3]
        };
        environment.sun_rgb = scaled(color, irradiance);
        environment
    }

    /// Whether sky or ground is anything but grey.
    fn has_color(&self) -> bool {
        [self.horizon_rgb, self.zenith_rgb, self.ground_rgb]
            .iter()
            .any(|&rgb| has_color(rgb))
    }
}

/// What a sky is like.
#[derive(Debug, Clone, Copy, Default)]
struct Sky {
    horizon_rgb: Rgb,
    zenith_rgb: Rgb,
    /// Share of the sun that clouds let through, as far as is known.
    open: f64,
}

impl Sky {
    /// The sky that shows `mean` at a sine of elevation, with the color of what is not clipped
    /// and the share of the sky that has one.
    fn through(mean: Rgb, sin_elevation: f64, color: Rgb, colored: f64) -> Self {
        let known = (colored / ENOUGH_COLOR).min(1.0);
        let clear = known * clearness(color);
        let of_color = f64::from(luminance(mean)) / f64::from(luminance(color)).max(1e-9);
        let clear_zenith = if known > 0.0 {
            scaled(color, of_color)
        } else {
            mean
        };
        // The horizon over what is seen; the zenith follows.
        let horizon = |law: f64| law / (law + (1.0 - law) * sin_elevation);
        let (grey, blue) = ((1.0 - clear) * horizon(OVERCAST), clear * horizon(CLEAR));
        Self {
            horizon_rgb: scaled(mean, grey + blue),
            zenith_rgb: sum(
                scaled(mean, grey / OVERCAST),
                scaled(clear_zenith, blue / CLEAR),
            ),
            open: 1.0 - known + clear,
        }
    }

    /// The overcast sky that alone makes a road look like this.
    fn over(ground: Rgb) -> Self {
        let up = HemisphereWeights::facing(1.0);
        let zenith = 1.0 / (ROAD_ALBEDO * (up.horizon * OVERCAST + up.zenith));
        Self {
            horizon_rgb: scaled(ground, zenith * OVERCAST),
            zenith_rgb: scaled(ground, zenith),
            open: 0.0,
        }
    }
}

/// What a ground is like.
#[derive(Debug, Clone, Copy)]
struct Ground {
    rgb: Rgb,
    /// Luminance out of the shade.
    sunlit: f32,
}

impl Ground {
    /// A ground without shade.
    fn even(rgb: Rgb) -> Self {
        Self {
            rgb,
            sunlit: luminance(rgb),
        }
    }
}

/// Pixels of some rows of a frame.
type Samples<'a> = dyn Fn(Range<u32>) -> Vec<Sample> + 'a;

/// Where the frame shows sky and ground.
struct Frame {
    horizon: Horizon,
    f_px: f64,
    width: u32,
    height: u32,
    /// Rows above the horizon, from the top, and above the dashboard.
    n_sky_rows: u32,
    n_outside_rows: u32,
}

impl Frame {
    fn new((width, height): (u32, u32), params: &EnvironmentParams, f_px: f64) -> Self {
        // A row is above another if its middle is.
        let n_above = |row: f64| {
            let rows = (row * f64::from(height) - 0.5).ceil();
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between 0 and the height"
            )]
            let n = rows.clamp(0.0, f64::from(height)) as u32;
            n
        };
        let n_outside_rows = n_above(params.dashboard.ends()[0]);
        Self {
            horizon: params.horizon(height, f_px),
            f_px,
            width,
            height,
            n_sky_rows: n_above(params.horizon_row).min(n_outside_rows),
            n_outside_rows,
        }
    }

    /// The sky above the horizon; none if there are no rows of it.
    fn sky(&self, samples: &Samples<'_>) -> Option<Sky> {
        let third = self.height.div_ceil(3);
        let samples = samples(0..third.min(self.n_sky_rows));
        let mut ranked: Vec<f32> = samples.iter().map(|sample| luminance(sample.rgb)).collect();
        let [least, most] = percentiles(&mut ranked)?;
        let mut sky = Mean::default();
        let mut sin_elevation = 0.0;
        for sample in &samples {
            if (least..=most).contains(&luminance(sample.rgb)) {
                sky.add(sample.rgb);
                sin_elevation += self.sin_elevation(sample);
            }
        }
        let sin_elevation = (sin_elevation / sky.n).clamp(0.0, 1.0);
        let bright = 0.5 * luminance(sky.rgb());
        let mut n_bright = 0.0;
        let mut colored = Mean::default();
        for sample in &samples {
            if luminance(sample.rgb) >= bright {
                n_bright += 1.0;
                if sample.rgb.iter().any(|&channel| channel < CLIPPED) {
                    colored.add(sample.rgb);
                }
            }
        }
        let share = if has_color(colored.rgb()) {
            colored.n / n_bright
        } else {
            0.0
        };
        Some(Sky::through(sky.rgb(), sin_elevation, colored.rgb(), share))
    }

    fn sin_elevation(&self, sample: &Sample) -> f64 {
        self.horizon.sin_elevation([
            sample.column_px - 0.5 * f64::from(self.width),
            sample.row_px - 0.5 * f64::from(self.height),
            self.f_px,
        ])
    }

    /// The ground below the horizon; none if there are no rows of it.
    fn ground(&self, samples: &Samples<'_>) -> Option<Ground> {
        let third = (self.n_outside_rows - self.n_sky_rows) / 3;
        let samples = samples(self.n_sky_rows + third..self.n_outside_rows - third);
        let ranked = |of: &dyn Fn(&Sample) -> f32, share: f64| {
            let mut values: Vec<f32> = samples.iter().map(of).collect();
            let at = rank(values.len(), share)?;
            Some(*values.select_nth_unstable_by(at, f32::total_cmp).1)
        };
        Some(Ground {
            rgb: [
                ranked(&|sample| sample.rgb[0], 0.5)?,
                ranked(&|sample| sample.rgb[1], 0.5)?,
                ranked(&|sample| sample.rgb[2], 0.5)?,
            ],
            sunlit: ranked(&|sample| luminance(sample.rgb), SUNLIT_RANK)?,
        })
    }
}

/// A mean color.
#[derive(Default)]
struct Mean {
    n: f64,
    sum: [f64; 3],
}

impl Mean {
    fn add(&mut self, rgb: Rgb) {
        self.n += 1.0;
        for (sum, channel) in self.sum.iter_mut().zip(rgb) {
            *sum += f64::from(channel);
        }
    }

    /// Black of nothing.
    fn rgb(&self) -> Rgb {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "light is kept in single precision"
        )]
        let rgb = self.sum.map(|sum| (sum / self.n.max(1.0)) as f32);
        rgb
    }
}

/// The luminances at [`SKY_RANKS`]; none of nothing.
fn percentiles(luminances: &mut [f32]) -> Option<[f32; 2]> {
    let high = rank(luminances.len(), SKY_RANKS[1])?;
    let low = rank(luminances.len(), SKY_RANKS[0])?;
    let (darker, &mut most, _) = luminances.select_nth_unstable_by(high, f32::total_cmp);
    if low == high {
        return Some([most, most]);
    }
    let (_, &mut least, _) = darker.select_nth_unstable_by(low, f32::total_cmp);
    Some([least, most])
}

/// Place of a share, 0 to 1, among `n` sorted values, rounded down; none among none.
fn rank(n: usize, share: f64) -> Option<usize> {
    let last = u32::try_from(n.checked_sub(1)?).unwrap_or(u32::MAX);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the last"
    )]
    let at = (f64::from(last) * share) as usize;
    Some(at)
}

/// Share of the clear sky's law in a sky of this color, 0 to 1.
fn clearness([red, _, blue]: Rgb) -> f64 {
    if blue <= 0.0 {
        return 0.0;
    }
    smooth_step(1.0 - f64::from(red) / f64::from(blue), BLUENESS)
}

/// Irradiance of the sun on a plane that faces it, from the radiance of the ground and that of a
/// white sheet on the ground under the sky alone.
fn sun_irradiance(ground: f64, sky_white: f64, sin_elevation: f64) -> f64 {
    if sin_elevation <= 0.0 {
        return 0.0;
    }
    let missing = PI * ((ground / ROAD_ALBEDO).min(MOST_WHITE) - sky_white);
    let most = SUN_OVER_SKY * PI * sky_white;
    (missing.max(0.0) / sin_elevation).min(most) * smooth_step(sky_white, DAYLIGHT)
}

/// 0 up to the first bound, 1 from the second, and without a kink between.
#[inline(always)]
pub(crate) fn smooth_step<N: Number>(x: N, [low, high]: [f64; 2]) -> N {
    let t = (x - x.all(low)) / x.all(high - low);
    let t = t.at_least(0.0).at_most(1.0);
    t * t * t.times(2.0).less_from(3.0)
}

/// Whether a color is anything but grey.
fn has_color([red, green, blue]: Rgb) -> bool {
    let most = red.max(green).max(blue);
    let least = red.min(green).min(blue);
    most - least > 1e-4 * most
}

fn sum(a: Rgb, b: Rgb) -> Rgb {
    std::array::from_fn(|k| a[k] + b[k])
}

fn scaled(rgb: Rgb, factor: f64) -> Rgb {
    rgb.map(|channel| {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "light is kept in single precision"
        )]
        let scaled = (f64::from(channel) * factor) as f32;
        scaled
    })
}
