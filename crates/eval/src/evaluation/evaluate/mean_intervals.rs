//! mPC and rPC with their intervals: all conditions of a detector with the same draws.

use super::intervals::Drawn;
use super::{EvaluateSettings, Plain};
use crate::EvalError;
use crate::evaluation::robustness::mean_rows;
use crate::evaluation::{
    Condition, Estimate, Evaluation, GroupKind, PairedMetric, RobustnessRow, Scope, ScopeKind,
};
use crate::failure::Where;
use crate::mean_performance::measured_performance;
use crate::resampling::{DrawnMean, DrawnPrecisions, Plan};
use crate::statistic::Measured;

/// Families with severities, and the seeds that all of them have.
#[derive(Debug)]
struct Grid {
    /// In the order of the conditions: place of the cell of family and severity, and of the seed.
    place: Vec<(usize, usize)>,
    n_seeds: usize,
}

impl Grid {
    /// Nothing unless each family and severity has the same seeds, each once.
    fn of(conditions: &[&Condition]) -> Option<Self> {
        let mut cells = Vec::new();
        let mut seeds = Vec::new();
        let mut place: Vec<(usize, usize)> = Vec::new();
        for condition in conditions {
            let cell = (condition.family.as_deref()?, condition.severity?);
            let at = place_of(&mut cells, cell);
            place.push((at, place_of(&mut seeds, condition.seed?)));
        }
        let mut unique = place.clone();
        unique.sort_unstable();
        unique.dedup();
        let is_full = unique.len() == place.len() && place.len() == cells.len() * seeds.len();
        is_full.then_some(Self {
            place,
            n_seeds: seeds.len(),
        })
    }
}

fn place_of<T: PartialEq>(known: &mut Vec<T>, one: T) -> usize {
    let place = known.iter().position(|other| *other == one);
    place.unwrap_or_else(|| {
        known.push(one);
        known.len() - 1
    })
}

/// What mPC and rPC are made from, condition by condition.
#[derive(Debug)]
pub(super) struct GridMeans {
    /// Those with family and severity.
    conditions: Vec<Condition>,
    /// Nothing where there are no intervals.
    grid: Option<Grid>,
    /// Of whole images and of the region, in the order of the conditions.
    drawn: Vec<(Scope, PairedMetric, Vec<DrawnMean>)>,
    /// Of each object whether it is to be found, and in the region under some condition.
    objects: Vec<(bool, bool)>,
    n_taken: usize,
    /// What all conditions share.
    shared: Option<(Plan, EvaluateSettings)>,
}

impl GridMeans {
    pub(super) fn new(conditions: &[Condition]) -> Self {
        let of_grid = conditions.iter().filter(|one| one.is_of_grid());
        let of_grid: Vec<&Condition> = of_grid.collect();
        Self {
            grid: Grid::of(&of_grid).filter(|_| of_grid.len() > 1),
            conditions: of_grid.into_iter().cloned().collect(),
            drawn: Vec::new(),
            objects: Vec::new(),
            n_taken: 0,
            shared: None,
        }
    }

    pub(super) fn take_drawn(
        &mut self,
        condition: &Condition,
        (scope, metric, kind): Drawn<'_>,
        drawn: &DrawnPrecisions,
    ) {
        let is_asked = kind == GroupKind::Class && scope.kind != ScopeKind::OutOfRegion;
        if !is_asked || self.grid.is_none() || !self.conditions.contains(condition) {
            return;
        }
        let known = self.drawn.iter_mut();
        let mut known = known.filter(|(s, m, _)| (s, *m) == (scope, metric));
        match known.next() {
            Some((.., means)) => {
                let mut mean = drawn.mean();
                if let Some(first) = means.first_mut() {
                    first.take_images(&mut mean);
                }
                means.push(mean);
            }
            None => self.drawn.push((scope.clone(), metric, vec![drawn.mean()])),
        }
    }

    pub(super) fn take_objects(&mut self, condition: &Condition, all: &Plain<'_>) {
        if !self.conditions.contains(condition) {
            return;
        }
        let tau = all.settings.tau();
        let coverages = all.labels.objects.iter().zip(&all.coverages.objects);
        let here = coverages.map(|(object, coverage)| {
            let is_inside = Where::Region { tau }.holds(*coverage);
            (object.is_to_be_found(), is_inside)
        });
        self.objects
            .resize(all.labels.objects.len(), (false, false));
        for (known, (is_to_be_found, is_inside)) in self.objects.iter_mut().zip(here) {
            *known = (is_to_be_found, known.1 || is_inside);
        }
        self.n_taken += 1;
        let shared = || (all.plan.clone(), all.settings.clone());
        self.shared.get_or_insert_with(shared);
    }

    /// See [`OverConditions::robustness`](super::OverConditions::robustness).
    pub(super) fn rows(&self, evaluations: &[Evaluation]) -> Result<Vec<RobustnessRow>, EvalError> {
        let Some((plan, settings)) = &self.shared else {
            return Ok(Vec::new());
        };
        if self.n_taken < self.conditions.len() {
            return Ok(Vec::new());
        }
        let n_objects = |scope: &Scope| {
            let is_whole = scope.kind == ScopeKind::WholeImage;
            let objects = self.objects.iter();
            let asked = objects
                .filter(|(is_to_be_found, is_inside)| *is_to_be_found && (is_whole || *is_inside));
            u64::try_from(asked.count()).unwrap_or(u64::MAX)
        };
        let mut rows = mean_rows(evaluations, settings.tau(), &n_objects);
        if let Some(grid) = &self.grid {
            for row in &mut rows {
                self.put_intervals(row, grid, plan)?;
            }
        }
        Ok(rows)
    }

    fn put_intervals(
        &self,
        row: &mut RobustnessRow,
        grid: &Grid,
        plan: &Plan,
    ) -> Result<(), EvalError> {
        let n_seeds = u32::try_from(grid.n_seeds).unwrap_or(u32::MAX);
        row.n_seeds = Some(n_seeds.into());
        let mut drawn = self.drawn.iter();
        let drawn = drawn.find(|(s, m, _)| (s, *m) == (&row.scope, row.metric));
        let Some((.., means)) = drawn.filter(|_| row.mpc.value.is_some()) else {
            return Ok(());
        };
        let cells: Vec<usize> = grid.place.iter().map(|(cell, _)| *cell).collect();
        if means.len() != cells.len() {
            return Ok(());
        }
        // On whole images the clean ones are the same for all conditions.
        let is_clean_one = row.scope.kind == ScopeKind::WholeImage;
        let [of_clean, mpc, rpc] = measured_performance(means, is_clean_one, &cells, plan)?;
        put(&mut row.clean, &of_clean);
        put(&mut row.mpc, &mpc);
        put(&mut row.rpc, &rpc);
        Ok(())
    }
}

/// The interval of the number that is there: both are the same but for the order of sums.
fn put(estimate: &mut Estimate, found: &Measured) {
    let is_same = estimate
        .value
        .zip(found.value)
        .is_some_and(|(one, other)| (one - other).abs() < 1e-9);
    if let Some(interval) = found.interval.as_ref().filter(|_| is_same) {
        (estimate.low, estimate.high) = (Some(interval.low), Some(interval.high));
    }
}
