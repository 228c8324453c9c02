//! Outlines against sums over what they hold.
#![expect(clippy::cast_precision_loss, reason = "some places")]

use std::f64::consts::PI;

use starbreak_seed::{Seed, Stream};

use super::*;

fn some_fallen(most: f64) -> Vec<Outline> {
    (0..40)
        .map(|k| Outline::fallen(&Drawn::by(&mut Seed(k).stream(Stream::Rain, 1)), most))
        .collect()
}

/// Places of a fine grid about the middle, and the area of each.
fn places() -> (impl Iterator<Item = [f64; 2]>, f64) {
    let n = 800;
    let place = move |k: i32| (f64::from(k) + 0.5) * 4.0 / f64::from(n) - 2.0;
    let all = (0..n).flat_map(move |y| (0..n).map(move |x| [place(x), place(y)]));
    (all, 16.0 / f64::from(n * n))
}

/// Distance from the middle to the outline at an angle.
fn radius(outline: &Outline, angle: f64) -> f64 {
    let (sin, cos) = libm::sincos(angle);
    let is_outside = |r: &f64| outline.round_place([r * cos, r * sin]).level > 1.0;
    (1..4000_i32)
        .map(|k| 5e-4 * f64::from(k))
        .find(is_outside)
        .unwrap_or(f64::NAN)
}

#[test]
fn drops_that_join_cover_what_they_covered() {
    let discs = [([-0.7, 0.1], 0.5), ([0.3, -0.2], 0.4), ([0.2, 0.95], 0.6)];
    let parts = discs.map(|(at, radius)| (at, radius, Outline::default()));
    let joined = Outline::joined(&parts, f64::INFINITY);
    // Moments about the middle of the area, by places on a grid.
    let is_covered = |[x, y]: [f64; 2]| {
        discs
            .iter()
            .any(|([a, b], r)| (x - a) * (x - a) + (y - b) * (y - b) < r * r)
    };
    let covered: Vec<[f64; 2]> = places().0.filter(|place| is_covered(*place)).collect();
    let each = places().1;
    let n = covered.len() as f64;
    let middle = [0, 1].map(|k| covered.iter().map(|place| place[k]).sum::<f64>() / n);
    let radius = (n * each / PI).sqrt();
    for (k, [a, b]) in (2..).zip(joined.waves) {
        let mut moment = [0.0; 2];
        for place in &covered {
            let z = [0, 1].map(|k| (place[k] - middle[k]) / radius);
            let power = (1..k).fold(z, |power, _| times(power, z));
            moment = [0, 1].map(|k| moment[k] + power[k] * each / (radius * radius) / PI);
        }
        let off = libm::hypot(moment[0] - a, moment[1] - b);
        assert!(off < 2e-3, "{k}: {moment:?} and {a}, {b}");
    }
    // The same one after the other.
    let [first, second, third] = parts;
    let two = Outline::joined(&[first, second], f64::INFINITY);
    let weights = [first.1 * first.1, second.1 * second.1];
    let area = weights[0] + weights[1];
    let at = [0, 1].map(|k| (weights[0] * first.0[k] + weights[1] * second.0[k]) / area);
    let three = Outline::joined(&[(at, area.sqrt(), two), third], f64::INFINITY);
    for (one, other) in three.waves.iter().zip(joined.waves) {
        assert!(libm::hypot(one[0] - other[0], one[1] - other[1]) < 1e-12);
    }
}

#[test]
fn an_outline_keeps_the_area_of_its_circle_and_reaches_as_far_as_it_says() {
    let ran = [1.0, -1.0].map(|goes| Outline::ran(goes, MOST));
    for outline in some_fallen(MOST).into_iter().chain(ran) {
        let covered = places()
            .0
            .filter(|place| outline.round_place(*place).level < 1.0);
        let area = covered.count() as f64 * places().1 / PI;
        assert!((area - 1.0).abs() < 0.01, "{outline:?}: {area}");
        let farthest = (0..90)
            .map(|k| radius(&outline, f64::from(k) * TAU / 90.0))
            .fold(0.0, f64::max);
        assert!(
            farthest <= outline.reach() + 1e-3,
            "{outline:?}: {farthest}"
        );
    }
}

#[test]
fn slopes_are_those_of_the_heights() {
    for outline in some_fallen(MOST) {
        for place in [[0.3, -0.2], [-0.5, 0.6], [0.1, 0.8]] {
            let step = 1e-5;
            let level = |right: f64, down: f64| {
                let there = outline.round_place([place[0] + right, place[1] + down]);
                there.level
            };
            let found = outline.round_place(place);
            let expected = [
                (level(step, 0.0) - level(-step, 0.0)) / (4.0 * step),
                (level(0.0, step) - level(0.0, -step)) / (4.0 * step),
            ];
            for (slope, expected) in found.slope.iter().zip(expected) {
                assert!((slope - expected).abs() < 1e-8);
            }
        }
    }
}

#[test]
fn contact_angles_are_held_and_some_are_near_the_limits() {
    let [receding, contact, advancing] = [35.0_f64, 50.0, 65.0].map(f64::to_radians);
    let most = Outline::most(contact, [receding, advancing]);
    let (mut lowest, mut highest) = (f64::INFINITY, 0.0_f64);
    let ran = [1.0, -1.0].map(|goes| Outline::ran(goes, most));
    let joined = Outline::joined(
        &[
            ([0.0; 2], 1.0, Outline::default()),
            ([1.8, 0.4], 0.9, Outline::default()),
        ],
        most,
    );
    let all = some_fallen(most).into_iter().chain(ran).chain([joined]);
    for outline in all {
        for k in 0..90 {
            let angle = f64::from(k) * TAU / 90.0;
            let r = radius(&outline, angle);
            let (sin, cos) = libm::sincos(angle);
            let [x, y] = outline.round_place([r * cos, r * sin]).slope;
            let angle = libm::atan(libm::hypot(x, y) * libm::tan(contact));
            lowest = lowest.min(angle);
            highest = highest.max(angle);
        }
    }
    assert!((receding..0.85 * contact).contains(&lowest), "{lowest}");
    assert!((1.08 * contact..advancing).contains(&highest), "{highest}");
    // Nothing holds water of one contact angle: its drops are round.
    assert!(Outline::most(contact, [contact, contact]) < 1e-12);
}
