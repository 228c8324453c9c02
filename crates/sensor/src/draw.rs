//! Random numbers for each pixel, two 32-bit words at a time: how many are drawn depends on the frame alone.

use std::f64::consts::{PI, SQRT_2};
use std::sync::LazyLock;

use rand_chacha::rand_core::Rng as _;
use starbreak_seed::{Seed, Stream};

/// Bits of a word that say the place in the table.
const BITS: u32 = 12;

/// Quantiles of the standard normal distribution at k/4096; those at both ends are never used.
static QUANTILES: LazyLock<[f32; (1 << BITS) + 1]> = LazyLock::new(|| {
    let n = 1_u32 << BITS;
    let mut quantiles = [0.0; (1 << BITS) + 1];
    for (k, quantile_at) in (0..n).zip(&mut quantiles).skip(1) {
        *quantile_at = single(quantile(f64::from(k) / f64::from(n)));
    }
    quantiles
});

/// Standard normal numbers out of random words.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Normal(&'static [f32; (1 << BITS) + 1]);

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

    /// Of up to N pairs of words, those of the first and those of the second; 0 where there are no words.
    pub(crate) fn of_pairs<const N: usize>(self, words: &[u32]) -> [[f32; N]; 2] {
        let mut numbers = [[0.0; N]; 2];
        for (k, [one, other]) in words.as_chunks().0.iter().enumerate().take(N) {
            numbers[0][k] = self.of(*one);
            numbers[1][k] = self.of(*other);
        }
        numbers
    }

    /// Normal numbers out of a stream, one after the other.
    pub(crate) fn numbers(self, seed: Seed, stream: Stream, index: u64) -> impl FnMut() -> f64 {
        let mut rng = seed.stream(stream, index);
        move || f64::from(self.of(rng.next_u32()))
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

/// Mean from which a Poisson number is as good as a normal one: its skewness is 1/√32 = 0.18.
pub(crate) const MAX_COUNTED: f32 = 32.0;

/// Tables of [`Poisson`] for each step of the root of the mean.
const PER_ROOT: f32 = 32.0;

/// Counts for which a table has a chance: from 32 on, more than 58 + 22 come less often than a word has values.
const N_COUNTS: usize = 80;

/// Distribution functions of Poisson numbers of mean (j/32)², j from 0 on.
static COUNTS: LazyLock<Vec<[f32; N_COUNTS]>> = LazyLock::new(|| {
    let n_tables = 183_u16;
    let of = |j: u16| {
        let root = f64::from(j) / f64::from(PER_ROOT);
        let mut share = libm::exp(-root * root);
        let mut below = 0.0;
        let mut table = [0.0; N_COUNTS];
        for (n, entry) in (1..).zip(&mut table) {
            below += share;
            *entry = single(below);
            share *= root * root / f64::from(n);
        }
        table
    };
    (0..n_tables).map(of).collect()
});

/// Poisson numbers of means below [`MAX_COUNTED`] out of random words.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Poisson(&'static [[f32; N_COUNTS]]);

impl Poisson {
    pub(crate) fn new() -> Self {
        Self(&COUNTS)
    }

    /// The least count whose distribution function is above (word + ½)/2³². The function lies between those of two
    /// tables, which has the right mean, and a variance that is 0.1 % too large at most.
    #[inline]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "a place in a table of 183, counts below 80, and a word as a single"
    )]
    pub(crate) fn of(self, mean: f32, root: f32, word: u32, normal: f32) -> f32 {
        let j = (root * PER_ROOT) as usize;
        let [low, high] = [&self.0[j.min(181)], &self.0[j.min(181) + 1]];
        let of = |j: usize| {
            let root = j as f32 / PER_ROOT;
            root * root
        };
        let within = (mean - of(j)) / (of(j + 1) - of(j));
        // Below 1, which no sum of singles exceeds.
        let wanted = ((word as f32 + 0.5) / 4_294_967_296.0).min(1.0 - f32::EPSILON);
        let reached = |n: usize| low[n] + (high[n] - low[n]) * within > wanted;
        // The quantile of Cornish and Fisher is seldom off by more than one.
        let guess = mean + root * normal + (normal * normal - 1.0) / 6.0;
        let least = ((guess - 1.0).max(0.0) as usize).min(N_COUNTS - 3);
        // Without branches, which nobody could foretell.
        let mut n = least
            + (0..3)
                .map(|k| usize::from(!reached(least + k)))
                .sum::<usize>();
        // Nor are dark pixels' counts of 0, than which nothing is less.
        if (n == least) & (least > 0) {
            while n > 0 && reached(n - 1) {
                n -= 1;
            }
        } else if n == least + 3 {
            while n + 1 < N_COUNTS && !reached(n) {
                n += 1;
            }
        }
        n as f32
    }
}

/// The first words of a stream.
pub(crate) fn words_of(seed: Seed, stream: Stream, index: usize, n: usize) -> Vec<u32> {
    let mut rng = seed.stream(stream, index as u64);
    let mut bytes = vec![0_u8; 4 * n];
    rng.fill_bytes(&mut bytes);
    let words = bytes.chunks_exact(4);
    words
        .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
        .collect()
}

#[expect(clippy::cast_possible_truncation, reason = "noise is single precision")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}

#[cfg(test)]
mod tests {
    use super::{Normal, Poisson, quantile};

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
        let poisson = Poisson::new();
        // The largest words are no wonders.
        for lambda in [0.01_f32, 1.0, 8.0, 31.9] {
            let far = poisson.of(lambda, lambda.sqrt(), u32::MAX, normal.of(u32::MAX));
            let most = lambda + 8.0 * lambda.sqrt() + 6.0;
            assert!(far <= most, "{far} of {lambda}");
        }
        for lambda in [0.02, 0.1, 0.5, 3.0, 3.1, 31.0] {
            let [mut mean, mut square] = [0.0_f64; 2];
            for word in words.clone().step_by(16) {
                let mean_e = super::single(lambda);
                let k = f64::from(poisson.of(mean_e, mean_e.sqrt(), word, normal.of(word)));
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
