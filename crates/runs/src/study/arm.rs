//! Detectors over one version of all images: clean, or under one condition.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use image::RgbImage;
use serde_json::Value;
use starbreak_dataset::LineLog;
use starbreak_detect::ImageToSee;
use starbreak_eval::Detection;

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
    /// Told for each image that all logs have, and after each other one.
    pub(super) tell: &'a (dyn Fn() + Sync),
}

/// What the threads of a run share.
struct Shared {
    /// Place of the image that is begun next.
    next: u32,
    /// What is found before its turn to be written has come.
    waiting: BTreeMap<u32, Vec<FoundInArm>>,
    /// Images that all logs have.
    n_done: u32,
    /// Those of them without a result in some arm.
    unseen: Vec<UnseenImage>,
    /// The log of each arm, in their order.
    logs: Vec<LineLog>,
    failure: Option<Error>,
}

/// What an arm, by its place among them, found in an image.
type FoundInArm = (usize, FoundInImage);

impl ArmsRun<'_> {
    /// Looks through the images that some log does not have yet. Comes to those without a result; none is returned where
    /// `stop` was set on the way.
    ///
    /// Each log has a line for each image, in their order, whatever the threads do.
    pub(super) fn run(&self) -> Result<Option<Vec<UnseenImage>>, Error> {
        let opened: Result<Vec<(LineLog, u32)>, Error> =
            self.arms.iter().map(|arm| self.open(arm)).collect();
        let (logs, n_known): (Vec<LineLog>, Vec<u32>) = opened?.into_iter().unzip();
        let Some(n_done) = n_known.iter().min().copied() else {
            return Ok(Some(Vec::new()));
        };
        (0..n_done).for_each(|_| (self.tell)());
        let shared = Mutex::new(Shared {
            next: n_done,
            waiting: BTreeMap::new(),
            n_done,
            unseen: Vec::new(),
            logs,
            failure: None,
        });
        // Threads of the system and no pool: a thread of a pool that waits for the model would begin
        // another image meanwhile, and hold both.
        std::thread::scope(|scope| {
            for _ in 0..self.n_threads {
                scope.spawn(|| self.work(&n_known, &shared));
            }
        });
        let shared = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = shared.failure {
            return Err(error);
        }
        let is_whole = shared.n_done as usize == self.images.len();
        Ok(is_whole.then_some(shared.unseen))
    }

    /// The log of an arm, and how many images it has.
    fn open(&self, arm: &Arm<'_>) -> Result<(LineLog, u32), Error> {
        let mut n_known = 0_u32;
        let log = LineLog::open(&arm.log, &arm.identity.to_string(), &mut |line| {
            let Some(found) = FoundInImage::of_line(line) else {
                return false;
            };
            let is_same = |image: &ImageToSee| {
                image.name == found.image
                    && (self.blake3)(image).is_ok_and(|blake3| blake3 == found.blake3)
            };
            let is_next = self.images.get(n_known as usize).is_some_and(is_same);
            // What failed may be mended: it is tried again, with all after it.
            let is_good = is_next && found.error.is_none();
            n_known += u32::from(is_good);
            is_good
        })?;
        Ok((log, n_known))
    }

    /// One thread: image after image, until there is none left.
    fn work(&self, n_known: &[u32], shared: &Mutex<Shared>) {
        let lock = || shared.lock().unwrap_or_else(PoisonError::into_inner);
        while !self.stop.load(Ordering::Relaxed) {
            let place = {
                let mut shared = lock();
                let place = shared.next;
                if shared.failure.is_some() {
                    return;
                }
                shared.next = place.saturating_add(1);
                place
            };
            let Some(image) = self.images.get(place as usize) else {
                return;
            };
            let found = self.look(place, image, n_known);
            let mut shared = lock();
            shared.waiting.insert(place, found);
            if let Err(error) = shared.write_those_in_turn() {
                shared.failure = Some(error);
            }
            drop(shared);
            (self.tell)();
        }
    }

    /// What the arms that do not know an image yet find in it.
    fn look(&self, place: u32, image: &ImageToSee, n_known: &[u32]) -> Vec<FoundInArm> {
        let (blake3, pixels) = match (self.blake3)(image) {
            Ok(blake3) => (blake3, (self.read)(image)),
            Err(error) => (String::new(), Err(error)),
        };
        let arms = self.arms.iter().enumerate();
        arms.filter(|(k, _)| n_known[*k] <= place)
            .map(|(k, arm)| {
                let found = match &pixels {
                    Ok(pixels) => {
                        (arm.find)(place, image, pixels).map_err(|error| error.to_string())
                    }
                    Err(error) => Err(error.to_string()),
                };
                (k, FoundInImage::new(&image.name, blake3.clone(), found))
            })
            .collect()
    }
}

impl Shared {
    fn write_those_in_turn(&mut self) -> Result<(), Error> {
        while let Some(found) = self.waiting.remove(&self.n_done) {
            for (arm, found) in found {
                self.logs[arm].append(&found.to_line()?)?;
                self.unseen.extend(found.unseen());
            }
            self.n_done += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
