//! mPC and rPC with their intervals: all conditions of a detector with the same draws.

use super::intervals::{Place, coverage_of, max_detections};
use super::plan_of;
use super::seeds::{CrackedSet, Patterns, SeedsInput, patterns_of};
use crate::evaluation::robustness::mean_rows;
use crate::evaluation::{
    Condition, Estimate, Evaluation, PairedMetric, RobustnessRow, Scope, ScopeKind,
};
use crate::failure::Where;
use crate::resampling::{Basis, RankedCategory, bootstrap, rank_by_category, units_of_classes};
use crate::statistic::{Measured, Method};
use crate::{Coverages, Detections, EvalError, Object};

/// Families with severities, and the seeds that all of them have.
struct Grid {
    /// In the order of the conditions: place of the cell of family and severity, and of the seed.
    place: Vec<(usize, usize)>,
    n_cells: usize,
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
            n_cells: cells.len(),
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
/// AP50 and AP75 have intervals. Each replicate draws images (or clusters) once for all conditions, and averages as mPC
/// is averaged; rPC is of the same replicate. Where not every family and severity has the same seeds, there is no
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
        for (_, found, coverages) in &patterns.cracked {
            // On whole images the clean ones are the same for all conditions.
            if !is_whole || clean.is_empty() {
                let coverage = coverage_of(coverages, 0);
                let matches = place.matches(&patterns.labels, &patterns.clean, coverage)?;
                clean.push(rank_by_category(&matches, n_categories));
            }
            let coverage = coverage_of(coverages, 1);
            let matches = place.matches(&patterns.labels, found, coverage)?;
            cracked.push(rank_by_category(&matches, n_categories));
        }
        let replicates = bootstrap(&plan, |weights| {
            let ap = |sets: &[Vec<RankedCategory>]| -> Vec<Option<f64>> {
                let of_set = |set: &Vec<RankedCategory>| mean_precision(set, weights);
                sets.iter().map(of_set).collect()
            };
            let of_clean = match ap(&clean).as_slice() {
                [alone] if is_whole => *alone,
                all => mean_of_cells(grid, all),
            };
            let of_cracked = mean_of_cells(grid, &ap(&cracked));
            let ratio = of_cracked
                .zip(of_clean.filter(|clean| *clean > 0.0))
                .map(|(cracked, clean)| cracked / clean);
            vec![of_clean, of_cracked, ratio]
        })?;
        // As of one condition: either side leans with the few images of a class, their ratio does not.
        let units = units_of_classes(n_categories, &plan, |at| {
            let of_class = clean.iter().filter_map(move |set| set.get(at));
            of_class.flat_map(RankedCategory::cells_with_objects)
        });
        let side = Basis::of_classes(&units, &plan);
        let ap = Method::AveragePrecision;
        put(&mut row.clean, &replicates.expanded(0, ap, side));
        put(&mut row.mpc, &replicates.expanded(1, ap, side));
        let whole = Basis::Units(plan.n_units());
        put(&mut row.rpc, &replicates.expanded(2, Method::Ratio, whole));
    }
    Ok(())
}

/// Mean over the categories with objects.
fn mean_precision(set: &[RankedCategory], weights: &[u32]) -> Option<f64> {
    let (mut sum, mut n) = (0.0, 0_u32);
    for ap in set.iter().filter_map(|one| one.average_precision(weights)) {
        sum += ap;
        n += 1;
    }
    (n > 0).then(|| sum / f64::from(n))
}

/// Mean over cells of the mean over seeds; nothing where a value is missing.
fn mean_of_cells(grid: &Grid, values: &[Option<f64>]) -> Option<f64> {
    let mut cells = vec![(0.0_f64, 0.0_f64); grid.n_cells];
    for ((cell, _), value) in grid.place.iter().zip(values) {
        let cell = cells.get_mut(*cell)?;
        *cell = (cell.0 + (*value)?, cell.1 + 1.0);
    }
    let n = f64::from(u32::try_from(grid.n_cells).ok()?);
    Some(cells.iter().map(|(sum, n)| sum / n).sum::<f64>() / n)
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
