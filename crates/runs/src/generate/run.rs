//! The run: all images of a plan, over all threads, to a finished set.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use serde_json::json;
use starbreak::Timings;
use starbreak_dataset::{
    BadRecord, CarriedFile, GeneratedSet, Manifest, SetLayout, SourceImage, blake3_file,
};

use super::Plan;
use crate::Error;

/// Something that a run tells as it happens.
#[derive(Debug)]
pub enum Event<'a> {
    /// A sample is done, now or by an earlier run.
    Done,
    /// A sample could not be made.
    Failed(&'a ItemFailure),
}

/// An image that could not be made.
#[derive(Debug)]
pub struct ItemFailure {
    /// Its name in the source.
    pub name: String,
    /// Which sample.
    pub sample_idx: u32,
    /// Why.
    pub error: Error,
}

impl ItemFailure {
    fn new(image: Result<SourceImage, BadRecord>, sample_idx: u32, error: Error) -> Self {
        let name = match image {
            Ok(image) => image.name,
            Err(bad) => bad.image.unwrap_or(bad.place),
        };
        Self {
            name,
            sample_idx,
            error,
        }
    }
}

/// How a run has ended.
#[derive(Debug)]
pub struct GenerateReport {
    /// Samples made.
    pub n_made: u64,
    /// Samples that an earlier run had made.
    pub n_done_before: u64,
    /// Samples with nothing broken in them, of those made.
    pub n_intact: u64,
    /// Samples that could not be made, in the order of the source.
    pub failures: Vec<ItemFailure>,
    /// Records of the source that were left out.
    pub skipped: Vec<BadRecord>,
    /// Samples that were not begun, because the run was stopped.
    pub n_not_begun: u64,
    /// Bytes written for the samples made.
    pub n_bytes: u64,
    /// Time of each stage over all samples made.
    pub timings: Timings,
    /// What the set says of itself, once it is finished.
    pub manifest: Option<Manifest>,
}

/// What the threads count together.
#[derive(Default)]
struct Tally {
    n_made: u64,
    n_done_before: u64,
    n_intact: u64,
    n_bytes: u64,
    timings: Timings,
    /// With the place in the source.
    failures: Vec<(u64, ItemFailure)>,
    /// What no other image would get by either.
    fatal: Option<Error>,
}

/// Makes the set of a plan in the context's folder, or goes on with it.
///
/// Once `stop` is set no further image or other file begins; the same call goes on later. Memory
/// does not grow with the number of images, but for the lists of failures, of bad records and of the
/// files that are carried over.
///
/// # Errors
/// [`Error`] for a folder that cannot be used, for labels that cannot be moved where a lens moves what they name, and for
/// what would fail every image, such as a
/// full disk; what is done stays done. The failure of one image is in the report.
pub fn generate(
    plan: &Plan<'_>,
    stop: &AtomicBool,
    tell: &(dyn Fn(Event<'_>) + Sync),
) -> Result<GenerateReport, Error> {
    let out = &plan.context.out;
    plan.source.refuse_output_at(out)?;
    plan.check_movable()?;
    let n_samples = plan.options.n_samples;
    let set = GeneratedSet::begin(out, n_samples, &plan.identity())?;
    set.put_state("recipe.toml", Some(&plan.context.recipe))?;

    let has_ended = AtomicBool::new(false);
    let is_over = || stop.load(Ordering::Relaxed) || has_ended.load(Ordering::Relaxed);
    // Side by side: threads that do nothing but create small files in one folder wait for each
    // other.
    let (mut tally, carried) = rayon::join(
        || plan.make_all(&set, &has_ended, &is_over, tell),
        || {
            let carried = plan.carry_files(&set, &is_over);
            if carried.as_ref().is_err_and(Error::is_of_the_disk) {
                has_ended.store(true, Ordering::Relaxed);
            }
            carried
        },
    );

    if let Some(error) = tally.fatal {
        return Err(error);
    }
    let carried = match carried {
        Err(error) if error.is_of_the_disk() => return Err(error),
        carried => carried,
    };
    tally.failures.sort_by_key(|(place, _)| *place);
    let failures: Vec<ItemFailure> = tally
        .failures
        .into_iter()
        .map(|(_, failure)| failure)
        .collect();
    let total = plan.survey.n_selected * u64::from(n_samples);
    let n_begun = tally.n_made + tally.n_done_before + failures.len() as u64;
    let mut report = GenerateReport {
        n_made: tally.n_made,
        n_done_before: tally.n_done_before,
        n_intact: tally.n_intact,
        failures,
        skipped: plan.survey.bad.clone(),
        n_not_begun: total.saturating_sub(n_begun),
        n_bytes: tally.n_bytes,
        timings: tally.timings,
        manifest: None,
    };
    put_lists_of_trouble(&set, &report)?;
    if report.n_not_begun == 0 && !is_over() {
        report.manifest = Some(plan.finish(&set, &carried?, &report)?);
    }
    Ok(report)
}

/// Records that are read by all threads before any is written to the list, which is in order.
const N_RECORDS_AT_ONCE: usize = 1024;

/// What became of one sample.
enum Outcome {
    /// It had been made before, from the same file and labels, and is as it was.
    Kept,
    Made {
        n_bytes: u64,
        is_intact: bool,
        timings: Timings,
    },
}

impl Plan<'_> {
    /// Makes each sample, or keeps it, until it `is_over`; what no other would get by either ends it.
    fn make_all(
        &self,
        set: &GeneratedSet,
        has_ended: &AtomicBool,
        is_over: &(dyn Fn() -> bool + Sync),
        tell: &(dyn Fn(Event<'_>) + Sync),
    ) -> Tally {
        let n_samples = self.options.n_samples;
        let tally = Mutex::new(Tally::default());
        let images = (0_u64..).zip(self.survey.selected_or_gone(self.source));
        let jobs = images.flat_map(|(place, image)| {
            let first = place * u64::from(n_samples);
            (0..n_samples).map(move |k| (first + u64::from(k), image.clone(), k))
        });
        jobs.take_while(|_| !is_over())
            .par_bridge()
            .for_each(|(place, image, sample_idx)| {
                if is_over() {
                    return;
                }
                let outcome = match &image {
                    Ok(image) => self.make_or_keep(set, image, sample_idx),
                    Err(bad) => Err(Error::Gone {
                        record: bad.to_string(),
                    }),
                };
                let mut tally = tally.lock().unwrap_or_else(PoisonError::into_inner);
                match outcome {
                    Ok(Outcome::Kept) => tally.n_done_before += 1,
                    Ok(Outcome::Made {
                        n_bytes,
                        is_intact,
                        timings,
                    }) => {
                        tally.n_made += 1;
                        tally.n_bytes += n_bytes;
                        tally.n_intact += u64::from(is_intact);
                        tally.timings.add(&timings);
                    }
                    Err(error) if error.is_of_the_disk() => {
                        has_ended.store(true, Ordering::Relaxed);
                        tally.fatal.get_or_insert(error);
                        return;
                    }
                    Err(error) => {
                        let failure = ItemFailure::new(image, sample_idx, error);
                        tell(Event::Failed(&failure));
                        tally.failures.push((place, failure));
                        let n_failed = tally.failures.len() as u64;
                        if self
                            .options
                            .max_failures
                            .is_some_and(|most| n_failed > most)
                        {
                            has_ended.store(true, Ordering::Relaxed);
                        }
                    }
                }
                tell(Event::Done);
            });

        tally.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tries to make the first sample of these images, and writes nothing. Comes to why each cannot be made; to none where
    /// one can, or is not in the source, or once `stop` is set.
    pub(crate) fn why_none_is_made(
        &self,
        names: &BTreeSet<String>,
        stop: &AtomicBool,
    ) -> Option<Vec<ItemFailure>> {
        let layout = SetLayout::new(&self.context.out, self.options.n_samples);
        let mut failures = Vec::new();
        if names.is_empty() {
            return Some(failures);
        }
        for image in self.survey.selected_or_gone(self.source) {
            let name = match &image {
                Ok(image) => Some(&image.name),
                Err(bad) => bad.image.as_ref(),
            };
            if !name.is_some_and(|name| names.contains(name)) {
                continue;
            }
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            let error = match &image {
                Ok(image) => self
                    .make(image, 0, &layout.files_of(&image.name, 0))
                    .err()?,
                Err(bad) => Error::Gone {
                    record: bad.to_string(),
                },
            };
            failures.push(ItemFailure::new(image, 0, error));
        }
        (failures.len() == names.len()).then_some(failures)
    }

    fn make_or_keep(
        &self,
        set: &GeneratedSet,
        image: &SourceImage,
        sample_idx: u32,
    ) -> Result<Outcome, Error> {
        if let Some(done) = set.done(&image.name, sample_idx)?
            && blake3_file(&image.path)? == done.input_blake3
            && set.layout().is_unaltered(&done)
            && let Ok(objects) = self.objects_of(image)
            && set.layout().has_labels(&image.name, sample_idx, &objects)
        {
            return Ok(Outcome::Kept);
        }
        let files = set.layout().files_of(&image.name, sample_idx);
        let made = self.make(image, sample_idx, &files)?;
        made.put(set, &image.name, sample_idx)?;
        Ok(Outcome::Made {
            n_bytes: made.n_bytes(),
            is_intact: made.is_intact,
            timings: made.timings,
        })
    }

    /// Writes the lists.
    fn finish(
        &self,
        set: &GeneratedSet,
        carried: &[CarriedFile],
        report: &GenerateReport,
    ) -> Result<Manifest, Error> {
        let n_samples = self.options.n_samples;
        let names = self.survey.selected_names(self.source);
        let mut samples = names.flat_map(|name| (0..n_samples).map(move |k| (name.clone(), k)));
        let mut items = std::iter::from_fn(|| {
            let some: Vec<(String, u32)> = samples.by_ref().take(N_RECORDS_AT_ONCE).collect();
            let done = some.par_iter().filter_map(|(name, k)| {
                // An image that failed has no record.
                set.done(name, *k).transpose()
            });
            (!some.is_empty()).then(|| done.collect::<Vec<_>>())
        })
        .flatten();
        let n_taken = self.survey.n_selected * u64::from(n_samples);
        let n_bad = [&report.failures.len(), &report.skipped.len()].map(|n| *n as u64);
        Ok(set.finish(&mut items, carried, n_taken, n_bad)?)
    }
}

/// The lists of what failed and what was left out; none where there is no such thing.
fn put_lists_of_trouble(set: &GeneratedSet, report: &GenerateReport) -> Result<(), Error> {
    let failures: String = report
        .failures
        .iter()
        .map(|failure| {
            let line = json!({
                "name": failure.name,
                "sample": failure.sample_idx,
                "error": failure.error.to_string(),
            });
            format!("{line}\n")
        })
        .collect();
    let skipped: String = report
        .skipped
        .iter()
        .map(|bad| {
            let line = json!({ "place": bad.place, "reason": bad.reason, "image": bad.image });
            format!("{line}\n")
        })
        .collect();
    let lists = [("failures.jsonl", failures), ("skipped.jsonl", skipped)];
    for (name, text) in lists {
        set.put_state(name, Some(text.as_str()).filter(|text| !text.is_empty()))?;
    }
    Ok(())
}
