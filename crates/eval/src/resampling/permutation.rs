//! Permutation tests: clean and cracked swapped.

use rayon::prelude::*;

use super::Plan;
use crate::EvalError;
use crate::statistic::{Interval, MIN_UNITS, Method, TestOutcome};

/// What a permutation test says of a difference.
#[derive(Debug, Clone, PartialEq)]
pub struct Permuted {
    /// The test itself.
    pub test: TestOutcome,
    /// The difference ± the largest size, among those of the permutations, that the test would not
    /// reject. So it holds 0 exactly where p is 1 − level or more. Permutations of images that do differ
    /// spread more than other images would, so with a large effect the interval errs on the wide side.
    pub interval: Option<Interval>,
}

/// Whether each of several differences is more than chance makes them, two-sided: per difference,
/// how often permutations of clean and cracked give one as far from 0 as what was seen.
///
/// `difference` gets for each image 1 if clean and cracked are swapped, else 0. It gives one value
/// per difference, always in the same number and order, `None` where one is undefined. Images of one
/// unit of the plan are swapped together, and an image with the cracks of all its seeds. If the
/// cracks did nothing, each permutation would be as likely as what was seen.
///
/// With n units, where 2ⁿ is up to 1024, all permutations are gone through, p = k/2ⁿ; beyond that
/// the plan's number is drawn, p = (k + 1)/(B + 1), which holds its level for any B
/// \[PhipsonSmyth2010\].
///
/// # Errors
/// If the plan has no replicates or no proper level.
pub fn permutation_test<F>(plan: &Plan, difference: F) -> Result<Vec<Permuted>, EvalError>
where
    F: Fn(&[u32]) -> Vec<Option<f64>> + Sync,
{
    plan.check()?;
    let rows: Vec<Vec<Option<f64>>> = (0..plan.n_permutations())
        .into_par_iter()
        .map(|k| difference(&plan.permutation(k)))
        .collect();
    let observed = difference(&vec![0; plan.n_images()]);
    Ok(permuted(plan, &observed, &rows))
}

/// The same from the differences under each draw, by its place among all of the plan.
pub(crate) fn permuted_draws(
    plan: &Plan,
    differences: impl Fn(usize) -> Vec<Option<f64>>,
) -> Vec<Permuted> {
    let rows: Vec<Vec<Option<f64>>> = plan.permutation_draws().map(&differences).collect();
    permuted(plan, &differences(plan.unexchanged_draw()), &rows)
}

/// The same from the differences that were observed, and from those of each permutation.
fn permuted(plan: &Plan, observed: &[Option<f64>], rows: &[Vec<Option<f64>>]) -> Vec<Permuted> {
    let is_exact = plan.n_all_permutations().is_some();
    let method = match is_exact {
        true => Method::PermutationExact,
        false => Method::PermutationSampled,
    };
    let n = u64::from(plan.n_units());
    let outcome = |(place, observed): (usize, &Option<f64>)| {
        let none = |why| Permuted {
            test: TestOutcome::none(n, method, why),
            interval: None,
        };
        let Some(observed) = observed.filter(|it| it.is_finite()) else {
            return none("undefined for the sample itself");
        };
        let values = rows.iter().filter_map(|row| *row.get(place)?);
        let mut sizes: Vec<f64> = values.map(f64::abs).collect();
        if sizes.is_empty() {
            return none("undefined under all permutations");
        }
        sizes.sort_by(|a, b| b.total_cmp(a));
        // Differences that are equal but for rounding are as far off.
        let far = observed.abs() * (1.0 - 1e-12);
        let n_far = sizes.partition_point(|size| *size >= far);
        let more = usize::from(!is_exact);
        let p_of = |n_far: usize| (n_far + more) as f64 / (sizes.len() + more) as f64;
        // The largest size that would not be rejected; none where all of them are, or none varies.
        let n_rejected = (0..sizes.len()).find(|k| p_of(k + 1) >= 1.0 - plan.level);
        let reach = n_rejected.and_then(|k| sizes.get(k)).copied();
        let reach = reach.filter(|reach| *reach > 0.0 && plan.n_units() >= MIN_UNITS);
        Permuted {
            test: TestOutcome::of(p_of(n_far), n, method),
            interval: reach.map(|reach| Interval {
                low: observed - reach,
                high: observed + reach,
                level: plan.level,
                method: Method::PermutationReach,
            }),
        }
    };
    observed.iter().enumerate().map(outcome).collect()
}
