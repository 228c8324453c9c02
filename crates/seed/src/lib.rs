//! Randomness without ambience: the [`Seed`] of a run, named [`Stream`]s of random numbers, and seeds of items.

mod draw;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

pub use draw::{normal, uniform};

/// The number that a whole run is reproducible from. Zero is a seed like any other.
///
/// # Example
/// ```
/// use starbreak_seed::Seed;
/// let dataset = Seed(7);
/// let frame = dataset.of_item("image_2/000001.png", 0);
/// assert_eq!(frame, dataset.of_item("image_2/000001.png", 0));
/// assert_ne!(frame, dataset.of_item("image_2/000002.png", 0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Seed(pub u64);

/// What a stream of random numbers is for. Each purpose has its own stream, so that drawing
/// more numbers for one never shifts another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Stream {
    /// Positions of the paper's particles.
    Particles,
    /// Position of an impact.
    ImpactPosition,
    /// Direction of an impact.
    ImpactDirection,
    /// Strength of the surface and of each arm under a hit.
    StoneFlaws,
    /// Wander and forks of crack tips.
    TipJitter,
    /// Tilt of the surfaces of cracks.
    CrackTilt,
    /// Strength of the glass along rings.
    Rings,
    /// Points and edges of dice.
    Dice,
    /// Flaws and loads of a long crack.
    LongCrack,
    /// What is left open of a stone.
    ImpactShape,
    /// Grains of a crushed zone, facets of chips and fragments.
    CrackRelief,
    /// Noise of the sensor.
    SensorNoise,
    /// Part of a photograph of broken glass that fills a frame.
    OverlayPlacement,
    /// Electrons that a faulty sensor counts, by row.
    SensorElectrons,
    /// What is fixed in each of a sensor's pixels, by row.
    SensorPattern,
    /// Places of a sensor's defects.
    SensorDefects,
    /// Phase of lamps.
    Lamps,
    /// Places of dust on a sensor's cover.
    SensorSpots,
    /// Rows of a frame whose colors are not interpolated.
    SensorRawRows,
    /// Bits that arrive wrong.
    LinkBits,
    /// Frames that do not arrive.
    Frames,
    /// Phase in which a camera trembles.
    Shake,
    /// Drops of rain, and what each leaves behind where it runs.
    Rain,
    /// Where more water condenses, and where less.
    Condensation,
    /// Grains of dust, and where there are more.
    Dust,
    /// Splats of mud.
    Mud,
    /// Waves of a film.
    Film,
    /// Nuclei and branches of ice.
    Frost,
}

impl Stream {
    /// At most 16 bytes; a part of the key, so never to be changed.
    fn name(self) -> &'static [u8] {
        match self {
            Self::Particles => b"particles",
            Self::ImpactPosition => b"impact-position",
            Self::ImpactDirection => b"impact-direction",
            Self::StoneFlaws => b"stone-flaws",
            Self::TipJitter => b"tip-jitter",
            Self::CrackTilt => b"crack-tilt",
            Self::Rings => b"rings",
            Self::Dice => b"dice",
            Self::LongCrack => b"long-crack",
            Self::ImpactShape => b"impact-shape",
            Self::CrackRelief => b"crack-relief",
            Self::SensorNoise => b"sensor-noise",
            Self::OverlayPlacement => b"overlay-place",
            Self::SensorElectrons => b"sensor-electrons",
            Self::SensorPattern => b"sensor-pattern",
            Self::SensorDefects => b"sensor-defects",
            Self::Lamps => b"lamps",
            Self::SensorSpots => b"sensor-spots",
            Self::SensorRawRows => b"sensor-raw-rows",
            Self::LinkBits => b"link-bits",
            Self::Frames => b"frames",
            Self::Shake => b"shake",
            Self::Rain => b"rain",
            Self::Condensation => b"condensation",
            Self::Dust => b"dust",
            Self::Mud => b"mud",
            Self::Film => b"film",
            Self::Frost => b"frost",
        }
    }
}

impl Seed {
    /// The `index`-th stream for one purpose: ChaCha8 keyed by (seed, name, index).
    ///
    /// Its numbers are the same on every platform and for any order of calls.
    #[must_use]
    pub fn stream(self, stream: Stream, index: u64) -> ChaCha8Rng {
        let mut key = [0_u8; 32];
        key[..8].copy_from_slice(&self.0.to_le_bytes());
        let name = stream.name();
        key[8..8 + name.len()].copy_from_slice(name);
        key[24..].copy_from_slice(&index.to_le_bytes());
        ChaCha8Rng::from_seed(key)
    }

    /// The seed of one item of a set: the first 53 bits of SHA-256(seed, path, sample index).
    ///
    /// `path` is the item's path inside its set, with `/` between its parts. 53 bits, so that
    /// the number survives every JSON reader.
    #[must_use]
    pub fn of_item(self, path: &str, sample_idx: u64) -> Self {
        let digest = Sha256::new()
            .chain_update(self.0.to_le_bytes())
            .chain_update(sample_idx.to_le_bytes())
            .chain_update(path.as_bytes())
            .finalize();
        let mut head = [0_u8; 8];
        head.copy_from_slice(&digest[..8]);
        Self(u64::from_be_bytes(head) >> 11)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::Rng;

    #[test]
    fn streams_differ_by_seed_name_and_index_and_repeat() {
        let first = |seed: u64, stream, index| Seed(seed).stream(stream, index).next_u64();
        let reference = first(1, Stream::Particles, 0);
        assert_eq!(
            reference,
            first(1, Stream::Particles, 0),
            "a stream repeats"
        );
        assert_ne!(reference, first(2, Stream::Particles, 0), "by seed");
        assert_ne!(reference, first(1, Stream::ImpactPosition, 0), "by name");
        assert_ne!(reference, first(1, Stream::Particles, 1), "by index");
    }

    #[test]
    fn stream_names_are_distinct_and_fit_the_key() {
        let names = [
            Stream::Particles,
            Stream::ImpactPosition,
            Stream::ImpactDirection,
            Stream::StoneFlaws,
            Stream::TipJitter,
            Stream::CrackTilt,
            Stream::Rings,
            Stream::Dice,
            Stream::LongCrack,
            Stream::ImpactShape,
            Stream::CrackRelief,
            Stream::SensorNoise,
            Stream::OverlayPlacement,
            Stream::SensorElectrons,
            Stream::SensorPattern,
            Stream::SensorDefects,
            Stream::Lamps,
            Stream::SensorSpots,
            Stream::SensorRawRows,
            Stream::LinkBits,
            Stream::Frames,
            Stream::Shake,
            Stream::Rain,
            Stream::Condensation,
            Stream::Dust,
            Stream::Mud,
            Stream::Film,
            Stream::Frost,
        ]
        .map(Stream::name);
        for (i, name) in names.iter().enumerate() {
            assert!(name.len() <= 16, "a name fits its 16 bytes of the key");
            assert!(!names[..i].contains(name), "a name stands for one purpose");
        }
    }

    #[test]
    fn item_seeds_fit_in_53_bits() {
        for i in 0..1000 {
            assert!(
                Seed(3).of_item("a/b.png", i).0 < 1 << 53,
                "every JSON reader keeps it"
            );
        }
    }
}
