//! What is on the glass ends where a dashboard stands before it.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::sync::Arc;

use image::{DynamicImage, Rgb, RgbImage, Rgba, RgbaImage};
use starbreak::photo::{GlassPhoto, OverlayOptions};
use starbreak::{Chain, Recipe, Scene, Seed, Stopwatch, simulate};
use starbreak_optics::photo::{Photo, PhotoParams};

const SIZE: (u32, u32) = (320, 200);

/// From the left, in the middle and at the right, as a share of the height.
const ROWS: &str = "optics.dashboard_rows=[0.7, 0.8, 0.6]";

fn row_px(column: u32) -> f64 {
    let part = (f64::from(column) + 0.5) / f64::from(SIZE.0) * 2.0;
    let share = match part < 1.0 {
        true => 0.7 + 0.1 * part,
        false => 0.8 - 0.2 * (part - 1.0),
    };
    share * f64::from(SIZE.1)
}

fn scene() -> RgbImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let code = |part: u32| u8::try_from(50 + part % 150).unwrap();
        Rgb([code(x * 7 + y * 3), code(y * 5), code(x * 2 + y * 11)])
    })
}

/// A preset under a light that is given.
fn recipe(preset: &str, more: &[&str]) -> Recipe {
    let mut recipe = Recipe::preset(preset).unwrap();
    for key in ["sky_horizon", "sky_zenith", "ground"] {
        recipe.set(&format!("optics.{key}=[0.4,0.4,0.4]")).unwrap();
    }
    recipe.set("optics.sun_irradiance=1").unwrap();
    for set in more {
        recipe.set(set).unwrap();
    }
    recipe
}

/// The picture, its region and its crack mask.
fn shown(recipe: &Recipe) -> [RgbImage; 3] {
    let chain = Chain::of(&recipe.settings().unwrap(), SIZE, Seed(3)).unwrap();
    let mut image = DynamicImage::ImageRgb8(scene());
    let mut watch = Stopwatch::start();
    let shown = chain
        .over_and_report(&mut image, Seed(3), &[], &mut watch)
        .unwrap();
    let masks = [shown.region, chain.crack_mask().unwrap()];
    let [region, crack] = masks.map(|mask| DynamicImage::ImageLuma8(mask).to_rgb8());
    [image.to_rgb8(), region, crack]
}

/// How many pixels differ whose middle is so far above (below 0) and below (above 0) the dashboard's row, px.
fn differ(a: &RgbImage, b: &RgbImage, is_asked: impl Fn(f64) -> bool) -> usize {
    let pixels = a.enumerate_pixels().zip(b.pixels());
    let asked = pixels.filter(|((x, y, _), _)| is_asked(f64::from(*y) + 0.5 - row_px(*x)));
    asked.filter(|((_, _, a), b)| a != b).count()
}

#[test]
fn what_is_on_the_glass_ends_at_the_dashboard() {
    let black = RgbImage::new(SIZE.0, SIZE.1);
    for preset in [
        "windshield-spiderweb",
        "tempered-cover",
        "rain",
        "muddy",
        "dusty",
        "greasy",
        "frosted",
        "scratched",
        "fogged",
    ] {
        let at = ["impact.0.position=[0.5,0.6]", "fracture.until_reach_mm=300"];
        let is_broken = ["windshield-spiderweb", "tempered-cover"].contains(&preset);
        let is_glass = is_broken || preset == "rain";
        let at: &[&str] = if is_broken { &at } else { &[] };
        let [whole, whole_region, whole_crack] = shown(&recipe(preset, at));
        let [image, region, crack] = shown(&recipe(preset, &[at, &[ROWS]].concat()));
        // The cells of a coat are some px wide.
        let fade_px = if is_glass { 1.0 } else { 6.0 };
        let below = |away: f64| away > fade_px;
        let above = |away: f64| away < -fade_px;
        let all = differ(&scene(), &whole, below);
        assert!(all > 0, "{preset} reaches below the row");
        assert_eq!(
            differ(&scene(), &image, below),
            0,
            "{preset}: on the dashboard"
        );
        assert_eq!(differ(&black, &region, below), 0, "{preset}: its region");
        assert_eq!(differ(&black, &crack, below), 0, "{preset}: its cracks");
        assert_eq!(
            differ(&whole_crack, &crack, above),
            0,
            "{preset}: cracks above"
        );
        assert!(differ(&scene(), &image, above) > 0, "{preset} is above");
        // Drops and cracks no longer show what is below.
        if !is_glass {
            assert_eq!(differ(&whole, &image, above), 0, "{preset} above");
            assert_eq!(
                differ(&whole_region, &region, above),
                0,
                "{preset}: region above"
            );
        }
    }
}

#[test]
fn random_stones_hit_the_glass_above_the_dashboard() {
    let stones = |rows: &str| {
        let recipe = recipe(
            "windshield-gravel",
            &["impact.0.position=\"anywhere\"", rows],
        );
        let settings = recipe.settings().unwrap();
        let network = simulate(&settings, SIZE, Seed(2)).unwrap().network;
        let view = Scene::of(&settings, SIZE).of_network(&network).unwrap();
        let hits = network.data().impacts.iter();
        let seen: Vec<[f64; 2]> = hits
            .map(|hit| view.project([hit.x, hit.y]).unwrap())
            .collect();
        seen
    };
    let anywhere = stones("optics.dashboard_rows=[]");
    assert!(anywhere.iter().any(|[_, y]| *y > 100.0), "{anywhere:?}");
    let above = stones("optics.dashboard_rows=[0.5]");
    assert_eq!(above.len(), anywhere.len());
    for seen in above {
        assert!(seen[1] < 100.0, "{seen:?} is hidden");
    }
}

#[test]
fn a_photograph_of_broken_glass_ends_at_the_dashboard() {
    let white = DynamicImage::ImageRgba8(RgbaImage::from_pixel(60, 40, Rgba([255, 255, 255, 180])));
    let photo = Photo::new(white, &PhotoParams::default()).unwrap();
    let glass = Arc::new(GlassPhoto {
        photo,
        name: "white.png".to_owned(),
        blake3: String::new(),
    });
    let settings = recipe("windshield-star", &[ROWS]).settings().unwrap();
    let placed = glass.place(SIZE, &OverlayOptions::default(), Seed(1));
    let mut watch = Stopwatch::start();
    let chain = Chain::of_photo(&settings, placed.unwrap(), SIZE, &mut watch).unwrap();
    let mut image = DynamicImage::ImageRgb8(scene());
    chain.over(&mut image, Seed(1)).unwrap();
    let (image, crack) = (image.to_rgb8(), chain.crack_mask().unwrap());
    let crack = DynamicImage::ImageLuma8(crack).to_rgb8();
    let below = |away: f64| away > 1.0;
    assert_eq!(differ(&scene(), &image, below), 0, "on the dashboard");
    let black = RgbImage::new(SIZE.0, SIZE.1);
    assert_eq!(differ(&black, &crack, below), 0, "its mask");
    let above = differ(&scene(), &image, |away| away < -1.0);
    assert!(above > 40_000, "{above} pixels above");
}
