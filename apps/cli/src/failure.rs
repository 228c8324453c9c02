//! An error on its way to the user: one line and an exit code.

use std::fmt::Display;

use starbreak_dataset::DatasetError;

/// All was done.
pub(crate) const DONE: u8 = 0;
/// The work or some items failed.
pub(crate) const SOME_FAILED: u8 = 1;
/// The command line, the recipe or the input is wrong.
pub(crate) const WRONG_INPUT: u8 = 2;
/// Interrupted; what was done is whole.
pub(crate) const INTERRUPTED: u8 = 130;

/// Why the command stops.
#[derive(Debug)]
pub struct Failure {
    /// What, where and the way out, in one line.
    pub message: String,
    /// The exit code: 1 where the work failed, 2 where the command line, the recipe or the input is wrong, 130 where
    /// it was interrupted.
    pub code: u8,
}

impl Failure {
    /// The input is wrong: exit code 2.
    pub(crate) fn wrong_input(message: impl Display) -> Self {
        Self {
            message: message.to_string(),
            code: WRONG_INPUT,
        }
    }

    /// Interrupted: exit code 130.
    pub(crate) fn interrupted(message: impl Display) -> Self {
        Self {
            message: message.to_string(),
            code: INTERRUPTED,
        }
    }
}

impl From<starbreak::Error> for Failure {
    fn from(error: starbreak::Error) -> Self {
        Self::wrong_input(error)
    }
}

impl From<starbreak_runs::Error> for Failure {
    fn from(error: starbreak_runs::Error) -> Self {
        if let starbreak_runs::Error::Dataset(DatasetError::Video(video)) = &error
            && video.is_failure_of_work()
        {
            return Self {
                message: error.to_string(),
                code: SOME_FAILED,
            };
        }
        Self::wrong_input(error)
    }
}

impl From<starbreak::RecipeError> for Failure {
    fn from(error: starbreak::RecipeError) -> Self {
        Self::wrong_input(error)
    }
}

impl From<starbreak_detect::DetectError> for Failure {
    fn from(error: starbreak_detect::DetectError) -> Self {
        Self::wrong_input(error)
    }
}

impl From<starbreak_eval::EvalError> for Failure {
    fn from(error: starbreak_eval::EvalError) -> Self {
        Self::wrong_input(error)
    }
}

impl From<DatasetError> for Failure {
    fn from(error: DatasetError) -> Self {
        Self::wrong_input(error)
    }
}
