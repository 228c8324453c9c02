//! One image as bytes to the files that it becomes in a set: for runners that read and write on their
//! own, such as a cluster's.

use std::path::Path;

use starbreak::Stopwatch;
use starbreak_dataset::{ImageLimits, LabeledObject, SetLayout, decode_image};

use super::item::Item;
use super::refuse_outputs;
use crate::bank::PatternBank;
use crate::patterns::Damaged;
use crate::{Error, Patterns, RunContext};

/// The files that one sample of an image becomes.
#[derive(Debug, Clone, PartialEq)]
pub struct CrackedFiles {
    /// Names from the root of the set, and bytes: the image, its region and crack masks if the recipe
    /// wants masks, its record, which is to be written last.
    pub files: Vec<(String, Vec<u8>)>,
    /// Share of the frame in the region.
    pub region_fraction: f64,
    /// Whether nothing is broken.
    pub is_intact: bool,
}

/// What [`generate`](super::generate) makes of an image without labels: the same bytes under the same
/// names.
///
/// `name` is that of the image in its source, which its crack is keyed by, beside the seed and
/// `sample_idx`, the number of the sample out of `n_samples`. The crack is made by the recipe of the
/// context, or comes out of a bank, whose recipe the context then has.
///
/// # Errors
/// [`Error::OfImage`] for bytes that are no image, or an image that cannot be broken;
/// [`Error::SetOutput`] for a recipe with another format or with maps; [`Error::Dataset`] for a name
/// that leaves the set.
pub fn crack_file(
    context: &RunContext,
    bank: Option<&PatternBank>,
    name: &str,
    (sample_idx, n_samples): (u32, u32),
    bytes: &[u8],
) -> Result<CrackedFiles, Error> {
    refuse_outputs(&context.settings.output)?;
    let layout = SetLayout::new(Path::new(""), n_samples);
    layout.safe(name)?;
    let names = layout.files_of(name, sample_idx);
    let item = Item {
        name,
        objects: &[],
        sample_idx,
        files: &names,
    };
    let none: &[LabeledObject] = &[];
    let damage_for = |size, seed, watch: &mut Stopwatch| match bank {
        Some(bank) => Damaged::of_bank(bank, &context.settings, (size, seed), watch),
        None => Patterns::Fresh.for_frame(&context.settings, (size, Some(none)), seed, watch),
    };
    let made = decode_image(name, bytes, &ImageLimits::default())
        .map_err(Error::from)
        .and_then(|file| item.made(context, damage_for, file, Stopwatch::start()))
        .map_err(|error| Error::of_image(Path::new(name), error))?;
    let files = [
        (names.image, Some(made.image)),
        (names.region, made.region),
        (names.crack, made.crack),
        (names.provenance, Some(made.provenance)),
    ];
    Ok(CrackedFiles {
        files: files
            .into_iter()
            .filter_map(|(name, bytes)| Some((name, bytes?)))
            .collect(),
        region_fraction: made.region_fraction,
        is_intact: made.is_intact,
    })
}
