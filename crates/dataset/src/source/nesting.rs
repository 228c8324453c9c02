//! Whether an output folder lies in what a dataset is read from, or that in it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::Source;
use crate::error::DatasetError;
use crate::paths::resolved;

impl Source {
    /// Refuses an output folder that lies in a folder which is read, or the other way round, and one
    /// that holds a file which is read: a run would read what it writes. Links are seen through, as
    /// many as there are on the way.
    ///
    /// # Errors
    /// [`DatasetError::OutputInInput`].
    pub fn refuse_output_at(&self, output: &Path) -> Result<(), DatasetError> {
        let out = resolved(output);
        let refuse = |input: &Path| {
            Err(DatasetError::OutputInInput {
                input: input.to_owned(),
                output: output.to_owned(),
            })
        };
        let is_nested = |folder: &Path| folder.starts_with(&out) || out.starts_with(folder);
        if is_nested(&resolved(&self.root)) {
            return refuse(&self.root);
        }
        if self.layout.own_files().is_none() {
            let mut walk = self.layout.walk(&self.root);
            walk.by_ref().for_each(drop);
            if let Some(folder) = walk.entered().iter().find(|folder| is_nested(folder)) {
                return refuse(folder);
            }
        }
        let mut seen: BTreeSet<PathBuf> = BTreeSet::new();
        let images = self.images().filter_map(Result::ok).map(|image| image.path);
        let files = self.files().filter_map(Result::ok).map(|file| file.path);
        for path in images.chain(files) {
            let folder = path.parent().unwrap_or(&path);
            if !seen.contains(folder) {
                if is_nested(&resolved(folder)) {
                    return refuse(folder);
                }
                seen.insert(folder.to_owned());
            }
            let is_link = fs::symlink_metadata(&path).is_ok_and(|file| file.is_symlink());
            if is_link && resolved(&path).starts_with(&out) {
                return refuse(&path);
            }
        }
        Ok(())
    }
}
