//! Average precision inside of a part of a dataset, by the rules of MS-COCO: `region-ap/1`.

use crate::evaluation::{Estimate, Group, GroupKind};
use crate::protocol::{Boxes, evaluate_boxes};
use crate::{
    AreaRange, CocoEvaluation, CocoParams, CoverageOf, Detections, EvalError, LabelSet, Subset,
    SubsetValues,
};

/// Fewer objects than these, and there is no average precision.
pub(crate) const MIN_OBJECTS: u64 = 20;

/// Average precision of one group in one subset.
#[derive(Debug, Clone, PartialEq)]
pub struct SubsetAp {
    /// Of which objects.
    pub group: Group,
    /// Objects to be found.
    pub n_objects: u64,
    /// Images with at least one of them.
    pub n_images: u64,
    /// Average precision, mean over all thresholds of overlap.
    pub ap: Estimate,
    /// Average precision at IoU 0.5.
    pub ap50: Estimate,
    /// Average precision at IoU 0.75.
    pub ap75: Estimate,
    /// Precision at the recalls 0, 0.01, …, 1 and IoU 0.5, the mean over the classes; its own mean is
    /// [`ap50`](Self::ap50), without which it is empty.
    pub curve50: Vec<f64>,
}

/// Which groups, and how many detections per image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SubsetParams {
    /// The most detections of a category in an image. **Default** 100.
    pub max_detections: u32,
    /// Fewer objects than these, and there is no number but the reason. **Default** 20.
    pub min_objects: u64,
}

impl Default for SubsetParams {
    fn default() -> Self {
        Self {
            max_detections: 100,
            min_objects: MIN_OBJECTS,
        }
    }
}

/// Average precision of all classes (the mean of those with objects), of each supercategory with
/// its classes pooled and their mean, and of each class, of one subset. Where coverages are not at hand, the
/// subset must be [`Subset::WholeImage`], and sizes and coverages do not count.
///
/// # Errors
/// As [`Subset::values`] and [`evaluate_coco`](crate::evaluate_coco).
pub fn subset_precision(
    labels: &LabelSet,
    detections: &Detections,
    coverage: CoverageOf<'_>,
    subset: &Subset,
    params: SubsetParams,
) -> Result<Vec<SubsetAp>, EvalError> {
    let boxes = Boxes::of(labels, detections);
    let values = subset.values(labels, detections, coverage)?;
    let mut rows = one_kind(boxes, &values, params, GroupKind::Class)?;
    if let Some(pooling) = labels.by_supercategory() {
        let pooled = Boxes {
            pooling: Some(&pooling),
            ..boxes
        };
        let groups = one_kind(pooled, &values, params, GroupKind::Supercategory)?;
        // Behind the row of all; that of all groups is their mean.
        let groups = groups.into_iter().map(|row| match row.group.kind {
            GroupKind::All => SubsetAp {
                group: Group::mean_of_supercategories(),
                ..row
            },
            _ => row,
        });
        rows.splice(1..1, groups);
    }
    Ok(rows)
}

/// The curves of a subset, with the one range that the subset is, and one number of detections.
///
/// # Errors
/// As [`Subset::values`] and [`evaluate_coco`](crate::evaluate_coco).
pub fn subset_curves(
    labels: &LabelSet,
    detections: &Detections,
    coverage: CoverageOf<'_>,
    subset: &Subset,
    max_detections: u32,
) -> Result<CocoEvaluation, EvalError> {
    let values = subset.values(labels, detections, coverage)?;
    curves_of(Boxes::of(labels, detections), &values, max_detections)
}

fn curves_of(
    boxes: Boxes<'_>,
    values: &SubsetValues,
    max_detections: u32,
) -> Result<CocoEvaluation, EvalError> {
    let restriction = values.restriction();
    let coco = CocoParams {
        max_detections: vec![max_detections],
        area_ranges: vec![AreaRange::new("subset", restriction.range)],
        ..CocoParams::default()
    };
    evaluate_boxes(boxes, &coco, Some(&restriction))
}

fn one_kind(
    boxes: Boxes<'_>,
    values: &SubsetValues,
    params: SubsetParams,
    kind: GroupKind,
) -> Result<Vec<SubsetAp>, EvalError> {
    let labels = boxes.labels;
    let evaluation = curves_of(boxes, values, params.max_detections)?;
    let n_categories = boxes.n_categories();
    let mut n_objects = vec![0u64; n_categories];
    let mut images: Vec<Vec<u32>> = vec![Vec::new(); n_categories];
    for (object, is_counted) in labels.objects.iter().zip(values.counted(labels)) {
        let category = usize::try_from(boxes.category(object.category)).unwrap_or(usize::MAX);
        let of_category = n_objects.get_mut(category).zip(images.get_mut(category));
        if let (true, Some((n, images))) = (is_counted, of_category) {
            *n += 1;
            images.push(object.image);
        }
    }
    let count = |mut images: Vec<u32>| {
        images.sort_unstable();
        images.dedup();
        u64::try_from(images.len()).unwrap_or(u64::MAX)
    };
    let thresholds: Vec<usize> = (0..evaluation.params.iou_thresholds.len()).collect();
    let at = |iou: f64| -> Vec<usize> { evaluation.threshold(iou).into_iter().collect() };
    let figure = |thresholds: &[usize], categories: &[usize], n: u64| {
        if n < params.min_objects {
            return Estimate::few(n, params.min_objects);
        }
        match evaluation.average_precision(thresholds, categories, 0, 0) {
            Some(ap) => Estimate::of(ap, n),
            None => Estimate::refused(n, "no objects"),
        }
    };
    let row = |group: Group, categories: &[usize], n_objects: u64, n_images: u64| {
        let ap50 = figure(&at(0.5), categories, n_objects);
        let curve50 = match (ap50.value, at(0.5).first()) {
            (Some(_), Some(t)) => evaluation.precision_curve(*t, categories, 0, 0),
            _ => Vec::new(),
        };
        SubsetAp {
            group,
            n_objects,
            n_images,
            ap: figure(&thresholds, categories, n_objects),
            ap50,
            ap75: figure(&at(0.75), categories, n_objects),
            curve50,
        }
    };
    let all: Vec<usize> = (0..n_categories).collect();
    let all_images: Vec<u32> = images.iter().flatten().copied().collect();
    let mut rows = vec![row(
        Group::all(),
        &all,
        n_objects.iter().sum(),
        count(all_images),
    )];
    let of_categories = boxes.categories().iter().zip(n_objects.iter().zip(images));
    for (idx, (category, (n, images))) in of_categories.enumerate() {
        let group = Group {
            kind,
            name: category.name.clone(),
        };
        rows.push(row(group, &[idx], *n, count(images)));
    }
    Ok(rows)
}
