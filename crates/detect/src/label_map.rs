//! A model's classes to a dataset's categories, by name.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use toml::{Table, Value};

use crate::DetectError;
use crate::contract::{ClassNames, did_you_mean};

/// A model's classes to a dataset's categories.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LabelMap {
    /// Of each class of the model the place of its category, where it has one.
    category_of_class: Vec<Option<u32>>,
    /// Names of the model's classes that have no category.
    unmapped_classes: Vec<String>,
    /// Names of the categories that no class leads to.
    unmapped_categories: Vec<String>,
}

/// Other names of classes, as a choice that can be read and changed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LabelRules {
    name: String,
    /// A class of a model, and the category that it counts as; none where it is left out.
    rules: Vec<(String, Option<String>)>,
    /// Whether every rule must name a class that the model has and a category that there is.
    is_strict: bool,
}

impl LabelRules {
    /// Only equal names.
    #[must_use]
    pub fn none() -> Self {
        Self::default()
    }

    /// The choice that comes along for a dataset: `kitti` or `bdd`; only equal names for others.
    ///
    /// # Errors
    ///
    /// None in fact: the files that come along are read by a test.
    pub fn of_dataset(format: &str) -> Result<Self, DetectError> {
        let text = match format {
            "kitti" => include_str!("../presets/labels/kitti.toml"),
            "bdd" => include_str!("../presets/labels/bdd.toml"),
            _ => return Ok(Self::none()),
        };
        let mut rules = Self::parse(format, text)?;
        rules.is_strict = false;
        Ok(rules)
    }

    /// The rules in a text of TOML: `schema = 1` and a table `[map]` of `"class" = "category"`,
    /// where `"-"` leaves the class out.
    ///
    /// # Errors
    ///
    /// [`DetectError::LabelMap`] for everything else.
    pub fn parse(name: &str, text: &str) -> Result<Self, DetectError> {
        let wrong = |reason: String| DetectError::LabelMap {
            map: name.to_owned(),
            reason,
        };
        let table: Table = text.parse().map_err(|error: toml::de::Error| {
            let message: Vec<&str> = error.message().lines().collect();
            wrong(format!("it is no TOML: {}", message.join(", ")))
        })?;
        if let Some(key) = table
            .keys()
            .find(|key| !["schema", "about", "map"].contains(&key.as_str()))
        {
            return Err(wrong(format!(
                "there is no key {key:?}{}; the keys are schema, about, map",
                did_you_mean(key, &["schema", "about", "map"])
            )));
        }
        if table.get("schema") != Some(&Value::Integer(1)) {
            return Err(wrong("schema = 1 is missing".to_owned()));
        }
        let Some(Value::Table(map)) = table.get("map") else {
            return Err(wrong(
                "the table [map] of \"class\" = \"category\" is missing".to_owned(),
            ));
        };
        let mut rules = Vec::new();
        for (class, category) in map {
            let Value::String(category) = category else {
                return Err(wrong(format!(
                    "map.{class:?}: expected the name of a category in quotes, found {category}"
                )));
            };
            let category = (category != "-").then(|| category.clone());
            rules.push((class.clone(), category));
        }
        Ok(Self {
            name: name.to_owned(),
            rules,
            is_strict: true,
        })
    }
}

impl LabelMap {
    /// The map to the categories of these names, by rules first and equal names then; case, spaces, `_` and `-` do
    /// not matter.
    ///
    /// # Errors
    ///
    /// [`DetectError::LabelMap`] where a rule of a file names a class or a category that there is
    /// not, with the nearest, and where no class has a category at all.
    pub fn new(
        classes: &ClassNames,
        categories: &[&str],
        rules: &LabelRules,
    ) -> Result<Self, DetectError> {
        let wrong = |reason: String| DetectError::LabelMap {
            map: rules.name.clone(),
            reason,
        };
        let mut places = BTreeMap::new();
        for (at, category) in (0_u32..).zip(categories) {
            places.entry(plain(category)).or_insert(at);
        }
        let place = |name: &str| places.get(&plain(name)).copied();
        if rules.is_strict {
            let class_names: Vec<&str> =
                classes.names.iter().flatten().map(String::as_str).collect();
            let known: BTreeSet<String> = class_names.iter().copied().map(plain).collect();
            for (class, category) in &rules.rules {
                if !known.contains(&plain(class)) {
                    return Err(wrong(format!(
                        "the model has no class {class:?}{}",
                        did_you_mean(class, &class_names)
                    )));
                }
                if let Some(category) = category.as_ref().filter(|name| place(name).is_none()) {
                    return Err(wrong(format!(
                        "the dataset has no category {category:?}{}",
                        did_you_mean(category, categories)
                    )));
                }
            }
        }
        let mut map = Self {
            category_of_class: Vec::with_capacity(classes.names.len()),
            unmapped_classes: Vec::new(),
            unmapped_categories: Vec::new(),
        };
        let mut by_rule = BTreeMap::new();
        for (class, category) in &rules.rules {
            by_rule.entry(plain(class)).or_insert(category);
        }
        for class in &classes.names {
            let Some(class) = class else {
                map.category_of_class.push(None);
                continue;
            };
            let category = match by_rule.get(&plain(class)) {
                Some(category) => category.as_deref().and_then(place),
                None => place(class),
            };
            if category.is_none() {
                map.unmapped_classes.push(class.clone());
            }
            map.category_of_class.push(category);
        }
        let reached: BTreeSet<u32> = map.category_of_class.iter().flatten().copied().collect();
        for (at, category) in (0..).zip(categories) {
            if !reached.contains(&at) {
                map.unmapped_categories.push((*category).to_owned());
            }
        }
        if map.category_of_class.iter().all(Option::is_none) {
            let some: Vec<&str> = map
                .unmapped_classes
                .iter()
                .take(5)
                .map(String::as_str)
                .collect();
            let others: Vec<&str> = categories.iter().take(5).copied().collect();
            return Err(DetectError::LabelMap {
                map: if rules.name.is_empty() {
                    "by name".to_owned()
                } else {
                    rules.name.clone()
                },
                reason: format!(
                    "no class of the model ({}, …) has a category of the dataset ({}, …); give a map with \
                     --label-map FILE.toml",
                    some.join(", "),
                    others.join(", ")
                ),
            });
        }
        Ok(map)
    }

    /// The category of a class, as its place among the dataset's.
    #[must_use]
    pub fn category(&self, class: u32) -> Option<u32> {
        *self.category_of_class.get(class as usize)?
    }

    /// The model's classes that have no category: their detections are left out.
    #[must_use]
    pub fn unmapped_classes(&self) -> &[String] {
        &self.unmapped_classes
    }

    /// The categories that no class leads to: their objects cannot be found.
    #[must_use]
    pub fn unmapped_categories(&self) -> &[String] {
        &self.unmapped_categories
    }
}

/// A name without what people write differently.
fn plain(name: &str) -> String {
    name.chars()
        .filter(|c| !matches!(c, ' ' | '_' | '-'))
        .flat_map(char::to_lowercase)
        .collect()
}
