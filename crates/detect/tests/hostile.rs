//! Files that are no models, or ask for too much: a clear error each, never a panic.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot write its file has failed"
)]

use crate::onnx_graph;

use std::fs;

use image::RgbImage;
use onnx_graph::{Builder, Dim, fixed, seen};
use rten_onnx::onnx::{DataLocation, DataType, NodeProto, StringStringEntryProto, TensorProto};
use starbreak_detect::{Contract, Detector, DetectorOptions};

/// The message of a model that cannot be opened.
fn refusal(bytes: &[u8], contract: Option<&str>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.onnx");
    fs::write(&path, bytes).unwrap();
    let options = DetectorOptions {
        contract: contract.map(|name| Contract::preset(name).unwrap()),
        ..DetectorOptions::default()
    };
    let error = Detector::open(&path, &options).unwrap_err().to_string();
    assert!(!error.contains('\n'), "one line: {error}");
    error
}

/// A graph like that of YOLOX for a frame of 32 px: 16 + 4 + 1 places.
fn yolox() -> Builder {
    Builder::default().image("images", &[1, 3, 32, 32]).output(
        "output",
        &[1, 21, 85],
        &[fixed(&[0, 0, 4], 1.0)],
    )
}

#[track_caller]
fn assert_says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{text:?} does not say {part:?}");
    }
}

#[test]
fn a_text_an_archive_and_a_pointer_are_told_apart_from_models() {
    assert_says(&refusal(b"", None), &["is empty"]);
    assert_says(
        &refusal(b"hello, world\n", None),
        &["no whole ONNX model", "it is text"],
    );
    assert_says(&refusal(b"PK\x03\x04rest", None), &["ZIP", "export"]);
    assert_says(
        &refusal(b"version https://git-lfs.github.com/spec/v1\n", None),
        &["Git LFS"],
    );
    assert_says(&refusal(b"<!DOCTYPE html>", None), &["web page"]);
    assert_says(&refusal(&[0xff; 4096], None), &["no whole ONNX model"]);
}

#[test]
fn a_model_cut_anywhere_is_refused() {
    let whole = yolox().bytes();
    for length in (1..whole.len()).step_by(7) {
        refusal(whole.get(..length).unwrap(), Some("yolox"));
    }
}

#[test]
fn bytes_that_flip_give_an_error_or_a_model_but_no_panic() {
    let whole = yolox().bytes();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.onnx");
    for place in (0..whole.len()).step_by(3) {
        let mut bytes = whole.clone();
        let flipped = bytes.get_mut(place).unwrap();
        *flipped ^= 0x2a;
        fs::write(&path, &bytes).unwrap();
        if let Ok(detector) = Detector::open(&path, &DetectorOptions::default()) {
            let _ = detector.detect("image", &RgbImage::new(8, 8));
        }
    }
}

#[test]
fn an_operator_that_is_not_known_or_wrong_is_named_with_the_way_out() {
    for name in ["RoiAlign", "NonMaxSuppression"] {
        let graph = yolox().operator(name, "images", "found");
        let error = refusal(&graph.bytes(), None);
        assert_says(&error, &[name, "--runtime onnxruntime"]);
    }
}

#[test]
fn weights_that_are_not_beside_the_model_are_named() {
    let external = |location: &'static str| {
        let graph = yolox().edit(|graph| {
            let tensor = graph.initializer.first_mut().unwrap();
            tensor.raw_data = None;
            tensor.data_location = Some(DataLocation::EXTERNAL);
            tensor.external_data = vec![StringStringEntryProto {
                key: Some("location".to_owned()),
                value: Some(location.to_owned()),
            }];
        });
        refusal(&graph.bytes(), None)
    };
    assert_says(
        &external("model.onnx.data"),
        &["model.onnx.data", "copy it along"],
    );
    assert_says(&external("../../etc/passwd"), &["not beside it"]);
    assert_says(&external("/etc/passwd"), &["not beside it"]);
}

#[test]
fn a_model_that_wants_a_hundred_gigabytes_is_refused_before_it_gets_them() {
    let of_input = Builder::default()
        .image("images", &[1, 3, 96_000, 96_000])
        .output("output", &[1, 21, 85], &[fixed(&[0, 0, 4], 1.0)]);
    assert_says(
        &refusal(&of_input.bytes(), None),
        &["103.0 GiB", "96000", "4.0 GiB"],
    );
    let of_operator = yolox().edit(|graph| {
        let shape = graph.initializer.first_mut().unwrap();
        let sides = [1_i64, 300_000, 90_000].map(i64::to_le_bytes).concat();
        shape.raw_data = Some(std::cell::RefCell::new(sides));
    });
    assert_says(
        &refusal(&of_operator.bytes(), None),
        &["100.6 GiB", "ConstantOfShape"],
    );
    let of_weights = yolox().edit(|graph| {
        graph.initializer.last_mut().unwrap().dims = vec![i64::MAX, i64::MAX];
    });
    assert_says(
        &refusal(&of_weights.bytes(), None),
        &["more than any memory"],
    );
    let negative = yolox().edit(|graph| {
        graph.initializer.last_mut().unwrap().dims = vec![-4];
    });
    assert_says(&refusal(&negative.bytes(), None), &["negative side"]);
}

/// The graph of YOLOX after one more operator on the image, whose input is a constant of these
/// whole numbers or of these.
fn grown(operator: &'static str, numbers: &[i64], scales: &[f32]) -> Vec<u8> {
    let (numbers, scales) = (numbers.to_vec(), scales.to_vec());
    let graph = yolox().edit(move |graph| {
        let whole = TensorProto {
            name: Some("numbers".to_owned()),
            dims: vec![numbers.len() as i64],
            data_type: Some(DataType::INT64),
            int64_data: numbers,
            ..TensorProto::default()
        };
        let floats = TensorProto {
            name: Some("scales".to_owned()),
            dims: vec![scales.len() as i64],
            data_type: Some(DataType::FLOAT),
            float_data: scales,
            ..TensorProto::default()
        };
        let input = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let node = |operator: &str, from: &[&str], to: &str| NodeProto {
            input: input(from),
            output: vec![to.to_owned()],
            op_type: Some(operator.to_owned()),
            ..NodeProto::default()
        };
        let from: &[&str] = match operator {
            "Resize" => &["handed_on", "", "scales"],
            _ => &["handed_on", "numbers"],
        };
        graph.initializer.extend([whole, floats]);
        graph.node.push(node("Relu", &["images"], "handed_on"));
        graph.node.push(node(operator, from, "grown"));
    });
    graph.bytes()
}

#[test]
fn an_operator_that_makes_much_of_a_frame_is_refused_before_it_runs() {
    for (operator, numbers, scales) in [
        ("Tile", &[1, 1, 1000, 1000][..], &[][..]),
        ("Pad", &[0, 0, 0, 0, 0, 0, 60_000, 60_000], &[]),
        ("Resize", &[], &[1.0, 1.0, 1000.0, 1000.0]),
        ("Expand", &[1, 3, 60_000, 60_000], &[]),
    ] {
        let error = refusal(&grown(operator, numbers, scales), None);
        assert_says(&error, &["asks for", operator, "4.0 GiB"]);
    }
    // Two columns make a table.
    let folded = yolox().edit(|graph| {
        for (name, dims) in [("a", [100_000, 1]), ("b", [1, 100_000])] {
            graph.initializer.push(TensorProto {
                name: Some(name.to_owned()),
                dims: dims.to_vec(),
                data_type: Some(DataType::FLOAT),
                float_data: vec![0.0; 100_000],
                ..TensorProto::default()
            });
        }
        graph.node.push(NodeProto {
            input: vec!["a".to_owned(), "b".to_owned()],
            output: vec!["table".to_owned()],
            op_type: Some("Add".to_owned()),
            ..NodeProto::default()
        });
    });
    assert_says(&refusal(&folded.bytes(), None), &["37.3 GiB", "Add"]);
}

#[test]
fn a_batch_other_channels_and_outputs_that_fit_nothing_are_refused_with_the_choices() {
    let batch = Builder::default().image("images", &[8, 3, 32, 32]).output(
        "output",
        &[8, 21, 85],
        &[fixed(&[0, 0, 4], 1.0)],
    );
    assert_says(
        &refusal(&batch.bytes(), Some("yolox")),
        &["several images", "batch of 1"],
    );
    let grey = Builder::default().image("images", &[1, 1, 32, 32]).output(
        "output",
        &[1, 21, 85],
        &[fixed(&[0, 0, 4], 1.0)],
    );
    assert_says(&refusal(&grey.bytes(), Some("yolox")), &["three channels"]);
    let nothing = Builder::default().image("images", &[1, 3, 32, 32]).output(
        "logits",
        &[1, 10],
        &[fixed(&[0, 0], 1.0)],
    );
    assert_says(
        &refusal(&nothing.bytes(), None),
        &["none of the presets", "logits [1, 10]", "--contract"],
    );
    let two_classes = Builder::default()
        .image("images", &[1, 3, 640, 640])
        .metadata("names", "{0: 'a', 1: 'b'}")
        .output("output0", &[1, 300, 6], &[fixed(&[0, 0, 4], 1.0)]);
    assert_says(
        &refusal(&two_classes.bytes(), None),
        &["several presets", "yolov10", "rtdetr-ultralytics"],
    );
    let open_places = Builder::default()
        .image("images", &[1, 3, 640, 640])
        .output_as(
            "output",
            &[Dim::Is(1), Dim::Open("n"), Dim::Is(85)],
            &[1, 8400, 85],
            &[fixed(&[0, 0, 4], 1.0)],
            DataType::FLOAT,
        );
    assert_says(&refusal(&open_places.bytes(), None), &["yolov5", "yolox"]);
    let static_sides = Builder::default()
        .image("input", &[1, 3, 800, 1344])
        .output("dets", &[1, 100, 5], &[fixed(&[0, 0, 4], 1.0)])
        .output("labels", &[1, 100], &[fixed(&[0, 0], 1.0)]);
    assert_says(
        &refusal(&static_sides.bytes(), None),
        &["one size", "input.resize"],
    );
}

/// The message of a model that cannot be used on an image.
fn failure(graph: Builder, value: u8) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = graph.write(folder.path(), "model.onnx");
    let detector = Detector::open(&path, &DetectorOptions::default()).unwrap();
    let image = RgbImage::from_pixel(32, 32, image::Rgb([value; 3]));
    detector.detect("a.png", &image).unwrap_err().to_string()
}

#[test]
fn outputs_that_are_no_numbers_fail_the_image_and_never_become_boxes() {
    let nan = Builder::default().image("images", &[1, 3, 32, 32]).output(
        "output",
        &[1, 21, 85],
        &[fixed(&[0, 3, 40], f32::NAN)],
    );
    assert_says(&failure(nan, 0), &["a.png", "not a number", "place 295"]);
    let infinite = Builder::default().image("images", &[1, 3, 32, 32]).output(
        "output",
        &[1, 21, 85],
        &[
            fixed(&[0, 3, 2], 800.0),
            fixed(&[0, 3, 4], 1.0),
            seen(&[0, 3, 5], &[0, 0, 0, 0]),
        ],
    );
    assert_says(&failure(infinite, 1), &["not finite"]);
}

#[test]
fn another_number_of_classes_than_the_list_is_said() {
    let graph = Builder::default().image("images", &[1, 3, 32, 32]).output(
        "output",
        &[1, 21, 25],
        &[fixed(&[0, 0, 4], 1.0)],
    );
    assert_says(
        &failure(graph, 0),
        &["20 classes", "lists 80", "classes.names"],
    );
}
