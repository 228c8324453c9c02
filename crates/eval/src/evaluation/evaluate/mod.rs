//! Everything about one detector under one condition, from labels, detections and masks.

mod intervals;
mod mean_intervals;
mod over_conditions;
mod seeds;
mod side_results;
mod what_fails;
mod worst_images;

pub use over_conditions::OverConditions;

use std::borrow::Cow;
use std::path::Path;

use super::{CleanResults, Condition, DamageFacts, Evaluation, ProtocolResults, Settings, Warning};
use crate::evaluation::compare::{compare_in_regions, cover};
use crate::resampling::Plan;
use crate::tide::TideSettings;
use crate::{
    CompareParams, Compared, Coverages, Detections, EvalError, GroundTruth, LabelSet, Protocol,
    RegionMasks, RegionResults, SaidDetections,
};

/// What is evaluated.
#[derive(Debug, Clone, Copy)]
pub struct EvaluateInput<'a> {
    /// Name of the detector.
    pub detector: &'a str,
    /// What was done to the glass.
    pub condition: &'a Condition,
    /// The labels.
    pub truth: &'a GroundTruth,
    /// What the detector finds in the clean images.
    pub clean: &'a SaidDetections,
    /// What it finds in the cracked images; without it only the clean numbers are there.
    pub cracked: Option<&'a SaidDetections>,
    /// Where the cracks' region masks are; without them only whole images are compared.
    pub regions: Option<RegionMasks<'a>>,
    /// What the cracks did to each object of [`GroundTruth::labels`].
    pub facts: Option<&'a DamageFacts>,
    /// Where both kinds of images are, for pictures of the worst failures.
    pub images: Option<ImageFolders<'a>>,
    /// How.
    pub settings: &'a EvaluateSettings,
}

/// Where both kinds of images are.
#[derive(Debug, Clone, Copy)]
pub struct ImageFolders<'a> {
    /// Root of the clean images.
    pub clean: &'a Path,
    /// Root of the cracked images, with the same names.
    pub cracked: &'a Path,
}

/// How it is evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct EvaluateSettings {
    /// The protocol's own.
    pub compare: CompareParams,
    /// Score from which a detection counts as found, in rates of failure. **Default** 0.3.
    pub score_threshold: f64,
    /// Overlap from which it does. **Default** 0.5.
    pub iou_threshold: f64,
    /// Draws of the bootstrap, and of the permutation test. **Default** 1000.
    pub n_replicates: u32,
    /// Seed of both. **Default** 0.
    pub seed: u64,
    /// Level of confidence of all intervals. **Default** 0.95.
    pub level: f64,
    /// Worst failures that are shown. **Default** 6.
    pub n_worst: u32,
    /// Longer side of a picture in the report, px. **Default** 640.
    pub picture_side_px: u32,
    /// Quality of its JPEG, 1 to 100. **Default** 78.
    pub picture_quality: u8,
}

impl EvaluateSettings {
    /// The defaults of a protocol.
    #[must_use]
    pub fn of(protocol: Protocol) -> Self {
        Self {
            compare: CompareParams::of(protocol),
            score_threshold: crate::failure::SCORE_THRESHOLD,
            iou_threshold: 0.5,
            n_replicates: 1000,
            seed: 0,
            level: 0.95,
            n_worst: 6,
            picture_side_px: 640,
            picture_quality: 78,
        }
    }

    /// τ that counts first.
    #[must_use]
    pub fn tau(&self) -> f64 {
        self.compare.tau()
    }

    /// The same for provenance.
    #[must_use]
    pub fn described(&self, truth: &GroundTruth, has_regions: bool) -> Settings {
        Settings {
            protocol: truth.protocol.name().to_owned(),
            region_definition: has_regions.then(|| "region-ap/1".to_owned()),
            tau: has_regions.then(|| self.tau()),
            score_threshold: self.score_threshold,
            iou_threshold: self.iou_threshold,
            n_bootstrap: self.n_replicates,
            n_permutations: self.n_replicates,
            seed: self.seed,
            resampling_unit: match has_clusters(&truth.labels) {
                true => "clip or drive".to_owned(),
                false => "image".to_owned(),
            },
            min_objects: self.compare.min_objects,
            max_detections: self.compare.coco.max_detections.last().copied(),
        }
    }
}

/// Fewer images or clusters than these draw too narrow an interval.
const FEW_UNITS: u32 = 20;

fn has_clusters(labels: &LabelSet) -> bool {
    labels.images.iter().any(|image| image.cluster.is_some())
}

/// The labels and both sets of detections as the rules of MS-COCO take them, under which everything but
/// KITTI's own AP is counted.
struct Plain<'a> {
    labels: &'a LabelSet,
    clean: &'a Detections,
    cracked: &'a Detections,
    coverages: &'a Coverages,
    plan: &'a Plan,
    settings: &'a EvaluateSettings,
}

/// All numbers of one detector under one condition.
///
/// Whole cracked images by the protocol; clean against cracked in the region, out of it and everywhere with
/// intervals and tests; what fails, over coverage and damage; kinds of errors; the worst failures. What the
/// detector does on the clean images is apart, in [`clean_results`]. Equal input gives equal numbers on any number of threads.
///
/// Under KITTI's protocol AP50 and AP75 by the rules of MS-COCO stand beside its AP11 and AP40.
///
/// `compared` is what [`compare_pair`](crate::compare_pair) gives for the same labels, detections and regions by
/// [`EvaluateSettings::compare`].
///
/// # Errors
/// As [`compare_pair`](crate::compare_pair); [`EvalError::Dataset`] for an image of a worst failure that cannot be read.
pub fn evaluate(input: &EvaluateInput<'_>, compared: Compared) -> Result<Evaluation, EvalError> {
    evaluate_to(input, compared, None)
}

/// As [`evaluate`]; `means` take what they need of it.
fn evaluate_to(
    input: &EvaluateInput<'_>,
    compared: Compared,
    means: Option<&mut OverConditions>,
) -> Result<Evaluation, EvalError> {
    let EvaluateInput {
        truth,
        clean,
        cracked,
        settings,
        ..
    } = *input;
    let Compared {
        mut warnings,
        counts,
        coverages,
        cracked: of_cracked,
        mut regions,
    } = compared;
    let cracked_results = of_cracked.map_or_else(ProtocolResults::default, |it| it.results);
    let mut evaluation = Evaluation {
        detector: input.detector.to_owned(),
        condition: input.condition.clone(),
        counts,
        warnings: Vec::new(),
        cracked: cracked_results,
        paired: Vec::new(),
        curves: Vec::new(),
        subsets: Vec::new(),
        failures: None,
        tide_cracked: None,
        timelines: Vec::new(),
        pooled_clips: None,
        worst: Vec::new(),
        changed_objects: Vec::new(),
    };
    if let (Some(cracked), Some(coverages)) = (cracked, &coverages)
        && truth.protocol == Protocol::Kitti
    {
        evaluation.paired = regions.take().unwrap_or_default().paired;
        let sides = [clean, cracked];
        intervals::put_kitti(&mut evaluation.paired, truth, sides, coverages, settings)?;
    }
    let coverages = with_plain(input, &mut evaluation, (coverages, regions), means)?;
    warnings.extend(small_samples(&evaluation, settings));
    warnings.extend(coverages.as_ref().and_then(small_damage));
    warnings.extend(control_moves(&evaluation, settings));
    evaluation.warnings.extend(warnings);
    Ok(evaluation)
}

/// What a detector does on the clean images: `results`, which are the protocol's numbers as
/// [`crate::evaluate`] gives them, kinds of errors, and whether its classes are those of the labels.
///
/// # Errors
/// As [`crate::evaluate`].
pub fn clean_results(
    detector: &str,
    truth: &GroundTruth,
    clean: &SaidDetections,
    results: ProtocolResults,
) -> Result<CleanResults, EvalError> {
    let mut of_clean = CleanResults {
        detector: detector.to_owned(),
        warnings: Vec::new(),
        results,
        tide: None,
        label_audit: None,
    };
    let Some((plain, clean, _)) = as_plain(truth, clean, None) else {
        return Ok(of_clean);
    };
    let found = &clean.detections;
    of_clean.tide = side_results::tide_errors(&plain.labels, found, TideSettings::default())?;
    let (audit, advice) = side_results::audit(&plain.labels, found)?;
    of_clean.label_audit = Some(audit);
    of_clean.warnings.extend(advice.map(Warning::Classes));
    Ok(of_clean)
}

/// What is counted by the rules of MS-COCO, whatever the protocol; gives the coverages of these labels back.
/// `regions` are the numbers of the region by these rules, where they are known.
fn with_plain(
    input: &EvaluateInput<'_>,
    evaluation: &mut Evaluation,
    (coverages, regions): (Option<Coverages>, Option<RegionResults>),
    mut means: Option<&mut OverConditions>,
) -> Result<Option<Coverages>, EvalError> {
    let (truth, settings) = (input.truth, input.settings);
    let Some((plain, clean, cracked)) = as_plain(truth, input.clean, input.cracked) else {
        return Ok(None);
    };
    let is_kitti = truth.protocol == Protocol::Kitti;
    let sets = std::iter::once(&clean).chain(&cracked);
    let sets: Vec<&SaidDetections> = sets.map(Cow::as_ref).collect();
    let has_regions = coverages.is_some();
    let coverages = match (coverages, is_kitti) {
        (Some(coverages), false) => coverages,
        (Some(_), true) => cover(&plain, &sets, input.regions, settings.tau())?
            .1
            .unwrap_or_default(),
        (None, _) => nothing_covered(&plain.labels, &sets),
    };
    let plan = plan_of(&plain.labels, settings);
    let Some(cracked) = &cracked else {
        return Ok(None);
    };
    if plan.n_units() < FEW_UNITS {
        let units = match has_clusters(&plain.labels) {
            true => "clips or drives",
            false => "images",
        };
        evaluation.warnings.push(Warning::FewUnits {
            n: plan.n_units().into(),
            units: units.to_owned(),
            few: FEW_UNITS,
        });
    }
    evaluation.tide_cracked =
        side_results::tide_errors(&plain.labels, &cracked.detections, TideSettings::default())?;
    let rows = match regions {
        Some(rows) => rows,
        None => {
            let mut compare = settings.compare.clone();
            if !has_regions {
                compare.taus.clear();
            }
            compare_in_regions(&plain, &clean, Some(cracked), &coverages, &compare)?
        }
    };
    let all = Plain {
        labels: &plain.labels,
        clean: &clean.detections,
        cracked: &cracked.detections,
        coverages: &coverages,
        plan: &plan,
        settings,
    };
    let mut paired = rows.paired;
    intervals::put(&mut paired, &all, &mut |of, drawn| match &mut means {
        Some(means) => means.take_drawn(input.condition, of, drawn),
        None => Ok(()),
    })?;
    evaluation.paired.extend(paired);
    evaluation.curves = rows.curves;
    if has_regions {
        evaluation.subsets = rows.subsets;
    }
    let facts = match (input.facts, &truth.kitti) {
        (Some(facts), Some(kitti)) if is_kitti => Some(facts.with_areas_as_crowds(kitti)),
        (facts, _) => facts.cloned(),
    };
    let sizes = side_results::image_areas_px(&plain);
    let (failures, pairs, matches) =
        what_fails::failures(&all, facts.as_ref(), has_regions, sizes)?;
    evaluation.failures = Some(failures);
    if let Some(means) = means {
        means.take_pairs(input, &all, &pairs, has_regions)?;
    }
    evaluation.changed_objects = worst_images::changed_objects(&all, &pairs);
    evaluation.worst = worst_images::worst(&all, &pairs, &matches, input.images)?;
    Ok(has_regions.then_some(coverages))
}

/// What is drawn: images, or clusters where the labels know them.
fn plan_of(labels: &LabelSet, settings: &EvaluateSettings) -> Plan {
    let clusters: Vec<Option<&str>> = labels
        .images
        .iter()
        .map(|image| image.cluster.as_deref())
        .collect();
    Plan::of_clusters(&clusters).with(settings.n_replicates, settings.seed, settings.level)
}

/// Labels, clean and cracked detections.
type AsPlain<'a> = (
    Cow<'a, GroundTruth>,
    Cow<'a, SaidDetections>,
    Option<Cow<'a, SaidDetections>>,
);

/// The same data without what only KITTI knows; nothing where only a part of the frames is evaluated.
fn as_plain<'a>(
    truth: &'a GroundTruth,
    clean: &'a SaidDetections,
    cracked: Option<&'a SaidDetections>,
) -> Option<AsPlain<'a>> {
    let kitti = truth.kitti.as_ref();
    let Some(kitti) = kitti.filter(|_| truth.protocol == Protocol::Kitti) else {
        let sides = (Cow::Borrowed(clean), cracked.map(Cow::Borrowed));
        return Some((Cow::Borrowed(truth), sides.0, sides.1));
    };
    let labels = kitti.with_areas_as_crowds();
    let is_whole = |said: &SaidDetections| {
        let n_frames = said.kitti.as_ref().map(|kitti| kitti.images.len());
        n_frames.is_none_or(|n| n == labels.images.len())
    };
    if !is_whole(clean) || !cracked.is_none_or(is_whole) {
        return None;
    }
    let plain = |said: &SaidDetections| {
        let items = said.detections.items.iter().filter_map(|detection| {
            let own = truth.labels.categories.get(detection.category as usize)?;
            let category = labels.category_of_name(&own.name)?;
            let [x0, y0, x1, y1] = detection.box_px.corners();
            (x1 >= x0 && y1 >= y0).then_some(crate::Detection {
                category,
                ..*detection
            })
        });
        Cow::Owned(SaidDetections {
            detections: Detections {
                items: items.collect(),
            },
            kitti: None,
            unused: None,
        })
    };
    let (clean, cracked) = (plain(clean), cracked.map(plain));
    let truth = GroundTruth {
        protocol: Protocol::Coco,
        labels,
        kitti: None,
        root: truth.root.clone(),
    };
    Some((Cow::Owned(truth), clean, cracked))
}

/// Coverages of images without any region.
fn nothing_covered(labels: &LabelSet, sets: &[&SaidDetections]) -> Coverages {
    let of = |said: &&SaidDetections| vec![0.0; said.detections.items.len()];
    Coverages {
        objects: vec![0.0; labels.objects.len()],
        detections: sets.iter().map(of).collect(),
        region_px: vec![None; labels.images.len()],
        region_share: vec![None; labels.images.len()],
    }
}

/// The cracks of an image take less of it than this, in the median: the damage is small.
const SMALL_DAMAGE: f64 = 0.02;

/// That the cracks take little of the images, and what makes them take more.
fn small_damage(coverages: &Coverages) -> Option<Warning> {
    let mut shares: Vec<f64> = coverages.region_share.iter().flatten().copied().collect();
    shares.sort_by(f64::total_cmp);
    let n = shares.len();
    if n == 0 {
        return None;
    }
    let median = 0.5 * (shares[(n - 1) / 2] + shares[n / 2]);
    (median < SMALL_DAMAGE).then(|| Warning::SmallDamage {
        median_percent: (100.0 * median).into(),
        small_percent: 100.0 * SMALL_DAMAGE,
    })
}

/// A control whose difference has a p below this moves. Stricter than elsewhere, since every condition is asked.
const CONTROL_P: f64 = 0.01;

/// That AP50 outside the region changes.
fn control_moves(evaluation: &Evaluation, settings: &EvaluateSettings) -> Option<Warning> {
    use super::{GroupKind, PairedMetric, ScopeKind};
    let row = evaluation.paired.iter().find(|row| {
        row.scope.kind == ScopeKind::OutOfRegion
            && row.scope.is_at(Some(settings.tau()))
            && row.group.kind == GroupKind::All
            && row.metric == PairedMetric::Ap50
    })?;
    let change = row
        .delta
        .value
        .filter(|_| row.p.is_some_and(|p| p < CONTROL_P))?;
    Some(Warning::ControlMoves {
        change_points: (100.0 * change).into(),
        tau: settings.tau(),
    })
}

/// How many classes have too few objects for a number, and how little there is in the region.
fn small_samples(evaluation: &Evaluation, settings: &EvaluateSettings) -> Vec<Warning> {
    use super::{GroupKind, ScopeKind};
    let mut warnings = Vec::new();
    let few = settings.compare.min_objects;
    if let Some(n) = evaluation.counts.n_objects_in_region
        && n < few
    {
        warnings.push(Warning::FewObjectsInRegion { n: n.into(), few });
    }
    let mut n_classes = 0_u32;
    let mut n_refused = 0_u32;
    let mut seen: Vec<&str> = Vec::new();
    for row in &evaluation.paired {
        let is_class = row.group.kind == GroupKind::Class
            && row.scope.kind == ScopeKind::InRegion
            && row.scope.tau == Some(settings.tau())
            && row.n_objects > 0;
        if is_class && !seen.contains(&row.group.name.as_str()) {
            seen.push(&row.group.name);
            n_classes += 1;
            n_refused += u32::from(row.clean.value.is_none());
        }
    }
    if n_refused > 0 {
        warnings.push(Warning::FewObjectsOfClasses {
            n: n_refused.into(),
            n_classes: n_classes.into(),
            few,
        });
    }
    warnings
}
