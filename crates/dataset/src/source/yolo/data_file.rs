//! `data.yaml`: where the images are, and the names of the classes.

use std::collections::BTreeMap;
use std::ops::Range;

use saphyr_parser::{Event, Parser, ScalarStyle, Span};

/// Deepest nesting that is read; a good file has two levels.
const MAX_DEPTH: usize = 16;

/// The keys of the parts of the data, in the order in which they are read.
const PARTS: [&str; 3] = ["train", "val", "test"];

/// What `data.yaml` says.
#[derive(Debug)]
pub(super) struct DataFile {
    text: String,
    /// Where the paths begin.
    pub(super) base: Option<Value>,
    /// The entry `path` as a whole, to be removed.
    base_entry: Option<Entry>,
    /// Parts of the data with their paths.
    pub(super) parts: Vec<(&'static str, Vec<Value>)>,
    /// Names of classes by number.
    pub(super) names: BTreeMap<usize, String>,
}

/// A text value and where it stands.
#[derive(Debug, Clone)]
pub(super) struct Value {
    pub(super) text: String,
    /// Bytes of the file.
    at: Range<usize>,
}

/// A key with its value.
#[derive(Debug)]
struct Entry {
    at: Range<usize>,
    value_at: Range<usize>,
    /// It stands on lines of its own, not within braces.
    is_block: bool,
}

/// A value of YAML.
#[derive(Debug)]
enum Node {
    Scalar {
        value: Value,
        is_block: bool,
    },
    List {
        items: Vec<Node>,
    },
    Map {
        entries: Vec<(Value, Node)>,
        is_block: bool,
    },
}

impl DataFile {
    /// What the text says.
    pub(super) fn parse(text: String) -> Result<Self, String> {
        let Some(Node::Map { entries, is_block }) = parse_yaml(&text)? else {
            return Err("it is not a mapping of keys to values".to_owned());
        };
        let mut file = Self {
            base: None,
            base_entry: None,
            parts: Vec::new(),
            names: BTreeMap::new(),
            text,
        };
        let mut seen: Vec<String> = Vec::new();
        let mut n_classes = None;
        for (key, node) in entries {
            if seen.contains(&key.text) {
                return Err(format!("the key {:?} occurs twice", key.text));
            }
            if key.text == "path" {
                file.base = paths_of(&key.text, node)?.into_iter().next();
                file.base_entry = file.base.as_ref().map(|value| Entry {
                    at: key.at.start..value.at.end,
                    value_at: value.at.clone(),
                    is_block,
                });
            } else if let Some(part) = PARTS.into_iter().find(|part| *part == key.text) {
                file.parts.push((part, paths_of(&key.text, node)?));
            } else if key.text == "kpt_shape" {
                return Err(
                    "it has kpt_shape: labels of poses are not read; give the boxes alone, or folder:DIR".to_owned(),
                );
            } else if key.text == "nc" {
                let Node::Scalar { value, .. } = node else {
                    return Err("nc is no number of classes".to_owned());
                };
                n_classes = Some(value.text);
            } else if key.text == "names" {
                file.names = names_of(node)?;
            }
            seen.push(key.text);
        }
        if file.parts.is_empty() {
            return Err("it has none of the keys train, val and test".to_owned());
        }
        if file.names.is_empty() {
            return Err("it has no names of classes".to_owned());
        }
        // As its trainer asks.
        let n_names = file.names.len();
        if let Some(n) = n_classes.filter(|n| n.parse() != Ok(n_names)) {
            return Err(format!("nc = {n:?}, and it names {n_names} classes"));
        }
        Ok(file)
    }

    /// The text with other paths: `path` is removed, and each path of a part becomes what
    /// `new_path` says; everything else stays as it is.
    pub(super) fn rewritten(&self, mut new_path: impl FnMut(&str) -> Option<String>) -> String {
        let mut changes: Vec<(Range<usize>, String)> = Vec::new();
        match &self.base_entry {
            Some(entry) if entry.is_block => changes.push((entry.at.clone(), String::new())),
            Some(entry) => changes.push((entry.value_at.clone(), "\"\"".to_owned())),
            None => {}
        }
        for value in self.parts.iter().flat_map(|(_, values)| values) {
            if let Some(path) = new_path(&value.text) {
                changes.push((value.at.clone(), scalar(&path)));
            }
        }
        changes.sort_by_key(|(at, _)| at.start);
        let mut text = String::new();
        let mut end = 0;
        for (at, new) in changes {
            text.push_str(self.text.get(end..at.start).unwrap_or_default());
            text.push_str(&new);
            end = at.end;
        }
        text.push_str(self.text.get(end..).unwrap_or_default());
        text
    }
}

/// A text as YAML writes it.
fn scalar(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '/' | '_' | '-' | '.');
    let begins_plain = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '.');
    if begins_plain && text.contains('/') && text.chars().all(is_plain) {
        return text.to_owned();
    }
    // The escapes of JSON are among those of YAML.
    serde_json::Value::from(text).to_string()
}

/// One path or a list of them; none for nothing.
fn paths_of(key: &str, node: Node) -> Result<Vec<Value>, String> {
    let path = |node| match node {
        Node::Scalar { value, is_block } if !is_block => Ok(value),
        _ => Err(format!(
            "{key} is not a path on one line or a list of paths"
        )),
    };
    match node {
        Node::Scalar {
            value,
            is_block: false,
        } if is_nothing(&value.text) => Ok(Vec::new()),
        Node::List { items } if key != "path" => items.into_iter().map(path).collect(),
        node => Ok(vec![path(node)?]),
    }
}

fn is_nothing(text: &str) -> bool {
    matches!(text, "" | "~" | "null" | "Null" | "NULL")
}

/// Names by number: a list, or a mapping.
fn names_of(node: Node) -> Result<BTreeMap<usize, String>, String> {
    let name = |node| match node {
        Node::Scalar { value, .. } => Ok(value.text),
        _ => Err("a name of a class is not a text".to_owned()),
    };
    match node {
        Node::List { items } => items
            .into_iter()
            .enumerate()
            .map(|(number, node)| Ok((number, name(node)?)))
            .collect(),
        Node::Map { entries, .. } => {
            let mut names = BTreeMap::new();
            for (key, node) in entries {
                let number = key.text.parse();
                let number =
                    number.map_err(|_| format!("the class {:?} is not a number", key.text))?;
                if names.insert(number, name(node)?).is_some() {
                    return Err(format!("the class {number} occurs twice"));
                }
            }
            Ok(names)
        }
        Node::Scalar { .. } => Err("names is neither a list nor a mapping".to_owned()),
    }
}

/// A list or mapping that is not read to its end.
enum Open {
    List(Vec<Node>),
    Map {
        entries: Vec<(Value, Node)>,
        key: Option<Value>,
        is_block: bool,
    },
}

/// The first document; nothing where there is none.
fn parse_yaml(text: &str) -> Result<Option<Node>, String> {
    // Places are counted in characters; ends need one more.
    let mut starts: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
    starts.push(text.len());
    let bytes_of = |span: Span| {
        let byte = |idx: usize| starts.get(idx).copied().unwrap_or(text.len());
        byte(span.start.index())..byte(span.end.index())
    };
    let mut parser = Parser::new_from_str(text);
    let mut open: Vec<Open> = Vec::new();
    let mut root = None;
    while let Some(event) = parser.next_event() {
        let (event, span) = event.map_err(|error| error.to_string())?;
        let line = span.start.line();
        let done = match event {
            Event::Scalar(value, style, ..) => Node::Scalar {
                value: Value {
                    text: value.into_owned(),
                    at: bytes_of(span),
                },
                is_block: matches!(style, ScalarStyle::Literal | ScalarStyle::Folded),
            },
            Event::SequenceStart(..) => {
                open.push(Open::List(Vec::new()));
                check_depth(&open, line)?;
                continue;
            }
            Event::MappingStart(..) => {
                let at = bytes_of(span);
                open.push(Open::Map {
                    entries: Vec::new(),
                    key: None,
                    is_block: !text.get(at.start..).unwrap_or_default().starts_with('{'),
                });
                check_depth(&open, line)?;
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => match open.pop() {
                Some(Open::List(items)) => Node::List { items },
                Some(Open::Map {
                    entries, is_block, ..
                }) => Node::Map { entries, is_block },
                None => return Err(format!("line {line}: an end without a beginning")),
            },
            Event::Alias(_) => return Err(format!("line {line}: aliases are not supported")),
            Event::DocumentEnd => return Ok(root),
            Event::Nothing | Event::StreamStart | Event::StreamEnd | Event::DocumentStart(_) => {
                continue;
            }
        };
        match open.last_mut() {
            None => root = Some(done),
            Some(Open::List(items)) => items.push(done),
            Some(Open::Map { entries, key, .. }) => match (key.take(), done) {
                (Some(key), value) => entries.push((key, value)),
                (None, Node::Scalar { value, .. }) => *key = Some(value),
                (None, _) => return Err(format!("line {line}: a key is not a text")),
            },
        }
    }
    Ok(root)
}

fn check_depth(open: &[Open], line: usize) -> Result<(), String> {
    if open.len() > MAX_DEPTH {
        return Err(format!(
            "line {line}: nested deeper than {MAX_DEPTH} levels"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rewritten(text: &str) -> String {
        let file = DataFile::parse(text.to_owned()).unwrap_or_else(|e| panic!("{text:?}: {e}"));
        file.rewritten(|path| path.strip_prefix("/data/").map(str::to_owned))
    }

    #[test]
    fn only_the_paths_are_rewritten() {
        for (before, after) in [
            (
                "# é\npath: /data  # root\ntrain: /data/images/train # t\nval: images/val\n\nnames:\n  0: person\n  1: 'a: b'\n",
                "# é\n  # root\ntrain: images/train # t\nval: images/val\n\nnames:\n  0: person\n  1: 'a: b'\n",
            ),
            (
                "train:\n  - \"/data/images/ü 1\"\n  - '/data/a/b'\nnames: [x, y]\npath: ..",
                "train:\n  - \"images/ü 1\"\n  - a/b\nnames: [x, y]\n",
            ),
            (
                "{path: /data, train: /data/yes, names: {0: x}}",
                "{path: \"\", train: \"yes\", names: {0: x}}",
            ),
        ] {
            let text = rewritten(before);
            assert_eq!(text, after, "{before:?}");
            DataFile::parse(text).unwrap_or_else(|e| panic!("{after:?}: {e}"));
        }
    }

    #[test]
    fn names_are_a_list_or_a_mapping() {
        for text in [
            "train: a\nnames: [x, 2]",
            "train: a\nnames:\n- x\n- 2\nnc: 2",
            "train: a\nnames: {1: 2, 0: x}",
        ] {
            let file = DataFile::parse(text.to_owned()).unwrap_or_else(|e| panic!("{text:?}: {e}"));
            let names: Vec<_> = file.names.iter().map(|(k, v)| (*k, v.as_str())).collect();
            assert_eq!(names, [(0, "x"), (1, "2")], "{text:?}");
        }
    }

    #[test]
    fn broken_files_are_refused() {
        let deep = format!("train: {}", "[".repeat(1_000_000));
        for text in [
            "",
            "- a",
            "names: [x]",
            "train: a",
            "train: a\nnames: x",
            "train: a\nnames: {a: x}",
            "train: a\ntrain: b\nnames: [x]",
            "train: {a: b}\nnames: [x]",
            "train: |\n  a\nnames: [x]",
            "train: &a b\nval: *a\nnames: [x]",
            "train: [a\nnames: [x]",
            "\0",
            "train: a\nnames: {0: x, 0: y}",
            &deep,
        ] {
            let file = DataFile::parse(text.to_owned());
            let start: String = text.chars().take(40).collect();
            assert!(file.is_err(), "{start:?} gave {file:?}");
        }
    }
}
