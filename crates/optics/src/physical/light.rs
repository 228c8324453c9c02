//! A baked layer under a light: what each pixel keeps of its own, and what is added.

use wide::f32x8;

use super::Glass;
use super::elsewhere::{Elsewhere, part_averaged};
use super::layer::{PatternLayer, Tint};
use super::overlay::{LEAST_ELSEWHERE, LEAST_INFLUENCE, OverlayLayer, Run};
use crate::bit_rows::set_bits;
use crate::environment::{Environment, HemisphereWeights, Rgb};
use crate::maps::{CHUNK, LaneRun};
use crate::surface::{
    CABIN_HIGH, CABIN_LOW, FRAME, FRAME_U, FRAME_V, GROUND, HELD, HORIZON, LANES, N_SHARES, SUN,
    WIDTH, ZENITH,
};

/// Lanes with light of their own: all shares but the frame's, which is looked up, and the sun's.
const LIT: [usize; 7] = [HORIZON, ZENITH, GROUND, CABIN_LOW, CABIN_HIGH, HELD, SUN];

/// Absorption of clear soda-lime glass in red, green and blue (610, 550 and 450 nm), per m
/// \[Rubin1985\].
const ABSORPTION_PER_M: [f64; 3] = [10.7, 5.0, 5.4];

/// Mean sine of the angle between light that the faces hold and their normal: between 1/n and 1.
const HELD_SINE: f64 = 0.83;

impl Glass {
    /// Radiance of light that the faces hold: ρ exp(−a D/sin θ) of what falls on the rim, with ρ
    /// the rim's reflectance, D the way to it and a the absorption of the glass.
    fn held_light(&self, environment: &Environment) -> Rgb {
        let rim = HemisphereWeights::facing(0.0).mean_radiance(environment);
        std::array::from_fn(|k| {
            let way_m = 1e-3 * self.rim_way_mm / HELD_SINE;
            let left = self.rim_reflectance * libm::exp(-ABSORPTION_PER_M[k] * way_m);
            #[expect(clippy::cast_possible_truncation, reason = "light as f32")]
            let left = left as f32;
            rim[k] * left
        })
    }
}

/// The light of each of the first lanes.
#[derive(Clone, Copy)]
pub(crate) struct Colors {
    /// None of the frame's.
    rgb: [Rgb; SUN + 1],
    /// The greatest of each color, at least 1, where there is light.
    greatest: [f32; SUN + 1],
}

impl Colors {
    pub(crate) fn of(environment: &Environment, glass: &Glass) -> Self {
        let mut colors = Self {
            rgb: [[0.0; 3]; SUN + 1],
            greatest: [0.0; SUN + 1],
        };
        let rgb = [
            environment.horizon_rgb,
            environment.zenith_rgb,
            environment.ground_rgb,
            environment.cabin_low_rgb,
            environment.cabin_high_rgb,
            glass.held_light(environment),
            environment.sun_rgb,
        ];
        for (lane, rgb) in LIT.into_iter().zip(rgb) {
            colors.rgb[lane] = rgb;
            colors.greatest[lane] = rgb.into_iter().fold(1.0, f32::max);
        }
        colors
    }
}

/// A layer that is given light run by run, in the order of rows.
pub(crate) struct Lighting {
    colors: Colors,
    layer: OverlayLayer,
}

impl Lighting {
    /// Of so many runs, in the memory of a layer that is no longer needed.
    pub(crate) fn new(colors: Colors, n_runs: usize, mut layer: OverlayLayer) -> Self {
        layer.runs.clear();
        layer.runs.reserve(n_runs);
        // Few layers have more of them than every other run.
        layer.tinted.clear();
        layer.tinted.reserve(n_runs / 2);
        layer.elsewhere.clear();
        layer.elsewhere.reserve(n_runs / 2);
        Self { colors, layer }
    }

    /// The next run: its first pixel and row, its lanes with a bit for each that is not all zeros,
    /// and its tint if it has one. Shares and light of the sun are not read without their bit, nor
    /// are place and width without that of the frame's share.
    #[inline(always)]
    pub(crate) fn push(
        &mut self,
        (x, y): (usize, usize),
        (lanes, present): (&LaneRun<LANES>, usize),
        tint: Option<&Tint>,
    ) {
        let layer = &mut self.layer;
        let run = layer.runs.push_mut(Run::untouched((x, y)));
        let mut shares = [0.0; CHUNK];
        for g in 0..CHUNK / GROUP {
            let group = self.colors.group(lanes, g, present);
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
        let has_frame = has(present, FRAME);
        if let Some(tint) = tint {
            let frame = if has_frame { &lanes[FRAME] } else { &NOTHING };
            run.tinted = Some(layer.tinted.len());
            layer.tinted.push(run.tint(tint, &shares, frame));
        }
        if has_frame && let Some(other) = Elsewhere::of(lanes, run.touched) {
            run.elsewhere = Some(layer.elsewhere.len());
            layer.elsewhere.push(other);
        }
    }

    /// The layer under the light, for frames of a size, px.
    pub(crate) fn into_layer(mut self, size: (usize, usize)) -> OverlayLayer {
        self.layer.find_averaged(size);
        self.layer
    }
}

impl OverlayLayer {
    /// A layer under a light, in the memory of another.
    pub(super) fn lit(layer: &PatternLayer, colors: Colors, memory: Self) -> Self {
        let mut lighting = Lighting::new(colors, layer.light.n_runs(), memory);
        for (x, y, lanes) in layer.light.iter() {
            lighting.push(
                (x, y),
                (lanes, present_lanes(lanes)),
                layer.tint.run_at(x, y),
            );
        }
        Self {
            has_drops: layer.has_drops,
            ..lighting.into_layer(layer.light.size())
        }
    }
}

/// A lane that is not present.
static NOTHING: [f32; CHUNK] = [0.0; CHUNK];

/// A bit for each lane that is not all zeros.
fn present_lanes(lanes: &LaneRun<LANES>) -> usize {
    lanes.iter().enumerate().fold(0, |present, (lane, values)| {
        let any = values.iter().fold(0, |any, value| any | value.to_bits());
        // But for signs of zeros.
        present | usize::from(any << 1 != 0) << lane
    })
}

#[inline(always)]
fn has(present: usize, lane: usize) -> bool {
    present >> lane & 1 == 1
}

/// Pixels that are lit together: as many as a processor's registers hold with all that is summed.
const GROUP: usize = 8;

/// Whether the bit of pixel k is set.
#[inline(always)]
fn is_set(touched: u32, k: usize) -> bool {
    touched >> k & 1 == 1
}

/// The g-th group of a lane.
#[inline(always)]
fn nth(lane: &[f32; CHUNK], g: usize) -> f32x8 {
    f32x8::new(lane.as_chunks().0[g])
}

#[inline(always)]
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
    #[inline(always)]
    fn group(&self, lanes: &LaneRun<LANES>, g: usize, present: usize) -> LitGroup {
        let [zero, one, least] = [0.0, 1.0, LEAST_INFLUENCE].map(f32x8::splat);
        // No color can be more than the bound.
        let (mut shares, mut bound, mut rgb) = (zero, zero, [zero; 3]);
        let mut add = |lane: usize, lit: f32x8| {
            bound += lit.abs() * self.greatest[lane];
            for (sum, color) in rgb.iter_mut().zip(self.rgb[lane]) {
                *sum += lit * color;
            }
        };
        // Few runs have light of every kind, and no branch can foretell of which.
        for lane in set_bits(present as u64 % (1 << N_SHARES)) {
            let share = nth(&lanes[lane], g);
            shares += share;
            add(lane, share);
        }
        if has(present, SUN) {
            // The steps of a kernel leave a trace of less than nothing beside a glint; under the
            // sun it would be a black pixel.
            add(SUN, nth(&lanes[SUN], g).fast_max(zero));
        }
        let frame = if has(present, FRAME) {
            nth(&lanes[FRAME], g)
        } else {
            zero
        };
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
#[inline(always)]
fn own_share(frame: f32) -> f32 {
    if frame > LEAST_ELSEWHERE { 0.0 } else { frame }
}

impl Run {
    /// Tints what is added; gives what is kept of each color.
    #[inline(always)]
    fn tint(
        &mut self,
        tint: &Tint,
        shares: &[f32; CHUNK],
        frame: &[f32; CHUNK],
    ) -> [[f32; CHUNK]; 3] {
        for (add, tint) in self.add.iter_mut().zip(tint) {
            for (add, tint) in add.iter_mut().zip(tint) {
                *add *= 1.0 + tint;
            }
        }
        // What is reflected more of one color is so at the expense of what passes, and by as much:
        // nothing is lost.
        let mut keep = [[1.0; CHUNK]; 3];
        for (keep, tint) in keep.iter_mut().zip(tint) {
            for k in 0..CHUNK {
                let lit_share = shares[k] - frame[k];
                let kept = (1.0 - shares[k] - lit_share * tint[k]) + own_share(frame[k]);
                keep[k] = if is_set(self.touched, k) { kept } else { 1.0 };
            }
        }
        keep
    }
}

impl Elsewhere {
    /// Light from elsewhere in the frame of the pixels that are touched, if there is any.
    #[inline(always)]
    fn of(lanes: &LaneRun<LANES>, touched: u32) -> Option<Self> {
        let mut share = lanes[FRAME];
        let (mut is_fine, mut is_wide) = (0, 0);
        for (k, share) in share.iter_mut().enumerate() {
            let is_shown = is_set(touched, k) & (*share > LEAST_ELSEWHERE);
            let averaged = part_averaged(lanes[WIDTH][k]);
            is_fine |= u32::from(is_shown & (averaged < 1.0)) << k;
            is_wide |= u32::from(is_shown & (averaged > 0.0)) << k;
            *share = if is_shown { *share } else { 0.0 };
        }
        let is_any = (is_fine | is_wide) > 0;
        is_any.then(|| Self {
            share,
            u: lanes[FRAME_U],
            v: lanes[FRAME_V],
            width: lanes[WIDTH],
            is_fine,
            is_wide,
        })
    }
}
