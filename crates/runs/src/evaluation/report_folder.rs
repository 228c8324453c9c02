//! Where a report of images or clips may be written.

use std::path::{Path, PathBuf};

use starbreak_dataset::{FileSet, OutputBatch, SourceSpec, file_len};

use super::{EvaluateRequest, files_of, label_files};
use crate::Error;

/// The files of a report of images.
pub const REPORT_FILES: [&str; 5] = [
    "report.html",
    "evaluation.json",
    "numbers.csv",
    "table.tex",
    "failures.jsonl",
];

/// The batch for the files of a report in a folder, where they may take the place of an earlier report, of
/// other files only if it `replaces` any, and never of what is read. One list, `written.json`, is of both kinds of reports: that
/// of images and that of clips replace each other.
///
/// # Errors
/// [`Error::Evaluation`] where the folder is that of a study or of a generated set,
/// [`Error::Dataset`] where a file is there that is no report's, or one that is read.
pub fn report_batch(
    folder: &Path,
    names: &[&str],
    replaces: bool,
    read: FileSet,
) -> Result<OutputBatch, Error> {
    let taken = [
        ("study.json", "a study, whose report would be replaced"),
        (
            "starbreak/run.json",
            "a generated set, to which no report belongs",
        ),
    ];
    let is_there = |(name, _): &&(&str, &str)| file_len(&folder.join(name)).is_ok();
    if let Some((_, what)) = taken.iter().find(is_there) {
        return Err(Error::Evaluation {
            why: format!(
                "{}: is the folder of {what}; give another",
                folder.display()
            ),
        });
    }
    let batch = OutputBatch::new().replacing(replaces);
    let batch = batch
        .with_list(&folder.join("written.json"), "report")
        .never_over(read);
    for name in names {
        batch.may_write(&folder.join(name))?;
    }
    Ok(batch)
}

impl EvaluateRequest {
    /// The labels and detections that are read, over which nothing is written. `source` is the dataset of the
    /// request with the links that the shell lets it follow.
    #[must_use]
    pub fn read_files(&self, source: Option<&SourceSpec>) -> FileSet {
        let mut files: Vec<PathBuf> = source.map(label_files).unwrap_or_default();
        let others = [&self.ground_truth, &self.cracked, &self.clusters];
        let others = others.into_iter().flatten().chain([&self.clean]);
        files.extend(others.flat_map(|path| files_of(path)));
        FileSet::of(&files)
    }
}
