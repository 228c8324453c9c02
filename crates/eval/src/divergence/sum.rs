//! Sums of many numbers.

/// Most terms that are added in one stretch.
const BLOCK: usize = 128;

/// The sum by halves, in eight lanes below [`BLOCK`] terms: its error grows with log n.
///
/// **Source**: \[Higham1993\]. Lanes and block are those of NumPy's `add.reduce`, so that
/// a sum here is the one there, to the bit.
pub(super) fn pairwise_sum(values: &[f64]) -> f64 {
    let n = values.len();
    if n > BLOCK {
        let half = n / 2 - (n / 2) % 8;
        let (head, tail) = values.split_at(half);
        return pairwise_sum(head) + pairwise_sum(tail);
    }
    let (lanes, tail) = values.as_chunks::<8>();
    let Some((first, more)) = lanes.split_first() else {
        return values.iter().sum();
    };
    let mut sums = *first;
    for lane in more {
        for (sum, value) in sums.iter_mut().zip(lane) {
            *sum += value;
        }
    }
    let [a, b, c, d, e, f, g, h] = sums;
    let whole = ((a + b) + (c + d)) + ((e + f) + (g + h));
    tail.iter().fold(whole, |sum, value| sum + value)
}

#[cfg(test)]
mod tests {
    use super::pairwise_sum;

    #[test]
    fn a_million_tenths_are_a_hundred_thousand_to_the_last_digits() {
        let tenths = vec![0.1; 1_000_000];
        let plain: f64 = tenths.iter().sum();
        let error = (pairwise_sum(&tenths) - 100_000.0).abs();
        assert!(error < 1e-10, "by halves {error:e}");
        assert!((plain - 100_000.0).abs() > 1e-7, "one by one is worse");
        for n in 0..300_u32 {
            let numbers: Vec<f64> = (1..=n).map(f64::from).collect();
            let closed = f64::from(n * (n + 1)) / 2.0;
            let got = pairwise_sum(&numbers);
            assert!((got - closed).abs() < 1e-9, "{n} terms are all there");
        }
    }
}
