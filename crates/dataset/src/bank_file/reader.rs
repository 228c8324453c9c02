//! Reading records of a bank file, in any order and from many threads.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};

use super::layout::{
    DIGEST, END_MAGIC, ENTRY, Entry, HEAD, MAGIC, MAX_EXPANSION, MAX_HEADER, MAX_RECORD, TAIL,
    Tail, VERSION, u32_at,
};
use crate::error::{BankFault, DatasetError};
use crate::ordinary_file::open_file;
use crate::provenance::hex;

/// A bank file that is open for reading: records of bytes by their number.
///
/// In memory there are header and index. Any number of threads may read at one time.
#[derive(Debug)]
pub struct BankFile {
    path: PathBuf,
    file: File,
    header: Vec<u8>,
    entries: Vec<Entry>,
    content_sha256: [u8; DIGEST],
    sha256: String,
    n_bytes: u64,
}

impl BankFile {
    /// Opens a bank and checks all of it but the records.
    ///
    /// # Errors
    /// [`DatasetError::Read`], [`DatasetError::NotAFile`], and [`DatasetError::Bank`] naming the
    /// part of the file that is wrong.
    pub fn open(path: &Path) -> Result<Self, DatasetError> {
        let read_error = |source| DatasetError::Read {
            path: path.to_owned(),
            source,
        };
        let file = open_file(path)?;
        let n_bytes = file.metadata().map_err(read_error)?.len();
        Self::of_file(path, file, n_bytes)
    }

    fn of_file(path: &Path, file: File, n_bytes: u64) -> Result<Self, DatasetError> {
        let mut bank = Self {
            path: path.to_owned(),
            file,
            header: Vec::new(),
            entries: Vec::new(),
            content_sha256: [0; DIGEST],
            sha256: String::new(),
            n_bytes,
        };
        let head = bank.read_head()?;
        let tail = bank.read_tail()?;
        let n_header = u32_at(&head, 12) as usize;
        let records_at = (HEAD + n_header) as u64;
        if n_header > MAX_HEADER || records_at > tail.index_at {
            return Err(bank.wrong("head", "its header would not fit"));
        }
        let n_index = bank.index_len(&tail)?;
        bank.header = bank.read_at(HEAD as u64, n_header)?;
        let mut crc = crc32fast::Hasher::new();
        crc.update(&head);
        crc.update(&bank.header);
        if crc.finalize() != tail.head_crc {
            return Err(bank.fault(BankFault::Damaged { part: "header" }));
        }
        let index = bank.read_at(tail.index_at, n_index)?;
        if crc32fast::hash(&index) != tail.index_crc {
            return Err(bank.fault(BankFault::Damaged { part: "index" }));
        }
        let (rows, digest) = index.split_at(n_index - DIGEST);
        let rows = rows.as_chunks::<ENTRY>().0.iter();
        bank.entries = rows.map(Entry::of_bytes).collect();
        bank.check_entries(records_at, tail.index_at)?;
        bank.content_sha256.copy_from_slice(digest);
        let identity = Sha256::new()
            .chain_update(&head)
            .chain_update(&bank.header)
            .chain_update(&index);
        bank.sha256 = hex(&identity.finalize());
        Ok(bank)
    }

    /// Bytes around the records; every caller has checked their number against the length of the file.
    fn read_at(&self, at: u64, n: usize) -> Result<Vec<u8>, DatasetError> {
        let mut bytes = vec![0; n];
        read_exact_at(&self.file, &mut bytes, at).map_err(|source| match source.kind() {
            io::ErrorKind::UnexpectedEof => self.fault(BankFault::NoEnd),
            _ => DatasetError::Read {
                path: self.path.clone(),
                source,
            },
        })?;
        Ok(bytes)
    }

    /// The head of a file of this version that is long enough for all that is around the records.
    fn read_head(&self) -> Result<Vec<u8>, DatasetError> {
        let is_bank = self.n_bytes >= MAGIC.len() as u64 && self.read_at(0, MAGIC.len())? == MAGIC;
        if !is_bank {
            return Err(self.fault(BankFault::NotABank));
        }
        if self.n_bytes < (HEAD + DIGEST + TAIL) as u64 {
            return Err(self.fault(BankFault::NoEnd));
        }
        let head = self.read_at(0, HEAD)?;
        match u32_at(&head, 8) {
            VERSION => Ok(head),
            found if found > VERSION => Err(self.fault(BankFault::NewerVersion {
                found,
                known: VERSION,
            })),
            _ => Err(self.wrong("head", "there is no such version")),
        }
    }

    fn read_tail(&self) -> Result<Tail, DatasetError> {
        let tail = self.read_at(self.n_bytes - TAIL as u64, TAIL)?;
        if !tail.ends_with(&END_MAGIC) {
            return Err(self.fault(BankFault::NoEnd));
        }
        let tail = tail.first_chunk().and_then(Tail::of_bytes);
        tail.ok_or_else(|| self.fault(BankFault::Damaged { part: "tail" }))
    }

    /// Bytes of the index, which lies between the records and the tail.
    fn index_len(&self, tail: &Tail) -> Result<usize, DatasetError> {
        let n_index = tail
            .n_records
            .checked_mul(ENTRY as u64)
            .and_then(|n| n.checked_add(DIGEST as u64));
        let end = n_index.and_then(|n| tail.index_at.checked_add(n));
        let n_index = n_index.and_then(|n| usize::try_from(n).ok());
        n_index
            .filter(|_| end == Some(self.n_bytes - TAIL as u64))
            .ok_or_else(|| {
                let why = "the index does not lie between the records and the end";
                self.wrong("tail", why)
            })
    }

    /// The records lie one after the other up to the index.
    fn check_entries(&self, records_at: u64, index_at: u64) -> Result<(), DatasetError> {
        let mut next = records_at;
        for (idx, entry) in self.entries.iter().enumerate() {
            let record = |why| self.record_fault(idx, why);
            let (n_stored, n_raw) = (entry.n_stored as usize, entry.n_bytes as usize);
            if entry.offset != next {
                return Err(record("it does not begin where the one before it ends"));
            }
            if n_stored > MAX_RECORD || n_raw > MAX_RECORD {
                return Err(record("it is longer than a record may be"));
            }
            if n_raw < n_stored || n_raw > n_stored.saturating_mul(MAX_EXPANSION) {
                return Err(record("its lengths do not fit each other"));
            }
            next += u64::from(entry.n_stored);
            if next > index_at {
                return Err(record("it reaches into the index"));
            }
        }
        if next != index_at {
            return Err(self.wrong("index", "there are bytes that belong to no record"));
        }
        Ok(())
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What says what the records mean.
    #[must_use]
    pub fn header(&self) -> &[u8] {
        &self.header
    }

    /// Number of records.
    #[must_use]
    pub fn n_records(&self) -> usize {
        self.entries.len()
    }

    /// Length of the file, in bytes.
    #[must_use]
    pub fn n_bytes(&self) -> u64 {
        self.n_bytes
    }

    /// SHA-256 of header and index, 64 hexadecimal digits. The index holds the SHA-256 of the records, so that
    /// two banks with the same digest have the same header and records.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// The bytes of a record, whose checksum is verified.
    ///
    /// # Errors
    /// [`DatasetError::Bank`] naming the record, [`DatasetError::Read`] where the file system
    /// refuses.
    pub fn read(&self, idx: usize) -> Result<Vec<u8>, DatasetError> {
        let (entry, stored) = self.stored(idx)?;
        self.expanded(idx, entry, stored)
    }

    /// Reads every record and verifies all checksums; `each` is called with number and bytes of
    /// each that is whole, and ends the check by returning `false`.
    ///
    /// # Errors
    /// [`DatasetError::Bank`] naming the first record that is wrong.
    pub fn check(&self, mut each: impl FnMut(usize, Vec<u8>) -> bool) -> Result<(), DatasetError> {
        let mut content = Sha256::new();
        for idx in 0..self.entries.len() {
            let (entry, stored) = self.stored(idx)?;
            content.update(&stored);
            if !each(idx, self.expanded(idx, entry, stored)?) {
                return Ok(());
            }
        }
        if content.finalize()[..] == self.content_sha256 {
            Ok(())
        } else {
            Err(self.fault(BankFault::OtherRecords))
        }
    }

    /// A record as it was before it was stored.
    fn expanded(&self, idx: usize, entry: Entry, stored: Vec<u8>) -> Result<Vec<u8>, DatasetError> {
        if entry.n_stored == entry.n_bytes {
            return Ok(stored);
        }
        // The length was checked against that of the stored bytes.
        let n_bytes = entry.n_bytes as usize;
        lz4_flex::block::decompress(&stored, n_bytes)
            .ok()
            .filter(|bytes| bytes.len() == n_bytes)
            .ok_or_else(|| self.record_fault(idx, "it does not decompress to its length"))
    }

    /// A record as it is in the file, verified.
    fn stored(&self, idx: usize) -> Result<(Entry, Vec<u8>), DatasetError> {
        let Some(&entry) = self.entries.get(idx) else {
            return Err(self.fault(BankFault::NoRecord {
                idx,
                n_records: self.entries.len(),
            }));
        };
        let mut stored = vec![0; entry.n_stored as usize];
        read_exact_at(&self.file, &mut stored, entry.offset).map_err(|source| {
            match source.kind() {
                io::ErrorKind::UnexpectedEof => {
                    self.record_fault(idx, "the file has become shorter")
                }
                _ => DatasetError::Read {
                    path: self.path.clone(),
                    source,
                },
            }
        })?;
        if crc32fast::hash(&stored) != entry.crc {
            return Err(self.record_fault(idx, "wrong checksum"));
        }
        Ok((entry, stored))
    }

    fn record_fault(&self, idx: usize, why: &'static str) -> DatasetError {
        self.fault(BankFault::Record {
            idx,
            n_records: self.entries.len(),
            why,
        })
    }

    fn wrong(&self, part: &'static str, why: &'static str) -> DatasetError {
        self.fault(BankFault::Inconsistent { part, why })
    }

    fn fault(&self, fault: BankFault) -> DatasetError {
        DatasetError::Bank {
            path: self.path.clone(),
            fault,
        }
    }
}

#[cfg(unix)]
fn read_exact_at(file: &File, bytes: &mut [u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, at)
}

// Nothing else reads the file meanwhile: there are no threads.
#[cfg(target_family = "wasm")]
fn read_exact_at(mut file: &File, bytes: &mut [u8], at: u64) -> io::Result<()> {
    io::Seek::seek(&mut file, io::SeekFrom::Start(at))?;
    io::Read::read_exact(&mut file, bytes)
}

#[cfg(windows)]
fn read_exact_at(file: &File, mut bytes: &mut [u8], mut at: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, bytes, at) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(n) => {
                bytes = &mut bytes[n..];
                at += n as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}
