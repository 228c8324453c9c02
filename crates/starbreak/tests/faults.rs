//! Faults of the camera through the chain: what they change, what they leave, and what recipes say of them.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::{ColorType, DynamicImage, GrayImage, ImageBuffer, Luma, LumaA, Rgb, RgbImage, Rgba};
use starbreak::sensor::FrameState;
use starbreak::{Chain, FAULTS, Recipe, Seed, Stopwatch};
use starbreak_dataset::{Encoding, ImageLimits, JpegQuality, decode_image, encode_image};

use crate::alpha::alpha_of;

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
        (
            "[banding]\nled_duty = 1.0\ndepth = 1.0\n",
            "LEDs that are always lit",
        ),
        ("[spots]\ncount = 0\n", "no spots"),
        ("[cfa]\nloss = 0.0\n", "all filters"),
        ("[mosaic]\nshare = 0.0\n", "no raw rows"),
        ("[isp]\nunsharp = 0.0\n", "a processor that works"),
        ("[drops]\nrain_mm_h = 0.0\n", "no rain"),
        ("[drops]\nage_s = 0.0\n", "a wiper that has just passed"),
        ("[condensation]\nage_s = 0.0\n", "no dew"),
        ("[condensation]\ngrowth_um_s = 0.0\n", "dry air"),
        ("[mud]\ncoverage_percent = 0.0\n", "no mud"),
        ("[dust]\ncoverage_percent = 0.0\n", "no dust"),
        ("[film]\nripple_um = 0.0\nhaze_percent = 0.0\n", "no film"),
        ("[frost]\nage_s = 0.0\n", "frost that has not begun"),
        ("[frost]\nfront_um_s = 0.0\n", "frost that does not grow"),
        ("[scratches]\nhaze_percent = 0.0\n", "no scratches"),
        ("[distortion]\ncorner_percent = 0.0\n", "no distortion"),
        ("[fringes]\nlateral_px = 0.0\n", "no fringes"),
        ("[defocus]\nsensor_shift_um = 0.0\n", "a sensor in focus"),
        ("[shake]\nrate_deg_s = 0.0\n", "a camera that is still"),
        (
            "[glare]\nveil_percent = 0.0\n",
            "a lens that scatters nothing",
        ),
        (
            "[shading]\ncorner_loss_percent = 0.0\n",
            "corners without loss",
        ),
        ("[lens]\nheadroom = 100.0\n", "lamps brighter than white"),
        ("[link]\nbit_error_rate = 0.0\n", "a link that works"),
        (
            "[frames]\nblack = 0.0\nwhite = 0.0\nfrozen = 0.0\ndropped = 0.0\n",
            "all frames",
        ),
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

/// The same by night, with a lamp.
fn by_night(image: &DynamicImage) -> DynamicImage {
    let mut lit = image.to_rgba16();
    for (x, y, Rgba([red, green, blue, _])) in lit.enumerate_pixels_mut() {
        let is_lamp = (10..12).contains(&x) && (5..7).contains(&y);
        for code in [red, green, blue] {
            *code = if is_lamp { u16::MAX } else { *code / 4 };
        }
    }
    let lit = DynamicImage::from(lit);
    match image.color() {
        ColorType::L8 => lit.to_luma8().into(),
        ColorType::La8 => lit.to_luma_alpha8().into(),
        ColorType::Rgb8 => lit.to_rgb8().into(),
        ColorType::Rgba8 => lit.to_rgba8().into(),
        ColorType::L16 => lit.to_luma16().into(),
        ColorType::La16 => lit.to_luma_alpha16().into(),
        ColorType::Rgb16 => lit.to_rgb16().into(),
        _ => lit,
    }
}

/// Presets of what gray images do not have: colors and their filters.
const OF_COLORS: [&str; 5] = [
    "fringes",
    "no-filters",
    "no-demosaicing",
    "no-white-balance",
    "no-color-matrix",
];

#[test]
fn every_preset_shows_more_at_every_severity_in_every_mode() {
    let large = colors();
    // Glass shows itself in fewer pixels, too; and lamps are thrown to other places.
    let mut small = large.crop_imm(0, 0, 480, 360).to_rgb8();
    for (x, y) in (100..104).flat_map(|x| (90..94).map(move |y| (x, y))) {
        small.put_pixel(x, y, Rgb([255; 3]));
    }
    let small = DynamicImage::from(small);
    let presets = FAULTS
        .iter()
        .flat_map(|fault| fault.presets.iter().map(move |(preset, _)| (fault, preset)));
    // Of blank frames there are more, below.
    for (fault, preset) in presets.filter(|(fault, _)| fault.table != "frames") {
        let is_small = fault.needs_pane() || ["ghosts", "star"].contains(&fault.table);
        let scene = if is_small { &small } else { &large };
        let at = |severity: u8| {
            let mut recipe = Recipe::preset_at(preset, severity).unwrap();
            if fault.needs_pane() {
                // A part of the pane.
                recipe.set("camera.f_px=600").unwrap();
            }
            if *preset == "frosted" {
                // That has ice in it.
                recipe.set("frost.seeds_per_cm2=2").unwrap();
            }
            if *preset == "ghosts" {
                recipe.set("lens.headroom=1000").unwrap();
            }
            recipe
        };
        let mut last = 0.0;
        for severity in 1..=5 {
            let recipe = at(severity);
            let changed = change(scene, &over(&recipe, scene, 5));
            assert!(
                changed > last,
                "{preset} at {severity}: {changed} after {last}"
            );
            last = changed;
        }
        let mut recipe = at(5);
        if *preset == "row-alias" {
            // These images have few rows.
            recipe.set("link.row_bits=1").unwrap();
        }
        for mut image in all_modes() {
            if ["ghosts", "star"].contains(&fault.table) {
                image = by_night(&image);
            }
            let after = over(&recipe, &image, 5);
            let stays = OF_COLORS.contains(preset) && !image.color().has_color();
            assert_eq!(after == image, stays, "{preset}, {:?}", image.color());
            assert_eq!(
                region_of(&recipe, &image) > 0.0,
                !stays,
                "{preset}, {:?}",
                image.color()
            );
            assert!(over(&recipe, &image, 5) == after, "{preset} repeats");
            assert_eq!(after.color(), image.color(), "{preset}");
            let alpha_stays = alpha_of(&after) == alpha_of(&image);
            assert!(alpha_stays || *preset == "distortion", "{preset}: alpha");
        }
    }
}

#[test]
fn more_frames_are_blank_at_every_severity() {
    let image: DynamicImage = RgbImage::from_pixel(4, 3, Rgb([90; 3])).into();
    for (severity, share) in (1..=5).zip([0.005, 0.025, 0.05, 0.125, 0.25]) {
        let recipe = Recipe::preset_at("blank-frames", severity).unwrap();
        let settings = recipe.settings().unwrap();
        let is_black = |seed: u64| {
            let chain = Chain::of(&settings, (4, 3), Seed(seed)).unwrap();
            let mut after = image.clone();
            let mut watch = Stopwatch::start();
            let shown = chain
                .over_and_report(&mut after, Seed(seed), &[], &mut watch)
                .unwrap();
            let is_black = after.to_rgb8().iter().all(|code| *code == 0);
            assert!(is_black || after == image, "all or nothing");
            assert_eq!(shown.region_fraction > 0.5, is_black, "the region says so");
            let arrival = shown.arrival.unwrap();
            assert_eq!(arrival == FrameState::Black, is_black, "the record says so");
            is_black
        };
        let n_black = (0..4000).filter(|seed| is_black(*seed)).count();
        let error = (share * (1.0 - share) / 4000.0_f64).sqrt();
        let found = n_black as f64 / 4000.0;
        assert!(
            (found - share).abs() < 4.0 * error,
            "{severity}: {found}, not {share}"
        );
    }
}

#[test]
fn a_codec_on_the_way_is_that_of_files() {
    let image = colors().crop_imm(0, 0, 96, 64);
    for quality in [8, 60, 95] {
        let tables = format!("[link]\njpeg_quality = {quality}\n");
        let found = over(&whole(&tables), &image, 1);
        let quality = JpegQuality::new(quality).unwrap();
        let bytes = encode_image(&image, &Encoding::Jpeg { quality }, None).unwrap();
        let expected = decode_image("mine.jpg", &bytes, &ImageLimits::default()).unwrap();
        assert!(found == expected.pixels, "quality {}", quality.get());
    }
}

#[test]
fn without_its_tone_curve_a_code_is_that_of_its_light() {
    let after = over(&whole("[isp]\ntone = 1.0\n"), &codes8(), 1).to_rgb8();
    for (code, before) in after.iter().zip(codes8().to_rgb8().iter()) {
        let light = f64::from(starbreak::optics::srgb::decode8(*before));
        assert!(
            (f64::from(*code) - 255.0 * light).abs() <= 0.5,
            "{code} of {before}"
        );
    }
}

#[test]
fn the_blur_of_the_papers_optics_is_that_of_its_glass() {
    let mut recipe = Recipe::preset("paper").unwrap();
    recipe.set("fracture.model=none").unwrap();
    recipe.set("noise.white_e=300").unwrap();
    let mut image = colors().crop_imm(0, 0, 200, 100);
    let chain = Chain::of(&recipe.settings().unwrap(), (200, 100), Seed(1)).unwrap();
    let boxes = [[20.0, 20.0, 90.0, 80.0]];
    let mut watch = Stopwatch::start();
    let shown = chain
        .over_and_report(&mut image, Seed(1), &boxes, &mut watch)
        .unwrap();
    let damage = shown.damage[0].unwrap();
    assert!(
        damage.blur_radius_px.abs() < 1e-12,
        "whole glass blurs nothing"
    );
    assert!(
        (damage.region_share - 1.0).abs() < 1e-12,
        "noise is everywhere"
    );
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
    let link = Recipe::parse("mine.toml", "schema = 1\n[link]\njpeg_quality = 30\n").unwrap();
    assert_eq!(
        link.to_json()["link"]["bit_error_rate"],
        0.0,
        "what is not named works"
    );
    assert_eq!(
        error("schema = 1\n[banding]\nled_duty = 1e-9\n"),
        "mine.toml: banding.led_duty = 0.000000001; expected 0.001 to 1, or 0: no LEDs"
    );
    assert!(
        error("schema = 1\n[spots]\nheight_mm = 10\nf_number = 1\n")
            .contains("the width of a shadow"),
        "no spots"
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

#[test]
fn a_table_of_several_faults_has_those_that_it_names() {
    let shown = |tables: &str| {
        let settings = whole(tables).settings().unwrap();
        let chain = Chain::of(&settings, (320, 200), Seed(1)).unwrap();
        chain.facts()["faults"].clone()
    };
    let heat = shown("[defocus]\nwarmer_k = 50.0\num_per_k = 0.1\n");
    // 5 um with f = 3 mm and f/2.8.
    let disc = heat["defocus"]["disc_px"].as_f64().unwrap();
    let expected = 5e-6 * (721.5377 / 1242.0 * 320.0) / (2.8 * 3e-3);
    assert!((disc - expected).abs() < 1e-5, "{disc}, not {expected}");
    let shift = shown("[distortion]\nshift_px = [3.0, -2.0]\n");
    let corner = &shift["distortion"]["corner_moves_px"];
    assert_eq!(corner, &serde_json::json!([3.0, -2.0]));
    let axial = shown("[fringes]\naxial_um = 20.0\n");
    assert_eq!(
        axial["fringes"],
        serde_json::json!({ "lateral_px": 0.0, "axial_um": 20.0 })
    );
}

/// Beside a lamp whose light is scattered away the sun brings as much at one place or another; no sample is then as if
/// nothing had been done to it.
#[test]
fn more_of_a_low_sun_makes_nothing_darker() {
    let image: DynamicImage = RgbImage::from_fn(200, 120, |x, y| {
        let is_lamp = (80..84).contains(&x) && (60..64).contains(&y);
        Rgb(if is_lamp {
            [235, 245, 255]
        } else {
            [30, 35, 40]
        })
    })
    .into();
    let under = |irradiance: u32| {
        let recipe = whole(&format!(
            "[glare]\nveil_percent = 4.0\n[lens]\nheadroom = 30.0\n[optics]\nsun_azimuth_deg = 2.0\n\
             sun_elevation_deg = 2.0\nsun_irradiance = {}\n",
            f64::from(irradiance) * 0.05
        ));
        over(&recipe, &image, 1).into_rgb8()
    };
    let mut before = under(0);
    for irradiance in 1..40 {
        let now = under(irradiance);
        for ((x, y, was), is) in before.enumerate_pixels().zip(now.pixels()) {
            for (was, is) in was.0.iter().zip(is.0) {
                assert!(
                    is.saturating_add(2) >= *was,
                    "{irradiance} at {x}, {y}: {was} to {is}"
                );
            }
        }
        before = now;
    }
}
