//! Numbers and names by which records of JSON files refer to each other.

use std::fmt;

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};

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

/// The number of a record where texts are none; also one that a table program wrote as 17.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WholeId(pub i64);

impl<'de> Deserialize<'de> for WholeId {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Id::deserialize(deserializer)? {
            Id::Int(id) => Ok(Self(id)),
            Id::Text(id) => Err(D::Error::invalid_type(
                Unexpected::Str(&id),
                &"a whole number as id",
            )),
        }
    }
}

struct IdVisitor;

impl Visitor<'_> for IdVisitor {
    type Value = Id;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an id (a whole number or a text)")
    }

    fn visit_i64<E: Error>(self, id: i64) -> Result<Id, E> {
        Ok(Id::Int(id))
    }

    fn visit_u64<E: Error>(self, id: u64) -> Result<Id, E> {
        i64::try_from(id)
            .map(Id::Int)
            .map_err(|_| E::custom(format!("the id {id} is above {}", i64::MAX)))
    }

    fn visit_f64<E: Error>(self, id: f64) -> Result<Id, E> {
        // What a table program makes of whole numbers: 17.0.
        let text = format!("{id:.0}");
        match text.parse() {
            Ok(whole) if id.fract().abs() <= 0.0 && id.abs() < 9e15 => Ok(Id::Int(whole)),
            _ => Err(E::custom(format!("the id {id} is not a whole number"))),
        }
    }

    fn visit_str<E: Error>(self, id: &str) -> Result<Id, E> {
        Ok(Id::Text(id.into()))
    }
}
