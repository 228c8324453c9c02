//! Real detectors on real images: the same bits for any number of threads, and what failed is said.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot open its model has failed"
)]

use crate::onnx_graph;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use onnx_graph::{Builder, seen};
use rten_onnx::onnx::{AttributeProto, AttributeType};
use starbreak_detect::{
    Backend, DetectError, Detector, DetectorOptions, Device, ImageDetections, ImageToSee,
};

/// A file or folder of the shared data, or `None` with a note on the error output.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    path.exists()
        .then_some(path)
        .or_else(|| skipped(&format!("{name} is not there")))
}

/// A detector by ONNX Runtime, or `None` with a note on the error output.
fn by_onnx_runtime() -> Option<DetectorOptions> {
    let Some(library) = std::env::var_os("STARBREAK_TEST_ONNXRUNTIME") else {
        return skipped("no ONNX Runtime is named by STARBREAK_TEST_ONNXRUNTIME");
    };
    Some(by_library(Path::new(&library)))
}

fn by_library(library: &Path) -> DetectorOptions {
    DetectorOptions {
        backend: Backend::OnnxRuntime {
            library: library.to_owned(),
            device: Device::Cpu,
        },
        ..DetectorOptions::default()
    }
}

#[expect(clippy::print_stderr, reason = "a skipped test must be seen")]
fn skipped<T>(why: &str) -> Option<T> {
    eprintln!("SKIPPED: {why}");
    None
}

fn images(n: usize) -> Option<Vec<ImageToSee>> {
    let folder = shared("coco96/val2017")?;
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    let image = |path: PathBuf| ImageToSee {
        name: path.file_name().unwrap().to_string_lossy().into_owned(),
        path,
    };
    Some(paths.into_iter().take(n).map(image).collect())
}

fn all(detector: &Detector, images: &[ImageToSee], n_threads: usize) -> Vec<ImageDetections> {
    let n_seen = AtomicUsize::new(0);
    let seen = detector.detect_all(images, n_threads, &AtomicBool::new(false), &|_, _| {
        n_seen.fetch_add(1, Ordering::Relaxed);
    });
    assert_eq!(n_seen.into_inner(), images.len(), "each image is told");
    seen.into_iter()
        .map(|found| found.unwrap().unwrap())
        .collect()
}

#[test]
fn both_real_detectors_are_known_and_give_the_same_bits_for_any_number_of_threads() {
    for (file, preset, n) in [("FastestDet", "fastestdet", 12), ("yolox_nano", "yolox", 6)] {
        let Some(model) = shared(&format!("onnx/{file}.onnx")) else {
            return;
        };
        let Some(images) = images(n) else { return };
        let detector = Detector::open(&model, &DetectorOptions::default()).unwrap();
        assert_eq!(detector.contract().name, preset, "{}", detector.reason());
        let alone = all(&detector, &images, 1);
        assert!(
            alone.iter().all(|found| !found.detections.is_empty()),
            "{file} finds something in every photograph"
        );
        for n_threads in [2, 5] {
            assert_eq!(
                all(&detector, &images, n_threads),
                alone,
                "{n_threads} threads"
            );
        }
        // Another load of the model, too.
        let again = Detector::open(&model, &DetectorOptions::default()).unwrap();
        assert_eq!(all(&again, &images, 3), alone, "loaded again");
    }
}

#[test]
fn an_image_that_cannot_be_read_fails_alone_and_a_stop_begins_no_more() {
    let folder = tempfile::tempdir().unwrap();
    let graph = Builder::default().image("images", &[1, 3, 32, 32]).output(
        "output",
        &[1, 21, 85],
        &[seen(&[0, 0, 4], &[0, 0, 0, 0])],
    );
    let model = graph.write(folder.path(), "model.onnx");
    let detector = Detector::open(&model, &DetectorOptions::default()).unwrap();
    let bad = folder.path().join("bad.png");
    std::fs::write(&bad, b"\x89PNG\r\n\x1a\nrest").unwrap();
    let images = [ImageToSee {
        name: "bad.png".to_owned(),
        path: bad,
    }];
    let seen = detector.detect_all(&images, 2, &AtomicBool::new(false), &|_, _| {});
    let error = seen[0].as_ref().unwrap().as_ref().unwrap_err();
    assert!(error.to_string().contains("bad.png"), "{error}");
    let stopped = detector.detect_all(&images, 2, &AtomicBool::new(true), &|_, _| {});
    assert_eq!(stopped.iter().flatten().count(), 0, "nothing was begun");
}

/// A network of three convolutions, each over all channels of the one before, whose last map is the output.
fn convolutions() -> Builder {
    let mut state = 1_u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        #[expect(clippy::cast_precision_loss, reason = "some number")]
        let unit = (state >> 40) as f32 / 16_777_216.0;
        unit - 0.5
    };
    let mut graph = Builder::default().image("images", &[1, 3, 32, 32]);
    let mut input = "images".to_owned();
    for (place, (n_in, n_out, stride)) in [(3, 24, 2), (24, 48, 2), (48, 85, 2)]
        .into_iter()
        .enumerate()
    {
        let [weights, output] = ["weights", "map"].map(|what| format!("{what}{place}"));
        let n = usize::try_from(n_in * n_out * 9).unwrap();
        let values: Vec<f32> = (0..n).map(|_| random() / 8.0).collect();
        graph = graph
            .weights(&weights, &[n_out, n_in, 3, 3], &values)
            .operation("Conv", &[&input, &weights], &output)
            .edit(|graph| {
                let list = |name: &str, values: &[i64]| AttributeProto {
                    name: Some(name.to_owned()),
                    ints: values.to_vec(),
                    r#type: Some(AttributeType(7)),
                    ..AttributeProto::default()
                };
                let node = graph.node.last_mut().unwrap();
                node.attribute.push(list("strides", &[stride, stride]));
                node.attribute.push(list("dilations", &[1, 1]));
                node.attribute.push(list("pads", &[1, 1, 1, 1]));
            });
        input = output;
    }
    graph
        .whole_numbers("rows", &[3], &[1, 16, 85])
        .operation("Reshape", &[&input, "rows"], "few")
        .output("rest", &[1, 5, 85], &[])
        .operation("Concat", &["few", "rest"], "output")
        .edit(|graph| {
            graph
                .node
                .last_mut()
                .unwrap()
                .attribute
                .push(AttributeProto {
                    name: Some("axis".to_owned()),
                    i: Some(1),
                    r#type: Some(AttributeType(2)),
                    ..AttributeProto::default()
                });
            graph.output.clear();
        })
        .declare("output", &[1, 21, 85])
}

#[test]
fn both_runtimes_give_the_same_numbers_but_for_the_last_digits() {
    let Some(options) = by_onnx_runtime() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let made = convolutions().write(folder.path(), "convolutions.onnx");
    // Fifty layers add up what three do not.
    let mut pairs = vec![(
        1e-5,
        made,
        image::RgbImage::from_fn(32, 32, |x, y| {
            image::Rgb([7 * x, 5 * y, 3 * (x + y)].map(|code| u8::try_from(code % 256).unwrap()))
        }),
    )];
    for file in ["FastestDet", "yolox_nano"] {
        let model = shared(&format!("onnx/{file}.onnx"));
        if let (Some(model), Some(images)) = (model, images(2)) {
            for image in images {
                pairs.push((
                    1e-3,
                    model.clone(),
                    image::open(&image.path).unwrap().to_rgb8(),
                ));
            }
        }
    }
    for (tolerance, model, pixels) in pairs {
        let rten = Detector::open(&model, &DetectorOptions::default()).unwrap();
        let other = Detector::open(&model, &options).unwrap();
        assert_eq!(rten.runtime(), "rten");
        assert!(
            other.runtime().starts_with("ONNX Runtime of commit "),
            "{}",
            other.runtime()
        );
        let [ours, theirs] = [&rten, &other].map(|one| one.raw_outputs("it", &pixels).unwrap());
        for (ours, theirs) in ours.iter().zip(&theirs) {
            assert_eq!((&ours.name, &ours.shape), (&theirs.name, &theirs.shape));
            let largest = theirs
                .values
                .iter()
                .fold(0.0_f32, |most, value| most.max(value.abs()));
            assert!(
                largest > 0.0,
                "{} of {} is empty",
                ours.name,
                model.display()
            );
            for (a, b) in ours.values.iter().zip(&theirs.values) {
                assert!(
                    (a - b).abs() <= tolerance * largest,
                    "{}: {a} and {b}",
                    model.display()
                );
            }
        }
        let again = Detector::open(&model, &options).unwrap();
        assert_eq!(
            again.raw_outputs("it", &pixels).unwrap(),
            theirs,
            "the same bits again"
        );
    }
}

#[test]
fn a_library_that_is_none_is_named_and_a_second_one_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let model = convolutions().write(folder.path(), "convolutions.onnx");
    let text = folder.path().join("no-library.so");
    std::fs::write(&text, "no library").unwrap();
    let error = Detector::open(&model, &by_library(&text)).unwrap_err();
    assert!(matches!(error, DetectError::Runtime(_)), "{error:?}");
    assert!(error.to_string().contains("no-library.so"), "{error}");
    // An attempt that failed is no obstacle.
    let Some(options) = by_onnx_runtime() else {
        return;
    };
    Detector::open(&model, &options).unwrap();
    let error = Detector::open(&model, &by_library(&text)).unwrap_err();
    assert!(error.to_string().contains("already loaded"), "{error}");
}
