//! Random numbers for each pixel, two 32-bit words at a time: how many are drawn depends on the frame alone.

use std::f64::consts::{PI, SQRT_2};
use std::sync::LazyLock;

/// Bits of a word that say the place in the table.
const BITS: u32 = 12;

/// Quantiles of the standard normal distribution at k/4096; those at both ends are never used.
static QUANTILES: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let n = 1_u32 << BITS;
    let inner = (1..n).map(|k| single(quantile(f64::from(k) / f64::from(n))));
    std::iter::once(0.0).chain(inner).chain([0.0]).collect()
});

/// Standard normal numbers out of random words.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Normal(&'static [f32]);

impl Normal {
    pub(crate) fn new() -> Self {
        Self(&QUANTILES)
    }

    /// The quantile at (word + ½)/2³²: straight between the entries of a table, exact in the last bins, where a straight
    /// line would not do.
    #[inline]
    pub(crate) fn of(self, word: u32) -> f32 {
        let k = (word >> (32 - BITS)) as usize;
        if k == 0 || k + 2 == self.0.len() {
            return single(quantile((f64::from(word) + 0.5) / 4_294_967_296.0));
        }
        #[expect(clippy::cast_precision_loss, reason = "20 bits fit")]
        let within = ((word << BITS) >> BITS) as f32 / (1_u32 << (32 - BITS)) as f32;
        let (low, high) = (self.0[k], self.0[k + 1]);
        low + (high - low) * within
    }
}

/// Where the standard normal distribution has reached p, by Newton's method from the middle outwards, which never
/// oversteps.
fn quantile(p: f64) -> f64 {
    let (tail, sign) = if p < 0.5 { (p, -1.0) } else { (1.0 - p, 1.0) };
    // The tail beyond x is ½ erfc(x/√2).
    let mut x = 0.0_f64;
    for _ in 0..64 {
        let excess = 0.5 * libm::erfc(x / SQRT_2) - tail;
        let density = libm::exp(-0.5 * x * x) / (2.0 * PI).sqrt();
        let step = excess / density;
        x += step;
        if step.abs() < 1e-12 {
            break;
        }
    }
    sign * x
}

/// A Poisson number of a mean below [`MAX_COUNTED`], by counting up to the uniform number (word + ½)/2³².
pub(crate) fn poisson(mean: f64, word: u32) -> f64 {
    let wanted = (f64::from(word) + 0.5) / 4_294_967_296.0;
    let mut share = libm::exp(-mean);
    let mut sum = share;
    let mut n = 0.0;
    while sum < wanted && share > 0.0 {
        n += 1.0;
        share *= mean / n;
        sum += share;
    }
    n
}

/// Mean from which a Poisson number is as good as a normal one: its skewness is 1/√32 = 0.18.
pub(crate) const MAX_COUNTED: f64 = 32.0;

#[expect(clippy::cast_possible_truncation, reason = "noise is single precision")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::{Normal, poisson, quantile};

    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        // Abramowitz and Stegun, table 26.5.
        for (p, x) in [
            (0.5, 0.0),
            (0.975, 1.959_963_984_5),
            (0.001, -3.090_232_306_2),
        ] {
            assert!((quantile(p) - x).abs() < 1e-9, "{p}: {}", quantile(p));
        }
        let far = quantile(0.5 / 4_294_967_296.0);
        assert!((far + 6.338).abs() < 0.01, "{far}");
    }

    #[test]
    fn moments_are_those_of_the_laws() {
        // Every 4096th word, and the middle between: a sample without chance.
        let words = (0..1_u32 << 20).map(|k| (k << 12) | 0x800);
        let normal = Normal::new();
        let [mut mean, mut square, mut fourth] = [0.0_f64; 3];
        for word in words.clone() {
            let x = f64::from(normal.of(word));
            mean += x;
            square += x * x;
            fourth += x.powi(4);
        }
        let n = f64::from(1 << 20);
        assert!((mean / n).abs() < 1e-4, "{}", mean / n);
        assert!((square / n - 1.0).abs() < 1e-3, "{}", square / n);
        assert!((fourth / n - 3.0).abs() < 2e-2, "{}", fourth / n);
        for lambda in [0.1, 3.0, 31.0] {
            let [mut mean, mut square] = [0.0_f64; 2];
            for word in words.clone().step_by(16) {
                let k = poisson(lambda, word);
                mean += k * 16.0 / n;
                square += k * k * 16.0 / n;
            }
            assert!((mean / lambda - 1.0).abs() < 1e-3, "{mean} for {lambda}");
            let variance = square - mean * mean;
            assert!(
                (variance / lambda - 1.0).abs() < 3e-3,
                "{variance} for {lambda}"
            );
        }
    }
}
