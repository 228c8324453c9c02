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
    Ledger, Motion, Piece, Tip, TipLaw, TipState, Tracing, Web, normal, trace, unit,
};

/// A crack longer than this is not repaired: it is a class of its own, m \[ROLAGS\].
const LONG_CRACK_M: f64 = 0.152;

/// Scatter of the distances at which radials start, standard deviation of the logarithm. FIT: legs of
/// real stars differ by a factor of two.
const START_SCATTER: f64 = 0.2;

/// Area of a bending test of glass that the strength is measured on, m².
const TEST_AREA_M2: f64 = 2.5e-3;

/// Growth in time from one solution to the next while the bending wave spreads: its reach doubles.
const EPOCH_GROWTH: f64 = 4.0;

/// Depth over thickness at which the compression of tempered glass ends: (½ − 1/√12)
/// of a parabola.
const COMPRESSION_DEPTH: f64 = 0.211_324_865_405_187_1;

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
}

/// A load and until when it holds.
struct Epoch {
    load: Load,
    from_s: f64,
    until_s: f64,
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
        let peak_s = contact
            .history
            .iter()
            .fold([0.0, 0.0], |best, &[t, f]| if f > best[1] { [t, f] } else { best })[0];
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
        let mut ledger = Ledger {
            available_j: 0.0,
            dissipated_j: 0.0,
        };
        let mut tips = Vec::new();
        let mut has_burst = false;
        if self.dices && !self.is_diced {
            has_burst = self.bursts(&hit, done)?;
        } else if !self.is_diced {
            let epochs = self.epochs(&hit);
            tips = self.radials(&hit, &epochs, &mut ledger, done)?;
            if tips.len() > 2 {
                self.rings(&hit, &epochs, &tips, first_piece, &mut ledger)?;
                done(Stage::Rings);
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

    /// Whether a hit on tempered glass gets through the compression of its surfaces.
    fn bursts(&mut self, hit: &Hit<'_>, done: &mut impl FnMut(Stage)) -> Result<bool, FractureError> {
        if self.cone_depth_m(hit) > COMPRESSION_DEPTH * self.pane.thickness_m {
            return Ok(true);
        }
        let epochs = self.epochs(hit);
        let bending = self.plates.bend(&epochs[0].load)?;
        done(Stage::Stress);
        let mut rng = self.seed.stream(Stream::StoneFlaws, (1 << 32) | hit.k);
        Ok(self.opens_flaw(hit, &bending.face(Face::Back), &mut rng))
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

    /// Whether the tension under the load opens the weakest flaw there: Weibull's strength, and
    /// the compression of a tempered surface.
    fn opens_flaw(&self, hit: &Hit<'_>, back: &dyn StressField, rng: &mut ChaCha8Rng) -> bool {
        let peak = back
            .stress_at(hit.stone.position_m, &mut 0)
            .map_or(0.0, |stress| stress.principal().0);
        let modulus = self.params.weibull_modulus;
        let scatter = libm::pow(-libm::log(1.0 - uniform(rng)), 1.0 / modulus);
        let residual = match self.pane.build {
            GlassBuild::Tempered {
                surface_compression_pa,
            } => surface_compression_pa,
            _ => 0.0,
        };
        let patch_m = self.plates.stiffness.patch_radius_m(hit.contact.contact_radius_m);
        let strength_pa = self.strength_of_area_pa(PI * patch_m * patch_m);
        peak >= strength_pa * scatter.clamp(0.5, 1.5) + residual
    }

    /// The loads of a hit in the order of time.
    fn epochs(&self, hit: &Hit<'_>) -> Vec<Epoch> {
        let center_m = hit.stone.position_m;
        let stiffness = &self.plates.stiffness;
        let patch_radius_m = stiffness.patch_radius_m(hit.contact.contact_radius_m);
        let load = |force_n, carrying| Load {
            center_m,
            patch_radius_m,
            force_n,
            carrying,
        };
        let from_s = hit.start_s + hit.peak_s;
        let contact_s = hit.contact.contact_time_s;
        let first = load(
            hit.contact.peak_force_n,
            self.plates.carrying(center_m, contact_s),
        );
        if let Carrying::Foundation { .. } = first.carrying {
            return vec![Epoch {
                load: first,
                from_s,
                until_s: f64::INFINITY,
            }];
        }
        let deflection_m = stiffness.deflection_m(hit.contact.impulse_n_s);
        let mut epochs = vec![Epoch {
            load: first,
            from_s,
            until_s: hit.start_s + contact_s.max(hit.peak_s),
        }];
        let mut time_s = contact_s;
        while u32::try_from(epochs.len()).is_ok_and(|n| n < self.params.epochs) {
            let last = &epochs[epochs.len() - 1];
            if matches!(last.load.carrying, Carrying::Rim) {
                break;
            }
            let from_s = last.until_s;
            time_s *= EPOCH_GROWTH;
            let force_n = stiffness.disc_force_n(deflection_m, stiffness.wave_reach_m(time_s));
            epochs.push(Epoch {
                load: load(force_n, self.plates.carrying(center_m, time_s)),
                from_s,
                until_s: hit.start_s + time_s,
            });
        }
        epochs
    }

    /// Radial cracks and their forks.
    fn radials(
        &mut self,
        hit: &Hit<'_>,
        epochs: &[Epoch],
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
            rim_shields: false,
        };
        for (k, epoch) in epochs.iter().enumerate() {
            let bending = self.bend_for_tips(&epoch.load)?;
            done(Stage::Stress);
            ledger.available_j = ledger
                .available_j
                .max(bending.energy_j.min(hit.contact.plate_energy_j));
            let back = bending.face(Face::Back);
            if k == 0 {
                tips = self.start_radials(hit, &back, epoch.from_s, ledger);
                if tips.is_empty() {
                    break;
                }
            }
            for tip in tips.iter_mut().filter(|tip| tip.state == TipState::Alive) {
                tip.time_s = tip.time_s.max(epoch.from_s);
            }
            let is_last = k + 1 == epochs.len();
            let until_s = if is_last { f64::INFINITY } else { epoch.until_s };
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
        let earlier = self.cracks_near(load);
        if earlier.is_empty() {
            self.plates.bend(load)
        } else {
            self.plates.bend_around(load, &earlier)
        }
    }

    /// Chains of the cracks through the pane that the bending of a load reaches.
    fn cracks_near(&self, load: &Load) -> Vec<Vec<[f64; 2]>> {
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
            piece.kind != SegmentKind::Cone && (is_near(piece.a) || is_near(piece.b))
        })
    }

    fn start_radials(
        &mut self,
        hit: &Hit<'_>,
        back: &dyn StressField,
        from_s: f64,
        ledger: &mut Ledger,
    ) -> Vec<Tip> {
        let stone = hit.stone;
        let center = stone.position_m;
        let h = self.pane.thickness_m;
        let start_m = hit
            .contact
            .contact_radius_m
            .max(hit.contact.crushed_radius_m)
            .max(0.5 * h);
        let mut rng = self.seed.stream(Stream::StoneFlaws, (1 << 32) | hit.k);
        let hoop = |angle: f64| {
            let [cos, sin] = unit(angle);
            let point = [center[0] + start_m * cos, center[1] + start_m * sin];
            back.stress_at(point, &mut 0)
                .map_or(0.0, |stress| stress.normal_pa([-sin, cos]))
        };
        if !self.opens_flaw(hit, back, &mut rng) {
            return Vec::new();
        }
        let modulus = self.params.weibull_modulus;
        let mean = mean_radial_count(
            &self.pane.material,
            h,
            stone.normal_speed_m_s(),
            self.params.radial_count_factor,
        );
        let count = draw_count(mean, &mut rng);
        let mut angles = draw_angles(count, modulus, hoop, &mut rng);
        cull(&mut angles, &hit.law, start_m, hoop);
        let node = self.web.add_node(center);
        let mut tips = Vec::with_capacity(angles.len());
        for angle in angles {
            let direction = unit(angle);
            // The flaws that open lie at different distances, and open one after the other.
            let start_m = start_m * libm::exp(START_SCATTER * normal(&mut rng));
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
            let speed = hit
                .law
                .speed_m_s(intensity)
                .max(0.1 * hit.law.rayleigh_m_s);
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
        epochs: &[Epoch],
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
        let is_steady = matches!(epochs[0].load.carrying, Carrying::Foundation { .. });
        let passes = if is_steady { self.params.epochs as usize - 1 } else { epochs.len() };
        let length_m = match epochs[0].load.carrying {
            Carrying::Foundation { length_m } => length_m,
            Carrying::Wave { .. } | Carrying::Rim => self.pane.thickness_m,
        };
        let strength_pa = self.strength_of_area_pa(length_m * length_m);
        for pass in 0..passes {
            let epoch = &epochs[if is_steady { 0 } else { pass }];
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
            let cracks = self.cracks_near(&epoch.load);
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
                let reach = own.clone().map(|piece| polar(piece.b).1).fold(0.0, f64::max);
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
        let (radius_m, depth_m) = match hit.cone.outcome {
            ConeOutcome::None => return,
            ConeOutcome::Ring => (hit.cone.ring_radius_m, 0.05 * h),
            ConeOutcome::Partial {
                depth_m,
                base_radius_m,
            } => (base_radius_m, depth_m),
            ConeOutcome::Through {
                bottom_radius_m, ..
            } => (bottom_radius_m, h),
        };
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

    fn report(
        &mut self,
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
