//! A detector of the user's own, for the playground: loaded where somebody drops a model on the page.
//!
//! It is: the detector of the command ([`starbreak_detect::Detector`]), seated at the desk.
//! It is not: a part of the module that breaks glass, which nobody should wait longer for.

use image::{DynamicImage, RgbaImage};
use serde::Deserialize;
use serde_json::json;
use starbreak_detect::{DetectError, Detector, DetectorOptions, ModelLimits};
use starbreak_web_desk::{Answer, Answers};

/// Longest file and largest tensor of a model, bytes: a page has 4 GiB for all of it.
const MAX_BYTES: u64 = 1 << 30;

/// One question; both come with bytes.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case", deny_unknown_fields)]
enum Question {
    /// Loads a model: the bytes of an ONNX file.
    Model {
        /// Its file name, for messages.
        name: String,
    },
    /// Finds boxes in a picture, four bytes a pixel.
    Detect {
        /// Its width, px.
        width_px: u32,
        /// Its height, px.
        height_px: u32,
    },
}

/// What a question may come to, in the words of the command.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// A model that cannot be used, or failed.
    #[error(transparent)]
    Model(#[from] DetectError),
    /// Not what this module knows.
    #[error("not a question: {0}")]
    Question(#[from] serde_json::Error),
    /// A step too early.
    #[error("there is no model yet")]
    NoModel,
    /// A picture whose bytes are not those of its size.
    #[error(
        "{n_bytes} bytes are no picture of {width_px} x {height_px} px; expected four for each pixel"
    )]
    Picture {
        /// How many came.
        n_bytes: usize,
        /// Its width, px.
        width_px: u32,
        /// Its height, px.
        height_px: u32,
    },
}

/// What a page works with.
#[derive(Debug, Default)]
pub struct Lookout {
    detector: Option<Detector>,
}

impl Answers for Lookout {
    fn answer(&mut self, words: &str, bytes: Vec<u8>) -> Result<Answer, String> {
        Self::answer(self, words, bytes).map_err(|trouble| trouble.to_string())
    }
}

impl Lookout {
    /// The answer to a question in JSON, which comes with bytes. A model that cannot be loaded leaves the one before.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn answer(&mut self, words: &str, bytes: Vec<u8>) -> Result<Answer, Trouble> {
        let words = match serde_json::from_str(words)? {
            Question::Model { name } => {
                let options = DetectorOptions {
                    limits: ModelLimits {
                        max_file_bytes: MAX_BYTES,
                        max_tensor_bytes: MAX_BYTES,
                        ..ModelLimits::default()
                    },
                    ..DetectorOptions::default()
                };
                let detector = Detector::of_bytes(&name, bytes, &options)?;
                let contract = detector.contract();
                let words = json!({
                    "name": name,
                    "contract": contract.name,
                    "reason": detector.reason(),
                });
                self.detector = Some(detector);
                words
            }
            Question::Detect {
                width_px,
                height_px,
            } => {
                let detector = self.detector.as_ref().ok_or(Trouble::NoModel)?;
                let n_bytes = bytes.len();
                let picture =
                    RgbaImage::from_raw(width_px, height_px, bytes).ok_or(Trouble::Picture {
                        n_bytes,
                        width_px,
                        height_px,
                    })?;
                let picture = DynamicImage::ImageRgba8(picture).into_rgb8();
                let found = detector.detect("the picture", &picture)?;
                let names = &detector.classes().names;
                let boxes = found.detections.iter().map(|one| {
                    json!({
                        "class": names.get(one.class as usize).cloned().flatten(),
                        "score": one.score,
                        "corners_px": one.corners_px,
                    })
                });
                json!({ "boxes": boxes.collect::<Vec<_>>() })
            }
        };
        Ok(Answer {
            words,
            bytes: Vec::new(),
        })
    }
}

/// Seats a lookout at the desk; the page calls it once.
#[expect(unsafe_code, reason = "a name that a page can call")]
#[unsafe(no_mangle)]
pub extern "C" fn take_seat() {
    starbreak_web_desk::seat(Lookout::default());
}
