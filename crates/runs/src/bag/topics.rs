//! Which topics are cameras, and what is said of those that seem to be.

use std::collections::{BTreeMap, BTreeSet};

use mcap::records::Channel;

use super::Added;
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
const REFUSED: [(&str, &str); 9] = [
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
    (
        "foxglove_msgs/msg/CompressedImage",
        "only messages of sensor_msgs are read",
    ),
    (
        "foxglove_msgs/CompressedImage",
        "only messages of sensor_msgs are read",
    ),
    (
        "foxglove_msgs/msg/RawImage",
        "only messages of sensor_msgs are read",
    ),
    (
        "foxglove_msgs/RawImage",
        "only messages of sensor_msgs are read",
    ),
];

/// All channels of a bag so far.
#[derive(Debug, Default)]
pub(super) struct Topics {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Known>,
    /// Every topic that the bag is known to have, wherever its channel stands.
    names: BTreeSet<String>,
}

#[derive(Debug)]
struct Known {
    topic: String,
    /// By its schema and encoding alone.
    content: Content,
    /// The topic beside which a run of ours would have put it.
    beside: Option<String>,
    /// Schema and encoding of messages, for people.
    what: String,
}

impl Topics {
    /// None yet, of a bag that is known to have topics of these names.
    pub(super) fn knowing<'a>(names: impl Iterator<Item = &'a str>) -> Self {
        Self {
            names: names.map(str::to_owned).collect(),
            ..Self::default()
        }
    }

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
            beside: camera_of(&channel.topic).map(str::to_owned),
            what: format!("{} in {encoding}", named(schema)),
        };
        self.names.insert(channel.topic.clone());
        self.channels.insert(channel.id, known);
    }

    pub(super) fn has_schema(&self, id: u16) -> bool {
        self.schemas.contains_key(&id)
    }

    /// Number, topic and content of each channel.
    pub(super) fn channels(&self) -> impl Iterator<Item = (u16, &str, Content)> {
        let channels = self.channels.iter();
        channels.map(|(id, known)| (*id, known.topic.as_str(), self.content_of(known)))
    }

    /// Topic and content of a channel.
    pub(super) fn of(&self, id: u16) -> Option<(&str, Content)> {
        let known = self.channels.get(&id)?;
        Some((&known.topic, self.content_of(known)))
    }

    /// Whether an earlier run added a topic, as far as the bag is known.
    pub(super) fn is_ours(&self, topic: &str) -> bool {
        camera_of(topic).is_some_and(|camera| self.names.contains(camera))
    }

    /// What an earlier run added beside a topic of the bag is no camera, whatever its type.
    fn content_of(&self, known: &Known) -> Content {
        match &known.beside {
            Some(camera) if self.names.contains(camera) => Content::Other,
            _ => known.content,
        }
    }

    /// Every topic once, with its content, in alphabetical order. A topic of several channels is refused if one is, and
    /// else a camera if one is.
    pub(super) fn all(&self) -> BTreeMap<&str, Content> {
        let mut all = BTreeMap::new();
        for known in self.channels.values() {
            let own = self.content_of(known);
            let content = all.entry(known.topic.as_str()).or_insert(own);
            if matches!(
                (*content, own),
                (Content::Other, _) | (Content::Camera(_), Content::Refused(_))
            ) {
                *content = own;
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
        let of_topic = || self.channels.values().filter(|known| known.topic == topic);
        let is_refused = |known: &&Known| matches!(known.content, Content::Refused(_));
        let known = of_topic().find(is_refused).or_else(|| of_topic().next());
        BagError::NotDamageable {
            topic: topic.to_owned(),
            what: known.map_or_else(String::new, |known| known.what.clone()),
            reason,
        }
    }
}

/// The camera beside which a run puts a topic of this name.
pub(super) fn camera_of(topic: &str) -> Option<&str> {
    let camera = Added::ALL
        .iter()
        .find_map(|added| topic.strip_suffix(added.topic("").as_str()));
    camera.filter(|camera| !camera.is_empty())
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
