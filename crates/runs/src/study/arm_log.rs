//! What a detector found, clean or under one condition: a log with a line for each image.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};
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
    pub(super) blake3: String,
    /// Category's place in the labels, `x, y, width, height` in px, and score.
    boxes: Vec<(u32, [f64; 4], f64)>,
    /// Why nothing could be looked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) error: Option<String>,
}

/// What stands between a line and its check, the first 16 hexadecimal digits of BLAKE3 of the line without it. By it a
/// line that was altered since is told from one that was written.
const BEFORE_CHECK: &str = ",\"check\":\"";

impl FoundInImage {
    pub(super) fn new(name: &str, blake3: String, result: Result<Vec<Detection>, String>) -> Self {
        let image = name.to_owned();
        match result {
            Ok(found) => Self {
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
            Err(error) => Self {
                image,
                blake3,
                boxes: Vec::new(),
                error: Some(error),
            },
        }
    }

    /// The line of a log; none for one that was altered.
    pub(super) fn of_line(line: &str) -> Option<Self> {
        let (found, check) = line.strip_suffix("\"}")?.rsplit_once(BEFORE_CHECK)?;
        let found = format!("{found}}}");
        let is_as_written = check_of(&found) == check;
        serde_json::from_str(&found).ok().filter(|_| is_as_written)
    }

    pub(super) fn to_line(&self) -> Result<String, Error> {
        let found = serde_json::to_string(self).map_err(|error| Error::StudyLine {
            image: self.image.clone(),
            reason: error.to_string(),
        })?;
        let check = check_of(&found);
        let open = found.strip_suffix('}').unwrap_or(&found);
        Ok(format!("{open}{BEFORE_CHECK}{check}\"}}"))
    }

    /// That it has no result, where that is so.
    pub(super) fn unseen(&self) -> Option<UnseenImage> {
        let reason = self.error.clone()?;
        Some(UnseenImage {
            name: self.image.clone(),
            reason,
        })
    }

    /// The detections, in the image of this place.
    fn detections(self, image: u32) -> impl Iterator<Item = Detection> {
        let boxes = self.boxes.into_iter();
        boxes.map(move |(category, [x, y, width, height], score)| Detection {
            image,
            category,
            box_px: BoxPx {
                x,
                y,
                width,
                height,
            },
            score,
        })
    }
}

fn check_of(found: &str) -> String {
    blake3_hex(found.as_bytes()).chars().take(16).collect()
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

/// What the log of an arm with this identity has, image by image as far as it has these in their order; none where
/// there is no such log. Comes to how many it has, and whether more lines follow after the last image: those of a run
/// that tried images again and was interrupted.
pub(super) fn read_found<'a>(
    log: &Path,
    identity: &str,
    images: impl IntoIterator<Item = &'a ImageToSee>,
    take: &mut dyn FnMut(FoundInImage),
) -> Result<Option<(usize, bool)>, Error> {
    if !LineLog::is_of(log, identity)? {
        return Ok(None);
    }
    let mut images = images.into_iter();
    let (mut n_found, mut is_over, mut has_more) = (0, false, false);
    LineLog::read(log, &mut |line| {
        let next = images.next();
        has_more |= next.is_none();
        let image = next.filter(|_| !is_over);
        let found = FoundInImage::of_line(line).zip(image);
        match found.filter(|(found, image)| found.image == image.name) {
            Some((found, _)) => {
                n_found += 1;
                take(found);
            }
            None => is_over = true,
        }
    })?;
    Ok(Some((n_found, has_more)))
}

/// What an arm that is whole found, from its log: in the order of the images, and of each image as the detector gave
/// them.
///
/// # Errors
/// [`Error::StudyLog`] where the log is not as the arm wrote it.
pub(super) fn read_whole(
    log: &Path,
    identity: &str,
    images: &[ImageToSee],
) -> Result<Detections, Error> {
    let mut detections = Detections::default();
    let mut place = 0;
    let found = read_found(log, identity, images, &mut |found| {
        detections.items.extend(found.detections(place));
        place += 1;
    })?;
    match images.get(found.map_or(0, |(n_found, _)| n_found)) {
        None => Ok(detections),
        Some(first) => Err(Error::StudyLog {
            log: log.to_owned(),
            image: first.name.clone(),
        }),
    }
}

/// Writes the log of an arm that is whole, in the order of the images, in place of any that is there. Comes to the
/// images without a result.
pub(super) fn write_whole(
    log: &Path,
    identity: &str,
    all: impl IntoIterator<Item = FoundInImage>,
) -> Result<Vec<UnseenImage>, Error> {
    let mut log = LineLog::open(log, identity, &mut |_, _| ())?;
    let (mut lines, mut unseen) = (Vec::new(), Vec::new());
    for found in all {
        lines.push(log.append(&found.to_line()?)?);
        unseen.extend(found.unseen());
    }
    log.close_with(lines.into_iter())?;
    Ok(unseen)
}

/// An image that some detector could not look at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnseenImage {
    /// Its name in the source.
    pub name: String,
    /// Why.
    pub reason: String,
}
