//! The matrix of all pairs as a picture.

use super::features::Feature;
use super::report::{DivergenceReport, Measure};
use crate::chart::{Anchor, Drawing, PAPER};

/// Pixels of a cell, and of what stands left of the cells, above and below them.
const CELL_PX: f64 = 70.0;
const LEFT_PX: f64 = 150.0;
const TOP_PX: f64 = 45.0;
const BELOW_PX: f64 = 110.0;

/// Height of the line above all panels.
const TITLE_PX: f64 = 40.0;

/// Longest name of a set in the picture.
const LONGEST_NAME: usize = 18;

/// Panels in a row.
const COLUMNS: usize = 3;

/// A heat map of the Jensen-Shannon divergence for each feature, all sets against all, as SVG. What
/// stands on the diagonal is the mean of a set's own split-halves: cells that are not above it say
/// nothing.
#[must_use]
pub fn divergence_svg(report: &DivergenceReport) -> String {
    let compared = report.pairs.first().map_or(&[][..], |pair| &pair.features);
    let panels = compared.iter().map(|it| panel(report, it.feature));
    let panels: Vec<Drawing> = panels.collect();
    let [width, height] = panels.first().map_or([0.0; 2], |panel| panel.size_px);
    let columns = COLUMNS.min(panels.len().max(1));
    let n_rows = panels.len().div_ceil(columns).max(1);
    let title = "Divergence of all pairs; on the diagonal: split-halves of one set";
    let mut sheet = Drawing {
        size_px: [
            (width * float(columns)).max(560.0),
            height * float(n_rows) + TITLE_PX,
        ],
        shapes: Vec::new(),
    };
    let middle = 0.5 * sheet.size_px[0];
    sheet.words(
        [middle, 26.0],
        title,
        (16.0, Anchor::Middle, 0.0),
        PAPER.ink,
    );
    for (place, panel) in panels.into_iter().enumerate() {
        let [row, column] = [place / columns, place % columns].map(float);
        sheet.put(panel, [column * width, TITLE_PX + row * height]);
    }
    sheet.svg()
}

/// The heat map of one feature.
fn panel(report: &DivergenceReport, feature: Feature) -> Drawing {
    let rows = matrix(report, feature);
    let names: Vec<String> = report.sets.iter().map(|set| shortened(&set.name)).collect();
    let side = CELL_PX * float(names.len());
    let mut panel = Drawing {
        size_px: [LEFT_PX + side + 20.0, TOP_PX + side + BELOW_PX],
        shapes: Vec::new(),
    };
    let numbers = || rows.iter().flatten().filter(|value| value.is_finite());
    let least = numbers().copied().fold(f64::INFINITY, f64::min);
    let most = numbers().copied().fold(f64::NEG_INFINITY, f64::max);
    let title = format!("{}: JS, millinats", feature.name());
    let style = |size, anchor| (size, anchor, 0.0);
    let middle = LEFT_PX + 0.5 * side;
    panel.words(
        [middle, 32.0],
        &title,
        style(14.0, Anchor::Middle),
        PAPER.ink,
    );
    for (k, (row, name)) in rows.iter().zip(&names).enumerate() {
        let y = TOP_PX + CELL_PX * float(k);
        let at = [LEFT_PX - 8.0, y + 0.5 * CELL_PX + 4.0];
        panel.words(at, name, style(12.0, Anchor::End), PAPER.ink);
        let below = [LEFT_PX + CELL_PX * (float(k) + 0.5), TOP_PX + side + 16.0];
        panel.words(below, name, (12.0, Anchor::End, -30.0), PAPER.ink);
        for (column, value) in row
            .iter()
            .enumerate()
            .filter(|(_, value)| value.is_finite())
        {
            let x = LEFT_PX + CELL_PX * float(column);
            let (right, bottom) = (x + CELL_PX, y + CELL_PX);
            let corners = [[x, y], [right, y], [right, bottom], [x, bottom]];
            let share = (value - least) / (most - least).max(f64::MIN_POSITIVE);
            panel.area(&corners, shade(share), 1.0);
            let middle = [x + 0.5 * CELL_PX, y + 0.5 * CELL_PX + 4.0];
            let text = format!("{value:.2}");
            panel.words(middle, &text, style(12.0, Anchor::Middle), PAPER.ink);
        }
    }
    let (right, bottom) = (LEFT_PX + side, TOP_PX + side);
    let rim = [
        [LEFT_PX, TOP_PX],
        [right, TOP_PX],
        [right, bottom],
        [LEFT_PX, bottom],
        [LEFT_PX, TOP_PX],
    ];
    panel.line(&rim, PAPER.axis, 1.0, &[]);
    panel
}

fn float(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
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
