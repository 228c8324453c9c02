//! The track file of the verb `video`: what the glass is like in each frame of a clip.

use std::path::Path;

use serde::Deserialize;
use starbreak_dataset::read_text;

use super::{Frame, GlassState};
use crate::EvalError;
use crate::json_record::{refuse, refuse_file};

/// Longest track file that is read, bytes: some hours of frames.
const MAX_BYTES: u64 = 1 << 30;

const SCHEMA: &str = "starbreak.track/1";

/// Rates of frames that are believed, 1/s: from one in twelve days to a little above the fastest cameras.
const RATES_PER_S: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Latest time of a frame that is believed, s.
const MOST_S: f64 = 1e9;

/// Longest clip that is taken, frames, nine hours of 30 per second: a wrong number must not fill the
/// memory.
pub(crate) const MOST_FRAMES: u64 = 1_000_000;

/// A clip with its frames, times and the onset of its damage.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClipTrack {
    /// Names that the clip goes by: of the file that was broken and of the one that came out,
    /// without folders and extensions.
    pub names: Vec<String>,
    /// Name of the file that was broken, and its SHA-256, where they are known.
    pub input: Option<(String, String)>,
    /// Frames per second.
    pub frames_per_s: Option<f64>,
    /// Width and height of a frame, px.
    pub size_px: Option<(u32, u32)>,
    /// All frames of the clip.
    pub frames: Vec<TrackedFrame>,
    /// Number of the first frame with damage.
    pub onset_idx: Option<u64>,
}

/// A frame, and the file that it is in a folder of frames.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedFrame {
    /// Number, time and state of the glass.
    pub frame: Frame,
    /// Name of its file.
    pub file: Option<String>,
}

#[derive(Deserialize)]
struct File {
    schema: String,
    input: Input,
    output: Output,
    n_frames: u64,
    fps: f64,
    width_px: u32,
    height_px: u32,
    damage_onset: Option<Onset>,
    frames: Vec<Line>,
}

#[derive(Deserialize)]
struct Input {
    name: String,
    sha256: String,
}

#[derive(Deserialize)]
struct Output {
    name: String,
}

#[derive(Deserialize)]
struct Onset {
    frame_idx: u64,
    time_s: Option<f64>,
}

#[derive(Deserialize)]
struct Line {
    frame_idx: u64,
    time_s: f64,
    state: GlassState,
    #[serde(default)]
    file: Option<String>,
}

impl File {
    /// It is of this schema, and its frames follow each other.
    fn check_frames(&self, path: &Path) -> Result<(), EvalError> {
        if self.schema != SCHEMA {
            let reason = format!("its schema is {:?}; expected {SCHEMA:?}", self.schema);
            return Err(refuse_file(path, reason));
        }
        if !RATES_PER_S.contains(&self.fps) {
            let reason = format!(
                "fps = {:e}; expected frames per second from 1e-6 to 1e6",
                self.fps
            );
            return Err(refuse_file(path, reason));
        }
        let n_frames = self.frames.len() as u64;
        if self.n_frames != n_frames || n_frames == 0 {
            let reason = format!(
                "it says n_frames = {} and lists {n_frames}; write the clip again with `video`",
                self.n_frames
            );
            return Err(refuse_file(path, reason));
        }
        let mut before_s = f64::NEG_INFINITY;
        for (idx, line) in (0..).zip(&self.frames) {
            let is_time = line.time_s > before_s && line.time_s <= MOST_S;
            if line.frame_idx != idx || !is_time {
                let reason = format!(
                    "frame {} at {:?} s is out of order; numbers count from 0 and times rise to 1e9 s at most",
                    line.frame_idx, line.time_s
                );
                return Err(refuse(path, format!("frames[{idx}]"), reason));
            }
            before_s = line.time_s;
        }
        Ok(())
    }

    /// Its onset is where its frames have it, or anywhere where no glass breaks; gives that frame.
    fn check_onset(&self, path: &Path) -> Result<Option<u64>, EvalError> {
        let is_intact = |line: &Line| line.state == GlassState::Intact;
        let is_back = |pair: &&[Line]| is_intact(&pair[1]) && !is_intact(&pair[0]);
        if let Some([before, line]) = self.frames.windows(2).find(is_back) {
            let reason = format!(
                "the glass is intact after it was {:?}; it does not heal: write the clip again with `video`",
                before.state
            );
            return Err(refuse(path, format!("frames[{}]", line.frame_idx), reason));
        }
        let broken = |line: &&Line| !is_intact(line);
        let of_states = self.frames.iter().find(broken).map(|line| line.frame_idx);
        let onset_idx = self.damage_onset.as_ref().map(|onset| onset.frame_idx);
        if of_states.is_some() && of_states != onset_idx {
            let said =
                |idx: Option<u64>| idx.map_or("none".to_owned(), |idx| format!("frame {idx}"));
            let reason = format!(
                "its damage_onset is {}, but the first frame that is not intact is {}; write the clip again with `video`",
                said(onset_idx),
                said(of_states)
            );
            return Err(refuse_file(path, reason));
        }
        let onset_s = self.damage_onset.as_ref().and_then(|onset| onset.time_s);
        let frame_s = onset_idx.and_then(|idx| self.frames.get(usize::try_from(idx).ok()?));
        if let Some((said, frame)) = onset_s.zip(frame_s)
            && (said - frame.time_s).abs() > 1e-6
        {
            let reason = format!(
                "its damage_onset is at {said:?} s, but that frame at {:?} s; write the clip again with `video`",
                frame.time_s
            );
            return Err(refuse_file(path, reason));
        }
        Ok(onset_idx)
    }
}

impl ClipTrack {
    /// The track in a file of schema `starbreak.track/1`.
    ///
    /// # Errors
    /// [`EvalError::File`] where it is no such file, has no rate of frames that can be, or says two
    /// things about its frames or its onset; [`EvalError::Record`] for a frame out of order; [`EvalError::Dataset`].
    pub fn read(path: &Path) -> Result<Self, EvalError> {
        let text = read_text(path, MAX_BYTES)?.text;
        let file: File = serde_json::from_str(&text).map_err(|error| {
            let reason = format!(
                "it is no track of `video`: {}; give the file OUT.track.json beside the damaged clip",
                error.to_string().replace('\n', " ")
            );
            refuse_file(path, reason)
        })?;
        file.check_frames(path)?;
        let onset_idx = file.check_onset(path)?;
        let names = [&file.input.name, &file.output.name];
        Ok(Self {
            names: names.map(|name| stem(name).to_owned()).into(),
            input: Some((file.input.name, file.input.sha256)),
            frames_per_s: Some(file.fps),
            size_px: Some((file.width_px, file.height_px)),
            frames: file
                .frames
                .into_iter()
                .map(|line| TrackedFrame {
                    frame: Frame {
                        frame_idx: line.frame_idx,
                        time_s: line.time_s,
                        state: Some(line.state),
                    },
                    file: line.file,
                })
                .collect(),
            onset_idx,
        })
    }

    /// A clip of which only the number of frames, their rate, 1/s, and the onset are known.
    ///
    /// # Errors
    /// [`EvalError::StatisticSetting`] for a rate that is none, [`EvalError::Rule`] for more than a
    /// million frames.
    pub fn plain(
        n_frames: u64,
        frames_per_s: f64,
        onset_idx: Option<u64>,
    ) -> Result<Self, EvalError> {
        if !RATES_PER_S.contains(&frames_per_s) {
            return Err(EvalError::StatisticSetting {
                what: "number of frames per second",
                value: frames_per_s,
                range: "from 1e-6 to 1e6",
            });
        }
        if n_frames > MOST_FRAMES {
            return Err(EvalError::Rule(format!(
                "a clip of {n_frames} frames, by its number or by the highest in its labels; at most {MOST_FRAMES} are \
                 taken: give the number with --frames, and with --first-frame what the labels' first number is"
            )));
        }
        let frame = |frame_idx: u64| {
            #[expect(
                clippy::cast_precision_loss,
                reason = "numbers of frames are far below 2^53"
            )]
            let time_s = frame_idx as f64 / frames_per_s;
            TrackedFrame {
                frame: Frame {
                    frame_idx,
                    time_s,
                    state: None,
                },
                file: None,
            }
        };
        Ok(Self {
            frames_per_s: Some(frames_per_s),
            frames: (0..n_frames).map(frame).collect(),
            onset_idx,
            ..Self::default()
        })
    }

    /// The same with another onset; what the track said of the glass is then left out.
    ///
    /// # Errors
    /// [`EvalError::Rule`] for a frame that is not there.
    pub fn with_onset(mut self, onset_idx: u64) -> Result<Self, EvalError> {
        let n_frames = self.frames.len() as u64;
        if onset_idx >= n_frames {
            return Err(EvalError::Rule(format!(
                "the damage begins in frame {onset_idx}, but the clip has {n_frames} frames, counted from 0; give one of them"
            )));
        }
        if self.onset_idx != Some(onset_idx) {
            for tracked in &mut self.frames {
                tracked.frame.state = None;
            }
        }
        self.onset_idx = Some(onset_idx);
        Ok(self)
    }
}

/// A file's name without folders and extension.
fn stem(name: &str) -> &str {
    let file = name.trim_end_matches('/');
    let file = file.rsplit('/').next().unwrap_or(file);
    match file.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem,
        _ => file,
    }
}
