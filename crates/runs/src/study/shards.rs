//! A study in shards: each does its images in a folder of its own, step by step; one call joins what they
//! found.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde::Deserialize;
use starbreak_dataset::{
    DatasetError, SetLayout, is_inside, merge_sets, read_text, refuse_inside_set, same_file,
};
use starbreak_detect::ImageToSee;
use starbreak_eval::GroundTruth;

use super::arm_log::{FoundInImage, UnseenImage, read_found, write_whole};
use super::identity::Identity;
use super::run::each_once;
use super::{Condition, StudyDetector, StudyEvent, StudyPlan, StudyRuns};
use crate::Error;
use crate::generate::{Shard, Survey};

/// The step in which detectors look at the clean images; the others have the names of the conditions.
pub const CLEAN_STEP: &str = "clean";

/// Longest list of failures that is read, bytes.
const MAX_BYTES: u64 = 1 << 30;

impl StudyPlan<'_> {
    /// The names of the steps that a shard has: the clean images, then each condition. They do not depend on each
    /// other and may run side by side, in several processes too.
    #[must_use]
    pub fn steps(&self) -> Vec<String> {
        let conditions = self.conditions.iter().map(|one| one.name.clone());
        std::iter::once(CLEAN_STEP.to_owned())
            .chain(conditions)
            .collect()
    }

    /// Does the images of a shard in the plan's folder: all steps, or the one that is named. What there is of an
    /// interrupted run stays. Comes to the images that some detector could not look at, in order; none where `stop`
    /// was set on the way.
    ///
    /// `shard` is a survey of the same source with a [`Selection::shard`](crate::generate::Selection::shard); plan and
    /// `truth` have all images.
    ///
    /// # Errors
    /// As [`StudyPlan::run`], and [`Error::StudyStep`].
    pub fn run_shard(
        &self,
        truth: &GroundTruth,
        shard: &Survey,
        step: Option<&str>,
        stop: &AtomicBool,
        tell: &(dyn Fn(StudyEvent<'_>) + Sync),
    ) -> Result<Option<Vec<UnseenImage>>, Error> {
        let steps = self.steps();
        if let Some(step) = step.filter(|step| !steps.iter().any(|one| one == step)) {
            let step = step.to_owned();
            return Err(Error::StudyStep { step, steps });
        }
        let images = self.images_of(|name| shard.is_selected(name));
        let part = StudyPlan {
            survey: shard,
            images: &images,
            ..*self
        };
        let mut identity = Identity::of(self, truth)?;
        identity.shard = shard.selection().shard;
        part.begin(&identity, truth)?;
        let is_asked = |name: &str| step.is_none_or(|step| step == name);
        let mut unseen = Vec::new();
        if is_asked(CLEAN_STEP) {
            let Some(of_arms) = part.look_at_clean(stop, tell)? else {
                return Ok(None);
            };
            unseen.extend(of_arms);
        }
        for condition in self.conditions.iter().filter(|one| is_asked(&one.name)) {
            if part.under(condition, &mut unseen, stop, tell)?.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(each_once(unseen)))
    }

    /// Joins finished shards in the plan's folder to what one run would have made and found. Files get a second
    /// name there where the disk gives one, else they are copied.
    ///
    /// # Errors
    /// [`Error::StudyShard`], [`Error::StudyShardMissing`] and [`Error::StudyShardUnfinished`] for folders that are not
    /// each shard of this study once, whole;
    /// [`Error::AnotherStudy`] for a folder of another study; [`Error::Dataset`] for files that are not as they were
    /// made.
    pub fn join(&self, truth: &GroundTruth, shards: &[PathBuf]) -> Result<StudyRuns, Error> {
        refuse_inside_set(self.out)?;
        self.source.refuse_output_at(self.out)?;
        let is_around =
            |shard: &&PathBuf| is_inside(self.out, shard) && !same_file(self.out, shard);
        if let Some(around) = shards.iter().find(is_around) {
            let what = format!("{:?} lies in it; join into a folder beside it", self.out);
            let folder = around.clone();
            return Err(Error::StudyShard { folder, what });
        }
        let identity = Identity::of(self, truth)?;
        identity.check(self.out)?;
        self.refuse_moved_labels()?;
        self.check_sizes(truth)?;
        let shards = self.places_of(in_order(&identity, shards)?);
        for (places, folder) in &shards {
            let images = places.iter().map(|place| self.images[*place].clone());
            let images: Vec<ImageToSee> = images.collect();
            let part = StudyPlan {
                images: &images,
                ..self.in_shard(folder)
            };
            part.check_files()?;
        }
        // What detectors have not looked at ends it before anything is written.
        let steps = || std::iter::once(None).chain(self.conditions.iter().map(Some));
        for step in steps() {
            for detector in self.detectors {
                self.read_shards(detector, step, &shards, &mut |_, _| ())?;
            }
        }
        identity.write(self.out)?;
        let mut unseen = Vec::new();
        for step in steps() {
            if let Some(condition) = step {
                let layout = self.join_set(condition, &shards)?;
                unseen.extend(failures_of(&layout, condition)?);
            }
            for detector in self.detectors {
                let mut found = BTreeMap::new();
                self.read_shards(detector, step, &shards, &mut |place, one| {
                    found.insert(place, one);
                })?;
                let identity = self.log_identity(detector, step)?.to_string();
                let log = self.log(detector, step);
                unseen.extend(write_whole(&log, &identity, found.into_values())?);
            }
        }
        Ok(StudyRuns {
            unseen: each_once(unseen),
        })
    }

    /// Joins the sets of a condition.
    fn join_set(
        &self,
        condition: &Condition,
        shards: &[(Vec<usize>, PathBuf)],
    ) -> Result<SetLayout, Error> {
        let folders = shards.iter().map(|(_, folder)| folder);
        let set_of = |folder: &PathBuf| self.in_shard(folder).set_folder(condition);
        let parts: Vec<PathBuf> = folders.map(set_of).collect();
        let layout = self.set_layout(condition);
        merge_sets(&parts, layout.root(), self.keeps_images)?;
        if !self.keeps_images {
            // A run that was interrupted here may have left some.
            self.remove_images(&layout)?;
        }
        Ok(layout)
    }

    /// Where among the plan's images those of each shard are, with its folder; each image is in one of all shards.
    fn places_of(&self, shards: Vec<(Shard, PathBuf)>) -> Vec<(Vec<usize>, PathBuf)> {
        let mut places = vec![Vec::new(); shards.len()];
        for (place, image) in self.images.iter().enumerate() {
            let of_image = shards.iter().position(|(one, _)| one.takes(&image.name));
            if let Some(shard) = of_image {
                places[shard].push(place);
            }
        }
        let folders = shards.into_iter().map(|(_, folder)| folder);
        places.into_iter().zip(folders).collect()
    }

    fn images_of(&self, is_taken: impl Fn(&str) -> bool) -> Vec<ImageToSee> {
        let images = self.images.iter();
        images.filter(|one| is_taken(&one.name)).cloned().collect()
    }

    /// The plan in the folder of a shard.
    fn in_shard<'a>(&'a self, shard: &'a Path) -> StudyPlan<'a> {
        StudyPlan {
            out: shard,
            ..*self
        }
    }

    /// Hands over what a detector found in the images of all shards, each with its place among the plan's. A log counts
    /// as far as it has the images of its shard in their order.
    fn read_shards(
        &self,
        detector: &StudyDetector,
        condition: Option<&Condition>,
        shards: &[(Vec<usize>, PathBuf)],
        take: &mut dyn FnMut(usize, FoundInImage),
    ) -> Result<(), Error> {
        let identity = self.log_identity(detector, condition)?.to_string();
        let mut first_missing: Option<usize> = None;
        for (places, folder) in shards {
            let log = self.in_shard(folder).log(detector, condition);
            let images = places.iter().map(|place| &self.images[*place]);
            let mut left = places.iter().copied();
            let found = read_found(&log, &identity, images, &mut |found| {
                if let Some(place) = left.next() {
                    take(place, found);
                }
            })?;
            let refuse = |what: String| Error::StudyShard {
                folder: folder.clone(),
                what,
            };
            match found {
                Some((_, false)) => {}
                Some((_, true)) => {
                    return Err(refuse(format!(
                        "the last run of this shard was interrupted while it tried images again, by {log:?}; run it again"
                    )));
                }
                None => {
                    return Err(refuse(format!(
                        "{log:?} is not there, or of another study or version; run this shard again"
                    )));
                }
            }
            first_missing = first_missing.into_iter().chain(left.next()).min();
        }
        match first_missing.and_then(|place| self.images.get(place)) {
            None => Ok(()),
            Some(image) => Err(Error::StudyShardUnfinished {
                detector: detector.name.clone(),
                step: condition.map_or(CLEAN_STEP, |one| &one.name).to_owned(),
                image: image.name.clone(),
            }),
        }
    }
}

/// The folders of all shards by their number.
fn in_order(identity: &Identity, folders: &[PathBuf]) -> Result<Vec<(Shard, PathBuf)>, Error> {
    let mut by_number = BTreeMap::new();
    let mut all = None;
    for folder in folders {
        let shard = identity.shard_in(folder)?;
        let of = *all.get_or_insert(shard.of);
        let refuse = |what: String| Error::StudyShard {
            folder: folder.clone(),
            what,
        };
        if shard.of != of {
            let (number, other) = (shard.number, shard.of);
            return Err(refuse(format!(
                "it is the shard {number}/{other}, and the first is one of {of}; give the shards of one run"
            )));
        }
        let entry = (shard, folder.clone());
        if by_number.insert(shard.number, entry).is_some() {
            let number = shard.number;
            return Err(refuse(format!(
                "shard {number}/{of} is there twice; give each once"
            )));
        }
    }
    let of = all.unwrap_or(0);
    match (1..=of).find(|number| !by_number.contains_key(number)) {
        Some(number) => Err(Error::StudyShardMissing { number, of }),
        None => Ok(by_number.into_values().collect()),
    }
}

/// A line of the list of images that could not be broken.
#[derive(Deserialize)]
struct FailedImage {
    name: String,
    error: String,
}

/// What a set could not break.
fn failures_of(layout: &SetLayout, condition: &Condition) -> Result<Vec<UnseenImage>, Error> {
    let list = layout.state("failures.jsonl");
    let text = match read_text(&list, MAX_BYTES) {
        Ok(file) => file.text,
        Err(DatasetError::Read { source, .. }) if source.kind() == ErrorKind::NotFound => {
            return Ok(Vec::new());
        }
        Err(error) => return Err(error.into()),
    };
    let unseen = text.lines().map(|line| {
        let failed: FailedImage =
            serde_json::from_str(line).map_err(|cause| Error::StudyShard {
                folder: list.clone(),
                what: format!("a line of it is damaged: {cause}; join the shards again"),
            })?;
        Ok(UnseenImage {
            name: failed.name,
            reason: format!("{}: {}", condition.name, failed.error),
        })
    });
    unseen.collect()
}
