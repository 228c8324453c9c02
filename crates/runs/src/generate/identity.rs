//! What a set is made from.

use serde_json::{Value, json};
use starbreak::Recipe;
use starbreak_dataset::{Carry, SET_SCHEMA};
use starbreak_seed::Seed;

use super::Plan;
use crate::Error;

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
            "patterns": self.patterns.identity(),
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

/// The words after `starbreak generate FORMAT:PATH -o SET` that make a set of this identity, where
/// `recipe` is a file with its recipe. Of what its cracks come from only the kind is known.
#[must_use]
pub fn generate_flags(identity: &Value, recipe: &str) -> Vec<String> {
    let patterns = &identity["patterns"];
    let patterns = [
        ("bank_sha256", "--bank BANK"),
        ("network_sha256", "--network NETWORK"),
        ("overlays", "--overlays PHOTOS"),
    ]
    .into_iter()
    .find(|(key, _)| !patterns[key].is_null());
    let is_bank = matches!(patterns, Some(("bank_sha256", _)));
    let mut flags = match is_bank {
        // Its recipe is that of the bank.
        true => Vec::new(),
        false => vec!["--recipe".to_owned(), recipe.to_owned()],
    };
    flags.extend(
        patterns
            .iter()
            .flat_map(|(_, flag)| flag.split(' '))
            .map(str::to_owned),
    );
    let mut add = |flag: &str, value: Option<String>| {
        flags.extend(value.into_iter().flat_map(|value| [flag.to_owned(), value]));
    };
    let number = |value: &Value| value.as_u64().map(|n| n.to_string());
    let not = |usual: &str, value: Option<String>| value.filter(|value| value != usual);
    add("--seed", not("0", number(&identity["seed"])));
    add("--samples", not("1", number(&identity["samples"])));
    add("--limit", number(&identity["selection"]["limit"]));
    add("--sample", number(&identity["selection"]["sample"]));
    let shard = &identity["shard"];
    let shard = number(&shard["number"]).zip(number(&shard["of"]));
    add(
        "--shard",
        shard.map(|(number, of)| format!("{number}/{of}")),
    );
    let other_files = identity["other_files"].as_str().map(str::to_owned);
    add("--other-files", not("copy", other_files));
    flags
}

/// The recipe and the seed that a set was made with.
///
/// # Errors
/// [`Error::Chain`] for a recipe that is not valid (any more).
pub fn set_seed_and_recipe(identity: &Value) -> Result<(Seed, Recipe), Error> {
    let text = identity["recipe"].as_str().unwrap_or_default();
    let recipe = Recipe::parse("the recipe of the set", text)?;
    Ok((Seed(identity["seed"].as_u64().unwrap_or(0)), recipe))
}
