//! One hit: contact, radials through the bending plate, rings, cone.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_glass::{Seed, SegmentKind, Stream};

use super::outcome::{DamageClass, ImpactReport, Stage};
use super::params::{GlassBuild, GlassPane, PhysicsParams, StoneImpact};
use super::plate::{Bending, Carrying, Load, Plates};
use super::radials::{cull, draw_angles, draw_count, mean_radial_count};
use super::rings::{Rings, Sector};
use crate::FractureError;
use crate::contact::{ConeOutcome, ContactLoad, HertzianCrack, contact_load, hertzian_crack};
use crate::mesh::uniform;
use crate::stress::{Face, StressField};
use crate::tips::{
    COMPETITION, Ledger, Motion, Piece, Tip, TipLaw, TipState, Tracing, Web, normal, trace, unit,
};

/// A crack longer than this is not repaired: it is a class of its own, m \[ROLAGS\].
const LONG_CRACK_M: f64 = 0.152;

/// Scatter of the distances at which radials start, standard deviation of the logarithm. FIT: legs of
/// real stars differ by a factor of two.
const START_SCATTER: f64 = 0.2;

/// Area of a bending test of glass that the strength is measured on, m².
const TEST_AREA_M2: f64 = 2.5e-3;

/// Growth in time from one load to the next while the solution needs no more than to be stretched.
const WINDOW_GROWTH: f64 = 1.4;

/// Growth in time from one solution to the next where a rim or a crack is in reach: the wave's
/// reach doubles.
const EPOCH_GROWTH: f64 = 4.0;

/// Loads from that which opens the first flaw to the highest, where the foundation carries.
const N_RAMP: u32 = 12;

/// Most loads of one hit.
const MAX_WINDOWS: usize = 60;

/// Depth over thickness at which the compression of tempered glass ends: (½ − 1/√12)
/// of a parabola.
const COMPRESSION_DEPTH: f64 = 0.211_324_865_405_187_1;

/// A radial that reaches this part of the farthest is a leg; the others end in the crushed zone.
const LEG_PART: f64 = 0.3;

/// A cone that goes deeper than this part of the sheet is seen as a bullseye.
const VISIBLE_CONE: f64 = 0.5;

/// The pane while it is being broken.
pub(super) struct Breaking<'a> {
    pub(super) pane: &'a GlassPane,
    pub(super) params: &'a PhysicsParams,
    pub(super) seed: Seed,
    pub(super) web: Web,
    pub(super) plates: Plates,
    /// Whether a crack anywhere sends the whole pane to pieces.
    pub(super) dices: bool,
    pub(super) is_diced: bool,
    /// Cracks that were there before the hit.
    pub(super) n_older: u32,
}

/// A load and the time in which it holds.
#[derive(Debug, Clone, Copy)]
struct Window {
    load: Load,
    from_s: f64,
    until_s: f64,
}

/// The first flaw opens.
struct Opening {
    /// The highest load, as the plate carries it at that time.
    load: Load,
    bending: Bending,
    time_s: f64,
    force_n: f64,
    rng: ChaCha8Rng,
}

/// What a hit has at hand.
struct Hit<'a> {
    stone: &'a StoneImpact,
    contact: ContactLoad,
    cone: HertzianCrack,
    law: TipLaw,
    /// Number of the hit.
    k: u64,
    /// When the stone touches, s.
    start_s: f64,
    /// When the force is highest, s after the touch.
    peak_s: f64,
}

impl Breaking<'_> {
    /// Breaks the pane by one stone that touches it at `start_s`.
    pub(super) fn hit(
        &mut self,
        stone: &StoneImpact,
        k: u64,
        start_s: f64,
        done: &mut impl FnMut(Stage),
    ) -> Result<ImpactReport, FractureError> {
        let (material, h) = (&self.pane.material, self.pane.thickness_m);
        let contact = contact_load(stone, material, h);
        let cone = hertzian_crack(stone, &contact, material, h, self.seed, k);
        let peak_s =
            contact.history.iter().fold(
                [0.0, 0.0],
                |best, &[t, f]| if f > best[1] { [t, f] } else { best },
            )[0];
        let hit = Hit {
            stone,
            cone,
            law: TipLaw::new(material, h, true),
            k,
            start_s,
            peak_s,
            contact,
        };
        done(Stage::Contact);
        let first_piece = self.web.pieces.len();
        self.n_older = self.web.n_cracks();
        let mut ledger = Ledger {
            available_j: 0.0,
            dissipated_j: 0.0,
        };
        let mut tips = Vec::new();
        let mut has_burst = false;
        if !self.is_diced {
            let is_deep = self.cone_depth_m(&hit) > COMPRESSION_DEPTH * h;
            if self.dices && is_deep {
                has_burst = true;
            } else if let Some(opening) = self.opening(&hit, done)? {
                if self.dices {
                    has_burst = true;
                } else {
                    let windows = self.windows(&hit, &opening);
                    tips = self.radials(&hit, opening, &windows, &mut ledger, done)?;
                    if tips.len() > 2 {
                        self.rings(&hit, &windows, &tips, first_piece, &mut ledger)?;
                        done(Stage::Rings);
                    }
                }
            }
        }
        if !self.is_diced && !has_burst {
            self.cone(&hit);
        }
        let mut report = self.report(&hit, &tips, first_piece, &ledger);
        if has_burst {
            report.damage = DamageClass::Diced;
        }
        Ok(report)
    }

    /// Strength of a small area, which has fewer flaws than that of a test: (A_test/A)^(1/m) times
    /// as much \[Weibull1939\].
    fn strength_of_area_pa(&self, area_m2: f64) -> f64 {
        let exponent = 1.0 / self.params.weibull_modulus;
        self.params.strength_pa * libm::pow(TEST_AREA_M2 / area_m2, exponent)
    }

    fn cone_depth_m(&self, hit: &Hit<'_>) -> f64 {
        match hit.cone.outcome {
            ConeOutcome::None | ConeOutcome::Ring => 0.0,
            ConeOutcome::Partial { depth_m, .. } => depth_m,
            ConeOutcome::Through { .. } => self.pane.thickness_m,
        }
    }

    /// The load at which the tension under the stone opens the weakest flaw there, `None` if it
    /// never does: Weibull's strength, and the compression of a tempered surface.
    fn opening(
        &mut self,
        hit: &Hit<'_>,
        done: &mut impl FnMut(Stage),
    ) -> Result<Option<Opening>, FractureError> {
        let center_m = hit.stone.position_m;
        let stiffness = self.plates.stiffness;
        let patch_radius_m = stiffness.patch_radius_m(hit.contact.contact_radius_m);
        let carrying = self.plates.carrying(center_m, hit.peak_s);
        let load = Load {
            center_m,
            patch_radius_m,
            force_n: hit.contact.peak_force_n,
            carrying,
        };
        let bending = self.bend_for_tips(&load)?;
        done(Stage::Stress);
        let stress_pa_n = bending
            .face(Face::Back)
            .stress_at(center_m, &mut 0)
            .map_or(0.0, |stress| stress.principal().0)
            / load.force_n;
        let mut rng = self.seed.stream(Stream::StoneFlaws, (1 << 32) | hit.k);
        let modulus = self.params.weibull_modulus;
        let scatter = libm::pow(-libm::log(1.0 - uniform(&mut rng)), 1.0 / modulus);
        let residual_pa = match self.pane.build {
            GlassBuild::Tempered {
                surface_compression_pa,
            } => surface_compression_pa,
            GlassBuild::Annealed | GlassBuild::Laminated { .. } => 0.0,
        };
        let area_m2 = PI * patch_radius_m * patch_radius_m;
        let strength_pa = self.strength_of_area_pa(area_m2) * scatter.clamp(0.5, 1.5) + residual_pa;
        let opens = |[time_s, force_n]: [f64; 2]| {
            // A younger wave bends a smaller disc, less by the logarithm of its reach.
            let younger = match carrying {
                Carrying::Wave { reach_m } => {
                    let ratio = (stiffness.wave_reach_m(time_s) / reach_m).max(1e-9);
                    stiffness.stress_per_log_reach_pa_n() * libm::log(ratio)
                }
                Carrying::Foundation { .. } | Carrying::Rim => 0.0,
            };
            force_n * (stress_pa_n + younger) >= strength_pa
        };
        let first = hit
            .contact
            .history
            .iter()
            .find(|&&[time_s, force_n]| time_s > 0.0 && opens([time_s, force_n]));
        // A cone that comes through first takes the load off the plate: its plug rests on what
        // lies behind, or leaves.
        let first = first.filter(|[_, force_n]| *force_n < hit.cone.through_n);
        Ok(first.map(|&[time_s, force_n]| Opening {
            load,
            bending,
            time_s,
            force_n,
            rng,
        }))
    }

    /// The loads of a hit from the opening of the first flaw on, in the order of time.
    ///
    /// On a foundation the force rises to its peak, and what then has come to rest stays. A
    /// plate without one bends farther and farther out: under the stone's force while it lasts,
    /// then by what the stone has set in motion.
    fn windows(&self, hit: &Hit<'_>, opening: &Opening) -> Vec<Window> {
        let stiffness = &self.plates.stiffness;
        let window = |force_n, carrying, from_s: f64, until_s: f64| Window {
            load: Load {
                force_n,
                carrying,
                ..opening.load
            },
            from_s: hit.start_s + from_s,
            until_s: hit.start_s + until_s,
        };
        let mut windows: Vec<Window> = Vec::new();
        if let Carrying::Foundation { .. } = opening.load.carrying {
            for k in 0..=N_RAMP {
                let part = f64::from(k) / f64::from(N_RAMP);
                let next = f64::from(k + 1) / f64::from(N_RAMP);
                let force_n = opening.force_n + part * (hit.contact.peak_force_n - opening.force_n);
                let at = |part: f64| opening.time_s + part * (hit.peak_s - opening.time_s);
                let until_s = if k == N_RAMP { f64::INFINITY } else { at(next) };
                windows.push(window(force_n, opening.load.carrying, at(part), until_s));
            }
            return windows;
        }
        let deflection_m = stiffness.deflection_m(hit.contact.impulse_n_s);
        let mut from_s = opening.time_s;
        let mut n_solved = 0;
        while windows.len() < MAX_WINDOWS && n_solved < self.params.epochs {
            let carrying_at = |time_s| self.plates.carrying(hit.stone.position_m, time_s);
            let stretched = carrying_at(from_s * WINDOW_GROWTH);
            let is_stretched = self.stretches(&opening.load, stretched);
            let growth = if is_stretched {
                WINDOW_GROWTH
            } else {
                EPOCH_GROWTH
            };
            let until_s = from_s * growth;
            let time_s = from_s * growth.sqrt();
            let carrying = carrying_at(time_s);
            let acting_n = hit.contact.force_at_n(time_s);
            let spreading_n = stiffness.disc_force_n(deflection_m, stiffness.wave_reach_m(time_s));
            let force_n = if acting_n > 0.0 {
                acting_n
            } else {
                spreading_n
            };
            windows.push(window(force_n, carrying, from_s, until_s));
            n_solved += u32::from(!is_stretched);
            if matches!(carrying, Carrying::Rim) && acting_n <= 0.0 {
                break;
            }
            from_s = until_s;
        }
        windows
    }

    /// Whether the first solution, stretched, is that of another time: no rim and no older crack
    /// is in reach.
    fn stretches(&self, first: &Load, carrying: Carrying) -> bool {
        let is_free = |carrying| self.plates.is_free(first.center_m, carrying);
        let load = Load { carrying, ..*first };
        is_free(first.carrying) && is_free(carrying) && !self.has_older_near(&load)
    }

    /// Radial cracks and their forks.
    fn radials(
        &mut self,
        hit: &Hit<'_>,
        opening: Opening,
        windows: &[Window],
        ledger: &mut Ledger,
        done: &mut impl FnMut(Stage),
    ) -> Result<Vec<Tip>, FractureError> {
        let mut tips: Vec<Tip> = Vec::new();
        let h = self.pane.thickness_m;
        let tracing = Tracing {
            law: hit.law,
            motion: Motion::Dynamic,
            step_m: [(0.1 * h).clamp(2e-5, 2e-4), (0.5 * h).min(1e-3)],
            forks: true,
            competition: COMPETITION,
            rim_shields: false,
        };
        let Opening {
            load: first,
            mut bending,
            mut rng,
            ..
        } = opening;
        let is_foundation = matches!(first.carrying, Carrying::Foundation { .. });
        for (k, window) in windows.iter().enumerate() {
            let Window {
                load,
                from_s,
                until_s,
            } = window;
            if is_foundation {
                bending.set_load(load.force_n, None);
            } else if let (Carrying::Wave { reach_m }, true) =
                (load.carrying, self.stretches(&first, load.carrying))
            {
                bending.set_load(load.force_n, Some(reach_m));
            } else {
                bending = self.bend_for_tips(load)?;
                done(Stage::Stress);
            }
            ledger.available_j = ledger
                .available_j
                .max(bending.energy_j().min(hit.contact.plate_energy_j));
            let back = bending.face(Face::Back);
            if k == 0 {
                tips = self.start_radials(hit, &back, *from_s, ledger, &mut rng);
                if tips.is_empty() {
                    break;
                }
            }
            for tip in tips.iter_mut().filter(|tip| tip.state == TipState::Alive) {
                tip.time_s = tip.time_s.max(*from_s);
            }
            let is_last = k + 1 == windows.len();
            let until_s = if is_last { f64::INFINITY } else { *until_s };
            trace(
                &mut self.web,
                &mut tips,
                &back,
                &tracing,
                ledger,
                self.seed,
                until_s,
            );
            done(Stage::Tips);
            if tips.iter().all(|tip| tip.state != TipState::Alive) {
                break;
            }
        }
        Ok(tips)
    }

    /// The bending that drives the tips of a hit: that of the pane with the cracks of earlier hits.
    ///
    /// A crack's own faces need not be in it: K of a crack is that of the stress which the body
    /// without the crack has along its line \[Bueckner1958\].
    fn bend_for_tips(&mut self, load: &Load) -> Result<Bending, FractureError> {
        let earlier = self.cracks_near(load, self.n_older);
        if earlier.is_empty() {
            self.plates.bend(load)
        } else {
            self.plates.bend_around(load, &earlier)
        }
    }

    fn has_older_near(&self, load: &Load) -> bool {
        !self.cracks_near(load, self.n_older).is_empty()
    }

    /// Chains of those of the first `count` cracks through the pane that the bending of a load
    /// reaches.
    fn cracks_near(&self, load: &Load, count: u32) -> Vec<Vec<[f64; 2]>> {
        let reach = match load.carrying {
            Carrying::Foundation { length_m } => 6.0 * length_m,
            Carrying::Wave { reach_m } => reach_m,
            Carrying::Rim => f64::INFINITY,
        };
        let is_near = |node: u32| {
            let [x, y] = self.web.nodes[node as usize];
            libm::hypot(x - load.center_m[0], y - load.center_m[1]) < reach
        };
        self.web.chains(|piece| {
            piece.crack < count
                && piece.kind != SegmentKind::Cone
                && (is_near(piece.a) || is_near(piece.b))
        })
    }

    fn start_radials(
        &mut self,
        hit: &Hit<'_>,
        back: &dyn StressField,
        from_s: f64,
        ledger: &mut Ledger,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Tip> {
        let stone = hit.stone;
        let center = stone.position_m;
        let h = self.pane.thickness_m;
        let start_m = hit
            .contact
            .contact_radius_m
            .max(hit.contact.crushed_radius_m)
            .max(0.5 * h);
        let hoop = |angle: f64| {
            let [cos, sin] = unit(angle);
            let point = [center[0] + start_m * cos, center[1] + start_m * sin];
            back.stress_at(point, &mut 0)
                .map_or(0.0, |stress| stress.normal_pa([-sin, cos]))
        };
        let modulus = self.params.weibull_modulus;
        let mean = mean_radial_count(
            &self.pane.material,
            h,
            stone.normal_speed_m_s(),
            self.params.radial_count_factor,
        );
        let count = draw_count(mean, rng);
        let mut angles = draw_angles(count, modulus, hoop, rng);
        cull(&mut angles, &hit.law, start_m, hoop);
        let node = self.web.add_node(center);
        let mut tips = Vec::with_capacity(angles.len());
        for angle in angles {
            let direction = unit(angle);
            // The flaws that open lie at different distances, and open one after the other.
            let start_m = start_m * libm::exp(START_SCATTER * normal(rng));
            let end = [
                center[0] + direction[0] * start_m,
                center[1] + direction[1] * start_m,
            ];
            if self.pane.outline.depth_m(end) <= 0.0 {
                continue;
            }
            let stress_pa = hoop(angle);
            let effective_m = start_m.min(h);
            let intensity = hit.law.intensity(stress_pa, effective_m);
            let speed = hit.law.speed_m_s(intensity).max(0.1 * hit.law.rayleigh_m_s);
            let cost = hit.law.fracture_energy_j_m2 * h * start_m;
            if !ledger.pay(cost) {
                break;
            }
            let mut tip = Tip::new(
                &mut self.web,
                self.seed,
                SegmentKind::Radial,
                node,
                direction,
                start_m,
                from_s + start_m / speed,
            );
            let tip_node = self.web.add_node(end);
            self.web.add_piece(Piece {
                a: node,
                b: tip_node,
                crack: tip.crack,
                kind: SegmentKind::Radial,
                time_s: [from_s, tip.time_s],
                along_m: [0.0, start_m],
                stress_pa,
                intensity_pa_sqrt_m: intensity,
                effective_m,
                tilt_rad: tip.tilt_rad,
            });
            tip.node = tip_node;
            tip.at_m = end;
            tip.along_m = start_m;
            tips.push(tip);
        }
        tips
    }

    /// Rings in the sectors between radials, after them in time.
    fn rings(
        &mut self,
        hit: &Hit<'_>,
        windows: &[Window],
        tips: &[Tip],
        first_piece: usize,
        ledger: &mut Ledger,
    ) -> Result<(), FractureError> {
        let sectors = self.sectors(hit, tips, first_piece);
        if sectors.is_empty() {
            return Ok(());
        }
        let mut taken: Vec<Vec<f64>> = vec![Vec::new(); sectors.len()];
        let mut rng = self.seed.stream(Stream::Rings, hit.k);
        let law = TipLaw::new(&self.pane.material, self.pane.thickness_m, true);
        // On a foundation the plate is at its highest load; without one at some times of the wave.
        let is_steady = matches!(windows[0].load.carrying, Carrying::Foundation { .. });
        let n_solved = self.params.epochs as usize;
        let loads: Vec<Window> = if is_steady {
            vec![windows[windows.len() - 1]; n_solved - 1]
        } else {
            let stride = windows.len().div_ceil(n_solved);
            windows.iter().step_by(stride).copied().collect()
        };
        let length_m = match windows[0].load.carrying {
            Carrying::Foundation { length_m } => length_m,
            Carrying::Wave { .. } | Carrying::Rim => self.pane.thickness_m,
        };
        let strength_pa = self.strength_of_area_pa(length_m * length_m);
        for (pass, epoch) in loads.iter().enumerate() {
            if pass == 0 || !is_steady {
                // Bending between free radial cuts is at most some times that of the whole plate.
                let intact = self.plates.bend(&epoch.load)?;
                if !may_ring(&intact.face(Face::Front), &sectors, strength_pa) {
                    if is_steady {
                        break;
                    }
                    continue;
                }
            }
            let cracks = self.cracks_near(&epoch.load, self.web.n_cracks());
            let bending = self.plates.bend_around(&epoch.load, &cracks)?;
            let front = bending.face(Face::Front);
            let mut has_broken = false;
            for (sector, taken) in sectors.iter().zip(&mut taken) {
                let mut rings = Rings {
                    web: &mut self.web,
                    front: &front,
                    law,
                    strength_pa,
                    weibull_modulus: self.params.weibull_modulus,
                    ledger,
                    from_s: epoch.from_s,
                };
                has_broken |= rings.break_sector(sector, taken, &mut rng);
            }
            if is_steady && !has_broken {
                break;
            }
        }
        Ok(())
    }

    /// Sectors between neighboring radials of this hit.
    fn sectors(&self, hit: &Hit<'_>, tips: &[Tip], first_piece: usize) -> Vec<Sector> {
        let center = hit.stone.position_m;
        let pieces = &self.web.pieces[first_piece..];
        let polar = |node: u32| {
            let [x, y] = self.web.nodes[node as usize];
            let (dx, dy) = (x - center[0], y - center[1]);
            (libm::atan2(dy, dx), libm::hypot(dx, dy))
        };
        let mut arms: Vec<(f64, u32, f64)> = tips
            .iter()
            .filter(|tip| tip.kind == SegmentKind::Radial)
            .filter_map(|tip| {
                let own = pieces.iter().filter(|piece| piece.crack == tip.crack);
                let reach = own
                    .clone()
                    .map(|piece| polar(piece.b).1)
                    .fold(0.0, f64::max);
                let angle = own.map(|piece| polar(piece.b).0).next()?;
                Some((angle, tip.crack, reach))
            })
            .collect();
        arms.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let low = 1.3
            * hit
                .contact
                .contact_radius_m
                .max(hit.contact.crushed_radius_m)
                .max(0.5 * self.pane.thickness_m);
        (0..arms.len())
            .filter(|_| arms.len() > 2)
            .map(|k| {
                let (left, right) = (arms[k], arms[(k + 1) % arms.len()]);
                Sector {
                    center_m: center,
                    angles_rad: [left.0, right.0],
                    cracks: [left.1, right.1],
                    radii_m: [low, left.2.min(right.2)],
                }
            })
            .collect()
    }

    /// The Hertzian cone where it shows: as a circle or an arc on the far face.
    fn cone(&mut self, hit: &Hit<'_>) {
        let h = self.pane.thickness_m;
        let ring = (hit.cone.ring_radius_m, 0.05 * h);
        let circles = match hit.cone.outcome {
            ConeOutcome::None => return,
            ConeOutcome::Ring => vec![ring],
            ConeOutcome::Partial {
                depth_m,
                base_radius_m,
            } => vec![ring, (base_radius_m, depth_m)],
            ConeOutcome::Through {
                bottom_radius_m, ..
            } => vec![ring, (bottom_radius_m, h)],
        };
        for circle in circles {
            self.circle(hit, circle);
        }
    }

    /// A circle or an arc of a cone's trace, of a radius and a depth, m.
    fn circle(&mut self, hit: &Hit<'_>, (radius_m, depth_m): (f64, f64)) {
        let h = self.pane.thickness_m;
        let mut rng = self.seed.stream(Stream::StoneFlaws, (2 << 32) | hit.k);
        // Cones are round to a few percent: low harmonics of the radius.
        let harmonics: Vec<[f64; 3]> = (2_u8..6)
            .map(|n| {
                let n = f64::from(n);
                [n, 0.03 / n * normal(&mut rng), 2.0 * PI * uniform(&mut rng)]
            })
            .collect();
        let n_steps = 96_u32;
        let arc = hit.cone.arc_rad;
        let is_closed = arc > 2.0 * PI - 1e-9;
        let center = hit.stone.position_m;
        let place = |k: u32| {
            let angle = hit.cone.arc_center_rad + arc * (f64::from(k) / f64::from(n_steps) - 0.5);
            let swell: f64 = harmonics
                .iter()
                .map(|[n, size, phase]| size * libm::cos(n * angle + phase))
                .sum();
            let [cos, sin] = unit(angle);
            let radius = radius_m * (1.0 + swell);
            [center[0] + radius * cos, center[1] + radius * sin]
        };
        // It opens as the force peaks, over its depth at the speed of a running crack.
        let time_s = hit.start_s + hit.peak_s;
        let end_s = time_s + radius_m / crate::tips::TERMINAL_SPEED_M_S;
        let crack = self.web.new_crack();
        let intensity = 1.2 * hit.law.toughness_pa_sqrt_m;
        let mut nodes: Vec<Option<u32>> = Vec::new();
        for k in 0..=n_steps {
            let node = if is_closed && k == n_steps {
                nodes[0]
            } else {
                let point = place(k);
                (self.pane.outline.depth_m(point) > 0.0).then(|| self.web.add_node(point))
            };
            nodes.push(node);
        }
        for pair in nodes.windows(2) {
            let (Some(a), Some(b)) = (pair[0], pair[1]) else {
                continue;
            };
            self.web.add_piece(Piece {
                a,
                b,
                crack,
                kind: SegmentKind::Cone,
                time_s: [time_s, end_s],
                along_m: [0.0, depth_m],
                stress_pa: hit.law.toughness_pa_sqrt_m / (PI * h).sqrt(),
                intensity_pa_sqrt_m: intensity,
                effective_m: h,
                tilt_rad: CONE_TILT_RAD,
            });
        }
    }

    /// Radial cracks that reach, with their forks, as far as a glazier would count.
    fn n_legs(&self, hit: &Hit<'_>, tips: &[Tip], first_piece: usize, reach_m: f64) -> usize {
        let [x, y] = hit.stone.position_m;
        let own = &self.web.pieces[first_piece..];
        let reaches = |tip: &&Tip| {
            let pieces = own.iter().filter(|piece| piece.crack == tip.crack);
            let far = |piece: &Piece| {
                let at = self.web.nodes[piece.b as usize];
                libm::hypot(at[0] - x, at[1] - y)
            };
            let farthest = pieces.map(far).fold(0.0, f64::max);
            tip.state == TipState::Forked || farthest >= LEG_PART * reach_m
        };
        let radials = tips.iter().filter(|tip| tip.kind == SegmentKind::Radial);
        radials.filter(reaches).count()
    }

    fn report(
        &self,
        hit: &Hit<'_>,
        tips: &[Tip],
        first_piece: usize,
        ledger: &Ledger,
    ) -> ImpactReport {
        let center = hit.stone.position_m;
        let own = &self.web.pieces[first_piece..];
        let reach_m = own
            .iter()
            .map(|piece| {
                let [x, y] = self.web.nodes[piece.b as usize];
                libm::hypot(x - center[0], y - center[1])
            })
            .fold(0.0, f64::max);
        let n_arms = tips
            .iter()
            .filter(|tip| tip.kind == SegmentKind::Radial)
            .count();
        let n_legs = self.n_legs(hit, tips, first_piece, reach_m);
        let h = self.pane.thickness_m;
        let cone_depth_m = self.cone_depth_m(hit);
        let has_cone = cone_depth_m >= VISIBLE_CONE * h;
        let meets_rim = tips
            .iter()
            .any(|tip| self.pane.outline.depth_m(tip.at_m) <= 1e-6);
        let is_marked = hit.contact.crushed_radius_m > 0.0 || hit.cone.outcome != ConeOutcome::None;
        let damage = if self.is_diced {
            DamageClass::AlreadyDiced
        } else if n_arms > 0 && meets_rim {
            DamageClass::RimToImpact
        } else if n_arms > 0 && reach_m > LONG_CRACK_M {
            DamageClass::LongCrack
        } else if n_arms > 0 && has_cone {
            DamageClass::Combination
        } else if n_arms > 0 {
            DamageClass::Star
        } else if has_cone && hit.cone.arc_rad > 2.0 * PI - 1e-9 {
            DamageClass::Bullseye
        } else if has_cone {
            DamageClass::HalfMoon
        } else if is_marked {
            DamageClass::Pit
        } else {
            DamageClass::Intact
        };
        ImpactReport {
            position_m: center,
            time_s: hit.start_s,
            damage,
            kinetic_energy_j: hit.stone.kinetic_energy_j(),
            peak_force_n: hit.contact.peak_force_n,
            contact_time_s: hit.contact.contact_time_s,
            contact_radius_m: hit.contact.contact_radius_m,
            crushed_radius_m: hit.contact.crushed_radius_m,
            n_arms,
            n_legs,
            reach_m,
            available_j: ledger.available_j,
            dissipated_j: ledger.dissipated_j,
        }
    }
}

/// A cone leans by 68° from the normal of the pane: 22° to its surface \[FrankLawn1967\].
const CONE_TILT_RAD: f64 = 68.0 * PI / 180.0;

/// Between free radial cuts the face bends at most this much more than in the whole plate.
const SECTOR_GAIN: f64 = 4.0;

/// Whether some sector may break at all, by the bending of the whole plate.
fn may_ring(front: &dyn StressField, sectors: &[Sector], strength_pa: f64) -> bool {
    sectors.iter().any(|sector| {
        let [low, high] = sector.radii_m;
        let direction = unit(sector.angles_rad[0]);
        (0..=16_u8).any(|k| {
            let radius = low + (high - low).max(0.0) * f64::from(k) / 16.0;
            let point = [
                sector.center_m[0] + direction[0] * radius,
                sector.center_m[1] + direction[1] * radius,
            ];
            let stress = front.stress_at(point, &mut 0).unwrap_or_default();
            let radial = stress.normal_pa(direction).abs();
            let hoop = stress.normal_pa([-direction[1], direction[0]]).abs();
            SECTOR_GAIN * radial.max(hoop) > strength_pa
        })
    })
}
