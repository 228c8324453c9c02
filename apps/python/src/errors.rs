//! Which Python error stands for which of ours; the message is the library's.

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::{PyErr, create_exception};
use starbreak::dataset::DatasetError;
use starbreak::eval::EvalError;
use starbreak::fracture::FractureError;
use starbreak::optics::OpticsError;
use starbreak::{Error, RecipeError};

create_exception!(
    starbreak,
    SimulationError,
    PyRuntimeError,
    "The models have no answer for valid parameters: no glass in the frame where a stone is to \
     hit, more cracks than can be held, equations without a solution."
);

/// An error of the library.
pub(crate) fn raised(error: &Error) -> PyErr {
    let message = error.to_string();
    match root(error) {
        Error::Dataset(cause) | Error::Eval(EvalError::Dataset(cause)) => of_file(cause, message),
        Error::Fracture(FractureError::Parameter { .. } | FractureError::Pane(_))
        | Error::Optics(
            OpticsError::Parameter { .. }
            | OpticsError::ImageMode { .. }
            | OpticsError::EmptyImage { .. }
            | OpticsError::SizeMismatch { .. },
        ) => PyValueError::new_err(message),
        Error::Fracture(_) | Error::Optics(_) | Error::OffGlass { .. } | Error::Threads { .. } => {
            SimulationError::new_err(message)
        }
        _ => PyValueError::new_err(message),
    }
}

/// An error of a recipe.
pub(crate) fn of_recipe(error: &RecipeError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// What an error is about, without the names of images and patterns around it.
fn root(error: &Error) -> &Error {
    match error {
        Error::OfImage { cause, .. } | Error::OfPattern { cause, .. } => root(cause),
        error => error,
    }
}

/// Files that cannot be read, written or used are `OSError`, of the class of their `errno` where
/// the system gave one; what is wrong in a request is `ValueError`.
fn of_file(error: &DatasetError, message: String) -> PyErr {
    match error {
        DatasetError::Read { source, .. }
        | DatasetError::Write { source, .. }
        | DatasetError::Commit { source, .. }
        | DatasetError::SubsetWrite { source, .. } => match source.raw_os_error() {
            Some(code) => PyOSError::new_err((code, message)),
            None => PyOSError::new_err(message),
        },
        DatasetError::ArrayShape { .. }
        | DatasetError::JpegQuality { .. }
        | DatasetError::UnsupportedMode { .. }
        | DatasetError::ImageSize { .. }
        | DatasetError::SourceSpec { .. }
        | DatasetError::UnsafeName { .. }
        | DatasetError::NotText { .. }
        | DatasetError::JsonText { .. } => PyValueError::new_err(message),
        _ => PyOSError::new_err(message),
    }
}
