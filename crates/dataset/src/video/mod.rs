//! Clips: frames out of a video file and into one by the program ffmpeg, and folders of frames.
//!
//! Every frame that ffmpeg decodes is delivered once, upright, in 8-bit RGB, with its own
//! timestamp; what is written has as many frames at the same times. Audio streams are copied packet by
//! packet. Memory holds the frame that is handed over and what fits a pipe.
//!
//! # Limits
//! Deeper colors become 8 bits and alpha is dropped; [`ClipInfo`] tells of both. Interlaced frames are taken as they are. Subtitles and data
//! streams are left out. The timestamps of `.mkv` are whole milliseconds, as that container keeps them.
//! docs/decisions/0016-video-through-ffmpeg.md says why it is done this way.

mod clip;
mod container_length;
mod folder;
mod matroska;
mod packet_times;
mod pixel_format;
mod program;
mod rate;
mod showinfo;
mod write;

pub use crate::error::VideoError;
pub use clip::{ClipInfo, ClipReader, TimedFrame};
pub use folder::{check_frame_sizes, frame_files, holds_anything, is_folder};
pub use program::Ffmpeg;
pub use rate::Fraction;
pub use write::{ClipFormat, ClipStream, ClipWriter};
