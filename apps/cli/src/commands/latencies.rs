//! How long frames took, in the memory of a few of them however many there are.

use std::time::Duration;

/// Bins of each doubling: a latency is known to 1/64 of it.
const PER_DOUBLING: u64 = 64;

/// Counts of latencies in bins of microseconds that widen with them.
#[derive(Debug, Default)]
pub(super) struct Latencies {
    /// Frames in each bin.
    counts: Vec<u64>,
    n: u64,
    most: Duration,
}

impl Latencies {
    /// One more.
    pub(super) fn add(&mut self, latency: Duration) {
        let bin = bin_of(u64::try_from(latency.as_micros()).unwrap_or(u64::MAX));
        if bin >= self.counts.len() {
            self.counts.resize(bin + 1, 0);
        }
        self.counts[bin] += 1;
        self.n += 1;
        self.most = self.most.max(latency);
    }

    /// The longest; none of no frames.
    pub(super) fn most_ms(&self) -> Option<f64> {
        (self.n > 0).then_some(self.most.as_secs_f64() * 1e3)
    }

    /// What so many of a hundred frames do not exceed, ms, to 1/64 of it upward; none of no frames.
    pub(super) fn percentile_ms(&self, percent: u64) -> Option<f64> {
        let rank = (self.n * percent).div_ceil(100).max(1);
        let mut below = 0;
        let bin = self.counts.iter().position(|count| {
            below += count;
            below >= rank
        })?;
        let end = Duration::from_micros(end_of(bin)).min(self.most);
        Some(end.as_secs_f64() * 1e3)
    }
}

/// The bin of a latency: one for each microsecond at first, then 64 for each doubling.
fn bin_of(micros: u64) -> usize {
    let doublings = (micros / PER_DOUBLING).checked_ilog2().map_or(0, u64::from);
    let in_doubling = micros >> doublings;
    let bin = doublings * PER_DOUBLING + in_doubling;
    usize::try_from(bin).unwrap_or(usize::MAX)
}

/// The end of a bin, µs.
fn end_of(bin: usize) -> u64 {
    let bin = bin as u64;
    let doublings = (bin / PER_DOUBLING).saturating_sub(1);
    let in_doubling = bin - doublings * PER_DOUBLING;
    (in_doubling + 1)
        .checked_shl(u32::try_from(doublings).unwrap_or(u32::MAX))
        .unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_latency_is_below_the_end_of_its_bin_by_a_64th() {
        let mut before = 0;
        for micros in (0..10_000).chain((0..40).map(|k| 12_345 << k)) {
            let bin = bin_of(micros);
            let end = end_of(bin);
            assert!(bin >= before, "{micros} us: in order");
            assert!(end > micros, "{micros} us: ends at {end}");
            assert!(end - micros <= micros / 64 + 1, "{micros} us: at {end}");
            before = bin;
        }
        assert!(bin_of(u64::MAX) < 4096, "any latency has a bin");
    }

    #[test]
    fn percentiles_are_those_of_the_frames() {
        let mut latencies = Latencies::default();
        assert_eq!(latencies.percentile_ms(50), None, "of no frames");
        for ms in 1..=200 {
            latencies.add(Duration::from_millis(ms));
        }
        for (percent, expected) in [(50, 100.0), (99, 198.0), (100, 200.0)] {
            let found = latencies.percentile_ms(percent).unwrap_or(f64::NAN);
            let above = found / expected;
            assert!((1.0..1.02).contains(&above), "{percent} %: {found} ms");
        }
        assert_eq!(latencies.most_ms(), Some(200.0), "the longest");
    }
}
