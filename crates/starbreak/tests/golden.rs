//! Digests of our own output: they guard against change and prove nothing else.
//!
//! A change that is meant is written with `UPDATE_GOLDEN=1 cargo test -p starbreak --test golden`
//! and entered in CHANGELOG.md under "Numbers changed".
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fmt::Write as _;
use std::path::Path;

use image::{DynamicImage, Rgb, RgbImage};
use starbreak::{Chain, Recipe, Seed};
use starbreak_dataset::sha256_hex;

const CASES: [(&str, &[&str]); 7] = [
    ("paper-far", &[]),
    (
        "paper-far-together",
        &["optics.far_focus_blur=crack-and-scene"],
    ),
    ("paper-short", &["camera.focus_distance_m=short"]),
    ("caption", &["fracture.rule=caption"]),
    (
        "mesh-edges-branches",
        &["fracture.neighbourhood=mesh-edges", "fracture.branches=2"],
    ),
    (
        "snapped-two-sided",
        &["fracture.snap_to_mesh=true", "fracture.two_sided=true"],
    ),
    (
        "image-mean-sum",
        &[
            "optics.light_intensity=image-mean",
            "optics.normalization=sum",
            "optics.line_width_px=2.5",
        ],
    ),
];

fn scene() -> DynamicImage {
    DynamicImage::ImageRgb8(RgbImage::from_fn(320, 180, |x, y| {
        let level = |k: u32| u8::try_from((x * k + y * 3 + (x * y) % 23) % 256).unwrap();
        Rgb([level(1), level(2), level(5)])
    }))
}

#[test]
fn output_is_what_it_was() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/paper/digests.txt");
    let mut text = String::new();
    for (name, overrides) in CASES {
        let mut recipe = Recipe::preset("paper").unwrap();
        recipe.set("fracture.particles=1500").unwrap();
        for assignment in overrides {
            recipe.set(assignment).unwrap();
        }
        let mut image = scene();
        let size = (image.width(), image.height());
        let chain = Chain::of(&recipe.settings().unwrap(), size, Seed(11)).unwrap();
        chain.over(&mut image, Seed(11)).unwrap();
        assert!(!chain.is_intact(), "{name} shows a crack");
        let network = sha256_hex(chain.network().unwrap().to_json().as_bytes());
        writeln!(
            text,
            "{name} network {network} image {}",
            sha256_hex(image.as_bytes())
        )
        .unwrap();
    }
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        return;
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    assert_eq!(
        text, expected,
        "output changed; if that is meant, see the head of this file"
    );
}
