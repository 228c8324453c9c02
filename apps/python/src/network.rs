//! `CrackNetwork`: the cracks as columns.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use numpy::ndarray::Array2;
use numpy::{IntoPyArray as _, PyFixedUnicode};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;
use starbreak::glass::{Nodes, SegmentKind, Segments};
use starbreak::import::{ImportedNetwork, parse_network};
use starbreak_runs::dataset::{DatasetError, OutputBatch, sha256_hex};
use starbreak_runs::read_network;

use crate::arguments::{Given, Kind};
use crate::errors::raised;
use crate::values::python_of;

/// A crack network: a planar graph of nodes and segments with its history, fully validated.
///
/// `len` is the number of segments. Columns are new NumPy arrays; columns that a model does not
/// produce are absent.
///
/// >>> import starbreak
/// >>> network = starbreak.simulate("windshield-star", seed=7)
/// >>> x, y = network.nodes["x"], network.nodes["y"]
/// >>> start, end = network.segments["from"], network.segments["to"]
/// >>> length_mm = ((x[end] - x[start]) ** 2 + (y[end] - y[start]) ** 2) ** 0.5
/// >>> bool(abs(length_mm.sum() - network.summary["total_length"]) < 1e-6)
/// True
/// >>> starbreak.CrackNetwork.from_json(network.to_json()) == network
/// True
#[pyclass(frozen, eq, module = "starbreak")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CrackNetwork {
    network: Arc<starbreak::glass::CrackNetwork>,
}

impl Kind for Py<CrackNetwork> {
    const EXPECTED: &'static str = "a starbreak.CrackNetwork";
}

/// Characters of the longest word in a column.
const N_CHARS: usize = 10;

impl CrackNetwork {
    pub(crate) fn of(network: starbreak::glass::CrackNetwork) -> Self {
        Self {
            network: Arc::new(network),
        }
    }

    /// The network in the place of a simulated one, as if it had been read from its own file.
    pub(crate) fn imported(&self) -> ImportedNetwork {
        ImportedNetwork {
            network: starbreak::glass::CrackNetwork::clone(&self.network),
            name: "network.json".to_owned(),
            sha256: sha256_hex(self.network.to_json().as_bytes()),
        }
    }
}

#[pymethods]
impl CrackNetwork {
    /// A network from the text of its file: JSON, or an SVG drawing whose stroked shapes are
    /// cracks. Raises `ValueError` if it is not a network.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: Given<String>) -> PyResult<Self> {
        let text = text.named("text")?;
        let network = py.detach(|| parse_network(&text));
        let wrong = |cause| PyValueError::new_err(format!("the text {cause}"));
        Ok(Self::of(network.map_err(wrong)?))
    }

    /// A network from its file, JSON or SVG. Raises `OSError` if it cannot be read, `ValueError` if
    /// it is not a network.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: Given<PathBuf>) -> PyResult<Self> {
        let path = path.named("path")?;
        let read = py.detach(|| read_network(&path));
        Ok(Self::of(read.map_err(|error| raised(&error))?.network))
    }

    /// The text of its file (`starbreak.crack-network/1`), the same bytes as the command writes.
    fn to_json(&self, py: Python<'_>) -> String {
        py.detach(|| self.network.to_json())
    }

    /// A drawing of the cracks, as SVG text.
    fn to_svg(&self, py: Python<'_>) -> String {
        py.detach(|| self.network.to_svg())
    }

    /// Writes the network as JSON, all or nothing, into an existing folder: to a temporary file
    /// that is then renamed. An existing network file is replaced by a new file with the mode of a
    /// new file; any other file or link only with `replace` (the target of the link stays). Raises
    /// `FileExistsError` for such a file, `OSError` if it cannot be written, `ValueError` for a
    /// name that ends in .svg.
    #[pyo3(signature = (path, *, replace = Given::of(false)), text_signature = "(self, path, *, replace=False)")]
    fn save(&self, py: Python<'_>, path: Given<PathBuf>, replace: Given<bool>) -> PyResult<()> {
        let path = path.named("path")?;
        let replaces = replace.named("replace")?;
        if path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("svg"))
        {
            return Err(PyValueError::new_err(format!(
                "path = {path:?}; save writes JSON, expected a name such as network.json; for a drawing write to_svg()"
            )));
        }
        let written = py.detach(|| -> Result<(), DatasetError> {
            // The batch would make the folder, as the command does; what Python saves does not.
            let folder = path.parent().filter(|folder| *folder != Path::new(""));
            let is_there = folder.map_or(Ok(()), |folder| fs::metadata(folder).map(drop));
            is_there.map_err(|source| DatasetError::Write {
                path: path.clone(),
                source,
            })?;
            let mut batch = OutputBatch::new().replacing(replaces);
            batch.stage(&path, self.network.to_json().as_bytes())?;
            batch.commit()
        });
        written.map_err(|error| raised(&error.into()))
    }

    /// The model that made it: `paper`, `physics` or `imported`.
    #[getter]
    fn model<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &json!(self.network.data().model))
    }

    /// The seed from which it can be reproduced; None for a drawing.
    #[getter]
    fn seed(&self) -> Option<u64> {
        self.network.data().seed.map(|seed| seed.0)
    }

    /// Unit of positions and lengths: `px` or `mm`.
    #[getter]
    fn unit(&self) -> &'static str {
        self.network.data().unit.symbol()
    }

    /// Name of the damage class, None if the model has none.
    #[getter]
    fn damage_class(&self) -> Option<&str> {
        self.network.data().damage_class.as_deref()
    }

    /// The pane: width and height in `unit`, and what else is known.
    #[getter]
    fn pane<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &json!(self.network.data().pane))
    }

    /// The impacts: x and y in `unit`, and what else is known about each.
    #[getter]
    fn impacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &json!(self.network.data().impacts))
    }

    /// Key figures: `n_segments`, `n_radial`, `total_length` in `unit`, and others.
    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &json!(self.network.summary()))
    }

    /// Points in `unit`, one in each piece of glass that has fallen out.
    #[getter]
    fn fallen(&self) -> Vec<[f64; 2]> {
        self.network.data().fallen.clone()
    }

    /// Number of segments.
    fn __len__(&self) -> usize {
        self.network.n_segments()
    }

    /// Columns of the nodes: `x` and `y`, float64, in `unit`, y down.
    #[getter]
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Nodes { x, y } = &self.network.data().nodes;
        let columns = PyDict::new(py);
        columns.set_item("x", x.clone().into_pyarray(py))?;
        columns.set_item("y", y.clone().into_pyarray(py))?;
        Ok(columns)
    }

    /// Columns of the segments, each of length N: `from` and `to` (uint32, node indices), `kind`
    /// (string), and, where the model has them, `parent` (int64, -1 for none), `arrival_us`,
    /// `departure_us`, `stress_mpa`, `opening_um`, `depth_fraction`, `roughness_um`, `tilt_deg`,
    /// `k_ratio`, `arrival_step`, `stress_paper_units` (float64), `depth_ends`, `tilt_ends_deg`
    /// (float64, N × 2: at `from` and at `to`), `zone` and `face` (string), `ply` (uint8).
    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        // All of them, so that a new one is not forgotten here.
        let Segments {
            from,
            to,
            kind,
            parent,
            arrival_step,
            arrival_us,
            departure_us,
            stress_paper_units,
            stress_mpa,
            opening_um,
            depth_fraction,
            zone,
            roughness_um,
            tilt_deg,
            depth_ends,
            tilt_ends_deg,
            ply,
            face,
            k_ratio,
        } = &self.network.data().segments;
        let columns = PyDict::new(py);
        columns.set_item("from", from.clone().into_pyarray(py))?;
        columns.set_item("to", to.clone().into_pyarray(py))?;
        let words: Vec<_> = kind
            .iter()
            .map(|kind| word(SegmentKind::name(*kind)))
            .collect();
        columns.set_item("kind", words.into_pyarray(py))?;
        if let Some(parent) = parent {
            let of_none = |parent: &Option<u32>| parent.map_or(-1, i64::from);
            let parent: Vec<i64> = parent.iter().map(of_none).collect();
            columns.set_item("parent", parent.into_pyarray(py))?;
        }
        let floats = [
            ("arrival_step", arrival_step),
            ("arrival_us", arrival_us),
            ("departure_us", departure_us),
            ("stress_paper_units", stress_paper_units),
            ("stress_mpa", stress_mpa),
            ("opening_um", opening_um),
            ("depth_fraction", depth_fraction),
            ("roughness_um", roughness_um),
            ("tilt_deg", tilt_deg),
            ("k_ratio", k_ratio),
        ];
        for (name, column) in floats {
            if let Some(column) = column {
                columns.set_item(name, column.clone().into_pyarray(py))?;
            }
        }
        for (name, column) in [("depth_ends", depth_ends), ("tilt_ends_deg", tilt_ends_deg)] {
            if let Some(ends) = column {
                let ends = Array2::from(ends.clone());
                columns.set_item(name, ends.into_pyarray(py))?;
            }
        }
        if let Some(zone) = zone {
            let words: Vec<_> = zone.iter().map(|zone| word(zone.name())).collect();
            columns.set_item("zone", words.into_pyarray(py))?;
        }
        if let Some(face) = face {
            let words: Vec<_> = face.iter().map(|face| word(face.name())).collect();
            columns.set_item("face", words.into_pyarray(py))?;
        }
        if let Some(ply) = ply {
            columns.set_item("ply", ply.clone().into_pyarray(py))?;
        }
        Ok(columns)
    }

    /// The drawing of `to_svg`, which notebooks show.
    fn _repr_svg_(&self, py: Python<'_>) -> String {
        self.to_svg(py)
    }

    fn __repr__(&self) -> String {
        let summary = self.network.summary();
        format!(
            "<starbreak.CrackNetwork of {} segments, {:.0} {} of cracks>",
            summary.n_segments,
            summary.total_length,
            self.unit()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let from_json = py.get_type::<Self>().getattr("from_json")?;
        Ok((from_json, (self.to_json(py),)))
    }
}

/// A word as NumPy keeps it in an array.
fn word(text: &str) -> PyFixedUnicode<N_CHARS> {
    let mut codes = [0; N_CHARS];
    for (code, letter) in codes.iter_mut().zip(text.chars()) {
        *code = letter.into();
    }
    PyFixedUnicode(codes)
}
