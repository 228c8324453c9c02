//! A stone against a plate: force over time.

use starbreak_glass::Material;

use super::indentation::Indentation;
use crate::params::StoneImpact;

/// Change of force (of its peak so far) and of speed (of that at touch) in one step.
const STEP_CHANGE: f64 = 0.003;
/// A bound that no contact reaches: the changes of force and speed add up to less than 5.
const MAX_STEPS: u32 = 20_000;
/// Where a contact that never opens is taken to end: force below this fraction of its peak,
const END_FORCE: f64 = 0.01;
/// and the stone slower than this fraction of its first speed.
const END_SPEED: f64 = 0.1;
/// Most points of the history.
const MAX_HISTORY: usize = 201;

/// What a hit does at the place of contact. Energies add up to ½mV² of the normal speed.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLoad {
    /// Largest force, N.
    pub peak_force_n: f64,
    /// Radius of the contact at that force, m.
    pub contact_radius_m: f64,
    /// Radius within which stone or glass crush at that force, m; 0 if nothing does.
    pub crushed_radius_m: f64,
    /// From touch to parting, s (or until the force has faded, see [`contact_load`]).
    pub contact_time_s: f64,
    /// ∫F dt, N·s.
    pub impulse_n_s: f64,
    /// Largest approach of stone and glass, m.
    pub indentation_m: f64,
    /// Pairs (t in s, F in N) in order of time, at most 201, peak and both ends included.
    pub history: Vec<[f64; 2]>,
    /// Kinetic energy that the stone has at the end, J.
    pub rebound_energy_j: f64,
    /// Energy that went into the plate as bending waves, ∫F²/Z dt, J.
    pub plate_energy_j: f64,
    /// Energy that crushing took, J.
    pub crushing_energy_j: f64,
    /// Elastic energy left in the contact at the end, J: 0 if stone and glass part.
    pub stored_energy_j: f64,
}

impl ContactLoad {
    /// Force at a time after the touch, N; 0 outside of the contact.
    #[must_use]
    pub fn force_at_n(&self, time_s: f64) -> f64 {
        let after = self.history.partition_point(|[time, _]| *time <= time_s);
        match (after.checked_sub(1), self.history.get(after)) {
            (Some(before), Some(&[t1, f1])) => {
                let [t0, f0] = self.history[before];
                f0 + (f1 - f0) * (time_s - t0) / (t1 - t0)
            }
            _ => 0.0,
        }
    }
}

/// Bending stiffness D = E h³/12(1 − ν²), N·m.
fn bending_stiffness_n_m(material: &Material, thickness_m: f64) -> f64 {
    let poisson_ratio = material.poisson_ratio.value;
    material.young_modulus_pa.value * (thickness_m * thickness_m * thickness_m)
        / (12.0 * (1.0 - poisson_ratio * poisson_ratio))
}

/// Force over time of a stone that hits a plate, by Hertz's law \[Hertz1882\] on a plate that gives
/// way.
///
/// m ẍ = −F, δ̇ = ẋ − F/Z with the impedance Z = 8 √(D ρ h) of an infinite plate \[Zener1941\]. The
/// force is F = (4/3) E* √R δ^1.5 until the highest pressure reaches the limit at which stone or
/// glass crush; from there on it grows by π R p δ, and unloading is elastic \[Thornton1997\].
/// Integrated with the two-stage Radau IIA method (order 3, L-stable): with the plate soft
/// and the stone heavy the force rises in nanoseconds and lasts for seconds, which no explicit
/// method affords. Steps are such that force and speed change by less than 0.6 %.
///
/// A heavy stone on a thin plate never bounces, and its force fades without an end. The contact is
/// then taken to end where the force is below 1 % of its peak and the stone slower than 10 % of
/// its first speed.
///
/// # Limits
/// Only the speed normal to the pane counts. The plate is infinite while the contact lasts: waves
/// that come back from the rim are left out, which for a stone of several cm on a thin plate they
/// would not be. Of a laminate it is the outer ply alone. A stone does not break up; the contact
/// never gets wider than the stone.
#[must_use]
pub fn contact_load(stone: &StoneImpact, material: &Material, thickness_m: f64) -> ContactLoad {
    let stiffness = bending_stiffness_n_m(material, thickness_m);
    let impedance = 8.0 * (stiffness * material.density_kg_m3.value * thickness_m).sqrt();
    integrate(stone, material, impedance)
}

/// Position of the stone against the plate in time.
#[derive(Debug, Clone, Copy)]
struct State {
    time_s: f64,
    depth_m: f64,
    speed_m_s: f64,
    plate_energy_j: f64,
}

/// The equations of motion.
struct Motion {
    law: Indentation,
    mass_kg: f64,
    impedance_kg_s: f64,
}

impl Motion {
    fn approach_m_s(&self, state: &State) -> f64 {
        state.speed_m_s - self.law.force(state.depth_m).0 / self.impedance_kg_s
    }

    /// One step of the two-stage Radau IIA method \[Hairer1996\]; the speeds of the stages are linear
    /// in their forces, so that only two depths remain to be found, by Newton's method.
    fn step(&self, from: &State, dt: f64) -> State {
        let a = [[5.0 / 12.0, -1.0 / 12.0], [0.75, 0.25]];
        let c = [1.0 / 3.0, 1.0];
        // a · a, for the speeds inside the depths.
        let aa = [0, 1].map(|i| [0, 1].map(|j| a[i][0] * a[0][j] + a[i][1] * a[1][j]));
        let (m, z) = (self.mass_kg, self.impedance_kg_s);
        let weight = |i: usize, j: usize| dt * dt * aa[i][j] / m + dt * a[i][j] / z;
        let drift = c.map(|c| from.depth_m + c * dt * from.speed_m_s);
        let slow = self.approach_m_s(from);
        let mut depth = c.map(|c| from.depth_m + c * dt * slow);
        for _ in 0..50 {
            let forces = depth.map(|d| self.law.force(d));
            let mut residual = [0.0; 2];
            let mut jacobian = [[0.0; 2]; 2];
            for i in 0..2 {
                residual[i] = drift[i] - depth[i];
                for j in 0..2 {
                    residual[i] -= weight(i, j) * forces[j].0;
                    jacobian[i][j] = f64::from(u8::from(i == j)) + weight(i, j) * forces[j].1;
                }
            }
            let [[p, q], [r, s]] = jacobian;
            let determinant = p * s - q * r;
            let change = [
                (s * residual[0] - q * residual[1]) / determinant,
                (p * residual[1] - r * residual[0]) / determinant,
            ];
            depth[0] += change[0];
            depth[1] += change[1];
            let scale = depth[0].abs().max(depth[1].abs());
            if change[0].abs().max(change[1].abs()) <= 1e-14 * scale {
                break;
            }
        }
        let forces = depth.map(|d| self.law.force(d).0);
        // The second stage is the end.
        State {
            time_s: from.time_s + dt,
            depth_m: depth[1],
            speed_m_s: from.speed_m_s - dt / m * (a[1][0] * forces[0] + a[1][1] * forces[1]),
            plate_energy_j: from.plate_energy_j
                + dt / z * (a[1][0] * forces[0] * forces[0] + a[1][1] * forces[1] * forces[1]),
        }
    }

    /// The state on the way from `from` over at most `dt` where `is_past` first holds.
    fn step_until(&self, from: &State, dt: f64, is_past: impl Fn(&State) -> bool) -> State {
        let (mut low, mut high) = (0.0, dt);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_past(&self.step(from, middle)) {
                high = middle;
            } else {
                low = middle;
            }
        }
        self.step(from, high)
    }
}

fn integrate(stone: &StoneImpact, material: &Material, impedance_kg_s: f64) -> ContactLoad {
    let mass_kg = stone.mass_kg();
    let touch_m_s = stone.normal_speed_m_s();
    let mut motion = Motion {
        law: Indentation::new(stone, material),
        mass_kg,
        impedance_kg_s,
    };
    let mut state = State {
        time_s: 0.0,
        depth_m: 0.0,
        speed_m_s: touch_m_s,
        plate_energy_j: 0.0,
    };
    // Force scale before there is a peak: that of Hertz on a rigid plate or of the wave, whichever
    // is less.
    let stiffness = motion.law.stiffness();
    let hertz_m = libm::pow(1.25 * mass_kg * touch_m_s * touch_m_s / stiffness, 0.4);
    let guess_n = motion.law.force(hertz_m).0.min(impedance_kg_s * touch_m_s);
    let mut dt = 1e-3 * libm::pow(guess_n / stiffness, 2.0 / 3.0) / touch_m_s;
    let mut points = vec![[0.0, 0.0]];
    let (mut peak, mut peak_idx) = (None, 0);
    let mut crushing_energy_j = 0.0;
    for _ in 0..MAX_STEPS {
        let mut next = motion.step(&state, dt);
        let force = |state: &State| motion.law.force(state.depth_m).0;
        let change = (force(&next) - force(&state)).abs() / guess_n.max(force(&state))
            + (next.speed_m_s - state.speed_m_s).abs() / touch_m_s;
        if change > 2.0 * STEP_CHANGE {
            dt *= 0.5;
            continue;
        }
        let is_turning = peak.is_none() && motion.approach_m_s(&next) <= 0.0;
        if is_turning {
            next = motion.step_until(&state, dt, |s| motion.approach_m_s(s) <= 0.0);
        }
        let is_opening = !is_turning && motion.law.is_open(next.depth_m);
        if is_opening {
            next = motion.step_until(&state, dt, |s| motion.law.is_open(s.depth_m));
        }
        state = next;
        let force_n = motion.law.force(state.depth_m).0;
        points.push([state.time_s, force_n]);
        if is_turning {
            peak = Some((state.depth_m, force_n));
            peak_idx = points.len() - 1;
            if motion.law.is_crushed_at(state.depth_m) {
                crushing_energy_j = motion.law.unload_from(state.depth_m);
            }
        }
        let has_faded = peak.is_some_and(|(_, peak_n)| force_n < END_FORCE * peak_n)
            && state.speed_m_s.abs() < END_SPEED * touch_m_s;
        if is_opening || has_faded {
            break;
        }
        dt *= (STEP_CHANGE / change.max(1e-300)).clamp(0.5, 1.25);
    }
    let (deepest_m, peak_force_n) =
        peak.unwrap_or((state.depth_m, motion.law.force(state.depth_m).0));
    ContactLoad {
        peak_force_n,
        contact_radius_m: motion.law.radius_m(deepest_m),
        crushed_radius_m: motion.law.crushed_radius_m(deepest_m),
        contact_time_s: state.time_s,
        impulse_n_s: mass_kg * (touch_m_s - state.speed_m_s),
        indentation_m: deepest_m,
        history: thinned(&points, peak_idx),
        rebound_energy_j: 0.5 * mass_kg * state.speed_m_s * state.speed_m_s,
        plate_energy_j: state.plate_energy_j,
        crushing_energy_j,
        stored_energy_j: motion.law.stored_j(state.depth_m),
    }
}

/// At most [`MAX_HISTORY`] of the points, evenly by number, with the peak and both ends.
fn thinned(points: &[[f64; 2]], peak_idx: usize) -> Vec<[f64; 2]> {
    let last = points.len() - 1;
    let stride = last.div_ceil(MAX_HISTORY - 3).max(1);
    let mut kept: Vec<usize> = (0..last).step_by(stride).collect();
    kept.extend([peak_idx, last]);
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|idx| points[idx]).collect()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    fn glass() -> Material {
        Material::soda_lime().unwrap()
    }

    /// Kinetic energy at touch, J, and what is missing of it at the end.
    fn balance(stone: &StoneImpact, load: &ContactLoad) -> (f64, f64) {
        let before = 0.5 * stone.mass_kg() * stone.normal_speed_m_s().powi(2);
        let after = load.rebound_energy_j
            + load.plate_energy_j
            + load.crushing_energy_j
            + load.stored_energy_j;
        (before, after - before)
    }

    #[test]
    fn on_a_rigid_plate_it_is_hertz() {
        // δ = (5mV²/4K)^0.4, F = K δ^1.5, t = 2.94 δ/V [Hertz1882]; slow enough to crush nothing.
        for (speed, radius) in [(0.01, 0.2), (0.1, 5e-3), (1.0, 5e-5), (2.0, 5e-3)] {
            let stone = StoneImpact::granite([0.0; 2], speed, radius);
            let load = integrate(&stone, &glass(), 1e15);
            let stiffness = 4.0 / 3.0 * radius.sqrt()
                / ((1.0 - 0.0625) / 50e9
                    + (1.0 - 0.22_f64.powi(2)) / glass().young_modulus_pa.value);
            let depth = libm::pow(1.25 * stone.mass_kg() * speed * speed / stiffness, 0.4);
            let force = stiffness * libm::pow(depth, 1.5);
            for (name, value, expected) in [
                ("depth", load.indentation_m, depth),
                ("force", load.peak_force_n, force),
                ("time", load.contact_time_s, 2.943_28 * depth / speed),
                ("radius", load.contact_radius_m, (radius * depth).sqrt()),
                ("impulse", load.impulse_n_s, 2.0 * stone.mass_kg() * speed),
            ] {
                let error = value / expected - 1.0;
                assert!(
                    error.abs() < 1e-4,
                    "{name} at {speed} m/s, {radius} m: {error}"
                );
            }
            assert!(load.crushed_radius_m == 0.0, "nothing crushes");
            let (before, missing) = balance(&stone, &load);
            assert!(missing.abs() < 1e-6 * before, "energy {}", missing / before);
        }
    }

    #[test]
    fn an_overdamped_hit_follows_the_plate_alone() {
        // F = Z V exp(−Zt/m) where the stone is heavy and the plate thin: its impulse is m(V − v),
        // its energy goes into the plate.
        let stone = StoneImpact::granite([0.0; 2], 1.0, 0.1);
        let load = contact_load(&stone, &glass(), 1e-3);
        let impedance = 8.0
            * (bending_stiffness_n_m(&glass(), 1e-3) * glass().density_kg_m3.value * 1e-3).sqrt();
        assert!(
            (load.peak_force_n / impedance - 1.0).abs() < 5e-3,
            "{}",
            load.peak_force_n / impedance
        );
        let decay = -libm::log(0.01) * stone.mass_kg() / impedance;
        assert!(
            (load.contact_time_s / decay - 1.0).abs() < 0.05,
            "{}",
            load.contact_time_s / decay
        );
        let (before, missing) = balance(&stone, &load);
        assert!(missing.abs() < 1e-6 * before, "energy {}", missing / before);
        assert!(
            load.plate_energy_j > 0.99 * before,
            "all of it bends the plate"
        );
    }

    #[test]
    fn the_loss_on_a_plate_is_zeners() {
        // Zener's coefficient of restitution depends on λ = K^0.4 V^0.2 m^0.6/Z alone. To first
        // order the loss is ∫F²/Z dt over Hertz's contact, 0.8 B(1.6, ½) 1.25^1.6 λ mV².
        let stone = StoneImpact::granite([0.0; 2], 0.5, 1e-3);
        let stiffness = Indentation::new(&stone, &glass()).stiffness();
        for inelasticity in [0.003, 0.01, 0.03] {
            let impedance =
                libm::pow(stiffness, 0.4) * libm::pow(0.5, 0.2) * libm::pow(stone.mass_kg(), 0.6)
                    / inelasticity;
            let load = integrate(&stone, &glass(), impedance);
            let (before, _) = balance(&stone, &load);
            let restitution = (load.rebound_energy_j / before).sqrt();
            let error = 1.0 - restitution - 1.7300 * inelasticity;
            assert!(
                error.abs() < 3.0 * inelasticity * inelasticity,
                "λ = {inelasticity}: {restitution}"
            );
        }
    }

    #[test]
    fn extremes_are_finite_and_keep_their_energy() {
        let mut n_longest = 0;
        for speed in [0.01, 0.3, 10.0, 100.0, 1000.0] {
            for radius in [5e-5, 1e-3, 5e-3, 0.03, 0.2] {
                for sharpness in [1.0, 0.1, 0.01] {
                    for thickness in [1e-4, 2.1e-3, 30e-3] {
                        for angle in [0.0_f64, 85.0] {
                            let mut stone = StoneImpact::granite([0.0; 2], speed, radius);
                            stone.tip_radius_m = (radius * sharpness).max(1e-5);
                            stone.obliquity_rad = angle.to_radians();
                            let load = contact_load(&stone, &glass(), thickness);
                            let (before, missing) = balance(&stone, &load);
                            assert!(
                                missing.abs() < 1e-6 * before,
                                "energy {}: {stone:?}",
                                missing / before
                            );
                            assert!(load.history.len() <= MAX_HISTORY, "bounded");
                            n_longest = n_longest.max(load.history.len());
                            let highest = load.history.iter().map(|p| p[1]).fold(0.0, f64::max);
                            assert!(
                                (highest / load.peak_force_n - 1.0).abs() < 1e-12,
                                "the peak is kept"
                            );
                            assert!(
                                load.history.windows(2).all(|w| w[0][0] < w[1][0]),
                                "in order"
                            );
                            assert!(load.contact_radius_m <= radius, "no wider than the stone");
                            assert!(
                                load.crushed_radius_m <= load.contact_radius_m,
                                "crushed inside"
                            );
                            let rest = load.history[load.history.len() - 1][1];
                            assert!(
                                rest <= END_FORCE * load.peak_force_n,
                                "it ended: {stone:?} {rest}"
                            );
                        }
                    }
                }
            }
        }
        assert!(n_longest > 100, "histories are resolved");
    }

    #[test]
    fn more_is_more() {
        let force = |speed, radius, thickness| {
            contact_load(
                &StoneImpact::granite([0.0; 2], speed, radius),
                &glass(),
                thickness,
            )
            .peak_force_n
        };
        for k in 0..60 {
            let grow = |from: f64, k: i32| from * libm::pow(1.1, k.into());
            assert!(
                force(grow(0.1, k + 1), 4e-3, 2.1e-3) > force(grow(0.1, k), 4e-3, 2.1e-3),
                "speed"
            );
            assert!(
                force(20.0, grow(1e-4, k + 1), 2.1e-3) > force(20.0, grow(1e-4, k), 2.1e-3),
                "radius"
            );
            assert!(
                force(20.0, 4e-3, grow(1e-4, k + 1)) >= force(20.0, 4e-3, grow(1e-4, k)),
                "thickness"
            );
        }
    }

    #[test]
    fn a_crushed_contact_keeps_its_pressure() {
        let stone = StoneImpact::granite([0.0; 2], 60.0, 5e-3);
        let load = contact_load(&stone, &glass(), 6e-3);
        assert!(
            load.crushed_radius_m > 0.0 && load.crushing_energy_j > 0.0,
            "it crushes"
        );
        let mean = load.peak_force_n / (std::f64::consts::PI * load.contact_radius_m.powi(2));
        assert!(
            (2e9..3e9).contains(&mean),
            "between 2/3 of the limit and the limit: {mean}"
        );
    }
}
