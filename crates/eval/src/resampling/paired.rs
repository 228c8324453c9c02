//! Average precision of clean and cracked images with all that is known about its difference.

use serde::{Deserialize, Serialize};

use super::ranked::Ranked;
use super::{Plan, RankedCategory, bootstrap, permutation_test};
use crate::EvalError;
use crate::matching::ImageMatches;
use crate::statistic::{Measured, Method, TestOutcome, holm};

/// Average precision of one category, or the mean over categories, clean and cracked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairedPrecision {
    /// Place of the category in [`LabelSet::categories`](crate::LabelSet::categories); `None` for
    /// the mean over those that have objects.
    pub category: Option<u32>,
    /// Objects to be found in the clean images.
    pub n_objects: u64,
    /// In the clean images, 0 to 1. The n of all four are the units drawn: images or clusters.
    pub clean: Measured,
    /// In the cracked images, those of all patterns pooled.
    pub cracked: Measured,
    /// Cracked minus clean.
    pub difference: Measured,
    /// Cracked over clean.
    pub ratio: Measured,
    /// Permutation test of the difference.
    pub test: TestOutcome,
    /// Its p after Holm's correction over the categories; the mean stands for itself and keeps its
    /// own.
    pub p_holm: Option<f64>,
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

/// Values per category in the bootstrap: clean, cracked, difference, ratio.
const N_VALUES: usize = 4;

/// Average precision per category, clean and cracked, with bootstrap intervals of both, of their
/// difference and of their ratio, a permutation test per category, and Holm's correction.
///
/// `clean` are the matches of the clean images, `cracked` those of the same images under each crack
/// pattern, all by the same rule. Replicates use the matches as they are, which is exact: matching
/// never crosses images.
///
/// # Errors
/// If the plan does not fit: another number of patterns, an image beyond its images; or if it has
/// no replicates or no proper level.
pub fn paired_average_precision(
    clean: &[ImageMatches],
    cracked: &[&[ImageMatches]],
    n_categories: usize,
    plan: &Plan,
) -> Result<PairedPrecisions, EvalError> {
    plan.check()?;
    let versions: Vec<&[ImageMatches]> = std::iter::once(clean)
        .chain(cracked.iter().copied())
        .collect();
    let n_versions = check_fit(&versions, plan)?;
    paired_of_ranked(
        &rank(&versions[..1], n_categories, 1),
        &rank(&versions[1..], n_categories, n_versions - 1),
        &rank(&versions, n_categories, n_versions),
        n_versions,
        plan,
    )
}

/// The same of anything that has an average precision: clean, cracked over cells image times
/// patterns plus pattern, and both together over cells image times versions plus version.
pub(super) fn paired_of_ranked<R: Ranked>(
    clean_ranked: &[R],
    cracked_ranked: &[R],
    all_ranked: &[R],
    n_versions: u32,
    plan: &Plan,
) -> Result<PairedPrecisions, EvalError> {
    let n_categories = clean_ranked.len();
    let mut found = precisions_of_ranked(clean_ranked, cracked_ranked, false, plan)?;
    let tests = permutation_test(plan, |roles| {
        let (as_clean, as_cracked) = role_weights(roles, n_versions);
        let mut values = Vec::with_capacity(n_categories + 1);
        let mut sums = MeanOfPairs::default();
        for ranked in all_ranked {
            let pair = ranked
                .average_precision(&as_clean)
                .zip(ranked.average_precision(&as_cracked));
            sums.add(pair);
            values.push(pair.map(|(clean, cracked)| cracked - clean));
        }
        values.push(sums.mean().map(|(clean, cracked)| cracked - clean));
        values
    })?;
    for (row, test) in found.categories.iter_mut().zip(&tests) {
        row.test = test.clone();
    }
    let p: Vec<Option<f64>> = found.categories.iter().map(|it| it.test.p).collect();
    for (category, corrected) in found.categories.iter_mut().zip(holm(&p)) {
        category.p_holm = corrected;
    }
    if let Some(test) = tests.last() {
        found.mean.test = test.clone();
    }
    found.mean.p_holm = found.mean.test.p;
    Ok(found)
}

/// The values with their intervals, without any test. The cells of the clean side are those of the
/// cracked one, image times patterns plus pattern, or the images alone.
pub(super) fn precisions_of_ranked<R: Ranked>(
    clean_ranked: &[R],
    cracked_ranked: &[R],
    is_clean_per_pattern: bool,
    plan: &Plan,
) -> Result<PairedPrecisions, EvalError> {
    let n_categories = clean_ranked.len();
    let replicates = bootstrap(plan, |weights| {
        let cells = cell_weights(&weights.images, &weights.patterns);
        let of_clean = match is_clean_per_pattern {
            true => &cells,
            false => &weights.images,
        };
        let mut values = Vec::with_capacity((n_categories + 1) * N_VALUES);
        let mut sums = MeanOfPairs::default();
        for (clean, cracked) in clean_ranked.iter().zip(cracked_ranked) {
            let pair = clean
                .average_precision(of_clean)
                .zip(cracked.average_precision(&cells));
            sums.add(pair);
            values.extend(four_values(pair));
        }
        values.extend(four_values(sums.mean()));
        values
    })?;
    let n_cells = match is_clean_per_pattern {
        true => plan.n_images() * plan.n_patterns() as usize,
        false => plan.n_images(),
    };
    let ones = vec![1; n_cells];
    let row = |place: usize, category: Option<u32>, n_objects: u64| PairedPrecision {
        category,
        n_objects,
        clean: replicates.basic(place * N_VALUES, Method::AveragePrecision, [0.0, 1.0]),
        cracked: replicates.basic(place * N_VALUES + 1, Method::AveragePrecision, [0.0, 1.0]),
        difference: replicates.basic(place * N_VALUES + 2, Method::Difference, [-1.0, 1.0]),
        ratio: replicates.percentile(place * N_VALUES + 3, Method::Ratio),
        test: TestOutcome::none(
            u64::from(plan.n_units()),
            Method::PermutationSampled,
            "there is no test over several patterns",
        ),
        p_holm: None,
    };
    let categories: Vec<PairedPrecision> = clean_ranked
        .iter()
        .enumerate()
        .map(|(place, ranked)| row(place, Some(ranked.category()), ranked.n_objects(&ones)))
        .collect();
    let n_objects = categories.iter().map(|it| it.n_objects).sum();
    let mean = row(n_categories, None, n_objects);
    Ok(PairedPrecisions {
        categories,
        mean,
        n_replicates: plan.n_replicates,
        seed: plan.seed,
    })
}

/// The number of versions of each image, clean included.
fn check_fit(versions: &[&[ImageMatches]], plan: &Plan) -> Result<u32, EvalError> {
    let n_patterns = plan.n_patterns() as usize;
    if versions.len() != n_patterns + 1 {
        return Err(EvalError::StatisticLength {
            what: "sets of cracked matches",
            found: versions.len() - 1,
            expected: n_patterns,
            of: "patterns of the plan",
        });
    }
    check_cells(versions, n_patterns + 1, plan)
}

/// The number of versions, if the images are the plan's and their cells can be counted.
pub(super) fn check_cells(
    versions: &[&[ImageMatches]],
    n_versions: usize,
    plan: &Plan,
) -> Result<u32, EvalError> {
    let images = versions.iter().copied().flatten().map(|it| it.image);
    let n_needed = images.max().map_or(0, |image| image as usize + 1);
    if n_needed > plan.n_images() {
        return Err(EvalError::StatisticLength {
            what: "images with matches",
            found: n_needed,
            expected: plan.n_images(),
            of: "images of the plan",
        });
    }
    // A cell and one bit more must fit 32 bits.
    match u32::try_from(n_versions) {
        Ok(n) if plan.n_images().saturating_mul(n_versions) < 1 << 31 => Ok(n),
        _ => Err(EvalError::StatisticSetting {
            what: "images times patterns",
            value: plan.n_images() as f64 * n_versions as f64,
            range: "below 2^31",
        }),
    }
}

/// Categories over cells: image times versions plus version.
pub(super) fn rank(
    versions: &[&[ImageMatches]],
    n_categories: usize,
    n_versions: u32,
) -> Vec<RankedCategory> {
    let mut by_category: Vec<Vec<(&ImageMatches, u32)>> = vec![Vec::new(); n_categories];
    for (matches, version) in versions.iter().zip(0..) {
        for item in *matches {
            if let Some(list) = by_category.get_mut(item.category as usize) {
                list.push((item, item.image * n_versions + version));
            }
        }
    }
    by_category
        .into_iter()
        .zip(0..)
        .map(|(cells, category)| RankedCategory::new(category, cells))
        .collect()
}

/// Weights of cells: image times pattern.
fn cell_weights(images: &[u32], patterns: &[u32]) -> Vec<u32> {
    images
        .iter()
        .flat_map(|image| patterns.iter().map(move |pattern| image * pattern))
        .collect()
}

/// Weights of the cells that play the clean and the cracked images.
fn role_weights(roles: &[u32], n_versions: u32) -> (Vec<u32>, Vec<u32>) {
    roles
        .iter()
        .flat_map(|role| {
            (0..n_versions).map(move |version| {
                let is_clean = u32::from(version == *role);
                (is_clean, 1 - is_clean)
            })
        })
        .unzip()
}

fn four_values(pair: Option<(f64, f64)>) -> [Option<f64>; N_VALUES] {
    let Some((clean, cracked)) = pair else {
        return [None; N_VALUES];
    };
    let ratio = (clean > 0.0).then(|| cracked / clean);
    [Some(clean), Some(cracked), Some(cracked - clean), ratio]
}

/// The mean over categories of both values, of those that have them.
#[derive(Debug, Default)]
struct MeanOfPairs {
    clean: f64,
    cracked: f64,
    n: u32,
}

impl MeanOfPairs {
    fn add(&mut self, pair: Option<(f64, f64)>) {
        if let Some((clean, cracked)) = pair {
            self.clean += clean;
            self.cracked += cracked;
            self.n += 1;
        }
    }

    fn mean(&self) -> Option<(f64, f64)> {
        let n = f64::from(self.n);
        (self.n > 0).then(|| (self.clean / n, self.cracked / n))
    }
}
