//! The protocol of MS-COCO.

use std::ops::Range;

use hotcoco::params::AreaRange as EngineRange;
use hotcoco::{COCOeval, EvalImg, Params};

use super::curve::{N_RECALLS, RankedMatches, mean_in_numpy_order};
use super::engine::{Boxes, Restriction, place_of, run, runs_of_categories};
use crate::{Detections, EvalError, LabelSet};

/// A range of areas, both ends in it.
#[derive(Debug, Clone, PartialEq)]
pub struct AreaRange {
    /// Its name: `all`, `small`, `medium`, `large`, or another.
    pub name: String,
    /// The least and the greatest area, px².
    pub area_px2: [f64; 2],
}

impl AreaRange {
    /// A range of this name.
    #[must_use]
    pub fn new(name: &str, area_px2: [f64; 2]) -> Self {
        Self {
            name: name.to_owned(),
            area_px2,
        }
    }
}

/// How to evaluate.
#[derive(Debug, Clone, PartialEq)]
pub struct CocoParams {
    /// Thresholds of overlap (IoU), 0 to 1. **Default** 0.5 to 0.95 in ten steps, as
    /// `numpy.linspace` has them.
    pub iou_thresholds: Vec<f64>,
    /// The most detections of a category in an image, one number per variant, rising. **Default**
    /// 1, 10, 100.
    pub max_detections: Vec<u32>,
    /// Ranges of areas. **Default** all, small (to 32² px²), medium (to 96² px²), large.
    pub area_ranges: Vec<AreaRange>,
    /// Whether a detection must be of the category of the object that it finds. **Default** true.
    pub by_category: bool,
    /// Whether a detection that finds an object of number 0 counts as having found nothing, as in
    /// pycocotools. **Default** false.
    pub has_gt_id_zero_quirk: bool,
}

impl Default for CocoParams {
    fn default() -> Self {
        let ranges = [
            ("all", [0.0, 1e10]),
            ("small", [0.0, 1024.0]),
            ("medium", [1024.0, 9216.0]),
            ("large", [9216.0, 1e10]),
        ];
        Self {
            iou_thresholds: Params::new(hotcoco::IouType::Bbox).iou_thrs,
            max_detections: vec![1, 10, 100],
            area_ranges: ranges
                .map(|(name, range)| AreaRange::new(name, range))
                .into(),
            by_category: true,
            has_gt_id_zero_quirk: false,
        }
    }
}

/// Most curves of precision over recall, of which each takes some 4 kB: thresholds times categories times ranges
/// of areas times numbers of detections.
const MOST_CURVES: usize = 400_000;

/// Most thresholds, ranges of areas, or numbers of detections: each is gone through for each detection.
const MOST_OF_A_KIND: usize = 1000;

impl CocoParams {
    fn check(&self, n_categories: usize) -> Result<(), EvalError> {
        let refuse = |reason: String| Err(EvalError::Rule(reason));
        let numbers = [
            self.iou_thresholds.len(),
            self.area_ranges.len(),
            self.max_detections.len(),
        ];
        let n_categories = if self.by_category { n_categories } else { 1 };
        let n_curves = numbers
            .iter()
            .fold(n_categories, |all, n| all.saturating_mul(*n));
        if numbers.iter().any(|n| *n > MOST_OF_A_KIND) || n_curves > MOST_CURVES {
            let [thresholds, ranges, most] = numbers;
            return refuse(format!(
                "{thresholds} thresholds of overlap, {ranges} ranges of areas, {most} numbers of detections and \
                 {n_categories} categories make {n_curves} curves; expected {MOST_CURVES} at most, and \
                 {MOST_OF_A_KIND} of a kind: ask for fewer"
            ));
        }
        let is_share = |t: &f64| (0.0..=1.0).contains(t);
        if self.iou_thresholds.is_empty() || !self.iou_thresholds.iter().all(is_share) {
            return refuse(format!(
                "thresholds of overlap {:?}; expected numbers from 0 to 1",
                self.iou_thresholds
            ));
        }
        if self.max_detections.is_empty() || self.max_detections.contains(&0) {
            return refuse(format!(
                "most detections per image {:?}; expected numbers from 1",
                self.max_detections
            ));
        }
        if !self.max_detections.is_sorted_by(|a, b| a < b) {
            return refuse(format!(
                "most detections per image {:?}; give each number once, rising",
                self.max_detections
            ));
        }
        let is_range = |range: &AreaRange| range.area_px2[0] <= range.area_px2[1];
        match self.area_ranges.iter().find(|range| !is_range(range)) {
            Some(range) => refuse(format!(
                "the range of areas {:?} is {:?} px²; the first must not be above the second",
                range.name, range.area_px2
            )),
            None => Ok(()),
        }
    }
}

/// Precision, recall and scores for each threshold, category, range of areas and number of
/// detections, laid out as in pycocotools; -1 where there is nothing to be found.
#[derive(Debug, Clone, PartialEq)]
pub struct CocoEvaluation {
    /// How it was evaluated.
    pub params: CocoParams,
    /// Categories: those of the labels in their order, or 1 where they do not count.
    pub n_categories: usize,
    /// The best precision at each recall or a higher one; the last index runs fastest: threshold,
    /// recall (101), category, range of areas, number of detections.
    pub precision: Vec<f64>,
    /// The highest recall: threshold, category, range of areas, number of detections.
    pub recall: Vec<f64>,
    /// The score that reaches each recall, laid out as the precision.
    pub scores: Vec<f64>,
}

/// Evaluates detections by the protocol of MS-COCO.
///
/// All arrays are equal to those of pycocotools 2.0.11 to the last bit. With a restriction, its
/// values stand in place of the areas, so that the ranges are those of its values and its own range
/// does not matter.
///
/// # Errors
/// [`EvalError::Rule`] for parameters that make no sense.
pub fn evaluate_coco(
    labels: &LabelSet,
    detections: &Detections,
    params: &CocoParams,
    values: Option<&Restriction<'_>>,
) -> Result<CocoEvaluation, EvalError> {
    evaluate_boxes(Boxes::of(labels, detections), params, values)
}

/// The same by categories or groups of them.
pub(crate) fn evaluate_boxes(
    boxes: Boxes<'_>,
    params: &CocoParams,
    values: Option<&Restriction<'_>>,
) -> Result<CocoEvaluation, EvalError> {
    let n_categories = boxes.n_categories();
    params.check(n_categories)?;
    if !params.by_category {
        return evaluate_run(boxes, params, values, &(0..n_categories));
    }
    let mut evaluation = CocoEvaluation::blank(params, n_categories);
    for categories in runs_of_categories(&[boxes]) {
        let part = evaluate_run(boxes, params, values, &categories)?;
        evaluation.put(&part, categories.start);
    }
    Ok(evaluation)
}

/// The same of some of the categories.
fn evaluate_run(
    boxes: Boxes<'_>,
    params: &CocoParams,
    values: Option<&Restriction<'_>>,
    categories: &Range<usize>,
) -> Result<CocoEvaluation, EvalError> {
    let mut engine = boxes.engine(values, categories)?;
    engine.params.iou_thrs.clone_from(&params.iou_thresholds);
    let caps = params.max_detections.iter();
    engine.params.max_dets = caps
        .map(|n| usize::try_from(*n).unwrap_or(usize::MAX))
        .collect();
    let ranges = params.area_ranges.iter().map(|range| EngineRange {
        label: range.name.clone(),
        range: range.area_px2,
    });
    engine.params.area_ranges = ranges.collect();
    engine.params.use_cats = params.by_category;
    run(&mut engine)?;
    let n_categories = match params.by_category {
        true => categories.len(),
        false => 1,
    };
    let mut evaluation = CocoEvaluation::blank(params, n_categories);
    let zero = boxes
        .labels
        .objects
        .iter()
        .position(|object| object.id == 0);
    match zero.filter(|_| params.has_gt_id_zero_quirk) {
        Some(zero) => {
            let first = categories.start;
            evaluation.accumulate(&engine, zero, values, boxes.detections, first);
        }
        None => {
            engine.accumulate();
            if let Some(curves) = engine.accumulated() {
                evaluation.precision.clone_from(&curves.precision);
                evaluation.recall.clone_from(&curves.recall);
                evaluation.scores.clone_from(&curves.scores);
            }
        }
    }
    Ok(evaluation)
}

impl CocoEvaluation {
    fn blank(params: &CocoParams, n_categories: usize) -> Self {
        let n_curves = params.iou_thresholds.len()
            * n_categories
            * params.area_ranges.len()
            * params.max_detections.len();
        Self {
            params: params.clone(),
            n_categories,
            precision: vec![-1.0; n_curves * N_RECALLS],
            recall: vec![-1.0; n_curves],
            scores: vec![-1.0; n_curves * N_RECALLS],
        }
    }

    /// Thresholds, recalls, categories, ranges of areas, numbers of detections.
    #[must_use]
    pub fn shape(&self) -> [usize; 5] {
        [
            self.params.iou_thresholds.len(),
            N_RECALLS,
            self.n_categories,
            self.params.area_ranges.len(),
            self.params.max_detections.len(),
        ]
    }

    /// Takes over the curves of a run of categories, the first of which is at this place.
    fn put(&mut self, part: &Self, first: usize) {
        let [_, _, n_k, n_a, n_m] = self.shape();
        let (of_whole, of_part) = (n_k * n_a * n_m, part.n_categories * n_a * n_m);
        let begin = first * n_a * n_m;
        for (to, from) in [
            (&mut self.precision, &part.precision),
            (&mut self.recall, &part.recall),
            (&mut self.scores, &part.scores),
        ] {
            let rows = to.chunks_mut(of_whole.max(1));
            for (row, values) in rows.zip(from.chunks(of_part.max(1))) {
                if let Some(slots) = row.get_mut(begin..begin + values.len()) {
                    slots.copy_from_slice(values);
                }
            }
        }
    }

    fn recall_at(&self, [t, k, a, m]: [usize; 4]) -> usize {
        let [_, _, n_k, n_a, n_m] = self.shape();
        ((t * n_k + k) * n_a + a) * n_m + m
    }

    fn precision_at(&self, [t, k, a, m]: [usize; 4], r: usize) -> usize {
        let [_, n_r, n_k, n_a, n_m] = self.shape();
        (((t * n_r + r) * n_k + k) * n_a + a) * n_m + m
    }

    /// The curves with the quirk of pycocotools about the object of number 0.
    fn accumulate(
        &mut self,
        engine: &COCOeval,
        zero: usize,
        values: Option<&Restriction<'_>>,
        detections: &Detections,
        first_category: usize,
    ) {
        let area_of = |detection: u32| {
            let idx = usize::try_from(detection).unwrap_or(usize::MAX);
            match values {
                Some(values) => values.detections.get(idx).copied(),
                None => detections.items.get(idx).map(|d| d.box_px.area_px2()),
            }
        };
        let [n_t, _, n_k, n_a, n_m] = self.shape();
        let cells = engine.eval_imgs();
        for (k, a) in (0..n_k).flat_map(|k| (0..n_a).map(move |a| (k, a))) {
            let Some(range) = self.params.area_ranges.get(a).map(|range| range.area_px2) else {
                continue;
            };
            // Each pair of image and category has one cell per range.
            let cells: Vec<&EvalImg> = cells
                .chunks(n_a.max(1))
                .filter_map(|of_pair| of_pair.get(a)?.as_ref())
                .filter(|cell| {
                    !self.params.by_category
                        || usize::try_from(cell.category_id) == Ok(first_category + k)
                })
                .collect();
            for t in 0..n_t {
                let mut ranked = RankedMatches::default();
                for cell in &cells {
                    let said = cell.dt_ids.iter().zip(&cell.dt_scores).enumerate();
                    let outcomes = said.map(|(rank, (id, score))| {
                        let is_lost = cell.dt_matched[(t, rank)]
                            && usize::try_from(place_of(cell.dt_matches[(t, rank)])) == Ok(zero);
                        let area = area_of(place_of(*id)).unwrap_or(0.0);
                        let is_outside = area < range[0] || area > range[1];
                        let is_ignored = cell.dt_ignore[(t, rank)] || (is_lost && is_outside);
                        let found = cell.dt_matched[(t, rank)] && !is_lost;
                        (*score, (!is_ignored).then_some(found))
                    });
                    let n_objects = cell.num_gt_in_denominator();
                    ranked.push(
                        u32::try_from(cell.image_id).unwrap_or(u32::MAX),
                        outcomes,
                        n_objects,
                    );
                }
                ranked.sort();
                for m in 0..n_m {
                    let cap = self.params.max_detections.get(m).copied().unwrap_or(0);
                    let Some(curve) = ranked.curve_of_first(cap, |_| 1) else {
                        continue;
                    };
                    let at = self.recall_at([t, k, a, m]);
                    if let Some(slot) = self.recall.get_mut(at) {
                        *slot = curve.recall;
                    }
                    for r in 0..N_RECALLS {
                        let at = self.precision_at([t, k, a, m], r);
                        let from = (curve.precision.get(r), curve.scores.get(r));
                        let to = (self.precision.get_mut(at), self.scores.get_mut(at));
                        if let ((Some(p), Some(s)), (Some(to_p), Some(to_s))) = (from, to) {
                            (*to_p, *to_s) = (*p, *s);
                        }
                    }
                }
            }
        }
    }

    /// The mean precision over all recalls, these thresholds and categories, and one range of areas
    /// and number of detections, by their places; nothing where there is nothing to be found.
    #[must_use]
    pub fn average_precision(
        &self,
        thresholds: &[usize],
        categories: &[usize],
        area_range: usize,
        max_detections: usize,
    ) -> Option<f64> {
        let mut values = Vec::with_capacity(thresholds.len() * N_RECALLS * categories.len());
        for &t in thresholds {
            for r in 0..N_RECALLS {
                let of_categories = categories.iter().filter_map(|&k| {
                    let at = self.precision_at([t, k, area_range, max_detections], r);
                    self.precision.get(at).copied()
                });
                values.extend(of_categories.filter(|value| *value > -1.0));
            }
        }
        mean_in_numpy_order(&values)
    }

    /// The mean over these categories of the precision at each of the 101 recalls, likewise; the mean of
    /// it is [`average_precision`](Self::average_precision). Empty where there is nothing to be found.
    #[must_use]
    pub(crate) fn precision_curve(
        &self,
        threshold: usize,
        categories: &[usize],
        area_range: usize,
        max_detections: usize,
    ) -> Vec<f64> {
        let at_recall = |r: usize| {
            let of_categories = categories.iter().filter_map(|&k| {
                let at = self.precision_at([threshold, k, area_range, max_detections], r);
                self.precision.get(at).copied()
            });
            let values: Vec<f64> = of_categories.filter(|value| *value > -1.0).collect();
            mean_in_numpy_order(&values)
        };
        (0..N_RECALLS).map_while(at_recall).collect()
    }

    /// The mean of the highest recalls, likewise.
    #[must_use]
    pub(crate) fn average_recall(
        &self,
        thresholds: &[usize],
        categories: &[usize],
        area_range: usize,
        max_detections: usize,
    ) -> Option<f64> {
        let mut values = Vec::with_capacity(thresholds.len() * categories.len());
        for &t in thresholds {
            let of_categories = categories.iter().filter_map(|&k| {
                let at = self.recall_at([t, k, area_range, max_detections]);
                self.recall.get(at).copied()
            });
            values.extend(of_categories.filter(|value| *value > -1.0));
        }
        mean_in_numpy_order(&values)
    }

    /// The place of a threshold, which must be there exactly.
    #[must_use]
    pub fn threshold(&self, iou: f64) -> Option<usize> {
        let is_it = |known: &f64| known.to_bits() == iou.to_bits();
        self.params.iou_thresholds.iter().position(is_it)
    }

    /// The twelve numbers of `summarize` in pycocotools, 0 to 1, -1 where there is nothing to be
    /// found: AP, AP50, AP75, AP of small, medium and large objects; AR with the three numbers of
    /// detections, AR of small, medium and large objects.
    ///
    /// The first is that of 100 detections, and -1 where that number is not among the three, as in
    /// pycocotools; [`average_precision`](Self::average_precision) gives that of any number.
    /// Nothing unless there are at least three numbers of detections.
    #[must_use]
    pub fn stats(&self) -> Option<[f64; 12]> {
        let [n_t, _, n_k, _, n_m] = self.shape();
        if n_m < 3 {
            return None;
        }
        let all: Vec<usize> = (0..n_t).collect();
        let categories: Vec<usize> = (0..n_k).collect();
        let cap_of = |n: u32| {
            self.params
                .max_detections
                .iter()
                .position(|known| *known == n)
        };
        let range_of = |name: &str| {
            let mut ranges = self.params.area_ranges.iter();
            ranges.position(|range| range.name == name)
        };
        let ap = |iou: Option<f64>, range: &str, cap: Option<usize>| {
            let thresholds = match iou {
                None => all.clone(),
                Some(iou) => self.threshold(iou).into_iter().collect(),
            };
            self.average_precision(&thresholds, &categories, range_of(range)?, cap?)
        };
        let ar = |range: &str, cap| self.average_recall(&all, &categories, range_of(range)?, cap);
        let stats = [
            ap(None, "all", cap_of(100)),
            ap(Some(0.5), "all", Some(2)),
            ap(Some(0.75), "all", Some(2)),
            ap(None, "small", Some(2)),
            ap(None, "medium", Some(2)),
            ap(None, "large", Some(2)),
            ar("all", 0),
            ar("all", 1),
            ar("all", 2),
            ar("small", 2),
            ar("medium", 2),
            ar("large", 2),
        ];
        Some(stats.map(|value| value.unwrap_or(-1.0)))
    }
}
