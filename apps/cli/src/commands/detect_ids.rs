//! The numbers of images and categories that detections refer to.

use std::collections::BTreeMap;

use starbreak::dataset::{FileRole, Source, SourceFormat};
use starbreak_eval::detector::{ClassNames, ImageToSee};
use starbreak_eval::{Category, LabelSet};

use crate::failure::Failure;

/// The numbers of images and categories that detections refer to: those of the labels.
pub(super) struct Numbers {
    /// Of each image.
    pub(super) image_ids: Vec<i64>,
    /// All categories.
    pub(super) categories: Vec<Category>,
}

/// The categories of KITTI's object benchmark, in the order of its devkit.
const KITTI: [&str; 8] = [
    "Car",
    "Van",
    "Truck",
    "Pedestrian",
    "Person_sitting",
    "Cyclist",
    "Tram",
    "Misc",
];

/// The categories of BDD100K `det_20`, numbered from 1 in this order.
const BDD: [&str; 10] = [
    "pedestrian",
    "rider",
    "car",
    "truck",
    "bus",
    "train",
    "motorcycle",
    "bicycle",
    "traffic light",
    "traffic sign",
];

impl Numbers {
    pub(super) fn of(
        source: &Source,
        images: &[ImageToSee],
        classes: &ClassNames,
    ) -> Result<Self, Failure> {
        let by_place = || (1..).take(images.len()).collect();
        Ok(match source.format() {
            SourceFormat::Coco => of_coco(source, images)?,
            SourceFormat::Kitti => Self {
                image_ids: by_place(),
                categories: numbered(KITTI),
            },
            SourceFormat::Bdd => Self {
                image_ids: by_place(),
                categories: numbered(BDD),
            },
            SourceFormat::Yolo => Self {
                image_ids: by_place(),
                categories: numbered(labeled(source).iter().map(String::as_str)),
            },
            // Nothing is labeled: the model's own classes.
            SourceFormat::Folder | SourceFormat::List => Self {
                image_ids: by_place(),
                categories: numbered(classes.names.iter().flatten().map(String::as_str)),
            },
        })
    }
}

fn numbered<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<Category> {
    let numbered = (1..).zip(names);
    numbered
        .map(|(id, name)| Category {
            id,
            name: name.to_owned(),
            supercategory: None,
        })
        .collect()
}

/// The names of all categories that something is labeled with, in order.
fn labeled(source: &Source) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for image in source.images().filter_map(Result::ok) {
        for object in image.objects {
            if let Err(place) = names.binary_search(&object.category) {
                names.insert(place, object.category);
            }
        }
    }
    names
}

/// The numbers of the annotation files.
fn of_coco(source: &Source, images: &[ImageToSee]) -> Result<Numbers, Failure> {
    let mut categories: Vec<Category> = Vec::new();
    let mut ids: BTreeMap<String, i64> = BTreeMap::new();
    for file in source.files().filter_map(Result::ok) {
        if file.role != FileRole::Index {
            continue;
        }
        let labels = LabelSet::read_coco(&file.path)?;
        for category in labels.categories {
            if !categories.contains(&category) {
                categories.push(category);
            }
        }
        for image in labels.images {
            if ids
                .insert(image.name.clone(), image.id)
                .is_some_and(|before| before != image.id)
            {
                return Err(Failure::wrong_input(format!(
                    "the image {:?} has two numbers in the annotation files of {:?}; name one file, coco:FILE.json",
                    image.name,
                    source.root()
                )));
            }
        }
    }
    let mut image_ids = Vec::with_capacity(images.len());
    for image in images {
        // Names inside an annotation file begin below the folder of its images.
        let mut rest = image.name.as_str();
        let id = loop {
            if let Some(id) = ids.get(rest) {
                break *id;
            }
            match rest.split_once('/') {
                Some((_, after)) => rest = after,
                None => {
                    return Err(Failure::wrong_input(format!(
                        "no annotation file of {:?} has a number for the image {:?}",
                        source.root(),
                        image.name
                    )));
                }
            }
        };
        image_ids.push(id);
    }
    Ok(Numbers {
        image_ids,
        categories,
    })
}
