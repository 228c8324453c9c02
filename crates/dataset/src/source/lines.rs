//! Text files of which each line is a record, one line at a time.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::path::Path;

use crate::error::DatasetError;
use crate::ordinary_file::open_file;

/// Longest line that is read, in bytes; longer than any path may be.
const MAX_LINE_BYTES: usize = 1 << 16;

/// A line of a text file.
pub(super) struct Line<'a> {
    /// Its number, from 1.
    pub(super) number: usize,
    /// It with its end, as it is in the file; only its beginning where it is too long.
    pub(super) bytes: &'a [u8],
    /// Its text without the end of the line, or why it cannot be read.
    pub(super) text: Result<&'a str, &'static str>,
}

/// Gives each line of a file to `take`, which may end the reading with its own error.
pub(super) fn for_each_line(
    path: &Path,
    mut take: impl FnMut(Line<'_>) -> Result<(), DatasetError>,
) -> Result<(), DatasetError> {
    let read_error = |source| DatasetError::Read {
        path: path.to_owned(),
        source,
    };
    let mut reader = BufReader::new(open_file(path)?);
    let mut bytes = Vec::new();
    for number in 1.. {
        bytes.clear();
        let limit = u64::try_from(MAX_LINE_BYTES).unwrap_or(u64::MAX);
        let n_read = reader
            .by_ref()
            .take(limit)
            .read_until(b'\n', &mut bytes)
            .map_err(read_error)?;
        if n_read == 0 {
            break;
        }
        let is_too_long = n_read == MAX_LINE_BYTES && !bytes.ends_with(b"\n");
        if is_too_long {
            skip_line(&mut reader).map_err(read_error)?;
        }
        take(Line {
            number,
            bytes: &bytes,
            text: if is_too_long {
                Err("the line is longer than 65536 bytes")
            } else {
                text_of(&bytes, number == 1)
            },
        })?;
    }
    Ok(())
}

fn text_of(bytes: &[u8], is_first: bool) -> Result<&str, &'static str> {
    let text = std::str::from_utf8(bytes).map_err(|_| "the line is not UTF-8 text")?;
    let text = text.strip_suffix('\n').unwrap_or(text);
    let text = text.strip_suffix('\r').unwrap_or(text);
    Ok(match is_first {
        // Some editors mark UTF-8 so.
        true => text.strip_prefix('\u{feff}').unwrap_or(text),
        false => text,
    })
}

fn skip_line(reader: &mut BufReader<File>) -> io::Result<()> {
    loop {
        let buffer = reader.fill_buf()?;
        let end = buffer.iter().position(|&byte| byte == b'\n');
        let n_bytes = end.map_or(buffer.len(), |at| at + 1);
        if n_bytes == 0 {
            return Ok(());
        }
        reader.consume(n_bytes);
        if end.is_some() {
            return Ok(());
        }
    }
}
