//! What the patterns of a bank are like: a table and a figure.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use kuva::prelude::{BarPlot, Figure, Histogram, Layout, Plot, PngBackend, SvgBackend};
use serde_json::{Value, json};
use starbreak::glass::{LengthUnit, Model};
use starbreak_runs::bank::{BankReport, PatternRow};

/// Color of the bars (Okabe and Ito).
const COLOR: &str = "#0072b2";

/// Pixels per user unit of the PNG.
const PNG_SCALE: f32 = 2.0;

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

/// Classes, area and density, as SVG text and as PNG bytes.
pub(super) fn figure(statistics: &Statistics) -> Result<(String, Vec<u8>), String> {
    let svg = SvgBackend::default().render_scene(&drawn(statistics).render());
    let png = PngBackend::new()
        .with_scale(PNG_SCALE)
        .render_scene(&drawn(statistics).render())?;
    Ok((svg, png))
}

fn drawn(statistics: &Statistics) -> Figure {
    let classes = BarPlot::new()
        .with_bars(statistics.classes.iter().map(|(class, n)| {
            #[expect(clippy::cast_precision_loss, reason = "a count")]
            let n = *n as f64;
            (class.replace('_', " "), n)
        }))
        .with_color(COLOR)
        .with_width(if statistics.classes.len() < 3 {
            0.4
        } else {
            0.7
        });
    let plots = [
        (Plot::Bar(classes), "damage class"),
        (histogram(&statistics.areas), "cracks cover of the frame, %"),
        (
            histogram(&statistics.densities),
            match statistics.density_unit {
                "m/m²" => "crack length over area of the pane, m/m²",
                _ => "crack length over area of the pane, px/px²",
            },
        ),
    ];
    let (mut cells, mut layouts) = (Vec::new(), Vec::new());
    for (plot, label) in plots {
        let cell = vec![plot];
        layouts.push(
            Layout::auto_from_plots(&cell)
                .with_x_label(label)
                .with_y_label("patterns"),
        );
        cells.push(cell);
    }
    let (width, height) = statistics.n_frame;
    Figure::new(1, 3)
        .with_title(format!(
            "{} patterns in frames of {width} × {height} px",
            statistics.n
        ))
        .with_cell_size(400.0, 320.0)
        .with_plots(cells)
        .with_layouts(layouts)
}

/// Up to the value that 99.5 % are below, so that few large ones do not squeeze the rest; those
/// count in the last bin.
fn histogram(values: &[f64]) -> Plot {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (sorted.len().saturating_sub(1) * 199).div_ceil(200);
    let most = sorted.get(at).copied().unwrap_or(0.0);
    let most = round_above(most);
    let clamped = values.iter().map(|value| value.min(most));
    Plot::Histogram(
        Histogram::new()
            .with_data(clamped)
            .with_range((0.0, most))
            .with_bins(if values.len() < MANY { FEW_BINS } else { BINS })
            .with_color(COLOR),
    )
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
