//! The light around the camera over a clip, without flicker.

use starbreak_optics::environment::{Environment, Rgb};

use super::Light;

/// Time in which a change of the light is followed to 63 %, s: about as slow as an exposure
/// control. FIT.
const FOLLOW_S: f64 = 1.0;

/// Change of any color, over the brightest, from which the crack is lit anew: below a step of an
/// 8-bit image. FIT.
const VISIBLE_CHANGE: f32 = 0.01;

/// Factor of the luminance between two frames from which they are of two scenes. FIT.
const CUT_FACTOR: f32 = 2.0;

/// Luminance below which a change is noise: a step of an 8-bit image in linear light.
const DARKEST: f32 = 1.0 / 255.0 / 12.92;

/// The light of a clip, frame by frame: the exponential mean of the frames' own lights with a time constant of a second,
/// which is held until it has visibly changed, and at once that of a new scene. It knows nothing of later frames.
#[derive(Debug)]
pub struct ClipLight {
    mode: Light,
    /// What a frame lasts, s.
    frame_s: f64,
    /// The first frame.
    first_idx: u64,
    mean: Option<Environment>,
    held: Option<Environment>,
    n_changes: u64,
    /// Mean luminance of the light of the frame before.
    before: Option<f32>,
}

impl ClipLight {
    /// Of frames that last so long, s.
    #[must_use]
    pub fn new(mode: Light, frame_s: f64) -> Self {
        Self {
            mode,
            frame_s,
            first_idx: 0,
            mean: None,
            held: None,
            n_changes: 0,
            before: None,
        }
    }

    /// The same, where the first frame is another.
    pub(super) fn starting_at(mut self, first_idx: u64) -> Self {
        self.first_idx = first_idx;
        self
    }

    /// Whether the light of the next frame is asked for.
    pub(super) fn wants(&self, frame_idx: u64) -> bool {
        self.mode == Light::Follow || frame_idx == self.first_idx
    }

    /// Whether the light of a frame that is next is asked for.
    pub(super) fn wants_more(&self) -> bool {
        self.mode == Light::Follow || self.mean.is_none()
    }

    /// The light for the crack in a frame, of which `own` is the estimate.
    ///
    /// It is the exponential mean of all estimates since the last cut up to this frame, and is held
    /// until the mean has visibly left it, so that it does not depend on how frames are grouped.
    pub(super) fn next(&mut self, own: Option<Environment>) -> Option<Environment> {
        self.next_in(own, self.frame_s)
    }

    /// The light for the crack in a frame that comes so many seconds after the one before, of which `own` is the estimate.
    pub fn next_in(&mut self, own: Option<Environment>, elapsed_s: f64) -> Option<Environment> {
        let is_cut = own.is_some_and(|own| self.is_cut(&own));
        let mean = match (self.mean, own) {
            (Some(_), Some(own)) if is_cut => Some(own),
            (Some(mean), Some(own)) => Some(moved(&mean, &own, share_after(elapsed_s))),
            (mean, own) => mean.or(own),
        };
        self.mean = mean;
        let is_off = match (&self.held, &mean) {
            (Some(held), Some(mean)) => change(held, mean) > VISIBLE_CHANGE,
            (held, mean) => held.is_none() && mean.is_some(),
        };
        if is_off {
            self.held = mean;
            self.n_changes += 1;
        }
        self.held
    }

    /// Whether a light is that of another scene than the light of the frame before.
    fn is_cut(&mut self, own: &Environment) -> bool {
        let before = self.before.replace(luminance(own));
        before.is_some_and(|before| {
            let (low, high) = (before.min(luminance(own)), before.max(luminance(own)));
            high > CUT_FACTOR * low.max(DARKEST)
        })
    }

    /// How many lights there were.
    #[must_use]
    pub fn n_lights(&self) -> u64 {
        self.n_changes
    }
}

/// Share of the way to a frame's own light that the mean goes in so many seconds.
fn share_after(elapsed_s: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "light as f32")]
    let share = (-libm::expm1(-elapsed_s / FOLLOW_S)) as f32;
    share
}

fn colors(environment: &Environment) -> [Rgb; 6] {
    [
        environment.horizon_rgb,
        environment.zenith_rgb,
        environment.ground_rgb,
        environment.cabin_low_rgb,
        environment.cabin_high_rgb,
        environment.sun_rgb,
    ]
}

/// Mean luminance of what a frame shows: the sky and the ground, by the weights of BT.709.
fn luminance(light: &Environment) -> f32 {
    let seen = [light.horizon_rgb, light.zenith_rgb, light.ground_rgb];
    let sum: f32 = seen
        .iter()
        .map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b)
        .sum();
    sum / 3.0
}

/// From one light towards another by a share of the way.
fn moved(from: &Environment, to: &Environment, share: f32) -> Environment {
    let step = |from: Rgb, to: Rgb| -> Rgb {
        std::array::from_fn(|k| from[k] + (to[k] - from[k]) * share)
    };
    Environment {
        horizon_rgb: step(from.horizon_rgb, to.horizon_rgb),
        zenith_rgb: step(from.zenith_rgb, to.zenith_rgb),
        ground_rgb: step(from.ground_rgb, to.ground_rgb),
        cabin_low_rgb: step(from.cabin_low_rgb, to.cabin_low_rgb),
        cabin_high_rgb: step(from.cabin_high_rgb, to.cabin_high_rgb),
        sun_rgb: step(from.sun_rgb, to.sun_rgb),
    }
}

/// Greatest change of a color over the brightest channel of that light.
fn change(a: &Environment, b: &Environment) -> f32 {
    let mut greatest = 0.0_f32;
    for (a, b) in colors(a).into_iter().zip(colors(b)) {
        let brightest = a.into_iter().chain(b).fold(1e-6_f32, f32::max);
        for (a, b) in a.into_iter().zip(b) {
            greatest = greatest.max((a - b).abs() / brightest);
        }
    }
    greatest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(level: f32) -> Environment {
        Environment {
            horizon_rgb: [level; 3],
            zenith_rgb: [level; 3],
            ground_rgb: [level; 3],
            cabin_low_rgb: [level; 3],
            cabin_high_rgb: [level; 3],
            sun_rgb: [0.0; 3],
        }
    }

    fn ground(light: Option<Environment>) -> f32 {
        light.map_or(f32::NAN, |light| light.ground_rgb[0])
    }

    #[test]
    fn a_flicker_is_not_followed() {
        let mut light = ClipLight::new(Light::Follow, 0.04);
        for k in 0..100 {
            let level = if k % 2 == 0 { 0.5 } else { 0.505 };
            let held = ground(light.next(Some(gray(level))));
            assert!((held - 0.5).abs() < 1e-6, "frame {k}: {held}");
        }
        assert_eq!(light.n_lights(), 1, "one light");
    }

    #[test]
    fn a_cut_brings_its_own_light() {
        for after in [0.2, 0.45, 1.2] {
            let mut light = ClipLight::new(Light::Follow, 0.04);
            light.next(Some(gray(0.5)));
            let held = ground(light.next(Some(gray(after))));
            let is_cut = !(0.25..=1.0).contains(&after);
            let expected = if is_cut {
                after
            } else {
                // A 25th of a second of the way.
                0.5 + (after - 0.5) * 0.039_21
            };
            assert!((held - expected).abs() < 0.005, "{after}: {held}");
        }
        // From black to black with noise is none.
        let mut light = ClipLight::new(Light::Follow, 0.04);
        light.next(Some(gray(1e-6)));
        light.next(Some(gray(1e-5)));
        let mean = light.mean.map_or(f32::NAN, |mean| mean.ground_rgb[0]);
        assert!(mean < 2e-6, "{mean} is the noise of one frame");
    }

    #[test]
    fn a_tunnel_is_followed_within_seconds() {
        let mut light = ClipLight::new(Light::Follow, 0.04);
        light.next(Some(gray(0.5)));
        let after = |light: &mut ClipLight, n: u32| {
            (0..n).map(|_| ground(light.next(Some(gray(0.3))))).last()
        };
        // 0.3 + 0.2/e after a second, to the hundredth that is not followed.
        let second = after(&mut light, 25).unwrap_or(f32::NAN);
        assert!((second - 0.3736).abs() < 0.01, "{second} after a second");
        let later = after(&mut light, 150).unwrap_or(f32::NAN);
        assert!((later - 0.3).abs() < 0.006, "{later} after seven seconds");
    }

    #[test]
    fn the_first_light_is_kept_if_asked_for() {
        let mut light = ClipLight::new(Light::First, 0.04);
        assert!(light.wants(0) && !light.wants(1), "only the first");
        light.next(Some(gray(0.5)));
        assert!((ground(light.next(None)) - 0.5).abs() < 1e-6, "kept");
    }
}
