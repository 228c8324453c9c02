//! How far the clean and the cracked images of a study lie apart.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use image::RgbImage;
use rayon::prelude::*;
use starbreak_dataset::blake3_file;
use starbreak_detect::ImageToSee;
use starbreak_eval::divergence::{
    CompareSettings, FailedImage, ImageSet, Item, ReadSettings, SummedSets,
};
use starbreak_eval::evaluation::DivergenceResults;

use super::numbers::reported;
use super::run::{clean_image, cracked_image};
use super::{Step, StudyEvent, StudyPlan, StudyRuns};
use crate::Error;

/// Up to so many sets each is compared with each; beyond, the clean one with each.
const MAX_SETS_OF_ALL_PAIRS: usize = 16;

/// Draws behind the intervals, and splits behind the noise floor: a sixth of what the verb `divergence` takes.
const N_DRAWS: [usize; 2] = [160, 50];

impl StudyPlan<'_> {
    /// The clean images, as detectors see them, against those of each condition, and up to 16 sets each
    /// against each: `div/1` of all features of pixels, with 160 replicates and 50 splits. None where
    /// `stop` was set on the way. Images in [`StudyRuns::unseen`] count in no set.
    ///
    /// # Errors
    /// [`Error::Eval`].
    pub fn divergence(
        &self,
        runs: &StudyRuns,
        seed: u64,
        stop: &AtomicBool,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<Option<DivergenceResults>, Error> {
        let quality = self.quality()?;
        let unseen: BTreeSet<&str> = runs.unseen.iter().map(|one| one.name.as_str()).collect();
        let n_sets = 1 + self.conditions.len();
        let n_images = self.images.len() - unseen.len().min(self.images.len());
        let n_all = u64::try_from(n_sets * n_images).unwrap_or(u64::MAX);
        tell(StudyEvent::Begun(Step::Comparing, n_all));
        let seen = self.images.iter();
        let seen: Vec<&ImageToSee> = seen
            .filter(|image| !unseen.contains(image.name.as_str()))
            .collect();
        let reading = ReadSettings::default();
        let item = |image: &ImageToSee, read: &Read<'_>| -> Result<Item, Error> {
            if stop.load(Ordering::Relaxed) {
                return Err(Error::Interrupted);
            }
            let (path, rgb) = read(image)?;
            let digest = blake3_file(&path)?;
            tell(StudyEvent::Image);
            let no_vector = Vec::new();
            Ok(Item::of_image(
                &image.name,
                digest,
                &rgb,
                &reading,
                no_vector,
            ))
        };
        // None where `stop` was set on the way.
        let set = |name: &str, read: &Read<'_>| -> Result<Option<ImageSet>, Error> {
            let items = seen.par_iter().map(|image| {
                item(image, read).map_err(|error| FailedImage {
                    name: image.name.clone(),
                    reason: error.to_string(),
                })
            });
            let items = items.collect();
            match stop.load(Ordering::Relaxed) {
                true => Ok(None),
                false => Ok(Some(ImageSet::new(name, items, None)?)),
            }
        };
        let clean = |image: &ImageToSee| {
            let rgb = clean_image(&image.path, quality)?;
            Ok((image.path.clone(), rgb))
        };
        let settings = CompareSettings {
            n_bootstrap: N_DRAWS[0],
            n_permutations: 0,
            n_splits: N_DRAWS[1],
            seed,
            ..CompareSettings::default()
        };
        // Set after set: the images of one are held at a time.
        let mut sets = SummedSets::new(reading, settings);
        let mut names = vec![CLEAN.to_owned()];
        let mut reports = Vec::new();
        let has_all_pairs = n_sets <= MAX_SETS_OF_ALL_PAIRS;
        let Some(clean) = set(CLEAN, &clean)? else {
            return Ok(None);
        };
        sets.push(clean);
        for condition in self.conditions {
            let layout = self.set_layout(condition);
            let name = reported(condition).name;
            let cracked = |image: &ImageToSee| {
                let path = layout.path(&image.name);
                let rgb = cracked_image(&path)?;
                Ok((path, rgb))
            };
            let Some(cracked) = set(&name, &cracked)? else {
                return Ok(None);
            };
            sets.push(cracked);
            names.push(name);
            if !has_all_pairs {
                reports.push(sets.compared()?);
                sets.truncate(1);
            }
        }
        if has_all_pairs {
            reports.push(sets.compared()?);
        }
        Ok(Some(DivergenceResults::of_reports(&names, &reports)))
    }
}

/// The name of the set of clean images.
const CLEAN: &str = "clean";

/// The file of an image, and its pixels.
type Read<'a> = dyn Fn(&ImageToSee) -> Result<(PathBuf, RgbImage), Error> + Sync + 'a;
