//! What of a plate's bending is sharp under a load, in closed form.

use std::f64::consts::PI;

use super::PatchLoad;

/// Coefficients of the spread pressure, by powers of s.
const N_POWERS: usize = 4;

/// The bending of an unbounded plate under a pressure on a disc, less that under the same force spread
/// smoothly over a wider disc. It is zero outside of the wider one, so that a plate with any rim
/// beyond that bends under the load as under the spread one and by this in addition; and a coarse
/// mesh is enough for the spread one.
///
/// With K = P/8πD, the radius c of the load and a of the wider disc, s = r²/a²:
///
/// ```text
/// w = K (r² ln(r/a) + ½ c² (ln(r/a) + 1))                         c ≤ r ≤ a
/// w = K (r⁴/8c² + r² (ln(c/a) + ½) + c² (½ ln(c/a) − ⅛))          r ≤ c
/// ```
///
/// is the plate under the load \[Timoshenko1959\]. Outside of any round load it depends on the force
/// and on the mean of r² over it, ½ c², alone, for r² ln r is biharmonic. So the spread pressure
///
/// ```text
/// q = P/πa² (1 − s)² (8 − 20m + (80m − 20) s),   m = c²/2a²
/// ```
///
/// which has the same of both, gives the same w outside of its disc, and within it a polynomial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NearLoad {
    center_m: [f64; 2],
    /// c, m, above 0.
    radius_m: f64,
    /// a, m, c at least.
    spread_m: f64,
    force_n: f64,
    /// K = P/8πD, 1/m.
    strength_per_m: f64,
    /// π a² q/P by powers of s.
    pressure: [f64; N_POWERS],
    /// Of the polynomial of w/K a² under the spread pressure, the first two coefficients.
    first: [f64; 2],
}

impl NearLoad {
    /// Of a load on a disc and a disc around it.
    pub(super) fn new(load: &PatchLoad, spread_m: f64, rigidity_n_m: f64) -> Self {
        let m = 0.5 * (load.radius_m / spread_m) * (load.radius_m / spread_m);
        let (p, q) = (8.0 - 20.0 * m, 80.0 * m - 20.0);
        let mut near = Self {
            center_m: load.center_m,
            radius_m: load.radius_m,
            spread_m,
            force_n: load.force_n,
            strength_per_m: load.force_n / (8.0 * PI * rigidity_n_m),
            pressure: [p, q - 2.0 * p, p - 2.0 * q, q],
            first: [0.0; 2],
        };
        // At r = a both are m K a², and r dw/dr is (1 + m) K a².
        let [h, slope, _] = near.under_spread(1.0);
        let linear = 0.5 * (1.0 + m) - slope;
        near.first = [m - h - linear, linear];
        near
    }

    /// w/K a² under the spread pressure and its first two derivatives by s.
    fn under_spread(&self, s: f64) -> [f64; 3] {
        let [zeroth, linear] = self.first;
        let mut sums = [zeroth + linear * s, linear, 0.0];
        let mut power = 1.0;
        let mut k = 0.0;
        for coefficient in self.pressure {
            // ∇⁴ r²ᵏ⁺⁴ = 16 (k + 1)² (k + 2)² r²ᵏ.
            let part = 0.5 * coefficient / ((k + 1.0) * (k + 2.0)) * power;
            sums[0] += part / ((k + 1.0) * (k + 2.0)) * s * s;
            sums[1] += part / (k + 1.0) * s;
            sums[2] += part;
            power *= s;
            k += 1.0;
        }
        sums
    }

    /// The spread pressure at a point, Pa.
    pub(super) fn spread_pa(&self, point: [f64; 2]) -> f64 {
        let a2 = self.spread_m * self.spread_m;
        let s = self.squared_m2(point).2 / a2;
        if s >= 1.0 {
            return 0.0;
        }
        let by_power = self.pressure.iter().rev();
        self.force_n / (PI * a2) * by_power.fold(0.0, |sum, q| sum * s + q)
    }

    fn squared_m2(&self, [x, y]: [f64; 2]) -> (f64, f64, f64) {
        let (dx, dy) = (x - self.center_m[0], y - self.center_m[1]);
        (dx, dy, dx * dx + dy * dy)
    }

    /// What is to be added to w, m, to its gradient, and to w_xx, w_yy, 2 w_xy, 1/m.
    pub(super) fn at(&self, point: [f64; 2]) -> (f64, [f64; 2], [f64; 3]) {
        let (dx, dy, r2) = self.squared_m2(point);
        let (c2, a2) = (self.radius_m * self.radius_m, self.spread_m * self.spread_m);
        if r2 >= a2 {
            return (0.0, [0.0; 2], [0.0; 3]);
        }
        // w, w'/r and (w'' − w'/r)/r² over K under the load.
        let [w, slope, bend] = if r2 >= c2 {
            let log = 0.5 * libm::log(r2 / a2);
            [
                r2 * log + 0.5 * c2 * (log + 1.0),
                2.0 * log + 1.0 + 0.5 * c2 / r2,
                (2.0 - c2 / r2) / r2,
            ]
        } else {
            let log = 0.5 * libm::log(c2 / a2);
            [
                r2 * (0.125 * r2 / c2 + log + 0.5) + c2 * (0.5 * log - 0.125),
                0.5 * r2 / c2 + 2.0 * log + 1.0,
                1.0 / c2,
            ]
        };
        let [of_spread, by_s, twice_by_s] = self.under_spread(r2 / a2);
        let k = self.strength_per_m;
        let (slope, bend) = (slope - 2.0 * by_s, bend - 4.0 * twice_by_s / a2);
        let curvature = [
            k * (slope + bend * dx * dx),
            k * (slope + bend * dy * dy),
            k * 2.0 * bend * dx * dy,
        ];
        (
            k * (w - a2 * of_spread),
            [k * slope * dx, k * slope * dy],
            curvature,
        )
    }

    /// Mean of what is to be added to w over the disc of the load, m.
    pub(super) fn mean_under_load_m(&self) -> f64 {
        let (c2, a2) = (self.radius_m * self.radius_m, self.spread_m * self.spread_m);
        let under_load = c2 * (0.5 * libm::log(c2 / a2) + 1.0 / 6.0);
        // The mean of sⁿ over the disc is (c²/a²)ⁿ/(n + 1).
        let s = c2 / a2;
        let mut mean = self.first[0] + 0.5 * self.first[1] * s;
        let (mut power, mut k) = (s * s, 0.0);
        for coefficient in self.pressure {
            let both = (k + 1.0) * (k + 2.0);
            mean += 0.5 * coefficient / (both * both) * power / (k + 3.0);
            power *= s;
            k += 1.0;
        }
        self.strength_per_m * (under_load - a2 * mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOAD: PatchLoad = PatchLoad {
        center_m: [0.3, -0.1],
        radius_m: 0.02,
        force_n: 50.0,
    };
    const SPREAD_M: f64 = 0.17;
    const RIGIDITY_N_M: f64 = 7.0;

    fn near(got: f64, want: f64, tolerance: f64) {
        assert!((got - want).abs() < tolerance, "{got} {want}");
    }

    /// At a distance in some direction.
    fn point(r: f64) -> [f64; 2] {
        [0.3 + 0.6 * r, -0.1 + 0.8 * r]
    }

    /// The mean over discs of equal area within a radius.
    fn mean_within(radius: f64, value: impl Fn([f64; 2]) -> f64) -> f64 {
        let n = 20_000;
        let ring = |k: i32| radius * ((f64::from(k) + 0.5) / f64::from(n)).sqrt();
        (0..n).map(|k| value(point(ring(k)))).sum::<f64>() / f64::from(n)
    }

    #[test]
    fn the_spread_pressure_has_the_force_and_the_second_moment_of_the_load() {
        let load = NearLoad::new(&LOAD, SPREAD_M, RIGIDITY_N_M);
        let area = PI * SPREAD_M * SPREAD_M;
        let force = area * mean_within(SPREAD_M, |at| load.spread_pa(at));
        near(force / 50.0, 1.0, 1e-7);
        let moment = |[x, y]: [f64; 2]| (x - 0.3).powi(2) + (y + 0.1).powi(2);
        let mean = area * mean_within(SPREAD_M, |at| load.spread_pa(at) * moment(at)) / 50.0;
        near(mean / (0.5 * 0.02 * 0.02), 1.0, 1e-5);
        near(load.spread_pa(point(0.171)), 0.0, 1e-300);
    }

    #[test]
    fn it_ends_smoothly_at_the_wider_disc() {
        let load = NearLoad::new(&LOAD, SPREAD_M, RIGIDITY_N_M);
        let most = load.at(point(0.0)).2[0].abs();
        let (w, _, curvature) = load.at(point(SPREAD_M * (1.0 - 1e-9)));
        near(w, 0.0, 1e-12);
        for part in curvature {
            near(part / most, 0.0, 1e-7);
        }
        assert_eq!(load.at(point(0.18)), (0.0, [0.0; 2], [0.0; 3]));
    }

    #[test]
    fn curvatures_are_those_of_the_deflection() {
        let load = NearLoad::new(&LOAD, SPREAD_M, RIGIDITY_N_M);
        let h = 1e-4;
        let most = load.at(point(0.0)).2[0].abs();
        // In the load, right at its edge, and outside.
        for r in [0.004, 0.0197, 0.0203, 0.06, 0.15] {
            let [x, y] = point(r);
            let w = |i: f64, j: f64| load.at([x + i * h, y + j * h]).0;
            let twice = [
                w(1.0, 0.0) - 2.0 * w(0.0, 0.0) + w(-1.0, 0.0),
                w(0.0, 1.0) - 2.0 * w(0.0, 0.0) + w(0.0, -1.0),
                0.5 * (w(1.0, 1.0) - w(1.0, -1.0) - w(-1.0, 1.0) + w(-1.0, -1.0)),
            ];
            for (got, want) in load.at([x, y]).2.iter().zip(twice) {
                near(got / most, want / (h * h) / most, 1e-4);
            }
        }
    }

    #[test]
    fn pressures_are_those_that_bend_so() {
        let load = NearLoad::new(&LOAD, SPREAD_M, RIGIDITY_N_M);
        let laplacian = |r: f64| {
            let [xx, yy, _] = load.at(point(r)).2;
            xx + yy
        };
        // ∇² of ∇²w around the center, for r in and outside of the load.
        for r in [0.01_f64, 0.05, 0.1, 0.16] {
            let h = 1e-3;
            let (low, mid, high) = (laplacian(r - h), laplacian(r), laplacian(r + h));
            let fourth = (high - 2.0 * mid + low) / (h * h) + (high - low) / (2.0 * h * r);
            let own = if r < 0.02 { 50.0 / (PI * 4e-4) } else { 0.0 };
            let want = own - load.spread_pa(point(r));
            near(RIGIDITY_N_M * fourth / 4e4, want / 4e4, 1e-3);
        }
    }

    #[test]
    fn the_mean_under_the_load_is_that_of_its_disc() {
        let load = NearLoad::new(&LOAD, SPREAD_M, RIGIDITY_N_M);
        let mean = mean_within(0.02, |at| load.at(at).0);
        near(mean / load.mean_under_load_m(), 1.0, 1e-6);
    }
}
