//! The sectors between radial cracks, and when they are looked at for rings.

use starbreak_glass::SegmentKind;
use starbreak_seed::Stream;

use super::impact::{Breaking, Hit};
use super::plate::Carrying;
use super::rings::{Rings, Sector};
use super::windows::Window;
use crate::FractureError;
use crate::stress::{Face, StressField};
use crate::tips::{Ledger, Tip, TipLaw, unit};

/// Least radius of a ring over thickness and contact radius.
const RING_LEAST_RADIUS: f64 = 1.5;

/// Between free radial cuts the face bends at most this much more than in the whole plate.
const SECTOR_GAIN: f64 = 4.0;

impl Breaking<'_> {
    /// Rings in the sectors between radials, after them in time.
    pub(super) fn rings(
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
            vec![windows[windows.len() - 1]; n_solved / 2]
        } else {
            let stride = windows.len().div_ceil(n_solved.div_ceil(2));
            windows.iter().step_by(stride).copied().collect()
        };
        let length_m = match windows[0].load.carrying {
            Carrying::Foundation { length_m } => length_m,
            Carrying::Wave { .. } | Carrying::Rim => self.pane.thickness_m,
        };
        let strength_pa = self.strength_of_area_pa(length_m * length_m);
        for (pass, epoch) in loads.iter().enumerate() {
            // Rings of later loads come later, when nothing counts any more.
            if !is_steady && epoch.from_s > self.ends_s(hit) {
                break;
            }
            let is_free = self
                .plates
                .is_free(epoch.load.center_m, epoch.load.carrying);
            if is_free && (pass == 0 || !is_steady) {
                // A look that costs little: between free radial cuts the plate bends at most some
                // times as much as the whole.
                let intact = self.plates.bend(&epoch.load)?;
                if !may_ring(&intact.face(Face::Front), &sectors, strength_pa) {
                    if is_steady {
                        break;
                    }
                    continue;
                }
            }
            // What is not looked at is not solved for; once there is no room, there is none later.
            let mut of_all = sectors.iter().zip(&taken);
            let has_room = of_all.any(|(sector, taken)| sector.has_room(taken, law.thickness_m));
            if !has_room {
                break;
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
                    seed: self.seed,
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
    pub(super) fn sectors(&self, hit: &Hit<'_>, tips: &[Tip], first_piece: usize) -> Vec<Sector> {
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
        // Nearer to the load than its thickness a plate does not bend as a plate.
        let low = RING_LEAST_RADIUS
            * hit
                .contact
                .contact_radius_m
                .max(hit.contact.crushed_radius_m)
                .max(self.pane.thickness_m);
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
}

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
