//! Ways in which classes can be wrong.

use std::collections::BTreeMap;

use hotcoco::primitives::assign::lsap;

use super::{ClassMap, ClassMove, Confusion};
use crate::labels::LabelSet;

/// Detected classes with a place in the labels for each, where there is one.
type ToLabels = Vec<Option<u32>>;

/// A map with what it makes of the classes, per half of the images.
pub(super) struct Candidate {
    pub(super) map: ClassMap,
    pub(super) to_labels: [ToLabels; 2],
}

pub(super) fn candidates(labels: &LabelSet, halves: &[Confusion; 2]) -> Vec<Candidate> {
    let ids: Vec<i64> = labels.categories.iter().map(|it| it.id).collect();
    let place_of: BTreeMap<i64, u32> = ids.iter().copied().zip(0..).collect();
    let n = i64::try_from(ids.len()).unwrap_or(i64::MAX);
    let place = |place: i64| {
        let place = u32::try_from(place).ok()?;
        (i64::from(place) < n).then_some(place)
    };
    // What a detected number really is. A detected category has the number of its place.
    let rule = |map: ClassMap, real: &dyn Fn(i64, i64) -> Option<u32>| {
        let to_labels: ToLabels = ids.iter().zip(0..).map(|(id, at)| real(*id, at)).collect();
        Candidate {
            map,
            to_labels: [to_labels.clone(), to_labels],
        }
    };
    let mut found = Vec::new();
    for by in [-2, -1, 1, 2] {
        let of_id = |id: i64, _: i64| place_of.get(&id.checked_sub(by)?).copied();
        found.push(rule(ClassMap::IdShift { by }, &of_id));
        let of_place = |_: i64, at: i64| place(at - by);
        found.push(rule(ClassMap::PlaceShift { by }, &of_place));
    }
    for first in [0, 1] {
        let of_place = |id: i64, _: i64| place(id.checked_sub(first)?);
        found.push(rule(ClassMap::PlaceAsId { first }, &of_place));
        let of_id = |_: i64, at: i64| place_of.get(&(at + first)).copied();
        found.push(rule(ClassMap::IdAsPlace { first }, &of_id));
    }
    let is_identity = |it: &Candidate| {
        it.to_labels
            .iter()
            .flat_map(|map| map.iter().zip(0_u32..))
            .all(|(to, from)| *to == Some(from))
    };
    found.retain(|it| !is_identity(it));
    // Rules that come to the same, such as both shifts where numbers have no gaps: the first stands.
    let mut distinct: Vec<Candidate> = Vec::new();
    for candidate in found {
        if !distinct
            .iter()
            .any(|it| it.to_labels == candidate.to_labels)
        {
            distinct.push(candidate);
        }
    }
    distinct.extend(permutation(halves));
    distinct
}

/// The permutation that agrees best, for each half as made from the other half.
fn permutation(halves: &[Confusion; 2]) -> Option<Candidate> {
    let [even, odd] = halves;
    let whole = Confusion::sum(halves);
    let moves: Vec<ClassMove> = best_permutation(&whole)
        .into_iter()
        .zip(0_u32..)
        .filter_map(|(labeled, detected)| {
            let labeled = labeled.filter(|it| *it != detected)?;
            let cell = |it: &(u32, u32, u64)| (it.0, it.1) == (detected, labeled);
            let n = whole.cells().find(cell).map_or(0, |it| it.2);
            (n > 0).then_some(ClassMove {
                detected,
                labeled,
                n,
            })
        })
        .collect();
    (!moves.is_empty()).then(|| Candidate {
        map: ClassMap::Permutation { moves },
        to_labels: [best_permutation(odd), best_permutation(even)],
    })
}

/// The assignment of detected to labeled classes under which most pairs agree; a class without
/// pairs keeps its own, and of equal ones the one that keeps most classes wins.
fn best_permutation(confusion: &Confusion) -> ToLabels {
    let n = confusion.n_categories();
    // Counts are whole; half a pair at most, over all classes, for keeping a class.
    let keep = 0.5 / (n.max(1) as f64);
    let gain: Vec<f64> = confusion
        .counts()
        .iter()
        .enumerate()
        .map(|(cell, count)| {
            let is_own = cell / n.max(1) == cell % n.max(1);
            *count as f64 + if is_own { keep } else { 0.0 }
        })
        .collect();
    let (_, columns) = lsap(&gain, n, n, true);
    columns
        .into_iter()
        .map(|it| u32::try_from(it).ok())
        .collect()
}
