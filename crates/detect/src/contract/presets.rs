//! The contracts that come along.

use super::table::did_you_mean;
use super::{ClassNames, Contract};
use crate::DetectError;

macro_rules! presets {
    ($($name:literal),* $(,)?) => {
        /// Names and texts of the presets.
        const PRESETS: &[(&str, &str)] = &[
            $(($name, include_str!(concat!("../../presets/", $name, ".toml")))),*
        ];
    };
}

presets![
    "yolov8",
    "yolov8-nms",
    "yolov10",
    "yolov5",
    "yolox",
    "yolox-decoded",
    "torchvision-fasterrcnn",
    "mmdeploy",
    "rtdetr",
    "rtdetr-ultralytics",
    "rfdetr",
    "detr",
    "fastestdet",
];

/// The names of the presets.
pub fn preset_names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|(name, _)| *name)
}

impl Contract {
    /// The preset of a name.
    ///
    /// # Errors
    ///
    /// [`DetectError::Contract`] where there is none, with the nearest.
    pub fn preset(name: &str) -> Result<Self, DetectError> {
        Self::parse(name, preset_text(name)?)
    }
}

/// The text of a preset.
pub(super) fn preset_text(name: &str) -> Result<&'static str, DetectError> {
    let found = PRESETS.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text).ok_or_else(|| {
        let known: Vec<&str> = preset_names().collect();
        DetectError::Contract {
            contract: name.to_owned(),
            key: "preset".to_owned(),
            reason: format!(
                "there is no preset of this name{}; the presets are {}",
                did_you_mean(name, &known),
                known.join(", ")
            ),
        }
    })
}

/// The list of classes of a name.
pub(super) fn class_list(name: &str) -> Option<ClassNames> {
    let text = match name {
        "coco-80" => include_str!("../../presets/classes/coco-80.txt"),
        "coco-91" => include_str!("../../presets/classes/coco-91.txt"),
        _ => return None,
    };
    Some(ClassNames::from_lines(name, text))
}
