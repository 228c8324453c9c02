//! `video` as it is typed.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use starbreak_runs::clip::{Growth, Light};

use super::overlay::OverlayArgs;

/// Flags of `starbreak video`.
#[derive(Debug, Args)]
pub(crate) struct VideoArgs {
    /// A clip, or a folder of PNG or JPEG frames in the order of their names
    #[arg(value_name = "IN")]
    pub(crate) input: PathBuf,
    /// Output clip (.mp4, .m4v, .mov: H.264; .mkv; .avi: Motion JPEG; .gif), or a new or empty
    /// folder. OUT.track.json and OUT.network.json are written beside it
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) damage: DamageArgs,
    /// New or empty folder for a region mask and a crack mask of each frame
    #[arg(long, value_name = "DIR")]
    pub(crate) masks: Option<PathBuf>,
    /// Frame rate of a folder of frames, e.g. 10, 29.97 or 30000/1001
    #[arg(long, value_name = "N")]
    pub(crate) fps: Option<String>,
    /// Write FFV1 in .mkv: 8-bit RGB frames without further loss
    #[arg(long)]
    pub(crate) lossless: bool,
    /// Light around the camera: the mean of about the last second, or that of the first frame
    #[arg(long, value_enum, default_value_t = LightWord::Follow)]
    pub(crate) light: LightWord,
    #[command(flatten)]
    pub(crate) reader: FfmpegArgs,
}

/// The damage of frames that follow each other, and its time.
#[derive(Debug, Args)]
pub(crate) struct DamageArgs {
    /// Time of the impact, s after the first frame; earlier frames stay unchanged
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub(crate) impact_at: f64,
    #[command(flatten)]
    pub(crate) growth: GrowthArgs,
    /// Take a crack from a bank made by `starbreak patterns`, chosen by the seed, with the
    /// bank's recipe; only output.…, coats and faults of the camera can then be set
    #[arg(long, value_name = "DIR", conflicts_with_all = ["preset", "recipe", "severity", "camera"])]
    pub(crate) bank: Option<PathBuf>,
    /// Use this crack network (JSON or SVG) instead of simulating one
    #[arg(long, value_name = "FILE", conflicts_with = "bank")]
    pub(crate) network: Option<PathBuf>,
    /// Use this photo of broken glass (PNG or JPEG) instead of simulated cracks
    #[arg(long, value_name = "FILE", conflicts_with_all = ["network", "bank", "grow", "growth_time"])]
    pub(crate) overlay: Option<PathBuf>,
    /// Take a random part of the photo, by the seed, instead of all of it
    #[arg(long, requires = "overlay")]
    pub(crate) overlay_random: bool,
    #[command(flatten)]
    pub(crate) overlay_args: OverlayArgs,
}

/// How cracks grow.
#[derive(Debug, Args)]
pub(crate) struct GrowthArgs {
    /// Let the cracks grow after the impact at their physical speed, which is mostly less than
    /// one frame
    #[arg(long)]
    grow: bool,
    /// Slow the growth down to this many seconds from the first to the last arrival of a crack
    #[arg(
        long,
        value_name = "S",
        requires = "grow",
        allow_negative_numbers = true
    )]
    growth_time: Option<f64>,
}

impl GrowthArgs {
    /// What is asked for.
    pub(crate) fn growth(&self) -> Growth {
        match (self.grow, self.growth_time) {
            (false, _) => Growth::Whole,
            (true, None) => Growth::OwnSpeed,
            (true, Some(time_s)) => Growth::Stretched { time_s },
        }
    }
}

/// What reads and writes clips.
#[derive(Debug, Args)]
pub(crate) struct FfmpegArgs {
    /// The ffmpeg program, which reads and writes clips [default: the one on PATH]
    #[arg(
        long,
        value_name = "PATH",
        default_value = "ffmpeg",
        hide_default_value = true
    )]
    pub(crate) ffmpeg: PathBuf,
}

/// Which light a crack is under.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LightWord {
    /// That of the first frame
    First,
    /// The mean of about the last second
    Follow,
}

impl LightWord {
    /// What it says.
    pub(crate) fn light(self) -> Light {
        match self {
            Self::First => Light::First,
            Self::Follow => Light::Follow,
        }
    }
}
