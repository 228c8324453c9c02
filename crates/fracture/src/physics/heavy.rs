//! A heavy body on a laminate: both plies break, each into radial cracks with chords between them.
//!
//! A stone is gone before bending has come far: the interlayer holds the ply that was hit, and only
//! that one breaks. A heavy body goes on pushing while the bending wave runs out through the whole
//! laminate. Both plies bend as free plates then, with half of the body each, and their radial
//! cracks follow the wave. Wedges of glass are left, which hang on the interlayer; as the dent
//! deepens they break across, again and again, from the middle outward: the rings of a spider's
//! web are chords between neighboring radials.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_glass::SegmentKind;
use starbreak_seed::{Seed, Stream, normal, uniform};

use super::impact::{Breaking, Facts};
use super::outcome::{ImpactReport, Stage};
use super::plate::Stiffness;
use super::radials::{draw_angles, draw_count, mean_radial_count, whole_count};
use crate::contact::{ContactLoad, contact_load};
use crate::params::{GlassBuild, GlassPane, StoneImpact};
use crate::tips::{Piece, TERMINAL_SPEED_M_S, Tip, TipLaw, Web, unit};

/// A body is heavy where bending has come this far, in thicknesses of the ply, in the time in which
/// both plies take its momentum. FIT: stones of some 10 g leave the inner ply whole, hail of 50 g
/// may not.
const HEAVY: f64 = 40.0;

/// Radial cracks would be nearer to each other than this many thicknesses: the glass is crumb. FIT.
const CRUMB: f64 = 1.2;

/// Of each radial crack, per e-fold of its distance: how often it ends, and how often it forks.
/// FIT to photographs, where about half of the cracks around the middle come to ten times its
/// radius.
const ENDS: f64 = 0.45;
const FORKS: f64 = 0.22;

/// Half of the angle of a fork, rad, and over which part of its distance a crack turns back to the
/// radius. FIT.
const FORK_RAD: f64 = 0.35;
const TURNS_BACK: f64 = 0.5;

/// Wander of the direction over a way of one thickness, rad. FIT.
const WANDER_RAD: f64 = 0.035;

impl Breaking<'_> {
    /// The plies of a laminate as panes of their own, for a body that breaks both.
    pub(super) fn heavy_plies(&self, stone: &StoneImpact) -> Option<[GlassPane; 2]> {
        let GlassBuild::Laminated {
            inner_thickness_m, ..
        } = self.pane.build
        else {
            return None;
        };
        let stiffness = Stiffness::of(self.pane);
        let lasts_s = 0.5 * stone.mass_kg() / stiffness.impedance_kg_s();
        let is_heavy = stiffness.wave_reach_m(lasts_s) > HEAVY * self.pane.thickness_m;
        is_heavy.then(|| {
            [self.pane.thickness_m, inner_thickness_m].map(|thickness_m| GlassPane {
                thickness_m,
                build: GlassBuild::Annealed,
                ..self.pane.clone()
            })
        })
    }

    /// Breaks both plies by a heavy body that touches the pane at `start_s`.
    pub(super) fn heavy_hit(
        &mut self,
        (stone, plies): (&StoneImpact, &[GlassPane; 2]),
        k: u64,
        start_s: f64,
        done: &mut impl FnMut(Stage),
    ) -> ImpactReport {
        self.n_older = self.web.n_cracks();
        let half = StoneImpact {
            density_kg_m3: 0.5 * stone.density_kg_m3,
            ..*stone
        };
        let contact = contact_load(&half, &self.pane.material, self.pane.thickness_m);
        done(Stage::Contact);
        let mut sums = Sums::default();
        let broken = if self.opens(&half, &contact) {
            &plies[..]
        } else {
            &[]
        };
        for (ply, pane) in (0_u64..).zip(broken) {
            let web = match ply {
                0 => &mut self.web,
                _ => self.inner.get_or_insert_with(|| Web::new(pane.outline)),
            };
            let index = (ply << 40) | k;
            let mut rng = self.seed.stream(Stream::StoneFlaws, (1 << 33) | index);
            let n_radial = draw_count(
                mean_radial_count(
                    &pane.material,
                    pane.thickness_m,
                    stone.normal_speed_m_s(),
                    self.params.radial_count_factor,
                ),
                &mut rng,
            );
            let crumb_m = CRUMB * f64::from(2 * n_radial) * pane.thickness_m / (2.0 * PI);
            let mut body = Body {
                web,
                stiffness: Stiffness::of(pane),
                law: TipLaw::new(&pane.material, pane.thickness_m, true),
                center_m: stone.position_m,
                start_s,
                crumb_m,
                strength_pa: self.params.strength_pa,
                seed: self.seed,
                rng,
                sums: &mut sums,
            };
            // An e-fold farther out so many are left as the law says.
            let at_crumb = whole_count(f64::from(n_radial) * libm::exp(ENDS));
            body.radials(at_crumb, self.params.weibull_modulus);
            done(Stage::Tips);
            let rng = self.seed.stream(Stream::Rings, (1 << 33) | index);
            body.chords(rng);
            done(Stage::Rings);
        }
        ImpactReport {
            position_m: stone.position_m,
            time_s: start_s,
            damage: Facts {
                has_legs: sums.n_arms > 0,
                has_cone: false,
                is_closed: false,
                is_marked: contact.crushed_radius_m > 0.0,
                meets_rim: sums.meets_rim,
                reach_m: sums.reach_m,
            }
            .class(),
            kinetic_energy_j: stone.kinetic_energy_j(),
            peak_force_n: 2.0 * contact.peak_force_n,
            contact_time_s: contact.contact_time_s,
            contact_radius_m: contact.contact_radius_m,
            crushed_radius_m: sums.crumb_m.max(contact.crushed_radius_m),
            n_arms: sums.n_arms,
            n_legs: sums.n_arms,
            reach_m: sums.reach_m,
            available_j: 2.0 * contact.plate_energy_j,
            dissipated_j: sums.dissipated_j,
        }
    }

    /// Whether half of a body bends a ply so far that it breaks: the stress in the middle of a
    /// clamped disc, as large as the wave has come, 3F(1 + ν)/(2πh²) ln(reach/patch)
    /// \[Timoshenko1959\], against the strength of the area under it.
    fn opens(&self, half: &StoneImpact, contact: &ContactLoad) -> bool {
        let stiffness = Stiffness::of(self.pane);
        let patch_m = stiffness.patch_radius_m(contact.contact_radius_m);
        let reach_m = stiffness.wave_reach_m(half.mass_kg() / stiffness.impedance_kg_s());
        let folds = libm::log((reach_m / patch_m).max(1.0));
        let stress_pa = contact.peak_force_n * stiffness.stress_per_log_reach_pa_n() * folds;
        stress_pa >= self.strength_of_area_pa(PI * patch_m * patch_m)
    }
}

/// What both plies add up to.
#[derive(Default)]
pub(super) struct Sums {
    n_arms: usize,
    pub(super) reach_m: f64,
    pub(super) crumb_m: f64,
    dissipated_j: f64,
    meets_rim: bool,
}

/// One ply under a heavy body.
pub(super) struct Body<'a> {
    pub(super) web: &'a mut Web,
    stiffness: Stiffness,
    pub(super) law: TipLaw,
    pub(super) center_m: [f64; 2],
    start_s: f64,
    pub(super) crumb_m: f64,
    pub(super) strength_pa: f64,
    pub(super) seed: Seed,
    rng: ChaCha8Rng,
    pub(super) sums: &'a mut Sums,
}

impl Body<'_> {
    /// Radial cracks and their forks, in the order in which they begin.
    fn radials(&mut self, count: u32, weibull_modulus: f64) {
        let angles = draw_angles(count, weibull_modulus, |_| 1.0, &mut self.rng);
        self.sums.n_arms += angles.len();
        self.sums.crumb_m = self.sums.crumb_m.max(self.crumb_m);
        let node = self.web.add_node(self.center_m);
        let mut waiting: Vec<Tip> = Vec::new();
        for angle in angles {
            let origin = (SegmentKind::Radial, None);
            let tip = Tip::new(
                self.web,
                self.seed,
                origin,
                node,
                unit(angle),
                0.0,
                self.start_s,
            );
            waiting.push(tip);
        }
        waiting.reverse();
        while let Some(tip) = waiting.pop() {
            if let Some(branches) = self.run(tip) {
                waiting.extend(branches);
            }
        }
    }

    /// When a radial crack is at a distance, s: with the bending wave, and no faster than cracks run.
    pub(super) fn passes_s(&self, radius_m: f64) -> f64 {
        let per_root_s = self.stiffness.wave_reach_m(1.0);
        let wave_s = (radius_m / per_root_s) * (radius_m / per_root_s);
        self.start_s + wave_s + radius_m / TERMINAL_SPEED_M_S
    }

    /// Stress across a radial crack at a distance: that of the strength in the crumb, falling with
    /// the logarithm of the distance.
    fn stress_pa(&self, radius_m: f64) -> f64 {
        self.strength_pa / (1.0 + libm::log((radius_m / self.crumb_m).max(1.0)))
    }

    /// Runs a crack to its end. The two branches, where it forks.
    fn run(&mut self, mut tip: Tip) -> Option<[Tip; 2]> {
        let h = self.law.thickness_m;
        loop {
            let [dx, dy] = [0, 1].map(|axis| tip.at_m[axis] - self.center_m[axis]);
            let radius = libm::hypot(dx, dy);
            let step = (0.08 * radius).clamp(0.5 * h, 2.0 * h);
            if radius > self.crumb_m {
                let folds = step / radius;
                if uniform(&mut self.rng) < ENDS * folds {
                    return None;
                }
                if uniform(&mut self.rng) < FORKS * folds && tip.since_fork_m > 3.0 * h {
                    return Some(self.branches(&tip));
                }
            }
            let outward = if radius > 0.0 {
                [dx / radius, dy / radius]
            } else {
                tip.direction
            };
            let memory = libm::exp(-step / (TURNS_BACK * radius).max(h));
            let wander = WANDER_RAD * (step / h).sqrt() * normal(&mut self.rng);
            let mixed =
                [0, 1].map(|axis| memory * tip.direction[axis] + (1.0 - memory) * outward[axis]);
            let angle = libm::atan2(mixed[1], mixed[0]) + wander;
            tip.direction = unit(angle);
            let to = [0, 1].map(|axis| tip.at_m[axis] + step * tip.direction[axis]);
            if self.go(&mut tip, to) {
                return None;
            }
        }
    }

    fn branches(&mut self, tip: &Tip) -> [Tip; 2] {
        let angle = libm::atan2(tip.direction[1], tip.direction[0]);
        [0.5, -0.5].map(|side| {
            let mut branch = Tip::new(
                self.web,
                self.seed,
                (SegmentKind::Fork, Some(tip.crack)),
                tip.node,
                unit(angle + side * FORK_RAD),
                tip.length_m,
                tip.time_s,
            );
            branch.along_m = tip.along_m;
            branch.tilt.goes_on_from(&tip.tilt);
            branch
        })
    }

    /// Takes a step, to what it meets. Whether it ends there.
    fn go(&mut self, tip: &mut Tip, mut to: [f64; 2]) -> bool {
        let from = tip.at_m;
        let mut is_over = false;
        if let Some(part) = self.web.outline.exit(from, to) {
            to = [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * part);
            self.sums.meets_rim = true;
            is_over = true;
        }
        let crack = tip.crack;
        // Within the crumb they cross each other.
        let radius = libm::hypot(from[0] - self.center_m[0], from[1] - self.center_m[1]);
        let hit = (radius > 0.5 * self.crumb_m)
            .then(|| {
                let others = |piece: &Piece| piece.crack != crack;
                self.web.first_hit(from, to, tip.node, others)
            })
            .flatten();
        let node = match hit {
            Some(hit) => {
                is_over = true;
                self.web.node_on(hit.piece, hit.point_m, 1e-5)
            }
            None => self.web.add_node(to),
        };
        to = self.web.nodes[node as usize];
        let length = libm::hypot(to[0] - from[0], to[1] - from[1]);
        if length <= 0.0 || node == tip.node {
            return true;
        }
        let radius = libm::hypot(to[0] - self.center_m[0], to[1] - self.center_m[1]);
        let end_s = self.passes_s(radius).max(tip.time_s + 1e-9);
        let tilt_rad = tip.tilt.wander(length / self.law.thickness_m);
        self.add(Piece {
            a: tip.node,
            b: node,
            crack,
            kind: tip.kind,
            time_s: [tip.time_s, end_s],
            along_m: [tip.along_m, tip.along_m + length],
            stress_pa: self.stress_pa(radius),
            intensity_pa_sqrt_m: 0.0,
            effective_m: self.law.thickness_m,
            tilt_rad,
        });
        self.sums.reach_m = self.sums.reach_m.max(radius);
        tip.node = node;
        tip.at_m = to;
        tip.time_s = end_s;
        tip.along_m += length;
        tip.since_fork_m += length;
        is_over
    }

    pub(super) fn add(&mut self, mut piece: Piece) {
        let law = &self.law;
        piece.intensity_pa_sqrt_m = law.intensity(piece.stress_pa, piece.effective_m);
        let length_m = piece.along_m[1] - piece.along_m[0];
        self.sums.dissipated_j += law.fracture_energy_j_m2 * law.thickness_m * length_m;
        self.web.add_piece(piece);
    }
}
