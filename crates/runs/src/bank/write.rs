//! Patterns into a bank.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;
use starbreak::{FractureSettings, Settings, simulate};
use starbreak_dataset::{BankRecord, BankWriter, OutputBatch, WrittenBank, refuse_inside_set};
use starbreak_glass::Generator;

use super::PatternRow;
use super::baked::bake_record;
use super::header::{BANK_SCHEMA, BankHeader, BankKind};
use super::network_record::network_to_bytes;
use crate::{Error, RunContext};

/// Patterns that are made before they are written: enough to keep many threads busy, and few in
/// memory.
const AT_ONCE: usize = 256;

/// What came of making a bank.
#[derive(Debug, Clone, PartialEq)]
pub struct BankReport {
    /// What its patterns were made from.
    pub header: BankHeader,
    /// Key figures of each pattern, in order.
    pub rows: Vec<PatternRow>,
    /// SHA-256 that identifies the bank.
    pub sha256: String,
    /// Length of the file, in bytes.
    pub n_bytes: u64,
}

/// A whole bank under a temporary name.
#[derive(Debug)]
pub struct BankDraft {
    /// What came of making it.
    pub report: BankReport,
    written: WrittenBank,
}

impl BankDraft {
    /// Gives the bank its name, after some files that belong to it: path and bytes of each.
    /// A draft that is dropped instead leaves nothing.
    ///
    /// # Errors
    /// [`Error::Dataset`] where the file system refuses.
    pub fn commit(self, beside: &[(PathBuf, Vec<u8>)]) -> Result<BankReport, Error> {
        self.written.commit(beside)?;
        Ok(self.report)
    }
}

/// Makes a bank of `n` patterns for frames of some sizes, px, to be at the path `to`.
///
/// Pattern k is simulated for the first size, by the recipe and its own seed, and baked for each;
/// the bytes depend on neither the number of threads nor, but for the index at their end, on `n`.
/// `progress` is called with the number of patterns that are made, in any order of threads. In
/// memory there are at most 256 patterns and a row for each.
///
/// # Errors
/// [`Error::NothingBreaks`] for a recipe without broken glass. [`Error::Interrupted`] once `stop` is set: there is no half a bank. [`Error::OfPattern`] for a
/// pattern that cannot be made, [`Error::Dataset`] for a path in a generated set, and where the file
/// system refuses.
pub fn write_bank(
    context: &RunContext,
    n: usize,
    sizes: &[(u32, u32)],
    to: &Path,
    stop: &AtomicBool,
    progress: impl Fn(usize) + Sync,
) -> Result<BankDraft, Error> {
    refuse_inside_set(to)?;
    if matches!(context.settings.fracture, FractureSettings::None(_)) {
        let way_out = if context.settings.drops.is_some() {
            "a bank keeps [drops] only together with cracks, so make it by a preset that breaks glass and --set its drops.…, \
             or generate without a bank"
        } else {
            "coats and faults of the camera are made anew for each image anyway, and generate --bank takes them with --set"
        };
        return Err(Error::NothingBreaks { way_out });
    }
    let mut distinct: Vec<(u32, u32)> = Vec::new();
    for size in sizes {
        if !distinct.contains(size) {
            distinct.push(*size);
        }
    }
    let header = BankHeader {
        schema: BANK_SCHEMA.to_owned(),
        generator: Generator {
            name: "starbreak".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        },
        kind: BankKind::Simulated,
        recipe: context.recipe.clone(),
        recipe_sha256: context.recipe_sha256.clone(),
        seed: context.seed,
        sizes: distinct,
    };
    let text = serde_json::to_vec(&header).unwrap_or_default();
    let mut writer = BankWriter::create(OutputBatch::new().replacing(context.replaces), to, &text)?;
    let mut rows = Vec::with_capacity(n);
    let n_made = AtomicUsize::new(0);
    let idxs: Vec<usize> = (0..n).collect();
    for some in idxs.chunks(AT_ONCE) {
        let made: Vec<Result<Made, Error>> = some
            .par_iter()
            .with_max_len(1)
            .map(|&idx| {
                if stop.load(Ordering::Relaxed) {
                    return Err(Error::Interrupted);
                }
                let made = make(&context.settings, &header, idx).map_err(|error| match error {
                    Error::Interrupted => error,
                    error => Error::OfPattern {
                        idx,
                        cause: Box::new(error),
                    },
                })?;
                progress(n_made.fetch_add(1, Ordering::Relaxed) + 1);
                Ok(made)
            })
            .collect();
        for made in made {
            let Made { row, records } = made?;
            rows.push(row);
            for record in &records {
                writer.append(record)?;
            }
        }
    }
    let written = writer.finish()?;
    Ok(BankDraft {
        report: BankReport {
            header,
            rows,
            sha256: written.sha256().to_owned(),
            n_bytes: written.n_bytes(),
        },
        written,
    })
}

/// A pattern on its way into the file.
struct Made {
    row: PatternRow,
    records: Vec<BankRecord>,
}

fn make(settings: &Settings, header: &BankHeader, idx: usize) -> Result<Made, Error> {
    let seed = header.seed_of(idx);
    let size = header.sizes.first().copied().ok_or(Error::NoSize)?;
    let network = simulate(settings, size, seed)?.network;
    let mut row = None;
    let mut records = vec![BankRecord::new(network_to_bytes(&network))];
    for &size in &header.sizes {
        let (record, mask) = bake_record(settings, &network, size, seed)?;
        row.get_or_insert_with(|| PatternRow::of(idx, &record.facts, &mask));
        records.push(BankRecord::new(record.to_bytes()));
    }
    let row = row.ok_or(Error::NoSize)?;
    Ok(Made { row, records })
}
