//! `pipe` as it is typed.

use clap::{Args, ValueEnum};
use starbreak::optics::Channels;

use super::parse_size;
use super::video::{DamageArgs, LightWord};

/// Flags of `starbreak pipe`.
#[derive(Debug, Args)]
#[command(after_help = "\
ffmpeg and GStreamer read and write cameras, streams and files on both sides, e.g.

  ffmpeg -v error -i rtsp://HOST/PATH -f rawvideo -pix_fmt bgr24 -s 1920x1080 - |
    starbreak pipe --size 1920x1080 --pixels bgr24 --fps 25 --late drop |
    ffplay -f rawvideo -pixel_format bgr24 -video_size 1920x1080 -

The summary is written to standard error, with --json as one line of JSON. More in docs/live.md.")]
pub(crate) struct PipeArgs {
    /// Width and height of the frames, px, e.g. 1920x1080
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Pixels of the frames, by ffmpeg's names, 8 bits per sample without padding; alpha stays, or
    /// is moved by a distortion
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) pixels: PixelsWord,
    /// Frame rate, e.g. 30, 29.97 or 30000/1001: frame k is k / N seconds after the first, and
    /// late if it takes longer than 1 / N seconds
    #[arg(long, value_name = "N", default_value = "30")]
    pub(crate) fps: String,
    /// What becomes of a frame that has waited longer than 1 / fps while the next one came: it is
    /// left out (drop), or damaged and written all the same (wait), so that whoever sends waits
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = LateWord::Wait)]
    pub(crate) late: LateWord,
    /// Name of the stream, from which its damage is drawn with --seed: with the name of a clip's
    /// or photo's file the damage is the one that `video` and `crack` give that
    #[arg(long, value_name = "NAME", default_value = "pipe")]
    pub(crate) name: String,
    #[command(flatten)]
    pub(crate) damage: DamageArgs,
    /// Light around the camera: the mean of about the last second, or that of the first frame
    #[arg(long, value_enum, default_value_t = LightWord::Follow)]
    pub(crate) light: LightWord,
}

/// What lies in a raw frame, by ffmpeg's names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PixelsWord {
    /// Red, green, blue
    Rgb24,
    /// Blue, green, red
    Bgr24,
    /// Red, green, blue, alpha
    Rgba,
    /// Blue, green, red, alpha
    Bgra,
    /// Gray
    Gray,
}

impl PixelsWord {
    /// Its name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rgb24 => "rgb24",
            Self::Bgr24 => "bgr24",
            Self::Rgba => "rgba",
            Self::Bgra => "bgra",
            Self::Gray => "gray",
        }
    }

    /// The library's word for it.
    pub(crate) fn channels(self) -> Channels {
        match self {
            Self::Rgb24 => Channels::Rgb,
            Self::Bgr24 => Channels::Bgr,
            Self::Rgba => Channels::Rgba,
            Self::Bgra => Channels::Bgra,
            Self::Gray => Channels::Gray,
        }
    }
}

/// What becomes of late frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LateWord {
    /// They are left out
    Drop,
    /// They are written all the same
    Wait,
}
