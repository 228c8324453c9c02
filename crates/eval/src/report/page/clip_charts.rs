//! Charts of a clip: what is found when, and how long objects stay found.

use super::super::charts::{ChartText, Curve, CurvePoint, CurveStyle, Ink, Mark, curve_chart};
use super::super::words;
use super::timeline::median_words;
use super::{Block, Cell, Table};
use crate::chart::Axis;
use crate::evaluation::{Estimate, TimelineResults};
use crate::timeline::{FrameRow, GlassState, Survival, Timeline, TrackFate};

/// Most frames in a table.
const MAX_FRAMES: usize = 400;

fn curve(name: &str, ink: Ink, style: CurveStyle, points: Vec<CurvePoint>) -> Curve<'_> {
    Curve {
        name,
        ink,
        style,
        points,
    }
}

/// Objects found in each frame.
pub(super) fn time_chart(clip: &TimelineResults, id: &str) -> Option<Block> {
    let frames = &clip.cracked.frames;
    let (first, last) = (frames.first()?.time_s, frames.last()?.time_s);
    // A frame lasts as long as the one before it.
    let step_s = match frames.len() {
        0 | 1 => 1.0,
        n => (last - first) / words::as_number(n as u64 - 1),
    };
    let end = last + step_s;
    let most = frames.iter().map(|f| f.n_objects).max().unwrap_or(0);
    if most == 0 {
        return None;
    }
    let points = |rows: &[FrameRow], of: fn(&FrameRow) -> u64| {
        let own = rows
            .iter()
            .map(|row| CurvePoint::at(row.time_s, words::as_number(of(row))));
        let held = rows
            .last()
            .map(|row| CurvePoint::at(end, words::as_number(of(row))));
        own.chain(held).collect::<Vec<_>>()
    };
    // The later lie over the earlier, narrower and with gaps: where all three are equal, all are seen.
    let curves = [
        curve(
            "found, damaged",
            Ink::Cracked,
            CurveStyle::Steps,
            points(frames, |row| row.n_found),
        ),
        curve(
            "found, clean",
            Ink::Clean,
            CurveStyle::DashedSteps,
            points(&clip.clean.frames, |row| row.n_found),
        ),
        curve(
            "objects to be found",
            Ink::Fourth,
            CurveStyle::ThinSteps,
            points(frames, |row| row.n_objects),
        ),
    ];
    let onset = clip.cracked.damage_onset.map(|frame| frame.time_s);
    let growing: Vec<&FrameRow> = frames
        .iter()
        .filter(|row| row.state == Some(GlassState::Growing))
        .collect();
    let mut marks = Vec::new();
    if let (Some(from), Some(to)) = (growing.first(), growing.last()) {
        marks.push(Mark::Shade {
            from: from.time_s,
            to: to.time_s + step_s,
            opacity: 0.14,
        });
    }
    if let Some(x) = onset {
        marks.push(Mark::Moment { x, words: "damage" });
    }
    let name = words::name(&clip.clip);
    let top = words::as_number(most) * 1.15;
    let glass = glass_words(onset, &growing, step_s);
    let chart = curve_chart(
        &curves,
        &marks,
        Axis::of([first, end], "time, s"),
        Axis::of_counts([0.0, top], "objects"),
        &ChartText {
            id,
            title: &format!("Objects found over time in {name}"),
            description: &format!(
                "Step curves of the objects to be found, of those found in the clean clip and of those found in the \
                 damaged clip. {glass} The table below gives the numbers."
            ),
        },
    );
    Some(Block::chart(
        chart,
        format!("Objects found in each frame of {name}. {glass}"),
        Some(frame_table(clip)),
    ))
}

/// When the glass breaks, in words.
fn glass_words(onset: Option<f64>, growing: &[&FrameRow], step_s: f64) -> String {
    let Some(onset) = onset else {
        return "It has no onset of damage.".to_owned();
    };
    let grown = growing.last().map_or(String::new(), |last| {
        format!(
            " and grows until {} s (shaded)",
            words::decimal(last.time_s + step_s, 2)
        )
    });
    format!(
        "The damage begins at {} s{grown}.",
        words::decimal(onset, 2)
    )
}

fn frame_table(clip: &TimelineResults) -> Table {
    let n_frames = clip.cracked.frames.len();
    let every = n_frames.div_ceil(MAX_FRAMES).max(1);
    let which = match every {
        1 => "Frame by frame".to_owned(),
        _ => format!("Every {every} frames (the JSON has all)"),
    };
    let mut table = Table::new(
        &format!("{which}, {}.", clip.clip),
        "#Frame|#Time, s|Glass|#Objects|#Found clean|#Found damaged|#Mean score clean|#Mean score damaged",
    );
    let pairs = clip.clean.frames.iter().zip(&clip.cracked.frames);
    for (clean, cracked) in pairs.step_by(every) {
        let glass = match cracked.state {
            Some(GlassState::Intact) => "intact",
            Some(GlassState::Growing) => "growing",
            Some(GlassState::Still) => "static",
            None => words::NOTHING,
        };
        table.push(vec![
            Cell::count(cracked.frame_idx),
            Cell::number(Some(cracked.time_s), |v| words::decimal(v, 3)),
            Cell::text(glass),
            Cell::count(cracked.n_objects),
            Cell::count(clean.n_found),
            Cell::count(cracked.n_found),
            Cell::number(clean.mean_score, |v| words::decimal(v, 2)),
            Cell::number(cracked.mean_score, |v| words::decimal(v, 2)),
        ]);
    }
    table
}

/// Until when any object at risk is followed, s after the damage.
fn last_s(timeline: &Timeline) -> f64 {
    let end = timeline.tracks.iter().map(|row| match row.fate {
        TrackFate::Lost { after_s, .. } => after_s,
        TrackFate::Kept { for_s } => for_s,
        TrackFate::NotAtRisk { .. } => 0.0,
    });
    end.fold(0.0, f64::max)
}

/// The share not lost, by `of`, as the corners of its steps; up to the first step that has none.
fn steps(
    survival: &Survival,
    mut end_s: f64,
    of: impl Fn(&crate::timeline::SurvivalStep) -> Option<f64>,
) -> Vec<CurvePoint> {
    let mut points = vec![CurvePoint::at(0.0, 100.0)];
    for step in &survival.steps {
        let Some(share) = of(step) else {
            end_s = step.time_s;
            break;
        };
        points.push(CurvePoint::at(step.time_s, share * 100.0));
    }
    if let Some(last) = points.last().map(|last| last.y) {
        points.push(CurvePoint::at(end_s, last));
    }
    points
}

/// How long objects stay found, clean and cracked.
pub(super) struct Curves<'a> {
    /// Of what: a clip, or all.
    pub(super) of: String,
    pub(super) clean: &'a Survival,
    pub(super) cracked: &'a Survival,
    /// Until when objects are followed, s after the damage, clean and cracked.
    pub(super) followed_s: [f64; 2],
    /// Level of confidence.
    pub(super) level: f64,
}

impl<'a> Curves<'a> {
    /// Those of a clip with damage.
    pub(super) fn of_clip(clip: &'a TimelineResults) -> Option<Self> {
        Some(Self {
            of: words::name(&clip.clip),
            clean: clip.clean.survival.as_ref()?,
            cracked: clip.cracked.survival.as_ref()?,
            followed_s: [last_s(&clip.clean), last_s(&clip.cracked)],
            level: clip.cracked.settings.level,
        })
    }

    /// A chart, where there is something to see in it.
    pub(super) fn chart(&self, id: &str) -> Option<Block> {
        let (clean, cracked) = (self.clean, self.cracked);
        let [clean_end_s, own] = self.followed_s;
        let end_s = own.max(clean_end_s);
        if cracked.n == 0 || end_s <= 0.0 {
            return None;
        }
        let value = |step: &crate::timeline::SurvivalStep| step.share.value;
        let mut curves = vec![
            curve(
                "damaged",
                Ink::Cracked,
                CurveStyle::Steps,
                steps(cracked, own, value),
            ),
            curve(
                "clean (control)",
                Ink::Clean,
                CurveStyle::DashedSteps,
                steps(clean, clean_end_s, value),
            ),
        ];
        let level = words::decimal(self.level * 100.0, 0);
        let interval_name = format!("{level} % interval, damaged");
        if cracked.n_lost > 0 {
            for (name, end) in [(interval_name.as_str(), 0), ("", 1)] {
                let of = |step: &crate::timeline::SurvivalStep| {
                    let interval = step.share.interval?;
                    Some(if end == 0 {
                        interval.low
                    } else {
                        interval.high
                    })
                };
                curves.push(curve(
                    name,
                    Ink::Cracked,
                    CurveStyle::ThinSteps,
                    steps(cracked, own, of),
                ));
            }
        }
        let of = &self.of;
        let median = median_words(cracked, self.level);
        let chart = curve_chart(
            &curves,
            &[],
            Axis::of([0.0, end_s], "time after the onset of damage, s"),
            Axis::of([0.0, 105.0], "objects not lost, %"),
            &ChartText {
                id: &format!("{id}-survival"),
                title: &format!("Objects not yet lost by time after the onset of damage in {of}"),
                description: &format!(
                    "Falling step curves of the share of objects not lost, damaged and clean. Of {} objects, {} are \
                     lost with damage and {} without. The table below gives the numbers.",
                    cracked.n, cracked.n_lost, clean.n_lost
                ),
            },
        );
        Some(Block::chart(
            chart,
            format!(
                "Share of the objects of {of} that are not yet lost (Kaplan-Meier). At risk are the {} objects found \
                 in the clean clip just after the onset of damage; {} are lost with damage, {} without. Median time \
                 to detection loss with damage: {median}.",
                words::count(cracked.n),
                words::count(cracked.n_lost),
                words::count(clean.n_lost),
            ),
            Some(self.table()),
        ))
    }

    fn table(&self) -> Table {
        let mut table = Table::new(
            &format!(
                "Objects of {} lost, by time after the onset of damage.",
                self.of
            ),
            "Clip|#Time, s|#At risk|#Lost|#Not lost, %",
        );
        for (name, survival) in [("damaged", self.cracked), ("clean", self.clean)] {
            if survival.steps.is_empty() {
                table.remark(&format!(
                    "In the {name} clip, none of {} objects is lost.",
                    survival.n
                ));
            }
            for step in &survival.steps {
                let share = table.estimate(&Estimate::from(&step.share), words::percent);
                table.push(vec![
                    Cell::head(name),
                    Cell::number(Some(step.time_s), |v| words::decimal(v, 2)),
                    Cell::count(step.n_at_risk),
                    Cell::count(step.n_lost),
                    share,
                ]);
            }
        }
        table
    }
}
