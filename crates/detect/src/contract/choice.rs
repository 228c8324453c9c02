//! Which preset a model is for, by what its file says.

use super::{ClassNames, Contract};
use crate::DetectError;
use crate::model_file::{ModelFacts, TensorFacts};

/// A contract, and why it was chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The contract.
    pub contract: Contract,
    /// What spoke for it, to be said out loud.
    pub reason: String,
}

/// The preset for a model, by the names and shapes of its inputs and outputs, its operators and
/// what Ultralytics writes into its files.
///
/// # Errors
///
/// [`DetectError::Model`] where none fits or several do that read the outputs differently; it lists
/// what the model takes and gives, and the candidates.
pub fn choose(model: &str, facts: &ModelFacts) -> Result<Choice, DetectError> {
    let candidates = candidates(facts);
    let wrong = |reason: String| DetectError::Model {
        model: model.to_owned(),
        reason,
    };
    match candidates.as_slice() {
        [(name, reason)] => Ok(Choice {
            contract: Contract::preset(name)?,
            reason: reason.clone(),
        }),
        [] => Err(wrong(format!(
            "fits none of the presets: it {facts}; name the nearest with --contract, or write a contract \
             (docs/detectors.md)"
        ))),
        several => {
            let list: Vec<String> = several
                .iter()
                .map(|(name, reason)| format!("{name} ({reason})"))
                .collect();
            Err(wrong(format!(
                "fits several presets: it {facts}; name one with --contract: {}",
                list.join(", or ")
            )))
        }
    }
}

type Candidate = (&'static str, String);

fn candidates(facts: &ModelFacts) -> Vec<Candidate> {
    match facts.outputs.as_slice() {
        [one] => by_one_output(facts, one),
        [_, _] => by_two_outputs(facts),
        [_, _, _] => by_three_outputs(facts),
        _ => {
            // Further outputs, such as masks, do not change what the named ones mean.
            let named = by_two_outputs(facts);
            if named.is_empty() {
                by_three_outputs(facts)
            } else {
                named
            }
        }
    }
}

fn by_one_output(facts: &ModelFacts, output: &TensorFacts) -> Vec<Candidate> {
    match output.rank() {
        Some(4) => {
            let (rows, columns) = (output.side(2), output.side(3));
            let n_numbers = output.side(1).unwrap_or(0);
            if n_numbers > 5 && rows.is_some() && columns.is_some() {
                return vec![(
                    "fastestdet",
                    format!("its one output is a grid of cells, {output}"),
                )];
            }
            Vec::new()
        }
        Some(3) => match (output.side(1), output.side(2)) {
            // Of small frames a grid has fewer places than there are numbers at each.
            (places, Some(n))
                if n > 6 && !grid_candidates(facts, output, places, n - 5).is_empty() =>
            {
                grid_candidates(facts, output, places, n - 5)
            }
            (_, Some(6)) => rows_of_six(facts, output),
            (Some(n), Some(places)) if n < places && n > 4 => vec![(
                "yolov8",
                format!(
                    "its one output has a box and {} classes in columns, {output}",
                    n - 4
                ),
            )],
            (Some(n), None) if n > 4 && facts.entry("task").is_some() => vec![(
                "yolov8",
                format!(
                    "its one output has a box and {} classes in columns, {output}",
                    n - 4
                ),
            )],
            (places, Some(n)) if n > 5 => by_places(facts, output, places, n),
            _ => Vec::new(),
        },
        _ => Vec::new(),
    }
}

/// `[1, n, 6]`: boxes with score and class, or a box and two classes.
fn rows_of_six(facts: &ModelFacts, output: &TensorFacts) -> Vec<Candidate> {
    let n_classes = class_names(facts).map(|list| list.names.len());
    let rows = if facts.has_operator("NonMaxSuppression") || has_argument(facts, "'nms': True") {
        (
            "yolov8-nms",
            format!("its one output has rows of six and there is suppression inside, {output}"),
        )
    } else {
        (
            "yolov10",
            format!("its one output has rows of six and there is no suppression inside, {output}"),
        )
    };
    // Five numbers and one class in a row make six, too.
    let places = output.side(1);
    let others = match n_classes {
        Some(1) | None => grid_candidates(facts, output, places, 1),
        _ => Vec::new(),
    };
    if !others.is_empty() {
        return others;
    }
    let mut found = vec![rows];
    if n_classes == Some(2) && says(facts, "description", "RT-DETR") {
        found = vec![(
            "rtdetr-ultralytics",
            format!("it calls itself RT-DETR and has two classes, {output}"),
        )];
    } else if n_classes == Some(2) && !says(facts, "description", "YOLO") {
        found.push((
            "rtdetr-ultralytics",
            format!("a box and its two classes make six, too, {output}"),
        ));
    }
    found
}

/// `[1, places, n]` with more than six numbers at a place.
fn by_places(
    facts: &ModelFacts,
    output: &TensorFacts,
    places: Option<u64>,
    n: u64,
) -> Vec<Candidate> {
    let n_listed = class_names(facts).map(|list| list.names.len() as u64);
    let queries = (
        "rtdetr-ultralytics",
        format!(
            "its one output has boxes with {} classes in rows, {output}",
            n - 4
        ),
    );
    match (places, n_listed) {
        (_, Some(listed)) if listed == n - 4 => vec![queries],
        (Some(..=1000), None) => vec![queries],
        _ => vec![
            (
                "yolov5",
                format!("rows with objectness and {} classes", n - 5),
            ),
            (
                "yolox",
                format!("rows with objectness and {} classes", n - 5),
            ),
            queries,
        ],
    }
}

/// By how many places the grids of strides 8, 16 and 32 have: one per cell, or three.
fn grid_candidates(
    facts: &ModelFacts,
    output: &TensorFacts,
    places: Option<u64>,
    n_classes: u64,
) -> Vec<Candidate> {
    let image = facts.inputs.first();
    let sides = image.and_then(|input| Some((input.side(2)?, input.side(3)?)));
    let (Some((height, width)), Some(places)) = (sides, places) else {
        return Vec::new();
    };
    let n_cells: u64 = [8, 16, 32].map(|s| (height / s) * (width / s)).iter().sum();
    if places == n_cells {
        if facts.has_operator("Exp") {
            return vec![(
                "yolox-decoded",
                format!(
                    "its one output has one place per cell with objectness and {n_classes} classes, already \
                     decoded (there is an Exp inside), {output}"
                ),
            )];
        }
        return vec![(
            "yolox",
            format!(
                "its one output has one place per cell with objectness and {n_classes} classes, {output}"
            ),
        )];
    }
    if places == 3 * n_cells {
        return vec![(
            "yolov5",
            format!(
                "its one output has three places per cell with objectness and {n_classes} classes, {output}"
            ),
        )];
    }
    Vec::new()
}

fn by_two_outputs(facts: &ModelFacts) -> Vec<Candidate> {
    let has = |name: &str| facts.output(name);
    if let (Some(boxes), Some(labels)) = (has("dets"), has("labels")) {
        return match (boxes.side(2), labels.rank()) {
            // MMDeploy's exports may leave the five numbers open.
            (Some(5), Some(2) | None) | (None, Some(2)) => vec![(
                "mmdeploy",
                format!("its outputs are boxes with scores, and labels: {boxes}, {labels}"),
            )],
            (Some(4), Some(3)) => vec![(
                "rfdetr",
                format!("its outputs are boxes, and a number per class: {boxes}, {labels}"),
            )],
            _ => Vec::new(),
        };
    }
    if let (Some(logits), Some(boxes)) = (has("logits"), has("pred_boxes")) {
        return vec![("detr", format!("its outputs are {logits}, {boxes}"))];
    }
    Vec::new()
}

fn by_three_outputs(facts: &ModelFacts) -> Vec<Candidate> {
    let named = ["boxes", "labels", "scores"].map(|name| facts.output(name).is_some());
    let all_named = named == [true; 3];
    if all_named && facts.input("orig_target_sizes").is_some() {
        return vec![(
            "rtdetr",
            "it takes orig_target_sizes and gives labels, boxes and scores".to_owned(),
        )];
    }
    let takes_one_image =
        facts.inputs.len() == 1 && facts.inputs.first().and_then(TensorFacts::rank) == Some(3);
    if all_named && takes_one_image {
        return vec![(
            "torchvision-fasterrcnn",
            "it takes an image without a batch and gives boxes, labels and scores".to_owned(),
        )];
    }
    Vec::new()
}

fn has_argument(facts: &ModelFacts, argument: &str) -> bool {
    facts
        .entry("args")
        .is_some_and(|text| text.contains(argument))
}

fn says(facts: &ModelFacts, key: &str, word: &str) -> bool {
    facts
        .entry(key)
        .is_some_and(|text| text.to_uppercase().contains(word))
}

fn class_names(facts: &ModelFacts) -> Option<ClassNames> {
    ClassNames::from_python_dictionary("", facts.entry("names")?).ok()
}
