//! Points with intervals in named rows: AP per class, clean above cracked.

use kuva::prelude::{MarkerShape, Plot, ScatterPlot, TickFormat};

use super::{
    Chart, ChartText, Ink, KeyEntry, count, finish, label, layout, letter_of, names_at_marks,
};

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
) -> Chart {
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
                .with_size(4.5),
        )
    });
    let mut labels: Vec<String> = names.iter().map(|name| label(name)).collect();
    labels.reverse();
    let height = ROW_HEIGHT * n_rows + FRAME_HEIGHT;
    let layout = layout(x, (0.4, n_rows + 0.6), height)
        .with_y_tick_step(1.0)
        .with_y_tick_format(names_at_marks(labels))
        .with_x_tick_step(step)
        .with_x_tick_format(TickFormat::Auto)
        .with_x_label(x_label);
    let key = series
        .iter()
        .map(|one| KeyEntry::new(one.name, one.ink, letter_of(one.marker)));
    finish(plots.collect(), layout, text, key.collect())
}
