//! Draws with replacement, as weights.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::EvalError;

/// What is drawn, how often and from which seed.
///
/// Units are images, or clusters of images that are not independent of each other: drives, clips.
/// With more than one crack pattern per image, the patterns are a second factor that crosses the
/// images: both are drawn on their own and a cell weighs the product (the pigeonhole bootstrap
/// \[Owen2007\]), which errs on the wide side.
///
/// A draw of n units out of n with replacement gives each a whole weight, how often it was drawn;
/// an image that is drawn twice counts twice. (Counting each drawn image once, as some tools do,
/// evaluates some 63 % of the images and gives other intervals.) \[Efron1979\]
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    unit_of_image: Vec<u32>,
    n_units: u32,
    n_patterns: u32,
    /// How many replicates.
    pub n_replicates: u32,
    /// Any number; the same one gives the same draws.
    pub seed: u64,
    /// Level of confidence of the intervals, between 0 and 1.
    pub level: f64,
}

/// How often each image and each pattern counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Weights {
    /// Per image.
    pub images: Vec<u32>,
    /// Per pattern.
    pub patterns: Vec<u32>,
}

/// What random numbers are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Factor {
    /// Which units are drawn.
    Units,
    /// Which patterns are drawn.
    Patterns,
    /// Which units swap clean and cracked.
    Swaps,
}

impl Factor {
    /// At most 16 bytes; a part of the key, so never to be changed.
    fn name(self) -> &'static [u8] {
        match self {
            Self::Units => b"bootstrap-units",
            Self::Patterns => b"bootstrap-pattn",
            Self::Swaps => b"swap-units",
        }
    }
}

impl Plan {
    /// 1000 replicates at 95 % over single images, seed 0.
    #[must_use]
    pub fn of_images(n_images: u32) -> Self {
        Self {
            unit_of_image: (0..n_images).collect(),
            n_units: n_images,
            n_patterns: 1,
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

    /// The same with `n_patterns` crack patterns as the second factor; at least 1.
    #[must_use]
    pub fn with_patterns(mut self, n_patterns: u32) -> Self {
        self.n_patterns = n_patterns.max(1);
        self
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

    /// How many patterns are drawn.
    #[must_use]
    pub fn n_patterns(&self) -> u32 {
        self.n_patterns
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
                what: "level of confidence",
                value: self.level,
                range: "between 0 and 1",
            });
        }
        Ok(())
    }

    /// Everything once: the sample itself.
    #[must_use]
    pub fn ones(&self) -> Weights {
        Weights {
            images: vec![1; self.unit_of_image.len()],
            patterns: vec![1; self.n_patterns as usize],
        }
    }

    /// The weights of one replicate, the same for any order of calls and on every platform.
    #[must_use]
    pub fn weights(&self, replicate: u32) -> Weights {
        let units = self.draw(Factor::Units, replicate, self.n_units);
        let patterns = if self.n_patterns == 1 {
            vec![1]
        } else {
            self.draw(Factor::Patterns, replicate, self.n_patterns)
        };
        Weights {
            images: self.per_image(&units),
            patterns,
        }
    }

    /// Per unit which of its versions plays the clean one in a random permutation: 0 the clean one
    /// itself, k the cracked one of pattern k.
    pub(super) fn roles(&self, replicate: u32) -> Vec<u32> {
        let mut stream = stream(self.seed, Factor::Swaps, replicate);
        (0..self.n_units)
            .map(|_| below(&mut stream, self.n_patterns + 1))
            .collect()
    }

    /// All images but those of every `n_groups`-th unit, from `group` on.
    pub(super) fn without_group(&self, group: u32, n_groups: u32) -> Weights {
        let units: Vec<u32> = (0..self.n_units)
            .map(|unit| u32::from(unit % n_groups != group))
            .collect();
        Weights {
            images: self.per_image(&units),
            patterns: vec![1; self.n_patterns as usize],
        }
    }

    fn per_image(&self, units: &[u32]) -> Vec<u32> {
        self.unit_of_image
            .iter()
            .map(|unit| units.get(*unit as usize).copied().unwrap_or(0))
            .collect()
    }

    fn draw(&self, factor: Factor, replicate: u32, n: u32) -> Vec<u32> {
        let mut stream = stream(self.seed, factor, replicate);
        let mut counts = vec![0_u32; n as usize];
        for _ in 0..n {
            let drawn = below(&mut stream, n);
            counts[drawn as usize] += 1;
        }
        counts
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
