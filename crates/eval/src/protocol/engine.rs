//! The matching of detections with objects, by the library hotcoco.

use std::ops::Range;
use std::sync::Arc;

use hotcoco::params::{AreaRange as EngineRange, IouType};
use hotcoco::types::Category;
use hotcoco::{Annotation, COCO, COCOeval, Dataset, EvalImg, Extra, Image};

use crate::{
    Detections, EvalError, ImageMatches, LabelSet, MatchedDetection, MatchedObject, ObjectKind,
    Outcome, Pooling,
};

/// What counts and what is merely ignored, by one value per object and detection: objects outside
/// the range are not to be found, and a detection that finds one of them counts for nothing, nor
/// does a detection outside the range that finds nothing.
///
/// With areas this is the rule of sizes of MS-COCO, with coverages that of regions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restriction<'a> {
    /// A value per object, in the order of [`LabelSet::objects`].
    pub objects: &'a [f64],
    /// A value per detection, in the order of [`Detections::items`].
    pub detections: &'a [f64],
    /// The least and the greatest value that counts.
    pub range: [f64; 2],
}

impl Restriction<'_> {
    /// There is a value for each.
    pub(crate) fn check(&self, n_objects: usize, n_detections: usize) -> Result<(), EvalError> {
        let (of_objects, of_detections) = (self.objects.len(), self.detections.len());
        if (of_objects, of_detections) == (n_objects, n_detections) {
            return Ok(());
        }
        Err(EvalError::Rule(format!(
            "{of_objects} and {of_detections} values for {n_objects} objects and {n_detections} detections"
        )))
    }
}

/// How detections are matched with objects, as in MS-COCO: image by image, detections by falling
/// score, each taking the object that it overlaps most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchRule<'a> {
    /// The least overlap, intersection over union, 0 to 1.
    pub iou_threshold: f64,
    /// The most detections of a category in an image; those with the highest scores stay.
    pub max_detections: u32,
    /// What counts, if not all.
    pub region: Option<Restriction<'a>>,
}

impl Default for MatchRule<'_> {
    /// IoU 0.5, 100 detections, everything counts.
    fn default() -> Self {
        Self {
            iou_threshold: 0.5,
            max_detections: 100,
            region: None,
        }
    }
}

/// What became of all detections and objects, one entry per image and category that has any, by
/// image and then category.
///
/// # Errors
/// [`EvalError::StatisticSetting`] for a threshold outside 0 to 1, [`EvalError::Rule`] for values of another number
/// than the objects and detections.
pub fn match_images(
    labels: &LabelSet,
    detections: &Detections,
    rule: &MatchRule<'_>,
) -> Result<Vec<ImageMatches>, EvalError> {
    Boxes::of(labels, detections).all_matches(rule, |_| {})
}

/// Categories that are evaluated together: as many as have so many detections, so that the engine,
/// which holds some 300 bytes for each, does not hold all at once.
const RUN_DETECTIONS: usize = 50_000;

/// All categories of some sets of the same labels in runs, in their order.
pub(crate) fn runs_of_categories(sets: &[Boxes<'_>]) -> Vec<Range<usize>> {
    // The engine holds one set after the other.
    let mut counts = vec![0; sets.first().map_or(0, |set| set.n_categories())];
    for set in sets {
        for (most, count) in counts.iter_mut().zip(set.counts()) {
            *most = count.max(*most);
        }
    }
    let mut runs = Vec::new();
    let (mut start, mut n_in_run) = (0, 0);
    for (idx, count) in counts.iter().enumerate() {
        if n_in_run + count > RUN_DETECTIONS && idx > start {
            runs.push(start..idx);
            (start, n_in_run) = (idx, 0);
        }
        n_in_run += count;
    }
    runs.push(start..counts.len());
    runs
}

/// Objects and detections to be matched, by their own categories or by groups of these.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Boxes<'a> {
    pub(crate) labels: &'a LabelSet,
    pub(crate) detections: &'a Detections,
    pub(crate) pooling: Option<&'a Pooling>,
}

impl<'a> Boxes<'a> {
    pub(crate) fn of(labels: &'a LabelSet, detections: &'a Detections) -> Self {
        Self {
            labels,
            detections,
            pooling: None,
        }
    }

    /// Those that count, of the labels or groups of them.
    pub(crate) fn categories(&self) -> &'a [crate::Category] {
        let own = &self.labels.categories;
        self.pooling.map_or(own, |pooling| &pooling.categories)
    }

    pub(crate) fn n_categories(&self) -> usize {
        self.categories().len()
    }

    /// Detections of each category.
    fn counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.n_categories()];
        for detection in &self.detections.items {
            let idx = usize::try_from(self.category(detection.category)).unwrap_or(usize::MAX);
            if let Some(count) = counts.get_mut(idx) {
                *count += 1;
            }
        }
        counts
    }

    /// The one as which an object or a detection counts.
    pub(crate) fn category(&self, own: u32) -> u32 {
        self.pooling.map_or(own, |pooling| pooling.group(own))
    }

    /// What became of all of them, by image and then category. Of each run of categories only what `thin` leaves is held when
    /// the next is matched.
    ///
    /// # Errors
    /// As [`match_images`].
    pub(crate) fn all_matches(
        &self,
        rule: &MatchRule<'_>,
        thin: impl Fn(&mut Vec<ImageMatches>),
    ) -> Result<Vec<ImageMatches>, EvalError> {
        let mut all = Vec::new();
        for categories in runs_of_categories(&[*self]) {
            let mut matches = self.matches(rule, &categories)?;
            thin(&mut matches);
            all.extend(matches);
        }
        all.sort_by_key(|of_image: &ImageMatches| (of_image.image, of_image.category));
        Ok(all)
    }

    /// What became of those of some categories, one entry per image and category that has any.
    ///
    /// # Errors
    /// As [`match_images`].
    pub(crate) fn matches(
        &self,
        rule: &MatchRule<'_>,
        categories: &Range<usize>,
    ) -> Result<Vec<ImageMatches>, EvalError> {
        let threshold = rule.iou_threshold;
        if !(0.0..=1.0).contains(&threshold) {
            return Err(EvalError::StatisticSetting {
                what: "threshold of overlap",
                value: threshold,
                range: "from 0 to 1",
            });
        }
        let range = rule.region.map_or([0.0, 1e10], |region| region.range);
        let mut engine = self.engine(rule.region.as_ref(), categories)?;
        engine.params.iou_thrs = vec![threshold];
        engine.params.max_dets = vec![usize::try_from(rule.max_detections).unwrap_or(usize::MAX)];
        engine.params.area_ranges = vec![EngineRange {
            label: "all".to_owned(),
            range,
        }];
        run(&mut engine)?;
        let cells = engine.eval_imgs().iter().flatten();
        Ok(cells.map(|cell| self.of_cell(cell)).collect())
    }

    /// The engine with labels and detections of these categories, to be set up and run.
    ///
    /// Images and categories go by their places, objects and detections by their places plus one, as 0
    /// is no number to pycocotools.
    pub(super) fn engine(
        &self,
        restriction: Option<&Restriction<'_>>,
        categories: &Range<usize>,
    ) -> Result<COCOeval, EvalError> {
        let (labels, detections) = (self.labels, self.detections);
        let category_in = |own: u32| {
            let category = self.category(own);
            let is_in = usize::try_from(category).is_ok_and(|c| categories.contains(&c));
            is_in.then_some(u64::from(category))
        };
        if let Some(restriction) = restriction {
            restriction.check(labels.objects.len(), detections.items.len())?;
        }
        let images = (0u64..).zip(&labels.images).map(|(id, _)| Image {
            id,
            file_name: String::new(),
            height: 0,
            width: 0,
            license: None,
            coco_url: None,
            flickr_url: None,
            date_captured: None,
            neg_category_ids: Vec::new(),
            not_exhaustive_category_ids: Vec::new(),
            extra: Extra::default(),
        });
        let of_run = (0u64..).zip(self.categories());
        let of_run = of_run.skip(categories.start).take(categories.len());
        let kinds = of_run.map(|(id, category)| Category {
            id,
            name: category.name.clone(),
            supercategory: None,
            skeleton: None,
            keypoints: None,
            frequency: None,
            isthing: None,
            extra: Extra::default(),
        });
        let objects = labels.objects.iter().enumerate();
        let objects = objects.filter_map(|(idx, object)| {
            let value = restriction.and_then(|r| r.objects.get(idx)).copied();
            Some(Annotation {
                id: number_of(idx),
                image_id: u64::from(object.image),
                category_id: category_in(object.category)?,
                bbox: Some(numbers(&object.box_px)),
                area: Some(match object.kind {
                    // In no range: found once without error, and not to be found.
                    ObjectKind::Ignored => f64::NEG_INFINITY,
                    // One with an area below 0 is in no range of areas, so in none of other values either.
                    _ if object.area_px2 < 0.0 => {
                        value.map_or(object.area_px2, |_| f64::NEG_INFINITY)
                    }
                    _ => value.unwrap_or(object.area_px2),
                }),
                iscrowd: object.kind == ObjectKind::Crowd,
                ..blank()
            })
        });
        let found = detections.items.iter().enumerate();
        let found = found.filter_map(|(idx, detection)| {
            let value = restriction.and_then(|r| r.detections.get(idx)).copied();
            Some(Annotation {
                id: number_of(idx),
                image_id: u64::from(detection.image),
                category_id: category_in(detection.category)?,
                bbox: Some(numbers(&detection.box_px)),
                area: Some(value.unwrap_or_else(|| detection.box_px.area_px2())),
                score: Some(detection.score),
                ..blank()
            })
        });
        let is_in = |own: u32| category_in(own).is_some();
        let n_objects = labels.objects.iter().filter(|o| is_in(o.category)).count();
        let said = detections.items.iter();
        let n_found = said.filter(|d| is_in(d.category)).count();
        let set = |images: Vec<Image>, categories: Vec<Category>, annotations: Vec<Annotation>| {
            let dataset = Dataset {
                info: None,
                images,
                annotations,
                categories,
                licenses: Vec::new(),
            };
            Arc::new(COCO::from_dataset(dataset))
        };
        let truth = set(
            images.collect(),
            kinds.collect(),
            gathered(objects, n_objects),
        );
        let said = set(Vec::new(), Vec::new(), gathered(found, n_found));
        Ok(COCOeval::new(truth, said, IouType::Bbox))
    }

    /// What became of the detections and objects of a cell, at its one threshold.
    fn of_cell(&self, cell: &EvalImg) -> ImageMatches {
        let (labels, detections) = (self.labels, self.detections);
        let box_of_object = |object: u32| {
            let idx = usize::try_from(object).unwrap_or(usize::MAX);
            labels.objects.get(idx).map(|object| object.box_px)
        };
        let outcome_of = |rank: usize, detection: u32| {
            if cell.dt_ignore[(0, rank)] {
                return Outcome::Ignored;
            }
            if !cell.dt_matched[(0, rank)] {
                return Outcome::FalsePositive;
            }
            let object = place_of(cell.dt_matches[(0, rank)]);
            let idx = usize::try_from(detection).unwrap_or(usize::MAX);
            let boxes = box_of_object(object).zip(detections.items.get(idx));
            Outcome::TruePositive {
                object,
                iou: boxes.map_or(0.0, |(object, said)| object.iou(&said.box_px)),
            }
        };
        let said = cell.dt_ids.iter().zip(&cell.dt_scores).enumerate();
        let objects = cell.gt_ids.iter().zip(&cell.gt_ignore).enumerate();
        let small = |id: u64| u32::try_from(id).unwrap_or(u32::MAX);
        ImageMatches {
            image: small(cell.image_id),
            category: small(cell.category_id),
            detections: said
                .map(|(rank, (id, score))| MatchedDetection {
                    detection: place_of(*id),
                    score: *score,
                    outcome: outcome_of(rank, place_of(*id)),
                })
                .collect(),
            objects: objects
                .map(|(idx, (id, is_ignored))| MatchedObject {
                    object: place_of(*id),
                    is_ignored: *is_ignored,
                    detection: cell.gt_matched[(0, idx)]
                        .then(|| place_of(cell.gt_matches[(0, idx)])),
                })
                .collect(),
        }
    }
}

/// The annotations in room that is taken once, as they are large.
fn gathered(annotations: impl Iterator<Item = Annotation>, n: usize) -> Vec<Annotation> {
    let mut list = Vec::with_capacity(n);
    list.extend(annotations);
    list
}

pub(super) fn run(engine: &mut COCOeval) -> Result<(), EvalError> {
    engine
        .evaluate()
        .map_err(|error| EvalError::Rule(format!("hotcoco: {error}")))
}

fn number_of(idx: usize) -> u64 {
    u64::try_from(idx).map_or(u64::MAX, |idx| idx + 1)
}

/// The place of what has this number in the engine.
pub(super) fn place_of(number: u64) -> u32 {
    u32::try_from(number.saturating_sub(1)).unwrap_or(u32::MAX)
}

fn numbers(box_px: &crate::BoxPx) -> [f64; 4] {
    [box_px.x, box_px.y, box_px.width, box_px.height]
}

fn blank() -> Annotation {
    Annotation {
        id: 0,
        image_id: 0,
        category_id: 0,
        bbox: None,
        area: None,
        segmentation: None,
        iscrowd: false,
        keypoints: None,
        num_keypoints: None,
        obb: None,
        score: None,
        is_group_of: None,
        extra: Extra::default(),
    }
}
