//! Points and lines over a number: failure over coverage, AP over severity, found over time.

use kuva::prelude::{
    LinePlot, MarkerShape, Plot, ReferenceLine, ScatterPlot, ShadedRegion, TextAnnotation,
    TickFormat,
};

use super::{Chart, ChartText, Ink, KeyEntry, finish, layout, letter_of};

/// A point with the ends of its interval.
#[derive(Debug, Clone)]
pub(in crate::report) struct CurvePoint {
    pub(in crate::report) x: f64,
    pub(in crate::report) y: f64,
    pub(in crate::report) interval: Option<[f64; 2]>,
    /// What stands above it at the top of the chart: how many objects it rests on.
    pub(in crate::report) words: Option<String>,
}

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::report) enum CurveStyle {
    /// Markers with intervals.
    Points,
    /// Markers with intervals, joined.
    JoinedPoints,
    /// A dashed line alone.
    Dashed,
    /// A wide line that jumps.
    Steps,
    /// A narrower one with gaps, through which one of [`Steps`](Self::Steps) below it is seen.
    DashedSteps,
    /// A thin, dotted one: an end of an interval.
    ThinSteps,
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
    pub(in crate::report) marker: MarkerShape,
    pub(in crate::report) style: CurveStyle,
    pub(in crate::report) points: Vec<CurvePoint>,
}

/// An axis: its ends, the distance of its marks, its words.
pub(in crate::report) type Axis<'a> = ((f64, f64), f64, &'a str);

/// A chart of curves.
pub(in crate::report) fn curve_chart(
    curves: &[Curve<'_>],
    x: Axis<'_>,
    y: Axis<'_>,
    text: &ChartText<'_>,
) -> Chart {
    marked_curve_chart(curves, &[], x, y, text)
}

/// A chart of curves with marks on its axis.
pub(in crate::report) fn marked_curve_chart(
    curves: &[Curve<'_>],
    marks: &[Mark<'_>],
    (x, x_step, x_label): Axis<'_>,
    (y, y_step, y_label): Axis<'_>,
    text: &ChartText<'_>,
) -> Chart {
    let mut plots = Vec::new();
    for curve in curves {
        let at = curve.points.iter().map(|point| (point.x, point.y));
        let arms = curve.points.iter().map(|point| match point.interval {
            Some([low, high]) => ((point.y - low).max(0.0), (high - point.y).max(0.0)),
            None => (0.0, 0.0),
        });
        let has_points = matches!(curve.style, CurveStyle::Points | CurveStyle::JoinedPoints);
        if curve.style != CurveStyle::Points {
            let mut line = LinePlot::new()
                .with_data(at.clone())
                .with_color(curve.ink.css())
                .with_stroke_width(2.0);
            line = match curve.style {
                CurveStyle::Dashed => line.with_dashed(),
                CurveStyle::Steps => line.with_step().with_stroke_width(4.0),
                CurveStyle::DashedSteps => line.with_step().with_dashed(),
                CurveStyle::ThinSteps => line.with_step().with_dotted().with_stroke_width(1.2),
                _ => line,
            };
            plots.push(Plot::Line(line));
        }
        if has_points {
            let points = ScatterPlot::new()
                .with_data(at)
                .with_y_err_asymmetric(arms)
                .with_color(curve.ink.css())
                .with_marker(curve.marker)
                .with_size(4.5);
            plots.push(Plot::Scatter(points));
        }
    }
    let mut layout = layout(x, y, 380.0)
        .with_x_tick_step(x_step)
        .with_y_tick_step(y_step)
        .with_x_tick_format(TickFormat::Auto)
        .with_y_tick_format(TickFormat::Auto)
        .with_x_label(x_label)
        .with_y_label(y_label);
    let width = x.1 - x.0;
    for mark in marks {
        layout = match *mark {
            Mark::Shade { from, to, opacity } => layout.with_shaded_region(
                ShadedRegion::vertical(from, to)
                    .with_color("var(--cracked)")
                    .with_opacity(opacity),
            ),
            Mark::Moment { x: at, words } => {
                let line = ReferenceLine::vertical(at).with_color("var(--ink)");
                // To the right of the line, or, near the end, to its left.
                if at < x.0 + width * 0.7 {
                    layout.with_reference_line(line.with_label(words))
                } else {
                    let half = width * 0.0056 * super::count(words.chars().count());
                    let height = y.0 + (y.1 - y.0) * 0.95;
                    let note = TextAnnotation::new(words, at - width * 0.012 - half, height)
                        .with_font_size(12)
                        .with_color("var(--ink)");
                    layout.with_reference_line(line).with_annotation(note)
                }
            }
        };
    }
    // Words stand in a row at the top; where two would touch, the table alone has the second.
    let mut is_free_from = x.0;
    let points = curves.iter().flat_map(|curve| &curve.points);
    for (point, words) in points.filter_map(|p| Some((p, p.words.as_ref()?))) {
        let at = point.x.clamp(x.0 + width * 0.045, x.1 - width * 0.045);
        if at < is_free_from {
            continue;
        }
        is_free_from = at + width * 0.1;
        let note = TextAnnotation::new(words.as_str(), at, y.0 + (y.1 - y.0) * 0.96)
            .with_font_size(11)
            .with_color("var(--soft)");
        layout = layout.with_annotation(note);
    }
    let named = curves.iter().filter(|curve| !curve.name.is_empty());
    let key = named.map(|curve| {
        let mark = match curve.style {
            CurveStyle::Points | CurveStyle::JoinedPoints => letter_of(curve.marker),
            CurveStyle::Steps => "━",
            CurveStyle::Dashed | CurveStyle::DashedSteps => "╍",
            CurveStyle::ThinSteps => "┈",
        };
        KeyEntry::new(curve.name, curve.ink, mark)
    });
    finish(plots, layout, text, key.collect())
}
