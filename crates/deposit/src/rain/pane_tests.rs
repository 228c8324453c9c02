use starbreak_seed::{Seed, Stream};

use super::*;

/// Upright glass at rest: all runs down.
fn dry() -> Pane {
    let rain = Rain {
        slope_rad: std::f64::consts::FRAC_PI_2,
        speed_m_s: 0.0,
        ..Rain::default()
    };
    Pane::dry(rain, Area::rectangle([0.0; 2], [100.0; 2]))
}

fn lands(pane: &mut Pane, age_s: f64, down_mm: f64, radius_mm: f64) {
    let mut rng = Seed(1).stream(Stream::Rain, 1);
    let landing = Landing {
        at_mm: [50.0, down_mm],
        volume_mm3: pane.volume_mm3(radius_mm),
        drawn: Drawn::by(&mut rng),
    };
    pane.run(age_s);
    pane.lands(age_s, &landing, || rng);
}

#[test]
fn what_lands_meets_a_drop_that_runs_where_it_is_by_then() {
    // It has gone 5 mm of its step of 6.6.
    let mut running = dry();
    lands(&mut running, 0.0, 20.0, 3.0);
    for (lands_mm, n_drops, most_mm) in [
        // Where it was, where it is, and where it comes to.
        (20.0, 2, 25.0),
        (22.5, 1, 25.0),
        (25.5, 1, 25.1),
        (29.0, 2, 25.0),
    ] {
        let mut pane = running.clone();
        lands(&mut pane, 0.05, lands_mm, 0.5);
        let drops = pane.caps(0.05);
        assert_eq!(drops.len(), n_drops, "at {lands_mm} mm: {drops:?}");
        let [_, down_mm] = drops[0].at_mm;
        assert!(
            (24.98..=most_mm + 1e-9).contains(&down_mm),
            "at {lands_mm} mm: the large one is at {down_mm} mm"
        );
        // Whatever comes of them, the water is there: a step later in the large one and in what it left behind.
        pane.run(0.07);
        let drops = pane.caps(0.07);
        let water_mm3: f64 = drops.iter().map(Cap::volume_mm3).sum();
        let fell_mm3 = pane.volume_mm3(3.0) + pane.volume_mm3(0.5);
        assert!(
            (water_mm3 / fell_mm3 - 1.0).abs() < 1e-9,
            "at {lands_mm} mm: {water_mm3} of {fell_mm3} mm³"
        );
    }
}

#[test]
fn of_drops_in_one_column_that_do_not_touch_each_runs_by_itself() {
    // Where the one behind comes to in its step is where the other was when that began, but it has gone on.
    let mut pane = dry();
    lands(&mut pane, 0.0, 10.0, 3.0);
    lands(&mut pane, 0.001, 20.0, 3.0);
    for age_s in (1..=30).map(|k| f64::from(k) * 0.011) {
        pane.run(age_s);
        let drops = pane.caps(age_s).into_iter();
        let large = drops.filter(|cap| cap.radius_mm > 2.0);
        let mut down_mm: Vec<f64> = large.map(|cap| cap.at_mm[1]).collect();
        down_mm.sort_by(f64::total_cmp);
        let ran_mm = [10.0 + 100.0 * age_s, 19.9 + 100.0 * age_s];
        // The one behind takes up what the other leaves.
        let is_there = |(is, be): (&f64, &f64)| (is - be).abs() < 0.2;
        assert!(
            down_mm.len() == 2 && down_mm.iter().zip(&ran_mm).all(is_there),
            "{age_s} s: {down_mm:?} mm, not {ran_mm:?}"
        );
    }
}

#[test]
fn what_lands_where_another_was_taken_up_lies_there_by_itself() {
    // A large drop runs over one that holds, and a third falls where that was, in the same step.
    let mut pane = dry();
    lands(&mut pane, 0.0, 23.6, 0.5);
    lands(&mut pane, 0.001, 20.0, 3.0);
    lands(&mut pane, 0.066, 22.8, 0.6);
    let with_the_first_mm = 3.0046;
    for (age_s, least_mm) in [(0.066, with_the_first_mm), (0.068, 2.9), (0.2, 2.8)] {
        pane.run(age_s);
        let drops = pane.caps(age_s);
        let is_there = |least_mm: f64, most_mm: f64| {
            let mut radii_mm = drops.iter().map(|cap| cap.radius_mm);
            radii_mm.any(|it| (least_mm..most_mm).contains(&it))
        };
        assert!(
            is_there(least_mm, 3.005) && is_there(0.6 - 1e-9, 0.6 + 1e-9),
            "{age_s} s: {drops:?}"
        );
    }
}

#[test]
fn what_is_left_behind_becomes_a_part_of_what_fell_there() {
    // A drop falls right behind one that runs, where that leaves another in the end of its step.
    let mut pane = dry();
    lands(&mut pane, 0.0, 20.0, 3.0);
    lands(&mut pane, 0.05, 19.0, 1.0);
    pane.run(0.6);
    let drops = pane.caps(0.6);
    for (k, one) in drops.iter().enumerate() {
        for other in &drops[..k] {
            let [dx, dy] = [0, 1].map(|k| one.at_mm[k] - other.at_mm[k]);
            let apart = libm::hypot(dx, dy) / (one.radius_mm + other.radius_mm);
            assert!(apart > 1.0, "{one:?} and {other:?} touch");
        }
    }
    let behind = drops.iter().find(|cap| cap.at_mm[1] < 20.5);
    let grew_mm = behind.map_or(0.0, |cap| cap.radius_mm - 1.0);
    assert!(grew_mm > 1e-4, "{drops:?}");
    let water_mm3: f64 = drops.iter().map(Cap::volume_mm3).sum();
    let fell_mm3 = pane.volume_mm3(3.0) + pane.volume_mm3(1.0);
    assert!(
        (water_mm3 / fell_mm3 - 1.0).abs() < 1e-9,
        "{water_mm3} of {fell_mm3} mm³"
    );
}
