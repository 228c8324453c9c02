//! What the patterns of a bank were made from.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use starbreak::{Recipe, RecipeError};
use starbreak_dataset::BankFile;
use starbreak_glass::Generator;
use starbreak_seed::Seed;

use crate::Error;

/// Name and version of the bank format, the value of its header's `schema`.
pub const BANK_SCHEMA: &str = "starbreak.bank/3";

/// What the patterns of a bank are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum BankKind {
    /// Crack networks simulated by the recipe, baked for each frame size.
    Simulated,
}

/// What the patterns of a bank were made from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BankHeader {
    /// [`BANK_SCHEMA`].
    pub schema: String,
    /// The program that made it.
    pub generator: Generator,
    /// What its patterns are.
    pub kind: BankKind,
    /// The complete recipe as TOML.
    pub recipe: String,
    /// SHA-256 of that text, hexadecimal.
    pub recipe_sha256: String,
    /// The seed; pattern k has the seed that [`BankHeader::seed_of`] says.
    pub seed: Seed,
    /// Frame sizes that patterns were baked for, width and height, px. The networks were
    /// simulated for the first.
    pub sizes: Vec<(u32, u32)>,
}

/// The header of a bank's file, which must have a schema; `knows` says who has that one.
pub(super) fn read_header<T: DeserializeOwned>(
    file: &BankFile,
    schema: &str,
    knows: &str,
) -> Result<T, Error> {
    let wrong = |why: String| Error::Bank {
        path: file.path().to_owned(),
        idx: None,
        why,
    };
    let header: Value = serde_json::from_slice(file.header())
        .map_err(|cause| wrong(format!("its header is no JSON: {cause}")))?;
    let found = header.get("schema").and_then(Value::as_str);
    if found != Some(schema) {
        return Err(wrong(format!(
            "its header's schema is {:?}; {knows} {schema:?}",
            found.unwrap_or_default()
        )));
    }
    serde_json::from_value(header)
        .map_err(|cause| wrong(format!("its header is not understood: {cause}")))
}

impl BankHeader {
    /// The seed of a pattern.
    #[must_use]
    pub fn seed_of(&self, idx: usize) -> Seed {
        self.seed.of_item("patterns", idx as u64)
    }

    /// Records of each pattern: its network, and one for each size.
    pub(super) fn n_records_per_pattern(&self) -> usize {
        1 + self.sizes.len()
    }

    /// The recipe.
    ///
    /// # Errors
    /// [`RecipeError`] for a recipe of another version of the program.
    pub fn parse_recipe(&self) -> Result<Recipe, RecipeError> {
        Recipe::parse("the recipe of the bank", &self.recipe)
    }
}
