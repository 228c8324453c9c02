//! The records of an MCAP file in their order, as far as they are whole.
//!
//! [MCAP](https://mcap.dev/spec): magic bytes, then records of one byte (what), eight (how long) and content. Messages
//! lie in the file itself, or in chunks, which may be compressed. Only one record and one chunk are in memory.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::{AttachmentHeader, Channel, MessageHeader, Metadata, Record, SchemaHeader, op};

use super::chunk::chunk;
use super::damage::Damage;
use super::promise::Promise;
use super::record::{HEAD, parsed, split};

/// Longest record and longest chunk when it is unpacked, bytes: far above what recorders write (1 to 4 MB).
pub(super) const MAX_RECORD_BYTES: u64 = 1 << 30;

/// What stands in a bag.
#[derive(Debug)]
pub(super) enum Event {
    Schema {
        header: SchemaHeader,
        data: Vec<u8>,
    },
    Channel(Channel),
    Message {
        header: MessageHeader,
        data: Vec<u8>,
    },
    Attachment {
        header: AttachmentHeader,
        data: Vec<u8>,
    },
    Metadata(Metadata),
    /// A record of a kind that is the application's own.
    Private {
        opcode: u8,
        data: Vec<u8>,
        is_in_chunk: bool,
    },
    /// A chunk is at its end.
    ChunkEnd,
}

impl Event {
    /// Bytes in memory.
    pub(super) fn n_bytes(&self) -> usize {
        let map = |map: &BTreeMap<String, String>| -> usize {
            let texts = map.iter().map(|(key, value)| key.len() + value.len());
            texts.sum::<usize>() + map.len() * size_of::<(String, String)>()
        };
        let owned = match self {
            Self::Schema { header, data } => header.name.len() + header.encoding.len() + data.len(),
            Self::Channel(channel) => {
                let texts = channel.topic.len() + channel.message_encoding.len();
                texts + map(&channel.metadata)
            }
            Self::Message { data, .. } | Self::Private { data, .. } => data.len(),
            Self::Attachment { header, data } => {
                header.name.len() + header.media_type.len() + data.len()
            }
            Self::Metadata(metadata) => metadata.name.len() + map(&metadata.metadata),
            Self::ChunkEnd => 0,
        };
        size_of::<Self>() + owned
    }
}

/// How messages are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packing {
    /// In the file itself.
    Bare,
    /// In chunks, with this compression.
    Chunks(Squeezing),
}

/// How chunks are compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Squeezing {
    None,
    Lz4,
    Zstd,
}

/// Why the records of a file cannot be read at all.
#[derive(Debug)]
pub(super) enum Unreadable {
    /// The system refused.
    Io(io::Error),
    /// It is no MCAP file.
    NotMcap,
    /// A record that no reader of ours takes.
    Records(String),
}

impl From<io::Error> for Unreadable {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// What is wrong with messages whose channel was lost.
const STRANGE: &str = "messages are of a channel that nothing describes any more";

/// A walk over the records of a file.
pub(super) struct Records<R> {
    from: R,
    /// Bytes of the file, and of it those that are read.
    n_bytes: u64,
    at: u64,
    record: Vec<u8>,
    queue: VecDeque<Event>,
    profile: String,
    packing: Option<Packing>,
    damage: Option<Damage>,
    is_at_end: bool,
    /// What the summary says of channels, for messages whose own was in a chunk that is lost, and channels that were read.
    promised: Vec<Event>,
    channels: BTreeSet<u16>,
    /// Whether anything behind the header was read.
    has_records: bool,
}

impl<R: Read + Seek> Records<R> {
    /// At the first record behind the header, of a file whose summary promises this.
    pub(super) fn open(mut from: R, promise: Option<&Promise>) -> Result<Self, Unreadable> {
        let n_bytes = from.seek(SeekFrom::End(0))?;
        from.seek(SeekFrom::Start(0))?;
        let mut magic = [0; mcap::MAGIC.len()];
        match from.read_exact(&mut magic) {
            Ok(()) if magic == *mcap::MAGIC => {}
            Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => return Err(error.into()),
            _ => return Err(Unreadable::NotMcap),
        }
        let mut records = Self {
            from,
            n_bytes,
            at: magic.len() as u64,
            record: Vec::new(),
            queue: VecDeque::new(),
            profile: String::new(),
            packing: None,
            damage: None,
            is_at_end: false,
            promised: promise.map(Promise::events).unwrap_or_default(),
            channels: BTreeSet::new(),
            has_records: false,
        };
        if let Some(opcode) = records.next_record()? {
            match parsed(opcode, &records.record) {
                Ok(Record::Header(header)) => records.profile = header.profile,
                _ => return Err(Unreadable::Records("it begins without a header".to_owned())),
            }
        }
        Ok(records)
    }

    /// What kind of bag it is, `ros2` for one of ROS 2.
    pub(super) fn profile(&self) -> &str {
        &self.profile
    }

    /// How messages are kept, as far as any was read.
    pub(super) fn packing(&self) -> Option<Packing> {
        self.packing
    }

    /// Where the file is not whole, if the walk came to an end there.
    pub(super) fn damage(&self) -> Option<&Damage> {
        self.damage.as_ref()
    }

    /// What comes next; none at the end of the data, or where the file is not whole.
    pub(super) fn next_event(&mut self) -> Result<Option<Event>, Unreadable> {
        loop {
            if let Some(event) = self.queue.pop_front() {
                return Ok(Some(event));
            }
            if self.is_at_end {
                return Ok(None);
            }
            let begin = self.at;
            let Some(opcode) = self.next_record()? else {
                if !self.is_at_end {
                    self.end_at(begin, "the file ends without the end of its data");
                }
                return Ok(None);
            };
            match opcode {
                op::CHUNK => self.unpack(begin)?,
                op::DATA_END => {
                    self.is_at_end = true;
                    self.walk_summary()?;
                }
                op::HEADER | op::FOOTER => {
                    self.end_at(begin, "the file ends without the end of its data");
                }
                _ => {
                    let event = event(opcode, &self.record, false);
                    match event {
                        Ok(Some(event)) if self.is_strange(&event) => {
                            self.end_at(begin, STRANGE);
                        }
                        Ok(Some(event)) => {
                            self.has_records = true;
                            self.know(&event);
                            if matches!(event, Event::Message { .. }) && self.packing.is_none() {
                                self.packing = Some(Packing::Bare);
                            }
                            self.queue.push_back(event);
                        }
                        Ok(None) => {}
                        Err(reason) => self.end_at(begin, &reason),
                    }
                }
            }
        }
    }

    /// The records of a chunk, all or none.
    fn unpack(&mut self, begin: u64) -> Result<(), Unreadable> {
        let read = match chunk(&self.record) {
            // Its name may be broken, where others before it are known.
            Err(Unreadable::Records(reason)) if self.packing.is_some() => Err(reason),
            read => read?,
        };
        match read {
            Ok((squeezing, events)) => {
                self.has_records = true;
                self.packing.get_or_insert(Packing::Chunks(squeezing));
                for event in &events {
                    self.know(event);
                }
                if events.iter().any(|event| self.is_strange(event)) {
                    self.lose(begin, STRANGE);
                    return Ok(());
                }
                self.queue.extend(events);
                self.queue.push_back(Event::ChunkEnd);
            }
            Err(reason) => self.lose(begin, &reason),
        }
        Ok(())
    }

    /// Leaves a chunk out, and goes on behind it. What the summary says of channels stands for those that it may have had.
    fn lose(&mut self, at_byte: u64, reason: &str) {
        self.damage_at(at_byte, reason).n_lost_chunks += 1;
        for event in std::mem::take(&mut self.promised) {
            self.know(&event);
            self.queue.push_back(event);
        }
    }

    fn know(&mut self, event: &Event) {
        if let Event::Channel(channel) = event {
            self.channels.insert(channel.id);
        }
    }

    /// Whether it is a message of a channel that was lost.
    fn is_strange(&self, event: &Event) -> bool {
        let is_known = |id: &u16| self.channels.contains(id);
        self.damage.is_some()
            && matches!(event, Event::Message { header, .. } if !is_known(&header.channel_id))
    }

    /// Behind the data only the summary may come, and the end.
    fn walk_summary(&mut self) -> Result<(), Unreadable> {
        let begin = self.at;
        while let Some(opcode) = self.next_record()? {
            if opcode == op::FOOTER {
                let mut magic = [0; mcap::MAGIC.len()];
                let is_whole = match self.from.read_exact(&mut magic) {
                    Ok(()) => magic == *mcap::MAGIC,
                    Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => false,
                    Err(error) => return Err(error.into()),
                };
                if !is_whole {
                    self.end_at(self.at, "the file ends without its magic bytes");
                }
                return Ok(());
            }
        }
        if self
            .damage
            .as_ref()
            .is_none_or(|it| it.ends_at_byte.is_none())
        {
            self.end_at(begin, "the file ends without its footer");
        }
        Ok(())
    }

    /// Nothing from here on is read.
    fn end_at(&mut self, at_byte: u64, reason: &str) {
        self.is_at_end = true;
        self.damage_at(at_byte, reason).ends_at_byte = Some(at_byte);
    }

    /// The first damage, which is this one if there was none before.
    fn damage_at(&mut self, at_byte: u64, reason: &str) -> &mut Damage {
        self.damage.get_or_insert_with(|| Damage {
            at_byte,
            reason: reason.to_owned(),
            n_lost_chunks: 0,
            ends_at_byte: None,
        })
    }

    /// Reads the next record whole; none at the end, or where less than a record is left.
    fn next_record(&mut self) -> Result<Option<u8>, Unreadable> {
        let begin = self.at;
        if begin == self.n_bytes {
            return Ok(None);
        }
        let mut head = [0; HEAD];
        let n_left = self.n_bytes - begin;
        if n_left < head.len() as u64 {
            self.end_at(begin, "the file ends within a record");
            return Ok(None);
        }
        self.from.read_exact(&mut head)?;
        let (opcode, length) = split(&head);
        if length > n_left - head.len() as u64 {
            self.end_at(begin, "the file ends within a record");
            return Ok(None);
        }
        if length > MAX_RECORD_BYTES {
            let reason = format!(
                "the record at byte {begin} has {length} bytes, more than the {MAX_RECORD_BYTES} that are read"
            );
            if !self.has_records {
                return Err(Unreadable::Records(reason));
            }
            self.end_at(begin, &reason);
            return Ok(None);
        }
        self.record.clear();
        let read = (&mut self.from)
            .take(length)
            .read_to_end(&mut self.record)?;
        self.at = begin + (HEAD + read) as u64;
        if (read as u64) < length {
            self.end_at(begin, "the file ends within a record");
            return Ok(None);
        }
        Ok(Some(opcode))
    }
}

/// What a record says, if it is one of those that are kept; indexes are made anew.
pub(super) fn event(opcode: u8, record: &[u8], is_in_chunk: bool) -> Result<Option<Event>, String> {
    let is_kept = matches!(
        opcode,
        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::ATTACHMENT | op::METADATA
    );
    if !is_kept {
        let own = (opcode >= 0x80).then(|| Event::Private {
            opcode,
            data: record.to_vec(),
            is_in_chunk,
        });
        return Ok(own);
    }
    Ok(match parsed(opcode, record)? {
        Record::Schema { header, data } => Some(Event::Schema {
            header,
            data: data.into_owned(),
        }),
        Record::Channel(channel) => Some(Event::Channel(channel)),
        Record::Message { header, data } => Some(Event::Message {
            header,
            data: data.into_owned(),
        }),
        Record::Attachment { header, data, .. } => Some(Event::Attachment {
            header,
            data: data.into_owned(),
        }),
        Record::Metadata(metadata) => Some(Event::Metadata(metadata)),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_event_counts_with_all_that_it_owns() {
        let text = || "x".repeat(1000);
        let metadata = BTreeMap::from([(text(), text())]);
        let channel = Channel {
            id: 1,
            schema_id: 1,
            topic: text(),
            message_encoding: text(),
            metadata: metadata.clone(),
        };
        let header = SchemaHeader {
            id: 1,
            name: text(),
            encoding: text(),
        };
        let data = vec![0; 1000];
        let name = text();
        let private = Event::Private {
            opcode: 0x91,
            data: data.clone(),
            is_in_chunk: false,
        };
        for (event, n_owned) in [
            (Event::Schema { header, data }, 3000),
            (Event::Channel(channel), 4000),
            (Event::Metadata(Metadata { name, metadata }), 3000),
            (private, 1000),
            (Event::ChunkEnd, 0),
        ] {
            let least = n_owned + size_of::<Event>();
            let n_bytes = event.n_bytes();
            assert!((least..least + 100).contains(&n_bytes), "{n_bytes} bytes");
        }
    }
}
