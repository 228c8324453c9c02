//! Frame sizes that a bank for one dataset is to be baked for.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use rayon::prelude::*;
use starbreak_dataset::{Source, image_size};

/// The sizes of a dataset's images.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameSizes {
    /// Width and height, px, with the number of images of that size: the most frequent first, of
    /// equally frequent ones the smallest.
    pub by_frequency: Vec<((u32, u32), u64)>,
    /// Images whose size could not be read.
    pub n_unreadable: u64,
}

impl FrameSizes {
    /// The sizes of all images of a dataset, from their headers.
    #[must_use]
    pub fn of(source: &Source) -> Self {
        let sizes: Vec<Option<(u32, u32)>> = source
            .images()
            .filter_map(Result::ok)
            .par_bridge()
            .map(|image| image_size(&image.path).ok())
            .collect();
        let mut counts = BTreeMap::<(u32, u32), u64>::new();
        for size in sizes.iter().flatten() {
            *counts.entry(*size).or_default() += 1;
        }
        let mut by_frequency: Vec<_> = counts.into_iter().collect();
        by_frequency.sort_by_key(|(size, n)| (Reverse(*n), *size));
        Self {
            by_frequency,
            n_unreadable: sizes.iter().filter(|size| size.is_none()).count() as u64,
        }
    }

    /// The `n` most frequent sizes, and the number of images that have another.
    #[must_use]
    pub fn most_frequent(&self, n: usize) -> (Vec<(u32, u32)>, u64) {
        let (taken, left) = self.by_frequency.split_at(n.min(self.by_frequency.len()));
        let sizes = taken.iter().map(|(size, _)| *size).collect();
        (sizes, left.iter().map(|(_, n_images)| n_images).sum())
    }
}
