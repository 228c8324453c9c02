//! Flags of `starbreak timeline`.

use std::path::PathBuf;

use clap::Args as ClapArgs;

/// Flags of `starbreak timeline`.
#[derive(Debug, ClapArgs)]
pub(crate) struct TimelineArgs {
    /// Labels with tracks: Scalabel or BDD100K frames (label id, videoName, frameIndex),
    /// MS-COCO with track_id or instance_id, or label_02 of KITTI's tracking benchmark. Without
    /// labels the objects are those found by the clean detections
    #[arg(value_name = "LABELS")]
    pub(crate) labels: Option<PathBuf>,
    /// Detections in the clean clip: MS-COCO results (JSON), Scalabel frames (JSON), or a
    /// folder of KITTI results; with --by-frame and several clips a folder with CLIP.json, or
    /// with a folder CLIP, for each
    #[arg(long, value_name = "PATH")]
    pub(crate) clean: PathBuf,
    /// Detections in the damaged clip
    #[arg(long, alias = "cracked", value_name = "PATH")]
    pub(crate) damaged: PathBuf,
    /// Track written by `video` beside the damaged clip (OUT.track.json), or a folder with one
    /// for each clip; CLIP=FILE names the clip of the labels it belongs to. Repeatable
    #[arg(long, value_name = "[CLIP=]FILE|DIR")]
    pub(crate) track: Vec<String>,
    /// Only this clip of the labels; repeatable
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Vec<String>,
    /// The first frame with damage, counted from 0, instead of that of the track
    #[arg(long, value_name = "K")]
    pub(crate) onset_frame: Option<u64>,
    /// Frames per second of a clip without a track
    #[arg(long, value_name = "N", conflicts_with = "track")]
    pub(crate) fps: Option<f64>,
    /// Number of frames of a clip without a track [default: that of the labels]
    #[arg(long, value_name = "N", requires = "fps", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub(crate) frames: Option<u64>,
    /// The detections number frames by their place in the clip, from 1, as `detect clip:FILE`
    /// does, instead of images as the labels do; always so with KITTI and without labels
    #[arg(long)]
    pub(crate) by_frame: bool,
    /// Number of the first frame in the labels
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) first_frame: u64,
    /// Minimum score of a detection that counts as found
    #[arg(long, value_name = "0..1", default_value_t = 0.3)]
    pub(crate) score_threshold: f64,
    /// Minimum IoU with the object
    #[arg(long, value_name = "0..1", default_value_t = 0.5)]
    pub(crate) iou: f64,
    /// Number of its frames in a row in which an object must be missed to count as lost
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) lost_for: u32,
    /// Replicates of the bootstrap over objects, 20 to 1000000
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(20..=1_000_000))]
    pub(crate) replicates: u32,
    /// Without labels: minimum score of a clean detection to follow
    #[arg(
        long,
        value_name = "0..1",
        default_value_t = 0.5,
        conflicts_with = "labels"
    )]
    pub(crate) follow_score: f64,
    /// Without labels: number of frames for which a followed object may be missing
    #[arg(long, value_name = "N", default_value_t = 2, conflicts_with = "labels")]
    pub(crate) follow_gap: u32,
    /// Without labels: minimum number of frames of a followed object
    #[arg(long, value_name = "N", default_value_t = 5, conflicts_with = "labels", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) follow_frames: u32,
    /// Name of the detector in the report [default: that of the file of clean detections]
    #[arg(long, value_name = "NAME")]
    pub(crate) detector: Option<String>,
    /// Name of the condition in the report [default: cracked]
    #[arg(long, value_name = "NAME")]
    pub(crate) condition: Option<String>,
    /// Output folder for report.html, evaluation.json and numbers.csv
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}
