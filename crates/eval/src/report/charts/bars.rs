//! Pairs of bars in named rows: what each kind of error costs.

use kuva::prelude::{BarPlot, Plot, ReferenceLine, TickFormat};

use super::{ChartText, Ink, finish, label, layout};

/// A chart with a clean and a cracked bar per name.
pub(in crate::report) fn bar_chart(
    rows: &[(String, [f64; 2])],
    (x_end, step): (f64, f64),
    x_label: &str,
    text: &ChartText<'_>,
) -> String {
    let mut bars = BarPlot::new().with_horizontal(true).with_gap(0.35);
    for (name, [clean, cracked]) in rows.iter().rev() {
        // The lower one comes first.
        let pair = [(*cracked, Ink::Cracked.css()), (*clean, Ink::Clean.css())];
        bars = bars.with_group(label(name), pair);
    }
    bars = bars.with_legend(vec!["cracked", "clean"]);
    let labels = rows.iter().rev().map(|(name, _)| label(name)).collect();
    let n_rows = f64::from(u32::try_from(rows.len()).unwrap_or(u32::MAX));
    let mut layout = layout((0.0, x_end), (0.4, n_rows + 0.6), 36.0 * n_rows + 110.0)
        .with_y_categories(labels)
        .with_x_tick_step(step)
        .with_x_tick_format(TickFormat::Auto)
        .with_x_label(x_label);
    let mut at = step;
    while at <= x_end + step * 1e-6 {
        let line = ReferenceLine::vertical(at)
            .with_color(Ink::Faint.css())
            .with_dasharray("none")
            .with_stroke_width(1.0);
        layout = layout.with_reference_line(line);
        at += step;
    }
    finish(vec![Plot::Bar(bars)], layout, text)
}
