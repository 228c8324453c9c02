//! Frames into a clip or into a folder, and the masks beside them.

use std::path::{Path, PathBuf};

use image::{DynamicImage, RgbImage};
use starbreak::{OutputFormat, Settings};
use starbreak_dataset::video::{ClipFormat, ClipStream, ClipWriter, Ffmpeg, is_folder};
use starbreak_dataset::{
    DatasetError, Encoding, JpegQuality, OutputBatch, encode_image, encode_image_as, same_file,
};

use super::pixels::Pixels;
use super::source::{Frame, FrameFile, Source};
use super::stage::StageFacts;
use super::{ClipError, ClipRequest};
use crate::Error;
use crate::images::{encoding, extension};

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    Clip(ClipFormat),
    Folder,
    /// Whoever asked for the frames writes them.
    Caller,
}

impl Target {
    /// A name with the extension of a clip is one; an existing folder, a name that ends in a
    /// separator and one without an extension are folders.
    pub(super) fn of(request: &ClipRequest) -> Result<Self, Error> {
        let path = &request.output;
        let ends_as_folder = path.to_string_lossy().ends_with(std::path::is_separator);
        if !(is_folder(path) || ends_as_folder || path.extension().is_none()) {
            let format = ClipFormat::of(path, request.is_lossless).map_err(DatasetError::from)?;
            return Ok(Self::Clip(format));
        }
        if request.is_lossless {
            return Err(ClipError::LosslessFolder {
                output: path.clone(),
            }
            .into());
        }
        Ok(Self::Folder)
    }

    /// A frame as it is written, ready for the one thread that writes.
    pub(super) fn prepare(
        self,
        frame: Frame,
        is_untouched: bool,
        settings: &Settings,
    ) -> Result<Ready, Error> {
        let Frame {
            idx,
            ticks,
            pixels,
            file,
            ..
        } = frame;
        let content = match (self, file) {
            (Self::Clip(_), _) => Content::Pixels {
                ticks,
                pixels: pixels.into_image()?.into_rgb8(),
            },
            (Self::Caller, _) => Content::Bare {
                pixels,
                is_untouched,
            },
            (Self::Folder, Some(file)) => {
                file_of(file, pixels.into_image()?, is_untouched, settings)?
            }
            (Self::Folder, None) => {
                let quality = JpegQuality::new(settings.output.quality)?;
                let (encoding, extension) = match settings.output.format {
                    OutputFormat::Jpeg => (Encoding::Jpeg { quality }, "jpg"),
                    OutputFormat::Same | OutputFormat::Png => (Encoding::Png, "png"),
                };
                Content::File {
                    name: format!("frame_{idx:06}.{extension}"),
                    bytes: encode_image(&pixels.into_image()?, &encoding, None)?,
                }
            }
        };
        Ok(Ready {
            idx,
            content,
            own_masks: None,
        })
    }
}

/// The file of a folder's frame: as it was, if nothing is to be seen in it, else with its pixels
/// laid as they were, its orientation and its color profile.
fn file_of(
    mut file: FrameFile,
    pixels: DynamicImage,
    is_untouched: bool,
    settings: &Settings,
) -> Result<Content, Error> {
    let encoding = encoding(settings, &file.image)?;
    let stem = file.path.file_stem().unwrap_or_default().to_string_lossy();
    let name = format!("{stem}.{}", extension(&file.path, encoding.format()));
    let bytes = if is_untouched && encoding.format() == file.image.format {
        std::mem::take(&mut file.bytes)
    } else {
        file.image.pixels = pixels;
        encode_image_as(&file.image, &encoding)
            .map_err(|error| Error::of_image(&file.path, error.into()))?
    };
    Ok(Content::File { name, bytes })
}

/// A frame that is ready to be written.
pub(super) struct Ready {
    idx: u64,
    content: Content,
    /// Region and crack mask as PNG, where those of the stage do not lie as this frame does.
    pub(super) own_masks: Option<[Vec<u8>; 2]>,
}

enum Content {
    Pixels { ticks: i64, pixels: RgbImage },
    File { name: String, bytes: Vec<u8> },
    Bare { pixels: Pixels, is_untouched: bool },
}

impl Ready {
    /// Its file name in a folder.
    pub(super) fn file_name(&self) -> Option<&str> {
        match &self.content {
            Content::Pixels { .. } | Content::Bare { .. } => None,
            Content::File { name, .. } => Some(name),
        }
    }

    /// The pixels for a caller who writes them, and whether they are those of the input.
    pub(super) fn into_pixels(self) -> Option<(Pixels, bool)> {
        match self.content {
            Content::Bare {
                pixels,
                is_untouched,
            } => Some((pixels, is_untouched)),
            Content::Pixels { .. } | Content::File { .. } => None,
        }
    }

    /// What its masks are named by.
    fn stem(&self) -> String {
        let stem = self.file_name().map(Path::new).and_then(Path::file_stem);
        match stem {
            Some(stem) => stem.to_string_lossy().into_owned(),
            None => format!("frame_{:06}", self.idx),
        }
    }
}

/// Where frames go, until all are there.
pub(super) struct Sink {
    output: PathBuf,
    masks: Option<PathBuf>,
    input: PathBuf,
    clip: Option<ClipWriter>,
    batch: OutputBatch,
}

impl Sink {
    pub(super) fn open(
        replaces: bool,
        request: &ClipRequest,
        target: Target,
        (source, ffmpeg): (&Source, Option<&Ffmpeg>),
    ) -> Result<Self, Error> {
        // Thousands of small files would wait for the disk one by one.
        let has_many_files = target == Target::Folder || request.masks.is_some();
        let batch = if has_many_files {
            OutputBatch::new_unsynced()
        } else {
            OutputBatch::new()
        };
        let mut batch = batch.replacing(replaces);
        let clip = match (target, ffmpeg) {
            (Target::Clip(format), Some(ffmpeg)) => {
                let (stream, audio) = match source {
                    Source::Clip { info, path, .. } => {
                        (ClipStream::like(info), Some(path.as_path()))
                    }
                    Source::Folder {
                        size: (width_px, height_px),
                        rate,
                        ..
                    } => (ClipStream::at_rate(*width_px, *height_px, *rate), None),
                };
                let file = batch.reserve(&request.output)?;
                let writer = ffmpeg
                    .write(&file, &request.output, format, &stream, audio)
                    .map_err(DatasetError::from)?;
                Some(writer)
            }
            _ => None,
        };
        Ok(Self {
            output: request.output.clone(),
            masks: request.masks.clone(),
            input: request.input.clone(),
            clip,
            batch,
        })
    }

    pub(super) fn write(&mut self, ready: &Ready, facts: &StageFacts) -> Result<(), Error> {
        match (&ready.content, &mut self.clip) {
            (Content::Pixels { ticks, pixels }, Some(clip)) => clip
                .write_frame(*ticks, pixels)
                .map_err(DatasetError::from)?,
            (Content::File { name, bytes }, _) => self.stage(&self.output.join(name), bytes)?,
            (Content::Pixels { .. }, None) | (Content::Bare { .. }, _) => {}
        }
        if let (Some(folder), Some([region, crack])) = (self.masks.clone(), &facts.masks) {
            let stem = ready.stem();
            let [region, crack] = match &ready.own_masks {
                Some([region, crack]) => [region.as_slice(), crack.as_slice()],
                None => [region.png(), crack.png()],
            };
            for (kind, bytes) in [("region", region), ("crack", crack)] {
                self.stage(&folder.join(format!("{stem}.{kind}.png")), bytes)?;
            }
        }
        Ok(())
    }

    fn stage(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Error> {
        if same_file(&self.input, path) {
            return Err(Error::OutputIsInput {
                input: self.input.clone(),
                output: path.to_owned(),
            });
        }
        self.batch.stage(path, bytes)?;
        Ok(())
    }

    /// Ends the clip and puts everything in its place, these files last. Files of an earlier run that are
    /// not among them are removed.
    pub(super) fn finish(
        mut self,
        files: &[(&Path, &[u8])],
        earlier: Vec<(PathBuf, String)>,
    ) -> Result<(), Error> {
        self.batch.take_over(earlier);
        if let Some(clip) = self.clip.take() {
            clip.finish().map_err(DatasetError::from)?;
        }
        for (path, bytes) in files {
            self.batch.stage(path, bytes)?;
        }
        self.batch.commit()?;
        Ok(())
    }
}
