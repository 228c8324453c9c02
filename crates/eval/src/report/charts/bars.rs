//! Pairs of bars in named rows: what each kind of error costs.

use kuva::prelude::{BarPlot, Plot, TickFormat};

use super::{Chart, ChartText, Ink, KeyEntry, count, finish, label, layout, names_at_marks};

/// A chart with a clean and a cracked bar per name.
pub(in crate::report) fn bar_chart(
    rows: &[(String, [f64; 2])],
    (x_end, step): (f64, f64),
    x_label: &str,
    text: &ChartText<'_>,
) -> Chart {
    let mut bars = BarPlot::new().with_horizontal(true).with_gap(0.35);
    for (name, [clean, cracked]) in rows.iter().rev() {
        // The lower one comes first.
        let pair = [(*cracked, Ink::Cracked.css()), (*clean, Ink::Clean.css())];
        bars = bars.with_group(label(name), pair);
    }
    let labels = rows.iter().rev().map(|(name, _)| label(name)).collect();
    let n_rows = count(rows.len());
    let layout = layout((0.0, x_end), (0.4, n_rows + 0.6), 36.0 * n_rows + 110.0)
        .with_y_tick_step(1.0)
        .with_y_tick_format(names_at_marks(labels))
        .with_x_tick_step(step)
        .with_x_tick_format(TickFormat::Auto)
        .with_x_label(x_label);
    let key = vec![
        KeyEntry::new("clean (upper bar)", Ink::Clean, "■"),
        KeyEntry::new("cracked (lower bar)", Ink::Cracked, "■"),
    ];
    finish(vec![Plot::Bar(bars)], layout, text, key)
}
