//! The glass breaks in mm: what breaks does not depend on the pixels that look at it.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use starbreak::glass::CrackNetwork;
use starbreak::pipeline::{self, Details};
use starbreak::{Recipe, Seed};

/// One view in three resolutions, all of them of one shape.
const SIZES_PX: [(u32, u32); 3] = [(828, 250), (1242, 375), (2484, 750)];

fn seen(recipe: &Recipe, (width, height): (u32, u32), seed: u64) -> (CrackNetwork, Vec<usize>) {
    let settings = recipe.settings().unwrap();
    let simulated = pipeline::simulate(&settings, width, height, Seed(seed)).unwrap();
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
