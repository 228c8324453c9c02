//! What a set is made from.

use serde_json::{Value, json};
use starbreak_dataset::{Carry, SET_SCHEMA};
use starbreak_glass::Seed;

use super::{Patterns, Plan};
use crate::{Error, Recipe};

impl Plan<'_> {
    /// All that the bytes of the set depend on, as the object in its `run.json`.
    #[must_use]
    pub fn identity(&self) -> Value {
        let selection = &self.options.selection;
        let mut identity = json!({
            "schema": SET_SCHEMA,
            "generator": { "name": "starbreak", "version": env!("CARGO_PKG_VERSION") },
            "recipe_sha256": self.context.recipe_sha256,
            "seed": self.context.seed.0,
            "patterns": match self.patterns {
                Patterns::Fresh => json!("fresh"),
                Patterns::Network(imported) => json!({ "network_sha256": imported.sha256 }),
                Patterns::OverlayBank(bank) => json!({ "bank_sha256": bank.sha256() }),
                Patterns::Overlays(set) => json!({ "overlays": set.facts() }),
                Patterns::Bank(bank) => json!({ "bank_sha256": bank.sha256() }),
            },
            "samples": self.options.n_samples,
            "selection": { "limit": selection.limit, "sample": selection.sample },
            "source": {
                "format": self.source.format().name(),
                "names_sha256": self.survey.names_sha256,
            },
            "other_files": match self.options.other_files {
                Some(Carry::Copy) => "copy",
                Some(Carry::HardLink) => "hard-link",
                None => "skip",
            },
            "recipe": self.context.recipe,
        });
        if let Some(shard) = selection.shard {
            identity["shard"] = json!({ "number": shard.number, "of": shard.of });
        }
        identity
    }
}

/// The recipe and the seed that a set was made with.
///
/// # Errors
/// [`Error::Recipe`] for a recipe that is not valid (any more).
pub fn set_seed_and_recipe(identity: &Value) -> Result<(Seed, Recipe), Error> {
    let text = identity["recipe"].as_str().unwrap_or_default();
    let recipe = Recipe::parse("the recipe of the set", text)?;
    Ok((Seed(identity["seed"].as_u64().unwrap_or(0)), recipe))
}
