//! `starbreak detect clip:FILE --video OUT`: the clip with the boxes that were found in it.

use std::path::Path;

use image::RgbImage;
use starbreak_dataset::video::{ClipFormat, ClipInfo, ClipStream, ClipWriter, Ffmpeg};
use starbreak_dataset::{DatasetError, OutputBatch, is_inside, same_file};
use starbreak_eval::chart::{Anchor, Shape};

use super::detect::{Looked, Run, interrupted};
use super::raster::draw;
use crate::args::detect::ResultFormat;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::screen::path_text;

/// Boxes below this score are not drawn; `evaluate` counts an object as found from here on, too.
const MIN_SCORE: f64 = 0.3;

/// So much of a category's name is written.
const MAX_LETTERS: usize = 40;

/// Colors of categories, in turn (Okabe and Ito), and of the words on them.
const COLORS: [(&str, &str); 6] = [
    ("#e69f00", "#000000"),
    ("#56b4e9", "#000000"),
    ("#009e73", "#ffffff"),
    ("#f0e442", "#000000"),
    ("#d55e00", "#ffffff"),
    ("#cc79a7", "#000000"),
];

/// A clip that is to be written with boxes, once it is known that it can be.
#[derive(Debug)]
pub(super) struct BoxedClip<'a> {
    clip: &'a Path,
    video: &'a Path,
    /// Whose audio goes with the frames; that of a part of them would go on after it.
    audio: Option<&'a Path>,
    ffmpeg: Ffmpeg,
    info: ClipInfo,
    format: ClipFormat,
}

impl<'a> BoxedClip<'a> {
    /// The clip that was asked for. Refuses one that cannot be written, or would take the place of the
    /// one that is read: better said before the work.
    pub(super) fn of(run: &Run<'a>, clip: Option<&'a Path>) -> Result<Option<Self>, Failure> {
        let Some(video) = &run.args.video else {
            return Ok(None);
        };
        let Some(clip) = clip.filter(|clip| !clip.is_dir()) else {
            return Err(Failure::wrong_input(
                "--video draws boxes into a clip; give clip:FILE with it",
            ));
        };
        let format = ClipFormat::of(video, false).map_err(DatasetError::from)?;
        if same_file(clip, video) {
            return Err(DatasetError::OutputIsInput {
                input: clip.to_owned(),
                output: video.clone(),
            }
            .into());
        }
        if run.args.format == ResultFormat::Kitti && is_inside(video, run.output) {
            return Err(Failure::wrong_input(format!(
                "--video {video:?} lies in the folder of the detections {:?}; choose another place",
                run.output
            )));
        }
        let mut trial = run.global.batch();
        if run.args.format != ResultFormat::Kitti {
            trial.reserve(run.output)?;
        }
        let file = trial.reserve(video)?;
        let ffmpeg = Ffmpeg::at(&run.args.reader.ffmpeg).map_err(DatasetError::from)?;
        let info = ffmpeg.probe(clip)?;
        format
            .check_rate((info.rate, info.has_constant_rate), clip, video)
            .map_err(DatasetError::from)?;
        let boxed = Self {
            clip,
            video,
            audio: run.args.limit.is_none().then_some(clip),
            ffmpeg,
            info,
            format,
        };
        boxed.try_writing(&file)?;
        Ok(Some(boxed))
    }

    /// Writes a black frame: what ffmpeg cannot write, such as this audio in this container, it says then.
    fn try_writing(&self, file: &Path) -> Result<(), Failure> {
        let mut writer = self.writer(file)?;
        let black = RgbImage::new(self.info.width_px, self.info.height_px);
        writer
            .write_frame(self.info.first_ticks, &black)
            .map_err(DatasetError::from)?;
        writer.finish().map_err(DatasetError::from)?;
        Ok(())
    }

    /// What writes frames into a file under a temporary name.
    fn writer(&self, file: &Path) -> Result<ClipWriter, Failure> {
        let stream = ClipStream::like(&self.info);
        let writer = self
            .ffmpeg
            .write(file, self.video, self.format, &stream, self.audio);
        Ok(writer.map_err(DatasetError::from)?)
    }

    /// Reads the clip again, and writes it with the boxes as a file of the batch.
    pub(super) fn stage(
        &self,
        run: &Run<'_>,
        looked: &Looked,
        batch: &mut OutputBatch,
    ) -> Result<(), Failure> {
        let interrupt = Interrupt::listen(run.screen);
        let reader = self.ffmpeg.read(self.clip, &self.info);
        let mut reader = reader.map_err(DatasetError::from)?;
        let mut writer = self.writer(&batch.reserve(self.video)?)?;
        let progress = run
            .screen
            .progress(looked.seen.len() as u64, "frames with boxes");
        for found in &looked.seen {
            if interrupt.is_set() {
                return Err(interrupted());
            }
            let Some(frame) = reader.next_frame().map_err(DatasetError::from)? else {
                break;
            };
            let mut pixels = frame.pixels;
            // The surest last, on top of the others.
            let boxes = found.as_ref().map_or(&[][..], |found| &found.detections);
            for raw in boxes.iter().rev() {
                if raw.score >= MIN_SCORE
                    && let Some(category) = looked.map.category(raw.class)
                {
                    let name = looked.referred.labels.categories.get(category as usize);
                    let name = name.map_or("", |category| category.name.as_str());
                    let name: String = name.chars().take(MAX_LETTERS).collect();
                    let words = format!("{name} {:.2}", raw.score);
                    draw_box(&mut pixels, raw.corners_px, &words, category as usize);
                }
            }
            writer
                .write_frame(frame.ticks, &pixels)
                .map_err(DatasetError::from)?;
            progress.step();
        }
        progress.finish();
        writer.finish().map_err(DatasetError::from)?;
        run.screen
            .say(&format!("boxes drawn in {}", path_text(self.video)));
        Ok(())
    }
}

/// A frame of lines with its words above it, or within it at the upper rim.
fn draw_box(image: &mut RgbImage, corners: [f64; 4], words: &str, place: usize) {
    let (color, ink) = COLORS[place % COLORS.len()];
    let (width, height) = (f64::from(image.width()), f64::from(image.height()));
    let width_px = (height / 250.0).max(1.5);
    // A contract may leave boxes as wide as it likes; what lies outside of the frame is not drawn.
    let [x0, y0, x1, y1] = corners;
    if !(x1 > 0.0 && y1 > 0.0 && x0 < width && y0 < height) {
        return;
    }
    let [x0, x1] = [x0, x1].map(|x| x.clamp(-width_px, width + width_px));
    let [y0, y1] = [y0, y1].map(|y| y.clamp(-width_px, height + width_px));
    let size_px = (height / 42.0).max(10.0);
    let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]];
    // Side by side: what a line encloses is looked through pixel by pixel.
    for side in corners.windows(2) {
        let line = Shape::Line {
            points: side.to_vec(),
            color: color.into(),
            width_px,
            dashes: &[],
        };
        draw(image, &line, 1.0);
    }
    // All letters of the font are equally wide.
    let letters = u32::try_from(words.chars().count()).unwrap_or(0);
    let length = 0.602 * size_px * f64::from(letters) + 0.4 * size_px;
    let top = match y0 - 1.3 * size_px >= 0.0 {
        true => y0 - 1.3 * size_px,
        false => y0,
    };
    let left = x0.min(width - length).max(0.0);
    let shapes = [
        Shape::Area {
            points: vec![
                [left, top],
                [left + length, top],
                [left + length, top + 1.3 * size_px],
                [left, top + 1.3 * size_px],
            ],
            color: color.into(),
            opacity: 1.0,
        },
        Shape::Words {
            at: [left + 0.2 * size_px, top + size_px],
            text: words.to_owned(),
            size_px,
            anchor: Anchor::Start,
            turn_deg: 0.0,
            color: ink.into(),
        },
    ];
    for shape in &shapes {
        draw(image, shape, 1.0);
    }
}
