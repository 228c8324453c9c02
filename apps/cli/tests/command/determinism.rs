//! Same recipe and seed, same bytes: for any number of threads, order of inputs and run.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{
    folder, jpeg_bytes, json, photo, png_bytes, snapshot, succeed, succeed_small,
};
use serde_json::Value;
use starbreak_dataset::{blake3_hex, sha256_hex};

const IMAGES: [&str; 5] = ["a.png", "b.png", "c.jpg", "d.png", "e.jpg"];

/// Five different pictures.
fn write_images(dir: &Path) {
    for (k, name) in (0..).zip(IMAGES) {
        let pixels = photo((160 + 7 * k, 100 - 5 * k));
        let bytes = if name.ends_with("png") {
            png_bytes(&pixels)
        } else {
            jpeg_bytes(&pixels)
        };
        fs::write(dir.join(name), bytes).unwrap();
    }
}

/// All files of a folder; of JSON files what is left without the times.
fn without_times(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    snapshot(dir)
        .into_iter()
        .map(|(path, content)| {
            let mut content = content.unwrap();
            if path
                .extension()
                .is_some_and(|extension| extension == "json")
            {
                let mut record: Value = serde_json::from_slice(&content).unwrap();
                let times = record.as_object_mut().unwrap().remove("timings_ms");
                assert!(times.is_some_and(|t| t["total"].is_number()), "{path:?}");
                content = record.to_string().into_bytes();
            }
            (path, content)
        })
        .collect()
}

/// Cracks the five images with a random impact.
fn crack(dir: &Path, out: &str, more: &[&str]) -> BTreeMap<PathBuf, Vec<u8>> {
    let first = ["crack", "-o", out, "--set", "impact.position=random"];
    let small = &crate::program::SMALL[..6];
    let inputs: &[&str] = if more.iter().any(|arg| arg.ends_with("a.png")) {
        &[]
    } else {
        &IMAGES
    };
    succeed(dir, &[&first[..], small, inputs, more].concat());
    without_times(&dir.join(out))
}

#[test]
fn cracked_images_do_not_depend_on_threads_or_run() {
    let dir = folder();
    write_images(dir.path());
    let one = crack(dir.path(), "one", &["--threads", "1"]);
    assert_eq!(one.len(), 4 * IMAGES.len(), "files of five images");
    for (out, threads) in [("again", "1"), ("two", "2"), ("three", "3"), ("all", "0")] {
        let other = crack(dir.path(), out, &["--threads", threads]);
        assert!(one == other, "{threads} threads give other bytes than 1");
    }
}

#[test]
fn cracked_images_do_not_depend_on_the_order_or_company_of_inputs() {
    let dir = folder();
    write_images(dir.path());
    let forward = crack(dir.path(), "forward", &[]);
    let backward = crack(
        dir.path(),
        "backward",
        &["e.jpg", "d.png", "c.jpg", "b.png", "a.png"],
    );
    assert!(forward == backward, "the order of the inputs matters");
    let alone = crack(dir.path(), "alone", &["./a.png"]);
    assert_eq!(alone.len(), 4, "files of one image");
    for (path, content) in alone {
        assert!(forward[&path] == content, "{path:?} depends on its company");
    }
}

#[test]
fn another_seed_gives_another_crack() {
    let dir = folder();
    write_images(dir.path());
    let (zero, one) = (
        crack(dir.path(), "zero", &["--seed", "0"]),
        crack(dir.path(), "one", &["--seed", "1"]),
    );
    for (path, content) in &zero {
        assert!(*content != one[path], "{path:?} is the same for two seeds");
    }
    let unseeded = crack(dir.path(), "unseeded", &[]);
    assert!(zero == unseeded, "the seed is 0 by default");
}

#[test]
fn each_image_has_a_crack_of_its_own() {
    let dir = folder();
    for name in ["a.png", "b.png"] {
        crate::program::write_photo(&dir.path().join(name));
    }
    succeed(
        dir.path(),
        &[
            &["crack", "a.png", "b.png", "-o", "o"][..],
            &crate::program::SMALL[..6],
        ]
        .concat(),
    );
    let crack = |name: &str| fs::read(dir.path().join("o").join(name)).unwrap();
    assert!(
        crack("a.crack.png") != crack("b.crack.png"),
        "equal pictures of different names have one crack"
    );
}

#[test]
fn networks_do_not_depend_on_threads_or_run() {
    let dir = folder();
    let simulate = |out: &str, more: &[&str]| {
        let svg = format!("{out}.svg");
        let json = format!("{out}.json");
        let args = ["simulate", "-o", &json, "--svg", &svg, "--preset", "paper"];
        succeed(dir.path(), &[&args[..], more].concat());
        [json, svg].map(|name| fs::read(dir.path().join(name)).unwrap())
    };
    let one = simulate("one", &["--threads", "1", "--seed", "5"]);
    for (out, threads) in [("again", "1"), ("two", "2"), ("all", "0")] {
        let other = simulate(out, &["--threads", threads, "--seed", "5"]);
        assert!(one == other, "{threads} threads give other bytes than 1");
    }
    let other = simulate("other", &["--threads", "1", "--seed", "6"]);
    assert!(one[0] != other[0] && one[1] != other[1], "seeds 5 and 6");
    let stdout = succeed(
        dir.path(),
        &["simulate", "--seed", "5", "--preset", "paper"],
    )
    .stdout;
    assert!(stdout.as_bytes() == one[0], "standard output and -o differ");
}

#[test]
fn a_printed_recipe_gives_the_same_bytes() {
    let dir = folder();
    write_images(dir.path());
    let settings = [
        "--set",
        "fracture.particles=700",
        "--set",
        "fracture.neighbour_radius_px=33.3",
        "--set",
        "impact.force=512.125",
        "--set",
        "optics.sun_azimuth_deg=-17.1",
    ];
    let direct = crack(dir.path(), "direct", &settings);
    let printed = succeed(
        dir.path(),
        &[
            &["recipe", "--set", "impact.position=random"][..],
            &crate::program::SMALL[..6],
            &settings,
        ]
        .concat(),
    );
    fs::write(dir.path().join("printed.toml"), &printed.stdout).unwrap();
    let mut args = vec!["crack", "-o", "fed_back", "--recipe", "printed.toml"];
    args.extend(IMAGES);
    succeed(dir.path(), &args);
    let fed_back = without_times(&dir.path().join("fed_back"));
    assert!(direct == fed_back, "the printed recipe is another one");

    let again = succeed(dir.path(), &["recipe", "--recipe", "printed.toml"]);
    assert_eq!(again.stdout, printed.stdout, "a recipe of a recipe");
    let preset = succeed(dir.path(), &["recipe", "--preset", "windshield-spiderweb"]).stdout;
    assert_eq!(
        preset,
        succeed(dir.path(), &["recipe"]).stdout,
        "`windshield-spiderweb` is the default"
    );
}

#[test]
fn an_image_is_made_again_from_its_provenance() {
    let dir = folder();
    write_images(dir.path());
    let set = ["--set", "impact.force=450", "--seed", "77"];
    crack(dir.path(), "first", &set);
    for (name, stem) in [("b.png", "b"), ("c.jpg", "c")] {
        let record = json(&dir.path().join(format!("first/{stem}.json")));
        let input = fs::read(dir.path().join(name)).unwrap();
        assert_eq!(record["input"]["blake3"], blake3_hex(&input), "{name}");
        let recipe = record["recipe"].as_str().unwrap();
        assert_eq!(
            record["recipe_sha256"],
            sha256_hex(recipe.as_bytes()),
            "{name}"
        );

        // Nothing but the record and the image that it names.
        let elsewhere = folder();
        fs::write(elsewhere.path().join("r.toml"), recipe).unwrap();
        let input_name = record["input"]["name"].as_str().unwrap();
        fs::write(elsewhere.path().join(input_name), input).unwrap();
        let seed = record["seed"].to_string();
        let args = [
            "crack", input_name, "--recipe", "r.toml", "--seed", &seed, "-o", "o",
        ];
        succeed(elsewhere.path(), &args);
        let output = record["output"]["name"].as_str().unwrap();
        let made = fs::read(elsewhere.path().join("o").join(output)).unwrap();
        assert_eq!(record["output"]["blake3"], blake3_hex(&made), "{name}");
    }
}

#[test]
fn the_largest_seed_survives_the_provenance() {
    let dir = folder();
    crate::program::write_photo(&dir.path().join("a.png"));
    let seed = u64::MAX.to_string();
    succeed_small(dir.path(), &["crack", "a.png", "-o", "o", "--seed", &seed]);
    let record = json(&dir.path().join("o/a.json"));
    assert_eq!(record["seed"].to_string(), seed, "to the last digit");
}
