//! Random numbers of the two laws that everything else is made of.

use std::f64::consts::TAU;

use rand_chacha::rand_core::Rng;

/// A uniform number in [0, 1) with 53 random bits.
pub fn uniform(rng: &mut impl Rng) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "53 bits fit an f64 exactly")]
    let bits = (rng.next_u64() >> 11) as f64;
    bits / 9_007_199_254_740_992.0
}

/// A standard normal number: √(−2 ln(1 − u)) cos 2πv of two uniform ones \[BoxMuller1958\].
pub fn normal(rng: &mut impl Rng) -> f64 {
    let radius = (-2.0 * libm::log(1.0 - uniform(rng))).sqrt();
    radius * libm::cos(TAU * uniform(rng))
}

#[cfg(test)]
mod tests {
    use super::{normal, uniform};
    use crate::{Seed, Stream};

    #[test]
    fn moments_are_those_of_the_laws() {
        let mut rng = Seed(1).stream(Stream::Particles, 0);
        let n = 100_000;
        let moments = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / f64::from(n);
            let square = values.iter().map(|it| it * it).sum::<f64>() / f64::from(n);
            let fourth = values.iter().map(|it| it.powi(4)).sum::<f64>() / f64::from(n);
            [mean, square, fourth]
        };
        let flat: Vec<f64> = (0..n).map(|_| uniform(&mut rng)).collect();
        assert!(flat.iter().all(|it| (0.0..1.0).contains(it)), "in [0, 1)");
        let bell: Vec<f64> = (0..n).map(|_| normal(&mut rng)).collect();
        for (found, expected, error) in [
            (moments(&flat), [0.5, 1.0 / 3.0, 0.2], [0.005, 0.005, 0.005]),
            (moments(&bell), [0.0, 1.0, 3.0], [0.016, 0.023, 0.16]),
        ] {
            for ((found, expected), error) in found.into_iter().zip(expected).zip(error) {
                assert!((found - expected).abs() < error, "{found} for {expected}");
            }
        }
    }
}
