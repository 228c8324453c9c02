//! The record from which an image can be made again.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::{Map, Value, json};
use starbreak::{Recipe, Settings, Shown};
use starbreak_dataset::{blake3_hex, sha256_hex};
use starbreak_seed::Seed;

use crate::Error;

/// Name and version of the provenance format.
pub const PROVENANCE_SCHEMA: &str = "starbreak.provenance/2";

/// What all items of a run share.
#[derive(Debug, Clone, PartialEq)]
pub struct RunContext {
    /// The complete recipe as TOML.
    pub recipe: String,
    /// SHA-256 of that text, hexadecimal.
    pub recipe_sha256: String,
    /// The seed of the run.
    pub seed: Seed,
    /// The recipe in SI units.
    pub settings: Settings,
    /// The folder that everything is written into.
    pub out: PathBuf,
    /// Whether files there may be replaced that are not of an earlier run.
    pub replaces: bool,
}

/// A file beside the record: by its name and hash the next run tells it from files of others.
#[derive(Debug, Serialize)]
pub(crate) struct WrittenFile {
    name: String,
    blake3: String,
}

impl WrittenFile {
    /// By a name from the folder of the run.
    pub(crate) fn of(name: &str, bytes: &[u8]) -> Self {
        Self {
            name: name.to_owned(),
            blake3: blake3_hex(bytes),
        }
    }
}

/// One sample of an image, and what its record says.
pub(crate) struct Sample<'a> {
    /// Name of the image inside the run, which its seed is keyed by.
    pub(crate) name: &'a str,
    pub(crate) sample_idx: u32,
    pub(crate) seed: Seed,
    /// Width and height of the image, px.
    pub(crate) size: (u32, u32),
    pub(crate) input_blake3: &'a str,
    /// The files beside the record, each by its key.
    pub(crate) files: Vec<(&'static str, WrittenFile)>,
    /// What the record says of the damage, by key.
    pub(crate) facts: &'a Map<String, Value>,
    pub(crate) shown: &'a Shown,
}

impl RunContext {
    /// The context of a run with this recipe and seed, into this folder.
    ///
    /// # Errors
    /// [`Error::Chain`] if the recipe has no valid settings.
    pub fn new(recipe: &Recipe, seed: Seed, out: &Path) -> Result<Self, Error> {
        let text = recipe.to_toml();
        let settings = recipe.settings()?;
        Ok(Self {
            recipe_sha256: sha256_hex(text.as_bytes()),
            recipe: text,
            seed,
            settings,
            out: out.to_owned(),
            replaces: false,
        })
    }

    /// The record of a sample, in any run; with the `recipe` where no list of a set has it.
    pub(crate) fn record(&self, of: Sample<'_>, recipe: Option<&str>) -> Map<String, Value> {
        let optics = &of.shown.optics;
        let mut camera = json!({ "width_px": of.size.0, "height_px": of.size.1 });
        if let Some(scene) = &optics.scene {
            camera["f_px"] = scene.f_px.into();
            camera["glass_disc_px"] = scene.glass_disc_px.into();
            camera["scene_disc_px"] = scene.scene_disc_px.into();
        }
        let mut record = Map::new();
        let mut add = |key: &str, value: Value| {
            record.insert(key.to_owned(), value);
        };
        add("schema", json!(PROVENANCE_SCHEMA));
        add(
            "generator",
            json!({ "name": "starbreak", "version": env!("CARGO_PKG_VERSION") }),
        );
        if let Some(recipe) = recipe {
            add("recipe", json!(recipe));
        }
        add("recipe_sha256", json!(self.recipe_sha256));
        add("seed", json!(self.seed.0));
        add(
            "item",
            json!({ "name": of.name, "sample_index": of.sample_idx, "seed": of.seed.0 }),
        );
        add("camera", camera);
        add(
            "input",
            json!({ "name": of.name, "blake3": of.input_blake3 }),
        );
        for (key, file) in of.files {
            add(key, json!(file));
        }
        for (key, fact) in of.facts {
            add(key, fact.clone());
        }
        add("optics", optics.to_json());
        add("region_fraction", json!(of.shown.region_fraction));
        if let Some(state) = of.shown.arrival {
            add("arrival", json!({ "state": state.name() }));
        }
        record
    }
}
