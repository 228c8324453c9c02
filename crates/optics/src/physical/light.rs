//! A baked layer under a light: what each pixel keeps of its own, and what is added.

use super::elsewhere::Elsewhere;
use super::overlay::{LEAST_ELSEWHERE, LEAST_INFLUENCE, OverlayLayer, Run};
use super::pattern::PatternLayer;
use crate::environment::{Environment, Rgb};
use crate::maps::{CHUNK, LaneRun};
use crate::surface::{
    CABIN, FRAME, FRAME_U, FRAME_V, GROUND, HORIZON, LANES, N_SHARES, SUN, ZENITH,
};

/// The lanes that are lit by the environment.
const LIT: [usize; 5] = [HORIZON, ZENITH, GROUND, CABIN, SUN];

/// Their light.
struct Colors {
    rgb: [Rgb; LIT.len()],
    /// The greatest of each color, at least 1.
    greatest: [f32; LIT.len()],
}

impl Colors {
    fn of(environment: &Environment) -> Self {
        let rgb = [
            environment.horizon_rgb,
            environment.zenith_rgb,
            environment.ground_rgb,
            environment.cabin_rgb,
            environment.sun_rgb,
        ];
        Self {
            rgb,
            greatest: rgb.map(|rgb| rgb.into_iter().fold(1.0, f32::max)),
        }
    }
}

impl OverlayLayer {
    /// A layer under the light of an environment.
    pub(super) fn lit(layer: &PatternLayer, environment: &Environment) -> Self {
        let mut overlay = Self {
            runs: Vec::with_capacity(layer.light.n_runs()),
            elsewhere: Vec::new(),
        };
        let colors = Colors::of(environment);
        for (x, y, lanes) in layer.light.iter() {
            let mut shares = shares_of(lanes);
            let scaled;
            let lanes = if greatest(&shares) > 1.0 {
                scaled = scaled_to_one(lanes, &mut shares);
                &scaled
            } else {
                lanes
            };
            let added = added_by(lanes, &shares, &colors);
            if added.touched == 0 {
                continue;
            }
            let mut run = Run::untouched((x, y));
            run.touched = added.touched;
            run.shine(&added, lanes, &shares);
            if let Some(tint) = layer.tint.run_at(x, y) {
                run.tint(&added, lanes, &shares, tint);
            }
            if greatest(&lanes[FRAME]) > LEAST_ELSEWHERE {
                let other = elsewhere_of(layer, &run, lanes);
                run.elsewhere = other.map(|other| {
                    overlay.elsewhere.push(other);
                    overlay.elsewhere.len() - 1
                });
            }
            overlay.runs.push(run);
        }
        overlay
    }
}

/// Sum of the shares of each pixel.
fn shares_of(lanes: &LaneRun<LANES>) -> [f32; CHUNK] {
    let mut shares = [0.0; CHUNK];
    for lane in &lanes[..N_SHARES] {
        for (sum, share) in shares.iter_mut().zip(lane) {
            *sum += share;
        }
    }
    shares
}

fn greatest(values: &[f32; CHUNK]) -> f32 {
    values
        .iter()
        .fold(f32::NEG_INFINITY, |most, value| match *value > most {
            true => *value,
            false => most,
        })
}

/// Where the shares come to more than 1 (facets of different blur over each other) all lanes over
/// their sum, which is 1 then.
fn scaled_to_one(lanes: &LaneRun<LANES>, shares: &mut [f32; CHUNK]) -> LaneRun<LANES> {
    let over = shares.map(|share| if share > 1.0 { share } else { 1.0 });
    for share in &mut *shares {
        *share = if *share > 1.0 { 1.0 } else { *share };
    }
    lanes.map(|lane| std::array::from_fn(|k| lane[k] / over[k]))
}

/// The light that the environment adds.
struct Added {
    rgb: [[f32; CHUNK]; 3],
    /// Bit k is set where that, or the share of light that is lost, is enough to be seen.
    touched: u32,
}

fn added_by(lanes: &LaneRun<LANES>, shares: &[f32; CHUNK], colors: &Colors) -> Added {
    let mut rgb = [[0.0_f32; CHUNK]; 3];
    let mut is_touched = [0_u32; CHUNK];
    for k in 0..CHUNK {
        // No color can be more.
        let mut bound = 0.0;
        let mut add = [0.0_f32; 3];
        for (at, lane) in LIT.into_iter().enumerate() {
            let share = lanes[lane][k];
            bound += share.abs() * colors.greatest[at];
            // The steps of a kernel leave a trace of less than nothing beside a glint; under the
            // sun it would be a black pixel.
            let lit = if lane == SUN && share <= 0.0 { 0.0 } else { share };
            for c in 0..3 {
                add[c] += lit * colors.rgb[at][c];
            }
        }
        let mut most = shares[k].abs();
        for c in 0..3 {
            rgb[c][k] = add[c];
            most = if add[c].abs() > most { add[c].abs() } else { most };
        }
        let may_touch = bound + lanes[FRAME][k].abs() >= LEAST_INFLUENCE;
        is_touched[k] = u32::from(may_touch & (most >= LEAST_INFLUENCE));
    }
    let touched = is_touched
        .into_iter()
        .enumerate()
        .fold(0, |bits, (k, is_touched)| bits | is_touched << k);
    Added { rgb, touched }
}

impl Run {
    fn is_touched(&self, k: usize) -> bool {
        self.touched >> k & 1 == 1
    }

    /// What is kept and added of every color where the layer has none of its own.
    fn shine(&mut self, added: &Added, lanes: &LaneRun<LANES>, shares: &[f32; CHUNK]) {
        let is_touched: [bool; CHUNK] = std::array::from_fn(|k| self.is_touched(k));
        for k in 0..CHUNK {
            let kept = 1.0 - shares[k];
            let frame = lanes[FRAME][k];
            let kept = if frame > LEAST_ELSEWHERE {
                kept
            } else {
                kept + frame
            };
            for c in 0..3 {
                self.keep[c][k] = if is_touched[k] { kept } else { 1.0 };
                self.add[c][k] = if is_touched[k] { added.rgb[c][k] } else { 0.0 };
            }
        }
    }

    /// What is kept and added where more of one color is reflected than of another.
    fn tint(
        &mut self,
        added: &Added,
        lanes: &LaneRun<LANES>,
        shares: &[f32; CHUNK],
        [_, red, green, blue]: &LaneRun<4>,
    ) {
        for k in self.touched_among(CHUNK) {
            let tint = [red[k], green[k], blue[k]];
            if tint.iter().all(|color| color.abs() <= 0.0) {
                continue;
            }
            let (share, frame) = (shares[k], lanes[FRAME][k]);
            let lit_share = share - frame;
            for (c, color) in tint.into_iter().enumerate() {
                let tint = tint_of(color, lit_share, share);
                // What is reflected more of one color is so at the expense of what passes,
                // and by as much: nothing is lost.
                let kept = 1.0 - share - lit_share * tint;
                self.keep[c][k] = if frame > LEAST_ELSEWHERE {
                    kept
                } else {
                    kept + frame
                };
                self.add[c][k] = added.rgb[c][k] * (1.0 + tint);
            }
        }
    }
}

/// Light of a run from elsewhere in the frame, if there is any.
fn elsewhere_of(layer: &PatternLayer, run: &Run, lanes: &LaneRun<LANES>) -> Option<Elsewhere> {
    let mut other = Elsewhere::new();
    let mut has_other = false;
    for k in run.touched_among(CHUNK) {
        let share = lanes[FRAME][k];
        if share <= LEAST_ELSEWHERE {
            continue;
        }
        has_other = true;
        other.set(k, [share, lanes[FRAME_U][k], lanes[FRAME_V][k]]);
        let beside = [(run.x + k + 1, run.y), (run.x + k, run.y + 1)].map(|(x, y)| {
            let lanes = layer.light.pixel(x, y)?;
            (lanes[FRAME] > LEAST_ELSEWHERE)
                .then(|| [lanes[FRAME_U] / lanes[FRAME], lanes[FRAME_V] / lanes[FRAME]])
        });
        other.widen(k, beside, layer.blur_px);
    }
    has_other.then_some(other)
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
