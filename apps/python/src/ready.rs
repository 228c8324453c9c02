//! A crack that is ready for many frames.

use std::sync::{Arc, Mutex, PoisonError};

use image::DynamicImage;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use serde_json::{Value, json};
use starbreak::optics::environment::Environment;
use starbreak::{
    Chain, Error, OpticsSettings, Seed, Settings, Simulated, Stopwatch, damage_to_json,
};

use crate::arguments::{BoxesArg, Given, SeedArg, SizeArg};
use crate::bank::PatternBank;
use crate::cracked::Cracked;
use crate::errors::raised_in_memory;
use crate::frames::{ChannelsArg, Worker, image_in, light_in, over_into, put_in_order};
use crate::images::{array_of, mask_of};
use crate::light::{environment_of, python_light};
use crate::network::CrackNetwork;
use crate::recipe::{Recipe, RecipeArg};
use crate::values::python_of;

/// The network that is to be shown, if one was given.
pub(crate) fn network_of(network: Option<Py<CrackNetwork>>) -> Option<CrackNetwork> {
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
/// Any number of threads may use it at the same time. A pickle holds what the crack was made from; the crack is made
/// again when unpickled, and its frames are under their own light again.
#[pyclass(frozen, module = "starbreak")]
#[derive(Debug)]
pub(crate) struct ReadyCrack {
    chain: Arc<Chain>,
    origin: Origin,
    /// The light that all frames are under, if one was set.
    environment: Mutex<Option<Environment>>,
    /// Memory that is used again from frame to frame, for each thread that is at work.
    idle: Mutex<Vec<Worker>>,
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
        Self {
            chain: Arc::new(chain),
            origin,
            environment: Mutex::new(None),
            idle: Mutex::new(Vec::new()),
        }
    }

    fn light(&self) -> Option<Environment> {
        *self
            .environment
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Lends memory that an earlier frame has used, with the light that is set.
    fn with_worker<T>(&self, work: impl FnOnce(&mut Worker) -> T) -> T {
        let idle = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let known = idle().pop();
        let mut worker = known.unwrap_or_else(|| Worker::of(Arc::clone(&self.chain)));
        worker.live.set_environment(self.light());
        let done = work(&mut worker);
        idle().push(worker);
        done
    }

    pub(crate) fn fresh(
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

    /// The crack in an image: the array, with its colors in an order that was asked for, or all that can be said of it.
    pub(crate) fn shown_in<'py>(
        &self,
        py: Python<'py>,
        mut pixels: DynamicImage,
        channels: Option<ChannelsArg>,
        seed: Seed,
        boxes: Option<BoxesArg>,
        full: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        if !full && boxes.is_none() {
            let image = py.detach(|| {
                match self.light() {
                    Some(light) => self.chain.under(Some(&light))?.over(&mut pixels, seed)?,
                    None => self.chain.over(&mut pixels, seed)?,
                }
                put_in_order(&mut pixels, channels);
                Ok(pixels)
            });
            return array_of(py, image.map_err(|error: Error| raised_in_memory(&error))?);
        }
        let boxes = boxes.map(|boxes| boxes.0).unwrap_or_default();
        let made = py.detach(|| {
            let chain = &self.chain;
            let mut watch = Stopwatch::start();
            let light = self.light().or_else(|| chain.light_of(&pixels));
            let shown =
                chain.over_and_report_under(light, &mut pixels, seed, &boxes, &mut watch)?;
            let crack = chain.crack_mask_of(&shown)?;
            put_in_order(&mut pixels, channels);
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

    /// The image behind the crack: a new array, `out`, or a `Cracked` with `boxes` or `full`. The image
    /// must have the crack's size.
    ///
    /// image: as for `crack`.
    /// seed: that of the sensor noise, if the recipe has any; the cracks do not change.
    /// out: where the image is to be written: a writable array of the same shape, any strides, or `image`
    /// itself, which is then changed where it lies. It must not overlap `image` in part. No frame is
    /// allocated, unless the recipe has coats, camera faults, a blurred scene, glare or the paper's optics.
    /// channels: "rgb", "bgr", "rgba", "bgra" or "gray", the order of the samples in `image` and `out`;
    /// default: by their number gray, rgb or rgba. Alpha stays as it is, or is moved by a distortion.
    ///
    /// Any number of threads may call it, each with its own `out`; the interpreter's lock is released.
    /// Raises the same errors as `crack`.
    ///
    /// >>> import numpy as np, starbreak
    /// >>> crack = starbreak.ReadyCrack("windshield-star", seed=7, size=(320, 200))
    /// >>> frame = np.full((200, 320, 4), 128, np.uint8)
    /// >>> crack.over(frame, out=frame, channels="bgra") is frame
    /// True
    #[pyo3(
    signature = (image, seed = SeedArg::ZERO, *, out = None, channels = None, boxes = None, full = Given::of(false)),
    text_signature = "($self, image, seed=0, *, out=None, channels=None, boxes=None, full=False)"
)]
    #[expect(
        clippy::too_many_arguments,
        reason = "they have names and defaults in Python"
    )]
    fn over<'py>(
        &self,
        py: Python<'py>,
        image: &Bound<'py, PyAny>,
        seed: SeedArg,
        out: Option<Bound<'py, PyAny>>,
        channels: Option<ChannelsArg>,
        boxes: Option<BoxesArg>,
        full: Given<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let full = full.named("full")?;
        let Some(out) = out else {
            let pixels = image_in(image, channels)?;
            return self.shown_in(py, pixels, channels, seed.0, boxes, full);
        };
        if full || boxes.is_some() {
            return Err(PyValueError::new_err(
                "out takes the image alone, and a Cracked has arrays of its own; leave out, or boxes and full, away",
            ));
        }
        self.with_worker(|worker| over_into(worker, image, &out, channels, seed.0))?;
        Ok(out)
    }

    /// The light around the camera as an image tells it, which `over` puts it under: linear light, 1 is
    /// white, by the keys of a record's `optics.environment`; None with the paper's optics, which know none.
    ///
    /// image, channels: as for `over`.
    #[pyo3(
    signature = (image, *, channels = None),
    text_signature = "($self, image, *, channels=None)"
)]
    fn estimate_environment<'py>(
        &self,
        py: Python<'py>,
        image: &Bound<'py, PyAny>,
        channels: Option<ChannelsArg>,
    ) -> PyResult<Bound<'py, PyAny>> {
        python_light(py, light_in(&self.chain, image, channels)?.as_ref())
    }

    /// Puts all further frames under one light, so that it cannot flicker and is computed once; None: each
    /// frame under its own again.
    ///
    /// environment: a dict of `sky_horizon`, `sky_zenith`, `ground`, `sun_irradiance` (each three numbers
    /// from 0 to 1e6) and `cabin` (two of these: straight down, straight up), as `estimate_environment`
    /// and records give it.
    ///
    /// >>> import numpy as np, starbreak
    /// >>> crack = starbreak.ReadyCrack("windshield-star", seed=7, size=(320, 200))
    /// >>> first = np.full((200, 320, 3), 128, np.uint8)
    /// >>> crack.set_environment(crack.estimate_environment(first))
    /// >>> sorted(crack.environment)
    /// ['cabin', 'ground', 'sky_horizon', 'sky_zenith', 'sun_irradiance']
    #[pyo3(
    signature = (environment = None),
    text_signature = "($self, environment=None)"
)]
    fn set_environment(&self, environment: Option<Bound<'_, PyAny>>) -> PyResult<()> {
        let light = environment
            .map(|given| environment_of(&given))
            .transpose()?;
        if light.is_some() && matches!(self.chain.settings().optics, OpticsSettings::Paper(_)) {
            return Err(PyValueError::new_err(
                "the paper's optics know no light; leave the environment away, or set optics.model to \"physical\"",
            ));
        }
        *self
            .environment
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = light;
        Ok(())
    }

    /// The light that all frames are under, if one was set.
    #[getter]
    fn environment<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_light(py, self.light().as_ref())
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
