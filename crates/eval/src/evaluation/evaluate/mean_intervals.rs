//! mPC and rPC with their intervals: all conditions of a detector with the same draws.

use super::intervals::{Place, coverage_of, max_detections};
use super::plan_of;
use super::seeds::{CrackedSet, Patterns, SeedsInput, patterns_of};
use crate::evaluation::robustness::mean_rows;
use crate::evaluation::{
    Condition, Estimate, Evaluation, PairedMetric, RobustnessRow, Scope, ScopeKind,
};
use crate::failure::Where;
use crate::mean_performance::measured_performance;
use crate::resampling::{RankedCategory, rank_by_category, rank_versions};
use crate::statistic::Measured;
use crate::{Coverages, Detections, EvalError, Object};

/// Families with severities, and the seeds that all of them have.
struct Grid {
    /// In the order of the conditions: place of the cell of family and severity, and of the seed.
    place: Vec<(usize, usize)>,
    n_seeds: usize,
}

impl Grid {
    /// Nothing unless each family and severity has the same seeds, each once.
    fn of(sets: &[&CrackedSet<'_>]) -> Option<Self> {
        let mut cells = Vec::new();
        let mut seeds = Vec::new();
        let mut place: Vec<(usize, usize)> = Vec::new();
        for set in sets {
            let condition = set.condition;
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

/// mPC and rPC of a detector: of AP, AP50 and AP75, on whole images and in the region at the first τ, over the
/// families, severities and seeds of the conditions; nothing unless two conditions or more have family and
/// severity. Those that have not, such as a recipe beside presets with severities, are left aside: they are
/// no part of the grid that is averaged over. `evaluations` are what [`evaluate`](super::evaluate) gives for them. The n is
/// that of the different objects: one that lies in the region of several conditions is one.
///
/// AP50 and AP75 have intervals ([`measured_performance`]). Where not every family and severity has the same seeds, there is no
/// interval.
///
/// # Errors
/// As [`crate::evaluation::evaluate`].
pub fn robustness(
    evaluations: &[Evaluation],
    input: &SeedsInput<'_>,
) -> Result<Vec<RobustnessRow>, EvalError> {
    let of_grid: Vec<&CrackedSet<'_>> = input
        .cracked
        .iter()
        .filter(|set| set.condition.is_of_grid())
        .collect();
    let Some(patterns) = patterns_of(input, &of_grid) else {
        return Ok(Vec::new());
    };
    let n_objects = |scope: &Scope| n_different_objects(&patterns, scope);
    let mut rows = mean_rows(evaluations, input.settings.tau(), &n_objects);
    if let Some(grid) = Grid::of(&of_grid) {
        put_intervals(&mut rows, &grid, &patterns, input)?;
    }
    Ok(rows)
}

/// Objects that are to be found in a place under some condition.
fn n_different_objects(patterns: &Patterns<'_>, scope: &Scope) -> u64 {
    let place = match (scope.kind, scope.tau) {
        (ScopeKind::InRegion, Some(tau)) => Where::Region { tau },
        _ => Where::Image,
    };
    let is_asked_for = |(idx, object): &(usize, &Object)| {
        let mut conditions = patterns.cracked.iter();
        let is_inside = |(_, _, coverages): &(&Condition, Detections, Coverages)| {
            let coverage = coverages.objects.get(*idx).copied();
            coverage.is_some_and(|coverage| place.holds(coverage))
        };
        object.is_to_be_found() && conditions.any(is_inside)
    };
    let objects = patterns.labels.objects.iter().enumerate();
    u64::try_from(objects.filter(is_asked_for).count()).unwrap_or(u64::MAX)
}

fn put_intervals(
    rows: &mut [RobustnessRow],
    grid: &Grid,
    patterns: &Patterns<'_>,
    input: &SeedsInput<'_>,
) -> Result<(), EvalError> {
    let n_seeds = u32::try_from(grid.n_seeds).unwrap_or(u32::MAX);
    let plan = plan_of(&patterns.labels, input.settings);
    let n_categories = patterns.labels.categories.len();
    let cells: Vec<usize> = grid.place.iter().map(|(cell, _)| *cell).collect();
    for row in rows {
        row.n_seeds = Some(n_seeds.into());
        let iou_threshold = match row.metric {
            PairedMetric::Ap50 => 0.5,
            PairedMetric::Ap75 => 0.75,
            _ => continue,
        };
        if row.mpc.value.is_none() {
            continue;
        }
        let place = Place {
            scope: &row.scope,
            iou_threshold,
            max_detections: max_detections(input.settings),
        };
        let is_whole = row.scope.kind == ScopeKind::WholeImage;
        let mut clean: Vec<Vec<RankedCategory>> = Vec::new();
        let mut cracked: Vec<Vec<RankedCategory>> = Vec::new();
        let mut both: Vec<Vec<RankedCategory>> = Vec::new();
        let mut of_clean = Vec::new();
        for (_, found, coverages) in &patterns.cracked {
            // On whole images the clean ones are the same for all conditions.
            if !is_whole || clean.is_empty() {
                let coverage = coverage_of(coverages, 0);
                of_clean = place.matches(&patterns.labels, &patterns.clean, coverage)?;
                clean.push(rank_by_category(&of_clean, n_categories));
            }
            let coverage = coverage_of(coverages, 1);
            let matches = place.matches(&patterns.labels, found, coverage)?;
            cracked.push(rank_by_category(&matches, n_categories));
            both.push(rank_versions(&[&of_clean, &matches], n_categories));
        }
        let [of_clean, mpc, rpc] = measured_performance(&clean, &cracked, &both, &cells, &plan)?;
        put(&mut row.clean, &of_clean);
        put(&mut row.mpc, &mpc);
        put(&mut row.rpc, &rpc);
    }
    Ok(())
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
