//! Every preset breaks what it is named after, at every severity.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use starbreak::{Details, PRESETS, PhysicsDetails, Recipe, Seed, Simulated};

/// The picture of the paper; what breaks does not depend on it.
const SIZE_PX: (u32, u32) = (1242, 375);

/// Seeds of the classes.
const SEEDS: [u64; 3] = [1, 2, 3];

/// A crack as long as this is one that repairers do not repair, m \[ROLAGS\].
const LONG_CRACK_M: f64 = 0.152;

fn simulated(preset: &str, severity: u8, seed: u64) -> Simulated {
    let mut recipe = Recipe::preset_at(preset, severity).unwrap();
    if preset != "paper" {
        recipe.set("fracture.mesh=fast").unwrap();
    }
    let settings = recipe.settings().unwrap();
    starbreak::simulate(&settings, SIZE_PX, Seed(seed))
        .unwrap_or_else(|error| panic!("{preset} at severity {severity}, seed {seed}: {error}"))
}

fn physics(preset: &str, seed: u64) -> PhysicsDetails {
    match simulated(preset, 3, seed).details {
        Details::Physics(details) => details,
        Details::Paper(_) | Details::Imported(_) | Details::None => {
            panic!("{preset} is a preset of the physics")
        }
    }
}

#[test]
fn every_preset_simulates_at_every_severity() {
    for (preset, _) in PRESETS {
        for severity in 1..=5 {
            let simulated = simulated(preset, severity, 1);
            let network = simulated.network;
            network
                .check_invariants()
                .unwrap_or_else(|error| panic!("{preset} at severity {severity}: {error}"));
            assert!(
                network.n_segments() > 0,
                "{preset} at severity {severity} breaks nothing"
            );
        }
    }
}

#[test]
fn presets_break_what_they_are_named_after() {
    let mut wrong = Vec::new();
    for (preset, expected) in [
        ("windshield-star", &["star"][..]),
        ("windshield-bullseye", &["bullseye", "half-moon"]),
        ("windshield-combination", &["combination"]),
        ("windshield-spiderweb", &["star"]),
        ("tempered-cover", &["diced"]),
        ("lens-cover-star", &["star", "rim-to-impact"]),
    ] {
        for seed in SEEDS {
            let details = physics(preset, seed);
            let got: Vec<&str> = details
                .impacts
                .iter()
                .map(|hit| hit.damage.name())
                .collect();
            if got.is_empty() || got.iter().any(|class| !expected.contains(class)) {
                wrong.push(format!(
                    "{preset}, seed {seed}: {got:?}, not {expected:?}: {:?}",
                    details.impacts
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_preset_of_a_long_crack_has_one() {
    for seed in SEEDS {
        let report = physics("windshield-long-crack", seed).long_crack.unwrap();
        assert!(
            report.length_m > LONG_CRACK_M && report.class != "intact",
            "seed {seed}: {report:?}"
        );
    }
}
