//! What a layer of facets shows, as far as it does not depend on the light.

use super::elsewhere::{FINE_WIDTHS, ONE_MIRROR, exponent_up, power_of};
use super::overlay::{LEAST_ELSEWHERE, LEAST_INFLUENCE};
use crate::maps::{CHUNK, LaneRun, LaneRuns};
use crate::pyramid::vectorized;
use crate::surface::{FRAME, FRAME_U, FRAME_V, LANES, N_SHARES, SQUARE, SUN, WIDTH};

/// By how much more than the mean red, green and blue are reflected, over that mean: −1 where none
/// of a color is, 2 where all is of this color.
pub(crate) type Tint = LaneRun<3>;

/// Facets that are rendered together.
#[derive(Debug, Clone)]
pub(crate) struct PatternLayer {
    /// Shares come to 1 together at most.
    pub(crate) light: LaneRuns<LANES>,
    pub(crate) tint: LaneRuns<3>,
    /// Whether it shows much of the frame at once, so that each lamp counts where that is averaged.
    pub(crate) has_drops: bool,
}

/// From what is told how far apart the places are that a pixel mixes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Spread {
    /// From how fast they run away from those of its neighbors, in a blur of this mean radius, px: of mirrors.
    Neighbors(f32),
    /// From their squares: of drops, each of which shows much of the frame.
    Squares,
}

impl PatternLayer {
    /// Of sums over facets, of which the places are weighted by their share and the tints by the
    /// light that is tinted.
    pub(super) fn of_sums(light: LaneRuns<LANES>, tint: &LaneRuns<4>, spread: Spread) -> Self {
        vectorized(
            #[inline(always)]
            || Self::of_all_sums(light, tint, spread),
        )
    }

    #[inline(always)]
    fn of_all_sums(mut light: LaneRuns<LANES>, tint: &LaneRuns<4>, spread: Spread) -> Self {
        let (width, height) = light.size();
        let mut tints = LaneRuns::with_room(width, height, tint.n_runs());
        for k in 0..light.n_runs() {
            find_places(&mut light, k, spread);
            let ((x, y), run) = light.nth_mut(k);
            let shares = shares_of(run);
            let over = shares.map(|share| if share > 1.0 { share } else { 1.0 });
            if shares.iter().any(|share| *share > 1.0) {
                at_most_one(run, &over);
            }
            if let Some(tint) = tint.run_at(x, y) {
                let tint = tint_of(run, &over, tint);
                if tint.as_flattened().iter().any(|color| color.abs() > 0.0) {
                    *tints.push((x, y)) = tint;
                }
            }
        }
        Self {
            light,
            tint: tints,
            has_drops: matches!(spread, Spread::Squares),
        }
    }
}

/// Places and widths of the k-th run, whose neighbors to the right and below are sums as yet.
#[inline(always)]
fn find_places(light: &mut LaneRuns<LANES>, k: usize, spread: Spread) {
    let (width, height) = light.size();
    let ((x, y), run) = light.nth_mut(k);
    let squares = std::mem::replace(&mut run[SQUARE], [0.0; CHUNK]);
    if !run[FRAME].iter().any(|share| *share > LEAST_ELSEWHERE) {
        [run[FRAME_U], run[FRAME_V]] = [[0.0; CHUNK]; 2];
        return;
    }
    let own = Places::of(run);
    let mut right = own.clone();
    let next = light.run_at(x + CHUNK, y).map(Places::first_of);
    right.shift_left(next, width - x);
    let below = light.run_at(x, y + 1).map_or(Places::NONE, Places::of);
    let (_, run) = light.nth_mut(k);
    let blur_px = match spread {
        Spread::Neighbors(blur_px) => blur_px,
        Spread::Squares => {
            #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
            let middle = [width, height].map(|n| 0.5 * n as f32);
            run[WIDTH] = own.widths(&squares, &run[FRAME], middle);
            // A pixel of what is sharp is as wide as that.
            1.0
        }
    };
    for beside in [right, below] {
        own.widen(&beside, blur_px, &mut run[WIDTH]);
    }
    if matches!(spread, Spread::Neighbors(_)) {
        run[WIDTH] = run[WIDTH].map(doubled_up);
    }
    [run[FRAME_U], run[FRAME_V]] = own.or_zero();
}

/// A width from which on the mean is of coarse cells alone: the next power of two, as banks keep it.
fn doubled_up(width: f32) -> f32 {
    if width > FINE_WIDTHS[1] {
        power_of(exponent_up(width))
    } else {
        width
    }
}

/// Sum of the shares of each pixel.
#[inline(always)]
fn shares_of(lanes: &LaneRun<LANES>) -> [f32; CHUNK] {
    let mut shares = [0.0; CHUNK];
    for lane in &lanes[..N_SHARES] {
        for (sum, share) in shares.iter_mut().zip(lane) {
            *sum += share;
        }
    }
    shares
}

/// All light over the sum of the shares where that is more than 1, as where facets of different blur lie over each
/// other.
fn at_most_one(run: &mut LaneRun<LANES>, over: &[f32; CHUNK]) {
    for lane in (0..N_SHARES).chain([SUN]) {
        for (light, over) in run[lane].iter_mut().zip(over) {
            *light /= over;
        }
    }
}

/// The tint of the light that is not from the frame; `sums` are those of its colors, over all
/// shares before they were at most 1.
fn tint_of(
    lanes: &LaneRun<LANES>,
    over: &[f32; CHUNK],
    [_, red, green, blue]: &LaneRun<4>,
) -> Tint {
    let shares = shares_of(lanes);
    [red, green, blue].map(|sums| {
        std::array::from_fn(|k| {
            let (share, lit_share) = (shares[k], shares[k] - lanes[FRAME][k]);
            if lit_share <= LEAST_INFLUENCE {
                return 0.0;
            }
            // No more than there is to reflect.
            let most = ((1.0 - share) / lit_share).clamp(0.0, 2.0);
            (sums[k] / over[k] / lit_share).clamp(-1.0, most)
        })
    })
}

/// The places that the pixels of a run show, px.
#[derive(Clone)]
struct Places {
    /// Not a number where a pixel shows none.
    u: [f32; CHUNK],
    v: [f32; CHUNK],
}

/// The place that a pixel of a share shows, px, by the sum of it; not a number where it shows none.
#[inline(always)]
fn place(sum: f32, share: f32) -> f32 {
    let place = sum / share;
    if share > LEAST_ELSEWHERE {
        place
    } else {
        f32::NAN
    }
}

impl Places {
    const NONE: Self = Self {
        u: [f32::NAN; CHUNK],
        v: [f32::NAN; CHUNK],
    };

    #[inline(always)]
    fn of(lanes: &LaneRun<LANES>) -> Self {
        let mut places = Self::NONE;
        for (to, lane) in [(&mut places.u, FRAME_U), (&mut places.v, FRAME_V)] {
            let sums = lanes[lane].iter().zip(&lanes[FRAME]);
            for (to, (sum, share)) in to.iter_mut().zip(sums) {
                *to = place(*sum, *share);
            }
        }
        places
    }

    /// The place of the first pixel of a run.
    fn first_of(lanes: &LaneRun<LANES>) -> [f32; 2] {
        [FRAME_U, FRAME_V].map(|lane| place(lanes[lane][0], lanes[FRAME][0]))
    }

    /// The places, 0 where there is none.
    #[inline(always)]
    fn or_zero(&self) -> [[f32; CHUNK]; 2] {
        [self.u, self.v].map(|of| of.map(|place| if place.is_nan() { 0.0 } else { place }))
    }

    /// The places of the pixels one to the right, up to the first `n`, beyond which there is no
    /// frame; `next` is that of the last one.
    #[inline(always)]
    fn shift_left(&mut self, next: Option<[f32; 2]>, n: usize) {
        let [u, v] = next.unwrap_or([f32::NAN; 2]);
        for (places, next) in [(&mut self.u, u), (&mut self.v, v)] {
            places[n.min(CHUNK)..].fill(f32::NAN);
            places.rotate_left(1);
            places[CHUNK - 1] = next;
        }
    }

    /// Averages pixels over so much of the frame as the places that they mix spread over: σ/√2 of their standard deviation
    /// σ. Of double that are the cells, lines between which have σ.
    #[inline(always)]
    fn widths(
        &self,
        squares: &[f32; CHUNK],
        shares: &[f32; CHUNK],
        [x, y]: [f32; 2],
    ) -> [f32; CHUNK] {
        let mut widths = [0.0; CHUNK];
        for (k, width) in widths.iter_mut().enumerate() {
            let (u, v) = (self.u[k] - x, self.v[k] - y);
            // What is not a number is not more.
            *width = (0.5 * (squares[k] / shares[k] - u * u - v * v).max(0.0)).sqrt();
        }
        widths
    }

    /// Averages pixels over more of the frame the faster their place runs away from that of a
    /// neighbor: mirrors mix over about a blur's radius.
    #[inline(always)]
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

#[cfg(test)]
mod tests {
    #![expect(clippy::float_cmp, reason = "sums and quotients of powers of two")]

    use super::*;
    use crate::surface::{CABIN_LOW, GROUND};

    /// One run of a frame of one row.
    fn run_of<const L: usize>(lanes: [f32; L]) -> LaneRuns<L> {
        let mut runs = LaneRuns::with_room(CHUNK, 1, 1);
        *runs.push((0, 0)) = lanes.map(|value| [value; CHUNK]);
        runs
    }

    /// A layer of some cabin light and light from (40, 8) in the frame.
    fn layer(cabin: f32, frame: f32, tint: [f32; 4]) -> PatternLayer {
        let mut lanes = [0.0; LANES];
        lanes[CABIN_LOW] = cabin;
        lanes[FRAME] = frame;
        lanes[FRAME_U] = 40.0 * frame;
        lanes[FRAME_V] = 8.0 * frame;
        PatternLayer::of_sums(run_of(lanes), &run_of(tint), Spread::Neighbors(3.0))
    }

    fn first<const L: usize>(runs: &LaneRuns<L>) -> Option<[f32; L]> {
        let run = runs.run_at(0, 0)?;
        Some(run.map(|lane| lane[0]))
    }

    #[test]
    fn facets_over_each_other_share_a_pixel_with_their_tints() {
        let once = layer(0.5, 0.25, [0.5, 0.05, 0.0, -0.05]);
        assert_eq!(
            first(&once.tint),
            Some([0.1, 0.0, -0.1]),
            "of the light that it tints"
        );
        // Of 2, each facet gets what it would have of a pixel with room.
        let over = layer(1.5, 0.5, [1.5, 0.15, 0.0, -0.15]);
        let scaled = layer(0.75, 0.25, [0.75, 0.075, 0.0, -0.075]);
        assert_eq!(first(&over.light), first(&scaled.light), "shares");
        // Nothing passes, so no color can be reflected more than all.
        let tint = first(&over.tint).unwrap_or_default();
        assert!(tint[0] <= 0.0 && (tint[2] + 0.1).abs() < 1e-6, "{tint:?}");
    }

    #[test]
    fn a_place_is_that_of_the_share_and_no_place_has_no_width() {
        let shown = layer(0.5, 0.25, [0.0; 4]);
        let lanes = first(&shown.light).unwrap_or([0.0; LANES]);
        let place = [lanes[FRAME_U], lanes[FRAME_V], lanes[WIDTH]];
        assert_eq!(place, [40.0, 8.0, 0.0], "one mirror");
        assert!(first(&shown.tint).is_none(), "no tint");
        let dark = layer(0.5, 0.0, [0.0; 4]);
        let lanes = first(&dark.light).unwrap_or([1.0; LANES]);
        let place = [lanes[FRAME_U], lanes[FRAME_V], lanes[WIDTH], lanes[GROUND]];
        assert_eq!(place, [0.0; 4], "nothing");
    }

    #[test]
    fn drops_are_averaged_over_what_they_mix() {
        // Half of the share from either end of 40 px, about a place off the middle of the frame.
        let mut sums = run_of([0.0; LANES]);
        let (_, run) = sums.nth_mut(0);
        run[FRAME] = [0.5; CHUNK];
        run[FRAME_U] = [0.5 * 60.0; CHUNK];
        run[FRAME_V] = [0.5 * 10.0; CHUNK];
        let [middle_u, middle_v] = [0.5 * CHUNK as f32, 0.5];
        let square = |u: f32| (u - middle_u).powi(2) + (10.0 - middle_v).powi(2);
        run[SQUARE] = [0.25 * (square(40.0) + square(80.0)); CHUNK];
        let none = LaneRuns::with_room(CHUNK, 1, 0);
        let layer = PatternLayer::of_sums(sums, &none, Spread::Squares);
        let lanes = first(&layer.light).unwrap_or([0.0; LANES]);
        assert!((lanes[WIDTH] - 200.0_f32.sqrt()).abs() < 0.01, "{lanes:?}");
        assert_eq!(lanes[SQUARE], 0.0, "layers leave none");
    }

    #[test]
    fn mirrors_that_show_places_far_apart_are_averaged() {
        // From pixel 3 to 4 the place jumps by 10 px to the right.
        let mut sums = run_of([0.0; LANES]);
        let (_, run) = sums.nth_mut(0);
        run[FRAME] = [0.5; CHUNK];
        run[FRAME_U] = std::array::from_fn(|k| if k > 3 { 0.5 * 30.0 } else { 0.5 * 20.0 });
        let layer = PatternLayer::of_sums(
            sums,
            &LaneRuns::with_room(CHUNK, 1, 0),
            Spread::Neighbors(4.0),
        );
        let width = layer.light.run_at(0, 0).map(|run| run[WIDTH]);
        let expected: [f32; CHUNK] = std::array::from_fn(|k| {
            if k == 3 {
                0.5 * (10.0 - ONE_MIRROR) * 4.0
            } else {
                0.0
            }
        });
        assert_eq!(
            width,
            Some(expected),
            "half of what is beyond one mirror, times the blur"
        );
    }
}
