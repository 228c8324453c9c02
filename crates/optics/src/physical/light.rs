//! A baked layer under a light: what each pixel keeps of its own, and what is added.

use wide::f32x8;

use super::elsewhere::Elsewhere;
use super::layer::{LAYER_LANES, PatternLayer, Tint, WIDTH};
use super::overlay::{LEAST_ELSEWHERE, LEAST_INFLUENCE, OverlayLayer, Run};
use crate::environment::{Environment, Rgb};
use crate::maps::{CHUNK, LaneRun};
use crate::surface::{CABIN, FRAME, FRAME_U, FRAME_V, GROUND, HORIZON, N_SHARES, SUN, ZENITH};

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

/// A layer that is given light run by run, in the order of rows.
pub(crate) struct Lighting {
    colors: Colors,
    layer: OverlayLayer,
}

impl Lighting {
    /// Of so many runs.
    pub(crate) fn new(environment: &Environment, n_runs: usize) -> Self {
        Self {
            colors: Colors::of(environment),
            layer: OverlayLayer {
                runs: Vec::with_capacity(n_runs),
                ..OverlayLayer::default()
            },
        }
    }

    /// The next run: its first pixel and row, its lanes, and its tint if it has one.
    pub(crate) fn push(
        &mut self,
        (x, y): (usize, usize),
        lanes: &LaneRun<LAYER_LANES>,
        tint: Option<&Tint>,
    ) {
        let is_lit = LIT.map(|lane| !is_dark(&lanes[lane]));
        let layer = &mut self.layer;
        let run = layer.runs.push_mut(Run::untouched((x, y)));
        let mut shares = [0.0; CHUNK];
        for g in 0..CHUNK / GROUP {
            let group = self.colors.group(lanes, g, is_lit);
            put_nth(&mut shares, g, group.shares);
            put_nth(&mut run.keep, g, group.keep);
            for (to, add) in run.add.iter_mut().zip(group.add) {
                put_nth(to, g, add);
            }
            run.touched |= group.touched << (g * GROUP);
        }
        if run.touched == 0 {
            layer.runs.pop();
            return;
        }
        let is_touched = BITS.map(|bit| run.touched & bit != 0);
        if let Some(tint) = tint {
            run.tinted = Some(layer.tinted.len());
            layer
                .tinted
                .push(run.tint(tint, (lanes, &shares), is_touched));
        }
        if let Some(other) = Elsewhere::of(lanes, is_touched) {
            run.elsewhere = Some(layer.elsewhere.len());
            layer.elsewhere.push(other);
        }
    }

    /// The layer under the light.
    pub(crate) fn into_layer(self) -> OverlayLayer {
        self.layer
    }
}

impl OverlayLayer {
    /// A layer under the light of an environment.
    pub(super) fn lit(layer: &PatternLayer, environment: &Environment) -> Self {
        let mut lighting = Lighting::new(environment, layer.light.n_runs());
        for (x, y, lanes) in layer.light.iter() {
            lighting.push((x, y), lanes, layer.tint.run_at(x, y));
        }
        lighting.into_layer()
    }
}

/// Whether there is nothing in a lane.
fn is_dark(lane: &[f32; CHUNK]) -> bool {
    let any = lane.iter().fold(0, |any, share| any | share.to_bits());
    // But for signs of zeros.
    any << 1 == 0
}

/// Of each pixel of a run, its bit.
const BITS: [u32; CHUNK] = {
    let mut bits = [0; CHUNK];
    let mut k = 0;
    while k < CHUNK {
        bits[k] = 1 << k;
        k += 1;
    }
    bits
};

/// Pixels that are lit together: as many as a processor's registers hold with all that is summed.
const GROUP: usize = 8;

/// The g-th group of a lane.
fn nth(lane: &[f32; CHUNK], g: usize) -> f32x8 {
    f32x8::new(lane.as_chunks().0[g])
}

fn put_nth(lane: &mut [f32; CHUNK], g: usize, values: f32x8) {
    lane.as_chunks_mut().0[g] = values.to_array();
}

/// A group of pixels under the light, whatever its tint.
struct LitGroup {
    /// Sum of the shares.
    shares: f32x8,
    keep: f32x8,
    add: [f32x8; 3],
    /// Bit k is set where light that is added, or the share that is lost, is enough to be seen.
    touched: u32,
}

impl Colors {
    #[inline]
    fn group(&self, lanes: &LaneRun<LAYER_LANES>, g: usize, is_lit: [bool; LIT.len()]) -> LitGroup {
        let [zero, one, least] = [0.0, 1.0, LEAST_INFLUENCE].map(f32x8::splat);
        let shares = lanes[..N_SHARES]
            .iter()
            .fold(zero, |sum, lane| sum + nth(lane, g));
        // No color can be more than the bound.
        let (mut bound, mut rgb) = (zero, [zero; 3]);
        for (l, lane) in LIT.into_iter().enumerate() {
            // Few runs have light of every kind.
            if !is_lit[l] {
                continue;
            }
            let share = nth(&lanes[lane], g);
            bound += share.abs() * f32x8::splat(self.greatest[l]);
            // The steps of a kernel leave a trace of less than nothing beside a glint; under the
            // sun it would be a black pixel.
            let lit = if lane == SUN {
                share.fast_max(zero)
            } else {
                share
            };
            for (sum, color) in rgb.iter_mut().zip(self.rgb[l]) {
                *sum += lit * f32x8::splat(color);
            }
        }
        let frame = nth(&lanes[FRAME], g);
        let most = rgb
            .iter()
            .fold(shares.abs(), |most, add| most.fast_max(add.abs()));
        let may_touch = (bound + frame.abs()).simd_ge(least);
        let is_touched = may_touch & most.simd_ge(least);
        // Light from elsewhere in the frame that is too little to be looked up passes.
        let is_elsewhere = frame.simd_gt(f32x8::splat(LEAST_ELSEWHERE));
        let kept = (one - shares) + is_elsewhere.bitselect(zero, frame);
        LitGroup {
            shares,
            keep: is_touched.bitselect(kept, one),
            add: rgb.map(|add| add & is_touched),
            touched: is_touched.to_bitmask(),
        }
    }
}

/// Light from elsewhere in the frame that is too little to be looked up: it passes.
fn own_share(frame: f32) -> f32 {
    if frame > LEAST_ELSEWHERE { 0.0 } else { frame }
}

impl Run {
    /// Tints what is added; gives what is kept of each color.
    fn tint(
        &mut self,
        tint: &Tint,
        (lanes, shares): (&LaneRun<LAYER_LANES>, &[f32; CHUNK]),
        is_touched: [bool; CHUNK],
    ) -> [[f32; CHUNK]; 3] {
        let frame = &lanes[FRAME];
        for (add, tint) in self.add.iter_mut().zip(tint) {
            for (add, tint) in add.iter_mut().zip(tint) {
                *add *= 1.0 + tint;
            }
        }
        // What is reflected more of one color is so at the expense of what passes, and by as much:
        // nothing is lost.
        tint.map(|tint| {
            std::array::from_fn(|k| {
                let lit_share = shares[k] - frame[k];
                let kept = (1.0 - shares[k] - lit_share * tint[k]) + own_share(frame[k]);
                if is_touched[k] { kept } else { 1.0 }
            })
        })
    }
}

impl Elsewhere {
    /// Light from elsewhere in the frame of the pixels that are touched, if there is any.
    fn of(lanes: &LaneRun<LAYER_LANES>, is_touched: [bool; CHUNK]) -> Option<Self> {
        let mut is_any = false;
        let share = std::array::from_fn(|k| {
            let share = lanes[FRAME][k];
            let is_shown = is_touched[k] & (share > LEAST_ELSEWHERE);
            is_any |= is_shown;
            if is_shown { share } else { 0.0 }
        });
        is_any.then(|| Self {
            share,
            u: lanes[FRAME_U],
            v: lanes[FRAME_V],
            width: lanes[WIDTH],
        })
    }
}
