//! Every preset on a graph with the names and shapes of the real export: it is chosen by itself, the
//! image reaches the model as the reference has it, and boxes come back to the image.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot open its graph has failed"
)]

use crate::onnx_graph;

use image::{Rgb, RgbImage};
use onnx_graph::{Builder, Dim, Entry, fixed, seen};
use rten_onnx::onnx::DataType;
use starbreak_detect::{Detector, DetectorOptions, ImageDetections};

/// 200 x 100 px: red 200, green 40, blue 10 on the left, 10, 90, 250 on the right.
fn image() -> RgbImage {
    RgbImage::from_fn(200, 100, |x, _| {
        if x < 100 {
            Rgb([200, 40, 10])
        } else {
            Rgb([10, 90, 250])
        }
    })
}

fn open(graph: Builder) -> Detector {
    let folder = tempfile::tempdir().unwrap();
    let path = graph.write(folder.path(), "model.onnx");
    Detector::open(&path, &DetectorOptions::default()).unwrap()
}

/// What the preset that is chosen finds in the image.
fn found_by(preset: &str, graph: Builder) -> (Detector, ImageDetections) {
    let detector = open(graph);
    assert_eq!(detector.contract().name, preset, "{}", detector.reason());
    let found = detector.detect("image", &image()).unwrap();
    (detector, found)
}

/// Class, corners and score of what is expected.
type Expected<'a> = (&'a str, [f64; 4], f64);

fn assert_found((detector, found): &(Detector, ImageDetections), expected: &[Expected<'_>]) {
    let classes = &detector.classes().names;
    let listed: Vec<(String, [f64; 4], f64)> = found
        .detections
        .iter()
        .map(|d| {
            let name = classes.get(d.class as usize).cloned().flatten();
            (name.unwrap_or_default(), d.corners_px, d.score)
        })
        .collect();
    assert_eq!(listed.len(), expected.len(), "{listed:?}");
    for ((name, corners, score), (class, box_px, expected_score)) in listed.iter().zip(expected) {
        assert_eq!(name, class, "{listed:?}");
        assert!((score - expected_score).abs() < 1e-5, "{score}: {listed:?}");
        for (side, expected) in corners.iter().zip(box_px) {
            assert!(
                (side - expected).abs() < 1e-3,
                "{corners:?} is not {box_px:?}"
            );
        }
    }
}

/// Numbers of one place of a dense output.
fn column(place: i64, numbers: &[(i64, f32)]) -> Vec<Entry> {
    let entry = |&(number, value): &(i64, f32)| fixed(&[0, number, place], value);
    numbers.iter().map(entry).collect()
}

fn row(place: i64, numbers: &[f32]) -> Vec<Entry> {
    (0..)
        .zip(numbers)
        .map(|(number, &value)| fixed(&[0, place, number], value))
        .collect()
}

/// A 640 px frame, letterboxed: 3.2 px per px of the image, 160 rows above it.
fn from_frame([x0, y0, x1, y1]: [f64; 4]) -> [f64; 4] {
    [x0 / 3.2, (y0 - 160.0) / 3.2, x1 / 3.2, (y1 - 160.0) / 3.2]
}

const RED: f64 = 200.0 / 255.0;
const GREY: f64 = 114.0 / 255.0;

#[test]
fn yolov8_is_letterboxed_rgb_with_suppression_per_class_and_several_labels() {
    let mut entries = column(10, &[(0, 320.0), (1, 320.0), (2, 100.0), (3, 50.0)]);
    // Its score for class 2 is the red of a place in the left half of the image.
    entries.push(seen(&[0, 4 + 2, 10], &[0, 0, 320, 100]));
    entries.extend(column(10, &[(4 + 7, 0.25)]));
    entries.extend(column(
        11,
        &[(0, 322.0), (1, 320.0), (2, 100.0), (3, 50.0), (4 + 2, 0.6)],
    ));
    entries.extend(column(
        12,
        &[(0, 322.0), (1, 320.0), (2, 100.0), (3, 50.0), (4 + 5, 0.6)],
    ));
    // Beyond the image, in the grey above it: cut at the sides.
    entries.extend(column(13, &[(0, 20.0), (1, 150.0), (2, 80.0), (3, 60.0)]));
    entries.push(seen(&[0, 4, 13], &[0, 1, 159, 5]));
    let graph = Builder::default()
        .image("images", &[1, 3, 640, 640])
        .metadata("task", "detect")
        .output("output0", &[1, 84, 8400], &entries);
    assert_found(
        &found_by("yolov8", graph),
        &[
            ("car", from_frame([270.0, 295.0, 370.0, 345.0]), RED),
            ("bus", from_frame([272.0, 295.0, 372.0, 345.0]), 0.6),
            ("person", [0.0, 0.0, 60.0 / 3.2, 20.0 / 3.2], GREY),
            ("truck", from_frame([270.0, 295.0, 370.0, 345.0]), 0.25),
        ],
    );
}

#[test]
fn ultralytics_names_come_from_the_model_and_a_frame_may_be_no_square() {
    let mut entries = column(3, &[(0, 320.0), (1, 192.0), (2, 64.0), (3, 64.0), (5, 0.5)]);
    entries.push(seen(&[0, 4, 3], &[0, 2, 192, 600]));
    let graph = Builder::default()
        .image("images", &[1, 3, 384, 640])
        .metadata("names", "{0: 'crack', 1: \"driver's door\"}")
        .output("output0", &[1, 6, 5040], &entries);
    // 32 rows above: (384 - 320) / 2. The blue of the right half is the score of class 0.
    let expected = [
        288.0 / 3.2,
        (160.0 - 32.0) / 3.2,
        352.0 / 3.2,
        (224.0 - 32.0) / 3.2,
    ];
    assert_found(
        &found_by("yolov8", graph),
        &[
            ("crack", expected, 250.0 / 255.0),
            ("driver's door", expected, 0.5),
        ],
    );
}

#[test]
fn rows_of_six_are_yolov10_or_yolov8_with_suppression_inside() {
    let graph = |with_nms: bool| {
        let mut entries = row(0, &[100.0, 200.0, 300.0, 400.0, 0.9, 2.0]);
        entries.extend(row(1, &[100.0, 200.0, 300.0, 400.0, 0.8, 2.0]));
        entries.extend(row(2, &[0.0, 160.0, 32.0, 192.0, 0.0, 0.0]));
        entries.push(seen(&[0, 2, 4], &[0, 0, 300, 10]));
        let arguments = if with_nms {
            "{'nms': True}"
        } else {
            "{'nms': False}"
        };
        Builder::default()
            .image("images", &[1, 3, 640, 640])
            .metadata("args", arguments)
            .output("output0", &[1, 300, 6], &entries)
    };
    let car = from_frame([100.0, 200.0, 300.0, 400.0]);
    let expected = [
        ("car", car, 0.9),
        ("car", car, 0.8),
        ("person", [0.0, 0.0, 10.0, 10.0], RED),
    ];
    assert_found(&found_by("yolov10", graph(false)), &expected);
    assert_found(&found_by("yolov8-nms", graph(true)), &expected);
}

#[test]
fn yolov5_multiplies_objectness_and_class() {
    let mut entries = row(100, &[320.0, 320.0, 100.0, 50.0, 0.5]);
    entries.push(seen(&[0, 100, 5 + 2], &[0, 0, 320, 100]));
    entries.extend(row(
        25_199,
        &[320.0, 320.0, 20.0, 20.0, 0.9, 0.0, 0.0, 0.0, 1.0],
    ));
    let graph = Builder::default()
        .image("images", &[1, 3, 640, 640])
        .output("output0", &[1, 25_200, 85], &entries);
    assert_found(
        &found_by("yolov5", graph),
        &[
            ("motorcycle", from_frame([310.0, 310.0, 330.0, 330.0]), 0.9),
            ("car", from_frame([270.0, 295.0, 370.0, 345.0]), 0.5 * RED),
        ],
    );
}

#[test]
fn yolox_is_top_left_bgr_of_whole_bytes_and_relative_to_its_cells() {
    // Of a 416 px frame: 52 x 52 cells of 8 px, 26 x 26 of 16, 13 x 13 of 32. Place 52 * 52 + 26 + 3
    // is the cell (3, 1) of the second grid.
    let place = 52 * 52 + 26 + 3;
    let mut entries = row(place, &[0.5, 0.25, 4.0_f32.ln(), 2.0_f32.ln(), 1.0]);
    // Blue first: 10 in the left half.
    entries.push(Entry {
        gain: 0.01,
        ..seen(&[0, place, 5 + 2], &[0, 0, 100, 100])
    });
    // Grey below the image, 208 rows.
    entries.extend(row(7, &[0.0, 0.0, 0.0, 0.0, 1.0]));
    entries.push(Entry {
        gain: 0.001,
        ..seen(&[0, 7, 5], &[0, 2, 300, 10])
    });
    let graph = Builder::default()
        .image("images", &[1, 3, 416, 416])
        .output("output", &[1, 3549, 85], &entries);
    let gain = 2.08;
    let center = [(3.0 + 0.5) * 16.0, (1.0 + 0.25) * 16.0];
    let car = [
        center[0] - 32.0,
        center[1] - 16.0,
        center[0] + 32.0,
        center[1] + 16.0,
    ];
    let person = [7.0 * 8.0 - 4.0, -4.0, 7.0 * 8.0 + 4.0, 4.0];
    assert_found(
        &found_by("yolox", graph),
        &[
            ("person", person.map(|side| side / gain), 0.114),
            ("car", car.map(|side| side / gain), 0.1),
        ],
    );
}

#[test]
fn yolox_that_is_decoded_inside_is_told_by_its_exp() {
    let mut entries = row(9, &[208.0, 104.0, 41.6, 20.8, 1.0]);
    entries.push(fixed(&[0, 9, 5], 0.5));
    let graph = Builder::default()
        .image("images", &[1, 3, 416, 416])
        .output("output", &[1, 3549, 85], &entries)
        .operator("Exp", "output/gains", "unused");
    let expected = [90.0, 45.0, 110.0, 55.0];
    assert_found(
        &found_by("yolox-decoded", graph),
        &[("person", expected, 0.5)],
    );
}

#[test]
fn torchvision_gets_the_image_as_it_is_and_counts_classes_from_one() {
    let boxes = [10.0, 20.0, 60.0, 80.0, 0.0, 0.0, 5.0, 5.0_f32];
    let boxes: Vec<Entry> = (0..)
        .zip(boxes)
        .map(|(at, value)| fixed(&[at / 4, at % 4], value))
        .collect();
    let n = Dim::Open("n");
    let graph = Builder::default()
        .input(
            "image",
            DataType::FLOAT,
            &[Dim::Is(3), Dim::Open("h"), Dim::Open("w")],
        )
        .output_as("boxes", &[n, Dim::Is(4)], &[2, 4], &boxes, DataType::FLOAT)
        .output_as(
            "labels",
            &[n],
            &[2],
            &[fixed(&[0], 3.0), fixed(&[1], 90.0)],
            DataType::INT64,
        )
        .output_as(
            "scores",
            &[n],
            &[2],
            &[seen(&[0], &[0, 50, 50]), seen(&[1], &[2, 50, 150])],
            DataType::FLOAT,
        );
    assert_found(
        &found_by("torchvision-fasterrcnn", graph),
        &[
            ("toothbrush", [0.0, 0.0, 5.0, 5.0], 250.0 / 255.0),
            ("car", [10.0, 20.0, 60.0, 80.0], RED),
        ],
    );
}

#[test]
fn mmdeploy_is_normalized_to_800_by_1333_and_padded_to_32() {
    // 200 x 100 becomes 1333 x 667 (6.665 times), in a frame of 1344 x 672.
    let mut dets = row(0, &[133.3, 66.7, 666.5, 333.5, 0.9]);
    // Grey beyond the image is zero after normalization; red is not.
    dets.extend(row(1, &[0.0, 0.0, 66.65, 66.7, 0.5]));
    dets.push(Entry {
        value: 0.5,
        ..seen(&[0, 1, 4], &[0, 0, 671, 1343])
    });
    dets.extend(row(2, &[0.0, 0.0, 133.3, 133.4]));
    dets.push(Entry {
        gain: 0.25,
        ..seen(&[0, 2, 4], &[0, 0, 300, 300])
    });
    let labels = [
        fixed(&[0, 0], 2.0),
        fixed(&[0, 1], 0.0),
        fixed(&[0, 2], 79.0),
    ];
    let batch = Dim::Open("batch");
    let (height, width, n) = (
        Dim::Open("height"),
        Dim::Open("width"),
        Dim::Open("num_dets"),
    );
    let graph = |numbers: Dim| {
        Builder::default()
            .input(
                "input",
                DataType::FLOAT,
                &[batch, Dim::Is(3), height, width],
            )
            .output_as(
                "dets",
                &[batch, n, numbers],
                &[1, 3, 5],
                &dets,
                DataType::FLOAT,
            )
            .output_as("labels", &[batch, n], &[1, 3], &labels, DataType::INT64)
    };
    let (gx, gy) = (1333.0 / 200.0, 667.0 / 100.0);
    let red = (200.0 - 123.675) / 58.395 * 0.25;
    // As the export of RetinaNet-PVTv2 names the third side.
    for numbers in [Dim::Is(5), Dim::Open("Reshapedets_dim_2")] {
        assert_found(
            &found_by("mmdeploy", graph(numbers)),
            &[
                ("car", [133.3 / gx, 66.7 / gy, 666.5 / gx, 333.5 / gy], 0.9),
                ("person", [0.0, 0.0, 10.0, 10.0], 0.5),
                ("toothbrush", [0.0, 0.0, 20.0, 20.0], red),
            ],
        );
    }
}

#[test]
fn rtdetr_is_told_the_width_and_the_height_of_the_image() {
    // The right side of the box is the first number that the model was told, the lower the second.
    let mut boxes = row(5, &[10.0, 20.0]);
    boxes.push(seen(&[0, 5, 2], &[0, 0]));
    boxes.push(seen(&[0, 5, 3], &[0, 1]));
    let scores = [seen(&[0, 5], &[0, 2, 600, 600])];
    let labels = [fixed(&[0, 5], 2.0)];
    let batch = Dim::Open("N");
    let frame = [batch, Dim::Is(3), Dim::Is(640), Dim::Is(640)];
    let many = [batch, Dim::Is(300)];
    let four = [batch, Dim::Is(300), Dim::Is(4)];
    let graph = Builder::default()
        .input("images", DataType::FLOAT, &frame)
        .input("orig_target_sizes", DataType::INT64, &[batch, Dim::Is(2)])
        .output_as("labels", &many, &[1, 300], &labels, DataType::INT64)
        .output_as("scores", &many, &[1, 300], &scores, DataType::FLOAT)
        .reading("orig_target_sizes", 2)
        .output_as("boxes", &four, &[1, 300, 4], &boxes, DataType::FLOAT);
    assert_found(
        &found_by("rtdetr", graph),
        &[("car", [10.0, 20.0, 200.0, 100.0], 250.0 / 255.0)],
    );
}

#[test]
fn rtdetr_of_ultralytics_is_stretched_and_has_shares_of_the_frame() {
    let mut entries = row(4, &[0.5, 0.5, 0.2, 0.4]);
    entries.push(seen(&[0, 4, 4 + 2], &[0, 0, 5, 5]));
    entries.push(fixed(&[0, 4, 4 + 3], 0.1));
    let graph = Builder::default()
        .image("images", &[1, 3, 640, 640])
        .output("output0", &[1, 300, 84], &entries);
    // The best class alone.
    assert_found(
        &found_by("rtdetr-ultralytics", graph),
        &[("car", [80.0, 30.0, 120.0, 70.0], RED)],
    );
}

#[test]
fn rfdetr_has_logits_of_coco_numbers() {
    let boxes = row(0, &[0.5, 0.5, 0.2, 0.4]);
    // A logit of zero is a score of one half: all others are far below.
    let mut logits: Vec<Entry> = (0..300 * 91)
        .filter(|at| ![1, 3].contains(at))
        .map(|at| fixed(&[0, at / 91, at % 91], -20.0))
        .collect();
    logits.push(fixed(&[0, 0, 3], 2.0));
    // Normalized: (10 / 255 - 0.485) / 0.229 of red on the right.
    logits.push(Entry {
        value: 1.0,
        ..seen(&[0, 0, 1], &[0, 0, 5, 500])
    });
    let graph = Builder::default()
        .image("input", &[1, 3, 560, 560])
        .output("dets", &[1, 300, 4], &boxes)
        .output("labels", &[1, 300, 91], &logits);
    let (detector, found) = found_by("rfdetr", graph);
    let mut found = found;
    found.detections.retain(|detection| detection.score > 0.01);
    let red = (10.0 / 255.0 - 0.485) / 0.229;
    let score = |logit: f64| 1.0 / (1.0 + f64::exp(-logit));
    assert_found(
        &(detector, found),
        &[
            ("car", [80.0, 30.0, 120.0, 70.0], score(2.0)),
            ("person", [80.0, 30.0, 120.0, 70.0], score(1.0 + red)),
        ],
    );
}

#[test]
fn detr_has_a_softmax_whose_last_class_is_none() {
    let boxes = row(0, &[0.5, 0.5, 0.2, 0.4]);
    // 0.5 ln 3 against zeros: what is sought is e^v / (e^v + 91).
    let logits = [fixed(&[0, 0, 3], 8.0), fixed(&[0, 1, 91], 20.0)];
    let (batch, height, width) = (Dim::Open("batch"), Dim::Open("height"), Dim::Open("width"));
    let graph = Builder::default()
        .input(
            "pixel_values",
            DataType::FLOAT,
            &[batch, Dim::Is(3), height, width],
        )
        .input("pixel_mask", DataType::INT64, &[batch, height, width])
        .output_as(
            "logits",
            &[batch, Dim::Is(100), Dim::Is(92)],
            &[1, 100, 92],
            &logits,
            DataType::FLOAT,
        )
        .output_as(
            "pred_boxes",
            &[batch, Dim::Is(100), Dim::Is(4)],
            &[1, 100, 4],
            &boxes,
            DataType::FLOAT,
        );
    let (detector, mut found) = found_by("detr", graph);
    found.detections.retain(|detection| detection.score > 0.5);
    let power = f64::exp(8.0);
    assert_found(
        &(detector, found),
        &[("car", [80.0, 30.0, 120.0, 70.0], power / (power + 91.0))],
    );
}

#[test]
fn fastestdet_is_stretched_bgr_with_powers_of_objectness_and_class() {
    let cell = |number: i64, value: f32| fixed(&[0, number, 11, 4], value);
    let mut entries = vec![
        cell(0, 0.81),
        cell(1, 0.0),
        cell(2, 0.5),
        cell(3, 0.0),
        cell(4, -1.0),
    ];
    // Blue first: 10 of 255 in the left half.
    entries.push(seen(&[0, 5 + 2, 11, 4], &[0, 0, 10, 10]));
    let graph = Builder::default()
        .image("input.1", &[1, 3, 352, 352])
        .output("758", &[1, 85, 22, 22], &entries);
    let (x, y) = (4.0 / 22.0, (11.0 + f64::tanh(0.5)) / 22.0);
    let (w, h) = (0.5, 1.0 / (1.0 + f64::exp(1.0)));
    let corners = [x - w / 2.0, y - h / 2.0, x + w / 2.0, y + h / 2.0];
    let expected = [
        corners[0] * 200.0,
        corners[1] * 100.0,
        corners[2] * 200.0,
        corners[3] * 100.0,
    ];
    let score = f64::powf(0.81, 0.6) * f64::powf(10.0 / 255.0, 0.4);
    assert_found(&found_by("fastestdet", graph), &[("car", expected, score)]);
}
