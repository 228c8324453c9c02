//! `starbreak divergence` as a user runs it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::program::{NO_DRAWS, skipped};
use serde_json::Value;

fn run(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_starbreak"))
        .current_dir(folder)
        .arg("divergence")
        .args(args)
        .output()
        .unwrap()
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A gray picture of a wave whose lightness and phase depend on two numbers.
fn put(path: &Path, lightness: u8, phase: u32) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    let (width, height) = (48 + phase % 5, 40);
    let pixels: Vec<u8> = (0..width * height)
        .map(|at| lightness.wrapping_add(u8::try_from((at % width * 3 + phase * 7) % 64).unwrap()))
        .collect();
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&pixels)
        .unwrap();
}

/// Folders a, b (like a) and far (lighter).
fn three_sets(folder: &Path) {
    three_sets_of(folder, 8);
}

fn three_sets_of(folder: &Path, n: u32) {
    for at in 0..n {
        let name = |set: &str| folder.join(set).join(format!("{set}{at}.png"));
        put(&name("a"), 40, at);
        put(&name("b"), 40, at + 20);
        put(&name("far"), 170, at);
    }
}

#[test]
fn one_distribution_is_within_its_floor_and_another_far_above_it_for_any_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    three_sets(dir.path());
    let args = ["a=folder:a", "b=folder:b", "far=folder:far", "-o"];
    let few = [
        "--bootstrap",
        "50",
        "--permutations",
        "199",
        "--splits",
        "20",
    ];
    let go = |out: &str, threads: &str| {
        let all = [&args[..], &[out], &few, &["--json", "--threads", threads]].concat();
        run(dir.path(), &all)
    };
    let (one, four) = (go("one", "1"), go("four", "4"));
    assert!(one.status.success(), "{}", said(&one));
    assert_eq!(one.stdout, four.stdout, "the same numbers");
    for file in ["divergence.json", "divergence.csv", "divergence.svg"] {
        let read = |out: &str| fs::read(dir.path().join(out).join(file)).unwrap();
        assert_eq!(read("one"), read("four"), "{file}");
    }
    let report = json(&one);
    assert_eq!(report["definition"], "div/1", "by name");
    let luma = |pair: usize| &report["pairs"][pair]["features"][0]["measures"]["js"];
    let number = |value: &Value| value.as_f64().unwrap();
    assert!(number(&luma(0)["p_value"]) > 0.05, "a and b: {}", luma(0));
    assert!(
        number(&luma(1)["p_value"]) <= 0.02,
        "a and far: {}",
        luma(1)
    );
    assert!(number(&luma(1)["effect"]) > 10.0, "a and far: {}", luma(1));
    let again = go("one", "1");
    assert_eq!(again.status.code(), Some(2), "nothing is replaced unasked");
}

#[test]
fn what_cannot_be_read_is_listed_and_ends_with_1() {
    let dir = tempfile::tempdir().unwrap();
    three_sets(dir.path());
    fs::write(dir.path().join("b/broken.png"), b"\x89PNG\r\n\x1a\nno").unwrap();
    let few = ["--bootstrap", "0", "--permutations", "0", "--splits", "0"];
    let output = run(
        dir.path(),
        &[&["a=folder:a", "b=folder:b", "--json"], &few[..]].concat(),
    );
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    let report = json(&output);
    assert_eq!(report["sets"][1]["n"], 8, "the rest is measured");
    assert_eq!(
        report["sets"][1]["failed"][0]["name"], "broken.png",
        "which"
    );

    fs::create_dir(dir.path().join("none")).unwrap();
    let output = run(dir.path(), &["folder:a", "folder:none"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(
        said(&output).contains("has no image that can be read"),
        "{}",
        said(&output)
    );
}

#[test]
fn one_image_has_no_floor_and_shared_files_are_said() {
    let dir = tempfile::tempdir().unwrap();
    three_sets(dir.path());
    fs::create_dir(dir.path().join("single")).unwrap();
    fs::copy(dir.path().join("a/a0.png"), dir.path().join("single/x.png")).unwrap();
    let output = run(
        dir.path(),
        &[
            "a=folder:a",
            "one=folder:single",
            "--json",
            "--permutations",
            "9",
        ],
    );
    assert!(output.status.success(), "{}", said(&output));
    let report = json(&output);
    let js = &report["pairs"][0]["features"][0]["measures"]["js"];
    assert!(js["interval"].is_null(), "no interval of one image: {js}");
    assert_eq!(report["pairs"][0]["n_shared"], 1, "the same file");
    let notes = report["notes"].to_string();
    assert!(notes.contains("has one image"), "{notes}");
    assert!(notes.contains("share 1 identical files"), "{notes}");
}

#[test]
fn a_twin_of_the_same_names_is_compared_image_by_image() {
    let dir = tempfile::tempdir().unwrap();
    for at in 0..8 {
        let shade = u8::try_from(at * 22).unwrap();
        put(&dir.path().join(format!("a/{at}.png")), shade, at);
        put(&dir.path().join(format!("b/{at}.png")), shade + 3, at);
        put(&dir.path().join(format!("c/x{at}.png")), shade + 3, at);
    }
    let args = |second: &'static str| ["a=folder:a", second, "--json", "--permutations", "199"];
    let p = |output: &Output| {
        let w1 = &json(output)["pairs"][0]["features"][0]["measures"]["w1"]["p_value"];
        w1.as_f64().unwrap()
    };
    let (paired, other) = (
        run(dir.path(), &args("b=folder:b")),
        run(dir.path(), &args("c=folder:c")),
    );
    assert_eq!(json(&paired)["pairs"][0]["is_paired"], true, "by name");
    assert!(
        p(&paired) < 0.05,
        "three codes lighter, each: {}",
        p(&paired)
    );
    assert!(
        p(&other) > 0.5,
        "hidden by what the images differ by: {}",
        p(&other)
    );
}

#[test]
fn the_papers_experiment_names_what_is_missing() {
    let dir = tempfile::tempdir().unwrap();
    three_sets_of(dir.path(), 12);
    let args = [
        "--experiment",
        "paper",
        "--simulated",
        "a",
        "--real-overlays",
        "b",
        "--kitti",
        "a",
        "--cats",
        "far",
        "--json",
        "--bootstrap",
        "50",
        "--permutations",
        "0",
        "--splits",
        "5",
    ];
    let output = run(dir.path(), &args);
    assert!(output.status.success(), "{}", said(&output));
    let experiment = json(&output);
    let ordering = &experiment["orderings"][0];
    assert_eq!(
        ordering["features"][0]["probability"], 1.0,
        "light is lighter: {ordering}"
    );
    assert!(
        experiment["missing"].to_string().contains("--road-broken"),
        "what is missing"
    );
    assert_eq!(
        experiment["comparisons"][1]["published"], 0.36,
        "of the text"
    );
    let output = run(dir.path(), &["--experiment", "paper"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
}

#[test]
fn given_histograms_and_vectors_are_measured_as_they_are() {
    let dir = tempfile::tempdir().unwrap();
    let pairs = r#"[{"p": [1, 0], "q": [0, 1], "alpha": 0}, {"p": [3, 3], "q": [1, 3]}, {"p": [0], "q": [1]}]"#;
    fs::write(dir.path().join("list.json"), pairs).unwrap();
    fs::write(
        dir.path().join("named.json"),
        format!("{{\"hist\": {pairs}}}"),
    )
    .unwrap();
    let of = |file: &str| run(dir.path(), &["--histograms", file, "--json"]);
    let output = of("list.json");
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert_eq!(output.stdout, of("named.json").stdout, "under hist, too");
    let answers = &json(&output)["hist"];
    assert_eq!(answers[0]["kl_pq"], "inf", "{answers}");
    assert_eq!(answers[1]["alpha"], 0.5, "unless given: {answers}");
    let error = answers[2]["error"].as_str().unwrap();
    assert!(error.contains("p is empty"), "{error}");
    fs::write(dir.path().join("other.json"), r#"{"gauss": []}"#).unwrap();
    let output = of("other.json");
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));

    for (name, step) in [("a.npy", 1.0), ("b.npy", 2.0)] {
        let values: Vec<f64> = (0..6).map(|at| f64::from(at * at) * step).collect();
        let array = starbreak_dataset::encode_array_f64(&[3, 2], &values).unwrap();
        fs::write(dir.path().join(name), array).unwrap();
    }
    let output = run(dir.path(), &["--features", "a.npy", "b.npy", "--json"]);
    assert!(output.status.success(), "{}", said(&output));
    let compared = &json(&output)["activations"];
    assert_eq!(compared["n_dimensions"], 2, "{compared}");
    assert!(compared["frechet"].as_f64().unwrap() > 1.0, "{compared}");
}

#[test]
fn a_bank_counts_with_its_patterns_and_a_few_pictures_not_at_all() {
    let dir = tempfile::tempdir().unwrap();
    three_sets_of(dir.path(), 12);
    let patterns = [
        "patterns",
        "-n",
        "12",
        "-o",
        "bank",
        "--size",
        "120x80",
        "--preset",
        "paper",
        "--set",
        "fracture.particles=300",
        "--set",
        "fracture.neighbour_radius_px=20",
    ];
    crate::program::succeed(dir.path(), &patterns);
    let cheap = [&["--json"][..], &NO_DRAWS].concat();
    let args = [
        "--experiment",
        "paper",
        "--simulated",
        "bank",
        "--real-overlays",
        "b",
    ];
    let output = run(dir.path(), &[&args[..], &cheap].concat());
    assert!(output.status.success(), "{}", said(&output));
    let set = &json(&output)["report"]["sets"][0];
    assert_eq!(set["n"], 12, "its patterns, and no chart: {set}");
    assert_eq!(
        set["size_range_px"],
        serde_json::json!([[120, 80], [120, 80]]),
        "{set}"
    );

    fs::create_dir(dir.path().join("few")).unwrap();
    fs::copy(
        dir.path().join("bank/statistics.png"),
        dir.path().join("few/chart.png"),
    )
    .unwrap();
    let args = [
        "--experiment",
        "paper",
        "--simulated",
        "few",
        "--real-overlays",
        "few",
    ];
    let output = run(dir.path(), &[&args[..], &cheap].concat());
    let said = said(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    for word in ["--simulated", "--real-overlays", "1 images", "10 or more"] {
        assert!(said.contains(word), "{word}: {said}");
    }
}

#[test]
fn a_layer_that_the_model_lacks_is_refused_before_any_image_is_read() {
    let model = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/onnx/FastestDet.onnx"
    );
    if !Path::new(model).is_file() {
        skipped(&format!("{model} is not at hand"));
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    three_sets(dir.path());
    let layers = ["--model", model, "--layer", "no such layer"];
    let output = run(
        dir.path(),
        &[&["folder:a", "folder:b"], &layers[..]].concat(),
    );
    let said = said(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    for words in [
        "FastestDet.onnx\" has no layer \"no such layer\"",
        "leave the layer out, or name one of its",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}
