//! A histogram of which only the bins with something in them are held.

/// The bins of one item that are not empty, in their order.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::divergence) struct Counts {
    bins: Vec<(u16, f64)>,
}

impl Counts {
    /// The bins of a full histogram of at most 65536.
    pub(in crate::divergence) fn of(histogram: &[f64]) -> Self {
        let bins = (0..=u16::MAX)
            .zip(histogram)
            .filter(|(_, count)| **count > 0.0)
            .map(|(bin, count)| (bin, *count))
            .collect();
        Self { bins }
    }

    /// Whether nothing was counted.
    #[cfg(test)]
    pub(in crate::divergence) fn is_empty(&self) -> bool {
        self.bins.is_empty()
    }

    /// Adds them to a full histogram, `times` times.
    pub(in crate::divergence) fn add_to(&self, histogram: &mut [f64], times: f64) {
        for (bin, count) in &self.bins {
            if let Some(slot) = histogram.get_mut(usize::from(*bin)) {
                *slot += count * times;
            }
        }
    }
}
