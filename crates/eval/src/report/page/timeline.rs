//! What is found when, in a clip.

use kuva::prelude::MarkerShape;

use super::super::charts::{ChartText, Curve, CurvePoint, CurveStyle, Ink, curve_chart};
use super::super::words;
use super::failures::nice_step;
use super::{Block, Cell, Table};
use crate::evaluation::{Evaluation, TimelineFrame, TimelineResults};

/// Most objects in a table.
const MAX_TRACKS: usize = 60;

pub(super) fn blocks(evaluation: &Evaluation, id: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    if !evaluation.timelines.is_empty() {
        blocks.push(Block::Heading {
            id: format!("{id}-time"),
            text: "Over time".to_owned(),
        });
    }
    for (place, clip) in evaluation.timelines.iter().enumerate() {
        blocks.extend(chart(clip, &format!("{id}-clip{place}")));
        if !clip.tracks.is_empty() {
            blocks.push(Block::Table {
                table: track_table(clip),
            });
        }
    }
    blocks
}

fn chart(clip: &TimelineResults, id: &str) -> Option<Block> {
    let end = clip.frames.last()?.time_s;
    let most = clip.frames.iter().map(|f| f.n_objects).max().unwrap_or(0);
    if end <= 0.0 || most == 0 {
        return None;
    }
    let points = |of: fn(&TimelineFrame) -> u64| {
        let point = |frame: &TimelineFrame| CurvePoint {
            x: frame.time_s,
            y: words::as_number(of(frame)),
            interval: None,
            words: None,
        };
        clip.frames.iter().map(point).collect()
    };
    let curve = |name, ink, style, points| Curve {
        name,
        ink,
        marker: MarkerShape::Circle,
        style,
        points,
    };
    let curves = [
        curve(
            "labeled",
            Ink::Fourth,
            CurveStyle::Dashed,
            points(|f| f.n_objects),
        ),
        curve(
            "found clean",
            Ink::Clean,
            CurveStyle::Steps,
            points(|f| f.n_found_clean),
        ),
        curve(
            "found cracked",
            Ink::Cracked,
            CurveStyle::Steps,
            points(|f| f.n_found_cracked),
        ),
    ];
    let name = words::name(&clip.clip);
    let top = words::as_number(most) * 1.1;
    let chart = curve_chart(
        &curves,
        ((0.0, end), nice_step(end), "time, s"),
        ((0.0, top), nice_step(top).max(1.0), "objects"),
        &ChartText {
            id,
            title: &format!("Objects found over time in {name}"),
            description: "Steps of labeled objects, of those found clean and of those found cracked.",
        },
    );
    let mut table = Table::new(
        &format!("Frame by frame, {name}."),
        &[
            ("Time, s", true),
            ("Labeled", true),
            ("Found clean", true),
            ("Found cracked", true),
        ],
    );
    for frame in &clip.frames {
        table.push(vec![
            Cell::number(Some(frame.time_s), |v| words::decimal(v, 3)),
            Cell::count(frame.n_objects),
            Cell::count(frame.n_found_clean),
            Cell::count(frame.n_found_cracked),
        ]);
    }
    Some(Block::Chart {
        id: format!("fig-{id}"),
        svg: chart.svg,
        key: chart.key,
        caption: format!("Objects found in each frame of {name}."),
        table: Some(table),
    })
}

fn track_table(clip: &TimelineResults) -> Table {
    let mut caption = format!(
        "Objects of {}: in which share of their frames they are found, how often that changes in the \
         cracked clip, and after which time they are no longer found.",
        words::name(&clip.clip)
    );
    if clip.tracks.len() > MAX_TRACKS {
        caption.push_str(&format!(
            " The first {MAX_TRACKS} of {}; the JSON has all.",
            clip.tracks.len()
        ));
    }
    let mut table = Table::new(
        &caption,
        &[
            ("Object", false),
            ("Class", false),
            ("Frames", true),
            ("Found clean, %", true),
            ("Found cracked, %", true),
            ("Changes", true),
            ("Time to failure, s", true),
        ],
    );
    for track in clip.tracks.iter().take(MAX_TRACKS) {
        table.push(vec![
            Cell::head(&track.track),
            Cell::text(&track.class),
            Cell::count(track.n_frames),
            Cell::number(Some(track.found_clean), words::percent),
            Cell::number(Some(track.found_cracked), words::percent),
            Cell::count(track.n_flickers),
            Cell::number(track.time_to_failure_s, |v| words::decimal(v, 2)),
        ]);
    }
    table
}
