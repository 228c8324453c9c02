//! One hit, from contact to report.

use std::f64::consts::PI;

use starbreak_glass::{Seed, SegmentKind};

use super::outcome::{DamageClass, ImpactReport, Stage};
use super::params::{GlassPane, PhysicsParams, StoneImpact};
use super::plate::Plates;
use crate::FractureError;
use crate::contact::{ConeOutcome, ContactLoad, HertzianCrack, contact_load, hertzian_crack};
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
    pub(super) web: Web,
    pub(super) plates: Plates,
    /// Whether a crack anywhere sends the whole pane to pieces.
    pub(super) dices: bool,
    pub(super) is_diced: bool,
    /// Cracks that were there before the hit.
    pub(super) n_older: u32,
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
