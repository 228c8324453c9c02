//! Severity is a dose: more of the same event, in every seed.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../examples/severity.rs"]
#[expect(dead_code, reason = "the example's own main")]
mod table;

use starbreak::{Recipe, Seed};
use table::{median, shares_of};

/// Seeds of this test; `docs/severity.md` has 32.
const N_SEEDS: u64 = 4;

/// Presets that are one event, cut or continued.
const NESTED: [&str; 9] = [
    "windshield-star",
    "windshield-bullseye",
    "windshield-combination",
    "windshield-long-crack",
    "windshield-spiderweb",
    "windshield-gravel",
    "windshield-hail",
    "lens-cover-star",
    "lens-cover-shattered",
];

#[test]
fn more_severe_is_more_of_the_frame() {
    for preset in NESTED {
        let shares = shares_of(preset, N_SEEDS, (414, &["fracture.mesh=fast"])).unwrap();
        for of in &shares {
            assert!(of[0] > 0.0, "{preset} is intact at 1: {of:?}");
            let falls = of.windows(2).any(|pair| pair[1] < pair[0]);
            assert!(!falls, "{preset} falls: {of:?}");
        }
        let medians = [0, 1, 2, 3, 4].map(|k| median(shares.iter().map(|of| of[k]).collect()));
        for pair in medians.windows(2) {
            // Half of what the medians over 32 seeds have to grow by.
            assert!(
                pair[1] > 1.25 * pair[0] || pair[0] > 0.6,
                "{preset}: {medians:?}"
            );
        }
    }
}

#[test]
fn a_tempered_cover_grows_in_the_median() {
    let shares = shares_of("tempered-cover", N_SEEDS, (414, &["fracture.mesh=fast"])).unwrap();
    let medians = [0, 1, 2, 3, 4].map(|k| median(shares.iter().map(|of| of[k]).collect()));
    let grows = medians.windows(2).all(|pair| pair[0] < pair[1]);
    assert!(medians[0] > 0.0 && grows, "{medians:?}");
}

#[test]
fn what_is_there_of_a_web_hangs_together() {
    for severity in [2, 3] {
        for seed in 0..6 {
            let recipe = Recipe::preset_at("windshield-spiderweb", severity).unwrap();
            let settings = recipe.settings().unwrap();
            let broken = starbreak::simulate(&settings, (1242, 375), Seed(seed)).unwrap();
            let data = broken.network.data();
            let mut n_at = vec![0; data.nodes.x.len()];
            for node in data.segments.from.iter().chain(&data.segments.to) {
                n_at[*node as usize] += 1;
            }
            let ends = data.segments.from.iter().zip(&data.segments.to);
            let is_loose = |(a, b): &(&u32, &u32)| n_at[**a as usize] + n_at[**b as usize] == 2;
            let n_loose = ends.filter(is_loose).count();
            assert_eq!(n_loose, 0, "severity {severity}, seed {seed}");
        }
    }
}
