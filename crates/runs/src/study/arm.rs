//! Detectors over one version of all images: clean, or under one condition.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use image::RgbImage;
use serde_json::Value;
use starbreak_dataset::{LineBytes, LineLog};
use starbreak_detect::ImageToSee;
use starbreak_eval::Detection;

use super::StudyEvent;
use super::arm_log::{FoundInImage, UnseenImage};
use crate::Error;

/// What is found in the image of a place, of these pixels.
type Find<'a> = dyn Fn(u32, &ImageToSee, &RgbImage) -> Result<Vec<Detection>, Error> + Sync + 'a;

/// BLAKE3 of the file of an image.
pub(super) type Hash<'a> = dyn Fn(&ImageToSee) -> Result<String, Error> + Sync + 'a;

/// The pixels of an image.
pub(super) type Read<'a> = dyn Fn(&ImageToSee) -> Result<RgbImage, Error> + Sync + 'a;

/// One detector over the images.
pub(super) struct Arm<'a> {
    /// Its log, from which it goes on.
    pub(super) log: PathBuf,
    /// What its lines are made from.
    pub(super) identity: Value,
    /// What it finds.
    pub(super) find: Box<Find<'a>>,
}

/// How arms are run, side by side: an image is read once for all of them.
pub(super) struct ArmsRun<'a> {
    /// The detectors.
    pub(super) arms: &'a [Arm<'a>],
    /// The images.
    pub(super) images: &'a [ImageToSee],
    /// BLAKE3 of the file that is looked at.
    pub(super) blake3: &'a Hash<'a>,
    /// The pixels of that file.
    pub(super) read: &'a Read<'a>,
    /// Threads to use, 1 or more.
    pub(super) n_threads: usize,
    /// Once it is set no further image begins.
    pub(super) stop: &'a AtomicBool,
    /// Told how many images all logs have, what fails, and of each other image once it is done.
    pub(super) tell: &'a (dyn Fn(StudyEvent<'_>) + Sync),
}

/// The log of an arm while it runs.
struct ArmLog {
    log: LineLog,
    /// By the places of the images: their lines, of those that it has.
    lines: Vec<Option<LineBytes>>,
}

/// What the threads of a run share.
struct Shared {
    /// Which of the images to look at is begun next.
    next: usize,
    /// What is found before its turn to be written has come.
    waiting: BTreeMap<usize, Vec<FoundInArm>>,
    /// How many of the images to look at have been written.
    n_written: usize,
    /// Those of them without a result in some arm.
    unseen: Vec<UnseenImage>,
    /// The log of each arm, in their order.
    logs: Vec<ArmLog>,
    failure: Option<Error>,
}

/// What an arm, by its place among them, found in an image.
type FoundInArm = (usize, FoundInImage);

impl ArmsRun<'_> {
    /// Looks through the images that some log does not have yet, or has no result of. Comes to those without a result;
    /// none is returned where `stop` was set on the way.
    ///
    /// In the end each log has a line for each image, in their order, whatever the threads do and however often it was
    /// interrupted.
    pub(super) fn run(&self) -> Result<Option<Vec<UnseenImage>>, Error> {
        let logs = self.open_logs()?;
        let lacks = |place: &u32| logs.iter().any(|log| log.lines[*place as usize].is_none());
        let to_look_at: Vec<u32> = (0_u32..).take(self.images.len()).filter(lacks).collect();
        let n_known = self.images.len() - to_look_at.len();
        (self.tell)(StudyEvent::Known(n_known as u64));
        let shared = Mutex::new(Shared {
            next: 0,
            waiting: BTreeMap::new(),
            n_written: 0,
            unseen: Vec::new(),
            logs,
            failure: None,
        });
        // Threads of the system and no pool: a thread of a pool that waits for the model would begin
        // another image meanwhile, and hold both.
        std::thread::scope(|scope| {
            for _ in 0..self.n_threads {
                scope.spawn(|| self.work(&to_look_at, &shared));
            }
        });
        let shared = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = shared.failure {
            return Err(error);
        }
        if shared.n_written < to_look_at.len() {
            return Ok(None);
        }
        for arm in shared.logs {
            arm.log.close_with(arm.lines.iter().flatten().cloned())?;
        }
        Ok(Some(shared.unseen))
    }

    /// The logs of all arms, with what they know of the images as these are now.
    fn open_logs(&self) -> Result<Vec<ArmLog>, Error> {
        let places = self.images.iter().enumerate();
        let places: BTreeMap<&str, usize> = places.map(|(k, it)| (&*it.name, k)).collect();
        // Each file is hashed once, and only where a log has it.
        let hashes: Vec<OnceCell<Option<String>>> = vec![OnceCell::new(); self.images.len()];
        let open = |arm: &Arm<'_>| {
            let mut lines = vec![None; self.images.len()];
            let log = LineLog::open(&arm.log, &arm.identity.to_string(), &mut |line, at| {
                // What failed may be mended: it is tried again.
                let found = FoundInImage::of_line(line).filter(|found| found.error.is_none());
                let Some((found, &place)) = found.and_then(|found| {
                    let place = places.get(&*found.image)?;
                    Some((found, place))
                }) else {
                    return;
                };
                let blake3 = hashes[place].get_or_init(|| (self.blake3)(&self.images[place]).ok());
                if blake3.as_deref() == Some(&*found.blake3) {
                    lines[place].get_or_insert(at);
                }
            })?;
            Ok(ArmLog { log, lines })
        };
        self.arms.iter().map(open).collect()
    }

    /// One thread: image after image, until there is none left.
    fn work(&self, to_look_at: &[u32], shared: &Mutex<Shared>) {
        let lock = || shared.lock().unwrap_or_else(PoisonError::into_inner);
        while !self.stop.load(Ordering::Relaxed) {
            let (turn, place, arms) = {
                let mut shared = lock();
                let turn = shared.next;
                let Some(place) = to_look_at.get(turn).copied() else {
                    return;
                };
                if shared.failure.is_some() {
                    return;
                }
                shared.next = turn + 1;
                (turn, place, shared.arms_without(place))
            };
            let found = self.look(place, &arms);
            let mut shared = lock();
            shared.waiting.insert(turn, found);
            if let Err(error) = shared.write_those_in_turn(to_look_at) {
                shared.failure = Some(error);
            }
            drop(shared);
            (self.tell)(StudyEvent::Image);
        }
    }

    /// What some arms, by their places, find in the image of a place.
    fn look(&self, place: u32, arms: &[usize]) -> Vec<FoundInArm> {
        let image = &self.images[place as usize];
        let (blake3, pixels) = match (self.blake3)(image) {
            Ok(blake3) => (blake3, (self.read)(image)),
            Err(error) => (String::new(), Err(error)),
        };
        let tell = |error: &Error| (self.tell)(StudyEvent::Failed(error.to_string()));
        match &pixels {
            // This was told when it could not be broken.
            Ok(_) | Err(Error::StudyUnbroken { .. }) => {}
            Err(error) => tell(error),
        }
        let found_by = |&k: &usize| {
            let found = match &pixels {
                Ok(pixels) => (self.arms[k].find)(place, image, pixels).map_err(|error| {
                    tell(&error);
                    error.to_string()
                }),
                Err(error) => Err(error.to_string()),
            };
            (k, FoundInImage::new(&image.name, blake3.clone(), found))
        };
        arms.iter().map(found_by).collect()
    }
}

impl Shared {
    /// The arms that have no line of the image of a place.
    fn arms_without(&self, place: u32) -> Vec<usize> {
        let logs = self.logs.iter().enumerate();
        let without = logs.filter(|(_, log)| log.lines[place as usize].is_none());
        without.map(|(k, _)| k).collect()
    }

    fn write_those_in_turn(&mut self, to_look_at: &[u32]) -> Result<(), Error> {
        while let Some(found) = self.waiting.remove(&self.n_written) {
            let place = to_look_at[self.n_written] as usize;
            for (arm, found) in found {
                let arm = &mut self.logs[arm];
                arm.lines[place] = Some(arm.log.append(&found.to_line()?)?);
                self.unseen.extend(found.unseen());
            }
            self.n_written += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
