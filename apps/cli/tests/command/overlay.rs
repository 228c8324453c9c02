//! `--overlay PHOTO` and `--overlays DIR`: photographs of broken glass in the place of cracks.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::program::{
    all_refused, folder, jpeg_bytes, json, names, photo, png_bytes, raw_png, snapshot, succeed,
    write_photo,
};
use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgba, RgbaImage};
use serde_json::Value;
use starbreak::optics::photo::{PhotoParams, Placement};
use starbreak::photo::{OverlayOptions, PlacedPhoto};
use starbreak::{Chain, Recipe, Seed, Stopwatch};
use starbreak_dataset::{ImageLimits, blake3_hex, read_image};
use starbreak_runs::overlay::read_photo;

/// White rays on black.
fn star(width: u32, height: u32) -> DynamicImage {
    GrayImage::from_fn(width, height, |x, y| {
        let (u, v) = (
            f64::from(x) - f64::from(width) * 0.5,
            f64::from(y) - f64::from(height) * 0.5,
        );
        let is_ray = (v.atan2(u) * 5.0).sin().abs() > 0.9;
        let inside = u.abs() < f64::from(width) * 0.45 && v.abs() < f64::from(height) * 0.45;
        Luma([if is_ray && inside { 230 } else { 2 }])
    })
    .into()
}

fn write_star(path: &Path) {
    fs::write(path, png_bytes(&star(300, 220))).unwrap();
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn a_photo_of_glass_comes_with_masks_and_a_record() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    write_star(&dir.path().join("star.png"));
    for preset in ["windshield-star", "paper"] {
        let args = ["crack", "a.png", "-o", preset, "--preset", preset];
        let outcome = succeed(
            dir.path(),
            &[&args[..], &["--overlay", "star.png"]].concat(),
        );
        assert!(
            outcome.stdout.contains("star.png before black"),
            "{preset}: {outcome:?}"
        );
        let out = dir.path().join(preset);
        assert_eq!(
            names(&out),
            ["a.crack.png", "a.json", "a.png", "a.region.png"],
            "{preset}"
        );
        let record = json(&out.join("a.json"));
        let overlay = &record["overlay"];
        assert_eq!(overlay["name"], "star.png", "{preset}");
        assert_eq!(
            overlay["blake3"],
            blake3_hex(&fs::read(dir.path().join("star.png")).unwrap()),
            "{preset}"
        );
        assert_eq!(overlay["background"], "black", "{preset}");
        assert!(record["network"].is_null(), "{preset}: there is no network");
        // 160 × 100 px of 300 × 220: the whole height would be too much.
        let place = &overlay["placement"];
        assert_eq!(place["width_px"], 300.0, "{preset}");
        assert_eq!(place["height_px"], 187.5, "{preset}");
        assert_eq!(place["top_px"], 16.25, "{preset}");

        let (before, after) = (
            raw_png(&dir.path().join("a.png")),
            raw_png(&out.join("a.png")),
        );
        let (region, crack) = (
            raw_png(&out.join("a.region.png")),
            raw_png(&out.join("a.crack.png")),
        );
        let covered = crack.data.iter().filter(|code| **code > 150).count();
        assert!(covered > 2000, "{preset}: {covered} px of glass");
        let mut n_changed = 0;
        for (k, (a, b)) in before.pixels().zip(after.pixels()).enumerate() {
            if a != b {
                n_changed += 1;
            } else {
                continue;
            }
            assert!(
                region.data[k] == 255 || preset != "paper",
                "{preset}: px {k} changes outside of the region"
            );
        }
        assert!(n_changed > 3000, "{preset}: {n_changed} px changed");
    }
}

#[test]
fn an_image_is_made_again_from_its_record() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    write_star(&dir.path().join("star.png"));
    let args = ["crack", "a.png", "-o", "o", "--overlay", "star.png"];
    let random = ["--overlay-random", "--overlay-gain", "1.5", "--seed", "11"];
    succeed(dir.path(), &[&args[..], &random].concat());
    let record = json(&dir.path().join("o/a.json"));
    let of = &record["overlay"];
    let place = &of["placement"];
    let flag = |key: &str| place[key].as_bool().unwrap();

    let params = PhotoParams {
        floor: number(&of["floor"]),
        ..PhotoParams::default()
    };
    let placed = PlacedPhoto {
        glass: Arc::new(read_photo(&dir.path().join("star.png"), &params).unwrap()),
        placement: Placement {
            left_px: number(&place["left_px"]),
            top_px: number(&place["top_px"]),
            width_px: number(&place["width_px"]),
            height_px: number(&place["height_px"]),
            flip_horizontal: flag("flip_horizontal"),
            flip_vertical: flag("flip_vertical"),
        },
        options: OverlayOptions {
            gain: number(&of["gain"]),
            ..OverlayOptions::default()
        },
    };
    let recipe = Recipe::parse("record", record["recipe"].as_str().unwrap()).unwrap();
    let settings = recipe.settings().unwrap();
    let read = |name: &str| {
        read_image(&dir.path().join(name), &ImageLimits::default())
            .unwrap()
            .pixels
    };
    let mut image = read("a.png");
    let mut watch = Stopwatch::start();
    let chain = Chain::of_photo(&settings, placed, (160, 100), &mut watch).unwrap();
    let seed = Seed(record["item"]["seed"].as_u64().unwrap());
    chain.over(&mut image, seed).unwrap();
    assert!(image == read("o/a.png"), "the same pixels");
}

#[test]
fn random_parts_differ_from_image_to_image_and_repeat_by_the_seed() {
    let dir = folder();
    for name in ["a.png", "b.png", "c.png"] {
        write_photo(&dir.path().join(name));
    }
    write_star(&dir.path().join("star.png"));
    let images = ["crack", "a.png", "b.png", "c.png", "--overlay", "star.png"];
    let run = |out: &str, more: &[&str]| {
        let args = [&images[..], &["-o", out, "--overlay-random"], more].concat();
        succeed(dir.path(), &args);
        ["a", "b", "c"].map(|name| {
            let record = json(&dir.path().join(out).join(format!("{name}.json")));
            let image = fs::read(dir.path().join(out).join(format!("{name}.png"))).unwrap();
            (record["overlay"]["placement"].clone(), image)
        })
    };
    let first = run("one", &["--threads", "1"]);
    assert_ne!(first[0], first[1], "each image has a part of its own");
    assert_ne!(first[1], first[2], "each image has a part of its own");
    assert_eq!(first, run("two", &["--threads", "2"]), "by the seed alone");
    assert_ne!(first, run("other", &["--seed", "1"]), "another seed");
    let whole = run(
        "whole",
        &["--overlay-min-scale", "1", "--overlay-max-shift", "0"],
    );
    for (placement, _) in whole {
        assert_eq!(placement["width_px"], 300.0, "the largest part");
        assert!(
            (0.0..=32.5).contains(&number(&placement["top_px"])),
            "within the photo: {placement}"
        );
    }
}

#[test]
fn cut_out_glass_leaves_all_else_as_it_is() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    let half: DynamicImage = RgbaImage::from_fn(320, 200, |x, _| {
        Rgba([240, 240, 240, if x < 100 { 180 } else { 0 }])
    })
    .into();
    fs::write(dir.path().join("half.png"), png_bytes(&half)).unwrap();
    let args = ["crack", "a.png", "-o", "o", "--overlay", "half.png"];
    succeed(
        dir.path(),
        &[&args[..], &["--set", "camera.f_number=8"]].concat(),
    );
    let (before, after) = (
        raw_png(&dir.path().join("a.png")),
        raw_png(&dir.path().join("o/a.png")),
    );
    for (k, (a, b)) in before.pixels().zip(after.pixels()).enumerate() {
        assert!(k % 160 < 70 || a == b, "px {k} is far from the glass");
    }
    let n_changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a != b);
    assert!(n_changed.count() > 4000, "the glass is seen");
}

#[test]
fn a_set_is_made_from_a_folder_of_photos_and_made_again() {
    let dir = folder();
    fs::create_dir_all(dir.path().join("photos/more")).unwrap();
    fs::create_dir(dir.path().join("scenes")).unwrap();
    write_star(&dir.path().join("photos/star.png"));
    let mut white = star(200, 200).to_luma8();
    image::imageops::invert(&mut white);
    fs::write(
        dir.path().join("photos/more/white.jpg"),
        jpeg_bytes(&white.into()),
    )
    .unwrap();
    for k in 0..6 {
        write_photo(&dir.path().join(format!("scenes/{k}.png")));
    }
    let overlays = ["--overlays", "photos", "--overlay-min-scale", "0.5"];
    let args = ["generate", "folder:scenes", "-o", "set", "--samples", "2"];
    succeed(dir.path(), &[&args[..], &overlays].concat());
    let mut used: Vec<String> = snapshot(&dir.path().join("set"))
        .into_values()
        .filter_map(|bytes| serde_json::from_slice::<Value>(&bytes?).ok())
        .filter_map(|record| Some(record["overlay"]["name"].as_str()?.to_owned()))
        .collect();
    assert_eq!(used.len(), 12, "a record of each sample");
    used.sort();
    used.dedup();
    assert_eq!(used, ["more/white.jpg", "star.png"], "both photos are used");

    let again = ["verify", "set", "--regenerate", "all", "--source"];
    let again = [&again[..], &["folder:scenes"], &overlays].concat();
    succeed(dir.path(), &again);
    // Another photo in the folder is another set.
    fs::write(dir.path().join("photos/new.png"), png_bytes(&star(90, 90))).unwrap();
    let outcome = crate::program::starbreak(dir.path(), &again);
    assert_ne!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn what_is_no_photo_of_glass_is_refused_in_one_line() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    write_photo(&at("a.png"));
    write_star(&at("star.png"));
    fs::write(at("crack.svg"), "<svg/>").unwrap();
    fs::write(at("text.png"), "no picture").unwrap();
    let gray: DynamicImage = GrayImage::from_pixel(40, 30, Luma([120])).into();
    fs::write(at("gray.png"), png_bytes(&gray)).unwrap();
    let clear: DynamicImage = RgbaImage::from_pixel(40, 30, Rgba([255, 255, 255, 0])).into();
    fs::write(at("clear.png"), png_bytes(&clear)).unwrap();
    let black16: DynamicImage = ImageBuffer::<Luma<u16>, _>::from_pixel(1, 1, Luma([0_u16])).into();
    fs::write(at("black.png"), png_bytes(&black16)).unwrap();
    fs::create_dir(at("none")).unwrap();
    let crack = |more: &[&'static str]| {
        [&["crack", "a.png", "-o", "o"][..], more]
            .concat()
            .into_iter()
            .collect::<Vec<_>>()
    };
    let generate =
        |more: &[&'static str]| [&["generate", "list:scenes.txt", "-o", "o"][..], more].concat();
    fs::write(at("scenes.txt"), "a.png\n").unwrap();
    all_refused(
        dir.path(),
        &[
            (crack(&["--overlay", "missing.png"]), "missing.png"),
            (crack(&["--overlay", "none"]), "none"),
            (crack(&["--overlay", "text.png"]), "text.png"),
            (crack(&["--overlay", "gray.png"]), "--overlay-background"),
            (
                crack(&["--overlay", "clear.png"]),
                "every pixel is transparent",
            ),
            (crack(&["--overlay", "black.png"]), "nothing is brighter"),
            (
                crack(&["--overlay", "star.png", "--network", "crack.svg"]),
                "--network",
            ),
            (crack(&["--overlay-random"]), "--overlay"),
            (crack(&["--overlay-gain", "2"]), "--overlay-gain"),
            (
                crack(&[
                    "--overlay",
                    "star.png",
                    "--overlay-gain",
                    "2",
                    "--preset",
                    "paper",
                ]),
                "--overlay-gain is for the physical optics",
            ),
            (
                crack(&["--overlay", "star.png", "--overlay-max-shift", "0.2"]),
                "--overlay-random",
            ),
            (
                crack(&["--overlay", "star.png", "--overlay-gain", "-1"]),
                "0 to 1000",
            ),
            (
                crack(&["--overlay", "star.png", "--overlay-floor", "0.6"]),
                "0 to 0.5",
            ),
            (
                crack(&[
                    "--overlay",
                    "star.png",
                    "--overlay-random",
                    "--overlay-min-scale",
                    "0",
                ]),
                "0.05 to 1",
            ),
            (
                crack(&["--overlay", "star.png", "--overlay-background", "grey"]),
                "grey",
            ),
            (generate(&["--overlays", "none"]), "no photographs"),
            (generate(&["--overlays", "missing"]), "missing"),
            (generate(&["--overlay-gain", "2"]), "--overlay-gain"),
        ],
    );
    // The grey one is taken where its background is named.
    let named = ["--overlay", "gray.png", "--overlay-background", "white"];
    succeed(dir.path(), &crack(&named));
    // Never over the photo of glass itself.
    let outcome = crate::program::starbreak(
        dir.path(),
        &["crack", "a.png", "-o", ".", "--overlay", "a.crack.png"],
    );
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    let large = photo((64, 64));
    fs::write(at("a.crack.png"), png_bytes(&large)).unwrap();
    let before = fs::read(at("a.crack.png")).unwrap();
    let outcome = crate::program::starbreak(
        dir.path(),
        &["crack", "a.png", "-o", ".", "--overlay", "a.crack.png"],
    );
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert_eq!(before, fs::read(at("a.crack.png")).unwrap(), "untouched");
}
