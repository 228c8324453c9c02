//! Evaluation in regions against pycocotools, with coverages of our own.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use crate::common;

use std::collections::BTreeMap;
use std::path::Path;

use common::{assert_same, json, npy, reference};
use starbreak_eval::{
    AreaRange, BoxPx, CocoParams, CoverageOf, Detections, LabelSet, MatchRule, ObjectKind, Outcome,
    RegionMask, Restriction, Size, Subset, SubsetParams, evaluate_coco, match_images,
    subset_curves, subset_precision,
};

/// The arrays of bits in a NumPy archive, by name.
fn npz(path: &Path) -> BTreeMap<String, Vec<u8>> {
    let bytes = std::fs::read(path).unwrap();
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
    let u32_at = |at: usize| u16_at(at) + (u16_at(at + 2) << 16);
    let end = bytes.windows(4).rposition(|w| w == b"PK\x05\x06").unwrap();
    let (n_files, mut at) = (u16_at(end + 10), u32_at(end + 16));
    let mut arrays = BTreeMap::new();
    for _ in 0..n_files {
        assert_eq!(
            &bytes[at..at + 4],
            b"PK\x01\x02",
            "an entry of the directory"
        );
        let (n_packed, begin) = (u32_at(at + 20), u32_at(at + 42));
        let (n_name, n_extra, n_comment) = (u16_at(at + 28), u16_at(at + 30), u16_at(at + 32));
        let name = String::from_utf8(bytes[at + 46..at + 46 + n_name].to_vec()).unwrap();
        let data = begin + 30 + u16_at(begin + 26) + u16_at(begin + 28);
        let packed = &bytes[data..data + n_packed];
        let file = miniz_oxide::inflate::decompress_to_vec(packed).unwrap();
        let header = 10 + usize::from(u16::from_le_bytes([file[8], file[9]]));
        let bits = file[header..].iter();
        let pixels = bits.flat_map(|byte| (0..8).map(move |k| (byte >> (7 - k)) & 1));
        arrays.insert(name.trim_end_matches(".npy").to_owned(), pixels.collect());
        at += 46 + n_name + n_extra + n_comment;
    }
    arrays
}

struct Case {
    labels: LabelSet,
    detections: Detections,
    objects: Vec<f64>,
    said: Vec<f64>,
}

impl Case {
    fn coverage(&self) -> CoverageOf<'_> {
        CoverageOf {
            objects: &self.objects,
            detections: &self.said,
        }
    }
}

/// The region cases, with the areas of the boxes and our own coverages.
fn case() -> Case {
    let folder = reference("coco/region_cov");
    let mut labels = LabelSet::read_coco(&folder.join("gt.json")).unwrap();
    for object in &mut labels.objects {
        object.area_px2 = object.box_px.area_px2();
    }
    let detections = Detections::read_coco(&folder.join("dt.json"), &labels).unwrap();
    let pixels = npz(&folder.join("masks.npz"));
    let masks: Vec<RegionMask> = labels
        .images
        .iter()
        .map(|image| RegionMask::of_pixels(640, 480, &pixels[&image.id.to_string()]).unwrap())
        .collect();
    let cover = |image: u32, b: &BoxPx| masks[image as usize].coverage(b);
    let objects = labels
        .objects
        .iter()
        .map(|o| cover(o.image, &o.box_px))
        .collect();
    let detections = detections.detections;
    let said = detections
        .items
        .iter()
        .map(|d| cover(d.image, &d.box_px))
        .collect();
    Case {
        labels,
        detections,
        objects,
        said,
    }
}

#[test]
fn coverages_are_those_of_the_reference() {
    let case = case();
    let folder = reference("coco/region_cov");
    let areas = LabelSet::read_coco(&folder.join("gt.json")).unwrap();
    let expected: Vec<f64> = areas.objects.iter().map(|o| o.area_px2).collect();
    assert_same(&case.objects, &expected, "coverages of objects");
    let given = json(&folder.join("params.json"));
    let expected = given["dt_area_override"].as_array().unwrap().iter();
    let expected: Vec<f64> = expected.map(|v| v.as_f64().unwrap()).collect();
    assert_same(&case.said, &expected, "coverages of detections");
}

#[test]
fn curves_in_regions_are_those_of_pycocotools() {
    let case = case();
    let folder = reference("coco/region_cov/ref");
    for (a, tau) in [(1, 0.0), (2, 0.05), (3, 0.2)] {
        let subset = Subset::InRegion { tau };
        let curves = subset_curves(
            &case.labels,
            &case.detections,
            case.coverage(),
            &subset,
            100,
        );
        let curves = curves.unwrap();
        // Of four ranges the one, of three numbers of detections the last.
        let theirs = |name: &str| -> Vec<f64> {
            let all = npy(&folder.join(name));
            all.into_iter().skip(a * 3 + 2).step_by(12).collect()
        };
        assert_same(&curves.precision, &theirs("precision.npy"), "precision");
        assert_same(&curves.recall, &theirs("recall.npy"), "recall");
        assert_same(&curves.scores, &theirs("scores.npy"), "scores");
    }
}

#[test]
fn sizes_in_regions_are_those_of_pycocotools() {
    let case = case();
    let theirs = npy(&reference("coco/region_size_tau05/ref").join("precision.npy"));
    for (a, size) in (1..).zip(Size::ALL) {
        let subset = Subset::SizeInRegion { size, tau: 0.05 };
        let curves = subset_curves(
            &case.labels,
            &case.detections,
            case.coverage(),
            &subset,
            100,
        );
        let expected: Vec<f64> = theirs.iter().skip(a * 3 + 2).step_by(12).copied().collect();
        assert_same(&curves.unwrap().precision, &expected, size.name());
    }
}

#[test]
fn a_threshold_of_all_coverages_is_the_whole_image_and_one_above_all_is_nothing() {
    let case = case();
    let whole =
        evaluate_coco(&case.labels, &case.detections, &CocoParams::default(), None).unwrap();
    let one = CocoParams {
        max_detections: vec![100],
        area_ranges: vec![AreaRange::new("all", [0.0, 2.0])],
        ..CocoParams::default()
    };
    // Every coverage is 0 or more.
    let values = Restriction {
        objects: &case.objects,
        detections: &case.said,
        range: [0.0, 2.0],
    };
    let zero = evaluate_coco(&case.labels, &case.detections, &one, Some(&values)).unwrap();
    let of_whole: Vec<f64> = whole
        .precision
        .iter()
        .skip(2)
        .step_by(12)
        .copied()
        .collect();
    assert_same(&zero.precision, &of_whole, "tau = 0");
    let params = SubsetParams::default();
    let rows = |subset: Subset| {
        let coverage = case.coverage();
        subset_precision(&case.labels, &case.detections, coverage, &subset, params).unwrap()
    };
    assert_eq!(
        rows(Subset::WholeImage)[0].ap50.value,
        whole.average_precision(&[0], &[0, 1, 2, 3], 0, 2),
        "the whole image"
    );
    for row in rows(Subset::InRegion { tau: 1.5 }) {
        assert_eq!(row.n_objects, 0, "tau > 1: {row:?}");
        assert!(
            row.ap50.value.is_none() && row.ap50.refused.is_some(),
            "{row:?}"
        );
    }
}

#[test]
fn region_and_control_share_out_the_objects() {
    let case = case();
    let n_regular = case
        .labels
        .objects
        .iter()
        .filter(|o| o.kind == ObjectKind::Regular)
        .count();
    let params = SubsetParams::default();
    let n_objects = |subset: Subset| {
        let coverage = case.coverage();
        let rows = subset_precision(&case.labels, &case.detections, coverage, &subset, params);
        usize::try_from(rows.unwrap()[0].n_objects).unwrap()
    };
    for tau in [0.0, 0.05, 0.2] {
        let inside = n_objects(Subset::InRegion { tau });
        let outside = n_objects(Subset::OutOfRegion { tau });
        assert_eq!(inside + outside, n_regular, "tau {tau}");
        assert!(inside > 0 && outside > 0, "tau {tau}: {inside} {outside}");
    }
    let bins = [0.0, 0.05, 0.2, 0.4, 0.7, 1.0];
    let n_binned: usize = bins
        .windows(2)
        .map(|ends| Subset::CoverageBin {
            least: ends[0],
            below: ends[1],
        })
        .map(n_objects)
        .sum();
    assert_eq!(n_binned, n_regular, "every object is in one bin");
}

/// What a detection counts as, by the words of the definition.
#[test]
fn objects_out_of_the_region_absorb_one_detection_and_are_not_missed() {
    let case = case();
    let rule = MatchRule {
        region: Some(Restriction {
            objects: &case.objects,
            detections: &case.said,
            range: [0.05, 2.0],
        }),
        ..MatchRule::default()
    };
    let mut seen = [0u32; 3];
    for image in match_images(&case.labels, &case.detections, &rule).unwrap() {
        for object in &image.objects {
            let truth = &case.labels.objects[object.object as usize];
            let is_in = case.objects[object.object as usize] >= 0.05;
            let counts = is_in && truth.kind == ObjectKind::Regular;
            assert_eq!(object.is_ignored, !counts, "{object:?}");
        }
        for said in &image.detections {
            let coverage = case.said[said.detection as usize];
            match said.outcome {
                Outcome::TruePositive { object, iou } => {
                    assert!(
                        case.objects[object as usize] >= 0.05 && iou >= 0.5,
                        "{said:?}"
                    );
                    seen[0] += 1;
                }
                Outcome::FalsePositive => {
                    assert!(coverage >= 0.05, "{said:?}: {coverage}");
                    seen[1] += 1;
                }
                Outcome::Ignored => seen[2] += 1,
            }
        }
    }
    assert!(seen.iter().all(|n| *n > 2), "all three occur: {seen:?}");
}
