use serde::Serialize;

use super::super::words;
use crate::evaluation::Estimate;

/// A table with its caption, and notes for numbers that are not there.
#[derive(Debug, Serialize)]
pub(in crate::report) struct Table {
    pub(in crate::report) caption: String,
    pub(in crate::report) columns: Vec<Column>,
    pub(in crate::report) rows: Vec<Vec<Cell>>,
    pub(in crate::report) notes: Vec<Note>,
}

/// A column's heading.
#[derive(Debug, Serialize)]
pub(in crate::report) struct Column {
    text: String,
    is_number: bool,
}

/// Why a number is missing.
#[derive(Debug, Serialize)]
pub(in crate::report) struct Note {
    mark: String,
    text: String,
}

/// A cell: what is read, in small letters its interval, what it sorts by.
#[derive(Debug, Default, Serialize)]
pub(in crate::report) struct Cell {
    text: String,
    small: Option<String>,
    sort: Option<f64>,
    mark: Option<String>,
    is_head: bool,
    /// Letters that say nothing to a reader, to be broken anywhere.
    is_hash: bool,
    /// Depth of its shade, percent.
    shade: Option<u8>,
}

impl Cell {
    pub(in crate::report) fn text(text: impl AsRef<str>) -> Self {
        Self {
            text: words::name(text.as_ref()),
            ..Self::default()
        }
    }

    /// A hash.
    pub(in crate::report) fn hash(text: impl AsRef<str>) -> Self {
        Self {
            is_hash: true,
            ..Self::text(text)
        }
    }

    /// What the row is about.
    pub(in crate::report) fn head(text: impl AsRef<str>) -> Self {
        Self {
            is_head: true,
            ..Self::text(text)
        }
    }

    /// Where there is no number.
    pub(in crate::report) fn nothing() -> Self {
        Self::text(words::NOTHING)
    }

    pub(in crate::report) fn count(n: u64) -> Self {
        Self {
            text: words::count(n),
            sort: Some(words::as_number(n)),
            ..Self::default()
        }
    }

    pub(in crate::report) fn number(value: Option<f64>, show: fn(f64) -> String) -> Self {
        Self {
            text: value.map_or_else(|| words::NOTHING.to_owned(), show),
            sort: value.filter(|value| value.is_finite()),
            ..Self::default()
        }
    }

    pub(in crate::report) fn probability(p: Option<f64>) -> Self {
        Self::number(p, words::probability)
    }

    pub(in crate::report) fn with_small(mut self, small: Option<String>) -> Self {
        self.small = small;
        self
    }

    pub(in crate::report) fn with_shade(mut self, percent: u8) -> Self {
        self.shade = Some(percent.min(100));
        self
    }
}

impl Table {
    /// A table without rows; the headings of its columns with `|` between them, and `#` before those of numbers.
    pub(in crate::report) fn new(caption: &str, columns: &str) -> Self {
        let columns = columns.split('|').map(|column| Column {
            text: column.trim_start_matches('#').to_owned(),
            is_number: column.starts_with('#'),
        });
        Self {
            caption: words::name(caption),
            columns: columns.collect(),
            rows: Vec::new(),
            notes: Vec::new(),
        }
    }

    pub(in crate::report) fn push(&mut self, row: Vec<Cell>) {
        self.rows.push(row);
    }

    /// A note that belongs to the whole table.
    pub(in crate::report) fn remark(&mut self, text: &str) {
        self.notes.push(Note {
            mark: String::new(),
            text: words::name(text),
        });
    }

    /// A number with its interval below it, or a mark of the note that says why there is none.
    pub(in crate::report) fn estimate<'a>(
        &mut self,
        estimate: impl Into<Option<&'a Estimate>>,
        show: fn(f64) -> String,
    ) -> Cell {
        let Some(estimate) = estimate.into() else {
            return Cell::nothing();
        };
        let small = estimate
            .interval()
            .map(|[low, high]| format!("[{}, {}]", show(low), show(high)));
        let mut cell = Cell::number(estimate.value, show).with_small(small);
        if let (None, Some(why)) = (estimate.value, &estimate.refused) {
            cell.mark = Some(self.mark_of(why));
        }
        cell
    }

    /// The mark of the note with this text, which is added if it is new.
    fn mark_of(&mut self, text: &str) -> String {
        let text = words::name(text);
        if let Some(known) = self.notes.iter().find(|note| note.text == text) {
            return known.mark.clone();
        }
        let mark = letters(self.notes.len());
        self.notes.push(Note {
            mark: mark.clone(),
            text,
        });
        mark
    }
}

/// `a` to `z`, then `aa`, `ab`, …
fn letters(mut place: usize) -> String {
    let mut text = String::new();
    loop {
        let letter = u8::try_from(place % 26).unwrap_or(0);
        text.insert(0, char::from(b'a' + letter));
        if place < 26 {
            return text;
        }
        place = place / 26 - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::{Table, letters};
    use crate::evaluation::Estimate;
    use crate::report::words::percent;

    #[test]
    fn equal_reasons_share_a_mark() {
        let mut table = Table::new("t", "#a");
        let few = Estimate::refused(3, "3 objects, 20 are needed");
        let cells = [few.clone(), few, Estimate::refused(0, "no object")];
        let cells = cells.map(|estimate| table.estimate(&estimate, percent).mark);
        let marks: Vec<_> = cells.iter().flatten().map(String::as_str).collect();
        assert_eq!(marks, ["a", "a", "b"], "one mark per reason");
        assert_eq!(table.notes.len(), 2, "one note per reason");
    }

    #[test]
    fn letters_go_on_after_z() {
        let marks = [0, 25, 26, 27, 701, 702].map(letters);
        assert_eq!(
            marks,
            ["a", "z", "aa", "ab", "zz", "aaa"],
            "as columns of a sheet"
        );
    }
}
