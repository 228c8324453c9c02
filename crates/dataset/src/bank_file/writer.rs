//! Writing a bank file, record by record.

use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};

use super::layout::{Entry, HEAD, MAGIC, MAX_HEADER, MAX_RECORD, Tail, VERSION};
use crate::OutputBatch;
use crate::error::{BankFault, DatasetError};
use crate::output_batch::StagedFile;
use crate::provenance::hex;

/// A record ready to be appended: compressed, where that makes it smaller.
#[derive(Debug, Clone)]
pub struct BankRecord {
    stored: Vec<u8>,
    n_bytes: usize,
    crc: u32,
}

impl BankRecord {
    /// A record of these bytes. This is the work of writing a bank, to be done by many threads;
    /// the stored form depends on nothing but the bytes.
    #[must_use]
    pub fn new(bytes: Vec<u8>) -> Self {
        let n_bytes = bytes.len();
        let packed = lz4_flex::block::compress(&bytes);
        let stored = if packed.len() < bytes.len() {
            packed
        } else {
            bytes
        };
        Self {
            crc: crc32fast::hash(&stored),
            n_bytes,
            stored,
        }
    }

    /// Number of bytes that it takes in the file.
    #[must_use]
    pub fn n_stored(&self) -> usize {
        self.stored.len()
    }
}

/// A bank file in the making, under a temporary name.
///
/// In memory there are 20 bytes per record. What is dropped before its
/// [commit](WrittenBank::commit) leaves nothing; a process that is killed leaves a file
/// `.starbreak-*` beside the destination.
#[derive(Debug)]
pub struct BankWriter {
    path: PathBuf,
    // Dropped in this order, so that the folders of the batch are empty when it removes them.
    file: BufWriter<File>,
    staged: StagedFile,
    batch: OutputBatch,
    at: u64,
    head_crc: u32,
    identity: Sha256,
    content: Sha256,
    index: Vec<u8>,
}

impl BankWriter {
    /// Begins a bank that is to be at `path`, with a header that this crate does not read. It becomes
    /// a file of the batch.
    ///
    /// # Errors
    /// [`DatasetError::Taken`], [`DatasetError::Write`] and [`DatasetError::DestinationNotAFile`] as for
    /// [`OutputBatch::stage`], [`DatasetError::Bank`] for a header of more than 16 MiB.
    pub fn create(
        mut batch: OutputBatch,
        path: &Path,
        header: &[u8],
    ) -> Result<Self, DatasetError> {
        let n_header = n_within(path, "a header", header.len(), MAX_HEADER)?;
        batch.may_fill(path)?;
        let (file, staged) = batch.begin(path)?;
        let mut head = [0; HEAD];
        head[..8].copy_from_slice(&MAGIC);
        head[8..12].copy_from_slice(&VERSION.to_le_bytes());
        head[12..].copy_from_slice(&n_header.to_le_bytes());
        let mut crc = crc32fast::Hasher::new();
        crc.update(&head);
        crc.update(header);
        let mut writer = Self {
            path: path.to_owned(),
            batch,
            staged,
            file: BufWriter::with_capacity(1 << 20, file),
            at: 0,
            head_crc: crc.finalize(),
            identity: Sha256::new().chain_update(head).chain_update(header),
            content: Sha256::new(),
            index: Vec::new(),
        };
        writer.write(&head)?;
        writer.write(header)?;
        Ok(writer)
    }

    /// Appends a record.
    ///
    /// # Errors
    /// [`DatasetError::Write`] where the file system refuses, [`DatasetError::Bank`] for a record
    /// of more than 256 MiB.
    pub fn append(&mut self, record: &BankRecord) -> Result<(), DatasetError> {
        let entry = Entry {
            offset: self.at,
            n_stored: n_within(&self.path, "a record", record.stored.len(), MAX_RECORD)?,
            n_bytes: n_within(&self.path, "a record", record.n_bytes, MAX_RECORD)?,
            crc: record.crc,
        };
        self.write(&record.stored)?;
        self.content.update(&record.stored);
        self.index.extend_from_slice(&entry.to_bytes());
        Ok(())
    }

    /// Writes the index and waits until all is on the disk.
    ///
    /// # Errors
    /// [`DatasetError::Write`] where the file system refuses.
    pub fn finish(mut self) -> Result<WrittenBank, DatasetError> {
        let index_at = self.at;
        let n_records = (self.index.len() / super::layout::ENTRY) as u64;
        let mut index = std::mem::take(&mut self.index);
        index.extend_from_slice(&std::mem::take(&mut self.content).finalize());
        let tail = Tail {
            index_at,
            n_records,
            head_crc: self.head_crc,
            index_crc: crc32fast::hash(&index),
        };
        self.write(&index)?;
        self.write(&tail.to_bytes())?;
        self.identity.update(&index);
        let path = self.path;
        let write_error = |source: io::Error| DatasetError::Write {
            path: path.clone(),
            source,
        };
        let file = self
            .file
            .into_inner()
            .map_err(|error| write_error(error.into_error()))?;
        file.sync_all().map_err(write_error)?;
        Ok(WrittenBank {
            batch: self.batch,
            staged: self.staged,
            sha256: hex(&self.identity.finalize()),
            n_bytes: self.at,
        })
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), DatasetError> {
        self.file
            .write_all(bytes)
            .map_err(|source| DatasetError::Write {
                path: self.path.clone(),
                source,
            })?;
        self.at += bytes.len() as u64;
        Ok(())
    }
}

/// A whole bank file that still has its temporary name.
#[derive(Debug)]
pub struct WrittenBank {
    // Dropped in this order, see `BankWriter`.
    staged: StagedFile,
    batch: OutputBatch,
    sha256: String,
    n_bytes: u64,
}

impl WrittenBank {
    /// What [`super::BankFile::sha256`] will say.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Length of the file, in bytes.
    #[must_use]
    pub fn n_bytes(&self) -> u64 {
        self.n_bytes
    }

    /// Gives the file its name, after some files that belong to it: path and bytes of each.
    ///
    /// # Errors
    /// As for [`OutputBatch::stage`] and [`OutputBatch::commit`].
    pub fn commit(mut self, beside: &[(PathBuf, Vec<u8>)]) -> Result<(), DatasetError> {
        for (path, bytes) in beside {
            self.batch.stage(path, bytes)?;
        }
        self.batch.end(self.staged);
        self.batch.commit()
    }
}

fn n_within(
    path: &Path,
    what: &'static str,
    n_bytes: usize,
    limit: usize,
) -> Result<u32, DatasetError> {
    u32::try_from(n_bytes)
        .ok()
        .filter(|_| n_bytes <= limit)
        .ok_or_else(|| DatasetError::Bank {
            path: path.to_owned(),
            fault: BankFault::TooLong {
                what,
                n_bytes,
                limit,
            },
        })
}
