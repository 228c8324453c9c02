//! Reading a clip: what it is, then its frames one by one.

use std::ffi::OsString;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::ChildStdout;

use image::RgbImage;

use super::container_length::missing_end;
use super::packet_times::PacketTimes;
use super::pixel_format::{bits_per_channel, has_alpha};
use super::program::{Ended, Running, file_arg};
use super::showinfo::{Color, FrameInfo};
use super::{Ffmpeg, Fraction, VideoError};
use crate::ordinary_file::open_file;
use crate::{DatasetError, ImageLimits};

/// What a clip is, apart from its frames.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipInfo {
    /// Width of a frame as it is shown, px: rotation is applied.
    pub width_px: u32,
    /// Height of a frame as it is shown, px.
    pub height_px: u32,
    /// Frames per second; of a clip of variable rate about the mean.
    pub rate: Fraction,
    /// Seconds per tick of its timestamps.
    pub time_base: Fraction,
    /// Timestamp of the first frame, ticks.
    pub first_ticks: i64,
    /// Number of frames that the container lists; a damaged clip may give fewer.
    pub n_frames: u64,
    /// From the first frame to the last, s.
    pub last_frame_s: f64,
    /// Whether all frames are equally far apart, as far as the clock of the container can tell.
    pub has_constant_rate: bool,
    /// Bits per channel, 8 or more; its frames are read with 8.
    pub bits_per_channel: u32,
    /// Whether it says how opaque its pixels are, which its frames do not.
    pub has_alpha: bool,
    pub(super) pixel_aspect: Option<Fraction>,
    pub(super) color: Color,
}

impl ClipInfo {
    /// The curve from light to numbers if it is one of high dynamic range, by ffmpeg's name:
    /// `smpte2084` (PQ) or `arib-std-b67` (HLG).
    #[must_use]
    pub fn high_dynamic_range(&self) -> Option<&str> {
        let transfer = self.color.transfer.as_str();
        matches!(transfer, "smpte2084" | "arib-std-b67").then_some(transfer)
    }
}

/// A frame of a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedFrame {
    /// When it is shown, ticks of [`ClipInfo::time_base`].
    pub ticks: i64,
    /// Its pixels, upright.
    pub pixels: RgbImage,
}

/// The frames of a clip, in the order in which they are shown.
///
/// ffmpeg decodes ahead by what fits a pipe; nothing else is kept. Dropping it ends ffmpeg.
#[derive(Debug)]
pub struct ClipReader {
    path: PathBuf,
    info: ClipInfo,
    /// Before the process: it is closed first.
    stdout: Option<ChildStdout>,
    running: Running,
    n_read: u64,
    last_ticks: Option<i64>,
}

impl Ffmpeg {
    /// What the first video stream of a file is: its first frame is decoded, and the packets are
    /// counted.
    ///
    /// # Errors
    /// [`VideoError::Clip`] where it has no frame that can be shown or is cut short,
    /// [`VideoError::NoVideo`] where it holds something else, [`VideoError::FrameTooLarge`],
    /// [`DatasetError::Read`] and [`DatasetError::NotAFile`] where there is no file.
    pub fn probe(&self, path: &Path) -> Result<ClipInfo, DatasetError> {
        check_file(path)?;
        let first = self.first_frame(path)?;
        let limits = ImageLimits::default();
        let (width_px, height_px) = (first.width_px, first.height_px);
        let n_pixels = u64::from(width_px) * u64::from(height_px);
        if width_px.max(height_px) > limits.max_side_px || n_pixels > limits.max_pixels {
            return Err(DatasetError::Video(VideoError::FrameTooLarge {
                path: path.to_owned(),
                width_px,
                height_px,
                max_side_px: limits.max_side_px,
                max_pixels: limits.max_pixels,
            }));
        }
        let times = self.packet_times(path)?;
        let (Some(time_base), Some(packet_base)) = (first.time_base, times.time_base) else {
            return Err(clip_error(path, "it has no clock".to_owned()).into());
        };
        let span_s = times.span_s(packet_base);
        let rate = first.rate.or_else(|| times.mean_rate(packet_base));
        let Some(rate) = rate else {
            return Err(clip_error(path, "it has no frame rate".to_owned()).into());
        };
        Ok(ClipInfo {
            width_px,
            height_px,
            rate,
            time_base,
            first_ticks: first.ticks.unwrap_or(0),
            n_frames: times.ticks.len() as u64,
            last_frame_s: span_s,
            has_constant_rate: times.has_constant_rate(packet_base, rate),
            bits_per_channel: bits_per_channel(&first.pixel_format),
            has_alpha: has_alpha(&first.pixel_format),
            pixel_aspect: first.pixel_aspect,
            color: first.color,
        })
    }

    /// The frames of a clip that was [probed](Self::probe).
    ///
    /// # Errors
    /// [`VideoError::NoFfmpeg`] where ffmpeg does not start.
    pub fn read(&self, path: &Path, info: &ClipInfo) -> Result<ClipReader, VideoError> {
        let mut args = decode_args(path);
        args.extend(["-vf".into(), self.showinfo.into()]);
        args.extend(self.every_frame());
        let output = [
            "-sws_flags",
            SCALER,
            "-f",
            "rawvideo",
            "-pix_fmt",
            "rgb24",
            "pipe:1",
        ];
        args.extend(output.map(OsString::from));
        let mut running = self.start(&args)?;
        Ok(ClipReader {
            path: path.to_owned(),
            info: info.clone(),
            stdout: running.child.take_stdout(),
            running,
            n_read: 0,
            last_ticks: None,
        })
    }

    fn first_frame(&self, path: &Path) -> Result<FrameInfo, VideoError> {
        let mut args = decode_args(path);
        args.extend(["-vf".into(), self.showinfo.into()]);
        args.extend(["-frames:v", "1", "-f", "null", "-"].map(OsString::from));
        let mut running = self.start(&args)?;
        // The log is read while it comes; what is not asked for is dropped.
        let ended = running.wait();
        match running.next_info() {
            Some(info) if info.width_px > 0 && info.height_px > 0 && ended.is_success => Ok(info),
            // `-map 0:V:0` of a file that ffmpeg can read, but for its sound alone.
            _ if ended.said.contains("matches no streams") => Err(VideoError::NoVideo {
                path: path.to_owned(),
            }),
            _ if ended.has_complained => Err(clip_error(path, ended.said)),
            _ => Err(clip_error(path, "it has no frames".to_owned())),
        }
    }

    /// When each packet of the video is shown, without decoding it; refused where the file does not
    /// go on to its end, in its audio, too.
    ///
    /// Only this run's log can be trusted with that: ffmpeg's threads share a line, and in a run
    /// with [`Self::showinfo`] the complaint of one may stand, without its level, at the end of
    /// what another says of a frame.
    fn packet_times(&self, path: &Path) -> Result<PacketTimes, VideoError> {
        let mut args = decode_args(path);
        let copied = ["-map", "0:a?", "-ignore_unknown", "-c", "copy"];
        args.extend(copied.map(OsString::from));
        args.extend(["-f", "framecrc", "pipe:1"].map(OsString::from));
        let mut running = self.start(&args)?;
        let mut times = PacketTimes::default();
        if let Some(stdout) = running.child.take_stdout() {
            for line in BufReader::new(stdout).split(b'\n') {
                let Ok(line) = line else { break };
                times.read_line(&String::from_utf8_lossy(&line));
            }
        }
        let ended = running.wait();
        if !ended.is_success || ended.has_complained {
            return Err(clip_error(path, ended.said));
        }
        times.sort();
        Ok(times)
    }
}

/// How YUV becomes RGB and back: with rounding and all of the chroma, so that a frame which nobody
/// touched comes back as it was.
pub(super) const SCALER: &str = "bicubic+accurate_rnd+full_chroma_int+full_chroma_inp";

/// A file that ffmpeg reads, and nothing but files, whatever the content asks for.
pub(super) fn input_args(path: &Path) -> Vec<OsString> {
    let mut args: Vec<OsString> = ["-protocol_whitelist", "file", "-i"]
        .map(OsString::from)
        .into();
    args.push(file_arg(path));
    args
}

/// The first stream of moving pictures, and an end at the first damage of any stream that is read.
fn decode_args(path: &Path) -> Vec<OsString> {
    let mut args: Vec<OsString> = vec!["-nostdin".into(), "-xerror".into()];
    args.extend(input_args(path));
    args.extend(["-map", "0:V:0"].map(OsString::from));
    args
}

fn clip_error(path: &Path, said: String) -> VideoError {
    VideoError::Clip {
        path: path.to_owned(),
        said,
    }
}

/// The file is there and is a file, said as of any other.
fn check_file(path: &Path) -> Result<(), DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: path.to_owned(),
        source,
    };
    let mut file = open_file(path)?;
    let n_file_bytes = file.metadata().map_err(read_error)?.len();
    if n_file_bytes == 0 {
        return Err(DatasetError::EmptyFile {
            name: path.to_string_lossy().into_owned(),
        });
    }
    if let Some(n_bytes) = missing_end(&mut file, n_file_bytes).map_err(read_error)? {
        let said = format!("it has {n_file_bytes} of the {n_bytes} bytes that its header tells of");
        return Err(clip_error(path, said).into());
    }
    Ok(())
}

impl ClipReader {
    /// The next frame; none after the last.
    ///
    /// # Errors
    /// [`VideoError::Clip`] where the clip is damaged or cut short (with the last frame at the
    /// latest), [`VideoError::FrameSize`] where its size changes.
    pub fn next_frame(&mut self) -> Result<Option<TimedFrame>, VideoError> {
        let Some(stdout) = &mut self.stdout else {
            return Ok(None);
        };
        let (width, height) = (self.info.width_px, self.info.height_px);
        let n_bytes = width as usize * height as usize * 3;
        let mut pixels = Vec::new();
        pixels
            .try_reserve_exact(n_bytes)
            .map_err(|_| clip_error(&self.path, "there is no memory for its frames".to_owned()))?;
        // An error of the pipe is its end, which ffmpeg then has the reason for.
        let _ = stdout.take(n_bytes as u64).read_to_end(&mut pixels);
        let n_read = pixels.len();
        let info = (n_read > 0).then(|| self.running.next_info()).flatten();
        if let Some(info) = &info
            && (info.width_px, info.height_px) != (width, height)
        {
            self.stdout = None;
            return Err(VideoError::FrameSize {
                path: self.path.clone(),
                frame_idx: self.n_read,
                width_px: info.width_px,
                height_px: info.height_px,
                expected_width_px: width,
                expected_height_px: height,
            });
        }
        let frame = RgbImage::from_raw(width, height, pixels);
        match (frame, info) {
            (Some(pixels), Some(info)) if n_read == n_bytes => {
                self.n_read += 1;
                Ok(Some(TimedFrame {
                    ticks: self.ticks_of(&info),
                    pixels,
                }))
            }
            _ => {
                self.stdout = None;
                self.check_end(n_read)
            }
        }
    }

    /// Number of frames that have been read.
    #[must_use]
    pub fn n_read(&self) -> u64 {
        self.n_read
    }

    /// The time of a frame: its own, if it is after that of the frame before, else one step later.
    fn ticks_of(&mut self, info: &FrameInfo) -> i64 {
        let step_ticks = (1.0 / self.info.rate.value() / self.info.time_base.value()).round();
        #[expect(
            clippy::cast_possible_truncation,
            reason = "ticks per frame; one that is out of range is cut off"
        )]
        let step_ticks = (step_ticks as i64).max(1);
        let next = self.last_ticks.map(|last| last.saturating_add(step_ticks));
        let is_later = |ticks: &i64| self.last_ticks.is_none_or(|last| *ticks > last);
        let ticks = info
            .ticks
            .filter(is_later)
            .or(next)
            .unwrap_or(self.info.first_ticks);
        self.last_ticks = Some(ticks);
        ticks
    }

    /// The end of the clip, if ffmpeg has nothing to say against it.
    fn check_end(&mut self, n_left: usize) -> Result<Option<TimedFrame>, VideoError> {
        let Ended {
            is_success,
            has_complained,
            said,
        } = self.running.wait();
        if is_success && !has_complained && n_left == 0 {
            return Ok(None);
        }
        Err(clip_error(
            &self.path,
            format!("after {} frames: {said}", self.n_read),
        ))
    }
}
