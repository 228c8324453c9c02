//! One detector over one version of all images: clean, or under one condition.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use serde_json::Value;
use starbreak_dataset::LineLog;
use starbreak_detect::ImageToSee;
use starbreak_eval::Detection;

use super::arm_log::{FoundInImage, UnseenImage};
use crate::Error;

/// What is found in the image of a place.
type Find<'a> = dyn Fn(u32, &ImageToSee) -> Result<Vec<Detection>, Error> + Sync + 'a;

/// How an arm is run.
pub(super) struct ArmRun<'a> {
    /// Its log, from which it goes on.
    pub(super) log: &'a Path,
    /// What its lines are made from.
    pub(super) identity: Value,
    /// The images.
    pub(super) images: &'a [ImageToSee],
    /// BLAKE3 of the file that is looked at.
    pub(super) blake3: &'a (dyn Fn(&ImageToSee) -> Result<String, Error> + Sync),
    /// What is found in the image of this place.
    pub(super) find: &'a Find<'a>,
    /// Threads to use, 1 or more.
    pub(super) n_threads: usize,
    /// Once it is set no further image begins.
    pub(super) stop: &'a AtomicBool,
    /// Told after each image.
    pub(super) tell: &'a (dyn Fn() + Sync),
}

/// What the threads of a run share.
struct Shared {
    /// Place of the image that is begun next.
    next: u32,
    /// What is found before its turn to be written has come.
    waiting: BTreeMap<u32, FoundInImage>,
    /// Images that the log has.
    n_done: u32,
    /// Those of them without a result.
    unseen: Vec<UnseenImage>,
    log: LineLog,
    failure: Option<Error>,
}

impl ArmRun<'_> {
    /// Looks through the images that the log does not have yet. Comes to those without a result; none is returned where
    /// `stop` was set on the way.
    ///
    /// The log has a line for each image, in their order, whatever the threads do.
    pub(super) fn run(&self) -> Result<Option<Vec<UnseenImage>>, Error> {
        let mut n_done = 0_u32;
        let log = LineLog::open(self.log, &self.identity.to_string(), &mut |line| {
            let Some(found) = FoundInImage::of_line(line) else {
                return false;
            };
            let is_same = |image: &ImageToSee| {
                image.name == found.image
                    && (self.blake3)(image).is_ok_and(|blake3| blake3 == found.blake3)
            };
            let is_next = self.images.get(n_done as usize).is_some_and(is_same);
            // What failed may be mended: it is tried again, with all after it.
            let is_good = is_next && found.error.is_none();
            n_done += u32::from(is_good);
            is_good
        })?;
        (0..n_done).for_each(|_| (self.tell)());
        let shared = Mutex::new(Shared {
            next: n_done,
            waiting: BTreeMap::new(),
            n_done,
            unseen: Vec::new(),
            log,
            failure: None,
        });
        // Threads of the system and no pool: a thread of a pool that waits for the model would begin
        // another image meanwhile, and hold both.
        std::thread::scope(|scope| {
            for _ in 0..self.n_threads {
                scope.spawn(|| self.work(&shared));
            }
        });
        let shared = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = shared.failure {
            return Err(error);
        }
        let is_whole = shared.n_done as usize == self.images.len();
        Ok(is_whole.then_some(shared.unseen))
    }

    /// One thread: image after image, until there is none left.
    fn work(&self, shared: &Mutex<Shared>) {
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
            let found = match (self.blake3)(image) {
                Ok(blake3) => FoundInImage::new(&image.name, blake3, (self.find)(place, image)),
                Err(error) => FoundInImage::new(&image.name, String::new(), Err(error)),
            };
            let mut shared = lock();
            shared.waiting.insert(place, found);
            if let Err(error) = shared.write_those_in_turn() {
                shared.failure = Some(error);
            }
            drop(shared);
            (self.tell)();
        }
    }
}

impl Shared {
    fn write_those_in_turn(&mut self) -> Result<(), Error> {
        while let Some(found) = self.waiting.remove(&self.n_done) {
            self.log.append(&found.to_line()?)?;
            self.unseen.extend(found.unseen());
            self.n_done += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use std::path::PathBuf;
    use std::sync::atomic::AtomicU32;

    use serde_json::json;
    use starbreak_eval::{BoxPx, Detections};

    use super::super::arm_log::{read_whole, seen_files};
    use super::*;

    fn images() -> Vec<ImageToSee> {
        let image = |k| ImageToSee {
            name: format!("{k:03}.png"),
            path: PathBuf::new(),
        };
        (0..40).map(image).collect()
    }

    /// As many boxes as the place of the image, with numbers that need all their digits.
    fn find(place: u32, _image: &ImageToSee) -> Result<Vec<Detection>, Error> {
        let one = |k: u32| Detection {
            image: place,
            category: k,
            box_px: BoxPx {
                x: f64::from(k) / 3.0,
                y: 0.1,
                width: 1.0 / 7.0,
                height: 2.0,
            },
            score: 1.0 / f64::from(place + 1),
        };
        Ok((0..place).map(one).collect())
    }

    /// Another file in the place of one image.
    #[test]
    fn an_image_that_was_replaced_is_looked_at_again() {
        let dir = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        run(&dir, 1, &find, &go).unwrap();
        let mut images = images();
        images[20].path = PathBuf::from("another");
        let n_calls = AtomicU32::new(0);
        ArmRun {
            log: &dir.path().join("arm.jsonl"),
            identity: json!({ "model": 1 }),
            images: &images,
            blake3: &|image| Ok(format!("{} {}", image.name, image.path.display())),
            find: &|place, image| {
                n_calls.fetch_add(1, Ordering::Relaxed);
                find(place, image)
            },
            n_threads: 2,
            stop: &go,
            tell: &|| (),
        }
        .run()
        .unwrap();
        assert_eq!(n_calls.into_inner(), 20, "that one and all after it");
    }

    /// Detections of an arm that is whole, and images without a result.
    fn run(
        dir: &tempfile::TempDir,
        model: u32,
        find: &Find<'_>,
        stop: &AtomicBool,
    ) -> Option<(Detections, Vec<UnseenImage>)> {
        let (log, identity) = (dir.path().join("arm.jsonl"), json!({ "model": model }));
        let unseen = ArmRun {
            log: &log,
            identity: identity.clone(),
            images: &images(),
            blake3: &|image| Ok(format!("{} {}", image.name, image.path.display())),
            find,
            n_threads: 3,
            stop,
            tell: &|| (),
        }
        .run()
        .unwrap()?;
        let detections = read_whole(&log, &identity.to_string(), &images()).unwrap();
        Some((detections, unseen))
    }

    #[test]
    fn what_was_interrupted_goes_on_and_comes_to_the_same() {
        let (dir, other_dir) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let go = AtomicBool::new(false);
        let whole = run(&other_dir, 1, &find, &go).unwrap();
        assert_eq!(whole.0.items.len(), 780, "0 to 39 boxes");

        let stop = AtomicBool::new(false);
        let interrupted = |place: u32, image: &ImageToSee| {
            stop.fetch_or(place > 10, Ordering::Relaxed);
            find(place, image)
        };
        assert_eq!(run(&dir, 1, &interrupted, &stop), None, "not whole");
        let n_calls = AtomicU32::new(0);
        let counted = |place: u32, image: &ImageToSee| {
            n_calls.fetch_add(1, Ordering::Relaxed);
            find(place, image)
        };
        assert_eq!(
            run(&dir, 1, &counted, &go),
            Some(whole),
            "the same to the last bit"
        );
        assert!(n_calls.into_inner() < 40, "what was done is not done again");
    }

    #[test]
    fn a_line_that_was_altered_is_looked_for_again() {
        let dir = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        let whole = run(&dir, 1, &find, &go).unwrap();
        let log = dir.path().join("arm.jsonl");
        let written = std::fs::read_to_string(&log).unwrap();
        // A coordinate of another value, and a box less.
        for (from, to) in [
            ("0.1,", "0.2,"),
            ("[0,[0.0,0.1,0.14285714285714285,2.0],0.5]", ""),
        ] {
            assert!(written.contains(from), "{from}");
            std::fs::write(&log, written.replacen(from, to, 1)).unwrap();
            assert_eq!(run(&dir, 1, &find, &go).unwrap(), whole, "{from}");
            assert_eq!(std::fs::read_to_string(&log).unwrap(), written, "mended");
        }
    }

    #[test]
    fn a_log_that_is_damaged_after_the_arm_is_refused_by_the_first_image_without_a_line() {
        let dir = tempfile::tempdir().unwrap();
        run(&dir, 1, &find, &AtomicBool::new(false)).unwrap();
        let (log, identity) = (dir.path().join("arm.jsonl"), r#"{"model":1}"#);
        let written = std::fs::read_to_string(&log).unwrap();
        let lines: Vec<&str> = written.lines().collect();
        let without = |k: usize| [&lines[..=k], &lines[k + 2..]].concat().join("\n") + "\n";
        let swapped = written.replacen("0.1,", "0.2,", 1);
        for (damaged, image) in [
            (String::new(), "000.png"),
            (without(0), "000.png"),
            (without(20), "020.png"),
            (without(39), "039.png"),
            (written[..written.len() - 9].to_owned(), "039.png"),
            (written.replacen("\"model\":1", "\"model\":2", 1), "000.png"),
            (swapped, "001.png"),
        ] {
            std::fs::write(&log, damaged).unwrap();
            let error = read_whole(&log, identity, &images()).unwrap_err();
            let is_it = matches!(&error, Error::StudyLog { image: first, .. } if first == image);
            assert!(is_it, "{image}: {error}");
            assert!(error.to_string().contains("run the study again"), "{error}");
        }
        std::fs::remove_file(&log).unwrap();
        assert!(read_whole(&log, identity, &images()).is_err(), "no log");
        std::fs::write(&log, &written).unwrap();
        let found = read_whole(&log, identity, &images()).unwrap();
        assert_eq!(found.items.len(), 780, "put back");
    }

    #[test]
    fn another_model_begins_anew() {
        let dir = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        run(&dir, 1, &find, &go).unwrap();
        let (found, _) = run(&dir, 2, &|_, _| Ok(Vec::new()), &go).unwrap();
        assert!(found.items.is_empty(), "of the second");
    }

    #[test]
    fn an_image_that_cannot_be_read_is_listed_and_tried_again() {
        let dir = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        let fails = |place: u32, image: &ImageToSee| match place {
            3 => Err(Error::NoSize),
            _ => find(place, image),
        };
        let (_, unseen) = run(&dir, 1, &fails, &go).unwrap();
        let seen = seen_files(&dir.path().join("arm.jsonl")).unwrap();
        assert_eq!(seen.len(), 39, "all but that one");
        assert_eq!(seen["004.png"], "004.png ", "the hash of its file");
        assert_eq!(unseen.len(), 1, "one");
        assert_eq!(unseen[0].name, "003.png", "that one");
        assert_eq!(run(&dir, 1, &find, &go).unwrap().1, [], "mended");
    }
}
