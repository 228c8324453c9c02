//! What drops show that are too small to be seen in parts: the mean over the drop, and how that changes across it.
//!
//! Of one contact angle, what a drop shows is the same whatever its size, and depends on the direction of sight alone.
//! So it is found at some places of the frame, by many rays each, and lies on straight lines between them.

use super::drops::RIM;
use super::lobe::{FRAME, FRAME_U, FRAME_V, LANES, SQUARE};
use super::rays::{MOST, Rays, Seen};
use super::water::{Sight, Water};
use crate::number::Number;

/// From one of these places to the next, of the focal length, and the most on a side of the frame.
const STEP: f64 = 0.2;
const MOST_PLACES: u32 = 32;

/// Rays of a place along each side of a square around the drop.
const RAYS: u32 = 20;

/// What a drop shows about its middle, per lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glimpse {
    mean: [f32; LANES],
    /// Change per radius to the right and down.
    slopes: [[f32; LANES]; 2],
}

impl Glimpse {
    /// What a place shows that is so far from the mean one, of the radius, times a weight.
    pub(super) fn lanes(&self, [right, down]: [f64; 2], weight: f64) -> [f32; LANES] {
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let [right, down, weight] = [right as f32, down as f32, weight as f32];
        let [x, y] = &self.slopes;
        std::array::from_fn(|k| weight * (self.mean[k] + right * x[k] + down * y[k]))
    }
}

/// Mean and slopes of a drop that appears at a place of the frame, with what it shows of the frame from there; none where
/// the pane is not before the camera.
fn mean_and_slopes(water: &Water<'_>, px: [f64; 2]) -> Option<[[f64; LANES]; 3]> {
    let sheet = water.from.sheet;
    let (_, sight) = sheet.behind(px, sheet.outer_mm())?;
    let sight = water.sight(sight);
    let middle = middle_px(sheet.view().size());
    let (mut sums, mut squares) = ([[0.0; LANES]; 3], [0.0; 3]);
    let place = |k: u32| (2.0 * f64::from(k) + 1.0) / f64::from(RAYS) - 1.0;
    let places = (0..RAYS).flat_map(|y| (0..RAYS).map(move |x| [place(x), place(y)]));
    let places: Vec<[f64; 2]> = places.filter(|[x, y]| x * x + y * y <= 1.0).collect();
    let seen = Glimpsed { water, sight };
    let mut rays = Rays::default();
    for places in places.chunks(MOST) {
        for (k, [x, y]) in places.iter().enumerate() {
            let inside = (RIM / (x * x + y * y).sqrt()).min(1.0);
            [rays.places[0][k], rays.places[1][k]] = [inside * x, inside * y];
        }
        rays.follow(places.len(), &seen);
        for ([x, y], mut lanes) in places.iter().zip(rays.lanes) {
            seen_from(&mut lanes, px, middle);
            for (k, by) in [1.0, *x, *y].into_iter().enumerate() {
                squares[k] += by * by;
                for (sum, lane) in sums[k].iter_mut().zip(lanes) {
                    *sum += by * lane;
                }
            }
        }
    }
    Some([0, 1, 2].map(|k| sums[k].map(|sum| sum / squares[k])))
}

/// A round drop along one direction of sight.
struct Glimpsed<'a> {
    water: &'a Water<'a>,
    sight: Sight,
}

impl Seen for Glimpsed<'_> {
    #[inline(always)]
    fn along<N: Number>(&self, at: [N; 2]) -> (N, [N; LANES]) {
        let sight = self
            .sight
            .of_all(self.sight.along.map(|part| at[0].all(part)));
        let lanes = self.water.seen(self.water.in_round(at), &sight);
        (at[0].all(1.0), lanes)
    }
}

/// The middle of the frame, px.
fn middle_px((width, height): (u32, u32)) -> [f64; 2] {
    [width, height].map(|side| 0.5 * f64::from(side))
}

/// Makes places in a frame of a middle, px, those from a place of it.
fn seen_from(lanes: &mut [f64; LANES], px: [f64; 2], middle: [f64; 2]) {
    lanes[FRAME_U] -= lanes[FRAME] * px[0];
    lanes[FRAME_V] -= lanes[FRAME] * px[1];
    lanes[SQUARE] -= square_more(lanes, px, middle);
}

/// Makes places from a place of a frame those in it, as lanes have them: the contrary of [`seen_from`].
fn in_frame(lanes: &mut [f64; LANES], px: [f64; 2], middle: [f64; 2]) {
    lanes[SQUARE] += square_more(lanes, px, middle);
    lanes[FRAME_U] += lanes[FRAME] * px[0];
    lanes[FRAME_V] += lanes[FRAME] * px[1];
}

/// How much larger squares are about the middle of a frame than about a place of it, from which places are.
fn square_more(lanes: &[f64; LANES], px: [f64; 2], middle: [f64; 2]) -> f64 {
    let [x, y] = [px[0] - middle[0], px[1] - middle[1]];
    2.0 * (x * lanes[FRAME_U] + y * lanes[FRAME_V]) + (x * x + y * y) * lanes[FRAME]
}

/// Glimpses of drops of one contact angle all over a frame.
#[derive(Debug)]
pub(super) struct Glimpses {
    /// Width and height of the frame, px.
    frame: (u32, u32),
    /// Places from one side of the frame to the other and down.
    size: [u32; 2],
    known: Vec<Option<[[f64; LANES]; 3]>>,
}

impl Glimpses {
    pub(super) fn of(water: &Water<'_>) -> Self {
        let sheet = water.from.sheet;
        let (width, height) = sheet.view().size();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some places"
        )]
        let size = [width, height].map(|side| {
            let steps = (f64::from(side) / (STEP * sheet.f_px())).ceil();
            steps.clamp(1.0, f64::from(MOST_PLACES)) as u32 + 1
        });
        let place = |k: u32, n: u32, side: u32| f64::from(k) / f64::from(n - 1) * f64::from(side);
        let known = (0..size[1])
            .flat_map(|y| (0..size[0]).map(move |x| [x, y]))
            .map(|[x, y]| {
                let px = [place(x, size[0], width), place(y, size[1], height)];
                mean_and_slopes(water, px)
            })
            .collect();
        Self {
            frame: (width, height),
            size,
            known,
        }
    }

    /// Of a drop that appears at a place, px; beyond the frame that of its border. Where it is not blurred no share is below
    /// 0 anywhere on it. None where some of what is around it is not known.
    pub(super) fn at(&self, px: [f64; 2], is_blurred: bool) -> Option<Glimpse> {
        let (width, height) = self.frame;
        let [(left, s), (top, t)] = [(0, width), (1, height)].map(|(k, side)| {
            let steps = self.size[k] - 1;
            let at = (px[k] / f64::from(side)).clamp(0.0, 1.0) * f64::from(steps);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "some places"
            )]
            let before = (at as u32).min(steps - 1);
            (before, at - f64::from(before))
        });
        let mut all = [[0.0; LANES]; 3];
        for (down, t) in [(0, 1.0 - t), (1, t)] {
            for (right, s) in [(0, 1.0 - s), (1, s)] {
                let place = (top + down) * self.size[0] + left + right;
                let there = self.known[place as usize].as_ref()?;
                for (all, there) in all.iter_mut().zip(there) {
                    for (lane, there) in all.iter_mut().zip(there) {
                        *lane += s * t * there;
                    }
                }
            }
        }
        for lanes in &mut all {
            in_frame(lanes, px, middle_px(self.frame));
        }
        let [mean, mut right, mut down] = all;
        for (k, mean) in mean.iter().enumerate() {
            let most = libm::hypot(right[k], down[k]);
            let limit = if is_blurred || matches!(k, FRAME_U | FRAME_V) || most <= *mean {
                1.0
            } else {
                mean / most
            };
            right[k] *= limit;
            down[k] *= limit;
        }
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let [mean, right, down] = [mean, right, down].map(|lanes| lanes.map(|lane| lane as f32));
        Some(Glimpse {
            mean,
            slopes: [right, down],
        })
    }
}
