//! What images and categories detections refer to.

use std::collections::BTreeMap;

use starbreak_dataset::{SourceFormat, SourceSpec};
use starbreak_detect::{ClassNames, ImageToSee};
use starbreak_eval::{Category, GroundTruth, LabelSet, LabeledImage};

use crate::failure::Failure;

/// What detections refer to: images and categories with the numbers of the labels.
pub(super) struct Referred {
    /// Those of the labels; the objects play no part.
    pub(super) labels: LabelSet,
    /// Of each image that is looked through the place in there.
    pub(super) places: Vec<u32>,
}

impl Referred {
    pub(super) fn of(
        spec: &SourceSpec,
        images: &[ImageToSee],
        classes: &ClassNames,
    ) -> Result<Self, Failure> {
        let labels = match spec.format {
            // Nothing is labeled: the model's own classes.
            SourceFormat::Folder | SourceFormat::List => LabelSet {
                images: (1..).zip(images).map(image_of).collect(),
                categories: of_model(classes),
                objects: Vec::new(),
            },
            _ => GroundTruth::of_dataset(spec, None)?.labels,
        };
        let mut place_of: BTreeMap<&str, u32> = BTreeMap::new();
        for (place, image) in (0..).zip(&labels.images) {
            place_of.insert(&image.name, place);
        }
        let mut places = Vec::with_capacity(images.len());
        for image in images {
            let Some(place) = place_of.get(image.name.as_str()) else {
                return Err(Failure::wrong_input(format!(
                    "the labels of {:?} do not know the image {:?}; give images without labels as folder:DIR",
                    spec.path, image.name
                )));
            };
            places.push(*place);
        }
        Ok(Self { labels, places })
    }

    /// The frames of a clip, numbered from 1, and the model's own classes.
    pub(super) fn of_clip(
        names: impl Iterator<Item = String>,
        video: &str,
        classes: &ClassNames,
    ) -> Self {
        let image = |(id, name): (i64, String)| LabeledImage {
            id,
            name,
            width_px: None,
            height_px: None,
            cluster: Some(video.to_owned()),
        };
        let images: Vec<LabeledImage> = (1..).zip(names).map(image).collect();
        Self {
            places: (0..).zip(&images).map(|(place, _)| place).collect(),
            labels: LabelSet {
                images,
                categories: of_model(classes),
                objects: Vec::new(),
            },
        }
    }
}

fn image_of((id, image): (i64, &ImageToSee)) -> LabeledImage {
    LabeledImage {
        id,
        name: image.name.clone(),
        width_px: None,
        height_px: None,
        cluster: None,
    }
}

/// The model's classes as categories, with the numbers of MS-COCO where it has them all.
pub(super) fn of_model(classes: &ClassNames) -> Vec<Category> {
    let names: Vec<&String> = classes.names.iter().flatten().collect();
    let numbers: Option<Vec<i64>> = names
        .iter()
        .map(|name| ClassNames::coco_number(name))
        .collect();
    let numbers = numbers.unwrap_or_else(|| (1..).take(names.len()).collect());
    let category = |(id, name): (i64, &String)| Category {
        id,
        name: name.clone(),
        supercategory: None,
    };
    numbers.into_iter().zip(names).map(category).collect()
}
