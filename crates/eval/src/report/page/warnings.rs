//! What a reader must know before the numbers.

use super::super::conditions::labels;
use super::super::words;
use super::PageWarning;
use crate::evaluation::{Study, Warning, WarningKind};

/// What several evaluations say, in words that differ in numbers at most.
struct Said<'a> {
    warnings: Vec<&'a Warning>,
    by: Vec<String>,
}

/// What a reader must know first: of the study, of the detectors, then of the evaluations, those without any number before
/// the others. What several say alike is one line, with who they are and from which to which number.
pub(super) fn warnings(study: &Study) -> Vec<PageWarning> {
    let page_warning = |kind: WarningKind, text: &str| PageWarning {
        about: about(kind),
        text: words::name(text),
    };
    let mut all: Vec<PageWarning> = Vec::new();
    for warning in &study.warnings {
        all.push(page_warning(warning.kind, &warning.text));
    }
    for one in &study.clean {
        for warning in &one.warnings {
            let text = format!("{}: {}", one.detector, warning.text);
            all.push(page_warning(warning.kind, &text));
        }
    }
    let mut said: Vec<Said<'_>> = Vec::new();
    for (one, label) in study.evaluations.iter().zip(labels(study)) {
        let who = format!("{}, {label}", one.detector);
        for warning in &one.warnings {
            let is_alike = |known: &&mut Said<'_>| {
                let first = known.warnings.first();
                first.is_some_and(|first| {
                    first.kind == warning.kind && shape(&first.text) == shape(&warning.text)
                })
            };
            match said.iter_mut().find(is_alike) {
                Some(known) => {
                    known.warnings.push(warning);
                    known.by.push(who.clone());
                }
                None => said.push(Said {
                    warnings: vec![warning],
                    by: vec![who.clone()],
                }),
            }
        }
    }
    said.sort_by_key(|one| one.warnings.first().map(|warning| rank(warning.kind)));
    let n_evaluations = study.evaluations.len();
    for one in &said {
        let Some(first) = one.warnings.first() else {
            continue;
        };
        let text = together(&one.warnings);
        let text = match one.by.len() {
            _ if n_evaluations == 1 => text,
            n if n == n_evaluations => format!("All {n_evaluations} evaluations: {text}"),
            1 => format!("{}: {text}", one.by.concat()),
            n => format!(
                "{n} of {n_evaluations} evaluations: {text}. These are {}",
                one.by.join("; ")
            ),
        };
        all.push(page_warning(first.kind, &text));
    }
    all
}

/// What weighs most comes first: no number at all, then numbers that may be wrong.
fn rank(kind: WarningKind) -> u8 {
    match kind {
        WarningKind::SmallSample => 0,
        WarningKind::LabelMap => 1,
        WarningKind::Missing => 2,
        WarningKind::Protocol => 3,
        WarningKind::Refused => 4,
    }
}

fn about(kind: WarningKind) -> &'static str {
    match kind {
        WarningKind::LabelMap => "Classes",
        WarningKind::SmallSample => "Few objects",
        WarningKind::Refused => "No number",
        WarningKind::Protocol => "Protocol",
        WarningKind::Missing => "Missing",
    }
}

/// A text in pieces that are a whole number or hold none.
fn pieces(text: &str) -> Vec<&str> {
    text.split_inclusive(|c: char| !c.is_ascii_digit())
        .flat_map(|piece| {
            let end = piece.trim_end_matches(|c: char| !c.is_ascii_digit()).len();
            let (number, rest) = piece.split_at(end);
            [number, rest]
        })
        .filter(|piece| !piece.is_empty())
        .collect()
}

fn number(piece: &str) -> Option<u64> {
    piece.parse().ok()
}

/// A text without its numbers.
fn shape(text: &str) -> Vec<&str> {
    let of_numbers = |piece| match number(piece) {
        Some(_) => "0",
        None => piece,
    };
    pieces(text).into_iter().map(of_numbers).collect()
}

/// Texts of one shape as one, with the least and the greatest number where they differ.
fn together(warnings: &[&Warning]) -> String {
    let all: Vec<Vec<&str>> = warnings.iter().map(|one| pieces(&one.text)).collect();
    let Some(first) = all.first() else {
        return String::new();
    };
    let piece = |place: usize, own: &str| {
        let numbers = || all.iter().filter_map(|one| number(one.get(place)?));
        match numbers().min().zip(numbers().max()) {
            Some((least, most)) if least < most => format!("{least} to {most}"),
            _ => own.to_owned(),
        }
    };
    first
        .iter()
        .enumerate()
        .map(|(place, own)| piece(place, own))
        .collect()
}
