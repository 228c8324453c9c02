//! The conditions of a study, told apart by all that they are: a name alone may stand for two.

use crate::evaluation::{Condition, Evaluation, Study};

/// A condition of a study.
#[derive(Debug, Clone)]
pub(super) struct Told<'a> {
    /// What was done to the glass.
    pub(super) condition: &'a Condition,
    /// Which of the evaluations of one detector that say the same of themselves.
    n_before: usize,
    /// Its name; the second of the same name gets a `(2)`, and so on.
    pub(super) label: String,
}

impl<'a> Told<'a> {
    /// The evaluation of a detector under this condition.
    pub(super) fn evaluation(&self, study: &'a Study, detector: &str) -> Option<&'a Evaluation> {
        let mut same = study
            .evaluations
            .iter()
            .filter(|one| one.detector == detector && one.condition == *self.condition);
        same.nth(self.n_before)
    }
}

/// All conditions, in the order of the study.
pub(super) fn told_apart(study: &Study) -> Vec<Told<'_>> {
    let mut told: Vec<Told<'_>> = Vec::new();
    for (place, _) in study.evaluations.iter().enumerate() {
        let Some((condition, n_before)) = key(study, place) else {
            continue;
        };
        let is_known = |one: &Told<'_>| one.condition == condition && one.n_before == n_before;
        if told.iter().any(is_known) {
            continue;
        }
        let same_name = |one: &&Told<'_>| one.condition.name == condition.name;
        let label = match told.iter().filter(same_name).count() {
            0 => condition.name.clone(),
            n => format!("{} ({})", condition.name, n + 1),
        };
        told.push(Told {
            condition,
            n_before,
            label,
        });
    }
    told
}

/// The label of each evaluation's condition.
pub(super) fn labels(study: &Study) -> Vec<String> {
    let told = told_apart(study);
    (0..study.evaluations.len())
        .map(|place| {
            let key = key(study, place);
            told.iter()
                .find(|one| Some((one.condition, one.n_before)) == key)
                .map_or_else(String::new, |one| one.label.clone())
        })
        .collect()
}

/// What an evaluation says of itself, and how many of the same detector before it say the same.
fn key(study: &Study, place: usize) -> Option<(&Condition, usize)> {
    let own = study.evaluations.get(place)?;
    let is_same =
        |one: &&Evaluation| one.detector == own.detector && one.condition == own.condition;
    let before = study.evaluations.iter().take(place);
    Some((&own.condition, before.filter(is_same).count()))
}
