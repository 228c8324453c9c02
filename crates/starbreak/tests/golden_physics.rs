//! Figures and digests of our own physics: they guard against change and prove nothing else. They are
//! the same on every processor; `cargo xtask test` runs this file on emulated ones, too
//! (docs/decisions/0013).
//!
//! A change that is meant is written with `UPDATE_GOLDEN=1 cargo test -p starbreak --test
//! golden_physics` and entered in CHANGELOG.md under "Numbers changed".
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fmt::Write as _;
use std::path::Path;

use image::{DynamicImage, GenericImageView as _};
use starbreak::{Chain, Details, Recipe, Seed};
use starbreak_dataset::{sha256_hex, street_scene};

const PRESETS: [&str; 7] = [
    "windshield-spiderweb",
    "windshield-star",
    "windshield-bullseye",
    "windshield-combination",
    "windshield-long-crack",
    "tempered-cover",
    "lens-cover-star",
];

fn recipe(preset: &str) -> Recipe {
    let mut recipe = Recipe::preset(preset).unwrap();
    recipe.set("fracture.mesh=fast").unwrap();
    recipe.set("impact.position=[0.5, 0.5]").unwrap();
    recipe
}

/// A part of the street, small enough for a processor that is emulated.
fn street() -> DynamicImage {
    DynamicImage::ImageRgb8(street_scene().image.view(480, 120, 320, 180).to_image())
}

#[test]
fn figures_are_what_they_were() {
    let mut text = String::new();
    for preset in PRESETS {
        let settings = recipe(preset).settings().unwrap();
        let mut image = street();
        let chain = Chain::of(&settings, (image.width(), image.height()), Seed(11)).unwrap();
        chain.over(&mut image, Seed(11)).unwrap();
        let network = chain.network().unwrap();
        network.check_invariants().unwrap();
        let Some(Details::Physics(physics)) = chain.details() else {
            panic!("{preset} is physics");
        };
        let hit = &physics.impacts[0];
        let summary = network.summary();
        writeln!(
            text,
            "{preset} {} arms {} legs {} fragments {} force_n {:.6e} reach_mm {:.6e} length_mm {:.6e} \
             network {} image {}",
            hit.damage.name(),
            hit.n_arms,
            hit.n_legs,
            summary.n_fragments.unwrap_or(1),
            hit.peak_force_n,
            hit.reach_m * 1e3,
            summary.total_length,
            sha256_hex(network.to_json().as_bytes()),
            sha256_hex(image.as_bytes()),
        )
        .unwrap();
    }
    compare("figures.txt", &text);
}

fn compare(name: &str, text: &str) {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/physics");
    let path = golden.join(name);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::create_dir_all(&golden).unwrap();
        std::fs::write(&path, text).unwrap();
        return;
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    assert_eq!(
        text, expected,
        "output changed; if that is meant, see the head of this file"
    );
}
