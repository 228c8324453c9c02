//! A wiper on its way over a pane.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::{Area, Coating, Passage};

/// How long a pass takes, s: half of a stroke, which goes there and back. GUESS: 43 strokes a minute, a wiper's lower speed.
const PASS_S: f64 = 0.7;

/// Where it turns, right and down of where the optical axis meets the pane, mm. GUESS: a camera behind the mirror.
const PIVOT_MM: [f64; 2] = [-250.0, 450.0];

/// From lying to the right to the end of its way, rad. GUESS.
const ENDS_RAD: [f64; 2] = [0.0, 1.2 * FRAC_PI_2];

/// Width of the blade with its arm, mm. GUESS.
const WIDTH_MM: f64 = 20.0;

/// Share of the light on it that it sends on: that of black rubber. GUESS.
const SENDS: f64 = 0.02;

/// The film that it leaves breaks up and dries: share of the light that it turns at first, after how long, s, that is 1/e of
/// it, until when it is looked at, s, and by how much light is turned, rad. GUESS.
const FILM: f64 = 0.3;
const FILM_FADES_S: f64 = 0.25;
const FILM_LASTS_S: f64 = 1.0;
const FILM_TURNS_RAD: f64 = 0.04;

/// exp(−`FILM_LASTS_S`/`FILM_FADES_S`).
const FILM_LEFT: f64 = 0.018_315_638_888_734_18;

/// How long a frame is exposed, s: so far it is blurred. GUESS.
const EXPOSED_S: f64 = 0.005;

/// Its edge is no sharper than this, mm: a blade of rubber stands off the pane beside its lip. GUESS.
const EDGE_MM: f64 = 1.5;

/// A wiper as it passes, there or back, and what it leaves for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wiper {
    pivot_mm: [f64; 2],
    is_back: bool,
    /// How long ago it started, and how long it takes, s.
    since_s: f64,
    lasts_s: f64,
    /// Where it is while a frame is exposed, rad from lying to the right upwards.
    at_rad: [f64; 2],
}

/// The passes of a wiper over a pane that is so old: the last one that has begun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pass {
    /// How many have begun.
    pub(crate) number: u64,
    /// From when on what falls behind it stays, and behind the one before it, if there was one, s of the pane's age: as if
    /// all places were passed when the wiper is in the middle of its way.
    pub(crate) began_s: f64,
    pub(crate) before_s: Option<f64>,
    /// Until nothing of it is seen.
    pub(crate) wiper: Option<Wiper>,
}

impl Pass {
    /// Of a wiper that starts each time a pane is so many periods old, from an age on, s; none before it does.
    pub(crate) fn at(age_s: f64, from_age_s: f64, period_s: f64) -> Option<Self> {
        if period_s <= 0.0 {
            return None;
        }
        let strokes = |age_s: f64| (age_s / period_s).floor();
        let n = strokes(age_s) - strokes(from_age_s);
        if n < 1.0 {
            return None;
        }
        let lasts_s = PASS_S.min(0.5 * period_s);
        let there_s = strokes(age_s) * period_s;
        let back_s = there_s + lasts_s;
        let is_back = age_s >= back_s;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "some strokes"
        )]
        let number = 2 * n as u64 - u64::from(!is_back);
        let starts_s = if is_back { back_s } else { there_s };
        let middle_s = 0.5 * lasts_s;
        let before_s = match (is_back, n > 1.0) {
            (true, _) => Some(there_s + middle_s),
            (false, true) => Some(there_s - period_s + lasts_s + middle_s),
            (false, false) => None,
        };
        let since_s = age_s - starts_s;
        let wiper = (since_s < lasts_s + FILM_LASTS_S).then(|| Wiper {
            pivot_mm: PIVOT_MM,
            is_back,
            since_s,
            lasts_s,
            at_rad: [since_s, since_s + EXPOSED_S].map(|since_s| {
                // It starts and stops gently.
                let part = 0.5 - 0.5 * libm::cos(PI * (since_s / lasts_s).min(1.0));
                let part = if is_back { 1.0 - part } else { part };
                ENDS_RAD[0] + part * (ENDS_RAD[1] - ENDS_RAD[0])
            }),
        });
        Some(Self {
            number,
            began_s: starts_s + middle_s,
            before_s,
            wiper,
        })
    }
}

impl Wiper {
    /// The same where the optical axis meets the pane at a place, mm.
    #[must_use]
    pub fn seen_from(mut self, axis_mm: [f64; 2]) -> Self {
        self.pivot_mm = [0, 1].map(|k| self.pivot_mm[k] + axis_mm[k]);
        self
    }

    /// How far a place is from the pivot, mm, and its angle from lying to the right upwards.
    fn polar(&self, at_mm: [f64; 2]) -> (f64, f64) {
        let [right, down] = [0, 1].map(|k| at_mm[k] - self.pivot_mm[k]);
        let far_mm = (right * right + down * down).sqrt();
        (far_mm, libm::atan2(-down, right))
    }

    /// Whether it has not come to the end of its way.
    #[must_use]
    pub fn is_on_its_way(&self) -> bool {
        self.since_s < self.lasts_s
    }

    /// How long ago it came by an angle last, s, in this pass, or on the way there if this is that back.
    fn passed_s(&self, rad: f64) -> Option<f64> {
        let part = ((rad - ENDS_RAD[0]) / (ENDS_RAD[1] - ENDS_RAD[0])).clamp(0.0, 1.0);
        let there_s = self.lasts_s * libm::acos(1.0 - 2.0 * part) / PI;
        let last_s = match self.is_back {
            true if self.lasts_s - there_s <= self.since_s => self.lasts_s - there_s,
            true => there_s - self.lasts_s,
            false => there_s,
        };
        Some(self.since_s - last_s).filter(|ago_s| *ago_s >= 0.0)
    }

    /// Whether some of it, or of what it leaves, may be on an area.
    #[must_use]
    pub fn may_be_on(&self, area: &Area) -> bool {
        let ([left, top], [right, bottom]) = (area.from_mm, area.to_mm);
        let corners = [[left, top], [right, top], [left, bottom], [right, bottom]];
        let corners = corners.map(|corner| self.polar(corner));
        let of = |pick: fn(f64, f64) -> f64, first: f64| {
            corners
                .iter()
                .fold(first, |most, (_, rad)| pick(most, *rad))
        };
        let [least, most] = [of(f64::min, PI), of(f64::max, -PI)];
        if most - least > FRAC_PI_2 {
            // About the pivot, or all around it.
            return true;
        }
        let near_mm = corners
            .iter()
            .fold(f64::INFINITY, |near, (far, _)| near.min(*far));
        // Its sides are no nearer than 0.7 of its corners then.
        let beside = WIDTH_MM / near_mm.max(1.0);
        let [from, to] = self.ends();
        let ago_s = [least, most].map(|rad| self.passed_s(rad).unwrap_or(f64::INFINITY));
        let is_wet = self.is_back || ago_s[0].min(ago_s[1]) < FILM_LASTS_S;
        is_wet || from - beside <= most && to + beside >= least
    }

    /// Where it is while a frame is exposed, the lesser angle first.
    fn ends(&self) -> [f64; 2] {
        let [a, b] = self.at_rad;
        [a.min(b), a.max(b)]
    }

    /// Whether it has come by a place, mm, in this pass.
    #[must_use]
    pub fn has_passed(&self, at_mm: [f64; 2]) -> bool {
        let (_, rad) = self.polar(at_mm);
        match self.is_back {
            true => rad > self.at_rad[0],
            false => rad < self.at_rad[0],
        }
    }
}

impl Coating for Wiper {
    /// Black rubber, for as much of the time as it is there, and behind it a film of water that fades.
    fn passage(&self, at_mm: [f64; 2]) -> Passage {
        let (far_mm, rad) = self.polar(at_mm);
        let covered = match self.is_on_its_way() {
            true => {
                let far_mm = far_mm.max(1e-6);
                let [from, to] = self.ends();
                let way = (to - from).max(EDGE_MM / far_mm);
                let middle = 0.5 * (from + to);
                let half = 0.5 * WIDTH_MM / far_mm;
                let [from, to] = [middle - 0.5 * way, middle + 0.5 * way];
                (((rad + half).min(to) - (rad - half).max(from)) / way).clamp(0.0, 1.0)
            }
            false => 0.0,
        };
        let film = self.passed_s(rad).map_or(0.0, |ago_s| {
            // None is left when it is no longer looked at.
            let is_left = ago_s < FILM_LASTS_S && covered < 1.0;
            let left = is_left.then(|| libm::exp(-ago_s / FILM_FADES_S) - FILM_LEFT);
            (1.0 - covered) * FILM * left.unwrap_or(0.0)
        });
        let sends = 0.5 * SENDS * covered;
        Passage {
            covered,
            direct: [1.0 - covered - film; 3],
            wide: film,
            diffuse: [sends; 3],
            back: [sends; 3],
            ..Passage::CLEAN
        }
    }

    fn even_over_mm(&self) -> f64 {
        EDGE_MM
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [0.0, FILM_TURNS_RAD]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_follow_each_other_there_and_back() {
        assert!(Pass::at(100.0, 0.0, 0.0).is_none(), "no wiper");
        // 4 s old at first, wiped when 5 s, 10 s, … old.
        let at = |age_s: f64| Pass::at(age_s, 4.0, 5.0);
        assert!(at(4.99).is_none(), "not yet");
        for (age_s, number, began_s, before_s, is_on_its_way) in [
            (5.0, 1, 5.35, None, true),
            (5.69, 1, 5.35, None, true),
            (5.71, 2, 6.05, Some(5.35), true),
            (6.41, 2, 6.05, Some(5.35), false),
            (9.99, 2, 6.05, Some(5.35), false),
            (10.1, 3, 10.35, Some(6.05), true),
            (10.8, 4, 11.05, Some(10.35), true),
        ] {
            let pass = at(age_s).unwrap_or_else(|| panic!("{age_s} s: no pass"));
            assert_eq!(pass.number, number, "{age_s} s");
            assert!((pass.began_s - began_s).abs() < 1e-9, "{age_s} s: {pass:?}");
            let before = pass.before_s.zip(before_s);
            assert_eq!(pass.before_s.is_some(), before_s.is_some(), "{age_s} s");
            assert!(
                before.is_none_or(|(a, b)| (a - b).abs() < 1e-9),
                "{age_s} s"
            );
            let wiper = pass.wiper.filter(Wiper::is_on_its_way);
            assert_eq!(wiper.is_some(), is_on_its_way, "{age_s} s");
        }
        // Old already when a clip begins: first when the next period is over.
        assert!(Pass::at(9.9, 7.0, 5.0).is_none(), "in its first period");
        assert!(
            Pass::at(10.1, 7.0, 5.0).is_some_and(|pass| pass.number == 1),
            "then"
        );
        // One that never rests.
        let fast = Pass::at(1.3, 0.0, 0.5);
        assert!(
            fast.is_some_and(|pass| pass.number == 4 && pass.wiper.is_some()),
            "{fast:?}"
        );
    }

    #[test]
    fn a_wiper_passes_each_place_once_on_each_way() {
        let place = [0.0, 0.0];
        let mut passed = Vec::new();
        let (mut most, mut least) = (0.0_f64, 1.0_f64);
        for age_s in (0..1400).map(|ms| f64::from(ms) * 1e-3) {
            let pass = Pass::at(5.0 + age_s, 0.0, 5.0);
            let Some(wiper) = pass.and_then(|pass| pass.wiper) else {
                panic!("{age_s} s: it rests");
            };
            passed.push(wiper.has_passed(place));
            let Passage {
                covered,
                direct,
                wide,
                ..
            } = wiper.passage(place);
            assert!(
                (covered + direct[1] + wide - 1.0).abs() < 1e-12,
                "all or nothing"
            );
            most = most.max(covered);
            least = least.min(covered);
        }
        let turns = passed.windows(2).filter(|two| two[0] != two[1]).count();
        assert_eq!(
            (passed[0], turns),
            (false, 3),
            "passed, not on the way back, passed"
        );
        assert!(most > 0.99 && least < 1e-12, "from {least} to {most}");
    }

    #[test]
    fn the_film_behind_a_wiper_fades() {
        let left = libm::exp(-FILM_LASTS_S / FILM_FADES_S);
        assert!((FILM_LEFT / left - 1.0).abs() < 1e-12, "{FILM_LEFT}");
        let place = [40.0, -20.0];
        let mut last: Option<f64> = None;
        let mut n_films = 0;
        for age_s in (0..300).map(|k| 5.0 + f64::from(k) * 0.01) {
            let wiper = Pass::at(age_s, 0.0, 5.0).and_then(|pass| pass.wiper);
            let film = wiper.map_or(0.0, |it| it.passage(place).wide);
            let is_blade = wiper.is_some_and(|it| it.passage(place).direct[0] + film < 1.0 - 1e-9);
            if let Some(last) = last.filter(|_| !is_blade) {
                let fades = last * libm::exp(-0.01 / FILM_FADES_S);
                assert!(
                    film <= last && film > fades - 0.002,
                    "{age_s} s: {last}, then {film}"
                );
            }
            n_films += u32::from(!is_blade && film > 0.01);
            last = (!is_blade).then_some(film);
        }
        // Some 0.8 s, once cut short by the way back.
        assert!(
            (100..180).contains(&n_films),
            "{n_films} hundredths of a second"
        );
        assert!(
            last.is_some_and(|film| film <= 0.0),
            "then it is dry: {last:?}"
        );
    }

    #[test]
    fn a_wiper_that_is_not_on_an_area_is_nowhere_on_it() {
        let area = Area::rectangle([-130.0, -80.0], [130.0, 60.0]);
        let (mut n_on, mut n_beside) = (0, 0);
        for age_s in (0..300).map(|k| f64::from(k) * 1e-2) {
            let Some(wiper) = Pass::at(5.0 + age_s, 0.0, 5.0).and_then(|pass| pass.wiper) else {
                n_beside += 1;
                continue;
            };
            let along = |k: i32, axis: usize| {
                area.from_mm[axis] + f64::from(k) / 60.0 * area.sides_mm()[axis]
            };
            let is_on = (0..=60).any(|y| {
                (0..=60).any(|x| wiper.passage([along(x, 0), along(y, 1)]).direct[1] < 1.0)
            });
            assert!(!is_on || wiper.may_be_on(&area), "{age_s} s: {wiper:?}");
            n_on += u32::from(is_on);
            n_beside += u32::from(!wiper.may_be_on(&area));
        }
        assert!(
            n_on > 100 && n_beside > 60,
            "{n_on} on it, {n_beside} beside"
        );
    }
}
