//! What a reader must know before the numbers.

use super::super::conditions::labels;
use super::super::words;
use super::PageWarning;
use crate::evaluation::{Study, Warning, WarningKind};

/// What a reader must know first: of the study, of the detectors, then of the evaluations, those without any number before
/// the others. What several say alike is one line, with who they are and from which to which number.
pub(super) fn warnings(study: &Study) -> Vec<PageWarning> {
    let page_warning = |kind: WarningKind, text: &str| PageWarning {
        about: about(kind),
        text: words::name(text),
    };
    let of_study = study.warnings.iter();
    let mut all: Vec<PageWarning> = of_study
        .map(|warning| page_warning(warning.kind(), &warning.to_string()))
        .collect();
    for one in &study.clean {
        let of_clean = one.warnings.iter();
        all.extend(
            of_clean.map(|warning| {
                page_warning(warning.kind(), &format!("{}: {warning}", one.detector))
            }),
        );
    }
    let mut said: Vec<(Warning, Vec<String>)> = Vec::new();
    for (one, label) in study.evaluations.iter().zip(labels(study)) {
        let who = format!("{}, {label}", one.detector);
        for warning in &one.warnings {
            match said
                .iter_mut()
                .find_map(|(known, by)| known.takes_in(warning).then_some(by))
            {
                Some(by) => by.push(who.clone()),
                None => said.push((warning.clone(), vec![who.clone()])),
            }
        }
    }
    said.sort_by_key(|(warning, _)| rank(warning.kind()));
    let n_evaluations = study.evaluations.len();
    all.extend(said.iter().map(|(warning, by)| {
        let text = match by.len() {
            _ if n_evaluations == 1 => warning.to_string(),
            n if n == n_evaluations => format!("All {n_evaluations} evaluations: {warning}"),
            1 => format!("{}: {warning}", by.concat()),
            n => format!(
                "{n} of {n_evaluations} evaluations: {warning}. These are: {}",
                by.join("; ")
            ),
        };
        page_warning(warning.kind(), &text)
    }));
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
        WarningKind::SmallSample => "Small sample",
        WarningKind::Refused => "Not given",
        WarningKind::Protocol => "Protocol",
        WarningKind::Missing => "Missing data",
    }
}
