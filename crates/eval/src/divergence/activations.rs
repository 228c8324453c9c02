//! Two sets of feature vectors compared, with floor, interval and p-value.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::draws::{Purpose, multiplicities, stream, subset};
use super::measures::{
    CMMD_SCALE, FeatureVectors, MmdKernel, frechet_distance, frechet_of_rows,
    kernel_inception_distance, mmd_rbf_biased,
};
use super::report::{CompareSettings, Estimate, Measure, VectorComparison};
use crate::EvalError;

/// Kernels of more vectors than this, both sets together, are not resampled: 128 MB.
const MOST_RESAMPLED: usize = 4000;

/// Operations that may go into resampling Fréchet distances, in each of three ways.
const FRECHET_BUDGET: u64 = 30_000_000_000;

/// Two sets of feature vectors compared: Fréchet distance (plain and shrunk), KID, MMD with an RBF
/// kernel. `sets` are their places, which the draws depend on, `origin` says where they come from.
///
/// Fréchet distances are resampled less often where vectors are long (the number is in
/// [`VectorComparison::n_frechet_resamples`]); not at all
/// where fewer than 20 would be affordable (from some 280 values on); kernels not beyond 4000 vectors.
///
/// # Errors
/// [`EvalError::VectorLengths`], [`EvalError::FewVectors`] below two vectors in a set,
/// [`EvalError::KernelWidth`].
pub fn compare_vectors(
    a: &FeatureVectors,
    b: &FeatureVectors,
    origin: &str,
    sigma: f64,
    sets: [usize; 2],
    settings: &CompareSettings,
) -> Result<VectorComparison, EvalError> {
    let frechet = frechet_distance(a, b)?;
    let kid = kernel_inception_distance(a, b)?;
    let rbf = mmd_rbf_biased(a, b, sigma)?;
    let d = a.n_dimensions();
    let (n_vectors, side) = (a.n() as u64 + b.n() as u64, d as u64);
    let work = side.saturating_pow(3).saturating_mul(60).saturating_add(
        n_vectors
            .saturating_mul(side.saturating_pow(2))
            .saturating_mul(2),
    );
    let n_frechet_resamples = match usize::try_from(FRECHET_BUDGET / work.max(1)) {
        Ok(..FEWEST_RESAMPLES) => 0,
        Ok(n) => n,
        Err(_) => usize::MAX,
    };
    let mut measures = BTreeMap::new();

    let draws = Draws {
        a,
        b,
        sets,
        settings,
    };
    let by_rows = |rows_a: &[&[f64]], rows_b: &[&[f64]]| -> Option<[f64; 2]> {
        let distance = frechet_of_rows(rows_a, rows_b, d).ok()?;
        Some([distance.d2, distance.d2_shrunk])
    };
    let estimates = draws.of_rows(
        n_frechet_resamples,
        by_rows,
        [frechet.d2, frechet.d2_shrunk],
    );
    for (measure, estimate) in [Measure::Frechet, Measure::FrechetShrunk]
        .into_iter()
        .zip(estimates)
    {
        measures.insert(measure, estimate);
    }
    let is_resampled = a.n() + b.n() <= MOST_RESAMPLED;
    for (measure, kernel, value, scale) in [
        (Measure::Kid, MmdKernel::Cubic, kid, 1.0),
        (Measure::MmdRbf, MmdKernel::Rbf { sigma }, rbf, CMMD_SCALE),
    ] {
        let estimate = if is_resampled {
            draws.of_kernel(kernel, value, scale)
        } else {
            Estimate::of(
                value * scale,
                Vec::new(),
                [Vec::new(), Vec::new()],
                &[],
                settings.confidence,
            )
        };
        measures.insert(measure, estimate);
    }
    Ok(VectorComparison {
        origin: origin.to_owned(),
        n_dimensions: d,
        n_a: a.n(),
        n_b: b.n(),
        shrinkage: [frechet.shrinkage_a, frechet.shrinkage_b],
        is_rank_deficient: frechet.is_rank_deficient,
        rbf_sigma: sigma,
        n_frechet_resamples,
        is_kernel_resampled: is_resampled,
        measures,
    })
}

/// A p-value or an interval of fewer resamples than this misleads: then there is none.
const FEWEST_RESAMPLES: usize = 20;

struct Draws<'a> {
    a: &'a FeatureVectors,
    b: &'a FeatureVectors,
    sets: [usize; 2],
    settings: &'a CompareSettings,
}

impl Draws<'_> {
    fn seed(&self) -> u64 {
        self.settings.seed
    }

    /// Estimates of two values that are computed from rows.
    fn of_rows(
        &self,
        most: usize,
        measured: impl Fn(&[&[f64]], &[&[f64]]) -> Option<[f64; 2]> + Sync,
        values: [f64; 2],
    ) -> [Estimate; 2] {
        let (rows_a, rows_b): (Vec<&[f64]>, Vec<&[f64]>) =
            (self.a.rows().collect(), self.b.rows().collect());
        let all: Vec<&[f64]> = rows_a.iter().chain(&rows_b).copied().collect();
        let times = |n: usize| (0..n.min(most)).into_par_iter();
        let drawn: Vec<[f64; 2]> = times(self.settings.n_bootstrap)
            .filter_map(|index| {
                let again = |rows: &[&'_ [f64]], set: usize| -> Vec<Vec<f64>> {
                    let mut random = stream(self.seed(), Purpose::Bootstrap, [set, set], index);
                    let counts = multiplicities(&mut random, rows.len());
                    let rows = rows.iter().zip(counts);
                    rows.flat_map(|(row, n)| (0..n).map(|_| row.to_vec()))
                        .collect()
                };
                let (a, b) = (again(&rows_a, self.sets[0]), again(&rows_b, self.sets[1]));
                let a: Vec<&[f64]> = a.iter().map(Vec::as_slice).collect();
                let b: Vec<&[f64]> = b.iter().map(Vec::as_slice).collect();
                measured(&a, &b)
            })
            .collect();
        let parted = |rows: &[&[f64]], purpose, sets, n_first: usize, index| {
            let mut random = stream(self.seed(), purpose, sets, index);
            let is_first = subset(&mut random, rows.len(), n_first);
            let part = |wanted: bool| -> Vec<&[f64]> {
                let rows = rows.iter().zip(&is_first);
                rows.filter(|(_, first)| **first == wanted)
                    .map(|(row, _)| *row)
                    .collect()
            };
            measured(&part(true), &part(false))
        };
        let halves = |rows: &[&[f64]], set: usize| -> Vec<[f64; 2]> {
            times(self.settings.n_splits)
                .filter_map(|index| {
                    parted(rows, Purpose::Halves, [set, set], rows.len() / 2, index)
                })
                .collect()
        };
        let floors = [halves(&rows_a, self.sets[0]), halves(&rows_b, self.sets[1])];
        let relabeled: Vec<[f64; 2]> = times(self.settings.n_permutations)
            .filter_map(|index| parted(&all, Purpose::Permutation, self.sets, rows_a.len(), index))
            .collect();
        let column = |values: &[[f64; 2]], at: usize| -> Vec<f64> {
            values
                .iter()
                .filter_map(|pair| pair.get(at).copied())
                .collect()
        };
        let estimate = |at: usize, value: f64| {
            let floors = [column(&floors[0], at), column(&floors[1], at)];
            let relabeled = column(&relabeled, at);
            Estimate::of(
                value,
                column(&drawn, at),
                floors,
                &relabeled,
                self.settings.confidence,
            )
        };
        [estimate(0, values[0]), estimate(1, values[1])]
    }

    /// The estimate of an MMD², whose kernel is computed once.
    fn of_kernel(&self, kernel: MmdKernel, value: f64, scale: f64) -> Estimate {
        let all: Vec<&[f64]> = self.a.rows().chain(self.b.rows()).collect();
        let (n_a, n) = (self.a.n(), all.len());
        let matrix: Vec<Vec<f64>> = all
            .par_iter()
            .map(|x| all.iter().map(|y| kernel.of(x, y)).collect())
            .collect();
        let is_unbiased = kernel == MmdKernel::Cubic;
        let measured = |weights_a: &[f64], weights_b: &[f64]| {
            scale * weighted_mmd(&matrix, weights_a, weights_b, is_unbiased)
        };
        let drawn: Vec<f64> = (0..self.settings.n_bootstrap)
            .into_par_iter()
            .map(|index| {
                let draw = |set: usize, from: usize, count: usize| -> Vec<f64> {
                    let mut random = stream(self.seed(), Purpose::Bootstrap, [set, set], index);
                    let times = multiplicities(&mut random, count)
                        .into_iter()
                        .map(f64::from);
                    let before = std::iter::repeat_n(0.0, from);
                    before
                        .chain(times)
                        .chain(std::iter::repeat_n(0.0, n - from - count))
                        .collect()
                };
                measured(
                    &draw(self.sets[0], 0, n_a),
                    &draw(self.sets[1], n_a, n - n_a),
                )
            })
            .collect();
        let parted = |purpose, sets, from: usize, count: usize, n_first: usize, index| {
            let mut random = stream(self.seed(), purpose, sets, index);
            let is_first = subset(&mut random, count, n_first);
            let weights = |wanted: bool| -> Vec<f64> {
                let inside = is_first
                    .iter()
                    .map(|first| if *first == wanted { 1.0 } else { 0.0 });
                let before = std::iter::repeat_n(0.0, from);
                before
                    .chain(inside)
                    .chain(std::iter::repeat_n(0.0, n - from - count))
                    .collect()
            };
            measured(&weights(true), &weights(false))
        };
        // The unbiased estimate needs two in each half.
        let halves = |set: usize, from: usize, count: usize| -> Vec<f64> {
            if count < 4 {
                return Vec::new();
            }
            (0..self.settings.n_splits)
                .into_par_iter()
                .map(|index| parted(Purpose::Halves, [set, set], from, count, count / 2, index))
                .collect()
        };
        let floors = [
            halves(self.sets[0], 0, n_a),
            halves(self.sets[1], n_a, n - n_a),
        ];
        let relabeled: Vec<f64> = (0..self.settings.n_permutations)
            .into_par_iter()
            .map(|index| parted(Purpose::Permutation, self.sets, 0, n, n_a, index))
            .collect();
        let drawn = drawn
            .into_iter()
            .filter(|value| value.is_finite())
            .collect();
        Estimate::of(
            value * scale,
            drawn,
            floors,
            &relabeled,
            self.settings.confidence,
        )
    }
}

/// MMD² of two weighted parts of one set of vectors. Unbiased: without the pairs of a vector with
/// itself, also where it was drawn twice.
fn weighted_mmd(matrix: &[Vec<f64>], a: &[f64], b: &[f64], is_unbiased: bool) -> f64 {
    let mut inside = [0.0; 2];
    let mut own = [0.0; 2];
    let mut across = 0.0;
    for (i, row) in matrix.iter().enumerate() {
        let (wa, wb) = (
            a.get(i).copied().unwrap_or_default(),
            b.get(i).copied().unwrap_or_default(),
        );
        if wa <= 0.0 && wb <= 0.0 {
            continue;
        }
        let (mut row_a, mut row_b) = (0.0, 0.0);
        for (value, (x, y)) in row.iter().zip(a.iter().zip(b)) {
            row_a += value * x;
            row_b += value * y;
        }
        let diagonal = row.get(i).copied().unwrap_or_default();
        inside[0] += wa * row_a;
        inside[1] += wb * row_b;
        own[0] += wa * wa * diagonal;
        own[1] += wb * wb * diagonal;
        across += wa * row_b;
    }
    let total = |w: &[f64]| w.iter().sum::<f64>();
    let squares = |w: &[f64]| w.iter().map(|w| w * w).sum::<f64>();
    let within = |at: usize, w: &[f64]| {
        let all = total(w) * total(w);
        if is_unbiased {
            (inside[at] - own[at]) / (all - squares(w))
        } else {
            inside[at] / all
        }
    };
    let mmd = within(0, a) + within(1, b) - 2.0 * across / (total(a) * total(b));
    if is_unbiased { mmd } else { mmd.max(0.0) }
}
