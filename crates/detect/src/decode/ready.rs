//! Outputs that list boxes.

use super::{Decoded, check_classes, places, sigmoid, unlike};
use crate::contract::{Activation, Contract};
use crate::runtime::OutputTensor;

/// `[1, places, 6]`: box, score, class.
pub(super) fn rows(contract: &Contract, output: &OutputTensor) -> Result<Decoded, String> {
    let [_, 6] = places(output)? else {
        return Err(unlike(output, "[1, places, 6]"));
    };
    let mut decoded = Decoded::default();
    for row in output.values.chunks_exact(6) {
        if let [x0, y0, x1, y1, score, label] = *row {
            take(&mut decoded, contract, [x0, y0, x1, y1], score, label)?;
        }
    }
    Ok(decoded)
}

/// Boxes, scores and labels, each by itself.
pub(super) fn three(
    contract: &Contract,
    boxes: &OutputTensor,
    scores: &OutputTensor,
    labels: &OutputTensor,
) -> Result<Decoded, String> {
    let n = n_boxes(boxes, 4)?;
    for other in [scores, labels] {
        if other.values.len() != n {
            return Err(unlike(other, &format!("[{n}], one for each box")));
        }
    }
    let mut decoded = Decoded::default();
    let rest = scores.values.iter().zip(&labels.values);
    for (row, (&score, &label)) in boxes.values.chunks_exact(4).zip(rest) {
        if let [x0, y0, x1, y1] = *row {
            take(&mut decoded, contract, [x0, y0, x1, y1], score, label)?;
        }
    }
    Ok(decoded)
}

/// Boxes with their scores, and labels.
pub(super) fn two(
    contract: &Contract,
    boxes: &OutputTensor,
    labels: &OutputTensor,
) -> Result<Decoded, String> {
    let n = n_boxes(boxes, 5)?;
    if labels.values.len() != n {
        return Err(unlike(labels, &format!("[1, {n}], one for each box")));
    }
    let mut decoded = Decoded::default();
    for (row, &label) in boxes.values.chunks_exact(5).zip(&labels.values) {
        if let [x0, y0, x1, y1, score] = *row {
            take(&mut decoded, contract, [x0, y0, x1, y1], score, label)?;
        }
    }
    Ok(decoded)
}

/// Boxes, and a number per class.
pub(super) fn logits(
    contract: &Contract,
    boxes: &OutputTensor,
    logits: &OutputTensor,
    last_is_background: bool,
) -> Result<Decoded, String> {
    let n = n_boxes(boxes, 4)?;
    let [n_rows, n_numbers] = places(logits)?;
    if n_rows != n {
        return Err(unlike(logits, &format!("[1, {n}, classes]")));
    }
    let n_classes = n_numbers.saturating_sub(usize::from(last_is_background));
    check_classes(contract, logits, n_classes)?;
    let mut decoded = Decoded::default();
    let rows = logits.values.chunks_exact(n_numbers.max(1));
    for (corners, row) in boxes.values.chunks_exact(4).zip(rows) {
        let [a, b, c, d] = *corners else { continue };
        let scores = scores(contract.output.activation, row);
        let classes = scores.iter().copied().take(n_classes).enumerate();
        if contract.output.is_multi_label {
            for (class, score) in classes {
                if score >= contract.score_threshold {
                    decoded.take_class(contract, [a, b, c, d], score, class)?;
                }
            }
            continue;
        }
        let mut best = (f32::NEG_INFINITY, 0);
        for (class, score) in classes {
            if score > best.0 {
                best = (score, class);
            }
        }
        if best.0 >= contract.score_threshold {
            decoded.take_class(contract, [a, b, c, d], best.0, best.1)?;
        }
    }
    Ok(decoded)
}

fn scores(activation: Activation, row: &[f32]) -> Vec<f32> {
    match activation {
        Activation::None => row.to_vec(),
        Activation::Sigmoid => row.iter().map(|&x| sigmoid(x)).collect(),
        Activation::Softmax => {
            let most = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            let powers: Vec<f32> = row.iter().map(|&x| (x - most).exp()).collect();
            let sum: f32 = powers.iter().sum();
            powers.iter().map(|power| power / sum).collect()
        }
    }
}

/// How many rows of so many numbers there are, in `[n, numbers]` or `[1, n, numbers]`.
fn n_boxes(output: &OutputTensor, n_numbers: usize) -> Result<usize, String> {
    match places(output)? {
        [n, numbers] if numbers == n_numbers => Ok(n),
        _ => Err(unlike(output, &format!("[1, boxes, {n_numbers}]"))),
    }
}

/// Takes a box with its label, if the score is not below the threshold.
fn take(
    decoded: &mut Decoded,
    contract: &Contract,
    corners: [f32; 4],
    score: f32,
    label: f32,
) -> Result<(), String> {
    if score < contract.score_threshold {
        return Ok(());
    }
    #[expect(
        clippy::cast_possible_truncation,
        reason = "labels are whole numbers; others are refused"
    )]
    let whole = label as i64;
    if !label.is_finite() || label.fract().abs() > f32::EPSILON {
        return Err(format!(
            "a label is {label}, which is no whole number; choose another contract"
        ));
    }
    let n = contract.classes.names.len();
    match usize::try_from(whole - contract.first_label) {
        Ok(class) if class < n => decoded.take_class(contract, corners, score, class),
        _ => Err(format!(
            "a label is {whole}, but {} lists {n} classes, from {} on; give their names in the contract's \
             classes.names",
            contract.classes.origin, contract.first_label
        )),
    }
}
