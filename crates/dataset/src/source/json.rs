//! JSON files with long lists of records, one record at a time.

use std::fmt;
use std::io::{self, BufReader, Write};
use std::path::Path;

use serde::de::{DeserializeSeed, Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;

use super::SourceFormat;
use crate::error::DatasetError;
use crate::image_file::open_file;

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 18;

/// Who takes the parts of an index file, in the order of the file.
///
/// The file is an object of which some members are lists of records, or one list of records; for
/// the latter the key is empty.
pub(super) trait Sink {
    /// Whether the member of this key is a list of records.
    fn is_list(&self, key: &str) -> bool;

    /// Takes a record, in the very characters of the file.
    fn record(&mut self, key: &str, text: &str) -> io::Result<()>;

    /// Takes a member that is not a list of records.
    fn member(&mut self, _key: &str, _text: &str) -> io::Result<()> {
        Ok(())
    }

    /// A list of records begins.
    fn begin_list(&mut self, _key: &str) -> io::Result<()> {
        Ok(())
    }

    /// A list of records ends.
    fn end_list(&mut self, _key: &str) -> io::Result<()> {
        Ok(())
    }
}

/// Reads a file and checks that these keys were there, or that it is a list of records.
pub(super) fn read(
    path: &Path,
    format: SourceFormat,
    keys: &[&str],
    sink: &mut impl Sink,
) -> Result<(), DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: path.to_owned(),
        source,
    };
    let file = open_file(path)?;
    let reader = BufReader::with_capacity(BUFFER_BYTES, file);
    let seen = parse(reader, sink).map_err(|error| match error.io_error_kind() {
        Some(kind) => read_error(kind.into()),
        None => index_error(path, format, &error.to_string()),
    })?;
    if seen == [""] {
        return Ok(());
    }
    match keys.iter().find(|key| !seen.iter().any(|s| s == *key)) {
        None => Ok(()),
        Some(key) => Err(index_error(
            path,
            format,
            &format!("it has no list {key:?}"),
        )),
    }
}

/// The error of a file that is broken as a whole.
pub(super) fn index_error(path: &Path, format: SourceFormat, reason: &str) -> DatasetError {
    DatasetError::SourceIndex {
        path: path.to_owned(),
        format,
        reason: reason.to_owned(),
    }
}

/// The lists that were there.
fn parse(reader: impl io::Read, sink: &mut impl Sink) -> serde_json::Result<Vec<String>> {
    let mut deserializer = serde_json::Deserializer::from_reader(reader);
    let seen = WholeFile { sink }.deserialize(&mut deserializer)?;
    deserializer.end()?;
    Ok(seen)
}

/// The whole file.
struct WholeFile<'s, S> {
    sink: &'s mut S,
}

impl<'de, S: Sink> DeserializeSeed<'de> for WholeFile<'_, S> {
    type Value = Vec<String>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de, S: Sink> Visitor<'de> for WholeFile<'_, S> {
    type Value = Vec<String>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object with lists of records")?;
        if self.sink.is_list("") {
            f.write_str(", or a list of records")?;
        }
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut seen: Vec<String> = Vec::new();
        while let Some(key) = map.next_key::<String>()? {
            if !key.is_empty() && self.sink.is_list(&key) {
                if seen.contains(&key) {
                    return Err(A::Error::custom(format!("the list {key:?} occurs twice")));
                }
                let sink = &mut *self.sink;
                map.next_value_seed(Records { key: &key, sink })?;
                seen.push(key);
            } else {
                // Not skipped unseen: what is no text must be found before a copy is written.
                let text: Box<RawValue> = map.next_value()?;
                let taken = self.sink.member(&key, text.get());
                taken.map_err(A::Error::custom)?;
            }
        }
        Ok(seen)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
        if !self.sink.is_list("") {
            return Err(A::Error::custom("it is a list, expected an object"));
        }
        let records = Records {
            key: "",
            sink: self.sink,
        };
        records.visit_seq(seq)?;
        Ok(vec![String::new()])
    }
}

/// A list of records.
struct Records<'k, 's, S> {
    key: &'k str,
    sink: &'s mut S,
}

impl<'de, S: Sink> DeserializeSeed<'de> for Records<'_, '_, S> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, S: Sink> Visitor<'de> for Records<'_, '_, S> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a list of records at {:?}", self.key)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        self.sink.begin_list(self.key).map_err(A::Error::custom)?;
        while let Some(text) = seq.next_element::<Box<RawValue>>()? {
            let taken = self.sink.record(self.key, text.get());
            taken.map_err(A::Error::custom)?;
        }
        self.sink.end_list(self.key).map_err(A::Error::custom)
    }
}

/// The number of a record in its file, or its name.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Id {
    Int(i64),
    Text(Box<str>),
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Int(id) => write!(f, "{id}"),
            Self::Text(id) => f.write_str(id),
        }
    }
}

impl<'de> Deserialize<'de> for Id {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(IdVisitor)
    }
}

struct IdVisitor;

impl Visitor<'_> for IdVisitor {
    type Value = Id;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an id (a whole number or a text)")
    }

    fn visit_i64<E: serde::de::Error>(self, id: i64) -> Result<Id, E> {
        Ok(Id::Int(id))
    }

    fn visit_u64<E: serde::de::Error>(self, id: u64) -> Result<Id, E> {
        i64::try_from(id)
            .map(Id::Int)
            .map_err(|_| E::custom(format!("the id {id} is above {}", i64::MAX)))
    }

    fn visit_f64<E: serde::de::Error>(self, id: f64) -> Result<Id, E> {
        // What a table program makes of whole numbers: 17.0.
        let text = format!("{id:.0}");
        match text.parse() {
            Ok(whole) if id.fract().abs() <= 0.0 && id.abs() < 9e15 => Ok(Id::Int(whole)),
            _ => Err(E::custom(format!("the id {id} is not a whole number"))),
        }
    }

    fn visit_str<E: serde::de::Error>(self, id: &str) -> Result<Id, E> {
        Ok(Id::Text(id.into()))
    }
}

/// What serde says about a record, without the line and column, which count inside the record.
pub(super) fn record_reason(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rsplit_once(" at line ") {
        Some((reason, _)) => reason.to_owned(),
        None => text,
    }
}

/// Writes a copy of an index file that has only some of its records.
///
/// `keeps` says of a record, by list and text, whether it is kept. `name` serves for messages.
pub(super) fn write_copy(
    path: &Path,
    name: &str,
    format: SourceFormat,
    lists: &[&str],
    keeps: impl FnMut(&str, &str) -> bool,
    out: &mut dyn Write,
) -> Result<(), DatasetError> {
    let mut copy = Copy {
        out,
        lists,
        keeps,
        is_object: true,
        n_members: 0,
        n_records: 0,
        failed: None,
    };
    let result = read(path, format, &[], &mut copy);
    let end = match (copy.is_object, copy.n_members) {
        (false, _) => "\n",
        (true, 0) => "{}\n",
        (true, _) => "}\n",
    };
    let written = match copy.failed.take() {
        Some(source) => Err(source),
        None => {
            result?;
            copy.out.write_all(end.as_bytes())
        }
    };
    written.map_err(|source| DatasetError::SubsetWrite {
        name: name.to_owned(),
        source,
    })
}

struct Copy<'o, 'l, K> {
    out: &'o mut dyn Write,
    lists: &'l [&'l str],
    keeps: K,
    is_object: bool,
    n_members: usize,
    /// Records of the present list that were written.
    n_records: usize,
    /// Why `out` takes no more.
    failed: Option<io::Error>,
}

impl<K> Copy<'_, '_, K> {
    fn put(&mut self, parts: &[&str]) -> io::Result<()> {
        for part in parts {
            if let Err(error) = self.out.write_all(part.as_bytes()) {
                let kind = error.kind();
                self.failed = Some(error);
                return Err(kind.into());
            }
        }
        Ok(())
    }

    fn put_key(&mut self, key: &str) -> io::Result<()> {
        let before = if self.n_members == 0 { "{" } else { ",\n" };
        self.n_members += 1;
        self.put(&[before, &serde_json::to_string(key)?, ":"])
    }
}

impl<K: FnMut(&str, &str) -> bool> Sink for Copy<'_, '_, K> {
    fn is_list(&self, key: &str) -> bool {
        self.lists.contains(&key)
    }

    fn member(&mut self, key: &str, text: &str) -> io::Result<()> {
        self.put_key(key)?;
        self.put(&[text])
    }

    fn begin_list(&mut self, key: &str) -> io::Result<()> {
        self.n_records = 0;
        if key.is_empty() {
            self.is_object = false;
        } else {
            self.put_key(key)?;
        }
        self.put(&["["])
    }

    fn record(&mut self, key: &str, text: &str) -> io::Result<()> {
        if !(self.keeps)(key, text) {
            return Ok(());
        }
        let before = if self.n_records == 0 { "\n" } else { ",\n" };
        self.n_records += 1;
        self.put(&[before, text])
    }

    fn end_list(&mut self, _: &str) -> io::Result<()> {
        self.put(&["]"])
    }
}
