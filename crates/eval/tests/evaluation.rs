//! Whole evaluations of made-up labels and detections: means over conditions and groups, labels without
//! an area, doses that say nothing.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "evaluation/curves.rs"]
mod curves;

use std::fs;
use std::path::{Path, PathBuf};

use image::{DynamicImage, GrayImage, Luma};
use starbreak_dataset::{Encoding, encode_image};
use starbreak_eval::evaluation::{
    Condition, DamageFacts, Estimate, EvaluateInput, EvaluateSettings, Evaluation, Group,
    GroupKind, OverConditions, PairedMetric, PairedRow, Provenance, RobustnessRow, Scope,
    ScopeKind, Study,
};
use starbreak_eval::report::html;
use starbreak_eval::{
    BoxPx, Category, CompareParams, Detection, Detections, GroundTruth, LabelSet, LabeledImage,
    Object, ObjectKind, Protocol, RegionMasks, SaidDetections, compare_pair, evaluate,
};

/// Images, of one object each.
const N: u32 = 60;

const BOX: [f64; 4] = [10.0, 10.0, 50.0, 50.0];

/// A number in 0..1 from two counts, without a pattern.
fn hashed(a: u32, b: u32) -> f64 {
    let mut x = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b) ^ 0x1234_5678;
    for shift in [16, 13, 16] {
        x ^= x >> shift;
        x = x.wrapping_mul(0xc2b2_ae35);
    }
    f64::from(x >> 8) / f64::from(1_u32 << 24)
}

fn name(image: u32) -> String {
    format!("{image:03}.png")
}

/// Cars, trucks and people by turns.
fn truth() -> GroundTruth {
    let category = |(id, (name, supercategory)): (i64, (&str, &str))| Category {
        id,
        name: name.to_owned(),
        supercategory: Some(supercategory.to_owned()),
    };
    let categories = [
        ("car", "vehicle"),
        ("truck", "vehicle"),
        ("person", "human"),
    ];
    let images = (0..N).map(|k| LabeledImage {
        id: i64::from(k),
        name: name(k),
        width_px: Some(100),
        height_px: Some(100),
        cluster: None,
    });
    let objects = (0..N).map(|k| Object {
        id: i64::from(k) + 1,
        image: k,
        category: k % 3,
        box_px: BoxPx::from_corners(BOX),
        area_px2: 1600.0,
        kind: ObjectKind::Regular,
    });
    GroundTruth {
        protocol: Protocol::Coco,
        labels: LabelSet {
            images: images.collect(),
            categories: (1..).zip(categories).map(category).collect(),
            objects: objects.collect(),
        },
        kitti: None,
        root: None,
    }
}

/// Each object that `is_found`, and here and there something that is none.
fn said(is_found: impl Fn(u32) -> bool) -> SaidDetections {
    let one = |image: u32, corners: [f64; 4], score: f64| Detection {
        image,
        category: image % 3,
        box_px: BoxPx::from_corners(corners),
        score,
    };
    let found = (0..N).filter(|k| is_found(*k));
    let found = found.map(|k| one(k, BOX, 0.4 + 0.5 * hashed(k, 1)));
    let wrong = (0..N).step_by(4);
    let wrong = wrong.map(|k| one(k, [5.0, 60.0, 45.0, 95.0], 0.4 + 0.5 * hashed(k, 2)));
    SaidDetections {
        detections: Detections {
            items: found.chain(wrong).collect(),
        },
        kitti: None,
        unused: None,
    }
}

/// A folder of masks: the left half of the images of `range`, nothing of the others.
fn masks(folder: &Path, range: std::ops::Range<u32>) -> PathBuf {
    fs::create_dir(folder).unwrap();
    for k in 0..N {
        let pixel = |x, _| {
            Luma([if range.contains(&k) && x < 50 {
                255_u8
            } else {
                0
            }])
        };
        let mask = DynamicImage::ImageLuma8(GrayImage::from_fn(100, 100, pixel));
        let bytes = encode_image(&mask, &Encoding::Png, None).unwrap();
        fs::write(folder.join(name(k)), bytes).unwrap();
    }
    folder.to_owned()
}

fn settings() -> EvaluateSettings {
    EvaluateSettings {
        n_replicates: 200,
        n_worst: 0,
        ..EvaluateSettings::of(Protocol::Coco)
    }
}

/// Family, severity, seed, what is found and where the masks are.
type Cell<'a> = (&'a str, u8, u64, SaidDetections, &'a Path);

fn condition((family, severity, seed, ..): &Cell<'_>) -> Condition {
    Condition {
        name: format!("{family}, severity {severity}, seed {seed}"),
        family: Some((*family).to_owned()),
        // A recipe, which no severity scales.
        severity: Some(*severity).filter(|severity| *severity > 0),
        seed: Some(*seed),
    }
}

fn input<'a>(
    truth: &'a GroundTruth,
    (cell, condition): (&'a Cell<'_>, &'a Condition),
    clean: &'a SaidDetections,
    settings: &'a EvaluateSettings,
) -> EvaluateInput<'a> {
    EvaluateInput {
        detector: "made-up",
        condition,
        truth,
        clean,
        cracked: Some(&cell.3),
        regions: Some(RegionMasks {
            folder: cell.4,
            root: None,
        }),
        facts: None,
        images: None,
        settings,
    }
}

/// All numbers of an input.
fn evaluated(input: &EvaluateInput<'_>) -> Evaluation {
    OverConditions::new(&[]).evaluate(input).unwrap()
}

/// One condition alone.
fn alone(truth: &GroundTruth, cell: &Cell<'_>, facts: Option<&DamageFacts>) -> Evaluation {
    let (condition, clean, settings) = (condition(cell), said(|_| true), settings());
    evaluated(&EvaluateInput {
        facts,
        ..input(truth, (cell, &condition), &clean, &settings)
    })
}

/// All conditions, one after the other.
fn all(truth: &GroundTruth, cells: &[Cell<'_>]) -> (Vec<Evaluation>, OverConditions) {
    let conditions: Vec<Condition> = cells.iter().map(condition).collect();
    let (clean, settings) = (said(|_| true), settings());
    let mut means = OverConditions::new(&conditions);
    let evaluations = cells.iter().zip(&conditions).map(|of| {
        let input = input(truth, of, &clean, &settings);
        means.evaluate(&input).unwrap()
    });
    (evaluations.collect(), means)
}

fn means(truth: &GroundTruth, cells: &[Cell<'_>]) -> Vec<RobustnessRow> {
    let (evaluations, means) = all(truth, cells);
    means.robustness(&evaluations).unwrap()
}

fn mean_of(rows: &[RobustnessRow], kind: ScopeKind, metric: PairedMetric) -> &RobustnessRow {
    let is_it = |row: &&RobustnessRow| row.scope.kind == kind && row.metric == metric;
    rows.iter().find(is_it).unwrap()
}

fn pair_of<'a>(
    rows: &'a [PairedRow],
    scope: &Scope,
    group: &Group,
    metric: PairedMetric,
) -> &'a PairedRow {
    let is_it =
        |row: &&PairedRow| row.scope == *scope && row.group == *group && row.metric == metric;
    rows.iter().find(is_it).unwrap()
}

fn in_region() -> Scope {
    Scope {
        kind: ScopeKind::InRegion,
        tau: Some(0.05),
    }
}

fn same(one: &Estimate, other: &Estimate, what: &str) {
    let numbers = |it: &Estimate| [it.value, it.low, it.high].map(Option::unwrap);
    for (a, b) in numbers(one).iter().zip(numbers(other)) {
        assert!((a - b).abs() < 1e-12, "{what}: {one:?} and {other:?}");
    }
}

#[test]
fn the_mean_over_conditions_that_are_alike_is_each_of_them_with_its_interval() {
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..50);
    let truth = truth();
    let cracked = said(|k| hashed(k, 3) > 0.4);
    let cells = [("star", 1), ("star", 3), ("long", 1), ("long", 3)]
        .map(|(family, severity)| (family, severity, 7, cracked.clone(), masks.as_path()));
    let rows = means(&truth, &cells);
    assert_eq!(rows.len(), 6, "two places, three metrics");
    let one = alone(&truth, &cells[0], None);
    for scope in [Scope::whole_image(), in_region()] {
        for metric in [PairedMetric::Ap50, PairedMetric::Ap75] {
            let mean = mean_of(&rows, scope.kind, metric);
            let pair = pair_of(&one.paired, &scope, &Group::all(), metric);
            same(&mean.clean, &pair.clean, "clean");
            same(&mean.mpc, &pair.cracked, "mPC");
            let ratio = pair.cracked.value.unwrap() / pair.clean.value.unwrap();
            assert!(
                (mean.rpc.value.unwrap() - ratio).abs() < 1e-12,
                "rPC {mean:?}"
            );
            let [low, high] = mean.rpc.interval().unwrap();
            assert!(low < ratio && ratio < high, "rPC {mean:?}");
            assert_eq!(mean.n_seeds, Some(1), "one seed");
        }
        let ap = mean_of(&rows, scope.kind, PairedMetric::Ap);
        assert!(
            ap.mpc.value.is_some() && ap.mpc.interval().is_none(),
            "of AP none"
        );
    }
}

#[test]
fn a_condition_without_severity_is_left_out_of_the_mean_and_changes_nothing_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let few = masks(&folder.path().join("a"), 0..40);
    let all = masks(&folder.path().join("b"), 0..N);
    let truth = truth();
    let of = |family, severity, least, masks| {
        let found = said(|k| hashed(k, 3 + u32::from(severity)) > least);
        (family, severity, 7, found, masks)
    };
    let grid = [("star", 1), ("star", 3)].map(|(family, n)| of(family, n, 0.4, few.as_path()));
    let recipe = of("mine", 0, 0.9, all.as_path());
    let rows = means(&truth, &grid);
    assert_eq!(rows.len(), 6, "of the grid alone");
    let [first, second] = grid.clone();
    assert_eq!(means(&truth, &[first, recipe.clone(), second]), rows);
    let [first, _] = grid;
    assert_eq!(means(&truth, &[first, recipe]), [], "no mean of one");
}

#[test]
fn an_interval_of_the_mean_needs_all_seeds_of_all_conditions() {
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..N);
    let truth = truth();
    let cells = |share: [f64; 2]| -> Vec<Cell<'_>> {
        let of = |severity: u8, seed: u64| {
            let lost = share[usize::try_from(seed).unwrap()];
            let found = said(|k| hashed(k, 10 + u32::from(severity)) > lost);
            ("star", severity, seed, found, masks.as_path())
        };
        vec![of(1, 0), of(1, 1), of(2, 0), of(2, 1)]
    };
    let width = |cells: &[Cell<'_>]| {
        let rows = means(&truth, cells);
        let row = mean_of(&rows, ScopeKind::WholeImage, PairedMetric::Ap50);
        assert_eq!(row.n_seeds, Some(2), "both");
        let [low, high] = row.mpc.interval().unwrap();
        high - low
    };
    let width = width(&cells([0.1, 0.7]));
    assert!((0.01..0.5).contains(&width), "{width}");

    let rows = means(&truth, &cells([0.1, 0.7])[..3]);
    let row = mean_of(&rows, ScopeKind::WholeImage, PairedMetric::Ap50);
    assert!(row.mpc.value.is_some(), "the mean is there");
    assert_eq!(
        (row.mpc.interval(), row.n_seeds),
        (None, None),
        "and no interval"
    );
}

#[test]
fn an_object_counts_once_whatever_the_number_of_conditions() {
    let folder = tempfile::tempdir().unwrap();
    let first = masks(&folder.path().join("a"), 0..40);
    let second = masks(&folder.path().join("b"), 20..50);
    let truth = truth();
    let cracked = said(|k| hashed(k, 3) > 0.4);
    let cells = [
        ("star", 1, 7, cracked.clone(), first.as_path()),
        ("star", 2, 7, cracked, second.as_path()),
    ];
    let rows = means(&truth, &cells);
    for (kind, n) in [(ScopeKind::WholeImage, 60), (ScopeKind::InRegion, 50)] {
        for metric in [PairedMetric::Ap, PairedMetric::Ap50] {
            let row = mean_of(&rows, kind, metric);
            assert_eq!([row.clean.n, row.mpc.n, row.rpc.n], [n; 3], "{kind:?}");
        }
    }
}

#[test]
fn the_mean_of_supercategories_is_that_of_their_classes_taken_as_one() {
    let truth = truth();
    let cracked = said(|k| hashed(k, 3) > 0.4);
    let params = CompareParams::of(Protocol::Coco);
    let groups = evaluate(&truth, &cracked, &params).unwrap().results.groups;
    let ap50 = |group: &Group| {
        let row = groups.iter().find(|row| row.group == *group).unwrap();
        row.ap50.value.unwrap()
    };
    let of = |name: &str| Group {
        kind: GroupKind::Supercategory,
        name: name.to_owned(),
    };
    // Each one's classes under one name, without the others.
    let merged = |classes: &[u32]| {
        let mut truth = truth.clone();
        truth.labels.categories.truncate(1);
        truth
            .labels
            .objects
            .retain(|it| classes.contains(&it.category));
        truth
            .labels
            .objects
            .iter_mut()
            .for_each(|it| it.category = 0);
        let mut said = cracked.clone();
        said.detections
            .items
            .retain(|it| classes.contains(&it.category));
        said.detections
            .items
            .iter_mut()
            .for_each(|it| it.category = 0);
        let all = evaluate(&truth, &said, &params).unwrap().results.groups;
        all[0].ap50.value.unwrap()
    };
    let (vehicle, human) = (merged(&[0, 1]), merged(&[2]));
    assert!(
        (ap50(&of("vehicle")) - vehicle).abs() < 1e-12,
        "vehicle {vehicle}"
    );
    assert!((ap50(&of("human")) - human).abs() < 1e-12, "human {human}");
    let mean = ap50(&Group::mean_of_supercategories());
    assert!(
        (mean - (vehicle + human) / 2.0).abs() < 1e-12,
        "mean {mean}"
    );
    assert!(
        (mean - ap50(&Group::all())).abs() > 1e-3,
        "not that of the classes"
    );

    // The same on whole images of both sides, with an interval of its own.
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..N);
    let one = alone(&truth, &("star", 1, 0, cracked.clone(), &masks), None);
    let row = pair_of(
        &one.paired,
        &Scope::whole_image(),
        &Group::mean_of_supercategories(),
        PairedMetric::Ap50,
    );
    assert!((row.cracked.value.unwrap() - mean).abs() < 1e-12, "{row:?}");
    let [low, high] = row.cracked.interval().unwrap();
    assert!(low < mean && mean < high, "{row:?}");
}

#[test]
fn an_object_with_an_area_below_0_is_not_to_be_found_anywhere() {
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..N);
    let mut truth = truth();
    let cracked = said(|k| hashed(k, 3) > 0.4);
    // One that is found and one that is missed.
    let is_found = |k: &u32| hashed(*k, 3) > 0.4;
    let places = [(0..N).find(is_found), (0..N).find(|k| !is_found(k))];
    for place in places.into_iter().flatten() {
        truth.labels.objects[place as usize].area_px2 = -1.0;
    }
    let regions = RegionMasks {
        folder: &masks,
        root: None,
    };
    let params = CompareParams::of(Protocol::Coco);
    let found = compare_pair(
        &truth,
        &said(|_| true),
        Some(&cracked),
        Some(regions),
        &params,
    );
    let found = found.unwrap();
    let texts: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
    assert!(
        texts
            .iter()
            .any(|text| text.contains("2 objects have a negative area")),
        "and said: {texts:?}"
    );
    let of_all = &found.cracked.unwrap().results.groups[0];
    assert_eq!(of_all.n_objects, u64::from(N) - 2, "by the protocol");
    assert_eq!(found.counts.n_objects, u64::from(N) - 2, "counted");
    assert_eq!(
        found.counts.n_objects_in_region,
        Some(u64::from(N) - 2),
        "and there"
    );
    let rows = found.regions.unwrap().paired;
    for scope in [Scope::whole_image(), in_region()] {
        let row = pair_of(&rows, &scope, &Group::all(), PairedMetric::Ap50);
        assert_eq!(row.n_objects, u64::from(N) - 2, "{scope:?}");
    }
    let whole = pair_of(
        &rows,
        &Scope::whole_image(),
        &Group::all(),
        PairedMetric::Ap50,
    );
    assert_eq!(whole.cracked.value, of_all.ap50.value, "the protocol's own");
    let one = alone(&truth, &("star", 1, 0, cracked, &masks), None);
    let rates = &one.failures.unwrap().rates;
    let everywhere = rates.iter().find(|row| row.scope == Scope::whole_image());
    assert_eq!(
        everywhere.unwrap().n_objects,
        u64::from(N) - 2,
        "in rates, too"
    );
}

#[test]
fn a_dose_that_tells_no_objects_apart_says_so_in_the_place_of_its_chart() {
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..N);
    let truth = truth();
    let cell = ("star", 1, 0, said(|k| hashed(k, 3) > 0.4), masks.as_path());
    let n = N as usize;
    let notes = |displacement_px: Vec<f64>, contrast_lost: Vec<f64>| -> Vec<String> {
        let facts = DamageFacts {
            displacement_px,
            blur_radius_px: vec![f64::NAN; n],
            contrast_lost,
            n_images_without: 0,
        };
        let one = alone(&truth, &cell, Some(&facts));
        let doses = &one.failures.as_ref().unwrap().dose_responses;
        let notes: Vec<String> = doses.iter().filter_map(|it| it.note.clone()).collect();
        let bins: usize = doses.iter().skip(1).map(|it| it.bins.len()).sum();
        assert_eq!(bins, 0, "no bins");
        let page = html(&Study::of_one(one, "made-up", Provenance::default())).unwrap();
        for note in &notes {
            assert!(page.contains(note), "the page says {note:?}");
        }
        notes
    };
    let mut nearly = vec![0.0; n];
    nearly[5] = 0.25;
    assert_eq!(
        notes(vec![0.0; n], vec![0.3; n]),
        [
            "it is 0 for all 60 objects found in the clean images",
            "it was not recorded for any object found in the clean images",
            "it is the same for nearly all of the 60 objects found in the clean images",
        ]
    );
    assert_eq!(
        notes(nearly.clone(), nearly)[0],
        "it is 0 for 59 of 60 objects found in the clean images, too many for bins of equal counts"
    );
}
