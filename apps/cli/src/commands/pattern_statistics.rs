//! What the patterns of a bank are like: a table and a figure.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Value, json};
use starbreak::glass::{LengthUnit, Model};
use starbreak_eval::chart::{Anchor, Axis, Drawing, PAPER, Plot};
use starbreak_runs::bank::{BankReport, PatternRow};

/// Color of the bars (Okabe and Ito).
const COLOR: &str = "#0072b2";

/// Bins of a histogram, of few patterns and of many.
const FEW_BINS: usize = 10;
const BINS: usize = 40;

/// Patterns from which on they are many.
const MANY: usize = 200;

/// What all patterns of a bank are like.
pub(super) struct Statistics {
    n: usize,
    n_frame: (u32, u32),
    /// Patterns of each class.
    pub(super) classes: BTreeMap<String, usize>,
    /// Share of the frame that cracks cover, percent, in the order of the patterns.
    areas: Vec<f64>,
    /// Crack length over the area of the pane, and its unit.
    densities: Vec<f64>,
    density_unit: &'static str,
    /// 5 %, 50 % and 95 % of the patterns cover less of the frame, percent.
    pub(super) area_percent: [f64; 3],
    density: [f64; 3],
}

impl Statistics {
    pub(super) fn of(report: &BankReport) -> Self {
        let mut classes = BTreeMap::new();
        for row in &report.rows {
            *classes.entry(class(row).to_owned()).or_insert(0) += 1;
        }
        let areas: Vec<f64> = report
            .rows
            .iter()
            .map(|row| row.area_share * 100.0)
            .collect();
        let densities: Vec<f64> = report.rows.iter().map(PatternRow::density).collect();
        Self {
            n: report.rows.len(),
            n_frame: report.header.sizes.first().copied().unwrap_or_default(),
            classes,
            area_percent: quantiles(&areas),
            density: quantiles(&densities),
            areas,
            densities,
            density_unit: report
                .rows
                .first()
                .map_or("m/m²", |row| match row.facts.unit {
                    LengthUnit::Px => "px/px²",
                    LengthUnit::Mm => "m/m²",
                }),
        }
    }

    pub(super) fn to_json(&self) -> Value {
        let [low, middle, high] = self.area_percent;
        let [sparse, usual, dense] = self.density;
        json!({
            "classes": self.classes,
            "area_percent": { "p5": low, "p50": middle, "p95": high },
            "density": { "unit": self.density_unit, "p5": sparse, "p50": usual, "p95": dense },
        })
    }
}

/// What kind of damage a pattern is.
fn class(row: &PatternRow) -> &str {
    match (&row.facts.damage_class, row.facts.model) {
        _ if row.facts.summary.n_segments == 0 => "intact",
        (Some(class), _) => class,
        (None, Model::Paper) => "paper",
        (None, _) => "unnamed",
    }
}

/// 5 %, 50 % and 95 % of some values.
fn quantiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    [5, 50, 95].map(|percent| {
        let at = (sorted.len().saturating_sub(1) * percent + 50) / 100;
        sorted.get(at).copied().unwrap_or(0.0)
    })
}

/// A row per pattern.
pub(super) fn csv(report: &BankReport) -> String {
    let unit = report
        .rows
        .first()
        .map_or(LengthUnit::Mm, |row| row.facts.unit);
    let (length, density) = match unit {
        LengthUnit::Px => ("total_length_px", "density_px_per_px2"),
        LengthUnit::Mm => ("total_length_mm", "density_m_per_m2"),
    };
    let mut text = format!(
        "pattern,seed,class,n_segments,n_fragments,{length},{density},area_share,left_px,top_px,right_px,bottom_px\n"
    );
    for row in &report.rows {
        let summary = &row.facts.summary;
        let n_fragments = summary.n_fragments.map(|n| n.to_string());
        let bbox = row.bbox_px.map(|bbox| bbox.map(|side| side.to_string()));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{}",
            row.idx,
            row.facts.seed.0,
            class(row),
            summary.n_segments,
            n_fragments.unwrap_or_default(),
            summary.total_length,
            row.density(),
            row.area_share,
            bbox.unwrap_or_default().join(","),
        );
    }
    text
}

/// Size of a panel, and height of the title above them.
const PANEL_PX: [f64; 2] = [400.0, 320.0];
const TITLE_PX: f64 = 40.0;

/// Classes, area and density.
pub(super) fn figure(statistics: &Statistics) -> Drawing {
    let density_label = match statistics.density_unit {
        "m/m²" => "crack length over area of the pane, m/m²",
        _ => "crack length over area of the pane, px/px²",
    };
    let panels = [
        classes(&statistics.classes),
        histogram(&statistics.areas, "cracks cover of the frame, %"),
        histogram(&statistics.densities, density_label),
    ];
    let mut sheet = Drawing {
        size_px: [3.0 * PANEL_PX[0], PANEL_PX[1] + TITLE_PX],
        ..Drawing::default()
    };
    let (width, height) = statistics.n_frame;
    let title = format!(
        "{} patterns in frames of {width} × {height} px",
        statistics.n
    );
    let middle = [0.5 * sheet.size_px[0], 26.0];
    sheet.words(middle, &title, (16.0, Anchor::Middle, 0.0), PAPER.ink);
    for (panel, x) in panels
        .into_iter()
        .zip([0.0, PANEL_PX[0], 2.0 * PANEL_PX[0]])
    {
        sheet.put(panel, [x, TITLE_PX]);
    }
    sheet
}

/// Patterns of each class, as rows: their names are longer than bars are wide.
fn classes(classes: &BTreeMap<String, usize>) -> Drawing {
    let names: Vec<String> = classes
        .keys()
        .map(|class| class.replace('_', " "))
        .collect();
    let counts: Vec<f64> = classes.values().map(|n| count(*n)).collect();
    let most = counts.iter().copied().fold(1.0, f64::max);
    let y = Axis::of_names(&names);
    let mut plot = Plot::new(
        PANEL_PX,
        Axis::of_counts([0.0, 1.05 * most], "patterns"),
        y,
        PAPER,
    );
    let half = if names.len() < 3 { 0.15 } else { 0.3 };
    for (k, n) in counts.iter().enumerate() {
        let row = plot.row(k);
        plot.bar([0.0, row - half], [*n, row + half], COLOR, 1.0);
    }
    plot.finish()
}

/// Up to the value that 99.5 % are below, so that few large ones do not squeeze the rest; those
/// count in the last bin.
fn histogram(values: &[f64], label: &str) -> Drawing {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (sorted.len().saturating_sub(1) * 199).div_ceil(200);
    let most = round_above(sorted.get(at).copied().unwrap_or(0.0));
    let n_bins = if values.len() < MANY { FEW_BINS } else { BINS };
    let width = most / count(n_bins);
    let mut bins = vec![0_usize; n_bins];
    for value in &sorted {
        let inside = (0..n_bins - 1).find(|k| *value < width * count(k + 1));
        if let Some(bin) = bins.get_mut(inside.unwrap_or(n_bins - 1)) {
            *bin += 1;
        }
    }
    let highest = bins.iter().copied().map(count).fold(1.0, f64::max);
    let y = Axis::of_counts([0.0, 1.05 * highest], "patterns");
    let mut plot = Plot::new(PANEL_PX, Axis::of([0.0, most], label), y, PAPER);
    for (k, n) in bins.iter().enumerate() {
        let ends = [k, k + 1].map(|k| width * count(k));
        let gap = 0.04 * width;
        plot.bar([ends[0] + gap, 0.0], [ends[1] - gap, count(*n)], COLOR, 1.0);
    }
    plot.finish()
}

fn count(n: usize) -> f64 {
    f64::from(u32::try_from(n).unwrap_or(u32::MAX))
}

/// The next number that is round, so that an axis up to it has round ticks.
fn round_above(value: f64) -> f64 {
    if value <= 0.0 {
        return 1.0;
    }
    let power = 10_f64.powf(value.log10().floor());
    let round = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0]
        .into_iter()
        .find(|round| round * power >= value);
    round.unwrap_or(10.0) * power
}
