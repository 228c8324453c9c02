//! The light around the camera: as Python has it, and followed from frame to frame.

use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;
use serde_json::Value;
use starbreak::environment_to_json;
use starbreak::optics::environment::{Environment, Rgb};
use starbreak_runs::clip::{ClipLight, Light};

use crate::arguments::{Real, entries, shown};
use crate::values::python_of;

/// Brightest light, 1 is white.
const MOST: f64 = 1e6;

/// A light as a record has it, or None.
pub(crate) fn python_light<'py>(
    py: Python<'py>,
    light: Option<&Environment>,
) -> PyResult<Bound<'py, PyAny>> {
    python_of(py, &light.map_or(Value::Null, environment_to_json))
}

/// A light from what `python_light` gives.
pub(crate) fn environment_of(given: &Bound<'_, PyAny>) -> PyResult<Environment> {
    let Ok(mapping) = given.cast::<PyMapping>() else {
        return Err(PyTypeError::new_err(format!(
            "environment = {}; expected a dict, such as estimate_environment gives, or None",
            shown(given)
        )));
    };
    let of = |key: &str| {
        mapping.get_item(key).map_err(|_| {
            PyValueError::new_err(format!(
                "environment has no {key:?}; expected sky_horizon, sky_zenith, ground, cabin and sun_irradiance, as \
                 estimate_environment gives them"
            ))
        })
    };
    let rgb = |key: &str| rgb_of(key, &of(key)?);
    let cabin = of("cabin")?;
    let ends: Option<Vec<Bound<'_, PyAny>>> = match entries(&cabin) {
        Some(ends) => Some(ends.take(3).collect::<PyResult<_>>()?),
        None => None,
    };
    let Some([low, high]) = ends.as_deref() else {
        return Err(PyValueError::new_err(format!(
            "cabin in environment = {}; expected two colors, straight down and straight up",
            shown(&cabin)
        )));
    };
    Ok(Environment {
        horizon_rgb: rgb("sky_horizon")?,
        zenith_rgb: rgb("sky_zenith")?,
        ground_rgb: rgb("ground")?,
        cabin_low_rgb: rgb_of("cabin", low)?,
        cabin_high_rgb: rgb_of("cabin", high)?,
        sun_rgb: rgb("sun_irradiance")?,
    })
}

fn rgb_of(key: &str, given: &Bound<'_, PyAny>) -> PyResult<Rgb> {
    let numbers: Option<PyResult<Vec<Real>>> =
        entries(given).map(|all| all.take(4).map(|one| one?.extract()).collect());
    let numbers: Vec<f64> = match numbers {
        Some(Ok(numbers)) => numbers.iter().map(|number| number.0).collect(),
        _ => Vec::new(),
    };
    match <[f64; 3]>::try_from(numbers) {
        Ok(rgb) if rgb.iter().all(|light| (0.0..=MOST).contains(light)) => {
            #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
            let rgb = rgb.map(|light| light as f32);
            Ok(rgb)
        }
        _ => Err(PyValueError::new_err(format!(
            "{key} in environment = {}; expected red, green and blue, each from 0 to 1000000 in linear light, 1 is white",
            shown(given)
        ))),
    }
}

/// Follows the light from frame to frame without flicker, as `starbreak video` does: the mean of about the last second,
/// held until it has visibly changed, and at once that of a new scene.
///
/// It knows nothing of later frames. Not for several threads: frames have an order.
///
/// >>> import numpy as np, starbreak
/// >>> crack = starbreak.ReadyCrack("windshield-star", seed=7, size=(320, 200))
/// >>> light = starbreak.LightFilter()
/// >>> for code in (128, 129, 128):
/// ...     frame = np.full((200, 320, 3), code, np.uint8)
/// ...     crack.set_environment(light.next(crack.estimate_environment(frame), 1 / 30))
/// ...     cracked = crack.over(frame, out=frame)
/// >>> light.n_lights
/// 1
#[pyclass(frozen, module = "starbreak")]
#[derive(Debug)]
pub(crate) struct LightFilter(Mutex<ClipLight>);

#[pymethods]
impl LightFilter {
    #[new]
    #[pyo3(signature = (), text_signature = "()")]
    fn new() -> Self {
        Self(Mutex::new(ClipLight::new(Light::Follow, 0.0)))
    }

    /// The light for a frame.
    ///
    /// environment: the frame's own, as `ReadyCrack.estimate_environment` gives it; None: it is not known.
    /// elapsed_s: time since the frame before, s.
    #[pyo3(
    signature = (environment, elapsed_s),
    text_signature = "($self, environment, elapsed_s)"
)]
    fn next<'py>(
        &self,
        py: Python<'py>,
        environment: Option<Bound<'py, PyAny>>,
        elapsed_s: Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let elapsed_given = || format!("elapsed_s = {}; expected 0 or more, s", shown(&elapsed_s));
        let elapsed: Real =
            (elapsed_s.extract()).map_err(|_| PyTypeError::new_err(elapsed_given()))?;
        if elapsed.0.is_nan() || elapsed.0 < 0.0 {
            return Err(PyValueError::new_err(elapsed_given()));
        }
        let own = environment
            .map(|given| environment_of(&given))
            .transpose()?;
        // Free before Python runs again: another thread may wait for it.
        let light = {
            let mut filter = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            filter.next_in(own, elapsed.0)
        };
        python_light(py, light.as_ref())
    }

    /// How many lights there were: each new one is computed once for all affected pixels.
    #[getter]
    fn n_lights(&self) -> u64 {
        let filter = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        filter.n_lights()
    }
}
