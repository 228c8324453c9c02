//! The detections of a clip, clean and cracked.

use std::path::{Path, PathBuf};

use starbreak_dataset::files_in;
use starbreak_eval::evaluation::{ClipSide, Warning};
use starbreak_eval::{Detections, EvalError, GroundTruth, LabeledImage, SaidDetections, Unused};
use starbreak_runs::evaluation::files_of;

use crate::failure::Failure;

/// The detections of one side of a clip.
pub(super) struct Side {
    pub(super) path: PathBuf,
    /// By the labeled frames.
    pub(super) detections: Detections,
    pub(super) n_read: usize,
    pub(super) unused: Option<Unused>,
}

impl Side {
    pub(super) fn at(self, path: PathBuf) -> Self {
        Self { path, ..self }
    }

    pub(super) fn named<'a>(&'a self, name: &'a str, is_of_all_images: bool) -> ClipSide<'a> {
        ClipSide {
            name,
            path: &self.path,
            detections: &self.detections,
            n_read: self.n_read,
            unused: self.unused.as_ref(),
            is_of_all_images,
        }
    }
}

/// Detections that name the frames of a clip, and by which numbers where that is a guess.
pub(super) fn by_frame_of(
    frames: &GroundTruth,
    path: &Path,
) -> Result<(SaidDetections, Option<Warning>), Failure> {
    let mut warning = None;
    let mut numbered = None;
    if files_in(path, "txt").is_ok()
        && let Some((frames, first)) = frames.numbered_as(path)?
    {
        warning = Some(Warning::NumberedFrames {
            path: path.to_owned(),
            first,
        });
        numbered = Some(frames);
    }
    let frames = numbered.as_ref().unwrap_or(frames);
    match frames.read_detections(path) {
        Ok(said) => Ok((said, warning)),
        Err(EvalError::UnknownImages {
            n_detections,
            n_all,
            first,
            ..
        }) => {
            let images = &frames.labels.images;
            let name = |image: Option<&LabeledImage>| {
                image.map_or_else(String::new, |image| image.name.clone())
            };
            Err(Failure::wrong_input(format!(
                "{path:?}: {n_detections} of {n_all} detections are in frames that the clip lacks, the first in image \
                 {first}; the clip has {} frames, image_id 1 to {0}, called {:?} to {:?}; give the detections of the \
                 same clip",
                images.len(),
                name(images.first()),
                name(images.last()),
            )))
        }
        Err(error) => Err(error.into()),
    }
}

/// The detections of one clip: a file or folder of its name in a folder of several.
pub(super) fn of_one_clip(path: &Path, clip: Option<&str>) -> PathBuf {
    let Some(clip) = clip else {
        return path.to_owned();
    };
    let inside = [path.join(format!("{clip}.json")), path.join(clip)];
    let found = inside.into_iter().find(|path| path.exists());
    found.unwrap_or_else(|| path.to_owned())
}

/// The files of a side: those of each clip where they are of several by frame.
pub(super) fn side_files(path: &Path, clips: &[&str]) -> Vec<(PathBuf, Vec<PathBuf>)> {
    let own = files_of(path);
    if !path.is_dir() || own.as_slice() != [path.to_owned()] {
        return vec![(path.to_owned(), own)];
    }
    let of_clips = clips.iter().map(|clip| of_one_clip(path, Some(clip)));
    of_clips
        .map(|path| (path.clone(), files_of(&path)))
        .collect()
}
