//! Where what is in a bank file.

/// First and last bytes. The first is no text and no UTF-8, so that nothing takes it for either.
pub(super) const MAGIC: [u8; 8] = *b"\x89SBBANK\n";
pub(super) const END_MAGIC: [u8; 8] = *b"\x89SBBEND\n";

/// Version of the format.
pub(super) const VERSION: u32 = 1;

/// Bytes of head and tail, of an entry of the index, and of the digest behind the entries.
pub(super) const HEAD: usize = 16;
pub(super) const TAIL: usize = 36;
pub(super) const ENTRY: usize = 20;
pub(super) const DIGEST: usize = 32;

/// Bytes of a record at most, stored or not, and of a header.
pub(super) const MAX_RECORD: usize = 1 << 28;
pub(super) const MAX_HEADER: usize = 1 << 24;

/// A byte of LZ4 stands for at most this many.
pub(super) const MAX_EXPANSION: usize = 255;

/// Where a record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) offset: u64,
    pub(super) n_stored: u32,
    /// The same where it is stored as it is.
    pub(super) n_bytes: u32,
    pub(super) crc: u32,
}

impl Entry {
    pub(super) fn to_bytes(self) -> [u8; ENTRY] {
        let mut out = [0; ENTRY];
        out[..8].copy_from_slice(&self.offset.to_le_bytes());
        out[8..12].copy_from_slice(&self.n_stored.to_le_bytes());
        out[12..16].copy_from_slice(&self.n_bytes.to_le_bytes());
        out[16..].copy_from_slice(&self.crc.to_le_bytes());
        out
    }

    pub(super) fn of_bytes(bytes: &[u8; ENTRY]) -> Self {
        Self {
            offset: u64_at(bytes, 0),
            n_stored: u32_at(bytes, 8),
            n_bytes: u32_at(bytes, 12),
            crc: u32_at(bytes, 16),
        }
    }
}

/// The number at a place; the callers' buffers are long enough.
pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    let bytes = bytes.get(at..).and_then(<[u8]>::first_chunk);
    u32::from_le_bytes(bytes.copied().unwrap_or_default())
}

/// As [`u32_at`].
pub(super) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    let bytes = bytes.get(at..).and_then(<[u8]>::first_chunk);
    u64::from_le_bytes(bytes.copied().unwrap_or_default())
}

/// The last bytes of a file.
pub(super) struct Tail {
    pub(super) index_at: u64,
    pub(super) n_records: u64,
    pub(super) head_crc: u32,
    pub(super) index_crc: u32,
}

impl Tail {
    pub(super) fn to_bytes(&self) -> [u8; TAIL] {
        let mut out = [0; TAIL];
        out[..8].copy_from_slice(&self.index_at.to_le_bytes());
        out[8..16].copy_from_slice(&self.n_records.to_le_bytes());
        out[16..20].copy_from_slice(&self.head_crc.to_le_bytes());
        out[20..24].copy_from_slice(&self.index_crc.to_le_bytes());
        let crc = crc32fast::hash(&out[..24]);
        out[24..28].copy_from_slice(&crc.to_le_bytes());
        out[28..].copy_from_slice(&END_MAGIC);
        out
    }

    /// `None` where it does not have its checksum.
    pub(super) fn of_bytes(bytes: &[u8; TAIL]) -> Option<Self> {
        (crc32fast::hash(&bytes[..24]) == u32_at(bytes, 24)).then(|| Self {
            index_at: u64_at(bytes, 0),
            n_records: u64_at(bytes, 8),
            head_crc: u32_at(bytes, 16),
            index_crc: u32_at(bytes, 20),
        })
    }
}
