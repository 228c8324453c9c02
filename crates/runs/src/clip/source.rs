//! Frames from a clip or from a folder.

use std::path::{Path, PathBuf};

use starbreak_dataset::video::{
    ClipInfo, ClipReader, Ffmpeg, Fraction, VideoError, check_frame_sizes, frame_files, is_folder,
};
use starbreak_dataset::{
    DatasetError, ImageFile, ImageLimits, decode_image, read_bytes, read_image, sha256_file,
    sha256_hex,
};

use super::pixels::Pixels;
use super::{ClipError, ClipRequest};
use crate::Error;

/// Frames per second of a folder that goes to a folder, where nothing else depends on time but
/// how fast the light is followed: KITTI's.
const FOLDER_RATE: u32 = 10;

/// Where frames come from.
#[derive(Debug)]
pub(super) enum Source {
    Clip {
        path: PathBuf,
        ffmpeg: Ffmpeg,
        info: Box<ClipInfo>,
    },
    Folder {
        files: Vec<PathBuf>,
        size: (u32, u32),
        rate: Fraction,
        /// Bits per channel of the first frame, and whether it has alpha.
        depth: (u32, bool),
    },
}

/// One frame.
pub(super) struct Frame {
    pub(super) idx: u64,
    /// Since the first frame, s.
    pub(super) time_s: f64,
    /// The timestamp in a clip, in its clock; in a folder the index.
    pub(super) ticks: i64,
    pub(super) pixels: Pixels,
    /// The file it is, in a folder.
    pub(super) file: Option<FrameFile>,
}

/// The file of a frame.
pub(super) struct FrameFile {
    pub(super) path: PathBuf,
    pub(super) bytes: Vec<u8>,
    /// All but its pixels.
    pub(super) image: ImageFile,
}

impl Source {
    pub(super) fn open(request: &ClipRequest, ffmpeg: Option<&Ffmpeg>) -> Result<Self, Error> {
        let path = request.input.clone();
        if is_folder(&path) {
            let files = frame_files(&path)?;
            check_frame_sizes(&files)?;
            let needs_rate = ffmpeg.is_some() || request.depends_on_time();
            let rate = match (request.fps, Fraction::new(FOLDER_RATE, 1)) {
                (Some(rate), _) => rate,
                (None, Some(rate)) if !needs_rate => rate,
                _ => return Err(ClipError::NoRate { input: path }.into()),
            };
            let (size, depth) = match files.first() {
                Some(first) => {
                    let image = read_image(first, &ImageLimits::default())?.pixels;
                    let color = image.color();
                    let bits = color.bits_per_pixel() / u16::from(color.channel_count());
                    let depth = (u32::from(bits), color.has_alpha());
                    ((image.width(), image.height()), depth)
                }
                None => ((0, 0), (8, false)),
            };
            return Ok(Self::Folder {
                files,
                size,
                rate,
                depth,
            });
        }
        if request.fps.is_some() {
            return Err(ClipError::OwnRate { input: path }.into());
        }
        let ffmpeg = match ffmpeg {
            Some(ffmpeg) => ffmpeg.clone(),
            None => Ffmpeg::at(&request.ffmpeg).map_err(DatasetError::from)?,
        };
        let info = Box::new(ffmpeg.probe(&path)?);
        Ok(Self::Clip { path, ffmpeg, info })
    }

    /// Its word in the track.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Clip { .. } => "clip",
            Self::Folder { .. } => "frames",
        }
    }

    pub(super) fn has_constant_rate(&self) -> bool {
        match self {
            Self::Clip { info, .. } => info.has_constant_rate,
            Self::Folder { .. } => true,
        }
    }

    pub(super) fn size(&self) -> (u32, u32) {
        match self {
            Self::Clip { info, .. } => (info.width_px, info.height_px),
            Self::Folder { size, .. } => *size,
        }
    }

    pub(super) fn rate(&self) -> Fraction {
        match self {
            Self::Clip { info, .. } => info.rate,
            Self::Folder { rate, .. } => *rate,
        }
    }

    /// Bits per channel, and whether it has alpha.
    pub(super) fn depth(&self) -> (u32, bool) {
        match self {
            Self::Clip { info, .. } => (info.bits_per_channel, info.has_alpha),
            Self::Folder { depth, .. } => *depth,
        }
    }

    /// How many frames are to be expected.
    pub(super) fn n_frames(&self) -> u64 {
        match self {
            Self::Clip { info, .. } => info.n_frames,
            Self::Folder { files, .. } => files.len() as u64,
        }
    }

    /// Time of the last frame since the first, s.
    pub(super) fn last_frame_s(&self) -> f64 {
        match self {
            Self::Clip { info, .. } => info.last_frame_s,
            Self::Folder { files, rate, .. } => {
                let last = i64::try_from(files.len()).unwrap_or(i64::MAX) - 1;
                rate.inverse().seconds(last)
            }
        }
    }

    /// SHA-256 of a clip; of a folder that of the lines `<sha256>  <name>` of its frames, as the
    /// tool `sha256sum` writes them.
    pub(super) fn sha256(&self) -> Result<String, Error> {
        match self {
            Self::Clip { path, .. } => Ok(sha256_file(path)?),
            Self::Folder { files, .. } => {
                let mut lines = String::new();
                for file in files {
                    let name = file.file_name().unwrap_or_default().to_string_lossy();
                    lines += &format!("{}  {name}\n", sha256_file(file)?);
                }
                Ok(sha256_hex(lines.as_bytes()))
            }
        }
    }

    pub(super) fn frames(&self) -> Result<Frames<'_>, Error> {
        let reader = match self {
            Self::Clip { path, ffmpeg, info } => {
                Some(ffmpeg.read(path, info).map_err(DatasetError::from)?)
            }
            Self::Folder { .. } => None,
        };
        Ok(Frames {
            source: self,
            reader,
            n_read: 0,
            first_ticks: None,
        })
    }
}

/// The frames of a source, one by one.
pub(super) struct Frames<'a> {
    source: &'a Source,
    reader: Option<ClipReader>,
    n_read: u64,
    first_ticks: Option<i64>,
}

impl Frames<'_> {
    fn read(&mut self) -> Result<Option<Frame>, Error> {
        let idx = self.n_read;
        let frame = match (self.source, &mut self.reader) {
            (Source::Clip { info, .. }, Some(reader)) => {
                let Some(frame) = reader.next_frame().map_err(DatasetError::from)? else {
                    return Ok(None);
                };
                let first = *self.first_ticks.get_or_insert(frame.ticks);
                Frame {
                    idx,
                    time_s: info.time_base.seconds(frame.ticks.saturating_sub(first)),
                    ticks: frame.ticks,
                    pixels: Pixels::Image(frame.pixels.into()),
                    file: None,
                }
            }
            (
                Source::Folder {
                    files, size, rate, ..
                },
                _,
            ) => {
                let file = usize::try_from(idx).ok().and_then(|idx| files.get(idx));
                let Some(path) = file else { return Ok(None) };
                let (bytes, mut image) = read_frame(path)?;
                let pixels = std::mem::take(&mut image.pixels);
                if (pixels.width(), pixels.height()) != *size {
                    return Err(Error::Dataset(DatasetError::Video(VideoError::FrameSize {
                        path: path.clone(),
                        frame_idx: idx,
                        width_px: pixels.width(),
                        height_px: pixels.height(),
                        expected_width_px: size.0,
                        expected_height_px: size.1,
                    })));
                }
                let ticks = i64::try_from(idx).unwrap_or(i64::MAX);
                Frame {
                    idx,
                    time_s: rate.inverse().seconds(ticks),
                    ticks,
                    pixels: Pixels::Image(pixels),
                    file: Some(FrameFile {
                        path: path.clone(),
                        bytes,
                        image,
                    }),
                }
            }
            _ => return Ok(None),
        };
        self.n_read += 1;
        Ok(Some(frame))
    }
}

impl Iterator for Frames<'_> {
    type Item = Result<Frame, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        self.read().transpose()
    }
}

/// The bytes of a frame's file, and the image in them.
fn read_frame(path: &Path) -> Result<(Vec<u8>, ImageFile), Error> {
    let limits = ImageLimits::default();
    let bytes = read_bytes(path, limits.max_file_bytes)?;
    let image = decode_image(&path.to_string_lossy(), &bytes, &limits)?;
    Ok((bytes, image))
}
