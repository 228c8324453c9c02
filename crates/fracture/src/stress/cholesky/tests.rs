use pulp::WithSimd as _;

use super::super::elimination::{Lists, supernodes};
use super::*;

const SIDE: u32 = 13;
const N: u32 = 3 * SIDE * SIDE;

/// Three unknowns on each point of a grid, every one coupled with its own and its neighbors'.
fn value(row: u32, column: u32) -> f64 {
    let place = |unknown: u32| [unknown / 3 % SIDE, unknown / 3 / SIDE];
    let ([a, b], [c, d]) = (place(row), place(column));
    if row == column {
        40.0 + f64::from(row % 7)
    } else if a.abs_diff(c) + b.abs_diff(d) <= 1 {
        f64::from((row * 31 + column * 31 + row * column) % 17) / 9.0 - 1.0
    } else {
        0.0
    }
}

fn lower() -> (Vec<u32>, Vec<u32>) {
    let (mut columns, mut rows) = (vec![0], Vec::new());
    for column in 0..N {
        rows.extend((column..N).filter(|&row| value(row, column) != 0.0));
        columns.push(to_u32(rows.len()));
    }
    (columns, rows)
}

fn room() -> Cholesky {
    let [beside, above] = [1, SIDE].map(|step| {
        (step..SIDE * SIDE)
            .filter(move |k| step > 1 || k % SIDE > 0)
            .map(move |k| [k - step, k])
    });
    let later = Lists::later((SIDE * SIDE) as usize, beside.chain(above));
    Cholesky::new(N as usize, &supernodes(&later))
}

fn bits(of: &[f64]) -> Vec<u64> {
    of.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn wide_instructions_leave_every_bit_and_the_system_is_solved() -> Result<(), FractureError> {
    let (columns, rows) = lower();
    let of_rows = (0..N).zip(columns.windows(2));
    let values: Vec<f64> = of_rows
        .flat_map(|(column, range)| {
            let rows = &rows[range[0] as usize..range[1] as usize];
            rows.iter().map(move |&row| value(row, column))
        })
        .collect();
    let matrix = Lower {
        columns: &columns,
        rows: &rows,
        values: &values,
    };
    let wanted: Vec<f64> = (0..N).map(|k| f64::from(k % 11) - 4.3).collect();
    let right: Vec<f64> = (0..N)
        .map(|row| (0..N).map(|c| value(row, c) * wanted[c as usize]).sum())
        .collect();

    let mut wide = room();
    wide.factor(&matrix)?;
    let mut solved = right.clone();
    wide.solve(&mut solved);
    for (solved, wanted) in solved.iter().zip(&wanted) {
        assert!((solved - wanted).abs() < 1e-12, "{solved}, not {wanted}");
    }

    let mut narrow = room();
    let factoring = Factoring {
        cholesky: &mut narrow,
        matrix: &matrix,
    };
    factoring.with_simd(pulp::Scalar::new())?;
    for (wide, narrow) in wide.blocks.iter().zip(&narrow.blocks) {
        assert_eq!(bits(&wide.values), bits(&narrow.values), "the factor");
    }
    let mut right = right;
    let solving = Solving {
        cholesky: &narrow,
        right: &mut right,
    };
    solving.with_simd(pulp::Scalar::new());
    assert_eq!(bits(&solved), bits(&right), "the solution");
    Ok(())
}

#[test]
fn a_matrix_that_is_not_positive_is_told() {
    let (columns, rows) = lower();
    let matrix = Lower {
        columns: &columns,
        rows: &rows,
        values: &vec![0.0; rows.len()],
    };
    let told = room().factor(&matrix).map_err(|error| error.to_string());
    assert!(
        matches!(&told, Err(text) if text.contains("pivot 0 is 0, not positive")),
        "{told:?}"
    );
}
