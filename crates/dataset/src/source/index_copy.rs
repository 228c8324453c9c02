//! Copies of index files with some of their records.

use std::io::{self, Write};
use std::path::Path;

use crate::error::DatasetError;
use crate::json_records::{JsonPart, JsonRecord, walk_json};

/// Writes a copy of an index file that has only some of its records.
///
/// `lists` are the keys of those lists of which `keeps` says which records are kept; everything else is
/// kept. `name` serves for messages.
pub(super) fn write_copy(
    path: &Path,
    name: &str,
    lists: &[&str],
    keeps: impl FnMut(&JsonRecord<'_>) -> bool,
    out: &mut dyn Write,
) -> Result<(), DatasetError> {
    let write_error = |source| DatasetError::SubsetWrite {
        name: name.to_owned(),
        source,
    };
    let mut copy = Copy {
        out,
        keeps,
        n_members: 0,
        n_records: 0,
    };
    let is_list = |key: &str| lists.contains(&key);
    let found = walk_json(path, is_list, |part| {
        // What is not JSON must be found before it is written again.
        if let JsonPart::Record(record @ JsonRecord { idx: None, .. }) = part {
            record.check(path)?;
        }
        copy.part(part).map_err(write_error)
    })?;
    let end: &[u8] = match (found.is_one_list, copy.n_members) {
        (true, _) => b"\n",
        (false, 0) => b"{}\n",
        (false, _) => b"}\n",
    };
    copy.out.write_all(end).map_err(write_error)
}

struct Copy<'o, K> {
    out: &'o mut dyn Write,
    keeps: K,
    n_members: usize,
    /// Records of the present list that were written.
    n_records: usize,
}

impl<K: FnMut(&JsonRecord<'_>) -> bool> Copy<'_, K> {
    fn part(&mut self, part: JsonPart<'_>) -> io::Result<()> {
        match part {
            JsonPart::Begin(key) => {
                self.n_records = 0;
                if !key.is_empty() {
                    self.key(key)?;
                }
                write!(self.out, "[")
            }
            JsonPart::End => write!(self.out, "]"),
            JsonPart::Record(record) if record.idx.is_none() => {
                self.key(record.key)?;
                self.out.write_all(record.text.as_bytes())
            }
            JsonPart::Record(record) if (self.keeps)(&record) => {
                let before = if self.n_records == 0 { "\n" } else { ",\n" };
                self.n_records += 1;
                self.out.write_all(before.as_bytes())?;
                self.out.write_all(record.text.as_bytes())
            }
            JsonPart::Record(_) => Ok(()),
        }
    }

    fn key(&mut self, key: &str) -> io::Result<()> {
        let before = if self.n_members == 0 { "{" } else { ",\n" };
        self.n_members += 1;
        write!(self.out, "{before}{}:", serde_json::to_string(key)?)
    }
}
