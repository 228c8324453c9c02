//! One sample of one image, from its file to the files of the set.

use image::DynamicImage;
use image::metadata::Orientation;
use serde_json::{Map, Value, json};
use starbreak_dataset::{
    DatasetError, Encoding, GeneratedSet, ImageFile, ImageFormat, ImageLimits, ItemRecord,
    LabeledObject, MAX_ITEM_BYTES, Provenance, SampleFiles, SourceImage, blake3_hex,
    encode_image_as, encode_mask_as, read_image,
};
use starbreak_seed::Seed;

use super::Plan;
use super::damage::damage_of;
use crate::Error;
use crate::pipeline::{
    OpticsReport, PROVENANCE_SCHEMA, ReadyCrack, RunContext, Shown, Stopwatch, Timings,
};

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
        let item = Item {
            name: &image.name,
            objects: &image.objects,
            sample_idx,
            files,
        };
        let pattern_of = |size, seed, watch: &mut Stopwatch| {
            self.patterns
                .for_item(self.context, (size, &image.objects), seed, watch)
        };
        item.made(self.context, pattern_of, file, watch)
            .map_err(|error| Error::of_image(&image.path, error))
    }
}

/// One sample of an image.
pub(super) struct Item<'a> {
    /// Name of the image in its source, which the seed is keyed by.
    pub(super) name: &'a str,
    pub(super) objects: &'a [LabeledObject],
    pub(super) sample_idx: u32,
    pub(super) files: &'a SampleFiles,
}

impl Item<'_> {
    /// The image behind the crack that `pattern_of` gives for a size and the seed of the item.
    pub(super) fn made(
        &self,
        context: &RunContext,
        pattern_of: impl FnOnce((u32, u32), Seed, &mut Stopwatch) -> Result<ReadyCrack, Error>,
        mut file: ImageFile,
        mut watch: Stopwatch,
    ) -> Result<MadeItem, Error> {
        let settings = &context.settings;
        let seed = context.seed.of_item(self.name, self.sample_idx.into());
        let size = (file.pixels.width(), file.pixels.height());
        let pattern = pattern_of(size, seed, &mut watch)?;
        let (before, shown) =
            pattern
                .baked
                .over_keeping(settings, &mut file.pixels, seed, &mut watch)?;
        let contrast = before.contrast(&file.pixels, &shown.region)?;
        watch.lap("contrast");
        let objects = damage_of(self.objects, (&before, &file.pixels), &shown, settings);
        watch.lap("damage");

        let quality = settings.output.quality;
        let encoding = match file.format {
            ImageFormat::Jpeg => Encoding::Jpeg { quality },
            ImageFormat::Png => Encoding::Png,
        };
        let bytes = encode_image_as(&file, &encoding)?;
        let masks = if settings.output.masks {
            let is_upright = file.orientation == Orientation::NoTransforms;
            let crack = match &pattern.crack_mask_png {
                Some(png) if is_upright => png.clone(),
                _ => encode_mask_as(&pattern.baked.crack_mask()?, &file)?,
            };
            Some((encode_mask_as(&shown.region, &file)?, crack))
        } else {
            None
        };
        watch.lap("encode");

        let region_fraction = region_fraction(&shown);
        let (region, crack) = masks.unzip();
        let files = self.files;
        let record = self.record(
            context,
            &Record {
                seed,
                size,
                input_blake3: &file.blake3,
                outputs: [
                    ("output", &files.image, Some(&bytes)),
                    ("region", &files.region, region.as_ref()),
                    ("crack", &files.crack, crack.as_ref()),
                ],
                pattern: &pattern,
                optics: &OpticsReport {
                    contrast,
                    scene: shown.scene,
                },
                region_fraction,
                objects,
            },
        )?;
        watch.lap("record");
        Ok(MadeItem {
            input_blake3: file.blake3,
            image: bytes,
            region,
            crack,
            provenance: record.to_bytes(),
            pixels: file.pixels,
            region_fraction,
            is_intact: pattern.is_intact,
            timings: watch.stop(),
        })
    }

    /// The record of a sample; it repeats to the byte, so it holds no times.
    fn record(&self, context: &RunContext, of: &Record<'_>) -> Result<Provenance, Error> {
        let name = self.name;
        let mut camera = json!({ "width_px": of.size.0, "height_px": of.size.1 });
        if let Some(scene) = &of.optics.scene {
            camera["f_px"] = scene.f_px.into();
            camera["glass_disc_px"] = scene.glass_disc_px.into();
            camera["scene_disc_px"] = scene.scene_disc_px.into();
        }
        let mut record = Map::from_iter([
            ("schema".to_owned(), json!(PROVENANCE_SCHEMA)),
            (
                "generator".to_owned(),
                json!({ "name": "starbreak", "version": env!("CARGO_PKG_VERSION") }),
            ),
            ("recipe_sha256".to_owned(), json!(context.recipe_sha256)),
            ("seed".to_owned(), json!(context.seed.0)),
            (
                "item".to_owned(),
                json!({ "name": name, "sample_index": self.sample_idx, "seed": of.seed.0 }),
            ),
            ("camera".to_owned(), camera),
            (
                "input".to_owned(),
                json!({ "name": name, "blake3": of.input_blake3 }),
            ),
        ]);
        for (key, name, bytes) in of.outputs {
            if let Some(bytes) = bytes {
                let file = json!({ "name": name, "blake3": blake3_hex(bytes) });
                record.insert(key.to_owned(), file);
            }
        }
        record.extend(of.pattern.facts.clone());
        record.insert("optics".to_owned(), of.optics.to_json());
        record.insert("region_fraction".to_owned(), json!(of.region_fraction));
        record.insert("objects".to_owned(), json!(of.objects));
        Ok(Provenance::new(Value::Object(record))?)
    }
}

/// What the record of a sample is made of.
struct Record<'a> {
    seed: Seed,
    size: (u32, u32),
    input_blake3: &'a str,
    /// Key, name and bytes.
    outputs: [(&'a str, &'a String, Option<&'a Vec<u8>>); 3],
    pattern: &'a ReadyCrack,
    optics: &'a OpticsReport,
    region_fraction: f64,
    objects: Vec<Value>,
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

fn region_fraction(shown: &Shown) -> f64 {
    let region = shown.region.as_raw();
    // In blocks whose count fits a byte, so that many are counted at once.
    let n_in_block = |block: &[u8]| block.iter().fold(0_u8, |n, code| n + u8::from(*code > 0));
    let n_changed: u64 = region
        .chunks(255)
        .map(|block| u64::from(n_in_block(block)))
        .sum();
    #[expect(clippy::cast_precision_loss, reason = "counts of pixels")]
    let fraction = n_changed as f64 / region.len().max(1) as f64;
    fraction
}
