//! Labels and other files of the source, carried over as they are.

use std::fs;
use std::io::{self, BufRead as _, BufReader, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::GeneratedSet;
use crate::error::DatasetError;
use crate::known_folders::{TEMPORARY, absolute_folder_of};
use crate::ordinary_file::open_file;
use crate::paths::same_file;
use crate::provenance::blake3_file;

/// How files are carried over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carry {
    /// As bytes of their own.
    Copy,
    /// As a second name of the same bytes, which takes no space; where the system gives none
    /// (another disk, say), as a copy. To change the one then changes the other.
    HardLink,
}

/// A file that was carried over: a line of `files.jsonl`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct CarriedFile {
    /// Path from the root of the set.
    pub name: String,
    /// Its length.
    pub n_bytes: u64,
    /// BLAKE3 of its bytes.
    pub blake3: String,
}

impl GeneratedSet {
    /// Carries a file over under a name, byte for byte. One that is there with the same bytes stays.
    ///
    /// # Errors
    /// [`DatasetError::Read`], [`DatasetError::Write`], [`DatasetError::UnsafeName`].
    pub fn carry(&self, from: &Path, name: &str, how: Carry) -> Result<CarriedFile, DatasetError> {
        let to = self.layout.safe(name)?;
        let there = fs::metadata(&to).ok().filter(|there| there.is_file());
        if let Some(there) = there
            && there.len() == file_len(from)?
        {
            let carried = carried(name, there.len(), &blake3_file(&to)?);
            // A copy that an earlier run has made is compared; a link is the file.
            if same_file(from, &to) || blake3_file(from)? == carried.blake3 {
                return Ok(carried);
            }
        }
        if how == Carry::HardLink && self.link(from, &to)? {
            return Ok(carried(name, file_len(from)?, &blake3_file(from)?));
        }
        let source = open_file(from)?;
        let mut source = BufReader::new(source);
        self.put_with(name, &mut |out| {
            loop {
                // Bytes that were read and cannot be written are no fault of the source.
                let bytes = match source.fill_buf() {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                    bytes => bytes.map_err(read_error(from))?,
                };
                let n = bytes.len();
                if n == 0 {
                    return Ok(());
                }
                out.write_all(bytes).map_err(|source| DatasetError::Write {
                    path: to.clone(),
                    source,
                })?;
                source.consume(n);
            }
        })
    }

    /// Writes a file under a name as it comes.
    ///
    /// # Errors
    /// What the writer says, [`DatasetError::Write`], [`DatasetError::UnsafeName`].
    pub fn put_with(
        &self,
        name: &str,
        write: &mut dyn FnMut(&mut dyn Write) -> Result<(), DatasetError>,
    ) -> Result<CarriedFile, DatasetError> {
        let to = self.layout.safe(name)?;
        let write_error = |source| DatasetError::Write {
            path: to.clone(),
            source,
        };
        let folder = absolute_folder_of(&to).map_err(write_error)?;
        let (folder, temporary) = self
            .folders
            .temporary_in(&folder, TEMPORARY, || fs::create_dir_all(&folder))
            .map_err(write_error)?;
        let mut hashing = Hashing {
            file: io::BufWriter::new(temporary),
            digest: blake3::Hasher::new(),
            n_bytes: 0,
        };
        write(&mut hashing)?;
        let Hashing {
            file,
            digest,
            n_bytes,
        } = hashing;
        let file = file
            .into_inner()
            .map_err(|error| write_error(error.into_error()))?;
        // Into the folder that the file is in, whatever leads there by now.
        file.persist(folder.join(to.file_name().unwrap_or_default()))
            .map_err(|failed| write_error(failed.error))?;
        Ok(carried(name, n_bytes, &digest.finalize().to_hex()))
    }

    /// Links a file; false where the system does not.
    fn link(&self, from: &Path, to: &Path) -> Result<bool, DatasetError> {
        // The file itself and not a link to it, which would lead elsewhere from here.
        let from = fs::canonicalize(from).map_err(read_error(from))?;
        let write_error = |source| DatasetError::Write {
            path: to.to_owned(),
            source,
        };
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder).map_err(write_error)?;
        }
        match fs::remove_file(to) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                return Err(write_error(source));
            }
            _ => {}
        }
        Ok(fs::hard_link(from, to).is_ok())
    }
}

fn carried(name: &str, n_bytes: u64, blake3: &str) -> CarriedFile {
    CarriedFile {
        name: name.to_owned(),
        n_bytes,
        blake3: blake3.to_owned(),
    }
}

fn read_error(path: &Path) -> impl FnOnce(io::Error) -> DatasetError {
    let path = path.to_owned();
    move |source| DatasetError::Read { path, source }
}

/// The length of a file, bytes.
///
/// # Errors
/// [`DatasetError::Read`].
pub fn file_len(path: &Path) -> Result<u64, DatasetError> {
    Ok(fs::metadata(path).map_err(read_error(path))?.len())
}

/// Writes and hashes at once.
struct Hashing<W: Write> {
    file: io::BufWriter<W>,
    digest: blake3::Hasher,
    n_bytes: u64,
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.file.write(bytes)?;
        self.digest.update(&bytes[..n]);
        self.n_bytes += n as u64;
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}
