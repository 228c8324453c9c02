//! The images in which most is lost, with boxes and pictures.

use image::imageops::FilterType;
use image::{DynamicImage, GenericImageView as _};
use starbreak_dataset::{Encoding, ImageLimits, JpegQuality, encode_image, read_image};

use super::what_fails::Matches;
use super::{ImageFolders, Plain};
use crate::evaluation::{BoxRole, Change, ChangedObject, PicturePair, RoledBox, WorstFailure};
use crate::failure::ObjectPair;
use crate::matching::{ImageMatches, Outcome};
use crate::{Detection, EvalError};

/// Overlap from which a cracked false positive was there in the clean image, too.
const SAME_PLACE_IOU: f64 = 0.5;

pub(super) fn worst(
    all: &Plain<'_>,
    pairs: &[ObjectPair],
    matches: &Matches,
    folders: Option<ImageFolders<'_>>,
) -> Result<Vec<WorstFailure>, EvalError> {
    let n_images = all.labels.images.len();
    let mut of_image: Vec<Vec<&ObjectPair>> = vec![Vec::new(); n_images];
    for pair in pairs {
        if let Some(list) = of_image.get_mut(pair.image as usize) {
            list.push(pair);
        }
    }
    let mut ranked: Vec<(u64, u64, usize)> = of_image
        .iter()
        .enumerate()
        .map(|(image, pairs)| {
            let count = |is: fn(&ObjectPair) -> bool| {
                pairs.iter().map(|pair| u64::from(is(pair))).sum::<u64>()
            };
            (
                count(ObjectPair::is_lost),
                count(|pair| pair.clean.is_some()),
                image,
            )
        })
        .filter(|(n_lost, ..)| *n_lost > 0)
        .collect();
    // Most lost first; of as many, where more of what was found is lost; then by place.
    ranked.sort_by_key(|(n_lost, n_found, image)| (std::cmp::Reverse(*n_lost), *n_found, *image));
    let n_worst = usize::try_from(all.settings.n_worst).unwrap_or(usize::MAX);
    ranked.truncate(n_worst);
    ranked
        .into_iter()
        .filter_map(|(n_lost, n_found_clean, image)| {
            let label = all.labels.images.get(image)?;
            let pairs = of_image.get(image)?;
            let new = new_detections(all, matches, image);
            let mut boxes: Vec<RoledBox> = pairs
                .iter()
                .filter_map(|pair| object_box(all, pair))
                .collect();
            boxes.extend(new.iter().map(|detection| RoledBox {
                role: BoxRole::New,
                class: class(all, detection.category),
                box_px: detection.box_px,
                score: Some(detection.score),
                coverage: None,
            }));
            boxes.sort_by_key(|one| one.role);
            Some((label, n_lost, n_found_clean, new.len(), boxes))
        })
        .map(|(label, n_lost, n_found_clean, n_new, boxes)| {
            let size = label.width_px.zip(label.height_px);
            let pictures = folders
                .map(|folders| pictures(all, folders, &label.name))
                .transpose()?;
            let (own_size, pictures) = match pictures {
                Some((size, pictures)) => (Some(size), Some(pictures)),
                None => (None, None),
            };
            let (width_px, height_px) = own_size.or(size).unwrap_or((0, 0));
            Ok(WorstFailure {
                image: label.name.clone(),
                width_px,
                height_px,
                n_found_clean,
                n_lost,
                n_new: u64::try_from(n_new).unwrap_or(u64::MAX),
                boxes,
                pictures,
            })
        })
        .collect()
}

/// All objects that only one of both images shows, in the order of the labels.
pub(super) fn changed_objects(all: &Plain<'_>, pairs: &[ObjectPair]) -> Vec<ChangedObject> {
    let changed = pairs.iter().filter_map(|pair| {
        let (change, found) = match (pair.clean, pair.cracked) {
            (Some(found), None) => (Change::Lost, found),
            (None, Some(found)) => (Change::Recovered, found),
            _ => return None,
        };
        let object = all.labels.objects.get(pair.object as usize)?;
        let image = all.labels.images.get(pair.image as usize)?;
        Some(ChangedObject {
            image: image.name.clone(),
            object_id: object.id,
            class: class(all, pair.category),
            box_px: object.box_px,
            change,
            coverage: pair.coverage,
            score: found.score,
            iou: found.iou,
        })
    });
    changed.collect()
}

fn class(all: &Plain<'_>, category: u32) -> String {
    let category = all.labels.categories.get(category as usize);
    category.map_or(String::new(), |category| category.name.clone())
}

fn object_box(all: &Plain<'_>, pair: &ObjectPair) -> Option<RoledBox> {
    let object = all.labels.objects.get(pair.object as usize)?;
    let (role, score) = match (pair.clean, pair.cracked) {
        (Some(_), None) => (BoxRole::Lost, None),
        (_, Some(found)) => (BoxRole::Found, Some(found.score)),
        (None, None) => (BoxRole::Missed, None),
    };
    Some(RoledBox {
        role,
        class: class(all, pair.category),
        box_px: object.box_px,
        score,
        coverage: Some(pair.coverage),
    })
}

/// False positives of the cracked image where the clean one has no detection.
fn new_detections<'a>(all: &Plain<'a>, matches: &Matches, image: usize) -> Vec<&'a Detection> {
    let least = all.settings.score_threshold;
    let is_here = |item: &&ImageMatches| item.image as usize == image;
    let seen: Vec<&Detection> = all
        .clean
        .items
        .iter()
        .filter(|it| it.image as usize == image && it.score >= least)
        .collect();
    matches
        .cracked
        .iter()
        .filter(is_here)
        .flat_map(|item| &item.detections)
        .filter(|it| it.outcome == Outcome::FalsePositive && it.score >= least)
        .filter_map(|it| all.cracked.items.get(it.detection as usize))
        .filter(|it| {
            seen.iter()
                .all(|old| old.box_px.iou(&it.box_px) < SAME_PLACE_IOU)
        })
        .collect()
}

/// Both pictures, small enough for a page, and the size of the image that the boxes refer to.
fn pictures(
    all: &Plain<'_>,
    folders: ImageFolders<'_>,
    name: &str,
) -> Result<((u32, u32), PicturePair), EvalError> {
    let read = |root: &std::path::Path| -> Result<DynamicImage, EvalError> {
        Ok(read_image(&root.join(name), &ImageLimits::default())?.pixels)
    };
    let (clean, cracked) = (read(folders.clean)?, read(folders.cracked)?);
    let size = clean.dimensions();
    let pair = PicturePair {
        clean_jpeg: jpeg(all, clean)?,
        cracked_jpeg: jpeg(all, cracked)?,
    };
    Ok((size, pair))
}

fn jpeg(all: &Plain<'_>, pixels: DynamicImage) -> Result<Vec<u8>, EvalError> {
    let side = all.settings.picture_side_px.max(1);
    let is_large = pixels.width().max(pixels.height()) > side;
    let small = match is_large {
        true => pixels.resize(side, side, FilterType::Triangle),
        false => pixels,
    };
    let quality = JpegQuality::new(all.settings.picture_quality)?;
    let rgb = DynamicImage::ImageRgb8(small.to_rgb8());
    Ok(encode_image(&rgb, &Encoding::Jpeg { quality }, None)?)
}
