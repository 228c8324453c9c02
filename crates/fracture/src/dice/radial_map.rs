//! Longer along the radius near a hit, and finer towards it: a map of the plane.

/// Farthest that a hit shows in the shape of its dice, m.
const REACH_M: f64 = 45e-3;
/// Up to here dice are as long as they get, m.
const FULL_M: f64 = 20e-3;
/// Radius of the crushed middle, in which dice are round again, m.
const CRUSHED_M: f64 = 1.5e-3;
/// Length over width near a hit. **Source** photographs: 1.5 to 2.
const ELONGATION: f64 = 1.75;

/// Maps between the pane and a plane in which all dice are alike. A disc around each hit is
/// mapped onto itself: from radius r to u with d ln u/d ln r = 1/elongation, so that u/r, and with
/// it the density of dice, grows towards the hit.
#[derive(Debug, Clone)]
pub(super) struct RadialMap {
    hits: Vec<Hit>,
}

#[derive(Debug, Clone, Copy)]
struct Hit {
    center: [f64; 2],
    /// Size against that of a single hit: two close hits share their room.
    scale: f64,
}

/// ln(u/r) at r, in a disc of radius [`REACH_M`].
fn log_ratio(r: f64) -> f64 {
    // d ln u/d ln r = b + s (r − full) beyond `FULL_M`, 1 at the end.
    let b = 1.0 / ELONGATION;
    let s = (1.0 - b) / (REACH_M - FULL_M);
    let outer = |r: f64| (1.0 - b + s * FULL_M) * libm::log(REACH_M / r) - s * (REACH_M - r);
    if r >= REACH_M {
        0.0
    } else if r >= FULL_M {
        outer(r)
    } else {
        outer(FULL_M) + (1.0 - b) * libm::log(FULL_M / r.max(CRUSHED_M))
    }
}

/// d ln u/d ln r.
fn slope(r: f64) -> f64 {
    let b = 1.0 / ELONGATION;
    if !(CRUSHED_M..REACH_M).contains(&r) {
        1.0
    } else if r < FULL_M {
        b
    } else {
        b + (1.0 - b) * (r - FULL_M) / (REACH_M - FULL_M)
    }
}

/// Part of a radius within which a map of it must be computed to know whether it is too large.
const CLOSE: f64 = 1e-14;

/// The radius whose map is `u`, to the last bit that halving the interval from 0 to `u` gives: Newton's steps
/// tell most of the halves.
fn radius_of(u: f64) -> f64 {
    let is_too_small = |r: f64| r * libm::exp(log_ratio(r)) < u;
    let near = newton(u);
    let sure = [near * (1.0 - CLOSE), near * (1.0 + CLOSE)];
    let is_found = is_too_small(sure[0]) && !is_too_small(sure[1]);
    let (mut low, mut high) = (0.0, u);
    for _ in 0..56 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        let goes_up = match is_found {
            true if middle < sure[0] => true,
            true if middle > sure[1] => false,
            _ => is_too_small(middle),
        };
        if goes_up {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// The same to some last bits, as a rule, by Newton's steps on ln r: ln u grows with it by 1/elongation to 1.
fn newton(u: f64) -> f64 {
    let ln_u = libm::log(u);
    let mut r = u;
    for _ in 0..12 {
        let step = (libm::log(r) + log_ratio(r) - ln_u) / slope(r);
        r *= libm::exp(-step);
        // The error after a step is about the square of the step.
        if step.abs() < 1e-8 {
            break;
        }
    }
    r
}

impl RadialMap {
    pub(super) fn new(impacts_m: &[[f64; 2]]) -> Self {
        let distance = |a: [f64; 2], b: [f64; 2]| libm::hypot(a[0] - b[0], a[1] - b[1]);
        let mut centers: Vec<[f64; 2]> = Vec::new();
        for &impact in impacts_m {
            if centers
                .iter()
                .all(|&c| distance(c, impact) > 2.0 * CRUSHED_M)
            {
                centers.push(impact);
            }
        }
        let hits = centers
            .iter()
            .enumerate()
            .map(|(k, &center)| {
                let others = centers.iter().enumerate().filter(|(other, _)| *other != k);
                let nearest = others
                    .map(|(_, &other)| distance(center, other))
                    .fold(f64::INFINITY, f64::min);
                Hit {
                    center,
                    scale: (0.5 * nearest / REACH_M).min(1.0),
                }
            })
            .collect();
        Self { hits }
    }

    /// u/r, the slope, and the hit that it is due to.
    fn at(&self, point: [f64; 2]) -> Option<(&Hit, f64)> {
        self.hits.iter().find_map(|hit| {
            let r = libm::hypot(point[0] - hit.center[0], point[1] - hit.center[1]) / hit.scale;
            (r < REACH_M).then_some((hit, r))
        })
    }

    /// From the pane.
    pub(super) fn to_even(&self, point: [f64; 2]) -> [f64; 2] {
        let Some((hit, r)) = self.at(point) else {
            return point;
        };
        let factor = libm::exp(log_ratio(r));
        [0, 1].map(|k| hit.center[k] + factor * (point[k] - hit.center[k]))
    }

    /// To the pane.
    pub(super) fn to_pane(&self, even: [f64; 2]) -> [f64; 2] {
        // A disc is mapped onto itself, so the hit is the same.
        let Some((hit, u)) = self.at(even) else {
            return even;
        };
        if u <= 0.0 {
            return even;
        }
        let r = radius_of(u);
        [0, 1].map(|k| hit.center[k] + r / u * (even[k] - hit.center[k]))
    }

    /// How many times smaller than far away a die is across the radius: r/u.
    pub(super) fn shrink(&self, point: [f64; 2]) -> f64 {
        self.at(point)
            .map_or(1.0, |(_, r)| libm::exp(-log_ratio(r)))
    }

    /// Area in the even plane of the part of the pane that `is_inside` says is one, less its area
    /// on the pane, m².
    pub(super) fn excess_area_m2(&self, is_inside: impl Fn([f64; 2]) -> bool) -> f64 {
        const RINGS: u32 = 96;
        const SECTORS: u32 = 128;
        let mut sum = 0.0;
        for hit in &self.hits {
            let step = REACH_M / f64::from(RINGS);
            for ring in 0..RINGS {
                let r = (f64::from(ring) + 0.5) * step;
                let ratio = libm::exp(log_ratio(r));
                let density = ratio * ratio * slope(r) - 1.0;
                let n_inside = (0..SECTORS)
                    .filter(|&sector| {
                        let angle = std::f64::consts::TAU * f64::from(sector) / f64::from(SECTORS);
                        let (sin, cos) = libm::sincos(angle);
                        let [x, y] = hit.center;
                        is_inside([x + hit.scale * r * cos, y + hit.scale * r * sin])
                    })
                    .count();
                #[expect(clippy::cast_precision_loss, reason = "at most 128")]
                let share = n_inside as f64 / f64::from(SECTORS);
                sum += std::f64::consts::TAU * r * step * share * density * hit.scale * hit.scale;
            }
        }
        sum
    }

    /// How far outside the pane the even plane may reach, m.
    pub(super) fn reach_m(&self) -> f64 {
        if self.hits.is_empty() { 0.0 } else { REACH_M }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_again() {
        let map = RadialMap::new(&[[0.1, 0.1], [0.13, 0.1], [0.1, 0.1]]);
        assert_eq!(map.hits.len(), 2, "a hit on a hit changes nothing");
        for k in 0..2000 {
            let k = f64::from(k);
            let point = [0.1 + 0.07 * libm::sin(k), 0.1 + 0.07 * libm::sin(1.7 * k)];
            let back = map.to_pane(map.to_even(point));
            let off = libm::hypot(back[0] - point[0], back[1] - point[1]);
            assert!(off < 1e-15, "{point:?} {off}");
        }
    }

    #[test]
    fn a_radius_is_that_of_halving_to_the_bit() {
        let mut n_steps = 0;
        for k in 1..20_000 {
            let u = REACH_M * f64::from(k) / 20_000.0;
            let (mut low, mut high) = (0.0, u);
            for _ in 0..56 {
                let middle = 0.5 * (low + high);
                if middle * libm::exp(log_ratio(middle)) < u {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            assert_eq!(radius_of(u).to_bits(), high.to_bits(), "{u}");
            n_steps += u32::from((newton(u) / high - 1.0).abs() < CLOSE);
        }
        assert!(n_steps > 19_900, "Newton's steps found {n_steps} of 19999");
    }

    #[test]
    fn slopes_are_those_of_the_map_and_the_disc_keeps_its_area() {
        for k in 0..500 {
            let r = 1e-4 * (f64::from(k) + 0.5);
            let ln_u = |r: f64| libm::log(r) + log_ratio(r);
            let step = 1e-6;
            let measured = (ln_u(r * (1.0 + step)) - ln_u(r * (1.0 - step))) / (2.0 * step);
            assert!((measured - slope(r)).abs() < 1e-4, "{r}: {measured}");
        }
        let excess = RadialMap::new(&[[0.0; 2]]).excess_area_m2(|_| true);
        assert!(
            excess.abs() < 0.01 * 45e-3 * 45e-3 * std::f64::consts::PI,
            "{excess}"
        );
    }
}
