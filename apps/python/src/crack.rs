//! `simulate`, `crack`, `corrupt`, and a crack that is ready for many frames.

use image::DynamicImage;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use serde_json::{Value, json};
use starbreak::{Chain, Error, Seed, Settings, Simulated, Stopwatch, damage_to_json};
use starbreak_runs::dataset::{Encoding, encode_image};

use crate::arguments::{BoxesArg, Given, NameArg, SeedArg, SizeArg, Whole, seed_of};
use crate::bank::PatternBank;
use crate::errors::{raised, raised_in_memory};
use crate::images::{array_of, image_of, mask_of, size_of};
use crate::network::CrackNetwork;
use crate::recipe::{Recipe, RecipeArg};
use crate::values::python_of;

/// The crack network of the glass in front of a frame.
///
/// recipe: a `Recipe`, the name of a preset, or tables as a dict; default `windshield-spiderweb`.
/// seed: 0 to 2**64 - 1, determines everything random.
/// size: width and height of the frame, px.
///
/// Raises `ValueError` for wrong parameters, `SimulationError` if the models have no result.
///
/// >>> import starbreak
/// >>> network = starbreak.simulate("windshield-star", seed=7)
/// >>> network.unit, network.damage_class
/// ('mm', 'star')
/// >>> len(network) == len(network.segments["arrival_us"])
/// True
#[pyfunction]
#[pyo3(
    signature = (recipe = None, seed = SeedArg::ZERO, size = SizeArg::DEFAULT),
    text_signature = "(recipe=None, seed=0, size=(1242, 375))"
)]
pub(crate) fn simulate(
    py: Python<'_>,
    recipe: Option<RecipeArg>,
    seed: SeedArg,
    size: SizeArg,
) -> PyResult<CrackNetwork> {
    let settings = RecipeArg::or_default(recipe)?.settings();
    let simulated = py.detach(|| starbreak::simulate(&settings, size.0, seed.0));
    Ok(CrackNetwork::of(
        simulated.map_err(|error| raised_in_memory(&error))?.network,
    ))
}

/// The seed of an item of a dataset, derived from the seed of the run, the name of the item and the
/// sample number, as the command does for each image.
///
/// >>> import starbreak
/// >>> starbreak.item_seed(7, "photo.png") == starbreak.item_seed(7, "other.png")
/// False
#[pyfunction]
#[pyo3(
    signature = (seed, name, sample_index = Whole::of(0)),
    text_signature = "(seed, name, sample_index=0)"
)]
#[expect(clippy::needless_pass_by_value, reason = "arguments come as values")]
pub(crate) fn item_seed(seed: SeedArg, name: NameArg, sample_index: Whole) -> PyResult<u64> {
    Ok(seed_of(seed, Some(&name), &sample_index)?.0)
}

/// The image behind broken glass, as a new array of the same shape; `image` is not changed.
///
/// image: uint8, H x W x 3 (sRGB), H x W x 4 (its alpha stays) or H x W (gray), any strides; 1 to
/// 32768 px per side; or an image of Pillow in the mode RGB, RGBA or L.
/// recipe: a `Recipe`, the name of a preset, or tables as a dict; default `windshield-spiderweb`.
/// severity: 1 (mild) to 5 (severe), of a preset.
/// seed: 0 to 2**64 - 1, determines everything random.
/// name, sample_index: with a name, the seed is `item_seed(seed, name, sample_index)`. With the
/// name that the command uses, the pixels are the command's: `starbreak crack` uses the file's name
/// (`photo.png`), `starbreak generate` its path in the dataset.
/// network: cracks to show instead of simulated ones.
/// boxes: boxes [x0, y0, x1, y1] in px whose damage is measured; the result is then a `Cracked`.
/// full: return a `Cracked`, with masks, network and facts, instead of the array.
///
/// Runs in the calling thread only and releases the interpreter's lock. Raises `TypeError` if
/// `image` is not an array, `ValueError` for another dtype or shape and for wrong parameters,
/// `SimulationError` if the models have no result.
///
/// >>> import numpy as np, starbreak
/// >>> image = np.full((375, 1242, 3), 128, np.uint8)
/// >>> cracked = starbreak.crack(image, "windshield-star", seed=7)
/// >>> cracked.shape, cracked.dtype
/// ((375, 1242, 3), dtype('uint8'))
/// >>> full = starbreak.crack(image, "windshield-star", seed=7, boxes=[[600, 100, 700, 200]])
/// >>> bool((full.image == cracked).all()), full.region.shape
/// (True, (375, 1242))
/// >>> sorted(full.damage[0])
/// ['blur_radius_px', 'contrast_lost', 'displacement_px', 'region_share']
#[pyfunction]
#[pyo3(
    signature = (image, recipe = None, seed = SeedArg::ZERO, *, severity = None, name = None, sample_index = Whole::of(0), network = None, boxes = None, full = Given::of(false)),
    text_signature = "(image, recipe=None, seed=0, *, severity=None, name=None, sample_index=0, network=None, boxes=None, full=False)"
)]
#[expect(
    clippy::too_many_arguments,
    reason = "they have names and defaults in Python"
)]
pub(crate) fn crack<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    recipe: Option<RecipeArg>,
    seed: SeedArg,
    severity: Option<Whole>,
    name: Option<NameArg>,
    sample_index: Whole,
    network: Option<Given<Py<CrackNetwork>>>,
    boxes: Option<BoxesArg>,
    full: Given<bool>,
) -> PyResult<Bound<'py, PyAny>> {
    let (network, full) = (Given::if_given(network, "network")?, full.named("full")?);
    let recipe = RecipeArg::at_severity(recipe, severity.as_ref())?;
    let pixels = image_of(image)?;
    let seed = seed_of(seed, name.as_ref(), &sample_index)?;
    let size = (pixels.width(), pixels.height());
    ReadyCrack::fresh(py, recipe, seed, size, network_of(network))?
        .shown_in(py, pixels, seed, boxes, full)
}

/// The image behind broken glass, with the signature of `imagecorruptions.corrupt` plus a seed.
///
/// image: uint8, H x W x 3 or H x W.
/// corruption_name: the name of a preset, see `presets`.
/// severity: 1 (mild) to 5 (severe); each preset defines which physical parameters this sets.
/// seed: 0 to 2**64 - 1, determines everything random.
///
/// Raises the same errors as `crack`.
///
/// >>> import numpy as np, starbreak
/// >>> image = np.full((375, 1242, 3), 128, np.uint8)
/// >>> starbreak.corrupt(image, "windshield-star", severity=3, seed=7).shape
/// (375, 1242, 3)
#[pyfunction]
#[pyo3(
    signature = (image, corruption_name = Given::of(starbreak::DEFAULT_PRESET.to_owned()), severity = Whole::of(1), *, seed = SeedArg::ZERO),
    text_signature = "(image, corruption_name='windshield-spiderweb', severity=1, *, seed=0)"
)]
pub(crate) fn corrupt<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    corruption_name: Given<String>,
    severity: Whole,
    seed: SeedArg,
) -> PyResult<Bound<'py, PyAny>> {
    let corruption_name = corruption_name.named("corruption_name")?;
    let recipe = Recipe::named(&corruption_name, Some(&severity))?;
    let sample_index = Whole::of(0);
    crack(
        py,
        image,
        Some(RecipeArg::of(recipe)),
        seed,
        None,
        None,
        sample_index,
        None,
        None,
        Given::of(false),
    )
}

/// The network that is to be shown, if one was given.
fn network_of(network: Option<Py<CrackNetwork>>) -> Option<CrackNetwork> {
    network.map(|network| network.get().clone())
}

fn ready(
    settings: &Settings,
    size: (u32, u32),
    seed: Seed,
    network: Option<&CrackNetwork>,
) -> Result<Chain, Error> {
    let simulated = match network {
        Some(network) => Simulated::from(&network.imported()),
        None => starbreak::simulate(settings, size, seed)?,
    };
    Chain::of_simulated(settings, simulated, size, seed, &mut Stopwatch::start())
}

/// A crack for any number of frames of one size, such as those of a video: simulated and baked
/// once, then applied to each frame under that frame's own light.
///
/// recipe, seed, network: as for `crack`.
/// size: width and height of the frames, px.
///
/// >>> import numpy as np, starbreak
/// >>> crack = starbreak.ReadyCrack("windshield-star", seed=7, size=(1242, 375))
/// >>> frames = [np.full((375, 1242, 3), code, np.uint8) for code in (60, 128)]
/// >>> bool((crack.over(frames[1], 7) == starbreak.crack(frames[1], "windshield-star", 7)).all())
/// True
///
/// A pickle holds what the crack was made from; the crack is made again when unpickled.
#[pyclass(frozen, module = "starbreak")]
#[derive(Debug)]
pub(crate) struct ReadyCrack {
    chain: Chain,
    origin: Origin,
}

/// What a crack was made from.
#[derive(Debug)]
pub(crate) enum Origin {
    Recipe {
        recipe: Recipe,
        seed: Seed,
        network: Option<CrackNetwork>,
    },
    Bank {
        bank: Py<PatternBank>,
        idx: usize,
    },
}

impl ReadyCrack {
    pub(crate) fn of(chain: Chain, origin: Origin) -> Self {
        Self { chain, origin }
    }

    fn fresh(
        py: Python<'_>,
        recipe: Recipe,
        seed: Seed,
        size: (u32, u32),
        network: Option<CrackNetwork>,
    ) -> PyResult<Self> {
        let settings = recipe.settings();
        let chain = py.detach(|| ready(&settings, size, seed, network.as_ref()));
        let origin = Origin::Recipe {
            recipe,
            seed,
            network,
        };
        Ok(Self::of(
            chain.map_err(|error| raised_in_memory(&error))?,
            origin,
        ))
    }

    /// The crack in an image: the array, or all that can be said of it.
    pub(crate) fn shown_in<'py>(
        &self,
        py: Python<'py>,
        mut pixels: DynamicImage,
        seed: Seed,
        boxes: Option<BoxesArg>,
        full: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        if !full && boxes.is_none() {
            let image = py.detach(|| {
                self.chain.over(&mut pixels, seed)?;
                Ok(pixels)
            });
            return array_of(py, image.map_err(|error: Error| raised_in_memory(&error))?);
        }
        let boxes = boxes.map(|boxes| boxes.0).unwrap_or_default();
        let made = py.detach(|| {
            let chain = &self.chain;
            let mut watch = Stopwatch::start();
            let shown = chain.over_and_report(&mut pixels, seed, &boxes, &mut watch)?;
            let crack = chain.crack_mask_of(&shown)?;
            Ok((pixels, shown, crack))
        });
        let (pixels, shown, crack_mask) = made.map_err(|error: Error| raised_in_memory(&error))?;
        let mut facts = self.chain.facts().clone();
        facts.insert("optics".to_owned(), shown.optics.to_json());
        facts.insert("region_fraction".to_owned(), json!(shown.region_fraction));
        let damage = shown.damage.iter();
        let damage = damage.map(|damage| damage.as_ref().map_or(Value::Null, damage_to_json));
        let network = self.chain.network().cloned().map(CrackNetwork::of);
        let cracked = Cracked {
            image: array_of(py, pixels)?.unbind(),
            region: mask_of(py, shown.region)?.into_any().unbind(),
            crack: mask_of(py, crack_mask)?.into_any().unbind(),
            network: network.map(|network| Py::new(py, network)).transpose()?,
            facts: python_of(py, &Value::Object(facts))?.unbind(),
            damage: python_of(py, &damage.collect())?.unbind(),
            intact: self.chain.is_intact(),
        };
        Ok(Bound::new(py, cracked)?.into_any())
    }
}

#[pymethods]
impl ReadyCrack {
    #[new]
    #[pyo3(
    signature = (recipe = None, seed = SeedArg::ZERO, size = SizeArg::DEFAULT, *, network = None),
    text_signature = "(recipe=None, seed=0, size=(1242, 375), *, network=None)"
)]
    fn new(
        py: Python<'_>,
        recipe: Option<RecipeArg>,
        seed: SeedArg,
        size: SizeArg,
        network: Option<Given<Py<CrackNetwork>>>,
    ) -> PyResult<Self> {
        let network = Given::if_given(network, "network")?;
        let recipe = RecipeArg::or_default(recipe)?;
        Self::fresh(py, recipe, seed.0, size.0, network_of(network))
    }

    /// Width and height of the frames, px.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.chain.size()
    }

    /// Whether the glass is intact.
    #[getter]
    fn intact(&self) -> bool {
        self.chain.is_intact()
    }

    /// The crack network; None for a pattern of a bank, whose network is `bank[index]`.
    #[getter]
    fn network(&self) -> Option<CrackNetwork> {
        self.chain.network().cloned().map(CrackNetwork::of)
    }

    /// What a provenance record says about the cracks: `network`, and `pattern` if it is from a
    /// bank.
    #[getter]
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &Value::Object(self.chain.facts().clone()))
    }

    /// The crack mask: uint8, H x W, coverage by cracks as if in focus, 255 is full coverage.
    fn crack_mask<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mask = py.detach(|| self.chain.crack_mask());
        Ok(mask_of(py, mask.map_err(|error| raised_in_memory(&error))?)?.into_any())
    }

    /// The image behind the crack: a new array, or a `Cracked` with `boxes` or `full`. The image
    /// must have the crack's size.
    ///
    /// The seed is that of the sensor noise, if the recipe has any; the cracks do not change.
    /// Raises the same errors as `crack`.
    #[pyo3(
    signature = (image, seed = SeedArg::ZERO, *, boxes = None, full = Given::of(false)),
    text_signature = "($self, image, seed=0, *, boxes=None, full=False)"
)]
    fn over<'py>(
        &self,
        py: Python<'py>,
        image: &Bound<'py, PyAny>,
        seed: SeedArg,
        boxes: Option<BoxesArg>,
        full: Given<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let full = full.named("full")?;
        self.shown_in(py, image_of(image)?, seed.0, boxes, full)
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.size();
        format!("<starbreak.ReadyCrack for {width} x {height} px>")
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        match &self.origin {
            Origin::Recipe {
                recipe,
                seed,
                network,
            } => {
                let words = PyDict::new(py);
                words.set_item("network", network.clone())?;
                let partial = py.import("functools")?.getattr("partial")?;
                let make = partial.call((py.get_type::<Self>(),), Some(&words))?;
                let from = (recipe.clone(), seed.0, self.size()).into_pyobject(py)?;
                Ok((make, from))
            }
            Origin::Bank { bank, idx } => {
                let make = bank.bind(py).getattr("pattern")?;
                Ok((make, (*idx, self.size()).into_pyobject(py)?))
            }
        }
    }
}

/// A cracked image with everything that is known about it. Returned by `crack` and similar
/// functions; the constructor is for unpickling.
#[pyclass(frozen, module = "starbreak", get_all)]
#[derive(Debug)]
pub(crate) struct Cracked {
    /// The image: uint8, of the shape of the input.
    image: Py<PyAny>,
    /// The region mask: uint8, H x W, 255 where pixels are affected, else 0.
    region: Py<PyAny>,
    /// The crack mask: uint8, H x W, coverage by cracks as if in focus, 255 is full coverage.
    crack: Py<PyAny>,
    /// The crack network; None for a pattern of a bank, whose network is `bank[index]`.
    network: Option<Py<CrackNetwork>>,
    /// What a provenance record says: `network`, `optics` (contrast, environment),
    /// `region_fraction`.
    facts: Py<PyAny>,
    /// The damage of each given box, None for a box without a pixel in the frame: `region_share` (0
    /// to 1), `displacement_px`, `blur_radius_px`, `contrast_lost` (None if the picture in the box
    /// is flat).
    damage: Py<PyAny>,
    /// Whether the glass is intact.
    intact: bool,
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
