//! Random picks of images, by seed alone: how often each counts.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use sha2::{Digest, Sha256};

/// The stream for one draw: ChaCha8 with the key SHA-256(`div/1`, seed, sets, index, what it is for).
pub(super) fn stream(seed: u64, purpose: &str, sets: [usize; 2], index: usize) -> ChaCha8Rng {
    let wide = |n: usize| u64::try_from(n).unwrap_or(u64::MAX).to_le_bytes();
    let key = Sha256::new()
        .chain_update(b"div/1")
        .chain_update(seed.to_le_bytes())
        .chain_update(wide(sets[0]))
        .chain_update(wide(sets[1]))
        .chain_update(wide(index))
        .chain_update(purpose)
        .finalize();
    ChaCha8Rng::from_seed(key.into())
}

/// One of `n`, all alike to one part in 2⁶⁴/n.
fn one_of(random: &mut ChaCha8Rng, n: usize) -> usize {
    let wide = u128::from(random.next_u64()) * u128::try_from(n).unwrap_or(u128::MAX >> 64);
    usize::try_from(wide >> 64).unwrap_or_default()
}

/// How often each of `n` is drawn in `n` draws with replacement.
pub(super) fn multiplicities(random: &mut ChaCha8Rng, n: usize) -> Vec<u32> {
    let mut times = vec![0; n];
    for _ in 0..n {
        times[one_of(random, n)] += 1;
    }
    times
}

/// Which `part` of `n` are picked, without replacement.
pub(super) fn subset(random: &mut ChaCha8Rng, n: usize, part: usize) -> Vec<u32> {
    let mut order: Vec<usize> = (0..n).collect();
    let mut is_picked = vec![0; n];
    for at in 0..part.min(n) {
        order.swap(at, at + one_of(random, n - at));
        is_picked[order[at]] = 1;
    }
    is_picked
}

/// `n` fair coins.
pub(super) fn coins(random: &mut ChaCha8Rng, n: usize) -> Vec<u32> {
    (0..n)
        .map(|_| u32::from(random.next_u64() >> 63 == 1))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_even_whole_and_the_same_again() {
        let mut hits = [0_u32; 7];
        for index in 0..7000 {
            let mut random = stream(1, "halves", [0, 0], index);
            let picked = subset(&mut random, 7, 3);
            assert_eq!(picked.iter().sum::<u32>(), 3, "three of seven");
            for (hit, picked) in hits.iter_mut().zip(picked) {
                *hit += picked;
            }
        }
        for hit in hits {
            // 3000 expected, standard deviation 41.
            assert!((2795..=3205).contains(&hit), "{hits:?}");
        }
        let draw = || multiplicities(&mut stream(5, "bootstrap", [1, 1], 9), 50);
        assert_eq!(draw(), draw(), "by seed alone");
        assert_eq!(draw().iter().sum::<u32>(), 50, "as many as there are");
    }
}
