//! A value with what its resamples say: interval, floor, effect, p-value.

use super::report::{CONFIDENCE, Estimate};

/// Resampled values that are this close to the value are as large as it: rounding of sums.
pub(super) const ROUNDING: f64 = 1e-9;

/// `part` of `whole`; NaN of none.
pub(super) fn share(part: usize, whole: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "numbers of replicates")]
    let share = part as f64 / whole as f64;
    share
}

impl Estimate {
    /// A value, its bootstrap draws and its relabeled values, all times `unit`, beside a floor in that unit.
    pub(super) fn of(
        value: f64,
        draws: Vec<f64>,
        floor: Option<f64>,
        relabeled: &[f64],
        unit: f64,
    ) -> Self {
        let tail = (1.0 - CONFIDENCE) / 2.0;
        let draws = sorted(draws);
        let interval = quantile(&draws, tail).zip(quantile(&draws, 1.0 - tail));
        let is_as_far = |drawn: &&f64| **drawn >= value - ROUNDING * value.abs();
        let n_as_far = relabeled.iter().filter(is_as_far).count();
        Self {
            value: value * unit,
            // Resamples of a biased measure may all lie beside the value: that is no interval of it.
            interval: interval
                .filter(|(low, high)| (*low..=*high).contains(&value))
                .map(|(low, high)| [low * unit, high * unit]),
            floor,
            effect: floor
                .map(|floor| value * unit / floor)
                .filter(|effect| effect.is_finite()),
            p_value: (!relabeled.is_empty()).then(|| share(n_as_far + 1, relabeled.len() + 1)),
        }
    }
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

/// The mean, by a sum from the least to the largest.
pub(super) fn mean(values: Vec<f64>) -> Option<f64> {
    let part = share(1, values.len());
    (!values.is_empty()).then(|| sorted(values).iter().sum::<f64>() * part)
}

/// The quantile of sorted values, between neighbors by their distance (type 7).
fn quantile(sorted: &[f64], level: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    #[expect(clippy::cast_precision_loss, reason = "a number of replicates")]
    let at = level * last as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the last place"
    )]
    let below = at.floor() as usize;
    let low = sorted.get(below)?;
    let high = sorted.get((below + 1).min(last))?;
    // Infinite ends have no middle.
    if low >= high || at.fract() <= 0.0 {
        return Some(*low);
    }
    Some(low + (high - low) * at.fract())
}
