//! How far the clean and the cracked images of a study lie apart.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use image::DynamicImage;
use starbreak_dataset::blake3_file;
use starbreak_eval::divergence::{
    CompareSettings, ImageFile, ImageSet, ReadSettings, compare_sets,
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
        let set = |name: &str, path_of: &dyn Fn(usize) -> Option<PathBuf>, read: &Read<'_>| {
            let seen = self.images.iter().enumerate();
            let files: Vec<ImageFile> = seen
                .filter(|(_, image)| !unseen.contains(image.name.as_str()))
                .filter_map(|(place, image)| {
                    Some(ImageFile {
                        name: image.name.clone(),
                        path: path_of(place)?,
                    })
                })
                .collect();
            let read = |path: &Path| -> Result<(DynamicImage, String), String> {
                if stop.load(Ordering::Relaxed) {
                    return Err("interrupted".to_owned());
                }
                let pixels = read(path).map_err(|error| error.to_string())?;
                let blake3 = blake3_file(path).map_err(|error| error.to_string())?;
                tell(StudyEvent::Image);
                Ok((DynamicImage::ImageRgb8(pixels), blake3))
            };
            ImageSet::of_files(name, &files, &ReadSettings::default(), None, &read)
        };
        let source = |place: usize| self.images.get(place).map(|image| image.path.clone());
        let clean = |path: &Path| clean_image(path, quality);
        let mut sets = vec![set(CLEAN, &source, &clean)];
        for (condition, layout) in self.conditions.iter().zip(&runs.sets) {
            let path = |place: usize| {
                let image = self.images.get(place)?;
                Some(layout.path(&image.name))
            };
            sets.push(set(&reported(condition).name, &path, &cracked_image));
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let sets: Result<Vec<ImageSet>, _> = sets.into_iter().collect();
        let sets = sets?;
        let settings = CompareSettings {
            n_bootstrap: N_DRAWS[0],
            n_permutations: 0,
            n_splits: N_DRAWS[1],
            seed,
            ..CompareSettings::default()
        };
        let compare =
            |sets: &[ImageSet]| compare_sets(sets, &ReadSettings::default(), &settings, &[]);
        let names: Vec<String> = sets.iter().map(|set| set.name().to_owned()).collect();
        let mut reports = Vec::new();
        match sets.split_first() {
            Some((clean, cracked)) if sets.len() > MAX_SETS_OF_ALL_PAIRS => {
                for one in cracked {
                    reports.push(compare(&[clean.clone(), one.clone()])?);
                }
            }
            _ => reports.push(compare(&sets)?),
        }
        Ok(Some(DivergenceResults::of_reports(&names, &reports)))
    }
}

/// The name of the set of clean images.
const CLEAN: &str = "clean";

/// The pixels in a file.
type Read<'a> = dyn Fn(&Path) -> Result<image::RgbImage, Error> + Sync + 'a;
