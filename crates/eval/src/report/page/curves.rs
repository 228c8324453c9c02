//! Precision over recall.

use super::super::charts::{ChartText, Curve, CurvePoint, CurveStyle, Ink, curve_chart};
use super::super::conditions::{Summed, summed};
use super::super::words;
use super::{Block, Cell, Table};
use crate::chart::Axis;
use crate::evaluation::{Evaluation, PrecisionCurves, ScopeKind, Study};

/// Most conditions of a chart: colors must be told apart.
const MAX_CONDITIONS: usize = 7;

/// Precision at the 101 recalls, by name.
struct Line {
    name: String,
    is_clean: bool,
    precision: Vec<f64>,
}

/// Of each detector on whole images: clean, and the most severe damage of each family.
pub(super) fn overview(study: &Study) -> Vec<Block> {
    let all = summed(study);
    let detectors = words::distinct(all.iter().map(|one| one.detector));
    let mut charts = Vec::new();
    for (place, detector) in detectors.iter().enumerate() {
        let mut clean_curve = None;
        let mut damaged: Vec<Line> = Vec::new();
        for one in all.iter().filter(|one| one.detector == *detector) {
            let is_more_severe = |other: &Summed<'_>| {
                other.detector == one.detector
                    && one.condition.family.is_some()
                    && other.condition.family == one.condition.family
                    && other.condition.severity > one.condition.severity
            };
            if all.iter().any(is_more_severe) {
                continue;
            }
            if let Some([clean, cracked]) = mean(study, one, ScopeKind::WholeImage) {
                clean_curve.get_or_insert(clean);
                damaged.push(Line {
                    name: one.condition.name.clone(),
                    is_clean: false,
                    precision: cracked,
                });
            }
        }
        let title = words::name(&format!("Precision over recall, whole images, {detector}"));
        let mut part = 0;
        while let (false, Some(clean)) = (damaged.is_empty(), &clean_curve) {
            let rest = damaged.split_off(MAX_CONDITIONS.min(damaged.len()));
            damaged.insert(0, clean_line(clean.clone()));
            charts.extend(chart(&damaged, &format!("curves-{place}-{part}"), &title));
            (damaged, part) = (rest, part + 1);
        }
    }
    charts
}

/// Of one condition: clean and damaged, in the region, or without one on whole images.
pub(super) fn of_condition(study: &Study, one: &Summed<'_>, id: &str) -> Option<Block> {
    let (place, [clean, cracked]) = [
        (ScopeKind::InRegion, "in the region"),
        (ScopeKind::WholeImage, "on whole images"),
    ]
    .into_iter()
    .find_map(|(kind, place)| Some((place, mean(study, one, kind)?)))?;
    let damaged = Line {
        name: "damaged".to_owned(),
        is_clean: false,
        precision: cracked,
    };
    let title = format!("Precision over recall {place}");
    chart(
        &[clean_line(clean), damaged],
        &format!("{id}-curves"),
        &title,
    )
}

fn clean_line(precision: Vec<f64>) -> Line {
    Line {
        name: "clean".to_owned(),
        is_clean: true,
        precision,
    }
}

/// Clean and cracked, the mean over the seeds that a condition stands for; nothing where one of them has none.
fn mean(study: &Study, one: &Summed<'_>, kind: ScopeKind) -> Option<[Vec<f64>; 2]> {
    let of_evaluation = |evaluation: &'_ Evaluation| -> Option<PrecisionCurves> {
        let mut curves = evaluation.curves.iter();
        curves.find(|curves| curves.scope.kind == kind).cloned()
    };
    let all: Vec<PrecisionCurves> = one
        .evaluations(study)
        .map(of_evaluation)
        .collect::<Option<_>>()?;
    if all.len() != one.n_seeds {
        return None;
    }
    let side = |of: fn(&PrecisionCurves) -> &Vec<f64>| -> Option<Vec<f64>> {
        let n_recalls = of(all.first()?).len();
        let mut sums = vec![0.0; n_recalls];
        for curves in &all {
            let values = of(curves);
            if values.is_empty() || values.len() != n_recalls {
                return None;
            }
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += value / all.len() as f64;
            }
        }
        Some(sums)
    };
    Some([
        side(|curves| &curves.clean)?,
        side(|curves| &curves.cracked)?,
    ])
}

fn chart(lines: &[Line], id: &str, title: &str) -> Option<Block> {
    if lines.len() < 2 {
        return None;
    }
    let names: Vec<String> = lines
        .iter()
        .map(|line| {
            let area = line.precision.iter().sum::<f64>() / line.precision.len() as f64;
            words::name(&format!("{}: AP50 {} %", line.name, words::percent(area)))
        })
        .collect();
    let mut inks = [
        Ink::Cracked,
        Ink::Third,
        Ink::Fourth,
        Ink::Fifth,
        Ink::Sixth,
    ]
    .into_iter()
    .chain([Ink::Seventh, Ink::Eighth]);
    let recall = |place: usize, n: usize| 100.0 * place as f64 / (n.max(2) - 1) as f64;
    let mut table = Table::new(&format!("{title}, percent."), &columns(&names));
    let mut curves = Vec::new();
    for (line, name) in lines.iter().zip(&names) {
        let n = line.precision.len();
        let points = line.precision.iter().enumerate();
        curves.push(Curve {
            name,
            ink: match line.is_clean {
                true => Ink::Clean,
                false => inks.next().unwrap_or(Ink::Cracked),
            },
            style: match line.is_clean {
                true => CurveStyle::Dashed,
                false => CurveStyle::Line,
            },
            points: points
                .map(|(place, y)| CurvePoint::at(recall(place, n), 100.0 * y))
                .collect(),
        });
    }
    for place in (0..=100).step_by(10) {
        let mut row = vec![Cell::count(place)];
        row.extend(lines.iter().map(|line| {
            let place = usize::try_from(place).unwrap_or(usize::MAX);
            Cell::number(line.precision.get(place).copied(), words::percent)
        }));
        table.push(row);
    }
    let chart = curve_chart(
        &curves,
        &[],
        Axis::of([0.0, 100.0], "recall, %"),
        Axis::of([0.0, 100.0], "precision, %"),
        &ChartText {
            id,
            title,
            description: "One curve per condition; the table below gives the numbers.",
        },
    );
    let caption = format!(
        "{title}: the best precision at each recall or a higher one, at IoU 0.5, the mean of the classes; the area \
         below a curve is AP50."
    );
    Some(Block::chart(chart, caption, Some(table)))
}

fn columns(names: &[String]) -> String {
    let names = names.iter().map(|name| name.replace('|', "/"));
    names.fold("#Recall, %".to_owned(), |all, name| {
        format!("{all}|#{name}")
    })
}
