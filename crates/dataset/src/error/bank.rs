//! Why a bank could not be read or written.

/// What is wrong with a bank file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BankFault {
    /// Its first bytes are others.
    #[error("it does not begin like a bank")]
    NotABank,
    /// It is of a later version.
    #[error("it is of format version {found}; this program reads up to {known}")]
    NewerVersion {
        /// The file's.
        found: u32,
        /// The program's.
        known: u32,
    },
    /// It does not end as a bank does.
    #[error("it is cut short or was never finished: its last bytes are not those of a bank")]
    NoEnd,
    /// A part of the file around the records does not have its checksum.
    #[error("its {part} is damaged: wrong checksum")]
    Damaged {
        /// Which part.
        part: &'static str,
    },
    /// A part of the file around the records says what cannot be.
    #[error("its {part} is damaged: {why}")]
    Inconsistent {
        /// Which part.
        part: &'static str,
        /// What cannot be.
        why: &'static str,
    },
    /// A record cannot be read.
    #[error("record {idx} of {n_records} is damaged: {why}")]
    Record {
        /// Which one, from 0.
        idx: usize,
        /// How many there are.
        n_records: usize,
        /// In which way.
        why: &'static str,
    },
    /// All records have their checksums, but together they are others.
    #[error("its records are not those that it was written with: wrong SHA-256")]
    OtherRecords,
    /// There is no such record.
    #[error("it has no record {idx}, only {n_records} (from 0)")]
    NoRecord {
        /// Which one was asked for.
        idx: usize,
        /// How many there are.
        n_records: usize,
    },
    /// More bytes than a bank can hold.
    #[error("{what} of {n_bytes} bytes is too long; a bank takes up to {limit}")]
    TooLong {
        /// What is too long, with its article.
        what: &'static str,
        /// Its length.
        n_bytes: usize,
        /// The limit.
        limit: usize,
    },
}
