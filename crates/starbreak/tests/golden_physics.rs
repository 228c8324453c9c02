//! Figures of our own physics: they guard against change and prove nothing else.
//!
//! Not digests: the plate's linear solver chooses its instructions by the processor, so the last bits
//! of stress, and with them the last digits of positions, differ between kinds of processors
//! (docs/decisions/0013). A change that is meant is written with
//! `UPDATE_GOLDEN=1 cargo test -p starbreak --test golden_physics` and entered in CHANGELOG.md under
//! "Numbers changed".
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fmt::Write as _;
use std::path::Path;

use starbreak::pipeline::{self, Details};
use starbreak::{Recipe, Seed};

const PRESETS: [&str; 6] = [
    "windshield-star",
    "windshield-bullseye",
    "windshield-combination",
    "windshield-long-crack",
    "tempered-cover",
    "lens-cover-star",
];

#[test]
fn figures_are_what_they_were() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/physics/figures.txt");
    let mut text = String::new();
    for preset in PRESETS {
        let mut recipe = Recipe::preset(preset).unwrap();
        recipe.set("fracture.mesh=fast").unwrap();
        recipe.set("impact.position=[0.5, 0.5]").unwrap();
        let settings = recipe.settings().unwrap();
        let broken = pipeline::simulate(&settings, 1242, 375, Seed(11)).unwrap();
        broken.network.check_invariants().unwrap();
        let Details::Physics(physics) = &broken.details else {
            panic!("{preset} is physics");
        };
        let hit = &physics.impacts[0];
        let summary = broken.network.summary();
        writeln!(
            text,
            "{preset} {} arms {} legs {} fragments {} force_n {:.6e} reach_mm {:.6e} length_mm {:.6e}",
            hit.damage.name(),
            hit.n_arms,
            hit.n_legs,
            summary.n_fragments.unwrap_or(1),
            hit.peak_force_n,
            hit.reach_m * 1e3,
            summary.total_length,
        )
        .unwrap();
    }
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        return;
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    let (new, old) = (text.lines(), expected.lines());
    assert_eq!(
        new.clone().count(),
        old.clone().count(),
        "one line a preset"
    );
    for (new, old) in new.zip(old) {
        for (a, b) in new.split(' ').zip(old.split(' ')) {
            let is_same = match (a.parse::<f64>(), b.parse::<f64>()) {
                (Ok(a), Ok(b)) => (a - b).abs() <= 1e-3 * b.abs(),
                _ => a == b,
            };
            assert!(is_same, "changed, which has to be meant:\n{new}\n{old}");
        }
    }
}
