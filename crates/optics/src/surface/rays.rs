//! Rays of sight that are followed side by side.

use pulp::Simd;

use super::lobe::LANES;
use crate::number::{MOST_LANES, Number, Several};

/// Rays that are followed together: as many as any processor can at once, at least.
pub(super) const MOST: usize = MOST_LANES;

/// Something that rays of sight meet.
pub(super) trait Seen {
    /// How much of it a ray stands for, and what that shows: of one ray or several, each by a place of its own.
    fn along<N: Number>(&self, at: [N; 2]) -> (N, [N; LANES]);
}

/// Rays that meet something, and what they show of it.
pub(super) struct Rays {
    pub(super) places: [[f64; MOST]; 2],
    pub(super) shares: [f64; MOST],
    pub(super) lanes: [[f64; LANES]; MOST],
}

impl Default for Rays {
    fn default() -> Self {
        Self {
            places: [[0.0; MOST]; 2],
            shares: [0.0; MOST],
            lanes: [[0.0; LANES]; MOST],
        }
    }
}

impl Rays {
    /// Finds what the first so many of them show.
    pub(super) fn follow(&mut self, n: usize, seen: &impl Seen) {
        pulp::Arch::new().dispatch(Following {
            rays: self,
            n,
            seen,
        });
    }
}

/// All rays, by as many at once as a processor can.
struct Following<'a, T> {
    rays: &'a mut Rays,
    n: usize,
    seen: &'a T,
}

impl<T: Seen> pulp::WithSimd for Following<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rays, n, seen } = self;
        for first in (0..n.min(MOST)).step_by(S::F64_LANES) {
            let places = (rays.places.each_ref()).map(|all| Several::load(simd, &all[first..]));
            let (share, lanes) = seen.along(places);
            share.store(&mut rays.shares[first..]);
            for (l, lane) in lanes.into_iter().enumerate() {
                let mut each = [0.0; MOST];
                lane.store(&mut each);
                for (lanes, value) in rays.lanes[first..].iter_mut().zip(each).take(S::F64_LANES) {
                    lanes[l] = value;
                }
            }
        }
    }
}
