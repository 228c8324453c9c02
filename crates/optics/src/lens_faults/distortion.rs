//! Lines that bend, and a picture that is moved.

use super::Optic;
use super::resample::{Beyond, Resampling};

/// How a lens projects what a pinhole would.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Projection {
    /// Brown and Conrady's \[Brown1966\]: x′ = x (1 + k₁r² + k₂r⁴ + k₃r⁶) + tangential terms.
    Brown,
    /// Kannala and Brandt's, of fisheyes \[KannalaBrandt2006\]: r′ = θ (1 + k₁θ² + k₂θ⁴ + k₃θ⁶ + k₄θ⁸), tan θ = r.
    Fisheye,
}

/// Distortion that nothing corrects: what a pinhole shows at r is seen elsewhere. Its coefficients are those of OpenCV.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distortion {
    /// By which law.
    pub projection: Projection,
    /// Radial coefficients; the fourth is of fisheyes alone.
    pub k: [f64; 4],
    /// Tangential coefficients p₁ and p₂; not of fisheyes.
    pub p: [f64; 2],
    /// How much farther out a corner is moved, a share of half the diagonal; added to k₁ of Brown's law.
    pub corner: f64,
    /// How far everything is moved to the right and down, px.
    pub shift_px: [f64; 2],
}

impl Distortion {
    /// None, by Brown's law.
    pub const NONE: Self = Self {
        projection: Projection::Brown,
        k: [0.0; 4],
        p: [0.0; 2],
        corner: 0.0,
        shift_px: [0.0; 2],
    };

    /// Whether it changes nothing.
    pub(super) fn is_nothing(&self) -> bool {
        let coefficients = self.k.iter().chain(&self.p).chain(&self.shift_px);
        self.projection == Projection::Brown
            && coefficients.chain([&self.corner]).all(|it| it.abs() <= 0.0)
    }

    /// With what the corner adds to k₁.
    fn radial(&self, optic: &Optic) -> [f64; 4] {
        let corner = optic.half_diagonal_px() / optic.f_px;
        let [k1, k2, k3, k4] = self.k;
        [k1 + self.corner / (corner * corner), k2, k3, k4]
    }

    /// Where the camera shows what a pinhole would show at a place of the frame, px.
    #[must_use]
    pub fn moved(&self, at: [f64; 2], optic: &Optic) -> [f64; 2] {
        let middle = optic.middle();
        let [x, y] = [0, 1].map(|k| (at[k] - middle[k]) / optic.f_px);
        let moved = self.of_plane([x, y], self.radial(optic));
        std::array::from_fn(|k| middle[k] + optic.f_px * moved[k] + self.shift_px[k])
    }

    /// The law, at a distance of 1 behind the pinhole.
    fn of_plane(&self, [x, y]: [f64; 2], k: [f64; 4]) -> [f64; 2] {
        let square = x * x + y * y;
        if self.projection == Projection::Fisheye {
            let gain = fisheye(square.sqrt(), k);
            return [gain * x, gain * y];
        }
        let gain = 1.0 + square * (k[0] + square * (k[1] + square * k[2]));
        let [p1, p2] = self.p;
        [
            gain * x + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
            gain * y + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// What a place of the picture shows of the plane; none where no place is seen there.
    fn of_picture(&self, [x, y]: [f64; 2], k: [f64; 4], most: f64) -> Option<[f64; 2]> {
        // Newton in two directions, with differences for slopes.
        const STEP: f64 = 1e-6;
        // Where the law grows, or it would be caught beyond its turn.
        let radius = libm::hypot(x, y);
        let inward = (0.99 * most / radius.max(1e-12)).min(1.0);
        let mut at = [inward * x, inward * y];
        for _ in 0..30 {
            let here = self.of_plane(at, k);
            let miss = [here[0] - x, here[1] - y];
            if miss[0].abs() + miss[1].abs() < 1e-9 {
                let r2 = at[0] * at[0] + at[1] * at[1];
                return (r2 <= most * most).then_some(at);
            }
            let right = self.of_plane([at[0] + STEP, at[1]], k);
            let down = self.of_plane([at[0], at[1] + STEP], k);
            let [a, c] = [0, 1].map(|k| (right[k] - here[k]) / STEP);
            let [b, d] = [0, 1].map(|k| (down[k] - here[k]) / STEP);
            let determinant = a * d - b * c;
            if determinant <= 1e-6 {
                return None;
            }
            at[0] -= (d * miss[0] - b * miss[1]) / determinant;
            at[1] -= (a * miss[1] - c * miss[0]) / determinant;
        }
        None
    }

    /// Distance from the axis up to which the law grows, beyond which it would show things twice.
    fn grows_up_to(&self, k: [f64; 4]) -> f64 {
        let radius = |r: f64| {
            let [x, _] = self.of_plane([r, 0.0], k);
            x
        };
        let mut r = 0.0;
        // No frame shows more than that.
        while r < 20.0 {
            let next = r + 0.01;
            if radius(next) <= radius(r) {
                return r;
            }
            r = next;
        }
        f64::INFINITY
    }

    /// The law for frames of one size.
    pub(super) fn for_frames(&self, optic: &Optic) -> OfFrames {
        let k = self.radial(optic);
        let without_p = Self {
            p: [0.0; 2],
            ..*self
        };
        let most = without_p.grows_up_to(k);
        let is_radial = self.p.iter().all(|p| p.abs() <= 0.0);
        let most_shown = match is_radial && most.is_finite() {
            true => without_p.of_plane([most, 0.0], k)[0],
            false => f64::INFINITY,
        };
        OfFrames {
            fault: *self,
            k,
            most,
            most_shown,
            middle: optic.middle(),
            f_px: optic.f_px,
        }
    }

    /// Where the pixels of frames come from.
    pub(super) fn resampling(&self, optic: &Optic) -> Resampling {
        let of_frames = self.for_frames(optic);
        Resampling::new(optic.size, Beyond::Nothing, |u, v| {
            of_frames.shown_at([u, v])
        })
    }
}

/// A distortion with what it needs to know of frames of one size.
#[derive(Debug, Clone)]
pub(super) struct OfFrames {
    fault: Distortion,
    k: [f64; 4],
    /// Distance from the axis up to which the law grows.
    most: f64,
    /// Distance from the axis at which that is shown, beyond which nothing is.
    most_shown: f64,
    middle: [f64; 2],
    f_px: f64,
}

impl OfFrames {
    /// Where the camera shows what a pinhole would show at a place, px; none beyond the distance up to which the law
    /// grows: nobody sees that.
    pub(super) fn seen_at(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        let [x, y] = [0, 1].map(|k| (at[k] - self.middle[k]) / self.f_px);
        if x * x + y * y > self.most * self.most {
            return None;
        }
        let moved = self.fault.of_plane([x, y], self.k);
        let shift_px = self.fault.shift_px;
        Some(std::array::from_fn(|k| {
            self.middle[k] + self.f_px * moved[k] + shift_px[k]
        }))
    }

    /// What place of a pinhole's frame, or beyond it, the camera shows at a place, px; none where it shows none.
    pub(super) fn shown_at(&self, [u, v]: [f64; 2]) -> Option<[f64; 2]> {
        let at = [u - self.fault.shift_px[0], v - self.fault.shift_px[1]];
        let at: [f64; 2] = std::array::from_fn(|k| (at[k] - self.middle[k]) / self.f_px);
        if libm::hypot(at[0], at[1]) > self.most_shown {
            return None;
        }
        let [x, y] = self.fault.of_picture(at, self.k, self.most)?;
        Some([
            self.middle[0] + self.f_px * x,
            self.middle[1] + self.f_px * y,
        ])
    }
}

/// θ (1 + k₁θ² + …)/r.
fn fisheye(r: f64, k: [f64; 4]) -> f64 {
    if r < 1e-9 {
        return 1.0;
    }
    let angle = libm::atan(r);
    let square = angle * angle;
    let of_angle = 1.0 + square * (k[0] + square * (k[1] + square * (k[2] + square * k[3])));
    angle * of_angle / r
}
