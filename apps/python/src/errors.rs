//! Which Python error stands for which of ours; the message is the library's.

use std::io;
use std::path::Path;

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
        Error::Bank { .. } => PyOSError::new_err(message),
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

/// Files that cannot be read, written or used are `OSError`; what is wrong in a request is
/// `ValueError`.
fn of_file(error: &DatasetError, message: String) -> PyErr {
    match error {
        DatasetError::Read { path, source } | DatasetError::Write { path, source } => {
            of_system(source, path, "", message)
        }
        DatasetError::Commit {
            path,
            replaced,
            source,
        } => {
            let n = replaced.len();
            let done = format!("; {n} existing files were already replaced, new ones removed");
            of_system(source, path, &done, message)
        }
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

/// An `OSError` as the interpreter makes it, with `errno`, `strerror` and `filename`, and of the class
/// of its `errno`; the message alone where the system gave no number.
fn of_system(source: &io::Error, path: &Path, done: &str, message: String) -> PyErr {
    let Some(code) = source.raw_os_error() else {
        return PyOSError::new_err(message);
    };
    let said = source.to_string();
    let said = said.split(" (os error").next().unwrap_or(&said);
    PyOSError::new_err((code, format!("{said}{done}"), path.as_os_str().to_owned()))
}
