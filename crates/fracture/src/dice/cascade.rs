//! Cracks that run and branch in the tension of a tempered pane's core until they meet.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

use rand_chacha::ChaCha8Rng;
use starbreak_seed::{Seed, Stream, normal, uniform};

use super::count::ONSET_PA;
use super::graph::Diced;
use super::tracks::{Meeting, Tracks};
use crate::FractureError;
use crate::mesh::Outline;

/// Speed of a running tip, m/s.
const TIP_SPEED_M_S: f64 = 1500.0;
/// Branching constant `A_b` of σ√r = `A_b`, Pa·√m. **Source** \[Mecholsky1978\]: 1.8 to 2.2 MPa√m.
const BRANCHING_PA_SQRT_M: f64 = 2.0e6;
/// `K_IC` of soda-lime glass, Pa·√m.
const TOUGHNESS_PA_SQRT_M: f64 = 0.75e6;
/// Spread of the logarithm of the distance between forks. FIT: 12 %.
const BRANCHING_SPREAD: f64 = 0.12;
/// Half of the angle of a fork, rad, and its spread. FIT between 45° (2:1 biaxial tension) and 90°
/// (equal tension in all directions).
const HALF_FORK_RAD: [f64; 2] = [55.0 * PI / 180.0, 8.0 * PI / 180.0];
/// Turn of a tip per distance between forks, standard deviation, rad.
const TURN_RAD: f64 = 10.0 * PI / 180.0;
/// Steps between forks.
const STEPS: f64 = 5.0;
/// Cracks that leave a hit.
const N_FIRST: u32 = 5;
/// Most steps of all tips.
const MAX_STEPS: usize = 6_000_000;
/// Area of a die in squared fork distances, to refuse too large panes before the work. Measured.
const DIE_AREA: f64 = 1.2;

/// A fork needs this many of the narrowest strips free ahead of both branches. FIT.
const FREE_STRIPS: f64 = 1.0;

/// A tip.
struct Tip {
    node: u32,
    direction_rad: f64,
    /// Turn per step, rad.
    turn_rad: f64,
    to_fork_m: f64,
}

/// Dice as cracks make them that run from the hits at 1500 m/s under the core's mean tension
/// σ = `σ_s`/3, fork after r = (`A_b`/σ)² of free run \[Mecholsky1978\], and end on a crack or on the rim.
///
/// Between two cracks s apart a third one gets the energy σ²s/2E per area, which is less than it
/// takes for s < 2 (`K_IC`/σ)². A tip that has a crack at its side nearer than that turns into it.
///
/// Areas over their mean then decay exponentially, as measured \[Dawara2026\].
///
/// The order of events is that of time, then of birth. Numbers come from stream `Dice`. A pane
/// below the onset, or without a hit, is left whole.
///
/// # Limits
/// Nothing is fitted to counts: the density follows from the fork distance alone, so that it grows
/// with `σ_s`⁴ and does not depend on thickness, where tests give about `σ_s`^2.4: at 70 MPa there
/// are about as many dice as in tests, at 100 MPa 1.4 times, at 140 MPa 2.4 times. For counts use
/// [`super::dice_cells`]. A crack farther away than that
/// is not felt.
///
/// # Errors
/// [`FractureError::TooManyDice`] for a pane of more than about 400 000.
pub fn dice_cascade(
    outline: &Outline,
    surface_compression_pa: f64,
    impacts_m: &[[f64; 2]],
    seed: Seed,
) -> Result<Diced, FractureError> {
    if surface_compression_pa <= ONSET_PA || impacts_m.is_empty() {
        return Ok(Diced {
            n_cells: 1,
            ..Diced::default()
        });
    }
    // The parabola σ_m (1 − 3ζ²), σ_m = σ_s/2, over the part of the thickness that is in tension.
    let tension_pa = 2.0 / 3.0 * 0.5 * surface_compression_pa;
    let length_m = |toughness_pa_sqrt_m: f64| {
        let root = toughness_pa_sqrt_m / tension_pa;
        root * root
    };
    let fork_m = length_m(BRANCHING_PA_SQRT_M);
    let [width, height] = outline.size_m();
    let too_many = |expected: f64| FractureError::TooManyDice {
        expected,
        limit: super::cells::MAX_CELLS,
        width_mm: width * 1e3,
        height_mm: height * 1e3,
        compression_mpa: surface_compression_pa * 1e-6,
    };
    let expected = width * height / (DIE_AREA * fork_m * fork_m);
    if expected > super::cells::MAX_CELLS {
        return Err(too_many(expected));
    }
    let mut cascade = Cascade {
        tracks: Tracks::new([width, height], fork_m / STEPS),
        queue: BinaryHeap::new(),
        tips: Vec::new(),
        is_met: Vec::new(),
        rng: seed.stream(Stream::Dice, 2),
        fork_m,
        strip_m: 2.0 * length_m(TOUGHNESS_PA_SQRT_M),
    };
    for &hit in impacts_m {
        cascade.start(hit);
    }
    let mut n_steps = 0;
    while let Some(Reverse((time_bits, tip))) = cascade.queue.pop() {
        n_steps += 1;
        if n_steps > MAX_STEPS {
            return Err(too_many(expected.max(super::cells::MAX_CELLS)));
        }
        cascade.advance(outline, f64::from_bits(time_bits), tip);
    }
    Ok(cascade.tracks.into_dice(outline))
}

struct Cascade {
    tracks: Tracks,
    /// (time in the bits of an f64 ≥ 0, which keep its order; tip).
    queue: BinaryHeap<Reverse<(u64, usize)>>,
    tips: Vec<Tip>,
    /// Nodes that another crack has ended on.
    is_met: Vec<bool>,
    rng: ChaCha8Rng,
    fork_m: f64,
    /// Width of a strip that is too narrow to be divided off.
    strip_m: f64,
}

impl Cascade {
    fn launch(&mut self, node: u32, direction_rad: f64, time_s: f64) {
        let turn_rad = TURN_RAD / STEPS * normal(&mut self.rng);
        let to_fork_m = self.fork_m * libm::exp(BRANCHING_SPREAD * normal(&mut self.rng));
        self.tips.push(Tip {
            node,
            direction_rad,
            turn_rad,
            to_fork_m,
        });
        self.queue
            .push(Reverse((time_s.to_bits(), self.tips.len() - 1)));
    }

    fn start(&mut self, hit: [f64; 2]) {
        let node = self.tracks.add_node(hit);
        let first = TAU * uniform(&mut self.rng);
        for k in 0..N_FIRST {
            let wobble = 0.2 * (uniform(&mut self.rng) - 0.5);
            let share = (f64::from(k) + wobble) / f64::from(N_FIRST);
            self.launch(node, first + TAU * share, 0.0);
        }
    }

    /// One step of a tip, to a fork, a crack or the rim at most.
    fn advance(&mut self, outline: &Outline, time_s: f64, tip_idx: usize) {
        self.is_met.resize(self.tracks.n_nodes(), false);
        let tip = &mut self.tips[tip_idx];
        let step_m = tip.to_fork_m.min(self.fork_m / STEPS);
        tip.direction_rad += tip.turn_rad;
        tip.to_fork_m -= step_m;
        let (node, direction_rad) = (tip.node, tip.direction_rad);
        let is_fork = tip.to_fork_m <= 0.0;
        let from = self.tracks.position(node);
        if self.is_met[node as usize] {
            return;
        }
        if let Some(beside) = self.beside(node, direction_rad) {
            self.join(node, time_s, beside.fraction * self.strip_m, &beside);
            return;
        }
        let (sin, cos) = libm::sincos(direction_rad);
        let end = [from[0] + step_m * cos, from[1] + step_m * sin];
        let meeting = self.tracks.first_meeting(node, end);
        let exit = outline.exit(from, end);
        if let Some(meeting) = meeting
            && exit.is_none_or(|t| meeting.fraction <= t)
        {
            let length = meeting.fraction * step_m;
            self.join(node, time_s, length, &meeting);
            return;
        }
        if let Some(t) = exit {
            let rim = super::cells::on_rim(
                outline,
                [
                    from[0] + t * (end[0] - from[0]),
                    from[1] + t * (end[1] - from[1]),
                ],
            );
            if t > 0.0 && rim.map(f64::to_bits) != from.map(f64::to_bits) {
                let to = self.tracks.add_node(rim);
                let end_s = time_s + (t * step_m / TIP_SPEED_M_S);
                self.tracks.add_track([node, to], [time_s, end_s]);
            }
            return;
        }
        let to = self.tracks.add_node(end);
        let end_s = time_s + step_m / TIP_SPEED_M_S;
        self.tracks.add_track([node, to], [time_s, end_s]);
        let half = HALF_FORK_RAD[0] + HALF_FORK_RAD[1] * normal(&mut self.rng);
        let half = half.clamp(0.35, 1.4);
        if is_fork && self.has_room(to, [direction_rad - half, direction_rad + half]) {
            self.launch(to, direction_rad + half, end_s);
            self.launch(to, direction_rad - half, end_s);
        } else {
            if is_fork {
                self.tips[tip_idx].to_fork_m = self.fork_m / STEPS;
            }
            self.tips[tip_idx].node = to;
            self.queue.push(Reverse((end_s.to_bits(), tip_idx)));
        }
    }

    /// Whether nothing is near enough to take the energy of either branch of a fork.
    fn has_room(&self, node: u32, directions_rad: [f64; 2]) -> bool {
        let from = self.tracks.position(node);
        let reach_m = FREE_STRIPS * self.strip_m;
        directions_rad.iter().all(|&direction| {
            let (sin, cos) = libm::sincos(direction);
            let end = [from[0] + reach_m * cos, from[1] + reach_m * sin];
            self.tracks.first_meeting(node, end).is_none()
        })
    }

    /// The nearer of the cracks to the left and right, if one is too near.
    fn beside(&self, node: u32, direction_rad: f64) -> Option<Meeting> {
        let from = self.tracks.position(node);
        let look = |turn: f64| {
            let (sin, cos) = libm::sincos(direction_rad + turn);
            let end = [from[0] + self.strip_m * cos, from[1] + self.strip_m * sin];
            self.tracks.first_meeting(node, end)
        };
        [0.5 * PI, -0.5 * PI, 0.25 * PI, -0.25 * PI]
            .into_iter()
            .filter_map(look)
            .min_by(|a, b| a.fraction.total_cmp(&b.fraction))
    }

    /// Ends a tip on the crack that it meets.
    fn join(&mut self, node: u32, time_s: f64, length_m: f64, meeting: &Meeting) {
        let to = self.tracks.node_at(node, meeting);
        // A tip that is met has nothing left to release.
        self.is_met.resize(self.tracks.n_nodes(), false);
        self.is_met[to as usize] = true;
        if to != node && !self.tracks.are_joined(node, to) {
            let end_s = time_s + length_m.max(1e-9) / TIP_SPEED_M_S;
            self.tracks.add_track([node, to], [time_s, end_s]);
        }
    }
}
