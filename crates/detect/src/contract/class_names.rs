//! The classes of a model.

use serde::Serialize;

use crate::DetectError;

/// The names of a model's classes in the order of the model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClassNames {
    /// Where they come from: a list that comes along, a contract, the model itself.
    #[serde(skip)]
    pub origin: String,
    /// The names; none where a number of the model stands for no class.
    pub names: Vec<Option<String>>,
    /// Whether it is a preset's, which the model may know better.
    is_guess: bool,
}

impl ClassNames {
    /// The names of a list that comes along, one per line; a line of `-` stands for no class.
    pub(super) fn from_lines(origin: &str, text: &str) -> Self {
        Self {
            is_guess: true,
            ..Self::new(origin, text.lines())
        }
    }

    /// Whether it is a preset's, which the model may know better.
    pub(crate) fn is_guess(&self) -> bool {
        self.is_guess
    }

    /// Names; `-` stands for no class.
    pub fn new<'a>(origin: &str, names: impl IntoIterator<Item = &'a str>) -> Self {
        Self {
            origin: origin.to_owned(),
            names: names
                .into_iter()
                .map(str::trim)
                .map(|name| (name != "-").then(|| name.to_owned()))
                .collect(),
            is_guess: false,
        }
    }

    /// The number of a class in MS-COCO, 1 to 90, where it has one of this name.
    #[must_use]
    pub fn coco_number(name: &str) -> Option<i64> {
        let list = include_str!("../../presets/classes/coco-91.txt");
        let numbered = (0..).zip(list.lines());
        let mut named = numbered.filter(|(_, known)| *known != "-");
        named
            .find(|(_, known)| *known == name)
            .map(|(number, _)| number)
    }

    /// The names in the entry `names` that Ultralytics writes into its models, a dictionary as
    /// Python prints it: `{0: 'person', 1: "cat's eye"}`.
    ///
    /// # Errors
    ///
    /// [`DetectError::Model`] where it is something else, or the numbers do not run from 0.
    pub(crate) fn from_python_dictionary(model: &str, text: &str) -> Result<Self, DetectError> {
        let wrong = || DetectError::Model {
            model: model.to_owned(),
            reason: format!(
                "has an entry `names` that is no list of classes: {:?}; give their names in the contract's classes.names",
                text.chars().take(60).collect::<String>()
            ),
        };
        let inside = text
            .trim()
            .strip_prefix('{')
            .and_then(|text| text.strip_suffix('}'))
            .ok_or_else(wrong)?;
        let mut names: Vec<Option<String>> = Vec::new();
        let mut rest = inside.trim_start();
        while !rest.is_empty() {
            let (number, after) = rest.split_once(':').ok_or_else(wrong)?;
            let number: usize = number.trim().parse().map_err(|_| wrong())?;
            if number != names.len() {
                return Err(wrong());
            }
            let (name, after) = python_text(after.trim_start()).ok_or_else(wrong)?;
            names.push(Some(name));
            let after = after.trim_start();
            rest = match after.strip_prefix(',') {
                Some(rest) => rest.trim_start(),
                None if after.is_empty() => after,
                None => return Err(wrong()),
            };
        }
        Ok(Self {
            origin: "the model's own list".to_owned(),
            names,
            is_guess: false,
        })
    }
}

/// A text in quotes at the start, and what comes after it.
fn python_text(text: &str) -> Option<(String, &str)> {
    let mut chars = text.char_indices();
    let (_, quote) = chars.next().filter(|(_, c)| matches!(c, '\'' | '"'))?;
    let mut out = String::new();
    while let Some((at, c)) = chars.next() {
        match c {
            '\\' => out.push(chars.next()?.1),
            _ if c == quote => return Some((out, text.get(at + 1..)?)),
            _ => out.push(c),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::ClassNames;

    #[test]
    fn a_python_dictionary_is_read_with_both_quotes_and_nothing_else_is() {
        let read = |text| ClassNames::from_python_dictionary("m.onnx", text);
        let names = read(r#"{0: 'person', 1: "cat's, eye", 2: 'a\'b'}"#).map(|list| list.names);
        let expected = ["person", "cat's, eye", "a'b"].map(|name| Some(name.to_owned()));
        assert_eq!(names.ok(), Some(expected.to_vec()), "three names");
        for bad in [
            "person",
            "{0: person}",
            "{1: 'person'}",
            "{0: 'a' 1: 'b'}",
            "{0: 'a",
        ] {
            assert!(read(bad).is_err(), "{bad} is no list of classes");
        }
    }
}
