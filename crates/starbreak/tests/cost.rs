//! The memory that a recipe is said to take, against what it takes.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::env;
use std::fs;
use std::process::Command;

use image::{DynamicImage, Rgb, RgbImage};
use rayon::prelude::*;
use starbreak::{Chain, Error, Recipe, Scene, Seed, Stopwatch};

/// The child's recipe, in this variable: preset, frame, and what is set.
const RECIPE: &str = "STARBREAK_TEST_RECIPE";

/// What is said of the child, and what it found, bytes.
#[derive(Debug)]
struct Found {
    said: f64,
    taken: f64,
}

/// Estimated and greatest memory of a process of its own that makes one picture.
fn cost_of(recipe: &str) -> Found {
    let output = Command::new(env::current_exe().unwrap())
        .args(["--exact", "one_picture", "--nocapture"])
        .env(RECIPE, recipe)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let number = |name: &str| -> f64 {
        let (_, rest) = text
            .split_once(name)
            .unwrap_or_else(|| panic!("{recipe}: {output:?}"));
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    Found {
        said: number("said "),
        taken: number("taken "),
    }
}

/// Makes the picture that the variable asks for; without it there is nothing to do.
#[test]
#[expect(clippy::print_stdout, reason = "to the process that asks")]
fn one_picture() {
    let Ok(text) = env::var(RECIPE) else {
        return;
    };
    let mut words = text.split(' ');
    let mut recipe = Recipe::preset(words.next().unwrap()).unwrap();
    let (width, height) = words.next().unwrap().split_once('x').unwrap();
    let size: (u32, u32) = (width.parse().unwrap(), height.parse().unwrap());
    for word in words {
        match word.strip_prefix("camera:") {
            Some(camera) => recipe.set_camera(camera).unwrap(),
            None => recipe.set(word).unwrap(),
        }
    }
    // Whatever it is said to take.
    recipe.set_max_memory(1 << 40);
    let settings = recipe.settings().unwrap();
    let gray = RgbImage::from_pixel(size.0, size.1, Rgb([90, 110, 140]));
    let mut image = DynamicImage::ImageRgb8(gray);
    let simulated = starbreak::simulate(&settings, size, Seed(1)).unwrap();
    let view = Scene::of(&settings, size)
        .of_network(&simulated.network)
        .unwrap();
    let said = if settings.drops.is_some() {
        // What lies there is known to the chain alone.
        recipe.set_max_memory(1 << 25);
        match Chain::of(&recipe.settings().unwrap(), size, Seed(1)) {
            Err(Error::TooCostly { needs_bytes, .. }) => needs_bytes,
            other => panic!("{text}: {other:?}"),
        }
    } else {
        let showing = settings.cost_of_showing(&simulated.network, &view, None);
        let breaking = settings.cost_of_breaking(size);
        showing.memory_bytes.max(breaking.memory_bytes)
    };
    let mut watch = Stopwatch::start();
    let chain = Chain::of_simulated(&settings, simulated, size, Seed(1), &mut watch).unwrap();
    chain
        .over_and_report(&mut image, Seed(1), &[], &mut watch)
        .unwrap();
    chain.crack_mask().unwrap();
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let (_, peak) = status.split_once("VmHWM:").unwrap();
    let peak_kib: f64 = peak.split_whitespace().next().unwrap().parse().unwrap();
    println!("said {said} taken {}", 1024.0 * peak_kib);
}

#[test]
fn a_picture_takes_no_more_than_is_said_and_no_less_than_a_third_of_it() {
    let recipes = [
        "windshield-star 1242x375",
        "windshield-gravel 1242x375 impact.count=40",
        "windshield-spiderweb 4000x3000",
        "windshield-star 2000x1500 camera:phone",
        "windshield-spiderweb 2000x1500 camera:adas-1080p",
        "lens-cover-star 1242x375",
        "lens-cover-star 3000x2000 camera.f_number=0.8",
        "lens-cover-shattered 4000x3000 camera.focus_distance_m=short",
        "lens-cover-star 1242x375 camera.focal_length_mm=300 camera.f_px=75000",
        "lens-cover-star 1242x375 glass.width_mm=1000 glass.height_mm=800 glass.thickness_mm=4 impact.speed_m_s=30 impact.radius_mm=10",
        "lens-cover-star 1242x375 fracture.mesh=fast impact.position=[0.5,0.001]",
        "lens-cover-star 1242x375 impact.position=[0.5,0.001]",
        "tempered-cover 3000x2000",
        "tempered-cover 1242x375 glass.kind=tempered glass.width_mm=1400 glass.height_mm=900",
        "windshield-gravel 4000x3000 optics.veiling_glare=0.1",
        "paper 4000x3000 fracture.neighbour_radius_px=330",
        "paper 4000x3000 fracture.neighbour_radius_px=330 optics.model=physical",
        "paper 1242x375 fracture.particles=1000000 fracture.neighbour_radius_px=6.5 fracture.two_sided=true fracture.critical_stress=1",
        "paper 1242x375 fracture.particles=1000000 fracture.neighbour_radius_px=3 fracture.branches=2 fracture.critical_stress=0.001",
        "paper 1242x375 fracture.particles=1000000 fracture.neighbour_radius_px=6.5 fracture.neighbourhood=\"mesh-edges\"",
    ];
    assert_said(&recipes, 3.1);
}

/// What is said is no less than what is taken, and so many times that at most.
fn assert_said(recipes: &[&str], most: f64) {
    let wrong_of = |recipe: &&str| {
        let Found { said, taken } = cost_of(recipe);
        let ratio = said / taken;
        let is_right = (1.0..=most).contains(&ratio);
        (!is_right).then(|| format!("{recipe}: {said:.0} bytes said, {taken:.0} taken: {ratio:.2}"))
    };
    // Each in a process of its own, of which some take gigabytes.
    let two = rayon::ThreadPoolBuilder::new()
        .num_threads(2)
        .build()
        .unwrap();
    let wrong: Vec<String> = two.install(|| recipes.par_iter().filter_map(wrong_of).collect());
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn what_lies_on_whole_glass_takes_no_more_than_is_said_and_no_less_than_two_fifths_of_it() {
    let recipes = [
        "fogged 4000x3000",
        "fogged 6000x4500 condensation.age_s=213",
        "fogged 1164x874",
        "frosted 4000x3000",
        "muddy 4000x3000 mud.coverage_percent=40",
        "muddy 4000x3000 camera.f_number=22",
        "dusty 4000x3000",
        "scratched 4000x3000",
        "greasy 4000x3000",
        "greasy 4000x3000 camera.f_number=22",
        "winter-morning 4000x3000",
        "desert-track 4000x3000",
        "desert-track 4000x3000 camera.f_number=22",
        "winter-morning 4000x3000 camera.f_number=22",
        "rain 4000x3000 drops.rain_mm_h=1 drops.age_s=2",
        "rain 4000x3000 drops.rain_mm_h=25",
        "rain 6000x4500 drops.rain_mm_h=25",
        "rain 4000x3000 drops.rain_mm_h=25 camera.f_number=0.8",
        "rain 4000x3000 drops.rain_mm_h=25 camera.f_number=22",
        "rain 1164x874",
        "rain 1164x874 drops.speed_m_s=60",
        "rainy-drive 4000x3000",
        "rainy-drive 4000x3000 camera.f_number=22",
        "car-wash 4000x3000",
    ];
    assert_said(&recipes, 2.5);
}

#[test]
fn what_takes_too_much_is_refused_with_the_key_to_change() {
    let refusal = |preset: &str, set: &[&str], size: (u32, u32), limit: u64| {
        let mut recipe = Recipe::preset(preset).unwrap();
        for set in set {
            recipe.set(set).unwrap();
        }
        recipe.set_max_memory(limit);
        let settings = recipe.settings().unwrap();
        match Chain::of(&settings, size, Seed(1)) {
            Err(error @ Error::TooCostly { .. }) => error.to_string(),
            other => panic!("{preset}: {other:?}"),
        }
    };
    let mib = 1 << 20;
    for (said, named) in [
        (
            refusal(
                "paper",
                &[
                    "fracture.particles=10000000",
                    "fracture.neighbour_radius_px=2",
                    "fracture.branches=2",
                ],
                (1242, 375),
                1 << 30,
            ),
            "breaking the glass may take 2.6 GiB of memory, more than the 1.0 GiB that one picture may take; lower fracture.particles",
        ),
        (
            refusal("lens-cover-star", &[], (64, 48), 32 * mib),
            "set fracture.mesh = \"fast\"",
        ),
        (
            refusal(
                "windshield-spiderweb",
                &["camera.f_number=0.5", "glass.distance_m=0.01"],
                (2000, 1500),
                256 * mib,
            ),
            "raise camera.f_number or glass.distance_m",
        ),
        (
            refusal(
                "windshield-spiderweb",
                &["output.maps=true"],
                (2000, 1500),
                256 * mib,
            ),
            "set output.maps = false",
        ),
        (
            refusal("rain", &[], (4000, 3000), 256 * mib),
            "showing the drops on the glass may take 1.4 GiB of memory, more than the 256 MiB that one picture may take; take smaller images, or raise that limit (--max-memory",
        ),
        (
            refusal("fogged", &[], (4000, 3000), 256 * mib),
            "showing what lies on the glass may take",
        ),
    ] {
        assert!(said.contains(named), "{said}");
    }
}
