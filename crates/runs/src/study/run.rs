//! All arms of a study: each detector over the clean images and over each condition's.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};
use starbreak::{DEFAULT_PRESET, Recipe};
use starbreak_dataset::{
    DatasetError, Encoding, ImageFormat, ImageLimits, JpegQuality, LineLog, SetLayout, Source,
    blake3_file, decode_image, encode_image_as, read_image, refuse_inside_set,
};
use starbreak_detect::{Detector, ImageToSee, LabelMap};
use starbreak_eval::{BoxPx, Detection, Detections, GroundTruth};

use super::Condition;
use super::arm::{Arm, ArmsRun, Hash, Read};
use super::arm_log::{UnseenImage, read_whole, seen_files};
use super::identity::{DetectorIdentity, Identity};
use super::set::{make_set, why_none_breaks};
use crate::generate::{Event, GenerateReport, ItemFailure, Survey};
use crate::{Error, Patterns};

/// A detector of a study.
#[derive(Debug)]
pub struct StudyDetector {
    /// Its name, which is that of its folder.
    pub name: String,
    /// SHA-256 of its file, hexadecimal.
    pub sha256: String,
    /// What finds boxes.
    pub detector: Detector,
    /// Its classes to the categories of the labels.
    pub map: LabelMap,
}

/// What a study is made of.
#[derive(Debug)]
pub struct StudyPlan<'a> {
    /// The dataset.
    pub source: &'a Source,
    /// Which images there are.
    pub survey: &'a Survey,
    /// The images in the order of the labels, to which detections refer.
    pub images: &'a [ImageToSee],
    /// The detectors.
    pub detectors: &'a [StudyDetector],
    /// What is done to the glass.
    pub conditions: &'a [Condition],
    /// The photographs of broken glass of those conditions that are not simulated.
    pub photos: Option<&'a Patterns>,
    /// The folder that everything is written into.
    pub out: &'a Path,
    /// Threads to use, 1 or more.
    pub n_threads: usize,
    /// Whether damaged images stay on the disk. Otherwise those of a condition are removed once all detectors have looked
    /// at them; masks, records with the hashes of the images, and what was found stay.
    pub keeps_images: bool,
}

/// What a study does at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step<'a> {
    /// The images of a condition are broken.
    Breaking(&'a Condition),
    /// All detectors look at the images, clean or under a condition.
    Detecting(Option<&'a Condition>),
    /// The sets of images are compared.
    Comparing,
}

/// Something that a study tells as it happens.
#[derive(Debug)]
pub enum StudyEvent<'a> {
    /// A step begins; it has so many images.
    Begun(Step<'a>, u64),
    /// So many images of the step were done by an earlier run.
    Known(u64),
    /// An image of the step is done.
    Image,
    /// An image cannot be broken or looked at: why.
    Failed(String),
}

/// What came of it, once all detectors have looked at everything. What was made lies in the folder of the plan, what they
/// found in their logs: [`StudyPlan::detections`].
#[derive(Debug)]
pub struct StudyRuns {
    /// Images that some detector could not look at in some arm, by their names, in order.
    pub unseen: Vec<UnseenImage>,
}

/// BLAKE3 of images that have been broken, by name, and those that cannot be.
type SeenImages = (BTreeMap<String, String>, Vec<ItemFailure>);

impl StudyPlan<'_> {
    /// Breaks all images, and looks at all of them; goes on where an earlier run was interrupted.
    /// None where `stop` was set on the way.
    ///
    /// A clean image that is a JPEG is written and read again as its cracked twins are, so that the
    /// glass is all that differs.
    ///
    /// `truth` are the labels of the images. The folder may be that of an earlier run of this study, or of one
    /// with fewer detectors or conditions.
    ///
    /// # Errors
    /// [`Error::AnotherStudy`] for the folder of another study, [`Error::LabeledSize`] for labels of images of
    /// another size, [`Error::StudyMoves`] for a condition that moves what labels name, all before anything is written.
    /// [`Error`] for folders that cannot be used and for what would fail every image. An image that
    /// fails alone is in [`StudyRuns::unseen`].
    pub fn run(
        &self,
        truth: &GroundTruth,
        stop: &AtomicBool,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<Option<StudyRuns>, Error> {
        self.begin(&Identity::of(self, truth)?, truth)?;
        let Some(mut unseen) = self.look_at_clean(stop, tell)? else {
            return Ok(None);
        };
        for condition in self.conditions {
            if self.under(condition, &mut unseen, stop, tell)?.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(StudyRuns {
            unseen: each_once(unseen),
        }))
    }

    /// Refuses what [`StudyPlan::run`] would refuse before it writes anything.
    ///
    /// # Errors
    /// As [`StudyPlan::run`].
    pub fn check(&self, truth: &GroundTruth) -> Result<(), Error> {
        self.check_as(&Identity::of(self, truth)?, truth)
    }

    /// Refuses a folder with another study, or with something else.
    ///
    /// # Errors
    /// [`Error::AnotherStudy`], [`Error::NotAStudy`].
    pub fn check_folder(&self, truth: &GroundTruth) -> Result<(), Error> {
        Identity::of(self, truth)?.check(self.out)
    }

    fn check_as(&self, identity: &Identity, truth: &GroundTruth) -> Result<(), Error> {
        refuse_inside_set(self.out)?;
        self.source.refuse_output_at(self.out)?;
        identity.check(self.out)?;
        self.check_files()?;
        self.check_sizes(truth)?;
        self.refuse_moved_labels()?;
        self.try_detectors(self.quality()?)
    }

    /// Refuses what cannot be studied, and makes the folder that of the study.
    pub(super) fn begin(&self, identity: &Identity, truth: &GroundTruth) -> Result<(), Error> {
        self.check_as(identity, truth)?;
        identity.write(self.out)
    }

    /// What a detector found on the clean images, or under a condition, once it has looked at all of them: from its log,
    /// by the places of the plan's images.
    ///
    /// # Errors
    /// [`Error::StudyLog`] where the log is not as it was written.
    pub fn detections(
        &self,
        detector: &StudyDetector,
        condition: Option<&Condition>,
    ) -> Result<Detections, Error> {
        let identity = self.log_identity(detector, condition)?.to_string();
        read_whole(&self.log(detector, condition), &identity, self.images)
    }

    /// Lets all detectors look at the clean images. Comes to those without a result; none where `stop` was set on the
    /// way.
    pub(super) fn look_at_clean(
        &self,
        stop: &AtomicBool,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<Option<Vec<UnseenImage>>, Error> {
        let quality = self.quality()?;
        let read = |image: &ImageToSee| clean_image(&image.path, quality);
        let hash = |image: &ImageToSee| Ok(blake3_file(&image.path)?);
        self.look(None, (&read, &hash), stop, tell)
    }

    /// Breaks all images under a condition, and lets all detectors look at them. Of a study that keeps no images, those of
    /// this condition are removed at the end; where all have been looked at before, none is made.
    pub(super) fn under(
        &self,
        condition: &Condition,
        unseen: &mut Vec<UnseenImage>,
        stop: &AtomicBool,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<Option<()>, Error> {
        let layout = self.set_layout(condition);
        tell(StudyEvent::Begun(
            Step::Breaking(condition),
            self.survey.n_selected,
        ));
        let seen = match self.keeps_images {
            true => None,
            false => self.seen_by_all(condition, &layout, stop)?,
        };
        let (seen, failures) = match seen {
            Some((seen, failures)) => {
                tell(StudyEvent::Known(seen.len() as u64));
                for failure in &failures {
                    tell(StudyEvent::Failed(failure.error.to_string()));
                }
                (seen, failures)
            }
            None => {
                let report = self.break_all(condition, layout.root(), stop, tell)?;
                if report.manifest.is_none() {
                    return Ok(None);
                }
                (BTreeMap::new(), report.failures)
            }
        };
        unseen.extend(failures.iter().map(|failure| UnseenImage {
            name: failure.name.clone(),
            reason: format!("{}: {}", condition.name, failure.error),
        }));
        let read = |image: &ImageToSee| cracked_image(&layout.path(&image.name));
        let hash = |image: &ImageToSee| match seen.get(&image.name) {
            Some(blake3) => Ok(blake3.clone()),
            None => blake3_file(&layout.path(&image.name)).map_err(|error| match error {
                DatasetError::Read { source, .. } if source.kind() == ErrorKind::NotFound => {
                    Error::StudyUnbroken {
                        condition: condition.name.clone(),
                    }
                }
                error => error.into(),
            }),
        };
        let Some(of_arms) = self.look(Some(condition), (&read, &hash), stop, tell)? else {
            return Ok(None);
        };
        unseen.extend(of_arms);
        if !self.keeps_images {
            self.remove_images(&layout)?;
        }
        Ok(Some(()))
    }

    /// Removes the images of a set, those without labels too.
    pub(super) fn remove_images(&self, layout: &SetLayout) -> Result<(), Error> {
        for name in self.survey.selected_names(self.source) {
            layout.remove_image(&name)?;
        }
        Ok(())
    }

    /// BLAKE3 of each image of a condition by its set's records, and what cannot be broken, where each detector has
    /// looked at all others.
    fn seen_by_all(
        &self,
        condition: &Condition,
        layout: &SetLayout,
        stop: &AtomicBool,
    ) -> Result<Option<SeenImages>, Error> {
        let images = self.images.iter();
        let looked_at: BTreeSet<&str> = images.map(|image| &*image.name).collect();
        let (mut made, mut unbroken) = (BTreeMap::new(), BTreeSet::new());
        for name in self.survey.selected_names(self.source) {
            match layout.recorded(&name, 0)? {
                Some(record) if looked_at.contains(&*name) => {
                    _ = made.insert(name, record.image_blake3);
                }
                Some(_) => {}
                None => _ = unbroken.insert(name),
            }
        }
        for detector in self.detectors {
            let log = self.log(detector, Some(condition));
            let identity = self.log_identity(detector, Some(condition))?;
            if !LineLog::is_of(&log, &identity.to_string())? || seen_files(&log)? != made {
                return Ok(None);
            }
        }
        let of_set = (condition, self.patterns(condition)?);
        let failures = why_none_breaks(
            (self.source, self.survey),
            of_set,
            layout.root(),
            &unbroken,
            stop,
        )?;
        Ok(failures.map(|failures| (made, failures)))
    }

    /// Lets each detector look at one image, before anything is broken: a model or a contract that
    /// does not work at all is no matter of single images.
    fn try_detectors(&self, quality: JpegQuality) -> Result<(), Error> {
        let readable = self.images.iter().find_map(|image| {
            let pixels = clean_image(&image.path, quality).ok()?;
            Some((&image.name, pixels))
        });
        if let Some((name, pixels)) = readable {
            for detector in self.detectors {
                detector.detector.detect(name, &pixels)?;
            }
        }
        Ok(())
    }

    /// Where the cracked images of a condition lie.
    #[must_use]
    pub fn set_folder(&self, condition: &Condition) -> PathBuf {
        self.out.join("sets").join(&condition.name)
    }

    /// The cracked images of a condition, with masks and records.
    pub(super) fn set_layout(&self, condition: &Condition) -> SetLayout {
        SetLayout::new(&self.set_folder(condition), 1)
    }

    /// Where it is noted what a detector found, image by image.
    pub(super) fn log(&self, detector: &StudyDetector, condition: Option<&Condition>) -> PathBuf {
        let arm_name = condition.map_or("clean", |condition| &condition.name);
        let folder = self.out.join("detections").join(&detector.name);
        folder.join(format!("{arm_name}.jsonl"))
    }

    fn break_all(
        &self,
        condition: &Condition,
        folder: &Path,
        stop: &AtomicBool,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<GenerateReport, Error> {
        make_set(
            (self.source, self.survey),
            (condition, self.patterns(condition)?),
            folder,
            stop,
            &|event| match event {
                Event::Done => tell(StudyEvent::Image),
                Event::Failed(failure) => tell(StudyEvent::Failed(failure.error.to_string())),
            },
        )
    }

    /// Where the damage of a condition comes from.
    pub(super) fn patterns(&self, condition: &Condition) -> Result<&Patterns, Error> {
        match (condition.is_photographed, self.photos) {
            (false, _) => Ok(&Patterns::Fresh),
            (true, Some(photos)) => Ok(photos),
            (true, None) => Err(Error::NoPhotos {
                folder: self.out.join("sets").join(&condition.name),
            }),
        }
    }

    fn look(
        &self,
        condition: Option<&Condition>,
        (read, blake3): (&Read<'_>, &Hash<'_>),
        stop: &AtomicBool,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<Option<Vec<UnseenImage>>, Error> {
        let step = Step::Detecting(condition);
        tell(StudyEvent::Begun(step, self.images.len() as u64));
        let arms = self.detectors.iter().map(|detector| {
            Ok(Arm {
                log: self.log(detector, condition),
                identity: self.log_identity(detector, condition)?,
                find: Box::new(|place, image, pixels| found_by(detector, (place, image), pixels)),
            })
        });
        ArmsRun {
            arms: &arms.collect::<Result<Vec<Arm<'_>>, Error>>()?,
            images: self.images,
            blake3,
            read,
            n_threads: self.n_threads,
            stop,
            tell,
        }
        .run()
    }

    /// What the lines of a log are made from.
    pub(super) fn log_identity(
        &self,
        detector: &StudyDetector,
        condition: Option<&Condition>,
    ) -> Result<Value, Error> {
        let mut identity = json!({
            "schema": "starbreak.detections/2",
            "generator": { "name": "starbreak", "version": env!("CARGO_PKG_VERSION") },
            "detector": DetectorIdentity::of(detector),
            "images": self.survey.names_sha256,
            "recipe": condition.map(|condition| condition.recipe.to_toml()),
            "seed": condition.map(|condition| condition.seed.0),
            "jpeg_quality": self.quality()?.get(),
        });
        if let Some(condition) = condition.filter(|condition| condition.is_photographed) {
            identity["photos"] = self.patterns(condition)?.identity();
        }
        Ok(identity)
    }

    /// Refuses a condition that moves what the labels name, which are those of the clean images.
    pub(super) fn refuse_moved_labels(&self) -> Result<(), Error> {
        for condition in self.conditions {
            if condition.recipe.settings()?.moves_labels() {
                let condition = condition.name.clone();
                return Err(Error::StudyMoves { condition });
            }
        }
        Ok(())
    }

    /// The quality of JPEG that all conditions share.
    pub(super) fn quality(&self) -> Result<JpegQuality, Error> {
        let mut qualities = Vec::new();
        for condition in self.conditions {
            qualities.push((condition, condition.recipe.settings()?.output.quality));
        }
        let Some((first, quality)) = qualities.first().copied() else {
            let default = Recipe::preset(DEFAULT_PRESET)?.settings()?;
            return Ok(JpegQuality::new(default.output.quality)?);
        };
        match qualities.iter().find(|(_, other)| *other != quality) {
            None => Ok(JpegQuality::new(quality)?),
            Some((other, other_quality)) => Err(Error::StudyQuality {
                conditions: [first.name.clone(), other.name.clone()],
                qualities: [quality, *other_quality],
            }),
        }
    }
}

/// What a detector finds in the image of a place, in the categories of the labels.
fn found_by(
    detector: &StudyDetector,
    (place, image): (u32, &ImageToSee),
    pixels: &image::RgbImage,
) -> Result<Vec<Detection>, Error> {
    let found = detector.detector.detect(&image.name, pixels)?;
    let of_labels = |raw: &starbreak_detect::RawDetection| {
        Some(Detection {
            image: place,
            category: detector.map.category(raw.class)?,
            box_px: BoxPx::from_corners(raw.corners_px),
            score: raw.score,
        })
    };
    Ok(found.detections.iter().filter_map(of_labels).collect())
}

/// Images by their names in order, each with the first reason.
pub(super) fn each_once(mut unseen: Vec<UnseenImage>) -> Vec<UnseenImage> {
    unseen.sort_by(|a, b| a.name.cmp(&b.name));
    unseen.dedup_by(|a, b| a.name == b.name);
    unseen
}

/// The pixels of a source's image after the codec that its cracked twins pass.
pub(super) fn clean_image(path: &Path, quality: JpegQuality) -> Result<image::RgbImage, Error> {
    let file = read_image(path, &ImageLimits::default())?;
    if file.format != ImageFormat::Jpeg {
        return Ok(file.pixels.to_rgb8());
    }
    let bytes = encode_image_as(&file, &Encoding::Jpeg { quality })?;
    let again = decode_image(&path.to_string_lossy(), &bytes, &ImageLimits::default())?;
    Ok(again.pixels.to_rgb8())
}

pub(super) fn cracked_image(path: &Path) -> Result<image::RgbImage, Error> {
    Ok(read_image(path, &ImageLimits::default())?.pixels.to_rgb8())
}
