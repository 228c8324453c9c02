//! Which topics are cameras, and what is said of those that seem to be.

use std::collections::BTreeMap;

use mcap::records::Channel;

use super::message::CameraKind;
use crate::bag_error::BagError;

/// What a topic holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    Camera(CameraKind),
    /// Pictures that are not damaged, with the reason.
    Refused(&'static str),
    Other,
}

/// Parts of names of schemas whose messages are pictures that are not damaged, with the reason.
const REFUSED: [(&str, &str); 6] = [
    (
        "CompressedVideo",
        "frames of a video depend on each other; decode it to images first",
    ),
    (
        "FFMPEGPacket",
        "frames of a video depend on each other; decode it to images first",
    ),
    (
        "theora_image_transport",
        "frames of a video depend on each other; decode it to images first",
    ),
    (
        "foxglove.CompressedImage",
        "only messages of sensor_msgs are read",
    ),
    ("foxglove.RawImage", "only messages of sensor_msgs are read"),
    ("foxglove_msgs/", "only messages of sensor_msgs are read"),
];

/// All channels of a bag so far.
#[derive(Debug, Default)]
pub(super) struct Topics {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Known>,
}

#[derive(Debug)]
struct Known {
    topic: String,
    content: Content,
    /// Schema and encoding of messages, for people.
    what: String,
}

impl Topics {
    pub(super) fn add_schema(&mut self, id: u16, name: &str) {
        self.schemas.insert(id, name.to_owned());
    }

    pub(super) fn add_channel(&mut self, channel: &Channel) {
        let schema = self.schemas.get(&channel.schema_id);
        let schema = schema.map_or("", String::as_str);
        let encoding = &channel.message_encoding;
        let known = Known {
            topic: channel.topic.clone(),
            content: content(schema, encoding),
            what: format!("{} in {encoding}", named(schema)),
        };
        self.channels.insert(channel.id, known);
    }

    pub(super) fn has_schema(&self, id: u16) -> bool {
        self.schemas.contains_key(&id)
    }

    /// Number, topic and content of each channel.
    pub(super) fn channels(&self) -> impl Iterator<Item = (u16, &str, Content)> {
        let channels = self.channels.iter();
        channels.map(|(id, known)| (*id, known.topic.as_str(), known.content))
    }

    /// Topic and content of a channel.
    pub(super) fn of(&self, id: u16) -> Option<(&str, Content)> {
        let known = self.channels.get(&id)?;
        Some((&known.topic, known.content))
    }

    /// Every topic once, with its content, in alphabetical order. A topic of several channels is a camera if one is.
    pub(super) fn all(&self) -> BTreeMap<&str, Content> {
        let mut all = BTreeMap::new();
        for known in self.channels.values() {
            let content = all.entry(known.topic.as_str()).or_insert(known.content);
            if *content == Content::Other {
                *content = known.content;
            }
        }
        all
    }

    /// Whether a number is that of a channel or of a schema.
    pub(super) fn is_taken(&self, id: u16) -> bool {
        self.channels.contains_key(&id) || self.schemas.contains_key(&id)
    }

    /// The refusal of a topic.
    pub(super) fn refusal(&self, topic: &str, reason: &'static str) -> BagError {
        let known = self.channels.values().find(|known| known.topic == topic);
        BagError::NotDamageable {
            topic: topic.to_owned(),
            what: known.map_or_else(String::new, |known| known.what.clone()),
            reason,
        }
    }
}

fn named(schema: &str) -> &str {
    match schema {
        "" => "without a schema",
        schema => schema,
    }
}

fn content(schema: &str, encoding: &str) -> Content {
    let kind = match schema {
        "sensor_msgs/msg/Image" | "sensor_msgs/Image" => CameraKind::Raw,
        "sensor_msgs/msg/CompressedImage" | "sensor_msgs/CompressedImage" => CameraKind::Compressed,
        schema => {
            let refused = REFUSED.iter().find(|(part, _)| schema.contains(part));
            return refused.map_or(Content::Other, |(_, reason)| Content::Refused(reason));
        }
    };
    match encoding {
        "cdr" => Content::Camera(kind),
        "ros1" => Content::Refused(
            "a message of ROS 1; convert the bag to ROS 2 first, for example with rosbags-convert",
        ),
        _ => Content::Refused("only messages in CDR are read"),
    }
}
