//! Draws with replacement, as weights.

use std::iter::StepBy;
use std::ops::Range;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::EvalError;

/// Pairs of halves that tell how much a statistic leans.
const N_PAIRS_OF_HALVES: u32 = 50;

/// Permutations up to which all of them are gone through rather than drawn.
const EXACT_UP_TO: u32 = 1024;

/// What is drawn, how often and from which seed.
///
/// Units are images, or clusters of images that are not independent of each other: drives, clips.
/// Where an image is cracked several times, by seeds, all of these are drawn with it.
///
/// A draw of n units out of n with replacement gives each a whole weight, how often it was drawn;
/// an image that is drawn twice counts twice. (Counting each drawn image once, as some tools do,
/// evaluates some 63 % of the images and gives other intervals.) \[Efron1979\]
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    unit_of_image: Vec<u32>,
    n_units: u32,
    /// How many replicates.
    pub n_replicates: u32,
    /// Any number; the same one gives the same draws.
    pub seed: u64,
    /// Level of confidence of the intervals, between 0 and 1.
    pub level: f64,
}

/// What random numbers are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Factor {
    /// Which units are drawn.
    Units,
    /// Which units swap clean and cracked.
    Swaps,
    /// Which units are in the first half.
    Halves,
}

impl Factor {
    /// At most 16 bytes; a part of the key, so never to be changed.
    fn name(self) -> &'static [u8] {
        match self {
            Self::Units => b"bootstrap-units",
            Self::Swaps => b"swap-units",
            Self::Halves => b"half-units",
        }
    }
}

/// One draw of a plan, image by image.
pub(super) enum Draw {
    /// How often each counts.
    Weights(Vec<u32>),
    /// 1 where clean and cracked are swapped, else 0.
    Swaps(Vec<u32>),
}

impl Plan {
    /// 1000 replicates at 95 % over single images, seed 0.
    #[must_use]
    pub fn of_images(n_images: u32) -> Self {
        Self {
            unit_of_image: (0..n_images).collect(),
            n_units: n_images,
            n_replicates: 1000,
            seed: 0,
            level: 0.95,
        }
    }

    /// The same over clusters: images with one name are drawn together, an image without a name on
    /// its own.
    #[must_use]
    pub fn of_clusters(clusters: &[Option<&str>]) -> Self {
        let mut names = std::collections::BTreeMap::new();
        let mut n_units = 0_u32;
        let mut unit_of_image = Vec::with_capacity(clusters.len());
        for cluster in clusters {
            let unit = match cluster {
                Some(name) => *names.entry(*name).or_insert(n_units),
                None => n_units,
            };
            n_units = n_units.max(unit + 1);
            unit_of_image.push(unit);
        }
        let n_images = u32::try_from(unit_of_image.len()).unwrap_or(u32::MAX);
        Self {
            unit_of_image,
            n_units,
            ..Self::of_images(n_images)
        }
    }

    /// The same with another number of replicates, seed and level.
    #[must_use]
    pub fn with(mut self, n_replicates: u32, seed: u64, level: f64) -> Self {
        (self.n_replicates, self.seed, self.level) = (n_replicates, seed, level);
        self
    }

    /// How many images there are.
    #[must_use]
    pub fn n_images(&self) -> usize {
        self.unit_of_image.len()
    }

    /// How many units are drawn: images or clusters.
    #[must_use]
    pub fn n_units(&self) -> u32 {
        self.n_units
    }

    /// The unit of each image.
    #[must_use]
    pub fn unit_of_image(&self) -> &[u32] {
        &self.unit_of_image
    }

    /// Whether the plan can be carried out.
    ///
    /// # Errors
    /// Without replicates, or with a level outside of 0 to 1.
    pub fn check(&self) -> Result<(), EvalError> {
        if self.n_replicates == 0 {
            return Err(EvalError::StatisticSetting {
                what: "number of replicates",
                value: 0.0,
                range: "1 or more",
            });
        }
        if !(self.level > 0.0 && self.level < 1.0) {
            return Err(EvalError::StatisticSetting {
                what: "confidence level",
                value: self.level,
                range: "between 0 and 1",
            });
        }
        Ok(())
    }

    /// The unit of an image.
    ///
    /// # Errors
    /// [`EvalError::StatisticLength`] for one that the plan does not have.
    pub fn unit(&self, image: u32) -> Result<u32, EvalError> {
        let unit = self.unit_of_image.get(image as usize).copied();
        unit.ok_or(EvalError::StatisticLength {
            what: "images with objects",
            found: image as usize + 1,
            expected: self.n_images(),
            of: "images of the plan",
        })
    }

    /// In how many units these images are.
    #[must_use]
    pub(crate) fn units_of(&self, images: impl IntoIterator<Item = u32>) -> u32 {
        let unit = |image: u32| self.unit_of_image.get(image as usize);
        let units: std::collections::BTreeSet<u32> =
            images.into_iter().filter_map(unit).copied().collect();
        u32::try_from(units.len()).unwrap_or(u32::MAX)
    }

    /// How often each image counts in one replicate, the same for any order of calls and on every
    /// platform.
    #[must_use]
    pub fn weights(&self, replicate: u32) -> Vec<u32> {
        let mut stream = stream(self.seed, Factor::Units, replicate);
        let mut counts = vec![0_u32; self.n_units as usize];
        for _ in 0..self.n_units {
            let drawn = below(&mut stream, self.n_units);
            counts[drawn as usize] += 1;
        }
        self.per_image(&counts)
    }

    /// How many draws there are of all kinds, in this order: the sample itself, the replicates, the halves in pairs, the
    /// exchange of nothing, and the permutations.
    pub(super) fn n_draws(&self) -> usize {
        self.permutation_draws().end
    }

    /// The replicates among all draws.
    pub(super) fn replicate_draws(&self) -> Range<usize> {
        1..1 + self.n_replicates as usize
    }

    /// The first halves among all draws, each before its second one.
    pub(super) fn half_draws(&self) -> StepBy<Range<usize>> {
        let first = self.replicate_draws().end;
        (first..first + 2 * N_PAIRS_OF_HALVES as usize).step_by(2)
    }

    /// The exchange of nothing among all draws.
    pub(super) fn unexchanged_draw(&self) -> usize {
        self.replicate_draws().end + 2 * N_PAIRS_OF_HALVES as usize
    }

    /// The permutations among all draws.
    pub(super) fn permutation_draws(&self) -> Range<usize> {
        let first = self.unexchanged_draw() + 1;
        first..first + self.n_permutations() as usize
    }

    /// A draw by its place among all.
    pub(super) fn draw(&self, place: usize) -> Draw {
        let at = |first: usize| u32::try_from(place - first).unwrap_or(u32::MAX);
        let (replicates, halves) = (self.replicate_draws(), self.replicate_draws().end);
        let unexchanged = self.unexchanged_draw();
        match place {
            0 => Draw::Weights(vec![1; self.n_images()]),
            _ if replicates.contains(&place) => Draw::Weights(self.weights(at(1))),
            _ if place < unexchanged => {
                let [first, second] = self.halves(at(halves) / 2);
                Draw::Weights(match at(halves) % 2 {
                    0 => first,
                    _ => second,
                })
            }
            _ if place == unexchanged => Draw::Swaps(vec![0; self.n_images()]),
            _ => Draw::Swaps(self.permutation(at(unexchanged + 1))),
        }
    }

    /// How many permutations of all units there are, where these are few enough to go through all of them.
    pub(super) fn n_all_permutations(&self) -> Option<u32> {
        1_u32
            .checked_shl(self.n_units)
            .filter(|n| *n <= EXACT_UP_TO)
    }

    /// How many permutations are gone through.
    pub(super) fn n_permutations(&self) -> u32 {
        self.n_all_permutations().unwrap_or(self.n_replicates)
    }

    /// Per image 1 where clean and cracked are swapped, else 0.
    pub(super) fn permutation(&self, k: u32) -> Vec<u32> {
        match self.n_all_permutations() {
            Some(_) => self.swaps_of(k),
            None => self.swaps(k),
        }
    }

    /// The same of a random permutation.
    fn swaps(&self, replicate: u32) -> Vec<u32> {
        let mut stream = stream(self.seed, Factor::Swaps, replicate);
        let units: Vec<u32> = (0..self.n_units).map(|_| below(&mut stream, 2)).collect();
        self.per_image(&units)
    }

    /// The same of the k-th of all permutations.
    fn swaps_of(&self, k: u32) -> Vec<u32> {
        let units: Vec<u32> = (0..self.n_units)
            .map(|unit| k.checked_shr(unit).unwrap_or(0) & 1)
            .collect();
        self.per_image(&units)
    }

    /// All units in two halves at random: per image 1 in its half, else 0. Of an odd number the second has one
    /// more.
    fn halves(&self, pair: u32) -> [Vec<u32>; 2] {
        let mut stream = stream(self.seed, Factor::Halves, pair);
        let mut order: Vec<u32> = (0..self.n_units).collect();
        for left in (1..self.n_units).rev() {
            order.swap(left as usize, below(&mut stream, left + 1) as usize);
        }
        let mut first = vec![0_u32; order.len()];
        for unit in order.iter().take(order.len() / 2) {
            first[*unit as usize] = 1;
        }
        let second: Vec<u32> = first.iter().map(|unit| 1 - unit).collect();
        [self.per_image(&first), self.per_image(&second)]
    }

    fn per_image(&self, units: &[u32]) -> Vec<u32> {
        self.unit_of_image
            .iter()
            .map(|unit| units.get(*unit as usize).copied().unwrap_or(0))
            .collect()
    }
}

/// `ChaCha8` keyed by seed (8 bytes), name (16) and replicate (8).
fn stream(seed: u64, factor: Factor, replicate: u32) -> ChaCha8Rng {
    let mut key = [0_u8; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    let name = factor.name();
    key[8..8 + name.len()].copy_from_slice(name);
    key[24..28].copy_from_slice(&replicate.to_le_bytes());
    ChaCha8Rng::from_seed(key)
}

/// A whole number below `n`, each as likely: the upper half of a product, redrawn where it would
/// favor some \[Lemire2019\].
fn below(stream: &mut ChaCha8Rng, n: u32) -> u32 {
    let reject_below = n.wrapping_neg() % n.max(1);
    loop {
        let product = u64::from(stream.next_u32()) * u64::from(n);
        let (high, low) = ((product >> 32) as u32, product & u64::from(u32::MAX));
        if low >= u64::from(reject_below) {
            return high;
        }
    }
}
