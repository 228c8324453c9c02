//! A baked layer under a light: what each pixel keeps of its own, and what is added.

use super::elsewhere::{Elsewhere, ONE_MIRROR};
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

/// A run of pixels as it was baked, and what of its layer lies beside it.
pub(crate) struct BakedRun<'a> {
    /// First pixel and row.
    pub(crate) at: (usize, usize),
    pub(crate) lanes: &'a LaneRun<LANES>,
    pub(crate) tint: Option<&'a LaneRun<4>>,
    /// The run to the right, and the one below.
    pub(crate) right: Option<&'a LaneRun<LANES>>,
    pub(crate) below: Option<&'a LaneRun<LANES>>,
}

/// A layer that is given light run by run, in the order of rows.
pub(crate) struct Lighting {
    colors: Colors,
    frame_width: usize,
    blur_px: f32,
    layer: OverlayLayer,
}

impl Lighting {
    /// Of so many runs.
    pub(crate) fn new(
        (frame_width, blur_px): (usize, f32),
        environment: &Environment,
        n_runs: usize,
    ) -> Self {
        Self {
            colors: Colors::of(environment),
            frame_width,
            blur_px,
            layer: OverlayLayer {
                runs: Vec::with_capacity(n_runs),
                elsewhere: Vec::with_capacity(n_runs),
            },
        }
    }

    /// The next run.
    pub(crate) fn push(&mut self, baked: &BakedRun<'_>) {
        let mut shares = shares_of(baked.lanes);
        let scaled;
        let lanes = if any_above(&shares, 1.0) {
            scaled = scaled_to_one(baked.lanes, &mut shares);
            &scaled
        } else {
            baked.lanes
        };
        let added = added_by(lanes, &shares, &self.colors);
        if added.touched == 0 {
            return;
        }
        let run = self.layer.runs.push_mut(Run::untouched(baked.at));
        run.touched = added.touched;
        run.shine(&added, lanes, &shares);
        if let Some(tint) = baked.tint {
            run.tint(&added, lanes, &shares, tint);
        }
        if any_above(&lanes[FRAME], LEAST_ELSEWHERE)
            && let Some(other) =
                elsewhere_of(baked, lanes, run.touched, (self.frame_width, self.blur_px))
        {
            run.elsewhere = Some(self.layer.elsewhere.len());
            self.layer.elsewhere.push(other);
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
        let light = &layer.light;
        let frame = (light.size().0, layer.blur_px);
        let mut lighting = Lighting::new(frame, environment, light.n_runs());
        for (x, y, lanes) in light.iter() {
            lighting.push(&BakedRun {
                at: (x, y),
                lanes,
                tint: layer.tint.run_at(x, y),
                right: light.run_at(x + CHUNK, y),
                below: light.run_at(x, y + 1),
            });
        }
        lighting.into_layer()
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

/// Whether any value is more.
fn any_above(values: &[f32; CHUNK], limit: f32) -> bool {
    values
        .iter()
        .fold(false, |any, value| any | (*value > limit))
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

/// The light that the environment adds.
struct Added {
    rgb: [[f32; CHUNK]; 3],
    /// Bit k is set where that, or the share of light that is lost, is enough to be seen.
    touched: u32,
}

// Loops over all pixels of a run within loops over lanes and colors: so the compiler works on
// several pixels at once.
fn added_by(lanes: &LaneRun<LANES>, shares: &[f32; CHUNK], colors: &Colors) -> Added {
    // The steps of a kernel leave a trace of less than nothing beside a glint; under the sun it
    // would be a black pixel.
    let sun = lanes[SUN].map(|share| if share > 0.0 { share } else { 0.0 });
    // No color can be more.
    let mut bound = [0.0_f32; CHUNK];
    let mut rgb = [[0.0_f32; CHUNK]; 3];
    for (lane, (color, greatest)) in LIT.into_iter().zip(colors.rgb.iter().zip(colors.greatest)) {
        // Few runs have light of every kind.
        if is_dark(&lanes[lane]) {
            continue;
        }
        for (bound, share) in bound.iter_mut().zip(&lanes[lane]) {
            *bound += share.abs() * greatest;
        }
        let lit = if lane == SUN { &sun } else { &lanes[lane] };
        for (sums, color) in rgb.iter_mut().zip(color) {
            for (sum, share) in sums.iter_mut().zip(lit) {
                *sum += share * color;
            }
        }
    }
    let mut most = shares.map(f32::abs);
    for add in &rgb {
        for (most, add) in most.iter_mut().zip(add) {
            *most = if add.abs() > *most { add.abs() } else { *most };
        }
    }
    let is_touched: [bool; CHUNK] = std::array::from_fn(|k| {
        let may_touch = bound[k] + lanes[FRAME][k].abs() >= LEAST_INFLUENCE;
        may_touch & (most[k] >= LEAST_INFLUENCE)
    });
    let touched = is_touched
        .iter()
        .zip(BITS)
        .fold(0, |bits, (is_touched, bit)| {
            bits | if *is_touched { bit } else { 0 }
        });
    Added { rgb, touched }
}

impl Run {
    /// What is kept and added of every color where the layer has none of its own.
    fn shine(&mut self, added: &Added, lanes: &LaneRun<LANES>, shares: &[f32; CHUNK]) {
        let touched = self.touched;
        let is_touched = BITS.map(|bit| touched & bit != 0);
        let kept: [f32; CHUNK] = std::array::from_fn(|k| {
            let (kept, frame) = (1.0 - shares[k], lanes[FRAME][k]);
            let with_frame = kept + frame;
            let kept = if frame > LEAST_ELSEWHERE {
                kept
            } else {
                with_frame
            };
            if is_touched[k] { kept } else { 1.0 }
        });
        self.keep = [kept; 3];
        for (to, add) in self.add.iter_mut().zip(&added.rgb) {
            *to = std::array::from_fn(|k| if is_touched[k] { add[k] } else { 0.0 });
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

/// Light of a run from elsewhere in the frame, if there is any; `lanes` are those of the run, of
/// shares of at most 1 together.
fn elsewhere_of(
    baked: &BakedRun<'_>,
    lanes: &LaneRun<LANES>,
    touched: u32,
    (frame_width, blur_px): (usize, f32),
) -> Option<Elsewhere> {
    let shows = |k: usize| touched >> k & 1 == 1 && lanes[FRAME][k] > LEAST_ELSEWHERE;
    let shows: [bool; CHUNK] = std::array::from_fn(shows);
    if !shows.contains(&true) {
        return None;
    }
    let own = Places::of(lanes);
    // The neighbors as they were baked.
    let mut right = if std::ptr::eq(baked.lanes, lanes) {
        own.clone()
    } else {
        Places::of(baked.lanes)
    };
    let next = baked.right.map(Places::first_of);
    right.shift_left(next, frame_width - baked.at.0);
    let below = baked.below.filter(|below| !is_dark(&below[FRAME]));
    let below = below.map_or(Places::NONE, Places::of);
    let mut width = [0.0; CHUNK];
    for beside in [right, below] {
        own.widen(&beside, blur_px, &mut width);
    }
    let only = |values: &[f32; CHUNK]| {
        let value = |k: usize| if shows[k] { values[k] } else { 0.0 };
        std::array::from_fn(value)
    };
    Some(Elsewhere {
        share: only(&lanes[FRAME]),
        u: only(&own.u),
        v: only(&own.v),
        width: only(&width),
    })
}

/// The place that a pixel shows, px, in the direction of a lane; not a number where it shows none.
fn place(lanes: &LaneRun<LANES>, lane: usize, k: usize) -> f32 {
    let share = lanes[FRAME][k];
    let place = lanes[lane][k] / share;
    if share > LEAST_ELSEWHERE {
        place
    } else {
        f32::NAN
    }
}

/// The places that the pixels of a run show, px.
#[derive(Clone)]
struct Places {
    /// Not a number where a pixel shows none.
    u: [f32; CHUNK],
    v: [f32; CHUNK],
}

impl Places {
    const NONE: Self = Self {
        u: [f32::NAN; CHUNK],
        v: [f32::NAN; CHUNK],
    };

    fn of(lanes: &LaneRun<LANES>) -> Self {
        let over = |lane: usize| std::array::from_fn(|k| place(lanes, lane, k));
        Self {
            u: over(FRAME_U),
            v: over(FRAME_V),
        }
    }

    /// The place of the first pixel of a run.
    fn first_of(lanes: &LaneRun<LANES>) -> [f32; 2] {
        [place(lanes, FRAME_U, 0), place(lanes, FRAME_V, 0)]
    }

    /// The places of the pixels one to the right, up to the first `n`, beyond which there is no
    /// frame; `next` is that of the last one.
    fn shift_left(&mut self, next: Option<[f32; 2]>, n: usize) {
        let [u, v] = next.unwrap_or([f32::NAN; 2]);
        for (places, next) in [(&mut self.u, u), (&mut self.v, v)] {
            places[n.min(CHUNK)..].fill(f32::NAN);
            places.rotate_left(1);
            places[CHUNK - 1] = next;
        }
    }

    /// Averages pixels over more of the frame the faster their place runs away from that of a
    /// neighbor: mirrors mix over about a blur's radius.
    fn widen(&self, beside: &Self, blur_px: f32, width: &mut [f32; CHUNK]) {
        for (k, width) in width.iter_mut().enumerate() {
            let (du, dv) = (beside.u[k] - self.u[k], beside.v[k] - self.v[k]);
            let excess = (du * du + dv * dv).sqrt() - ONE_MIRROR;
            let wide = 0.5 * excess * blur_px;
            // What is not a number is not more.
            *width = if wide > *width { wide } else { *width };
        }
    }
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
