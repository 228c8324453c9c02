//! Why a clip could not be read or written.

use std::io;
use std::path::PathBuf;

use super::one_line;

/// What went wrong with a clip, as one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VideoError {
    /// There is no ffmpeg, or it cannot be started.
    #[error(
        "clips are read and written by the program ffmpeg, which {program:?} did not start: {}; \
         install it (Debian, Ubuntu, Fedora: package ffmpeg; Arch: pacman -S ffmpeg; macOS: brew install ffmpeg; \
         Windows: winget install ffmpeg) or name it with --ffmpeg PATH; a folder of PNG or JPEG frames needs none",
        one_line(.source)
    )]
    NoFfmpeg {
        /// What was started.
        program: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Something else than ffmpeg answers.
    #[error(
        "{program:?} is not ffmpeg: asked for its version it said {said:?}; name the program with --ffmpeg PATH"
    )]
    NotFfmpeg {
        /// What was started.
        program: PathBuf,
        /// Its first line.
        said: String,
    },
    /// The file is no clip, or not all of it is.
    #[error(
        "{path:?} cannot be read as a clip: {said}; if a player shows it, repair it first, for example with \
         `ffmpeg -i IN -c:v ffv1 -c:a copy REPAIRED.mkv`"
    )]
    Clip {
        /// The file.
        path: PathBuf,
        /// What ffmpeg said.
        said: String,
    },
    /// A file of audio or other streams alone.
    #[error("{path:?} has no video stream; choose a clip with one")]
    NoVideo {
        /// The file.
        path: PathBuf,
    },
    /// The frames are larger than any image may be.
    #[error(
        "{path:?} has frames of {width_px} x {height_px} px; the limit is {max_side_px} px per side and {max_pixels} \
         px in all, so scale the clip down"
    )]
    FrameTooLarge {
        /// The file.
        path: PathBuf,
        /// Width of a frame, px.
        width_px: u32,
        /// Height of a frame, px.
        height_px: u32,
        /// The limit of each side, px.
        max_side_px: u32,
        /// The limit of width times height, px.
        max_pixels: u64,
    },
    /// A clip whose frames are not all of one size.
    #[error(
        "frame {frame_idx} of {path:?} is {width_px} x {height_px} px, but frame 0 is {expected_width_px} x \
         {expected_height_px} px; bring all frames to one size"
    )]
    FrameSize {
        /// The clip or the file of the frame.
        path: PathBuf,
        /// Index of the frame, from 0.
        frame_idx: u64,
        /// Its width, px.
        width_px: u32,
        /// Its height, px.
        height_px: u32,
        /// Width of frame 0, px.
        expected_width_px: u32,
        /// Height of frame 0, px.
        expected_height_px: u32,
    },
    /// A folder whose frames are not all of one size.
    #[error(
        "{path:?} is {width_px} x {height_px} px, but {first:?}, a frame before it, is {first_width_px} x \
         {first_height_px} px; bring all frames to one size"
    )]
    FileSize {
        /// The first file of another size.
        path: PathBuf,
        /// Its width, px.
        width_px: u32,
        /// Its height, px.
        height_px: u32,
        /// The first file.
        first: PathBuf,
        /// Width of that, px.
        first_width_px: u32,
        /// Height of that, px.
        first_height_px: u32,
    },
    /// ffmpeg did not take the frames.
    #[error("{path:?} cannot be written: {said}; {way_out}")]
    Write {
        /// The clip that was to be written.
        path: PathBuf,
        /// What ffmpeg said, or how it ended.
        said: String,
        /// What to do.
        way_out: &'static str,
    },
    /// The extension of the output is none of a known container.
    #[error(
        "{path:?}: a clip is written as .mp4, .m4v, .mov, .mkv, .avi or .gif; choose one of them, or end the name with / \
         for a folder of frames"
    )]
    OutputFormat {
        /// The output.
        path: PathBuf,
    },
    /// A lossless clip in a container that has no codec for it here.
    #[error("{path:?}: a lossless clip is written as .mkv (FFV1); choose that extension")]
    Lossless {
        /// The output.
        path: PathBuf,
    },
    /// A container of constant rate for a clip of variable rate.
    #[error(
        "{input:?} has a variable frame rate, which .avi cannot hold; write {output:?} as .mp4, .mov or .mkv"
    )]
    VariableRate {
        /// The clip.
        input: PathBuf,
        /// The output.
        output: PathBuf,
    },
    /// More frames per second than a GIF shows.
    #[error(
        "{input:?} has {rate:.4} frames per second, and a .gif shows at most 50; write {output:?} as .mp4, or give \
         fewer frames"
    )]
    GifRate {
        /// The clip.
        input: PathBuf,
        /// The output.
        output: PathBuf,
        /// Its frames per second.
        rate: f64,
    },
    /// A folder without frames.
    #[error("{path:?} has no frames; expected files that end in .png, .jpg or .jpeg")]
    NoFrames {
        /// The folder.
        path: PathBuf,
    },
    /// A number that is no frame rate.
    #[error(
        "frame rate {given:?}: expected frames per second, 0.001 to 1000, such as 25, 29.97 or 30000/1001"
    )]
    Rate {
        /// What was given.
        given: String,
    },
}

impl VideoError {
    /// Whether the work failed and not the input: the encoder died, or the disk is full.
    #[must_use]
    pub fn is_failure_of_work(&self) -> bool {
        matches!(self, Self::Write { .. })
    }
}
