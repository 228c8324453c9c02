//! A part of a pane.

use rand_chacha::ChaCha8Rng;
use starbreak_seed::uniform;

/// How often a place is drawn until one is not cut off.
const MOST_DRAWS: u32 = 1000;

/// A part of a pane: a rectangle, of which the upper corners may be cut off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// Upper left corner of the rectangle, mm.
    pub from_mm: [f64; 2],
    /// Its lower right corner, mm.
    pub to_mm: [f64; 2],
    /// How far its upper edge is cut from the left and from the right, mm, and by how much less an edge below it, mm per mm.
    cut_mm: [f64; 2],
    widens: [f64; 2],
    /// Least radius of drops that are seen at its upper edge, mm, and by how much more below it, mm per mm.
    least_mm: f64,
    grows: f64,
    /// Height from which on it is shown, mm, and how much higher up it is as wide as what is shown.
    shown_from_mm: f64,
    run_in_mm: f64,
}

impl Area {
    /// A rectangle between corners, mm.
    #[must_use]
    pub const fn rectangle(from_mm: [f64; 2], to_mm: [f64; 2]) -> Self {
        Self {
            from_mm,
            to_mm,
            cut_mm: [0.0; 2],
            widens: [0.0; 2],
            least_mm: 0.0,
            grows: 0.0,
            shown_from_mm: f64::NEG_INFINITY,
            run_in_mm: 0.0,
        }
    }

    /// Of which frames show only a part: nothing above a height, mm, and at each height no more to the sides than the area has
    /// `run_in_mm` higher up. Drops run down from the rest.
    #[must_use]
    pub fn shown_below(self, from_mm: f64, run_in_mm: f64) -> Self {
        Self {
            shown_from_mm: from_mm,
            run_in_mm,
            ..self
        }
    }

    /// What frames may show of it.
    #[must_use]
    pub fn shown(&self) -> Self {
        let from_mm = self.from_mm[1].max(self.shown_from_mm);
        let below_mm = from_mm - self.run_in_mm - self.from_mm[1];
        let cut_mm = [0, 1].map(|k| self.cut_mm[k] - self.widens[k] * below_mm);
        let cuts = cut_mm.map(|cut_mm| cut_mm > 0.0);
        Self {
            from_mm: [self.from_mm[0], from_mm],
            cut_mm: [0, 1].map(|k| if cuts[k] { cut_mm[k] } else { 0.0 }),
            widens: [0, 1].map(|k| if cuts[k] { self.widens[k] } else { 0.0 }),
            least_mm: self.least_mm + self.grows * (from_mm - self.from_mm[1]),
            run_in_mm: 0.0,
            ..*self
        }
    }

    /// Without drops that are too small to be seen: the least radius that is, mm, at two heights, mm; in between and beyond them
    /// it lies on a straight line, as distance from a camera does.
    #[must_use]
    pub fn without_smaller(
        self,
        [(at_mm, radius_mm), (other_mm, other_radius_mm)]: [(f64, f64); 2],
    ) -> Self {
        let grows = (other_radius_mm - radius_mm) / (other_mm - at_mm);
        let least_mm = radius_mm + grows * (self.from_mm[1] - at_mm);
        let (least_mm, grows) = if (least_mm + grows).is_finite() {
            (least_mm, grows)
        } else {
            (0.0, 0.0)
        };
        Self {
            least_mm,
            grows,
            ..self
        }
    }

    /// Least radius of drops that are seen at a height, mm.
    #[must_use]
    pub fn least_radius_mm(&self, down_mm: f64) -> f64 {
        (self.least_mm + self.grows * (down_mm - self.from_mm[1])).max(0.0)
    }

    /// Without what is left of a straight line, or right of another: each by the place to the right, mm, where it meets the
    /// upper edge, and how far that moves with each mm down. A line that leaves more of the upper edge than of others cuts
    /// nothing off: what slides down the pane would come from there.
    #[must_use]
    pub fn between(self, lines: [(f64, f64); 2]) -> Self {
        let cut = |k: usize| {
            let (at_mm, moves) = lines[k];
            let (cut_mm, widens) = match k {
                0 => (at_mm - self.from_mm[0], -moves),
                _ => (self.to_mm[0] - at_mm, moves),
            };
            let does_cut = cut_mm > 0.0 && widens > 0.0 && (cut_mm + widens).is_finite();
            if does_cut {
                (cut_mm, widens)
            } else {
                (0.0, 0.0)
            }
        };
        let [left, right] = [0, 1].map(cut);
        Self {
            cut_mm: [left.0, right.0],
            widens: [left.1, right.1],
            ..self
        }
    }

    /// From where to where it reaches at a height, mm.
    #[must_use]
    pub fn across_mm(&self, down_mm: f64) -> [f64; 2] {
        let below_mm = down_mm - self.from_mm[1];
        let [left, right] = [0, 1].map(|k| (self.cut_mm[k] - self.widens[k] * below_mm).max(0.0));
        [self.from_mm[0] + left, self.to_mm[0] - right]
    }

    /// Whether a place, mm, is in it.
    #[must_use]
    pub fn holds(&self, at_mm: [f64; 2]) -> bool {
        let [left, right] = self.across_mm(at_mm[1]);
        (left..right).contains(&at_mm[0]) && (self.from_mm[1]..self.to_mm[1]).contains(&at_mm[1])
    }

    /// A place in it, mm: each as likely as any other.
    pub(crate) fn place(&self, rng: &mut ChaCha8Rng) -> [f64; 2] {
        let sides = self.sides_mm();
        let mut at_mm = self.from_mm;
        // What is cut off is seldom more than half of it.
        for _ in 0..MOST_DRAWS {
            at_mm = [0, 1].map(|k| self.from_mm[k] + sides[k] * uniform(rng));
            if self.holds(at_mm) {
                break;
            }
        }
        at_mm
    }

    /// Whether a place is in it, or may be so near, mm.
    pub(crate) fn is_near(&self, at_mm: [f64; 2], within_mm: f64) -> bool {
        // No row that near is wider than the lowest.
        let [left, right] = self.across_mm(at_mm[1] + within_mm);
        let is_beside =
            |mm: f64, [from, to]: [f64; 2]| mm >= from - within_mm && mm <= to + within_mm;
        is_beside(at_mm[0], [left, right]) && is_beside(at_mm[1], [self.from_mm[1], self.to_mm[1]])
    }

    /// Sides of the rectangle, mm.
    #[must_use]
    pub fn sides_mm(&self) -> [f64; 2] {
        [0, 1].map(|k| (self.to_mm[k] - self.from_mm[k]).max(0.0))
    }

    /// Cells of a width, mm, along each side of the rectangle: one at least.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cells of a pane"
    )]
    pub(crate) fn cells(&self, cell_mm: f64) -> [usize; 2] {
        self.sides_mm()
            .map(|side| ((side / cell_mm).ceil() as usize).max(1))
    }

    /// Its area, m²: without the corners that are cut off.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        let [_, height_mm] = self.sides_mm();
        let corner_mm2 = |k: usize| {
            let (cut_mm, widens) = (self.cut_mm[k], self.widens[k]);
            let high_mm = if widens > 0.0 {
                (cut_mm / widens).min(height_mm)
            } else {
                0.0
            };
            high_mm * (cut_mm - 0.5 * widens * high_mm)
        };
        self.rectangle_m2() - 1e-6 * (corner_mm2(0) + corner_mm2(1))
    }

    /// The area of the rectangle, m².
    pub(crate) fn rectangle_m2(&self) -> f64 {
        let [width, height] = self.sides_mm();
        width * height * 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_off_is_neither_held_nor_counted() {
        let whole = Area::rectangle([-60.0, 10.0], [40.0, 90.0]);
        let lines = [
            [(-20.0, -0.5), (15.0, 0.25)],
            [(-60.0, -0.5), (15.0, 3.0)],
            // Lines that leave more of the upper edge, that run beside the rectangle, and one that nothing is known of.
            [(-20.0, 0.5), (50.0, 0.1)],
            [(-20.0, f64::NAN), (15.0, f64::INFINITY)],
        ];
        for (k, two) in lines.into_iter().enumerate() {
            let area = whole.between(two);
            let at = |k: usize| [k % 500, k / 500].map(|n| (n as f64 + 0.5) / 500.0);
            let places = (0..250_000)
                .map(at)
                .map(|[s, t]| [-60.0 + 100.0 * s, 10.0 + 80.0 * t]);
            let held = places.filter(|place| area.holds(*place)).count();
            let share = held as f64 / 250_000.0;
            let counted = area.area_m2() / area.rectangle_m2();
            assert!((share - counted).abs() < 2e-3, "{k}: {share}, {counted}");
            assert_eq!(k < 2, counted < 0.99, "{k}: {counted}");
        }
        let area = whole.between(lines[0]);
        let [[left, right], [lower_left, lower_right]] = [10.0, 30.0].map(|y| area.across_mm(y));
        assert!(
            (left + 20.0).abs() < 1e-9 && (right - 15.0).abs() < 1e-9,
            "{left} to {right}"
        );
        let is_wider = (lower_left + 30.0).abs() < 1e-9 && (lower_right - 20.0).abs() < 1e-9;
        assert!(is_wider, "{lower_left} to {lower_right}");
    }

    #[test]
    fn what_is_near_an_area_is_told_from_what_is_not() {
        let area = Area::rectangle([0.0; 2], [100.0; 2]).between([(40.0, -1.0), (60.0, 1.0)]);
        assert!(area.is_near([50.0, 50.0], 0.0), "within");
        assert!(area.is_near([38.0, 0.0], 2.0), "beside its upper edge");
        assert!(
            !area.is_near([20.0, 0.0], 5.0),
            "in a corner that is cut off"
        );
        assert!(!area.is_near([50.0, 106.0], 5.0), "below");
        assert!(area.is_near([50.0, 104.0], 5.0), "a little below");
    }

    #[test]
    fn what_is_shown_is_what_there_is_farther_up_and_not_above_a_height() {
        let whole = Area::rectangle([-60.0, 10.0], [40.0, 90.0]);
        let lines = [(-20.0, -0.5), (15.0, 0.25)];
        // Lines with which the area begins below where they are shown from, and above; and none.
        for (k, (area, from_mm, run_in_mm)) in [
            (whole.between(lines), 40.0, 30.0),
            (whole.between(lines), 15.0, 30.0),
            (whole.between(lines), 5.0, 0.0),
            (whole, 40.0, 30.0),
        ]
        .into_iter()
        .enumerate()
        {
            let shown = area.shown_below(from_mm, run_in_mm).shown();
            for place in 0..10_000 {
                let [x, y] = [place % 100, place / 100].map(|n| f64::from(n) + 0.5);
                let (x, y) = (x - 60.0, y * 0.8 + 10.0);
                // The lines, as far above the area as they go.
                let of_lines = lines.map(|(at_mm, moves)| at_mm + moves * (y - run_in_mm - 10.0));
                let [left, right] = if k < 3 { of_lines } else { [-60.0, 40.0] };
                let is_shown = y >= from_mm && (left..right).contains(&x);
                assert_eq!(shown.holds([x, y]), is_shown, "{k}: {x}, {y} mm");
            }
        }
        assert_eq!(whole.shown(), whole, "all, if nothing is said");
    }
}
