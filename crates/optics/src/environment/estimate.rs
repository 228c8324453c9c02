//! The light around the camera from one image.

use std::f64::consts::PI;

use image::{DynamicImage, GenericImageView};

use super::samples::{Sample, samples};
use super::sun::sun_color;
use super::{Environment, EnvironmentParams, HemisphereWeights, Horizon, Rgb, luminance};

/// Share of the light that a road sends back: asphalt. FIT.
const ROAD_ALBEDO: f64 = 0.1;

/// Radiance of the dark side of the glass over that of the ground. FIT.
const CABIN_OVER_GROUND: f32 = 0.02;

/// Most irradiance of the sun, on a plane that faces it, over that of the sky: a clear day. FIT.
const SUN_OVER_SKY: f64 = 10.0;

/// Ranks, as shares, between which the luminance of a pixel counts as sky: below are trees and
/// houses, above are lamps and the sun. FIT.
const SKY_RANKS: [f64; 2] = [0.7, 0.95];

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
    /// of the frame as far as it lies above the horizon, and the lower third as far as it lies
    /// below. Then:
    ///
    /// - **Sky**: the mean of the pixels between the 70th and the 95th percentile of luminance,
    ///   with the mean s of the sines of their elevations. Its radiance is straight in sin e, so
    ///   the mean is that at s, Z (q + (1 − q) s), which gives the zenith Z and the horizon qZ.
    ///   q is 1/3 for the overcast sky [MoonSpencer1942] and 5.95 for the clear one, whose line
    ///   keeps mean and irradiance of the gradation of [CIE2003], type 12. Between them the blend
    ///   goes by color: the share of clear sky grows with 1 − R/B from 0.1 to 0.4.
    /// - **Ground**: the median of each channel.
    /// - **Cabin**: 0.02 of the ground.
    /// - **Sun**: what the sky cannot account for. A ground of albedo ρ = 0.1 that shows L gets
    ///   E = πL/ρ; the sun brings max(0, E − `E_sky`)/sin e, at most 10 `E_sky`, and nothing from
    ///   below the horizon. Its color is that of sunlight through clean air; white for a grey
    ///   image.
    ///
    /// A side of the horizon that the frame does not show follows from the other by the same
    /// balance without a sun: E = `E_sky`.
    ///
    /// # Units
    /// Light in units of the image's white, at the camera: what the glass takes away is not put
    /// back.
    ///
    /// # Limits
    /// All of it is a guess that keeps the order of magnitude. Pixels at the greatest code are
    /// taken to show 1, though they show at least that; a sky that is clipped to white has lost
    /// its color and is taken to be overcast. What a tone curve did is not undone. Snow or sand
    /// looks like sunlight to the balance, and a wall in the upper third looks like sky. Give the
    /// values if they are known.
    #[must_use]
    pub fn estimate(image: &DynamicImage, params: &EnvironmentParams, f_px: f64) -> Self {
        let frame = Frame::new(image, params.horizon_row, f_px);
        let given_sky = params.horizon_rgb.is_some() && params.zenith_rgb.is_some();
        let seen_sky = if given_sky { None } else { frame.sky(image) };
        let seen_ground = params.ground_rgb.or_else(|| frame.ground(image));
        let sky = seen_sky
            .or_else(|| seen_ground.map(sky_over))
            .unwrap_or_default();
        let horizon_rgb = params.horizon_rgb.unwrap_or(sky.horizon_rgb);
        let zenith_rgb = params.zenith_rgb.unwrap_or(sky.zenith_rgb);
        let mut environment = Self {
            horizon_rgb,
            zenith_rgb,
            ground_rgb: [0.0; 3],
            cabin_rgb: [0.0; 3],
            sun_rgb: [0.0; 3],
        };
        let sky_white = HemisphereWeights::facing(1.0).mean_radiance(&environment);
        environment.ground_rgb = seen_ground.unwrap_or_else(|| scaled(sky_white, ROAD_ALBEDO));
        environment.cabin_rgb = params.cabin_rgb.unwrap_or_else(|| {
            environment
                .ground_rgb
                .map(|light| light * CABIN_OVER_GROUND)
        });
        let irradiance = params.sun_irradiance.unwrap_or_else(|| {
            sun_irradiance(
                f64::from(luminance(environment.ground_rgb)),
                f64::from(luminance(sky_white)),
                libm::sin(params.sun_elevation_rad),
            )
        });
        let color = if image.color().has_color() {
            sun_color(params.sun_elevation_rad)
        } else {
            [1.0; 3]
        };
        environment.sun_rgb = scaled(color, irradiance);
        environment
    }
}

/// The colors of a sky.
#[derive(Debug, Clone, Copy, Default)]
struct Sky {
    horizon_rgb: Rgb,
    zenith_rgb: Rgb,
}

impl Sky {
    /// The sky that shows `rgb` at a sine of elevation.
    fn through(rgb: Rgb, sin_elevation: f64) -> Self {
        let clear = clearness(rgb);
        let mut sky = Self::default();
        for (law, share) in [(OVERCAST, 1.0 - clear), (CLEAR, clear)] {
            // Of each law the horizon over what is seen; the zenith follows.
            let horizon = law / (law + (1.0 - law) * sin_elevation);
            let (at_horizon, at_zenith) = (
                scaled(rgb, share * horizon),
                scaled(rgb, share * horizon / law),
            );
            for k in 0..3 {
                sky.horizon_rgb[k] += at_horizon[k];
                sky.zenith_rgb[k] += at_zenith[k];
            }
        }
        sky
    }
}

/// Where the frame shows sky and ground.
struct Frame {
    horizon: Horizon,
    f_px: f64,
    width: u32,
    height: u32,
    /// Rows above the horizon, from the top.
    n_sky_rows: u32,
}

impl Frame {
    fn new(image: &DynamicImage, horizon_row: f64, f_px: f64) -> Self {
        let (width, height) = image.dimensions();
        let f_px = f_px.max(1.0);
        // A row is above the horizon if its middle is.
        let rows = (horizon_row * f64::from(height) - 0.5)
            .ceil()
            .clamp(0.0, f64::from(height));
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the height"
        )]
        let n_sky_rows = rows as u32;
        Self {
            horizon: Horizon::at_row(horizon_row, height, f_px),
            f_px,
            width,
            height,
            n_sky_rows,
        }
    }

    /// The sky above the horizon; none if there are no rows of it.
    fn sky(&self, image: &DynamicImage) -> Option<Sky> {
        let third = self.height.div_ceil(3);
        let samples = samples(image, 0..third.min(self.n_sky_rows));
        let mut ranked: Vec<f32> = samples.iter().map(|sample| luminance(sample.rgb)).collect();
        let [least, most] = percentiles(&mut ranked)?;
        let mut n = 0.0;
        let mut sum = [0.0; 3];
        let mut sin_sum = 0.0;
        for sample in &samples {
            if (least..=most).contains(&luminance(sample.rgb)) {
                n += 1.0;
                sin_sum += self.sin_elevation(sample);
                for (sum, channel) in sum.iter_mut().zip(sample.rgb) {
                    *sum += f64::from(channel);
                }
            }
        }
        #[expect(
            clippy::cast_possible_truncation,
            reason = "light is kept in single precision"
        )]
        let mean = sum.map(|sum: f64| (sum / n) as f32);
        Some(Sky::through(mean, (sin_sum / n).clamp(0.0, 1.0)))
    }

    fn sin_elevation(&self, sample: &Sample) -> f64 {
        self.horizon.sin_elevation([
            sample.column_px - 0.5 * f64::from(self.width),
            sample.row_px - 0.5 * f64::from(self.height),
            self.f_px,
        ])
    }

    /// The ground below the horizon; none if there are no rows of it.
    fn ground(&self, image: &DynamicImage) -> Option<Rgb> {
        let third = self.height.div_ceil(3);
        let first = (self.height - third).max(self.n_sky_rows);
        let samples = samples(image, first..self.height);
        let mut ground = [0.0; 3];
        for (k, median) in ground.iter_mut().enumerate() {
            let mut channel: Vec<f32> = samples.iter().map(|sample| sample.rgb[k]).collect();
            let middle = channel.len() / 2;
            if middle >= channel.len() {
                return None;
            }
            *median = *channel.select_nth_unstable_by(middle, f32::total_cmp).1;
        }
        Some(ground)
    }
}

/// The luminances at [`SKY_RANKS`]; none of nothing.
fn percentiles(luminances: &mut [f32]) -> Option<[f32; 2]> {
    let last = luminances.len().checked_sub(1)?;
    let [low, high] = SKY_RANKS.map(|rank| {
        let of = u32::try_from(last).unwrap_or(u32::MAX);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the last"
        )]
        let at = (f64::from(of) * rank) as usize;
        at
    });
    let (_, most, _) = luminances.select_nth_unstable_by(high, f32::total_cmp);
    let most = *most;
    let (_, least, _) = luminances[..=high].select_nth_unstable_by(low, f32::total_cmp);
    Some([*least, most])
}

/// Share of the clear sky's law in a sky of this color, 0 to 1.
fn clearness([red, _, blue]: Rgb) -> f64 {
    if blue <= 0.0 {
        return 0.0;
    }
    let blueness = 1.0 - f64::from(red) / f64::from(blue);
    let t = ((blueness - BLUENESS[0]) / (BLUENESS[1] - BLUENESS[0])).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The overcast sky that alone makes a road look like this.
fn sky_over(ground: Rgb) -> Sky {
    let up = HemisphereWeights::facing(1.0);
    let zenith = 1.0 / (ROAD_ALBEDO * (up.horizon * OVERCAST + up.zenith));
    Sky {
        horizon_rgb: scaled(ground, zenith * OVERCAST),
        zenith_rgb: scaled(ground, zenith),
    }
}

/// Irradiance of the sun on a plane that faces it, from the radiance of the ground and that of a
/// white sheet on the ground under the sky alone.
fn sun_irradiance(ground: f64, sky_white: f64, sin_elevation: f64) -> f64 {
    if sin_elevation <= 0.0 {
        return 0.0;
    }
    let missing = PI * (ground / ROAD_ALBEDO - sky_white);
    (missing.max(0.0) / sin_elevation).min(SUN_OVER_SKY * PI * sky_white)
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
