//! When the first flaw opens, and the loads that follow it in time.

use std::f64::consts::PI;

use rand_chacha::ChaCha8Rng;
use starbreak_glass::SegmentKind;
use starbreak_seed::Stream;

use super::impact::{Breaking, Hit};
use super::outcome::Stage;
use super::plate::{Bending, Carrying, Load};
use crate::FractureError;
use crate::draw::weibull_factor;
use crate::params::GlassBuild;
use crate::stress::{Face, StressField};

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

/// A load and the time in which it holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub(super) load: Load,
    pub(super) from_s: f64,
    pub(super) until_s: f64,
}

/// The first flaw opens.
pub(super) struct Opening {
    /// The highest load, as the plate carries it at that time.
    pub(super) load: Load,
    pub(super) bending: Bending,
    pub(super) time_s: f64,
    pub(super) force_n: f64,
    pub(super) rng: ChaCha8Rng,
}

impl Breaking<'_> {
    /// Strength of a small area, which has fewer flaws than that of a test: (A_test/A)^(1/m) times
    /// as much \[Weibull1939\].
    pub(super) fn strength_of_area_pa(&self, area_m2: f64) -> f64 {
        let exponent = 1.0 / self.params.weibull_modulus;
        self.params.strength_pa * libm::pow(TEST_AREA_M2 / area_m2, exponent)
    }

    /// The load at which the tension under the stone opens the weakest flaw there, `None` if it
    /// never does: Weibull's strength, and the compression of a tempered surface.
    pub(super) fn opening(
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
        let scatter = weibull_factor(self.params.weibull_modulus, &mut rng);
        let residual_pa = match self.pane.build {
            GlassBuild::Tempered {
                surface_compression_pa,
            } => surface_compression_pa,
            GlassBuild::Annealed | GlassBuild::Laminated { .. } => 0.0,
        };
        let area_m2 = PI * patch_radius_m * patch_radius_m;
        let strength_pa = self.strength_of_area_pa(area_m2) * scatter + residual_pa;
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
    pub(super) fn windows(&self, hit: &Hit<'_>, opening: &Opening) -> Vec<Window> {
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
    pub(super) fn stretches(&self, first: &Load, carrying: Carrying) -> bool {
        let is_free = |carrying| self.plates.is_free(first.center_m, carrying);
        let load = Load { carrying, ..*first };
        is_free(first.carrying) && is_free(carrying) && !self.has_older_near(&load)
    }

    /// The bending that drives the tips of a hit: that of the pane with the cracks of earlier hits.
    ///
    /// A crack's own faces need not be in it: K of a crack is that of the stress which the body
    /// without the crack has along its line \[Bueckner1958\].
    pub(super) fn bend_for_tips(&mut self, load: &Load) -> Result<Bending, FractureError> {
        let earlier = self.cracks_near(load, self.n_older);
        if earlier.is_empty() {
            self.plates.bend(load)
        } else {
            self.plates.bend_around(load, &earlier)
        }
    }

    pub(super) fn has_older_near(&self, load: &Load) -> bool {
        self.n_older > 0 && !self.cracks_near(load, self.n_older).is_empty()
    }

    /// Chains of those of the first `count` cracks through the pane that the bending of a load
    /// reaches.
    pub(super) fn cracks_near(&self, load: &Load, count: u32) -> Vec<Vec<[f64; 2]>> {
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
}
