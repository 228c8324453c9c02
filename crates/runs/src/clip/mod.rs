//! Damage over a clip: static, or growing from the impact on.
//!
//! The glass is broken once. Frames before the impact are as the lens shows them. While the
//! cracks grow they are baked for each frame; afterwards only their light changes, with that of
//! the scene. Beside the clip lies a track, which says for each frame what the glass is like.

mod light;
mod live;
pub(crate) mod pixels;
mod run;
mod show;
mod sink;
mod source;
mod stage;
pub(crate) mod stream;
mod timeline;
mod track;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use starbreak::Chain;
use starbreak_dataset::video::{Ffmpeg, Fraction, holds_anything, is_folder};
use starbreak_dataset::{
    DatasetError, OutputBatch, blake3_hex, is_inside, read_bytes, refuse_inside_set, same_file,
    sha256_hex,
};

pub use crate::clip_error::ClipError;
pub use light::ClipLight;
pub use live::{LiveClip, LiveFrames, LiveRequest};
pub use timeline::GlassState;
pub use track::TRACK_SCHEMA;

use crate::{Error, MAX_NETWORK_FILE_BYTES, Patterns, RunContext};
use run::{Finished, run};
use show::Show;
use sink::{Sink, Target};
use source::Source;
use stage::Masks;
use timeline::Timeline;
use track::{TrackHeader, first_visible, onset, track_text};

/// Longest stretched growth, s: a day.
const MAX_GROWTH_S: f64 = 86_400.0;

/// What is to become of a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipRequest {
    /// A clip that ffmpeg reads, or a folder of PNG and JPEG frames.
    pub input: PathBuf,
    /// A clip (`.mp4`, `.m4v`, `.mov`, `.mkv`, `.avi`), or a folder.
    pub output: PathBuf,
    /// When the glass is hit, s after the first frame; 0 for a crack that is there all along.
    pub impact_at_s: f64,
    /// Whether the growth of the cracks is shown.
    pub growth: Growth,
    /// Folder for a region mask and a crack mask of each frame.
    pub masks: Option<PathBuf>,
    /// Frames per second of an input folder.
    pub fps: Option<Fraction>,
    /// Whether the clip keeps every bit of its frames.
    pub is_lossless: bool,
    /// Which light the crack is under.
    pub light: Light,
    /// The program ffmpeg: a path, or a name that the system finds.
    pub ffmpeg: PathBuf,
}

/// How the cracks come about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Growth {
    /// All at once.
    Whole,
    /// At their own speed, which is a kilometer and a half per second.
    OwnSpeed,
    /// Slowed down so that the last arrives after this time; the quiet time from the impact to the
    /// first arrival is left out.
    Stretched {
        /// From the impact, or just before the first arrival, to the last arrival, s.
        time_s: f64,
    },
}

/// Which light the crack is under, with the physical optics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// That of the first frame, for the whole clip.
    First,
    /// The mean light of about the last second.
    Follow,
}

/// A clip that has been looked at, ready to run.
#[derive(Debug)]
pub struct Clip {
    request: ClipRequest,
    source: Source,
    target: Target,
    ffmpeg: Option<Ffmpeg>,
}

/// What a run says.
#[derive(Debug)]
pub struct ClipReport {
    /// Number of frames written.
    pub n_frames: u64,
    /// Index and time (s) of the first frame at the impact or after it.
    pub damage_onset: Option<(u64, f64)>,
    /// Index and time (s) of the first frame in which the cracks influence a pixel.
    pub first_visible: Option<(u64, f64)>,
    /// Number of frames in which the cracks grow.
    pub n_growing: u64,
    /// Number of lights that the crack was under.
    pub n_lights: u64,
    /// Share of the last frame that the cracks influence.
    pub region_fraction: f64,
    /// The damage.
    pub chain: Chain,
}

impl ClipRequest {
    fn depends_on_time(&self) -> bool {
        self.impact_at_s > 0.0 || self.growth != Growth::Whole
    }

    /// A file beside the output, named by it.
    fn beside(&self, suffix: &str) -> PathBuf {
        let name = self.output.file_name().unwrap_or_default();
        let name = format!("{}.{suffix}", name.to_string_lossy());
        self.output.with_file_name(name)
    }

    /// The track of the clip.
    #[must_use]
    pub fn track(&self) -> PathBuf {
        self.beside("track.json")
    }

    /// The network of the crack.
    #[must_use]
    pub fn network(&self) -> PathBuf {
        self.beside("network.json")
    }

    fn check(&self) -> Result<(), Error> {
        let (input, output) = (&self.input, &self.output);
        if same_file(input, output) {
            if !is_folder(input) {
                return Err(Error::from(ClipError::ClipIsInput {
                    output: output.clone(),
                }));
            }
            return Err(Error::OutputIsInput {
                input: input.clone(),
                output: output.clone(),
            });
        }
        if is_folder(input) {
            for written in [Some(output), self.masks.as_ref()].into_iter().flatten() {
                if is_inside(written, input) {
                    return Err(Error::from(ClipError::OutputInInput {
                        input: input.clone(),
                        output: written.clone(),
                    }));
                }
            }
        }
        if let Some(masks) = &self.masks
            && same_file(masks, output)
        {
            return Err(Error::from(ClipError::MasksAmongFrames {
                masks: masks.clone(),
                output: output.clone(),
            }));
        }
        Ok(self.growth.check()?)
    }
}

impl Growth {
    /// Refuses a time that is none.
    fn check(self) -> Result<(), ClipError> {
        match self {
            Self::Stretched { time_s } if !(time_s > 0.0 && time_s <= MAX_GROWTH_S) => {
                Err(ClipError::GrowthTime {
                    growth_time_s: time_s,
                })
            }
            _ => Ok(()),
        }
    }
}

impl Clip {
    /// Checks a request, finds ffmpeg if it is needed, and looks at the input.
    ///
    /// # Errors
    /// [`Error::Clip`] for a request that makes no sense or a folder that is not empty, [`Error::OutputIsInput`],
    /// [`Error::Dataset`] for an input that cannot be read, an absent ffmpeg, or an output in a generated
    /// set.
    pub fn open(request: ClipRequest) -> Result<Self, Error> {
        request.check()?;
        for output in [Some(&request.output), request.masks.as_ref()]
            .into_iter()
            .flatten()
        {
            refuse_inside_set(output)?;
        }
        let target = Target::of(&request)?;
        let ffmpeg = match target {
            Target::Clip(_) => Some(Ffmpeg::at(&request.ffmpeg).map_err(DatasetError::from)?),
            Target::Folder | Target::Caller => None,
        };
        let frames = (target == Target::Folder).then_some(&request.output);
        if let Some(folder) = [frames, request.masks.as_ref()]
            .into_iter()
            .flatten()
            .find(|folder| holds_anything(folder))
        {
            return Err(Error::from(ClipError::FolderNotEmpty {
                folder: folder.clone(),
            }));
        }
        let source = Source::open(&request, ffmpeg.as_ref())?;
        let last_frame_s = source.last_frame_s();
        // Half a frame for what the clock of a container rounds.
        let latest_s = last_frame_s + 0.5 / source.rate().value();
        if !(0.0..=latest_s).contains(&request.impact_at_s) {
            return Err(Error::from(ClipError::ImpactTime {
                impact_at_s: request.impact_at_s,
                last_frame_s,
            }));
        }
        if let Target::Clip(format) = target {
            let is_constant = match &source {
                Source::Clip { info, .. } => info.has_constant_rate,
                Source::Folder { .. } => true,
            };
            format
                .check_rate(
                    (source.rate(), is_constant),
                    &request.input,
                    &request.output,
                )
                .map_err(DatasetError::from)?;
        }
        Ok(Self {
            request,
            source,
            target,
            ffmpeg,
        })
    }

    /// How many frames are to be expected.
    #[must_use]
    pub fn n_frames(&self) -> u64 {
        self.source.n_frames()
    }

    /// Width and height of a frame as it is shown, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        self.source.size()
    }

    /// Frames per second.
    #[must_use]
    pub fn rate(&self) -> Fraction {
        self.source.rate()
    }

    /// Whether the clip that is written keeps all chroma because a side is odd, which not every
    /// player shows.
    #[must_use]
    pub fn has_rare_pixels(&self) -> bool {
        use starbreak_dataset::video::ClipFormat::{Matroska, Mov, Mp4};
        let (width, height) = self.size();
        let is_odd = !(width.is_multiple_of(2) && height.is_multiple_of(2));
        is_odd && matches!(self.target, Target::Clip(Mp4 | Mov | Matroska))
    }

    /// What the frames that are written lack of the input's: bits per channel above 8, and alpha.
    /// `None` where they lack nothing.
    #[must_use]
    pub fn reduction(&self) -> Option<(u32, bool)> {
        if let (Source::Folder { .. }, Target::Folder) = (&self.source, self.target) {
            return None;
        }
        let (bits, has_alpha) = self.source.depth();
        (bits > 8 || has_alpha).then_some((bits, has_alpha))
    }

    /// The curve from light to numbers of a clip of high dynamic range, by ffmpeg's name.
    #[must_use]
    pub fn high_dynamic_range(&self) -> Option<&str> {
        match &self.source {
            Source::Clip { info, .. } => info.high_dynamic_range(),
            Source::Folder { .. } => None,
        }
    }

    /// Breaks the glass and writes the clip, its track and its network, if it has one (a photograph has
    /// none); they appear together or not at all. `done` is called after each frame. `None` if `stop` was set: nothing is written
    /// then.
    ///
    /// Frames and files beside the clip are a function of input, settings and seed alone; the bytes
    /// of a clip also depend on the version of ffmpeg.
    ///
    /// # Errors
    /// [`Error`]; nothing is written then.
    pub fn run(
        &self,
        context: &RunContext,
        patterns: &Patterns,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> Result<Option<ClipReport>, Error> {
        let Self {
            request, source, ..
        } = self;
        // Hours may pass before they are written.
        let batch = OutputBatch::new().replacing(context.replaces);
        let clip = (self.target != Target::Folder).then(|| request.output.clone());
        let network = patterns.has_networks().then(|| request.network());
        for path in [clip, Some(request.track()), network] {
            path.map_or(Ok(()), |path| batch.may_write(&path))?;
        }
        let name = name_of(&request.input)?;
        let size = source.size();
        let seed = context.seed.of_item(&name, 0);
        let chain = patterns.for_clip(&context.settings, size, seed)?;
        let frame_s = 1.0 / source.rate().value();
        let bare_layer = chain.before_impact()?;
        let bare = chain.layer_under(&bare_layer, None)?;
        let (impact_at_s, growth) = (request.impact_at_s, request.growth);
        let show = Show {
            timeline: Timeline::new(&chain, impact_at_s, growth, frame_s)?,
            chain: &chain,
            bare,
            bare_layer: &bare_layer,
            settings: &context.settings,
            target: self.target,
            seed: context.seed,
            name: &name,
            masks: match request.masks {
                Some(_) => Masks::Files,
                None => Masks::No,
            },
        };
        let input_sha256 = source.sha256()?;
        let sink = Sink::open(
            context.replaces,
            request,
            self.target,
            (source, self.ffmpeg.as_ref()),
        )?;
        let light = ClipLight::new(request.light, frame_s);
        let Some(finished) = run(&show, light, source, sink, stop, &done)? else {
            return Ok(None);
        };
        let Finished {
            sink,
            frames,
            n_lights,
        } = finished;
        let network_path = request.network();
        let network_name = name_of(&network_path)?;
        let network_file = chain.network().map(|network| {
            let json = network.to_json();
            (sha256_hex(json.as_bytes()), json)
        });
        let track = track_text(
            &TrackHeader {
                request,
                context,
                name: &name,
                seed,
                input_kind: source.kind(),
                input_sha256: &input_sha256,
                size,
                rate: source.rate(),
                has_constant_rate: source.has_constant_rate(),
                chain: &chain,
                network_file: network_file
                    .as_ref()
                    .map(|(sha256, _)| (network_name.as_str(), sha256.as_str())),
                output_name: &name_of(&request.output)?,
                n_lights,
            },
            &frames,
        );
        let track_path = request.track();
        let network_file = network_file
            .iter()
            .map(|(_, json)| (network_path.as_path(), json.as_bytes()));
        let beside: Vec<_> = network_file
            .chain([(track_path.as_path(), track.as_bytes())])
            .collect();
        sink.finish(&beside, earlier_network(request).into_iter().collect())?;
        let n_growing = frames
            .iter()
            .filter(|frame| frame.state == GlassState::Growing)
            .count();
        Ok(Some(ClipReport {
            n_frames: frames.len() as u64,
            damage_onset: onset(&frames),
            first_visible: first_visible(&frames),
            n_growing: n_growing as u64,
            n_lights,
            region_fraction: frames.last().map_or(0.0, |frame| frame.region_fraction),
            chain,
        }))
    }
}

/// The network that an earlier run has left beside this output, as its track says, with the BLAKE3 of it.
fn earlier_network(request: &ClipRequest) -> Option<(PathBuf, String)> {
    let path = request.network();
    let bytes = read_bytes(&path, MAX_NETWORK_FILE_BYTES).ok()?;
    let track = read_bytes(&request.track(), u64::MAX).ok()?;
    let track: Value = serde_json::from_slice(&track).ok()?;
    let is_its =
        track["schema"] == TRACK_SCHEMA && track["network"]["sha256"] == sha256_hex(&bytes);
    is_its.then(|| (path, blake3_hex(&bytes)))
}

/// The last part of a path.
fn name_of(path: &Path) -> Result<String, Error> {
    let name = path.file_name().ok_or_else(|| Error::NoFileName {
        input: path.to_owned(),
    })?;
    Ok(name.to_string_lossy().into_owned())
}
