//! Precision over recall, and a control that moves.

use super::{alone, in_region, masks, pair_of, said, settings, truth};
use starbreak_eval::evaluation::{EvaluateInput, Group, PairedMetric, Provenance, Scope, Study};
use starbreak_eval::report::html;

#[test]
fn a_curve_has_the_area_that_ap50_is_and_falls() {
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..50);
    let cracked = said(|k| super::hashed(k, 3) > 0.4);
    let one = alone(&truth(), &("star", 1, 7, cracked, &masks), None);
    let scopes: Vec<&Scope> = one.curves.iter().map(|curves| &curves.scope).collect();
    assert_eq!(scopes, [&Scope::whole_image(), &in_region()], "each once");
    for curves in &one.curves {
        let row = pair_of(
            &one.paired,
            &curves.scope,
            &Group::all(),
            PairedMetric::Ap50,
        );
        for (curve, ap50) in [(&curves.clean, &row.clean), (&curves.cracked, &row.cracked)] {
            assert_eq!(curve.len(), 101, "recalls");
            assert!(curve.is_sorted_by(|a, b| a >= b), "falls: {curve:?}");
            let area = curve.iter().sum::<f64>() / 101.0;
            assert!(
                (area - ap50.value.unwrap()).abs() < 1e-12,
                "{area} {ap50:?}"
            );
        }
    }
}

#[test]
fn half_of_each_class_found_without_an_error_is_a_step_at_one_half() {
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..50);
    let mut cracked = said(|k| k % 2 == 0);
    let items = &mut cracked.detections.items;
    items.retain(|one| one.box_px.corners() == super::BOX);
    let one = alone(&truth(), &("star", 1, 7, cracked, &masks), None);
    let curve = &one.curves[0].cracked;
    let step: Vec<f64> = (0..=100).map(|r| f64::from(u8::from(r <= 50))).collect();
    assert_eq!(*curve, step);
}

#[test]
fn the_curves_of_seeds_are_one_whose_area_is_their_ap50() {
    let folder = tempfile::tempdir().unwrap();
    let (masks, truth) = (masks(&folder.path().join("m"), 0..50), truth());
    let cells = [7, 8].map(|seed| {
        let found =
            said(|k| super::hashed(k, 3 + u32::try_from(seed).unwrap()) > 0.05 * seed as f64);
        ("star", 1, seed, found, masks.as_path())
    });
    let (evaluations, means) = super::all(&truth, &cells);
    let pooled = means.over_seeds();
    let everywhere = Scope::whole_image();
    let [all, first] = [&pooled[0].paired, &evaluations[0].paired].map(|rows| {
        let row = pair_of(rows, &everywhere, &Group::all(), PairedMetric::Ap50);
        format!("{:.1}", 100.0 * row.cracked.value.unwrap())
    });
    assert_ne!(all, first, "seeds differ");
    let mut study = Study::of_one(evaluations[0].clone(), "made-up", Provenance::default());
    (study.evaluations, study.over_seeds) = (evaluations, pooled);
    let page = html(&study).unwrap();
    let key = format!("star, severity 1, 2 seeds: AP50 {all} %");
    assert!(page.contains(&key), "{key}");
}

#[test]
fn a_control_that_moves_is_told_and_one_that_does_not_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..30);
    let is_told = |is_found: &dyn Fn(u32) -> bool, has_regions: bool| {
        let cracked = said(is_found);
        let cell = ("star", 1, 7, cracked, masks.as_path());
        let one = match has_regions {
            true => alone(&truth(), &cell, None),
            false => {
                let (condition, clean) = (super::condition(&cell), said(|_| true));
                let (truth, settings) = (truth(), settings());
                let input = EvaluateInput {
                    regions: None,
                    ..super::input(&truth, (&cell, &condition), &clean, &settings)
                };
                super::evaluated(&input)
            }
        };
        let mut texts = one.warnings.iter().map(ToString::to_string);
        texts.any(|text| text.contains("outside the region (τ = 0.05)"))
    };
    let outside = |k: u32| k < 30 || super::hashed(k, 3) > 0.5;
    let inside = |k: u32| k >= 30 || super::hashed(k, 3) > 0.5;
    assert!(is_told(&outside, true), "lost outside");
    assert!(!is_told(&inside, true), "lost inside");
    assert!(!is_told(&|k| k != 40, true), "one object of thirty");
    assert!(
        !is_told(&outside, false),
        "without regions there is no control"
    );
}

#[test]
fn every_family_has_its_curve() {
    let folder = tempfile::tempdir().unwrap();
    let masks = masks(&folder.path().join("m"), 0..50);
    let cracked = said(|k| super::hashed(k, 3) > 0.4);
    let one = alone(&truth(), &("star", 1, 7, cracked, &masks), None);
    let mut study = Study::of_one(one.clone(), "made-up", Provenance::default());
    let of_family = |k: u32| {
        let mut one = one.clone();
        one.condition.family = Some(format!("family {k}"));
        one.condition.name = format!("family {k}, severity 1, seed 7");
        one
    };
    study.evaluations = (0..9).map(of_family).collect();
    let page = html(&study).unwrap();
    for k in 0..9 {
        let key = format!("family {k}, severity 1, seed 7: AP50 ");
        assert!(page.contains(&key), "{key}");
    }
}
