//! `PatternBank`: cracks that were made beforehand.

use std::path::PathBuf;

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use starbreak::Stopwatch;

use crate::arguments::{BoxesArg, Given, Kind, NameArg, SeedArg, SizeArg, Whole, seed_of};
use crate::errors::{of_recipe, raised};
use crate::images::image_of;
use crate::network::CrackNetwork;
use crate::ready::{Origin, ReadyCrack};
use crate::recipe::Recipe;

/// A bank of patterns made by `starbreak patterns`, open for reading: cracks that are simulated and
/// baked already, for any number of images. `len` is the number of patterns; `bank[k]` is the
/// `CrackNetwork` of one.
///
/// path: the folder, or the file `patterns.bank` in it.
///
/// Any number of threads and processes, forked or spawned, may use it at the same time. A pickle
/// holds the path and digest; if the path holds another bank when unpickled, that is a
/// `ValueError`. Raises `OSError` for a file that cannot be read or is damaged.
#[pyclass(frozen, module = "starbreak")]
#[derive(Debug)]
pub(crate) struct PatternBank {
    bank: starbreak_runs::bank::PatternBank,
    path: PathBuf,
}

impl PatternBank {
    /// The library's.
    pub(crate) fn bank(&self) -> &starbreak_runs::bank::PatternBank {
        &self.bank
    }

    /// The number of a pattern; negative ones count from the end, as in a list.
    fn number(&self, index: &Whole) -> PyResult<usize> {
        let n = self.bank.len();
        let number = index.clamped("index")?;
        let idx = match usize::try_from(number) {
            Ok(idx) => Some(idx),
            Err(_) => usize::try_from(number.unsigned_abs())
                .ok()
                .and_then(|back| n.checked_sub(back)),
        };
        idx.filter(|idx| *idx < n).ok_or_else(|| {
            PyIndexError::new_err(format!(
                "the bank {:?} has no pattern {}, only {n} (from 0)",
                self.bank.path(),
                index.given()
            ))
        })
    }

    fn ready(slf: &Bound<'_, Self>, idx: usize, size: (u32, u32)) -> PyResult<ReadyCrack> {
        let bank = slf.get();
        let pattern = slf
            .py()
            .detach(|| bank.bank.pattern(idx, size, &mut Stopwatch::start()));
        let chain = pattern.map_err(|error| raised(&error))?.chain;
        let origin = Origin::Bank {
            bank: slf.clone().unbind(),
            idx,
        };
        Ok(ReadyCrack::of(chain, origin))
    }
}

#[pymethods]
impl PatternBank {
    #[new]
    fn new(py: Python<'_>, path: Given<PathBuf>) -> PyResult<Self> {
        let path = path.named("path")?;
        let bank = py.detach(|| starbreak_runs::bank::PatternBank::open(&path));
        let bank = bank.map_err(|error| raised(&error))?;
        if bank.is_empty() {
            let message = format!("the bank {path:?} has no patterns");
            return Err(PyValueError::new_err(message));
        }
        Ok(Self {
            path: std::path::absolute(&path)?,
            bank,
        })
    }

    /// The bank of a pickle: the one at its path, if that is still the same.
    #[staticmethod]
    fn _reopen(py: Python<'_>, path: PathBuf, sha256: &str) -> PyResult<Self> {
        let bank = Self::new(py, Given::of(path))?;
        if bank.bank.sha256() != sha256 {
            return Err(PyValueError::new_err(format!(
                "{:?} holds another bank than the one that was pickled: its digest is {}, not {sha256}; put that \
                 one back, or open this one with PatternBank",
                bank.path,
                bank.bank.sha256()
            )));
        }
        Ok(bank)
    }

    /// Number of patterns.
    fn __len__(&self) -> usize {
        self.bank.len()
    }

    /// The network of a pattern.
    #[expect(clippy::needless_pass_by_value, reason = "arguments come as values")]
    fn __getitem__(&self, py: Python<'_>, index: Whole) -> PyResult<CrackNetwork> {
        let idx = self.number(&index)?;
        let network = py.detach(|| self.bank.network(idx));
        Ok(CrackNetwork::of(network.map_err(|error| raised(&error))?))
    }

    /// The networks of all patterns, one by one.
    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let builtins = slf.py().import("builtins")?;
        let numbers = builtins.call_method1("range", (slf.get().bank.len(),))?;
        builtins.call_method1("map", (slf.getattr("__getitem__")?, numbers))
    }

    /// The folder or file, absolute.
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    /// Width and height of the frames that it was baked for, px; images of other sizes take longer.
    #[getter]
    fn sizes(&self) -> Vec<(u32, u32)> {
        self.bank.header().sizes.clone()
    }

    /// The seed with which it was made.
    #[getter]
    fn seed(&self) -> u64 {
        self.bank.header().seed.0
    }

    /// SHA-256 of its header and index, hexadecimal; banks with the same digest are the same.
    #[getter]
    fn sha256(&self) -> &str {
        self.bank.sha256()
    }

    /// The recipe from which it was made; its camera and optics apply to all images.
    #[getter]
    fn recipe(&self) -> PyResult<Recipe> {
        let recipe = self.bank.header().parse_recipe();
        Recipe::of(recipe.map_err(|error| of_recipe(&error))?)
    }

    /// The index of the pattern that `crack` uses for this seed and name; all are equally likely.
    #[pyo3(
    signature = (seed, *, name = None, sample_index = Whole::of(0)),
    text_signature = "($self, seed, *, name=None, sample_index=0)"
)]
    #[expect(clippy::needless_pass_by_value, reason = "arguments come as values")]
    fn index_for(
        &self,
        seed: SeedArg,
        name: Option<NameArg>,
        sample_index: Whole,
    ) -> PyResult<usize> {
        let seed = seed_of(seed, name.as_ref(), &sample_index)?;
        Ok(self.bank.idx_for(seed))
    }

    /// Pattern `index`, ready for frames of a size (width and height, px). Negative indices count
    /// from the end. Raises `IndexError` if there is no such pattern.
    #[expect(clippy::needless_pass_by_value, reason = "arguments come as values")]
    fn pattern(slf: &Bound<'_, Self>, index: Whole, size: SizeArg) -> PyResult<ReadyCrack> {
        let idx = slf.get().number(&index)?;
        Self::ready(slf, idx, size.0)
    }

    /// The image behind a pattern of the bank: a new array, or a `Cracked` with `boxes` or `full`.
    ///
    /// image, seed, name, sample_index, boxes, full: as for `starbreak.crack`. With the path of the
    /// image in its dataset as `name`, the pixels are those of `starbreak generate --bank`.
    /// index: the pattern to use; without it one is drawn by the seed.
    #[pyo3(
    signature = (image, seed = SeedArg::ZERO, *, name = None, sample_index = Whole::of(0), index = None, boxes = None, full = Given::of(false)),
    text_signature = "($self, image, seed=0, *, name=None, sample_index=0, index=None, boxes=None, full=False)"
)]
    #[expect(
        clippy::too_many_arguments,
        reason = "they have names and defaults in Python"
    )]
    fn crack<'py>(
        slf: &Bound<'py, Self>,
        image: &Bound<'py, PyAny>,
        seed: SeedArg,
        name: Option<NameArg>,
        sample_index: Whole,
        index: Option<Whole>,
        boxes: Option<BoxesArg>,
        full: Given<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let full = full.named("full")?;
        let seed = seed_of(seed, name.as_ref(), &sample_index)?;
        let bank = slf.get();
        let idx = match index {
            Some(index) => bank.number(&index)?,
            None => bank.bank.idx_for(seed),
        };
        let pixels = image_of(image)?;
        let size = (pixels.width(), pixels.height());
        Self::ready(slf, idx, size)?.shown_in(slf.py(), pixels, None, seed, boxes, full)
    }

    fn __repr__(&self) -> String {
        format!("<starbreak.PatternBank of {} patterns>", self.bank.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (PathBuf, String))> {
        let reopen = py.get_type::<Self>().getattr("_reopen")?;
        Ok((reopen, (self.path.clone(), self.bank.sha256().to_owned())))
    }
}

impl Kind for Py<PatternBank> {
    const EXPECTED: &'static str = "a starbreak.PatternBank";
}
