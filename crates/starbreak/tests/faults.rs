//! Faults of the camera through the chain: what they change, what they leave, and what recipes say of them.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, LumaA, Rgb, RgbImage, Rgba};
use starbreak::{Chain, FAULTS, Recipe, Seed, Stopwatch};

/// Every code of 8 bits, in three orders.
fn codes8() -> DynamicImage {
    RgbImage::from_fn(64, 64, |x, y| {
        let code = u8::try_from((y * 64 + x) % 256).unwrap();
        Rgb([code, code.wrapping_mul(7), 255 - code])
    })
    .into()
}

/// Images of all modes, with every code of theirs.
fn all_modes() -> Vec<DynamicImage> {
    let code16 = |x: u32, y: u32| u16::try_from(y * 256 + x).unwrap();
    let gray = |x: u32, y: u32| u8::try_from((y * 32 + x) % 256).unwrap();
    vec![
        codes8(),
        DynamicImage::ImageRgba8(ImageBuffer::from_fn(32, 16, |x, y| {
            let code = gray(x, y);
            Rgba([code, 255 - code, code / 2, code])
        })),
        DynamicImage::ImageLuma8(GrayImage::from_fn(32, 16, |x, y| Luma([gray(x, y)]))),
        DynamicImage::ImageLumaA8(ImageBuffer::from_fn(32, 16, |x, y| LumaA([gray(x, y), 9]))),
        DynamicImage::ImageLuma16(ImageBuffer::from_fn(256, 256, |x, y| Luma([code16(x, y)]))),
        DynamicImage::ImageLumaA16(ImageBuffer::from_fn(256, 256, |x, y| {
            LumaA([code16(x, y), 7])
        })),
        DynamicImage::ImageRgb16(ImageBuffer::from_fn(256, 256, |x, y| {
            let code = code16(x, y);
            Rgb([code, 65_535 - code, code.rotate_left(5)])
        })),
        DynamicImage::ImageRgba16(ImageBuffer::from_fn(256, 256, |x, y| {
            let code = code16(x, y);
            Rgba([code, code / 2, code / 3, 65_535 - code])
        })),
    ]
}

fn over(recipe: &Recipe, image: &DynamicImage, seed: u64) -> DynamicImage {
    let mut image = image.clone();
    let size = (image.width(), image.height());
    let chain = Chain::of(&recipe.settings().unwrap(), size, Seed(seed)).unwrap();
    chain.over(&mut image, Seed(seed)).unwrap();
    image
}

fn whole(tables: &str) -> Recipe {
    let text = format!("schema = 1\n[fracture]\nmodel = \"none\"\n{tables}");
    Recipe::parse("mine.toml", &text).unwrap()
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

#[test]
fn no_fault_and_faults_of_nothing_leave_every_code_of_every_mode() {
    let nothing = [
        ("", "no fault"),
        ("[exposure]\nev = 0.0\n", "an exposure of 0 EV"),
        ("[banding]\ndepth = 0.0\n", "lamps that do not pulse"),
        (
            "[noise]\nwhite_e = inf\nread_e = 9.0\nrow_e = 9.0\nprnu_percent = 5.0\n",
            "endless electrons",
        ),
        (
            "[pixels]\ndead_per_mpx = 0.0\nhot_per_mpx = 0.0\nstuck_per_mpx = 0.0\n",
            "no defects",
        ),
        ("[lines]\nrows = 0\ncolumns = 0\n", "no lines"),
    ];
    for (tables, what) in nothing {
        let recipe = whole(tables);
        for image in all_modes() {
            assert!(
                over(&recipe, &image, 3) == image,
                "{what}, {:?}",
                image.color()
            );
        }
    }
}

#[test]
fn every_preset_shows_more_at_every_severity_in_every_mode() {
    for (preset, _) in FAULTS.iter().flat_map(|fault| fault.presets) {
        let gray: DynamicImage = RgbImage::from_pixel(1600, 1200, Rgb([128; 3])).into();
        let mut last = 0.0;
        for severity in 1..=5 {
            let recipe = Recipe::preset_at(preset, severity).unwrap();
            let changed = change(&gray, &over(&recipe, &gray, 5));
            assert!(
                changed > last || changed > 120.0,
                "{preset} at {severity}: {changed} after {last}"
            );
            last = changed;
        }
        let recipe = Recipe::preset_at(preset, 5).unwrap();
        for image in all_modes() {
            let after = over(&recipe, &image, 5);
            assert!(after != image, "{preset}, {:?}", image.color());
            assert!(over(&recipe, &image, 5) == after, "{preset} repeats");
            assert_eq!(after.color(), image.color(), "{preset}");
        }
    }
}

#[test]
fn alpha_stays() {
    for image in all_modes() {
        let after = over(&Recipe::preset_at("noise", 5).unwrap(), &image, 1);
        if let (Some(before), Some(after)) = (image.as_rgba8(), after.as_rgba8()) {
            let alpha = |image: &image::RgbaImage| image.pixels().map(|p| p[3]).collect::<Vec<_>>();
            assert_eq!(alpha(before), alpha(after), "alpha");
        }
    }
}

#[test]
fn an_exposure_is_a_factor_of_light() {
    let image: DynamicImage = RgbImage::from_pixel(40, 30, Rgb([100, 60, 30])).into();
    let bright = over(&whole("[exposure]\nev = 1.0\n"), &image, 1).to_rgb8();
    let light = starbreak::optics::srgb::decode8;
    for (code, before) in bright.get_pixel(7, 7).0.into_iter().zip([100, 60, 30]) {
        let expected = starbreak::optics::srgb::encode8(2.0 * light(before));
        assert_eq!(code, expected, "twice the light of {before}");
    }
}

#[test]
fn a_record_says_how_large_a_fault_is_and_the_region_where_it_is() {
    let image = RgbImage::from_pixel(300, 200, Rgb([120; 3]));
    let shown = |recipe: &Recipe| {
        let mut image = DynamicImage::ImageRgb8(image.clone());
        let chain = Chain::of(&recipe.settings().unwrap(), (300, 200), Seed(1)).unwrap();
        let mut watch = Stopwatch::start();
        let shown = chain
            .over_and_report(&mut image, Seed(1), &[], &mut watch)
            .unwrap();
        assert!(!chain.is_intact(), "a fault is damage");
        (chain.facts().clone(), shown.region)
    };
    let (facts, region) = shown(&Recipe::preset("noise").unwrap());
    let snr = facts["faults"]["noise"]["snr_18"].as_f64().unwrap();
    assert!((snr - 10.0).abs() < 0.1, "{snr}");
    assert!(!facts.contains_key("network"), "no cracks are told of");
    assert!(
        region.iter().all(|code| *code == 255),
        "noise is everywhere"
    );
    let (facts, region) = shown(&whole("[lines]\nrows = 1\ncolumns = 0\n"));
    let row = facts["faults"]["lines"]["rows"][0].as_u64().unwrap();
    for (y, codes) in (0..).zip(region.chunks_exact(300)) {
        let is_near = row.abs_diff(y) <= 2;
        assert!(
            codes.iter().all(|code| (*code == 255) == is_near),
            "row {y} of a line at {row}"
        );
    }
}

#[test]
fn glass_and_sensor_come_one_after_the_other() {
    let image: DynamicImage = RgbImage::from_pixel(400, 240, Rgb([128; 3])).into();
    let cracked = over(&Recipe::preset("windshield-spiderweb").unwrap(), &image, 2);
    let mut both = Recipe::preset("windshield-spiderweb").unwrap();
    both.set("exposure.ev=-1").unwrap();
    both.set("exposure.white_e=1000000").unwrap();
    both.set("exposure.read_e=0").unwrap();
    let darker = over(&both, &image, 2);
    let mut expected = cracked.clone();
    let after_glass = whole("[exposure]\nev = -1.0\nwhite_e = 1e6\nread_e = 0.0\n");
    expected = over(&after_glass, &expected, 2);
    assert!(darker == expected, "first the glass, then the sensor");
    assert!(change(&cracked, &image) > 1.0, "there is a crack");
}

#[test]
fn defects_are_the_sensors_and_noise_is_the_frames() {
    let image: DynamicImage = RgbImage::from_pixel(300, 200, Rgb([128; 3])).into();
    let pixels = Recipe::preset_at("pixels", 5).unwrap();
    assert!(
        over(&pixels, &image, 1) == over(&pixels, &image, 2),
        "in all images the same"
    );
    let mut other = pixels.clone();
    other.set("sensor.number=1").unwrap();
    assert!(
        over(&other, &image, 1) != over(&pixels, &image, 1),
        "another camera"
    );
    let noise = Recipe::preset("noise").unwrap();
    assert!(
        over(&noise, &image, 1) != over(&noise, &image, 2),
        "photons"
    );
}

#[test]
fn recipes_know_the_faults() {
    let recipe = Recipe::parse("mine.toml", "schema = 1\n[noise]\nwhite_e = 300\n").unwrap();
    assert!(recipe.to_commented_toml().contains("[noise]"), "printed");
    assert_eq!(recipe.to_json()["noise"]["read_e"], 3.0, "filled in");
    assert_eq!(
        recipe.to_json()["fracture"]["model"],
        "physics",
        "beside cracks"
    );
    let again = Recipe::parse("again.toml", &recipe.to_toml()).unwrap();
    assert_eq!(again, recipe, "read again");
    let error = |text: &str| Recipe::parse("mine.toml", text).unwrap_err().to_string();
    assert_eq!(
        error("schema = 1\n[noise]\nwhite = 300\n"),
        "mine.toml: unknown key `noise.white`; did you mean `noise.white_e`?"
    );
    assert_eq!(
        error("schema = 1\n[exposure]\nev = 11\n"),
        "mine.toml: exposure.ev = 11; expected -10 to 10"
    );
    assert!(
        error("schema = 1\n[nois]\n").contains("did you mean `noise`?"),
        "tables"
    );
    let unknown = Recipe::preset("noisy").unwrap_err().to_string();
    assert!(unknown.contains("did you mean `noise`?"), "{unknown}");
    let stone = Recipe::preset("noise").unwrap().set("impact.speed_m_s=3");
    let stone = stone.unwrap_err().to_string();
    assert!(
        stone.contains("impact") && stone.contains("fracture.model"),
        "{stone}"
    );
    let mut none = Recipe::preset("windshield-star").unwrap();
    none.set("fracture.model=none").unwrap();
    let tables = none.to_json();
    assert!(
        tables.get("impact").is_none() && tables.get("glass").is_none(),
        "no stone, no pane"
    );
    assert!(
        none.to_toml().contains("model = \"none\""),
        "{}",
        none.to_toml()
    );
}
