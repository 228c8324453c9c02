//! A study as JSON, and back.

use std::io::{Result as IoResult, Write};

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::Formatter;

use crate::EvalError;
use crate::evaluation::Study;

/// Depth down to which an object has a line per member.
const N_OBJECT_LEVELS: usize = 4;

/// Depth down to which an array has a line per item.
const N_ARRAY_LEVELS: usize = 5;

/// A study as JSON of the schema [`Study::SCHEMA`], a line per row of numbers, with a line feed at its end;
/// pictures are not part of it.
///
/// # Errors
/// [`EvalError::Report`] if serde gives up, which no value of a study makes it do.
pub fn json(study: &Study) -> Result<String, EvalError> {
    let failed = |reason: String| EvalError::Report { reason };
    let mut bytes = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut bytes, RowPerLine::default());
    study
        .serialize(&mut serializer)
        .map_err(|cause| failed(cause.to_string()))?;
    bytes.push(b'\n');
    String::from_utf8(bytes).map_err(|cause| failed(cause.to_string()))
}

/// Indents what is near the root, and leaves what is below on one line.
#[derive(Default)]
struct RowPerLine {
    /// Of each open container whether it is spread over lines, and whether it holds something.
    open: Vec<(bool, bool)>,
}

impl RowPerLine {
    fn begin(&mut self, n_levels: usize) {
        let is_in_lines = self.open.last().is_none_or(|(is_spread, _)| *is_spread);
        let is_spread = is_in_lines && self.open.len() < n_levels;
        self.open.push((is_spread, false));
    }

    fn item<W: ?Sized + Write>(&mut self, writer: &mut W, is_first: bool) -> IoResult<()> {
        if !is_first {
            writer.write_all(b",")?;
        }
        let n_open = self.open.len();
        let Some((is_spread, has_items)) = self.open.last_mut() else {
            return Ok(());
        };
        *has_items = true;
        match *is_spread {
            true => line(writer, n_open),
            false => Ok(()),
        }
    }

    fn end<W: ?Sized + Write>(&mut self, writer: &mut W) -> IoResult<()> {
        match self.open.pop() {
            Some((true, true)) => line(writer, self.open.len()),
            _ => Ok(()),
        }
    }
}

fn line<W: ?Sized + Write>(writer: &mut W, n_levels: usize) -> IoResult<()> {
    writer.write_all(b"\n")?;
    (0..n_levels).try_for_each(|_| writer.write_all(b" "))
}

impl Formatter for RowPerLine {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> IoResult<()> {
        self.begin(N_ARRAY_LEVELS);
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> IoResult<()> {
        self.end(writer)?;
        writer.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> IoResult<()> {
        self.item(writer, first)
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> IoResult<()> {
        self.begin(N_OBJECT_LEVELS);
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> IoResult<()> {
        self.end(writer)?;
        writer.write_all(b"}")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> IoResult<()> {
        self.item(writer, first)
    }
}

/// A study from its JSON.
///
/// # Errors
/// [`EvalError::ReportFile`] if it is not JSON of this schema, or not of this version.
pub fn read_json(text: &str) -> Result<Study, EvalError> {
    let study: Study = serde_json::from_str(text).map_err(|cause| EvalError::ReportFile {
        reason: cause.to_string().replace('\n', " "),
    })?;
    if study.schema != Study::SCHEMA {
        let found: String = study
            .schema
            .chars()
            .filter(|c| !c.is_control())
            .take(60)
            .collect();
        return Err(EvalError::ReportFile {
            reason: format!(
                "its schema is {found:?}, this program reads {:?}",
                Study::SCHEMA
            ),
        });
    }
    Ok(study)
}
