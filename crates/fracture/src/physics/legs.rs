//! Radial cracks and their forks, traced through the bending plate.

use rand_chacha::ChaCha8Rng;
use starbreak_glass::SegmentKind;
use starbreak_seed::normal;

use super::impact::{Breaking, Hit};
use super::outcome::Stage;
use super::plate::Carrying;
use super::radials::{cull, draw_angles, draw_count, mean_radial_count};
use super::windows::{Opening, Window};
use crate::FractureError;
use crate::stress::{Face, StressField};
use crate::tips::{COMPETITION, Ledger, Motion, Piece, Tip, TipState, Tracing, trace, unit};

/// Scatter of the distances at which radials start, standard deviation of the logarithm. FIT: legs of
/// real stars differ by a factor of two.
const START_SCATTER: f64 = 0.2;

impl Breaking<'_> {
    /// Radial cracks and their forks.
    pub(super) fn radials(
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
            rng,
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
            if tips.is_empty() {
                // A weak flaw opens before the force can drive a crack; then they start later.
                tips = self.start_radials(hit, &back, *from_s, ledger, &mut rng.clone());
                if tips.is_empty() {
                    continue;
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

    pub(super) fn start_radials(
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
                (SegmentKind::Radial, None),
                node,
                direction,
                start_m,
                from_s + start_m / speed,
            );
            let tip_node = self.web.add_node(end);
            let tilt_rad = tip.tilt.wander(start_m / h);
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
                tilt_rad,
            });
            tip.node = tip_node;
            tip.at_m = end;
            tip.origin_m = center;
            tip.along_m = start_m;
            tips.push(tip);
        }
        tips
    }
}
