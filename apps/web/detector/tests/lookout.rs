//! A lookout beside the detector that it is made of.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../../../crates/detect/tests/onnx_graph/mod.rs"]
mod onnx_graph;

use std::path::Path;

use image::RgbaImage;
use onnx_graph::{Builder, fixed, seen};
use serde_json::{Value, json};
use starbreak_detect::{Detector, DetectorOptions};
use starbreak_web_detector::Lookout;

/// The model of the page's own test, too: a box in the middle whose score is the red there, and one that is always
/// there.
fn spot() -> Vec<u8> {
    let place = |place, numbers: [f32; 4]| {
        (0..)
            .zip(numbers)
            .map(move |(number, value)| fixed(&[0, number, place], value))
    };
    let mut entries: Vec<_> = place(0, [32.0, 32.0, 8.0, 6.0]).collect();
    entries.push(seen(&[0, 4, 0], &[0, 0, 32, 32]));
    entries.extend(place(1, [12.0, 30.0, 10.0, 4.0]));
    entries.push(fixed(&[0, 5, 1], 0.75));
    let graph = Builder::default()
        .image("images", &[1, 3, 64, 64])
        .metadata("names", "{0: 'red', 1: 'always'}");
    graph.output("output0", &[1, 6, 84], &entries).bytes()
}

fn ask(lookout: &mut Lookout, question: &Value, bytes: &[u8]) -> Result<Value, String> {
    let given = lookout.answer(&question.to_string(), bytes.to_vec());
    given
        .map(|answer| answer.words)
        .map_err(|trouble| trouble.to_string())
}

#[test]
fn boxes_are_those_of_the_detector() {
    let picture = RgbaImage::from_fn(124, 38, |x, y| {
        let [x, y] = [x, y].map(|side| u8::try_from(side).unwrap());
        image::Rgba([2 * x, 3 * y, 90, 255])
    });
    let mut lookout = Lookout::default();
    let model = json!({ "ask": "model", "name": "spot.onnx" });
    let said = ask(&mut lookout, &model, &spot()).unwrap();
    assert_eq!(said["contract"], "yolov8", "{said}");
    let look = json!({ "ask": "detect", "width_px": 124, "height_px": 38 });
    let found = ask(&mut lookout, &look, picture.as_raw()).unwrap();

    let detector = Detector::of_bytes("spot.onnx", spot(), &DetectorOptions::default()).unwrap();
    let rgb = image::DynamicImage::ImageRgba8(picture.clone()).into_rgb8();
    let expected = detector.detect("a picture", &rgb).unwrap().detections;
    let boxes = found["boxes"].as_array().unwrap();
    assert_eq!(boxes.len(), expected.len(), "{found}");
    assert_eq!(boxes.len(), 2, "{found}");
    for (found, expected) in boxes.iter().zip(expected) {
        let name = ["red", "always"][expected.class as usize];
        assert_eq!(found["class"], name, "{found}");
        assert_eq!(found["score"], expected.score, "{found}");
        assert_eq!(found["corners_px"], json!(expected.corners_px), "{found}");
    }
}

#[test]
fn what_cannot_be_done_is_said_and_the_model_stays() {
    let mut lookout = Lookout::default();
    let look = json!({ "ask": "detect", "width_px": 2, "height_px": 2 });
    let error = ask(&mut lookout, &look, &[0; 16]).unwrap_err();
    assert_eq!(error, "there is no model yet", "too early");
    ask(
        &mut lookout,
        &json!({ "ask": "model", "name": "spot.onnx" }),
        &spot(),
    )
    .unwrap();
    let broken = json!({ "ask": "model", "name": "broken.onnx" });
    let error = ask(&mut lookout, &broken, &spot()[..40]).unwrap_err();
    assert!(error.contains("broken.onnx"), "{error}");
    let error = ask(&mut lookout, &look, &[0; 15]).unwrap_err();
    assert!(error.contains("15 bytes"), "{error}");
    assert!(
        ask(&mut lookout, &look, &[0; 16]).is_ok(),
        "the first model is there"
    );
}

#[test]
fn the_page_is_tested_with_this_model() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../page/test/spot.onnx");
    if std::env::var_os("STARBREAK_WRITE_SPOT").is_some() {
        std::fs::write(path, spot()).unwrap();
    }
    let kept = std::fs::read(Path::new(path)).unwrap();
    assert!(
        kept == spot(),
        "write it again: STARBREAK_WRITE_SPOT=1 cargo test -p starbreak-web-detector"
    );
}
