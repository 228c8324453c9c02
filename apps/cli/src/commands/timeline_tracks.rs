//! Which track belongs to which clip.

use std::path::{Path, PathBuf};

use starbreak_dataset::files_in;
use starbreak_eval::timeline::ClipTrack;
use starbreak_eval::{LabeledClip, TrackedLabels};

use crate::args::timeline::TimelineArgs;
use crate::failure::Failure;

/// A track with the name of its clip.
#[derive(Debug, Clone)]
pub(super) struct NamedTrack {
    pub(super) name: String,
    pub(super) track: ClipTrack,
}

/// A track file.
struct TrackFile {
    path: PathBuf,
    /// The clip that the command line says it is of.
    said: Option<String>,
    track: ClipTrack,
}

/// The tracks that were given, or what stands for one.
pub(super) struct Tracks {
    files: Vec<TrackFile>,
    plain: Option<Plain>,
    onset_idx: Option<u64>,
}

/// A clip without a track.
#[derive(Clone, Copy)]
struct Plain {
    frames_per_s: f64,
    n_frames: Option<u64>,
}

impl Tracks {
    pub(super) fn read(args: &TimelineArgs) -> Result<Self, Failure> {
        let mut files = Vec::new();
        for word in &args.track {
            // A name of a file may hold a =, too.
            let whole = Path::new(word);
            let (said, path) = match word.split_once('=') {
                Some((clip, path)) if !whole.exists() => {
                    (Some(clip.to_owned()), PathBuf::from(path))
                }
                _ => (None, whole.to_owned()),
            };
            match files_in(&path, "json") {
                Ok(_) if said.is_some() => {
                    return Err(Failure::wrong_input(format!(
                        "--track {word:?}: {path:?} is a folder; give the file of the clip"
                    )));
                }
                Ok(found) => {
                    let is_track = |stem: &str| stem.ends_with(".track");
                    let n_before = files.len();
                    for (_, path) in found.into_iter().filter(|(stem, _)| is_track(stem)) {
                        let track = ClipTrack::read(&path)?;
                        files.push(TrackFile {
                            path,
                            said: None,
                            track,
                        });
                    }
                    if files.len() == n_before {
                        return Err(Failure::wrong_input(format!(
                            "{path:?} has no files *.track.json; give the folder with the tracks that `video` wrote"
                        )));
                    }
                }
                Err(_) => {
                    let track = ClipTrack::read(&path)?;
                    files.push(TrackFile { path, said, track });
                }
            }
        }
        let plain = args.fps.map(|frames_per_s| Plain {
            frames_per_s,
            n_frames: args.frames,
        });
        if files.is_empty() && plain.is_none() {
            return Err(Failure::wrong_input(
                "no track; give --track OUT.track.json, which `video` wrote beside the cracked clip, or --fps and \
                 --onset-frame of a clip from elsewhere",
            ));
        }
        Ok(Self {
            files,
            plain,
            onset_idx: args.onset_frame,
        })
    }

    /// The track files.
    pub(super) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.files.iter().map(|file| &file.path)
    }

    /// Names and hashes of the clips that were cracked.
    pub(super) fn clips(&self) -> impl Iterator<Item = &(String, String)> {
        self.files
            .iter()
            .filter_map(|file| file.track.input.as_ref())
    }

    /// The clips of the labels to look at: the only one, or those that have a track.
    pub(super) fn clips_with_track<'l>(
        &self,
        labels: &'l TrackedLabels,
    ) -> Result<Vec<&'l LabeledClip>, Failure> {
        if labels.clips.len() <= 1 || self.plain.is_some() {
            return Ok(vec![labels.clip(None)?]);
        }
        for file in &self.files {
            let is_known = |clip: &LabeledClip| clip.name.as_ref().is_some_and(|n| file.is_of(n));
            if !labels.clips.iter().any(is_known) {
                return Err(Failure::wrong_input(format!(
                    "{:?} is of the clip {:?}, which the labels do not have; say with --track CLIP={} which it is",
                    file.path,
                    file.name(),
                    file.path.display()
                )));
            }
        }
        let has_track = |clip: &&LabeledClip| {
            let name = clip.name.as_ref();
            name.is_some_and(|name| self.files.iter().any(|file| file.is_of(name)))
        };
        Ok(labels.clips.iter().filter(has_track).collect())
    }

    /// The track of a clip of the labels; `n_labeled` frames stand for the clip's where none has a
    /// track.
    pub(super) fn of(
        &self,
        clip: Option<&str>,
        is_only: bool,
        n_labeled: u64,
    ) -> Result<NamedTrack, Failure> {
        if let Some(plain) = self.plain {
            return self.plain_track(clip.unwrap_or("clip"), plain, n_labeled);
        }
        let fits: Vec<&TrackFile> = match clip {
            Some(name) => self.files.iter().filter(|file| file.is_of(name)).collect(),
            None => self.files.iter().collect(),
        };
        match (fits.as_slice(), clip) {
            ([only], _) => self.with_onset(&only.name(), only.track.clone()),
            ([], _) => {
                let first = self.files.first();
                let of = first.map_or_else(String::new, TrackFile::name);
                let path = first.map_or_else(String::new, |file| file.path.display().to_string());
                let name = clip.unwrap_or_default();
                let way_out = match is_only {
                    true => format!("if it is the same clip, say --track '{name}={path}'"),
                    false => format!("give its track, or say --track '{name}=FILE'"),
                };
                Err(Failure::wrong_input(format!(
                    "no track is of the clip {name:?} of the labels, the first is of {of:?}; {way_out}"
                )))
            }
            ([a, b, ..], Some(name)) => Err(Failure::wrong_input(format!(
                "{:?} and {:?} are both tracks of the clip {name:?}; give one of them",
                a.path, b.path
            ))),
            ([_, _, ..], None) => Err(Failure::wrong_input(format!(
                "{} tracks, and the labels are of one clip without a name; give its track alone",
                fits.len()
            ))),
        }
    }

    /// The only track, under this name if one is given.
    pub(super) fn only(&self, name: Option<&str>) -> Result<NamedTrack, Failure> {
        match (self.plain, self.files.as_slice()) {
            (Some(plain), _) => match plain.n_frames {
                Some(n_frames) => self.plain_track(name.unwrap_or("clip"), plain, n_frames),
                None => Err(Failure::wrong_input(
                    "how many frames has the clip? without labels and track give --frames N, too",
                )),
            },
            (None, [only]) => {
                let own = only.name();
                self.with_onset(name.unwrap_or(&own), only.track.clone())
            }
            (None, files) => Err(Failure::wrong_input(format!(
                "{} tracks without labels; give the one of the clip",
                files.len()
            ))),
        }
    }

    fn plain_track(&self, name: &str, plain: Plain, n_frames: u64) -> Result<NamedTrack, Failure> {
        let n_frames = plain.n_frames.unwrap_or(n_frames);
        let track = ClipTrack::plain(n_frames, plain.frames_per_s, None)?;
        self.with_onset(name, track)
    }

    fn with_onset(&self, name: &str, track: ClipTrack) -> Result<NamedTrack, Failure> {
        Ok(NamedTrack {
            name: name.to_owned(),
            track: match self.onset_idx {
                Some(onset_idx) => track.with_onset(onset_idx)?,
                None => track,
            },
        })
    }
}

impl TrackFile {
    /// The clip's name: as said, else that of the file that was cracked.
    fn name(&self) -> String {
        let own = self.track.names.first();
        self.said.clone().or(own.cloned()).unwrap_or_default()
    }

    fn is_of(&self, clip: &str) -> bool {
        match &self.said {
            Some(said) => said == clip,
            None => self.track.names.iter().any(|name| name == clip),
        }
    }
}
