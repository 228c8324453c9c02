//! Chords of a spider's web: wedges between radial cracks break across, from the middle outward.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_glass::SegmentKind;
use starbreak_seed::{normal, uniform};

use super::heavy::Body;
use super::rings;
use crate::tips::{Piece, Tilt, unit};

/// A radius of chords over the next smaller one, and its scatter from sector to sector. FIT to
/// photographs, where rings jump by up to 8 % at radials and are uneven.
const CHORD_STEP: [f64; 2] = [1.15, 1.5];
const CHORD_JUMP: f64 = 0.06;

/// Of the sectors a chord breaks these shares, at the middle and at the outermost chord. FIT.
const CHORDS: [f64; 2] = [0.8, 0.2];

/// How far chords bow outward, of an arc about the middle, and its scatter. FIT to photographs, where most of
/// them follow a circle.
const ROUND: [f64; 2] = [0.8, 0.35];

/// Chords run at this part of the speed of Rayleigh waves at least. FIT.
const SLOWEST_CHORD: f64 = 0.05;

/// Chords go out to this part of the reach of the radials, and break when those have come so many
/// times as far as they are. FIT: photographs have them in the inner half.
const CHORD_REACH: f64 = 0.5;
const CHORD_AFTER: f64 = 1.6;

impl Body<'_> {
    /// Chords between neighboring radials, from the crumb outward.
    pub(super) fn chords(&mut self, mut rng: ChaCha8Rng) {
        let reach_m = CHORD_REACH * self.sums.reach_m;
        let folds = libm::log((reach_m / self.crumb_m).max(1.0));
        let mut radius = self.crumb_m;
        let step =
            |rng: &mut ChaCha8Rng| CHORD_STEP[0] + (CHORD_STEP[1] - CHORD_STEP[0]) * uniform(rng);
        radius *= step(&mut rng);
        while radius < reach_m {
            let out = libm::log(radius / self.crumb_m) / folds.max(1e-9);
            let share = CHORDS[0] + (CHORDS[1] - CHORDS[0]) * out;
            // Once around, from one crack to the next.
            let mut angle = 2.0 * PI * uniform(&mut rng);
            let end = angle + 2.0 * PI;
            while angle < end {
                let own = radius * libm::exp(CHORD_JUMP * normal(&mut rng));
                let breaks = uniform(&mut rng) < share;
                let Some((start, start_rad)) = self.next_crack(own, angle) else {
                    break;
                };
                if breaks && start_rad < end {
                    self.chord((start, start_rad), own, &mut rng);
                }
                angle = start_rad + 0.5 * self.law.thickness_m / own;
            }
            radius *= step(&mut rng);
        }
    }

    /// The first crack that a circle meets from an angle on: a node on it, and its angle.
    fn next_crack(&mut self, radius_m: f64, from_rad: f64) -> Option<(u32, f64)> {
        let at = |angle: f64| {
            let [cos, sin] = unit(angle);
            [
                self.center_m[0] + radius_m * cos,
                self.center_m[1] + radius_m * sin,
            ]
        };
        let n = 240;
        let step = 2.0 * PI / f64::from(n);
        let is_radial = |piece: &Piece| piece.kind != SegmentKind::Ring;
        for k in 0..n {
            let angle = from_rad + f64::from(k) * step;
            let (a, b) = (at(angle), at(angle + step));
            if self.web.outline.depth_m(b) <= 0.0 {
                continue;
            }
            if let Some(hit) = self.web.first_hit(a, b, u32::MAX, is_radial) {
                let node = self.web.node_on(hit.piece, hit.point_m, 1e-5);
                return Some((node, angle + hit.at * step));
            }
        }
        None
    }

    /// A chord from a crack to the next one around the middle.
    fn chord(&mut self, (start, start_rad): (u32, f64), radius_m: f64, rng: &mut ChaCha8Rng) {
        let Some((end, end_rad)) =
            self.next_crack(radius_m, start_rad + 0.5 * self.law.thickness_m / radius_m)
        else {
            return;
        };
        let span = end_rad - start_rad;
        if span <= 0.0 || span > 0.6 * PI || start == end {
            return;
        }
        let sine = libm::sin(0.5 * span);
        let bow_m =
            (ROUND[0] + ROUND[1] * normal(rng)) * radius_m * (1.0 - (1.0 - sine * sine).sqrt());
        self.break_across([start, end], bow_m, self.passes_s(CHORD_AFTER * radius_m));
    }

    /// Breaks a chord between two nodes, which bows so far from the straight way, from its middle
    /// to both sides.
    fn break_across(&mut self, [start, end]: [u32; 2], bow_m: f64, breaks_s: f64) {
        let [from, to] = [start, end].map(|node| self.web.nodes[node as usize]);
        let whole = libm::hypot(to[0] - from[0], to[1] - from[1]);
        if whole < 0.5 * self.law.thickness_m {
            return;
        }
        let outward = [(to[1] - from[1]) / whole, -(to[0] - from[0]) / whole];
        let at = |part: f64| {
            let off = 4.0 * bow_m * part * (1.0 - part);
            [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * part + off * outward[axis])
        };
        let crack = self.web.new_crack(None);
        let middle = self.web.add_node(at(0.5));
        let first = Tilt::new(self.seed, (1 << 34) | u64::from(crack), rings::TILT_RAD);
        let mut second = Tilt::new(self.seed, (1 << 35) | u64::from(crack), rings::TILT_RAD);
        second.goes_back_from(&first);
        for (last, side, tilt) in [(end, 0.5, first), (start, -0.5, second)] {
            let way = |part: f64| at(0.5 + side * part);
            self.half_a_chord(crack, [middle, last], (way, 0.5 * whole), breaks_s, tilt);
        }
    }

    /// Runs a crack from node to node along a way of a length, m, to what it meets first.
    fn half_a_chord(
        &mut self,
        crack: u32,
        [start, end]: [u32; 2],
        (at, whole_m): (impl Fn(f64) -> [f64; 2], f64),
        breaks_s: f64,
        mut tilt: Tilt,
    ) {
        let h = self.law.thickness_m;
        let n = libm::ceil(whole_m / (1.5 * h)).clamp(1.0, 32.0);
        let speed_m_s = (self.law.speed_m_s(self.law.intensity(self.strength_pa, h)))
            .max(SLOWEST_CHORD * self.law.rayleigh_m_s);
        let mut node = start;
        let mut k = 1.0;
        let (mut along, mut time_s) = (0.0, breaks_s);
        while k <= n {
            let point = at(k / n);
            let last = self.web.nodes[node as usize];
            let others = |piece: &Piece| piece.crack != crack;
            let met = self.web.first_hit(last, point, node, others);
            let met = met.filter(|_| k < n);
            let next = match met {
                Some(hit) => self.web.node_on(hit.piece, hit.point_m, 1e-5),
                None if k < n => self.web.add_node(point),
                None => end,
            };
            let place = self.web.nodes[next as usize];
            let length = libm::hypot(place[0] - last[0], place[1] - last[1]);
            if length > 0.0 && next != node {
                let tilt_rad = tilt.wander(length / h);
                self.add(Piece {
                    a: node,
                    b: next,
                    crack,
                    kind: SegmentKind::Ring,
                    time_s: [time_s, time_s + length / speed_m_s],
                    along_m: [along, along + length],
                    stress_pa: self.strength_pa,
                    intensity_pa_sqrt_m: 0.0,
                    effective_m: h,
                    tilt_rad,
                });
                along += length;
                time_s += length / speed_m_s;
            }
            node = next;
            if met.is_some() {
                break;
            }
            k += 1.0;
        }
    }
}
