//! Dew against drops that grow and merge one by one.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::{FRAC_PI_2, PI};

use starbreak_deposit::{Area, Cap, Condensation, Dew, Field, Outline};
use starbreak_seed::{Seed, Stream, uniform};

/// Hemispheres on a square of side 1, which goes on beyond its border: x, y and volume.
struct Drops(Vec<[f64; 3]>);

impl Drops {
    fn radius(volume: f64) -> f64 {
        (1.5 * volume / PI).cbrt()
    }

    fn of(n: usize, seed: u64) -> Self {
        let mut rng = Seed(seed).stream(Stream::Rain, 0);
        Self(
            (0..n)
                .map(|_| [uniform(&mut rng), uniform(&mut rng), 0.0])
                .collect(),
        )
    }

    /// Adds water, to each as much as its rim takes up, and merges what touches, until nothing does.
    fn grow(&mut self, more: f64) {
        let rims: f64 = self
            .0
            .iter()
            .map(|drop| Self::radius(drop[2]).max(1e-9))
            .sum();
        for drop in &mut self.0 {
            drop[2] += more * Self::radius(drop[2]).max(1e-9) / rims;
        }
        while self.merge() {}
    }

    fn merge(&mut self) -> bool {
        self.0.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let largest = self
            .0
            .iter()
            .map(|drop| Self::radius(drop[2]))
            .fold(0.0, f64::max);
        let mut has_merged = false;
        let mut gone = vec![false; self.0.len()];
        let n = self.0.len();
        for i in 0..n {
            if gone[i] {
                continue;
            }
            for step in 1..n {
                let j = (i + step) % n;
                let [mut dx, mut dy] = [self.0[j][0] - self.0[i][0], self.0[j][1] - self.0[i][1]];
                dx -= dx.round();
                dy -= dy.round();
                if dx.rem_euclid(1.0) > 2.0 * largest {
                    break;
                }
                let reach = Self::radius(self.0[i][2]) + Self::radius(self.0[j][2]);
                if gone[j] || dx * dx + dy * dy >= reach * reach {
                    continue;
                }
                let [a, b] = [self.0[i][2], self.0[j][2]];
                let share = b / (a + b).max(1e-300);
                self.0[i] = [
                    (self.0[i][0] + share * dx).rem_euclid(1.0),
                    (self.0[i][1] + share * dy).rem_euclid(1.0),
                    a + b,
                ];
                gone[j] = true;
                has_merged = true;
            }
        }
        let mut kept = gone.iter();
        self.0.retain(|_| !kept.next().unwrap());
        has_merged
    }

    fn covered(&self) -> f64 {
        self.0
            .iter()
            .map(|drop| PI * Self::radius(drop[2]).powi(2))
            .sum()
    }

    /// Mean radius by the glass that drops cover.
    fn mean_radius(&self) -> f64 {
        let volume: f64 = self.0.iter().map(|drop| drop[2]).sum();
        // Of hemispheres that cover c of the glass with this much water.
        1.5 * volume / self.covered()
    }
}

const N: usize = 4000;

fn dew(film_m: f64) -> Condensation {
    Condensation {
        growth_m_s: film_m,
        age_s: 1.0,
        clears_from_s: f64::INFINITY,
        clears_m_s: 0.0,
        nuclei_per_m2: N as f64,
        contact_rad: FRAC_PI_2,
    }
}

#[test]
fn drops_one_by_one_cover_and_grow_as_the_law_says() {
    let mut drops = Drops::of(N, 5);
    let mut film = 1e-6;
    drops.grow(film);
    let mut found = Vec::new();
    while film < 4e-2 {
        let more = 0.06 * film;
        drops.grow(more);
        film += more;
        found.push((film, drops.covered(), drops.mean_radius()));
    }
    // The exponent of the radius over some of the growth.
    let slope = |from: f64, to: f64| {
        let of: Vec<_> = found
            .iter()
            .filter(|it| (from..to).contains(&it.0))
            .collect();
        let (a, b) = (of.first().unwrap(), of.last().unwrap());
        (b.2 / a.2).ln() / (b.0 / a.0).ln()
    };
    let early = slope(1e-6, 2e-5);
    assert!((early - 1.0 / 3.0).abs() < 0.06, "alone: t^{early}");
    let late = slope(6e-3, 4e-2);
    assert!((late - 1.0).abs() < 0.15, "merging: t^{late}");
    for (film, covered, radius) in &found {
        let law = dew(*film).drops(1.0);
        if *film < 2e-5 {
            assert!(
                (covered / law.covered - 1.0).abs() < 0.15,
                "{film}: {covered} {law:?}"
            );
        } else if *film > 6e-3 {
            assert!((0.48..0.62).contains(covered), "{film}: {covered}");
            assert!(
                (radius / law.radius_m - 1.0).abs() < 0.15,
                "{film}: {radius} {law:?}"
            );
        }
    }
}

/// As dew goes, its drops hold what water is left, none goes before its water has, and their rims stay until they have half
/// of the contact angle, whichever that was.
#[test]
fn dew_that_clears_holds_what_water_is_left() {
    // Drops one by one, of 60°, and such as have merged, of 90°.
    for (degrees, film_m) in [(60.0_f64, 1e-6), (90.0, 1e-2)] {
        let grown = Condensation {
            contact_rad: degrees.to_radians(),
            ..dew(film_m)
        };
        let old = grown.drops(1.0);
        let water_m = |of: &Dew, n_per_m2: f64| {
            let drop = Cap {
                at_mm: [0.0; 2],
                radius_mm: of.radius_m,
                contact_rad: of.contact_rad,
                outline: Outline::default(),
            };
            n_per_m2 * drop.volume_mm3()
        };
        let n_per_m2 = old.covered / (PI * old.radius_m * old.radius_m);
        let (mut last, mut has_pinned, mut has_receded) = (old, false, false);
        for percent in 0..100 {
            let part = 1.0 - 0.01 * f64::from(percent);
            let clearing = Condensation {
                age_s: 1.0 + 1e3 * (1.0 - part),
                clears_from_s: 1.0,
                clears_m_s: 1e-3 * film_m,
                ..grown
            };
            let now = clearing.drops(1.0);
            let left = water_m(&now, n_per_m2) / film_m;
            assert!((left - part).abs() < 1e-9, "{part}: {left} {now:?}");
            let n_now = now.covered / (PI * now.radius_m * now.radius_m);
            assert!(
                (n_now / n_per_m2 - 1.0).abs() < 1e-9,
                "no drop goes: {now:?}"
            );
            assert!(now.radius_m <= last.radius_m, "{part}: {now:?} {last:?}");
            let is_pinned = now.radius_m > 0.999_999 * old.radius_m;
            has_pinned |= is_pinned && part < 0.6;
            has_receded |= now.radius_m < 0.5 * old.radius_m;
            let half = 0.5 * old.contact_rad;
            let is_half = (now.contact_rad / half - 1.0).abs() < 1e-9;
            assert!(is_pinned || is_half, "{part}: {now:?}");
            assert!(now.contact_rad > 0.999_999 * half, "{part}: {now:?}");
            last = now;
        }
        assert!(has_pinned && has_receded, "{degrees}: {last:?}");
        let gone = Condensation {
            age_s: 1e4,
            clears_from_s: 1.0,
            clears_m_s: 1e-3 * film_m,
            ..grown
        };
        assert!(gone.drops(1.0).covered <= 0.0, "{:?}", gone.drops(1.0));
        // Where twice the water was some is left when elsewhere it is gone.
        let half = Condensation {
            age_s: 1001.0,
            ..gone
        };
        assert!(half.drops(1.0).covered < 1e-6 && half.drops(2.0).covered > 0.0);
    }
}

#[test]
fn the_law_is_one_curve() {
    // At the change from one part of it to the other.
    let at = |film: f64| dew(film).drops(1.0);
    let (mut low, mut high) = (1e-9, 1.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if at(middle).covered < 0.55 - 1e-12 {
            low = middle
        } else {
            high = middle
        }
    }
    let (before, after) = (at(low * 0.999_999), at(high * 1.000_001));
    assert!(
        (before.radius_m / after.radius_m - 1.0).abs() < 1e-5,
        "{before:?} {after:?}"
    );
    assert!(at(0.0).covered.abs() < 1e-300, "no water, no dew");
}

#[test]
fn a_field_is_about_one_and_smooth() {
    let area = Area::rectangle([-50.0, 10.0], [350.0, 310.0]);
    let field = Field::over(&area, (40.0, 0.5), (Stream::Condensation, Seed(3)));
    let (mut sum, mut n, mut least, mut most) = (0.0, 0.0, f64::INFINITY, 0.0_f64);
    for y in 0..300 {
        for x in 0..400 {
            let here = field.at([f64::from(x) - 50.0, f64::from(y) + 10.0]);
            let beside = field.at([f64::from(x) - 49.0, f64::from(y) + 10.0]);
            assert!((here - beside).abs() < 0.06, "{x}, {y}");
            (sum, n) = (sum + here, n + 1.0);
            (least, most) = (least.min(here), most.max(here));
        }
    }
    assert!((sum / n - 1.0_f64).abs() < 0.1, "{}", sum / n);
    assert!(
        least >= 0.5 && most <= 1.5 && most - least > 0.4,
        "{least} to {most}"
    );
    assert!(
        (field.at([-1e9, 1e9]) - 1.0).abs() <= 0.5,
        "beyond the area"
    );
}
