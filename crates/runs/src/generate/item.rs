//! One sample of one image, from its file to the files of the set.

use image::DynamicImage;
use image::metadata::Orientation;
use serde_json::json;
use starbreak::{Stopwatch, Timings};
use starbreak_dataset::{
    DatasetError, GeneratedSet, ImageFile, ImageFormat, ImageLimits, ItemRecord, LabeledObject,
    MAX_ITEM_BYTES, Provenance, SampleFiles, SourceImage, blake3_hex, encode_image_as,
    encode_mask_as, read_image,
};
use starbreak_seed::Seed;

use super::Plan;
use super::damage::damage_of;
use crate::images::encoding;
use crate::patterns::Damaged;
use crate::provenance::{Sample, WrittenFile};
use crate::{Error, RunContext};

/// The bytes that one sample of an image becomes.
pub(super) struct MadeItem {
    /// BLAKE3 of the source's file.
    input_blake3: String,
    pub(super) image: Vec<u8>,
    pub(super) region: Option<Vec<u8>>,
    pub(super) crack: Option<Vec<u8>>,
    pub(super) provenance: Vec<u8>,
    /// What the image shows.
    pub(super) pixels: DynamicImage,
    /// Share of the frame in the region.
    pub(super) region_fraction: f64,
    pub(super) is_intact: bool,
    pub(super) timings: Timings,
}

impl Plan<'_> {
    /// Makes one sample of an image, in memory.
    pub(super) fn make(
        &self,
        image: &SourceImage,
        sample_idx: u32,
        files: &SampleFiles,
    ) -> Result<MadeItem, Error> {
        let mut watch = Stopwatch::start();
        let file = read_image(&image.path, &ImageLimits::default())?;
        watch.lap("read");
        let objects = self.objects_of(image)?;
        let item = Item {
            name: &image.name,
            objects: &objects,
            sample_idx,
            files,
        };
        let damage_for = |size, seed, watch: &mut Stopwatch| {
            // The glass stands before the lens, which moves it with what it hides.
            let frame = (size, Some(image.objects.as_slice()));
            let settings = &self.context.settings;
            self.patterns.for_frame(settings, frame, seed, watch)
        };
        item.made(self.context, damage_for, file, watch)
            .map_err(|error| Error::of_image(&image.path, error))
    }
}

/// One sample of an image.
pub(super) struct Item<'a> {
    /// Name of the image in its source, which the seed is keyed by.
    pub(super) name: &'a str,
    /// Where the image shows them in the end.
    pub(super) objects: &'a [LabeledObject],
    pub(super) sample_idx: u32,
    pub(super) files: &'a SampleFiles,
}

impl Item<'_> {
    /// The image behind the damage that `damage_for` gives for a size and the seed of the item.
    pub(super) fn made(
        &self,
        context: &RunContext,
        damage_for: impl FnOnce((u32, u32), Seed, &mut Stopwatch) -> Result<Damaged, Error>,
        mut file: ImageFile,
        mut watch: Stopwatch,
    ) -> Result<MadeItem, Error> {
        let settings = &context.settings;
        if matches!(file.format, ImageFormat::WebP | ImageFormat::Bmp) {
            return Err(Error::SetOutput {
                why: "WebP and BMP are read, not written, and images of a set keep their names and formats; convert it \
                      to PNG",
            });
        }
        let seed = context.seed.of_item(self.name, self.sample_idx.into());
        let size = (file.pixels.width(), file.pixels.height());
        let Damaged {
            chain,
            crack_mask_png,
        } = damage_for(size, seed, &mut watch)?;
        let boxes_px: Vec<[f64; 4]> = self.objects.iter().map(|object| object.box_px).collect();
        let shown = chain.over_and_report(&mut file.pixels, seed, &boxes_px, &mut watch)?;

        let image = encode_image_as(&file, &encoding(settings, &file)?)?;
        let masks = if settings.output.masks {
            let is_upright = file.orientation == Orientation::NoTransforms;
            let crack = match crack_mask_png {
                Some(png) if is_upright && shown.arrival.is_none() => png,
                _ => encode_mask_as(&chain.crack_mask_of(&shown)?, &file)?,
            };
            Some((encode_mask_as(&shown.region, &file)?, crack))
        } else {
            None
        };
        watch.lap("encode");

        let (region, crack) = masks.unzip();
        let names = self.files;
        let outputs = [
            ("output", &names.image, Some(&image)),
            ("region", &names.region, region.as_ref()),
            ("crack", &names.crack, crack.as_ref()),
        ];
        let files = outputs
            .into_iter()
            .filter_map(|(key, name, bytes)| Some((key, WrittenFile::of(name, bytes?))));
        let sample = Sample {
            name: self.name,
            sample_idx: self.sample_idx,
            seed,
            size,
            input_blake3: &file.blake3,
            files: files.collect(),
            facts: chain.facts(),
            shown: &shown,
        };
        // It repeats to the byte, so it holds no times.
        let mut record = context.record(sample, None);
        let objects = damage_of(self.objects, &shown.damage);
        record.insert("objects".to_owned(), json!(objects));
        let provenance = Provenance::new(record.into())?.to_bytes();
        watch.lap("record");
        Ok(MadeItem {
            input_blake3: file.blake3,
            image,
            region,
            crack,
            provenance,
            pixels: file.pixels,
            region_fraction: shown.region_fraction,
            is_intact: chain.is_intact(),
            timings: watch.stop(),
        })
    }
}

impl MadeItem {
    /// Puts the files in their places, the record last, and notes that they are made.
    pub(super) fn put(&self, set: &GeneratedSet, name: &str, sample_idx: u32) -> Result<(), Error> {
        let mut batch = set.batch();
        let layout = set.layout();
        let files = layout.files_of(name, sample_idx);
        batch.stage(&layout.path(&files.image), &self.image)?;
        let masks = [(&files.region, &self.region), (&files.crack, &self.crack)];
        for (name, bytes) in masks {
            if let Some(bytes) = bytes {
                batch.stage(&layout.path(name), bytes)?;
            }
        }
        check_record_len(&files.provenance, self.provenance.len())?;
        batch.stage(&layout.path(&files.provenance), &self.provenance)?;
        batch.commit()?;
        Ok(set.note_made(&self.line(name, sample_idx))?)
    }

    /// What the list of the set says of it.
    pub(super) fn line(&self, name: &str, sample_idx: u32) -> ItemRecord {
        let hash = |bytes: &Option<Vec<u8>>| bytes.as_ref().map(|bytes| blake3_hex(bytes));
        ItemRecord {
            name: name.to_owned(),
            sample: sample_idx,
            input_blake3: self.input_blake3.clone(),
            image_blake3: blake3_hex(&self.image),
            region_blake3: hash(&self.region),
            crack_blake3: hash(&self.crack),
            provenance_blake3: blake3_hex(&self.provenance),
        }
    }

    /// Bytes of all its files.
    pub(super) fn n_bytes(&self) -> u64 {
        let masks = [&self.region, &self.crack].into_iter().flatten();
        let masks: usize = masks.map(Vec::len).sum();
        (self.image.len() + masks + self.provenance.len()) as u64
    }
}

/// A record that nobody would read back is not written.
fn check_record_len(name: &str, n_bytes: usize) -> Result<(), DatasetError> {
    if n_bytes as u64 <= MAX_ITEM_BYTES {
        return Ok(());
    }
    Err(DatasetError::FileTooLong {
        name: name.to_owned(),
        max_bytes: MAX_ITEM_BYTES,
    })
}
