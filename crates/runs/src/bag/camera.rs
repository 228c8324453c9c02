//! A camera of a bag: its panes, its frames behind them, and what they came to.

use std::sync::OnceLock;

use image::DynamicImage;
use mcap::records::MessageHeader;
use rayon::prelude::*;
use starbreak_dataset::{ImageFile, ImageFormat, ImageLimits, JpegQuality};
use starbreak_seed::Seed;

use super::Added;
use super::message::{CameraKind, CameraMessage, text_message};
use super::records::Event;
use super::survey::Clock;
use super::write::Outgoing;
use crate::bag_error::{BagError, MessageFault};
use crate::clip::pixels::Pixels;
use crate::clip::stream::{Pane, Stream, StreamFrame, StreamParams, StreamShown};
use crate::clip::{Growth, Light};
use crate::{Error, RunContext};

/// Most sizes of images on a topic. Each has a pane of its own, which stays in memory.
const N_SIZES: usize = 16;

/// A camera that is damaged.
#[derive(Debug)]
pub(super) struct Camera {
    pub(super) topic: String,
    pub(super) context: RunContext,
    pub(super) clock: Clock,
    /// What a frame lasts, s.
    pub(super) frame_s: f64,
    pub(super) impact_at_s: f64,
    pub(super) growth: Growth,
    pub(super) light: Light,
    pub(super) added: Vec<Added>,
}

/// What became of a camera.
#[derive(Debug, Clone, Default)]
pub struct CameraReport {
    /// Its topic.
    pub topic: String,
    /// What its pane was drawn by: the topic without the first slash, with dots for the others.
    pub name: String,
    /// The seed of the pane.
    pub seed: u64,
    /// Number of images.
    pub n_frames: u64,
    /// Number of images that are others now.
    pub n_altered: u64,
    /// Number of images in which the cracks grow.
    pub n_growing: u64,
    /// Index and time (s after the first image of all) of the first image at the impact or after it.
    pub damage_onset: Option<(u64, f64)>,
    /// Index and time (s) of the first image in which a pixel is affected.
    pub first_visible: Option<(u64, f64)>,
    /// Time of the latest image, s.
    pub last_s: Option<f64>,
    /// Share of the last image that is affected.
    pub region_fraction: f64,
    /// Width and height of its images, px, in the order in which they came.
    pub sizes: Vec<(u32, u32)>,
}

impl Camera {
    /// What its pane is drawn by: as `crack` by the name of a file, which has no slash.
    pub(super) fn name(&self) -> String {
        self.topic.trim_start_matches('/').replace('/', ".")
    }

    fn seed(&self) -> Seed {
        self.context.seed.of_item(&self.name(), 0)
    }

    fn quality(&self) -> Result<JpegQuality, Error> {
        Ok(JpegQuality::new(self.context.settings.output.quality)?)
    }

    fn of_message(&self, idx: u64, fault: MessageFault) -> Error {
        let topic = self.topic.clone();
        BagError::Message { topic, idx, fault }.into()
    }
}

/// Panes that stay where they are once they are there: one for each size of image, as a rule one alone.
#[derive(Debug, Default)]
pub(super) struct Panes {
    next: OnceLock<Box<(Pane, Panes)>>,
}

impl Panes {
    /// Keeps a pane behind all others.
    fn add(&self, pane: Pane) -> &Pane {
        let mut last = self;
        while let Some(kept) = last.next.get() {
            last = &kept.1;
        }
        &last
            .next
            .get_or_init(|| Box::new((pane, Self::default())))
            .0
    }
}

/// A message of a camera on its way.
pub(super) struct Incoming {
    /// Place in the batch.
    pub(super) at: usize,
    pub(super) camera: usize,
    pub(super) kind: CameraKind,
    /// Which message of the camera.
    pub(super) idx: u64,
    pub(super) header: MessageHeader,
    pub(super) data: Vec<u8>,
}

/// The same with its pixels.
pub(super) struct Decoded {
    /// Without its bytes where the pixels lie in them.
    incoming: Incoming,
    message: CameraMessage,
    pixels: Pixels,
    /// All but the pixels of the file that a compressed image is.
    file: Option<ImageFile>,
    /// The message with the pixels as they are, written again.
    control: Option<Vec<u8>>,
}

impl Incoming {
    /// Reads the pixels, and writes them again where a control is asked for.
    pub(super) fn decoded(mut self, camera: &Camera) -> Result<Decoded, Error> {
        let of_message = |fault| camera.of_message(self.idx, fault);
        let message = CameraMessage::read(self.kind, &self.data).map_err(of_message)?;
        let mut file = message
            .file(&self.data, &ImageLimits::default())
            .map_err(of_message)?;
        let control = match &file {
            // JPEG loses something whenever it is written.
            Some(file)
                if camera.added.contains(&Added::Control) && file.format == ImageFormat::Jpeg =>
            {
                let written = message.with_file(&self.data, file, camera.quality()?);
                Some(written.map_err(of_message)?)
            }
            _ => None,
        };
        let pixels = match message.layout() {
            Some(layout) => Pixels::Rows {
                bytes: std::mem::take(&mut self.data),
                layout,
            },
            None => {
                let pixels = file.as_mut().map(|file| std::mem::take(&mut file.pixels));
                Pixels::Image(pixels.unwrap_or_default())
            }
        };
        Ok(Decoded {
            incoming: self,
            message,
            pixels,
            file,
            control,
        })
    }
}

/// A frame behind the glass, not yet written.
pub(super) struct Damaged {
    decoded: Decoded,
    shown: StreamShown,
}

/// The frames of a camera, one after the other.
pub(super) struct CameraRun<'a> {
    camera: &'a Camera,
    name: &'a str,
    panes: &'a Panes,
    streams: Vec<((u32, u32), Stream<'a>)>,
    /// Time of the image before, s.
    time_s: f64,
    pub(super) report: CameraReport,
}

impl<'a> CameraRun<'a> {
    pub(super) fn new(camera: &'a Camera, name: &'a str, panes: &'a Panes) -> Self {
        let report = CameraReport {
            topic: camera.topic.clone(),
            name: name.to_owned(),
            seed: camera.seed().0,
            ..CameraReport::default()
        };
        Self {
            camera,
            name,
            panes,
            streams: Vec::new(),
            time_s: 0.0,
            report,
        }
    }

    /// The next frames behind the glass, in their order.
    pub(super) fn show(&mut self, frames: Vec<Decoded>) -> Result<Vec<Damaged>, Error> {
        let size_of = |frame: &Decoded| frame.pixels.size();
        let mut all = Vec::with_capacity(frames.len());
        let mut frames = frames.into_iter().peekable();
        while let Some(size) = frames.peek().map(size_of) {
            let mut alike = Vec::new();
            while let Some(frame) = frames.next_if(|frame| size_of(frame) == size) {
                alike.push(frame);
            }
            all.extend(self.show_alike(size, alike)?);
        }
        Ok(all)
    }

    /// Frames of one size.
    fn show_alike(
        &mut self,
        size: (u32, u32),
        mut frames: Vec<Decoded>,
    ) -> Result<Vec<Damaged>, Error> {
        let first_idx = frames.first().map_or(0, |frame| frame.incoming.idx);
        // An image whose stamp was never set counts as one of the moment of that before it.
        let time_of = |frame: &Decoded| {
            let set = self.camera.clock.time_s(frame.message.stamp_ns());
            self.time_s = set.unwrap_or(self.time_s);
            self.time_s
        };
        let times: Vec<f64> = frames.iter().map(time_of).collect();
        let pixels = (frames.iter_mut().zip(&times)).map(|(frame, time_s)| StreamFrame {
            idx: frame.incoming.idx,
            time_s: *time_s,
            pixels: std::mem::replace(&mut frame.pixels, Pixels::Image(DynamicImage::default())),
        });
        let pixels = pixels.collect();
        let shown = self.stream(size, first_idx)?.batch(pixels)?;
        for ((frame, shown), time_s) in frames.iter().zip(&shown).zip(times) {
            self.note(frame.incoming.idx, time_s, shown);
        }
        let damaged = frames.into_iter().zip(shown);
        Ok(damaged
            .map(|(decoded, shown)| Damaged { decoded, shown })
            .collect())
    }

    /// The stream of frames of a size, whose pane is broken when the first comes.
    fn stream(&mut self, size: (u32, u32), first_idx: u64) -> Result<&mut Stream<'a>, Error> {
        let known = self.streams.iter().position(|(of, _)| *of == size);
        let idx = match known {
            Some(idx) => idx,
            None if self.streams.len() >= N_SIZES => {
                let (width, height) = size;
                let fault = MessageFault::Sizes {
                    width,
                    height,
                    n_most: N_SIZES,
                };
                return Err(self.camera.of_message(first_idx, fault));
            }
            None => {
                let Camera { context, .. } = self.camera;
                let pane = Pane::of(&context.settings, size, self.camera.seed())?;
                let params = StreamParams {
                    settings: &context.settings,
                    seed: context.seed,
                    name: self.name,
                    impact_at_s: self.camera.impact_at_s,
                    growth: self.camera.growth,
                    light: self.camera.light,
                    frame_s: self.camera.frame_s,
                    with_masks: self.camera.added.contains(&Added::Region),
                };
                let stream = Stream::new(self.panes.add(pane), params, first_idx)?;
                self.report.sizes.push(size);
                self.streams.push((size, stream));
                self.streams.len() - 1
            }
        };
        Ok(&mut self.streams[idx].1)
    }

    fn note(&mut self, idx: u64, time_s: f64, shown: &StreamShown) {
        let report = &mut self.report;
        report.n_frames += 1;
        report.n_altered += u64::from(!shown.is_untouched);
        report.n_growing += u64::from(shown.is_growing);
        report.region_fraction = shown.region_fraction;
        let latest = report.last_s.map_or(time_s, |last_s| last_s.max(time_s));
        report.last_s = Some(latest);
        if shown.has_begun && report.damage_onset.is_none() {
            report.damage_onset = Some((idx, time_s));
        }
        if shown.region_fraction > 0.0 && report.first_visible.is_none() {
            report.first_visible = Some((idx, time_s));
        }
    }
}

impl Damaged {
    /// Place in the batch, and what is written there: the message, and what is added behind it.
    pub(super) fn written(self, camera: &Camera) -> Result<(usize, Vec<Outgoing>), Error> {
        let Self { decoded, shown } = self;
        let Decoded {
            incoming,
            message,
            file,
            control,
            ..
        } = decoded;
        let of_message = |fault| camera.of_message(incoming.idx, fault);
        let bytes = match &shown.pixels {
            Pixels::Rows { bytes, .. } => bytes,
            Pixels::Image(_) => &incoming.data,
        };
        let mut added = Vec::new();
        for one in &camera.added {
            let data = match one {
                Added::Region => match shown.region() {
                    Some(region) => Some(message.mask(bytes, region).map_err(of_message)?),
                    None => None,
                },
                Added::Track => Some(text_message(&shown.line.to_string()).map_err(of_message)?),
                Added::Control => None,
            };
            added.extend(data.map(|data| (*one, data)));
        }
        added.extend(control.map(|data| (Added::Control, data)));
        let header = incoming.header;
        let data = match (shown.pixels, file) {
            (Pixels::Rows { bytes, .. }, _) => bytes,
            (Pixels::Image(pixels), Some(mut file)) if !shown.is_untouched => {
                file.pixels = pixels;
                message
                    .with_file(&incoming.data, &file, camera.quality()?)
                    .map_err(of_message)?
            }
            (Pixels::Image(_), _) => incoming.data,
        };
        let mut all = vec![Outgoing::Kept(Event::Message { header, data })];
        all.extend(added.into_iter().map(|(added, data)| Outgoing::Added {
            topic: (incoming.camera, added),
            like: header,
            data,
        }));
        Ok((incoming.at, all))
    }
}

/// Work on each, on all threads; the first error in their order.
pub(super) fn on_all<T: Send, R: Send>(
    items: Vec<T>,
    work: impl Fn(T) -> Result<R, Error> + Sync + Send,
) -> Result<Vec<R>, Error> {
    let results: Vec<Result<R, Error>> = items.into_par_iter().with_max_len(1).map(work).collect();
    results.into_iter().collect()
}
