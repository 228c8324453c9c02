//! Many records of bytes in one file: written one after the other, read in any order.
//!
//! ```text
//! head     magic (8), version u32, length of the header u32
//! header   bytes that say what the records mean; this crate does not read them
//! records  one after the other, each as it is or compressed by LZ4
//! index    per record: offset u64, length u32, length after decompression u32, CRC-32 u32;
//!          then the SHA-256 of all records as they are stored
//! tail     offset of the index u64, number of records u64, CRC-32 of head and header,
//!          CRC-32 of the index, CRC-32 of the tail so far, magic (8)
//! ```
//!
//! All numbers are little-endian. Nothing before the index depends on the number of records, so
//! that a file of the first few records of another is its beginning.

mod layout;
mod reader;
mod writer;

pub use reader::BankFile;
pub use writer::{BankRecord, BankWriter, WrittenBank};
