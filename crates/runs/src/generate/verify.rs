//! Is a generated set whole, unmixed, and as its lists say.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use serde_json::Value;
use starbreak_dataset::{DatasetError, Finding, Manifest, STATE_FOLDER, SetChecker};

use super::generate_flags;
use crate::Error;

/// What a check has found.
#[derive(Debug)]
pub struct VerifyReport {
    /// What the run said at its end.
    pub manifest: Manifest,
    /// Images whose files were read and hashed, samples counted one by one.
    pub n_items: u64,
    /// Carried files that were read and hashed.
    pub n_files: u64,
    /// What is wrong, in the order of the names.
    pub findings: Vec<Finding>,
    /// Whether the check was stopped before its end.
    pub was_stopped: bool,
    /// What the set is made from.
    pub identity: Value,
}

impl VerifyReport {
    /// The words after `starbreak generate FORMAT:PATH -o SET` that make the set again, with a recipe
    /// out of the set itself that is as it was.
    #[must_use]
    pub fn generate_flags(&self, root: &Path) -> Vec<String> {
        let state = root.join(STATE_FOLDER);
        let is_damaged = |name: &str| {
            let name = format!("{STATE_FOLDER}/{name}");
            self.findings.iter().any(|finding| finding.name == name)
        };
        let name = match is_damaged("run.json") {
            true => "recipe.toml",
            false => "run.json",
        };
        let mut flags = generate_flags(&self.identity, &state.join(name).to_string_lossy());
        if self.manifest.n_skipped > 0 {
            flags.extend(["--on-error", "skip"].map(str::to_owned));
        }
        flags
    }
}

/// Checks a finished set: all files of its lists are there with the right bytes, and no others.
///
/// # Errors
/// [`DatasetError::NotASet`] where there is no finished set, [`DatasetError::Read`].
pub fn verify(
    root: &Path,
    stop: &AtomicBool,
    tell: &(dyn Fn() + Sync),
) -> Result<VerifyReport, Error> {
    let mut checker = SetChecker::open(root)?;
    let mut findings = checker.check_lists()?;
    let lists_are_good = findings.is_empty();
    let (mut n_items, mut n_files) = (0, 0);
    if lists_are_good {
        for item in checker.items()? {
            checker.know_item(&item?);
            n_items += 1;
        }
        for file in checker.files()? {
            checker.know(&file?.name);
            n_files += 1;
        }
        findings.extend(checker.check_manifest(n_items, n_files)?);
        findings.extend(checker.strangers()?);
        let found = Mutex::new(Vec::new());
        let note = |more: Vec<Finding>| {
            found
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .extend(more);
            tell();
        };
        let goes_on = || !stop.load(Ordering::Relaxed);
        let items = checker.items()?.take_while(|_| goes_on());
        items
            .par_bridge()
            .try_for_each(|item| -> Result<(), DatasetError> {
                note(checker.check_item(&item?));
                Ok(())
            })?;
        let files = checker.files()?.take_while(|_| goes_on());
        files
            .par_bridge()
            .try_for_each(|file| -> Result<(), DatasetError> {
                let file = file?;
                note(
                    checker
                        .check_file(&file.name, &file.blake3)
                        .into_iter()
                        .collect(),
                );
                Ok(())
            })?;
        findings.extend(found.into_inner().unwrap_or_else(PoisonError::into_inner));
    }
    let manifest = checker.manifest().clone();
    if manifest.n_failed > 0 {
        findings.push(Finding {
            name: "starbreak/failures.jsonl".to_owned(),
            what: format!(
                "lists {} images that could not be made; run the same generate again once they are mended",
                manifest.n_failed
            ),
            is_foreign: false,
        });
    }
    findings.sort();
    Ok(VerifyReport {
        manifest,
        n_items,
        n_files,
        findings,
        was_stopped: stop.load(Ordering::Relaxed),
        identity: checker.identity().clone(),
    })
}
