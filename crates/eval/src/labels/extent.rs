//! How much labels and detections may be.

use std::path::Path;

use super::LabelSet;
use crate::EvalError;
use crate::json_record::refuse_file;

/// Most categories: every one has its curves, and each may be taken for each other.
const MOST_CATEGORIES: usize = 3000;

/// Most objects of an image, and most detections: each is compared with each.
const MOST_IN_IMAGE: u32 = 10_000;

impl LabelSet {
    /// The same, which must not be more than can be evaluated.
    pub(crate) fn within_limits(self, path: &Path) -> Result<Self, EvalError> {
        self.check_categories(path)?;
        self.check_images(path, "objects", self.objects.iter().map(|it| it.image))?;
        Ok(self)
    }

    pub(crate) fn check_categories(&self, path: &Path) -> Result<(), EvalError> {
        if self.categories.len() > MOST_CATEGORIES {
            let reason = format!(
                "more than {MOST_CATEGORIES} categories, which cannot be evaluated; take out those that do not matter"
            );
            return Err(refuse_file(path, reason));
        }
        Ok(())
    }

    /// No image has more of these than can be compared with each other.
    pub(crate) fn check_images(
        &self,
        path: &Path,
        what: &str,
        images: impl Iterator<Item = u32>,
    ) -> Result<(), EvalError> {
        let mut counts = vec![0_u32; self.images.len()];
        for image in images {
            let Some(count) = counts.get_mut(image as usize) else {
                continue;
            };
            *count += 1;
            if *count > MOST_IN_IMAGE {
                let name = self.images.get(image as usize).map(|image| &image.name);
                return Err(refuse_file(
                    path,
                    format!(
                        "more than {MOST_IN_IMAGE} {what} in the image {:?}; leave the others out, or cut \
                         the image into tiles",
                        name.map_or("", String::as_str)
                    ),
                ));
            }
        }
        Ok(())
    }
}
