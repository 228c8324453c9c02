use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};

use crate::error::DatasetError;
use crate::ordinary_file::{open_file, refuse_no_file};

/// A line that is longer is not one of ours, bytes.
const MAX_LINE_BYTES: usize = 1 << 26;

/// A file that grows by a line for each thing done, so that a run that was killed goes on.
///
/// Its first line says what the lines are made from; a file with another first line is begun
/// anew. A line counts once its end is written: what a killed run left half-written is cut off.
#[derive(Debug)]
pub struct LineLog {
    file: File,
    path: PathBuf,
}

impl LineLog {
    /// Opens or begins the log of what `identity` names, one line without its end, and hands over
    /// the lines that are there. The first that `is_good` refuses is cut off with all after it.
    ///
    /// # Errors
    /// [`DatasetError::Read`], [`DatasetError::Write`], [`DatasetError::NotAFile`], and
    /// [`DatasetError::FolderInUse`] while another process has it open.
    pub fn open(
        path: &Path,
        identity: &str,
        is_good: &mut dyn FnMut(&str) -> bool,
    ) -> Result<Self, DatasetError> {
        let write_error = |source| DatasetError::Write {
            path: path.to_owned(),
            source,
        };
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(write_error)?;
        }
        refuse_no_file(path)?;
        let mut file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(path)
            .map_err(write_error)?;
        // Some file systems have no locks; that is no reason to refuse them. On Windows a lock would keep others from
        // reading.
        if cfg!(unix) && matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)) {
            return Err(DatasetError::FolderInUse {
                path: path.to_owned(),
            });
        }
        let n_good =
            n_good_bytes(&file, Some(identity), is_good).map_err(|source| DatasetError::Read {
                path: path.to_owned(),
                source,
            })?;
        file.set_len(n_good).map_err(write_error)?;
        if n_good == 0 {
            file.write_all(format!("{identity}\n").as_bytes())
                .map_err(write_error)?;
        }
        Ok(Self {
            file,
            path: path.to_owned(),
        })
    }

    /// Whether there is a log of what `identity` names.
    ///
    /// # Errors
    /// [`DatasetError::Read`], [`DatasetError::NotAFile`].
    pub fn is_of(path: &Path, identity: &str) -> Result<bool, DatasetError> {
        let file = match open_file(path) {
            Err(DatasetError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Ok(false);
            }
            file => file?,
        };
        let n_good = n_good_bytes(&file, Some(identity), &mut |_| false);
        n_good.map(|n| n > 0).map_err(|source| DatasetError::Read {
            path: path.to_owned(),
            source,
        })
    }

    /// Hands over the lines of a log, whatever they are made from, and leaves it as it is. A log that is
    /// not there has none.
    ///
    /// # Errors
    /// [`DatasetError::Read`], [`DatasetError::NotAFile`].
    pub fn read(path: &Path, take: &mut dyn FnMut(&str)) -> Result<(), DatasetError> {
        let file = match open_file(path) {
            Err(DatasetError::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Ok(());
            }
            file => file?,
        };
        n_good_bytes(&file, None, &mut |line| {
            take(line);
            true
        })
        .map(|_| ())
        .map_err(|source| DatasetError::Read {
            path: path.to_owned(),
            source,
        })
    }

    /// Adds a line, given without its end.
    ///
    /// # Errors
    /// [`DatasetError::Write`].
    pub fn append(&mut self, line: &str) -> Result<(), DatasetError> {
        self.file
            .write_all(format!("{line}\n").as_bytes())
            .map_err(|source| DatasetError::Write {
                path: self.path.clone(),
                source,
            })
    }

    /// Removes the file, once what it was for stands elsewhere.
    ///
    /// # Errors
    /// [`DatasetError::Write`].
    pub fn remove(self) -> Result<(), DatasetError> {
        fs::remove_file(&self.path).map_err(|source| DatasetError::Write {
            path: self.path,
            source,
        })
    }
}

/// Bytes from the beginning that are whole lines in order; 0 where the first line is another than the
/// one that is asked for.
fn n_good_bytes(
    file: &File,
    identity: Option<&str>,
    is_good: &mut dyn FnMut(&str) -> bool,
) -> io::Result<u64> {
    let mut reader = BufReader::new(file);
    let mut n_good = 0;
    let mut line = Vec::new();
    loop {
        line.clear();
        let n_read =
            io::Read::take(&mut reader, MAX_LINE_BYTES as u64).read_until(b'\n', &mut line)?;
        let Some(text) = line
            .strip_suffix(b"\n")
            .and_then(|text| std::str::from_utf8(text).ok())
        else {
            return Ok(n_good);
        };
        let is_right = match n_good {
            0 => identity.is_none_or(|identity| text == identity),
            _ => is_good(text),
        };
        if !is_right {
            return Ok(n_good);
        }
        n_good += n_read as u64;
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::LineLog;

    #[test]
    fn a_killed_run_goes_on_after_the_last_whole_line() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state/clean.jsonl");
        let mut log = LineLog::open(&path, "a", &mut |_| true).unwrap();
        log.append("1").unwrap();
        log.append("2").unwrap();
        drop(log);
        let mut half = std::fs::read(&path).unwrap();
        half.extend(b"3 and no en");
        std::fs::write(&path, half).unwrap();

        let mut all = Vec::new();
        LineLog::read(&path, &mut |line| all.push(line.to_owned())).unwrap();
        assert_eq!(all, ["1", "2"], "whole lines, without their identity");
        LineLog::read(&dir.path().join("none"), &mut |_| panic!("a line")).unwrap();

        let mut seen = Vec::new();
        let mut log = LineLog::open(&path, "a", &mut |line| {
            seen.push(line.to_owned());
            true
        })
        .unwrap();
        assert_eq!(seen, ["1", "2"], "whole lines");
        log.append("3").unwrap();
        drop(log);
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "a\n1\n2\n3\n",
            "cut off"
        );
    }

    #[test]
    fn another_identity_begins_anew_and_a_bad_line_ends_what_counts() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("log");
        std::fs::write(&path, "a\n1\nbad\n2\n").unwrap();
        drop(LineLog::open(&path, "a", &mut |line| line != "bad").unwrap());
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "a\n1\n",
            "up to the bad one"
        );
        drop(LineLog::open(&path, "b", &mut |_| true).unwrap());
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "b\n",
            "of something else"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_refused_without_opening_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("log");
        let made = std::process::Command::new("mkfifo").arg(&path).status();
        if !made.is_ok_and(|status| status.success()) {
            return;
        }
        let opened = LineLog::open(&path, "a", &mut |_| true).map(|_| ());
        let read = LineLog::read(&path, &mut |_| {});
        for refused in [opened, read] {
            let Err(error) = refused else {
                panic!("a pipe is no log")
            };
            assert!(error.to_string().contains("a pipe"), "{error}");
        }
    }
}
