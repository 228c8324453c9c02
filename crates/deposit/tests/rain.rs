//! Rain against closed forms and balances.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};

use starbreak_deposit::{Area, Cap, Outline, Rain, Shower};
use starbreak_seed::Seed;

const AREA: Area = Area::rectangle([-150.0, 20.0], [150.0, 220.0]);

fn rain(mm_h: f64) -> Rain {
    Rain {
        rate_m_s: mm_h * 1e-3 / 3600.0,
        ..Rain::default()
    }
}

/// On level ground, at rest.
fn level(mm_h: f64, age_s: f64) -> Rain {
    Rain {
        speed_m_s: 0.0,
        slope_rad: 0.0,
        age_s,
        ..rain(mm_h)
    }
}

#[test]
fn a_cap_has_the_volume_of_its_sphere() {
    for degrees in [20.0_f64, 50.0, 90.0, 110.0] {
        let cap = Cap {
            at_mm: [0.0; 2],
            radius_mm: 1.5,
            contact_rad: degrees.to_radians(),
            outline: Outline::default(),
        };
        // π h² (3 R − h)/3 of the sphere and the height.
        let (sphere, height) = (cap.sphere_mm(), cap.height_mm());
        let expected = PI * height * height * (3.0 * sphere - height) / 3.0;
        assert!(
            (cap.volume_mm3() / expected - 1.0).abs() < 1e-12,
            "{degrees}"
        );
        let again = Cap::of_volume([0.0; 2], expected, cap.contact_rad);
        assert!((again.radius_mm - 1.5).abs() < 1e-12, "{degrees}");
    }
}

#[test]
fn level_glass_gets_the_rain_that_falls() {
    for mm_h in [1.0, 5.0, 25.0, 100.0] {
        let found = level(mm_h, 1.0).water_m_s() * 3.6e6;
        assert!((found / mm_h - 1.0).abs() < 0.2, "{mm_h} mm/h: {found}");
    }
}

#[test]
fn drops_hold_the_water_that_fell() {
    // Over many drops, all of which stay.
    let rain = level(10.0, 60.0);
    let large = Area::rectangle([0.0; 2], [1000.0; 2]);
    let deposit = rain.on_pane(&large, Seed(1));
    let found = deposit.water_m(&large);
    let fell = rain.water_m_s() * rain.age_s;
    assert!((found / fell - 1.0).abs() < 0.05, "{found} of {fell} m");
}

#[test]
fn as_many_drops_land_as_the_law_says() {
    let rain = Rain {
        age_s: 0.5,
        ..rain(7.6)
    };
    let expected = rain.impacts_per_m2_s() * rain.age_s * AREA.area_m2();
    // Few have merged yet.
    let n: usize = (0..20)
        .map(|seed| rain.on_pane(&AREA, Seed(seed)).caps.len())
        .sum();
    let found = n as f64 / 20.0;
    assert!(
        (found / expected - 1.0).abs() < 0.05,
        "{found}, not {expected}"
    );
}

#[test]
fn a_drop_runs_where_gravity_exceeds_what_holds_it() {
    // By bisection of m g sin α − 2 r γ (cos θ_r − cos θ_a), with the volume of a sphere's cap.
    for (contact, slope) in [(50.0_f64, 30.0_f64), (90.0, 90.0), (30.0, 60.0)] {
        let rain = Rain {
            contact_rad: contact.to_radians(),
            slope_rad: slope.to_radians(),
            ..rain(5.0)
        };
        let (mut low, mut high) = (0.01, 100.0);
        for _ in 0..60 {
            let r = 0.5 * (low + high);
            let (sphere, height) = (
                r / contact.to_radians().sin(),
                r * (contact / 2.0).to_radians().tan(),
            );
            let mass = 998.0e-9 * PI * height * height * (3.0 * sphere - height) / 3.0;
            let pulls = mass * 9.81 * slope.to_radians().sin();
            let grip = (contact - 15.0).to_radians().cos() - (contact + 15.0).to_radians().cos();
            let holds = 2.0 * r * 1e-3 * 0.0728 * grip;
            if pulls > holds { high = r } else { low = r }
        }
        let found = rain.runs_from_mm();
        assert!(
            (found / low - 1.0).abs() < 0.02,
            "{contact}: {found}, not {low}"
        );
    }
    assert!(
        level(1.0, 1.0).runs_from_mm().is_infinite(),
        "on level glass none runs"
    );
    // 7.9 γ/(ρ U²) of a height of 1 mm: 22 m/s.
    let rain = Rain {
        speed_m_s: 21.9,
        contact_rad: FRAC_PI_2,
        ..rain(1.0)
    };
    assert!(
        (rain.driven_from_mm() - 1.0).abs() < 0.01,
        "{}",
        rain.driven_from_mm()
    );
}

#[test]
fn no_drop_touches_another_and_none_that_stays_is_too_heavy() {
    let rain = Rain {
        age_s: 30.0,
        ..rain(25.0)
    };
    let caps = rain.on_pane(&AREA, Seed(3)).caps;
    assert!(caps.len() > 300, "{}", caps.len());
    let mut n_touching = 0;
    for (k, a) in caps.iter().enumerate() {
        for b in &caps[k + 1..] {
            let apart = (a.at_mm[0] - b.at_mm[0]).hypot(a.at_mm[1] - b.at_mm[1]);
            n_touching += usize::from(apart < a.radius_mm + b.radius_mm);
        }
    }
    // Those that were just left behind by one that ran.
    assert!(
        n_touching * 50 < caps.len(),
        "{n_touching} of {}",
        caps.len()
    );
    // Those alone move that began to in the last seconds.
    let moves_from = rain.runs_from_mm().min(rain.driven_from_mm());
    let n_moving = caps.iter().filter(|cap| cap.radius_mm > moves_from).count();
    assert!(n_moving * 100 < caps.len(), "{n_moving} of {}", caps.len());
}

#[test]
fn a_pane_fills_until_as_much_runs_off_as_falls() {
    let mean_at = |age_s: f64| {
        let rain = Rain {
            age_s,
            ..rain(50.0)
        };
        let all = (0..6).map(|seed| rain.on_pane(&AREA, Seed(seed)).coverage(&AREA));
        all.sum::<f64>() / 6.0
    };
    let [early, late, latest] = [1.0, 30.0, 60.0].map(mean_at);
    assert!(early < 0.6 * late, "it fills: {early}, {late}");
    assert!(
        (late / latest - 1.0).abs() < 0.15,
        "and no more: {late}, {latest}"
    );
}

#[test]
fn wind_drives_large_drops_up_and_leaves_small_ones() {
    // Wind moves drops from 1.7 mm on, gravity from 0.4 mm.
    let rain = Rain {
        contact_rad: 110.0_f64.to_radians(),
        hysteresis_rad: 1.0_f64.to_radians(),
        age_s: 10.0,
        ..rain(10.0)
    };
    let [driven, runs] = [rain.driven_from_mm(), rain.runs_from_mm()];
    assert!(driven > 3.0 * runs, "{driven} {runs}");
    let caps = rain.on_pane(&AREA, Seed(2)).caps;
    let n_heavy = caps.iter().filter(|cap| cap.radius_mm > runs).count();
    assert!(
        n_heavy * 20 < caps.len(),
        "{n_heavy} of {} should run down",
        caps.len()
    );
}

#[test]
fn severities_cover_what_was_expected_of_them() {
    // Shares of the pane that an estimate without merging had: 0.9, 3.6, 8, 17, 26 %.
    let expected = [0.009, 0.036, 0.08, 0.17, 0.26];
    let cases = [(1.0, 2.0), (2.5, 4.0), (7.6, 4.0), (25.0, 4.0), (50.0, 4.0)];
    for ((mm_h, age_s), expected) in cases.into_iter().zip(expected) {
        let rain = Rain {
            age_s,
            ..rain(mm_h)
        };
        let all = (0..8).map(|seed| rain.on_pane(&AREA, Seed(seed)).coverage(&AREA));
        let found = all.sum::<f64>() / 8.0;
        assert!(
            (found / expected - 1.0).abs() < 0.3,
            "{mm_h} mm/h: {found}, not {expected}"
        );
    }
}

#[test]
fn later_is_more_of_the_same() {
    let early = Rain {
        age_s: 0.2,
        ..rain(5.0)
    }
    .on_pane(&AREA, Seed(9));
    let late = Rain {
        age_s: 0.4,
        ..rain(5.0)
    }
    .on_pane(&AREA, Seed(9));
    let n_kept = early
        .caps
        .iter()
        .filter(|cap| late.caps.contains(cap))
        .count();
    assert!(
        n_kept * 10 > early.caps.len() * 9,
        "{n_kept} of {}",
        early.caps.len()
    );
    assert_eq!(
        early,
        Rain {
            age_s: 0.2,
            ..rain(5.0)
        }
        .on_pane(&AREA, Seed(9)),
        "repeats"
    );
    assert_ne!(
        early,
        Rain {
            age_s: 0.2,
            ..rain(5.0)
        }
        .on_pane(&AREA, Seed(10))
    );
    assert!(rain(0.0).on_pane(&AREA, Seed(1)).is_empty(), "no rain");
    assert!(early.caps.first().unwrap().volume_mm3() > 0.0);
}

#[test]
fn drops_that_are_too_small_to_be_seen_are_left_out_with_little_of_the_water() {
    // As before a pane that leans: the lower, the farther away; and one of which next to nothing is seen.
    let seen = AREA.without_smaller([(20.0, 0.05), (220.0, 0.25)]);
    let unseen = AREA.without_smaller([(20.0, 5.0), (220.0, 5.0)]);
    assert!((seen.least_radius_mm(120.0) - 0.15).abs() < 1e-12);
    let rain = rain(7.6);
    let (mut n, mut n_smaller, mut water) = ([0; 3], 0, [0.0; 3]);
    for seed in (0..30).map(Seed) {
        for (k, area) in [AREA, seen, unseen].into_iter().enumerate() {
            let deposit = rain.on_pane(&area, seed);
            n[k] += deposit.caps.len();
            water[k] += deposit.water_m(&area);
            if k == 1 {
                let least_mm = |cap: &Cap| seen.least_radius_mm(cap.at_mm[1]);
                let is_smaller = |cap: &&Cap| cap.radius_mm < 0.98 * least_mm(cap);
                n_smaller += deposit.caps.iter().filter(is_smaller).count();
            }
        }
    }
    let [all, left, few] = n;
    assert!(n_smaller * 100 < left, "{n_smaller} of {left} are smaller");
    assert!(
        left * 10 < all * 8 && few * 2 < all,
        "{left} and {few} of {all} are left"
    );
    let [all, left, few] = water;
    assert!(left / all > 0.99, "{left} m of {all} m");
    assert!((0.985..0.995).contains(&(few / all)), "{few} m of {all} m");
    // The others are the same, whatever is seen.
    let [all, left] = [AREA, seen].map(|area| rain.on_pane(&area, Seed(1)).caps);
    let n_same = left.iter().filter(|cap| all.contains(cap)).count();
    assert!(n_same * 10 > left.len() * 9, "{n_same} of {}", left.len());
}

#[test]
fn what_is_gone_does_not_come_back() {
    // Every tenth of a second of heavy rain, in which drops run down, and of rain at speed, in which they run up.
    for (mm_h, speed_m_s) in [(50.0, 0.0), (25.0, 25.0), (25.0, 40.0)] {
        let (mut last, mut gone) = (BTreeSet::new(), BTreeSet::new());
        for age_s in (10..80).map(|k| f64::from(k) * 0.1) {
            let rain = Rain {
                speed_m_s,
                age_s,
                ..rain(mm_h)
            };
            let caps = rain.on_pane(&AREA, Seed(4)).caps.into_iter();
            let drops: BTreeSet<[u64; 3]> = caps
                .map(|cap| [cap.at_mm[0], cap.at_mm[1], cap.radius_mm].map(f64::to_bits))
                .collect();
            let n_back = gone.intersection(&drops).count();
            assert_eq!(n_back, 0, "come back at {speed_m_s} m/s, {age_s} s");
            gone.extend(last.difference(&drops));
            last = drops;
        }
        assert!(gone.len() > 1000, "{} were taken up", gone.len());
    }
}

#[test]
fn rain_that_goes_on_is_the_rain_of_each_age() {
    // Standing in heavy rain, where drops run down, and at speed, where they run up; at ages of a clip whose frames are shown
    // side by side, and in jumps, one of them back.
    let ages_s = [1.0, 1.033, 1.1, 1.066, 1.7, 4.0, 3.8, 4.033, 2.0, 6.5];
    let mut n_ran = 0;
    for (mm_h, speed_m_s) in [(40.0, 0.0), (25.0, 25.0)] {
        for seed in (0..3).map(Seed) {
            let rain = Rain {
                speed_m_s,
                ..rain(mm_h)
            };
            let mut shower = Shower::of(rain, AREA, seed);
            let mut before = Vec::new();
            for age_s in ages_s {
                let fresh = Rain { age_s, ..rain }.on_pane(&AREA, seed);
                assert!(shower.at(age_s) == fresh, "{mm_h} mm/h at {age_s} s");
                // Some that lay there were taken up.
                n_ran += before
                    .iter()
                    .filter(|cap| !fresh.caps.contains(cap))
                    .count();
                before = fresh.caps;
            }
            assert!(shower.is_of(&Rain { age_s: 9.0, ..rain }, &AREA, seed));
            assert!(!shower.is_of(&rain, &AREA, Seed(77)), "of another seed");
        }
    }
    assert!(n_ran > 1000, "{n_ran} drops were taken up");
}
