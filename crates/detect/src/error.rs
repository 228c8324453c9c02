use starbreak_dataset::DatasetError;

/// What is wrong with a model, its contract or its classes, as one line: what, where, the way out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DetectError {
    /// A file or an image.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// A contract of a model does not say what it must, or something that means nothing.
    #[error("contract {contract:?}: {key}: {reason}")]
    Contract {
        /// The file or the preset.
        contract: String,
        /// The key, with its table.
        key: String,
        /// What is wrong, with the value, and the way out.
        reason: String,
    },
    /// A model that cannot be used.
    #[error("model {model:?} {reason}")]
    Model {
        /// Its file.
        model: String,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// A model that failed on an image, or said what cannot be taken for detections.
    #[error("model {model:?} on {image:?}: {reason}")]
    Inference {
        /// Its file.
        model: String,
        /// The image.
        image: String,
        /// What is wrong, and the way out.
        reason: String,
    },
    /// What runs models cannot be loaded.
    #[error("ONNX Runtime: {0}")]
    Runtime(String),
    /// Names of classes which do not fit.
    #[error("label map {map:?}: {reason}")]
    LabelMap {
        /// The file, or what it was made from.
        map: String,
        /// What is wrong, and the way out.
        reason: String,
    },
}
