//! One detector under all its conditions, one after the other.

use super::intervals::Drawn;
use super::mean_intervals::GridMeans;
use super::seeds::SeedSums;
use super::{EvaluateInput, Plain, evaluate_to};
use crate::evaluation::{Condition, Evaluation, OverSeeds, RobustnessRow};
use crate::failure::ObjectPair;
use crate::resampling::DrawnPrecisions;
use crate::{EvalError, compare_pair};

/// Means over the conditions of one detector, which are evaluated one after the other. What a condition's detections are
/// may be dropped then; what stays are two numbers for each draw of the plan, and of several seeds what became of each
/// object.
///
/// Of conditions that differ in nothing but their seed, the sums over the seeds stay until all of them were there.
#[derive(Debug)]
pub struct OverConditions {
    cells: Vec<Cell>,
    grid: GridMeans,
}

/// Conditions that differ in nothing but their seed, two or more.
#[derive(Debug)]
struct Cell {
    conditions: Vec<Condition>,
    n_left: usize,
    sums: SeedSums,
    mean: Option<OverSeeds>,
}

impl OverConditions {
    /// Of these conditions.
    #[must_use]
    pub fn new(conditions: &[Condition]) -> Self {
        let mut cells: Vec<Vec<Condition>> = Vec::new();
        let is_known = |one: &&Condition| one.family.is_some() && one.seed.is_some();
        for condition in conditions.iter().filter(is_known) {
            let key = |one: &Condition| (one.family.clone(), one.severity);
            let is_same = |cell: &&mut Vec<Condition>| {
                cell.first()
                    .is_some_and(|first| key(first) == key(condition))
            };
            match cells.iter_mut().find(is_same) {
                Some(cell) => cell.push(condition.clone()),
                None => cells.push(vec![condition.clone()]),
            }
        }
        let of_seeds = cells.into_iter().filter(|cell| cell.len() > 1);
        Self {
            cells: of_seeds
                .map(|conditions| Cell {
                    n_left: conditions.len(),
                    conditions,
                    sums: SeedSums::default(),
                    mean: None,
                })
                .collect(),
            grid: GridMeans::new(conditions),
        }
    }

    /// All numbers under one of the conditions, by [`compare_pair`] and [`evaluate`](super::evaluate); takes what the
    /// means need. Each condition is to be evaluated once, in their order, with the same labels, clean detections and
    /// settings.
    ///
    /// # Errors
    /// As both.
    pub fn evaluate(&mut self, input: &EvaluateInput<'_>) -> Result<Evaluation, EvalError> {
        let params = &input.settings.compare;
        let compared = compare_pair(
            input.truth,
            input.clean,
            input.cracked,
            input.regions,
            params,
        )?;
        evaluate_to(input, compared, Some(self))
    }

    /// For each family and severity with two seeds or more the mean over its seeds: AP50 and AP75 in the region at
    /// the first τ, out of it and everywhere, and what is lost there. Those of which a condition has not been evaluated
    /// are missing.
    #[must_use]
    pub fn over_seeds(&self) -> Vec<OverSeeds> {
        let cells = self.cells.iter();
        cells.filter_map(|cell| cell.mean.clone()).collect()
    }

    /// mPC and rPC of a detector: of AP, AP50 and AP75, on whole images and in the region at the first τ, over the
    /// families, severities and seeds of the conditions; nothing unless two conditions or more have family and
    /// severity and all of them have been evaluated. Those that lack one, such as a recipe beside presets with
    /// severities, are left aside: they are no part of the grid that is averaged over. `evaluations` are what [`evaluate`](Self::evaluate) gave. The n is
    /// that of the different objects: one that lies in the region of several conditions is one.
    ///
    /// AP50 and AP75 have intervals ([`measured_performance`](crate::measured_performance)). Where not every family and
    /// severity has the same seeds, there is no interval.
    ///
    /// # Errors
    /// As [`measured_performance`](crate::measured_performance).
    pub fn robustness(&self, evaluations: &[Evaluation]) -> Result<Vec<RobustnessRow>, EvalError> {
        self.grid.rows(evaluations)
    }

    pub(super) fn take_drawn(
        &mut self,
        condition: &Condition,
        of: Drawn<'_>,
        drawn: DrawnPrecisions,
    ) -> Result<(), EvalError> {
        self.grid.take_drawn(condition, of, &drawn);
        match self.cell_of(condition) {
            Some(cell) => cell.sums.add_drawn(of, drawn),
            None => Ok(()),
        }
    }

    /// What is left of a condition, after its draws.
    pub(super) fn take_pairs(
        &mut self,
        input: &EvaluateInput<'_>,
        all: &Plain<'_>,
        pairs: &[ObjectPair],
        has_regions: bool,
    ) -> Result<(), EvalError> {
        self.grid.take_objects(input.condition, all);
        let Some(cell) = self.cell_of(input.condition) else {
            return Ok(());
        };
        cell.sums
            .add_pairs(input.condition.seed, pairs, has_regions);
        cell.n_left = cell.n_left.saturating_sub(1);
        if let (0, Some(first)) = (cell.n_left, cell.conditions.first()) {
            let sums = std::mem::take(&mut cell.sums);
            cell.mean = Some(sums.mean(input.detector, first, all)?);
        }
        Ok(())
    }

    fn cell_of(&mut self, condition: &Condition) -> Option<&mut Cell> {
        let mut cells = self.cells.iter_mut();
        cells.find(|cell| cell.conditions.contains(condition))
    }
}
