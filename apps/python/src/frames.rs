//! NumPy arrays as frames that are changed where they lie.

use std::sync::Arc;

use image::DynamicImage;
use numpy::ndarray::{ArrayView3, ArrayViewMut3, Axis, Ix2, Ix3};
use numpy::{
    BorrowError, PyArrayDyn, PyArrayMethods as _, PyReadonlyArrayDyn, PyReadwriteArrayDyn,
    PyUntypedArrayMethods as _,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use starbreak::optics::environment::Environment;
use starbreak::optics::{Channels, FrameMut};
use starbreak::{Chain, Error, Live, Seed};

use crate::arguments::{checked_size, shown};
use crate::errors::raised_in_memory;
use crate::images::{array_of_pillow, codes_of, image_of, refuse_masked, sides_of};

/// The order of the samples of a pixel, as it is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ChannelsArg(Channels);

impl<'a, 'py> FromPyObject<'a, 'py> for ChannelsArg {
    type Error = PyErr;

    fn extract(channels: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let said = || {
            let given = shown(&channels);
            format!("channels = {given}; expected \"rgb\", \"bgr\", \"rgba\", \"bgra\" or \"gray\"")
        };
        let Ok(name) = channels.extract::<String>() else {
            return Err(PyTypeError::new_err(said()));
        };
        let known = Channels::of_name(&name);
        known.map(Self).ok_or_else(|| PyValueError::new_err(said()))
    }
}

/// A chain over frames, with its memory, and that of a frame whose rows do not lie in one piece.
#[derive(Debug)]
pub(crate) struct Worker {
    pub(crate) live: Live,
    bytes: Vec<u8>,
}

impl Worker {
    /// Nothing is taken before the first frame.
    pub(crate) fn of(chain: Arc<Chain>) -> Self {
        Self {
            live: Live::of(chain),
            bytes: Vec::new(),
        }
    }
}

/// An image from an array whose samples have an order: a copy of it in red, green, blue.
pub(crate) fn image_in(
    image: &Bound<'_, PyAny>,
    channels: Option<ChannelsArg>,
) -> PyResult<DynamicImage> {
    let mut pixels = image_of(image)?;
    if let Some(ChannelsArg(channels)) = channels {
        let n = usize::from(pixels.color().channel_count());
        check_number(channels, n)?;
    }
    put_in_order(&mut pixels, channels);
    Ok(pixels)
}

/// The light that an array tells of, without a copy of it.
pub(crate) fn light_in(
    chain: &Chain,
    image: &Bound<'_, PyAny>,
    channels: Option<ChannelsArg>,
) -> PyResult<Option<Environment>> {
    let image = &array_of_pillow(image)?;
    let array = codes_of("image", image)?;
    refuse_masked("image", array.as_untyped())?;
    let (width, height) = sides_of("image", array, true)?;
    let size = checked_size(width, height)?;
    let channels = channels_of(array, channels)?;
    let array = array
        .try_readonly()
        .map_err(|error| refused("image", &error))?;
    let pixels = pixels_of(&array)?;
    let last = channels.n_colors() - 1;
    Ok(image.py().detach(|| {
        let codes = |x: u32, y: u32| {
            let code = |c: usize| pixels[[y as usize, x as usize, c]];
            match channels {
                Channels::Bgr | Channels::Bgra => [code(2), code(1), code(0)],
                _ => [code(0), code(last / 2), code(last)],
            }
        };
        chain.light_by(size, &codes)
    }))
}

/// The order of the samples of an array: what is asked for, which has to be of as many, or by their number.
fn channels_of(
    array: &Bound<'_, PyArrayDyn<u8>>,
    asked: Option<ChannelsArg>,
) -> PyResult<Channels> {
    let n = array.shape().get(2).copied().unwrap_or(1);
    match asked {
        Some(ChannelsArg(channels)) => check_number(channels, n).map(|()| channels),
        None if n == 1 => Ok(Channels::Gray),
        None if n == 3 => Ok(Channels::Rgb),
        None => Ok(Channels::Rgba),
    }
}

/// Exchanges red and blue where blue comes first, there and back.
pub(crate) fn put_in_order(pixels: &mut DynamicImage, channels: Option<ChannelsArg>) {
    match (pixels, channels) {
        (DynamicImage::ImageRgb8(pixels), Some(ChannelsArg(Channels::Bgr))) => {
            pixels.pixels_mut().for_each(|pixel| pixel.0.swap(0, 2));
        }
        (DynamicImage::ImageRgba8(pixels), Some(ChannelsArg(Channels::Bgra))) => {
            pixels.pixels_mut().for_each(|pixel| pixel.0.swap(0, 2));
        }
        _ => {}
    }
}

/// Refuses an order of other samples than an image has.
fn check_number(channels: Channels, n: usize) -> PyResult<()> {
    if channels.n_samples() == n {
        return Ok(());
    }
    let fitting = Channels::ALL.into_iter();
    let fitting = fitting.filter(|channels| channels.n_samples() == n);
    let fitting: Vec<String> = fitting.map(|it| format!("{:?}", it.name())).collect();
    Err(PyValueError::new_err(format!(
        "channels = {:?} is of {} samples per pixel, but image has {n}; expected {}",
        channels.name(),
        channels.n_samples(),
        fitting.join(" or "),
    )))
}

/// Puts a crack over an image, into an array of the same shape, which may be the image itself.
pub(crate) fn over_into(
    worker: &mut Worker,
    image: &Bound<'_, PyAny>,
    out: &Bound<'_, PyAny>,
    channels: Option<ChannelsArg>,
    seed: Seed,
) -> PyResult<()> {
    let py = image.py();
    let image = &array_of_pillow(image)?;
    let (from, to) = (codes_of("image", image)?, codes_of("out", out)?);
    refuse_masked("image", from.as_untyped())?;
    refuse_masked("out", to.as_untyped())?;
    let (width, height) = sides_of("image", from, true)?;
    let size = checked_size(width, height)?;
    if from.shape() != to.shape() {
        return Err(PyValueError::new_err(format!(
            "out has shape {}, image has {}; expected the same shape",
            out.getattr("shape")?.str()?,
            image.getattr("shape")?.str()?
        )));
    }
    let channels = channels_of(from, channels)?;
    let is_same = from.data() == to.data() && from.strides() == to.strides();
    if overlaps_itself(to) {
        return Err(PyValueError::new_err(
            "out has several pixels in one place of memory; give an array that has each once, such as numpy.empty_like(image)",
        ));
    }
    if !is_same && shares_memory(image, out)? {
        return Err(PyValueError::new_err(
            "image and out overlap in part; give two arrays that share no memory, or the same array twice",
        ));
    }
    let run = |worker: &mut Worker, from: Option<ArrayView3<'_, u8>>, to: &mut _| {
        let frame = (from, pixels_mut_of(to)?);
        let done = py.detach(|| over_pixels(worker, frame, (size, channels), seed));
        done.map_err(|error| raised_in_memory(&error))
    };
    if is_same {
        let mut to = to.try_readwrite().map_err(|error| refused("out", &error))?;
        return run(worker, None, &mut to);
    }
    let image = from
        .try_readonly()
        .map_err(|error| refused("image", &error))?;
    match to.try_readwrite() {
        Ok(mut to) => run(worker, Some(pixels_of(&image)?), &mut to),
        Err(error @ BorrowError::NotWriteable) => Err(refused("out", &error)),
        // Of two arrays that lie within each other, as columns of one, NumPy knows that they share nothing, but what
        // watches over borrows does not: the image is read before the other is written.
        Err(_) => {
            let pixels = pixels_of(&image)?;
            let mut kept = std::mem::take(&mut worker.bytes);
            kept.resize(pixels.len(), 0);
            let shape = pixels.raw_dim();
            if let Ok(mut kept) = ArrayViewMut3::from_shape(shape, &mut kept) {
                kept.assign(&pixels);
            }
            drop(image);
            let mut to = to.try_readwrite().map_err(|error| refused("out", &error))?;
            let done = run(worker, ArrayView3::from_shape(shape, &kept).ok(), &mut to);
            worker.bytes = kept;
            done
        }
    }
}

/// Whether two pixels of an array may have the same place: its strides, from the least, do not step over what lies within.
fn overlaps_itself(array: &Bound<'_, PyArrayDyn<u8>>) -> bool {
    let axes = array.shape().iter().zip(array.strides());
    let mut axes: Vec<(usize, usize)> = axes
        .filter(|(n, _)| **n > 1)
        .map(|(n, stride)| (stride.unsigned_abs(), *n))
        .collect();
    axes.sort_unstable();
    let mut reach = 0;
    axes.into_iter().any(|(stride, n)| {
        let is_within = stride <= reach;
        reach += stride * (n - 1);
        is_within
    })
}

fn shares_memory(image: &Bound<'_, PyAny>, out: &Bound<'_, PyAny>) -> PyResult<bool> {
    let numpy = image.py().import("numpy")?;
    // Ends that do not meet are the rule, and soon told.
    if !numpy
        .call_method1("may_share_memory", (image, out))?
        .is_truthy()?
    {
        return Ok(false);
    }
    numpy
        .call_method1("shares_memory", (image, out))?
        .is_truthy()
}

fn refused(name: &str, error: &BorrowError) -> PyErr {
    PyValueError::new_err(match error {
        BorrowError::NotWriteable => {
            format!(
                "{name} is read-only; expected a writable array, such as numpy.empty_like(image)"
            )
        }
        _ => format!("{name} is in use by another call; give each call an array of its own"),
    })
}

/// The samples of an array as rows, columns and channels.
fn pixels_of<'a>(array: &'a PyReadonlyArrayDyn<'_, u8>) -> PyResult<ArrayView3<'a, u8>> {
    let view = array.as_array();
    match view.ndim() {
        2 => (view.into_dimensionality::<Ix2>()).map(|view| view.insert_axis(Axis(2))),
        _ => view.into_dimensionality::<Ix3>(),
    }
    .map_err(|cause| PyValueError::new_err(cause.to_string()))
}

fn pixels_mut_of<'a>(
    array: &'a mut PyReadwriteArrayDyn<'_, u8>,
) -> PyResult<ArrayViewMut3<'a, u8>> {
    let view = array.as_array_mut();
    match view.ndim() {
        2 => (view.into_dimensionality::<Ix2>()).map(|view| view.insert_axis(Axis(2))),
        _ => view.into_dimensionality::<Ix3>(),
    }
    .map_err(|cause| PyValueError::new_err(cause.to_string()))
}

/// An image, if it is another array, and where it is to be written.
type Pixels<'a> = (Option<ArrayView3<'a, u8>>, ArrayViewMut3<'a, u8>);

fn over_pixels(
    worker: &mut Worker,
    (from, mut to): Pixels<'_>,
    (size, mut channels): ((u32, u32), Channels),
    seed: Seed,
) -> Result<(), Error> {
    // Before anything is written.
    worker.live.check_size(size)?;
    // Colors in the other order, as `bgr[..., ::-1]` has them.
    let is_turned = to.strides()[2] == -1 && channels.n_samples() == 3;
    let has_rows = {
        let mut row = to.index_axis(Axis(0), 0);
        if is_turned {
            row.invert_axis(Axis(1));
        }
        row.is_standard_layout()
    };
    if !has_rows {
        let shape = to.raw_dim();
        worker.bytes.resize(shape[0] * shape[1] * shape[2], 0);
        if let Ok(mut kept) = ArrayViewMut3::from_shape(shape, &mut worker.bytes) {
            match from {
                Some(from) => kept.assign(&from),
                None => kept.assign(&to),
            }
        }
        let mut frame = FrameMut::of_bytes(&mut worker.bytes, size, channels)?;
        worker.live.over(&mut frame, seed)?;
        if let Ok(kept) = ArrayView3::from_shape(shape, &worker.bytes) {
            to.assign(&kept);
        }
        return Ok(());
    }
    if let Some(from) = from {
        for (mut to, from) in to.outer_iter_mut().zip(from.outer_iter()) {
            match (to.as_slice_mut(), from.as_slice()) {
                (Some(to), Some(from)) => to.copy_from_slice(from),
                _ => to.assign(&from),
            }
        }
    }
    if is_turned {
        to.invert_axis(Axis(2));
        channels = match channels {
            Channels::Rgb => Channels::Bgr,
            _ => Channels::Rgb,
        };
    }
    let rows = to.axis_iter_mut(Axis(0));
    let rows = rows.filter_map(|row| row.into_slice()).collect();
    let mut frame = FrameMut::of_rows(rows, size.0, channels)?;
    worker.live.over(&mut frame, seed)
}
