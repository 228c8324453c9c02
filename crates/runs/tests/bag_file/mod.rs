//! Bags and messages written here, by another hand than the one that is tested, and records read by the library's own
//! reader.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

pub(crate) mod suite;

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use mcap::records::{MessageHeader, Metadata, Record};
use mcap::{Attachment, WriteOptions, Writer};
use starbreak::{Assignment, Recipe, Seed};
use starbreak_runs::bag::{Added, Bag, BagReport, BagRequest, CameraRequest, ImpactAt};
use starbreak_runs::clip::{Growth, Light};
use starbreak_runs::{Error, RunContext, with_threads};
use tempfile::TempDir;

pub(crate) const WIDTH: u32 = 48;
pub(crate) const HEIGHT: u32 = 32;

/// A message in CDR, field by field.
pub(crate) struct Cdr {
    pub(crate) bytes: Vec<u8>,
    is_big: bool,
}

impl Cdr {
    pub(crate) fn new(is_big: bool) -> Self {
        Self {
            bytes: vec![0, u8::from(!is_big), 0, 0],
            is_big,
        }
    }

    pub(crate) fn u8(mut self, value: u8) -> Self {
        self.bytes.push(value);
        self
    }

    pub(crate) fn u32(mut self, value: u32) -> Self {
        while !self.bytes.len().is_multiple_of(4) {
            self.bytes.push(0);
        }
        let bytes = if self.is_big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        };
        self.bytes.extend(bytes);
        self
    }

    pub(crate) fn data(mut self, data: &[u8]) -> Self {
        self = self.u32(u32::try_from(data.len()).unwrap());
        self.bytes.extend(data);
        self
    }

    pub(crate) fn text(self, text: &str) -> Self {
        self.data(format!("{text}\0").as_bytes())
    }

    pub(crate) fn header(self, stamp_ns: u64, frame_id: &str) -> Self {
        self.u32(u32::try_from(stamp_ns / 1_000_000_000).unwrap())
            .u32(u32::try_from(stamp_ns % 1_000_000_000).unwrap())
            .text(frame_id)
    }
}

/// Pixels that are nowhere flat, with so many channels; bytes of `filler` behind each row.
pub(crate) fn rows(n_channels: u32, filler: usize) -> Vec<u8> {
    let mut data = Vec::new();
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            for channel in 0..n_channels {
                let wave = x * 7 + y * 5 + channel * 31 + (x * y * 3) % 60;
                data.push(u8::try_from(60 + wave % 160).unwrap());
            }
        }
        data.extend((0..filler).map(|k| u8::try_from(200 + k).unwrap()));
    }
    data
}

/// `sensor_msgs/msg/Image`.
pub(crate) fn raw(is_big: bool, stamp_ns: u64, encoding: &str, filler: u32) -> Vec<u8> {
    let n_channels = match encoding {
        "mono8" => 1,
        "rgba8" | "bgra8" => 4,
        _ => 3,
    };
    Cdr::new(is_big)
        .header(stamp_ns, "camera")
        .u32(HEIGHT)
        .u32(WIDTH)
        .text(encoding)
        .u8(0)
        .u32(WIDTH * n_channels + filler)
        .data(&rows(n_channels, filler as usize))
        .bytes
}

/// `sensor_msgs/msg/CompressedImage`.
pub(crate) fn compressed(is_big: bool, stamp_ns: u64, format: &str, file: &[u8]) -> Vec<u8> {
    Cdr::new(is_big)
        .header(stamp_ns, "camera")
        .text(format)
        .data(file)
        .bytes
}

/// An image file of the same pixels.
pub(crate) fn file(is_jpeg: bool) -> Vec<u8> {
    let image = image::RgbImage::from_raw(WIDTH, HEIGHT, rows(3, 0)).unwrap();
    let encoding = match is_jpeg {
        true => starbreak_dataset::Encoding::Jpeg {
            quality: starbreak_dataset::JpegQuality::new(90).unwrap(),
        },
        false => starbreak_dataset::Encoding::Png,
    };
    starbreak_dataset::encode_image(&image.into(), &encoding, None).unwrap()
}

/// A bag that is being written.
pub(crate) struct BagFile {
    writer: Writer<Cursor<Vec<u8>>>,
    n_messages: u32,
}

pub(crate) const IMAGE: &str = "sensor_msgs/msg/Image";
pub(crate) const COMPRESSED: &str = "sensor_msgs/msg/CompressedImage";

impl BagFile {
    pub(crate) fn new(options: WriteOptions) -> Self {
        let options = options.profile("ros2").library("the tests");
        Self {
            writer: options.create(Cursor::new(Vec::new())).unwrap(),
            n_messages: 0,
        }
    }

    pub(crate) fn topic(&mut self, topic: &str, schema: &str) -> u16 {
        let schema = self
            .writer
            .add_schema(schema, "ros2msg", format!("# {schema}").as_bytes())
            .unwrap();
        let quality =
            BTreeMap::from([("offered_qos_profiles".to_owned(), "- depth: 5".to_owned())]);
        self.writer
            .add_channel(schema, topic, "cdr", &quality)
            .unwrap()
    }

    pub(crate) fn message(&mut self, channel_id: u16, time: u64, data: &[u8]) {
        let header = MessageHeader {
            channel_id,
            sequence: self.n_messages * 3,
            log_time: time + 5,
            publish_time: time + 2,
        };
        self.n_messages += 1;
        self.writer.write_to_known_channel(&header, data).unwrap();
    }

    pub(crate) fn attachment(&mut self, name: &str) {
        self.writer
            .attach(&Attachment {
                log_time: 3,
                create_time: 4,
                name: name.to_owned(),
                media_type: "text/plain".to_owned(),
                data: name.as_bytes().into(),
            })
            .unwrap();
    }

    pub(crate) fn metadata(&mut self, name: &str) {
        self.writer
            .write_metadata(&Metadata {
                name: name.to_owned(),
                metadata: BTreeMap::from([("a".to_owned(), name.to_owned())]),
            })
            .unwrap();
    }

    pub(crate) fn private(&mut self, data: &[u8]) {
        self.writer
            .write_private_record(0x91, data, Default::default())
            .unwrap();
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.writer.finish().unwrap();
        self.writer.into_inner().into_inner()
    }
}

/// All ways to keep messages.
pub(crate) fn packings() -> [(&'static str, WriteOptions); 5] {
    let options = || WriteOptions::new().compression(None);
    [
        ("bare", options().use_chunks(false)),
        ("chunks", options().chunk_size(Some(4000))),
        (
            "lz4",
            options()
                .chunk_size(Some(4000))
                .compression(Some(mcap::Compression::Lz4)),
        ),
        (
            "zstd",
            options()
                .chunk_size(Some(4000))
                .compression(Some(mcap::Compression::Zstd)),
        ),
        (
            "without a summary",
            options()
                .chunk_size(Some(4000))
                .emit_summary_records(false)
                .emit_summary_offsets(false),
        ),
    ]
}

/// A bag with four cameras, other topics between them, two schemas that none has, attachments and metadata.
pub(crate) fn drive(options: WriteOptions, n_rounds: u64) -> Vec<u8> {
    let mut bag = BagFile::new(options);
    bag.metadata("rosbag2");
    let front = bag.topic("/front/image_raw", IMAGE);
    let rear = bag.topic("/rear/image_raw", IMAGE);
    let left = bag.topic("/left/compressed", COMPRESSED);
    let right = bag.topic("/right/compressed", COMPRESSED);
    let imu = bag.topic("/imu", "sensor_msgs/msg/Imu");
    let _ = bag.topic("/silent", "std_msgs/msg/String");
    let (jpeg, png) = (file(true), file(false));
    for k in 0..n_rounds {
        let time = 1_700_000_000_000_000_000 + k * 100_000_000;
        bag.message(imu, time, &Cdr::new(false).header(time, "imu").u32(7).bytes);
        bag.message(front, time + 1, &raw(false, time, "rgb8", 0));
        bag.message(left, time + 3, &compressed(false, time, "jpeg", &jpeg));
        if k == 1 {
            bag.attachment("calibration.txt");
        }
        bag.message(imu, time, &[1, 2, 3]);
        bag.message(rear, time + 2, &raw(true, time + 20_000_000, "bgra8", 5));
        bag.message(
            right,
            time + 4,
            &compressed(true, time, "rgb8; png compressed", &png),
        );
        if k == 2 {
            bag.metadata("notes");
            bag.private(b"of another program");
        }
    }
    bag.finish()
}

/// The kinds and places of the records of a bag that lie in the file itself.
pub(crate) fn places(bag: &[u8]) -> Vec<(u8, usize)> {
    let mut places = Vec::new();
    let mut at = mcap::MAGIC.len();
    while at + 9 < bag.len() {
        places.push((bag[at], at));
        let length = u64::from_le_bytes(bag[at + 1..at + 9].try_into().unwrap());
        at += 9 + usize::try_from(length).unwrap();
    }
    places
}

/// A bag whose summary has one more channel that neither its data nor its statistics have, as the writer of rosbag2
/// leaves topics without messages. The bag has no offsets in its summary.
pub(crate) fn silent(bag: &[u8], id: u16, topic: &str, schema: &str) -> Vec<u8> {
    let text = |text: &str| {
        let length = u32::try_from(text.len()).unwrap();
        [&length.to_le_bytes()[..], text.as_bytes()].concat()
    };
    let record = |opcode: u8, content: Vec<u8>| {
        let length = content.len() as u64;
        [&[opcode][..], &length.to_le_bytes(), &content].concat()
    };
    let id = id.to_le_bytes();
    let schema = [&id[..], &text(schema), &text("ros2msg"), &text("# none")].concat();
    let channel = [&id[..], &id, &text(topic), &text("cdr"), &text("")].concat();
    let more = [record(0x03, schema), record(0x04, channel)].concat();
    let footer = bag.len() - mcap::MAGIC.len() - 20;
    let begin = u64::from_le_bytes(bag[footer..footer + 8].try_into().unwrap());
    let begin = usize::try_from(begin).unwrap();
    let mut bag = bag.to_vec();
    // Without a checksum.
    bag[footer + 16..footer + 20].fill(0);
    bag.splice(begin..begin, more);
    bag
}

/// What stands in a bag: records in their order, but those that say where others are; and its schemas and channels.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Content {
    pub(crate) profile: String,
    pub(crate) schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    pub(crate) channels: BTreeMap<u16, (String, u16, String, BTreeMap<String, String>)>,
    pub(crate) records: Vec<Kept>,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kept {
    Message(MessageHeader, Vec<u8>),
    Attachment(mcap::records::AttachmentHeader, Vec<u8>),
    Metadata(Metadata),
    Private(u8, Vec<u8>),
}

impl Content {
    /// By the reader of the MCAP library, which checks magic bytes and checksums.
    pub(crate) fn of(bytes: &[u8]) -> Self {
        let mut content = Self::default();
        let mut is_summary = false;
        for record in mcap::read::ChunkFlattener::new(bytes).unwrap() {
            match record.unwrap() {
                Record::Header(header) => content.profile = header.profile,
                Record::Schema { header, data } => {
                    let schema = (header.name, header.encoding, data.into_owned());
                    content.schemas.insert(header.id, schema);
                }
                Record::Channel(it) => {
                    let channel = (it.topic, it.schema_id, it.message_encoding, it.metadata);
                    content.channels.insert(it.id, channel);
                }
                Record::Message { header, data } => {
                    content
                        .records
                        .push(Kept::Message(header, data.into_owned()));
                }
                Record::Attachment { header, data, .. } => {
                    content
                        .records
                        .push(Kept::Attachment(header, data.into_owned()));
                }
                Record::Metadata(metadata) => content.records.push(Kept::Metadata(metadata)),
                Record::DataEnd(_) => is_summary = true,
                Record::Unknown { opcode, data } if !is_summary => {
                    content
                        .records
                        .push(Kept::Private(opcode, data.into_owned()));
                }
                _ => {}
            }
        }
        content
    }

    /// Without what says how the bag was made.
    pub(crate) fn without_provenance(mut self) -> Self {
        let last = self.records.pop();
        let is_ours = matches!(&last, Some(Kept::Metadata(it)) if it.name == "starbreak");
        assert!(is_ours, "the last record is {last:?}");
        self
    }

    pub(crate) fn topic(&self, id: u16) -> &str {
        &self.channels[&id].0
    }

    /// Messages of a topic.
    pub(crate) fn messages(&self, topic: &str) -> Vec<(MessageHeader, Vec<u8>)> {
        let records = self.records.iter();
        records
            .filter_map(|record| match record {
                Kept::Message(header, data) if self.topic(header.channel_id) == topic => {
                    Some((*header, data.clone()))
                }
                _ => None,
            })
            .collect()
    }

    /// The record of what was done.
    pub(crate) fn provenance(&self) -> &BTreeMap<String, String> {
        match self.records.last() {
            Some(Kept::Metadata(it)) if it.name == "starbreak" => &it.metadata,
            last => panic!("the last record is {last:?}"),
        }
    }
}

/// A crack of the paper's model that fits the small pictures and leaves a part of them as they are.
pub(crate) const SMALL: [&str; 4] = [
    "fracture.particles=300",
    "fracture.neighbour_radius_px=12",
    "impact.position=[0.2,0.4]",
    "impact.direction_deg=20",
];

pub(crate) fn context(preset: &str, set: &[&str], seed: u64) -> RunContext {
    let mut recipe = Recipe::preset(preset).unwrap();
    let set: Vec<Assignment> = set
        .iter()
        .map(|it| Assignment::parse(it).unwrap())
        .collect();
    recipe.adjust(None, &set).unwrap();
    RunContext::new(&recipe, Seed(seed), Path::new(".")).unwrap()
}

pub(crate) fn small(seed: u64) -> RunContext {
    context("paper", &SMALL, seed)
}

/// A recipe that changes nothing.
pub(crate) fn nothing() -> RunContext {
    let recipe = Recipe::parse("nothing", "schema = 1\n[fracture]\nmodel = \"none\"\n").unwrap();
    RunContext::new(&recipe, Seed(0), Path::new(".")).unwrap()
}

/// A folder with a bag.
pub(crate) struct Folder {
    pub(crate) dir: TempDir,
}

impl Folder {
    pub(crate) fn with(bag: &[u8]) -> Self {
        let folder = Self {
            dir: tempfile::tempdir().unwrap(),
        };
        fs::write(folder.at("in.mcap"), bag).unwrap();
        folder
    }

    pub(crate) fn at(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    /// All cameras by one recipe.
    pub(crate) fn request(&self, context: RunContext) -> BagRequest {
        BagRequest {
            input: self.at("in.mcap"),
            output: self.at("out.mcap"),
            cameras: Vec::new(),
            all: Some(context),
            impact_at: ImpactAt::AfterFirst(0.0),
            growth: Growth::Whole,
            light: Light::Follow,
            added: Vec::new(),
            replaces: true,
        }
    }

    /// One camera.
    pub(crate) fn request_of(&self, topic: &str, context: RunContext) -> BagRequest {
        let cameras = vec![CameraRequest {
            topic: topic.to_owned(),
            context: context.clone(),
        }];
        BagRequest {
            cameras,
            all: None,
            ..self.request(context)
        }
    }

    pub(crate) fn run(&self, request: BagRequest, n_threads: usize) -> Result<BagReport, Error> {
        let bag = Bag::open(request)?;
        let stop = AtomicBool::new(false);
        let report = with_threads(n_threads, || bag.run(&stop, || ()))??;
        Ok(report.unwrap())
    }

    pub(crate) fn output(&self) -> Content {
        Content::of(&fs::read(self.at("out.mcap")).unwrap())
    }

    /// The refusal of a request, after which nothing was written.
    pub(crate) fn refusal(&self, request: BagRequest) -> String {
        let before = fs::read(self.at("in.mcap")).unwrap();
        let message = match self.run(request, 2) {
            Ok(report) => panic!("not refused: {report:?}"),
            Err(error) => error.to_string(),
        };
        let names: Vec<_> = (fs::read_dir(self.dir.path()).unwrap())
            .map(|entry| entry.unwrap().file_name())
            .collect();
        assert_eq!(names, ["in.mcap"], "{message}");
        assert_eq!(fs::read(self.at("in.mcap")).unwrap(), before, "{message}");
        message
    }
}

pub(crate) const MASKS: [Added; 2] = [Added::Region, Added::Track];

/// Where the data of one of our messages begin: they are its last bytes.
pub(crate) fn data_at(message: &[u8]) -> usize {
    let is_big = message[1] == 0;
    (8..message.len())
        .step_by(4)
        .find(|at| {
            let told = message[at - 4..*at].try_into().unwrap();
            let told = if is_big {
                u32::from_be_bytes(told)
            } else {
                u32::from_le_bytes(told)
            };
            told as usize == message.len() - at && told > 16
        })
        .unwrap()
}

/// The stamp of a message, ns.
pub(crate) fn stamp_of(message: &[u8]) -> u64 {
    let is_big = message[1] == 0;
    let number = |at: usize| {
        let bytes = message[at..at + 4].try_into().unwrap();
        u64::from(if is_big {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        })
    };
    number(4) * 1_000_000_000 + number(8)
}
