//! The glass breaks in mm: what breaks does not depend on the pixels that look at it, nor what is
//! seen of it.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::DynamicImage;
use starbreak::Details;
use starbreak::glass::CrackNetwork;
use starbreak::{Chain, Recipe, Seed, Stopwatch};

/// One view in three resolutions, all of them of one shape.
const SIZES_PX: [(u32, u32); 3] = [(828, 250), (1242, 375), (2484, 750)];

fn seen(recipe: &Recipe, (width, height): (u32, u32), seed: u64) -> (CrackNetwork, Vec<usize>) {
    let settings = recipe.settings().unwrap();
    let simulated = starbreak::simulate(&settings, (width, height), Seed(seed)).unwrap();
    let Details::Physics(details) = simulated.details else {
        panic!("a physics preset");
    };
    let arms = details.impacts.iter().map(|hit| hit.n_arms).collect();
    (simulated.network, arms)
}

#[test]
fn what_breaks_does_not_depend_on_pixels() {
    let mut n_broken = 0;
    for preset in [
        "windshield-star",
        "windshield-bullseye",
        "windshield-combination",
        "windshield-long-crack",
        "lens-cover-star",
        "tempered-cover",
    ] {
        let mut recipe = Recipe::preset(preset).unwrap();
        recipe.set("fracture.mesh=fast").unwrap();
        // A place at random and one that is given; the frames have one shape.
        for position in ["random", "[0.45, 0.55]"] {
            recipe.set(&format!("impact.position={position}")).unwrap();
            for seed in 1..3 {
                let (reference, arms) = seen(&recipe, SIZES_PX[1], seed);
                n_broken += u32::from(reference.n_segments() > 0);
                let length_mm = reference.summary().total_length;
                for size in SIZES_PX {
                    let (network, n_arms) = seen(&recipe, size, seed);
                    let text = format!("{preset}, {position}, {size:?}, seed {seed}");
                    assert_eq!(n_arms, arms, "{text}: arms");
                    let got_mm = network.summary().total_length;
                    assert!(
                        (got_mm - length_mm).abs() <= 0.01 * length_mm,
                        "{text}: {got_mm} mm, not {length_mm} mm"
                    );
                    let longest = |network: &CrackNetwork| network.summary().longest_crack;
                    if let (Some(got), Some(expected)) = (longest(&network), longest(&reference)) {
                        assert!(
                            (got - expected).abs() <= 0.01 * expected,
                            "{text}: longest {got} mm, not {expected} mm"
                        );
                    }
                }
            }
        }
    }
    assert!(n_broken > 16, "{n_broken} of 24 break");
}

/// Share of the light that each pixel loses to a crack before a lens of this focal length in px.
fn lost((width, height): (u32, u32), f_px: f64) -> Vec<f64> {
    let mut recipe = Recipe::preset("lens-cover-star").unwrap();
    for set in [
        "impact.position=[0.5, 0.5]",
        "camera.focal_length_mm=12",
        "camera.f_number=1.4",
        "output.maps=true",
        &format!("camera.f_px={f_px}"),
    ] {
        recipe.set(set).unwrap();
    }
    let mut image = DynamicImage::new_rgb8(width, height);
    let settings = recipe.settings().unwrap();
    let chain = Chain::of(&settings, (width, height), Seed(3)).unwrap();
    let mut watch = Stopwatch::start();
    let shown = chain.over_and_report(&mut image, Seed(3), &[], &mut watch);
    let maps = shown.unwrap().maps.unwrap();
    maps.attenuation.iter().copied().map(f64::from).collect()
}

/// Greatest difference over the greatest value.
fn difference(got: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(got.len(), expected.len(), "pixels");
    let most = expected.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.01, "something is seen: {most}");
    let pairs = got.iter().zip(expected);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / most
}

/// Means over squares of a frame.
fn means(values: &[f64], (width, height): (usize, usize), side: usize) -> Vec<f64> {
    let mean = |x: usize, y: usize| {
        let rows = (y * side..(y + 1) * side).map(|y| &values[y * width + x * side..][..side]);
        rows.flatten().sum::<f64>() / f64::from(u32::try_from(side * side).unwrap())
    };
    let (columns, rows) = (width / side, height / side);
    (0..rows)
        .flat_map(|y| (0..columns).map(move |x| mean(x, y)))
        .collect()
}

#[test]
fn a_large_disc_shows_on_a_fine_frame_what_a_smaller_one_does_on_a_coarse_frame() {
    // Discs of 171 px of radius, on cells of 8 px, and of 1371 px, on cells of 32 px.
    let coarse = lost((60, 40), 600.0);
    let fine = means(&lost((480, 320), 4800.0), (480, 320), 8);
    let worst = difference(&fine, &coarse);
    assert!(worst < 0.02, "{worst} of the greatest");
}

#[test]
fn a_frame_smaller_than_its_discs_shows_what_the_middle_of_a_larger_one_does() {
    // Discs of 343 px of radius: a crack far beyond the small frame is still over it.
    let small = lost((60, 40), 1200.0);
    let large = lost((604, 408), 1200.0);
    let middle: Vec<f64> = (184..224)
        .flat_map(|y| large[y * 604 + 272..][..60].to_vec())
        .collect();
    let worst = difference(&small, &middle);
    assert!(worst < 0.03, "{worst} of the greatest");
}
