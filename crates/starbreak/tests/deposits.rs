//! What lies on the glass through the chain: what it changes, what is told of it, and what becomes of it.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::{DynamicImage, Rgb, RgbImage};
use starbreak::{Chain, Error, FAULTS, Recipe, SCENARIOS, Scene, Seed, Stopwatch, simulate};

fn over(recipe: &Recipe, image: &DynamicImage, seed: u64) -> DynamicImage {
    let mut image = image.clone();
    let size = (image.width(), image.height());
    let chain = Chain::of(&recipe.settings().unwrap(), size, Seed(seed)).unwrap();
    chain.over(&mut image, Seed(seed)).unwrap();
    image
}

/// Root of the mean square of a change, in codes.
fn change(a: &DynamicImage, b: &DynamicImage) -> f64 {
    let [a, b] = [a, b].map(|image| image.to_rgb8().into_raw());
    let squares = a
        .iter()
        .zip(&b)
        .map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

/// A scene of colors that change from row to row, with fine detail of no one period, neither black nor white anywhere.
fn colors() -> DynamicImage {
    RgbImage::from_fn(1600, 1200, |x, y| {
        let fine = (x * x * 7 + y * y * 13 + x * y * 3) % 40;
        let code = |part: u32| u8::try_from(60 + part + fine).unwrap();
        Rgb([code(y / 12), code(x / 40), code((x / 9 + y / 5) % 50)])
    })
    .into()
}

/// Share of an image that a record says is affected.
fn region_of(recipe: &Recipe, image: &DynamicImage) -> f64 {
    let size = (image.width(), image.height());
    let chain = Chain::of(&recipe.settings().unwrap(), size, Seed(5)).unwrap();
    let mut image = image.clone();
    let mut watch = Stopwatch::start();
    let shown = chain.over_and_report(&mut image, Seed(5), &[], &mut watch);
    shown.unwrap().region_fraction
}

#[test]
fn what_lies_on_the_pane_is_told_of_and_stays_with_the_seed() {
    let image: DynamicImage = RgbImage::from_pixel(320, 200, Rgb([128; 3])).into();
    let scene = colors().crop_imm(0, 0, 320, 200);
    for (preset, key) in [
        ("rain", "drops"),
        ("fogged", "condensation"),
        ("muddy", "mud"),
        ("dusty", "dust"),
        ("greasy", "film"),
        ("frosted", "frost"),
    ] {
        let mut recipe = Recipe::preset(preset).unwrap();
        // A part of the pane.
        recipe.set("camera.f_px=600").unwrap();
        let settings = recipe.settings().unwrap();
        let chain = Chain::of(&settings, (320, 200), Seed(1)).unwrap();
        let coverage = chain.facts()[key]["coverage"].as_f64().unwrap();
        assert!((0.02..0.6).contains(&coverage), "{preset}: {coverage}");
        assert!(!chain.is_intact(), "{preset} is damage");
        assert!(
            over(&recipe, &scene, 1) != over(&recipe, &scene, 2),
            "{preset} by the seed"
        );
    }
    // Cracks and rain go together, and with each alone there is less.
    let mut both = Recipe::preset("windshield-spiderweb").unwrap();
    both.set("drops.rain_mm_h=25").unwrap();
    let cracks = region_of(&Recipe::preset("windshield-spiderweb").unwrap(), &image);
    assert!(region_of(&both, &image) > cracks + 0.05);
    let mut endless = Recipe::preset("rain").unwrap();
    endless.set("drops.rain_mm_h=150").unwrap();
    for (period_s, age_s, said) in [
        (0, 600, "or let drops.wiper_period_s wipe a clip's pane"),
        (
            5,
            600,
            "lower drops.age_s (600 s, though the pane is wiped every 5 s), ",
        ),
        (600, 600, ", and for a clip drops.wiper_period_s"),
    ] {
        endless
            .set(&format!("drops.wiper_period_s={period_s}"))
            .unwrap();
        endless.set(&format!("drops.age_s={age_s}")).unwrap();
        let refused = Chain::of(&endless.settings().unwrap(), (320, 200), Seed(1)).unwrap_err();
        assert!(refused.to_string().contains(said), "{refused}");
    }
    // Frames of a clip go on where a picture by itself is refused, whether or not any were asked for before.
    let mut unwiped = Recipe::preset("rain").unwrap();
    unwiped.set("drops.wiper_period_s=0").unwrap();
    unwiped.set("drops.rain_mm_h=25").unwrap();
    let clip = Chain::of(&unwiped.settings().unwrap(), (32, 20), Seed(1)).unwrap();
    let after_s = (1..).map(|k| f64::from(k) * 20.0).find(|after_s| {
        unwiped
            .set(&format!("drops.age_s={}", 4.0 + after_s))
            .unwrap();
        Chain::of(&unwiped.settings().unwrap(), (32, 20), Seed(1)).is_err()
    });
    assert!(
        clip.later(after_s.unwrap(), Some(f64::INFINITY)).is_ok(),
        "{after_s:?}"
    );
    let papers = Recipe::preset("paper")
        .unwrap()
        .set("drops.rain_mm_h=5")
        .unwrap_err();
    assert!(papers.to_string().contains("optics.model"), "{papers}");
}

#[test]
fn what_lies_on_the_glass_lies_in_all_of_a_tall_frame() {
    for (size, leans_less) in [
        ((320, 240), false),
        ((310, 94), false),
        ((240, 240), true),
        ((180, 240), true),
        ((80, 240), true),
    ] {
        for preset in ["fogged", "frosted", "rain"] {
            let recipe = Recipe::preset_at(preset, 3).unwrap();
            let settings = recipe.settings().unwrap();
            let chain = Chain::of(&settings, size, Seed(2)).unwrap();
            let rake_deg = chain.facts().get("pane").map(|it| it["rake_deg"].as_f64());
            assert_eq!(rake_deg.is_some(), leans_less, "{preset}, {size:?}");
            if let Some(rake_deg) = rake_deg {
                assert!((0.0..50.0).contains(&rake_deg.unwrap()), "{rake_deg:?}");
            }
            let image = RgbImage::from_fn(size.0, size.1, |x, y| {
                Rgb([x, y, x + y].map(|it| 60 + u8::try_from(it * 37 % 120).unwrap()))
            });
            let shown = over(&recipe, &image.clone().into(), 2).to_rgb8();
            // As much of the lowest eighth is changed as of the middle.
            let changed = |from: u32, to: u32| {
                let all = (from..to).flat_map(|y| (0..size.0).map(move |x| (x, y)));
                all.filter(|(x, y)| image.get_pixel(*x, *y) != shown.get_pixel(*x, *y))
                    .count()
            };
            let (middle, lowest) = (
                changed(size.1 * 7 / 16, size.1 * 9 / 16),
                changed(size.1 * 7 / 8, size.1),
            );
            assert!(
                2 * lowest > middle && middle > 0,
                "{preset}, {size:?}: {lowest} pixels of the lowest rows, {middle} of those in the middle"
            );
        }
    }
}

#[test]
fn cracks_of_a_file_lie_on_the_pane_that_drops_lie_on() {
    let star = Recipe::preset("windshield-star").unwrap();
    let star = star.settings().unwrap();
    let network = simulate(&star, (180, 240), Seed(2)).unwrap().network;
    let shows_lowest_row = |rain_mm_h: &str| {
        let mut recipe = Recipe::preset("rain").unwrap();
        recipe.set(&format!("drops.rain_mm_h={rain_mm_h}")).unwrap();
        let settings = recipe.settings().unwrap();
        let view = Scene::of(&settings, (180, 240)).of_network(&network);
        view.unwrap().unproject([90.0, 239.5]).is_some()
    };
    assert!(shows_lowest_row("7.6"), "it leans less");
    assert!(
        !shows_lowest_row("0"),
        "nothing lies on it: as the recipe has it"
    );
}

#[test]
fn a_scenario_has_all_its_faults_and_each_severity_is_worse() {
    for scenario in SCENARIOS {
        let mut last = 0.0;
        for severity in 1..=5 {
            let mut recipe = Recipe::preset_at(scenario.preset.0, severity).unwrap();
            // A part of the pane.
            recipe.set("camera.f_px=600").unwrap();
            let settings = recipe.settings().unwrap();
            let mut image = colors().crop_imm(200, 100, 480, 320);
            let before = image.clone();
            let chain = Chain::of(&settings, (480, 320), Seed(4)).unwrap();
            chain.over(&mut image, Seed(4)).unwrap();
            let differs = change(&image, &before);
            assert!(
                differs > last,
                "{}: {differs} after {last}",
                scenario.preset.0
            );
            last = differs;
            let n_coats = settings.coats.len() + usize::from(settings.drops.is_some());
            let n_lens = settings
                .faults
                .as_ref()
                .map_or(0, |it| it.lens.faults().len());
            assert!(n_coats + n_lens >= 2, "{}", scenario.preset.0);
        }
    }
}

/// A fault of a scenario alone has the values of the scenario at each severity, and no other fault; all of them are the
/// scenario.
#[test]
fn a_scenario_comes_apart_into_its_faults() {
    let tables = |name: &str, severity: u8| {
        let recipe = Recipe::preset_at(name, severity).unwrap();
        let json = recipe.to_json();
        let tables = json.as_object().unwrap().clone();
        let faults = FAULTS.iter().map(|fault| fault.table);
        let there = faults.filter(|table| tables.contains_key(*table));
        let there: Vec<_> = there.map(|table| (table, tables[table].clone())).collect();
        (there, tables.get("lens").cloned())
    };
    for scenario in SCENARIOS {
        for severity in [1, 3, 5] {
            let (whole, lens) = tables(scenario.preset.0, severity);
            let mut apart = Vec::new();
            for name in scenario.alone() {
                let (alone, its_lens) = tables(&name, severity);
                assert_eq!(alone.len(), 1, "{name}: {alone:?}");
                assert_eq!(its_lens, lens, "{name} is in the same light");
                apart.extend(alone);
            }
            let by_table = |(table, _): &(&str, _)| (*table).to_owned();
            apart.sort_by_key(by_table);
            let mut whole = whole;
            whole.sort_by_key(by_table);
            assert_eq!(apart, whole, "{} {severity}", scenario.preset.0);
        }
    }
    let refused = Recipe::preset("rainy-drive.mud").unwrap_err().to_string();
    assert!(refused.contains("has rainy-drive.drops, "), "{refused}");
    let refused = Recipe::preset("windshield-star.drops")
        .unwrap_err()
        .to_string();
    assert!(refused.contains("windshield-star.drops"), "{refused}");
}

#[test]
fn classes_tell_how_much_light_comes_through() {
    let image: DynamicImage = RgbImage::from_pixel(320, 200, Rgb([128; 3])).into();
    let classes = |preset: &str, more: &[&str]| -> [usize; 4] {
        let mut recipe = Recipe::preset(preset).unwrap();
        recipe.set("output.classes=true").unwrap();
        for set in more {
            recipe.set(set).unwrap();
        }
        let chain = Chain::of(&recipe.settings().unwrap(), (320, 200), Seed(2)).unwrap();
        let mut watch = Stopwatch::start();
        let shown = chain
            .over_and_report(&mut image.clone(), Seed(2), &[], &mut watch)
            .unwrap();
        [0, 85, 170, 255].map(|code| shown.region.iter().filter(|it| **it == code).count())
    };
    let [clean, transparent, semi, opaque] = classes("muddy", &[]);
    assert_eq!(clean + transparent + semi + opaque, 320 * 200);
    assert!(opaque > 1000, "thick mud is opaque: {opaque}");
    assert!(clean > 40_000, "most of the glass is clean: {clean}");
    let [_, _, semi_thin, opaque_thin] = classes("muddy", &["mud.thickness_um=20"]);
    assert!(opaque_thin < opaque / 5, "{opaque_thin} of {opaque}");
    assert!(
        semi_thin > semi,
        "a thin film of it is not: {semi_thin} and {semi}"
    );
    // Drops and dew pass nearly all light.
    let [clean, transparent, _, opaque] = classes("rain", &[]);
    assert!(
        transparent > 20 * opaque.max(1) && clean > 0,
        "{transparent}, {opaque}"
    );
    let [_, transparent, semi, opaque] = classes("fogged", &["condensation.age_s=300"]);
    assert_eq!([transparent, semi, opaque], [320 * 200, 0, 0]);
    // All of light is scattered by white ice, which is not seen through.
    let [_, _, semi, opaque] = classes("frosted", &["frost.age_s=20000"]);
    assert!(semi + opaque > 30_000, "{semi} {opaque}");
}

#[test]
fn what_lies_on_the_glass_ages_and_a_wiper_wipes_it() {
    let coverage = |chain: &Chain, key: &str| chain.facts()[key]["coverage"].as_f64().unwrap();
    for (preset, key, by_s) in [
        ("rain", "drops", 8.0),
        ("fogged", "condensation", 60.0),
        ("frosted", "frost", 600.0),
    ] {
        let mut recipe = Recipe::preset(preset).unwrap();
        if key == "drops" {
            recipe.set("drops.wiper_period_s=0").unwrap();
        }
        let settings = recipe.settings().unwrap();
        let chain = Chain::of(&settings, (320, 200), Seed(1)).unwrap();
        assert!(chain.ages(), "{preset}");
        let [now, later] = [0.0, by_s].map(|by_s| chain.later(by_s, Some(f64::INFINITY)).unwrap());
        let mut image = colors().crop_imm(0, 0, 320, 200);
        let mut same = image.clone();
        chain.over(&mut image, Seed(1)).unwrap();
        now.over(&mut same, Seed(1)).unwrap();
        assert!(image == same, "{preset} after no time");
        assert!(
            coverage(&later, key) > 1.2 * coverage(&now, key),
            "{preset} grows"
        );
    }
    for preset in ["muddy", "dusty", "greasy", "scratched", "windshield-star"] {
        let settings = Recipe::preset(preset).unwrap().settings().unwrap();
        let chain = Chain::of(&settings, (320, 200), Seed(1)).unwrap();
        assert!(!chain.ages(), "{preset} stays as it is");
    }
    let mut wiped = Recipe::preset("rain").unwrap();
    wiped.set("drops.wiper_period_s=5").unwrap();
    let chain = Chain::of(&wiped.settings().unwrap(), (320, 200), Seed(1)).unwrap();
    let later = |by_s: f64| chain.later(by_s, Some(f64::INFINITY)).unwrap();
    let at = |by_s: f64| coverage(&later(by_s), "drops");
    // 4 s old at first: the wiper starts after 1 s and after 6 s, is at the other end 0.7 s later, and back after as much.
    assert!(at(0.9) > at(0.0), "it rains on");
    assert!(at(1.68) < 0.2 * at(0.9), "it has gone there");
    assert!(at(2.45) < 0.1 * at(0.9), "and back");
    assert!(
        at(5.9) > 0.5 * at(0.9) && at(7.45) < 0.1 * at(0.9),
        "and again"
    );
    // In the middle of its way, and of that back, it is before the camera, and hides what is behind it.
    for (by_s, is_there) in [
        (0.9, false),
        (1.1, false),
        (1.37, true),
        (2.03, true),
        (2.5, false),
    ] {
        let chain = later(by_s);
        let wiper = chain
            .facts()
            .get("wiper")
            .map(|it| it["coverage"].as_f64().unwrap());
        assert_eq!(wiper.is_some(), is_there, "{by_s} s: {wiper:?}");
        let mut white: DynamicImage = RgbImage::from_pixel(320, 200, Rgb([200; 3])).into();
        chain.over(&mut white, Seed(1)).unwrap();
        let n_black = white.to_rgb8().pixels().filter(|it| it.0[1] < 60).count();
        assert_eq!(
            n_black > 320 * 200 / 100,
            is_there,
            "{by_s} s: {n_black} px"
        );
        if let Some(covered) = wiper {
            assert!((0.02..0.2).contains(&covered), "{by_s} s: {covered}");
        }
    }
}

#[test]
fn a_frame_does_not_depend_on_the_frames_before_it() {
    let image = colors().crop_imm(0, 0, 320, 200);
    for (preset, set) in [
        ("rain", "drops.wiper_period_s=4.5"),
        ("fogged", "condensation.clears_from_s=124"),
        ("frosted", "frost.melts_from_s=1803"),
        ("rainy-drive", "drops.wiper_period_s=0"),
    ] {
        let mut recipe = Recipe::preset(preset).unwrap();
        recipe.set(set).unwrap();
        let settings = recipe.settings().unwrap();
        let chain = Chain::of(&settings, (320, 200), Seed(1)).unwrap();
        for by_s in [0.0, 0.033, 0.4, 0.1, 0.78, 0.81, 1.4, 2.0, 6.0, 6.033, 3.0] {
            let fresh = Chain::of(&settings, (320, 200), Seed(1)).unwrap();
            let [codes, expected] = [&chain, &fresh].map(|chain| {
                let mut image = image.clone();
                let later = chain.later(by_s, Some(f64::INFINITY)).unwrap();
                later.over(&mut image, Seed(1)).unwrap();
                (image, later.facts().clone())
            });
            assert!(codes == expected, "{preset} after {by_s} s");
        }
    }
}

#[test]
fn lamps_brighter_than_white_stay_as_they_are_where_nothing_meets_their_light() {
    let lamps: DynamicImage = RgbImage::from_fn(320, 200, |x, y| {
        Rgb([
            255,
            u8::try_from(x % 256).unwrap(),
            u8::try_from(y).unwrap(),
        ])
    })
    .into();
    let over = |sets: &[&str]| {
        let mut recipe = Recipe::preset("muddy").unwrap();
        for set in sets {
            recipe.set(set).unwrap();
        }
        let chain = Chain::of(&recipe.settings().unwrap(), (320, 200), Seed(3)).unwrap();
        let mut after = lamps.clone();
        let mut watch = Stopwatch::start();
        let shown = chain
            .over_and_report(&mut after, Seed(3), &[], &mut watch)
            .unwrap();
        (after, shown.region)
    };
    let (after, region) = over(&["lens.headroom=50"]);
    let pixels = after.to_rgb8();
    let before = lamps.to_rgb8();
    // Around splats the glass is dirty by less than the region counts.
    let is_far = |x: u32, y: u32| {
        let near = |k: u32, n: u32| k.saturating_sub(2)..(k + 3).min(n);
        near(y, 200).all(|y| near(x, 320).all(|x| region.get_pixel(x, y).0[0] == 0))
    };
    let (mut n_far, mut n_clean) = (0, 0);
    for (x, y, pixel) in before.enumerate_pixels() {
        if is_far(x, y) {
            n_far += 1;
            n_clean += u32::from(pixels.get_pixel(x, y) == pixel);
        } else if region.get_pixel(x, y).0[0] == 0 {
            let channels = pixels.get_pixel(x, y).0.into_iter().zip(pixel.0);
            let most = channels.map(|(is, was)| is.abs_diff(was)).max();
            assert!(most < Some(12), "{most:?} codes at {x}, {y}");
        }
    }
    assert!(n_far > 20_000, "{n_far} px are far from mud");
    assert!(n_clean > n_far * 99 / 100, "{n_clean} of {n_far} stay");
    let (after, _) = over(&[
        "mud.coverage_percent=0",
        "frost.age_s=0",
        "lens.headroom=50",
    ]);
    assert!(after == lamps, "with nothing on the pane");
}

/// Lamps brighter than white behind drops, in every kind of image, and what noise and lost frames make of it.
#[test]
fn bright_lamps_meet_drops_in_any_image() {
    let mut recipe = Recipe::preset("rain").unwrap();
    recipe.set("camera.focus_distance_m=0.15").unwrap();
    let chain = Chain::of(&recipe.settings().unwrap(), (160, 100), Seed(3)).unwrap();
    let night = RgbImage::from_fn(160, 100, |x, y| {
        Rgb([if x % 40 < 2 && y % 25 < 2 { 255 } else { 12 }; 3])
    });
    let night = DynamicImage::from(night);
    let images = [
        DynamicImage::from(night.to_luma8()),
        DynamicImage::from(night.to_luma_alpha8()),
        night.clone(),
        DynamicImage::from(night.to_rgba8()),
        DynamicImage::from(night.to_luma16()),
        DynamicImage::from(night.to_rgb16()),
        DynamicImage::from(night.to_rgba16()),
    ];
    for image in images {
        let mut wet = image.clone();
        chain.over(&mut wet, Seed(3)).unwrap();
        assert!(wet != image, "{:?}", image.color());
        let light = |image: &DynamicImage| -> u64 {
            image.to_rgb8().iter().map(|code| u64::from(*code)).sum()
        };
        assert!(
            light(&wet) > light(&image),
            "lamps light drops: {:?}",
            image.color()
        );
    }
    for size in [(80, 100), (161, 100), (0, 0)] {
        let mut other = DynamicImage::new_rgb8(size.0, size.1);
        let refused = chain.over(&mut other, Seed(3));
        assert!(matches!(refused, Err(Error::Optics(_))), "{size:?}");
    }
    recipe.set("optics.noise_read=0.05").unwrap();
    for set in ["frames.black=1", "frames.white=0", "frames.frozen=0"] {
        recipe.set(set).unwrap();
    }
    let chain = Chain::of(&recipe.settings().unwrap(), (160, 100), Seed(3)).unwrap();
    let mut black = night;
    chain.over(&mut black, Seed(3)).unwrap();
    assert!(
        black.to_rgb8().iter().all(|code| *code == 0),
        "a black frame is black"
    );
}

#[test]
fn glass_with_nothing_on_it_is_intact_whatever_the_headroom() {
    let mut recipe = Recipe::preset("frosted").unwrap();
    recipe.set("frost.age_s=0").unwrap();
    let chain = Chain::of(&recipe.settings().unwrap(), (160, 100), Seed(3)).unwrap();
    assert!(chain.is_intact());
}
