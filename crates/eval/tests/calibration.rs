//! Intervals and tests of the report on a population whose truth is known: 40 samples of it each, with fixed seeds.
//! `validation/run calibration` does it over thousands, and on real detections.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "population/mod.rs"]
mod population;

use std::collections::BTreeMap;

use population::cells::{sample, truth, wrong};
use population::{Law, N_CATEGORIES, image, matches};
use starbreak_eval::resampling::{
    PairedPrecisions, Plan, RankedCategory, paired_average_precision,
};
use starbreak_eval::{ImageMatches, Outcome};

/// More of 40 intervals at 95 % beside the truth happen by chance in 7 of 10 000 cases.
const MOST: u32 = 7;
/// The same of all six laws together: more of 240 in 4 of 10 000.
const MOST_OF_ALL: u32 = 24;

/// Images alone, with three seeds each, and in drives that are alike, without an effect and with one.
#[test]
fn intervals_and_tests_are_wrong_as_rarely_as_they_say() {
    let mut of_all = BTreeMap::<&'static str, (u32, u32)>::new();
    let kinds = [("images", 1, 1), ("three seeds", 3, 1), ("drives", 3, 4)];
    let laws = [0.0, 1.5].map(|effect| kinds.map(|kind| (effect, kind)));
    for (place, (effect, (what, n_seeds, drive))) in (0..).zip(laws.as_flattened()) {
        let law = Law {
            effect: *effect,
            n_seeds: *n_seeds,
            drive: *drive,
        };
        let truth = truth(law, 30_000);
        let table = wrong(40, &truth, |number| sample(law, 120, number + 40 * place));
        assert!(table.len() >= 10, "{what}: {table:?}");
        for (name, row) in table {
            let about = format!("{what}, effect {effect}, {name}: {row:?}");
            assert!(row.n_intervals >= 20, "{about}");
            assert!(
                row.n_beside <= MOST,
                "{about} do not hold {:?}",
                truth.get(name)
            );
            let is_null = *effect == 0.0;
            assert!(!is_null || row.n_below <= MOST, "{about}: p below 0.05");
            let sum = of_all.entry(name).or_default();
            *sum = (sum.0 + row.n_beside, sum.1 + row.n_intervals);
        }
    }
    for (name, (n_beside, n)) in of_all {
        assert!(
            n_beside <= MOST_OF_ALL,
            "{name}: {n_beside} of {n} beside the truth"
        );
    }
}

const N_IMAGES: u32 = 60;
const N_SEEDS: usize = 3;

/// Matches of the clean images, and of those of each seed.
fn sides(effect: f64, first: u64) -> (Vec<ImageMatches>, Vec<Vec<ImageMatches>>) {
    let law = Law {
        effect,
        n_seeds: N_SEEDS,
        drive: 1,
    };
    let images: Vec<_> = (0..u64::from(N_IMAGES))
        .map(|k| image(law, first + k))
        .collect();
    let cracked = (1..=N_SEEDS).map(|seed| matches(&images, seed));
    (matches(&images, 0), cracked.collect())
}

fn of_seeds(clean: &[ImageMatches], cracked: &[Vec<ImageMatches>]) -> PairedPrecisions {
    let clean = vec![clean; cracked.len()];
    let cracked: Vec<&[ImageMatches]> = cracked.iter().map(Vec::as_slice).collect();
    let plan = Plan::of_images(N_IMAGES).with(200, 1, 0.95);
    paired_average_precision(&clean, &cracked, N_CATEGORIES as usize, &plan).unwrap()
}

#[test]
fn the_mean_over_seeds_is_that_of_each_seed_alone() {
    let (clean, cracked) = sides(1.5, 0);
    let together = of_seeds(&clean, &cracked);
    let alone: Vec<PairedPrecisions> = cracked
        .iter()
        .map(|one| of_seeds(&clean, std::slice::from_ref(one)))
        .collect();
    let mean = |of: fn(&PairedPrecisions) -> Option<f64>| {
        alone.iter().map(|one| of(one).unwrap()).sum::<f64>() / N_SEEDS as f64
    };
    let delta = |one: &PairedPrecisions| one.mean.difference.value;
    let cracked = |one: &PairedPrecisions| one.categories[0].cracked.value;
    assert!((delta(&together).unwrap() - mean(delta)).abs() < 1e-14);
    assert!((cracked(&together).unwrap() - mean(cracked)).abs() < 1e-14);
    let interval = together.mean.difference.interval.unwrap();
    assert!(interval.low < mean(delta) && mean(delta) < interval.high);
    assert!(together.mean.test.p.unwrap() < 0.05, "an effect is seen");
}

/// The mean over classes of AP of several sets of matches ranked as one.
fn pooled(sets: &[&[ImageMatches]]) -> f64 {
    let n = u32::try_from(sets.len()).unwrap();
    let of_category = |category: u32| {
        let cells = sets.iter().zip(0_u32..).flat_map(|(set, seed)| {
            let items = set.iter().filter(move |item| item.category == category);
            items.map(move |item| (item, item.image * n + seed))
        });
        let ranked = RankedCategory::new(category, cells.collect());
        ranked.average_precision(&vec![1; (N_IMAGES * n) as usize])
    };
    let aps: Vec<f64> = (0..N_CATEGORIES).filter_map(of_category).collect();
    aps.iter().sum::<f64>() / aps.len() as f64
}

/// Scores to three digits, as if a detector gave no more: equal ones are in the order of the images.
fn rounded(mut set: Vec<ImageMatches>) -> Vec<ImageMatches> {
    for detection in set.iter_mut().flat_map(|item| &mut item.detections) {
        detection.score = (detection.score * 1000.0).round() / 1000.0;
    }
    set
}

/// Clean and cracked are of one law here, so that their difference is 0 but for chance: over many sets the mean over
/// seeds has none, while the images of all seeds in one ranking have one. There, clean copies tie: n copies of a false
/// detection stand together, and so do those of a true one, whereas cracked ones interleave.
#[test]
fn without_an_effect_the_mean_over_seeds_finds_none_and_one_ranking_does() {
    let n_sets = 40;
    let (mut of_mean, mut of_pool) = (Vec::new(), Vec::new());
    for set in 0..n_sets {
        let (clean, cracked) = sides(0.0, set * 1000);
        let clean = rounded(clean);
        let cracked: Vec<Vec<ImageMatches>> = cracked.into_iter().map(rounded).collect();
        let one = |matches: &[ImageMatches]| pooled(&[matches]);
        let mean = cracked.iter().map(|it| one(it)).sum::<f64>() / N_SEEDS as f64;
        of_mean.push(mean - one(&clean));
        let copies = vec![clean.as_slice(); N_SEEDS];
        let cracked: Vec<&[ImageMatches]> = cracked.iter().map(Vec::as_slice).collect();
        of_pool.push(pooled(&cracked) - pooled(&copies));
    }
    let in_errors = |values: &[f64]| {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|it| (it - mean).powi(2)).sum();
        mean / (squares / (n - 1.0) / n).sqrt()
    };
    let (mean, pool) = (in_errors(&of_mean), in_errors(&of_pool));
    assert!(mean.abs() < 3.0, "the mean over seeds is {mean} errors off");
    assert!(pool < -3.0, "one ranking is {pool} errors off");
    let found = |set: &[ImageMatches]| {
        let detections = set.iter().flat_map(|item| &item.detections);
        detections
            .filter(|it| matches!(it.outcome, Outcome::TruePositive { .. }))
            .count()
    };
    let (clean, _) = sides(0.0, 0);
    assert!(found(&clean) > 50, "a population that is seen");
}
