//! Pictures of every preset, pixel by pixel, focused on the scene and on the glass: they guard against
//! change and prove nothing else.
//!
//! Where pixels differ, the picture as it was, as it is, and eight times the difference lie side by
//! side in a file that the failure names. A change that is meant is looked at there, written with
//! `UPDATE_GOLDEN=1 cargo test -p starbreak --test golden_pictures`, and entered in CHANGELOG.md under
//! "Numbers changed".
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;

use image::{DynamicImage, GenericImage as _, Rgb, RgbImage};
use starbreak::{Chain, PRESETS, Recipe, Seed, presets};
use starbreak_dataset::{Encoding, ImageLimits, decode_image, encode_image};

const SIZE: (u32, u32) = (128, 80);

/// A road under a sky, with a row of houses: enough to be mirrored, little to store.
fn scene() -> RgbImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| match y {
        0..30 => {
            let down = u8::try_from(y).unwrap();
            Rgb([150 + 2 * down, 185 + down, 235])
        }
        30..48 if x % 32 < 26 => Rgb([[150, 96, 70], [196, 180, 150]][(x / 32 % 2) as usize]),
        30..48 => Rgb([60, 110, 50]),
        _ if x.abs_diff(64) < (y - 46) / 8 => Rgb([235, 235, 230]),
        _ => Rgb([95, 95, 100]),
    })
}

fn picture(preset: &str, focus: &str) -> RgbImage {
    if !PRESETS.iter().any(|(glass, _)| *glass == preset) {
        // Of few pixels some have to be defective, and of few rows some missing.
        let mut recipe =
            Recipe::preset_at(preset, if preset == "bit-errors" { 5 } else { 4 }).unwrap();
        if preset == "spots" {
            // As wide in this frame as in one of a camera.
            recipe.set("spots.pitch_um=25").unwrap();
        }
        let settings: &[&str] = match (preset, focus) {
            // In a blur of 1 to 3 px, in which most drops are small.
            ("rain", "far") => &["camera.f_px=600"],
            // Glass at hand, in focus.
            ("rain" | "muddy" | "frosted", _) => {
                &["camera.f_px=300", "camera.focus_distance_m=0.15"]
            }
            _ => &[],
        };
        for setting in settings {
            recipe.set(setting).unwrap();
        }
        if preset == "blank-frames" {
            for setting in ["frames.frozen=0", "frames.black=0", "frames.white=1"] {
                recipe.set(setting).unwrap();
            }
        }
        if ["ghosts", "star-burst"].contains(&preset) {
            // A lamp.
            let mut lit = scene();
            for (x, y) in (40..42).flat_map(|x| (60..62).map(move |y| (x, y))) {
                lit.put_pixel(x, y, Rgb([255, 255, 250]));
            }
            return behind(&recipe, lit);
        }
        return through(&recipe);
    }
    let mut recipe = Recipe::preset(preset).unwrap();
    // A small frame behind glass at hand sees the hit and what runs from it.
    for setting in ["impact.position=[0.5, 0.5]", "camera.f_px=220"] {
        recipe.set(setting).unwrap();
    }
    if preset != "paper" {
        recipe.set("fracture.mesh=fast").unwrap();
        let setting = format!("camera.focus_distance_m={focus}");
        recipe.set(&setting).unwrap();
    }
    through(&recipe)
}

fn through(recipe: &Recipe) -> RgbImage {
    behind(recipe, scene())
}

fn behind(recipe: &Recipe, scene: RgbImage) -> RgbImage {
    let settings = recipe.settings().unwrap();
    let mut image = DynamicImage::ImageRgb8(scene);
    let chain = Chain::of(&settings, SIZE, Seed(11)).unwrap();
    chain.over(&mut image, Seed(11)).unwrap();
    image.to_rgb8()
}

fn save(path: &Path, image: RgbImage) {
    let image = DynamicImage::ImageRgb8(image);
    let bytes = encode_image(&image, &Encoding::Png, None).unwrap();
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, bytes).unwrap();
}

/// As it was, as it is, and eight times the difference about gray.
fn triptych(was: &RgbImage, is: &RgbImage) -> RgbImage {
    let difference = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let (was, is) = (was.get_pixel(x, y).0, is.get_pixel(x, y).0);
        Rgb(std::array::from_fn(|k| {
            let by = 8 * (i32::from(is[k]) - i32::from(was[k]));
            (128 + by).clamp(0, 255) as u8
        }))
    });
    let mut all = RgbImage::new(3 * SIZE.0, SIZE.1);
    for (part, at) in [was, is, &difference].into_iter().zip([0, 1, 2]) {
        all.copy_from(part, at * SIZE.0, 0).unwrap();
    }
    all
}

#[test]
fn pictures_are_what_they_were() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/pictures");
    let mut changed = Vec::new();
    for (preset, _) in presets() {
        for (focus, in_focus) in [("far", "scene"), ("0.15", "glass")] {
            let is_glass = PRESETS.iter().any(|(glass, _)| *glass == preset) && preset != "paper";
            if in_focus == "glass" && !is_glass && preset != "rain" {
                continue;
            }
            let name = format!("{preset}-{in_focus}.png");
            let (path, is) = (golden.join(&name), picture(preset, focus));
            if std::env::var_os("UPDATE_GOLDEN").is_some() {
                save(&path, is);
                continue;
            }
            let bytes = std::fs::read(&path).unwrap();
            let was = decode_image(&name, &bytes, &ImageLimits::default()).unwrap();
            let was = was.pixels.to_rgb8();
            if was != is {
                let shown = Path::new(env!("CARGO_TARGET_TMPDIR")).join(&name);
                save(&shown, triptych(&was, &is));
                let n = was.pixels().zip(is.pixels()).filter(|(was, is)| was != is);
                changed.push(format!("{name}: {} pixels, {}", n.count(), shown.display()));
            }
        }
    }
    assert!(
        changed.is_empty(),
        "pixels changed; if that is meant, see the head of this file:\n{}",
        changed.join("\n")
    );
}

#[test]
fn every_picture_shows_damage() {
    for (preset, _) in presets() {
        let n = picture(preset, "far")
            .pixels()
            .zip(scene().pixels())
            .filter(|(is, was)| is != was)
            .count();
        assert!(n > 100, "{preset}: {n} pixels changed");
    }
}
