//! FastestDet's one output: a grid of cells.

use super::dense::combine;
use super::{Decoded, check_classes, sigmoid, unlike};
use crate::contract::Contract;
use crate::runtime::OutputTensor;

/// `center = (tanh(value) + cell) / cells`, `size = sigmoid(value)`, the best class alone.
#[expect(
    clippy::cast_precision_loss,
    reason = "cells of a grid are small whole numbers"
)]
pub(super) fn decode(contract: &Contract, output: &OutputTensor) -> Result<Decoded, String> {
    let [1, n_numbers, rows, columns] = *output.shape.as_slice() else {
        return Err(unlike(output, "[1, 5 + classes, rows, columns]"));
    };
    let n_classes = n_numbers.saturating_sub(5);
    check_classes(contract, output, n_classes)?;
    let n_cells = rows * columns;
    let mut decoded = Decoded::default();
    for cell in 0..n_cells {
        let value = |number: usize| {
            let at = number * n_cells + cell;
            output.values.get(at).copied().unwrap_or(f32::NAN)
        };
        let mut best = (f32::NEG_INFINITY, 0);
        for class in 0..n_classes {
            let score = value(5 + class);
            if score > best.0 {
                best = (score, class);
            }
        }
        let score = combine(contract, value(0), best.0);
        if score < contract.score_threshold {
            continue;
        }
        let (x, y) = ((cell % columns) as f32, (cell / columns) as f32);
        let numbers = [
            (value(1).tanh() + x) / columns as f32,
            (value(2).tanh() + y) / rows as f32,
            sigmoid(value(3)),
            sigmoid(value(4)),
        ];
        decoded.take_class(contract, numbers, score, best.1)?;
    }
    Ok(decoded)
}
