//! The files of the conformance suite of MCAP (`tests/conformance/data` of its repository), written byte by byte: six
//! contents, each with and without chunks, indexes, repeated schemas and channels, statistics, offsets, and bytes behind
//! the fields that a later version may add. That they are those files a test proves by their SHA-256.

/// A choice of the suite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Choice {
    Chunks,
    MessageIndexes,
    Statistics,
    Schemas,
    Channels,
    AttachmentIndexes,
    MetadataIndexes,
    ChunkIndexes,
    Offsets,
    Extra,
}

use Choice::{
    AttachmentIndexes, Channels, ChunkIndexes, Chunks, Extra, MessageIndexes, MetadataIndexes,
    Offsets, Schemas, Statistics,
};

/// What a bag of the suite has: its name, numbers of messages, attachments and metadata, whether messages have a
/// schema, and which choices make sense.
pub(crate) const CONTENTS: [(&str, [u32; 3], bool, &[Choice]); 6] = [
    ("NoData", [0, 0, 0], false, &[Statistics, Offsets, Extra]),
    (
        "OneMessage",
        [1, 0, 0],
        true,
        &[
            Chunks,
            MessageIndexes,
            Statistics,
            Schemas,
            Channels,
            ChunkIndexes,
            Offsets,
            Extra,
        ],
    ),
    (
        "OneSchemalessMessage",
        [1, 0, 0],
        false,
        &[
            Chunks,
            MessageIndexes,
            Statistics,
            Channels,
            ChunkIndexes,
            Offsets,
            Extra,
        ],
    ),
    (
        "TenMessages",
        [10, 0, 0],
        true,
        &[
            Chunks,
            MessageIndexes,
            Statistics,
            Schemas,
            Channels,
            ChunkIndexes,
            Offsets,
            Extra,
        ],
    ),
    (
        "OneAttachment",
        [0, 1, 0],
        false,
        &[Statistics, AttachmentIndexes, Offsets, Extra],
    ),
    (
        "OneMetadata",
        [0, 0, 1],
        false,
        &[Statistics, MetadataIndexes, Offsets, Extra],
    ),
];

/// All subsets of some choices that can be had together.
pub(crate) fn subsets(choices: &[Choice]) -> Vec<Vec<Choice>> {
    let all = (0..1_u32 << choices.len()).map(|bits| {
        let chosen = choices
            .iter()
            .enumerate()
            .filter(|(k, _)| bits >> k & 1 == 1);
        chosen.map(|(_, choice)| *choice).collect::<Vec<_>>()
    });
    let of_summary = |choice: &Choice| !matches!(choice, Chunks | MessageIndexes | Offsets | Extra);
    all.filter(|chosen| {
        let has = |choice: Choice| chosen.contains(&choice);
        // Indexes of chunks and of messages in them need chunks, and offsets a summary.
        (has(Chunks) || !(has(MessageIndexes) || has(ChunkIndexes)))
            && (!has(Offsets) || chosen.iter().any(of_summary))
    })
    .collect()
}

/// Content of a record, field by field.
#[derive(Default)]
struct Fields(Vec<u8>);

impl Fields {
    fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.extend(bytes);
        self
    }

    fn u16(self, value: u16) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    fn u32(self, value: u32) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    fn u64(self, value: u64) -> Self {
        self.bytes(&value.to_le_bytes())
    }

    fn sized(self, bytes: &[u8]) -> Self {
        self.u32(u32::try_from(bytes.len()).unwrap()).bytes(bytes)
    }

    fn text(self, text: &str) -> Self {
        self.sized(text.as_bytes())
    }

    fn map(self, pairs: &[[&str; 2]]) -> Self {
        let fields = Self::default();
        let fields = (pairs.iter()).fold(fields, |it, [key, value]| it.text(key).text(value));
        self.sized(&fields.0)
    }
}

/// Records one after the other.
struct Records {
    bytes: Vec<u8>,
    has_extra: bool,
}

impl Records {
    fn add(&mut self, opcode: u8, fields: Fields) -> (u64, u64) {
        // Messages and chunks end with their data; the end of the data and the footer have a fixed length.
        let extra: &[u8] = match (self.has_extra, opcode) {
            (true, opcode) if ![0x02, 0x05, 0x06, 0x0f].contains(&opcode) => &[0x01, 0xff, 0xff],
            _ => &[],
        };
        let at = self.bytes.len() as u64;
        self.bytes.push(opcode);
        let length = fields.0.len() + extra.len();
        self.bytes.extend((length as u64).to_le_bytes());
        self.bytes.extend(fields.0);
        self.bytes.extend(extra);
        (at, self.bytes.len() as u64 - at)
    }
}

fn schema() -> Fields {
    Fields::default()
        .u16(1)
        .text("Example")
        .text("c")
        .sized(&[4, 5, 6])
}

fn channel(has_schema: bool) -> Fields {
    let fields = Fields::default()
        .u16(1)
        .u16(u16::from(has_schema))
        .text("example");
    match has_schema {
        true => fields.text("a").map(&[["foo", "bar"]]),
        false => fields.text("text").map(&[]),
    }
}

/// When each message was logged and published, and its sequence.
fn messages(n_messages: u32) -> Vec<(u64, u64, u32)> {
    match n_messages {
        1 => vec![(2, 1, 10)],
        n => ([0, 2, 1, 3, 3, 5, 4, 7, 8, 9].into_iter().zip(0..n))
            .map(|(time, sequence)| (time, time, sequence))
            .collect(),
    }
}

/// A bag with one content and these choices.
pub(crate) fn bag(
    [n_messages, n_attachments, n_metadata]: [u32; 3],
    has_schema: bool,
    chosen: &[Choice],
) -> Vec<u8> {
    let has = |choice| chosen.contains(&choice);
    let mut file = Records {
        bytes: mcap::MAGIC.to_vec(),
        has_extra: has(Extra),
    };
    file.add(0x01, Fields::default().text("").text(""));
    let messages = messages(n_messages);
    let logged = messages.iter().map(|(logged, ..)| *logged);
    let [first, last] = [logged.clone().min(), logged.max()].map(Option::unwrap_or_default);
    let mut chunk_index = None;
    if n_messages > 0 {
        let mut inner = Records {
            bytes: Vec::new(),
            // Records in a chunk have none.
            has_extra: has(Extra) && !has(Chunks),
        };
        if has_schema {
            inner.add(0x03, schema());
        }
        inner.add(0x04, channel(has_schema));
        let mut places = Fields::default();
        for (logged, published, sequence) in messages {
            let message = Fields::default().u16(1).u32(sequence);
            let message = message.u64(logged).u64(published).bytes(&[1, 2, 3]);
            let (at, _) = inner.add(0x05, message);
            places = places.u64(logged).u64(at);
        }
        if has(Chunks) {
            let n_bytes = inner.bytes.len() as u64;
            let head = Fields::default().u64(first).u64(last).u64(n_bytes);
            let head = head
                .u32(crc32fast::hash(&inner.bytes))
                .text("")
                .u64(n_bytes);
            let (at, length) = file.add(0x06, head.bytes(&inner.bytes));
            let mut offsets = Fields::default();
            let mut index_length = 0;
            if has(MessageIndexes) {
                let index = Fields::default().u16(1).sized(&places.0);
                let (at, length) = file.add(0x07, index);
                offsets = offsets.u16(1).u64(at);
                index_length = length;
            }
            let index = Fields::default().u64(first).u64(last).u64(at).u64(length);
            let index = index.sized(&offsets.0).u64(index_length).text("");
            chunk_index = Some(index.u64(n_bytes).u64(n_bytes));
        } else {
            file.bytes.extend(inner.bytes);
        }
    }
    let mut attachment_index = None;
    if n_attachments > 0 {
        let head = |fields: Fields| fields.u64(2).u64(1);
        let fields = head(Fields::default())
            .text("myFile")
            .text("application/octet-stream");
        let fields = fields.u64(3).bytes(&[1, 2, 3]);
        let crc = crc32fast::hash(&fields.0);
        let (at, length) = file.add(0x09, fields.u32(crc));
        let index = head(Fields::default().u64(at).u64(length)).u64(3);
        attachment_index = Some(index.text("myFile").text("application/octet-stream"));
    }
    let mut metadata_index = None;
    if n_metadata > 0 {
        let metadata = Fields::default().text("myMetadata").map(&[["foo", "bar"]]);
        let (at, length) = file.add(0x0c, metadata);
        metadata_index = Some(Fields::default().u64(at).u64(length).text("myMetadata"));
    }
    let crc = crc32fast::hash(&file.bytes);
    file.add(0x0f, Fields::default().u32(crc));
    let summary_at = file.bytes.len();
    let mut groups = Vec::new();
    let counts = match n_messages {
        0 => Fields::default(),
        n => Fields::default().u16(1).u64(u64::from(n)),
    };
    let statistics = Fields::default()
        .u64(u64::from(n_messages))
        .u16(u16::from(has_schema))
        .u32(u32::from(n_messages > 0))
        .u32(n_attachments)
        .u32(n_metadata)
        .u32(u32::from(chunk_index.is_some()))
        .u64(first)
        .u64(last)
        .sized(&counts.0);
    for (choice, opcode, fields) in [
        (Schemas, 0x03, has_schema.then(schema)),
        (
            Channels,
            0x04,
            (n_messages > 0).then(|| channel(has_schema)),
        ),
        (Statistics, 0x0b, Some(statistics)),
        (MetadataIndexes, 0x0d, metadata_index),
        (AttachmentIndexes, 0x0a, attachment_index),
        (ChunkIndexes, 0x08, chunk_index),
    ] {
        if let Some(fields) = fields.filter(|_| has(choice)) {
            groups.push((opcode, file.add(opcode, fields)));
        }
    }
    let offsets_at = file.bytes.len() as u64;
    if has(Offsets) {
        for (opcode, (at, length)) in &groups {
            let offset = Fields::default().bytes(&[*opcode]).u64(*at);
            file.add(0x0e, offset.u64(*length));
        }
    }
    let [summary, offsets] = [
        (!groups.is_empty(), summary_at as u64),
        (has(Offsets), offsets_at),
    ]
    .map(|(is_there, at)| if is_there { at } else { 0 });
    // All of the summary and the footer before its last field.
    file.bytes.push(0x02);
    file.bytes.extend(20_u64.to_le_bytes());
    file.bytes
        .extend(Fields::default().u64(summary).u64(offsets).0);
    let crc = crc32fast::hash(&file.bytes[summary_at..]);
    file.bytes.extend(crc.to_le_bytes());
    file.bytes.extend(mcap::MAGIC);
    file.bytes
}
