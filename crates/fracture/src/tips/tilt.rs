//! How the surface of a crack leans.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_seed::{Seed, Stream, normal};

/// The tilt of a crack's surface against the normal of the pane, which wanders along the crack.
///
/// A stationary process without kinks, of the correlation σ² (1 + λs) e^{−λs} with λ = √3/ℓ
/// \[Rasmussen2006\] over a way s; ℓ is one thickness. FIT.
#[derive(Debug, Clone)]
pub(crate) struct Tilt {
    /// Tilt, and its slope over λ, in standard deviations.
    state: [f64; 2],
    deviation_rad: f64,
    rng: ChaCha8Rng,
}

/// Standard deviation of the tilt of radial cracks, rad. FIT: dark and bright patches in
/// photographs.
pub(crate) const TILT_RAD: f64 = 2.9 * PI / 180.0;

impl Tilt {
    /// That of one crack.
    pub(crate) fn new(seed: Seed, crack: u64, deviation_rad: f64) -> Self {
        let mut rng = seed.stream(Stream::CrackTilt, crack);
        Self {
            state: [normal(&mut rng), normal(&mut rng)],
            deviation_rad,
            rng,
        }
    }

    /// Goes on from where another one is.
    pub(crate) fn goes_on_from(&mut self, other: &Self) {
        self.state = other.state;
    }

    /// Begins with a tilt, rad.
    pub(crate) fn starts_at(&mut self, tilt_rad: f64) {
        self.state[0] = tilt_rad / self.deviation_rad;
    }

    /// Goes on from where another one is, the other way: what leaned to the left leans to the
    /// right.
    pub(crate) fn goes_back_from(&mut self, other: &Self) {
        let [tilt, slope] = other.state;
        self.state = [-tilt, slope];
    }

    /// The tilt before and after a way, in thicknesses, rad.
    pub(crate) fn wander(&mut self, way: f64) -> [f64; 2] {
        let s = 3.0_f64.sqrt() * way;
        let fades = libm::exp(-s);
        let [x, v] = self.state;
        let mean = [
            fades * ((1.0 + s) * x + s * v),
            fades * ((1.0 - s) * v - s * x),
        ];
        // Covariance of what is new: that of the whole less that of what is left, both known.
        let square = fades * fades;
        let xx = 1.0 - square * ((1.0 + s) * (1.0 + s) + s * s);
        let xv = square * 2.0 * s * s;
        let vv = 1.0 - square * ((1.0 - s) * (1.0 - s) + s * s);
        let root = xx.max(0.0).sqrt();
        let across = if root > 0.0 { xv / root } else { 0.0 };
        let rest = (vv - across * across).max(0.0).sqrt();
        let [p, q] = [normal(&mut self.rng), normal(&mut self.rng)];
        self.state = [mean[0] + root * p, mean[1] + across * p + rest * q];
        [x, self.state[0]].map(|tilt| self.deviation_rad * tilt)
    }
}
