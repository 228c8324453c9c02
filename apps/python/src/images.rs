//! NumPy arrays to images and back.

use image::{DynamicImage, GrayImage, RgbImage, RgbaImage};
use numpy::ndarray::{Array2, Array3, ArrayViewMut};
use numpy::{
    IntoPyArray as _, PyArray2, PyArrayDyn, PyArrayMethods as _, PyUntypedArray,
    PyUntypedArrayMethods as _,
};
use pyo3::exceptions::{PyMemoryError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::arguments::checked_size;
use crate::values::python_of;

/// An image from an array: a copy of it, which becomes the output.
pub(crate) fn image_of(image: &Bound<'_, PyAny>) -> PyResult<DynamicImage> {
    let image = &array_of_pillow(image)?;
    let bytes = codes_of("image", image)?;
    refuse_masked("image", bytes.as_untyped())?;
    let (width, height) = sides_of("image", bytes, true)?;
    let (width_px, height_px) = checked_size(width, height)?;
    let pixels = copied(bytes)?;
    let image = match bytes.ndim() {
        2 => GrayImage::from_raw(width_px, height_px, pixels).map(DynamicImage::ImageLuma8),
        _ if bytes.shape().last() == Some(&4) => {
            RgbaImage::from_raw(width_px, height_px, pixels).map(DynamicImage::ImageRgba8)
        }
        _ => RgbImage::from_raw(width_px, height_px, pixels).map(DynamicImage::ImageRgb8),
    };
    image.ok_or_else(|| PyValueError::new_err("image changed its shape while it was read"))
}

/// The array of an image of Pillow whose numbers are colors; anything else as it is.
pub(crate) fn array_of_pillow<'py>(image: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let is_array = image.cast::<PyUntypedArray>().is_ok();
    let mode = image
        .getattr("mode")
        .and_then(|mode| mode.extract::<String>());
    let (Ok(mode), false) = (mode, is_array) else {
        return Ok(image.clone());
    };
    if !["L", "RGB", "RGBA"].contains(&mode.as_str()) {
        return Err(PyValueError::new_err(format!(
            "image has mode {mode:?}; expected RGB, RGBA or L, such as image.convert(\"RGB\")"
        )));
    }
    image
        .py()
        .import("numpy")?
        .call_method1("asarray", (image,))
}

/// Width and height of an array that is an image or, without channels, a mask, px.
pub(crate) fn size_of(
    name: &str,
    array: &Bound<'_, PyAny>,
    has_channels: bool,
) -> PyResult<(usize, usize)> {
    sides_of(name, codes_of(name, array)?, has_channels)
}

/// The argument as an array of codes.
pub(crate) fn codes_of<'a, 'py>(
    name: &str,
    array: &'a Bound<'py, PyAny>,
) -> PyResult<&'a Bound<'py, PyArrayDyn<u8>>> {
    let Ok(untyped) = array.cast::<PyUntypedArray>() else {
        let kind = array.get_type().name()?;
        return Err(PyTypeError::new_err(format!(
            "{name} is of type {kind}; expected a numpy.ndarray of uint8, H x W x 3, H x W x 4 or H x W, such as numpy.asarray({name})"
        )));
    };
    array.cast::<PyArrayDyn<u8>>().map_err(|_| {
        PyValueError::new_err(format!(
            "{name} has dtype {}; expected uint8, codes from 0 to 255",
            untyped.dtype()
        ))
    })
}

pub(crate) fn sides_of(
    name: &str,
    array: &Bound<'_, PyArrayDyn<u8>>,
    has_channels: bool,
) -> PyResult<(usize, usize)> {
    match *array.shape() {
        [height, width] => Ok((width, height)),
        [height, width, 3 | 4] if has_channels => Ok((width, height)),
        _ => Err(PyValueError::new_err(format!(
            "{name} has shape {}; expected {}(height, width)",
            array.getattr("shape")?.str()?,
            if has_channels {
                "(height, width, 3), (height, width, 4) or "
            } else {
                ""
            }
        ))),
    }
}

/// Refuses an array of `numpy.ma` with masked entries, whose codes mean nothing.
pub(crate) fn refuse_masked(name: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<()> {
    let py = array.py();
    if array.get_type().is(py.get_type::<PyUntypedArray>()) {
        return Ok(());
    }
    let is_masked = py.import("numpy.ma")?.call_method1("is_masked", (array,))?;
    match is_masked.is_truthy()? {
        true => Err(PyValueError::new_err(format!(
            "{name} has masked entries, which have no code; fill them first, as with {name}.filled(0)"
        ))),
        false => Ok(()),
    }
}

/// The bytes of an array in C order, whatever its own order and strides are.
fn copied(array: &Bound<'_, PyArrayDyn<u8>>) -> PyResult<Vec<u8>> {
    let array = array.try_readonly()?;
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(array.len())
        .map_err(|cause| PyMemoryError::new_err(cause.to_string()))?;
    // In Fortran order the slice has the bytes in another order.
    if let (true, Ok(contiguous)) = (array.is_c_contiguous(), array.as_slice()) {
        bytes.extend_from_slice(contiguous);
    } else {
        bytes.resize(array.len(), 0);
        let view = array.as_array();
        ArrayViewMut::from_shape(view.raw_dim(), &mut bytes)
            .map_err(|cause| PyValueError::new_err(cause.to_string()))?
            .assign(&view);
    }
    Ok(bytes)
}

/// An array of the pixels, whose buffer it takes over.
pub(crate) fn array_of(py: Python<'_>, image: DynamicImage) -> PyResult<Bound<'_, PyAny>> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    match image {
        DynamicImage::ImageLuma8(gray) => Ok(mask_of(py, gray)?.into_any()),
        DynamicImage::ImageRgb8(rgb) => {
            let array = Array3::from_shape_vec((height, width, 3), rgb.into_raw());
            Ok(array.map_err(wrong_shape)?.into_pyarray(py).into_any())
        }
        DynamicImage::ImageRgba8(rgba) => {
            let array = Array3::from_shape_vec((height, width, 4), rgba.into_raw());
            Ok(array.map_err(wrong_shape)?.into_pyarray(py).into_any())
        }
        _ => Err(PyValueError::new_err("the image came out in another mode")),
    }
}

/// An array of a mask, H x W.
pub(crate) fn mask_of(py: Python<'_>, mask: GrayImage) -> PyResult<Bound<'_, PyArray2<u8>>> {
    let (width, height) = (mask.width() as usize, mask.height() as usize);
    let array = Array2::from_shape_vec((height, width), mask.into_raw());
    Ok(array.map_err(wrong_shape)?.into_pyarray(py))
}

/// A picture of a street for a first look without a photo: the image (uint8,
/// 375 x 1242 x 3) and the objects in it, as `{"category": name, "box_px": [x0, y0, x1, y1]}`.
///
/// >>> import starbreak
/// >>> image, objects = starbreak.street_scene()
/// >>> image.shape, "Pedestrian" in {thing["category"] for thing in objects}
/// ((375, 1242, 3), True)
#[pyfunction]
pub(crate) fn street_scene(py: Python<'_>) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> {
    let scene = py.detach(starbreak_runs::dataset::street_scene);
    let objects: Vec<Value> = scene
        .objects
        .iter()
        .map(|thing| json!({ "category": thing.category, "box_px": thing.bbox_xyxy_px }))
        .collect();
    let image = array_of(py, DynamicImage::ImageRgb8(scene.image))?;
    Ok((image, python_of(py, &Value::Array(objects))?))
}

fn wrong_shape(cause: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(cause.to_string())
}
