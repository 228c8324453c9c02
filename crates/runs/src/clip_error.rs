//! Why a clip was refused.

use std::path::PathBuf;

/// What is wrong with a request for a clip, as one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClipError {
    /// Frames of a folder into a clip, or at a time, without a rate.
    #[error(
        "{input:?} is a folder of frames, which has no frame rate; give it with --fps, for example --fps 10"
    )]
    NoRate {
        /// The folder.
        input: PathBuf,
    },
    /// A rate for a clip that has its own.
    #[error(
        "--fps is for folders of frames: {input:?} has a frame rate of its own; leave --fps out"
    )]
    OwnRate {
        /// The clip.
        input: PathBuf,
    },
    /// Lossless frames in a folder.
    #[error(
        "--lossless is for .mkv clips: {output:?} is a folder, whose PNG frames are lossless; leave --lossless out"
    )]
    LosslessFolder {
        /// The folder.
        output: PathBuf,
    },
    /// The impact is not within the clip.
    #[error(
        "--impact-at {impact_at_s} s: the clip's last frame comes at {last_frame_s:.3} s; choose a time from 0 to that"
    )]
    ImpactTime {
        /// What was asked for, s.
        impact_at_s: f64,
        /// Time of the last frame, s.
        last_frame_s: f64,
    },
    /// The impact is at no time of a clip without an end.
    #[error("--impact-at {impact_at_s} s: expected a time from 0 on, s after the first frame")]
    LiveImpactTime {
        /// What was asked for, s.
        impact_at_s: f64,
    },
    /// A frame that comes after a later one.
    #[error("frame {frame_idx} comes after frame {}; frames go on in their order", .next_idx - 1)]
    FrameBefore {
        /// Which frame, from 0.
        frame_idx: u64,
        /// The first that may come.
        next_idx: u64,
    },
    /// A growth time that is none.
    #[error("--growth-time {growth_time_s} s: expected more than 0 s, up to 86400 s")]
    GrowthTime {
        /// What was asked for, s.
        growth_time_s: f64,
    },
    /// Growth at its own speed of cracks that count steps.
    #[error(
        "these cracks grow in steps, not in time; say with --growth-time S how many seconds they are to take"
    )]
    NoSpeed,
    /// An impact where nothing breaks.
    #[error(
        "no glass breaks, so nothing is hit and nothing grows; leave --impact-at and --grow out, and give the faults an \
         onset_s (--set noise.onset_s=2)"
    )]
    NothingBreaks,
    /// Growth of a photograph.
    #[error("a photograph of broken glass does not grow; leave --grow out")]
    NoNetwork,
    /// Growth of cracks that keep no arrival times.
    #[error(
        "the network keeps no arrival times, so it cannot grow; leave --grow out, or use a network with arrival_us"
    )]
    NoArrivals,
    /// An output in the place of the input, or among its frames.
    #[error("the output {output:?} lies inside the input folder {input:?}; choose another place")]
    OutputInInput {
        /// The input folder.
        input: PathBuf,
        /// The output.
        output: PathBuf,
    },
    /// Frames or masks into a folder that holds something already.
    #[error(
        "the folder {folder:?} is not empty, and its files would lie among those of this clip; choose another \
         folder, or empty it first"
    )]
    FolderNotEmpty {
        /// The folder of frames or of masks.
        folder: PathBuf,
    },
    /// A clip in the place of the input.
    #[error("the output {output:?} would replace the input; choose another name")]
    ClipIsInput {
        /// The clip.
        output: PathBuf,
    },
    /// The masks would lie among the frames.
    #[error(
        "the masks {masks:?} and the frames {output:?} would lie in one folder; choose another for the masks"
    )]
    MasksAmongFrames {
        /// The folder of masks.
        masks: PathBuf,
        /// The folder of frames.
        output: PathBuf,
    },
}
