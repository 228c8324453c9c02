use std::fmt;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Something that a reader must know before the numbers, in plain words, with the way out.
///
/// As JSON it is `{kind, text}`; read back it is [`Warning::Read`], which is equal to what was written.
#[derive(Debug, Clone, thiserror::Error, Serialize, Deserialize)]
#[serde(into = "Written", from = "Written")]
#[expect(missing_docs, reason = "each text says what the values in it are")]
#[non_exhaustive]
pub enum Warning {
    #[error(
        "{n} objects have a negative area in the labels, the first is object {first_id} with {first_area_px2} px²; as in \
         MS-COCO, they are in no area range and count nowhere; correct `area` if they should count"
    )]
    AreasBelowZero {
        n: Span,
        first_id: i64,
        first_area_px2: f64,
    },
    #[error(
        "{n_frames} of {n_labeled} labeled frames have a result file; as in KITTI's development kit, the others are not \
         evaluated"
    )]
    FramesWithoutResults { n_frames: Span, n_labeled: Span },
    #[error(
        "{n} of {n_all} detections on the {side} side have categories that the labels lack (first: {first:?}); they are \
         ignored"
    )]
    UnknownCategories {
        side: String,
        n: Span,
        n_all: Span,
        first: String,
    },
    #[error(
        "{n_clean} of {n_images} images have detections only on the clean side and {n_cracked} only on the damaged side; \
         if a results file does not cover all images, every difference is wrong: run the detector on all of them"
    )]
    OneSided {
        n_clean: Span,
        n_cracked: Span,
        n_images: Span,
    },
    #[error(
        "{n} of {n_images} images could not be damaged or run through a detector and count nowhere"
    )]
    ImagesNotSeen { n: Span, n_images: Span },
    /// What to do about the classes, in words of the audit.
    #[error("{0}")]
    Classes(String),
    #[error(
        "with {n_replicates} replicates no p is below 1/{n_replicates}, which after the correction for so many tests \
         decides nothing; use --replicates {needed} or more"
    )]
    FewReplicates { n_replicates: u32, needed: u32 },
    #[error("intervals are over {n} {units}; over fewer than {few} they are too narrow")]
    FewUnits { n: Span, units: String, few: u32 },
    #[error(
        "the region is {median_percent:.1} % of an image (median), less than {small_percent:.0} %, so little can be \
         lost; for more, use a higher severity, or of broken glass a smaller glass.distance_m or a larger impact.count"
    )]
    SmallDamage {
        median_percent: Span,
        small_percent: f64,
    },
    #[error(
        "the region contains {n} objects, fewer than {few}, so no number is given for it; use more images, or, where \
         it is not the whole image, a higher severity, or of broken glass a smaller glass.distance_m or a larger impact.count"
    )]
    FewObjectsInRegion { n: Span, few: u64 },
    #[error(
        "{n} of {n_classes} classes in the region have too few objects for an AP of their own (fewer than {few}); they \
         still count in the AP of all classes"
    )]
    FewObjectsOfClasses { n: Span, n_classes: Span, few: u64 },

    #[error(
        "AP50 of the objects outside the region (τ = {tau}) changes by {change_points:.1} points (p below 0.01); they \
         should be a control, so part of the damage reaches beyond the region, or the two sides differ in something \
         else; a smaller optics.region_threshold makes the region larger"
    )]
    ControlMoves { change_points: Span, tau: f64 },

    // Of clips.
    #[error(
        "clip {clip}: no detections on the {side} side in any of its {n_frames} frames; if the detector was not run on \
         them, everything that follows is wrong"
    )]
    NoDetections {
        clip: String,
        side: String,
        n_frames: Span,
    },
    #[error(
        "clip {clip}: detections on the {side} side end at frame {end}, on the {other} side at {other_end} of {last}; if \
         the detector was stopped there, objects count as lost in frames that it never processed"
    )]
    DetectionsEndEarly {
        clip: String,
        side: String,
        end: Span,
        other: String,
        other_end: Span,
        last: Span,
    },
    #[error(
        "clip {clip}: detections on the {side} side begin at frame {begin}, on the {other} side at {other_begin}; if the \
         detector was started there, objects count as missed in frames that it never processed"
    )]
    DetectionsBeginLate {
        clip: String,
        side: String,
        begin: Span,
        other: String,
        other_begin: Span,
    },
    #[error(
        "clip {clip}: the labels end at frame {last}, the clip has {n_frames} frames, counted from 0; if the track is \
         that of a longer clip, everything that follows is wrong; otherwise objects are followed up to there"
    )]
    LabelsEndEarly {
        clip: String,
        last: Span,
        n_frames: Span,
    },
    #[error("{}: its file names are read as frame numbers, counted from {first}", path.display())]
    NumberedFrames { path: PathBuf, first: u64 },
    #[error(
        "clip {clip}: there are no labels, so the ground truth is what the detector itself finds in the clean clip, \
         including its errors; what it misses there is not counted, and the clean clip finds everything by construction, \
         so it is no control"
    )]
    NoLabels { clip: String },
    #[error("clip {clip}: no onset of damage, so there is no time to detection loss")]
    NoDamage { clip: String },
    #[error("clip {clip}: only {n} objects are at risk of being lost; use longer clips or several")]
    FewAtRisk { clip: String, n: Span },
    #[error(
        "the {n_clips} clips together: only {n} objects are at risk of being lost; use longer clips or more"
    )]
    FewAtRiskTogether { n_clips: Span, n: Span },
    #[error(
        "the {n_clips} clips together: fewer than {least} have objects at risk, so intervals treat objects as \
         independent; they are too narrow, because objects of one clip share its damage"
    )]
    ObjectsAsIndependent { n_clips: Span, least: u64 },
    #[error(
        "the {n_clips} clips together: intervals use the variance between clips; with fewer than {few} they are too \
         narrow"
    )]
    FewClips { n_clips: Span, few: u64 },

    /// From JSON.
    #[error("{text}")]
    Read { kind: WarningKind, text: String },
}

/// What a warning is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WarningKind {
    /// The classes of the detector may not be those of the labels.
    LabelMap,
    /// There is little to count.
    SmallSample,
    /// Numbers are refused.
    Refused,
    /// Something is not as the protocol has it.
    Protocol,
    /// Files or images are missing.
    Missing,
}

/// A number, or the least and the greatest one of several warnings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Span([f64; 2]);

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.0.map(|value| match f.precision() {
            Some(n_digits) => format!("{value:.n_digits$}"),
            None => value.to_string(),
        });
        f.write_str(&least)?;
        match least == most {
            true => Ok(()),
            false => write!(f, " to {most}"),
        }
    }
}

impl From<f64> for Span {
    fn from(value: f64) -> Self {
        Self([value; 2])
    }
}

impl From<u32> for Span {
    fn from(n: u32) -> Self {
        f64::from(n).into()
    }
}

impl From<u64> for Span {
    fn from(n: u64) -> Self {
        crate::protocol::exact(n).into()
    }
}

impl From<usize> for Span {
    fn from(n: usize) -> Self {
        (n as u64).into()
    }
}

impl Warning {
    /// What it is about.
    #[must_use]
    pub fn kind(&self) -> WarningKind {
        match self {
            Self::UnknownCategories { .. } | Self::Classes(_) => WarningKind::LabelMap,
            Self::FewUnits { .. }
            | Self::FewReplicates { .. }
            | Self::SmallDamage { .. }
            | Self::FewObjectsInRegion { .. }
            | Self::FewAtRisk { .. }
            | Self::FewAtRiskTogether { .. }
            | Self::ObjectsAsIndependent { .. }
            | Self::FewClips { .. } => WarningKind::SmallSample,
            Self::FewObjectsOfClasses { .. } | Self::NoDamage { .. } => WarningKind::Refused,
            Self::AreasBelowZero { .. }
            | Self::FramesWithoutResults { .. }
            | Self::NumberedFrames { .. }
            | Self::ControlMoves { .. }
            | Self::NoLabels { .. } => WarningKind::Protocol,
            Self::OneSided { .. }
            | Self::ImagesNotSeen { .. }
            | Self::NoDetections { .. }
            | Self::DetectionsEndEarly { .. }
            | Self::DetectionsBeginLate { .. }
            | Self::LabelsEndEarly { .. } => WarningKind::Missing,
            Self::Read { kind, .. } => *kind,
        }
    }

    /// Takes another warning in, with the least and the greatest of their numbers, if it says the same but
    /// for these.
    pub(crate) fn takes_in(&mut self, other: &Self) -> bool {
        let mut other = other.clone();
        let [mut own_words, mut other_words] = [self.clone(), other.clone()];
        for words in [&mut own_words, &mut other_words] {
            for number in words.numbers() {
                *number = Span::default();
            }
        }
        if own_words != other_words {
            return false;
        }
        for (own, other) in self.numbers().into_iter().zip(other.numbers()) {
            own.0 = [own.0[0].min(other.0[0]), own.0[1].max(other.0[1])];
        }
        true
    }

    fn numbers(&mut self) -> Vec<&mut Span> {
        match self {
            Self::AreasBelowZero { n, .. }
            | Self::FewUnits { n, .. }
            | Self::FewObjectsInRegion { n, .. }
            | Self::FewAtRisk { n, .. } => vec![n],
            Self::FramesWithoutResults {
                n_frames: a,
                n_labeled: b,
            }
            | Self::UnknownCategories { n: a, n_all: b, .. }
            | Self::ImagesNotSeen { n: a, n_images: b }
            | Self::FewObjectsOfClasses {
                n: a, n_classes: b, ..
            }
            | Self::LabelsEndEarly {
                last: a,
                n_frames: b,
                ..
            }
            | Self::DetectionsBeginLate {
                begin: a,
                other_begin: b,
                ..
            }
            | Self::FewAtRiskTogether { n_clips: a, n: b } => vec![a, b],
            Self::OneSided {
                n_clean: a,
                n_cracked: b,
                n_images: c,
            }
            | Self::DetectionsEndEarly {
                end: a,
                other_end: b,
                last: c,
                ..
            } => vec![a, b, c],
            Self::SmallDamage { median_percent, .. } => vec![median_percent],
            Self::ControlMoves { change_points, .. } => vec![change_points],
            Self::NoDetections { n_frames, .. } => vec![n_frames],
            Self::ObjectsAsIndependent { n_clips, .. } | Self::FewClips { n_clips, .. } => {
                vec![n_clips]
            }
            Self::Classes(_)
            | Self::FewReplicates { .. }
            | Self::NumberedFrames { .. }
            | Self::NoLabels { .. }
            | Self::NoDamage { .. }
            | Self::Read { .. } => Vec::new(),
        }
    }
}

/// Those are equal that say the same.
impl PartialEq for Warning {
    fn eq(&self, other: &Self) -> bool {
        self.kind() == other.kind() && self.to_string() == other.to_string()
    }
}

/// A warning as JSON.
#[derive(Serialize, Deserialize)]
struct Written {
    kind: WarningKind,
    text: String,
}

impl From<Warning> for Written {
    fn from(warning: Warning) -> Self {
        Self {
            kind: warning.kind(),
            text: warning.to_string(),
        }
    }
}

impl From<Written> for Warning {
    fn from(Written { kind, text }: Written) -> Self {
        Self::Read { kind, text }
    }
}

#[cfg(test)]
mod tests {
    use super::Warning;

    #[test]
    fn keys_of_broken_glass_are_named_as_such() {
        let small = Warning::SmallDamage {
            median_percent: 1.0.into(),
            small_percent: 2.0,
        };
        let few = Warning::FewObjectsInRegion {
            n: 3_u64.into(),
            few: 20,
        };
        for text in [small, few].map(|warning| warning.to_string()) {
            let all = "a higher severity, or of broken glass a smaller glass.distance_m";
            assert!(text.contains(all), "{text}");
        }
    }

    #[test]
    fn like_warnings_are_one_with_the_span_of_their_numbers() {
        let small = |median_percent: f64| Warning::SmallDamage {
            median_percent: median_percent.into(),
            small_percent: 2.0,
        };
        let mut one = small(1.26);
        assert!(one.takes_in(&small(0.8)), "alike");
        assert!(one.takes_in(&small(1.3)), "alike");
        let text = one.to_string();
        assert!(text.contains("is 0.8 to 1.3 % of an image"), "{text}");
        assert!(text.contains("less than 2 %"), "{text}");
        let of_clip = |clip: &str| Warning::FewAtRisk {
            clip: clip.to_owned(),
            n: 3_u64.into(),
        };
        assert!(!of_clip("5").takes_in(&of_clip("6")), "another clip");
    }
}
