//! How far sets of images lie apart: one shaded table per feature and measure.

use super::super::words;
use super::{Block, Cell, Section, Table};
use crate::evaluation::{DivergenceResults, DivergenceTable};

pub(super) fn section(results: &DivergenceResults) -> Section {
    let mut blocks = vec![Block::text(
        "Tables compare image sets (rows) with others (columns); a stronger shade is a larger distance. The \
               noise floor is the distance between two halves of the same set: between sets of different \
               images, a distance near it says nothing. A clean set and its damaged counterpart show the same \
               scenes, so their distance may lie below the floor and still be due to the damage.",
    )];
    let n_before = blocks.len();
    for feature in words::distinct(results.tables.iter().map(|table| &table.feature)) {
        blocks.extend(of_clean(results, feature).map(Block::table));
    }
    let has_summary = blocks.len() > n_before;
    let mut matrices = Vec::new();
    // Beyond so many sets only the first is compared with each, which stands above.
    if results.sets.len() <= MAX_SETS || !has_summary {
        for table in &results.tables {
            matrices.push(Block::table(matrix(&results.sets, table)));
        }
    }
    match has_summary && !matrices.is_empty() {
        true => blocks.push(Block::fold("All pairs of sets", matrices)),
        false => blocks.extend(matrices),
    }
    Section {
        id: "divergence".to_owned(),
        title: "Distances between image sets".to_owned(),
        blocks,
    }
}

/// The first set, if it is the clean one, against each other by one feature.
fn of_clean(results: &DivergenceResults, feature: &str) -> Option<Table> {
    if results.sets.first().is_none_or(|name| name != "clean") {
        return None;
    }
    let of_measure = |begin: &str| {
        let mut tables = results.tables.iter();
        tables.find(|table| table.feature == feature && table.measure.starts_with(begin))
    };
    let (kl, js, w1) = (of_measure("KL")?, of_measure("JS")?, of_measure("W1"));
    let columns = format!(
        "Clean against|#KL(clean ‖ set), nats|#KL(set ‖ clean), nats|#JS, nats{}|#Noise floor of JS",
        if w1.is_some() { "|#W1" } else { "" }
    );
    let unit = w1.and_then(|w1| w1.measure.strip_prefix("W1, "));
    let unit = unit.map_or(String::new(), |unit| format!("; W1 in {unit}"));
    let caption = format!(
        "{feature}: the clean images against those of each condition, with 95 % bootstrap intervals over \
         images{unit}."
    );
    let mut table = Table::new(&caption, &columns);
    let at = |of: &DivergenceTable, row: usize, column: usize| {
        let row = of.values.get(row).map_or(&[][..], Vec::as_slice);
        row.get(column).cloned().unwrap_or_default()
    };
    for (place, name) in results.sets.iter().enumerate().skip(1) {
        let mut cells = vec![Cell::head(name)];
        let all = [(kl, 0, place), (kl, place, 0), (js, 0, place)];
        let w1 = w1.map(|w1| (w1, 0, place));
        for (of, row, column) in all.into_iter().chain(w1) {
            cells.push(table.estimate(&at(of, row, column), digits));
        }
        let floor = |set: usize| js.noise_floor.get(set).copied().flatten();
        let floor = floor(0).into_iter().chain(floor(place)).reduce(f64::max);
        cells.push(Cell::number(floor, digits));
        table.push(cells);
    }
    Some(table)
}

fn digits(value: f64) -> String {
    let n_digits = match value.abs() {
        v if v > 0.0 && v < 0.001 => {
            let text = format!("{value:.1e}");
            return text.replace('-', "\u{2212}");
        }
        v if v < 0.1 => 4,
        v if v < 10.0 => 3,
        _ => 1,
    };
    words::decimal(value, n_digits)
}

/// Most sets that are compared each with each.
const MAX_SETS: usize = 16;

fn matrix(sets: &[String], matrix: &DivergenceTable) -> Table {
    let n = sets.len().min(MAX_SETS);
    // The names would be too wide: columns are numbered as the rows are.
    let numbers: String = (1..=n).map(|number| format!("|#{number}")).collect();
    let columns = format!("Set{numbers}|#Noise floor");
    let caption = format!("{} of {}", matrix.measure, matrix.feature);
    let mut table = Table::new(&caption, &columns);
    let all = matrix.values.iter().flatten().filter_map(|e| e.value);
    let most = all.fold(0.0_f64, |most, value| most.max(value.abs()));
    for (place, name) in sets.iter().take(n).enumerate() {
        let mut cells = vec![Cell::head(format!("{} {name}", place + 1))];
        let row = matrix.values.get(place).map_or(&[][..], Vec::as_slice);
        for column in 0..n {
            let Some(estimate) = row.get(column).filter(|_| column != place) else {
                cells.push(Cell::nothing());
                continue;
            };
            let cell = table.estimate(estimate, digits);
            cells.push(match estimate.value {
                Some(value) if most > 0.0 => cell.with_shade(shade(value.abs() / most)),
                _ => cell,
            });
        }
        let floor = matrix.noise_floor.get(place).copied().flatten();
        cells.push(Cell::number(floor, digits));
        table.push(cells);
    }
    table
}

/// Percent of the deepest shade.
fn shade(share: f64) -> u8 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share between 0 and 1"
    )]
    let percent = (share.clamp(0.0, 1.0) * 60.0).round() as u8;
    percent
}
