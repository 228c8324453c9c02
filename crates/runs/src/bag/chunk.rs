//! What a chunk holds: records, which may be compressed.

use std::borrow::Cow;
use std::io::{self, Read};

use mcap::records::{ChunkHeader, Record, op};

use super::record::{parsed, split};
use super::records::{Event, MAX_RECORD_BYTES, Squeezing, Unreadable, event};

/// Memory for a chunk before it is unpacked, bytes; recorders write 1 to 4 MB.
const USUAL_BYTES: usize = 8 << 20;

/// What a chunk holds and how it was compressed, or what is wrong with it: that ends the walk, an [`Unreadable`] the run.
pub(super) fn chunk(record: &[u8]) -> Result<Result<(Squeezing, Vec<Event>), String>, Unreadable> {
    let (header, data) = match parsed(op::CHUNK, record) {
        Ok(Record::Chunk { header, data }) => (header, data),
        Ok(_) => return Ok(Err("a chunk is none".to_owned())),
        Err(reason) => return Ok(Err(reason)),
    };
    let squeezing = squeezing(&header)?;
    let events = unpacked(&header, squeezing, &data)
        .and_then(|unpacked| events(&unpacked, MAX_RECORD_BYTES));
    Ok(events.map(|events| (squeezing, events)))
}

/// The events of an unpacked chunk, as far as they take no more memory than some bytes: records may be short.
fn events(mut records: &[u8], most_bytes: u64) -> Result<Vec<Event>, String> {
    let (mut events, mut n_bytes) = (Vec::new(), 0);
    while let Some((head, rest)) = records.split_first_chunk() {
        let (opcode, length) = split(head);
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let Some((record, rest)) = rest.split_at_checked(length) else {
            return Err("a chunk ends within a record".to_owned());
        };
        if let Some(event) = event(opcode, record, true)? {
            n_bytes += event.n_bytes() as u64;
            events.push(event);
        }
        if n_bytes > most_bytes {
            return Err(format!(
                "a chunk has records that take more than {most_bytes} bytes of memory"
            ));
        }
        records = rest;
    }
    match records {
        [] => Ok(events),
        _ => Err("a chunk ends within a record".to_owned()),
    }
}

fn squeezing(header: &ChunkHeader) -> Result<Squeezing, Unreadable> {
    match header.compression.as_str() {
        "" => Ok(Squeezing::None),
        "lz4" => Ok(Squeezing::Lz4),
        "zstd" => Ok(Squeezing::Zstd),
        other => Err(Unreadable::Records(format!(
            "its chunks are compressed by {other:?}; only lz4 and zstd are read"
        ))),
    }
}

/// What a chunk holds, with its checksum.
fn unpacked<'a>(
    header: &ChunkHeader,
    squeezing: Squeezing,
    data: &'a [u8],
) -> Result<Cow<'a, [u8]>, String> {
    let n_bytes = header.uncompressed_size;
    if n_bytes > MAX_RECORD_BYTES {
        return Err(format!(
            "a chunk claims {n_bytes} bytes, more than the {MAX_RECORD_BYTES} that are read"
        ));
    }
    let unpacked = match squeezing {
        Squeezing::None => Ok(Cow::Borrowed(data)),
        Squeezing::Lz4 => read_all(lz4::Decoder::new(data), n_bytes),
        Squeezing::Zstd => read_all(zstd::Decoder::new(data), n_bytes),
    };
    let unpacked = unpacked
        .ok()
        .filter(|unpacked| unpacked.len() as u64 == n_bytes)
        .ok_or("a chunk does not unpack to what it claims")?;
    let crc = header.uncompressed_crc;
    if crc != 0 && crc32fast::hash(&unpacked) != crc {
        return Err("a chunk has another checksum than its bytes".to_owned());
    }
    Ok(unpacked)
}

/// What a decoder gives, one byte more than is claimed at most; no more memory is taken than for what it turns out to
/// be, or for a chunk of usual size.
fn read_all(decoder: io::Result<impl Read>, claimed: u64) -> io::Result<Cow<'static, [u8]>> {
    let usual = usize::try_from(claimed).map_or(USUAL_BYTES, |claimed| claimed.min(USUAL_BYTES));
    let mut unpacked = Vec::with_capacity(usual + 1);
    decoder?.take(claimed + 1).read_to_end(&mut unpacked)?;
    Ok(Cow::Owned(unpacked))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_short_records_take_no_more_memory_than_is_allowed() {
        let private = [0x80, 0, 0, 0, 0, 0, 0, 0, 0].repeat(1000);
        let n_bytes = 1000 * size_of::<Event>() as u64;
        assert_eq!(
            events(&private, n_bytes).map(|events| events.len()),
            Ok(1000)
        );
        assert!(events(&private, n_bytes - 1).is_err());
    }
}
