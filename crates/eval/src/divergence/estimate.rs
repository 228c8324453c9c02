//! A value with what its resamples say: interval, floor, effect, p-value.

use super::report::Estimate;

/// Resampled values that are this close to the value are as large as it: rounding of sums.
pub(super) const ROUNDING: f64 = 1e-9;

/// `part` of `whole`; NaN of none.
pub(super) fn share(part: usize, whole: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "numbers of replicates")]
    let share = part as f64 / whole as f64;
    share
}

impl Estimate {
    /// A value with what its resamples say.
    pub(super) fn of(
        value: f64,
        draws: Vec<f64>,
        floors: [Vec<f64>; 2],
        relabeled: &[f64],
        confidence: f64,
    ) -> Self {
        let tail = (1.0 - confidence) / 2.0;
        let draws = sorted(draws);
        let interval = quantile(&draws, tail).zip(quantile(&draws, 1.0 - tail));
        // What may lie on both sides of 0, as an unbiased MMD², has a floor near 0 and no ratio to it.
        let has_ratio = floors.iter().flatten().all(|floor| *floor >= 0.0);
        let floor = floors
            .into_iter()
            .filter_map(|values| {
                let values = sorted(values);
                Some((mean(&values)?, quantile(&values, 0.95)?))
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let n_as_far = relabeled
            .iter()
            .filter(|drawn| **drawn >= value - ROUNDING * value.abs())
            .count();
        Self {
            value,
            // Resamples of a biased measure may all lie beside the value: that is no interval of it.
            interval: interval
                .map(|(low, high)| [low, high])
                .filter(|[low, high]| *low <= value && value <= *high),
            floor: floor.map(|floor| floor.0),
            floor_q95: floor.map(|floor| floor.1),
            effect: floor
                .filter(|_| has_ratio)
                .map(|floor| value / floor.0)
                .filter(|effect| effect.is_finite()),
            p_value: (!relabeled.is_empty()).then(|| share(n_as_far + 1, relabeled.len() + 1)),
        }
    }

    /// In another unit.
    pub(super) fn times(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            interval: self.interval.map(|ends| ends.map(|end| end * factor)),
            floor: self.floor.map(|floor| floor * factor),
            floor_q95: self.floor_q95.map(|floor| floor * factor),
            ..self
        }
    }
}

pub(super) fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

pub(super) fn mean(values: &[f64]) -> Option<f64> {
    let share = share(1, values.len());
    (!values.is_empty()).then(|| values.iter().sum::<f64>() * share)
}

/// The quantile of sorted values, between neighbors by their distance (type 7).
pub(super) fn quantile(sorted: &[f64], level: f64) -> Option<f64> {
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
