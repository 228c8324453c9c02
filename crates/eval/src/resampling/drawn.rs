//! Average precisions under every draw of a plan, from which those of several sets of images are combined.

use std::collections::BTreeSet;
use std::ops::Range;

use rayon::prelude::*;

use super::draws::Draw;
use super::paired::{PairedPrecision, PairedPrecisions};
use super::permutation::permuted_draws;
use super::ranked::{N_SIDE_BY_SIDE, Ranked, RankedCategory, SideBySide, rank_run};
use super::{Basis, Permuted, Plan, Replicates};
use crate::EvalError;
use crate::matching::ImageMatches;
use crate::statistic::Method;

/// Average precision of clean and cracked images, of each category and in their mean, under every draw of a plan.
///
/// All sets of cracked images have the same draws, and what is said of several sets is, under each draw, a mean over
/// the sets of one value of each. So sets are matched, and their boxes dropped, one after the other; what stays of
/// them are two numbers for each draw and category, and the numbers of the images that have objects.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnPrecisions {
    /// By the place of the draw: clean and cracked of each category, and behind them of the mean over those that have
    /// objects. NaN where undefined. Of several sets the sums.
    rows: Vec<Vec<[f64; 2]>>,
    n_sets: u32,
    /// In the order of the values.
    categories: Vec<CategoryObjects>,
}

/// The objects of a category.
#[derive(Debug, Clone, PartialEq)]
struct CategoryObjects {
    category: u32,
    /// How many of them are to be found, in each set.
    by_set: Vec<u64>,
    /// Images that have some, in some set.
    images: BTreeSet<u32>,
}

/// What is ranked of one set, by category.
pub(super) struct Sides<R> {
    /// Over the images.
    pub(super) clean: Vec<R>,
    /// Over the images.
    pub(super) cracked: Vec<R>,
    /// Over cells, image times 2, plus 1 for the cracked one.
    pub(super) both: Vec<R>,
}

impl Sides<RankedCategory> {
    /// Of no category yet, if the plan can be carried out.
    fn under(plan: &Plan) -> Result<Self, EvalError> {
        plan.check()?;
        Ok(Self {
            clean: Vec::new(),
            cracked: Vec::new(),
            both: Vec::new(),
        })
    }

    /// Takes the next categories, all of whose matches are given.
    fn rank(
        &mut self,
        versions: [&[ImageMatches]; 2],
        categories: Range<usize>,
        plan: &Plan,
    ) -> Result<(), EvalError> {
        check_images(&versions, plan)?;
        let [clean, cracked] = versions;
        self.clean.extend(rank_run(&[clean], categories.clone()));
        self.cracked
            .extend(rank_run(&[cracked], categories.clone()));
        self.both.extend(rank_run(&versions, categories));
        Ok(())
    }
}

impl<R: Ranked> Sides<R> {
    /// Clean and cracked of each category, and of their mean, under draws of one kind: one row for each.
    fn rows(&self, plan: &Plan, places: Range<usize>) -> Vec<Vec<[f64; 2]>> {
        let mut rows = vec![Vec::with_capacity(self.clean.len() + 1); places.len()];
        let (mut as_clean, mut as_cracked) = (SideBySide::default(), SideBySide::default());
        let is_exchange = places.start >= plan.unexchanged_draw();
        for (draw, place) in places.enumerate() {
            match plan.draw(place) {
                Draw::Weights(weights) => as_clean.put(draw, &weights),
                Draw::Swaps(swaps) => {
                    let (clean, cracked) = role_weights(&swaps);
                    as_clean.put(draw, &clean);
                    as_cracked.put(draw, &cracked);
                }
            }
        }
        let (clean, cracked, as_cracked) = match is_exchange {
            true => (&self.both, &self.both, &as_cracked),
            false => (&self.clean, &self.cracked, &as_clean),
        };
        for (clean, cracked) in clean.iter().zip(cracked) {
            let clean = clean.average_precisions(&as_clean);
            let cracked = cracked.average_precisions(as_cracked);
            for (row, pair) in rows.iter_mut().zip(clean.into_iter().zip(cracked)) {
                let pair = pair.0.zip(pair.1);
                row.push(pair.map_or([f64::NAN; 2], <[f64; 2]>::from));
            }
        }
        for row in &mut rows {
            row.push(mean_of_categories(row));
        }
        rows
    }
}

/// Values per category in the bootstrap: clean, cracked, difference.
const N_VALUES: usize = 3;

impl DrawnPrecisions {
    /// Of one set of cracked images, from the matches of the clean images and of the cracked ones by the same rule.
    ///
    /// # Errors
    /// If an image is beyond those of the plan, or the plan has no replicates or no proper level.
    pub fn of_matches(
        clean: &[ImageMatches],
        cracked: &[ImageMatches],
        n_categories: usize,
        plan: &Plan,
    ) -> Result<Self, EvalError> {
        let mut sides = Sides::under(plan)?;
        sides.rank([clean, cracked], 0..n_categories, plan)?;
        Ok(Self::of(&sides, plan))
    }

    /// The same of categories in runs, whose matches, clean and cracked, are there one run after the other.
    ///
    /// # Errors
    /// As [`DrawnPrecisions::of_matches`], and those of the matches.
    pub(crate) fn of_runs(
        runs: Vec<Range<usize>>,
        plan: &Plan,
        mut matches: impl FnMut(&Range<usize>) -> Result<[Vec<ImageMatches>; 2], EvalError>,
    ) -> Result<Self, EvalError> {
        let mut sides = Sides::under(plan)?;
        for run in runs {
            let [clean, cracked] = matches(&run)?;
            sides.rank([&clean, &cracked], run, plan)?;
        }
        Ok(Self::of(&sides, plan))
    }

    /// The same of anything that has an average precision.
    pub(super) fn of<R: Ranked>(sides: &Sides<R>, plan: &Plan) -> Self {
        // Draws of weights come first, then those of swaps.
        let groups = |places: Range<usize>| {
            let end = places.end;
            let firsts = places.step_by(N_SIDE_BY_SIDE);
            firsts.map(move |first| first..end.min(first + N_SIDE_BY_SIDE))
        };
        let weights = groups(0..plan.unexchanged_draw());
        let swaps = groups(plan.unexchanged_draw()..plan.n_draws());
        let groups: Vec<Range<usize>> = weights.chain(swaps).collect();
        let rows = groups.into_par_iter();
        let rows = rows.map(|places| sides.rows(plan, places));
        let categories = sides.clean.iter().map(|ranked| CategoryObjects {
            category: ranked.category(),
            by_set: vec![ranked.objects().iter().map(|(_, n)| u64::from(*n)).sum()],
            images: ranked.objects().iter().map(|(image, _)| *image).collect(),
        });
        Self {
            rows: rows.flatten_iter().collect(),
            n_sets: 1,
            categories: categories.collect(),
        }
    }

    /// Takes another set of cracked images to it, of the same categories under the same plan. A value that is undefined
    /// of one set is undefined of all together.
    ///
    /// # Errors
    /// [`EvalError::StatisticLength`] for a set of other categories or another number of draws.
    pub fn add(&mut self, other: &Self) -> Result<(), EvalError> {
        let n_draws = [other.rows.len(), self.rows.len()];
        check_length("draws of a set", n_draws, "draws of the sets before")?;
        let n_categories = [other.categories.len(), self.categories.len()];
        check_length("categories", n_categories, "categories of the sets before")?;
        for (sums, values) in self.rows.iter_mut().zip(&other.rows) {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum = [sum[0] + value[0], sum[1] + value[1]];
            }
        }
        self.n_sets += other.n_sets;
        for (all, one) in self.categories.iter_mut().zip(&other.categories) {
            all.by_set.extend(&one.by_set);
            all.images.extend(&one.images);
        }
        Ok(())
    }

    /// Objects to be found in each set, and images that have some of them in some set: of a category, or of all.
    pub(crate) fn objects(&self, category: Option<u32>) -> (Vec<u64>, usize) {
        let is_asked = |one: &&CategoryObjects| category.is_none_or(|it| it == one.category);
        let mut by_set = vec![0; self.n_sets as usize];
        let mut images: BTreeSet<u32> = BTreeSet::new();
        for one in self.categories.iter().filter(is_asked) {
            for (sum, n) in by_set.iter_mut().zip(&one.by_set) {
                *sum += n;
            }
            images.extend(&one.images);
        }
        (by_set, images.len())
    }

    /// The mean over categories alone.
    #[must_use]
    pub fn mean(&self) -> DrawnMean {
        let n_sets = f64::from(self.n_sets);
        let mean = |row: &Vec<[f64; 2]>| {
            row.last()
                .map_or([f64::NAN; 2], |it| it.map(|sum| sum / n_sets))
        };
        DrawnMean {
            rows: self.rows.iter().map(mean).collect(),
            images: self
                .categories
                .iter()
                .map(|one| one.images.clone())
                .collect(),
        }
    }

    /// All that is known about them, as [`paired_average_precision`](super::paired_average_precision) says it.
    ///
    /// # Errors
    /// [`EvalError::StatisticLength`] for a plan with another number of draws than that by which it was drawn.
    pub fn measured(&self, plan: &Plan) -> Result<PairedPrecisions, EvalError> {
        check_length(
            "draws",
            [self.rows.len(), plan.n_draws()],
            "draws of the plan",
        )?;
        let replicates = Replicates::of_draws(plan, |draw| {
            self.pairs(draw).flat_map(three_values).collect()
        });
        let difference = |pair: Option<[f64; 2]>| pair.map(|[clean, cracked]| cracked - clean);
        let tests = permuted_draws(plan, |draw| self.pairs(draw).map(difference).collect());
        let images = self.categories.iter().map(|one| &one.images);
        let n_units: Vec<u32> = images.map(|it| plan.units_of(it.iter().copied())).collect();
        let mut rows = Vec::with_capacity(tests.len());
        for (at, test) in tests.into_iter().enumerate() {
            let category = self.categories.get(at).map(|one| one.category);
            let side = match n_units.get(at) {
                Some(n) => Basis::Units(*n),
                None => Basis::of_classes(&n_units, plan),
            };
            rows.push(row(&replicates, at, category, side, test));
        }
        let mean = rows.pop().ok_or(EvalError::StatisticLength {
            what: "rankings",
            found: 0,
            expected: 1,
            of: "seeds",
        })?;
        Ok(PairedPrecisions {
            categories: rows,
            mean,
            n_replicates: plan.n_replicates,
            seed: plan.seed,
        })
    }

    /// Clean and cracked under a draw, of each category and of their mean.
    fn pairs(&self, draw: usize) -> impl Iterator<Item = Option<[f64; 2]>> {
        let n_sets = f64::from(self.n_sets);
        let row = self.rows.get(draw).map_or(&[][..], Vec::as_slice);
        row.iter()
            .map(move |sums| defined(sums.map(|sum| sum / n_sets)))
    }
}

/// The mean over categories of the average precision of clean and cracked images, under every draw of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnMean {
    /// By the place of the draw: clean and cracked; NaN where undefined.
    rows: Vec<[f64; 2]>,
    /// By category, images that have objects of it.
    images: Vec<BTreeSet<u32>>,
}

impl DrawnMean {
    /// Clean and cracked under a draw, by its place among all of the plan.
    pub(crate) fn pair(&self, draw: usize) -> Option<[f64; 2]> {
        defined(*self.rows.get(draw)?)
    }

    /// Takes the images of another set, for [`DrawnMean::basis`] asks for those of all sets together.
    pub(crate) fn take_images(&mut self, other: &mut Self) {
        let images = std::mem::take(&mut other.images);
        for (all, one) in self.images.iter_mut().zip(images) {
            all.extend(one);
        }
    }

    /// What the mean of several sets rests on, on each side.
    pub(crate) fn basis(sets: &[Self], plan: &Plan) -> Basis {
        let n_categories = sets.iter().map(|set| set.images.len()).max();
        let n_units = |at: usize| {
            let of_category = sets.iter().filter_map(|set| set.images.get(at));
            plan.units_of(of_category.flatten().copied())
        };
        let n_units: Vec<u32> = (0..n_categories.unwrap_or(0)).map(n_units).collect();
        Basis::of_classes(&n_units, plan)
    }
}

fn check_length(
    what: &'static str,
    [found, expected]: [usize; 2],
    of: &'static str,
) -> Result<(), EvalError> {
    match found == expected {
        true => Ok(()),
        false => Err(EvalError::StatisticLength {
            what,
            found,
            expected,
            of,
        }),
    }
}

fn defined(pair: [f64; 2]) -> Option<[f64; 2]> {
    (!pair[0].is_nan() && !pair[1].is_nan()).then_some(pair)
}

/// The mean over the categories that there are.
fn mean_of_categories(row: &[[f64; 2]]) -> [f64; 2] {
    let (mut sum, mut n) = ([0.0, 0.0], 0.0);
    for [clean, cracked] in row.iter().filter_map(|pair| defined(*pair)) {
        sum = [sum[0] + clean, sum[1] + cracked];
        n += 1.0;
    }
    sum.map(|sum| sum / n)
}

fn three_values(pair: Option<[f64; 2]>) -> [Option<f64>; N_VALUES] {
    let Some([clean, cracked]) = pair else {
        return [None; N_VALUES];
    };
    [Some(clean), Some(cracked), Some(cracked - clean)]
}

fn row(
    replicates: &Replicates,
    at: usize,
    category: Option<u32>,
    side: Basis,
    Permuted { test, interval }: Permuted,
) -> PairedPrecision {
    let place = at * N_VALUES;
    PairedPrecision {
        category,
        clean: replicates.expanded(place, Method::AveragePrecision, side),
        cracked: replicates.expanded(place + 1, Method::AveragePrecision, side),
        difference: replicates.with_interval(place + 2, Method::Difference, side, interval),
        test,
    }
}

/// Weights of the cells that play the clean and the cracked images.
fn role_weights(swaps: &[u32]) -> (Vec<u32>, Vec<u32>) {
    swaps
        .iter()
        .flat_map(|swap| [(1 - swap, *swap), (*swap, 1 - swap)])
        .unzip()
}

/// Refuses images that the plan does not have, and more than cells can be counted.
fn check_images(sides: &[&[ImageMatches]], plan: &Plan) -> Result<(), EvalError> {
    let images = sides.iter().copied().flatten().map(|it| it.image);
    let n_needed = images.max().map_or(0, |image| image as usize + 1);
    if n_needed > plan.n_images() {
        return Err(EvalError::StatisticLength {
            what: "images with matches",
            found: n_needed,
            expected: plan.n_images(),
            of: "images of the plan",
        });
    }
    // Two cells per image must fit 32 bits.
    if plan.n_images() >= 1 << 31 {
        return Err(EvalError::StatisticSetting {
            what: "number of images",
            value: plan.n_images() as f64,
            range: "below 2^31",
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
