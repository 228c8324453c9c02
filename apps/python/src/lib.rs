//! The Python package `starbreak`: glue between Python and the crates, without logic of its own.
//!
//! Each file mirrors what it wraps: `recipe`, `network`, `crack`, `cracked`, `ready`, `light`, `bank`, `file`, `measure`,
//! `command`; `arguments`, `images`, `frames` and `values` carry arguments, arrays and plain values across, `errors` says
//! which Python error is which.
//! What Python sees is described in `python/starbreak/_starbreak.pyi` and in the docstrings.
#![forbid(unsafe_code)]

mod arguments;
mod bank;
mod command;
mod crack;
mod cracked;
mod errors;
mod file;
mod frames;
mod images;
mod light;
mod measure;
mod network;
mod ready;
mod recipe;
mod values;

/// The compiled part of the package `starbreak`.
#[pyo3::pymodule]
mod _starbreak {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::bank::PatternBank;
    #[pymodule_export]
    use crate::command::{_call, _run};
    #[pymodule_export]
    use crate::crack::{corrupt, crack, item_seed, simulate};
    #[pymodule_export]
    use crate::cracked::Cracked;
    #[pymodule_export]
    use crate::errors::SimulationError;
    #[pymodule_export]
    use crate::file::{blake3_hex, crack_file};
    #[pymodule_export]
    use crate::images::street_scene;
    #[pymodule_export]
    use crate::light::LightFilter;
    #[pymodule_export]
    use crate::measure::{divergence, evaluate};
    #[pymodule_export]
    use crate::network::CrackNetwork;
    #[pymodule_export]
    use crate::ready::ReadyCrack;
    #[pymodule_export]
    use crate::recipe::{Recipe, cameras, json_schema, presets};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        starbreak_runs::dataset::silence_fenced_panics();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
