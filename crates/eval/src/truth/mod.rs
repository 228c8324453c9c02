//! Ground truth with the protocol that goes with it, of images and of clips, and detections read for it.

mod kept;
mod open;
mod tracked;

pub use open::{GroundTruth, Protocol, SaidDetections};
pub use tracked::{
    ClipLabels, LabeledClip, LabeledFrame, TrackName, TrackedLabels, frames_of, said_categories,
};
