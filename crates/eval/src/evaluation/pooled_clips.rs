//! The clips of an evaluation, taken together.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::clip::FEW_AT_RISK;
use super::{TimelineResults, Warning};
use crate::EvalError;
use crate::timeline::{Survival, Timeline, TrackFate, kaplan_meier, kaplan_meier_of_clusters};

/// From so many clips on intervals take clips as what is drawn, and not objects.
const MIN_CLIPS: u64 = 5;

/// Fewer clips than these give too narrow an interval.
const FEW_CLIPS: u64 = 20;

/// How long the objects of several clips stay found, all clips with damage taken together: time counts from
/// the onset of the damage of each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PooledClips {
    /// Clips with damage.
    pub n_clips: u64,
    /// What intervals take as independent.
    pub unit: PooledUnit,
    /// Level of confidence of all intervals.
    pub level: f64,
    /// Until when any object is followed, s after the damage, clean and cracked.
    pub followed_s: [f64; 2],
    /// The clean clips under the same rules: the control.
    pub clean: Survival,
    /// The cracked clips.
    pub cracked: Survival,
}

/// What intervals take as independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PooledUnit {
    /// Clips, whose objects share their cracks and their scene.
    Clip,
    /// Objects, since the clips are too few.
    Object,
}

/// The fates of one side of all clips.
struct Fates {
    after_s: Vec<f64>,
    is_lost: Vec<bool>,
    clip: Vec<u32>,
}

impl Fates {
    fn of<'a>(sides: impl Iterator<Item = &'a Timeline>) -> Self {
        let mut fates = Self {
            after_s: Vec::new(),
            is_lost: Vec::new(),
            clip: Vec::new(),
        };
        for (clip, side) in (0_u32..).zip(sides) {
            for row in &side.tracks {
                let (after_s, is_lost) = match row.fate {
                    TrackFate::Lost { after_s, .. } => (after_s, true),
                    TrackFate::Kept { for_s } => (for_s, false),
                    TrackFate::NotAtRisk { .. } => continue,
                };
                // Whole microseconds: the same time after two onsets is one time.
                fates.after_s.push((after_s * 1e6).round() / 1e6);
                fates.is_lost.push(is_lost);
                fates.clip.push(clip);
            }
        }
        fates
    }

    /// Clips with an object at risk.
    fn n_clips(&self) -> u64 {
        self.clip.iter().collect::<BTreeSet<_>>().len() as u64
    }

    fn survival(&self, unit: PooledUnit, level: f64) -> Result<Survival, EvalError> {
        match unit {
            PooledUnit::Clip => {
                kaplan_meier_of_clusters(&self.after_s, &self.is_lost, &self.clip, level)
            }
            PooledUnit::Object => kaplan_meier(&self.after_s, &self.is_lost, level),
        }
    }
}

/// The clips with damage taken together; nothing where there are fewer than two. Intervals are between
/// clips (see [`kaplan_meier_of_clusters`]) where five or more have an object at risk.
///
/// # Errors
/// As [`kaplan_meier`].
pub fn pool_clips(clips: &[TimelineResults]) -> Result<Option<PooledClips>, EvalError> {
    let damaged: Vec<&TimelineResults> = clips
        .iter()
        .filter(|clip| clip.cracked.survival.is_some())
        .collect();
    let [first, _, ..] = damaged.as_slice() else {
        return Ok(None);
    };
    let level = first.cracked.settings.level;
    let clean = Fates::of(damaged.iter().map(|clip| &clip.clean));
    let cracked = Fates::of(damaged.iter().map(|clip| &clip.cracked));
    // The same objects are at risk on both sides.
    let unit = match cracked.n_clips() >= MIN_CLIPS && clean.n_clips() >= MIN_CLIPS {
        true => PooledUnit::Clip,
        false => PooledUnit::Object,
    };
    let last_s = |fates: &Fates| fates.after_s.iter().copied().fold(0.0, f64::max);
    Ok(Some(PooledClips {
        n_clips: damaged.len() as u64,
        unit,
        level,
        followed_s: [last_s(&clean), last_s(&cracked)],
        clean: clean.survival(unit, level)?,
        cracked: cracked.survival(unit, level)?,
    }))
}

impl PooledClips {
    /// Whether the clips together have so many objects at risk that a curve of one clip need not.
    #[must_use]
    pub fn is_enough(&self) -> bool {
        self.cracked.n >= FEW_AT_RISK
    }

    /// Whether some share has one: clips that are all alike give none.
    fn has_interval(&self) -> bool {
        let mut steps = self.clean.steps.iter().chain(&self.cracked.steps);
        steps.any(|step| step.share.interval.is_some())
    }

    /// What a reader must know before the numbers.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let n_clips = self.n_clips.into();
        if !self.is_enough() {
            warnings.push(Warning::FewAtRiskTogether {
                n_clips,
                n: self.cracked.n.into(),
            });
        }
        match self.unit {
            PooledUnit::Object => warnings.push(Warning::ObjectsAsIndependent {
                n_clips,
                least: MIN_CLIPS,
            }),
            PooledUnit::Clip if self.n_clips < FEW_CLIPS && self.has_interval() => {
                warnings.push(Warning::FewClips {
                    n_clips,
                    few: FEW_CLIPS,
                });
            }
            PooledUnit::Clip => {}
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::{PooledClips, PooledUnit, kaplan_meier_of_clusters};

    /// Six clips with four objects each, of which `is_lost` says by clip and object which are lost.
    fn said(is_lost: fn(u32, u32) -> bool) -> String {
        let all = (0..6).flat_map(|clip| (0..4).map(move |object| (clip, object)));
        let (clips, lost): (Vec<u32>, Vec<bool>) = all
            .map(|(clip, object)| (clip, is_lost(clip, object)))
            .unzip();
        let times_s: Vec<f64> = lost.iter().map(|is| if *is { 0.1 } else { 1.0 }).collect();
        let curve = kaplan_meier_of_clusters(&times_s, &lost, &clips, 0.95).unwrap();
        let pooled = PooledClips {
            n_clips: 6,
            unit: PooledUnit::Clip,
            level: 0.95,
            followed_s: [1.0; 2],
            clean: curve.clone(),
            cracked: curve,
        };
        let texts: Vec<String> = pooled.warnings().iter().map(ToString::to_string).collect();
        texts.join("; ")
    }

    #[test]
    fn an_interval_that_is_not_there_is_not_too_narrow() {
        let alike = said(|_, object| object == 0);
        assert!(!alike.contains("too narrow"), "{alike}");
        let other = said(|clip, object| object < clip % 2);
        assert!(other.contains("too narrow"), "{other}");
    }
}
