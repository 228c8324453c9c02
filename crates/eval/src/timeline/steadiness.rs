//! How steadily objects are found, and how much the damage changes that.

use serde::{Deserialize, Serialize};

use super::{TimelineSettings, Track};
use crate::EvalError;
use crate::resampling::{Plan, bootstrap};
use crate::statistic::{Measured, Method};

/// How steadily objects are found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Steadiness {
    /// Objects in frames.
    pub n_sightings: u64,
    /// Share of them found; interval by drawing tracks, which its n counts.
    pub found: Measured,
    /// From one frame of a track to its next.
    pub n_steps: u64,
    /// Share of them at which found turns to missed or back; interval likewise.
    pub flicker: Measured,
}

/// Cracked minus clean, over the same frames of the same tracks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Of the share found; interval by drawing tracks, each with both of its sides.
    pub found: Measured,
    /// Of the share of steps at which found turns to missed or back.
    pub flicker: Measured,
}

/// Counts of a track.
#[derive(Debug, Clone, Copy, Default)]
struct Steps {
    n_sightings: u64,
    n_found: u64,
    n_steps: u64,
    n_changes: u64,
}

impl Steps {
    fn of(track: &Track, counts: impl Fn(u32) -> bool) -> Self {
        let mut steps = Self::default();
        for sighting in track.sightings.iter().filter(|it| counts(it.frame)) {
            steps.n_sightings += 1;
            steps.n_found += u64::from(sighting.is_found());
        }
        // A step is of the time to which it leads.
        let pairs = track.sightings.windows(2);
        for pair in pairs.filter(|pair| counts(pair[1].frame)) {
            steps.n_steps += 1;
            steps.n_changes += u64::from(pair[0].is_found() != pair[1].is_found());
        }
        steps
    }

    fn total<'a>(all: impl Iterator<Item = &'a Self>, weights: &[u32]) -> Self {
        let mut sum = Self::default();
        for (steps, weight) in all.zip(weights) {
            let weight = u64::from(*weight);
            sum.n_sightings += weight * steps.n_sightings;
            sum.n_found += weight * steps.n_found;
            sum.n_steps += weight * steps.n_steps;
            sum.n_changes += weight * steps.n_changes;
        }
        sum
    }

    fn found(&self) -> Option<f64> {
        share(self.n_found, self.n_sightings)
    }

    fn flicker(&self) -> Option<f64> {
        share(self.n_changes, self.n_steps)
    }
}

#[expect(
    clippy::cast_precision_loss,
    reason = "counts of frames are far below 2^53"
)]
fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

fn plan(n_tracks: usize, settings: TimelineSettings) -> Plan {
    let n_tracks = u32::try_from(n_tracks).unwrap_or(u32::MAX);
    Plan::of_images(n_tracks).with(settings.n_replicates, settings.seed, settings.level)
}

pub(super) fn steadiness(
    tracks: &[Track],
    counts: impl Fn(u32) -> bool,
    settings: TimelineSettings,
) -> Result<Steadiness, EvalError> {
    let steps: Vec<Steps> = tracks
        .iter()
        .map(|track| Steps::of(track, &counts))
        .filter(|it| it.n_sightings > 0)
        .collect();
    let replicates = bootstrap(&plan(steps.len(), settings), |weights| {
        let sum = Steps::total(steps.iter(), weights);
        vec![sum.found(), sum.flicker()]
    })?;
    let all = Steps::total(steps.iter(), &vec![1; steps.len()]);
    Ok(Steadiness {
        n_sightings: all.n_sightings,
        found: replicates.percentile(0, Method::Share),
        n_steps: all.n_steps,
        flicker: replicates.percentile(1, Method::Share),
    })
}

/// How much less, and how much less steadily, objects are found from the onset of the damage on:
/// cracked minus clean over the same sightings, so that what every video does to a detector drops
/// out. `None` without an onset.
///
/// # Errors
/// [`EvalError::NotPaired`] where both sides have not the same tracks in the same frames, and those
/// of a bootstrap without sense.
pub fn change_after(
    onset: Option<u32>,
    clean: &[Track],
    cracked: &[Track],
    settings: TimelineSettings,
) -> Result<Option<Change>, EvalError> {
    let Some(onset) = onset else {
        return Ok(None);
    };
    let frames = |track: &Track| -> Vec<u32> { track.sightings.iter().map(|s| s.frame).collect() };
    let is_same = |(a, b): (&Track, &Track)| a.track == b.track && frames(a) == frames(b);
    if clean.len() != cracked.len() || !clean.iter().zip(cracked).all(is_same) {
        return Err(EvalError::NotPaired {
            what: "the tracks and their frames".to_owned(),
        });
    }
    let counts = |frame: u32| frame >= onset;
    let pairs: Vec<[Steps; 2]> = clean
        .iter()
        .zip(cracked)
        .map(|(clean, cracked)| [Steps::of(clean, counts), Steps::of(cracked, counts)])
        .filter(|[clean, _]| clean.n_sightings > 0)
        .collect();
    let difference = |clean: Option<f64>, cracked: Option<f64>| Some(cracked? - clean?);
    let replicates = bootstrap(&plan(pairs.len(), settings), |weights| {
        let clean = Steps::total(pairs.iter().map(|pair| &pair[0]), weights);
        let cracked = Steps::total(pairs.iter().map(|pair| &pair[1]), weights);
        vec![
            difference(clean.found(), cracked.found()),
            difference(clean.flicker(), cracked.flicker()),
        ]
    })?;
    Ok(Some(Change {
        found: replicates.percentile(0, Method::Difference),
        flicker: replicates.percentile(1, Method::Difference),
    }))
}
