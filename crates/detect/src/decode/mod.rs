//! A model's outputs to boxes with scores and classes.

mod dense;
mod fastestdet;
mod ready;

use crate::contract::{BoxForm, Contract, OutputForm};
use crate::runtime::OutputTensor;

/// A box of the model's frame, or of the image where the model says so, with a score and a class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Candidate {
    /// Left, top, right, bottom, in the contract's unit.
    pub(crate) corners: [f32; 4],
    /// How sure the model is.
    pub(crate) score: f32,
    /// Place of the class among the model's.
    pub(crate) class: u32,
}

/// What the outputs of one image hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Decoded {
    /// Boxes whose score is not below the threshold, in the order of the outputs.
    pub(crate) candidates: Vec<Candidate>,
    /// Boxes whose right side lies left of the left one, or the lower above the upper: left out.
    pub(crate) n_inverted: u32,
    /// Labels that stand for no class: left out.
    pub(crate) n_without_class: u32,
}

/// Boxes out of the outputs, in the order of [`output_names`].
///
/// # Errors
///
/// What is wrong with the outputs, as the reason of an error.
pub(crate) fn decode(contract: &Contract, outputs: &[OutputTensor]) -> Result<Decoded, String> {
    for output in outputs {
        refuse_nan(output)?;
    }
    match (&contract.output.form, outputs) {
        (
            OutputForm::Dense {
                places_first,
                has_objectness,
                strides_px,
                ..
            },
            [output],
        ) => {
            let layout = dense::Layout {
                places_first: *places_first,
                has_objectness: *has_objectness,
            };
            dense::decode(contract, output, layout, strides_px)
        }
        (OutputForm::Rows { .. }, [output]) => ready::rows(contract, output),
        (OutputForm::BoxesScoresLabels { .. }, [boxes, scores, labels]) => {
            ready::three(contract, boxes, scores, labels)
        }
        (OutputForm::ScoredBoxesLabels { .. }, [boxes, labels]) => {
            ready::two(contract, boxes, labels)
        }
        (
            OutputForm::BoxesLogits {
                last_is_background, ..
            },
            [boxes, logits],
        ) => ready::logits(contract, boxes, logits, *last_is_background),
        (OutputForm::FastestDet { .. }, [output]) => fastestdet::decode(contract, output),
        _ => Err(format!(
            "the contract {:?} speaks of another number of outputs than {}",
            contract.name,
            outputs.len()
        )),
    }
}

/// Which outputs the contract reads, by name or by place in the model, in the order of [`decode`].
pub(crate) fn output_names(form: &OutputForm) -> Vec<Option<&str>> {
    match form {
        OutputForm::Dense { output, .. }
        | OutputForm::Rows { output }
        | OutputForm::FastestDet { output } => vec![output.as_deref()],
        OutputForm::BoxesScoresLabels { outputs } => outputs.iter().map(Option::as_deref).collect(),
        OutputForm::ScoredBoxesLabels { outputs } | OutputForm::BoxesLogits { outputs, .. } => {
            outputs.iter().map(Option::as_deref).collect()
        }
    }
}

fn refuse_nan(output: &OutputTensor) -> Result<(), String> {
    let n_nan = output.values.iter().filter(|value| value.is_nan()).count();
    let place = output.values.iter().position(|value| value.is_nan());
    match place {
        None => Ok(()),
        Some(place) => Err(format!(
            "the output {:?} {:?} has {n_nan} values that are not a number, the first at place {place}; the model is \
             broken, or its contract feeds it wrong numbers",
            output.name, output.shape
        )),
    }
}

/// The two last sides, where all before are 1.
fn places(output: &OutputTensor) -> Result<[usize; 2], String> {
    match output.shape.as_slice() {
        [a, b] | [1, a, b] => Ok([*a, *b]),
        _ => Err(unlike(output, "[1, places, numbers]")),
    }
}

fn unlike(output: &OutputTensor, expected: &str) -> String {
    format!(
        "the output {:?} has the shape {:?}, but the contract expects {expected}; choose another contract",
        output.name, output.shape
    )
}

/// As many numbers as classes.
fn check_classes(contract: &Contract, output: &OutputTensor, n: usize) -> Result<(), String> {
    let n_listed = contract.classes.names.len();
    if n == n_listed {
        return Ok(());
    }
    Err(format!(
        "the output {:?} {:?} has {n} classes, but {} lists {n_listed}; give their names in the contract's \
         classes.names",
        output.name, output.shape, contract.classes.origin
    ))
}

impl Decoded {
    /// Takes a box of a class, unless the number stands for none.
    fn take_class(
        &mut self,
        contract: &Contract,
        numbers: [f32; 4],
        score: f32,
        class: usize,
    ) -> Result<(), String> {
        match contract.classes.names.get(class) {
            Some(Some(_)) => self.push(
                contract,
                numbers,
                score,
                u32::try_from(class).unwrap_or(u32::MAX),
            ),
            _ => {
                self.n_without_class += 1;
                Ok(())
            }
        }
    }

    /// Takes a box that is not below the threshold.
    fn push(
        &mut self,
        contract: &Contract,
        numbers: [f32; 4],
        score: f32,
        class: u32,
    ) -> Result<(), String> {
        let corners = match contract.output.box_form {
            BoxForm::Corners => numbers,
            BoxForm::CenterSize => {
                let [x, y, w, h] = numbers;
                [x - w / 2.0, y - h / 2.0, x + w / 2.0, y + h / 2.0]
            }
        };
        if !score.is_finite() || corners.iter().any(|side| !side.is_finite()) {
            return Err(format!(
                "a box {corners:?} with score {score} is not finite; the model is broken, or its contract feeds it \
                 wrong numbers"
            ));
        }
        if corners[2] < corners[0] || corners[3] < corners[1] {
            self.n_inverted += 1;
            return Ok(());
        }
        self.candidates.push(Candidate {
            corners,
            score,
            class,
        });
        Ok(())
    }
}

/// The logistic function, as PyTorch has it in 32 bits.
fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + (-x).exp())
}
