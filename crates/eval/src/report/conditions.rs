//! The conditions of a study, told apart by all that they are: a name alone may stand for two.

use crate::evaluation::{Condition, Evaluation, FailureRow, OverSeeds, PairedRow, Study};

/// A condition of a study.
#[derive(Debug, Clone)]
pub(super) struct Told<'a> {
    /// What was done to the glass.
    pub(super) condition: &'a Condition,
    /// Which of the evaluations of one detector that say the same of themselves.
    n_before: usize,
    /// Its name; the second of the same name gets a `(2)`, and so on.
    pub(super) label: String,
    /// Whether it is all seeds of a family and severity.
    pub(super) is_pooled: bool,
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

    /// What a detector's clean and cracked images say under it.
    pub(super) fn paired(&self, study: &'a Study, detector: &str) -> Option<&'a [PairedRow]> {
        if self.is_pooled {
            let mut pooled = study.over_seeds.iter();
            let is_it =
                |one: &&OverSeeds| one.detector == detector && one.condition == *self.condition;
            return pooled.find(is_it).map(|one| one.paired.as_slice());
        }
        Some(&self.evaluation(study, detector)?.paired)
    }
}

/// The conditions of a table on paper: seeds that are taken together are one.
pub(super) fn printed(study: &Study) -> Vec<Told<'_>> {
    let mut printed: Vec<Told<'_>> = Vec::new();
    for told in told_apart(study) {
        let mut of_condition = study.evaluations.iter();
        let one = of_condition.find(|one| one.condition == *told.condition);
        let Some(pooled) = one.and_then(|one| pool_of(study, one)) else {
            printed.push(told);
            continue;
        };
        if printed
            .iter()
            .all(|known| *known.condition != pooled.condition)
        {
            printed.push(Told {
                condition: &pooled.condition,
                n_before: 0,
                label: pooled.condition.name.clone(),
                is_pooled: true,
            });
        }
    }
    printed
}

/// A detector under a condition, or under all seeds of one: what sums a study up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Summed<'a> {
    /// The detector.
    pub(super) detector: &'a str,
    /// What was done to the glass.
    pub(super) condition: &'a Condition,
    /// Clean against cracked.
    pub(super) paired: &'a [PairedRow],
    /// What is lost.
    pub(super) rates: &'a [FailureRow],
    /// Seeds taken together; 1 of a condition that stands alone.
    pub(super) n_seeds: usize,
    /// A condition that stands alone.
    alone: Option<&'a Evaluation>,
}

impl<'a> Summed<'a> {
    /// A condition alone.
    pub(super) fn of(evaluation: &'a Evaluation) -> Self {
        let failures = evaluation.failures.as_ref();
        Self {
            detector: &evaluation.detector,
            condition: &evaluation.condition,
            paired: &evaluation.paired,
            rates: failures.map_or(&[], |failures| &failures.rates),
            n_seeds: 1,
            alone: Some(evaluation),
        }
    }

    /// The evaluations of its seeds, one of each.
    pub(super) fn evaluations(self, study: &'a Study) -> impl Iterator<Item = &'a Evaluation> {
        let is_it = move |pool: &&OverSeeds| {
            self.alone.is_none()
                && pool.detector == self.detector
                && pool.condition == *self.condition
        };
        let pool = study.over_seeds.iter().find(is_it);
        let seeds = pool.map_or(&[][..], |pool| &pool.seeds);
        let of_seed = move |seed: &u64| {
            let mut all = study.evaluations.iter();
            all.find(|one| {
                one.condition.seed == Some(*seed)
                    && pool_of(study, one).is_some_and(|of_one| pool == Some(of_one))
            })
        };
        self.alone
            .into_iter()
            .chain(seeds.iter().filter_map(of_seed))
    }

    /// All seeds of a condition.
    pub(super) fn of_pool(pooled: &'a OverSeeds) -> Self {
        Self {
            detector: &pooled.detector,
            condition: &pooled.condition,
            paired: &pooled.paired,
            rates: &pooled.rates,
            n_seeds: pooled.seeds.len(),
            alone: None,
        }
    }
}

/// The seeds that an evaluation is taken together with.
pub(super) fn pool_of<'a>(study: &'a Study, one: &Evaluation) -> Option<&'a OverSeeds> {
    study.over_seeds.iter().find(|pooled| {
        pooled.detector == one.detector
            && pooled.condition.family == one.condition.family
            && pooled.condition.severity == one.condition.severity
            && one
                .condition
                .seed
                .is_some_and(|seed| pooled.seeds.contains(&seed))
    })
}

/// Every condition of every detector in the order of the study; seeds that are taken together are one.
pub(super) fn summed(study: &Study) -> Vec<Summed<'_>> {
    let mut all: Vec<Summed<'_>> = Vec::new();
    for one in &study.evaluations {
        let next = match pool_of(study, one) {
            None => Summed::of(one),
            Some(pooled) => Summed::of_pool(pooled),
        };
        let is_known = |known: &Summed<'_>| {
            next.n_seeds > 1 && known.detector == next.detector && known.condition == next.condition
        };
        if !all.iter().any(is_known) {
            all.push(next);
        }
    }
    all
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
            is_pooled: false,
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
