//! The bag that is written: records as they were, with their numbers, and the topics that are added.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufWriter, Seek, Write};
use std::path::PathBuf;

use mcap::records::{Channel, MessageHeader, Metadata};
use mcap::write::PrivateRecordOptions;
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};
use starbreak_dataset::DatasetError;

use super::records::{Event, Packing, Squeezing};
use super::survey::Survey;
use super::{Added, Bag};
use crate::Error;
use crate::bag_error::BagError;

/// Bytes that are written at once.
const WRITE_BYTES: usize = 1 << 20;

/// The fields of `sensor_msgs/msg/Image`, for bags that have none of it.
const IMAGE_SCHEMA: &str = "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n\
uint32 step\nuint8[] data\n\
================================================================================\n\
MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
================================================================================\n\
MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

/// The field of `std_msgs/msg/String`.
const STRING_SCHEMA: &str = "string data\n";

/// What is written next.
pub(super) enum Outgoing {
    /// As it came, or with other pixels.
    Kept(Event),
    /// On a topic of ours.
    Added {
        /// Which camera, and which of its topics.
        topic: (usize, Added),
        /// The message of the camera, whose sequence and times it gets.
        like: MessageHeader,
        data: Vec<u8>,
    },
}

/// A bag on its way to the disk.
pub(super) struct BagWriter<W: Write + Seek> {
    writer: Writer<BufWriter<W>>,
    input: PathBuf,
    output: PathBuf,
    is_chunked: bool,
    /// Which camera a topic is, and what it gets.
    cameras: BTreeMap<String, (usize, Vec<Added>)>,
    /// Channels of ours.
    channels: BTreeMap<(usize, Added), u16>,
    /// Schemas of ours by their name.
    schemas: BTreeMap<&'static str, u16>,
    /// Numbers that no channel and no schema of the bag has, the largest last.
    free: Vec<u16>,
    /// Numbers of the channels and of the schemas that were written.
    written: [BTreeSet<u16>; 2],
}

impl<W: Write + Seek> BagWriter<W> {
    /// With the profile of a bag and its messages kept as they are there.
    pub(super) fn new(to: W, bag: &Bag) -> Result<Self, Error> {
        let (is_chunked, compression) = match bag.survey.packing {
            Packing::Bare => (false, None),
            Packing::Chunks(Squeezing::None) => (true, None),
            Packing::Chunks(Squeezing::Lz4) => (true, Some(Compression::Lz4)),
            Packing::Chunks(Squeezing::Zstd) => (true, Some(Compression::Zstd)),
        };
        let options = WriteOptions::new()
            .profile(&bag.survey.profile)
            .library(concat!("starbreak ", env!("CARGO_PKG_VERSION")))
            .compression(compression)
            .use_chunks(is_chunked)
            // Chunks end where those of the bag do.
            .chunk_size(None)
            // The bytes do not depend on the number of processors.
            .compression_threads(0);
        let (input, output) = (bag.request.input.clone(), bag.request.output.clone());
        let writer = options
            .create(BufWriter::with_capacity(WRITE_BYTES, to))
            .map_err(|error| failed((&input, &output), error))?;
        let cameras = bag.cameras.iter().enumerate();
        // A channel for each topic, and the schemas of images and of texts.
        let n_ours = bag.cameras.len() * bag.request.added.len() + 2;
        let free = (1..=u16::MAX).rev().filter(|id| bag.survey.is_free(*id));
        let mut free: Vec<u16> = free.take(n_ours).collect();
        free.reverse();
        Ok(Self {
            writer,
            input,
            output,
            is_chunked,
            cameras: cameras
                .map(|(idx, camera)| (camera.topic.clone(), (idx, camera.added.clone())))
                .collect(),
            channels: BTreeMap::new(),
            schemas: BTreeMap::new(),
            free,
            written: Default::default(),
        })
    }

    pub(super) fn write(&mut self, next: Outgoing) -> Result<(), Error> {
        let written = match next {
            Outgoing::Kept(event) => self.keep(event),
            Outgoing::Added { topic, like, data } => match self.channels.get(&topic) {
                Some(id) => {
                    let header = MessageHeader {
                        channel_id: *id,
                        ..like
                    };
                    self.writer.write_to_known_channel(&header, &data)
                }
                None => Ok(()),
            },
        };
        written.map_err(|error| self.failed(error))
    }

    /// Schemas and channels that only the summary has: those of topics without messages, as rosbag2 writes them.
    pub(super) fn silent(&mut self, survey: &Survey) -> Result<(), Error> {
        let Some(promise) = &survey.promise else {
            return Ok(());
        };
        for event in promise.events() {
            let is_written = match &event {
                Event::Schema { header, .. } => self.written[1].contains(&header.id),
                Event::Channel(channel) => self.written[0].contains(&channel.id),
                _ => false,
            };
            if !is_written {
                self.write(Outgoing::Kept(event))?;
            }
        }
        Ok(())
    }

    /// A metadata record behind everything so far.
    pub(super) fn metadata(&mut self, metadata: Metadata) -> Result<(), Error> {
        let written = self.writer.write_metadata(&metadata);
        written.map_err(|error| self.failed(error))
    }

    /// The summary and the end.
    pub(super) fn finish(mut self) -> Result<(), Error> {
        let finished = self.writer.finish();
        finished.map_err(|error| self.failed(error))?;
        let mut file = self.writer.into_inner();
        file.flush().map_err(|source| {
            let path = self.output;
            Error::from(DatasetError::Write { path, source })
        })
    }

    fn failed(&self, error: McapError) -> Error {
        failed((&self.input, &self.output), error)
    }

    fn keep(&mut self, event: Event) -> Result<(), McapError> {
        match event {
            Event::Schema { header, data } => {
                self.writer
                    .add_schema_with_id(header.id, &header.name, &header.encoding, &data)?;
                self.written[1].insert(header.id);
            }
            Event::Channel(channel) => {
                self.add(&channel, channel.id)?;
                self.written[0].insert(channel.id);
                self.add_ours(&channel)?;
            }
            Event::Message { header, data } => {
                self.writer.write_to_known_channel(&header, &data)?;
            }
            Event::Attachment { header, data } => self.writer.attach(&Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name,
                media_type: header.media_type,
                data: Cow::Owned(data),
            })?,
            Event::Metadata(metadata) => self.writer.write_metadata(&metadata)?,
            Event::Private {
                opcode,
                data,
                is_in_chunk,
            } => {
                let options = match is_in_chunk {
                    true => PrivateRecordOptions::IncludeInChunks.into(),
                    false => Default::default(),
                };
                self.writer.write_private_record(opcode, &data, options)?;
            }
            Event::ChunkEnd if self.is_chunked => self.writer.flush()?,
            Event::ChunkEnd => {}
        }
        Ok(())
    }

    fn add(&mut self, channel: &Channel, id: u16) -> Result<(), McapError> {
        let Channel {
            schema_id, topic, ..
        } = channel;
        let encoding = &channel.message_encoding;
        self.writer
            .add_channel_with_id(id, *schema_id, topic, encoding, &channel.metadata)?;
        Ok(())
    }

    /// The topics that a camera gets, with the quality of service of its own.
    fn add_ours(&mut self, camera: &Channel) -> Result<(), McapError> {
        let Some((idx, added)) = self.cameras.get(&camera.topic).cloned() else {
            return Ok(());
        };
        let quality = |key: &String| key == "offered_qos_profiles";
        for one in added {
            if self.channels.contains_key(&(idx, one)) {
                continue;
            }
            let id = self.free_id()?;
            let mut channel = Channel {
                topic: one.topic(&camera.topic),
                ..camera.clone()
            };
            let schema = match one {
                Added::Region => Some(("sensor_msgs/msg/Image", IMAGE_SCHEMA)),
                Added::Track => Some(("std_msgs/msg/String", STRING_SCHEMA)),
                Added::Control => None,
            };
            if let Some((name, fields)) = schema {
                channel.schema_id = self.schema(name, fields)?;
                channel.message_encoding = "cdr".to_owned();
                channel.metadata.retain(|key, _| quality(key));
            }
            self.add(&channel, id)?;
            self.channels.insert((idx, one), id);
        }
        Ok(())
    }

    /// The number of a schema of ours.
    fn schema(&mut self, name: &'static str, fields: &str) -> Result<u16, McapError> {
        if let Some(id) = self.schemas.get(name) {
            return Ok(*id);
        }
        let id = self.free_id()?;
        self.writer
            .add_schema_with_id(id, name, "ros2msg", fields.as_bytes())?;
        self.schemas.insert(name, id);
        Ok(id)
    }

    fn free_id(&mut self) -> Result<u16, McapError> {
        self.free.pop().ok_or(McapError::TooManyChannels)
    }
}

/// What was refused: by the system, or because the records of the input contradict each other.
fn failed((input, output): (&PathBuf, &PathBuf), error: McapError) -> Error {
    match error {
        McapError::Io(source) => DatasetError::Write {
            path: output.clone(),
            source,
        }
        .into(),
        error => BagError::Records {
            path: input.clone(),
            reason: error.to_string().escape_debug().to_string(),
        }
        .into(),
    }
}
