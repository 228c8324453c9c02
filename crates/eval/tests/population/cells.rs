//! Every sort of interval and test of the report on samples: how often they are wrong.

use std::collections::BTreeMap;

use rayon::prelude::*;
use starbreak_eval::failure::{
    FalsePositiveAreas, FalsePositives, Group, ObjectPair, Where, class_flips, dose_response,
    failure_rates, new_false_positives, shifts,
};
use starbreak_eval::resampling::{
    DrawnMean, DrawnPrecisions, Plan, RankedCategory, paired_average_precision, rank_by_category,
};
use starbreak_eval::statistic::{Measured, TestOutcome};
use starbreak_eval::{EvalError, ImageMatches, LabelSet, measured_performance};

use super::{
    FoundSet, Image, Law, N_CATEGORIES, areas_px, found_set, image, labels, matches, pairs,
};

/// Detections from this score on count as found.
const SCORE: f64 = 0.3;

/// What one sample says of each number: its interval and its p, where there are.
type Said = BTreeMap<&'static str, (Option<[f64; 2]>, Option<f64>)>;

/// Of one number over many samples.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Wrong {
    /// Samples with an interval.
    pub(crate) n_intervals: u32,
    /// Intervals without the truth.
    pub(crate) n_beside: u32,
    /// Samples with a p.
    pub(crate) n_tests: u32,
    /// p below 0.05.
    pub(crate) n_below: u32,
    /// Samples in which only one of interval and p says that it is other than 0.
    pub(crate) n_disagree: u32,
}

/// Clean and cracked detections of the same images under some seeds.
pub(crate) struct Sample {
    /// Per seed, the matches of the clean images.
    pub(crate) clean: Vec<Vec<ImageMatches>>,
    /// Per seed, those of the cracked images.
    pub(crate) cracked: Vec<Vec<ImageMatches>>,
    /// What became of each object, of all seeds.
    pub(crate) pairs: Vec<ObjectPair>,
    /// Classes.
    pub(crate) n_categories: usize,
    /// What is drawn.
    pub(crate) plan: Plan,
    /// What was found clean and under the first seed, where it is known in boxes.
    pub(crate) boxes: Option<Boxes>,
}

/// Labels and detections of some images with their boxes.
pub(crate) struct Boxes {
    labels: LabelSet,
    clean: FoundSet,
    cracked: FoundSet,
    region_px: Vec<f64>,
    image_px: Vec<f64>,
}

impl Boxes {
    fn of(images: &[Image]) -> Self {
        let (region_px, image_px) = areas_px(images);
        Self {
            labels: labels(images),
            clean: found_set(images, 0),
            cracked: found_set(images, 1),
            region_px,
            image_px,
        }
    }

    /// Share of the objects taken for others.
    fn flips(&self, pairs: &[ObjectPair], plan: &Plan) -> Result<Measured, EvalError> {
        let FoundSet {
            matches,
            detections,
            ..
        } = &self.cracked;
        let flips = class_flips(pairs, matches, detections, &self.labels, SCORE, 0.5, plan)?;
        Ok(flips.flip_rate)
    }

    /// False positives of whole images and of the region.
    fn false_positives(&self, plan: &Plan) -> Result<Vec<FalsePositives>, EvalError> {
        new_false_positives(
            (&self.clean.matches, &self.clean.detections),
            (&self.cracked.matches, &self.cracked.detections),
            FalsePositiveAreas {
                clean_coverage: &self.clean.coverage,
                cracked_coverage: &self.cracked.coverage,
                region_px: &self.region_px,
                image_px: &self.image_px,
                tau: 0.05,
            },
            SCORE,
            plan,
        )
    }
}

/// A sample of a law from a number on.
pub(crate) fn sample(law: Law, n_images: u32, number: u64) -> Sample {
    let first = number * u64::from(n_images);
    let images: Vec<Image> = (0..u64::from(n_images))
        .map(|k| image(law, first + k))
        .collect();
    let names: Vec<String> = (0..u64::from(n_images))
        .map(|k| ((first + k) / law.drive).to_string())
        .collect();
    let names: Vec<Option<&str>> = names.iter().map(|name| Some(name.as_str())).collect();
    Sample {
        clean: vec![matches(&images, 0); law.n_seeds],
        cracked: (1..=law.n_seeds)
            .map(|seed| matches(&images, seed))
            .collect(),
        pairs: (0..law.n_seeds)
            .flat_map(|seed| pairs(&images, seed, SCORE))
            .collect(),
        n_categories: N_CATEGORIES as usize,
        plan: Plan::of_clusters(&names).with(400, number, 0.95),
        boxes: Some(Boxes::of(&images)),
    }
}

impl Sample {
    /// All that the report would say of it.
    pub(crate) fn said(&self) -> Said {
        let mut said = Said::new();
        let mut put = |name: &'static str, measured: &Measured, test: Option<&TestOutcome>| {
            let interval = measured.interval.map(|it| [it.low, it.high]);
            said.insert(name, (interval, test.and_then(|test| test.p)));
        };
        let clean: Vec<&[ImageMatches]> = self.clean.iter().map(Vec::as_slice).collect();
        let cracked: Vec<&[ImageMatches]> = self.cracked.iter().map(Vec::as_slice).collect();
        // Fewer are refused by the report.
        let is_enough = |category: Option<u32>| {
            self.clean.iter().all(|set| {
                let of_class = set
                    .iter()
                    .filter(|item| category.is_none_or(|it| it == item.category));
                let objects = of_class.flat_map(|item| &item.objects);
                objects.filter(|object| !object.is_ignored).count() >= 20
            })
        };
        let found = paired_average_precision(&clean, &cracked, self.n_categories, &self.plan);
        if let Ok(found) = found {
            let all = &found.mean;
            if is_enough(None) {
                put(
                    "AP50, all classes: difference",
                    &all.difference,
                    Some(&all.test),
                );
                put("AP50, all classes: clean", &all.clean, None);
                put("AP50, all classes: cracked", &all.cracked, None);
            }
            if let Some(class) = found.categories.first().filter(|_| is_enough(Some(0))) {
                put(
                    "AP50, one class: difference",
                    &class.difference,
                    Some(&class.test),
                );
                put("AP50, one class: clean", &class.clean, None);
            }
        }
        // Each seed as if it were a kind of crack of its own.
        let cells: Vec<usize> = (0..self.cracked.len()).collect();
        let sides = self.clean.iter().zip(&self.cracked);
        let sets: Result<Vec<DrawnMean>, EvalError> = sides
            .map(|(clean, cracked)| {
                let n_categories = self.n_categories;
                let drawn = DrawnPrecisions::of_matches(clean, cracked, n_categories, &self.plan)?;
                Ok(drawn.mean())
            })
            .collect();
        let means = sets.and_then(|sets| measured_performance(&sets, false, &cells, &self.plan));
        if let Ok([_, mpc, rpc]) = means
            && is_enough(None)
        {
            put("mPC: cracked", &mpc, None);
            put("rPC", &rpc, None);
        }
        if let Some(boxes) = &self.boxes {
            let of_seed = self.pairs.get(..boxes.labels.objects.len());
            if let Ok(rate) = boxes.flips(of_seed.unwrap_or_default(), &self.plan) {
                put("flip rate", &rate, None);
            }
            if let Ok([whole, region, ..]) = boxes.false_positives(&self.plan).as_deref() {
                put("new false positives per Mpx", &whole.new_per_mpx, None);
                put(
                    "new false positives per Mpx, region",
                    &region.new_per_mpx,
                    None,
                );
                put("more false positives", &whole.more_per_image, None);
            }
        }
        let tau = 0.05;
        for (name, category) in [("all classes", None), ("one class", Some(0))] {
            let group = Group {
                category,
                place: Where::Region { tau },
            };
            let members = || {
                self.pairs.iter().filter(move |pair| {
                    pair.coverage >= tau && category.is_none_or(|it| it == pair.category)
                })
            };
            let n_found = members().filter(|pair| pair.clean.is_some()).count();
            let (Ok(rates), Ok(shift)) = (
                failure_rates(group.clone(), members(), &self.plan),
                shifts(group, members(), &self.plan),
            ) else {
                continue;
            };
            if n_found < 20 || shift.n_pairs < 20 {
                continue;
            }
            let names = match name {
                "all classes" => ["failure rate, all classes", "score shift, all classes"],
                _ => ["failure rate, one class", "score shift, one class"],
            };
            put(names[0], &rates.failure_rate, Some(&rates.test));
            put(names[1], &shift.score.mean, Some(&shift.score.test));
            if category.is_none() {
                let doses = members().map(|pair| (pair, pair.coverage));
                if let Ok(dose) = dose_response("coverage", doses, &[0.0, 1.0], &self.plan) {
                    put("slope over coverage", &dose.slope, Some(&dose.test));
                }
            }
        }
        said
    }
}

/// The same of a population as large as `n_images`: the truth, as far as so many images know it. Where they come in
/// drives of four, AP of 20,000 is off by 0.004 to 0.01, a fifth of the standard error of 300 images.
pub(crate) fn truth(law: Law, n_images: u64) -> BTreeMap<&'static str, f64> {
    let images: Vec<Image> = (0..n_images)
        .into_par_iter()
        .map(|k| image(law, (1 << 40) + k))
        .collect();
    let ones = vec![1; images.len()];
    let of = |version: usize| rank_by_category(&matches(&images, version), N_CATEGORIES as usize);
    let mean = |set: &[RankedCategory]| {
        let aps: Vec<f64> = set
            .iter()
            .filter_map(|it| it.average_precision(&ones))
            .collect();
        aps.iter().sum::<f64>() / aps.len() as f64
    };
    let first = |set: &[RankedCategory]| set[0].average_precision(&ones).unwrap_or(f64::NAN);
    let (clean, cracked) = (of(0), of(1));
    let mut truth = BTreeMap::new();
    let is_null = law.effect == 0.0;
    let unless_null = |value: f64| if is_null { 0.0 } else { value };
    truth.insert("AP50, all classes: clean", mean(&clean));
    truth.insert("AP50, all classes: cracked", mean(&cracked));
    let difference = unless_null(mean(&cracked) - mean(&clean));
    truth.insert("AP50, all classes: difference", difference);
    truth.insert("AP50, one class: clean", first(&clean));
    let difference = unless_null(first(&cracked) - first(&clean));
    truth.insert("AP50, one class: difference", difference);
    // All versions are of one law.
    truth.insert("mPC: cracked", mean(&cracked));
    let rpc = mean(&cracked) / mean(&clean);
    truth.insert("rPC", if is_null { 1.0 } else { rpc });
    let all = pairs(&images, 0, SCORE);
    let plan = Plan::of_images(u32::try_from(n_images).unwrap_or(u32::MAX));
    let members: Vec<&ObjectPair> = all.iter().filter(|pair| pair.coverage >= 0.05).collect();
    let group = Group {
        category: None,
        place: Where::Image,
    };
    let value = |measured: &Measured| measured.value.unwrap_or(f64::NAN);
    let boxes = Boxes::of(&images);
    if let Ok(rate) = boxes.flips(&all, &plan) {
        truth.insert("flip rate", value(&rate));
    }
    if let Ok([whole, region, ..]) = boxes.false_positives(&plan).as_deref() {
        let per_mpx = value(&whole.new_per_mpx);
        truth.insert("new false positives per Mpx", per_mpx);
        let per_mpx = value(&region.new_per_mpx);
        truth.insert("new false positives per Mpx, region", per_mpx);
        let more = unless_null(value(&whole.more_per_image));
        truth.insert("more false positives", more);
    }
    if let Ok(rates) = failure_rates(group.clone(), members.iter().copied(), &plan) {
        // Nothing tells the classes apart but how common they are.
        truth.insert("failure rate, all classes", value(&rates.failure_rate));
        truth.insert("failure rate, one class", value(&rates.failure_rate));
    }
    if let Ok(shift) = shifts(group, members.iter().copied(), &plan) {
        let value = unless_null(value(&shift.score.mean));
        truth.insert("score shift, all classes", value);
        truth.insert("score shift, one class", value);
    }
    let doses = members.iter().map(|pair| (*pair, pair.coverage));
    if let Ok(dose) = dose_response("coverage", doses, &[0.0, 1.0], &plan) {
        truth.insert(
            "slope over coverage",
            unless_null(value(&dose.fit.slope.estimate)),
        );
    }
    truth
}

/// How often what many samples say is wrong. A p below 0.05 is so where nothing differs.
pub(crate) fn wrong(
    n_samples: u64,
    truth: &BTreeMap<&'static str, f64>,
    sample: impl Fn(u64) -> Sample + Sync,
) -> BTreeMap<&'static str, Wrong> {
    let all: Vec<Said> = (0..n_samples)
        .into_par_iter()
        .map(|number| sample(number).said())
        .collect();
    let mut table = BTreeMap::<&'static str, Wrong>::new();
    for (name, (interval, p)) in all.into_iter().flatten() {
        let Some(truth) = truth.get(name) else {
            continue;
        };
        let row = table.entry(name).or_default();
        let beside = |value: f64| interval.map(|[low, high]| value < low || value > high);
        row.n_intervals += u32::from(interval.is_some());
        row.n_beside += u32::from(beside(*truth) == Some(true));
        row.n_tests += u32::from(p.is_some());
        row.n_below += u32::from(p.is_some_and(|p| p < 0.05));
        // The p of a rate asks for lost against recovered, not for a rate of 0.
        let both = beside(0.0)
            .zip(p)
            .filter(|_| !name.starts_with("failure rate"));
        row.n_disagree += u32::from(both.is_some_and(|(beside, p)| beside != (p < 0.05)));
    }
    table
}
