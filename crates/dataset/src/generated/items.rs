//! Which images are done, and the hashes of what they became.

use std::fs;
use std::io::ErrorKind;

use serde::{Deserialize, Serialize};

use super::{GeneratedSet, MAX_ITEM_BYTES, SetLayout};
use crate::error::DatasetError;
use crate::provenance::{blake3_file, blake3_hex};
use crate::source::LabeledObject;
use crate::text_file::read_text;

/// One sample of one image: a line of `items.jsonl`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ItemRecord {
    /// Name of the image in the source.
    pub name: String,
    /// Which sample of it.
    pub sample: u32,
    /// BLAKE3 of the source's file.
    pub input_blake3: String,
    /// BLAKE3 of the image.
    pub image_blake3: String,
    /// BLAKE3 of the region mask, where one was written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region_blake3: Option<String>,
    /// BLAKE3 of the crack mask, where one was written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crack_blake3: Option<String>,
    /// BLAKE3 of the record.
    pub provenance_blake3: String,
}

impl ItemRecord {
    /// Its line in the list, without the end.
    pub(super) fn to_line(&self) -> String {
        // A record of texts and numbers always has a JSON form.
        serde_json::to_string(self).unwrap_or_default()
    }
}

impl GeneratedSet {
    /// The record of a sample that is done: its provenance, which is put in place last, is there
    /// as it was written, and so are its pictures. None where it is still to be done.
    ///
    /// # Errors
    /// [`DatasetError::Read`] where the disk cannot be asked.
    pub fn done(&self, name: &str, sample_idx: u32) -> Result<Option<ItemRecord>, DatasetError> {
        let done = self.layout.done(name, sample_idx)?;
        Ok(done.filter(|item| self.known.has(item)))
    }

    /// Notes a sample whose files have just been put in place.
    ///
    /// # Errors
    /// [`DatasetError::Write`].
    pub fn note_made(&self, item: &ItemRecord) -> Result<(), DatasetError> {
        self.known.note(item)
    }
}

/// What a record says of the labels that it was made with.
#[derive(Deserialize)]
struct Labels {
    objects: Vec<Label>,
}

#[derive(Deserialize)]
struct Label {
    record: String,
    category: String,
    kind: String,
    box_px: [f64; 4],
}

impl Label {
    fn is_of(&self, object: &LabeledObject) -> bool {
        let bits = |box_px: &[f64; 4]| box_px.map(f64::to_bits);
        self.record == object.record
            && self.category == object.category
            && self.kind == object.kind.name()
            && bits(&self.box_px) == bits(&object.box_px)
    }
}

/// What is wanted of a sample's record.
#[derive(Deserialize)]
struct Sample {
    item: Item,
    input: NamedFile,
    output: NamedFile,
    region: Option<NamedFile>,
    crack: Option<NamedFile>,
}

#[derive(Deserialize)]
struct Item {
    sample_index: u32,
}

#[derive(Deserialize)]
struct NamedFile {
    name: String,
    blake3: String,
}

impl SetLayout {
    /// As [`GeneratedSet::done`], of a set that no run need be at work on.
    ///
    /// # Errors
    /// [`DatasetError::Read`] where the disk cannot be asked.
    pub fn done(&self, name: &str, sample_idx: u32) -> Result<Option<ItemRecord>, DatasetError> {
        let files = self.files_of(name, sample_idx);
        let record = self.recorded(name, sample_idx)?;
        Ok(record.filter(|record| {
            let wanted = [
                Some(&files.image),
                record.region_blake3.as_ref().map(|_| &files.region),
                record.crack_blake3.as_ref().map(|_| &files.crack),
            ];
            let is_there =
                |name: &String| fs::metadata(self.path(name)).is_ok_and(|it| it.is_file());
            wanted.into_iter().flatten().all(is_there)
        }))
    }

    /// What the record of a sample says, whether its image and its masks are there or not.
    ///
    /// # Errors
    /// [`DatasetError::Read`] where the disk cannot be asked.
    pub fn recorded(
        &self,
        name: &str,
        sample_idx: u32,
    ) -> Result<Option<ItemRecord>, DatasetError> {
        let path = self.path(&self.files_of(name, sample_idx).provenance);
        let file = match read_text(&path, MAX_ITEM_BYTES) {
            Ok(file) => file,
            Err(DatasetError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => {
                return Ok(None);
            }
            // What is not whole is made again, unless the disk cannot even say that it is there.
            Err(_) => return super::is_there(&path).map(|_| None),
        };
        let Ok(record) = serde_json::from_str::<Sample>(&file.text) else {
            return Ok(None);
        };
        let is_this = record.input.name == name && record.item.sample_index == sample_idx;
        let (input_blake3, image_blake3) = (record.input.blake3, record.output.blake3);
        let of = |file: Option<NamedFile>| file.map(|file| file.blake3);
        let (region_blake3, crack_blake3) = (of(record.region), of(record.crack));
        Ok(is_this.then(|| ItemRecord {
            name: name.to_owned(),
            sample: sample_idx,
            input_blake3,
            image_blake3,
            region_blake3,
            crack_blake3,
            provenance_blake3: blake3_hex(file.text.as_bytes()),
        }))
    }

    /// Removes an image of a set of one sample each; it may be gone already. Its record stays.
    ///
    /// # Errors
    /// [`DatasetError::Write`].
    pub fn remove_image(&self, name: &str) -> Result<(), DatasetError> {
        let path = self.path(name);
        match fs::remove_file(&path) {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                Err(DatasetError::Write { path, source })
            }
            _ => Ok(()),
        }
    }

    /// Whether the record of a sample is about these objects, in their order.
    #[must_use]
    pub fn has_labels(&self, name: &str, sample_idx: u32, objects: &[LabeledObject]) -> bool {
        let path = self.path(&self.files_of(name, sample_idx).provenance);
        let Ok(file) = read_text(&path, MAX_ITEM_BYTES) else {
            return false;
        };
        serde_json::from_str::<Labels>(&file.text).is_ok_and(|labels| {
            labels.objects.len() == objects.len()
                && labels
                    .objects
                    .iter()
                    .zip(objects)
                    .all(|(label, object)| label.is_of(object))
        })
    }

    /// Whether image and masks of a sample have the bytes that its record says. A file that cannot be
    /// read has not.
    #[must_use]
    pub fn is_unaltered(&self, item: &ItemRecord) -> bool {
        let files = self.files_of(&item.name, item.sample);
        let hashes = [
            (&files.image, Some(&item.image_blake3)),
            (&files.region, item.region_blake3.as_ref()),
            (&files.crack, item.crack_blake3.as_ref()),
        ];
        hashes.iter().all(|(name, blake3)| {
            blake3.is_none_or(|blake3| {
                blake3_file(&self.path(name)).is_ok_and(|found| found == *blake3)
            })
        })
    }
}
