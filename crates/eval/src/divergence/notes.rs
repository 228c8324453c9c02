//! What a reader of the numbers must know.

use super::report::PairComparison;
use super::sets::ImageSet;

/// Files that are in both sets, by their bytes.
pub(super) fn n_shared(a: &ImageSet, b: &ImageSet) -> usize {
    let mut digests: Vec<&str> = b.items.iter().map(|item| item.digest.as_str()).collect();
    digests.sort_unstable();
    let is_there = |digest: &str| digests.binary_search(&digest).is_ok();
    a.items.iter().filter(|item| is_there(&item.digest)).count()
}

/// Whether both sets have the same images by name: a clean set and its cracked twin.
pub(super) fn are_paired(a: &ImageSet, b: &ImageSet) -> bool {
    let names = |set: &ImageSet| -> Vec<String> {
        set.items.iter().map(|item| item.name.clone()).collect()
    };
    a.items.len() > 1 && names(a) == names(b)
}

/// For each set the place of the first one that has the same images by name; its own where there is none.
pub(super) fn first_twins(sets: &[ImageSet]) -> Vec<usize> {
    let of_set = |(place, set): (usize, &ImageSet)| {
        let mut earlier = sets.iter().take(place);
        let twin = earlier.position(|other| are_paired(other, set));
        twin.unwrap_or(place)
    };
    sets.iter().enumerate().map(of_set).collect()
}

/// One line for each thing.
pub(super) fn notes(sets: &[ImageSet], pairs: &[PairComparison]) -> Vec<String> {
    let mut notes = Vec::new();
    for set in sets {
        let summary = set.summary();
        let (name, n) = (&summary.name, summary.n);
        if n == 1 {
            notes.push(format!(
                "{name:?} has one image: no floor of its own, no interval; nothing can be said of its distribution"
            ));
        } else if n < 20 {
            notes.push(format!(
                "{name:?} has {n} images: intervals and floors of so few are rough"
            ));
        }
        if let Some(first) = summary.failed.first() {
            notes.push(format!(
                "{name:?}: {} of {} images could not be read, the first: {:?}: {}",
                summary.failed.len(),
                summary.failed.len() + n,
                first.name,
                first.reason
            ));
        }
        if summary.n_repeated > 0 {
            notes.push(format!(
                "{name:?} has {} images that are copies of others of it: they are not independent",
                summary.n_repeated
            ));
        }
        if summary.n_enlarged > 0 {
            notes.push(format!(
                "{name:?}: {} images were enlarged for gradients and spectra and lack fine detail by that",
                summary.n_enlarged
            ));
        }
    }
    for pair in pairs.iter().filter(|pair| pair.n_shared > 0) {
        notes.push(format!(
            "{:?} and {:?} share {} identical files: the sets are not independent, so distances are too small and p-values too large",
            pair.a, pair.b, pair.n_shared
        ));
    }
    notes
}
