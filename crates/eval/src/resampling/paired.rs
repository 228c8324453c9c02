//! Average precision of clean and cracked images with all that is known about its difference.

use serde::{Deserialize, Serialize};

use super::ranked::{Ranked, rank_by_category, rank_versions};
use super::{Basis, Permuted, Plan, RankedCategory, Replicates, bootstrap, permutation_test};
use crate::EvalError;
use crate::matching::ImageMatches;
use crate::statistic::{Measured, Method, TestOutcome};

/// Average precision of one category, or the mean over categories, clean and cracked; of several
/// seeds the mean over them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairedPrecision {
    /// Place of the category in [`LabelSet::categories`](crate::LabelSet::categories); `None` for
    /// the mean over those that have objects.
    pub category: Option<u32>,
    /// In the clean images, 0 to 1. The n of all three are the units drawn: images or clusters.
    pub clean: Measured,
    /// In the cracked images.
    pub cracked: Measured,
    /// Cracked minus clean.
    pub difference: Measured,
    /// Permutation test of the difference.
    pub test: TestOutcome,
}

/// All categories and their mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairedPrecisions {
    /// One per category, in the order of the label set.
    pub categories: Vec<PairedPrecision>,
    /// The mean over categories with objects.
    pub mean: PairedPrecision,
    /// How often images were drawn.
    pub n_replicates: u32,
    /// From which seed.
    pub seed: u64,
}

/// Values per category in the bootstrap: clean, cracked, difference.
const N_VALUES: usize = 3;

/// Average precision per category, clean and cracked, with intervals of both and of their
/// difference from the bootstrap, and a permutation test per category.
///
/// Of each seed of the cracks, `clean` are the matches of the clean images and `cracked` those of
/// the same images behind the cracks, all by the same rule; in a region, what counts in the clean
/// images depends on the seed, too. A value is the mean over the seeds: ranking the images of all
/// seeds together gives another number, since the scores of clean copies tie and those of cracked
/// ones interleave. Images are drawn, and exchanged, with all their seeds.
///
/// Replicates use the matches as they are, which is exact: matching never crosses images.
/// The interval of a difference reaches as far as permutations do from 0, so that it and the test say the same
/// ([`Permuted`]). Those of either side are [`expanded`](super::expanded_interval): of a class by the
/// units that its objects lie in, of the mean over classes by all units and the harmonic mean of the
/// classes' own, since drawn images are fewer; and lower by what AP of few images leans to above, as halves of
/// the images tell.
///
/// # Errors
/// If both sides have not as many seeds, or none; if an image is beyond those of the plan, or the
/// plan has no replicates or no proper level.
pub fn paired_average_precision(
    clean: &[&[ImageMatches]],
    cracked: &[&[ImageMatches]],
    n_categories: usize,
    plan: &Plan,
) -> Result<PairedPrecisions, EvalError> {
    plan.check()?;
    if clean.len() != cracked.len() || clean.is_empty() {
        return Err(EvalError::StatisticLength {
            what: "sets of damaged matches",
            found: cracked.len(),
            expected: clean.len().max(1),
            of: "sets of clean matches",
        });
    }
    let sides: Result<Vec<Sides<RankedCategory>>, EvalError> = clean
        .iter()
        .zip(cracked)
        .map(|(clean, cracked)| {
            check_images(&[clean, cracked], plan)?;
            Ok(Sides {
                clean: rank_by_category(clean, n_categories),
                cracked: rank_by_category(cracked, n_categories),
                both: rank_versions(&[clean, cracked], n_categories),
            })
        })
        .collect();
    paired_of_ranked(&sides?, plan)
}

/// What is ranked of one seed, by category.
pub(super) struct Sides<R> {
    /// Over the images.
    pub(super) clean: Vec<R>,
    /// Over the images.
    pub(super) cracked: Vec<R>,
    /// Over cells, image times 2, plus 1 for the cracked one.
    pub(super) both: Vec<R>,
}

/// The same of anything that has an average precision, of one seed or more.
pub(super) fn paired_of_ranked<R: Ranked>(
    seeds: &[Sides<R>],
    plan: &Plan,
) -> Result<PairedPrecisions, EvalError> {
    let values = |weights: &[u32]| -> Vec<Option<f64>> {
        let pairs = mean_of_seeds(seeds.iter().map(|one| {
            let sides = one.clean.iter().zip(&one.cracked);
            sides.map(|(clean, cracked)| {
                let clean = clean.average_precision(weights);
                clean.zip(cracked.average_precision(weights))
            })
        }));
        pairs.into_iter().flat_map(three_values).collect()
    };
    let replicates = bootstrap(plan, values)?.leaning(plan, values);
    let tests = permutation_test(plan, |swaps| {
        let (as_clean, as_cracked) = role_weights(swaps);
        let pairs = mean_of_seeds(seeds.iter().map(|one| {
            one.both.iter().map(|both| {
                let clean = both.average_precision(&as_clean);
                clean.zip(both.average_precision(&as_cracked))
            })
        }));
        let difference = |pair: Option<(f64, f64)>| pair.map(|(clean, cracked)| cracked - clean);
        pairs.into_iter().map(difference).collect()
    })?;
    let first = seeds.first().map_or(&[][..], |one| one.clean.as_slice());
    let n_units = units_of_classes(first.len(), plan, |at| {
        let of_class = seeds.iter().filter_map(move |one| one.clean.get(at));
        of_class.flat_map(Ranked::cells_with_objects)
    });
    let mut rows = Vec::with_capacity(tests.len());
    for (at, test) in tests.into_iter().enumerate() {
        let category = first.get(at).map(Ranked::category);
        let side = match n_units.get(at) {
            Some(n) => Basis::Units(*n),
            None => Basis::of_classes(&n_units, plan),
        };
        rows.push(row(&replicates, at, category, side, test));
    }
    let mean = rows.pop().ok_or(EvalError::StatisticLength {
        what: "rankings",
        found: 0,
        expected: 1,
        of: "seeds",
    })?;
    Ok(PairedPrecisions {
        categories: rows,
        mean,
        n_replicates: plan.n_replicates,
        seed: plan.seed,
    })
}

fn row(
    replicates: &Replicates,
    at: usize,
    category: Option<u32>,
    side: Basis,
    Permuted { test, interval }: Permuted,
) -> PairedPrecision {
    let place = at * N_VALUES;
    PairedPrecision {
        category,
        clean: replicates.expanded(place, Method::AveragePrecision, side),
        cracked: replicates.expanded(place + 1, Method::AveragePrecision, side),
        difference: replicates.with_interval(place + 2, Method::Difference, side, interval),
        test,
    }
}

/// Mean over seeds of clean and cracked per category, and behind them of the mean over the
/// categories that a seed has; nothing where a seed has none.
fn mean_of_seeds<I>(seeds: impl Iterator<Item = I>) -> Vec<Option<(f64, f64)>>
where
    I: Iterator<Item = Option<(f64, f64)>>,
{
    let mut sums: Vec<Option<(f64, f64)>> = Vec::new();
    let mut n_seeds = 0.0;
    for seed in seeds {
        let mut of_seed: Vec<Option<(f64, f64)>> = seed.collect();
        let (mut mean, mut n) = ((0.0, 0.0), 0.0);
        for (clean, cracked) in of_seed.iter().flatten() {
            mean = (mean.0 + clean, mean.1 + cracked);
            n += 1.0;
        }
        of_seed.push((n > 0.0).then(|| (mean.0 / n, mean.1 / n)));
        n_seeds += 1.0;
        if sums.is_empty() {
            sums = of_seed;
            continue;
        }
        for (sum, one) in sums.iter_mut().zip(of_seed) {
            *sum = sum.zip(one).map(|(a, b)| (a.0 + b.0, a.1 + b.1));
        }
    }
    for sum in sums.iter_mut().flatten() {
        *sum = (sum.0 / n_seeds, sum.1 / n_seeds);
    }
    sums
}

/// In how many units each class has objects, by the images that it has them in.
pub(crate) fn units_of_classes<I: Iterator<Item = u32>>(
    n_classes: usize,
    plan: &Plan,
    images_of: impl Fn(usize) -> I,
) -> Vec<u32> {
    (0..n_classes)
        .map(|at| plan.units_of(images_of(at)))
        .collect()
}

/// Refuses images that the plan does not have, and more than cells can be counted.
fn check_images(sides: &[&[ImageMatches]], plan: &Plan) -> Result<(), EvalError> {
    let images = sides.iter().copied().flatten().map(|it| it.image);
    let n_needed = images.max().map_or(0, |image| image as usize + 1);
    if n_needed > plan.n_images() {
        return Err(EvalError::StatisticLength {
            what: "images with matches",
            found: n_needed,
            expected: plan.n_images(),
            of: "images of the plan",
        });
    }
    // Two cells per image and one bit more must fit 32 bits.
    if plan.n_images() >= 1 << 30 {
        return Err(EvalError::StatisticSetting {
            what: "number of images",
            value: plan.n_images() as f64,
            range: "below 2^30",
        });
    }
    Ok(())
}

/// Weights of the cells that play the clean and the cracked images.
pub(crate) fn role_weights(swaps: &[u32]) -> (Vec<u32>, Vec<u32>) {
    swaps
        .iter()
        .flat_map(|swap| [(1 - swap, *swap), (*swap, 1 - swap)])
        .unzip()
}

fn three_values(pair: Option<(f64, f64)>) -> [Option<f64>; N_VALUES] {
    let Some((clean, cracked)) = pair else {
        return [None; N_VALUES];
    };
    [Some(clean), Some(cracked), Some(cracked - clean)]
}
