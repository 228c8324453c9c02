/// An axis: its ends, the marks on it, and what is measured along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub(super) ends: [f64; 2],
    pub(super) marks: Vec<(f64, String)>,
    pub(super) label: String,
    is_log: bool,
}

impl Axis {
    /// An axis with about five marks at round numbers.
    #[must_use]
    pub fn of(ends: [f64; 2], label: &str) -> Self {
        Self::with_step(ends, nice_step(ends[1] - ends[0]), label)
    }

    /// An axis from 0 to the first mark that is not below a value.
    #[must_use]
    pub fn up_to(most: f64, label: &str) -> Self {
        let step = nice_step(most);
        Self::with_step([0.0, (most / step).ceil().max(1.0) * step], step, label)
    }

    /// As [`Axis::of`], of whole numbers.
    #[must_use]
    pub fn of_counts(ends: [f64; 2], label: &str) -> Self {
        Self::with_step(ends, nice_step(ends[1] - ends[0]).max(1.0), label)
    }

    fn with_step([low, high]: [f64; 2], step: f64, label: &str) -> Self {
        let first = (low / step - 1e-9).ceil();
        let n_digits = (0..9).find(|n| {
            let scaled = step * 10.0_f64.powi(*n);
            (scaled - scaled.round()).abs() < 1e-6
        });
        let n_digits = n_digits.and_then(|n| usize::try_from(n).ok()).unwrap_or(9);
        let marks = (0..100_u32)
            .map(|place| (first + f64::from(place)) * step)
            .take_while(|at| *at <= high + 1e-9 * step)
            .map(|at| (at, format!("{:.n_digits$}", at + 0.0)));
        Self {
            marks: marks.collect(),
            ends: [low, high],
            label: label.to_owned(),
            is_log: false,
        }
    }

    /// A logarithmic axis with room for all of some values above 0, and marks at 1, 2 and 5 times powers of ten.
    #[must_use]
    pub fn log(values: impl Iterator<Item = f64>, label: &str) -> Self {
        let values = values.filter(|value| *value > 0.0 && value.is_finite());
        let [low, high] = values.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], value| {
            [low.min(value), high.max(value)]
        });
        let round = (-9..12).flat_map(|power| [1.0, 2.0, 5.0].map(|of| of * 10.0_f64.powi(power)));
        let round: Vec<f64> = round.collect();
        let low = round.iter().rfind(|at| **at <= low * 1.000_001);
        let high = round.iter().find(|at| **at >= high * 0.999_999);
        let ends = match (low, high) {
            (Some(low), Some(high)) if low < high => [*low, *high],
            (Some(low), _) => [*low, low * 10.0],
            _ => [1.0, 10.0],
        };
        // Of many decades the tens alone.
        let has_all = ends[1] / ends[0] < 2e3;
        let is_ten = |at: f64| (at.log10() - at.log10().round()).abs() < 1e-9;
        let marks = round.iter().filter(|at| {
            (ends[0] * 0.999_999..=ends[1] * 1.000_001).contains(*at) && (has_all || is_ten(**at))
        });
        Self {
            marks: marks
                .map(|at| (*at, format!("{}", (at * 1e9).round() / 1e9)))
                .collect(),
            ends,
            label: label.to_owned(),
            is_log: true,
        }
    }

    /// A y axis whose marks are names, the first at the top, a unit between two of them.
    #[must_use]
    pub fn of_names(names: &[String]) -> Self {
        let n = names.len();
        Self {
            ends: [0.4, row_count(n) + 0.6],
            marks: (names.iter().enumerate())
                .map(|(k, name)| (row_count(n - k), name.clone()))
                .collect(),
            label: String::new(),
            is_log: false,
        }
    }

    /// The least and the greatest value on it.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        self.ends
    }

    /// Where a value is, as a share of the way from the first to the last.
    pub(super) fn share(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        let share = match self.is_log {
            true => (value / low).ln() / (high / low).ln(),
            false => (value - low) / (high - low),
        };
        match share.is_finite() {
            true => share.clamp(0.0, 1.0),
            false => 0.0,
        }
    }
}

fn row_count(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}

/// The distance of marks on an axis of some length: 1, 2 or 5 times a power of ten, about five of them.
fn nice_step(length: f64) -> f64 {
    let rough = length / 5.0;
    if !rough.is_finite() || rough <= 0.0 {
        return 1.0;
    }
    let power = 10.0_f64.powf(rough.log10().floor());
    let factor = match rough / power {
        f if f < 1.5 => 1.0,
        f if f < 3.5 => 2.0,
        f if f < 7.5 => 5.0,
        _ => 10.0,
    };
    factor * power
}

#[cfg(test)]
mod tests {
    use super::{Axis, nice_step};

    #[test]
    fn marks_stand_at_round_numbers() {
        for (end, step) in [
            (1.0, 0.2),
            (0.37, 0.05),
            (7.0, 1.0),
            (48.0, 10.0),
            (0.0, 1.0),
        ] {
            let found = nice_step(end);
            assert!((found - step).abs() < 1e-12, "up to {end}: {found}");
        }
    }

    #[test]
    fn marks_are_within_the_ends_and_have_the_digits_of_their_step() {
        let said = |axis: Axis| -> Vec<String> { axis.marks.into_iter().map(|it| it.1).collect() };
        assert_eq!(
            said(Axis::of([0.5, 5.5], "")),
            ["1", "2", "3", "4", "5"],
            "whole"
        );
        assert_eq!(
            said(Axis::of([0.0, 0.37], ""))[..3],
            ["0.00", "0.05", "0.10"],
            "two digits"
        );
        let log = Axis::log([30.0, 2.5, 0.0].into_iter(), "");
        assert_eq!(said(log), ["2", "5", "10", "20", "50"], "1, 2 and 5");
    }
}
