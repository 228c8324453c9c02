//! A look at the beginning of a bag: its cameras, their first stamps, and how its messages are kept.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

use super::damage::Damage;
use super::message::{CameraKind, CameraMessage};
use super::promise::{Promise, promise};
use super::records::{Event, Packing, Records, Unreadable};
use super::topics::{Content, Topics};
use crate::bag_error::{BagError, MessageFault};

/// From so many frames of a camera its rate is told.
const N_STAMPS: usize = 10;

/// What a frame lasts where a camera has one alone, s.
const LONE_FRAME_S: f64 = 0.1;

/// From here on stamps are of the wall clock, that of 2001 and later; a simulation's begin with 0.
const WALL_CLOCK_NS: i64 = 1_000_000_000_000_000_000;

/// Seconds from nanoseconds.
#[expect(
    clippy::cast_precision_loss,
    reason = "to some hundred ns where it is the time since 1970"
)]
pub(super) fn seconds(ns: i64) -> f64 {
    ns as f64 / 1e9
}

/// When images were taken, by the stamps of their headers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    /// The first stamp of all cameras, ns: time 0.
    pub(super) first_ns: i64,
    /// Whether stamps are of the wall clock, so that one of 0 was never set.
    is_wall: bool,
}

impl Clock {
    /// Time of an image, s; `None` where its stamp was never set.
    pub(super) fn time_s(self, stamp_ns: i64) -> Option<f64> {
        (!self.is_unset(stamp_ns)).then(|| self.since_first_s(stamp_ns))
    }

    /// From the first stamp to another, s.
    pub(super) fn since_first_s(self, stamp_ns: i64) -> f64 {
        seconds(stamp_ns.saturating_sub(self.first_ns))
    }

    /// Whether a stamp is of another clock than all images, which go by a wall clock.
    pub(super) fn is_of_another(self, stamp_ns: i64) -> bool {
        self.first_ns >= WALL_CLOCK_NS && stamp_ns < WALL_CLOCK_NS
    }

    fn is_unset(self, stamp_ns: i64) -> bool {
        stamp_ns == 0 && self.is_wall
    }
}

/// What was found.
#[derive(Debug)]
pub(super) struct Survey {
    pub(super) profile: String,
    pub(super) packing: Packing,
    topics: Topics,
    /// The cameras that were asked for, by topic.
    pub(super) cameras: BTreeMap<String, Seen>,
    pub(super) promise: Option<Promise>,
    /// Why it is not whole, as far as it was looked at.
    pub(super) damage: Option<Damage>,
}

/// A camera as it begins.
#[derive(Debug, Default)]
pub(super) struct Seen {
    n_images: u64,
    /// The first stamps, and of those of 0 that come first the first alone.
    stamps_ns: Vec<i64>,
    /// Whether its first image is JPEG.
    pub(super) is_jpeg: bool,
}

impl Seen {
    /// Whether enough is known of it: a driver may begin before its clock is set.
    fn is_known(&self) -> bool {
        self.stamps_ns.len() >= N_STAMPS
    }

    /// Whether it has images, and no stamps.
    pub(super) fn has_no_stamps(&self, clock: Clock) -> bool {
        let mut stamps = self.stamps_ns.iter();
        !self.stamps_ns.is_empty() && stamps.all(|stamp_ns| clock.is_unset(*stamp_ns))
    }

    /// Whether its images are stamped by another clock than the wall clock of other cameras.
    pub(super) fn has_other_clock(&self, clock: Clock) -> bool {
        let first = self.stamps_ns.iter().find(|it| !clock.is_unset(**it));
        clock.is_wall && first.is_some_and(|stamp_ns| *stamp_ns < WALL_CLOCK_NS)
    }

    /// The middle one of the times between its first frames, s.
    pub(super) fn frame_s(&self, clock: Clock) -> f64 {
        let set = self.stamps_ns.iter().copied();
        let set: Vec<i64> = set.filter(|stamp_ns| !clock.is_unset(*stamp_ns)).collect();
        let steps = set.windows(2).map(|pair| pair[1] - pair[0]);
        let mut steps: Vec<i64> = steps.filter(|step| *step > 0).collect();
        steps.sort_unstable();
        match steps.get(steps.len() / 2) {
            Some(step) => seconds(*step),
            None => LONE_FRAME_S,
        }
    }
}

/// Why there is no survey.
#[derive(Debug)]
pub(super) enum SurveyFault {
    Unreadable(Unreadable),
    Bag(BagError),
}

impl From<Unreadable> for SurveyFault {
    fn from(fault: Unreadable) -> Self {
        Self::Unreadable(fault)
    }
}

impl From<std::io::Error> for SurveyFault {
    fn from(error: std::io::Error) -> Self {
        Self::Unreadable(error.into())
    }
}

impl From<BagError> for SurveyFault {
    fn from(error: BagError) -> Self {
        Self::Bag(error)
    }
}

impl Survey {
    /// Looks at a bag until each of these topics, or each camera where none is named, has shown how it is: to the end
    /// where the bag has no summary.
    ///
    /// # Errors
    /// A bag that cannot be read, a camera among those asked for that is not damaged, and a first message of one that
    /// is not read.
    pub(super) fn of<R: Read + Seek>(
        from: &mut R,
        names: Option<&[String]>,
    ) -> Result<Self, SurveyFault> {
        let promise = promise(from)?;
        if let Some(promise) = &promise {
            refuse(&promise.topics, names)?;
        }
        from.seek(SeekFrom::Start(0))?;
        let mut records = Records::open(from, promise.as_ref())?;
        let promised: BTreeMap<&str, Content> = (promise.iter())
            .flat_map(|promise| promise.topics.all())
            .collect();
        // A camera may have no images, and then perhaps no channel in the data.
        let cameras = promised.iter().filter(|(topic, content)| {
            matches!(content, Content::Camera(_)) && is_asked_for(topic, names)
        });
        let mut survey = Self {
            profile: records.profile().to_owned(),
            packing: Packing::Bare,
            topics: Topics::knowing(promised.keys().copied()),
            cameras: cameras
                .map(|(topic, _)| ((*topic).to_owned(), Seen::default()))
                .collect(),
            promise,
            damage: None,
        };
        while let Some(event) = records.next_event()? {
            survey.take(event, names)?;
            if survey.has_seen_enough(names) && records.packing().is_some() {
                break;
            }
        }
        survey.packing = records.packing().unwrap_or(Packing::Bare);
        survey.damage = records.damage().cloned();
        // What an earlier run added may stand before its camera.
        let Self {
            topics, cameras, ..
        } = &mut survey;
        cameras.retain(|topic, _| !topics.is_ours(topic));
        Ok(survey)
    }

    /// The clock of all cameras, from the first stamp of each that is set.
    pub(super) fn clock(&self) -> Clock {
        let stamps = self.cameras.values().map(|seen| seen.stamps_ns.iter());
        let is_wall = stamps
            .clone()
            .flatten()
            .any(|stamp_ns| *stamp_ns >= WALL_CLOCK_NS);
        let firsts = stamps.filter_map(|mut stamps| stamps.find(|it| **it != 0 || !is_wall));
        Clock {
            first_ns: firsts.min().copied().unwrap_or(0),
            is_wall,
        }
    }

    /// How many frames these cameras have, where the bag says so.
    pub(super) fn n_frames(&self) -> Option<u64> {
        let promise = self.promise.as_ref()?;
        let counts = promise.n_messages(|topic, _| self.cameras.contains_key(topic));
        Some(counts.values().sum())
    }

    /// Whether a number of a channel or a schema is free in the whole bag, as far as it is known.
    pub(super) fn is_free(&self, id: u16) -> bool {
        self.known().all(|topics| !topics.is_taken(id))
    }

    /// Whether the bag has a topic, as far as it is known.
    pub(super) fn has_topic(&self, topic: &str) -> bool {
        self.known().any(|topics| topics.all().contains_key(topic))
    }

    /// Every topic with its content, as far as it is known.
    pub(super) fn all_topics(&self) -> BTreeMap<&str, Content> {
        self.known().flat_map(Topics::all).collect()
    }

    /// The refusal of a topic that the bag has.
    pub(super) fn refusal(&self, topic: &str, reason: &'static str) -> BagError {
        let mut known = self.known();
        let of_topic = known.find(|topics| topics.all().contains_key(topic));
        of_topic.unwrap_or(&self.topics).refusal(topic, reason)
    }

    fn known(&self) -> impl Iterator<Item = &Topics> {
        let promised = self.promise.as_ref().map(|promise| &promise.topics);
        promised.into_iter().chain([&self.topics])
    }

    fn take(&mut self, event: Event, names: Option<&[String]>) -> Result<(), BagError> {
        match event {
            Event::Schema { header, .. } => self.topics.add_schema(header.id, &header.name),
            Event::Channel(channel) => {
                self.topics.add_channel(&channel);
                refuse(&self.topics, names)?;
                if is_asked_for(&channel.topic, names)
                    && let Some((topic, Content::Camera(_))) = self.topics.of(channel.id)
                {
                    self.cameras.entry(topic.to_owned()).or_default();
                }
            }
            Event::Message { header, data } => {
                if let Some((topic, Content::Camera(kind))) = self.topics.of(header.channel_id)
                    && let Some(seen) = self.cameras.get_mut(topic)
                    && !seen.is_known()
                {
                    let idx = seen.n_images;
                    look(seen, kind, &data).map_err(|fault| BagError::Message {
                        topic: topic.to_owned(),
                        idx,
                        fault,
                    })?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn has_seen_enough(&self, names: Option<&[String]>) -> bool {
        let Some(promise) = &self.promise else {
            return false;
        };
        let is_wanted = |topic: &str, content| {
            matches!(content, Content::Camera(_)) && is_asked_for(topic, names)
        };
        let counts = promise.n_messages(is_wanted);
        counts.into_iter().all(|(topic, n_messages)| {
            let is_known = |seen: &Seen| seen.is_known() || seen.n_images >= n_messages;
            n_messages == 0 || self.cameras.get(topic).is_some_and(is_known)
        })
    }
}

/// Whether a topic is one of those that are named, or none is.
fn is_asked_for(topic: &str, names: Option<&[String]>) -> bool {
    names.is_none_or(|names| names.iter().any(|name| name == topic))
}

/// Refuses pictures that are asked for and are not damaged.
fn refuse(topics: &Topics, names: Option<&[String]>) -> Result<(), BagError> {
    for (topic, content) in topics.all() {
        if let Content::Refused(reason) = content
            && is_asked_for(topic, names)
        {
            return Err(topics.refusal(topic, reason));
        }
    }
    Ok(())
}

fn look(seen: &mut Seen, kind: CameraKind, data: &[u8]) -> Result<(), MessageFault> {
    let message = CameraMessage::read(kind, data)?;
    if seen.n_images == 0 {
        seen.is_jpeg = message.is_jpeg(data);
    }
    seen.n_images += 1;
    let stamp_ns = message.stamp_ns();
    if stamp_ns != 0 || seen.stamps_ns != [0] {
        seen.stamps_ns.push(stamp_ns);
    }
    Ok(())
}
