//! JSON files with long lists of records, one record at a time, in memory that does not depend on
//! the length of the file.

mod members;
mod record;

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use crate::error::DatasetError;
use crate::ordinary_file::open_file;
pub(crate) use members::JsonMembers;
pub(crate) use record::reason_of;
pub use record::{JsonRecord, RecordFault};

/// Bytes that are read at once.
const BLOCK_BYTES: usize = 1 << 20;

/// Longest record, in bytes; the outline of an object may take some ten thousand.
const MAX_RECORD_BYTES: usize = 1 << 26;

/// Deepest nesting inside a record: that of `serde_json`.
const MAX_DEPTH: usize = 127;

/// A part of a file.
pub(crate) enum JsonPart<'a> {
    /// A list of records begins; its key is empty where it is the whole file.
    Begin(&'a str),
    Record(JsonRecord<'a>),
    /// The list ends.
    End,
}

/// What lists a file has.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct JsonLists {
    /// Whether the file is one list.
    pub is_one_list: bool,
    /// The keys of members which are lists, in the order of the file.
    pub keys: Vec<String>,
}

impl JsonLists {
    /// Whether there is a list of this key.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.keys.iter().any(|known| known == key)
    }
}

/// Gives each record of a JSON file to `take`: the elements of its lists and its other members, in
/// the order of the file, which is one list or one object.
///
/// No more is held than one record, of at most 64 MiB and 127 levels.
///
/// # Errors
/// [`DatasetError::Read`] and [`DatasetError::NotAFile`]; [`DatasetError::JsonText`] with the place
/// of the byte where the file is no such JSON or ends too early; what `take` returns.
pub fn read_json_records<E: From<DatasetError>>(
    path: &Path,
    mut take: impl FnMut(JsonRecord<'_>) -> Result<(), E>,
) -> Result<JsonLists, E> {
    // A list under no key could not be told from a file that is one list: it is given whole.
    walk_json(
        path,
        |key| !key.is_empty(),
        |part| match part {
            JsonPart::Record(record) => take(record),
            JsonPart::Begin(_) | JsonPart::End => Ok(()),
        },
    )
}

/// The same with the ends of lists, where of the members of an object those of some keys only are
/// taken for lists of records.
pub(crate) fn walk_json<E: From<DatasetError>>(
    path: &Path,
    is_list: impl Fn(&str) -> bool,
    mut take: impl FnMut(JsonPart<'_>) -> Result<(), E>,
) -> Result<JsonLists, E> {
    let mut text = Text {
        path: path.to_owned(),
        file: open_file(path)?,
        buffer: Vec::new(),
        at: 0,
        start: 0,
        is_at_end: false,
    };
    let mut lists = JsonLists::default();
    match text.next_token()? {
        Some(b'[') => {
            lists.is_one_list = true;
            text.list("", &mut take)?;
        }
        Some(b'{') => text.object(&mut lists, &is_list, &mut take)?,
        Some(_) => return Err(text.wrong(0, "expected a list or an object").into()),
        None => return Err(text.wrong(0, "the file has no content").into()),
    }
    match text.next_token()? {
        None => Ok(lists),
        Some(_) => Err(text.wrong(0, "there is more after the end").into()),
    }
}

/// A file and a window of it.
struct Text {
    path: PathBuf,
    file: File,
    /// The bytes of the window.
    buffer: Vec<u8>,
    /// Where reading goes on in the window.
    at: usize,
    /// Where the window begins in the file.
    start: u64,
    is_at_end: bool,
}

impl Text {
    /// The error at so many bytes behind the place of reading.
    fn wrong(&self, behind: usize, reason: &str) -> DatasetError {
        DatasetError::JsonText {
            path: self.path.clone(),
            at_byte: self.offset() + u64::try_from(behind).unwrap_or(u64::MAX),
            reason: reason.to_owned(),
        }
    }

    fn offset(&self) -> u64 {
        self.start + u64::try_from(self.at).unwrap_or(u64::MAX)
    }

    /// Reads more of the file behind the window, of which all before the place of reading goes.
    fn refill(&mut self) -> Result<bool, DatasetError> {
        if self.is_at_end {
            return Ok(false);
        }
        self.start = self.offset();
        self.buffer.drain(..self.at);
        self.at = 0;
        let block = u64::try_from(BLOCK_BYTES).unwrap_or(u64::MAX);
        let n_read = (&mut self.file)
            .take(block)
            .read_to_end(&mut self.buffer)
            .map_err(|source| DatasetError::Read {
                path: self.path.clone(),
                source,
            })?;
        self.is_at_end = n_read == 0;
        Ok(n_read > 0)
    }

    /// The next byte that is not white space; it is not taken.
    fn next_token(&mut self) -> Result<Option<u8>, DatasetError> {
        loop {
            while let Some(&byte) = self.buffer.get(self.at) {
                if !matches!(byte, b' ' | b'\n' | b'\r' | b'\t') {
                    return Ok(Some(byte));
                }
                self.at += 1;
            }
            if !self.refill()? {
                return Ok(None);
            }
        }
    }

    fn token(&mut self) -> Result<u8, DatasetError> {
        match self.next_token()? {
            Some(byte) => Ok(byte),
            None => Err(self.wrong(0, "the file ends too early")),
        }
    }

    /// The elements of the list that begins here.
    fn list<E: From<DatasetError>>(
        &mut self,
        key: &str,
        take: &mut impl FnMut(JsonPart<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        take(JsonPart::Begin(key))?;
        self.at += 1;
        if self.token()? == b']' {
            self.at += 1;
            return take(JsonPart::End);
        }
        for idx in 0.. {
            self.token()?;
            self.value(key, Some(idx), take)?;
            match self.token()? {
                b',' => self.at += 1,
                b']' => {
                    self.at += 1;
                    break;
                }
                _ => {
                    return Err(self
                        .wrong(0, "expected a comma or the end of a list")
                        .into());
                }
            }
        }
        take(JsonPart::End)
    }

    /// The members of the object that begins here.
    fn object<E: From<DatasetError>>(
        &mut self,
        lists: &mut JsonLists,
        is_list: &impl Fn(&str) -> bool,
        take: &mut impl FnMut(JsonPart<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.at += 1;
        if self.token()? == b'}' {
            self.at += 1;
            return Ok(());
        }
        loop {
            if self.token()? != b'"' {
                return Err(self.wrong(0, "expected a key in quotes").into());
            }
            let n_bytes = self.extent()?;
            let bytes = self.buffer.get(self.at..self.at + n_bytes);
            let key: Option<String> = bytes.and_then(|b| serde_json::from_slice(b).ok());
            let Some(key) = key else {
                return Err(self.wrong(0, "the key is no JSON text").into());
            };
            self.at += n_bytes;
            if self.token()? != b':' {
                return Err(self.wrong(0, "expected a colon").into());
            }
            self.at += 1;
            if self.token()? == b'[' && is_list(&key) {
                if lists.keys.contains(&key) {
                    let reason = format!("the list {key:?} occurs twice");
                    return Err(self.wrong(0, &reason).into());
                }
                self.list(&key, take)?;
                lists.keys.push(key);
            } else {
                self.value(&key, None, take)?;
            }
            match self.token()? {
                b',' => self.at += 1,
                b'}' => {
                    self.at += 1;
                    return Ok(());
                }
                _ => {
                    return Err(self
                        .wrong(0, "expected a comma or the end of an object")
                        .into());
                }
            }
        }
    }

    /// Gives away the value that begins here.
    fn value<E: From<DatasetError>>(
        &mut self,
        key: &str,
        idx: Option<u64>,
        take: &mut impl FnMut(JsonPart<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let n_bytes = self.extent()?;
        let offset = self.offset();
        let bytes = self.buffer.get(self.at..self.at + n_bytes).unwrap_or(&[]);
        let text = std::str::from_utf8(bytes)
            .map_err(|error| self.wrong(error.valid_up_to(), "it is not UTF-8 text"))?;
        take(JsonPart::Record(JsonRecord {
            key,
            idx,
            offset,
            text,
        }))?;
        self.at += n_bytes;
        Ok(())
    }

    /// How many bytes the value has that begins here; all of them are in the window then.
    fn extent(&mut self) -> Result<usize, DatasetError> {
        let mut scan = Scan::default();
        loop {
            let seen = self.buffer.get(self.at..).unwrap_or(&[]);
            match scan.go_on(seen) {
                Ok(Some(n_bytes)) => return Ok(n_bytes),
                Ok(None) => {}
                Err(reason) => return Err(self.wrong(scan.n_seen, reason)),
            }
            if scan.n_seen > MAX_RECORD_BYTES {
                return Err(self.wrong(0, "a record of more than 64 MiB begins here"));
            }
            if !self.refill()? {
                return match scan.is_scalar() {
                    true => Ok(scan.n_seen),
                    false => Err(self.wrong(scan.n_seen, "the file ends inside a record")),
                };
            }
        }
    }
}

/// The search for the end of a value.
#[derive(Default)]
struct Scan {
    n_seen: usize,
    depth: usize,
    is_in_text: bool,
    is_escaped: bool,
}

impl Scan {
    /// Whether a number or word has begun, which ends at the end of the file, too.
    fn is_scalar(&self) -> bool {
        self.n_seen > 0 && self.depth == 0 && !self.is_in_text
    }

    /// The length of the value if its end is among these bytes, of which it begins with the first.
    fn go_on(&mut self, bytes: &[u8]) -> Result<Option<usize>, &'static str> {
        while let Some(&byte) = bytes.get(self.n_seen) {
            if self.is_in_text {
                self.n_seen += 1;
                if self.is_escaped {
                    self.is_escaped = false;
                } else if byte == b'\\' {
                    self.is_escaped = true;
                } else if byte == b'"' {
                    self.is_in_text = false;
                    if self.depth == 0 {
                        return Ok(Some(self.n_seen));
                    }
                }
                continue;
            }
            match byte {
                b'"' if self.depth > 0 || self.n_seen == 0 => self.is_in_text = true,
                b'{' | b'[' if self.depth > 0 || self.n_seen == 0 => {
                    self.depth += 1;
                    if self.depth > MAX_DEPTH {
                        return Err("more than 127 levels inside a record");
                    }
                }
                b'}' | b']' if self.depth > 1 => self.depth -= 1,
                b'}' | b']' if self.depth == 1 => {
                    self.n_seen += 1;
                    return Ok(Some(self.n_seen));
                }
                b',' | b'}' | b']' | b' ' | b'\n' | b'\r' | b'\t' if self.depth == 0 => {
                    return Ok(Some(self.n_seen));
                }
                _ => {}
            }
            self.n_seen += 1;
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    fn read(text: &str) -> Result<(Vec<String>, JsonLists), DatasetError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        std::fs::write(&path, text).unwrap();
        let mut seen = Vec::new();
        let lists = read_json_records::<DatasetError>(&path, |record| {
            let from = usize::try_from(record.offset).unwrap();
            let whole = &text[from..from + record.text.len()];
            assert_eq!(whole, record.text, "the offset is true");
            seen.push(format!("{}{:?}={}", record.key, record.idx, record.text));
            Ok(())
        })?;
        Ok((seen, lists))
    }

    #[test]
    fn records_come_in_their_very_characters() {
        let text = " {\"a\": [ {\"x\":\"]}\\\"\"} ,[1,[2]], 3 ], \"b\":null, \"c\\n\":[]}\n";
        let (seen, lists) = read(text).unwrap();
        let expected = [
            "aSome(0)={\"x\":\"]}\\\"\"}",
            "aSome(1)=[1,[2]]",
            "aSome(2)=3",
            "bNone=null",
        ];
        assert_eq!(seen, expected, "in the order of the file");
        assert_eq!(lists.keys, ["a", "c\n"], "an empty list is a list");
        let (seen, lists) = read("[{},\"x\"]").unwrap();
        assert_eq!(seen, ["Some(0)={}", "Some(1)=\"x\""], "one list");
        assert!(lists.is_one_list, "it is one list");
    }

    #[test]
    fn records_may_lie_over_the_ends_of_blocks() {
        let long = "x".repeat(BLOCK_BYTES - 3);
        let text = format!("[\"{long}\", {{\"a\": \"{long}\"}}, 12]");
        let (seen, _) = read(&text).unwrap();
        assert_eq!(seen.len(), 3, "all three");
        assert_eq!(seen.last().unwrap(), "Some(2)=12", "the last is whole");
    }

    #[test]
    fn what_is_no_json_is_refused_at_its_byte() {
        for (text, at, why) in [
            ("", 0, "no content"),
            ("  7", 2, "expected a list"),
            ("[1, 2", 5, "ends too early"),
            ("[{\"a\": [1, 2", 12, "ends inside a record"),
            ("[{\"a\": \"b", 9, "ends inside a record"),
            ("[1 2]", 3, "expected a comma"),
            ("[1] x", 4, "more after the end"),
            ("{a: 1}", 1, "expected a key"),
            ("{\"a\" 1}", 5, "expected a colon"),
            ("{\"a\":[],\"a\":[]}", 12, "occurs twice"),
        ] {
            let error = read(text).unwrap_err().to_string();
            let place = format!("byte {at} on:");
            assert!(
                error.contains(&place) && error.contains(why),
                "{text}: {error}"
            );
        }
    }

    #[test]
    fn nesting_is_refused_where_it_gets_too_deep() {
        let error = read(&format!("[{}", "[".repeat(5_000_000))).unwrap_err();
        assert!(
            error.to_string().contains("byte 128 on: more than 127"),
            "{error}"
        );
        let fine = format!("[{}{}]", "[".repeat(127), "]".repeat(127));
        assert_eq!(read(&fine).unwrap().0.len(), 1, "127 levels are read");
    }
}
