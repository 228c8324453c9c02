//! One output with a box and numbers per class at every place: the YOLO family.

use super::{Decoded, check_classes, places, sigmoid};
use crate::contract::{Activation, Contract};
use crate::runtime::OutputTensor;

/// Where the numbers of a place lie.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// One after the other, otherwise a whole side apart.
    pub(super) places_first: bool,
    /// Whether the fifth is an objectness.
    pub(super) has_objectness: bool,
}

pub(super) fn decode(
    contract: &Contract,
    output: &OutputTensor,
    layout: Layout,
    strides_px: &[u32],
) -> Result<Decoded, String> {
    let [a, b] = places(output)?;
    let (n_places, n_numbers) = if layout.places_first { (a, b) } else { (b, a) };
    let n_before = if layout.has_objectness { 5 } else { 4 };
    let n_classes = n_numbers.saturating_sub(n_before);
    check_classes(contract, output, n_classes)?;
    let cells = cells(output, strides_px, n_places)?;
    let value = |place: usize, number: usize| {
        let at = if layout.places_first {
            place * n_numbers + number
        } else {
            number * n_places + place
        };
        output.values.get(at).copied().unwrap_or(f32::NAN)
    };
    let scores_of = contract.output.activation;
    let score = |place: usize, class: usize, objectness: f32| {
        let number = value(place, n_before + class);
        let number = match scores_of {
            Activation::Sigmoid => sigmoid(number),
            // A softmax over places of a dense output is nobody's.
            Activation::None | Activation::Softmax => number,
        };
        combine(contract, objectness, number)
    };
    let mut decoded = Decoded::default();
    for place in 0..n_places {
        let objectness = if layout.has_objectness {
            value(place, 4)
        } else {
            1.0
        };
        let mut numbers = [0, 1, 2, 3].map(|number| value(place, number));
        if let Some(cell) = cells.get(place) {
            let [x, y, w, h] = numbers;
            numbers = [
                (x + cell.x) * cell.stride,
                (y + cell.y) * cell.stride,
                w.exp() * cell.stride,
                h.exp() * cell.stride,
            ];
        }
        if contract.output.is_multi_label {
            for class in 0..n_classes {
                let score = score(place, class, objectness);
                if score >= contract.score_threshold {
                    decoded.take_class(contract, numbers, score, class)?;
                }
            }
            continue;
        }
        let mut best = (f32::NEG_INFINITY, 0);
        for class in 0..n_classes {
            let score = score(place, class, objectness);
            if score > best.0 {
                best = (score, class);
            }
        }
        if best.0 >= contract.score_threshold {
            decoded.take_class(contract, numbers, best.0, best.1)?;
        }
    }
    Ok(decoded)
}

/// The score out of objectness and that of the class.
pub(super) fn combine(contract: &Contract, objectness: f32, class: f32) -> f32 {
    let power = |base: f32, exponent: f32| {
        // Most have powers of one, and their product is to be the very product.
        if (exponent - 1.0).abs() < f32::EPSILON {
            base
        } else {
            base.powf(exponent)
        }
    };
    power(objectness, contract.output.objectness_power) * power(class, contract.output.class_power)
}

/// A cell of a grid.
struct Cell {
    x: f32,
    y: f32,
    stride: f32,
}

/// The cells of all grids, row by row, the finest first; none where boxes are ready.
#[expect(
    clippy::cast_precision_loss,
    reason = "cells and strides are small whole numbers"
)]
fn cells(output: &OutputTensor, strides_px: &[u32], n_places: usize) -> Result<Vec<Cell>, String> {
    let mut cells = Vec::new();
    for &stride in strides_px {
        let [width, height] = output.frame_px.map(|side| side / stride);
        for y in 0..height {
            for x in 0..width {
                cells.push(Cell {
                    x: x as f32,
                    y: y as f32,
                    stride: stride as f32,
                });
            }
        }
    }
    if !strides_px.is_empty() && cells.len() != n_places {
        return Err(format!(
            "the output {:?} {:?} has {n_places} places, but grids of strides {strides_px:?} px over a frame of {} x \
             {} px have {} cells; correct the contract's output.strides_px",
            output.name,
            output.shape,
            output.frame_px[0],
            output.frame_px[1],
            cells.len()
        ));
    }
    Ok(cells)
}
