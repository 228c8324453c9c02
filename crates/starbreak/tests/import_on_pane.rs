//! A network that was drawn over a frame, seen through the physical optics.
#![expect(clippy::unwrap_used, reason = "a test that cannot read has failed")]

use image::{DynamicImage, Rgb, RgbImage};
use starbreak::import::{ImportedNetwork, parse_network};
use starbreak::{Chain, Recipe, Seed, Simulated, Stopwatch};

const DRAWING: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" width="621" height="375"><path d="M150 100L310 240M250 200H390" stroke="red"/></svg>"#;

#[test]
fn what_was_drawn_appears_where_it_was_drawn() {
    let mut recipe = Recipe::preset("windshield-star").unwrap();
    recipe.set("camera.focus_distance_m=short").unwrap();
    let settings = recipe.settings().unwrap();
    let imported = ImportedNetwork {
        network: parse_network(DRAWING).unwrap(),
        name: "drawing.svg".to_owned(),
        sha256: String::new(),
    };
    let mut image = DynamicImage::ImageRgb8(RgbImage::from_pixel(1242, 375, Rgb([90, 100, 110])));
    let simulated = Simulated::from(&imported);
    let mut watch = Stopwatch::start();
    let chain =
        Chain::of_simulated(&settings, simulated, (1242, 375), Seed(1), &mut watch).unwrap();
    chain.over(&mut image, Seed(1)).unwrap();
    let mask = chain.crack_mask().unwrap();
    // The drawing is stretched twofold across. A crack is seen between its trace on the face, and
    // that trace moved by the parallax in the glass, upward here.
    for (x, y) in [(400_u32, 150_u32), (560, 220), (640, 200), (740, 200)] {
        let near = (y.saturating_sub(14)..y + 3).any(|y| mask.get_pixel(x, y).0[0] > 60);
        assert!(near, "a crack near ({x}, {y})");
    }
    for (x, y, level) in mask.enumerate_pixels() {
        if level.0[0] > 0 {
            assert!(
                (280..800).contains(&x) && (70..260).contains(&y),
                "no crack at ({x}, {y})"
            );
        }
    }
}
