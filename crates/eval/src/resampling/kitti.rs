//! The same for the average precisions of KITTI.

use super::drawn::{DrawnPrecisions, Sides};
use super::ranked::{N_SIDE_BY_SIDE, Ranked, SideBySide};
use super::{PairedPrecisions, Plan};
use crate::{EvalError, KittiRanking};

/// Recalls over which KITTI averages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KittiRecalls {
    /// 0, 0.1, … 1.
    R11,
    /// 1/40 to 1.
    R40,
}

struct Averaged {
    place: u32,
    ranking: KittiRanking,
    recalls: KittiRecalls,
}

impl Ranked for Averaged {
    fn category(&self) -> u32 {
        self.place
    }

    fn objects(&self) -> &[(u32, u32)] {
        self.ranking.objects()
    }

    fn average_precisions(&self, weights: &SideBySide) -> [Option<f64>; N_SIDE_BY_SIDE] {
        std::array::from_fn(|draw| self.average_precision(&weights.of_draw(draw)))
    }
}

impl Averaged {
    fn average_precision(&self, weights: &[u32]) -> Option<f64> {
        if weights.len() < self.ranking.n_cells() {
            return None;
        }
        let curve = self.ranking.curve(weights);
        let percent = match self.recalls {
            KittiRecalls::R11 => curve.ap11(),
            KittiRecalls::R40 => curve.ap40(),
        };
        (curve.n_gt > 0 && percent.is_finite()).then_some(percent / 100.0)
    }
}

/// KITTI's average precision per ranking, clean and cracked, with intervals and tests as those of
/// [`paired_average_precision`](super::paired_average_precision); each replicate is the benchmark's
/// own curve of the drawn frames. Both hold the same classes and difficulties in the same order, of
/// the same frames, which are the images of the plan; categories are their places.
///
/// # Errors
/// [`EvalError::StatisticLength`] if they do not;
/// [`EvalError::StatisticSetting`] for a plan without replicates or proper level.
pub fn paired_kitti_precision(
    clean: &[KittiRanking],
    cracked: &[KittiRanking],
    recalls: KittiRecalls,
    plan: &Plan,
) -> Result<PairedPrecisions, EvalError> {
    plan.check()?;
    let lengths = ("damaged rankings", cracked.len(), clean.len(), "clean ones");
    let n_images = plan.n_images();
    let of_frames = clean.iter().chain(cracked);
    let frames = of_frames.map(|it| ("frames", it.n_cells(), n_images, "images of the plan"));
    for (what, found, expected, of) in std::iter::once(lengths).chain(frames) {
        if found != expected {
            return Err(EvalError::StatisticLength {
                what,
                found,
                expected,
                of,
            });
        }
    }
    let averaged = |rankings: Vec<KittiRanking>| -> Vec<Averaged> {
        let places = rankings.into_iter().zip(0..);
        places
            .map(|(ranking, place)| Averaged {
                place,
                ranking,
                recalls,
            })
            .collect()
    };
    let both = clean.iter().zip(cracked);
    let crossed = both.filter_map(|(clean, cracked)| KittiRanking::crossed(&[clean, cracked]));
    let sides = Sides {
        clean: averaged(clean.to_vec()),
        cracked: averaged(cracked.to_vec()),
        both: averaged(crossed.collect()),
    };
    DrawnPrecisions::of(&sides, plan).measured(plan)
}
