//! A bag through the glass: read, shown and written at the same time.

use std::collections::BTreeMap;
use std::io::{Read, Seek, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use super::camera::{Camera, CameraReport, CameraRun, Damaged, Decoded, Incoming, Panes, on_all};
use super::damage::Damage;
use super::records::{Event, Records};
use super::topics::{Content, Topics};
use super::write::{BagWriter, Outgoing};
use super::{Bag, unreadable};
use crate::Error;
use crate::bag_error::BagError;

/// How often a run that waits looks whether it is to stop.
const LOOK_AROUND: Duration = Duration::from_millis(100);

/// Bytes of messages from which on a batch is full, whatever they are.
const BATCH_BYTES: usize = 1 << 25;

/// What comes out of a run that was not interrupted.
pub(super) struct Finished<W: Write + Seek> {
    pub(super) writer: BagWriter<W>,
    pub(super) cameras: Vec<CameraReport>,
    pub(super) n_messages: u64,
    pub(super) damage: Option<Damage>,
}

/// What is done at once.
#[derive(Default)]
struct Batch {
    /// What is only written; none at the places of images.
    events: Vec<Option<Event>>,
    frames: Vec<Incoming>,
    n_bytes: usize,
}

/// What a reader says.
enum Read1 {
    Batch(Batch),
    /// The end, with the number of messages.
    End(u64, Option<Damage>),
}

/// Runs a bag; `None` if it was stopped.
///
/// One thread reads, one writes, and the pool between them takes images by the batch. Nobody waits for more than one,
/// so that memory holds four of them, whatever the bag has.
pub(super) fn run<R: Read + Seek + Send, W: Write + Seek + Send>(
    bag: &Bag,
    records: Records<R>,
    writer: BagWriter<W>,
    stop: &AtomicBool,
    done: &(impl Fn() + Sync),
) -> Result<Option<Finished<W>>, Error> {
    let names: Vec<String> = bag.cameras.iter().map(Camera::name).collect();
    let panes: Vec<Panes> = bag.cameras.iter().map(|_| Panes::default()).collect();
    let mut cameras: Vec<CameraRun<'_>> = (bag.cameras.iter())
        .zip(names.iter().zip(&panes))
        .map(|(camera, (name, panes))| CameraRun::new(camera, name, panes))
        .collect();
    let n_batch = (2 * rayon::current_num_threads()).clamp(2, 16);
    std::thread::scope(|scope| {
        let (to_pool, from_reader) = sync_channel(1);
        let (to_writer, from_pool) = sync_channel(1);
        let reader = Reader::new(bag, n_batch);
        scope.spawn(move || reader.read_all(records, &to_pool));
        let writer = scope.spawn(move || write_all(writer, &from_pool));
        let ended = show_all(bag, &mut cameras, (&from_reader, &to_writer), stop, done);
        // The reader and the writer end when nobody listens or speaks any more.
        drop(from_reader);
        drop(to_writer);
        let writer = match writer.join() {
            Ok(writer) => writer?,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        let Some((n_messages, damage)) = ended? else {
            return Ok(None);
        };
        Ok(Some(Finished {
            writer,
            cameras: cameras.into_iter().map(|camera| camera.report).collect(),
            n_messages,
            damage,
        }))
    })
}

/// All batches, until the end; none if it was stopped, or where nobody writes any more.
fn show_all(
    bag: &Bag,
    cameras: &mut [CameraRun<'_>],
    (from, to): (&Receiver<Result<Read1, Error>>, &SyncSender<Vec<Outgoing>>),
    stop: &AtomicBool,
    done: &(impl Fn() + Sync),
) -> Result<Option<(u64, Option<Damage>)>, Error> {
    while !stop.load(Ordering::Relaxed) {
        let batch = match from.recv_timeout(LOOK_AROUND) {
            Ok(Ok(Read1::Batch(batch))) => batch,
            Ok(Ok(Read1::End(n_messages, damage))) => return Ok(Some((n_messages, damage))),
            Ok(Err(error)) => return Err(error),
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return Ok(None),
        };
        let n_frames = batch.frames.len();
        if to.send(show(bag, cameras, batch)?).is_err() {
            return Ok(None);
        }
        (0..n_frames).for_each(|_| done());
    }
    Ok(None)
}

/// A batch behind the glass, in its order; the result does not depend on how batches are made.
fn show(bag: &Bag, cameras: &mut [CameraRun<'_>], batch: Batch) -> Result<Vec<Outgoing>, Error> {
    let Batch { events, frames, .. } = batch;
    let decoded = on_all(frames, |frame| {
        let camera = frame.camera;
        Ok((camera, frame.decoded(&bag.cameras[camera])?))
    })?;
    let mut of_cameras: Vec<Vec<Decoded>> = cameras.iter().map(|_| Vec::new()).collect();
    for (camera, frame) in decoded {
        of_cameras[camera].push(frame);
    }
    let runs = cameras.iter_mut().zip(of_cameras).enumerate();
    let damaged = on_all(runs.collect(), |(idx, (run, frames))| {
        Ok((idx, run.show(frames)?))
    })?;
    let damaged: Vec<(usize, Damaged)> = (damaged.into_iter())
        .flat_map(|(idx, frames)| frames.into_iter().map(move |frame| (idx, frame)))
        .collect();
    let written = on_all(damaged, |(idx, frame)| frame.written(&bag.cameras[idx]))?;
    let mut at_places: BTreeMap<usize, Vec<Outgoing>> = written.into_iter().collect();
    let mut outgoing = Vec::with_capacity(events.len() + at_places.len());
    for (at, event) in events.into_iter().enumerate() {
        match event {
            Some(event) => outgoing.push(Outgoing::Kept(event)),
            None => outgoing.extend(at_places.remove(&at).unwrap_or_default()),
        }
    }
    Ok(outgoing)
}

fn write_all<W: Write + Seek>(
    mut writer: BagWriter<W>,
    from: &Receiver<Vec<Outgoing>>,
) -> Result<BagWriter<W>, Error> {
    for one in from.iter().flatten() {
        writer.write(one)?;
    }
    Ok(writer)
}

/// From records to batches.
struct Reader<'a> {
    path: &'a Path,
    /// Which camera a topic is.
    cameras: BTreeMap<&'a str, usize>,
    /// Whether all cameras are asked for.
    is_all: bool,
    n_batch: usize,
    topics: Topics,
    /// Messages of each camera so far.
    n_frames: Vec<u64>,
    n_messages: u64,
}

impl<'a> Reader<'a> {
    fn new(bag: &'a Bag, n_batch: usize) -> Self {
        let cameras = bag.cameras.iter().enumerate();
        Self {
            path: &bag.request.input,
            cameras: cameras
                .map(|(idx, camera)| (camera.topic.as_str(), idx))
                .collect(),
            is_all: bag.request.all.is_some(),
            n_batch,
            topics: Topics::knowing(bag.survey.all_topics().into_keys()),
            n_frames: vec![0; bag.cameras.len()],
            n_messages: 0,
        }
    }

    fn read_all<R: Read + Seek>(
        mut self,
        mut records: Records<R>,
        to: &SyncSender<Result<Read1, Error>>,
    ) {
        let mut batch = Batch::default();
        loop {
            let event = records.next_event();
            let event = event.map_err(|fault| unreadable(self.path, fault));
            let taken = match event {
                Ok(Some(event)) => self.take(event, &mut batch).map_err(Error::from),
                Ok(None) => {
                    // Whoever does not listen any more has its reason.
                    if to.send(Ok(Read1::Batch(batch))).is_ok() {
                        let damage = records.damage().cloned();
                        let _ = to.send(Ok(Read1::End(self.n_messages, damage)));
                    }
                    return;
                }
                Err(error) => Err(error),
            };
            if let Err(error) = taken {
                let _ = to.send(Err(error));
                return;
            }
            let is_full = batch.frames.len() >= self.n_batch || batch.n_bytes >= BATCH_BYTES;
            if is_full
                && to
                    .send(Ok(Read1::Batch(std::mem::take(&mut batch))))
                    .is_err()
            {
                return;
            }
        }
    }

    fn take(&mut self, event: Event, batch: &mut Batch) -> Result<(), BagError> {
        batch.n_bytes += event.n_bytes();
        match event {
            Event::Message { header, data } => {
                self.n_messages += 1;
                let camera = self.topics.of(header.channel_id);
                if let Some((topic, Content::Camera(kind))) = camera
                    && let Some(camera) = self.cameras.get(topic).copied()
                {
                    batch.frames.push(Incoming {
                        at: batch.events.len(),
                        camera,
                        kind,
                        idx: self.n_frames[camera],
                        header,
                        data,
                    });
                    self.n_frames[camera] += 1;
                    batch.events.push(None);
                    return Ok(());
                }
                batch.events.push(Some(Event::Message { header, data }));
                return Ok(());
            }
            Event::Schema { ref header, .. } => self.topics.add_schema(header.id, &header.name),
            Event::Channel(ref channel) => {
                self.topics.add_channel(channel);
                let is_damaged = self.cameras.contains_key(channel.topic.as_str());
                let is_unannounced = match self.topics.of(channel.id) {
                    Some((_, Content::Camera(_))) => self.is_all && !is_damaged,
                    // Such a channel was refused if it was known.
                    Some((_, Content::Refused(_))) => self.is_all || is_damaged,
                    _ => false,
                };
                if is_unannounced {
                    return Err(BagError::Unannounced {
                        path: self.path.to_owned(),
                        topic: channel.topic.clone(),
                    });
                }
            }
            Event::Attachment { .. }
            | Event::Private { .. }
            | Event::Metadata(_)
            | Event::ChunkEnd => {}
        }
        batch.events.push(Some(event));
        Ok(())
    }
}
