//! Images to boxes: detectors, which are ONNX models.
//!
//! [`Detector::open`] reads a model, chooses its [`Contract`] or takes the one given, and loads it;
//! [`Detector::detect`] finds boxes in an image. Pre- and post-processing follow the code that each
//! model's authors evaluate with; `docs/detectors.md` names it per preset.
//!
//! It is: the contracts of detectors, what runs them, and their classes by the names of a dataset.
//! It is not: anything that sees ground truth, numbers of an evaluation, or how an image was broken.

mod contract;
mod decode;
mod detector;
mod error;
mod input_plan;
mod label_map;
mod model_file;
mod nms;
mod pixels;
mod runtime;

pub use contract::{Choice, ClassNames, Contract, Interpolation, choose, preset_names};
pub use detector::{
    Detector, DetectorOptions, ImageDetections, ImageToSee, RawDetection, RawTensor, Seen,
};
pub use error::DetectError;
pub use label_map::{LabelMap, LabelRules};
pub use model_file::{ModelFacts, ModelLimits, Side, TensorFacts, TensorType};
pub use pixels::{Placement, resize};
pub use runtime::{Backend, Device};
