//! The timing figure: time per module over the number of particles, both axes logarithmic.

use kuva::prelude::{Layout, LegendPosition, LinePlot, Plot};
use kuva::{render_to_png, render_to_svg};

use super::bench::Spread;

/// Colors that stay apart for color-blind eyes (Okabe and Ito).
const COLORS: [&str; 4] = ["#0072b2", "#009e73", "#d55e00", "#222222"];

/// Pixels per user unit of the PNG.
const PNG_SCALE: f32 = 2.0;

/// The figure as SVG text and as PNG bytes: means as lines, minimum to maximum as bands.
pub(super) fn timing_figure(
    lines: &[(&'static str, Vec<(f64, Spread)>)],
) -> Result<(String, Vec<u8>), String> {
    let plots = || -> Vec<Plot> {
        lines
            .iter()
            .zip(COLORS)
            .map(|((name, points), color)| {
                let line = LinePlot::new()
                    .with_data(points.iter().map(|(n, spread)| (*n, spread.mean)))
                    .with_color(color)
                    .with_band(
                        points.iter().map(|(_, spread)| spread.min),
                        points.iter().map(|(_, spread)| spread.max),
                    )
                    .with_stroke_width(2.0)
                    .with_legend(*name);
                Plot::Line(line)
            })
            .collect()
    };
    let layout = |plots: &[Plot]| {
        Layout::auto_from_plots(plots)
            .with_title("Time per image over the number of particles (1242 × 375, one thread)")
            .with_x_label("particles")
            .with_y_label("time, ms (mean, minimum to maximum)")
            .with_log_scale()
            .with_width(900.0)
            .with_height(540.0)
            .with_legend_position(LegendPosition::OutsideRightTop)
    };
    let (first, second) = (plots(), plots());
    let (svg_layout, png_layout) = (layout(&first), layout(&second));
    let svg = render_to_svg(first, svg_layout);
    let png = render_to_png(second, png_layout, PNG_SCALE).map_err(|cause| cause.to_string())?;
    Ok((svg, png))
}
