use std::path::{Path, PathBuf};

use starbreak::{ImportError, RecipeError};
use starbreak_dataset::DatasetError;
use starbreak_detect::DetectError;
use starbreak_eval::EvalError;
use starbreak_fracture::FractureError;
use starbreak_optics::OpticsError;

use crate::bag_error::BagError;
use crate::clip_error::ClipError;

/// Why a run or one of its items failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A bank of cracks by a recipe that breaks nothing.
    #[error(
        "fracture.model = \"none\": no glass breaks, so there is nothing to keep in a bank; {way_out}"
    )]
    NothingBreaks {
        /// What to do instead.
        way_out: &'static str,
    },
    /// Glass could not be broken or shown.
    #[error(transparent)]
    Chain(#[from] starbreak::Error),
    /// A file could not be read or written.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A request for a clip that makes no sense.
    #[error(transparent)]
    Clip(#[from] ClipError),
    /// A bag that is not read, or a request for one that makes no sense.
    #[error(transparent)]
    Bag(#[from] BagError),
    /// A network file that holds no network.
    #[error("{path:?} {cause}")]
    Import {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: ImportError,
    },
    /// A folder in which no photograph of glass is.
    #[error("{folder:?} holds no photographs of broken glass; expected PNG or JPEG files in it")]
    NoPhotos {
        /// The folder.
        folder: PathBuf,
    },
    /// A photograph of glass that cannot be used, in a folder of them.
    #[error("photographs of broken glass in {folder:?}: {reason}")]
    BadPhoto {
        /// The folder.
        folder: PathBuf,
        /// Which file, and why.
        reason: String,
    },
    /// An output of a recipe that the images of a set do not have.
    #[error("{why}")]
    SetOutput {
        /// Why not, and what to set.
        why: &'static str,
    },
    /// A file beside the labels of a set in which there may be more of them, where a lens moves what they name.
    #[error(
        "[distortion] moves what images show, and labels with it, but {path:?} may hold others, which would stay; leave \
         such files out with --other-files skip"
    )]
    OtherFileStays {
        /// The first such file.
        path: PathBuf,
    },
    /// A condition of a study that moves what the labels name.
    #[error(
        "condition {condition}: [distortion] moves what images show, and a study holds clean and damaged images against \
         the same labels; leave that condition out, generate the set instead, whose labels move, and run `starbreak \
         evaluate` once for clean and once for damaged images, each with their own labels"
    )]
    StudyMoves {
        /// The condition.
        condition: String,
    },
    /// A detector.
    #[error(transparent)]
    Detect(#[from] DetectError),
    /// Labels, detections or a question of the evaluation.
    #[error(transparent)]
    Eval(#[from] EvalError),
    /// A comparison of sets that makes no sense.
    #[error("{why}")]
    Divergence {
        /// Why not.
        why: String,
    },
    /// A request for an evaluation that makes no sense.
    #[error("{why}")]
    Evaluation {
        /// Why not.
        why: String,
    },
    /// What was found in an image cannot be written down.
    #[error("what was found in {image:?} cannot be written down: {reason}")]
    StudyLine {
        /// The image.
        image: String,
        /// Why.
        reason: String,
    },
    /// Conditions whose images are not written alike.
    #[error(
        "condition {} writes JPEG at quality {}, {} at {}; the clean images pass the same codec, so set one \
         output.quality for all, as with --set output.quality={}",
        .conditions[0], .qualities[0], .conditions[1], .qualities[1], .qualities[0]
    )]
    StudyQuality {
        /// Two conditions.
        conditions: [String; 2],
        /// Their qualities.
        qualities: [u8; 2],
    },
    /// The folder of a study holds another one.
    #[error("{folder:?} holds another study: {what}; {way_out}, or choose another folder")]
    AnotherStudy {
        /// The folder.
        folder: PathBuf,
        /// What differs.
        what: String,
        /// What makes it this one.
        way_out: &'static str,
    },
    /// A folder that a study cannot begin in.
    #[error("{folder:?} {what}; choose another folder, which is made if it is not there")]
    NotAStudy {
        /// The folder.
        folder: PathBuf,
        /// Why not.
        what: String,
    },
    /// An image that detectors cannot look at, since it could not be damaged.
    #[error("there is no image of the condition {condition}")]
    StudyUnbroken {
        /// The condition.
        condition: String,
    },
    /// A folder that is not the shard of a study that it should be.
    #[error("{folder:?} cannot be joined: {what}")]
    StudyShard {
        /// The folder.
        folder: PathBuf,
        /// Why, and what to do.
        what: String,
    },
    /// A shard of a study that was not given.
    #[error("shard {number} of {of} is missing; give the folder of each shard once")]
    StudyShardMissing {
        /// Which one, from 1.
        number: u32,
        /// Of how many.
        of: u32,
    },
    /// A shard of a study that was interrupted.
    #[error(
        "step {step:?}: the log of {detector} has no intact line of {image:?} in its place; run its shard again, which looks \
         only at what is missing, then join"
    )]
    StudyShardUnfinished {
        /// The detector.
        detector: String,
        /// The step.
        step: String,
        /// The first image without such a line.
        image: String,
    },
    /// A step that a study does not have.
    #[error("the study has no step {step:?}; its steps are {}", .steps.join(", "))]
    StudyStep {
        /// The step.
        step: String,
        /// Those that there are.
        steps: Vec<String>,
    },
    /// Labels that give an image another size than its file has.
    #[error(
        "image {id}, {name:?}, is {} x {} px by the labels, its file {path:?} {} x {} px; mend the labels, or give the \
         images that they are of",
        .said.0, .said.1, .found.0, .found.1
    )]
    LabeledSize {
        /// Its number in the labels.
        id: i64,
        /// Its name in the labels.
        name: String,
        /// Width and height by the labels, px.
        said: (u32, u32),
        /// Its file.
        path: PathBuf,
        /// Width and height of the file, upright, px.
        found: (u32, u32),
    },
    /// A log of what a detector found that has changed since.
    #[error(
        "{log:?} was damaged after it was written: {image:?} is not where it should be; run the study again, which looks \
         once more at what is missing"
    )]
    StudyLog {
        /// The log.
        log: PathBuf,
        /// The first image without an intact line in its place.
        image: String,
    },
    /// An image that was there when the source was surveyed.
    #[error("{record}; it was good when the run began")]
    Gone {
        /// What is wrong with it now.
        record: String,
    },
    /// A bank whose content is not what this version knows, or a pattern that it does not have.
    #[error(
        "the bank {path:?}{}: {why}; make it again from its recipe and seed, with this version",
        .idx.map(|idx| format!(", pattern {idx}")).unwrap_or_default()
    )]
    Bank {
        /// The file.
        path: PathBuf,
        /// The pattern, from 0, if it is one.
        idx: Option<usize>,
        /// What is wrong.
        why: String,
    },
    /// A pattern of a bank that cannot be made.
    #[error("pattern {idx}: {cause}")]
    OfPattern {
        /// Which one, from 0.
        idx: usize,
        /// Why.
        cause: Box<Error>,
    },
    /// A bank without frame sizes.
    #[error("a bank needs at least one frame size")]
    NoSize,
    /// What is done as a whole or not at all was interrupted.
    #[error("interrupted; nothing was written")]
    Interrupted,
    /// Two inputs would write the same file.
    #[error(
        "{first:?} and {second:?} would both write {name:?}; give them different names or run them apart"
    )]
    OutputCollision {
        /// The earlier input.
        first: PathBuf,
        /// The later one.
        second: PathBuf,
        /// The name they share.
        name: String,
    },
    /// An image was read, but could not be cracked or encoded.
    #[error("{input:?}: {cause}")]
    OfImage {
        /// The image file.
        input: PathBuf,
        /// Why.
        cause: Box<Error>,
    },
    /// An output would replace an input.
    #[error(
        "the output {output:?} would replace the input {input:?}; choose another output folder"
    )]
    OutputIsInput {
        /// The file that would be replaced.
        input: PathBuf,
        /// The file that would be written.
        output: PathBuf,
    },
    /// A path without a file name.
    #[error("{input:?} is not a file name")]
    NoFileName {
        /// What was given.
        input: PathBuf,
    },
    /// The library that runs threads could not start them.
    #[error("{n_threads} threads could not be started: {cause}")]
    Threads {
        /// How many were asked for.
        n_threads: usize,
        /// What the system said.
        cause: String,
    },
}

impl Error {
    /// Whether it would meet every other file, too: the disk is full, or nothing can be written
    /// there.
    #[must_use]
    pub fn is_of_the_disk(&self) -> bool {
        match self {
            Self::Dataset(error) => error.is_of_the_disk(),
            Self::OfImage { cause, .. } => cause.is_of_the_disk(),
            _ => false,
        }
    }

    /// An error that came up with this image.
    pub(crate) fn of_image(input: &Path, error: Self) -> Self {
        Self::OfImage {
            input: input.to_owned(),
            cause: Box::new(error),
        }
    }
}

impl From<RecipeError> for Error {
    fn from(error: RecipeError) -> Self {
        Self::Chain(error.into())
    }
}

impl From<FractureError> for Error {
    fn from(error: FractureError) -> Self {
        Self::Chain(error.into())
    }
}

impl From<OpticsError> for Error {
    fn from(error: OpticsError) -> Self {
        Self::Chain(error.into())
    }
}
