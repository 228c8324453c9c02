//! The frames of a clip through the glass: read, shown and written at the same time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use super::light::ClipLight;
use super::show::{Show, Shown};
use super::sink::{Ready, Sink};
use super::source::{Frame, Source};
use super::stage::StageFacts;
use super::track::TrackFrame;
use crate::Error;

/// How often a run that waits for a frame looks whether it is to stop.
const LOOK_AROUND: Duration = Duration::from_millis(100);

/// What comes out of a run that was not interrupted.
pub(super) struct Finished {
    pub(super) sink: Sink,
    pub(super) frames: Vec<TrackFrame>,
    pub(super) n_lights: u64,
}

/// Runs all frames of a source into a sink; `None` if it was stopped.
///
/// One thread reads, one writes, and the pool between them takes frames by the batch. Nobody
/// waits for more than a batch, so that memory holds three of them.
pub(super) fn run(
    show: &Show<'_>,
    light: ClipLight,
    source: &Source,
    sink: Sink,
    stop: &AtomicBool,
    done: &(impl Fn() + Sync),
) -> Result<Option<Finished>, Error> {
    let n_batch = (2 * rayon::current_num_threads()).clamp(2, 16);
    let mut kept = show.kept(light)?;
    let frames = source.frames()?;
    std::thread::scope(|scope| {
        let (to_pool, from_reader) = sync_channel(n_batch);
        let (to_writer, from_pool) = sync_channel(n_batch);
        scope.spawn(move || read_all(frames, &to_pool));
        let writer = scope.spawn(move || write_all(sink, &from_pool, done));
        let mut lines = Vec::new();
        let mut failure = None;
        let mut is_whole = false;
        while !stop.load(Ordering::Relaxed) {
            let batch = match next_batch(&from_reader, n_batch, stop) {
                Ok(batch) => batch,
                Err(error) => {
                    failure = Some(error);
                    break;
                }
            };
            if batch.is_empty() {
                is_whole = !stop.load(Ordering::Relaxed);
                break;
            }
            let shown = match show.batch(&mut kept, batch) {
                Ok(shown) => shown,
                Err(error) => {
                    failure = Some(error);
                    break;
                }
            };
            let mut has_writer = true;
            for Shown { ready, facts, line } in shown {
                lines.push(line);
                has_writer &= to_writer.send((ready, facts)).is_ok();
            }
            if !has_writer {
                break;
            }
        }
        // The reader and the writer end when nobody listens or speaks any more.
        drop(from_reader);
        drop(to_writer);
        let sink = match writer.join() {
            Ok(sink) => sink?,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        match failure {
            Some(error) => Err(error),
            None if !is_whole => Ok(None),
            None => Ok(Some(Finished {
                sink,
                frames: lines,
                n_lights: kept.n_lights(),
            })),
        }
    })
}

fn read_all(
    frames: impl Iterator<Item = Result<Frame, Error>>,
    to: &SyncSender<Result<Frame, Error>>,
) {
    for frame in frames {
        let is_last = frame.is_err();
        if to.send(frame).is_err() || is_last {
            return;
        }
    }
}

fn write_all(
    mut sink: Sink,
    from: &Receiver<(Ready, Arc<StageFacts>)>,
    done: &impl Fn(),
) -> Result<Sink, Error> {
    for (ready, facts) in from {
        sink.write(&ready, &facts)?;
        done();
    }
    Ok(sink)
}

/// The next frames; fewer at the end, none after it or when the run is to stop.
fn next_batch(
    from: &Receiver<Result<Frame, Error>>,
    n_batch: usize,
    stop: &AtomicBool,
) -> Result<Vec<Frame>, Error> {
    let mut batch = Vec::with_capacity(n_batch);
    while batch.len() < n_batch && !stop.load(Ordering::Relaxed) {
        match from.recv_timeout(LOOK_AROUND) {
            Ok(frame) => batch.push(frame?),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    Ok(batch)
}
