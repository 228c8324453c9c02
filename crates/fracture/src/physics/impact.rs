//! One hit, from contact to report.

use std::f64::consts::PI;
use std::sync::Arc;

use starbreak_glass::SegmentKind;
use starbreak_seed::Seed;

use super::long_crack::{Driven, PaneStress, grow_long_crack};
use super::outcome::{DamageClass, ImpactReport, LongCrackReport, Stage};
use super::plate::Plates;
use crate::FractureError;
use crate::contact::{ConeOutcome, ContactLoad, HertzianCrack, contact_load, hertzian_crack};
use crate::params::{GlassPane, LongCrack, LongCrackOrigin, PhysicsParams, StoneImpact};
use crate::tips::{Ledger, MAX_STEPS, Piece, Tip, TipLaw, TipState, Web};

/// A crack longer than this is not repaired: it is a class of its own, m \[ROLAGS\].
const LONG_CRACK_M: f64 = 0.152;

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
    /// Cracks of the sheet that is hit, of a laminate the outer ply.
    pub(super) web: Web,
    /// Cracks of the inner ply, once a heavy body has broken it.
    pub(super) inner: Option<Web>,
    pub(super) plates: Plates,
    /// Stress in the plane, once it is known.
    pub(super) in_plane: Option<Arc<PaneStress>>,
    /// What it has done.
    pub(super) driven: Option<Driven>,
    /// Whether a crack anywhere sends the whole pane to pieces.
    pub(super) dices: bool,
    pub(super) is_diced: bool,
    /// Cracks that were there before the hit.
    pub(super) n_older: u32,
}

/// What decides the class of a hit.
pub(super) struct Facts {
    pub(super) has_legs: bool,
    pub(super) has_cone: bool,
    /// Whether the cone closes around the contact.
    pub(super) is_closed: bool,
    /// Whether the glass is crushed, or has a ring.
    pub(super) is_marked: bool,
    pub(super) meets_rim: bool,
    pub(super) reach_m: f64,
}

impl Facts {
    pub(super) fn class(&self) -> DamageClass {
        match (self.has_legs, self.has_cone) {
            (true, _) if self.meets_rim => DamageClass::RimToImpact,
            (true, _) if self.reach_m > LONG_CRACK_M => DamageClass::LongCrack,
            (true, true) => DamageClass::Combination,
            (true, false) => DamageClass::Star,
            (false, true) if self.is_closed => DamageClass::Bullseye,
            (false, true) => DamageClass::HalfMoon,
            (false, false) if self.is_marked => DamageClass::Pit,
            (false, false) => DamageClass::Intact,
        }
    }
}

/// What a hit has at hand.
pub(super) struct Hit<'a> {
    pub(super) stone: &'a StoneImpact,
    pub(super) contact: ContactLoad,
    pub(super) cone: HertzianCrack,
    pub(super) law: TipLaw,
    /// Number of the hit.
    pub(super) k: u64,
    /// When the stone touches, s.
    pub(super) start_s: f64,
    /// When the force is highest, s after the touch.
    pub(super) peak_s: f64,
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
            steps_left: MAX_STEPS,
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

    pub(super) fn cone_depth_m(&self, hit: &Hit<'_>) -> f64 {
        match hit.cone.outcome {
            ConeOutcome::None | ConeOutcome::Ring => 0.0,
            ConeOutcome::Partial { depth_m, .. } => depth_m,
            ConeOutcome::Through { .. } => self.pane.thickness_m,
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
        let facts = Facts {
            has_legs: n_arms > 0,
            has_cone,
            is_closed: hit.cone.arc_rad > 2.0 * PI - 1e-9,
            is_marked,
            meets_rim,
            reach_m,
        };
        let damage = if self.is_diced {
            DamageClass::AlreadyDiced
        } else {
            facts.class()
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

    /// The class and the reach of a hit whose cracks have been cut or have gone on: of the cracks
    /// that start at it, and of those that grew out of them.
    pub(super) fn reclassify(&self, center_m: [f64; 2], report: &mut ImpactReport) {
        if matches!(
            report.damage,
            DamageClass::Diced | DamageClass::AlreadyDiced
        ) {
            return;
        }
        let was = report.damage;
        let at = |node: u32| self.web.nodes[node as usize];
        let far = |node: u32| {
            let [x, y] = at(node);
            libm::hypot(x - center_m[0], y - center_m[1])
        };
        let starts_here = |piece: &Piece| piece.kind == SegmentKind::Radial && far(piece.a) <= 1e-9;
        let is_own = self.web.grown_from(starts_here);
        let mut own = self
            .web
            .pieces
            .iter()
            .filter(|piece| is_own[piece.crack as usize]);
        let legs_m = own.clone().map(|piece| far(piece.b)).fold(0.0, f64::max);
        let is_closed = was != DamageClass::HalfMoon;
        report.damage = Facts {
            has_legs: legs_m > 0.0,
            has_cone: matches!(
                was,
                DamageClass::Bullseye | DamageClass::HalfMoon | DamageClass::Combination
            ),
            is_closed,
            is_marked: was != DamageClass::Intact,
            meets_rim: own.any(|piece| self.pane.outline.depth_m(at(piece.b)) <= 1e-6),
            reach_m: legs_m,
        }
        .class();
        if legs_m > 0.0 {
            report.reach_m = legs_m;
        }
    }

    /// The cracks of each ply.
    pub(super) fn webs(&self) -> impl Iterator<Item = &Web> {
        std::iter::once(&self.web).chain(&self.inner)
    }

    /// The moment at which a crack gets so far from a place, s; infinity where none does.
    pub(super) fn reaches_s(&self, center_m: [f64; 2], reach_m: f64) -> f64 {
        let passes = |web: &Web, piece: &Piece| {
            let [from_m, to_m] = [piece.a, piece.b].map(|node| {
                let [x, y] = web.nodes[node as usize];
                libm::hypot(x - center_m[0], y - center_m[1])
            });
            let [from_s, to_s] = piece.time_s;
            if from_m >= reach_m {
                Some(from_s)
            } else if to_m >= reach_m {
                let part = (reach_m - from_m) / (to_m - from_m);
                Some(from_s + part * (to_s - from_s))
            } else {
                None
            }
        };
        self.webs()
            .flat_map(|web| web.pieces.iter().filter_map(|piece| passes(web, piece)))
            .fold(f64::INFINITY, f64::min)
    }

    /// The moment, so far, after which nothing counts, s: the first hit has got as far as it shall.
    pub(super) fn ends_s(&self, hit: &Hit<'_>) -> f64 {
        match self.params.until_reach_m {
            Some(reach_m) if hit.k == 0 => self.reaches_s(hit.stone.position_m, reach_m),
            _ => f64::INFINITY,
        }
    }

    /// Stress in the plane of the pane, if there is any, from a moment on.
    pub(super) fn grow(
        &mut self,
        load: Option<&LongCrack>,
        after_s: f64,
    ) -> Result<(), FractureError> {
        let Some(load) = load.filter(|_| !self.is_diced) else {
            return Ok(());
        };
        let field = match &self.in_plane {
            Some(field) => Arc::clone(field),
            None => {
                let field = PaneStress::of(self.pane, &load.load, self.params.mesh)?;
                Arc::clone(self.in_plane.insert(field))
            }
        };
        let n_older = self.n_older;
        let web = &mut self.web;
        let more = grow_long_crack(web, self.pane, (load, &field), n_older, self.seed, after_s);
        self.driven = Some(self.driven.map_or(more, |before| before.and(more)));
        Ok(())
    }

    /// What the cracks that stress in the plane drove have come to, after all that happened to them.
    pub(super) fn long_report(
        &self,
        load: &LongCrack,
        hits: &[ImpactReport],
    ) -> Option<LongCrackReport> {
        let done = self.driven?;
        let is_driven = self.web.grown_from(|piece| piece.kind == SegmentKind::Edge);
        let driven = self
            .web
            .pieces
            .iter()
            .filter(|piece| is_driven[piece.crack as usize]);
        let length_m: f64 = driven
            .clone()
            .map(|piece| piece.along_m[1] - piece.along_m[0])
            .sum();
        let meets_rim = driven
            .map(|piece| self.web.nodes[piece.b as usize])
            .any(|at| self.pane.outline.depth_m(at) <= 1e-6);
        let class = match load.origin {
            _ if length_m <= 0.0 => DamageClass::Intact.name(),
            LongCrackOrigin::Rim if load.load.frame_tension_pa <= 0.0 => "stress-crack",
            LongCrackOrigin::Rim => "edge-crack",
            LongCrackOrigin::Impact if meets_rim => "long-crack",
            LongCrackOrigin::Impact => "floater-crack",
            LongCrackOrigin::Legs => ImpactReport::worst(hits).unwrap_or("intact"),
        };
        Some(done.report(class, length_m))
    }
}
