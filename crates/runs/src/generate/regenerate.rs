//! Images of a set, made again from source, recipe and seed, and compared with what is there.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use serde_json::Value;
use starbreak_dataset::{
    Carry, Finding, ImageLimits, ItemRecord, SetChecker, Source, SourceImage, read_image,
};

use super::{GenerateOptions, Plan, Selection, Shard, set_seed_and_recipe, survey};
use crate::RunContext;
use crate::{Error, Patterns};

/// What a comparison has found.
#[derive(Debug, Default)]
pub struct RegenerateReport {
    /// Samples that were made again.
    pub n_made: u64,
    /// Of those, samples of which every file has the same bytes.
    pub n_same_bytes: u64,
    /// Of the others, samples whose image still has the same pixels.
    pub n_same_pixels: u64,
    /// What differs.
    pub findings: Vec<Finding>,
    /// Whether it was stopped before its end.
    pub was_stopped: bool,
}

/// Makes `n` evenly spread samples of a finished set again, or all of them, and compares them with
/// the hashes of its list; where these differ, with the pixels on the disk. An image may take so much
/// memory, bytes.
///
/// # Errors
/// [`Error::Dataset`] where there is no finished set, or where the source or the patterns are not
/// those that the set was made from, and what the recipe and the source say.
pub fn regenerate(
    root: &Path,
    source: &Source,
    patterns: &Patterns,
    (n, max_memory_bytes): (Option<u64>, u64),
    stop: &AtomicBool,
    tell: &(dyn Fn() + Sync),
) -> Result<RegenerateReport, Error> {
    let checker = SetChecker::open(root)?;
    let identity = checker.identity();
    let (seed, mut recipe) = set_seed_and_recipe(identity)?;
    recipe.set_max_memory(max_memory_bytes);
    let context = RunContext::new(&recipe, seed, root)?;
    let options = options_of(identity);
    let survey = survey(source, options.selection, seed);
    let plan = Plan {
        source,
        context: &context,
        patterns,
        options: &options,
        survey: &survey,
    };
    starbreak_dataset::compare_identity(root, identity, &plan.identity())?;

    let total = checker.manifest().n_items;
    let wanted = n.unwrap_or(total).min(total);
    // The k-th of `wanted` among `total`, evenly spread.
    let is_wanted = |idx: u64| (idx + 1) * wanted / total.max(1) > idx * wanted / total.max(1);
    let report = Mutex::new(RegenerateReport::default());
    let mut images = survey.selected(source).peekable();
    let pairs = (0..).zip(checker.items()?).filter_map(|(idx, item)| {
        let item = match item {
            Ok(item) => item,
            Err(error) => return Some(Err(error)),
        };
        // Both go by name; an image that had failed is in the source only.
        while images.next_if(|image| image.name < item.name).is_some() {}
        let image = images.peek().filter(|image| image.name == item.name);
        is_wanted(idx).then(|| Ok((item, image.cloned())))
    });
    let pairs = pairs.take_while(|_| !stop.load(Ordering::Relaxed));
    pairs
        .par_bridge()
        .try_for_each(|pair| -> Result<(), Error> {
            let (item, image) = pair?;
            let outcome = plan.compare(&checker, &item, image.as_ref());
            let mut report = report.lock().unwrap_or_else(PoisonError::into_inner);
            report.n_made += 1;
            match outcome {
                Ok(()) => report.n_same_bytes += 1,
                Err(difference) => {
                    report.n_same_pixels += u64::from(difference.has_same_pixels);
                    report.findings.push(difference.finding);
                }
            }
            tell();
            Ok(())
        })?;
    let mut report = report.into_inner().unwrap_or_else(PoisonError::into_inner);
    report.findings.sort();
    report.was_stopped = stop.load(Ordering::Relaxed);
    Ok(report)
}

/// How a set was made, by its identity.
fn options_of(identity: &Value) -> GenerateOptions {
    let selection = &identity["selection"];
    let shard = &identity["shard"];
    let number = |value: &Value| value.as_u64().and_then(|n| u32::try_from(n).ok());
    GenerateOptions {
        n_samples: number(&identity["samples"]).unwrap_or(1),
        selection: Selection {
            limit: selection["limit"].as_u64(),
            sample: selection["sample"].as_u64(),
            shard: number(&shard["number"])
                .zip(number(&shard["of"]))
                .map(|(number, of)| Shard { number, of }),
        },
        other_files: match identity["other_files"].as_str() {
            Some("copy") => Some(Carry::Copy),
            Some("hard-link") => Some(Carry::HardLink),
            _ => None,
        },
        max_failures: None,
    }
}

/// How a sample differs from what the list says.
struct Difference {
    finding: Finding,
    has_same_pixels: bool,
}

impl Plan<'_> {
    fn compare(
        &self,
        checker: &SetChecker,
        item: &ItemRecord,
        image: Option<&SourceImage>,
    ) -> Result<(), Difference> {
        let files = checker.layout().files_of(&item.name, item.sample);
        let differs = |what: String, has_same_pixels| Difference {
            finding: Finding {
                name: files.image.clone(),
                what,
                is_foreign: false,
            },
            has_same_pixels,
        };
        let Some(image) = image else {
            return Err(differs("is not in the source".to_owned(), false));
        };
        let made = self
            .make(image, item.sample, &files)
            .map_err(|error| differs(format!("cannot be made again: {error}"), false))?;
        let again = made.line(&item.name, item.sample);
        let same = [
            ("image", again.image_blake3 == item.image_blake3),
            ("region mask", again.region_blake3 == item.region_blake3),
            ("crack mask", again.crack_blake3 == item.crack_blake3),
            ("record", again.provenance_blake3 == item.provenance_blake3),
        ];
        let other: Vec<&str> = same
            .iter()
            .filter(|(_, is_same)| !is_same)
            .map(|(what, _)| *what)
            .collect();
        if other.is_empty() {
            return Ok(());
        }
        let stored = read_image(
            &checker.layout().path(&files.image),
            &ImageLimits::default(),
        );
        let again =
            starbreak_dataset::decode_image(&files.image, &made.image, &ImageLimits::default());
        let has_same_pixels = match (stored, again) {
            (Ok(stored), Ok(again)) => stored.pixels == again.pixels,
            _ => false,
        };
        let pixels = if has_same_pixels {
            "the image's pixels are the same"
        } else {
            "the image's pixels differ"
        };
        let what = format!("comes out otherwise now: {} ({pixels})", other.join(", "));
        Err(differs(what, has_same_pixels))
    }
}
