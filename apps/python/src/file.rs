//! `crack_file`: one image file to the files of a set; and the digest by which records know files.

use std::path::Path;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use starbreak_runs::RunContext;
use starbreak_runs::generate::{CrackedFiles, crack_file as cracked_files};

use crate::arguments::{BytesArg, Given, NameArg, SeedArg, Whole};
use crate::bank::PatternBank;
use crate::errors::{of_recipe, raised};
use crate::recipe::RecipeArg;

/// The files that an image becomes in a set, by their names from the root of the set.
type NamedFiles<'py> = Vec<(String, Bound<'py, PyBytes>)>;

/// The files that `starbreak generate` makes of one image file without labels, to the byte; for
/// pipelines with their own input and output, such as on a cluster.
///
/// data: the bytes of a PNG or JPEG file; `bytes`, or anything with a buffer.
/// name: its name in the dataset, such as `train/a.png`, which determines the crack together with
/// seed and sample.
/// recipe: a `Recipe`, the name of a preset, or tables as a dict; default `windshield-spiderweb`.
/// seed: 0 to 2**64 - 1, the seed of the whole set.
/// bank: a `PatternBank`, instead of a recipe.
/// sample_index, n_samples: which of how many cracked versions of the image.
///
/// Returns pairs of name and bytes: the image, the region and crack masks, and the record, which
/// should be written last. Runs in the calling thread only and releases the interpreter's lock.
/// Raises `ValueError` for wrong parameters and for a recipe whose `output.format` or `output.maps`
/// a set cannot have, `OSError` for bytes that are not an image, `SimulationError` if the models
/// have no result.
///
/// >>> import starbreak
/// >>> starbreak.crack_file(b"no image", "a.png")
/// Traceback (most recent call last):
///     ...
/// OSError: "a.png": "a.png" is not PNG, JPEG, WebP or BMP, it looks like text; convert it to PNG
#[pyfunction]
#[pyo3(
    signature = (data, name, recipe = None, seed = SeedArg::ZERO, *, bank = None, sample_index = Whole::of(0), n_samples = Whole::of(1)),
    text_signature = "(data, name, recipe=None, seed=0, *, bank=None, sample_index=0, n_samples=1)"
)]
#[expect(
    clippy::too_many_arguments,
    reason = "they have names and defaults in Python"
)]
pub(crate) fn crack_file<'py>(
    py: Python<'py>,
    data: BytesArg,
    name: NameArg,
    recipe: Option<RecipeArg>,
    seed: SeedArg,
    bank: Option<Given<Py<PatternBank>>>,
    sample_index: Whole,
    n_samples: Whole,
) -> PyResult<NamedFiles<'py>> {
    let bank = Given::if_given(bank, "bank")?;
    let bank = bank.as_ref().map(Py::get);
    let data = data.0.as_bytes(py);
    if bank.is_some() && recipe.is_some() {
        let message = "a bank has its recipe; give one of both";
        return Err(PyValueError::new_err(message));
    }
    let n_samples = n_samples.within("n_samples", 1..=u32::MAX)?;
    let sample_index = sample_index.within("sample_index", 0..=u32::MAX)?;
    if sample_index >= n_samples {
        let message =
            format!("sample_index {sample_index}; expected less than n_samples {n_samples}");
        return Err(PyValueError::new_err(message));
    }
    let recipe = match bank {
        Some(bank) => {
            let recipe = bank.bank().header().parse_recipe();
            recipe.map_err(|error| of_recipe(&error))?
        }
        None => RecipeArg::or_default(recipe)?.recipe().clone(),
    };
    let made: Result<CrackedFiles, starbreak_runs::Error> = py.detach(|| {
        let context = RunContext::new(&recipe, seed.0, Path::new(""))?;
        let bank = bank.map(PatternBank::bank);
        cracked_files(&context, bank, &name.0, (sample_index, n_samples), data)
    });
    let files = made.map_err(|error| raised(&error))?.files;
    let named = files.into_iter();
    Ok(named
        .map(|(name, bytes)| (name, PyBytes::new(py, &bytes)))
        .collect())
}

/// BLAKE3 of the bytes of a file, 64 hexadecimal digits; the `blake3` in records and lists.
///
/// data: `bytes`, or anything with a buffer.
///
/// >>> import starbreak
/// >>> starbreak.blake3_hex(b"")[:16]
/// 'af1349b9f5f9a1a6'
#[pyfunction]
#[pyo3(text_signature = "(data)")]
pub(crate) fn blake3_hex(py: Python<'_>, data: BytesArg) -> String {
    starbreak_runs::dataset::blake3_hex(data.0.as_bytes(py))
}
