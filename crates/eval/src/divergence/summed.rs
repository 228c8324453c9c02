//! Sets that are compared without their images.

use super::ReadSettings;
use super::compare::{Pooled, compare_summed, draws, halves_differ_by, replicate, twin_of, whole};
use super::report::{CompareSettings, DivergenceReport, SetFloor};
use super::set::ImageSet;
use crate::EvalError;

/// Sets that come one after the other and are then compared, each with each: of a set stay the names, digests and
/// vectors of its images, and a sum for each bootstrap replicate, 36 kB. That is less than the images of all sets where
/// a set has more than three times as many of them as there are replicates. There are no permutations, which need the
/// images of both sets.
///
/// # Example
/// ```
/// # use image::RgbImage;
/// # use starbreak_eval::divergence::{CompareSettings, ImageSet, Item, ReadSettings, SummedSets};
/// let reading = ReadSettings::default();
/// let set = |name: &str, level: u8| {
///     let image = RgbImage::from_pixel(8, 8, image::Rgb([level; 3]));
///     let item = Item::of_image("0.png", format!("{level}"), &image, &reading, Vec::new());
///     ImageSet::new(name, vec![Ok(item)], None)
/// };
/// let settings = CompareSettings { n_bootstrap: 20, n_splits: 20, ..CompareSettings::default() };
/// let mut sets = SummedSets::new(reading, settings);
/// sets.push(set("clean", 10)?);
/// sets.push(set("cracked", 90)?);
/// assert_eq!(sets.compared()?.pairs.len(), 1);
/// # Ok::<(), starbreak_eval::EvalError>(())
/// ```
#[derive(Debug)]
pub struct SummedSets {
    reading: ReadSettings,
    settings: CompareSettings,
    sets: Vec<SummedSet>,
}

/// A set without what its images count.
#[derive(Debug)]
pub(super) struct SummedSet {
    pub(super) set: ImageSet,
    pub(super) whole: Pooled,
    pub(super) replicates: Vec<Pooled>,
    pub(super) floor: Option<SetFloor>,
}

impl SummedSets {
    /// No sets yet; [`CompareSettings::n_permutations`] does not count.
    #[must_use]
    pub fn new(reading: ReadSettings, settings: CompareSettings) -> Self {
        Self {
            reading,
            settings: CompareSettings {
                n_permutations: 0,
                ..settings
            },
            sets: Vec::new(),
        }
    }

    /// Sums a set over each draw, and drops what its images count.
    pub fn push(&mut self, mut set: ImageSet) {
        let place = self.sets.len();
        let before: Vec<&ImageSet> = self.sets.iter().map(|it| &it.set).collect();
        let twin = twin_of(&before, &set);
        let whole = whole(&set);
        let replicates = draws(self.settings.n_bootstrap, |index| {
            replicate(&set, twin, index, &self.settings)
        });
        let floor = halves_differ_by(&set, place, &whole, &self.settings);
        set.drop_counts();
        self.sets.push(SummedSet {
            set,
            whole,
            replicates,
            floor,
        });
    }

    /// Keeps the first `n` sets.
    pub fn truncate(&mut self, n: usize) {
        self.sets.truncate(n);
    }

    /// Every pair of at least two sets: what [`compare_sets`](super::compare_sets) gives of them without permutations, to the bit.
    ///
    /// # Errors
    /// As for [`compare_sets`](super::compare_sets).
    pub fn compared(&self) -> Result<DivergenceReport, EvalError> {
        compare_summed(&self.sets, &self.reading, &self.settings)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use image::RgbImage;

    use super::super::{Item, compare_sets};
    use super::*;

    /// Images by names from this one on, of levels that the seed mixes.
    fn set(name: &str, first: u32, n: u32, seed: u32) -> ImageSet {
        let mut state = seed;
        let items = (first..first + n).map(|number| {
            let image = RgbImage::from_fn(9, 7, |_, _| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let [_, _, level, other] = state.to_le_bytes();
                image::Rgb([level / 4, other / 2, level])
            });
            let name = format!("{number}.png");
            let digest = format!("{seed} {name}");
            Ok(Item::of_image(
                &name,
                digest,
                &image,
                &ReadSettings::default(),
                Vec::new(),
            ))
        });
        ImageSet::new(name, items.collect(), None).unwrap()
    }

    #[test]
    fn sets_one_after_the_other_compare_as_all_at_once() {
        let clean = set("clean", 0, 11, 1);
        // Twins of it, one of other images, a twin of that, and one image alone.
        let others = [
            set("star", 0, 11, 2),
            set("cats", 40, 6, 3),
            set("web", 0, 11, 4),
            set("wet cats", 40, 6, 5),
            set("lone", 0, 1, 6),
        ];
        let settings = CompareSettings {
            n_bootstrap: 5,
            n_permutations: 0,
            n_splits: 3,
            seed: 7,
            ..CompareSettings::default()
        };
        let reading = ReadSettings::default();
        let at_once = |sets: &[ImageSet]| compare_sets(sets, &reading, &settings).unwrap();
        let mut summed = SummedSets::new(reading, settings);
        summed.push(clean.clone());
        let mut all = vec![clean.clone()];
        for other in &others {
            summed.push(other.clone());
            all.push(other.clone());
            assert_eq!(
                summed.compared().unwrap(),
                at_once(&all),
                "{} sets",
                all.len()
            );
        }
        for other in others {
            summed.truncate(1);
            summed.push(other.clone());
            let two = at_once(&[clean.clone(), other]);
            assert_eq!(summed.compared().unwrap(), two, "the clean one and another");
        }
        summed.truncate(1);
        assert!(summed.compared().is_err(), "one set is no pair");
    }
}
