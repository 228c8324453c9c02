//! Named rows with a point and its interval, or a bar, per series: clean above cracked.

use super::{Chart, ChartText, Ink, PAGE, WIDTH, finish};
use crate::chart::{Axis, Marker, Plot};

/// Height of a row, of what stands above and below them.
const ROW_HEIGHT: f64 = 34.0;
const FRAME_HEIGHT: f64 = 80.0;

/// Share of a row that all series take together: of bars, and of points, whose rows are told apart by the room
/// between them.
const USED_BY_BARS: f64 = 0.7;
const USED_BY_POINTS: f64 = 0.4;

/// One series of values, one per row.
pub(in crate::report) struct RowSeries<'a> {
    pub(in crate::report) name: &'a str,
    pub(in crate::report) ink: Ink,
    /// A bar without one.
    pub(in crate::report) marker: Option<Marker>,
    /// The values with their intervals.
    pub(in crate::report) values: Vec<(f64, Option<[f64; 2]>)>,
}

/// A chart with one row per name.
pub(in crate::report) fn row_chart(
    names: &[String],
    series: &[RowSeries<'_>],
    x: Axis,
    text: &ChartText<'_>,
) -> Chart {
    let y = Axis::of_names(names);
    let count = |n: usize| f64::from(u32::try_from(n).unwrap_or(u32::MAX));
    let height = ROW_HEIGHT * count(names.len()) + FRAME_HEIGHT;
    let mut plot = Plot::new([WIDTH, height], x, y, PAGE);
    let used = match series.iter().all(|one| one.marker.is_none()) {
        true => USED_BY_BARS,
        false => USED_BY_POINTS,
    };
    let share = used / count(series.len()).max(1.0);
    let mut key = Vec::new();
    for (place, one) in series.iter().enumerate() {
        let shift = 0.5 * used - share * (count(place) + 0.5);
        for (row, (value, interval)) in one.values.iter().enumerate() {
            let y = plot.row(row) + shift;
            let Some(marker) = one.marker else {
                let half = 0.5 * share;
                plot.bar([0.0, y - half], [*value, y + half], one.ink.css(), 1.0);
                continue;
            };
            if let Some([low, high]) = *interval {
                plot.interval([[low, y], [high, y]], one.ink.css());
            }
            plot.marker([*value, y], marker, one.ink.css());
        }
        key.push(
            one.ink
                .key(one.name, one.marker.unwrap_or(Marker::Square).letter()),
        );
    }
    finish(plot, text, key)
}
