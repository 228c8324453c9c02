use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, BufWriter, Seek as _, SeekFrom, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::error::DatasetError;
use crate::ordinary_file::{open_file, refuse_no_file};
use crate::output_batch::OutputBatch;

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
    /// Bytes of the file.
    n_bytes: u64,
    /// Bytes of its first line.
    n_head_bytes: u64,
}

/// Where a line of a [`LineLog`] lies in its file: bytes, with its end.
pub type LineBytes = Range<u64>;

impl LineLog {
    /// Opens or begins the log of what `identity` names, one line without its end, and hands over
    /// the whole lines that are there, with their places.
    ///
    /// # Errors
    /// [`DatasetError::Read`], [`DatasetError::Write`], [`DatasetError::NotAFile`], and
    /// [`DatasetError::FolderInUse`] while another process has it open.
    pub fn open(
        path: &Path,
        identity: &str,
        take: &mut dyn FnMut(&str, LineBytes),
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
        let mut n_bytes =
            n_whole_bytes(&file, Some(identity), take).map_err(|source| DatasetError::Read {
                path: path.to_owned(),
                source,
            })?;
        file.set_len(n_bytes).map_err(write_error)?;
        let n_head_bytes = identity.len() as u64 + 1;
        if n_bytes == 0 {
            file.write_all(format!("{identity}\n").as_bytes())
                .map_err(write_error)?;
            n_bytes = n_head_bytes;
        }
        Ok(Self {
            file,
            path: path.to_owned(),
            n_bytes,
            n_head_bytes,
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
        let mut head = Vec::new();
        io::Read::take(BufReader::new(file), identity.len() as u64 + 1)
            .read_until(b'\n', &mut head)
            .map_err(|source| DatasetError::Read {
                path: path.to_owned(),
                source,
            })?;
        Ok(head.strip_suffix(b"\n") == Some(identity.as_bytes()))
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
        n_whole_bytes(&file, None, &mut |line, _| take(line))
            .map(|_| ())
            .map_err(|source| DatasetError::Read {
                path: path.to_owned(),
                source,
            })
    }

    /// Adds a line, given without its end. Comes to its place.
    ///
    /// # Errors
    /// [`DatasetError::Write`].
    pub fn append(&mut self, line: &str) -> Result<LineBytes, DatasetError> {
        let line = format!("{line}\n");
        self.file
            .write_all(line.as_bytes())
            .map_err(|source| self.write_error(source))?;
        let begin = self.n_bytes;
        self.n_bytes += line.len() as u64;
        Ok(begin..self.n_bytes)
    }

    /// Leaves these lines, in this order, and no other. The file is replaced at once, or stays as it is where it has just
    /// that already.
    ///
    /// # Errors
    /// [`DatasetError::Read`], [`DatasetError::Write`], [`DatasetError::Commit`].
    pub fn close_with(
        mut self,
        lines: impl Iterator<Item = LineBytes> + Clone,
    ) -> Result<(), DatasetError> {
        let mut end = self.n_head_bytes;
        let follows = |line: LineBytes| {
            let does = line.start == end;
            end = line.end;
            does
        };
        if lines.clone().all(follows) && end == self.n_bytes {
            return Ok(());
        }
        // It takes the place of the only copy, so it waits for the disk.
        let mut batch = OutputBatch::new().replacing(true);
        let mut ordered = BufWriter::new(batch.open(&self.path)?);
        for LineBytes { start, end } in std::iter::once(0..self.n_head_bytes).chain(lines) {
            self.file
                .seek(SeekFrom::Start(start))
                .map_err(|source| DatasetError::Read {
                    path: self.path.clone(),
                    source,
                })?;
            let line = io::Read::take(&self.file, end - start);
            let n_copied = io::copy(&mut BufReader::new(line), &mut ordered)
                .map_err(|source| self.write_error(source))?;
            if n_copied != end - start {
                // Another process has shortened it, where there are no locks.
                return Err(self.write_error(io::ErrorKind::UnexpectedEof.into()));
            }
        }
        ordered.flush().map_err(|source| self.write_error(source))?;
        drop(ordered);
        if cfg!(windows) {
            // There an open file is not replaced; elsewhere its lock holds until it is.
            drop(self.file);
        }
        batch.commit()
    }

    fn write_error(&self, source: io::Error) -> DatasetError {
        DatasetError::Write {
            path: self.path.clone(),
            source,
        }
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

/// Bytes from the beginning that are whole lines, of which all but the first are handed over; 0 where the first line is
/// another than the one that is asked for.
fn n_whole_bytes(
    file: &File,
    identity: Option<&str>,
    take: &mut dyn FnMut(&str, LineBytes),
) -> io::Result<u64> {
    let mut reader = BufReader::new(file);
    let mut n_bytes = 0;
    let mut line = Vec::new();
    loop {
        line.clear();
        let n_read =
            io::Read::take(&mut reader, MAX_LINE_BYTES as u64).read_until(b'\n', &mut line)?;
        let Some(text) = line.strip_suffix(b"\n") else {
            return Ok(n_bytes);
        };
        let end = n_bytes + n_read as u64;
        match (n_bytes, identity) {
            (0, Some(identity)) if text != identity.as_bytes() => return Ok(0),
            (0, _) => {}
            _ => {
                if let Ok(text) = std::str::from_utf8(text) {
                    take(text, n_bytes..end);
                }
            }
        }
        n_bytes = end;
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use super::LineLog;
    use crate::same_file;

    #[test]
    fn a_killed_run_goes_on_after_the_last_whole_line() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state/clean.jsonl");
        let mut log = LineLog::open(&path, "a", &mut |_, _| ()).unwrap();
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
        let mut log = LineLog::open(&path, "a", &mut |line, _| seen.push(line.to_owned())).unwrap();
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
    fn another_identity_begins_anew() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("log");
        std::fs::write(&path, "a\n1\n2\n").unwrap();
        assert!(LineLog::is_of(&path, "a").unwrap(), "its own");
        for other in ["b", "a\n1", "", "aa"] {
            assert!(!LineLog::is_of(&path, other).unwrap(), "{other:?}");
        }
        drop(LineLog::open(&path, "b", &mut |line, _| panic!("{line}")).unwrap());
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "b\n",
            "of something else"
        );
    }

    #[test]
    fn lines_that_are_kept_stand_in_the_order_that_is_asked_for() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("log");
        std::fs::write(&path, b"a\none\nbad\n\xff\nthree\n").unwrap();
        let mut kept = Vec::new();
        let mut log = LineLog::open(&path, "a", &mut |line, at| {
            if line != "bad" {
                kept.push(at);
            }
        })
        .unwrap();
        let two = log.append("two").unwrap();
        kept.insert(1, two);
        assert_eq!(kept, [2..6, 18..22, 12..18], "each with its end");
        log.close_with(kept.into_iter()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "a\none\ntwo\nthree\n", "without what is bad");

        // A second name of the file tells whether it is replaced.
        let second = dir.path().join("second");
        std::fs::hard_link(&path, &second).unwrap();
        let mut all = Vec::new();
        let log = LineLog::open(&path, "a", &mut |_, at| all.push(at)).unwrap();
        log.close_with(all.clone().into_iter()).unwrap();
        assert!(same_file(&path, &second), "it was so already");
        let log = LineLog::open(&path, "a", &mut |_, _| ()).unwrap();
        log.close_with(all[..2].iter().cloned()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "a\none\ntwo\n", "one less");
        assert!(!same_file(&path, &second), "replaced, not written over");
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
        let opened = LineLog::open(&path, "a", &mut |_, _| ()).map(|_| ());
        let read = LineLog::read(&path, &mut |_| {});
        for refused in [opened, read] {
            let Err(error) = refused else {
                panic!("a pipe is no log")
            };
            assert!(error.to_string().contains("a pipe"), "{error}");
        }
    }
}
