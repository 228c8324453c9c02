//! A complete recipe as text: plain for provenance, commented for people.

use std::fmt::Write as _;

use serde_json::Value as Json;
use toml::{Table, Value};

use super::schema::{keys, of_choice};
use super::tables::Choice;

/// Tables in the order in which a reader thinks of them.
const ORDER: [&str; 35] = [
    "camera",
    "glass",
    "impact",
    "fracture",
    "long_crack",
    "optics",
    "mud",
    "dust",
    "film",
    "frost",
    "scratches",
    "drops",
    "condensation",
    "distortion",
    "fringes",
    "defocus",
    "shake",
    "ghosts",
    "star",
    "glare",
    "shading",
    "lens",
    "exposure",
    "banding",
    "spots",
    "cfa",
    "noise",
    "pixels",
    "lines",
    "mosaic",
    "isp",
    "link",
    "frames",
    "sensor",
    "output",
];

/// Width of a comment line.
const COLUMNS: usize = 96;

pub(super) fn plain(table: &Table) -> String {
    write_recipe(table, None)
}

pub(super) fn commented(table: &Table, choice: Choice) -> String {
    write_recipe(table, Some(of_choice(choice)))
}

fn write_recipe(table: &Table, schema: Option<&Json>) -> String {
    let mut text = String::new();
    if let Some(schema) = schema {
        comment(
            &mut text,
            schema["properties"]["schema"]["description"].as_str(),
        );
    }
    // Writing to a String cannot fail.
    let _ = writeln!(text, "schema = {}", super::SCHEMA_VERSION);
    for name in ORDER {
        let (entries, header) = match table.get(name) {
            Some(Value::Table(table)) => (vec![table], format!("[{name}]")),
            Some(Value::Array(tables)) => (
                tables.iter().filter_map(Value::as_table).collect(),
                format!("[[{name}]]"),
            ),
            _ => continue,
        };
        for (k, entry) in entries.iter().enumerate() {
            text.push('\n');
            let described = if k == 0 { schema } else { None };
            if let Some(schema) = described {
                comment(
                    &mut text,
                    schema["properties"][name]["description"].as_str(),
                );
            }
            let _ = writeln!(text, "{header}");
            for (key, value) in *entry {
                if let Some(schema) = described {
                    let property = keys(&schema["properties"][name]).and_then(|keys| keys.get(key));
                    comment(
                        &mut text,
                        property.and_then(|known| known["description"].as_str()),
                    );
                }
                let _ = writeln!(text, "{key} = {value}");
            }
        }
    }
    text
}

fn comment(text: &mut String, description: Option<&str>) {
    let Some(description) = description else {
        return;
    };
    let mut line = String::from("#");
    for word in description.split_whitespace() {
        if line.len() + 1 + word.len() > COLUMNS {
            let _ = writeln!(text, "{line}");
            line = String::from("#");
        }
        line.push(' ');
        line.push_str(word);
    }
    let _ = writeln!(text, "{line}");
}
