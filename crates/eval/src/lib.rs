//! Detections to numbers: what a detector finds in clean and in cracked images, and how sure the
//! difference is.
//!
//! It is: the running of detectors, readers of labels and detections, the protocols of MS-COCO,
//! KITTI and BDD100K, evaluation inside a region of the image, paired statistics of failure,
//! distances between sets of images, and the report.
//! It is not: anything that knows how an image was broken. It gets labels, detections, masks and
//! pixels, so that no metric can peek at the simulator.

mod boxes;
mod detections;
mod error;
mod labels;
mod matching;

pub mod divergence;

pub use boxes::BoxPx;
pub use detections::{Detection, Detections};
pub use error::EvalError;
pub use labels::{Category, LabelSet, LabeledImage, Object, ObjectKind};
pub use matching::{ImageMatches, MatchedDetection, MatchedObject, Outcome};
