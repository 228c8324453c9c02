//! Labels and other files of the source, carried into each sample's tree.

use rayon::prelude::*;
use starbreak_dataset::{CarriedFile, Carry, FileRole, GeneratedSet, SourceFile, SourceFormat};

use super::Plan;
use super::survey::{is_state, is_stray};
use crate::Error;

impl Plan<'_> {
    /// Carries over what the set keeps of the source beside its images, until it `is_over`.
    pub(super) fn carry_files(
        &self,
        set: &GeneratedSet,
        is_over: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<CarriedFile>, Error> {
        // The survey has listed what is wrong with others.
        let files = self
            .source
            .files()
            .take_while(|_| !is_over())
            .filter_map(Result::ok)
            .filter(|file| !is_state(&file.name) && !is_stray(file));
        let per_file = |file: SourceFile| -> Result<Vec<CarriedFile>, Error> {
            let mut carried: Vec<CarriedFile> = Vec::new();
            for sample_idx in 0..self.options.n_samples {
                let name = set.layout().in_sample(&file.name, sample_idx);
                carried.extend(match carried.first() {
                    // What is moved is the same in each sample.
                    Some(first) if self.moves_labels() && file.role != FileRole::Other => {
                        let first = set.layout().path(&first.name);
                        Some(set.carry(&first, &name, Carry::Copy)?)
                    }
                    _ => self.carry_file(set, &file, &name)?,
                });
            }
            Ok(carried)
        };
        let carried: Result<Vec<Vec<CarriedFile>>, Error> =
            files.par_bridge().map(per_file).collect();
        let mut carried = carried?.concat();
        carried.sort();
        Ok(carried)
    }

    /// Whether indexes are written anew: for the images that there are, and those of YOLO
    /// always, since a path in them may lead back to the source; where none does, they stay as
    /// they are.
    fn reduces_indexes(&self) -> bool {
        self.options.selection.is_partial()
            || self.survey.n_left_out > 0
            || self.source.format() == SourceFormat::Yolo
    }

    fn carry_file(
        &self,
        set: &GeneratedSet,
        file: &SourceFile,
        name: &str,
    ) -> Result<Option<CarriedFile>, Error> {
        let selection = &self.options.selection;
        let is_first_shard = selection.shard.is_none_or(|shard| shard.number == 1);
        let carried = match (&file.role, self.options.other_files) {
            (FileRole::LabelOf(image), _) if self.moves_labels() => {
                if !self.writes_moved(image) {
                    return Ok(None);
                }
                self.put_moved(set, file, name)?
            }
            (FileRole::LabelOf(image), _) => {
                // A label without an image goes along with the whole source.
                let is_kept = if selection.is_partial() || selection.shard.is_some() {
                    self.survey.is_selected(image)
                } else {
                    true
                };
                if !is_kept {
                    return Ok(None);
                }
                set.carry(&file.path, name, Carry::Copy)?
            }
            (FileRole::Index, _) if self.moves_labels() => self.put_moved(set, file, name)?,
            (FileRole::Index, _) if self.reduces_indexes() => set.put_with(name, &mut |out| {
                let is_kept = &mut |image: &str| self.survey.is_of_set(image);
                self.source.subset(file, is_kept, out)
            })?,
            (FileRole::Index, _) => set.carry(&file.path, name, Carry::Copy)?,
            (FileRole::Other, Some(how)) if is_first_shard => set.carry(&file.path, name, how)?,
            (FileRole::Other, _) => return Ok(None),
        };
        Ok(Some(carried))
    }

    /// Writes labels where the lens shows what they name.
    fn put_moved(
        &self,
        set: &GeneratedSet,
        file: &SourceFile,
        name: &str,
    ) -> Result<CarriedFile, Error> {
        let places = |size_px| self.places(size_px);
        let is_kept = &mut |image: &str| self.survey.is_of_set(image);
        let moved = set.put_with(name, &mut |out| {
            self.source.write_moved(file, &places, is_kept, out)
        });
        Ok(moved?)
    }
}
