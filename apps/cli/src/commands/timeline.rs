//! `starbreak timeline`: what a detector finds over the frames of clips, clean and cracked.

use std::path::{Path, PathBuf};

use serde_json::json;
use starbreak_dataset::{FileSet, same_file};
use starbreak_eval::evaluation::{
    ClipInput, ClipSettings, Condition, Counts, Evaluation, InputFile, ProtocolResults, Provenance,
    Settings, Study, TimelineResults, Versions, Warning, check_end, check_sides, pool_clips,
};
use starbreak_eval::report::report_files;
use starbreak_eval::timeline::{FollowSettings, Frame, Survival, TimelineSettings};
use starbreak_eval::{
    LabeledClip, Protocol, SaidDetections, TrackedLabels, frames_of, said_categories,
};
use starbreak_runs::evaluation::{files_of, report_batch, stem_of};
use starbreak_runs::with_threads;

use super::timeline_sides::{Side, by_frame_of, of_one_clip, side_files};
use super::timeline_tracks::{NamedTrack, Tracks};
use crate::args::Global;
use crate::args::timeline::TimelineArgs;
use crate::failure::{DONE, Failure};
use crate::screen::{Screen, path_text};

/// The files that a report of clips has; the others are of images.
const FILES: [&str; 3] = ["numbers.csv", "evaluation.json", "report.html"];

pub(crate) fn run(global: &Global, args: &TimelineArgs, screen: &Screen) -> Result<u8, Failure> {
    with_threads(usize::from(global.threads), || {
        evaluated(global, args, screen)
    })??;
    Ok(DONE)
}

fn evaluated(global: &Global, args: &TimelineArgs, screen: &Screen) -> Result<(), Failure> {
    let batch = match &args.output {
        Some(folder) => report_batch(folder, &FILES, global.replace, FileSet::of(&[]))?,
        None => global.batch(),
    };
    let tracks = Tracks::read(args)?;
    let settings = ClipSettings {
        score_threshold: args.score_threshold,
        iou_threshold: args.iou,
        timeline: TimelineSettings {
            lost_for_frames: args.lost_for,
            n_replicates: args.replicates,
            seed: global.seed,
            ..TimelineSettings::default()
        },
    };
    let (evaluated, protocol) = match &args.labels {
        Some(path) => {
            let labels = TrackedLabels::read(path, args.first_frame)?;
            (
                of_labels(args, &labels, &tracks, &settings)?,
                labels.truth.protocol,
            )
        }
        None => (without_labels(args, &tracks, &settings)?, Protocol::Coco),
    };
    let study = study(global, args, evaluated, &tracks, protocol)?;
    let Some(evaluation) = study.evaluations.first() else {
        return Ok(());
    };
    if let Some(folder) = &args.output {
        let clips = evaluation.timelines.iter();
        let names: Vec<&str> = clips.map(|clip| clip.clip.as_str()).collect();
        // The files of a report of images, which there is more of, go with it.
        let mut batch = batch;
        for (name, text) in report_files(&study)? {
            let path = folder.join(name);
            refuse_input(args, &tracks, &names, &path)?;
            if FILES.contains(&name) {
                batch.stage(&path, text.as_bytes())?;
            }
        }
        batch.commit()?;
    }
    for warning in &evaluation.warnings {
        screen.note(&format!("warning: {warning}"));
    }
    for clip in &evaluation.timelines {
        screen.say(&said(clip));
    }
    if let Some(pooled) = &evaluation.pooled_clips {
        screen.say(&format!(
            "{} clips together: {}",
            pooled.n_clips,
            said_of_lost(&pooled.cracked, &pooled.clean)
        ));
    }
    if let Some(folder) = &args.output {
        screen.say(&format!("wrote {}", path_text(folder.join("report.html"))));
    }
    screen.result(|| {
        json!({
            "schema": Study::SCHEMA,
            "warnings": evaluation.warnings,
            "timelines": evaluation.timelines,
            "pooled_clips": evaluation.pooled_clips,
        })
    })
}

/// No file of the report takes the place of one that was read.
fn refuse_input(
    args: &TimelineArgs,
    tracks: &Tracks,
    clips: &[&str],
    output: &Path,
) -> Result<(), Failure> {
    let sides = [&args.clean, &args.damaged];
    let sides = sides.map(|path| side_files(path, clips));
    let of_sides = sides.iter().flatten().flat_map(|(_, files)| files);
    let mut inputs = of_sides.chain(&args.labels).chain(tracks.files());
    match inputs.find(|input| same_file(input, output)) {
        Some(input) => Err(Failure::wrong_input(format!(
            "the output {output:?} would replace the input {input:?}; choose another folder"
        ))),
        None => Ok(()),
    }
}

/// What was found, and what is to be said of what was read.
#[derive(Default)]
struct Evaluated {
    clips: Vec<TimelineResults>,
    warnings: Vec<Warning>,
}

impl Evaluated {
    /// Says a thing once.
    fn warn(&mut self, warnings: impl IntoIterator<Item = Warning>) {
        for warning in warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
    }
}

/// The clips of the labels that were asked for, or all.
fn of_labels(
    args: &TimelineArgs,
    labels: &TrackedLabels,
    tracks: &Tracks,
    settings: &ClipSettings,
) -> Result<Evaluated, Failure> {
    let mut names = args.clip.iter();
    if let Some(name) = names.find(|name| args.clip.iter().filter(|it| it == name).count() > 1) {
        return Err(Failure::wrong_input(format!(
            "--clip {name:?} is given twice; give each clip once"
        )));
    }
    let chosen: Vec<&LabeledClip> = match args.clip.is_empty() {
        true => tracks.clips_with_track(labels)?,
        false => {
            let named = args.clip.iter().map(|name| labels.clip(Some(name)));
            named.collect::<Result<_, _>>()?
        }
    };
    let by_frame = args.by_frame || !labels.has_image_ids;
    // Of all images once; by frames clip by clip.
    let of_all: Option<[SaidDetections; 2]> = match by_frame {
        true => None,
        false => Some([
            labels.truth.read_detections(&args.clean)?,
            labels.truth.read_detections(&args.damaged)?,
        ]),
    };
    let is_one = labels.clips.len() == 1;
    let mut evaluated = Evaluated::default();
    for clip in chosen {
        let n_labeled = clip.frames.iter().filter_map(|frame| frame.number).max();
        let n_labeled = n_labeled.map_or(clip.frames.len() as u64, |last| last + 1);
        let track = tracks.of(clip.name.as_deref(), is_one, n_labeled)?;
        let of_clip = labels.of_clip(clip, &track.track)?;
        let name = clip.name.clone().unwrap_or_else(|| track.name.clone());
        let [clean, cracked] = match &of_all {
            Some(all) => {
                let [clean, cracked] = [&all[0], &all[1]].map(|said| Side {
                    path: PathBuf::new(),
                    detections: of_clip.of_images(&said.detections),
                    n_read: said.detections.items.len(),
                    unused: said.unused.clone(),
                });
                [
                    clean.at(args.clean.clone()),
                    cracked.at(args.damaged.clone()),
                ]
            }
            None => {
                let truth = frames_of(
                    &track.track,
                    clip.name.as_deref(),
                    &labels.truth.labels.categories,
                    labels.truth.protocol,
                );
                let mut read = |path: &Path| -> Result<Side, Failure> {
                    let path = of_one_clip(path, clip.name.as_deref());
                    let (said, warning) = by_frame_of(&truth, &path)?;
                    evaluated.warn(warning);
                    Ok(Side {
                        path,
                        detections: of_clip.of_frames(&said.detections),
                        n_read: said.detections.items.len(),
                        unused: said.unused,
                    })
                };
                [read(&args.clean)?, read(&args.damaged)?]
            }
        };
        let pair = [
            clean.named("clean", !by_frame),
            cracked.named("damaged", !by_frame),
        ];
        evaluated.warn(check_sides(&name, &of_clip.frames, &pair, args.lost_for)?);
        let frames = all_frames(&track);
        let n_frames = frames.len() as u64;
        evaluated.warn(check_end(&name, &of_clip.frames, n_frames));
        let input = ClipInput {
            name: &name,
            frames_per_s: track.track.frames_per_s,
            frames: &frames,
            onset_idx: track.track.onset_idx,
            clean: &clean.detections,
            cracked: &cracked.detections,
        };
        evaluated.clips.push(settings.of_labels(&input, &of_clip)?);
    }
    Ok(evaluated)
}

fn all_frames(track: &NamedTrack) -> Vec<Frame> {
    track.track.frames.iter().map(|it| it.frame).collect()
}

/// One clip whose objects are what the clean detections show.
fn without_labels(
    args: &TimelineArgs,
    tracks: &Tracks,
    settings: &ClipSettings,
) -> Result<Evaluated, Failure> {
    if args.first_frame != 0 {
        return Err(Failure::wrong_input(
            "--first-frame is about the labels; give labels, too, or leave it out",
        ));
    }
    let track = tracks.only(args.clip.first().map(String::as_str))?;
    let categories = said_categories(&[&args.clean, &args.damaged])?;
    let truth = frames_of(&track.track, Some(&track.name), &categories, Protocol::Coco);
    let mut evaluated = Evaluated::default();
    let mut read = |path: &Path| -> Result<Side, Failure> {
        let (said, warning) = by_frame_of(&truth, path)?;
        evaluated.warn(warning);
        Ok(Side {
            path: path.to_owned(),
            n_read: said.detections.items.len(),
            detections: said.detections,
            unused: said.unused,
        })
    };
    let (clean, cracked) = (read(&args.clean)?, read(&args.damaged)?);
    let frames = all_frames(&track);
    let pair = [clean.named("clean", false), cracked.named("damaged", false)];
    evaluated.warn(check_sides(&track.name, &frames, &pair, args.lost_for)?);
    let input = ClipInput {
        name: &track.name,
        frames_per_s: track.track.frames_per_s,
        frames: &frames,
        onset_idx: track.track.onset_idx,
        clean: &clean.detections,
        cracked: &cracked.detections,
    };
    let follow = FollowSettings {
        score_threshold: args.follow_score,
        iou: args.iou,
        max_gap_frames: args.follow_gap,
        min_frames: args.follow_frames,
    };
    if !(0.0..=1.0).contains(&args.score_threshold) {
        return Err(Failure::wrong_input(format!(
            "--score-threshold {:?}: expected a score from 0 to 1",
            args.score_threshold
        )));
    }
    if !(args.follow_score >= args.score_threshold && args.follow_score <= 1.0) {
        return Err(Failure::wrong_input(format!(
            "--follow-score {}: expected a score from --score-threshold {} to 1, since what is followed must count \
             as found",
            args.follow_score, args.score_threshold
        )));
    }
    let results = settings.of_clean_detections(&input, &categories, follow)?;
    evaluated.clips.push(results);
    Ok(evaluated)
}

fn study(
    global: &Global,
    args: &TimelineArgs,
    evaluated: Evaluated,
    tracks: &Tracks,
    protocol: Protocol,
) -> Result<Study, Failure> {
    let Evaluated {
        clips: timelines,
        mut warnings,
    } = evaluated;
    let pooled_clips = pool_clips(&timelines)?;
    let pooled = pooled_clips.as_ref();
    warnings.extend(timelines.iter().flat_map(|clip| clip.warnings(pooled)));
    warnings.extend(pooled.iter().flat_map(|pooled| pooled.warnings()));
    let sum = |of: fn(&TimelineResults) -> u64| timelines.iter().map(of).sum();
    let detector = args.detector.clone();
    let evaluation = Evaluation {
        detector: detector.unwrap_or_else(|| stem_of(&args.clean)),
        condition: Condition {
            name: args
                .condition
                .clone()
                .unwrap_or_else(|| "cracked".to_owned()),
            ..Condition::default()
        },
        counts: Counts {
            n_images: sum(|clip| clip.n_frames),
            n_objects: sum(|clip| clip.cracked.frames.iter().map(|row| row.n_objects).sum()),
            ..Counts::default()
        },
        warnings,
        cracked: ProtocolResults::default(),
        paired: Vec::new(),
        curves: Vec::new(),
        subsets: Vec::new(),
        failures: None,
        tide_cracked: None,
        timelines,
        pooled_clips,
        worst: Vec::new(),
        changed_objects: Vec::new(),
    };
    let dataset = match (&args.labels, evaluation.timelines.as_slice()) {
        (_, [only]) => only.clip.clone(),
        (Some(labels), _) => stem_of(labels),
        (None, _) => "clips".to_owned(),
    };
    let provenance = Provenance {
        inputs: inputs(args, tracks, &evaluation.timelines)?,
        versions: vec![Versions {
            name: "starbreak".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }],
        settings: Settings {
            protocol: format!("objects over frames, matched as in {}", protocol.name()),
            score_threshold: args.score_threshold,
            iou_threshold: args.iou,
            n_bootstrap: args.replicates,
            seed: global.seed,
            resampling_unit: "object".to_owned(),
            max_detections: Some(100),
            ..Settings::default()
        },
        command: Some(global.command.clone()),
        recipe: None,
    };
    Ok(Study::of_one(evaluation, &dataset, provenance))
}

/// The files that the numbers rest on, with their hashes.
fn inputs(
    args: &TimelineArgs,
    tracks: &Tracks,
    clips: &[TimelineResults],
) -> Result<Vec<InputFile>, Failure> {
    let mut inputs = Vec::new();
    let mut add_files = |role: &str, path: &Path, files: &[PathBuf]| -> Result<(), Failure> {
        inputs.push(InputFile::of(role, &path_text(path), files)?);
        Ok(())
    };
    let mut add = |role: &str, path: &Path| add_files(role, path, &files_of(path));
    if let Some(path) = &args.labels {
        add("labels", path)?;
    }
    for path in tracks.files() {
        add("track of the damaged clip", path)?;
    }
    let names: Vec<&str> = clips.iter().map(|clip| clip.clip.as_str()).collect();
    for (side, path) in [("clean", &args.clean), ("damaged", &args.damaged)] {
        for (path, files) in side_files(path, &names) {
            add_files(&format!("detections, {side}"), &path, &files)?;
        }
    }
    for (name, sha256) in tracks.clips() {
        inputs.push(InputFile {
            role: "source clip, by its track".to_owned(),
            path: name.clone(),
            sha256: sha256.clone(),
            n_bytes: None,
        });
    }
    Ok(inputs)
}

/// One clip, for people.
fn said(clip: &TimelineResults) -> String {
    let percent =
        |value: Option<f64>| value.map_or("-".to_owned(), |v| format!("{:.1}", v * 100.0));
    let name = &clip.clip;
    let Some(onset) = clip.cracked.damage_onset else {
        return format!(
            "{name}: found in {} % of frames clean, {} % damaged; no damage",
            percent(clip.clean.before.found.value),
            percent(clip.cracked.before.found.value)
        );
    };
    let mut text = format!(
        "{name}: damage from frame {} ({:.3} s) on; before it found in {} % of frames clean, {} % damaged; from it on \
         {} % clean, {} % damaged",
        onset.frame_idx,
        onset.time_s,
        percent(clip.clean.before.found.value),
        percent(clip.cracked.before.found.value),
        percent(clip.clean.after.found.value),
        percent(clip.cracked.after.found.value),
    );
    if let (Some(cracked), Some(clean)) = (&clip.cracked.survival, &clip.clean.survival) {
        text.push_str(&format!("; {}", said_of_lost(cracked, clean)));
    }
    text
}

fn said_of_lost(cracked: &Survival, clean: &Survival) -> String {
    let half = cracked.median_s.value.map_or(String::new(), |median_s| {
        format!(", half of them within {median_s:.2} s")
    });
    format!(
        "of {} objects at risk {} lost, {} clean{half}",
        cracked.n, cracked.n_lost, clean.n_lost
    )
}
