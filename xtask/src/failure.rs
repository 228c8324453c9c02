//! Why a chore failed, in one line.

use std::fmt;
use std::path::Path;

/// One line that says what is wrong and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure(String);

impl Failure {
    /// A failure from its line.
    pub fn new(line: impl Into<String>) -> Self {
        Self(line.into())
    }

    /// A file that could not be read or written.
    #[must_use]
    pub fn of_file(path: &Path, cause: &std::io::Error) -> Self {
        Self(format!("{}: {cause}", path.display()))
    }

    /// Success without findings; otherwise prints each and returns their number as the failure.
    ///
    /// # Errors
    /// A failure if there is a finding.
    pub fn from_findings(findings: &[String], of: &str) -> Result<(), Self> {
        for finding in findings {
            eprintln!("error: {finding}");
        }
        match findings.len() {
            0 => Ok(()),
            n => Err(Self(format!("{n} {of}"))),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
