//! The timing figure: time per module over the number of particles, both axes logarithmic.

use starbreak_eval::chart::{Anchor, Axis, Drawing, PAPER, Plot};

use super::bench::Spread;

/// Colors that stay apart for color-blind eyes (Okabe and Ito).
const COLORS: [&str; 4] = ["#0072b2", "#009e73", "#d55e00", "#222222"];

/// Sizes of the plot, and of the sheet with title and key around it.
const PLOT_PX: [f64; 2] = [680.0, 500.0];
const SHEET_PX: [f64; 2] = [900.0, 540.0];

/// The figure: means as lines, minimum to maximum as bands.
pub(super) fn timing_figure(lines: &[(&'static str, Vec<(f64, Spread)>)]) -> Drawing {
    let all = || lines.iter().flat_map(|(_, points)| points);
    let x = Axis::log(all().map(|(n, _)| *n), "particles");
    let times = all().flat_map(|(_, spread)| [spread.min, spread.max]);
    let y = Axis::log(times, "time, ms (mean, minimum to maximum)");
    let mut plot = Plot::new(PLOT_PX, x, y, PAPER);
    let mut sheet = Drawing {
        size_px: SHEET_PX,
        ..Drawing::default()
    };
    let title = "Time per image over the number of particles (1242 × 375, one thread)";
    let middle = [0.5 * SHEET_PX[0], 26.0];
    sheet.words(middle, title, (16.0, Anchor::Middle, 0.0), PAPER.ink);
    let mut y = 60.0;
    for ((name, points), color) in lines.iter().zip(COLORS) {
        let lower = points.iter().map(|(n, spread)| [*n, spread.min]);
        let upper = points.iter().rev().map(|(n, spread)| [*n, spread.max]);
        plot.area(&lower.chain(upper).collect::<Vec<_>>(), color, 0.2);
        let means: Vec<[f64; 2]> = points.iter().map(|(n, it)| [*n, it.mean]).collect();
        plot.line(&means, color, 2.0, &[]);
        let x = PLOT_PX[0];
        sheet.line(&[[x, y], [x + 22.0, y]], color, 2.0, &[]);
        sheet.words(
            [x + 30.0, y + 4.5],
            name,
            (13.0, Anchor::Start, 0.0),
            PAPER.ink,
        );
        y += 22.0;
    }
    sheet.put(plot.finish(), [0.0, 40.0]);
    sheet
}
