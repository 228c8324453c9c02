//! `starbreak detect clip:…`: a detector over the frames of a clip.
//!
//! Frame k of the clip, from 0, is the image of number k + 1 and is called `frame_00000k.png`, as
//! `video` calls the frames that it writes into a folder; a folder of frames keeps its names.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

use starbreak_dataset::DatasetError;
use starbreak_dataset::video::{Ffmpeg, check_frame_sizes, frame_files, is_folder};
use starbreak_detect::ImageToSee;
use starbreak_eval::LabelSet;

use super::detect::{Looked, Run, interrupted, look_at};
use super::detect_labels::{Referred, of_model};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::screen::path_text;

/// Clips go by the rules for images without labels.
const FORMAT: &str = "folder";

/// The clip in `clip:PATH`.
pub(super) fn clip_of(source: &OsStr) -> Option<PathBuf> {
    // A path need not be Unicode; what is before it is.
    let bytes = source.as_encoded_bytes().strip_prefix(b"clip:")?;
    let path = match std::str::from_utf8(bytes) {
        Ok(path) => PathBuf::from(path),
        Err(_) => PathBuf::from(source.to_string_lossy().strip_prefix("clip:")?),
    };
    Some(path)
}

/// Looks through a clip, or a folder of frames in the order of their names.
pub(super) fn look(run: &Run<'_>, clip: &Path) -> Result<Looked, Failure> {
    if clip.as_os_str().is_empty() {
        return Err(Failure::wrong_input(
            "\"clip:\" has no path after the colon; give clip:FILE or clip:DIR",
        ));
    }
    if run.args.limit == Some(0) {
        return Err(Failure::wrong_input(
            "--limit 0 leaves no frame; give 1 or more",
        ));
    }
    let video = clip_name(clip);
    run.refuse_among(std::iter::once(clip.to_owned()))?;
    if is_folder(clip) {
        let files = frame_files(clip)?;
        run.refuse_among(files.iter().cloned())?;
        check_frame_sizes(&files)?;
        let images: Vec<ImageToSee> = files
            .into_iter()
            .map(|path| ImageToSee {
                name: path_text(path.file_name().unwrap_or_default()),
                path,
            })
            .take(run.args.limit.unwrap_or(usize::MAX))
            .collect();
        let detector = run.detector()?;
        let names = images.iter().map(|image| image.name.clone());
        let referred = Referred::of_clip(names, &video, detector.classes());
        let map = run.map(&detector, &referred.labels, FORMAT)?;
        return look_at(run, detector, map, &images, referred);
    }
    let ffmpeg = Ffmpeg::at(&run.args.reader.ffmpeg).map_err(DatasetError::from)?;
    let info = ffmpeg.probe(clip)?;
    let detector = run.detector()?;
    let categories = LabelSet {
        categories: of_model(detector.classes()),
        ..LabelSet::default()
    };
    let map = run.map(&detector, &categories, FORMAT)?;
    let limit = run.args.limit.unwrap_or(usize::MAX);
    let n_expected = usize::try_from(info.n_frames)
        .unwrap_or(usize::MAX)
        .min(limit);
    let interrupt = Interrupt::listen(run.screen);
    let progress = run.screen.progress(n_expected as u64, "frames");
    let started = Instant::now();
    let mut reader = ffmpeg.read(clip, &info).map_err(DatasetError::from)?;
    let mut n_given = 0;
    let seen = detector.detect_frames(
        || {
            if n_given == limit {
                return Ok(None);
            }
            let frame = reader.next_frame().map_err(DatasetError::from)?;
            n_given += 1;
            Ok(frame.map(|frame| (frame_name(n_given - 1), frame.pixels)))
        },
        usize::from(run.global.threads),
        interrupt.flag(),
        &|name, found| {
            progress.step();
            if let Err(error) = found {
                progress.line(&format!("error: {name:?}: {error}"));
            }
        },
    );
    progress.finish();
    if interrupt.flag().load(std::sync::atomic::Ordering::Relaxed) {
        return Err(interrupted());
    }
    let seen = seen?;
    let names: Vec<String> = (0..seen.len()).map(frame_name).collect();
    let referred = Referred::of_clip(names.iter().cloned(), &video, detector.classes());
    Ok(Looked {
        detector,
        map,
        names,
        seen,
        referred,
        seconds: started.elapsed().as_secs_f64(),
    })
}

/// The name of a frame, as `video` has it.
fn frame_name(idx: usize) -> String {
    format!("frame_{idx:06}.png")
}

/// The name of a clip: that of its file without the extension.
fn clip_name(clip: &Path) -> String {
    let name = match is_folder(clip) {
        true => clip.file_name(),
        false => clip.file_stem(),
    };
    path_text(name.unwrap_or_default())
}
