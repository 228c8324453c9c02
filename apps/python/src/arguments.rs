//! Arguments that Python has no type of its own for: whole numbers, seeds, sizes, boxes, names.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyMapping, PyString};
use starbreak::Seed;
use starbreak_runs::dataset::ImageLimits;

/// Longest value that a message writes out, characters.
const MAX_SHOWN_CHARS: usize = 60;

/// A value as a message shows it: written out where that is short, and its type.
pub(crate) fn shown(value: &Bound<'_, PyAny>) -> String {
    let kind = value.get_type().name();
    let kind = kind.map_or_else(|_| "?".to_owned(), |kind| kind.to_string());
    let text = value.repr().map(|text| text.to_string());
    match text {
        Ok(text) if value.is_none() => text,
        Ok(text) if text.chars().count() <= MAX_SHOWN_CHARS && !text.contains('\n') => {
            format!("{text} ({kind})")
        }
        _ => format!("something of type {kind}"),
    }
}

/// A kind of argument, as a message names it.
pub(crate) trait Kind {
    const EXPECTED: &'static str;
}

impl Kind for bool {
    const EXPECTED: &'static str = "True or False";
}

impl Kind for String {
    const EXPECTED: &'static str = "text";
}

impl Kind for PathBuf {
    const EXPECTED: &'static str = "text or a path";
}

impl Kind for OsString {
    const EXPECTED: &'static str = "text or a path";
}

impl Kind for Real {
    const EXPECTED: &'static str = "a number";
}

impl Kind for List<Real> {
    const EXPECTED: &'static str = "a list of numbers";
}

impl Kind for List<Whole> {
    const EXPECTED: &'static str = "a list of whole numbers";
}

impl Kind for BTreeMap<String, [Real; 2]> {
    const EXPECTED: &'static str =
        "a dict of names to least and most, such as {\"small\": (0, 1024)}";
}

impl Kind for Py<PyMapping> {
    const EXPECTED: &'static str = "a dict of tables";
}

/// An argument of a kind, or what was given instead: that is said once the argument has a name.
#[derive(Debug)]
pub(crate) struct Given<T>(Result<T, Refused>);

/// What was given instead, and whether it was of another type.
#[derive(Debug)]
struct Refused {
    given: String,
    is_type: bool,
}

impl<T> Given<T> {
    /// What is taken where none is given.
    pub(crate) const fn of(value: T) -> Self {
        Self(Ok(value))
    }
}

impl<T: Kind> Given<T> {
    /// The value; `TypeError` or `ValueError` with the name of the argument.
    pub(crate) fn named(self, name: &str) -> PyResult<T> {
        self.0.map_err(|refused| {
            let said = format!("{name} = {}; expected {}", refused.given, T::EXPECTED);
            match refused.is_type {
                true => PyTypeError::new_err(said),
                false => PyValueError::new_err(said),
            }
        })
    }

    /// The value of an argument that may be left out.
    pub(crate) fn if_given(given: Option<Self>, name: &str) -> PyResult<Option<T>> {
        given.map(|given| given.named(name)).transpose()
    }
}

impl<'a, 'py, T: FromPyObjectOwned<'py>> FromPyObject<'a, 'py> for Given<T> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let py = given.py();
        Ok(Self(given.extract::<T>().map_err(|error| Refused {
            given: shown(&given),
            is_type: error.into().is_instance_of::<PyTypeError>(py),
        })))
    }
}

/// The entries of a sequence, such as a list, a tuple or an array: of what has a length and places;
/// a set has no places, an iterator no length. No more than its length says, for places may go on
/// for ever.
pub(crate) fn entries<'py>(
    given: &Bound<'py, PyAny>,
) -> Option<impl Iterator<Item = PyResult<Bound<'py, PyAny>>> + use<'py>> {
    let n = given.len().ok()?;
    let is_sequence =
        given.hasattr("__getitem__").unwrap_or(false) && given.cast::<PyMapping>().is_err();
    let all = given.try_iter().ok().filter(|_| is_sequence)?;
    Some(all.take(n))
}

/// Most entries of a list of settings.
const MAX_ENTRIES: usize = 10_000;

/// A sequence of a kind of argument. What it says of its length is not believed: no memory is taken
/// for entries before they have come.
#[derive(Debug)]
pub(crate) struct List<T>(pub(crate) Vec<T>);

impl<'a, 'py, T: FromPyObjectOwned<'py>> FromPyObject<'a, 'py> for List<T> {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let all = entries(&given).filter(|_| given.cast::<PyString>().is_err());
        let Some(all) = all else {
            return Err(PyTypeError::new_err("no sequence"));
        };
        let mut list = Vec::new();
        for entry in all {
            if list.len() == MAX_ENTRIES {
                return Err(PyValueError::new_err("too many entries"));
            }
            list.push(entry?.extract().map_err(Into::into)?);
        }
        Ok(Self(list))
    }
}

/// The bytes of a file: `bytes`, or anything with a buffer, of which it is a copy.
#[derive(Debug)]
pub(crate) struct BytesArg(pub(crate) Py<PyBytes>);

impl<'a, 'py> FromPyObject<'a, 'py> for BytesArg {
    type Error = PyErr;

    fn extract(data: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(bytes) = data.cast::<PyBytes>() {
            return Ok(Self(bytes.to_owned().unbind()));
        }
        let view = data.py().import("builtins")?.getattr("memoryview")?;
        let Ok(view) = view.call1((data,)) else {
            let said = format!("data = {}; expected the bytes of a file", shown(&data));
            return Err(PyTypeError::new_err(said));
        };
        let copy = view.call_method0("tobytes")?;
        Ok(Self(copy.cast_into::<PyBytes>()?.unbind()))
    }
}

/// A whole number as an argument: an `int`, one of NumPy, anything with `__index__`; no `bool`.
/// Whether it is one, and in its range, is said with the name of the argument.
#[derive(Debug)]
pub(crate) struct Whole {
    /// None for what is no whole number; the ends of the type stand for all beyond.
    value: Option<i128>,
    given: String,
}

impl Whole {
    /// What is taken where none is given.
    pub(crate) fn of(value: u32) -> Self {
        Self {
            value: Some(value.into()),
            given: value.to_string(),
        }
    }

    /// As a message shows it.
    pub(crate) fn given(&self) -> &str {
        &self.given
    }

    /// The number, of any size: the ends of the type stand for all beyond.
    pub(crate) fn clamped(&self, name: &str) -> PyResult<i128> {
        self.value.ok_or_else(|| {
            PyTypeError::new_err(format!("{name} = {}; expected a whole number", self.given))
        })
    }

    /// The number, in a range; `TypeError` for what is no whole number, `ValueError` outside.
    pub(crate) fn within<T>(&self, name: &str, range: RangeInclusive<T>) -> PyResult<T>
    where
        T: TryFrom<i128> + PartialOrd + Display,
    {
        let (least, most) = (range.start(), range.end());
        let said = format!(
            "{name} = {}; expected a whole number from {least} to {most}",
            self.given
        );
        let Some(value) = self.value else {
            return Err(PyTypeError::new_err(said));
        };
        let value = T::try_from(value).ok();
        value
            .filter(|value| range.contains(value))
            .ok_or_else(|| PyValueError::new_err(said))
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Whole {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        // NumPy's own are those, too.
        if given.extract::<bool>().is_ok() {
            let given = shown(&given);
            return Ok(Self { value: None, given });
        }
        let value = match given.extract::<i64>() {
            Ok(value) => Some(value.into()),
            Err(error) if error.is_instance_of::<PyOverflowError>(given.py()) => {
                match given.extract::<u64>() {
                    Ok(value) => Some(value.into()),
                    Err(_) if given.lt(0)? => Some(i128::MIN),
                    Err(_) => Some(i128::MAX),
                }
            }
            Err(_) => None,
        };
        let given = match value {
            Some(value) if value != i128::MIN && value != i128::MAX => value.to_string(),
            _ => shown(&given),
        };
        Ok(Self { value, given })
    }
}

/// A number as an argument, no `bool` and no complex number; one that is too large for a float is
/// infinite.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Real(pub(crate) f64);

impl<'a, 'py> FromPyObject<'a, 'py> for Real {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if given.extract::<bool>().is_ok() || is_complex(&given)? {
            return Err(PyTypeError::new_err("no number"));
        }
        match given.extract() {
            Ok(value) => Ok(Self(value)),
            Err(error) if error.is_instance_of::<PyOverflowError>(given.py()) => {
                Ok(Self(match given.lt(0)? {
                    true => f64::NEG_INFINITY,
                    false => f64::INFINITY,
                }))
            }
            Err(error) => Err(error),
        }
    }
}

/// Whether it is a complex number, of NumPy's, too, which would be taken for its real part.
fn is_complex(given: &Bound<'_, PyAny>) -> PyResult<bool> {
    let numbers = given.py().import("numbers")?;
    Ok(given.is_instance(&numbers.getattr("Complex")?)?
        && !given.is_instance(&numbers.getattr("Real")?)?)
}

/// A seed, from anything that is a whole number to Python.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeedArg(pub(crate) Seed);

impl SeedArg {
    /// What is taken where none is given.
    pub(crate) const ZERO: Self = Self(Seed(0));
}

impl<'a, 'py> FromPyObject<'a, 'py> for SeedArg {
    type Error = PyErr;

    fn extract(seed: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let seed: Whole = seed.extract()?;
        Ok(Self(Seed(seed.within("seed", 0..=u64::MAX)?)))
    }
}

/// The name of an image in its set, from text or a path; of a path with slashes.
#[derive(Debug)]
pub(crate) struct NameArg(pub(crate) String);

impl<'a, 'py> FromPyObject<'a, 'py> for NameArg {
    type Error = PyErr;

    fn extract(name: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(text) = name.cast::<PyString>() {
            return Ok(Self(text.to_str()?.to_owned()));
        }
        let path = name.py().import("os")?.call_method1("fspath", (name,));
        match path.map(|path| path.extract::<String>()) {
            Ok(Ok(path)) => Ok(Self(path.replace(std::path::MAIN_SEPARATOR, "/"))),
            _ => Err(PyTypeError::new_err(format!(
                "name = {}; expected text or a path, such as \"photo.png\"",
                shown(&name)
            ))),
        }
    }
}

/// The seed of an item: of its name and number where it has a name, as the command has it, else
/// the seed itself.
pub(crate) fn seed_of(
    seed: SeedArg,
    name: Option<&NameArg>,
    sample_index: &Whole,
) -> PyResult<Seed> {
    let sample_index = sample_index.within("sample_index", 0..=u64::MAX)?;
    Ok(match name {
        Some(name) => seed.0.of_item(&name.0, sample_index),
        None => seed.0,
    })
}

/// Width and height of a frame, px, from any sequence of two whole numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SizeArg(pub(crate) (u32, u32));

impl SizeArg {
    /// The frame that the command simulates for.
    pub(crate) const DEFAULT: Self = Self((1242, 375));
}

impl<'a, 'py> FromPyObject<'a, 'py> for SizeArg {
    type Error = PyErr;

    fn extract(size: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let said = || format!("size = {}; expected width and height in px", shown(&size));
        let Some(sides) = entries(&size) else {
            return Err(PyTypeError::new_err(said()));
        };
        let sides: Vec<Whole> = sides
            .take(3)
            .map(|side| side?.extract())
            .collect::<PyResult<_>>()?;
        let [width, height] = sides.as_slice() else {
            return Err(PyValueError::new_err(said()));
        };
        let most = ImageLimits::default().max_side_px;
        let width = width.within("width in size", 1..=most)?;
        let height = height.within("height in size", 1..=most)?;
        checked_size(width, height).map(Self)
    }
}

/// A size of a frame that can be worked with, the same as that of an image file.
pub(crate) fn checked_size<N>(width: N, height: N) -> PyResult<(u32, u32)>
where
    N: TryInto<u32> + Display + Copy,
{
    let limits = ImageLimits::default();
    let side = |n: N| {
        let n = n.try_into().ok()?;
        (1..=limits.max_side_px).contains(&n).then_some(n)
    };
    match (side(width), side(height)) {
        (Some(width), Some(height))
            if u64::from(width) * u64::from(height) <= limits.max_pixels =>
        {
            Ok((width, height))
        }
        _ => Err(PyValueError::new_err(format!(
            "the frame is {width} x {height} px; expected 1 to {} px per side and at most {} px in all",
            limits.max_side_px, limits.max_pixels
        ))),
    }
}

/// Boxes in an image whose damage is measured: x0, y0, x1, y1 in px.
#[derive(Debug)]
pub(crate) struct BoxesArg(pub(crate) Vec<[f64; 4]>);

impl<'a, 'py> FromPyObject<'a, 'py> for BoxesArg {
    type Error = PyErr;

    fn extract(boxes: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let Some(all) = entries(&boxes) else {
            return Err(PyTypeError::new_err(format!(
                "boxes = {}; expected a list of boxes, each x0, y0, x1, y1 in px",
                shown(&boxes)
            )));
        };
        let all = all.enumerate().map(|(idx, one)| box_of(idx, &one?));
        Ok(Self(all.collect::<PyResult<_>>()?))
    }
}

fn box_of(idx: usize, given: &Bound<'_, PyAny>) -> PyResult<[f64; 4]> {
    let expected = "expected x0, y0, x1, y1 in px";
    let numbers: Option<PyResult<Vec<Real>>> =
        entries(given).map(|all| all.take(5).map(|one| one?.extract()).collect());
    let Some(Ok(numbers)) = numbers else {
        let said = format!("boxes[{idx}] = {}; {expected}", shown(given));
        return Err(PyTypeError::new_err(said));
    };
    let ends: Vec<f64> = numbers.iter().map(|number| number.0).collect();
    match <[f64; 4]>::try_from(ends.as_slice()) {
        Ok(ends) if is_box(ends) => Ok(ends),
        _ => {
            let ends: Vec<String> = ends
                .iter()
                .map(|end| end.to_string().to_lowercase())
                .collect();
            Err(PyValueError::new_err(format!(
                "boxes[{idx}] = [{}]; {expected}, finite, with x0 <= x1 and y0 <= y1",
                ends.join(", ")
            )))
        }
    }
}

fn is_box(ends: [f64; 4]) -> bool {
    let [x0, y0, x1, y1] = ends;
    ends.iter().all(|end| end.is_finite()) && x0 <= x1 && y0 <= y1
}
