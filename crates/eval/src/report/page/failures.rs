//! What is lost, over what dose, what appears, what shifts.

use super::super::charts::{ChartText, Curve, CurvePoint, CurveStyle, Ink, curve_chart};
use super::super::words;
use super::overview::{unit, units};
use super::precision::group_name;
use super::{Block, Cell, Table};
use crate::chart::{Axis, Marker};
use crate::evaluation::{
    DoseResponse, Estimate, Evaluation, FailureResults, FailureRow, GroupKind, LogisticFit,
    ScopeKind, Study,
};

/// Points of a fitted curve.
const N_CURVE_POINTS: u32 = 60;

pub(super) fn blocks(study: &Study, evaluation: &Evaluation, id: &str) -> Vec<Block> {
    let Some(failures) = &evaluation.failures else {
        return Vec::new();
    };
    let settings = &study.provenance.settings;
    let mut blocks = vec![
        Block::heading(format!("{id}-failures"), "Detection failures".to_owned()),
        Block::text(format!(
            "An object counts as found if a detection of its class has a confidence score of at least {} and \
                 overlaps it by an IoU of at least {}.",
            settings.score_threshold, settings.iou_threshold
        )),
    ];
    blocks.extend(rate_blocks(study, &failures.rates));
    for (place, dose) in failures.dose_responses.iter().enumerate() {
        blocks.extend(dose_chart(dose, &format!("{id}-dose{place}")));
    }
    blocks.extend(new_table(failures).map(Block::table));
    blocks.extend(shift_table(study, failures).map(Block::table));
    blocks.extend(flip_table(study, failures).map(Block::table));
    blocks
}

/// All classes everywhere, then the groups in the region, and folded away the same elsewhere.
fn rate_blocks(study: &Study, rates: &[FailureRow]) -> Vec<Block> {
    let scopes = words::distinct(rates.iter().map(|row| &row.scope));
    let all = rates.iter().filter(|row| row.group.kind == GroupKind::All);
    let mut blocks = vec![Block::table(rate_table(
        &format!(
            "All classes, in the region and outside it: lost and recovered objects. 95 % intervals use the \
                 variance between {units}. p tests lost against recovered objects by exchanging clean and \
                 damaged {unit} by {unit}; Holm's correction is over the conditions of the study.",
            units = units(study),
            unit = unit(study),
        ),
        "Where",
        all.map(|row| (vec![words::scope(&row.scope)], row)),
    ))];
    for scope in scopes {
        let groups: Vec<&FailureRow> = rates
            .iter()
            .filter(|row| row.scope == *scope && row.group.kind != GroupKind::All)
            .filter(|row| row.failure_rate.value.is_some())
            .collect();
        if groups.is_empty() {
            continue;
        }
        let place = words::scope(scope);
        let caption = format!(
            "Supercategories and classes with enough objects, {place}; Holm's correction is over them and \
             the conditions of the study."
        );
        let table = rate_table(
            &caption,
            "Class",
            groups
                .into_iter()
                .map(|row| (vec![group_name(&row.group)], row)),
        );
        let is_main =
            scope.kind == ScopeKind::InRegion && scope.is_at(study.provenance.settings.tau);
        blocks.push(match is_main {
            true => Block::table(table),
            false => Block::fold(
                format!("Failure rates per class, {place}"),
                vec![Block::table(table)],
            ),
        });
    }
    blocks
}

/// What is lost and recovered. Each row says what it is about in as many cells as `about` has headings.
pub(super) fn rate_table<'a>(
    caption: &str,
    about: &str,
    rows: impl Iterator<Item = (Vec<String>, &'a FailureRow)>,
) -> Table {
    let columns = format!(
        "{about}|#Objects|#Found clean|#Found damaged|#Lost|#Recovered|#Failure rate, %|#p|#p (Holm)"
    );
    let mut table = Table::new(caption, &columns);
    for (names, row) in rows {
        let rate = table.estimate(&row.failure_rate, words::percent);
        let mut cells: Vec<Cell> = names.iter().map(Cell::text).collect();
        if let (Some(first), Some(name)) = (cells.first_mut(), names.first()) {
            *first = Cell::head(name);
        }
        cells.extend([
            Cell::count(row.n_objects),
            Cell::count(row.n_found_clean),
            Cell::count(row.n_found_cracked),
            Cell::count(row.n_lost),
            Cell::count(row.n_recovered),
            rate,
            Cell::probability(row.p),
            Cell::probability(row.p_holm),
        ]);
        table.push(cells);
    }
    table
}

fn three_digits(value: f64) -> String {
    words::decimal(value, 3)
}

fn dose_chart(dose: &DoseResponse, id: &str) -> Option<Block> {
    let fact = words::name(&dose.fact);
    if let Some(note) = &dose.note {
        return Some(Block::text(format!(
            "Failure rate by {fact}: no chart, because {}.",
            words::name(note)
        )));
    }
    let unit = match dose.unit.as_str() {
        "" => String::new(),
        unit => format!(", {}", words::name(unit)),
    };
    let mut table = Table::new(
        &format!("Failure rate of the objects found in the clean images, by {fact}."),
        "#From|#To|#Mean|#Found clean|#Lost|#Failure rate, %",
    );
    let mut points = Vec::new();
    // The last bin may be long and have its objects near its beginning.
    let mut end = 0.0_f64;
    for bin in &dose.bins {
        let mean = bin.mean.unwrap_or(bin.low);
        end = end.max(bin.high.min(mean * 1.25));
        let rate = table.estimate(&bin.rate, words::percent);
        table.push(vec![
            Cell::number(Some(bin.low), three_digits),
            Cell::number(Some(bin.high), three_digits),
            Cell::number(bin.mean, three_digits),
            Cell::count(bin.n),
            Cell::count(bin.n_lost),
            rate,
        ]);
        if let Some(value) = bin.rate.value {
            points.push(CurvePoint {
                x: bin.mean.unwrap_or((bin.low + bin.high) / 2.0),
                y: value * 100.0,
                interval: bin.rate.interval().map(|ends| ends.map(|v| v * 100.0)),
                words: Some(format!("n={}", bin.n)),
            });
        }
    }
    if points.is_empty() || !end.is_finite() || end <= 0.0 {
        let why = match end > 0.0 {
            true => "no bin has enough objects",
            false => "it is 0 for all objects found in the clean images",
        };
        return Some(Block::text(format!(
            "Failure rate by {fact}: no chart, because {why}."
        )));
    }
    let name = "share lost, with 95 % intervals";
    let mut curves = Vec::new();
    if let Some(fit) = &dose.fit {
        curves.push(Curve {
            name: "logistic fit",
            ink: Ink::Third,
            style: CurveStyle::Dashed,
            points: fit_points(fit, end),
        });
    }
    curves.push(Curve {
        name,
        ink: Ink::Cracked,
        style: CurveStyle::Points(Marker::Diamond),
        points,
    });
    let chart = curve_chart(
        &curves,
        &[],
        Axis::of([0.0, end], &format!("{fact} of the object{unit}")),
        Axis::of([0.0, 118.0], "failure rate, %"),
        &ChartText {
            id,
            title: &format!("Failure rate by {fact}"),
            description: "Points are bins of objects, vertical lines their intervals; the table gives the \
                          numbers and the objects in each bin.",
        },
    );
    Some(Block::chart(
        chart,
        format!(
            "Share of the objects found in the clean images that are lost, by {fact}{unit}.{}",
            dose.fit.as_ref().map_or(String::new(), fit_text)
        ),
        Some(table),
    ))
}

fn fit_text(fit: &LogisticFit) -> String {
    let Some(slope) = fit.slope.value else {
        return String::new();
    };
    let interval = fit.slope.interval().map_or(String::new(), |[low, high]| {
        format!(
            " (95 % interval {} to {})",
            words::decimal(low, 2),
            words::decimal(high, 2)
        )
    });
    let p = fit
        .p
        .map_or(String::new(), |p| format!(", p {}", words::probability(p)));
    format!(
        " Logistic fit to the single objects: slope {}{interval} per unit{p}.",
        words::decimal(slope, 2)
    )
}

fn fit_points(fit: &LogisticFit, end: f64) -> Vec<CurvePoint> {
    let Some(slope) = fit.slope.value else {
        return Vec::new();
    };
    let at = |place: u32| {
        let x = end * f64::from(place) / f64::from(N_CURVE_POINTS);
        CurvePoint::at(x, 100.0 / (1.0 + (-(fit.intercept + slope * x)).exp()))
    };
    (0..=N_CURVE_POINTS).map(at).collect()
}

fn new_table(failures: &FailureResults) -> Option<Table> {
    if failures.new_false_positives.is_empty() {
        return None;
    }
    let mut table = Table::new(
        "False positives. New: those in the damaged images that no clean detection overlaps by an IoU of 0.5 or \
         more.",
        "Where|#Clean|#Damaged|#New|#Area, Mpx|#New per Mpx",
    );
    for row in &failures.new_false_positives {
        let rate = table.estimate(&row.new_per_mpx, |v| words::decimal(v, 2));
        table.push(vec![
            Cell::head(words::scope(&row.scope)),
            Cell::count(row.n_clean),
            Cell::count(row.n_cracked),
            Cell::count(row.n_new),
            Cell::number(Some(row.area_mpx), |v| words::decimal(v, 2)),
            rate,
        ]);
    }
    Some(table)
}

fn signed_three_digits(value: f64) -> String {
    let text = words::decimal(value, 3);
    if value > 0.0 && text != "0.000" {
        return format!("+{text}");
    }
    text
}

fn shift_table(study: &Study, failures: &FailureResults) -> Option<Table> {
    let is_shown =
        |kind: GroupKind, score: &Estimate| kind != GroupKind::Class || score.value.is_some();
    let rows: Vec<_> = failures
        .shifts
        .iter()
        .filter(|row| is_shown(row.group.kind, &row.score))
        .filter(|row| row.scope.is_at(study.provenance.settings.tau))
        .collect();
    if rows.is_empty() {
        return None;
    }
    let mut table = Table::new(
        &format!(
            "Objects found in both images: mean change of the confidence score and of the IoU with the ground \
             truth (damaged minus clean). 95 % intervals and p use the variance between {}; p with Holm's \
             correction.",
            units(study)
        ),
        "Class|Where|#Pairs|#Score change|#p (Holm)|#IoU change|#p (Holm)",
    );
    for row in rows {
        let score = table.estimate(&row.score, signed_three_digits);
        let iou = table.estimate(&row.iou, signed_three_digits);
        table.push(vec![
            Cell::head(group_name(&row.group)),
            Cell::text(words::scope(&row.scope)),
            Cell::count(row.n_pairs),
            score,
            Cell::probability(row.p_score_holm),
            iou,
            Cell::probability(row.p_iou_holm),
        ]);
    }
    Some(table)
}

fn flip_table(study: &Study, failures: &FailureResults) -> Option<Table> {
    if failures.flips.is_empty() {
        return None;
    }
    let mut table = Table::new(
        "Class flips: objects found in the clean image and detected as another class in the damaged one.",
        "Where|#Found clean|#Flipped|#Rate, %|Most frequent",
    );
    let of_tau = failures.flips.iter();
    for row in of_tau.filter(|row| row.scope.is_at(study.provenance.settings.tau)) {
        let commonest: Vec<String> = row
            .commonest
            .iter()
            .take(5)
            .map(|flip| format!("{} → {} ({})", flip.from, flip.to, flip.n))
            .collect();
        let rate = table.estimate(&row.rate, words::percent);
        table.push(vec![
            Cell::head(words::scope(&row.scope)),
            Cell::count(row.n),
            Cell::count(row.n_flipped),
            rate,
            Cell::text(match commonest.is_empty() {
                true => words::NOTHING.to_owned(),
                false => commonest.join(", "),
            }),
        ]);
    }
    Some(table)
}
