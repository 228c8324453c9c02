//! Detections of nothing that the cracks brought.

use serde::{Deserialize, Serialize};

use super::Where;
use crate::EvalError;
use crate::detections::{Detection, Detections};
use crate::matching::{ImageMatches, Outcome};
use crate::resampling::{Basis, Plan, bootstrap};
use crate::statistic::{Measured, Method};

/// Overlap from which two detections are at the same place.
const SAME_PLACE_IOU: f64 = 0.5;

/// False positives of one place, clean and cracked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FalsePositives {
    /// Where.
    pub place: Where,
    /// Images looked at.
    pub n_images: u64,
    /// Area looked at, millions of pixels.
    pub area_mpx: f64,
    /// In the clean images.
    pub n_clean: u64,
    /// In the cracked images.
    pub n_cracked: u64,
    /// Of those, where no detection is in the clean image.
    pub n_new: u64,
    /// New ones per million pixels of the place; n are the units drawn.
    pub new_per_mpx: Measured,
    /// New ones per image.
    pub new_per_image: Measured,
    /// Cracked minus clean, per image.
    pub more_per_image: Measured,
}

/// What the counts of false positives are related to: per detection how much of it the region
/// covers, per image how large region and rest are.
#[derive(Debug, Clone, Copy)]
pub struct FalsePositiveAreas<'a> {
    /// Share of each clean detection's box that the region covers.
    pub clean_coverage: &'a [f64],
    /// Share of each cracked detection's box that the region covers.
    pub cracked_coverage: &'a [f64],
    /// The region's area in each image, px.
    pub region_px: &'a [f64],
    /// Each image's area, px.
    pub image_px: &'a [f64],
    /// Coverage from which a detection lies in the region.
    pub tau: f64,
}

/// False positives of at least `score_threshold`, in the whole image, in the region and outside,
/// with bootstrap intervals of the rates over the plan's images or clusters.
///
/// One is new if no clean detection of at least that score, of whatever category, overlaps it by an
/// IoU of 0.5: at this working point something is seen where nothing was. An object that is now
/// taken for another class is not new; see [`class_flips`](super::class_flips).
///
/// # Errors
/// If coverages or areas are missing, a match names a detection that is not there, or the plan
/// cannot be carried out.
pub fn new_false_positives(
    (clean, clean_detections): (&[ImageMatches], &Detections),
    (cracked, cracked_detections): (&[ImageMatches], &Detections),
    areas: FalsePositiveAreas<'_>,
    score_threshold: f64,
    plan: &Plan,
) -> Result<Vec<FalsePositives>, EvalError> {
    let n_images = plan.n_images();
    let expect = |what, found: usize, expected: usize, of| {
        if found < expected {
            return Err(EvalError::StatisticLength {
                what,
                found,
                expected,
                of,
            });
        }
        Ok(())
    };
    let (n_clean, n_cracked) = (clean_detections.items.len(), cracked_detections.items.len());
    let coverages = "coverages of detections";
    expect(coverages, areas.clean_coverage.len(), n_clean, "detections")?;
    let n_coverages = areas.cracked_coverage.len();
    expect(coverages, n_coverages, n_cracked, "detections")?;
    expect("region areas", areas.region_px.len(), n_images, "images")?;
    expect("image areas", areas.image_px.len(), n_images, "images")?;
    let clean_false = listed(clean, clean_detections, score_threshold, n_images)?;
    let cracked_false = listed(cracked, cracked_detections, score_threshold, n_images)?;
    let mut seen: Vec<Vec<&Detection>> = vec![Vec::new(); n_images];
    for detection in &clean_detections.items {
        if let Some(list) = seen.get_mut(detection.image as usize)
            && detection.score >= score_threshold
        {
            list.push(detection);
        }
    }
    let is_new = |detection: &Detection| {
        let at_place = |it: &&Detection| it.box_px.iou(&detection.box_px) >= SAME_PLACE_IOU;
        !seen[detection.image as usize].iter().any(at_place)
    };
    let tau = areas.tau;
    let places = [Where::Image, Where::Region { tau }, Where::Outside { tau }];
    let counted: Vec<Vec<Counts>> = places
        .iter()
        .map(|place| {
            let mut counts: Vec<Counts> = (0..n_images)
                .map(|image| Counts {
                    area_px: area_of(*place, areas.region_px[image], areas.image_px[image]),
                    ..Counts::default()
                })
                .collect();
            for (idx, detection) in &clean_false {
                if place.holds(areas.clean_coverage[*idx]) {
                    counts[detection.image as usize].n_clean += 1.0;
                }
            }
            for (idx, detection) in &cracked_false {
                if place.holds(areas.cracked_coverage[*idx]) {
                    let count = &mut counts[detection.image as usize];
                    count.n_cracked += 1.0;
                    count.n_new += f64::from(u8::from(is_new(detection)));
                }
            }
            counts
        })
        .collect();
    let replicates = bootstrap(plan, |weights| {
        counted
            .iter()
            .flat_map(|counts| rates(counts, weights))
            .collect()
    })?;
    let basis = Basis::Units(plan.n_units());
    let row = |(place, (at, counts)): (usize, (&Where, &Vec<Counts>))| {
        let total = total(counts, &vec![1; n_images]);
        FalsePositives {
            place: *at,
            n_images: n_images as u64,
            area_mpx: total.area_px * 1e-6,
            n_clean: whole(total.n_clean),
            n_cracked: whole(total.n_cracked),
            n_new: whole(total.n_new),
            new_per_mpx: replicates.expanded(place * 3, Method::Density, basis),
            new_per_image: replicates.expanded(place * 3 + 1, Method::Density, basis),
            more_per_image: replicates.expanded(place * 3 + 2, Method::Difference, basis),
        }
    };
    Ok(places.iter().zip(&counted).enumerate().map(row).collect())
}

/// Sums over images.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    n_clean: f64,
    n_cracked: f64,
    n_new: f64,
    area_px: f64,
}

fn area_of(place: Where, region_px: f64, image_px: f64) -> f64 {
    match place {
        Where::Region { .. } => region_px,
        Where::Outside { .. } => (image_px - region_px).max(0.0),
        Where::Image | Where::Coverage { .. } => image_px,
    }
}

fn total(counts: &[Counts], weights: &[u32]) -> Counts {
    let mut sum = Counts::default();
    for (count, weight) in counts.iter().zip(weights) {
        let weight = f64::from(*weight);
        sum.n_clean += weight * count.n_clean;
        sum.n_cracked += weight * count.n_cracked;
        sum.n_new += weight * count.n_new;
        sum.area_px += weight * count.area_px;
    }
    sum
}

fn rates(counts: &[Counts], weights: &[u32]) -> [Option<f64>; 3] {
    let sum = total(counts, weights);
    let n_images: f64 = weights.iter().map(|it| f64::from(*it)).sum();
    let per_image = |value: f64| (n_images > 0.0).then(|| value / n_images);
    [
        (sum.area_px > 0.0).then(|| sum.n_new / (sum.area_px * 1e-6)),
        per_image(sum.n_new),
        per_image(sum.n_cracked - sum.n_clean),
    ]
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a sum of ones, exact below 2^53"
)]
fn whole(count: f64) -> u64 {
    count as u64
}

/// The false positives among the matches.
fn listed<'a>(
    matches: &[ImageMatches],
    detections: &'a Detections,
    score_threshold: f64,
    n_images: usize,
) -> Result<Vec<(usize, &'a Detection)>, EvalError> {
    let mut list = Vec::new();
    for matched in matches.iter().flat_map(|item| &item.detections) {
        if matched.outcome != Outcome::FalsePositive || matched.score < score_threshold {
            continue;
        }
        let idx = matched.detection as usize;
        let detection = detections.items.get(idx);
        let Some(detection) = detection.filter(|it| (it.image as usize) < n_images) else {
            return Err(EvalError::NotPaired {
                what: format!("detection {idx}, which the detections do not have"),
            });
        };
        list.push((idx, detection));
    }
    Ok(list)
}
