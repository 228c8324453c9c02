//! The matrix of all pairs as a picture.

use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::prelude::{ColorMap, Figure, Heatmap, Layout, Plot};

use super::features::Feature;
use super::report::{DivergenceReport, Measure};

/// Pixels of a cell, and of what stands around.
const CELL_PX: f64 = 70.0;
const AROUND_PX: f64 = 220.0;

/// Longest name of a set in the picture.
const LONGEST_NAME: usize = 18;

/// Panels in a row.
const COLUMNS: usize = 3;

/// A heat map of the Jensen-Shannon divergence for each feature, all sets against all, as SVG. What
/// stands on the diagonal is the mean of a set's own split-halves: cells that are not above it say
/// nothing.
#[must_use]
pub fn divergence_svg(report: &DivergenceReport) -> String {
    let names: Vec<String> = report.sets.iter().map(|set| shortened(&set.name)).collect();
    let features: Vec<Feature> = report
        .pairs
        .first()
        .map(|pair| {
            pair.features
                .iter()
                .map(|compared| compared.feature)
                .collect()
        })
        .unwrap_or_default();
    #[expect(clippy::cast_precision_loss, reason = "a number of sets")]
    let side = AROUND_PX + CELL_PX * names.len() as f64;
    let (mut plots, mut layouts) = (Vec::new(), Vec::new());
    for feature in &features {
        // The first row is drawn at the bottom: turned, so that it is on top.
        let mut rows = matrix(report, *feature);
        rows.reverse();
        let heat = Heatmap::new()
            .with_data(rows)
            .with_color_map(ColorMap::Custom(Arc::new(shade)))
            .with_values();
        let panel = vec![Plot::Heatmap(heat)];
        let mut turned = names.clone();
        turned.reverse();
        let layout = Layout::auto_from_plots(&panel)
            .with_title(format!("{}: JS, millinats", feature.name()))
            .with_x_categories(names.clone())
            .with_y_categories(turned)
            .with_x_tick_rotate(-30.0);
        plots.push(panel);
        layouts.push(layout);
    }
    let columns = COLUMNS.min(plots.len().max(1));
    let figure = Figure::new(plots.len().div_ceil(columns).max(1), columns)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_cell_size(side, side)
        .with_title("Divergence of all pairs; on the diagonal: split-halves of one set");
    SvgBackend.render_scene(&figure.render())
}

/// JS of all pairs, by rows; floors on the diagonal, NaN where there is no number.
fn matrix(report: &DivergenceReport, feature: Feature) -> Vec<Vec<f64>> {
    let value = |a: &str, b: &str| -> Option<f64> {
        let is_it = |x: &str, y: &str| x == a && y == b || x == b && y == a;
        let pair = report.pairs.iter().find(|pair| is_it(&pair.a, &pair.b))?;
        let compared = pair.features.iter().find(|c| c.feature == feature)?;
        Some(compared.measures.get(&Measure::Js)?.value)
    };
    let floor = |set: &str| report.floor(set, feature, Measure::Js);
    let cell = |(i, a): (usize, &str), (j, b): (usize, &str)| {
        let value = if i == j { floor(a) } else { value(a, b) };
        value.map_or(f64::NAN, |v| (v * 1e5).round() / 1e2)
    };
    let names: Vec<&str> = report.sets.iter().map(|set| set.name.as_str()).collect();
    let places = || names.iter().copied().enumerate();
    places()
        .map(|row| places().map(|column| cell(row, column)).collect())
        .collect()
}

/// White to orange: dark text stays readable on all of it.
fn shade(share: f64) -> String {
    let mix = |end: f64| 255.0 - (255.0 - end) * share.clamp(0.0, 1.0);
    format!("rgb({:.0},{:.0},{:.0})", mix(240.0), mix(150.0), mix(40.0))
}

fn shortened(name: &str) -> String {
    let n = name.chars().count();
    if n <= LONGEST_NAME {
        return name.to_owned();
    }
    let tail: String = name.chars().skip(n + 1 - LONGEST_NAME).collect();
    format!("…{tail}")
}
