//! The members of an object in their very characters, of which some are replaced.

use std::fmt;

use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use serde_json::value::RawValue;

/// The members of an object, in its order.
#[derive(Debug)]
pub(crate) struct JsonMembers<'a>(Vec<(String, &'a RawValue)>);

impl<'a> JsonMembers<'a> {
    /// The first member of a key; none where it is absent or null.
    pub(crate) fn get(&self, key: &str) -> Option<&'a RawValue> {
        let found = self.0.iter().find(|(known, _)| known == key);
        found
            .map(|(_, value)| *value)
            .filter(|value| value.get() != "null")
    }

    /// The first key of no list of these whose value has numbers in a list: they may be places.
    pub(crate) fn other_with_numbers(&self, known: &[&str]) -> Option<&str> {
        let mut others = self
            .0
            .iter()
            .filter(|(key, _)| !known.contains(&key.as_str()));
        let found = others.find(|(_, value)| {
            serde_json::from_str(value.get()).is_ok_and(|value: Value| has_numbers_in_lists(&value))
        });
        found.map(|(key, _)| key.as_str())
    }

    /// The object with other JSON for some of its keys, where it has them; all others in their very characters.
    pub(crate) fn with(&self, replaced: &[(&str, String)]) -> String {
        let member = |(key, value): &(String, &RawValue)| {
            let new = replaced.iter().find(|(other, _)| other == key);
            let value = new.map_or(value.get(), |(_, new)| new);
            format!("{}:{value}", Value::from(key.as_str()))
        };
        let members: Vec<String> = self.0.iter().map(member).collect();
        format!("{{{}}}", members.join(","))
    }
}

fn has_numbers_in_lists(value: &Value) -> bool {
    match value {
        Value::Array(values) => values
            .iter()
            .any(|value| value.is_number() || has_numbers_in_lists(value)),
        Value::Object(members) => members.values().any(has_numbers_in_lists),
        _ => false,
    }
}

impl<'de: 'a, 'a> Deserialize<'de> for JsonMembers<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Members)
    }
}

struct Members;

impl<'de> Visitor<'de> for Members {
    type Value = JsonMembers<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut members = Vec::new();
        while let Some(member) = map.next_entry::<String, &RawValue>()? {
            members.push(member);
        }
        Ok(JsonMembers(members))
    }
}
