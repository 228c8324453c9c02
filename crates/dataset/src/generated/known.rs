//! What is known of the images that are done: a record is checked against it, never against itself.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::sync::{Mutex, PoisonError};

use super::lists::read_list;
use super::{ItemRecord, SetLayout, is_there, name_head};
use crate::error::DatasetError;
use crate::line_log::LineLog;
use crate::provenance::blake3_hex;

/// The log of the images that were made since the lists were last finished.
pub(super) const MADE_LOG: &str = "made.jsonl";

/// The lines of the list of images, and those of the log beside it, a few bytes each.
#[derive(Debug)]
pub(super) struct KnownItems(Mutex<Known>);

#[derive(Debug)]
struct Known {
    /// By the head of the digest of a sample's name: that of its line.
    lines: BTreeMap<u64, u64>,
    log: LineLog,
}

impl KnownItems {
    /// Reads the list of a set whose `run.json` holds this text, and opens its log. A line that cannot
    /// be read is not known, and its image is made again.
    pub(super) fn open(layout: &SetLayout, run_text: &str) -> Result<Self, DatasetError> {
        let mut lines = BTreeMap::new();
        let list = layout.state("items.jsonl");
        if is_there(&list)? {
            for item in read_list::<ItemRecord>(&list)? {
                match item {
                    Ok(item) => _ = lines.insert(place(&item.name, item.sample), digest(&item)),
                    Err(DatasetError::Record { .. }) => {}
                    Err(DatasetError::Read { source, .. })
                        if source.kind() == ErrorKind::InvalidData => {}
                    Err(error) => return Err(error),
                }
            }
        }
        let identity = blake3_hex(run_text.as_bytes());
        let log = LineLog::open(&layout.state(MADE_LOG), &identity, &mut |line, _| {
            if let Ok(item) = serde_json::from_str::<ItemRecord>(line) {
                lines.insert(place(&item.name, item.sample), digest(&item));
            }
        })?;
        Ok(Self(Mutex::new(Known { lines, log })))
    }

    /// Whether this is what was written of the sample when it was made.
    pub(super) fn has(&self, item: &ItemRecord) -> bool {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.lines.get(&place(&item.name, item.sample)) == Some(&digest(item))
    }

    /// Notes a sample that has just been made.
    pub(super) fn note(&self, item: &ItemRecord) -> Result<(), DatasetError> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        _ = known.log.append(&item.to_line())?;
        known
            .lines
            .insert(place(&item.name, item.sample), digest(item));
        Ok(())
    }
}

fn place(name: &str, sample_idx: u32) -> u64 {
    name_head(&format!("{sample_idx}/{name}"))
}

fn digest(item: &ItemRecord) -> u64 {
    name_head(&item.to_line())
}
