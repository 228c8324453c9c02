//! Ring cracks: the sectors between radial cracks bend like cantilevers and break across.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_glass::SegmentKind;
use starbreak_seed::{Seed, uniform};

use crate::draw::weibull_factor;
use crate::stress::StressField;
use crate::tips::{Ledger, Piece, Tilt, TipLaw, Web, crack_direction, unit};

/// A sector between two neighboring radial cracks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sector {
    pub(super) center_m: [f64; 2],
    /// Directions of its two sides; the second follows the first.
    pub(super) angles_rad: [f64; 2],
    /// Cracks at its sides.
    pub(super) cracks: [u32; 2],
    /// Radii between which it may break, m.
    pub(super) radii_m: [f64; 2],
}

impl Sector {
    /// By how much it turns from its first side to its second, rad.
    fn span_rad(&self) -> f64 {
        (self.angles_rad[1] - self.angles_rad[0]).rem_euclid(2.0 * PI)
    }

    /// Radii at which it may break beside its rings so far, m.
    fn free_radii_m<'a>(
        &self,
        taken_m: &'a [f64],
        thickness_m: f64,
    ) -> impl Iterator<Item = f64> + use<'a> {
        let [low, high] = self.radii_m;
        let n = if high > low && self.span_rad() < PI {
            SAMPLES + 1
        } else {
            0
        };
        (0..n)
            .map(move |k| low + (high - low) * f64::from(k) / f64::from(SAMPLES))
            .filter(move |radius| {
                taken_m.iter().all(|taken| {
                    (taken - radius).abs() >= (LEAST_SPACING * radius).max(thickness_m)
                })
            })
    }

    /// Whether a ring has room in it beside those that there are.
    pub(super) fn has_room(&self, taken_m: &[f64], thickness_m: f64) -> bool {
        self.free_radii_m(taken_m, thickness_m).next().is_some()
    }
}

/// Samples along the axis of a sector.
const SAMPLES: u32 = 64;

/// A ring goes on down to this part of the strength that started it: a running crack needs less
/// than a flaw.
const RUNNING_PART: f64 = 0.5;

/// Least distance of two rings over their radius, and a thickness at least; nearer ones relieve each
/// other.
const LEAST_SPACING: f64 = 0.22;

/// Standard deviation of the tilt of rings, rad. UNKNOWN.
pub(super) const TILT_RAD: f64 = 0.12;

/// Most steps of one half of a ring.
const MAX_STEPS: u32 = 4000;

/// What rings are traced with.
pub(super) struct Rings<'a> {
    pub(super) web: &'a mut Web,
    /// Stress of the face that was hit.
    pub(super) front: &'a dyn StressField,
    pub(super) law: TipLaw,
    pub(super) strength_pa: f64,
    pub(super) weibull_modulus: f64,
    pub(super) ledger: &'a mut Ledger,
    pub(super) from_s: f64,
    pub(super) seed: Seed,
}

impl Rings<'_> {
    /// Breaks the sector where the radial tension of its face is highest, if it exceeds the
    /// strength. `taken_m` are the radii of its rings so far; the new one is added.
    pub(super) fn break_sector(
        &mut self,
        sector: &Sector,
        taken_m: &mut Vec<f64>,
        rng: &mut ChaCha8Rng,
    ) -> bool {
        // The weakest flaw is not on the axis of the sector.
        let axis = sector.angles_rad[0] + sector.span_rad() * (0.3 + 0.4 * uniform(rng));
        let strength_pa = self.strength_pa * weibull_factor(self.weibull_modulus, rng);
        let direction = unit(axis);
        let mut hint = 0;
        let mut best: Option<(f64, f64)> = None;
        for radius in sector.free_radii_m(taken_m, self.law.thickness_m) {
            let point = at(sector.center_m, direction, radius);
            let Some(stress) = self.front.stress_at(point, &mut hint) else {
                continue;
            };
            let tension = stress.normal_pa(direction);
            if best.is_none_or(|(most, _)| tension > most) {
                best = Some((tension, radius));
            }
        }
        let Some((tension, radius)) = best else {
            return false;
        };
        if tension < strength_pa {
            return false;
        }
        let start_m = at(sector.center_m, direction, radius);
        let start_s = sector
            .cracks
            .iter()
            .map(|&crack| self.passed_s(crack, sector.center_m, radius))
            .fold(self.from_s, f64::max);
        let start = self.web.add_node(start_m);
        let crack = self.web.new_crack(None);
        let first_piece = self.web.pieces.len();
        let mut early_s: f64 = 0.0;
        let first = Tilt::new(self.seed, u64::from(crack), TILT_RAD);
        for sign in [1.0, -1.0] {
            let mut tilt = first.clone();
            if sign < 0.0 {
                tilt = Tilt::new(self.seed, (1 << 32) | u64::from(crack), TILT_RAD);
                tilt.goes_back_from(&first);
            }
            let heading = [-direction[1] * sign, direction[0] * sign];
            early_s = early_s.max(self.run(
                sector,
                start,
                heading,
                crack,
                start_s,
                strength_pa,
                &mut tilt,
            ));
        }
        // What it ended at may have passed there later than at the radius where the ring started:
        // the ring waits for it.
        let own = |piece: &&mut Piece| piece.crack == crack;
        for piece in self.web.pieces[first_piece..].iter_mut().filter(own) {
            piece.time_s = piece.time_s.map(|time_s| time_s + early_s);
        }
        taken_m.push(radius);
        true
    }

    /// When a crack passed a distance from the hit, s.
    fn passed_s(&self, crack: u32, center_m: [f64; 2], radius_m: f64) -> f64 {
        let far = |node: u32| {
            let [x, y] = self.web.nodes[node as usize];
            libm::hypot(x - center_m[0], y - center_m[1])
        };
        self.web
            .pieces
            .iter()
            .filter(|piece| piece.crack == crack && far(piece.a) <= radius_m)
            .map(|piece| piece.time_s[1])
            .fold(0.0, f64::max)
    }

    /// One half of a ring. Returns by how much it leaves for what it ends at before that is there,
    /// s.
    #[expect(
        clippy::too_many_arguments,
        reason = "one half of a ring is all of these"
    )]
    fn run(
        &mut self,
        sector: &Sector,
        start: u32,
        heading: [f64; 2],
        crack: u32,
        start_s: f64,
        strength_pa: f64,
        tilt: &mut Tilt,
    ) -> f64 {
        let mut early_s: f64 = 0.0;
        let law = self.law;
        let [x, y] = self.web.nodes[start as usize];
        let radius = libm::hypot(x - sector.center_m[0], y - sector.center_m[1]);
        let span = sector.span_rad();
        let step = (0.5 * law.thickness_m).min(0.05 * radius).max(5e-5);
        let (mut node, mut at_m, mut running) = (start, [x, y], heading);
        let (mut along, mut time, mut hint) = (0.0, start_s, 0);
        for _ in 0..MAX_STEPS {
            let Some(stress) = self.front.stress_at(at_m, &mut hint) else {
                break;
            };
            let (major, ..) = stress.principal();
            // Beyond its sector the plate is whole, and does not bend like a cantilever.
            let bearing = libm::atan2(at_m[1] - sector.center_m[1], at_m[0] - sector.center_m[0]);
            let inside = (bearing - sector.angles_rad[0]).rem_euclid(2.0 * PI);
            let has_left = inside > span + 0.05 && inside < 2.0 * PI - 0.05;
            if major < RUNNING_PART * strength_pa || along > PI * radius || has_left {
                break;
            }
            let target = crack_direction(&stress, running);
            let memory = libm::exp(-step / law.thickness_m);
            let mixed = [
                memory * running[0] + (1.0 - memory) * target[0],
                memory * running[1] + (1.0 - memory) * target[1],
            ];
            let size = libm::hypot(mixed[0], mixed[1]).max(1e-12);
            running = [mixed[0] / size, mixed[1] / size];
            let mut to = at(at_m, running, step);
            let mut is_over = false;
            if let Some(part) = self.web.outline.exit(at_m, to) {
                to = at(at_m, running, step * part);
                is_over = true;
            }
            let reach = at(at_m, running, 1.3 * step);
            let hit = self
                .web
                .first_hit(at_m, reach, node, |piece| piece.crack != crack);
            let end = match hit {
                Some(hit) => {
                    is_over = true;
                    let node = self.web.node_on(hit.piece, hit.point_m, 0.1 * step);
                    let met = &self.web.pieces[hit.piece as usize];
                    early_s = (met.time_s[usize::from(met.b == node)] - time).max(0.0);
                    node
                }
                None => self.web.add_node(to),
            };
            to = self.web.nodes[end as usize];
            let length = libm::hypot(to[0] - at_m[0], to[1] - at_m[1]);
            if length <= 1e-3 * step
                || !self
                    .ledger
                    .pay(law.fracture_energy_j_m2 * law.thickness_m * length)
            {
                break;
            }
            let effective_m = (along + step).min(law.thickness_m);
            let intensity = law.intensity(major, effective_m);
            let speed = law.speed_m_s(intensity).max(0.05 * law.rayleigh_m_s);
            let tilt_rad = tilt.wander(length / law.thickness_m);
            self.web.add_piece(Piece {
                a: node,
                b: end,
                crack,
                kind: SegmentKind::Ring,
                time_s: [time, time + length / speed],
                along_m: [along, along + length],
                stress_pa: major,
                intensity_pa_sqrt_m: intensity,
                effective_m,
                tilt_rad,
            });
            along += length;
            time += length / speed;
            node = end;
            at_m = to;
            if is_over {
                break;
            }
        }
        early_s
    }
}

fn at([x, y]: [f64; 2], direction: [f64; 2], distance: f64) -> [f64; 2] {
    [x + direction[0] * distance, y + direction[1] * distance]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sector_has_room_until_its_rings_relieve_all_of_it() {
        let sector = |radii_m: [f64; 2], span_rad: f64| Sector {
            center_m: [0.0; 2],
            angles_rad: [3.0, 3.0 + span_rad],
            cracks: [0, 1],
            radii_m,
        };
        let room = |of: Sector, taken_m: &[f64]| of.has_room(taken_m, 2e-3);
        assert!(room(sector([3e-3, 8e-3], 1.0), &[]));
        assert!(!room(sector([3e-3, 3e-3], 1.0), &[]), "no length");
        assert!(!room(sector([3e-3, 8e-3], 4.0), &[]), "more than a half");
        assert!(room(sector([3e-3, 8e-3], 1.0), &[4e-3]));
        assert!(!room(sector([3e-3, 8e-3], 1.0), &[4e-3, 7e-3]), "two rings");
    }
}
