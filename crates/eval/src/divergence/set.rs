//! Sets of images or of crack networks: each item read once, kept as histograms.

use std::collections::BTreeSet;

use image::RgbImage;
use serde::Serialize;

use super::features::{Counts, Feature, ReadSettings, image_counts, network_counts};
use super::vectors::FeatureVectors;
use crate::EvalError;

/// An image or a crack network of a set: an image of COCO takes some 12 kB.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    name: String,
    digest: String,
    features: &'static [Feature],
    /// One for each of these features.
    pub(super) counts: Vec<Counts>,
    size_px: Option<[u32; 2]>,
    is_enlarged: bool,
    vector: Vec<f32>,
}

impl Item {
    /// An image that [`ReadSettings::opaque`] gave. `digest` is the same of the same file; `vector` is what a
    /// model says of it, empty without one.
    #[must_use]
    pub fn of_image(
        name: &str,
        digest: String,
        rgb: &RgbImage,
        reading: &ReadSettings,
        vector: Vec<f32>,
    ) -> Self {
        let (counts, is_enlarged) = image_counts(rgb, reading);
        Self {
            name: name.to_owned(),
            digest,
            features: &Feature::OF_IMAGES,
            counts,
            size_px: Some([rgb.width(), rgb.height()]),
            is_enlarged,
            vector,
        }
    }

    /// A crack network: places of nodes, the two nodes of each segment, and the diagonal of the pane, all
    /// in one unit.
    ///
    /// # Errors
    /// [`EvalError::NotComparable`] for a segment to a node that is not there, a place that is not
    /// finite, or a diagonal that is not above 0.
    pub fn of_network(
        name: &str,
        digest: String,
        nodes: &[[f64; 2]],
        segments: &[[usize; 2]],
        diagonal: f64,
    ) -> Result<Self, EvalError> {
        Ok(Self {
            name: name.to_owned(),
            digest,
            features: &Feature::OF_NETWORKS,
            counts: network_counts(nodes, segments, diagonal)?,
            size_px: None,
            is_enlarged: false,
            vector: Vec::new(),
        })
    }
}

/// An image that could not be read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FailedImage {
    /// Its name in the set, or the record.
    pub name: String,
    /// Why.
    pub reason: String,
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
    /// Smallest and largest width and height, px: `[[w, h], [w, h]]`; none of networks.
    pub size_range_px: Option<[[u32; 2]; 2]>,
    /// Images that were enlarged for gradients and spectra.
    pub n_enlarged: usize,
    /// Images that are the very file of an earlier one of the set.
    pub n_repeated: usize,
}

/// A set of images, or of crack networks, as histograms.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageSet {
    /// What it is made of.
    pub summary: SetSummary,
    pub(super) items: Vec<Item>,
    pub(super) features: &'static [Feature],
    pub(super) vectors: Option<FeatureVectors>,
}

impl ImageSet {
    /// What could be read, in its order; all images, or all networks. `origin` says where the vectors of the
    /// images come from, where they have some.
    ///
    /// # Errors
    /// [`EvalError::EmptySet`] where no image is left, [`EvalError::VectorLengths`] for vectors of different
    /// lengths, and what [`FeatureVectors::new`] says of vectors.
    pub fn new(
        name: &str,
        read: Vec<Result<Item, FailedImage>>,
        origin: Option<&str>,
    ) -> Result<Self, EvalError> {
        let (mut items, mut failed) = (Vec::new(), Vec::new());
        for one in read {
            match one {
                Ok(item) => items.push(item),
                Err(image) => failed.push(image),
            }
        }
        let Some(first) = items.first() else {
            return Err(EvalError::EmptySet {
                name: name.to_owned(),
                n_failed: failed.len(),
                first: failed.first().map_or_else(String::new, |image| {
                    format!(", the first: {:?}: {}", image.name, image.reason)
                }),
            });
        };
        let features = first.features;
        let vectors = match origin {
            Some(origin) => Some(vectors_of(origin, &mut items)?),
            None => None,
        };
        let sizes = items.iter().filter_map(|item| item.size_px);
        let sizes = sizes.map(|size| [size, size]);
        let size_range_px = sizes.reduce(|[[w, h], [wide, high]], [size, _]| {
            let least = [w.min(size[0]), h.min(size[1])];
            [least, [wide.max(size[0]), high.max(size[1])]]
        });
        let digests: BTreeSet<&str> = items.iter().map(|item| item.digest.as_str()).collect();
        let summary = SetSummary {
            name: name.to_owned(),
            n: items.len(),
            failed,
            size_range_px,
            n_enlarged: items.iter().filter(|item| item.is_enlarged).count(),
            n_repeated: items.len() - digests.len(),
        };
        Ok(Self {
            summary,
            items,
            features,
            vectors,
        })
    }

    /// Forgets what its images count.
    pub(super) fn drop_counts(&mut self) {
        for item in &mut self.items {
            item.counts = Vec::new();
            item.vector = Vec::new();
        }
    }

    /// Whether both have the same images by name: a clean set and its cracked twin. One image makes no pairs.
    pub(super) fn is_twin_of(&self, other: &Self) -> bool {
        let theirs = other.items.iter().map(|item| &item.name);
        self.items.len() > 1 && self.items.iter().map(|item| &item.name).eq(theirs)
    }

    /// How many of its files are in the other, too, by their bytes.
    pub(super) fn n_shared_with(&self, other: &Self) -> usize {
        let digests = other.items.iter().map(|item| item.digest.as_str());
        let digests: BTreeSet<&str> = digests.collect();
        let is_shared = |item: &&Item| digests.contains(item.digest.as_str());
        self.items.iter().filter(is_shared).count()
    }

    /// What a reader of its numbers must know.
    pub(super) fn notes(&self) -> Vec<String> {
        let SetSummary {
            name,
            n,
            failed,
            n_repeated,
            n_enlarged,
            ..
        } = &self.summary;
        let mut notes = Vec::new();
        let mut note = |what: String| notes.push(format!("{name:?}{what}"));
        match n {
            1 => note(" has one image: no floor of its own, no interval; nothing can be said of its distribution".to_owned()),
            2..20 => note(format!(
                " has {n} images: intervals and floors of so few are rough"
            )),
            _ => (),
        }
        if let Some(FailedImage { name, reason }) = failed.first() {
            note(format!(
                ": {} of {} images could not be read, the first: {name:?}: {reason}",
                failed.len(),
                failed.len() + n
            ));
        }
        if *n_repeated > 0 {
            note(format!(
                " has {n_repeated} images that are copies of others of it: they are not independent"
            ));
        }
        if *n_enlarged > 0 {
            note(format!(
                ": {n_enlarged} images were enlarged for gradients and spectra and lack fine detail by that"
            ));
        }
        notes
    }
}

/// The vectors of all items, which leave them.
fn vectors_of(origin: &str, items: &mut [Item]) -> Result<FeatureVectors, EvalError> {
    let n_a = items.first().map_or(0, |item| item.vector.len());
    let mut values = Vec::new();
    for item in items {
        let vector = std::mem::take(&mut item.vector);
        if vector.len() != n_a {
            let n_b = vector.len();
            return Err(EvalError::VectorLengths { n_a, n_b });
        }
        values.extend(vector.into_iter().map(f64::from));
    }
    FeatureVectors::new(origin, n_a, values)
}
