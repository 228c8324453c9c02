//! Permutation tests: clean and cracked swapped.

use rayon::prelude::*;

use super::Plan;
use crate::EvalError;
use crate::statistic::{Method, TestOutcome};

/// Permutations up to which all of them are gone through rather than drawn.
const EXACT_UP_TO: u32 = 1024;

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
pub fn permutation_test<F>(plan: &Plan, difference: F) -> Result<Vec<TestOutcome>, EvalError>
where
    F: Fn(&[u32]) -> Vec<Option<f64>> + Sync,
{
    plan.check()?;
    let n_all = 1_u32
        .checked_shl(plan.n_units())
        .filter(|n| *n <= EXACT_UP_TO);
    let method = match n_all {
        Some(_) => Method::PermutationExact,
        None => Method::PermutationSampled,
    };
    let rows: Vec<Vec<Option<f64>>> = (0..n_all.unwrap_or(plan.n_replicates))
        .into_par_iter()
        .map(|k| {
            difference(&match n_all {
                Some(_) => plan.swaps_of(k),
                None => plan.swaps(k),
            })
        })
        .collect();
    let observed = difference(&vec![0; plan.n_images()]);
    let n = u64::from(plan.n_units());
    let outcome = |(place, observed): (usize, &Option<f64>)| {
        let Some(observed) = observed.filter(|it| it.is_finite()) else {
            return TestOutcome::none(n, method, "undefined in the sample itself");
        };
        // Differences that are equal but for rounding are as far off.
        let far = observed.abs() * (1.0 - 1e-12);
        let (mut n_far, mut n_defined) = (0_u32, 0_u32);
        for value in rows
            .iter()
            .filter_map(|row| row.get(place).copied().flatten())
        {
            n_defined += 1;
            n_far += u32::from(value.abs() >= far);
        }
        if n_defined == 0 {
            return TestOutcome::none(n, method, "undefined under all permutations");
        }
        let more = u32::from(n_all.is_none());
        let p = f64::from(n_far + more) / f64::from(n_defined + more);
        TestOutcome::of(p, n, method)
    };
    Ok(observed.iter().enumerate().map(outcome).collect())
}
