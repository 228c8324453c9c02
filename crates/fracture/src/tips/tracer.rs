//! Crack tips on their way, in the order of time.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_glass::SegmentKind;
use starbreak_seed::{Seed, Stream, normal};

use super::gaps::{finite_width, gaps_beside, way_to_rim};
use super::law::{BRANCHING_SCATTER, Gaps, TipLaw, WANDER_RAD, crack_direction, fork_angle_rad};
use super::tilt::{TILT_RAD, Tilt};
use super::web::{Piece, Web};
use crate::stress::{PlaneStress, StressField};

/// Most steps of all tips of one hit or load.
pub(crate) const MAX_STEPS: u32 = 300_000;

/// Most tips of one hit or load; from here on they run on without forks.
const MAX_TIPS: usize = 600;

/// How fast tips run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Motion {
    /// As running cracks: v from the energy that is left over.
    Dynamic,
    /// By stress corrosion, v = v0 (K/K_IC)^n, while loaded: half of every period.
    Corrosion {
        /// Time from load to load, s.
        period_s: f64,
    },
}

/// Crack speed of soda-lime glass at K_IC by stress corrosion, m/s; n = 16
/// \[Wiederhorn1967\].
const CORROSION_SPEED_M_S: f64 = 1e-2;

/// K/K_IC below which stress corrosion ends.
pub(crate) const CORROSION_LIMIT: f64 = 0.35;

/// Way over which the branches of a fork part, over the length that counts for K. FIT: forks of long
/// cracks keep their angle over about a quarter of the crack before they run side by side.
const APART: f64 = 0.25;

/// What a tip is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TipState {
    /// On its way, or waiting for more stress.
    Alive,
    /// It met a crack or the rim, or the energy is spent.
    Ended,
    /// Its branches stand for it.
    Forked,
}

/// The front end of a crack.
#[derive(Debug, Clone)]
pub(crate) struct Tip {
    pub(crate) crack: u32,
    pub(crate) kind: SegmentKind,
    pub(crate) node: u32,
    pub(crate) at_m: [f64; 2],
    /// Unit vector.
    pub(crate) direction: [f64; 2],
    /// Where the crack began, with all that it forked from, m.
    pub(crate) origin_m: [f64; 2],
    /// Length that counts for K (a fork hands half of it to each branch), m.
    pub(crate) length_m: f64,
    /// Way from where the crack began, m.
    pub(crate) along_m: f64,
    /// Way since the last fork, m.
    pub(crate) since_fork_m: f64,
    pub(crate) time_s: f64,
    pub(crate) tilt: Tilt,
    pub(crate) state: TipState,
    pub(crate) hint: u32,
    /// Length that counted for K at the last step, m.
    effective_m: f64,
    /// Way over which it forgets its direction, besides a thickness, m: the branches of a fork
    /// push each other apart for as long as the crack that they share is.
    apart_m: f64,
    /// Normal stress as it counts for K: that of the way behind the tip, the nearer the more.
    mean_stress_pa: Option<f64>,
    /// Node of the fork that it comes from.
    pub(super) fork_node: Option<u32>,
    branching_scatter: f64,
    /// Whether K has been below that of a fork: a tip forks where K rises to it. Where K is above it
    /// from the start, as under a stone, cracks start together, and their number has its own law.
    has_been_calm: bool,
    rng: ChaCha8Rng,
}

impl Tip {
    /// A tip of a new crack that starts at `node`, by itself or out of an older one.
    pub(crate) fn new(
        web: &mut Web,
        seed: Seed,
        (kind, parent): (SegmentKind, Option<u32>),
        node: u32,
        direction: [f64; 2],
        length_m: f64,
        time_s: f64,
    ) -> Self {
        let crack = web.new_crack(parent);
        let mut rng = seed.stream(Stream::TipJitter, u64::from(crack));
        let branching_scatter = libm::exp(BRANCHING_SCATTER * normal(&mut rng));
        Self {
            crack,
            kind,
            node,
            at_m: web.nodes[node as usize],
            origin_m: web.nodes[node as usize],
            direction,
            length_m,
            along_m: 0.0,
            since_fork_m: 0.0,
            time_s,
            tilt: Tilt::new(seed, u64::from(crack), TILT_RAD),
            state: TipState::Alive,
            hint: 0,
            effective_m: length_m,
            apart_m: 0.0,
            mean_stress_pa: None,
            fork_node: None,
            branching_scatter,
            has_been_calm: false,
            rng,
        }
    }
}

/// Energy that may still go into new surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ledger {
    pub(crate) available_j: f64,
    pub(crate) dissipated_j: f64,
    /// Steps that tips may still take, so that work is bounded.
    pub(crate) steps_left: u32,
}

impl Ledger {
    /// Takes `cost_j` if it is there.
    pub(crate) fn pay(&mut self, cost_j: f64) -> bool {
        let is_paid = self.dissipated_j + cost_j <= self.available_j;
        if is_paid {
            self.dissipated_j += cost_j;
        }
        is_paid
    }
}

/// How tips are traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tracing {
    pub(crate) law: TipLaw,
    pub(crate) motion: Motion,
    /// Range of a step, m.
    pub(crate) step_m: [f64; 2],
    /// Whether tips may fork.
    pub(crate) forks: bool,
    /// [`COMPETITION`], or 0 for tips that do not.
    pub(crate) competition: f64,
    /// Whether the rim feeds a tip less than glass does, as under stress in the plane.
    pub(crate) rim_shields: bool,
}

/// Runs the tips through the field until `until_s`, or until none can run.
///
/// Tips that lack the stress stay where they are, alive, and may run in another field.
pub(crate) fn trace(
    web: &mut Web,
    tips: &mut Vec<Tip>,
    field: &dyn StressField,
    tracing: &Tracing,
    ledger: &mut Ledger,
    seed: Seed,
    until_s: f64,
) {
    // (time, tip): of equal times the lower tip.
    let mut queue: BinaryHeap<Reverse<(u64, usize)>> = tips
        .iter()
        .enumerate()
        .filter(|(_, tip)| tip.state == TipState::Alive)
        .map(|(idx, tip)| Reverse((tip.time_s.to_bits(), idx)))
        .collect();
    while let Some(Reverse((_, idx))) = queue.pop() {
        if tips[idx].time_s >= until_s || ledger.steps_left == 0 {
            continue;
        }
        ledger.steps_left -= 1;
        let gaps = gaps_beside(web, tips, idx, tracing);
        let step = Step {
            web,
            field,
            tracing,
            ledger,
            gaps,
        };
        match step.take(&mut tips[idx]) {
            Outcome::Ran => queue.push(Reverse((tips[idx].time_s.to_bits(), idx))),
            Outcome::Rests => {}
            Outcome::Ended => tips[idx].state = TipState::Ended,
            Outcome::Forks { angle_rad } => {
                if tips.len() + 2 > MAX_TIPS {
                    queue.push(Reverse((tips[idx].time_s.to_bits(), idx)));
                    continue;
                }
                tips[idx].state = TipState::Forked;
                for side in [0.5, -0.5] {
                    let branch = branch_of(web, &tips[idx], seed, side * angle_rad);
                    queue.push(Reverse((branch.time_s.to_bits(), tips.len())));
                    tips.push(branch);
                }
            }
        }
    }
}

fn branch_of(web: &mut Web, parent: &Tip, seed: Seed, turn_rad: f64) -> Tip {
    let mut branch = Tip::new(
        web,
        seed,
        (SegmentKind::Fork, Some(parent.crack)),
        parent.node,
        rotated(parent.direction, turn_rad),
        // G is shared by the two, and G is proportional to the length.
        0.5 * parent.length_m,
        parent.time_s,
    );
    branch.hint = parent.hint;
    branch.origin_m = parent.origin_m;
    branch.apart_m = APART * parent.effective_m;
    branch.mean_stress_pa = parent.mean_stress_pa;
    branch.fork_node = Some(parent.node);
    branch.along_m = parent.along_m;
    branch.tilt.goes_on_from(&parent.tilt);
    branch
}

enum Outcome {
    /// It went on.
    Ran,
    /// It lacks the stress.
    Rests,
    /// It met something, or the energy is spent.
    Ended,
    /// It divides where it is.
    Forks { angle_rad: f64 },
}

struct Step<'a> {
    web: &'a mut Web,
    field: &'a dyn StressField,
    tracing: &'a Tracing,
    ledger: &'a mut Ledger,
    gaps: Gaps,
}

impl Step<'_> {
    fn take(self, tip: &mut Tip) -> Outcome {
        let Tracing { law, step_m, .. } = self.tracing;
        let Some(stress) = self.field.stress_at(tip.at_m, &mut tip.hint) else {
            return Outcome::Ended;
        };
        let side = [-tip.direction[1], tip.direction[0]];
        let effective_m = law.effective_length_m(tip.length_m, self.gaps);
        let normal_stress = stress.normal_pa(side);
        tip.effective_m = effective_m;
        let counts_pa = match tip.mean_stress_pa {
            Some(mean_pa) => mean_pa,
            None => self.stress_behind(tip, side).unwrap_or(normal_stress),
        };
        let mut intensity = law.intensity(counts_pa, effective_m);
        if self.tracing.rim_shields {
            let ligament_m = way_to_rim(self.web, tip.at_m, tip.direction);
            intensity *= finite_width(tip.length_m, ligament_m);
        }
        let Some(speed) = self.speed(intensity) else {
            return Outcome::Rests;
        };
        if let Some(angle_rad) = self.fork(tip, &stress, intensity) {
            return Outcome::Forks { angle_rad };
        }
        let length = (0.1 * tip.length_m).clamp(step_m[0], step_m[1]);
        let direction = self.turned(tip, &stress, length);
        tip.mean_stress_pa = law.mean_stress_pa(counts_pa, normal_stress, length, effective_m);
        let to = [
            tip.at_m[0] + direction[0] * length,
            tip.at_m[1] + direction[1] * length,
        ];
        self.go(
            tip,
            to,
            direction,
            [normal_stress, intensity, effective_m, speed],
        )
    }

    /// The stress across the crack at the place behind the tip that counts for K.
    fn stress_behind(&self, tip: &Tip, side: [f64; 2]) -> Option<f64> {
        let place = self.tracing.law.stress_place(tip.length_m, self.gaps);
        if place >= 1.0 {
            return None;
        }
        let [x, y] = tip.origin_m;
        let point = [x + (tip.at_m[0] - x) * place, y + (tip.at_m[1] - y) * place];
        let stress = self.field.stress_at(point, &mut tip.hint.clone())?;
        Some(stress.normal_pa(side))
    }

    /// Speed, or `None` where the tip rests.
    fn speed(&self, intensity: f64) -> Option<f64> {
        let law = &self.tracing.law;
        let speed = match self.tracing.motion {
            Motion::Dynamic => law.speed_m_s(intensity),
            Motion::Corrosion { .. } => {
                let ratio = intensity / law.toughness_pa_sqrt_m;
                if ratio < CORROSION_LIMIT {
                    0.0
                } else if ratio < 1.0 {
                    CORROSION_SPEED_M_S * libm::pow(ratio, 16.0)
                } else {
                    CORROSION_SPEED_M_S.max(law.speed_m_s(intensity))
                }
            }
        };
        // A tip at the very limit creeps; it does not stand still for ever.
        (speed > 0.0).then(|| speed.max(1e-9))
    }

    fn fork(&self, tip: &mut Tip, stress: &PlaneStress, intensity: f64) -> Option<f64> {
        let law = &self.tracing.law;
        let branching = law.branching_intensity(tip.branching_scatter);
        tip.has_been_calm |= intensity < branching;
        let may = self.tracing.forks
            && tip.has_been_calm
            && tip.since_fork_m > law.thickness_m
            && intensity >= branching
            // Each branch gets half of the energy, and needs Γ.
            && intensity * intensity >= 2.0 * law.toughness_pa_sqrt_m * law.toughness_pa_sqrt_m;
        may.then(|| fork_angle_rad(stress))
    }

    /// The direction after a step: it forgets the old one over a way of one thickness
    /// \[FrankLawn1967\], and wanders a little.
    fn turned(&self, tip: &mut Tip, stress: &PlaneStress, length: f64) -> [f64; 2] {
        let way = length / self.tracing.law.thickness_m;
        let memory = libm::exp(-length / (self.tracing.law.thickness_m + tip.apart_m));
        let target = crack_direction(stress, tip.direction);
        let x = memory * tip.direction[0] + (1.0 - memory) * target[0];
        let y = memory * tip.direction[1] + (1.0 - memory) * target[1];
        let size = libm::hypot(x, y);
        let mean = if size > 1e-12 {
            [x / size, y / size]
        } else {
            tip.direction
        };
        rotated(
            mean,
            WANDER_RAD * way.min(1.0).sqrt() * normal(&mut tip.rng),
        )
    }

    fn go(
        self,
        tip: &mut Tip,
        mut to: [f64; 2],
        direction: [f64; 2],
        [stress_pa, intensity, effective_m, speed]: [f64; 4],
    ) -> Outcome {
        let from = tip.at_m;
        let step = libm::hypot(to[0] - from[0], to[1] - from[1]);
        let mut outcome = Outcome::Ran;
        let mut node = None;
        if let Some(part) = self.web.outline.exit(from, to) {
            to = [
                from[0] + (to[0] - from[0]) * part,
                from[1] + (to[1] - from[1]) * part,
            ];
            outcome = Outcome::Ended;
        }
        // It snaps to a crack that is nearly within reach.
        let reach = [
            from[0] + (to[0] - from[0]) * 1.3,
            from[1] + (to[1] - from[1]) * 1.3,
        ];
        let crack = tip.crack;
        let time_s = tip.time_s;
        let hit = self.web.first_hit(from, reach, tip.node, |piece| {
            piece.crack != crack && piece.time_s[0] <= time_s
        });
        if let Some(hit) = hit {
            to = hit.point_m;
            node = Some(self.web.node_on(hit.piece, hit.point_m, 0.1 * step));
            outcome = Outcome::Ended;
        }
        let node = node.unwrap_or_else(|| self.web.add_node(to));
        to = self.web.nodes[node as usize];
        let length = libm::hypot(to[0] - from[0], to[1] - from[1]);
        if length <= 1e-3 * step {
            return Outcome::Ended;
        }
        let law = &self.tracing.law;
        if !self
            .ledger
            .pay(law.fracture_energy_j_m2 * law.thickness_m * length)
        {
            return Outcome::Ended;
        }
        let end_s = self.arrival_s(tip.time_s, length / speed);
        let tilt_rad = tip.tilt.wander(length / law.thickness_m);
        self.web.add_piece(Piece {
            a: tip.node,
            b: node,
            crack,
            kind: tip.kind,
            time_s: [tip.time_s, end_s],
            along_m: [tip.along_m, tip.along_m + length],
            stress_pa,
            intensity_pa_sqrt_m: intensity,
            effective_m,
            tilt_rad,
        });
        tip.node = node;
        tip.at_m = to;
        tip.direction = direction;
        tip.time_s = end_s;
        tip.along_m += length;
        tip.length_m += length;
        tip.since_fork_m += length;
        outcome
    }

    /// When a way that takes `running_s` is done: under repeated load only half of the time
    /// counts.
    fn arrival_s(&self, start_s: f64, running_s: f64) -> f64 {
        match self.tracing.motion {
            Motion::Dynamic => start_s + running_s,
            Motion::Corrosion { period_s } => {
                let half = 0.5 * period_s;
                let periods = libm::floor(start_s / period_s);
                let within = start_s - periods * period_s;
                let ran_before = periods * half + within.min(half);
                let total = ran_before + running_s;
                let whole = libm::floor(total / half);
                let rest = total - whole * half;
                (whole * period_s + rest).max(start_s)
            }
        }
    }
}

pub(crate) fn rotated([x, y]: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(angle_rad);
    [x * cos - y * sin, x * sin + y * cos]
}

/// The unit vector at an angle.
pub(crate) fn unit(angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(angle_rad.rem_euclid(2.0 * PI));
    [cos, sin]
}
