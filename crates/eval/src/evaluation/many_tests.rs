//! Many tests at once: Holm's correction over all conditions of a study.

use super::{
    Evaluation, FailureResults, FailureRow, GroupKind, OverSeeds, PairedRow, Study, Warning,
};
use crate::statistic::holm;

/// A p with what it is of, and where its corrected one goes.
struct Test<'a> {
    /// The metric of a detector in a place: what is corrected together.
    family: String,
    /// The data; with `is_super` it tells whether two are the same test.
    data: String,
    /// Whether it is of a supercategory, or of the mean over them.
    is_super: bool,
    p: Option<f64>,
    p_holm: &'a mut Option<f64>,
}

impl Study {
    /// Puts the corrected p beside each p, by Holm's method.
    ///
    /// A family is one metric of one detector in one place over all conditions of the study. All
    /// classes together (and the mean of the supercategories) are the question that a study asks and
    /// a family of their own; supercategories and classes, which look closer, are another one. Where
    /// two of its rows are of the same data, as the class `person` and the supercategory of the same
    /// name are, they are one test. The means over seeds are families of their own.
    pub fn correct_for_many_tests(&mut self) {
        let mut tests = Vec::new();
        for (condition, one) in self.evaluations.iter_mut().enumerate() {
            of_evaluation(condition, one, &mut tests);
        }
        for (condition, one) in self.over_seeds.iter_mut().enumerate() {
            let OverSeeds {
                detector,
                paired,
                rates,
                ..
            } = one;
            let about = format!("over seeds of {detector}");
            of_pairs(&about, condition, paired, &mut tests);
            of_rates(&about, condition, rates, &mut tests);
        }
        correct(tests);
    }

    /// Warns where the smallest p that so many replicates can give is no longer significant once it is corrected, at
    /// 5 %, in the question that a study asks: all classes together.
    pub fn warn_of_few_replicates(&mut self, n_replicates: u32) {
        let least = 1.0 / (f64::from(n_replicates) + 1.0);
        let rows = self.evaluations.iter().flat_map(|one| &one.paired);
        let of_all = rows.filter(|row| row.group.kind == GroupKind::All);
        let factors = of_all.filter_map(|row| {
            let (p, p_holm) = (row.p?, row.p_holm?);
            (p < 1.001 * least && p_holm > 0.05).then_some(p_holm / p)
        });
        let factor = factors.fold(0.0, f64::max);
        if factor > 0.0 {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "twenty times a number of tests, held by the largest"
            )]
            let needed = (factor * 20.0 / 1000.0).ceil() as u32 * 1000;
            self.warnings.push(Warning::FewReplicates {
                n_replicates,
                needed,
            });
        }
    }
}

fn correct(mut tests: Vec<Test<'_>>) {
    tests.retain(|test| test.p.is_some());
    tests.sort_by(|a, b| (&a.family, &a.data).cmp(&(&b.family, &b.data)));
    for family in tests.chunk_by_mut(|a, b| a.family == b.family) {
        let mut p = Vec::new();
        for same in family.chunk_by(|a, b| a.data == b.data) {
            // A supercategory and a class of the same data are one test; two classes are two.
            let n_super = same.iter().filter(|test| test.is_super).count();
            let n_tests = n_super.max(same.len() - n_super);
            p.extend(same.iter().take(n_tests).map(|test| test.p));
            p.extend(same.iter().skip(n_tests).map(|_| None));
        }
        let mut last = None;
        for (test, corrected) in family.iter_mut().zip(holm(&p)) {
            // Equal ones lie together, and the corrected p of equal p are equal.
            last = corrected.or(last);
            *test.p_holm = last;
        }
    }
}

fn of_evaluation<'a>(condition: usize, one: &'a mut Evaluation, tests: &mut Vec<Test<'a>>) {
    let about = format!("each condition of {}", one.detector);
    of_pairs(&about, condition, &mut one.paired, tests);
    let Some(failures) = &mut one.failures else {
        return;
    };
    let FailureResults {
        rates,
        shifts,
        dose_responses,
        ..
    } = failures;
    of_rates(&about, condition, rates, tests);
    for row in shifts {
        let place = format!("{about}, {:?}, {}", row.scope, sort_of(row.group.kind));
        let ps = (row.p_score, row.p_iou);
        let data = format!("{condition} {} {:?} {ps:?}", row.n_pairs, row.score.value);
        tests.push(Test {
            family: format!("score shift of {place}"),
            data: data.clone(),
            is_super: false,
            p: row.p_score,
            p_holm: &mut row.p_score_holm,
        });
        tests.push(Test {
            family: format!("overlap shift of {place}"),
            data,
            is_super: false,
            p: row.p_iou,
            p_holm: &mut row.p_iou_holm,
        });
    }
    for dose in dose_responses {
        if let Some(fit) = &mut dose.fit {
            tests.push(Test {
                family: format!("{} of {about}", dose.fact),
                data: condition.to_string(),
                is_super: false,
                p: fit.p,
                p_holm: &mut fit.p_holm,
            });
        }
    }
}

fn of_pairs<'a>(
    about: &str,
    condition: usize,
    rows: &'a mut [PairedRow],
    tests: &mut Vec<Test<'a>>,
) {
    for row in rows {
        let (clean, cracked) = (row.clean.value, row.cracked.value);
        tests.push(Test {
            family: format!(
                "{:?} of {about}, {:?}, {}",
                row.metric,
                row.scope,
                sort_of(row.group.kind)
            ),
            data: format!(
                "{condition} {} {clean:?} {cracked:?} {:?}",
                row.n_objects, row.p
            ),
            is_super: is_super(row.group.kind),
            p: row.p,
            p_holm: &mut row.p_holm,
        });
    }
}

fn of_rates<'a>(
    about: &str,
    condition: usize,
    rows: &'a mut [FailureRow],
    tests: &mut Vec<Test<'a>>,
) {
    for row in rows {
        tests.push(Test {
            family: format!(
                "failure of {about}, {:?}, {}",
                row.scope,
                sort_of(row.group.kind)
            ),
            data: format!(
                "{condition} {} {} {} {} {:?}",
                row.n_objects, row.n_found_clean, row.n_lost, row.n_recovered, row.p
            ),
            is_super: is_super(row.group.kind),
            p: row.p,
            p_holm: &mut row.p_holm,
        });
    }
}

fn sort_of(kind: GroupKind) -> &'static str {
    match kind {
        GroupKind::All | GroupKind::MeanOfSupercategories => "all",
        GroupKind::Supercategory | GroupKind::Class => "groups",
    }
}

fn is_super(kind: GroupKind) -> bool {
    matches!(
        kind,
        GroupKind::Supercategory | GroupKind::MeanOfSupercategories
    )
}

#[cfg(test)]
mod tests {
    use super::{Test, correct};

    /// Corrected p of tests given as family, data, whether of a supercategory, and p.
    fn corrected(tests: &[(&str, &str, bool, Option<f64>)]) -> Vec<Option<f64>> {
        let mut found = vec![None; tests.len()];
        let with_slots = tests.iter().zip(&mut found);
        correct(
            with_slots
                .map(|((family, data, is_super, p), p_holm)| Test {
                    family: (*family).to_owned(),
                    data: (*data).to_owned(),
                    is_super: *is_super,
                    p: *p,
                    p_holm,
                })
                .collect(),
        );
        found
    }

    #[test]
    fn conditions_are_corrected_together_and_detectors_are_not() {
        let found = corrected(&[
            ("YOLOX", "star", false, Some(0.01)),
            ("YOLOX", "long", false, Some(0.04)),
            ("YOLOX", "hail", false, None),
            ("other", "star", false, Some(0.03)),
        ]);
        assert_eq!(found, [Some(0.02), Some(0.04), None, Some(0.03)]);
    }

    #[test]
    fn a_supercategory_of_one_class_is_one_test_with_it() {
        let found = corrected(&[
            ("f", "person", false, Some(0.01)),
            ("f", "person", true, Some(0.01)),
            ("f", "chair", false, Some(0.04)),
        ]);
        assert_eq!(found, [Some(0.02), Some(0.02), Some(0.04)], "two tests");
        let found = corrected(&[
            ("f", "same counts", false, Some(0.01)),
            ("f", "same counts", false, Some(0.01)),
            ("f", "chair", false, Some(0.04)),
        ]);
        assert_eq!(
            found,
            [Some(0.03), Some(0.03), Some(0.04)],
            "two classes that happen to say the same are two"
        );
    }
}
