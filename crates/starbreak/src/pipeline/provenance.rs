//! The record from which an image can be made again.

use std::path::{Path, PathBuf};

use serde::Serialize;
use serde_json::json;
use starbreak_dataset::{Provenance, blake3_hex, sha256_hex};
use starbreak_glass::CrackNetwork;
use starbreak_seed::Seed;

use super::details::Details;
use super::show::OpticsReport;
use super::timings::Timings;
use crate::import::ImportedNetwork;
use crate::overlay::OverlaySet;
use crate::{Error, Recipe, Settings};

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
    /// The network that stands in for a simulated one, if there is one.
    pub imported: Option<ImportedNetwork>,
    /// The photographs of broken glass that stand in for a network, if there are any.
    pub overlay: Option<OverlaySet>,
}

/// A file beside the record: by its name and hash the next run tells it from files of others.
#[derive(Debug, Serialize)]
pub(super) struct WrittenFile {
    name: String,
    blake3: String,
}

impl WrittenFile {
    pub(super) fn of(path: &Path, bytes: &[u8]) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Self {
            name: name.into_owned(),
            blake3: blake3_hex(bytes),
        }
    }
}

/// One image of a run.
pub(super) struct Item<'a> {
    /// Name of the input inside the run, which its seed is keyed by.
    pub(super) name: &'a str,
    pub(super) seed: Seed,
    pub(super) width_px: u32,
    pub(super) height_px: u32,
    pub(super) input_blake3: &'a str,
    pub(super) output: WrittenFile,
    pub(super) region: Option<WrittenFile>,
    pub(super) crack: Option<WrittenFile>,
    pub(super) maps: Vec<WrittenFile>,
    pub(super) network: &'a CrackNetwork,
    pub(super) details: &'a Details,
    pub(super) optics: &'a OpticsReport,
    pub(super) region_fraction: f64,
    pub(super) timings: &'a Timings,
}

impl RunContext {
    /// The context of a run with this recipe and seed, into this folder.
    ///
    /// # Errors
    /// [`Error::Recipe`] if the recipe has no valid settings.
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
            imported: None,
            overlay: None,
        })
    }

    pub(super) fn provenance(&self, item: &Item<'_>) -> Result<Provenance, Error> {
        let (pattern, facts) = item.details.facts_of(item.network);
        let mut camera = json!({ "width_px": item.width_px, "height_px": item.height_px });
        if let Some(scene) = &item.optics.scene {
            camera["f_px"] = scene.f_px.into();
            camera["glass_disc_px"] = scene.glass_disc_px.into();
            camera["scene_disc_px"] = scene.scene_disc_px.into();
        }
        let mut record = json!({
            "schema": PROVENANCE_SCHEMA,
            "generator": { "name": "starbreak", "version": env!("CARGO_PKG_VERSION") },
            "recipe": self.recipe,
            "recipe_sha256": self.recipe_sha256,
            "seed": self.seed.0,
            "item": { "name": item.name, "sample_index": 0, "seed": item.seed.0 },
            "camera": camera,
            "input": { "name": item.name, "blake3": item.input_blake3 },
            "output": item.output,
            (pattern): facts,
            "optics": item.optics.to_json(),
            "region_fraction": item.region_fraction,
            "timings_ms": item.timings.to_json(),
        });
        for (key, mask) in [("region", &item.region), ("crack", &item.crack)] {
            if let Some(mask) = mask {
                record[key] = json!(mask);
            }
        }
        if !item.maps.is_empty() {
            record["maps"] = json!(item.maps);
        }
        Ok(Provenance::new(record)?)
    }
}
