//! Which Python error stands for which of ours; the message is the library's.

use std::io;
use std::path::Path;

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::types::PyAnyMethods as _;
use pyo3::{PyErr, PyResult, Python, create_exception};
use starbreak::RecipeError;
use starbreak::fracture::FractureError;
use starbreak::optics::OpticsError;
use starbreak_runs::Error;
use starbreak_runs::dataset::DatasetError;
use starbreak_runs::eval::EvalError;

create_exception!(
    starbreak,
    SimulationError,
    PyRuntimeError,
    "Valid parameters without a result: no glass in the frame where a stone should hit, too many \
     cracks, equations without a solution."
);

/// An error of the library.
pub(crate) fn raised(error: &Error) -> PyErr {
    let message = error.to_string();
    match root(error) {
        Error::Dataset(cause) | Error::Eval(EvalError::Dataset(cause)) => of_file(cause, message),
        Error::Chain(cause) => of_chain(cause, message),
        Error::Threads { .. } => SimulationError::new_err(message),
        Error::Bank { .. } => PyOSError::new_err(message),
        _ => PyValueError::new_err(message),
    }
}

/// An error of breaking and showing glass.
pub(crate) fn raised_in_memory(error: &starbreak::Error) -> PyErr {
    of_chain(error, error.to_string())
}

fn of_chain(error: &starbreak::Error, message: String) -> PyErr {
    match error {
        starbreak::Error::Fracture(FractureError::Parameter { .. } | FractureError::Pane(_))
        | starbreak::Error::Optics(
            OpticsError::Parameter { .. }
            | OpticsError::ImageMode { .. }
            | OpticsError::EmptyImage { .. }
            | OpticsError::SizeMismatch { .. },
        ) => PyValueError::new_err(message),
        starbreak::Error::Fracture(_)
        | starbreak::Error::Optics(_)
        | starbreak::Error::OffGlass { .. } => SimulationError::new_err(message),
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
            let done = match replaced.len() {
                0 => String::new(),
                n => format!("; {n} existing files were already replaced, new ones removed"),
            };
            of_system(source, path, &done, message)
        }
        DatasetError::Taken { path } => {
            let way_out = "; choose another name or folder, or give replace=True";
            of_system(&io::ErrorKind::AlreadyExists.into(), path, way_out, message)
        }
        DatasetError::Altered { path } => {
            let way_out = "; an earlier run wrote it otherwise; move it away, or give replace=True";
            of_system(&io::ErrorKind::AlreadyExists.into(), path, way_out, message)
        }
        DatasetError::NotAFile { path, what }
        | DatasetError::DestinationNotAFile { path, what }
            if what.ends_with("folder") =>
        {
            of_system(&io::ErrorKind::IsADirectory.into(), path, "", message)
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
/// of its `errno`; the message alone where there is no number.
fn of_system(source: &io::Error, path: &Path, done: &str, message: String) -> PyErr {
    let Some(code) = source.raw_os_error().or_else(|| code_of(source.kind())) else {
        return PyOSError::new_err(message);
    };
    let said = Python::attach(|py| -> PyResult<String> {
        py.import("os")?
            .call_method1("strerror", (code,))?
            .extract()
    });
    let said = said.unwrap_or(message);
    PyOSError::new_err((code, format!("{said}{done}"), path.as_os_str().to_owned()))
}

/// The number of what a library says without one, the same on all systems.
fn code_of(kind: io::ErrorKind) -> Option<i32> {
    match kind {
        io::ErrorKind::NotFound => Some(2),
        io::ErrorKind::PermissionDenied => Some(13),
        io::ErrorKind::AlreadyExists => Some(17),
        io::ErrorKind::NotADirectory => Some(20),
        io::ErrorKind::IsADirectory => Some(21),
        io::ErrorKind::StorageFull => Some(28),
        io::ErrorKind::ReadOnlyFilesystem => Some(30),
        _ => None,
    }
}
