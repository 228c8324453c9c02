//! Recipe to settings to pictures: the place where physics, optics and samples on disk meet.
//!
//! [`Recipe`] is what a user writes; [`Recipe::settings`] makes it valid and SI;
//! [`pipeline`] runs it. This crate contains no formula of its own, and it never prints.
//!
//! # Example
//! ```
//! use image::{DynamicImage, RgbImage};
//! use starbreak::{Recipe, Seed, pipeline};
//!
//! let mut recipe = Recipe::preset("paper")?;
//! recipe.set("fracture.particles=2000")?;
//! recipe.set("impact.position=[0.5, 0.5]")?;
//! let settings = recipe.settings()?;
//!
//! let mut image = DynamicImage::ImageRgb8(RgbImage::from_pixel(320, 200, image::Rgb([80, 90, 100])));
//! let cracked = pipeline::crack_image(&settings, &mut image, Seed(7))?;
//! assert!(cracked.network.n_segments() > 0);
//! # Ok::<(), starbreak::Error>(())
//! ```
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod bank;
pub mod clip;
mod cost;
pub mod divergence;
mod error;
pub mod evaluation;
pub mod generate;
pub mod import;
pub mod overlay;
pub mod pipeline;
mod plain_words;
mod recipe;
pub mod study;

pub use cost::{Cost, DEFAULT_MAX_MEMORY_BYTES, LEAST_MAX_MEMORY_BYTES};
pub use error::Error;
pub use import::ImportError;
pub use recipe::{
    Assignment, CameraSettings, DEFAULT_PRESET, FocalLength, FractureSettings, MAX_RECIPE_BYTES,
    Mount, OpticsSettings, OutputFormat, OutputSettings, PRESETS, PaperSettings, PhysicsSettings,
    Recipe, RecipeError, SCHEMA_VERSION, Settings, StoneSettings, cameras, json_schema,
};
pub use starbreak_dataset as dataset;
pub use starbreak_eval as eval;
pub use starbreak_fracture as fracture;
pub use starbreak_glass as glass;
pub use starbreak_optics as optics;
pub use starbreak_seed::Seed;
