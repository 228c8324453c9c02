//! How far sets of images lie apart: one shaded table per feature and measure.

use super::super::words;
use super::{Block, Cell, Section, Table};
use crate::evaluation::{DivergenceResults, DivergenceTable};

pub(super) fn section(results: &DivergenceResults) -> Section {
    let mut blocks = vec![Block::Text {
        text: "Each table compares every set of images (row) with every other (column); deeper shade is \
               further apart. The noise floor is what two halves of the same set give: a distance near it \
               says nothing."
            .to_owned(),
    }];
    for table in &results.tables {
        blocks.push(Block::Table {
            table: matrix(&results.sets, table),
        });
    }
    Section {
        id: "divergence".to_owned(),
        title: "Distances between sets of images".to_owned(),
        blocks,
    }
}

fn digits(value: f64) -> String {
    words::decimal(value, if value.abs() < 10.0 { 3 } else { 1 })
}

/// A column per set would need headings of its own; so columns are numbered as the rows are.
const NUMBERS: [&str; 16] = [
    "1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12", "13", "14", "15", "16",
];

fn matrix(sets: &[String], matrix: &DivergenceTable) -> Table {
    let n = sets.len().min(NUMBERS.len());
    let mut columns = vec![("Set", false)];
    columns.extend(NUMBERS.iter().take(n).map(|number| (*number, true)));
    columns.push(("Noise floor", true));
    let caption = format!("{} of {}", matrix.measure, matrix.feature);
    let mut table = Table::new(&caption, &columns);
    let all = matrix.values.iter().flatten().filter_map(|e| e.value);
    let most = all.fold(0.0_f64, |most, value| most.max(value.abs()));
    for (place, name) in sets.iter().take(n).enumerate() {
        let number = NUMBERS.get(place).unwrap_or(&"");
        let mut cells = vec![Cell::head(format!("{number} {name}"))];
        let row = matrix.values.get(place).map_or(&[][..], Vec::as_slice);
        for column in 0..n {
            let Some(estimate) = row.get(column).filter(|_| column != place) else {
                cells.push(Cell::text(words::NOTHING));
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
