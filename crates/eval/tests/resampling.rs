//! The bootstrap and the permutation test, where the answer is known.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use starbreak_eval::resampling::{
    Basis, Plan, bootstrap, paired_average_precision, permutation_test, rank_by_category,
};
use starbreak_eval::statistic::Method;
use starbreak_eval::{ImageMatches, MatchedDetection, MatchedObject, Outcome, RankedMatches};

fn unit(stream: &mut ChaCha8Rng) -> f64 {
    f64::from(stream.next_u32()) / 4_294_967_296.0
}

/// Matches of one category in `n_images` images, with ties of scores, ignored detections and images
/// without objects.
fn matches(seed: u64, n_images: u32, found: f64) -> Vec<ImageMatches> {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    let mut places = ChaCha8Rng::seed_from_u64(99);
    let mut n = 0;
    (0..n_images)
        .map(|image| {
            let mut detections = Vec::new();
            let mut objects = Vec::new();
            let score = |stream: &mut ChaCha8Rng| (unit(stream) * 20.0).floor() / 20.0;
            for _ in 0..places.next_u32() % 5 {
                n += 1;
                let is_found = unit(&mut stream) < found;
                if is_found {
                    detections.push(MatchedDetection {
                        detection: n,
                        score: score(&mut stream).sqrt(),
                        outcome: Outcome::TruePositive {
                            object: n,
                            iou: 0.7,
                        },
                    });
                }
                objects.push(MatchedObject {
                    object: n,
                    is_ignored: false,
                    detection: is_found.then_some(n),
                });
            }
            for _ in 0..stream.next_u32() % 4 {
                let outcome = if stream.next_u32().is_multiple_of(5) {
                    Outcome::Ignored
                } else {
                    Outcome::FalsePositive
                };
                detections.push(MatchedDetection {
                    detection: 0,
                    score: score(&mut stream),
                    outcome,
                });
            }
            detections.sort_by(|a, b| b.score.total_cmp(&a.score));
            ImageMatches {
                image,
                category: 0,
                detections,
                objects,
            }
        })
        .collect()
}

#[test]
fn weights_of_one_give_the_protocols_average_precision_to_the_last_bit() {
    for seed in 0..20 {
        let matches = matches(seed, 40, 0.6);
        let ranked = &rank_by_category(&matches, 1)[0];
        let expected = RankedMatches::of(&matches);
        let ones = vec![1; 40];
        let found = ranked.average_precision(&ones);
        let same = expected.average_precision(&ones);
        assert!(found.is_some(), "there are objects");
        assert_eq!(
            found.map(f64::to_bits),
            same.map(f64::to_bits),
            "seed {seed}"
        );
        let weights = Plan::of_images(40).with(1, seed, 0.95).weights(0);
        assert_eq!(
            ranked.average_precision(&weights).map(f64::to_bits),
            expected.average_precision(&weights).map(f64::to_bits),
            "drawn with seed {seed}"
        );
    }
}

#[test]
fn a_lone_true_positive_is_not_quite_a_precision_of_one() {
    // 1 / (1 + 2^-52), as in pycocotools.
    let lone = [ImageMatches {
        image: 0,
        category: 0,
        detections: vec![MatchedDetection {
            detection: 0,
            score: 0.5,
            outcome: Outcome::TruePositive {
                object: 0,
                iou: 0.7,
            },
        }],
        objects: vec![MatchedObject {
            object: 0,
            is_ignored: false,
            detection: Some(0),
        }],
    }];
    let found = rank_by_category(&lone, 1)[0].average_precision(&[1]);
    assert_eq!(
        found,
        RankedMatches::of(&lone).average_precision(&[1]),
        "as in the protocol"
    );
    assert!(
        found.is_some_and(|it| it < 1.0 && it > 0.999_999),
        "{found:?}"
    );
    let twice = rank_by_category(&lone, 1)[0].average_precision(&[2]);
    assert_eq!(twice, Some(1.0), "2 of 2 are");
}

#[test]
fn an_image_drawn_twice_counts_as_two_images() {
    let matches = matches(4, 30, 0.6);
    let weights = Plan::of_images(30).with(1, 8, 0.95).weights(0);
    let mut copies = Vec::new();
    for (item, weight) in matches.iter().zip(&weights) {
        for _ in 0..*weight {
            let mut copy = item.clone();
            // Scores that differ by image, so that copies stand beside each other.
            for detection in &mut copy.detections {
                detection.score += f64::from(item.image) * 1e-6;
            }
            copy.image = u32::try_from(copies.len()).unwrap_or(u32::MAX);
            copies.push(copy);
        }
    }
    let mut apart = matches;
    for item in &mut apart {
        for detection in &mut item.detections {
            detection.score += f64::from(item.image) * 1e-6;
        }
    }
    let weighted = rank_by_category(&apart, 1)[0].average_precision(&weights);
    let copied = rank_by_category(&copies, 1)[0].average_precision(&vec![1; copies.len()]);
    let (weighted, copied) = (weighted.unwrap_or(-1.0), copied.unwrap_or(-2.0));
    // Equal scores within one image come in another order in copies, which moves a step of the curve.
    assert!(
        (weighted - copied).abs() < 2e-3,
        "{weighted} for {copied}: as if it were there twice"
    );
}

#[test]
fn without_objects_or_weights_there_is_no_average_precision() {
    let matches = matches(1, 10, 0.5);
    let ranked = &rank_by_category(&matches, 2);
    assert_eq!(ranked[0].average_precision(&[1; 9]), None, "weights lack");
    assert_eq!(ranked[0].average_precision(&[0; 10]), None, "no objects");
    assert_eq!(ranked[1].average_precision(&[1; 10]), None, "no category");
}

#[test]
fn draws_have_the_number_of_units_and_repeat() {
    let plan = Plan::of_images(500).with(10, 7, 0.95);
    let first = plan.weights(3);
    assert_eq!(first.iter().sum::<u32>(), 500, "500 of 500");
    assert_eq!(first, plan.weights(3), "the same again");
    assert_ne!(first, plan.weights(4), "another replicate");
    let other = plan.clone().with(10, 8, 0.95);
    assert_ne!(first, other.weights(3), "another seed");
    // Poisson with mean 1: a share of 1/e is not drawn.
    let n_zero: usize = (0..10)
        .map(|k| plan.weights(k).iter().filter(|it| **it == 0).count())
        .sum();
    assert!((1750..1930).contains(&n_zero), "{n_zero} of 5000 are 0");
}

#[test]
fn draws_are_the_same_on_every_platform_and_in_every_version() {
    let plan = Plan::of_images(12).with(1, 7, 0.95);
    assert_eq!(
        plan.weights(0),
        [2, 1, 0, 0, 1, 3, 2, 0, 0, 0, 1, 2],
        "first draw of seed 7"
    );
}

#[test]
fn images_of_a_cluster_are_drawn_together() {
    let clusters = [Some("a"), None, Some("b"), Some("a"), None, Some("b")];
    let plan = Plan::of_clusters(&clusters).with(50, 1, 0.95);
    assert_eq!(plan.n_units(), 4, "two clusters and two lone images");
    let mut n_alone = 0;
    for k in 0..50 {
        let images = plan.weights(k);
        assert_eq!(images[0], images[3], "cluster a");
        assert_eq!(images[2], images[5], "cluster b");
        n_alone += usize::from(images[1] != images[4]);
    }
    assert!(n_alone > 10, "images without a cluster go alone");
}

#[test]
fn the_mean_of_a_linear_statistic_over_draws_is_that_of_the_sample() {
    let values: Vec<f64> = (0..50).map(|k| f64::from(k * k % 37)).collect();
    let mean = values.iter().sum::<f64>() / 50.0;
    let spread = (values.iter().map(|it| (it - mean).powi(2)).sum::<f64>() / 50.0).sqrt();
    let plan = Plan::of_images(50).with(20_000, 3, 0.95);
    let replicates = bootstrap(&plan, |weights| {
        let sum: f64 = values
            .iter()
            .zip(weights)
            .map(|(it, weight)| it * f64::from(*weight))
            .sum();
        vec![Some(sum / 50.0)]
    });
    let values: Vec<f64> = replicates
        .as_ref()
        .map(|it| it.values[0].iter().copied().flatten().collect())
        .unwrap_or_default();
    assert_eq!(values.len(), 20_000, "all replicates");
    let of_draws = values.iter().sum::<f64>() / 20_000.0;
    let error = spread / 50_f64.sqrt();
    assert!(
        (of_draws - mean).abs() < 5.0 * error / 20_000_f64.sqrt(),
        "mean {of_draws} of {mean}"
    );
    let variance = values.iter().map(|it| (it - of_draws).powi(2)).sum::<f64>() / 20_000.0;
    assert!(
        (variance.sqrt() / error - 1.0).abs() < 0.03,
        "standard error {} of {error}",
        variance.sqrt()
    );
}

#[test]
fn intervals_of_a_share_hold_it_as_often_as_they_say() {
    let mut stream = ChaCha8Rng::seed_from_u64(5);
    let (n_trials, n) = (600_u32, 80_u32);
    let (mut n_percentile, mut n_expanded) = (0_u32, 0_u32);
    for trial in 0..n_trials {
        let sample: Vec<bool> = (0..n).map(|_| unit(&mut stream) < 0.3).collect();
        let plan = Plan::of_images(n).with(400, u64::from(trial), 0.9);
        let replicates = bootstrap(&plan, |weights| {
            let hits: u32 = sample
                .iter()
                .zip(weights)
                .map(|(hit, weight)| u32::from(*hit) * weight)
                .sum();
            let n: u32 = weights.iter().sum();
            vec![Some(f64::from(hits) / f64::from(n))]
        });
        let Ok(replicates) = replicates else {
            continue;
        };
        let holds = |interval: Option<starbreak_eval::statistic::Interval>| {
            u32::from(interval.is_some_and(|it| it.low <= 0.3 && 0.3 <= it.high))
        };
        n_percentile += holds(replicates.percentile(0, Method::Share).interval);
        let expanded = replicates.expanded(0, Method::Share, Basis::Units(n));
        n_expanded += holds(expanded.interval);
    }
    for (name, n_held) in [("percentile", n_percentile), ("expanded", n_expanded)] {
        let coverage = f64::from(n_held) / f64::from(n_trials);
        // 0.9, less a little for 80 units; three standard errors of 600 trials are 0.037.
        assert!(
            (0.85..0.94).contains(&coverage),
            "{name} intervals of 90 % held {coverage}"
        );
    }
}

/// An interval of no width would claim that nothing else can be.
#[test]
fn what_no_draw_changes_and_what_few_units_give_has_no_interval() {
    let reason = |plan: &Plan, statistic: &(dyn Fn(u32) -> f64 + Sync)| {
        let replicates = bootstrap(plan, |weights| vec![Some(statistic(weights[0]))]);
        let Ok(replicates) = replicates else {
            panic!("the plan is fine");
        };
        let measured = replicates.percentile(0, Method::Mean);
        assert!(measured.value.is_some(), "the value itself stays");
        (measured.interval, measured.reason.unwrap_or_default())
    };
    let constant = |_| 0.0;
    let varying = |weight: u32| f64::from(weight);
    let many = Plan::of_images(30).with(200, 1, 0.95);
    let (interval, why) = reason(&many, &constant);
    assert!(interval.is_none() && why.contains("the same"), "{why}");
    assert!(reason(&many, &varying).0.is_some(), "what varies has one");
    let few = Plan::of_clusters(&[Some("a"), Some("a"), Some("b"), Some("c")]).with(200, 1, 0.95);
    let (interval, why) = reason(&few, &varying);
    assert!(
        interval.is_none() && why.contains("3 resampling units"),
        "{why}"
    );
}

#[test]
fn a_statistic_that_most_draws_leave_undefined_has_no_interval() {
    let plan = Plan::of_images(10).with(100, 0, 0.95);
    let replicates = bootstrap(&plan, |weights| {
        // Defined with image 0 only, in some 65 % of the draws.
        vec![(weights[0] > 0).then_some(1.0), Some(f64::NAN), Some(2.0)]
    });
    let Ok(replicates) = replicates else {
        panic!("the plan is fine");
    };
    let rare = replicates.percentile(0, Method::Mean);
    assert_eq!((rare.value, rare.interval), (Some(1.0), None), "too rare");
    assert!(rare.reason.is_some_and(|it| it.contains("of 100")), "why");
    let nan = replicates.percentile(1, Method::Mean);
    assert_eq!(nan.value, None, "NaN does not leak");
    let constant = replicates.expanded(2, Method::Mean, Basis::Units(10));
    assert!(constant.interval.is_none(), "of a constant");
    assert!(constant.reason.is_some(), "and why not");
    assert!(
        bootstrap(&plan.clone().with(0, 0, 0.95), |_| vec![]).is_err(),
        "none"
    );
    assert!(
        bootstrap(&plan.with(10, 0, 1.0), |_| vec![]).is_err(),
        "level"
    );
}

/// Mean of differences, some of them turned around.
fn mean_difference<'a>(
    differences: &'a [f64],
) -> impl Fn(&[u32]) -> Vec<Option<f64>> + Sync + use<'a> {
    |roles| {
        let signed = differences
            .iter()
            .zip(roles)
            .map(|(it, role)| if *role == 0 { *it } else { -it });
        vec![Some(signed.sum::<f64>() / differences.len() as f64)]
    }
}

/// Two-sided p over all signs, by hand.
fn enumerated(differences: &[f64]) -> f64 {
    let n = u32::try_from(differences.len()).unwrap_or(0);
    let observed = differences.iter().sum::<f64>().abs();
    let far = (0..1_u32 << n).filter(|signs| {
        let sum: f64 = differences
            .iter()
            .enumerate()
            .map(|(k, it)| if signs >> k & 1 == 1 { -it } else { *it })
            .sum();
        sum.abs() >= observed - 1e-12
    });
    far.count() as f64 / f64::from(1_u32 << n)
}

#[test]
fn p_of_few_units_is_exact_and_that_of_many_close_to_it() {
    let differences = [
        0.4, -0.1, 0.3, 0.2, 0.5, -0.2, 0.1, 0.35, 0.6, 0.15, -0.3, 0.25,
    ];
    let few = &differences[..8];
    let plan = Plan::of_images(8);
    let tests = permutation_test(&plan, mean_difference(few)).unwrap_or_default();
    assert_eq!(
        tests[0].test.method,
        Method::PermutationExact,
        "2^8 are gone through"
    );
    assert_eq!(tests[0].test.p, Some(enumerated(few)), "exact p");
    let plan = Plan::of_images(12).with(20_000, 1, 0.95);
    let tests = permutation_test(&plan, mean_difference(&differences)).unwrap_or_default();
    let (found, exact) = (tests[0].test.p.unwrap_or(-1.0), enumerated(&differences));
    assert_eq!(
        tests[0].test.method,
        Method::PermutationSampled,
        "2^12 are not"
    );
    let error = (exact * (1.0 - exact) / 20_000.0).sqrt();
    assert!((found - exact).abs() < 4.0 * error, "p {found} of {exact}");
}

#[test]
fn p_is_uniform_where_nothing_differs() {
    let mut stream = ChaCha8Rng::seed_from_u64(11);
    let mut n_below = 0;
    for trial in 0..400 {
        let differences: Vec<f64> = (0..20)
            .map(|_| unit(&mut stream) - unit(&mut stream))
            .collect();
        let plan = Plan::of_images(20).with(199, trial, 0.95);
        let tests = permutation_test(&plan, mean_difference(&differences)).unwrap_or_default();
        n_below += u32::from(tests[0].test.p.is_some_and(|p| p <= 0.1));
    }
    // 40 expected, standard deviation 6.
    assert!((22..=58).contains(&n_below), "{n_below} of 400 below 0.1");
}

#[test]
fn swapping_clean_and_cracked_negates_every_difference() {
    let (clean, cracked) = (matches(1, 60, 0.8), matches(2, 60, 0.5));
    let plan = Plan::of_images(60).with(200, 5, 0.95);
    let there = paired_average_precision(&[&clean], &[&cracked], 1, &plan);
    let back = paired_average_precision(&[&cracked], &[&clean], 1, &plan);
    let (Ok(there), Ok(back)) = (there, back) else {
        panic!("the plan fits");
    };
    let (a, b) = (&there.categories[0], &back.categories[0]);
    assert_eq!(
        a.difference.value,
        b.difference.value.map(|it| -it),
        "difference"
    );
    let ends = |it: &starbreak_eval::statistic::Measured| it.interval.map(|it| [it.low, it.high]);
    let turned = ends(&b.difference).map(|[low, high]| [-high, -low]);
    let same = ends(&a.difference)
        .zip(turned)
        .is_some_and(|(a, b)| (a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12);
    assert!(same, "{:?} and {turned:?}", ends(&a.difference));
    assert_eq!(a.test.p, b.test.p, "two-sided p");
    assert!(
        a.difference.value.is_some_and(|it| it < -0.1),
        "it is worse"
    );
    assert!(a.test.p.is_some_and(|p| p < 0.02), "surely: {:?}", a.test);
    let equal = paired_average_precision(&[&clean], &[&clean], 1, &plan);
    let equal = equal.map(|it| it.categories[0].clone());
    assert!(
        equal.as_ref().is_ok_and(|it| it.test.p == Some(1.0)),
        "nothing differs from itself: {equal:?}"
    );
    assert_eq!(
        there.mean.difference.value, a.difference.value,
        "mean of one"
    );
}

#[test]
fn a_plan_that_does_not_fit_is_refused() {
    let (clean, cracked) = (matches(1, 40, 0.8), matches(2, 40, 0.5));
    let plan = Plan::of_images(40).with(100, 5, 0.95);
    assert!(
        paired_average_precision(&[&clean, &clean], &[&cracked], 1, &plan).is_err(),
        "one set of cracked matches for two of clean ones"
    );
    assert!(
        paired_average_precision(&[], &[], 1, &plan).is_err(),
        "no set"
    );
    let short = Plan::of_images(39).with(100, 5, 0.95);
    assert!(
        paired_average_precision(&[&clean], &[&cracked], 1, &short).is_err(),
        "an image beyond the plan"
    );
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let (clean, cracked) = (matches(1, 60, 0.8), matches(2, 60, 0.5));
    let plan = Plan::of_images(60).with(100, 5, 0.95);
    let with = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads)
            .build();
        let pool = pool.map_err(|it| it.to_string());
        pool.map(|it| {
            it.install(|| {
                format!(
                    "{:?}",
                    paired_average_precision(&[&clean], &[&cracked], 1, &plan)
                )
            })
        })
    };
    let one = with(1);
    assert!(one.as_ref().is_ok_and(|it| it.starts_with("Ok")), "{one:?}");
    assert_eq!(one, with(4), "one thread and four");
}
