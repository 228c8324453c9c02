//! How much of each object and detection lies in the region of its image.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::RegionMask;
use crate::protocol::exact;
use crate::{BoxPx, Detections, EvalError, LabelSet};

/// Where the region masks of a dataset are, and how large its images are.
#[derive(Debug, Clone, Copy)]
pub struct RegionMasks<'a> {
    /// The folder with a mask `STEM.png` per image `STEM.*`, by its name in the dataset.
    pub folder: &'a Path,
    /// The root of the dataset, where images are at hand that say their size.
    pub root: Option<&'a Path>,
}

/// How much of each box lies in the region of its image, and how large the regions are.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Coverages {
    /// The coverage of each object, 0 to 1, in the order of [`LabelSet::objects`].
    pub objects: Vec<f64>,
    /// The coverages of each set of detections, in the order of
    /// [`Detections::items`](crate::Detections::items).
    pub detections: Vec<Vec<f64>>,
    /// Pixels in the region of each image; nothing where no mask was needed, as there is neither
    /// object nor detection, and there is none.
    pub region_px: Vec<Option<u64>>,
    /// Share of each image that the region covers, 0 to 1; nothing as above.
    pub region_share: Vec<Option<f64>>,
}

impl RegionMasks<'_> {
    /// The path of the mask of an image.
    #[must_use]
    pub fn path_of(&self, image: &str) -> PathBuf {
        let (folder, file) = image.rsplit_once('/').unwrap_or(("", image));
        let stem = match file.rsplit_once('.') {
            Some((stem, _)) if !stem.is_empty() => stem,
            _ => file,
        };
        let mut path = self.folder.to_owned();
        path.extend(folder.split('/').filter(|part| !part.is_empty()));
        path.push(format!("{stem}.png"));
        path
    }

    /// How much of each object and of each detection of these sets lies in the regions. Masks are
    /// read one by one for each thread.
    ///
    /// # Errors
    /// [`EvalError::Mask`] for an image with objects or detections whose mask is not there or has
    /// another size than the image, and what [`RegionMask::read`] says.
    pub fn coverages(
        &self,
        labels: &LabelSet,
        sets: &[&Detections],
    ) -> Result<Coverages, EvalError> {
        let n_images = labels.images.len();
        let objects = by_image(n_images, labels.objects.iter().map(|o| (o.image, o.box_px)));
        let detections: Vec<ByImage> = sets
            .iter()
            .map(|set| by_image(n_images, set.items.iter().map(|d| (d.image, d.box_px))))
            .collect();
        let of_image = |idx: usize| {
            let is_needed =
                !objects.of(idx).is_empty() || detections.iter().any(|set| !set.of(idx).is_empty());
            let Some(mask) = self.mask(labels, idx, is_needed)? else {
                return Ok(OfImage::default());
            };
            let covered = |boxes: &[(usize, BoxPx)]| -> Vec<f64> {
                boxes.iter().map(|(_, b)| mask.coverage(b)).collect()
            };
            Ok(OfImage {
                region_px: Some(mask.n_pixels()),
                region_share: share_of(&mask),
                objects: covered(objects.of(idx)),
                detections: detections.iter().map(|set| covered(set.of(idx))).collect(),
            })
        };
        let found: Result<Vec<OfImage>, EvalError> =
            (0..n_images).into_par_iter().map(of_image).collect();
        let found = found?;
        let mut coverages = Coverages {
            objects: vec![0.0; labels.objects.len()],
            detections: sets.iter().map(|set| vec![0.0; set.items.len()]).collect(),
            region_px: found.iter().map(|image| image.region_px).collect(),
            region_share: found.iter().map(|image| image.region_share).collect(),
        };
        let put = |to: &mut Vec<f64>, boxes: &[(usize, BoxPx)], values: &[f64]| {
            for ((idx, _), value) in boxes.iter().zip(values) {
                if let Some(slot) = to.get_mut(*idx) {
                    *slot = *value;
                }
            }
        };
        for (idx, image) in found.iter().enumerate() {
            put(&mut coverages.objects, objects.of(idx), &image.objects);
            let sets = coverages.detections.iter_mut().zip(&detections);
            for ((to, set), values) in sets.zip(&image.detections) {
                put(to, set.of(idx), values);
            }
        }
        Ok(coverages)
    }

    /// The mask of an image, of its size.
    fn mask(
        &self,
        labels: &LabelSet,
        idx: usize,
        is_needed: bool,
    ) -> Result<Option<RegionMask>, EvalError> {
        let Some(image) = labels.images.get(idx) else {
            return Ok(None);
        };
        let path = self.path_of(&image.name);
        let refuse = |reason: String| EvalError::Mask {
            image: image.name.clone(),
            path: path.clone(),
            reason,
        };
        let mask = match RegionMask::read(&path) {
            Ok(mask) => mask,
            Err(error) if is_absent(&error) && !is_needed => return Ok(None),
            Err(error) if is_absent(&error) => {
                let reason = "it is not there, and an image without a mask is not one without a region; generate it, or leave its detections out";
                return Err(refuse(reason.to_owned()));
            }
            Err(error) => return Err(error),
        };
        let size = match (image.width_px, image.height_px, self.root) {
            (Some(width), Some(height), _) => Some((width, height)),
            (_, _, Some(root)) => starbreak_dataset::image_size(&root.join(&image.name)).ok(),
            _ => None,
        };
        let own = (mask.width_px(), mask.height_px());
        match size {
            Some(size) if size != own => Err(refuse(format!(
                "it is {} x {} px, but the image is {} x {} px; give the masks of these images",
                own.0, own.1, size.0, size.1
            ))),
            _ => Ok(Some(mask)),
        }
    }
}

/// Whether there is no such file.
fn is_absent(error: &EvalError) -> bool {
    use starbreak_dataset::DatasetError;
    matches!(error, EvalError::Dataset(DatasetError::Read { source, .. })
        if source.kind() == std::io::ErrorKind::NotFound)
}

#[derive(Default)]
struct OfImage {
    region_px: Option<u64>,
    region_share: Option<f64>,
    objects: Vec<f64>,
    detections: Vec<Vec<f64>>,
}

/// The share of its image that a mask covers; nothing of an empty image.
fn share_of(mask: &RegionMask) -> Option<f64> {
    let n_pixels = u64::from(mask.width_px()) * u64::from(mask.height_px());
    (n_pixels > 0).then(|| exact(mask.n_pixels()) / exact(n_pixels))
}

/// Boxes with their places, image by image.
struct ByImage {
    boxes: Vec<(usize, BoxPx)>,
    /// Where those of each image end.
    ends: Vec<usize>,
}

impl ByImage {
    fn of(&self, image: usize) -> &[(usize, BoxPx)] {
        let end = |image: usize| self.ends.get(image).copied().unwrap_or(0);
        let begin = image.checked_sub(1).map_or(0, end);
        self.boxes.get(begin..end(image)).unwrap_or(&[])
    }
}

fn by_image(n_images: usize, boxes: impl Iterator<Item = (u32, BoxPx)>) -> ByImage {
    let mut rows: Vec<(u32, usize, BoxPx)> = boxes
        .enumerate()
        .map(|(idx, (image, box_px))| (image, idx, box_px))
        .collect();
    rows.sort_by_key(|(image, idx, _)| (*image, *idx));
    let end_of = |image: u32| rows.partition_point(|(known, ..)| *known <= image);
    let ends = (0u32..).take(n_images).map(end_of).collect();
    ByImage {
        boxes: rows.into_iter().map(|(_, idx, b)| (idx, b)).collect(),
        ends,
    }
}

impl Coverages {
    /// Images of whose masks at least one pixel is in the region.
    #[must_use]
    pub fn n_images_with_region(&self) -> usize {
        let sizes = self.region_px.iter().flatten();
        sizes.filter(|size| **size > 0).count()
    }

    /// Mean over the images that have a mask of the share that it covers, 0 to 1.
    #[must_use]
    pub fn mean_region_share(&self) -> Option<f64> {
        let shares: Vec<f64> = self.region_share.iter().copied().flatten().collect();
        let n = exact(u64::try_from(shares.len()).ok()?);
        (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / n)
    }

    /// Images of whose masks no pixel is in the region: the cracks left them as they are.
    #[must_use]
    pub fn n_images_intact(&self) -> usize {
        let sizes = self.region_px.iter().flatten();
        sizes.filter(|size| **size == 0).count()
    }
}
