//! A table of a contract, whose keys are asked for one by one; what nobody asked for is unknown.

use std::cell::RefCell;

use toml::{Table, Value};

use crate::DetectError;

/// A table of a contract.
pub(super) struct Keys<'a> {
    contract: &'a str,
    table_name: &'a str,
    table: &'a Table,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Keys<'a> {
    pub(super) fn new(contract: &'a str, table_name: &'a str, table: &'a Table) -> Self {
        Self {
            contract,
            table_name,
            table,
            asked: RefCell::new(Vec::new()),
        }
    }

    /// An error about a key.
    pub(super) fn wrong(&self, key: &str, reason: impl Into<String>) -> DetectError {
        let key = if self.table_name.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.table_name)
        };
        DetectError::Contract {
            contract: self.contract.to_owned(),
            key,
            reason: reason.into(),
        }
    }

    /// Notes that the key is known.
    pub(super) fn get(&self, key: &'static str) -> Option<&'a Value> {
        self.asked.borrow_mut().push(key);
        self.table.get(key)
    }

    /// A table inside.
    pub(super) fn table(&self, key: &'static str) -> Result<Option<&'a Table>, DetectError> {
        match self.get(key) {
            None => Ok(None),
            Some(Value::Table(table)) => Ok(Some(table)),
            Some(other) => Err(self.wrong(key, expected("a table", other))),
        }
    }

    pub(super) fn text(&self, key: &'static str) -> Result<Option<&'a str>, DetectError> {
        match self.get(key) {
            None => Ok(None),
            Some(Value::String(text)) if !text.is_empty() => Ok(Some(text)),
            Some(other) => Err(self.wrong(key, expected("a text in quotes", other))),
        }
    }

    pub(super) fn name(&self, key: &'static str) -> Result<Option<String>, DetectError> {
        Ok(self.text(key)?.map(str::to_owned))
    }

    pub(super) fn truth(&self, key: &'static str, default: bool) -> Result<bool, DetectError> {
        match self.get(key) {
            None => Ok(default),
            Some(Value::Boolean(truth)) => Ok(*truth),
            Some(other) => Err(self.wrong(key, expected("true or false", other))),
        }
    }

    /// One of a few words.
    pub(super) fn word<T: Copy>(
        &self,
        key: &'static str,
        words: &[(&str, T)],
    ) -> Result<Option<T>, DetectError> {
        let Some(text) = self.text(key)? else {
            return Ok(None);
        };
        if let Some((_, meaning)) = words.iter().find(|(word, _)| *word == text) {
            return Ok(Some(*meaning));
        }
        let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
        Err(self.wrong(
            key,
            format!(
                "{text:?} is none of {}{}",
                known.join(", "),
                did_you_mean(text, &known)
            ),
        ))
    }

    /// A finite number in a range.
    pub(super) fn number(
        &self,
        key: &'static str,
        [least, most]: [f32; 2],
        default: f32,
    ) -> Result<f32, DetectError> {
        match self.get(key) {
            None => Ok(default),
            Some(value) => self.number_of(key, value, [least, most]),
        }
    }

    fn number_of(
        &self,
        key: &str,
        value: &Value,
        [least, most]: [f32; 2],
    ) -> Result<f32, DetectError> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_precision_loss,
            reason = "models calculate in f32"
        )]
        let number = match value {
            Value::Float(number) => *number as f32,
            Value::Integer(number) => *number as f32,
            other => return Err(self.wrong(key, expected("a number", other))),
        };
        if !(least..=most).contains(&number) {
            return Err(self.wrong(key, format!("{number} is not in {least} to {most}")));
        }
        Ok(number)
    }

    /// Three numbers, one per channel.
    pub(super) fn channels(
        &self,
        key: &'static str,
        range: [f32; 2],
        default: f32,
    ) -> Result<[f32; 3], DetectError> {
        let wrong = |value| self.wrong(key, expected("three numbers in brackets", value));
        match self.get(key) {
            None => Ok([default; 3]),
            Some(value @ Value::Array(items)) => {
                let numbers: Result<Vec<f32>, DetectError> = items
                    .iter()
                    .map(|item| self.number_of(key, item, range))
                    .collect();
                <[f32; 3]>::try_from(numbers?).map_err(|_| wrong(value))
            }
            Some(other) => Err(wrong(other)),
        }
    }

    /// A whole number in a range.
    pub(super) fn whole(
        &self,
        key: &'static str,
        [least, most]: [i64; 2],
    ) -> Result<Option<i64>, DetectError> {
        match self.get(key) {
            None => Ok(None),
            Some(value) => self.whole_of(key, value, [least, most]).map(Some),
        }
    }

    fn whole_of(
        &self,
        key: &str,
        value: &Value,
        [least, most]: [i64; 2],
    ) -> Result<i64, DetectError> {
        match value {
            Value::Integer(number) if (least..=most).contains(number) => Ok(*number),
            Value::Integer(number) => {
                Err(self.wrong(key, format!("{number} is not in {least} to {most}")))
            }
            other => Err(self.wrong(key, expected("a whole number", other))),
        }
    }

    /// A number of pixels.
    pub(super) fn side_px(&self, key: &'static str) -> Result<Option<u32>, DetectError> {
        let side = self.whole(key, [1, i64::from(MAX_SIDE_PX)])?;
        Ok(side.map(|side| u32::try_from(side).unwrap_or(MAX_SIDE_PX)))
    }

    /// A list of numbers of pixels.
    pub(super) fn sides_px(&self, key: &'static str) -> Result<Option<Vec<u32>>, DetectError> {
        match self.get(key) {
            None => Ok(None),
            Some(Value::Array(items)) => items
                .iter()
                .map(|item| {
                    let side = self.whole_of(key, item, [1, i64::from(MAX_SIDE_PX)])?;
                    Ok(u32::try_from(side).unwrap_or(MAX_SIDE_PX))
                })
                .collect::<Result<_, _>>()
                .map(Some),
            Some(other) => Err(self.wrong(key, expected("whole numbers in brackets", other))),
        }
    }

    /// Nothing stands in the table that was not asked for.
    pub(super) fn refuse_unknown(&self) -> Result<(), DetectError> {
        let asked = self.asked.borrow();
        for key in self.table.keys() {
            if !asked.contains(&key.as_str()) {
                return Err(self.wrong(
                    key,
                    format!(
                        "there is no such key here{}; the keys are {}",
                        did_you_mean(key, &asked),
                        asked.join(", ")
                    ),
                ));
            }
        }
        Ok(())
    }
}

/// The longest side of a frame, px.
const MAX_SIDE_PX: u32 = 32_768;

fn expected(what: &str, found: &Value) -> String {
    let text = found.to_string();
    let short: String = text.chars().take(60).collect();
    format!("expected {what}, found {short}")
}

/// The nearest of some words, as a question.
pub(crate) fn did_you_mean(text: &str, known: &[&str]) -> String {
    known
        .iter()
        .map(|word| (strsim::damerau_levenshtein(text, word), *word))
        .min()
        .filter(|(distance, word)| *distance <= word.len().max(4) / 2)
        .map(|(_, word)| format!(", did you mean {word:?}?"))
        .unwrap_or_default()
}
