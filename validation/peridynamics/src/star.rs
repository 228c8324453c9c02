//! How many radial cracks a damage field has.

use std::f64::consts::TAU;

use crate::lattice::{Lattice, as_f64};

/// Directions that a circle is looked at in.
const N_ANGLES: usize = 360;
/// A place is cracked when the mean damage of the nodes near it is more than this. A straight crack
/// breaks some 0.4 of the bonds of the nodes beside it.
const CRACKED: f64 = 0.25;
/// Nodes nearer than this many spacings count: there always are some, and an arm stays narrow.
const NEAR: f64 = 1.25;

/// Counts the arms of the star around the origin.
///
/// The reach of a direction is the largest radius, up to `outer_m`, at which it meets the crack
/// that is connected with the middle. An arm is a peak of the reach over the directions that stands
/// out by at least `prominence_m` from the deeper of the valleys that part it from higher peaks. So
/// arms of different length count alike, the crushed zone is no arm, however wide it is, and an arm
/// that forks outside `outer_m` counts once.
#[must_use]
pub fn n_arms(lattice: &Lattice, damage: &[f64], outer_m: f64, prominence_m: f64) -> usize {
    n_peaks(&reach(lattice, damage, outer_m), prominence_m)
}

/// The reach of each direction, m; 0 where none.
fn reach(lattice: &Lattice, damage: &[f64], outer_m: f64) -> Vec<f64> {
    let ring_m = 0.5 * lattice.spacing_m;
    // Circles about the origin; the crack may wind outside `outer_m` but is not followed there.
    let cracked: Vec<Vec<bool>> = (0..)
        .map(|ring| (f64::from(ring) + 0.5) * ring_m)
        .take_while(|radius_m| *radius_m < outer_m)
        .map(|radius_m| cracked_on_circle(lattice, damage, radius_m))
        .collect();
    let mut reached = vec![vec![false; N_ANGLES]; cracked.len()];
    let mut open: Vec<(usize, usize)> = Vec::new();
    // The middle: the innermost circle that the crack touches.
    if let Some(ring) = cracked.iter().position(|circle| circle.contains(&true)) {
        open.extend(
            (0..N_ANGLES)
                .map(|at| (ring, at))
                .filter(|&(ring, at)| cracked[ring][at]),
        );
    }
    let mut reach_m = vec![0.0_f64; N_ANGLES];
    while let Some((ring, at)) = open.pop() {
        if std::mem::replace(&mut reached[ring][at], true) {
            continue;
        }
        reach_m[at] = reach_m[at].max(as_f64(ring + 1) * ring_m);
        for near_ring in ring.saturating_sub(1)..(ring + 2).min(cracked.len()) {
            for step in [N_ANGLES - 1, 0, 1] {
                let near = (at + step) % N_ANGLES;
                if cracked[near_ring][near] && !reached[near_ring][near] {
                    open.push((near_ring, near));
                }
            }
        }
    }
    reach_m
}

/// Whether the crack field covers each direction on a circle.
fn cracked_on_circle(lattice: &Lattice, damage: &[f64], radius_m: f64) -> Vec<bool> {
    (0..N_ANGLES)
        .map(|at| {
            let (sin, cos) = libm::sincos(as_f64(at) / as_f64(N_ANGLES) * TAU);
            mean_near(lattice, damage, radius_m * cos, radius_m * sin) > CRACKED
        })
        .collect()
}

/// Mean damage of the nodes near a place.
fn mean_near(lattice: &Lattice, damage: &[f64], x_m: f64, y_m: f64) -> f64 {
    let spacing_m = lattice.spacing_m;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let around = |at_m: f64, n: usize| {
        let middle = (at_m / spacing_m + 0.5 * as_f64(n)).clamp(0.0, as_f64(n - 1)) as usize;
        middle.saturating_sub(2)..(middle + 3).min(n)
    };
    let near_m = NEAR * spacing_m;
    let (mut sum, mut count) = (0.0, 0.0);
    for row in around(y_m, lattice.n_y) {
        for column in around(x_m, lattice.n_x) {
            let i = row * lattice.n_x + column;
            let (dx, dy) = (lattice.x_m[i] - x_m, lattice.y_m[i] - y_m);
            if dx * dx + dy * dy <= near_m * near_m {
                sum += damage[i];
                count += 1.0;
            }
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}

/// Peaks on a closed curve with at least a prominence. Walked as a zigzag from the lowest point: a
/// peak counts once the curve has climbed and then fallen by the prominence.
fn n_peaks(heights: &[f64], prominence: f64) -> usize {
    let n = heights.len();
    let Some(start) = (0..n).min_by(|&i, &j| heights[i].total_cmp(&heights[j])) else {
        return 0;
    };
    let (mut peaks, mut is_climbing) = (0, true);
    let (mut low, mut high) = (heights[start], heights[start]);
    for height in (1..=n).map(|step| heights[(start + step) % n]) {
        if is_climbing {
            high = high.max(height);
            low = low.min(height);
            // A new climb starts at the lowest point since the last peak.
            if high - low < prominence {
                high = height;
            } else if high - height >= prominence {
                peaks += 1;
                is_climbing = false;
                low = height;
            }
        } else {
            low = low.min(height);
            if height - low >= prominence {
                is_climbing = true;
                high = height;
            }
        }
    }
    peaks
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Damage of a drawn star: 0.45 within a spacing of each arm, all broken in the middle. Every
    /// second arm is shorter.
    fn star(lattice: &Lattice, arms: usize, from_m: f64, to_m: f64) -> Vec<f64> {
        (0..lattice.len())
            .map(|i| {
                let (x, y) = (lattice.x_m[i], lattice.y_m[i]);
                let radius = libm::hypot(x, y);
                if radius < from_m {
                    return 1.0;
                }
                let sector = TAU / as_f64(arms);
                let angle = libm::atan2(y, x) - 0.3;
                let off = libm::remainder(angle, sector).abs() * radius;
                let is_odd = libm::remainder(angle, 2.0 * sector).abs() > 0.5 * sector;
                let end_m = if is_odd { 0.6 * to_m } else { to_m };
                if radius < end_m && off < 1.2 * lattice.spacing_m {
                    0.45
                } else {
                    0.02
                }
            })
            .collect()
    }

    #[test]
    fn drawn_stars_are_counted() {
        let lattice = Lattice::new(125, 125, 0.4e-3, 0.35, &mut Random::new(5));
        for arms in 3..=14 {
            let damage = star(&lattice, arms, 2e-3, 12e-3);
            assert_eq!(n_arms(&lattice, &damage, 20e-3, 1e-3), arms, "drawn");
        }
    }

    #[test]
    fn a_hole_and_scattered_damage_are_no_star() {
        let mut random = Random::new(6);
        let lattice = Lattice::new(125, 125, 0.4e-3, 0.35, &mut random);
        let damage: Vec<f64> = star(&lattice, 5, 4e-3, 0.0)
            .into_iter()
            .map(|damage| if random.unit() < 0.02 { 0.4 } else { damage })
            .collect();
        assert_eq!(n_arms(&lattice, &damage, 20e-3, 1e-3), 0, "no arm");
    }

    #[test]
    fn prominence() {
        let check =
            |heights: &[f64], expected| assert_eq!(n_peaks(heights, 2.0), expected, "{heights:?}");
        check(&[0.0, 5.0, 0.0, 5.0, 4.0, 5.0, 0.0], 2);
        check(&[5.0, 0.0, 3.0, 1.5, 3.0], 1);
        check(&[3.0, 1.0, 4.0, 1.0, 5.0, 3.5, 4.5], 2);
        check(&[1.0; 7], 0);
        check(&[], 0);
    }
}
