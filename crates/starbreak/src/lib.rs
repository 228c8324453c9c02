//! Recipe to settings to pictures, in memory: the place where physics and optics meet.
//!
//! [`Recipe`] is what a user writes; [`Recipe::settings`] makes it valid and SI; a [`Chain`] breaks the
//! glass and puts it over images. This crate contains no formula of glass or light, never prints, touches no
//! file and starts no thread, so that it runs in a browser, too.
//!
//! # Example
//! ```
//! use image::{DynamicImage, RgbImage};
//! use starbreak::{Chain, Recipe, Seed};
//!
//! let mut recipe = Recipe::preset("paper")?;
//! recipe.set("fracture.particles=2000")?;
//! recipe.set("impact.position=[0.5, 0.5]")?;
//! let chain = Chain::of(&recipe.settings()?, (320, 200), Seed(7))?;
//!
//! let mut image = DynamicImage::ImageRgb8(RgbImage::from_pixel(320, 200, image::Rgb([80, 90, 100])));
//! chain.over(&mut image, Seed(7))?;
//! assert!(!chain.is_intact());
//! # Ok::<(), starbreak::Error>(())
//! ```
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod broken;
mod camera_faults;
mod chain;
mod cost;
mod error;
mod growth;
pub mod import;
pub mod photo;
mod plain_words;
mod recipe;
mod scene;
mod timings;

pub use broken::{Details, ImportedDetails, PaperDetails, PhysicsDetails, Simulated, simulate};
pub use camera_faults::CameraFaults;
pub use chain::{
    CLASSES, Chain, KeptFrame, Lit, Live, OpticsReport, PaneLayer, SceneReport, Shown,
    damage_to_json, environment_to_json, region_fraction,
};
pub use cost::Cost;
pub use error::Error;
pub use growth::{Arrivals, growth_drawing, growth_times};
pub use import::ImportError;
pub use recipe::{
    Assignment, CameraSettings, DEFAULT_MAX_MEMORY_BYTES, DEFAULT_PRESET, FAULTS, FaultKind,
    FocalLength, FractureSettings, LEAST_MAX_MEMORY_BYTES, MAX_RECIPE_BYTES, Mount, OpticsSettings,
    OutputFormat, OutputSettings, PRESETS, PaperSettings, PhysicsSettings, Recipe, RecipeError,
    SCENARIOS, SCHEMA_VERSION, Scenario, Settings, StoneSettings, cameras, json_schema, presets,
};
pub use scene::Scene;
pub use starbreak_fracture as fracture;
pub use starbreak_glass as glass;
pub use starbreak_optics as optics;
pub use starbreak_seed::Seed;
pub use starbreak_sensor as sensor;
pub use timings::{Stopwatch, Timings};
