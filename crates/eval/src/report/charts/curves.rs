//! Points and lines over a number: failure over coverage, AP over severity, found over time.

use super::{Chart, ChartText, Ink, PAGE, WIDTH, finish};
use crate::chart::{Anchor, Axis, Marker, Plot};

const HEIGHT: f64 = 380.0;

/// A point with the ends of its interval.
#[derive(Debug, Clone)]
pub(in crate::report) struct CurvePoint {
    pub(in crate::report) x: f64,
    pub(in crate::report) y: f64,
    pub(in crate::report) interval: Option<[f64; 2]>,
    /// What stands above it at the top of the chart: how many objects it rests on.
    pub(in crate::report) words: Option<String>,
}

impl CurvePoint {
    /// A point alone.
    pub(in crate::report) fn at(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            interval: None,
            words: None,
        }
    }
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum CurveStyle {
    /// Markers with intervals.
    Points(Marker),
    /// Markers with intervals, joined.
    JoinedPoints(Marker),
    /// A line alone.
    Line,
    /// A dashed one.
    Dashed,
    /// A wide line that jumps.
    Steps,
    /// A narrower one with gaps, through which one of [`Steps`](Self::Steps) below it is seen.
    DashedSteps,
    /// A thin, dotted one: an end of an interval.
    ThinSteps,
}

impl CurveStyle {
    /// Width of its line, px, its dashes, and whether it jumps; points alone have none.
    fn line(self) -> Option<(f64, &'static [f64], bool)> {
        match self {
            Self::Points(_) => None,
            Self::JoinedPoints(_) | Self::Line => Some((2.0, &[], false)),
            Self::Dashed => Some((2.0, &[7.0, 4.0], false)),
            Self::Steps => Some((4.0, &[], true)),
            Self::DashedSteps => Some((2.0, &[7.0, 4.0], true)),
            Self::ThinSteps => Some((1.2, &[2.0, 3.0], true)),
        }
    }

    /// How it looks in the key.
    fn letter(self) -> &'static str {
        match self {
            Self::Points(marker) | Self::JoinedPoints(marker) => marker.letter(),
            Self::Line | Self::Steps => "━",
            Self::Dashed | Self::DashedSteps => "╍",
            Self::ThinSteps => "┈",
        }
    }
}

/// A moment or a time on the axis of a chart.
#[derive(Debug, Clone, Copy)]
pub(in crate::report) enum Mark<'a> {
    /// A dashed line with words at its top.
    Moment { x: f64, words: &'a str },
    /// A shade behind the curves.
    Shade { from: f64, to: f64, opacity: f64 },
}

/// One curve.
pub(in crate::report) struct Curve<'a> {
    /// Its name in the key, where it is not there if it has none.
    pub(in crate::report) name: &'a str,
    pub(in crate::report) ink: Ink,
    pub(in crate::report) style: CurveStyle,
    pub(in crate::report) points: Vec<CurvePoint>,
}

/// A chart of curves, with marks on its x axis.
pub(in crate::report) fn curve_chart(
    curves: &[Curve<'_>],
    marks: &[Mark<'_>],
    x: Axis,
    y: Axis,
    text: &ChartText<'_>,
) -> Chart {
    let [begin, end] = x.ends();
    let [low, high] = y.ends();
    let width = end - begin;
    let mut plot = Plot::new([WIDTH, HEIGHT], x, y, PAGE);
    for mark in marks {
        match *mark {
            Mark::Shade { from, to, opacity } => {
                plot.bar([from, low], [to, high], Ink::Cracked.css(), opacity);
            }
            Mark::Moment { x, words } => {
                plot.line(&[[x, low], [x, high]], PAGE.ink, 1.0, &[4.0, 4.0]);
                // To the right of the line, or, near the end, to its left.
                let anchor = match x < begin + width * 0.7 {
                    true => Anchor::Start,
                    false => Anchor::End,
                };
                plot.note(x, words, anchor, false);
            }
        }
    }
    for curve in curves {
        if let Some((width_px, dashes, jumps)) = curve.style.line() {
            let mut values: Vec<[f64; 2]> = Vec::new();
            for point in &curve.points {
                let before = values
                    .last()
                    .filter(|_| jumps)
                    .map(|last| [point.x, last[1]]);
                values.extend(before);
                values.push([point.x, point.y]);
            }
            plot.line(&values, curve.ink.css(), width_px, dashes);
        }
        if let CurveStyle::Points(marker) | CurveStyle::JoinedPoints(marker) = curve.style {
            for point in &curve.points {
                if let Some([low, high]) = point.interval {
                    plot.interval([[point.x, low], [point.x, high]], curve.ink.css());
                }
                plot.marker([point.x, point.y], marker, curve.ink.css());
            }
        }
    }
    // Words stand in a row at the top; where two would touch, the table alone has the second.
    let mut is_free_from = begin;
    let points = curves.iter().flat_map(|curve| &curve.points);
    for (point, words) in points.filter_map(|p| Some((p, p.words.as_ref()?))) {
        let at = point.x.clamp(begin + width * 0.045, end - width * 0.045);
        if at >= is_free_from {
            is_free_from = at + width * 0.1;
            plot.note(at, words, Anchor::Middle, true);
        }
    }
    let named = curves.iter().filter(|curve| !curve.name.is_empty());
    let key = named.map(|curve| curve.ink.key(curve.name, curve.style.letter()));
    finish(plot, text, key.collect())
}
