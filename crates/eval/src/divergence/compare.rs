//! Every pair of sets, by every feature, with floor, interval and p-value.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::draws::{Purpose, coins, multiplicities, stream, subset};
use super::estimate::{ROUNDING, mean, quantile, share, sorted};
use super::features::{BinAxis, Feature};
use super::measures::{HistogramDivergence, circular_w1_bins, histogram_divergence};
use super::notes::{are_paired, first_twins, n_shared, notes};
use super::report::{
    CompareSettings, DEFINITION, DivergenceReport, Estimate, FeatureComparison, FeatureOrdering,
    Measure, OrderingTest, PairComparison, REPORT_SCHEMA, SetFloor,
};
use super::sets::{ImageSet, Item, ReadSettings};
use crate::EvalError;

/// An ordering holds in a feature above this probability…
const SURE: f64 = 0.95;

/// …and on the whole in so many features.
const ENOUGH_FEATURES: usize = 4;

/// A claim to be tested: sets by their places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OrderingClaim {
    /// The pair that is claimed to be closer.
    pub closer: [usize; 2],
    /// The pair that is claimed to be farther.
    pub farther: [usize; 2],
}

/// Full histograms, one for each feature.
type Pooled = Vec<Vec<f64>>;

/// What is measured of one feature in one comparison; none where a histogram is empty.
type Values = Option<[f64; 7]>;

/// The measures of histograms in the order of [`Values`].
const MEASURES: [Measure; 7] = [
    Measure::KlAb,
    Measure::KlBa,
    Measure::Jeffreys,
    Measure::Js,
    Measure::W1Bins,
    Measure::Hellinger,
    Measure::Tv,
];

/// The place of [`Measure::Js`] there, by which orderings are judged.
const JS: usize = 3;

/// Every pair of at least two sets compared by all features that both have.
///
/// Histograms are pooled: the counts of a set are summed over its images, so that an image counts
/// as much as it has pixels. Each draw has its own stream and sums go in the order of the images:
/// the same numbers for any number of threads.
///
/// # Errors
/// [`EvalError::NotComparable`] for fewer than two sets, or sets without a feature in common, or a
/// claim about sets that are not there; [`EvalError::Smoothing`] and
/// [`EvalError::DivergenceSetting`] for settings out of range.
pub fn compare_sets(
    sets: &[ImageSet],
    reading: &ReadSettings,
    settings: &CompareSettings,
    claims: &[OrderingClaim],
) -> Result<DivergenceReport, EvalError> {
    check(sets, settings, claims)?;
    let pairs: Vec<[usize; 2]> = (0..sets.len())
        .flat_map(|a| (a + 1..sets.len()).map(move |b| [a, b]))
        .collect();
    let features = &sets
        .first()
        .map(|set| set.features.clone())
        .unwrap_or_default();
    let comparison = Comparison {
        sets,
        settings,
        features,
    };
    let pooled: Vec<Pooled> = sets
        .iter()
        .map(|set| comparison.pooled(set.items.iter(), |_| 1))
        .collect();
    let values: Vec<Vec<Values>> = pairs
        .iter()
        .map(|[a, b]| comparison.of_pools(pooled.get(*a), pooled.get(*b)))
        .collect();
    let replicates = comparison.bootstrap(&pairs);
    let floors: Vec<Vec<Vec<Values>>> = (0..sets.len())
        .map(|s| comparison.halves(s, pooled.get(s)))
        .collect();

    let mut compared = Vec::new();
    for (place, (&[a, b], values)) in pairs.iter().zip(&values).enumerate() {
        let (Some(set_a), Some(set_b)) = (sets.get(a), sets.get(b)) else {
            continue;
        };
        let relabeled = comparison.permutations([a, b]);
        let spread = Spread {
            bootstrap: replicates.iter().filter_map(|all| all.get(place)).collect(),
            floors: [floors.get(a), floors.get(b)],
            relabeled: &relabeled,
            is_single: set_a.items.len() == 1 || set_b.items.len() == 1,
            settings,
        };
        let by_feature = features.iter().zip(values).enumerate();
        compared.push(PairComparison {
            a: set_a.name.clone(),
            b: set_b.name.clone(),
            n_a: set_a.items.len(),
            n_b: set_b.items.len(),
            n_shared: n_shared(set_a, set_b),
            is_paired: are_paired(set_a, set_b),
            features: by_feature
                .map(|(at, (feature, values))| spread.feature(at, *feature, values))
                .collect(),
            activations: None,
        });
    }
    let orderings = claims
        .iter()
        .map(|claim| comparison.ordering(claim, &pairs, &values, &replicates))
        .collect();
    Ok(DivergenceReport {
        schema: REPORT_SCHEMA,
        definition: DEFINITION,
        log_base: "e",
        settings: *settings,
        reading: *reading,
        sets: sets.iter().map(ImageSet::summary).collect(),
        notes: notes(sets, &compared),
        pairs: compared,
        floors: comparison.set_floors(&floors),
        orderings,
    })
}

fn check(
    sets: &[ImageSet],
    settings: &CompareSettings,
    claims: &[OrderingClaim],
) -> Result<(), EvalError> {
    let refuse = |fact: String, way_out| Err(EvalError::NotComparable { fact, way_out });
    let alpha = settings.alpha;
    if !(alpha.is_finite() && alpha >= 0.0) {
        return Err(EvalError::Smoothing { alpha });
    }
    if !(settings.confidence > 0.0 && settings.confidence < 1.0) {
        return Err(EvalError::DivergenceSetting {
            name: "confidence",
            value: settings.confidence.to_string(),
            expected: "a number between 0 and 1",
        });
    }
    let Some((first, more)) = sets.split_first() else {
        return refuse("there is no set".to_owned(), "give two or more");
    };
    if more.is_empty() {
        return refuse(
            format!("{:?} is the only set", first.name),
            "give two or more",
        );
    }
    if let Some(other) = more.iter().find(|set| set.features != first.features) {
        return refuse(
            format!(
                "{:?} and {:?} have nothing in common: one is of images, one of crack patterns",
                first.name, other.name
            ),
            "compare images with images",
        );
    }
    let mentioned = claims
        .iter()
        .flat_map(|claim| [claim.closer, claim.farther]);
    if let Some([a, b]) = mentioned
        .into_iter()
        .find(|[a, b]| a >= b || *b >= sets.len())
    {
        return refuse(
            format!("a claim names sets {a} and {b} of {}", sets.len()),
            "name two different ones in their order",
        );
    }
    Ok(())
}

struct Comparison<'a> {
    sets: &'a [ImageSet],
    settings: &'a CompareSettings,
    features: &'a [Feature],
}

impl Comparison<'_> {
    /// The sum of the items, each as often as said by its place.
    fn pooled<'i>(
        &self,
        items: impl Iterator<Item = &'i Item>,
        times: impl Fn(usize) -> u32,
    ) -> Pooled {
        let mut pooled: Pooled = self
            .features
            .iter()
            .map(|f| vec![0.0; f.n_bins()])
            .collect();
        for (place, item) in items.enumerate() {
            let times = times(place);
            if times == 0 {
                continue;
            }
            for (counts, histogram) in item.counts.iter().zip(&mut pooled) {
                counts.add_to(histogram, f64::from(times));
            }
        }
        pooled
    }

    /// All measures of all features.
    fn of_pools(&self, a: Option<&Pooled>, b: Option<&Pooled>) -> Vec<Values> {
        let (Some(a), Some(b)) = (a, b) else {
            return vec![None; self.features.len()];
        };
        let pools = self.features.iter().zip(a.iter().zip(b));
        pools
            .map(|(feature, (p, q))| measured(*feature, p, q, self.settings.alpha))
            .collect()
    }

    /// Values of all pairs for each replicate, in which all sets are drawn anew; sets of the same images by
    /// name, such as a clean one and its cracked twin, get the same draws.
    fn bootstrap(&self, pairs: &[[usize; 2]]) -> Vec<Vec<Vec<Values>>> {
        let twins = first_twins(self.sets);
        let replicate = |index: usize| -> Vec<Vec<Values>> {
            let pools: Vec<Pooled> = twins
                .iter()
                .copied()
                .zip(self.sets)
                .map(|(place, set)| {
                    let purpose = Purpose::Bootstrap;
                    let mut random = stream(self.settings.seed, purpose, [place, place], index);
                    let times = multiplicities(&mut random, set.items.len());
                    self.pooled(set.items.iter(), |item| {
                        times.get(item).copied().unwrap_or_default()
                    })
                })
                .collect();
            pairs
                .iter()
                .map(|[a, b]| self.of_pools(pools.get(*a), pools.get(*b)))
                .collect()
        };
        (0..self.settings.n_bootstrap)
            .into_par_iter()
            .map(replicate)
            .collect()
    }

    /// Values of one half of a set against the other, for each split; none of a set of one image.
    fn halves(&self, place: usize, whole: Option<&Pooled>) -> Vec<Vec<Values>> {
        let (Some(set), Some(whole)) = (self.sets.get(place), whole) else {
            return Vec::new();
        };
        let n = set.items.len();
        if n < 2 {
            return Vec::new();
        }
        let split = |index: usize| {
            let seed = self.settings.seed;
            let mut random = stream(seed, Purpose::Halves, [place, place], index);
            let is_first = subset(&mut random, n, n / 2);
            let first = self.pooled(set.items.iter(), |item| {
                is_first.get(item).map_or(0, |p| u32::from(*p))
            });
            let second = rest(whole, &first);
            self.of_pools(Some(&first), Some(&second))
        };
        (0..self.settings.n_splits)
            .into_par_iter()
            .map(split)
            .collect()
    }

    fn set_floors(&self, floors: &[Vec<Vec<Values>>]) -> Vec<SetFloor> {
        let of_set = |(set, splits): (&ImageSet, &Vec<Vec<Values>>)| -> Option<SetFloor> {
            let mut features = BTreeMap::new();
            for (at, feature) in self.features.iter().enumerate() {
                let mut measures = BTreeMap::new();
                for (place, measure) in MEASURES.into_iter().enumerate() {
                    let values = splits
                        .iter()
                        .filter_map(|values| values.get(at)?.as_ref()?.get(place).copied());
                    let values = sorted(values.collect());
                    if let Some(floor) = mean(&values).zip(quantile(&values, 0.95)) {
                        measures.insert(measure, floor.into());
                    }
                }
                features.insert(feature.name(), measures);
            }
            (!splits.is_empty()).then(|| SetFloor {
                set: set.name.clone(),
                n_half: set.items.len() / 2,
                features,
            })
        };
        self.sets.iter().zip(floors).filter_map(of_set).collect()
    }

    /// Values of all images of both sets, labeled anew (of paired sets: inside each pair); none where there are only two.
    fn permutations(&self, [a, b]: [usize; 2]) -> Vec<Vec<Values>> {
        let (Some(set_a), Some(set_b)) = (self.sets.get(a), self.sets.get(b)) else {
            return Vec::new();
        };
        let items = || set_a.items.iter().chain(&set_b.items);
        let n_items = items().count();
        if n_items < 3 {
            return Vec::new();
        }
        let is_paired = are_paired(set_a, set_b);
        let whole = self.pooled(items(), |_| 1);
        let n_a = set_a.items.len();
        // The smaller set is summed, the larger is what is left.
        let n_picked = n_a.min(n_items - n_a);
        let relabel = |index: usize| {
            let mut random = stream(self.settings.seed, Purpose::Permutation, [a, b], index);
            let is_picked = if is_paired {
                // Of each image one of its two versions.
                let flips = coins(&mut random, n_a);
                let others = flips.iter().map(|flip| !flip);
                flips.iter().copied().chain(others).collect()
            } else {
                subset(&mut random, n_items, n_picked)
            };
            let picked = self.pooled(items(), |item| {
                is_picked.get(item).map_or(0, |p| u32::from(*p))
            });
            let others = rest(&whole, &picked);
            if n_picked == n_a {
                self.of_pools(Some(&picked), Some(&others))
            } else {
                self.of_pools(Some(&others), Some(&picked))
            }
        };
        (0..self.settings.n_permutations)
            .into_par_iter()
            .map(relabel)
            .collect()
    }

    fn ordering(
        &self,
        claim: &OrderingClaim,
        pairs: &[[usize; 2]],
        values: &[Vec<Values>],
        replicates: &[Vec<Vec<Values>>],
    ) -> OrderingTest {
        let place = |pair: [usize; 2]| pairs.iter().position(|p| *p == pair).unwrap_or_default();
        let (near, far) = (place(claim.closer), place(claim.farther));
        let js = |of: &[Vec<Values>], pair: usize, feature: usize| -> Option<f64> {
            let values = of.get(pair)?.get(feature)?.as_ref()?;
            values.get(JS).copied()
        };
        let mut features = Vec::new();
        for (at, feature) in self.features.iter().enumerate() {
            let (Some(closer), Some(farther)) = (js(values, near, at), js(values, far, at)) else {
                continue;
            };
            let held: Vec<bool> = replicates
                .iter()
                .filter_map(|all| Some(js(all, near, at)? < js(all, far, at)?))
                .collect();
            features.push(FeatureOrdering {
                feature: *feature,
                closer,
                farther,
                probability: (!held.is_empty())
                    .then(|| share(held.iter().filter(|held| **held).count(), held.len())),
            });
        }
        let n_holding = features
            .iter()
            .filter(|f| f.probability.is_some_and(|p| p > SURE))
            .count();
        let names = |pair: [usize; 2]| {
            pair.map(|set| {
                self.sets
                    .get(set)
                    .map(|s| s.name.clone())
                    .unwrap_or_default()
            })
        };
        OrderingTest {
            closer: names(claim.closer),
            farther: names(claim.farther),
            measure: Measure::Js,
            n_features: features.len(),
            features,
            n_holding,
            holds: n_holding >= ENOUGH_FEATURES,
        }
    }
}

/// All measures of one feature, W1 in bins, around the circle where they lie so, 0 where they have
/// no order.
fn measured(feature: Feature, p: &[f64], q: &[f64], alpha: f64) -> Values {
    let HistogramDivergence {
        kl_pq,
        kl_qp,
        jeffreys,
        js,
        w1_bins,
        hellinger,
        tv,
    } = histogram_divergence(p, q, alpha).ok()?;
    let w1_bins = match feature.axis() {
        BinAxis::Line { .. } => w1_bins,
        BinAxis::Circle { .. } => circular_w1_bins(p, q, alpha).ok()?,
        BinAxis::Unordered => 0.0,
    };
    Some([kl_pq, kl_qp, jeffreys, js, w1_bins, hellinger, tv])
}

/// What is left of the whole without a part; rounding leaves nothing below 0.
fn rest(whole: &Pooled, part: &Pooled) -> Pooled {
    let left = |whole: &[f64], part: &[f64]| {
        // Where the part is all there was, its sum in another order leaves a trace.
        let left = |(w, p): (&f64, &f64)| {
            if w - p > ROUNDING * w { w - p } else { 0.0 }
        };
        whole.iter().zip(part).map(left).collect()
    };
    whole.iter().zip(part).map(|(w, p)| left(w, p)).collect()
}

/// The resampled values of one pair.
struct Spread<'a> {
    bootstrap: Vec<&'a Vec<Values>>,
    floors: [Option<&'a Vec<Vec<Values>>>; 2],
    relabeled: &'a [Vec<Values>],
    /// Whether a set has one image only, which cannot be drawn anew.
    is_single: bool,
    settings: &'a CompareSettings,
}

impl Spread<'_> {
    fn feature(&self, at: usize, feature: Feature, values: &Values) -> FeatureComparison {
        let mut measures = BTreeMap::new();
        for (place, measure) in MEASURES.into_iter().enumerate() {
            let Some(value) = values.as_ref().and_then(|values| values.get(place)) else {
                continue;
            };
            let is_w1 = measure == Measure::W1Bins;
            let width = match feature.axis() {
                BinAxis::Line { bin_width, .. } | BinAxis::Circle { bin_width, .. } => bin_width,
                BinAxis::Unordered if is_w1 => continue,
                BinAxis::Unordered => 1.0,
            };
            let estimate = self.estimate(at, place, *value);
            if is_w1 {
                measures.insert(Measure::W1, estimate.times(width));
            }
            measures.insert(measure, estimate);
        }
        FeatureComparison {
            feature,
            n_bins: feature.n_bins(),
            axis: feature.axis(),
            missing: measures
                .is_empty()
                .then(|| "nothing was counted in one of the sets".to_owned()),
            measures,
        }
    }

    fn estimate(&self, feature: usize, place: usize, value: f64) -> Estimate {
        let pick = |values: &Vec<Values>| -> Option<f64> {
            values.get(feature)?.as_ref()?.get(place).copied()
        };
        let mut draws: Vec<f64> = self
            .bootstrap
            .iter()
            .filter_map(|values| pick(values))
            .collect();
        let floors = self.floors.map(|floor| -> Vec<f64> {
            floor
                .map(|all| all.iter().filter_map(&pick).collect())
                .unwrap_or_default()
        });
        let relabeled: Vec<f64> = self.relabeled.iter().filter_map(pick).collect();
        if self.is_single {
            draws.clear();
        }
        Estimate::of(value, draws, floors, &relabeled, self.settings.confidence)
    }
}
