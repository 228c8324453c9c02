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

/// What is found in the pixels of the image of a place.
type Find<'a> = dyn Fn(u32, &RgbImage) -> Result<Vec<Detection>, Error> + Sync + 'a;

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
    /// One or more.
    pub(super) arms: &'a [Arm<'a>],
    /// The images.
    pub(super) images: &'a [ImageToSee],
    /// BLAKE3 of the file that is looked at.
    pub(super) blake3: &'a (dyn Fn(&ImageToSee) -> Result<String, Error> + Sync),
    /// The pixels of that file.
    pub(super) read: &'a (dyn Fn(&ImageToSee) -> Result<RgbImage, Error> + Sync),
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
    waiting: BTreeMap<u32, Vec<FoundInArm>>,
    /// Images that all logs have.
    n_done: u32,
    /// Those of them without a result in some arm.
    unseen: Vec<UnseenImage>,
    /// Of each arm.
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
        let n_done = n_known.iter().min().copied().unwrap_or(0);
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

    /// What those arms find in an image that do not know it yet.
    fn look(&self, place: u32, image: &ImageToSee, n_known: &[u32]) -> Vec<FoundInArm> {
        let (blake3, pixels) = match (self.blake3)(image) {
            Ok(blake3) => (blake3, (self.read)(image)),
            Err(error) => (String::new(), Err(error)),
        };
        let arms = self.arms.iter().enumerate();
        arms.filter(|(k, _)| n_known[*k] <= place)
            .map(|(k, arm)| {
                let found = match &pixels {
                    Ok(pixels) => (arm.find)(place, pixels).map_err(|error| error.to_string()),
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
    #[expect(clippy::unnecessary_wraps, reason = "as an arm has it")]
    fn find(place: u32, _pixels: &RgbImage) -> Result<Vec<Detection>, Error> {
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
        let counted = |place: u32, pixels: &RgbImage| {
            n_calls.fetch_add(1, Ordering::Relaxed);
            find(place, pixels)
        };
        run_arms(&[arm(&dir, 1, &counted)], &images, &go, &read);
        assert_eq!(n_calls.into_inner(), 20, "that one and all after it");
    }

    #[expect(clippy::unnecessary_wraps, reason = "as a run has it")]
    fn read(_image: &ImageToSee) -> Result<RgbImage, Error> {
        Ok(RgbImage::new(1, 1))
    }

    fn arm<'a>(dir: &tempfile::TempDir, model: u32, find: &'a Find<'a>) -> Arm<'a> {
        Arm {
            log: dir.path().join("arm.jsonl"),
            identity: json!({ "model": model }),
            find: Box::new(find),
        }
    }

    fn run_arms(
        arms: &[Arm<'_>],
        images: &[ImageToSee],
        stop: &AtomicBool,
        read: &(dyn Fn(&ImageToSee) -> Result<RgbImage, Error> + Sync),
    ) -> Option<Vec<UnseenImage>> {
        let run = ArmsRun {
            arms,
            images,
            blake3: &|image| Ok(format!("{} {}", image.name, image.path.display())),
            read,
            n_threads: 3,
            stop,
            tell: &|| (),
        };
        run.run().unwrap()
    }

    /// Detections of an arm that is whole, and images without a result.
    fn run(
        dir: &tempfile::TempDir,
        model: u32,
        find: &Find<'_>,
        stop: &AtomicBool,
    ) -> Option<(Detections, Vec<UnseenImage>)> {
        let arm = arm(dir, model, find);
        let unseen = run_arms(std::slice::from_ref(&arm), &images(), stop, &read)?;
        let detections = read_whole(&arm.log, &arm.identity.to_string(), &images()).unwrap();
        Some((detections, unseen))
    }

    #[test]
    fn an_image_is_read_once_for_all_arms_that_do_not_know_it() {
        let dirs = [0; 3].map(|_| tempfile::tempdir().unwrap());
        let go = AtomicBool::new(false);
        let log = |k: usize| std::fs::read(dirs[k].path().join("arm.jsonl")).unwrap();
        let fewer = |place: u32, pixels: &RgbImage| find(place / 2, pixels);
        run(&dirs[0], 1, &find, &go).unwrap();
        run(&dirs[1], 2, &fewer, &go).unwrap();
        let alone = [log(0), log(1)];

        // The first goes on after 11 images or some more, the second is whole, the third begins.
        std::fs::remove_file(dirs[0].path().join("arm.jsonl")).unwrap();
        let stop = AtomicBool::new(false);
        let interrupted = |place: u32, pixels: &RgbImage| {
            stop.fetch_or(place > 10, Ordering::Relaxed);
            find(place, pixels)
        };
        assert_eq!(run(&dirs[0], 1, &interrupted, &stop), None, "not whole");
        let n_known = seen_files(&dirs[0].path().join("arm.jsonl")).unwrap().len();
        let never = |_: u32, _: &RgbImage| -> Result<Vec<Detection>, Error> {
            panic!("a whole arm is asked")
        };
        let n_reads = AtomicU32::new(0);
        let counted = |image: &ImageToSee| {
            n_reads.fetch_add(1, Ordering::Relaxed);
            read(image)
        };
        let places = Mutex::new(Vec::new());
        let noted = |place: u32, pixels: &RgbImage| {
            places.lock().unwrap().push(place as usize);
            find(place, pixels)
        };
        let arms = [
            arm(&dirs[0], 1, &noted),
            arm(&dirs[1], 2, &never),
            arm(&dirs[2], 1, &find),
        ];
        assert_eq!(run_arms(&arms, &images(), &go, &counted), Some(Vec::new()));
        assert_eq!(n_reads.into_inner(), 40, "each image once");
        let mut places = places.lock().unwrap().clone();
        places.sort_unstable();
        assert_eq!(places, (n_known..40).collect::<Vec<_>>(), "what it had not");
        assert!(log(0) == alone[0] && log(1) == alone[1] && log(2) == alone[0]);
        let unread = |_: &ImageToSee| -> Result<RgbImage, Error> { panic!("read for nothing") };
        run_arms(&arms, &images(), &go, &unread).unwrap();
    }

    #[test]
    fn an_image_that_cannot_be_decoded_is_without_a_result_in_each_arm() {
        let dirs = [0; 2].map(|_| tempfile::tempdir().unwrap());
        let fails = |image: &ImageToSee| match image.name.as_str() {
            "007.png" => Err(Error::NoSize),
            _ => read(image),
        };
        let arms = [arm(&dirs[0], 1, &find), arm(&dirs[1], 2, &find)];
        let unseen = run_arms(&arms, &images(), &AtomicBool::new(false), &fails).unwrap();
        let names: Vec<&str> = unseen.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["007.png"; 2]);
        assert_eq!(unseen[0].reason, Error::NoSize.to_string());
    }

    #[test]
    fn what_was_interrupted_goes_on_and_comes_to_the_same() {
        let (dir, other_dir) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let go = AtomicBool::new(false);
        let whole = run(&other_dir, 1, &find, &go).unwrap();
        assert_eq!(whole.0.items.len(), 780, "0 to 39 boxes");

        let stop = AtomicBool::new(false);
        let interrupted = |place: u32, pixels: &RgbImage| {
            stop.fetch_or(place > 10, Ordering::Relaxed);
            find(place, pixels)
        };
        assert_eq!(run(&dir, 1, &interrupted, &stop), None, "not whole");
        let n_calls = AtomicU32::new(0);
        let counted = |place: u32, pixels: &RgbImage| {
            n_calls.fetch_add(1, Ordering::Relaxed);
            find(place, pixels)
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
        let fails = |place: u32, pixels: &RgbImage| match place {
            3 => Err(Error::NoSize),
            _ => find(place, pixels),
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
