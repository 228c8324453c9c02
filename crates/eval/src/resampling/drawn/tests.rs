#![expect(clippy::unwrap_used, reason = "a test may panic")]

use super::*;
use crate::mean_performance::measured_performance;
use crate::resampling::{
    RankedCategory, bootstrap, permutation_test, rank_by_category, rank_versions,
};
use crate::statistic::Measured;
use crate::{MatchedDetection, MatchedObject, Outcome};

const N_IMAGES: u32 = 30;
const N_CATEGORIES: usize = 5;

/// A number from 0 to 1 that looks random, of few different ones so that scores tie.
fn hashed(parts: [u32; 4]) -> f64 {
    let mix = |hash: u32, part: u32| (hash ^ part).wrapping_mul(0x9E37_79B1).rotate_left(15);
    f64::from(parts.into_iter().fold(7, mix) >> 24) / 255.0
}

/// Of a region that is another one in each set: category 3 has objects in one image of it, and in none of the second
/// set, and 4 has none anywhere.
fn matches(set: u32, side: u32) -> Vec<ImageMatches> {
    let at = |image: u32, category: u32| {
        let is_there = match category {
            3 => image == 4 && set != 1,
            4 => false,
            _ => hashed([set, image, category, 1]) > 0.4,
        };
        let detections = (0..4).map(|k| MatchedDetection {
            detection: k,
            score: hashed([side, image, category, k + 2]),
            outcome: match (k, is_there) {
                (0, true) if hashed([set, image, category, 9 + side]) > 0.3 => {
                    Outcome::TruePositive {
                        object: 0,
                        iou: 0.8,
                    }
                }
                (3, _) => Outcome::Ignored,
                _ => Outcome::FalsePositive,
            },
        });
        let mut detections: Vec<MatchedDetection> = detections.collect();
        detections.sort_by(|a, b| b.score.total_cmp(&a.score));
        let object = MatchedObject {
            object: 0,
            is_ignored: !is_there,
            detection: None,
        };
        ImageMatches {
            image,
            category,
            detections,
            objects: vec![object; 1 + (image % 2) as usize],
        }
    };
    let categories = 0..u32::try_from(N_CATEGORIES).unwrap();
    let images = 0..N_IMAGES;
    images
        .flat_map(|image| categories.clone().map(move |category| at(image, category)))
        .collect()
}

/// All sets as they are ranked together: clean, cracked, and both in one.
type Ranked3 = [Vec<RankedCategory>; 3];

fn ranked(set: u32) -> Ranked3 {
    let (clean, cracked) = (matches(set, 0), matches(set, set + 1));
    [
        rank_by_category(&clean, N_CATEGORIES),
        rank_by_category(&cracked, N_CATEGORIES),
        rank_versions(&[&clean, &cracked], N_CATEGORIES),
    ]
}

fn drawn(set: u32, plan: &Plan) -> DrawnPrecisions {
    let (clean, cracked) = (matches(set, 0), matches(set, set + 1));
    DrawnPrecisions::of_matches(&clean, &cracked, N_CATEGORIES, plan).unwrap()
}

#[test]
fn categories_in_runs_are_drawn_as_all_at_once() {
    let plan = Plan::of_images(N_IMAGES).with(20, 3, 0.9);
    let all = [matches(0, 0), matches(0, 1)];
    let of_run = |run: &Range<usize>| {
        let is_in = |it: &&ImageMatches| run.contains(&(it.category as usize));
        Ok((all.each_ref()).map(|side| side.iter().filter(is_in).cloned().collect()))
    };
    let runs = vec![0..1, 1..4, 4..N_CATEGORIES];
    let in_runs = DrawnPrecisions::of_runs(runs, &plan, of_run).unwrap();
    // As texts, in which what is not a number equals itself.
    let texts = [in_runs, drawn(0, &plan)].map(|it| format!("{it:?}"));
    assert!(texts[0] == texts[1], "the same numbers");
}

/// Clean and cracked of a category, or of the mean over those that there are, in one set.
fn value(
    [clean, cracked]: [&[RankedCategory]; 2],
    [as_clean, as_cracked]: [&[u32]; 2],
    category: Option<usize>,
) -> Option<[f64; 2]> {
    let pair = |at: usize| {
        let clean = clean[at].average_precision(as_clean)?;
        Some([clean, cracked[at].average_precision(as_cracked)?])
    };
    if let Some(category) = category {
        return pair(category);
    }
    let all: Vec<[f64; 2]> = (0..N_CATEGORIES).filter_map(pair).collect();
    let mean = |side: usize| all.iter().map(|it| it[side]).sum::<f64>() / all.len() as f64;
    (!all.is_empty()).then(|| [mean(0), mean(1)])
}

/// The mean over sets, all of which are held at once.
fn joint(sets: &[Ranked3], draw: &Draw, category: Option<usize>) -> Option<[f64; 2]> {
    let of_set = |[clean, cracked, both]: &Ranked3| match draw {
        Draw::Weights(weights) => value([clean, cracked], [weights, weights], category),
        Draw::Swaps(swaps) => {
            let (as_clean, as_cracked) = role_weights(swaps);
            value([both, both], [&as_clean, &as_cracked], category)
        }
    };
    let all: Option<Vec<[f64; 2]>> = sets.iter().map(of_set).collect();
    let all = all?;
    let mean = |side: usize| all.iter().map(|it| it[side]).sum::<f64>() / all.len() as f64;
    Some([mean(0), mean(1)])
}

fn bits(measured: &Measured) -> [Option<u64>; 3] {
    let interval = measured.interval;
    let ends = [interval.map(|it| it.low), interval.map(|it| it.high)];
    [measured.value, ends[0], ends[1]].map(|it| it.map(f64::to_bits))
}

/// More than ten units, whose permutations are drawn, and fewer, of which all are gone through.
fn plans() -> [Plan; 2] {
    let names: Vec<String> = (0..N_IMAGES).map(|k| (k % 8).to_string()).collect();
    let names: Vec<Option<&str>> = names.iter().map(|name| Some(name.as_str())).collect();
    [Plan::of_images(N_IMAGES), Plan::of_clusters(&names)].map(|plan| plan.with(60, 3, 0.9))
}

#[test]
fn sets_one_after_the_other_are_to_the_bit_what_all_at_once_are() {
    for (plan, n_sets) in plans().iter().zip([3, 2]) {
        let sets: Vec<Ranked3> = (0..n_sets).map(ranked).collect();
        let mut sum = drawn(0, plan);
        (1..n_sets).for_each(|set| sum.add(&drawn(set, plan)).unwrap());
        let found = sum.measured(plan).unwrap();
        let mut n_undefined = 0;
        for at in (0..N_CATEGORIES).map(Some).chain([None]) {
            let found = at.map_or(&found.mean, |at| &found.categories[at]);
            let three = |draw: &Draw| three_values(joint(&sets, draw, at)).to_vec();
            let weighted = |weights: &[u32]| three(&Draw::Weights(weights.to_vec()));
            let replicates = bootstrap(plan, weighted).unwrap();
            let whole = [
                found.clean.value,
                found.cracked.value,
                found.difference.value,
            ];
            assert_eq!(replicates.whole, whole, "the sample, {at:?}");
            for (side, values) in replicates.values.iter().enumerate() {
                let of_draw = |draw| {
                    three_values(sum.pairs(draw).nth(at.unwrap_or(N_CATEGORIES)).unwrap())[side]
                };
                let drawn: Vec<Option<f64>> = plan.replicate_draws().map(of_draw).collect();
                assert_eq!(values, &drawn, "replicates, {at:?}");
                n_undefined += values.iter().filter(|it| it.is_none()).count();
            }
            for half in plan.half_draws().flat_map(|first| [first, first + 1]) {
                let drawn = sum.pairs(half).nth(at.unwrap_or(N_CATEGORIES)).unwrap();
                assert_eq!(
                    joint(&sets, &plan.draw(half), at),
                    drawn,
                    "half {half}, {at:?}"
                );
            }
            let swapped = |swaps: &[u32]| vec![three(&Draw::Swaps(swaps.to_vec()))[2]];
            let permuted = permutation_test(plan, swapped).unwrap();
            assert_eq!(permuted[0].test, found.test, "test, {at:?}");
            let reach = permuted[0]
                .interval
                .filter(|_| found.difference.interval.is_some());
            assert_eq!(reach, found.difference.interval, "reach, {at:?}");
        }
        assert!(n_undefined > 0, "some draws have none of category 3");
        assert!(
            found.mean.clean.interval.is_some() && found.mean.test.p.is_some(),
            "{found:?}"
        );
    }
}

#[test]
fn mean_performance_of_sets_one_after_the_other_is_to_the_bit_that_of_all_at_once() {
    let [plan, _] = plans();
    // Two kinds, with two seeds each; of the second set category 3 has no object.
    let cells = [0, 0, 1, 1];
    let sets: Vec<Ranked3> = (0..4).map(ranked).collect();
    let means: Vec<DrawnMean> = (0..4).map(|set| drawn(set, &plan).mean()).collect();
    for is_clean_one in [false, true] {
        let found = measured_performance(&means, is_clean_one, &cells, &plan).unwrap();
        let of_cells = |side: usize, draw: &Draw| {
            let of = |set: usize| joint(&sets[set..=set], draw, None).map(|it| it[side]);
            let cell = |k: usize| Some((of(k)? + of(k + 1)?) / 2.0);
            Some((cell(0)? + cell(2)?) / 2.0)
        };
        let values = |draw: &Draw| {
            let clean = match is_clean_one {
                true => joint(&sets[..1], draw, None).map(|it| it[0]),
                false => of_cells(0, draw),
            };
            let cracked = of_cells(1, draw);
            let ratio = |clean: Option<f64>| Some(cracked? / clean.filter(|it| *it > 0.0)?);
            vec![clean, cracked, ratio(clean)]
        };
        let replicates = Replicates::of_draws(&plan, |draw| values(&plan.draw(draw)));
        let logs = permutation_test(&plan, |swaps| {
            let draw = Draw::Swaps(swaps.to_vec());
            let ratio = Some((of_cells(1, &draw), of_cells(0, &draw)));
            vec![ratio.and_then(|(cracked, clean)| Some((cracked? / clean?).ln()))]
        });
        let of_log = logs.unwrap()[0].interval.unwrap();
        let of_ratio = crate::statistic::Interval {
            low: of_log.low.exp(),
            high: of_log.high.exp(),
            ..of_log
        };
        let basis = DrawnMean::basis(&means, &plan);
        let expected = [
            replicates.expanded(0, Method::AveragePrecision, basis),
            replicates.expanded(1, Method::AveragePrecision, basis),
            replicates.expanded_to(2, Method::Ratio, basis, Some(of_ratio)),
        ];
        for (found, expected) in found.iter().zip(&expected) {
            assert!(expected.interval.is_some(), "{expected:?}");
            assert_eq!(bits(found), bits(expected), "{is_clean_one}");
        }
    }
}
