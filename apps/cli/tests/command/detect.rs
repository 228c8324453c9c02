//! `starbreak detect`: a detector over a dataset, whole results or none.

use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{
    all_refused, command, folder, json, skipped, starbreak, succeed, write_photo,
};
use serde_json::Value;

/// A file or folder of the shared data, or `None` with a note on the error output.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name);
    if path.exists() {
        return Some(path);
    }
    skipped(&format!("{} is not there", path.display()));
    None
}

#[test]
fn boxes_carry_the_numbers_of_the_labels_and_do_not_depend_on_threads() {
    let (Some(model), Some(data)) = (shared("onnx/FastestDet.onnx"), shared("coco96")) else {
        return;
    };
    let dir = folder();
    let source = format!("coco:{}", data.display());
    let model = model.to_string_lossy().into_owned();
    let detect = |out: &str, threads: &str| {
        let args = ["detect", "--json", "--model", &model, &source, "-o", out];
        succeed(
            dir.path(),
            &[&args[..], &["--limit", "6", "--threads", threads]].concat(),
        )
    };
    let outcome = detect("one.json", "1");
    assert!(
        outcome.stderr.contains("contract fastestdet, because"),
        "{outcome:?}"
    );
    detect("three.json", "3");
    let read = |name: &str| fs::read(dir.path().join(name)).unwrap();
    assert_eq!(read("one.json"), read("three.json"), "the same bytes");
    let annotations = fs::read_dir(data.join("annotations"))
        .unwrap()
        .next()
        .unwrap();
    let labels = json(&annotations.unwrap().path());
    let ids = |list: &str| -> Vec<i64> {
        let items = labels[list].as_array().unwrap();
        items
            .iter()
            .map(|item| item["id"].as_i64().unwrap())
            .collect()
    };
    let (images, categories) = (ids("images"), ids("categories"));
    let boxes = json(&dir.path().join("one.json"));
    let boxes: &Vec<Value> = boxes.as_array().unwrap();
    let said: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(
        said["n_detections"].as_u64(),
        Some(boxes.len() as u64),
        "{said}"
    );
    assert!(boxes.len() > 100, "only {} boxes", boxes.len());
    for found in boxes {
        assert!(
            images.contains(&found["image_id"].as_i64().unwrap()),
            "{found}"
        );
        assert!(
            categories.contains(&found["category_id"].as_i64().unwrap()),
            "{found}"
        );
        assert_eq!(found["bbox"].as_array().unwrap().len(), 4, "{found}");
    }
}

#[test]
fn results_of_kitti_and_bdd_have_the_forms_of_their_datasets() {
    let (Some(model), Some(data)) = (shared("onnx/FastestDet.onnx"), shared("kitti")) else {
        return;
    };
    let dir = folder();
    let source = format!("kitti:{}", data.display());
    let model = model.to_string_lossy().into_owned();
    let detect = |out: &str, format: &str| {
        let args = [
            "detect", "--model", &model, &source, "-o", out, "--format", format,
        ];
        succeed(
            dir.path(),
            &[&args[..], &["--limit", "2", "--score-threshold", "0.2"]].concat(),
        )
    };
    let outcome = detect("results", "kitti");
    assert!(
        outcome.stderr.contains("bicycle"),
        "unmapped classes are listed: {outcome:?}"
    );
    let mut files: Vec<String> = fs::read_dir(dir.path().join("results/data"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(
        files,
        ["000000.txt", "000001.txt"],
        "only what was looked through"
    );
    let text = fs::read_to_string(dir.path().join("results/data/000000.txt")).unwrap();
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        assert_eq!(words.len(), 16, "{line}");
        assert!(
            ["Car", "Truck", "Pedestrian", "Tram"].contains(&words[0]),
            "{line}"
        );
    }
    assert!(text.contains("Pedestrian"), "the frame shows one: {text}");
    detect("dt.json", "bdd");
    let frames = json(&dir.path().join("dt.json"));
    assert_eq!(frames[0]["name"], "000000.png", "{}", frames[0]);
}

#[test]
fn an_image_that_is_none_is_listed_and_the_others_are_done() {
    let Some(model) = shared("onnx/FastestDet.onnx") else {
        return;
    };
    let dir = folder();
    fs::create_dir(dir.path().join("photos")).unwrap();
    write_photo(&dir.path().join("photos/good.png"));
    fs::write(dir.path().join("photos/bad.png"), b"no image").unwrap();
    let model = model.to_string_lossy().into_owned();
    let args = [
        "detect",
        "--json",
        "--model",
        &model,
        "folder:photos",
        "-o",
        "dt.json",
    ];
    let outcome = starbreak(dir.path(), &args);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(
        outcome.stderr.contains("1 of 2 images failed"),
        "{outcome:?}"
    );
    let said: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(said["failed"][0]["name"], "bad.png", "{said}");
    let boxes = json(&dir.path().join("dt.json"));
    let is_second = |found: &Value| found["image_id"] == 2;
    assert!(boxes.as_array().unwrap().iter().all(is_second), "{boxes}");
}

#[test]
fn what_cannot_work_is_refused_before_anything_is_written() {
    let dir = folder();
    fs::create_dir(dir.path().join("photos")).unwrap();
    write_photo(&dir.path().join("photos/good.png"));
    fs::write(dir.path().join("text.onnx"), "no model").unwrap();
    fs::write(
        dir.path().join("mine.toml"),
        "schema = 1\npreset = \"yolov9\"\n",
    )
    .unwrap();
    let detect = |more: &[&'static str]| [&["detect", "folder:photos"][..], more].concat();
    all_refused(
        dir.path(),
        &[
            (detect(&["-o", "dt.json"]), "--model"),
            (
                detect(&["--model", "text.onnx", "-o", "dt.json"]),
                "it is text",
            ),
            (
                detect(&["--model", "none.onnx", "-o", "dt.json"]),
                "none.onnx",
            ),
            (
                detect(&["--model", "text.onnx", "-o", "text.onnx"]),
                "would replace",
            ),
            (detect(&["--model", "text.onnx", "-o", "photos"]), "photos"),
            (
                detect(&["--model", "text.onnx", "-o", "a", "--contract", "yolov99"]),
                "did you mean \"yolov",
            ),
            (
                detect(&["--model", "text.onnx", "-o", "a", "--contract", "mine.toml"]),
                "yolov9",
            ),
            (
                detect(&[
                    "--model",
                    "text.onnx",
                    "-o",
                    "a",
                    "--score-threshold",
                    "1.5",
                ]),
                "0 to 1",
            ),
            (
                detect(&[
                    "--model",
                    "text.onnx",
                    "-o",
                    "a",
                    "--cuda",
                    "--runtime",
                    "rten",
                ]),
                "--runtime rten asks for rten",
            ),
            (
                detect(&[
                    "--model",
                    "text.onnx",
                    "-o",
                    "a",
                    "--onnxruntime",
                    "text.onnx",
                ]),
                "pip install onnxruntime",
            ),
        ],
    );
    let listed = succeed(dir.path(), &["detect", "--list-contracts"]);
    assert!(
        listed.stdout.contains("torchvision-fasterrcnn"),
        "{listed:?}"
    );
}

/// Runs `detect` on four images with a variable for the library, and gives exit code, result and remarks.
fn detect_with(library: &Path, more: &[&str]) -> Option<(Option<i32>, Value, String)> {
    let (model, data) = (shared("onnx/FastestDet.onnx")?, shared("coco96")?);
    let dir = folder();
    let source = format!("coco:{}", data.display());
    let model = model.to_string_lossy().into_owned();
    let args = [
        "detect", "--json", "--model", &model, &source, "--limit", "4", "-o", "dt.json",
    ];
    let mut command = command(dir.path(), &[&args, more].concat());
    let done = command.env("ORT_DYLIB_PATH", library).output().unwrap();
    let result = serde_json::from_slice(&done.stdout).unwrap_or_default();
    Some((
        done.status.code(),
        result,
        String::from_utf8(done.stderr).unwrap(),
    ))
}

#[test]
fn onnx_runtime_is_taken_where_it_is_found_and_rten_where_it_is_not() {
    let dir = folder();
    let none = dir.path().join("none.so");
    let Some((code, result, said)) = detect_with(&none, &["--runtime", "auto"]) else {
        return;
    };
    assert_eq!(
        (code, &result["runtime"]),
        (Some(0), &"rten".into()),
        "{said}"
    );
    assert!(
        said.contains("none.so") && said.contains("rten runs the detectors"),
        "{said}"
    );
    let of_rten = result["n_detections"].as_i64().unwrap();
    let (code, _, said) = detect_with(&none, &["--runtime", "onnxruntime"]).unwrap();
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("none.so") && said.contains("--runtime rten"),
        "{said}"
    );
    // Who asks for nothing gets what all have.
    let (_, result, said) = detect_with(&none, &[]).unwrap();
    assert_eq!(result["runtime"], "rten", "{said}");
    let Some(library) = std::env::var_os("STARBREAK_TEST_ONNXRUNTIME").map(PathBuf::from) else {
        return skipped("no ONNX Runtime is named by STARBREAK_TEST_ONNXRUNTIME");
    };
    let named = library.to_string_lossy().into_owned();
    for (in_variable, more) in [
        (&library, &["--runtime", "auto"][..]),
        (&library, &["--runtime", "onnxruntime"]),
        (&none, &["--onnxruntime", &named]),
    ] {
        let (code, result, said) = detect_with(in_variable, more).unwrap();
        assert_eq!(code, Some(0), "{said}");
        let runtime = result["runtime"].as_str().unwrap();
        assert!(runtime.starts_with("ONNX Runtime of commit "), "{runtime}");
        assert!(said.contains(runtime), "{said}");
        let n = result["n_detections"].as_i64().unwrap();
        assert!((n - of_rten).abs() <= 1, "{n} boxes, {of_rten} by rten");
    }
}
