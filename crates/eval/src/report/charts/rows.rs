//! Points with intervals in named rows: AP per class, clean above cracked.

use kuva::prelude::{MarkerShape, Plot, ReferenceLine, ScatterPlot, TickFormat};

use super::{ChartText, Ink, finish, label, layout};

/// A point in a row.
#[derive(Debug, Clone, Copy)]
pub(in crate::report) struct RowPoint {
    /// Which row, from the top.
    pub(in crate::report) row: usize,
    /// Where.
    pub(in crate::report) value: f64,
    /// Both ends of its interval.
    pub(in crate::report) interval: Option<[f64; 2]>,
}

/// One series of points: its name, color, marker and points.
pub(in crate::report) struct RowSeries<'a> {
    pub(in crate::report) name: &'a str,
    pub(in crate::report) ink: Ink,
    pub(in crate::report) marker: MarkerShape,
    pub(in crate::report) points: Vec<RowPoint>,
}

/// Height of a row, of what stands above and below them.
const ROW_HEIGHT: f64 = 34.0;
const FRAME_HEIGHT: f64 = 110.0;

/// A chart with one row per name.
pub(in crate::report) fn row_chart(
    names: &[String],
    series: &[RowSeries<'_>],
    (x, step): ((f64, f64), f64),
    x_label: &str,
    text: &ChartText<'_>,
) -> String {
    let n_rows = count(names.len());
    let spread = 0.34;
    let n_series = count(series.len());
    let plots = series.iter().enumerate().map(|(place, one)| {
        let shift = spread * (count(place) + 0.5 - n_series / 2.0) / n_series.max(1.0) * 2.0;
        let y = |point: &RowPoint| n_rows - count(point.row) - shift / 2.0;
        let points = one.points.iter().map(|point| (point.value, y(point)));
        let arms = one.points.iter().map(|point| match point.interval {
            Some([low, high]) => ((point.value - low).max(0.0), (high - point.value).max(0.0)),
            None => (0.0, 0.0),
        });
        Plot::Scatter(
            ScatterPlot::new()
                .with_data(points)
                .with_x_err_asymmetric(arms)
                .with_color(one.ink.css())
                .with_marker(one.marker)
                .with_size(4.5)
                .with_legend(one.name),
        )
    });
    let mut labels: Vec<String> = names.iter().map(|name| label(name)).collect();
    labels.reverse();
    let height = ROW_HEIGHT * n_rows + FRAME_HEIGHT;
    let mut layout = layout(x, (0.4, n_rows + 0.6), height)
        .with_y_categories(labels)
        .with_x_tick_step(step)
        .with_x_tick_format(TickFormat::Auto)
        .with_x_label(x_label);
    let mut at = x.0;
    while at <= x.1 + step * 1e-6 {
        let line = ReferenceLine::vertical(at)
            .with_color(Ink::Faint.css())
            .with_dasharray("none")
            .with_stroke_width(1.0);
        layout = layout.with_reference_line(line);
        at += step;
    }
    finish(plots.collect(), layout, text)
}

/// A count of rows or series as a place on an axis.
fn count(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}
