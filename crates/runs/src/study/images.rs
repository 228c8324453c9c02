//! Whether the files of the images are those of the labels and of an earlier run.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use starbreak_dataset::{SetLayout, blake3_file, image_size};
use starbreak_detect::ImageToSee;
use starbreak_eval::{GroundTruth, LabeledImage};

use super::StudyPlan;
use super::arm_log::seen_files;
use crate::Error;

impl StudyPlan<'_> {
    /// Refuses images whose files are others than those that an earlier run of the folder has broken or
    /// looked at. One that could be neither broken nor looked at may be mended.
    pub(super) fn check_files(&self) -> Result<(), Error> {
        let sets = self.conditions.iter().map(|one| self.set_layout(one));
        let sets: Vec<SetLayout> = sets.collect();
        let mut seen = BTreeMap::new();
        for detector in self.detectors {
            seen.append(&mut seen_files(&self.log(detector, None))?);
        }
        let is_changed = |image: &ImageToSee| -> Result<bool, Error> {
            let mut earlier = None;
            for set in &sets {
                if let Some(done) = set.done(&image.name, 0)? {
                    earlier = Some(done.input_blake3);
                    break;
                }
            }
            let earlier = earlier.as_ref().or_else(|| seen.get(&image.name));
            // A file that is gone is told of with its name where it is read.
            Ok(earlier.is_some_and(|earlier| {
                blake3_file(&image.path).is_ok_and(|blake3| blake3 != *earlier)
            }))
        };
        let are_changed: Result<Vec<bool>, Error> =
            self.images.par_iter().map(is_changed).collect();
        let are_changed = are_changed?;
        let mut changed = self.images.iter().zip(&are_changed).filter(|(_, is)| **is);
        let Some((first, _)) = changed.next() else {
            return Ok(());
        };
        Err(Error::AnotherStudy {
            folder: self.out.to_owned(),
            what: format!(
                "the files of {} of its {} images have changed since, the first {:?}",
                1 + changed.count(),
                self.images.len(),
                first.name
            ),
            way_out: "put back the files that they were",
        })
    }

    /// Refuses labels that give an image another size than its file has, upright: their boxes are of
    /// other pixels.
    pub(super) fn check_sizes(&self, truth: &GroundTruth) -> Result<(), Error> {
        // Those of a shard are not all that have labels.
        let labels: Vec<&LabeledImage> = truth
            .labels
            .images
            .iter()
            .filter(|label| self.survey.is_selected(&label.name))
            .collect();
        let sizes = labels.into_par_iter().zip(self.images);
        let wrong = sizes.find_map_first(|(label, image)| wrong_size(label, &image.path));
        wrong.map_or(Ok(()), Err)
    }
}

/// A file without a good header is told of where it is read.
fn wrong_size(label: &LabeledImage, path: &Path) -> Option<Error> {
    let said = (label.width_px?, label.height_px?);
    let found = image_size(path).ok()?;
    (said != found).then(|| Error::LabeledSize {
        id: label.id,
        name: label.name.clone(),
        said,
        path: path.to_owned(),
        found,
    })
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::wrong_size;
    use starbreak_eval::LabeledImage;

    #[test]
    fn a_size_of_other_pixels_is_named_with_record_and_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("7.png");
        image::RgbImage::new(64, 48).save(&path).unwrap();
        let of = |width_px, height_px| {
            let label = LabeledImage {
                id: 7,
                name: "val/7.png".to_owned(),
                width_px,
                height_px,
                cluster: None,
            };
            wrong_size(&label, &path).map(|error| error.to_string())
        };
        let error = of(Some(60), Some(48)).unwrap();
        for word in ["image 7", "val/7.png", "60 x 48 px", "64 x 48 px"] {
            assert!(error.contains(word), "{word}: {error}");
        }
        assert!(of(Some(48), Some(64)).is_some(), "sides swapped");
        assert_eq!(of(Some(64), Some(48)), None, "the same");
        assert_eq!(of(None, Some(40)), None, "no size is said");
    }
}
