//! One detector over one version of all images: clean, or under one condition.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use serde_json::Value;
use starbreak_dataset::{LineLog, blake3_hex};
use starbreak_detect::ImageToSee;
use starbreak_eval::{BoxPx, Detection, Detections};

use crate::Error;

/// What a detector found in one image, as a line of the log of its arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct FoundInImage {
    /// Name of the image in the source.
    pub(super) image: String,
    /// BLAKE3 of the file that was looked at, hexadecimal; empty where it could not be read.
    #[serde(default)]
    blake3: String,
    /// Category's place in the labels, `x, y, width, height` in px, and score.
    boxes: Vec<(u32, [f64; 4], f64)>,
    /// Why nothing could be looked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

/// A line of the log: by the hash, a line that was altered since is told from one that was written.
#[derive(Serialize, Deserialize)]
struct Line {
    #[serde(flatten)]
    found: FoundInImage,
    /// BLAKE3 of the line without this, the first 16 hexadecimal digits.
    check: String,
}

impl FoundInImage {
    /// The line of a log; none for one that was altered.
    fn of_line(line: &str) -> Option<Self> {
        let line: Line = serde_json::from_str(line).ok()?;
        (line.found.check().ok()? == line.check).then_some(line.found)
    }

    fn to_line(&self) -> serde_json::Result<String> {
        serde_json::to_string(&Line {
            found: self.clone(),
            check: self.check()?,
        })
    }

    fn to_log_line(&self) -> Result<String, Error> {
        self.to_line().map_err(|error| Error::StudyLine {
            image: self.image.clone(),
            reason: error.to_string(),
        })
    }

    fn check(&self) -> serde_json::Result<String> {
        let hash = blake3_hex(serde_json::to_string(self)?.as_bytes());
        Ok(hash.chars().take(16).collect())
    }
}

/// The names of the images that the log of an arm has, with the BLAKE3 of the files that were looked
/// at; without those that could not be.
pub(super) fn seen_files(log: &Path) -> Result<BTreeMap<String, String>, Error> {
    let mut seen = BTreeMap::new();
    LineLog::read(log, &mut |line| {
        if let Some(found) = FoundInImage::of_line(line)
            && found.error.is_none()
        {
            seen.insert(found.image, found.blake3);
        }
    })?;
    Ok(seen)
}

/// What the log of an arm with this identity has, image by image; none where there is no such log.
pub(super) fn found_by(log: &Path, identity: &str) -> Result<Option<Vec<FoundInImage>>, Error> {
    if !LineLog::is_of(log, identity)? {
        return Ok(None);
    }
    let mut all = Vec::new();
    LineLog::read(log, &mut |line| all.extend(FoundInImage::of_line(line)))?;
    Ok(Some(all))
}

/// Writes the log of an arm that is whole, in the order of the images, in place of any that is there.
pub(super) fn write_whole(
    log: &Path,
    identity: &str,
    found: Vec<FoundInImage>,
) -> Result<Arm, Error> {
    let mut log = LineLog::open(log, identity, &mut |_| false)?;
    for one in &found {
        log.append(&one.to_log_line()?)?;
    }
    Ok(collected(found))
}

/// An image that no detector could look at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnseenImage {
    /// Its name in the source.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// What came out of an arm, once it is whole.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Arm {
    /// In the order of the images, and of each image as the detector gave them.
    pub(super) detections: Detections,
    /// Images without a result.
    pub(super) unseen: Vec<UnseenImage>,
}

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
    done: Vec<FoundInImage>,
    log: LineLog,
    failure: Option<Error>,
}

impl ArmRun<'_> {
    /// Looks through the images that the log does not have yet; none is returned where `stop` was
    /// set on the way.
    ///
    /// The log has a line for each image, in their order, whatever the threads do.
    pub(super) fn run(&self) -> Result<Option<Arm>, Error> {
        let mut done: Vec<FoundInImage> = Vec::new();
        let log = LineLog::open(self.log, &self.identity.to_string(), &mut |line| {
            let Some(found) = FoundInImage::of_line(line) else {
                return false;
            };
            let is_same = |image: &ImageToSee| {
                image.name == found.image
                    && (self.blake3)(image).is_ok_and(|blake3| blake3 == found.blake3)
            };
            let is_next = self.images.get(done.len()).is_some_and(is_same);
            // What failed may be mended: it is tried again, with all after it.
            let is_good = is_next && found.error.is_none();
            if is_good {
                done.push(found);
            }
            is_good
        })?;
        done.iter().for_each(|_| (self.tell)());
        let shared = Mutex::new(Shared {
            next: u32::try_from(done.len()).unwrap_or(u32::MAX),
            waiting: BTreeMap::new(),
            done,
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
        let is_whole = shared.done.len() == self.images.len();
        Ok(is_whole.then(|| collected(shared.done)))
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
                Ok(blake3) => found_in(&image.name, blake3, (self.find)(place, image)),
                Err(error) => found_in(&image.name, String::new(), Err(error)),
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
        let turn = |done: &Vec<FoundInImage>| u32::try_from(done.len()).unwrap_or(u32::MAX);
        while let Some(found) = self.waiting.remove(&turn(&self.done)) {
            self.log.append(&found.to_log_line()?)?;
            self.done.push(found);
        }
        Ok(())
    }
}

fn found_in(name: &str, blake3: String, result: Result<Vec<Detection>, Error>) -> FoundInImage {
    let image = name.to_owned();
    match result {
        Ok(found) => FoundInImage {
            image,
            blake3,
            boxes: found
                .iter()
                .map(|detection| {
                    let b = detection.box_px;
                    let sides = [b.x, b.y, b.width, b.height];
                    (detection.category, sides, detection.score)
                })
                .collect(),
            error: None,
        },
        Err(error) => FoundInImage {
            image,
            blake3,
            boxes: Vec::new(),
            error: Some(error.to_string()),
        },
    }
}

fn collected(done: Vec<FoundInImage>) -> Arm {
    let mut arm = Arm {
        detections: Detections::default(),
        unseen: Vec::new(),
    };
    for (image, found) in (0..).zip(done) {
        if let Some(reason) = found.error {
            arm.unseen.push(UnseenImage {
                name: found.image,
                reason,
            });
            continue;
        }
        let items = found.boxes.into_iter();
        arm.detections
            .items
            .extend(
                items.map(|(category, [x, y, width, height], score)| Detection {
                    image,
                    category,
                    box_px: BoxPx {
                        x,
                        y,
                        width,
                        height,
                    },
                    score,
                }),
            );
    }
    arm
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "a test may panic")]

    use std::path::PathBuf;
    use std::sync::atomic::AtomicU32;

    use serde_json::json;

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

    fn run(dir: &tempfile::TempDir, model: u32, find: &Find<'_>, stop: &AtomicBool) -> Option<Arm> {
        ArmRun {
            log: &dir.path().join("arm.jsonl"),
            identity: json!({ "model": model }),
            images: &images(),
            blake3: &|image| Ok(format!("{} {}", image.name, image.path.display())),
            find,
            n_threads: 3,
            stop,
            tell: &|| (),
        }
        .run()
        .unwrap()
    }

    #[test]
    fn what_was_interrupted_goes_on_and_comes_to_the_same() {
        let (dir, other_dir) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let go = AtomicBool::new(false);
        let whole = run(&other_dir, 1, &find, &go).unwrap();
        assert_eq!(whole.detections.items.len(), 780, "0 to 39 boxes");

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
    fn another_model_begins_anew() {
        let dir = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        run(&dir, 1, &find, &go).unwrap();
        let arm = run(&dir, 2, &|_, _| Ok(Vec::new()), &go).unwrap();
        assert!(arm.detections.items.is_empty(), "of the second");
    }

    #[test]
    fn an_image_that_cannot_be_read_is_listed_and_tried_again() {
        let dir = tempfile::tempdir().unwrap();
        let go = AtomicBool::new(false);
        let fails = |place: u32, image: &ImageToSee| match place {
            3 => Err(Error::NoSize),
            _ => find(place, image),
        };
        let unseen = run(&dir, 1, &fails, &go).unwrap().unseen;
        let seen = seen_files(&dir.path().join("arm.jsonl")).unwrap();
        assert_eq!(seen.len(), 39, "all but that one");
        assert_eq!(seen["004.png"], "004.png ", "the hash of its file");
        assert_eq!(unseen.len(), 1, "one");
        assert_eq!(unseen[0].name, "003.png", "that one");
        assert_eq!(run(&dir, 1, &find, &go).unwrap().unseen, [], "mended");
    }
}
