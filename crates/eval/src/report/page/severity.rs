//! What more severe damage costs: a curve per detector and family over the severity.

use super::super::charts::{ChartText, Curve, CurvePoint, CurveStyle, Ink, curve_chart};
use super::super::conditions::{Summed, summed};
use super::super::words;
use super::overview::{headline, headline_failure};
use super::{Block, Cell, Table};
use crate::chart::{Axis, Marker};
use crate::evaluation::{Estimate, PairedMetric, ScopeKind, Study};

/// Curves at one severity stand so far apart, so that their intervals do not hide each other.
const APART: f64 = 0.06;

/// A number in percent with its interval.
type Percents = (f64, Option<[f64; 2]>);

/// One of the charts.
struct Cost {
    id: &'static str,
    title: &'static str,
    axis: &'static str,
    column: &'static str,
    caption: &'static str,
    /// More is worse.
    of: fn(&Study, &Summed<'_>) -> Option<Percents>,
}

const COSTS: [Cost; 2] = [
    Cost {
        id: "severities",
        title: "AP50 lost in the region by severity of the damage",
        axis: "AP50 lost in the region, points",
        column: "#AP50 lost, points",
        caption: "AP50 of all classes in the region, clean minus damaged, on the same objects; 95 % intervals. \
                  0: the damage costs nothing. The region grows with the severity, so each point has its own \
                  objects.",
        of: |study, one| {
            let row = headline(study, one, ScopeKind::InRegion, PairedMetric::Ap50)?;
            let (lost, interval) = percents(&row.delta)?;
            Some((-lost, interval.map(|[low, high]| [-high, -low])))
        },
    },
    Cost {
        id: "severities-lost",
        title: "Objects lost in the region by severity of the damage",
        axis: "lost of the objects found clean, %",
        column: "#Lost, %",
        caption: "Of the objects in the region that are found in the clean images, the share that is not found in \
                  the damaged ones; 95 % intervals.",
        of: |study, one| percents(&headline_failure(study, one, ScopeKind::InRegion)?.failure_rate),
    },
];

fn percents(estimate: &Estimate) -> Option<Percents> {
    let interval = estimate.interval();
    let value = estimate.value? * 100.0;
    Some((value, interval.map(|ends| ends.map(|end| end * 100.0))))
}

/// The charts, where conditions have two severities or more.
pub(super) fn charts(study: &Study) -> Vec<Block> {
    COSTS.iter().filter_map(|cost| cost.chart(study)).collect()
}

impl Cost {
    fn chart(&self, study: &Study) -> Option<Block> {
        let all = summed(study);
        let family = |one: &Summed<'_>| one.condition.family.clone().unwrap_or_default();
        let severe = all.iter().filter(|one| one.condition.severity.is_some());
        let names = words::distinct(severe.map(|one| (one.detector, family(one))));
        let titles: Vec<String> = names
            .iter()
            .map(|(detector, family)| {
                words::name(format!("{detector}, {family}").trim_end_matches(", "))
            })
            .collect();
        let mut table = Table::new(
            &format!("{}.", self.title),
            &format!("Curve|#Severity|#Seeds|{}", self.column),
        );
        let mut curves = Vec::new();
        let mut ends = [0.0_f64, 1.0];
        for (place, (name, title)) in names.iter().zip(&titles).enumerate() {
            let beside = APART * (place as f64 - 0.5 * (names.len() as f64 - 1.0));
            let mut points = Vec::new();
            for severity in 1..=5_u8 {
                let at_severity = all.iter().find(|one| {
                    (one.detector, family(one)) == *name && one.condition.severity == Some(severity)
                });
                let Some((one, (y, interval))) =
                    at_severity.and_then(|one| Some((one, (self.of)(study, one)?)))
                else {
                    continue;
                };
                let [low, high] = interval.unwrap_or([y, y]);
                ends = [ends[0].min(low), ends[1].max(high)];
                let small = interval.map(|[low, high]| {
                    format!("[{}, {}]", words::decimal(low, 1), words::decimal(high, 1))
                });
                table.push(vec![
                    Cell::head(title),
                    Cell::count(severity.into()),
                    Cell::count(u64::try_from(one.n_seeds).unwrap_or(u64::MAX)),
                    Cell::number(Some(y / 100.0), words::percent).with_small(small),
                ]);
                points.push(CurvePoint {
                    x: f64::from(severity) + beside.clamp(-0.4, 0.4),
                    y,
                    interval,
                    words: None,
                });
            }
            curves.push(Curve {
                name: title,
                ink: Ink::of_series(place),
                style: CurveStyle::JoinedPoints(marker(place)),
                points,
            });
        }
        if curves.iter().map(|curve| curve.points.len()).max()? < 2 {
            return None;
        }
        let chart = curve_chart(
            &curves,
            &[],
            Axis::of([0.5, 5.5], "severity"),
            Axis::of(
                [(ends[0] / 5.0).floor() * 5.0, (ends[1] / 5.0).ceil() * 5.0],
                self.axis,
            ),
            &ChartText {
                id: self.id,
                title: self.title,
                description: "One curve per detector and family of damage; the table below gives the numbers.",
            },
        );
        Some(Block::chart(chart, self.caption, Some(table)))
    }
}

/// Eight curves have colors of their own; the next eight other markers.
fn marker(place: usize) -> Marker {
    let markers = [
        Marker::Circle,
        Marker::Diamond,
        Marker::Square,
        Marker::Triangle,
    ];
    markers[(place + place / 8) % 4]
}
