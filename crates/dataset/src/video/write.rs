//! Writing a clip: frames into a pipe, and the audio of another clip beside them.

use std::ffi::OsString;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ChildStdin;

use image::RgbImage;

use super::clip::{SCALER, input_args};
use super::matroska::{before_frame, head};
use super::program::{Running, file_arg};
use super::showinfo::Color;
use super::{ClipInfo, Ffmpeg, Fraction, VideoError};

/// Threads of an encoder. The bytes of H.264 depend on their number, so it is always this one.
const N_ENCODER_THREADS: &str = "8";

/// Container and codec of a clip that is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClipFormat {
    /// `.mp4` and `.m4v`: H.264, constant rate factor 18.
    Mp4,
    /// `.mov`: the same.
    Mov,
    /// `.mkv`: the same.
    Matroska,
    /// `.mkv` without loss: FFV1, version 3, RGB.
    MatroskaLossless,
    /// `.avi`: Motion JPEG of quality 2.
    Avi,
    /// `.gif`: 256 colors of its own for each frame, without audio, times rounded to 1/100 s.
    Gif,
}

impl ClipFormat {
    /// The format for a file name.
    ///
    /// # Errors
    /// [`VideoError::OutputFormat`] for another extension, [`VideoError::Lossless`] where it has no
    /// lossless codec.
    pub fn of(path: &Path, is_lossless: bool) -> Result<Self, VideoError> {
        let extension = path
            .extension()
            .map(|own| own.to_string_lossy().to_lowercase());
        let format = match extension.as_deref() {
            Some("mp4" | "m4v") => Self::Mp4,
            Some("mov") => Self::Mov,
            Some("mkv") => Self::Matroska,
            Some("avi") => Self::Avi,
            Some("gif") => Self::Gif,
            _ => {
                return Err(VideoError::OutputFormat {
                    path: path.to_owned(),
                });
            }
        };
        match (format, is_lossless) {
            (format, false) => Ok(format),
            (Self::Matroska, true) => Ok(Self::MatroskaLossless),
            _ => Err(VideoError::Lossless {
                path: path.to_owned(),
            }),
        }
    }

    /// Refuses times that the container cannot hold: those of a variable rate in `.avi`, more than 50
    /// frames per second in `.gif`.
    ///
    /// # Errors
    /// [`VideoError::VariableRate`], [`VideoError::GifRate`].
    pub fn check_rate(
        self,
        (rate, is_constant): (Fraction, bool),
        input: &Path,
        output: &Path,
    ) -> Result<(), VideoError> {
        let (input, output) = (input.to_owned(), output.to_owned());
        match self {
            Self::Avi if !is_constant => Err(VideoError::VariableRate { input, output }),
            Self::Gif if rate.value() > 50.0 => Err(VideoError::GifRate {
                input,
                output,
                rate: rate.value(),
            }),
            _ => Ok(()),
        }
    }

    fn muxer(self) -> &'static str {
        match self {
            Self::Mp4 => "mp4",
            Self::Mov => "mov",
            Self::Matroska | Self::MatroskaLossless => "matroska",
            Self::Avi => "avi",
            Self::Gif => "gif",
        }
    }
}

/// What a clip that is written is like.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipStream {
    width_px: u32,
    height_px: u32,
    rate: Fraction,
    time_base: Fraction,
    first_ticks: i64,
    pixel_aspect: Option<Fraction>,
    color: Color,
}

impl ClipStream {
    /// Like a clip that was read: its size, clock, shape of pixels and way to store color.
    #[must_use]
    pub fn like(info: &ClipInfo) -> Self {
        Self {
            width_px: info.width_px,
            height_px: info.height_px,
            rate: info.rate,
            time_base: info.time_base,
            first_ticks: info.first_ticks,
            pixel_aspect: info.pixel_aspect,
            color: info.color.clone(),
        }
    }

    /// Frames of one size at a constant rate: the clock ticks once a frame, from 0.
    #[must_use]
    pub fn at_rate(width_px: u32, height_px: u32, rate: Fraction) -> Self {
        Self {
            width_px,
            height_px,
            rate,
            time_base: rate.inverse(),
            first_ticks: 0,
            pixel_aspect: Fraction::new(1, 1),
            color: Color::default(),
        }
    }

    /// Whether H.264 must store these frames with all of their chroma: half of a side is not whole.
    fn has_odd_side(&self) -> bool {
        !(self.width_px.is_multiple_of(2) && self.height_px.is_multiple_of(2))
    }

    fn encode_args(&self, format: ClipFormat) -> Vec<OsString> {
        let mut filters = Vec::new();
        let mut args: Vec<String> = Vec::new();
        let mut tag = |name: &str, value: &str| {
            if !value.is_empty() {
                args.extend([name.to_owned(), value.to_owned()]);
            }
        };
        match format {
            ClipFormat::Mp4 | ClipFormat::Mov | ClipFormat::Matroska => {
                let pixels = if self.has_odd_side() {
                    "yuv444p"
                } else {
                    "yuv420p"
                };
                let range = if self.color.range == "pc" { "pc" } else { "tv" };
                let mut scale = format!("scale=flags={SCALER}:out_range={range}");
                if let Some(matrix) = matrix_of(&self.color.space) {
                    scale += &format!(":out_color_matrix={matrix}");
                    tag("-colorspace", &self.color.space);
                }
                filters.extend([scale, format!("format={pixels}")]);
                tag("-color_range", &self.color.range);
                tag("-c:v", "libx264");
                tag("-crf", "18");
            }
            ClipFormat::MatroskaLossless => {
                filters.push("format=bgr0".to_owned());
                for (name, value) in [
                    ("-c:v", "ffv1"),
                    ("-level", "3"),
                    ("-g", "1"),
                    ("-slices", "16"),
                    ("-slicecrc", "1"),
                ] {
                    tag(name, value);
                }
            }
            ClipFormat::Avi => {
                filters.push(format!("scale=flags={SCALER}:out_range=pc"));
                filters.push("format=yuvj420p".to_owned());
                tag("-c:v", "mjpeg");
                tag("-q:v", "2");
            }
            // A palette of the whole clip would hold all of its frames in memory.
            ClipFormat::Gif => filters.push(
                "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1:dither=sierra2_4a"
                    .to_owned(),
            ),
        }
        // Newer versions of ffmpeg take these from the frames and not from the options.
        let known = [
            (
                "color_primaries",
                known_tag(&self.color.primaries, &PRIMARIES),
            ),
            ("color_trc", known_tag(&self.color.transfer, &TRANSFERS)),
        ];
        let has_tags = !matches!(format, ClipFormat::Avi | ClipFormat::Gif);
        for (name, value) in known {
            if let (Some(value), true) = (value, has_tags) {
                filters.push(format!("setparams={name}={value}"));
                tag(&format!("-{name}"), value);
            }
        }
        if let Some(aspect) = self.pixel_aspect {
            let (width, height) = (aspect.numerator(), aspect.denominator());
            filters.push(format!("setsar={width}/{height}"));
        }
        // An AVI file has no clock but its rate, and the clock of a GIF is always the same.
        let tick = match format {
            ClipFormat::Gif => None,
            ClipFormat::Avi => Some(self.rate.inverse()),
            _ => Some(self.time_base),
        };
        if let Some(tick) = tick {
            let tick = format!("{}:{}", tick.numerator(), tick.denominator());
            tag("-enc_time_base", &tick);
        }
        tag("-threads:v", N_ENCODER_THREADS);
        args.extend(["-vf".to_owned(), filters.join(",")]);
        args.into_iter().map(OsString::from).collect()
    }
}

/// ffmpeg's name for a matrix in its scaler, which differs from that of its tag.
fn matrix_of(space: &str) -> Option<&'static str> {
    match space {
        "bt709" => Some("bt709"),
        "bt470bg" | "smpte170m" => Some("bt601"),
        "smpte240m" => Some("smpte240m"),
        "fcc" => Some("fcc"),
        "bt2020nc" => Some("bt2020"),
        _ => None,
    }
}

/// Primaries that ffmpeg's filter `setparams` knows.
const PRIMARIES: [&str; 10] = [
    "bt709",
    "bt470m",
    "bt470bg",
    "smpte170m",
    "smpte240m",
    "film",
    "bt2020",
    "smpte428",
    "smpte431",
    "smpte432",
];

/// Transfer characteristics that it knows.
const TRANSFERS: [&str; 15] = [
    "bt709",
    "bt470m",
    "bt470bg",
    "smpte170m",
    "smpte240m",
    "linear",
    "log100",
    "log316",
    "iec61966-2-4",
    "iec61966-2-1",
    "bt2020-10",
    "bt2020-12",
    "smpte2084",
    "smpte428",
    "arib-std-b67",
];

fn known_tag(name: &str, known: &[&'static str]) -> Option<&'static str> {
    known.iter().find(|known| **known == name).copied()
}

/// A clip that is being written. Dropping it before [`ClipWriter::finish`] ends ffmpeg; the
/// unfinished file is the caller's to remove.
#[derive(Debug)]
pub struct ClipWriter {
    /// What the user calls the clip.
    path: PathBuf,
    stream: ClipStream,
    /// Before the process: it is closed first.
    stdin: Option<ChildStdin>,
    running: Running,
    n_written: u64,
}

impl Ffmpeg {
    /// Starts to write a clip into `file`, which messages call `path`, with the audio streams of
    /// another clip, packet by packet.
    ///
    /// # Errors
    /// [`VideoError::NoFfmpeg`] where ffmpeg does not start; anything else comes up with the frames
    /// or at the end.
    pub fn write(
        &self,
        file: &Path,
        path: &Path,
        format: ClipFormat,
        stream: &ClipStream,
        audio_from: Option<&Path>,
    ) -> Result<ClipWriter, VideoError> {
        let start_s = match format {
            // Its audio starts with its video.
            ClipFormat::Avi => 0.0,
            _ => stream.time_base.seconds(stream.first_ticks),
        };
        let audio_from = audio_from.filter(|_| format != ClipFormat::Gif);
        let mut args: Vec<OsString> = vec!["-y".into()];
        if audio_from.is_some() {
            args.extend(["-itsoffset".into(), format!("{start_s:.9}").into()]);
        }
        args.extend(["-f", "matroska", "-i", "pipe:0"].map(OsString::from));
        if let Some(audio) = audio_from {
            args.extend(input_args(audio));
            let copied = [
                "-map",
                "0:v:0",
                "-map",
                "1:a?",
                "-c:a",
                "copy",
                "-map_metadata",
                "1",
            ];
            args.extend(copied.map(OsString::from));
        }
        args.extend(self.every_frame());
        if format == ClipFormat::Avi {
            // Audio that begins before its first sound would push the video by a part of a frame.
            args.extend(["-avoid_negative_ts", "disabled"].map(OsString::from));
        }
        args.extend(stream.encode_args(format));
        // Nothing of the day or of the version of a library.
        args.extend(["-fflags", "+bitexact", "-f", format.muxer()].map(OsString::from));
        args.push(file_arg(file));
        let mut running = self.start(&args)?;
        let stdin = running.child.take_stdin();
        let mut writer = ClipWriter {
            path: path.to_owned(),
            stream: stream.clone(),
            running,
            stdin,
            n_written: 0,
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a rate of 0.001 to 1000 per second"
        )]
        let frame_ns = (1e9 / stream.rate.value()).round() as u64;
        let head = head(stream.width_px, stream.height_px, frame_ns.max(1));
        writer.send(&head)?;
        Ok(writer)
    }
}

impl ClipWriter {
    /// Appends a frame that is shown at `ticks`, which is after the frame before.
    ///
    /// # Errors
    /// [`VideoError::Write`] where ffmpeg has gone, [`VideoError::FrameSize`] for another size than
    /// that of the clip.
    pub fn write_frame(&mut self, ticks: i64, pixels: &RgbImage) -> Result<(), VideoError> {
        let (width_px, height_px) = pixels.dimensions();
        let (expected_width_px, expected_height_px) = (self.stream.width_px, self.stream.height_px);
        if (width_px, height_px) != (expected_width_px, expected_height_px) {
            return Err(VideoError::FrameSize {
                path: self.path.clone(),
                frame_idx: self.n_written,
                width_px,
                height_px,
                expected_width_px,
                expected_height_px,
            });
        }
        let base = self.stream.time_base;
        let time_ns = nanoseconds(ticks.saturating_sub(self.stream.first_ticks), base);
        self.send(&before_frame(time_ns, pixels.as_raw().len()))?;
        self.send(pixels.as_raw())?;
        self.n_written += 1;
        Ok(())
    }

    /// Ends the clip and waits until ffmpeg has written it.
    ///
    /// # Errors
    /// [`VideoError::Write`] where it could not.
    pub fn finish(mut self) -> Result<(), VideoError> {
        self.stdin = None;
        let ended = self.running.wait();
        if ended.is_success {
            return Ok(());
        }
        Err(self.write_error(ended.said))
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), VideoError> {
        let sent = match &mut self.stdin {
            Some(stdin) => stdin.write_all(bytes),
            None => Err(std::io::ErrorKind::BrokenPipe.into()),
        };
        if sent.is_ok() {
            return Ok(());
        }
        // ffmpeg has gone, and knows why.
        self.stdin = None;
        let said = self.running.wait().said;
        Err(self.write_error(format!("after {} frames: {said}", self.n_written)))
    }

    fn write_error(&self, said: String) -> VideoError {
        let lower = said.to_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| lower.contains(word));
        let way_out = if has(&["no space left", "quota"]) {
            "free some space or choose another disk"
        } else if has(&["unknown encoder", "encoder not found"]) {
            "install an ffmpeg with this encoder, or choose .avi, or .mkv with --lossless"
        } else if has(&["codec", "tag", "not currently supported", "header"]) {
            "if the container cannot hold the audio of the clip, choose .mkv"
        } else {
            "run the command again"
        };
        VideoError::Write {
            path: self.path.clone(),
            said,
            way_out,
        }
    }
}

/// Ticks as nanoseconds, rounded; 0 for what is before the first frame.
fn nanoseconds(ticks: i64, base: Fraction) -> u64 {
    let ticks = i128::from(ticks.max(0));
    let (above, below) = (i128::from(base.numerator()), i128::from(base.denominator()));
    let exact = ticks * above * 1_000_000_000;
    u64::try_from((exact + below / 2) / below).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_become_the_nearest_nanosecond() {
        let base = |above, below| Fraction::new(above, below).unwrap_or_else(|| unreachable!());
        for (ticks, base, ns) in [
            (1001, base(1, 30_000), 33_366_667),
            (1, base(1001, 30_000), 33_366_667),
            (30, base(1001, 30_000), 1_001_000_000),
            (-5, base(1, 1000), 0),
            (i64::MAX, base(u32::MAX, 1), u64::MAX),
        ] {
            assert_eq!(nanoseconds(ticks, base), ns, "{ticks} ticks of {base} s");
        }
    }

    #[test]
    fn the_extension_is_the_format() {
        let of = |name: &str, is_lossless| ClipFormat::of(Path::new(name), is_lossless).ok();
        assert_eq!(of("a.MP4", false), Some(ClipFormat::Mp4), "mp4");
        assert_eq!(
            of("a.mkv", true),
            Some(ClipFormat::MatroskaLossless),
            "lossless"
        );
        assert_eq!(of("a.mp4", true), None, "lossless mp4");
        assert_eq!(of("a.webm", false), None, "webm");
        assert_eq!(of("a", false), None, "no extension");
    }
}
