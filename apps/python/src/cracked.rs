//! A cracked image with everything that is known about it.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use starbreak_runs::dataset::{Encoding, encode_image};

use crate::arguments::Given;
use crate::errors::raised;
use crate::images::{image_of, size_of};
use crate::network::CrackNetwork;

/// A cracked image with everything that is known about it. Returned by `crack` and similar
/// functions; the constructor is for unpickling.
#[pyclass(frozen, module = "starbreak", get_all)]
#[derive(Debug)]
pub(crate) struct Cracked {
    /// The image: uint8, of the shape of the input.
    pub(crate) image: Py<PyAny>,
    /// The region mask: uint8, H x W, 255 where pixels are affected, else 0.
    pub(crate) region: Py<PyAny>,
    /// The crack mask: uint8, H x W, coverage by cracks as if in focus, 255 is full coverage.
    pub(crate) crack: Py<PyAny>,
    /// The crack network; None for a pattern of a bank, whose network is `bank[index]`.
    pub(crate) network: Option<Py<CrackNetwork>>,
    /// What a provenance record says: `network`, `optics` (contrast, environment),
    /// `region_fraction`.
    pub(crate) facts: Py<PyAny>,
    /// The damage of each given box, None for a box without a pixel in the frame: `region_share` (0
    /// to 1), `displacement_px`, `blur_radius_px`, `contrast_lost` (None if the picture in the box
    /// is flat).
    pub(crate) damage: Py<PyAny>,
    /// Whether the glass is intact.
    pub(crate) intact: bool,
}

#[pymethods]
impl Cracked {
    #[new]
    fn new(
        image: Bound<'_, PyAny>,
        region: Bound<'_, PyAny>,
        crack: Bound<'_, PyAny>,
        network: Option<Given<Py<CrackNetwork>>>,
        facts: Py<PyAny>,
        damage: Py<PyAny>,
        intact: Given<bool>,
    ) -> PyResult<Self> {
        let size = size_of("image", &image, true)?;
        for (name, mask) in [("region", &region), ("crack", &crack)] {
            let of_mask = size_of(name, mask, false)?;
            if of_mask != size {
                return Err(PyValueError::new_err(format!(
                    "{name} is {} x {} px, the image {} x {} px; expected masks of the size of the image",
                    of_mask.0, of_mask.1, size.0, size.1
                )));
            }
        }
        Ok(Self {
            image: image.unbind(),
            region: region.unbind(),
            crack: crack.unbind(),
            network: Given::if_given(network, "network")?,
            facts,
            damage,
            intact: intact.named("intact")?,
        })
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let of = |value: &Py<PyAny>| value.clone_ref(py);
        let from = (
            of(&self.image),
            of(&self.region),
            of(&self.crack),
            self.network.as_ref().map(|network| network.clone_ref(py)),
            of(&self.facts),
            of(&self.damage),
            self.intact,
        );
        Ok((py.get_type::<Self>().into_any(), from.into_pyobject(py)?))
    }

    /// The image as PNG, which notebooks show.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let pixels = image_of(self.image.bind(py))?;
        let png = py.detach(|| encode_image(&pixels, &Encoding::Png, None));
        let png = png.map_err(|error| raised(&starbreak_runs::Error::from(error)))?;
        Ok(PyBytes::new(py, &png))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let facts = self.facts.bind(py).cast::<PyDict>()?;
        let share = facts.get_item("region_fraction")?;
        let share: f64 = share.map_or(Ok(0.0), |share| share.extract())?;
        Ok(format!(
            "<starbreak.Cracked: {:.1} % of the frame affected>",
            share * 100.0
        ))
    }
}
