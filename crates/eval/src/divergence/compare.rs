//! Every pair of sets, by every feature, with floor, interval and p-value.

use std::borrow::Cow;

use rayon::prelude::*;

use super::draws::{coins, multiplicities, stream, subset};
use super::estimate::{ROUNDING, mean};
use super::features::Feature;
use super::histogram::{HistogramDivergence, histogram_divergence};
use super::report::{
    CONFIDENCE, CompareSettings, DEFINITION, DivergenceReport, Estimate, FeatureComparison,
    Measure, PairComparison, REPORT_SCHEMA, SetFloor, floor_of,
};
use super::set::{ImageSet, Item};
use super::summed::SummedSet;
use super::vectors::compare_vectors;
use super::{ReadSettings, VectorComparison};
use crate::EvalError;

/// Full histograms, one for each feature.
pub(super) type Pooled = Vec<Vec<f64>>;

/// What is measured in one comparison, one for each feature; none where a histogram is empty.
pub(super) type Values = Vec<Option<HistogramDivergence>>;

/// Every pair of at least two sets compared by all features, and by their vectors where both have some.
///
/// Histograms are pooled: the counts of a set are summed over its images, so that an image counts
/// as much as it has pixels. Each draw has its own stream and sums go in the order of the images:
/// the same numbers for any number of threads.
///
/// # Errors
/// [`EvalError::NotComparable`] for fewer than two sets, or images with networks; [`EvalError::Smoothing`] for
/// an alpha out of range; as for [`compare_vectors`].
pub fn compare_sets(
    sets: &[ImageSet],
    reading: &ReadSettings,
    settings: &CompareSettings,
) -> Result<DivergenceReport, EvalError> {
    Ok(compare_with_replicates(sets, reading, settings)?.0)
}

/// As [`compare_sets`], with the values of every pair in each bootstrap replicate.
pub(super) fn compare_with_replicates(
    sets: &[ImageSet],
    reading: &ReadSettings,
    settings: &CompareSettings,
) -> Result<(DivergenceReport, Vec<Vec<Values>>), EvalError> {
    let refs: Vec<&ImageSet> = sets.iter().collect();
    check(&refs, settings.alpha)?;
    let twins = refs.iter().enumerate();
    let twins = twins.map(|(place, set)| twin_of(&refs[..place], set));
    Comparison {
        sums: Sums::OnTheWay {
            wholes: sets.iter().map(whole).collect(),
            twins: twins.collect(),
        },
        sets: refs,
        settings,
    }
    .report(reading)
}

/// The same of sets whose images are not there any more, without permutations.
pub(super) fn compare_summed(
    sets: &[SummedSet],
    reading: &ReadSettings,
    settings: &CompareSettings,
) -> Result<DivergenceReport, EvalError> {
    let comparison = Comparison {
        sets: sets.iter().map(|it| &it.set).collect(),
        sums: Sums::Kept(sets),
        settings,
    };
    check(&comparison.sets, settings.alpha)?;
    Ok(comparison.report(reading)?.0)
}

fn check(sets: &[&ImageSet], alpha: f64) -> Result<(), EvalError> {
    if !(alpha.is_finite() && alpha >= 0.0) {
        return Err(EvalError::Smoothing { alpha });
    }
    let (fact, way_out) = match sets {
        [] => ("there is no set".to_owned(), "give two or more"),
        [one] => {
            let fact = format!("{:?} is the only set", one.summary.name);
            (fact, "give two or more")
        }
        [first, more @ ..] => {
            let other = more.iter().find(|set| set.features != first.features);
            let Some(other) = other else {
                return Ok(());
            };
            let fact = format!(
                "{:?} and {:?} have nothing in common: one is of images, one of crack networks",
                first.summary.name, other.summary.name
            );
            (fact, "compare images with images")
        }
    };
    Err(EvalError::NotComparable { fact, way_out })
}

struct Comparison<'a> {
    sets: Vec<&'a ImageSet>,
    sums: Sums<'a>,
    settings: &'a CompareSettings,
}

/// Sums over the images of each set.
enum Sums<'a> {
    /// Of all of its images; those of draws are taken when they are needed.
    OnTheWay {
        wholes: Vec<Pooled>,
        /// Of each set the first one with the same images by name, which may be itself.
        twins: Vec<usize>,
    },
    /// Of all of its images and of every draw; the images are gone, so that nothing can be permuted.
    Kept(&'a [SummedSet]),
}

impl Comparison<'_> {
    /// Every pair, and the values of every pair in each bootstrap replicate.
    fn report(
        &self,
        reading: &ReadSettings,
    ) -> Result<(DivergenceReport, Vec<Vec<Values>>), EvalError> {
        let n = self.sets.len();
        let pairs: Vec<[usize; 2]> = (0..n)
            .flat_map(|a| (a + 1..n).map(move |b| [a, b]))
            .collect();
        let replicates = self.bootstrap(&pairs);
        let floors: Vec<SetFloor> = (0..n).filter_map(|set| self.floor(set)).collect();
        let mut compared = Vec::new();
        for (place, pair) in pairs.iter().enumerate() {
            let drawn: Vec<&Values> = replicates.iter().map(|all| &all[place]).collect();
            compared.push(self.pair(*pair, &drawn, &floors)?);
        }
        let shared = compared.iter().filter(|pair| pair.n_shared > 0);
        let shared = shared.map(|pair| {
            format!(
                "{:?} and {:?} share {} identical files: the sets are not independent, so distances are too small and p-values too large",
                pair.a, pair.b, pair.n_shared
            )
        });
        let sets = self.sets.iter();
        let notes = sets.flat_map(|set| set.notes()).chain(shared).collect();
        let report = DivergenceReport {
            schema: REPORT_SCHEMA,
            definition: DEFINITION,
            log_base: "e",
            confidence: CONFIDENCE,
            settings: *self.settings,
            reading: *reading,
            sets: self.sets.iter().map(|set| set.summary.clone()).collect(),
            notes,
            pairs: compared,
            floors,
        };
        Ok((report, replicates))
    }

    /// The sum of all images of a set.
    fn whole(&self, set: usize) -> &Pooled {
        match &self.sums {
            Sums::OnTheWay { wholes, .. } => &wholes[set],
            Sums::Kept(sets) => &sets[set].whole,
        }
    }

    /// The values of all pairs in each replicate, in which all sets are drawn anew; sets of the same images by
    /// name, such as a clean one and its cracked twin, get the same draws.
    fn bootstrap(&self, pairs: &[[usize; 2]]) -> Vec<Vec<Values>> {
        draws(self.settings.n_bootstrap, |index| {
            let drawn = |(place, set): (usize, &&ImageSet)| match &self.sums {
                Sums::OnTheWay { twins, .. } => {
                    Cow::Owned(replicate(set, twins[place], index, self.settings))
                }
                Sums::Kept(sets) => Cow::Borrowed(&sets[place].replicates[index]),
            };
            let drawn: Vec<Cow<'_, Pooled>> = self.sets.iter().enumerate().map(drawn).collect();
            let values =
                |[a, b]: &[usize; 2]| measured(&drawn[*a], &drawn[*b], self.settings.alpha);
            pairs.iter().map(values).collect()
        })
    }

    /// The floor of a set; none of a set of one image.
    fn floor(&self, place: usize) -> Option<SetFloor> {
        match &self.sums {
            Sums::OnTheWay { wholes, .. } => {
                halves_differ_by(self.sets[place], place, &wholes[place], self.settings)
            }
            Sums::Kept(sets) => sets[place].floor.clone(),
        }
    }

    /// The values of all images of both sets, labeled anew (of paired sets: inside each pair); none where
    /// there are only two.
    fn permutations(&self, [a, b]: [usize; 2]) -> Vec<Values> {
        let (set_a, set_b) = (self.sets[a], self.sets[b]);
        let items = || set_a.items.iter().chain(&set_b.items);
        let (n_a, n_items) = (set_a.items.len(), items().count());
        if n_items < 3 || self.settings.n_permutations == 0 {
            return Vec::new();
        }
        let is_paired = set_a.is_twin_of(set_b);
        let whole = pooled(set_a.features, items(), &vec![1; n_items]);
        // The smaller set is summed, the larger is what is left.
        let n_picked = n_a.min(n_items - n_a);
        draws(self.settings.n_permutations, |index| {
            let mut random = stream(self.settings.seed, "permutation", [a, b], index);
            let is_picked = if is_paired {
                // Of each image one of its two versions.
                let flips = coins(&mut random, n_a);
                let others = flips.iter().map(|flip| 1 - flip);
                flips.iter().copied().chain(others).collect()
            } else {
                subset(&mut random, n_items, n_picked)
            };
            let picked = pooled(set_a.features, items(), &is_picked);
            let others = rest(&whole, &picked);
            if n_picked == n_a {
                measured(&picked, &others, self.settings.alpha)
            } else {
                measured(&others, &picked, self.settings.alpha)
            }
        })
    }

    /// Two sets compared; `drawn` are their replicates.
    fn pair(
        &self,
        [a, b]: [usize; 2],
        drawn: &[&Values],
        floors: &[SetFloor],
    ) -> Result<PairComparison, EvalError> {
        let sets = [self.sets[a], self.sets[b]];
        let [set_a, set_b] = sets;
        let [n_a, n_b] = sets.map(|set| set.items.len());
        let values = measured(self.whole(a), self.whole(b), self.settings.alpha);
        let relabeled = self.permutations([a, b]);
        let relabeled: Vec<&Values> = relabeled.iter().collect();
        // One image cannot be drawn anew.
        let drawn = if n_a == 1 || n_b == 1 { &[] } else { drawn };
        let of_feature = |(at, feature): (usize, &Feature)| {
            let estimate = |measure: Measure| {
                let floors = sets.map(|set| floor_of(floors, &set.summary.name, *feature, measure));
                let estimate = Estimate::of(
                    measure.of(values[at].as_ref()?),
                    column(drawn, at, measure),
                    floors.into_iter().flatten().max_by(f64::total_cmp),
                    &column(&relabeled, at, measure),
                    measure.unit(*feature)?,
                );
                Some((measure, estimate))
            };
            let missing = values[at].is_none();
            FeatureComparison {
                feature: *feature,
                n_bins: feature.n_bins(),
                w1_unit: feature.bin_width().map(|(_, unit)| unit),
                measures: Measure::ALL.into_iter().filter_map(estimate).collect(),
                missing: missing.then_some("nothing was counted in one of the sets"),
            }
        };
        Ok(PairComparison {
            a: set_a.summary.name.clone(),
            b: set_b.summary.name.clone(),
            n_a,
            n_b,
            n_shared: set_a.n_shared_with(set_b),
            is_paired: set_a.is_twin_of(set_b),
            features: set_a.features.iter().enumerate().map(of_feature).collect(),
            activations: activations(sets)?,
        })
    }
}

/// All measures of all features.
fn measured(a: &Pooled, b: &Pooled, alpha: f64) -> Values {
    let pools = a.iter().zip(b);
    pools
        .map(|(p, q)| histogram_divergence(p, q, alpha).ok())
        .collect()
}

/// The place of the first set with the same images by name; behind all of them where there is none.
pub(super) fn twin_of(before: &[&ImageSet], set: &ImageSet) -> usize {
    let first = before.iter().position(|other| other.is_twin_of(set));
    first.unwrap_or(before.len())
}

/// A set drawn anew, with the draws of its twin.
pub(super) fn replicate(
    set: &ImageSet,
    twin: usize,
    index: usize,
    settings: &CompareSettings,
) -> Pooled {
    let mut random = stream(settings.seed, "bootstrap", [twin, twin], index);
    let times = multiplicities(&mut random, set.items.len());
    pooled(set.features, &set.items, &times)
}

/// What random halves of a set differ by; none of a set of one image.
pub(super) fn halves_differ_by(
    set: &ImageSet,
    place: usize,
    whole: &Pooled,
    settings: &CompareSettings,
) -> Option<SetFloor> {
    let n_half = set.items.len() / 2;
    if n_half == 0 || settings.n_splits == 0 {
        return None;
    }
    let splits: Vec<Values> = draws(settings.n_splits, |index| {
        let mut random = stream(settings.seed, "halves", [place, place], index);
        let is_first = subset(&mut random, set.items.len(), n_half);
        let first = pooled(set.features, &set.items, &is_first);
        measured(&first, &rest(whole, &first), settings.alpha)
    });
    let splits: Vec<&Values> = splits.iter().collect();
    let of_feature = |(at, feature): (usize, &Feature)| {
        let floor = |measure: Measure| {
            let mean = mean(column(&splits, at, measure))?;
            Some((measure, mean * measure.unit(*feature)?))
        };
        let measures = Measure::ALL.into_iter().filter_map(floor).collect();
        (feature.name(), measures)
    };
    Some(SetFloor {
        set: set.summary.name.clone(),
        n_half,
        features: set.features.iter().enumerate().map(of_feature).collect(),
    })
}

/// Two sets compared by the vectors of their images, where both have two or more.
fn activations([a, b]: [&ImageSet; 2]) -> Result<Option<VectorComparison>, EvalError> {
    let vectors = a.vectors.as_ref().zip(b.vectors.as_ref());
    let compared = vectors.filter(|(a, b)| a.n() > 1 && b.n() > 1);
    compared.map(|(a, b)| compare_vectors(a, b)).transpose()
}

/// So many draws, side by side.
pub(super) fn draws<T: Send>(n: usize, draw: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    (0..n).into_par_iter().map(draw).collect()
}

/// One measure of one feature in all draws that have it.
fn column(draws: &[&Values], at: usize, measure: Measure) -> Vec<f64> {
    let values = draws.iter().filter_map(|values| values[at].as_ref());
    values.map(|all| measure.of(all)).collect()
}

/// The histograms of a set.
pub(super) fn whole(set: &ImageSet) -> Pooled {
    pooled(set.features, &set.items, &vec![1; set.items.len()])
}

/// The sum of the items, each as often as said.
fn pooled<'i>(
    features: &[Feature],
    items: impl IntoIterator<Item = &'i Item>,
    times: &[u32],
) -> Pooled {
    let empty = features.iter().map(|feature| vec![0.0; feature.n_bins()]);
    let mut pooled: Pooled = empty.collect();
    let items = items.into_iter().zip(times);
    for (item, times) in items.filter(|(_, times)| **times > 0) {
        for (counts, histogram) in item.counts.iter().zip(&mut pooled) {
            counts.add_to(histogram, f64::from(*times));
        }
    }
    pooled
}

/// What is left of the whole without a part; rounding leaves nothing below 0.
fn rest(whole: &Pooled, part: &Pooled) -> Pooled {
    let left = |whole: &Vec<f64>, part: &Vec<f64>| {
        // Where the part is all there was, its sum in another order leaves a trace.
        let left = |(w, p): (&f64, &f64)| {
            if w - p > ROUNDING * w { w - p } else { 0.0 }
        };
        whole.iter().zip(part).map(left).collect()
    };
    whole.iter().zip(part).map(|(w, p)| left(w, p)).collect()
}
