//! Which images are done, and the hashes of what they became.

use std::fs;
use std::io::ErrorKind;

use serde::{Deserialize, Serialize};

use super::{GeneratedSet, MAX_RECORD_BYTES, SetLayout};
use crate::error::DatasetError;
use crate::provenance::sha256_file;
use crate::text_file::read_text;

/// One sample of one image: a line of `items.jsonl`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ItemRecord {
    /// Name of the image in the source.
    pub name: String,
    /// Which sample of it.
    pub sample: u32,
    /// SHA-256 of the source's file.
    pub input_sha256: String,
    /// SHA-256 of the image.
    pub image_sha256: String,
    /// SHA-256 of the region mask, where one was written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region_sha256: Option<String>,
    /// SHA-256 of the crack mask, where one was written.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crack_sha256: Option<String>,
    /// SHA-256 of the record.
    pub provenance_sha256: String,
}

impl GeneratedSet {
    /// The record of a sample that is done: its provenance, which is put in place last, is there
    /// and belongs to this run, and so are its pictures. None where it is still to be done.
    ///
    /// # Errors
    /// [`DatasetError::Read`] where the disk cannot be asked.
    pub fn done(&self, name: &str, sample_idx: u32) -> Result<Option<ItemRecord>, DatasetError> {
        self.layout.done(name, sample_idx)
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
    sha256: String,
}

impl SetLayout {
    /// As [`GeneratedSet::done`], of a set that no run need be at work on.
    ///
    /// # Errors
    /// [`DatasetError::Read`] where the disk cannot be asked.
    pub fn done(&self, name: &str, sample_idx: u32) -> Result<Option<ItemRecord>, DatasetError> {
        let files = self.files_of(name, sample_idx);
        let path = self.path(&files.provenance);
        let file = match read_text(&path, MAX_RECORD_BYTES) {
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
        let (input_sha256, image_sha256) = (record.input.sha256, record.output.sha256);
        let of = |file: Option<NamedFile>| file.map(|file| file.sha256);
        let (region_sha256, crack_sha256) = (of(record.region), of(record.crack));
        let wanted = [
            Some(&files.image),
            region_sha256.as_ref().map(|_| &files.region),
            crack_sha256.as_ref().map(|_| &files.crack),
        ];
        let are_there = wanted
            .into_iter()
            .flatten()
            .all(|name| fs::metadata(self.path(name)).is_ok_and(|file| file.is_file()));
        Ok((is_this && are_there).then(|| ItemRecord {
            name: name.to_owned(),
            sample: sample_idx,
            input_sha256,
            image_sha256,
            region_sha256,
            crack_sha256,
            provenance_sha256: file.sha256,
        }))
    }

    /// Whether image and masks of a sample have the bytes that its record says. A file that cannot be
    /// read has not.
    #[must_use]
    pub fn is_unaltered(&self, item: &ItemRecord) -> bool {
        let files = self.files_of(&item.name, item.sample);
        let hashes = [
            (&files.image, Some(&item.image_sha256)),
            (&files.region, item.region_sha256.as_ref()),
            (&files.crack, item.crack_sha256.as_ref()),
        ];
        hashes.iter().all(|(name, sha256)| {
            sha256.is_none_or(|sha256| {
                sha256_file(&self.path(name)).is_ok_and(|found| found == *sha256)
            })
        })
    }
}
