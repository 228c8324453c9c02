//! One set of detections, or clean against cracked, by a protocol: all that has no statistics.

mod compared;
mod pairs;
mod precision;

pub use compared::{Compared, compare_pair};
pub(crate) use precision::MIN_OBJECTS;
pub use precision::{SubsetAp, SubsetParams, subset_curves, subset_precision};

use serde::{Deserialize, Serialize};

use crate::evaluation::{
    Counts, Estimate, Group, GroupAp, GroupKind, KittiAp, PairedMetric, PairedRow, PrecisionCurves,
    ProtocolResults, Scope, ScopeKind,
};
use crate::protocol::{Boxes, evaluate_boxes};
use crate::{
    AreaRange, CocoEvaluation, CocoParams, CoverageOf, Coverages, EvalError, GroundTruth,
    KittiCurve, Protocol, RegionMasks, SaidDetections, Size, Subset, evaluate_coco, evaluate_kitti,
};

/// How to compare.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareParams {
    /// How MS-COCO's protocol is carried out, and BDD100K's.
    pub coco: CocoParams,
    /// Least coverages of what is in the region; the first one counts first, and is that of sizes.
    /// 0 stands for the region touching a box. **Default** 0.05, 0, 0.2.
    pub taus: Vec<f64>,
    /// Fewer objects than these, and a number in a region is refused. **Default** 20; 41 with
    /// KITTI's protocol.
    pub min_objects: u64,
}

impl CompareParams {
    /// The defaults of a protocol.
    #[must_use]
    pub fn of(protocol: Protocol) -> Self {
        Self {
            coco: CocoParams::default(),
            taus: vec![0.05, 0.0, 0.2],
            min_objects: match protocol {
                Protocol::Kitti => 41,
                Protocol::Coco | Protocol::Bdd => MIN_OBJECTS,
            },
        }
    }

    /// τ that counts first.
    #[must_use]
    pub fn tau(&self) -> f64 {
        self.taus.first().copied().unwrap_or(0.05)
    }
}

/// Ends of the bins of coverage; 1 is in the last.
pub(crate) const COVERAGE_BINS: [f64; 6] = [0.0, 0.05, 0.2, 0.4, 0.7, 1.0];

/// A set of detections as a protocol sees it.
#[derive(Debug, Clone)]
pub struct Evaluated {
    /// The numbers.
    pub results: ProtocolResults,
    /// The curves of MS-COCO's protocol.
    pub coco: Option<CocoEvaluation>,
    /// The curves of KITTI's protocol.
    pub kitti: Vec<KittiCurve>,
}

/// Clean against cracked in one part of the dataset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SubsetRow {
    /// Which objects: `small in region`, `coverage 0.05 to 0.2`.
    pub subset: String,
    /// Of which group.
    pub group: Group,
    /// Objects to be found.
    pub n_objects: u64,
    /// Images with at least one of them.
    pub n_images: u64,
    /// AP at IoU 0.5 of the clean images.
    pub clean_ap50: Estimate,
    /// AP at IoU 0.5 of the cracked images.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cracked_ap50: Option<Estimate>,
}

/// Numbers of the region.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RegionResults {
    /// In the region by each least coverage, out of it, and everywhere.
    pub paired: Vec<PairedRow>,
    /// In the region by the first of these, and everywhere.
    pub curves: Vec<PrecisionCurves>,
    /// By bin of coverage, and by size in the region.
    pub subsets: Vec<SubsetRow>,
}

/// The protocol's numbers on whole images.
///
/// # Errors
/// [`EvalError::Rule`] for parameters that make no sense.
pub fn evaluate(
    truth: &GroundTruth,
    said: &SaidDetections,
    params: &CompareParams,
) -> Result<Evaluated, EvalError> {
    let n_detections = count(said.detections.items.len());
    if let (Protocol::Kitti, Some(labels), Some(detections)) =
        (truth.protocol, &truth.kitti, &said.kitti)
    {
        let kitti = evaluate_kitti(labels, detections, None)?;
        return Ok(Evaluated {
            results: ProtocolResults {
                kitti: kitti.iter().map(kitti_ap).collect(),
                n_detections,
                ..ProtocolResults::default()
            },
            coco: None,
            kitti,
        });
    }
    let coco = evaluate_coco(&truth.labels, &said.detections, &params.coco, None)?;
    let stats = coco
        .stats()
        .map(|stats| stats.map(|stat| (stat > -1.0).then_some(stat)));
    Ok(Evaluated {
        results: ProtocolResults {
            coco_stats: stats,
            groups: groups(truth, said, params, &coco)?,
            kitti: Vec::new(),
            n_detections,
        },
        coco: Some(coco),
        kitti: Vec::new(),
    })
}

/// Average precisions of all, of pooled supercategories and of classes that have objects.
fn groups(
    truth: &GroundTruth,
    said: &SaidDetections,
    params: &CompareParams,
    coco: &CocoEvaluation,
) -> Result<Vec<GroupAp>, EvalError> {
    let labels = &truth.labels;
    let Some(cap) = params.coco.max_detections.len().checked_sub(1) else {
        return Ok(Vec::new());
    };
    let is_all = |range: &AreaRange| range.name == "all";
    let range = params.coco.area_ranges.iter().position(is_all).unwrap_or(0);
    // Of all objects it is the protocol's own number, however few they are.
    let is_few = |group: &Group, n: u64| group.kind != GroupKind::All && n < params.min_objects;
    let row = |coco: &CocoEvaluation, group: Group, categories: &[usize], range, cap, n| {
        let every: Vec<usize> = (0..coco.params.iou_thresholds.len()).collect();
        let at = |iou: f64| -> Vec<usize> { coco.threshold(iou).into_iter().collect() };
        let figure = |thresholds: &[usize]| match thresholds.is_empty() {
            true => Estimate::refused(n, "not among the IoU thresholds"),
            false if is_few(&group, n) => Estimate::few(n, params.min_objects),
            false => match coco.average_precision(thresholds, categories, range, cap) {
                Some(ap) => Estimate::of(ap, n),
                None => Estimate::refused(n, "no objects"),
            },
        };
        let [ap, ap50, ap75] = [every, at(0.5), at(0.75)].map(|it| figure(&it));
        GroupAp {
            group,
            n_objects: n,
            ap,
            ap50,
            ap75,
        }
    };
    let counts = objects_per_category(Boxes::of(labels, &said.detections));
    let all: Vec<usize> = (0..coco.n_categories).collect();
    let mut rows = vec![row(
        coco,
        Group::all(),
        &all,
        range,
        cap,
        counts.iter().sum(),
    )];
    if !params.coco.by_category {
        return Ok(rows);
    }
    if let Some(pooling) = labels.by_supercategory() {
        let one = CocoParams {
            area_ranges: params
                .coco
                .area_ranges
                .get(range)
                .cloned()
                .into_iter()
                .collect(),
            max_detections: params
                .coco
                .max_detections
                .get(cap)
                .copied()
                .into_iter()
                .collect(),
            ..params.coco.clone()
        };
        let pooled = Boxes {
            pooling: Some(&pooling),
            ..Boxes::of(labels, &said.detections)
        };
        let pooled_coco = evaluate_boxes(pooled, &one, None)?;
        let counts = objects_per_category(pooled);
        let every: Vec<usize> = (0..pooled.n_categories()).collect();
        let n = counts.iter().sum();
        let mean = Group::mean_of_supercategories();
        rows.push(row(&pooled_coco, mean, &every, 0, 0, n));
        for (idx, (category, n)) in pooling.categories.iter().zip(counts).enumerate() {
            let group = group_of(GroupKind::Supercategory, &category.name);
            rows.push(row(&pooled_coco, group, &[idx], 0, 0, n));
        }
    }
    for (idx, (category, n)) in labels.categories.iter().zip(counts).enumerate() {
        if n > 0 {
            let group = group_of(GroupKind::Class, &category.name);
            rows.push(row(coco, group, &[idx], range, cap, n));
        }
    }
    Ok(rows)
}

fn group_of(kind: GroupKind, name: &str) -> Group {
    Group {
        kind,
        name: name.to_owned(),
    }
}

/// Objects to be found of each category.
fn objects_per_category(boxes: Boxes<'_>) -> Vec<u64> {
    let mut counts = vec![0; boxes.n_categories()];
    for object in &boxes.labels.objects {
        let idx = usize::try_from(boxes.category(object.category)).unwrap_or(usize::MAX);
        if let (true, Some(n)) = (object.is_to_be_found(), counts.get_mut(idx)) {
            *n += 1;
        }
    }
    counts
}

fn count(n: usize) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}

fn kitti_ap(curve: &KittiCurve) -> KittiAp {
    let [ceiling11, ceiling40] = KittiCurve::ceiling(curve.n_gt);
    // The curve of no object is one of zeros in KITTI's own program.
    let of = |percent: f64| match curve.n_gt {
        0 => Estimate::refused(0, "no objects"),
        n => Estimate::of(percent / 100.0, n),
    };
    KittiAp {
        class: curve.class.name().to_owned(),
        difficulty: curve.difficulty.name().to_owned(),
        min_overlap: curve.class.min_overlap(),
        n_objects: curve.n_gt,
        ap11: of(curve.ap11()),
        ap40: of(curve.ap40()),
        ceiling_ap11: ceiling11 / 100.0,
        ceiling_ap40: ceiling40 / 100.0,
    }
}

/// How much there is, and how much of every box the regions cover, of one set of detections or of
/// clean and cracked.
///
/// # Errors
/// As [`RegionMasks::coverages`].
pub(crate) fn cover(
    truth: &GroundTruth,
    sets: &[&SaidDetections],
    masks: Option<RegionMasks<'_>>,
    tau: f64,
) -> Result<(Counts, Option<Coverages>), EvalError> {
    let labels = &truth.labels;
    let regular = |o: &&crate::Object| o.is_to_be_found();
    let mut counts = Counts {
        n_images: count(labels.images.len()),
        n_objects: count(labels.objects.iter().filter(regular).count()),
        ..Counts::default()
    };
    let Some(masks) = masks else {
        return Ok((counts, None));
    };
    let detections: Vec<_> = sets.iter().map(|said| &said.detections).collect();
    let coverages = masks.coverages(labels, &detections)?;
    let least = if tau <= 0.0 { f64::from_bits(1) } else { tau };
    let objects = labels.objects.iter().zip(&coverages.objects);
    let inside = objects.filter(|(o, c)| regular(o) && **c >= least).count();
    counts.n_objects_in_region = Some(count(inside));
    counts.n_images_with_region = Some(count(coverages.n_images_with_region()));
    counts.n_images_intact = Some(count(coverages.n_images_intact()));
    counts.mean_region_share = coverages.mean_region_share();
    Ok((counts, Some(coverages)))
}

/// Clean against cracked in the region, out of it and everywhere, by bin of coverage and by size;
/// the cracked numbers are missing where there are no cracked detections.
///
/// # Errors
/// [`EvalError::Rule`] where clean and cracked are not of the same frames, or for parameters that
/// make no sense.
pub(crate) fn compare_in_regions(
    truth: &GroundTruth,
    clean: &SaidDetections,
    cracked: Option<&SaidDetections>,
    coverages: &Coverages,
    params: &CompareParams,
) -> Result<RegionResults, EvalError> {
    let mut results = RegionResults::default();
    let of_set = |idx: usize| CoverageOf {
        objects: &coverages.objects,
        detections: coverages.detections.get(idx).map_or(&[], Vec::as_slice),
    };
    let scopes = scopes_of(&params.taus);
    if truth.protocol == Protocol::Kitti {
        for (scope, subset) in &scopes {
            let one = kitti_rows(truth, clean, of_set(0), subset)?;
            let other = match cracked {
                Some(cracked) => Some(kitti_rows(truth, cracked, of_set(1), subset)?),
                None => None,
            };
            kitti_pairs(&mut results.paired, scope, &one, other.as_deref(), params);
        }
        return Ok(results);
    }
    let subset_params = SubsetParams {
        max_detections: params.coco.max_detections.last().copied().unwrap_or(100),
        min_objects: params.min_objects,
    };
    let both = |subset: &Subset| -> Result<(Vec<SubsetAp>, Option<Vec<SubsetAp>>), EvalError> {
        let rows = |said: &SaidDetections, idx: usize| {
            let labels = &truth.labels;
            subset_precision(labels, &said.detections, of_set(idx), subset, subset_params)
        };
        let other = cracked.map(|cracked| rows(cracked, 1)).transpose()?;
        Ok((rows(clean, 0)?, other))
    };
    // A class without any object in a place has no row there.
    let is_there = |row: &SubsetAp| row.group.kind != GroupKind::Class || row.n_objects > 0;
    for (scope, subset) in &scopes {
        let (clean, cracked) = both(subset)?;
        if scope.kind != ScopeKind::OutOfRegion
            && scope.is_at(Some(params.tau()))
            && let (Some(one), Some(other)) =
                (clean.first(), cracked.as_ref().and_then(|c| c.first()))
            && !one.curve50.is_empty()
        {
            results.curves.push(PrecisionCurves {
                scope: scope.clone(),
                clean: one.curve50.clone(),
                cracked: other.curve50.clone(),
            });
        }
        for (idx, row) in clean.iter().enumerate().filter(|(_, row)| is_there(row)) {
            let other = cracked.as_ref().and_then(|rows| rows.get(idx));
            for metric in [PairedMetric::Ap50, PairedMetric::Ap75, PairedMetric::Ap] {
                let figure = |row: &SubsetAp| match metric {
                    PairedMetric::Ap50 => row.ap50.clone(),
                    PairedMetric::Ap75 => row.ap75.clone(),
                    _ => row.ap.clone(),
                };
                let counts = (row.n_objects, row.n_images);
                let pair = (figure(row), other.map(figure));
                results
                    .paired
                    .push(pair_of(scope, &row.group, metric, counts, pair, None));
            }
        }
    }
    for (name, subset) in parts_of_region(params.tau()) {
        let (clean, cracked) = both(&subset)?;
        for (idx, row) in clean.iter().enumerate().filter(|(_, row)| is_there(row)) {
            let other = cracked.as_ref().and_then(|rows| rows.get(idx));
            results.subsets.push(SubsetRow {
                subset: name.clone(),
                group: row.group.clone(),
                n_objects: row.n_objects,
                n_images: row.n_images,
                clean_ap50: row.ap50.clone(),
                cracked_ap50: other.map(|row| row.ap50.clone()),
            });
        }
    }
    Ok(results)
}

/// Whole images, and for each coverage that an object must have, in the region and out of it.
fn scopes_of(taus: &[f64]) -> Vec<(Scope, Subset)> {
    let mut scopes = vec![(Scope::whole_image(), Subset::WholeImage)];
    for tau in taus {
        let scope = |kind| Scope {
            kind,
            tau: Some(*tau),
        };
        scopes.push((scope(ScopeKind::InRegion), Subset::InRegion { tau: *tau }));
        let out = Subset::OutOfRegion { tau: *tau };
        scopes.push((scope(ScopeKind::OutOfRegion), out));
    }
    scopes
}

/// Parts of the region: by bins of coverage and by size of object, with their names.
fn parts_of_region(tau: f64) -> Vec<(String, Subset)> {
    let bins = COVERAGE_BINS.array_windows().map(|[least, below]| {
        let (least, below) = (*least, *below);
        let name = format!("coverage {least} to {below}");
        (name, Subset::CoverageBin { least, below })
    });
    let sizes = Size::ALL.map(|size| {
        let name = format!("{} in region", size.name());
        (name, Subset::SizeInRegion { size, tau })
    });
    bins.chain(sizes).collect()
}

fn kitti_rows(
    truth: &GroundTruth,
    said: &SaidDetections,
    coverage: CoverageOf<'_>,
    subset: &Subset,
) -> Result<Vec<KittiCurve>, EvalError> {
    let (Some(labels), Some(detections)) = (&truth.kitti, &said.kitti) else {
        return Ok(Vec::new());
    };
    let values = subset.values(&labels.set, &detections.set, coverage)?;
    evaluate_kitti(labels, detections, Some(&values.restriction()))
}

fn kitti_pairs(
    rows: &mut Vec<PairedRow>,
    scope: &Scope,
    clean: &[KittiCurve],
    cracked: Option<&[KittiCurve]>,
    params: &CompareParams,
) {
    for (idx, curve) in clean.iter().enumerate() {
        if curve.difficulty != crate::KittiDifficulty::Moderate {
            continue;
        }
        let n = curve.n_gt;
        let [ceiling11, ceiling40] = KittiCurve::ceiling(n);
        for metric in [PairedMetric::KittiAp11, PairedMetric::KittiAp40] {
            let is_11 = metric == PairedMetric::KittiAp11;
            let figure = |curve: &KittiCurve| match n < params.min_objects {
                true => Estimate::few(n, params.min_objects),
                false if is_11 => Estimate::of(curve.ap11() / 100.0, n),
                false => Estimate::of(curve.ap40() / 100.0, n),
            };
            let other = cracked.and_then(|curves| curves.get(idx)).map(figure);
            let group = group_of(GroupKind::Class, curve.class.name());
            let ceiling = if is_11 { ceiling11 } else { ceiling40 } / 100.0;
            let counts = (n, curve.n_images);
            let pair = (figure(curve), other);
            rows.push(pair_of(scope, &group, metric, counts, pair, Some(ceiling)));
        }
    }
}

fn pair_of(
    scope: &Scope,
    group: &Group,
    metric: PairedMetric,
    (n_objects, n_images): (u64, u64),
    (clean, cracked): (Estimate, Option<Estimate>),
    ceiling: Option<f64>,
) -> PairedRow {
    let missing = || Estimate::refused(n_objects, "no detections on the damaged side");
    let cracked = cracked.unwrap_or_else(missing);
    let delta = match (clean.value, cracked.value) {
        (Some(clean), Some(cracked)) => Estimate::of(cracked - clean, n_objects),
        _ => {
            let why = clean.refused.as_ref().or(cracked.refused.as_ref());
            Estimate::refused(n_objects, why.map_or("", String::as_str))
        }
    };
    PairedRow {
        scope: scope.clone(),
        group: group.clone(),
        metric,
        n_objects,
        n_images,
        clean,
        cracked,
        delta,
        p: None,
        p_holm: None,
        ceiling: ceiling.filter(|ceiling| *ceiling < 1.0),
    }
}
