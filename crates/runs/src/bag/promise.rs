//! What the summary at the end of an MCAP file promises of its data, where there is one.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

use mcap::records::{Channel, Record, SchemaHeader, op};

use super::record::{parsed, split};
use super::records::{Event, Unreadable};
use super::topics::{Content, Topics};

/// The footer: what it is, its length, two places and a checksum.
const FOOTER_BYTES: usize = 9 + 20;

/// Longest summary that is read, bytes.
const MAX_SUMMARY_BYTES: u64 = 1 << 28;

/// The channels of a whole file with their numbers of messages.
#[derive(Debug)]
pub(super) struct Promise {
    pub(super) topics: Topics,
    pub(super) schemas: Vec<(SchemaHeader, Vec<u8>)>,
    pub(super) channels: Vec<Channel>,
    n_messages: BTreeMap<u16, u64>,
}

impl Promise {
    /// Its schemas and channels as they stand in a file, where no schema has the number 0.
    pub(super) fn events(&self) -> Vec<Event> {
        let schemas = self.schemas.iter().filter(|(header, _)| header.id != 0);
        let schemas = schemas.map(|(header, data)| Event::Schema {
            header: header.clone(),
            data: data.clone(),
        });
        let channels = self.channels.iter().cloned().map(Event::Channel);
        schemas.chain(channels).collect()
    }

    /// Messages of each of the topics that `is_wanted` takes, by their content.
    pub(super) fn n_messages(
        &self,
        is_wanted: impl Fn(&str, Content) -> bool,
    ) -> BTreeMap<&str, u64> {
        let mut counts = BTreeMap::new();
        for (id, topic, content) in self.topics.channels() {
            if is_wanted(topic, content) {
                let n_messages = self.n_messages.get(&id).copied().unwrap_or(0);
                *counts.entry(topic).or_default() += n_messages;
            }
        }
        counts
    }
}

/// What a file promises; none where it has no summary or one that says less. What it says serves to stop looking and to
/// count, and channels that stand nowhere else are kept: nothing is left out because of it.
pub(super) fn promise<R: Read + Seek>(from: &mut R) -> Result<Option<Promise>, Unreadable> {
    let n_bytes = from.seek(SeekFrom::End(0))?;
    let tail = (FOOTER_BYTES + mcap::MAGIC.len()) as u64;
    let Some(footer_at) = n_bytes.checked_sub(tail) else {
        return Ok(None);
    };
    from.seek(SeekFrom::Start(footer_at))?;
    let mut footer = [0; FOOTER_BYTES];
    from.read_exact(&mut footer)?;
    let Some((head, content)) = footer.split_first_chunk() else {
        return Ok(None);
    };
    let (opcode, length) = split(head);
    let summary_at = match parsed(opcode, content) {
        Ok(Record::Footer(footer)) if length == content.len() as u64 => footer.summary_start,
        _ => return Ok(None),
    };
    let length = footer_at.saturating_sub(summary_at);
    if summary_at == 0 || length == 0 || length > MAX_SUMMARY_BYTES {
        return Ok(None);
    }
    from.seek(SeekFrom::Start(summary_at))?;
    let mut summary = Vec::new();
    from.take(length).read_to_end(&mut summary)?;
    Ok(promised(&summary))
}

fn promised(mut summary: &[u8]) -> Option<Promise> {
    let mut topics = Topics::default();
    let mut schemas = Vec::new();
    let mut channels = Vec::new();
    let mut statistics = None;
    while let Some((head, rest)) = summary.split_first_chunk() {
        let (opcode, length) = split(head);
        let (record, rest) = rest.split_at_checked(usize::try_from(length).ok()?)?;
        if matches!(opcode, op::SCHEMA | op::CHANNEL | op::STATISTICS) {
            match parsed(opcode, record).ok()? {
                Record::Schema { header, data } => {
                    topics.add_schema(header.id, &header.name);
                    schemas.push((header, data.into_owned()));
                }
                Record::Channel(channel) => channels.push(channel),
                Record::Statistics(found) => statistics = Some(found),
                _ => {}
            }
        }
        summary = rest;
    }
    let statistics = statistics?;
    // Schemas may come behind the channels that have them.
    let has_schema = |id| id == 0 || topics.has_schema(id);
    // The writer of rosbag2 counts only channels with messages; those without stand in the summary alone.
    if (channels.len() as u64) < u64::from(statistics.channel_count)
        || !channels.iter().all(|channel| has_schema(channel.schema_id))
    {
        return None;
    }
    for channel in &channels {
        topics.add_channel(channel);
    }
    Some(Promise {
        topics,
        schemas,
        channels,
        n_messages: statistics.channel_message_counts,
    })
}
