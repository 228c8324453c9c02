//! Why a bag, or a message in one, was refused.

use std::path::PathBuf;

use starbreak_dataset::DatasetError;

/// What is wrong with a bag or with what is asked of it, as one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BagError {
    /// The file is no MCAP file.
    #[error(
        "{path:?} is not an MCAP file: it does not begin with its magic bytes; give a recording in MCAP"
    )]
    NotMcap {
        /// The file.
        path: PathBuf,
    },
    /// The file is a bag of another kind, which a tool converts.
    #[error("{path:?} is {kind}; convert it first: mcap convert {path:?} {mcap:?}")]
    OtherBag {
        /// The file.
        path: PathBuf,
        /// What it is, with its article.
        kind: &'static str,
        /// A name for the converted one.
        mcap: PathBuf,
    },
    /// The records of a bag contradict each other, or are of a kind that is not known.
    #[error("{path:?}: {reason}; write the bag again, for example with mcap recover")]
    Records {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// The output is the input.
    #[error("the output {output:?} would replace the input; choose another name")]
    OutputIsInput {
        /// The bag.
        output: PathBuf,
    },
    /// No topic has images.
    #[error(
        "{path:?} has no camera: none of its {n_topics} topics holds sensor_msgs/msg/Image or CompressedImage in CDR{}",
        why_so_few(.damage.as_deref())
    )]
    NoCamera {
        /// The bag.
        path: PathBuf,
        /// How many topics it has.
        n_topics: usize,
        /// Why it is not whole, if it is not.
        damage: Option<String>,
    },
    /// A topic that is not there.
    #[error(
        "{path:?} has no topic {}; its cameras are {}{}",
        .topic.escape_debug(),
        listed(.cameras),
        why_so_few(.damage.as_deref())
    )]
    NoTopic {
        /// The bag.
        path: PathBuf,
        /// What was asked for.
        topic: String,
        /// Topics with images, in alphabetical order.
        cameras: Vec<String>,
        /// Why the bag is not whole, if it is not.
        damage: Option<String>,
    },
    /// A topic that is named twice.
    #[error("topic {} is named twice; a camera has one recipe", .topic.escape_debug())]
    TopicTwice {
        /// The topic.
        topic: String,
    },
    /// A topic whose messages are no images that can be damaged one by one.
    #[error(
        "topic {} is {}: {reason}; name only topics that are damaged with --topic",
        .topic.escape_debug(), .what.escape_debug()
    )]
    NotDamageable {
        /// The topic.
        topic: String,
        /// Its schema and encoding of messages.
        what: String,
        /// Why not.
        reason: &'static str,
    },
    /// A message of a camera that cannot be read.
    #[error(
        "topic {}, message {idx}: {fault}; without this topic, the others may be named with --topic", .topic.escape_debug()
    )]
    Message {
        /// The topic.
        topic: String,
        /// Which message of the topic, from 0.
        idx: u64,
        /// What is wrong with it.
        fault: MessageFault,
    },
    /// A topic of ours is there already.
    #[error(
        "the bag has a topic {} already, as after an earlier run; leave --masks and --control out, or give the bag from \
         before it", .topic.escape_debug()
    )]
    TopicTaken {
        /// The topic.
        topic: String,
    },
    /// A topic that the summary of the bag does not name.
    #[error(
        "{path:?} has a camera {} that its summary does not name; write the bag again, for example with mcap recover",
        .topic.escape_debug()
    )]
    Unannounced {
        /// The bag.
        path: PathBuf,
        /// The topic.
        topic: String,
    },
    /// Control pictures of images that lose nothing.
    #[error(
        "--control is for JPEG: no camera that is damaged has it, and raw images and PNG lose nothing when they are \
         written again; leave it out"
    )]
    NoJpeg,
    /// The hit comes after the last image.
    #[error(
        "--impact-at: the hit at {impact_at_s} s comes after the last image, {last_s:.3} s after the first; choose an earlier \
         time"
    )]
    ImpactTime {
        /// The hit, s after the first image.
        impact_at_s: f64,
        /// The last image, s after the first one.
        last_s: f64,
    },
    /// A hit at a stamp of another clock than that of the images, which would come before all of them.
    #[error(
        "--impact-at @{stamp_s}: the images are stamped by a wall clock, the first at {first_s:.3} s; give a stamp of that \
         clock, or seconds after the first image without @"
    )]
    StampClock {
        /// The stamp that was asked for, s.
        stamp_s: f64,
        /// That of the first image, s.
        first_s: f64,
    },
    /// A hit at a moment, and a camera whose images have none.
    #[error(
        "topic {}: its images have no stamps (0, beside stamps of a wall clock), so that a hit at a moment and growth \
         cannot be placed in it; set them, name the other cameras with --topic, or leave out --impact-at and --grow",
        .topic.escape_debug()
    )]
    NoStamps {
        /// The topic.
        topic: String,
    },
    /// A hit at a moment, and cameras whose images are stamped by different clocks.
    #[error(
        "topic {}: its images are stamped by another clock than those of other cameras, which go by a wall clock, so that \
         they have no moment in common; name the cameras of one clock with --topic, or leave out --impact-at and --grow",
        .topic.escape_debug()
    )]
    OtherClock {
        /// The topic.
        topic: String,
    },
    /// Another format than that of the messages.
    #[error(
        "the recipe for topic {} sets output.format, but a message keeps its format; leave it at \"same\"",
        .topic.escape_debug()
    )]
    Format {
        /// The topic.
        topic: String,
    },
}

/// What is wrong with a message of a camera.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MessageFault {
    /// Not even the header of CDR.
    #[error("{n_bytes} bytes, fewer than the 4 of CDR's header")]
    NoHeader {
        /// How many there are.
        n_bytes: usize,
    },
    /// Another encapsulation than plain CDR.
    #[error(
        "encapsulation {id:#06x} ({name}); expected plain CDR (0x0000 or 0x0001), as ROS 2 writes it"
    )]
    Encapsulation {
        /// The identifier.
        id: u16,
        /// Its name in the specification of DDS-XTypes.
        name: &'static str,
    },
    /// The message ends inside a field.
    #[error("it ends within {field}, of which {n_left} bytes are left")]
    Short {
        /// The field.
        field: &'static str,
        /// Bytes left.
        n_left: usize,
    },
    /// A field longer than the message.
    #[error("{field} claims {n_bytes} bytes, but {n_left} are left")]
    Long {
        /// The field.
        field: &'static str,
        /// What it claims.
        n_bytes: u32,
        /// Bytes left.
        n_left: usize,
    },
    /// A text that does not end in its zero.
    #[error("{field} is not a text that ends in a zero byte")]
    NotText {
        /// The field.
        field: &'static str,
    },
    /// More than padding behind the last field.
    #[error("{n_bytes} bytes lie behind its last field, data; expected 3 at most")]
    Behind {
        /// How many.
        n_bytes: usize,
    },
    /// An encoding of pixels that is not damaged.
    #[error("encoding {encoding:?}: {reason}; expected rgb8, bgr8, rgba8, bgra8 or mono8")]
    Encoding {
        /// What the message says.
        encoding: String,
        /// Why not.
        reason: &'static str,
    },
    /// An image without pixels, or with too many.
    #[error("{width} x {height} px; expected sides of 1 to 32768 px, 134217728 px in all")]
    Size {
        /// Width, px.
        width: u32,
        /// Height, px.
        height: u32,
    },
    /// Rows that are shorter than their pixels.
    #[error("step {step} bytes; a row of {width} px of {encoding} has {n_row} bytes")]
    Step {
        /// What the message says, bytes.
        step: u32,
        /// Width, px.
        width: u32,
        /// The encoding.
        encoding: &'static str,
        /// Bytes of a row's pixels.
        n_row: u64,
    },
    /// Data that are not the rows.
    #[error("data have {n_bytes} bytes; {height} rows with a step of {step} have {}", span(*.least, *.most))]
    Data {
        /// How many there are.
        n_bytes: usize,
        /// Rows.
        height: u32,
        /// Bytes from row to row.
        step: u32,
        /// Bytes up to the last pixel.
        least: u64,
        /// Bytes of all rows.
        most: u64,
    },
    /// A compressed image that is neither JPEG nor PNG, or no picture of 8 bits per channel.
    #[error("format {format:?}: {reason}; expected JPEG or PNG of 8 bits per channel")]
    Format {
        /// What the message says.
        format: String,
        /// Why not.
        reason: &'static str,
    },
    /// Images of more sizes than a topic of a camera has.
    #[error(
        "{width} x {height} px, after images of {n_most} other sizes; each size has a pane in memory, and one topic has \
         at most {n_most}"
    )]
    Sizes {
        /// Width, px.
        width: u32,
        /// Height, px.
        height: u32,
        /// The most.
        n_most: usize,
    },
    /// Data that are no image, or one that cannot be written again.
    #[error("{0}")]
    Image(#[source] Box<DatasetError>),
    /// Data of more than 4 GiB.
    #[error("data of {n_bytes} bytes do not fit a message")]
    TooLong {
        /// How many bytes.
        n_bytes: usize,
    },
}

impl From<DatasetError> for MessageFault {
    fn from(error: DatasetError) -> Self {
        Self::Image(Box::new(error))
    }
}

/// That a bag is not whole, where it is not: what is missing may stand in what cannot be read.
fn why_so_few(damage: Option<&str>) -> String {
    damage.map_or_else(String::new, |damage| {
        format!(", and the file is not whole: {damage}")
    })
}

/// Names in a list, or that there are none.
fn listed(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        names => names.join(", ").escape_debug().to_string(),
    }
}

/// A number of bytes, or two that bound it.
fn span(least: u64, most: u64) -> String {
    match least == most {
        true => most.to_string(),
        false => format!("{least} to {most}"),
    }
}
