//! Copies of index files with some of their records.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use crate::error::DatasetError;
use crate::json_records::{JsonPart, JsonRecord, walk_json};

/// Writes a copy of an index file that has only some of its records.
///
/// `lists` are the keys of those lists of which `text_of` says what is written for a record, nothing where it is left
/// out; everything else is kept. `name` serves for messages.
pub(super) fn write_copy(
    path: &Path,
    name: &str,
    lists: &[&str],
    text_of: impl for<'r> FnMut(&JsonRecord<'r>) -> Result<Option<Cow<'r, str>>, DatasetError>,
    out: &mut dyn Write,
) -> Result<(), DatasetError> {
    let write_error = |source| DatasetError::SubsetWrite {
        name: name.to_owned(),
        source,
    };
    let mut copy = Copy {
        out,
        write_error,
        text_of,
        n_members: 0,
        n_records: 0,
    };
    let is_list = |key: &str| lists.contains(&key);
    let found = walk_json(path, is_list, |part| {
        // What is not JSON must be found before it is written again.
        if let JsonPart::Record(record @ JsonRecord { idx: None, .. }) = part {
            record.check(path)?;
        }
        copy.part(part)
    })?;
    let end: &[u8] = match (found.is_one_list, copy.n_members) {
        (true, _) => b"\n",
        (false, 0) => b"{}\n",
        (false, _) => b"}\n",
    };
    copy.out.write_all(end).map_err(write_error)
}

struct Copy<'o, E, T> {
    out: &'o mut dyn Write,
    write_error: E,
    text_of: T,
    n_members: usize,
    /// Records of the present list that were written.
    n_records: usize,
}

impl<E, T> Copy<'_, E, T>
where
    E: Fn(io::Error) -> DatasetError,
    T: for<'r> FnMut(&JsonRecord<'r>) -> Result<Option<Cow<'r, str>>, DatasetError>,
{
    fn part(&mut self, part: JsonPart<'_>) -> Result<(), DatasetError> {
        match part {
            JsonPart::Begin(key) => {
                self.n_records = 0;
                if !key.is_empty() {
                    self.key(key)?;
                }
                self.put("[")
            }
            JsonPart::End => self.put("]"),
            JsonPart::Record(record) if record.idx.is_none() => {
                self.key(record.key)?;
                self.put(record.text)
            }
            JsonPart::Record(record) => {
                let Some(text) = (self.text_of)(&record)? else {
                    return Ok(());
                };
                let before = if self.n_records == 0 { "\n" } else { ",\n" };
                self.n_records += 1;
                self.put(before)?;
                self.put(&text)
            }
        }
    }

    fn key(&mut self, key: &str) -> Result<(), DatasetError> {
        let before = if self.n_members == 0 { "{" } else { ",\n" };
        self.n_members += 1;
        self.put(&format!("{before}{}:", serde_json::Value::from(key)))
    }

    fn put(&mut self, text: &str) -> Result<(), DatasetError> {
        self.out
            .write_all(text.as_bytes())
            .map_err(&self.write_error)
    }
}

/// A record as it is, where it is kept.
pub(super) fn as_it_is<'r>(record: &JsonRecord<'r>, is_kept: bool) -> Option<Cow<'r, str>> {
    is_kept.then_some(Cow::Borrowed(record.text))
}
