//! Sets of images: read once, kept as histograms.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use image::{DynamicImage, RgbImage};
use rayon::prelude::*;
use serde::Serialize;
use starbreak_dataset::{ImageLimits, Source, SourceImage, read_image};

use super::features::{
    AnalysisSize, Background, Counts, CrackGeometry, Feature, Frame, image_counts,
};
use super::measures::FeatureVectors;
use crate::EvalError;

/// How the images of a set are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ReadSettings {
    /// What shows through where an image is transparent. **Default** black.
    pub background: Background,
    /// Size for gradients and spectra.
    pub analysis: AnalysisSize,
}

impl Default for ReadSettings {
    fn default() -> Self {
        Self {
            background: Background::Black,
            analysis: AnalysisSize::default(),
        }
    }
}

/// A feature vector of an opaque 8-bit image, or why there is none.
pub type VectorOf<'a> = dyn Fn(&RgbImage) -> Result<Vec<f32>, String> + Sync + 'a;

/// Where an image of a set is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageFile {
    /// Its name in the set.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
}

/// The pixels of an image and a digest of its file, or why there are none.
pub type PixelsOf<'a> = dyn Fn(&Path) -> Result<(DynamicImage, String), String> + Sync + 'a;

/// An image or a pattern of a set.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Item {
    pub(super) name: String,
    /// A digest of its file; the same of the same bytes.
    pub(super) digest: String,
    /// One for each of the set's features.
    pub(super) counts: Vec<Counts>,
    size_px: Option<[u32; 2]>,
    is_enlarged: bool,
    vector: Option<Vec<f32>>,
}

/// An image that could not be read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FailedImage {
    /// Its name in the set, or the record.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// A set of images, or of crack patterns, as histograms.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageSet {
    pub(super) name: String,
    pub(super) items: Vec<Item>,
    pub(super) features: Vec<Feature>,
    failed: Vec<FailedImage>,
    vectors: Option<FeatureVectors>,
}

/// A crack pattern of a set of patterns.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPattern {
    /// Its name.
    pub name: String,
    /// A digest of its file; the same of the same bytes.
    pub digest: String,
    /// What is measured of it.
    pub geometry: CrackGeometry,
}

/// What a set is made of.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetSummary {
    /// Its name.
    pub name: String,
    /// Images that were read.
    pub n: usize,
    /// Images that could not be.
    pub failed: Vec<FailedImage>,
    /// Smallest and largest width and height, px: `[[w, h], [w, h]]`; none of patterns.
    pub size_range_px: Option<[[u32; 2]; 2]>,
    /// Images that were enlarged for gradients and spectra.
    pub n_enlarged: usize,
    /// Images that are the very file of an earlier one of the set.
    pub n_repeated: usize,
}

impl ImageSet {
    /// The images of a dataset as histograms of [`Feature::OF_IMAGES`], and as vectors where
    /// `vector_of` is given. One decoded image per thread is in memory at a time; what stays is
    /// some 10 kB an image. The same for any number of threads.
    ///
    /// What cannot be read is listed, and the rest is taken. `limit` takes the first images of the
    /// order of names only. Once `stop` is set, no further image is read, and each one left counts as
    /// failed with the reason `interrupted`.
    ///
    /// # Errors
    /// [`EvalError::EmptySet`] where no image is left; what [`FeatureVectors::new`] says of vectors.
    pub fn read(
        name: &str,
        source: &Source,
        settings: &ReadSettings,
        limit: Option<usize>,
        vector_of: Option<&VectorOf<'_>>,
        stop: &AtomicBool,
        step: &(dyn Fn() + Sync),
    ) -> Result<Self, EvalError> {
        let images: Vec<_> = source.images().take(limit.unwrap_or(usize::MAX)).collect();
        let read: Vec<Result<Item, FailedImage>> = images
            .into_par_iter()
            .map(|image| {
                let image = image.map_err(|bad| FailedImage {
                    name: bad.place,
                    reason: bad.reason,
                })?;
                let failed = |reason: String| FailedImage {
                    name: image.name.clone(),
                    reason,
                };
                if stop.load(Ordering::Relaxed) {
                    return Err(failed("interrupted".to_owned()));
                }
                let item = item_of(&image, settings, vector_of).map_err(failed);
                step();
                item
            })
            .collect();
        Self::of_items(name, read, Feature::OF_IMAGES.to_vec())
    }

    /// The same of files, each read by `pixels_of`.
    ///
    /// # Errors
    /// As for [`ImageSet::read`].
    pub fn of_files(
        name: &str,
        files: &[ImageFile],
        settings: &ReadSettings,
        vector_of: Option<&VectorOf<'_>>,
        pixels_of: &PixelsOf<'_>,
    ) -> Result<Self, EvalError> {
        let read = |file: &ImageFile| {
            let failed = |reason: String| FailedImage {
                name: file.name.clone(),
                reason,
            };
            let (pixels, digest) = pixels_of(&file.path).map_err(failed)?;
            item_of_pixels(&file.name, &pixels, digest, settings, vector_of).map_err(failed)
        };
        let read = files.par_iter().map(read).collect();
        Self::of_items(name, read, Feature::OF_IMAGES.to_vec())
    }

    /// A set of crack patterns as histograms of [`Feature::OF_CRACKS`].
    ///
    /// # Errors
    /// [`EvalError::EmptySet`] where there is no pattern.
    pub fn of_patterns(
        name: &str,
        patterns: Vec<Result<NamedPattern, FailedImage>>,
    ) -> Result<Self, EvalError> {
        let item = |pattern: NamedPattern| Item {
            counts: pattern.geometry.counts(),
            name: pattern.name,
            digest: pattern.digest,
            size_px: None,
            is_enlarged: false,
            vector: None,
        };
        let read = patterns.into_iter().map(|pattern| pattern.map(item));
        Self::of_items(name, read.collect(), Feature::OF_CRACKS.to_vec())
    }

    fn of_items(
        name: &str,
        read: Vec<Result<Item, FailedImage>>,
        features: Vec<Feature>,
    ) -> Result<Self, EvalError> {
        let (mut items, mut failed) = (Vec::new(), Vec::new());
        for one in read {
            match one {
                Ok(item) => items.push(item),
                Err(image) => failed.push(image),
            }
        }
        if items.is_empty() {
            return Err(EvalError::EmptySet {
                name: name.to_owned(),
                n_failed: failed.len(),
                first: failed.first().map_or_else(String::new, |image| {
                    format!(", the first: {:?}: {}", image.name, image.reason)
                }),
            });
        }
        let vectors = vectors_of(&mut items)?;
        Ok(Self {
            name: name.to_owned(),
            items,
            features,
            failed,
            vectors,
        })
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many images it has.
    #[must_use]
    pub fn n(&self) -> usize {
        self.items.len()
    }

    /// The images that could not be read.
    #[must_use]
    pub fn failed(&self) -> &[FailedImage] {
        &self.failed
    }

    /// The feature vectors of its images, where they were asked for.
    #[must_use]
    pub fn vectors(&self) -> Option<&FeatureVectors> {
        self.vectors.as_ref()
    }

    /// The pooled histogram of a feature: the sum over its images; none of a feature that is not
    /// measured in such a set.
    #[must_use]
    pub fn pooled(&self, feature: Feature) -> Option<Vec<f64>> {
        let place = self.features.iter().position(|known| *known == feature)?;
        let mut histogram = vec![0.0; feature.n_bins()];
        for item in &self.items {
            if let Some(counts) = item.counts.get(place) {
                counts.add_to(&mut histogram, 1.0);
            }
        }
        Some(histogram)
    }

    /// What it is made of.
    #[must_use]
    pub fn summary(&self) -> SetSummary {
        let sizes: Vec<[u32; 2]> = self.items.iter().filter_map(|item| item.size_px).collect();
        let side = |axis: usize, pick: fn(u32, u32) -> u32| -> Option<u32> {
            sizes
                .iter()
                .filter_map(|size| size.get(axis).copied())
                .reduce(pick)
        };
        let size_range_px = (|| {
            Some([
                [side(0, u32::min)?, side(1, u32::min)?],
                [side(0, u32::max)?, side(1, u32::max)?],
            ])
        })();
        let mut digests: Vec<&str> = self.items.iter().map(|item| item.digest.as_str()).collect();
        digests.sort_unstable();
        digests.dedup();
        SetSummary {
            name: self.name.clone(),
            n: self.items.len(),
            failed: self.failed.clone(),
            size_range_px,
            n_enlarged: self.items.iter().filter(|item| item.is_enlarged).count(),
            n_repeated: self.items.len() - digests.len(),
        }
    }
}

fn item_of(
    image: &SourceImage,
    settings: &ReadSettings,
    vector_of: Option<&VectorOf<'_>>,
) -> Result<Item, String> {
    let file = read_image(&image.path, &ImageLimits::default()).map_err(|e| e.to_string())?;
    item_of_pixels(&image.name, &file.pixels, file.blake3, settings, vector_of)
}

fn item_of_pixels(
    name: &str,
    pixels: &DynamicImage,
    digest: String,
    settings: &ReadSettings,
    vector_of: Option<&VectorOf<'_>>,
) -> Result<Item, String> {
    let frame = Frame::of(pixels, settings.background, settings.analysis);
    let vector = match vector_of {
        Some(vector_of) => Some(vector_of(&frame.rgb)?),
        None => None,
    };
    Ok(Item {
        name: name.to_owned(),
        digest,
        counts: image_counts(&frame),
        size_px: Some([frame.rgb.width(), frame.rgb.height()]),
        is_enlarged: frame.is_enlarged,
        vector,
    })
}

/// The vectors of all items, where all have one.
fn vectors_of(items: &mut [Item]) -> Result<Option<FeatureVectors>, EvalError> {
    let vectors: Vec<Vec<f32>> = items
        .iter_mut()
        .filter_map(|item| item.vector.take())
        .collect();
    let Some(first) = vectors.first() else {
        return Ok(None);
    };
    let d = first.len();
    if let Some(other) = vectors.iter().find(|vector| vector.len() != d) {
        return Err(EvalError::VectorLengths {
            n_a: d,
            n_b: other.len(),
        });
    }
    let values = vectors.into_iter().flatten().map(f64::from).collect();
    FeatureVectors::new(d, values).map(Some)
}
