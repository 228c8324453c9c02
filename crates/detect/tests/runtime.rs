//! Real detectors on real images: the same bits for any number of threads, and what failed is said.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot open its model has failed"
)]

mod onnx_graph;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use onnx_graph::{Builder, seen};
use starbreak_detect::{Detector, DetectorOptions, ImageDetections, ImageToSee};

/// A file or folder of the shared data, or `None` with a note on the error output.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    #[expect(clippy::print_stderr, reason = "a skipped test must be seen")]
    {
        eprintln!("SKIPPED: {} is not there", path.display());
    }
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
