//! A study with numbers as they might be, made up from a formula: for looking at the report, and for
//! tests of its form. No number of it is a result.
#![expect(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "small made-up numbers"
)]

use image::{DynamicImage, Rgb, RgbImage};
use starbreak_dataset::{Encoding, JpegQuality, encode_image};
use starbreak_eval::evaluation::{
    BoxRole, ClassFlip, CleanResults, Condition, Counts, DivergenceResults, DivergenceTable,
    DoseBin, DoseResponse, Estimate, Evaluation, FailureResults, FailureRow, FlipRow, Group,
    GroupAp, GroupKind, InputFile, KittiAp, LabelAudit, LabelVerdict, LogisticFit,
    NewFalsePositives, PairedMetric, PairedRow, PicturePair, PrecisionCurves, ProtocolResults,
    Provenance, RobustnessRow, RoledBox, Scope, ScopeKind, Settings, ShiftRow, ShiftedLabel, Study,
    TideErrors, TimelineResults, TrackSource, Versions, Warning, WorstFailure,
};
use starbreak_eval::timeline::{
    Frame, GlassState, Sighting, TimelineSettings, Track, change_after, timeline,
};
use starbreak_eval::{BoxPx, TrackName};

/// Classes with how many objects each has, its AP50 and its supercategory.
const CLASSES: [(&str, u64, f64, &str); 9] = [
    ("person", 254, 0.647, "person"),
    ("car", 61, 0.452, "vehicle"),
    ("truck", 24, 0.331, "vehicle"),
    ("bus", 21, 0.52, "vehicle"),
    ("bicycle", 12, 0.2, "vehicle"),
    ("pizza", 31, 0.61, "food"),
    ("hot dog", 22, 0.48, "food"),
    ("donut", 14, 0.5, "food"),
    ("toothbrush", 2, 0.1, "indoor"),
];

const TAU: f64 = 0.05;

fn estimate(value: f64, n: u64) -> Estimate {
    if n < 20 {
        return Estimate::refused(n, format!("{n} objects, 20 are needed"));
    }
    let half = 0.9 / (n as f64).sqrt();
    Estimate::with_interval(value, [(value - half).max(0.0), (value + half).min(1.0)], n)
}

fn difference(value: f64, n: u64) -> Estimate {
    if n < 20 {
        return Estimate::refused(n, format!("{n} objects, 20 are needed"));
    }
    let half = 0.7 / (n as f64).sqrt();
    Estimate::with_interval(value, [value - half, value + half], n)
}

fn groups() -> Vec<(Group, u64, f64)> {
    let of = |kind, name: &str| Group {
        kind,
        name: name.to_owned(),
    };
    let mut groups = vec![(Group::all(), CLASSES.iter().map(|c| c.1).sum(), 0.47)];
    for (name, ap) in [
        ("person", 0.647),
        ("vehicle", 0.396),
        ("food", 0.559),
        ("indoor", 0.1),
    ] {
        let n = CLASSES.iter().filter(|c| c.3 == name).map(|c| c.1).sum();
        groups.push((of(GroupKind::Supercategory, name), n, ap));
    }
    for (name, n, ap, _) in CLASSES {
        groups.push((of(GroupKind::Class, name), n, ap));
    }
    groups
}

/// Where, with the share of objects there and the loss relative to AP.
fn scopes(severity: f64) -> Vec<(Scope, f64, f64)> {
    let scope = |kind, tau| Scope { kind, tau };
    vec![
        (scope(ScopeKind::InRegion, Some(TAU)), 0.6, 0.09 * severity),
        (scope(ScopeKind::InRegion, Some(0.0)), 0.7, 0.08 * severity),
        (scope(ScopeKind::InRegion, Some(0.2)), 0.45, 0.11 * severity),
        (
            scope(ScopeKind::OutOfRegion, Some(TAU)),
            0.4,
            0.012 * severity,
        ),
        (Scope::whole_image(), 1.0, 0.06 * severity),
    ]
}

fn paired(severity: f64, skill: f64) -> Vec<PairedRow> {
    let mut rows = Vec::new();
    for (scope, share, loss) in scopes(severity) {
        for (group, n, ap) in groups() {
            let n_objects = (n as f64 * share).round() as u64;
            for (metric, factor) in [
                (PairedMetric::Ap50, 1.0),
                (PairedMetric::Ap75, 0.62),
                (PairedMetric::Ap, 0.58),
            ] {
                let clean = ap * factor * skill;
                let cracked = clean * (1.0 - loss);
                let has_number = n_objects >= 20;
                rows.push(PairedRow {
                    scope: scope.clone(),
                    group: group.clone(),
                    metric,
                    n_objects,
                    n_images: n_objects / 3 + 1,
                    clean: estimate(clean, n_objects),
                    cracked: estimate(cracked, n_objects),
                    delta: difference(cracked - clean, n_objects),
                    p: has_number.then_some((0.4 - loss).max(0.0002)),
                    p_holm: has_number.then_some((0.8 - 2.0 * loss).clamp(0.0004, 1.0)),
                    ceiling: None,
                });
            }
        }
    }
    rows
}

/// Straight lines with the area that AP50 is.
fn curves(severity: f64, skill: f64) -> Vec<PrecisionCurves> {
    let ap = groups()[0].2 * skill;
    let curve = |area: f64| -> Vec<f64> {
        (0..=100)
            .map(|place| area * 2.0 * (1.0 - f64::from(place) / 100.0))
            .map(|precision| precision.min(1.0))
            .collect()
    };
    let of = |(scope, _, loss): (Scope, f64, f64)| PrecisionCurves {
        scope,
        clean: curve(ap),
        cracked: curve(ap * (1.0 - loss)),
    };
    let mut scopes = scopes(severity);
    scopes.retain(|one| one.0 == Scope::whole_image() || one.0.tau == Some(TAU));
    scopes.retain(|one| one.0.kind != ScopeKind::OutOfRegion);
    scopes.into_iter().map(of).collect()
}

fn failures(severity: f64) -> FailureResults {
    let mut results = FailureResults::default();
    for (scope, share, loss) in scopes(severity) {
        for (group, n, ap) in groups() {
            let n_objects = (n as f64 * share).round() as u64;
            let n_found_clean = (n_objects as f64 * (ap * 1.2).min(0.9)).round() as u64;
            let n_lost = (n_found_clean as f64 * (1.6 * loss).min(0.9)).round() as u64;
            let rate = n_lost as f64 / n_found_clean.max(1) as f64;
            results.rates.push(FailureRow {
                scope: scope.clone(),
                group,
                n_objects,
                n_found_clean,
                n_found_cracked: n_found_clean - n_lost + n_lost / 8,
                n_lost,
                n_recovered: n_lost / 8,
                failure_rate: estimate(rate, n_found_clean),
                recovery_rate: estimate(0.03, n_objects - n_found_clean),
                p: (n_found_clean >= 20).then_some(0.0007),
                p_holm: (n_found_clean >= 20).then_some(0.004),
            });
        }
        results.new_false_positives.push(NewFalsePositives {
            scope: scope.clone(),
            n_clean: 140,
            n_cracked: 171,
            n_new: 66,
            area_mpx: 10.9 * share,
            new_per_mpx: Estimate::with_interval(6.1, [4.7, 7.8], 66),
        });
        results.shifts.push(ShiftRow {
            scope: scope.clone(),
            group: Group::all(),
            n_pairs: 167,
            score: Estimate::with_interval(-0.08 * severity / 3.0, [-0.1, -0.06], 167),
            p_score: Some(1e-9),
            p_score_holm: Some(2e-9),
            iou: Estimate::with_interval(-0.021, [-0.03, -0.01], 167),
            p_iou: Some(0.002),
            p_iou_holm: Some(0.004),
        });
        results.flips.push(FlipRow {
            scope,
            n: 326,
            n_flipped: 9,
            rate: Estimate::with_interval(9.0 / 326.0, [0.0146, 0.0516], 326),
            commonest: vec![ClassFlip {
                from: "truck".to_owned(),
                to: "car".to_owned(),
                n: 4,
            }],
        });
    }
    for (fact, unit, end) in [("coverage", "", 1.0), ("blur radius", "px", 8.0)] {
        let bins = (0..8_u32).map(|place| {
            let (low, high) = (f64::from(place) / 8.0, f64::from(place + 1) / 8.0);
            let middle = (low + high) / 2.0;
            let rate = 1.0 / (1.0 + (-(-2.2 + 4.0 * middle * severity / 3.0)).exp());
            let n = 90 - 10 * u64::from(place);
            DoseBin {
                low: low * end,
                high: high * end,
                mean: Some(middle * end),
                n,
                n_lost: (n as f64 * rate) as u64,
                rate: estimate(rate, n),
            }
        });
        results.dose_responses.push(DoseResponse {
            fact: fact.to_owned(),
            unit: unit.to_owned(),
            group: Group::all(),
            bins: bins.collect(),
            note: None,
            fit: Some(LogisticFit {
                intercept: -2.2,
                slope: Estimate::with_interval(4.0 / end, [3.1 / end, 4.9 / end], 382),
                p: Some(1e-7),
                p_holm: Some(1e-7),
            }),
        });
    }
    results
}

fn tide(scale: f64) -> TideErrors {
    TideErrors {
        ap50: 0.47 / scale,
        classification: 0.021,
        localization: 0.062 * scale,
        both: 0.008,
        duplicate: 0.001,
        background: 0.034,
        missed: 0.231 * scale,
        false_positive: 0.11,
        false_negative: 0.28 * scale,
    }
}

/// Objects in six seconds, hit after two: clean nearly all found, cracked lost one after the other.
fn clip() -> TimelineResults {
    let frames: Vec<Frame> = (0..60_u32)
        .map(|place| Frame {
            frame_idx: u64::from(place),
            time_s: f64::from(place) / 10.0,
            state: Some(match place {
                0..20 => GlassState::Intact,
                20..26 => GlassState::Growing,
                _ => GlassState::Still,
            }),
        })
        .collect();
    let track = |number: u64, is_cracked: bool| {
        let lost_from = 22 + 5 * number;
        let is_found = |frame: u64| match is_cracked {
            true => frame < lost_from || number > 6,
            false => !(frame + number).is_multiple_of(17),
        };
        let score = |frame: u64| if frame < 20 || !is_cracked { 0.8 } else { 0.6 };
        Track {
            track: number,
            category: 0,
            sightings: (number as u32..60)
                .map(|frame| Sighting {
                    frame,
                    score: is_found(frame.into()).then(|| score(frame.into())),
                })
                .collect(),
        }
    };
    let tracks = |is_cracked| (1..=9).map(|k| track(k, is_cracked)).collect::<Vec<_>>();
    let (clean, cracked) = (tracks(false), tracks(true));
    let settings = TimelineSettings::default();
    let of =
        |tracks: &[Track]| timeline(&frames, Some(20), tracks, Some(&clean), settings).unwrap();
    let name = |track: u64| TrackName {
        track,
        name: format!("{}", track + 16),
        class: if track == 2 { "person" } else { "car" }.to_owned(),
    };
    TimelineResults {
        clip: "drive 0005".to_owned(),
        frames_per_s: Some(10.0),
        n_frames: 60,
        truth: TrackSource::Labels,
        score_threshold: 0.3,
        iou_threshold: 0.5,
        objects: (1..=9).map(name).collect(),
        clean: of(&clean),
        cracked: of(&cracked),
        change: change_after(Some(20), &clean, &cracked, settings).unwrap(),
    }
}

fn picture(seed: u32, is_cracked: bool) -> Vec<u8> {
    let pixel = |x: u32, y: u32| {
        let ray = (x * 3 + seed * 40) % 97 < 3 || (x + 2 * y) % 131 < 3;
        let shade = (120 + (x / 4 + y / 3 + seed * 31) % 90) as u8;
        match is_cracked && ray {
            true => Rgb([235, 238, 240]),
            false => Rgb([shade, shade / 2 + 60, 200 - shade / 2]),
        }
    };
    let image = DynamicImage::ImageRgb8(RgbImage::from_fn(320, 200, pixel));
    let quality = JpegQuality::new(80).unwrap();
    encode_image(&image, &Encoding::Jpeg { quality }, None).unwrap()
}

fn worst(seed: u32, name: &str) -> WorstFailure {
    let one = |role, class: &str, at: [f64; 4], score| RoledBox {
        role,
        class: class.to_owned(),
        box_px: BoxPx::from_corners(at),
        score,
        coverage: Some(0.4),
    };
    WorstFailure {
        image: name.to_owned(),
        width_px: 640,
        height_px: 400,
        n_found_clean: 7,
        n_lost: 5,
        n_new: 1,
        boxes: vec![
            one(
                BoxRole::Found,
                "car",
                [40.0, 180.0, 200.0, 280.0],
                Some(0.81),
            ),
            one(BoxRole::Lost, "person", [300.0, 90.0, 370.0, 300.0], None),
            one(BoxRole::Lost, "person", [420.0, 100.0, 480.0, 290.0], None),
            one(
                BoxRole::Missed,
                "bicycle",
                [520.0, 200.0, 600.0, 270.0],
                None,
            ),
            one(BoxRole::New, "bird", [90.0, 20.0, 150.0, 60.0], Some(0.44)),
        ],
        pictures: Some(PicturePair {
            clean_jpeg: picture(seed, false),
            cracked_jpeg: picture(seed, true),
        }),
    }
}

fn protocol(scale: f64) -> ProtocolResults {
    let stats = [
        0.34, 0.527, 0.36, 0.12, 0.35, 0.52, 0.28, 0.4, 0.42, 0.18, 0.44, 0.61,
    ];
    let kitti =
        [("Car", "easy", 12_u64), ("Car", "moderate", 55)].map(|(class, difficulty, n)| KittiAp {
            class: class.to_owned(),
            difficulty: difficulty.to_owned(),
            min_overlap: 0.7,
            n_objects: n,
            ap11: estimate(0.61 * scale, n),
            ap40: match n {
                ..41 => Estimate::refused(n, format!("{n} objects, 41 are needed for AP40")),
                _ => Estimate::of(0.58 * scale, n),
            },
            ceiling_ap11: if n < 41 { 0.2727 } else { 1.0 },
            ceiling_ap40: if n < 41 { 0.275 } else { 1.0 },
        });
    let group = |(group, n_objects, ap): (Group, u64, f64)| GroupAp {
        group,
        n_objects,
        ap: Estimate::of(0.58 * ap * scale, n_objects),
        ap50: Estimate::of(ap * scale, n_objects),
        ap75: Estimate::of(0.62 * ap * scale, n_objects),
    };
    ProtocolResults {
        coco_stats: Some(stats.map(|value| Some(value * scale))),
        groups: groups().into_iter().map(group).collect(),
        kitti: kitti.to_vec(),
        n_detections: 8342,
    }
}

/// One detector under one condition.
pub(crate) fn evaluation(detector: &str, severity: u8) -> Evaluation {
    let strength = f64::from(severity);
    let skill = if detector == "YOLOX-nano" { 1.0 } else { 0.55 };
    Evaluation {
        detector: detector.to_owned(),
        condition: Condition {
            name: format!("windshield-star, severity {severity}"),
            family: Some("windshield-star".to_owned()),
            severity: Some(severity),
            seed: Some(1),
        },
        counts: Counts {
            n_images: 96,
            n_images_with_region: Some(95),
            n_objects: 441,
            n_objects_in_region: Some(265),
            n_images_intact: Some(1),
            mean_region_share: Some(0.073 * strength),
        },
        warnings: vec![Warning::FewObjectsOfClasses {
            n: 5_u32.into(),
            n_classes: 11_u32.into(),
            few: 20,
        }],
        cracked: protocol(skill * (1.0 - 0.06 * strength)),
        paired: paired(strength, skill),
        curves: curves(strength, skill),
        subsets: Vec::new(),
        failures: Some(failures(strength)),
        tide_cracked: Some(tide(1.0 + 0.1 * strength)),
        timelines: vec![clip()],
        pooled_clips: None,
        worst: vec![
            worst(1, "val2017/000000000139.jpg"),
            worst(2, "val2017/000000000285.jpg"),
        ],
        changed_objects: Vec::new(),
    }
}

/// One detector on the clean images.
fn clean_results(detector: &str) -> CleanResults {
    let skill = if detector == "YOLOX-nano" { 1.0 } else { 0.55 };
    CleanResults {
        detector: detector.to_owned(),
        warnings: Vec::new(),
        results: protocol(skill),
        tide: Some(tide(1.0)),
        label_audit: Some(LabelAudit {
            n_pairs: 312,
            agreement: Estimate::with_interval(0.859, [0.816, 0.893], 312),
            verdict: match detector {
                "YOLOX-nano" => LabelVerdict::Fits,
                _ => LabelVerdict::Wrong,
            },
            advice: (detector != "YOLOX-nano")
                .then(|| "subtract 1 from the category numbers of the detections".to_owned()),
            disagreements: vec![ShiftedLabel {
                truth: "truck".to_owned(),
                detected: "car".to_owned(),
                n: 9,
            }],
        }),
    }
}

/// Two detectors under the given severities.
pub(crate) fn study(severities: &[u8]) -> Study {
    let evaluations: Vec<Evaluation> = ["YOLOX-nano", "FastestDet"]
        .iter()
        .flat_map(|detector| {
            severities
                .iter()
                .map(|severity| evaluation(detector, *severity))
        })
        .collect();
    let sets = ["clean", "star", "tempered", "photographs of cracks"];
    let value = |row: usize, column: usize| {
        Estimate::of(0.1 * (row as f64 - 1.3 * column as f64).abs() + 0.01, 96)
    };
    Study {
        schema: Study::SCHEMA.to_owned(),
        title: "A study with made-up numbers".to_owned(),
        dataset: "coco:coco96".to_owned(),
        provenance: Provenance {
            inputs: vec![InputFile {
                role: "labels".to_owned(),
                path: "coco96/annotations/instances_val2017.json".to_owned(),
                sha256: "b4841f41".repeat(8),
                n_bytes: Some(1_234_567),
            }],
            versions: vec![Versions {
                name: "starbreak".to_owned(),
                version: "0.1.0".to_owned(),
            }],
            settings: Settings {
                protocol: "coco".to_owned(),
                region_definition: Some("region-ap/1".to_owned()),
                tau: Some(TAU),
                score_threshold: 0.3,
                iou_threshold: 0.5,
                n_bootstrap: 1000,
                n_permutations: 10_000,
                seed: 0,
                resampling_unit: "image".to_owned(),
                min_objects: 20,
                max_detections: Some(100),
            },
            command: Some("starbreak study coco:coco96 --model yolox_nano.onnx -o study".to_owned()),
            recipe: Some("schema = 1\n[glass]\nkind = \"laminated\"\n".to_owned()),
        },
        warnings: vec![Warning::Classes(
            "FastestDet: classes shifted by +1 agree better with the labels (290 of 312 objects, as they are 268); \
             check the label map before you believe a number per class"
                .to_owned(),
        )],
        clean: ["YOLOX-nano", "FastestDet"].map(clean_results).to_vec(),
        evaluations,
        over_seeds: Vec::new(),
        robustness: vec![RobustnessRow {
            detector: "YOLOX-nano".to_owned(),
            scope: Scope {
                kind: ScopeKind::InRegion,
                tau: Some(TAU),
            },
            metric: PairedMetric::Ap,
            clean: Estimate::of(0.27, 265),
            mpc: Estimate::of(0.2, 265),
            rpc: Estimate::of(0.2 / 0.27, 265),
            n_seeds: Some(1),
        }],
        divergence: Some(DivergenceResults {
            sets: sets.map(str::to_owned).to_vec(),
            tables: vec![DivergenceTable {
                feature: "luma256".to_owned(),
                measure: "KL(row ‖ column), nats".to_owned(),
                values: (0..4).map(|r| (0..4).map(|c| value(r, c)).collect()).collect(),
                noise_floor: vec![Some(0.011), Some(0.012), Some(0.01), None],
            }],
        }),
    }
}
