//! What is found when, in a clip.

use super::super::words;
use super::clip_charts::{Curves, time_chart};
use super::{Block, Cell, Section, Table};
use crate::evaluation::{
    Estimate, Evaluation, PooledClips, PooledUnit, Study, TimelineResults, TrackSource,
};
use crate::timeline::{Steadiness, Survival, Timeline, TrackFate, TrackRow};

/// Most objects in a table.
const MAX_TRACKS: usize = 60;

pub(super) fn blocks(evaluation: &Evaluation, id: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    for (place, clip) in evaluation.timelines.iter().enumerate() {
        let id = format!("{id}-clip{place}");
        blocks.push(Block::heading(
            format!("{id}-time"),
            words::name(&format!("Over time: {}", clip.clip)),
        ));
        blocks.push(Block::text(words::name(&about(clip))));
        blocks.extend(time_chart(clip, &id));
        blocks.push(Block::table(steadiness_table(clip)));
        blocks.extend(Curves::of_clip(clip).and_then(|curves| curves.chart(&id)));
        if !clip.objects.is_empty() {
            blocks.push(Block::table(track_table(clip)));
        }
    }
    blocks
}

/// By which rules.
fn about(clip: &TimelineResults) -> String {
    let objects = match clip.truth {
        TrackSource::Labels => "The objects are those of the labels".to_owned(),
        TrackSource::CleanDetections { follow } => format!(
            "There are no labels: the objects are the detections in the clean clip with a confidence score of at \
             least {}, followed from frame to frame by an IoU of at least {}, over gaps of at most {} frames, and kept \
             if they are in at least {} frames",
            follow.score_threshold, follow.iou, follow.max_gap_frames, follow.min_frames
        ),
    };
    let n_labeled = clip.cracked.frames.len() as u64;
    let frames = match n_labeled == clip.n_frames {
        true => format!("all {} frames", words::count(n_labeled)),
        false => format!(
            "{} labeled of {} frames",
            words::count(n_labeled),
            words::count(clip.n_frames)
        ),
    };
    let rate = clip.frames_per_s.map_or(String::new(), |rate| {
        format!(" at {} per second", words::decimal(rate, 2))
    });
    format!(
        "{objects}, over {frames}{rate}. An object is found if a detection of its class has a confidence score of at \
         least {} and an IoU of at least {}. From the onset of damage on, it is lost at the first frame from which it \
         is missed in {} of its frames in a row.",
        clip.score_threshold, clip.iou_threshold, clip.cracked.settings.lost_for_frames
    )
}

/// Clean and cracked, before and after the damage.
fn steadiness_table(clip: &TimelineResults) -> Table {
    let mut table = Table::new(
        &format!(
            "Stability of detection in {}, before the onset of damage and from it on. Flicker: the share of steps from \
             one frame of an object to its next at which it changes between found and missed. Percent; {} % intervals \
             by resampling objects.",
            clip.clip,
            words::decimal(clip.cracked.settings.level * 100.0, 0)
        ),
        "Clip|When|#Objects|#Frames of objects|#Found|#Steps|#Flicker",
    );
    let has_onset = clip.cracked.damage_onset.is_some();
    for (name, side) in [("clean", &clip.clean), ("damaged", &clip.cracked)] {
        let parts: &[(&str, &Steadiness)] = match has_onset {
            true => &[
                ("before the onset", &side.before),
                ("from the onset on", &side.after),
            ],
            false => &[("all frames", &side.before)],
        };
        for (when, part) in parts {
            let row = vec![
                Cell::head(name),
                Cell::text(when),
                Cell::count(part.found.n),
                Cell::count(part.n_sightings),
                table.estimate(&Estimate::from(&part.found), words::percent),
                Cell::count(part.n_steps),
                table.estimate(&Estimate::from(&part.flicker), words::percent),
            ];
            table.push(row);
        }
    }
    if let Some(change) = &clip.change {
        let row = vec![
            Cell::head("damaged − clean"),
            Cell::text("from the onset on"),
            Cell::count(change.found.n),
            Cell::nothing(),
            table.estimate(&Estimate::from(&change.found), words::signed_percent),
            Cell::nothing(),
            table.estimate(&Estimate::from(&change.flicker), words::signed_percent),
        ];
        table.push(row);
    }
    table
}

/// A fate in words, and what it sorts by.
fn fate(row: &TrackRow) -> (u8, f64, String) {
    match &row.fate {
        TrackFate::Lost { frame_idx, after_s } => (
            0,
            *after_s,
            format!(
                "lost in frame {frame_idx}, after {} s",
                words::decimal(*after_s, 2)
            ),
        ),
        TrackFate::Kept { for_s } => (
            1,
            *for_s,
            format!("not lost in {} s (censored)", words::decimal(*for_s, 2)),
        ),
        TrackFate::NotAtRisk { reason } => (2, 0.0, format!("not at risk: {reason}")),
    }
}

fn track_table(clip: &TimelineResults) -> Table {
    let mut rows: Vec<(&TrackRow, Option<&TrackRow>)> = clip
        .cracked
        .tracks
        .iter()
        .map(|row| {
            let mut clean = clip.clean.tracks.iter();
            (row, clean.find(|other| other.track == row.track))
        })
        .collect();
    rows.sort_by(|(a, _), (b, _)| {
        let (a, b) = (fate(a), fate(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut caption = format!(
        "Objects of {}, lost ones first: the share of their frames in which they are found, how often that changes, \
         the longest gap, and whether they are lost in the damaged and in the clean clip.",
        clip.clip
    );
    if rows.len() > MAX_TRACKS {
        caption.push_str(&format!(
            " The first {MAX_TRACKS} of {}; the JSON has all.",
            rows.len()
        ));
    }
    let mut table = Table::new(
        &caption,
        "Object|Class|Damaged|Clean|#Frames|#Found clean, %|#Found damaged, %|#Changes clean|#Changes damaged|#Longest gap damaged, frames",
    );
    let share = |row: &TrackRow| {
        (row.n_frames > 0).then(|| words::as_number(row.n_found) / words::as_number(row.n_frames))
    };
    for (row, clean) in rows.into_iter().take(MAX_TRACKS) {
        let named = clip.objects.iter().find(|it| it.track == row.track);
        let gap = row.gaps_frames.iter().max().copied().unwrap_or(0);
        table.push(vec![
            Cell::head(named.map_or("", |it| it.name.as_str())),
            Cell::text(named.map_or("", |it| it.class.as_str())),
            Cell::text(fate(row).2),
            Cell::text(clean.map_or_else(String::new, |clean| fate(clean).2)),
            Cell::count(row.n_frames),
            Cell::number(clean.and_then(share), words::percent),
            Cell::number(share(row), words::percent),
            clean.map_or_else(Cell::nothing, |clean| Cell::count(clean.n_changes)),
            Cell::count(row.n_changes),
            Cell::count(gap.into()),
        ]);
    }
    table
}

/// The median time to detection loss with the ends of its interval, s.
pub(super) fn median_words(survival: &Survival, level: f64) -> String {
    let seconds = |value: f64| words::decimal(value, 2);
    let level = words::decimal(level * 100.0, 0);
    match survival.median_s.value {
        Some(value) => {
            let interval = match survival.median_ends_s {
                [Some(low), Some(high)] => {
                    format!(
                        " ({level} % interval {} to {} s)",
                        seconds(low),
                        seconds(high)
                    )
                }
                [Some(low), None] => format!(
                    " ({level} % interval from {} s, upper end beyond the clip)",
                    seconds(low)
                ),
                [None, _] => String::new(),
            };
            format!("{} s{interval}", words::decimal(value, 2))
        }
        None => "not reached (fewer than half are lost)".to_owned(),
    }
}

/// Whether there is nothing in a study but clips.
pub(super) fn is_of_clips_alone(study: &Study) -> bool {
    !study.evaluations.is_empty()
        && study
            .evaluations
            .iter()
            .all(|one| !one.timelines.is_empty() && one.paired.is_empty() && one.failures.is_none())
}

/// What a study of clips alone is of.
pub(super) fn subtitle(study: &Study) -> String {
    let clips: Vec<&TimelineResults> = study
        .evaluations
        .iter()
        .flat_map(|e| &e.timelines)
        .collect();
    let n_frames: u64 = clips.iter().map(|clip| clip.n_frames).sum();
    let n_objects: u64 = clips.iter().map(|clip| clip.objects.len() as u64).sum();
    let s = |n: u64| if n == 1 { "" } else { "s" };
    let n_clips = clips.len() as u64;
    words::name(&format!(
        "{} clip{} of {} frames with {} object{} of {}, clean and damaged: what the detector finds in each frame, and \
         after what time it loses an object.",
        words::count(n_clips),
        s(n_clips),
        words::count(n_frames),
        words::count(n_objects),
        s(n_objects),
        study.dataset,
    ))
}

/// The findings of clips, one sentence each.
pub(super) fn facts(study: &Study) -> Vec<String> {
    let mut facts = Vec::new();
    for one in &study.evaluations {
        let pooled = one.pooled_clips.as_ref();
        facts.extend(pooled.map(|pooled| pooled_fact(one, pooled)));
        for clip in &one.timelines {
            facts.extend(fact(one, clip));
        }
    }
    facts
}

fn fact(one: &Evaluation, clip: &TimelineResults) -> Option<String> {
    let onset = clip.cracked.damage_onset?;
    let percent = |value: Option<f64>| value.map(words::percent);
    let found = percent(clip.cracked.after.found.value)?;
    let found_clean = percent(clip.clean.after.found.value)?;
    let mut text = format!(
        "{}, {}: from the onset of damage at {} s on, objects are found in {found} % of their frames, against \
         {found_clean} % in the clean clip",
        one.detector,
        clip.clip,
        words::decimal(onset.time_s, 2)
    );
    let change = clip
        .change
        .as_ref()
        .map(|change| Estimate::from(&change.found));
    if let Some([low, high]) = change.and_then(|change| change.interval()) {
        text.push_str(&format!(
            " (95 % interval of the difference {} to {} points)",
            words::signed_percent(low),
            words::signed_percent(high)
        ));
    }
    if let (Some(cracked), Some(clean)) = (&clip.cracked.survival, &clip.clean.survival) {
        text.push_str(&format!(
            "; of {} objects at risk, {} are lost, against {} in the clean clip",
            words::count(cracked.n),
            words::count(cracked.n_lost),
            words::count(clean.n_lost)
        ));
        if cracked.n_lost > 0 {
            let median = median_words(cracked, clip.cracked.settings.level);
            text.push_str(&format!("; median time to detection loss {median}"));
        }
    }
    text.push('.');
    Some(words::name(&text))
}

fn pooled_fact(one: &Evaluation, pooled: &PooledClips) -> String {
    let mut text = format!(
        "{}, all {} clips together: of {} objects at risk, {} are lost, against {} in the clean clips",
        one.detector,
        words::count(pooled.n_clips),
        words::count(pooled.cracked.n),
        words::count(pooled.cracked.n_lost),
        words::count(pooled.clean.n_lost)
    );
    if pooled.cracked.n_lost > 0 {
        let median = median_words(&pooled.cracked, pooled.level);
        text.push_str(&format!("; median time to detection loss {median}"));
    }
    text.push('.');
    words::name(&text)
}

/// All clips in one table.
pub(super) fn section(study: &Study) -> Section {
    let mut table = Table::new(
        "All clips: objects at risk at the onset of damage, how many of them are lost, their median time to detection \
         loss, and the share of their frames in which objects are found from then on. Percent; 95 % intervals in \
         brackets.",
        "Clip|#Onset, s|#At risk|#Lost damaged|#Lost clean|#Median time to detection loss, s|#Found clean, %|#Found damaged, %|#Difference",
    );
    for one in &study.evaluations {
        for clip in &one.timelines {
            let survival = clip.cracked.survival.as_ref();
            let lost = |side: &Timeline| match &side.survival {
                Some(survival) => Cell::count(survival.n_lost),
                None => Cell::nothing(),
            };
            let onset = clip.cracked.damage_onset.map(|frame| frame.time_s);
            let median = match survival {
                Some(survival) => median_cell(&mut table, survival),
                None => Cell::nothing(),
            };
            let row = vec![
                Cell::head(&clip.clip),
                Cell::number(onset, |v| words::decimal(v, 2)),
                survival.map_or_else(Cell::nothing, |it| Cell::count(it.n)),
                lost(&clip.cracked),
                lost(&clip.clean),
                median,
                table.estimate(&Estimate::from(&clip.clean.after.found), words::percent),
                table.estimate(&Estimate::from(&clip.cracked.after.found), words::percent),
                match &clip.change {
                    Some(change) => {
                        table.estimate(&Estimate::from(&change.found), words::signed_percent)
                    }
                    None => Cell::nothing(),
                },
            ];
            table.push(row);
        }
        if let Some(pooled) = &one.pooled_clips {
            let median = median_cell(&mut table, &pooled.cracked);
            let nothing = Cell::nothing;
            table.push(vec![
                Cell::head("all clips together"),
                nothing(),
                Cell::count(pooled.cracked.n),
                Cell::count(pooled.cracked.n_lost),
                Cell::count(pooled.clean.n_lost),
                median,
                nothing(),
                nothing(),
                nothing(),
            ]);
        }
    }
    let mut blocks = vec![Block::table(table)];
    for (place, one) in study.evaluations.iter().enumerate() {
        let Some(pooled) = &one.pooled_clips else {
            continue;
        };
        blocks.push(Block::text(words::name(&about_pooled(pooled))));
        let curves = Curves {
            of: format!("all {} clips together", words::count(pooled.n_clips)),
            clean: &pooled.clean,
            cracked: &pooled.cracked,
            followed_s: pooled.followed_s,
            level: pooled.level,
        };
        blocks.extend(curves.chart(&format!("e{place}-clips")));
    }
    Section {
        id: "overview".to_owned(),
        title: "Overview".to_owned(),
        blocks,
    }
}

/// By which rules clips are taken together.
fn about_pooled(pooled: &PooledClips) -> String {
    let unit = match pooled.unit {
        PooledUnit::Clip => {
            "objects of one clip share its damage and its scene, so the interval uses the variance between clips (Williams)"
        }
        PooledUnit::Object => {
            "there are too few clips, so the interval treats objects as independent (Greenwood); it is too narrow, as \
             objects of one clip share its damage"
        }
    };
    format!(
        "One curve for the objects of all {} clips with damage, with time from the onset of damage of each clip; \
         {unit}.",
        words::count(pooled.n_clips)
    )
}

/// The median time to detection loss, s, with those ends of its interval that are known.
fn median_cell(table: &mut Table, survival: &Survival) -> Cell {
    let ends = survival.median_ends_s;
    let small = ends.iter().any(Option::is_some).then(|| {
        let [low, high] =
            ends.map(|end| end.map_or(words::NOTHING.to_owned(), |v| words::decimal(v, 2)));
        format!("[{low}, {high}]")
    });
    let mut estimate = Estimate::from(&survival.median_s);
    (estimate.low, estimate.high) = (None, None);
    table
        .estimate(&estimate, |v| words::decimal(v, 2))
        .with_small(small)
}
