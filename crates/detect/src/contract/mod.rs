//! What a model takes and gives: how an image becomes its input, and its output boxes.

mod choice;
mod class_names;
mod presets;
mod reader;
mod table;

use serde::Serialize;

pub use choice::{Choice, choose};
pub use class_names::ClassNames;
pub use presets::preset_names;
pub(crate) use table::did_you_mean;

/// What a model takes and gives.
///
/// Read from a small TOML file with [`Contract::parse`], or a preset by [`Contract::preset`]; the
/// keys are described in `docs/detectors.md`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contract {
    /// The preset or the file.
    #[serde(skip)]
    pub name: String,
    /// Which models it is for, in a line.
    #[serde(skip)]
    pub about: String,
    /// How an image becomes the model's input.
    pub input: InputContract,
    /// What the model's outputs mean.
    pub output: OutputContract,
    /// Detections with a lower score are left out.
    pub score_threshold: f32,
    /// At most so many detections of an image are kept, those of the highest scores.
    pub max_detections: u32,
    /// Whether boxes are cut at the sides of the image.
    pub clips_boxes: bool,
    /// Non-maximum suppression, where the model does not do without or within.
    pub nms: Option<NmsContract>,
    /// Its classes.
    pub classes: ClassNames,
    /// The number by which the model calls the first class.
    pub first_label: i64,
}

/// How an image becomes the model's input: `(byte / divisor - mean) / std` per channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InputContract {
    /// Name of the image input; the model's first where it is not said.
    pub image: Option<String>,
    /// Order of the sides.
    pub layout: Layout,
    /// Order of the channels.
    pub color: ColorOrder,
    /// What a byte is divided by first.
    pub divisor: f32,
    /// What is taken off then, per channel in the model's order.
    pub mean: [f32; 3],
    /// What it is divided by last, per channel in the model's order.
    pub std: [f32; 3],
    /// How the image comes to its size.
    pub resize: Resize,
    /// How pixels are made in another size.
    pub interpolation: Interpolation,
    /// What fills the frame around the image.
    pub pad_value: f32,
    /// Whether it is filled before or after the numbers above.
    pub pad_stage: PadStage,
    /// Width and height of the frame where the model leaves them open, px.
    pub size_px: Option<[u32; 2]>,
    /// An input that takes the size of the image.
    pub image_size: Option<SizeInput>,
    /// An input of ones in the size of the frame, which says that all of it is image.
    pub mask: Option<String>,
}

/// An input that takes the size of the image.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SizeInput {
    /// Its name.
    pub name: String,
    /// Whether the width comes first.
    pub width_first: bool,
}

/// Order of the sides of the image input.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Layout {
    /// Image, channel, row, column.
    Nchw,
    /// Image, row, column, channel.
    Nhwc,
    /// Channel, row, column.
    Chw,
}

/// Order of the channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum ColorOrder {
    /// Red first.
    Rgb,
    /// Blue first.
    Bgr,
}

/// How an image comes to the model's size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Resize {
    /// Not at all: the model does it.
    Keep,
    /// Each side for itself.
    Stretch,
    /// Both by one factor, the rest of the frame filled.
    Letterbox {
        /// Whether the image lies in the middle, otherwise in the upper left corner.
        is_centered: bool,
        /// How its sides become whole.
        rounding: Rounding,
    },
    /// Both by one factor until the shorter is `min_side_px`, or the longer `max_side_px`.
    ShortestSide {
        /// The shorter side, px.
        min_side_px: u32,
        /// The longest that the longer may be, px.
        max_side_px: u32,
        /// Both are filled up to multiples of it, px, to the right and below.
        pad_multiple_px: u32,
    },
}

/// How a side becomes whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Rounding {
    /// Python's `round`.
    HalfToEven,
    /// Python's `int`.
    Down,
}

/// How pixels are made in another size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Interpolation {
    /// OpenCV's `INTER_LINEAR`.
    Linear,
    /// OpenCV's `INTER_AREA`.
    Area,
    /// Pillow's `BILINEAR`, which is antialiased.
    Antialiased,
}

/// When the frame around the image is filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum PadStage {
    /// Before the bytes become numbers: the value is one of pixels.
    Pixels,
    /// After: the value is one of the model's numbers.
    Numbers,
}

/// What the model's outputs mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputContract {
    /// Which outputs there are.
    pub form: OutputForm,
    /// What the four numbers of a box are.
    pub box_form: BoxForm,
    /// In which unit.
    pub box_unit: BoxUnit,
    /// What turns the numbers of classes into scores.
    pub activation: Activation,
    /// The score is objectness to this power …
    pub objectness_power: f32,
    /// … times the class's score to that one.
    pub class_power: f32,
    /// Whether a place gives a detection of every class above the threshold, not only the best.
    pub is_multi_label: bool,
}

/// Which outputs there are; a name that is not given stands for the model's outputs in their order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub enum OutputForm {
    /// One output: at each place a box, an objectness where there is one, and a number per class.
    Dense {
        /// Its name.
        output: Option<String>,
        /// Whether the numbers of a place lie one after the other, `[1, places, numbers]`.
        places_first: bool,
        /// Whether there is an objectness.
        has_objectness: bool,
        /// The strides of the grids, px, whose cells the boxes are relative to:
        /// `center = (value + cell) stride`, `size = exp(value) stride`. None where boxes are ready.
        strides_px: Vec<u32>,
    },
    /// One output `[1, places, 6]`: a box, its score, its class.
    Rows {
        /// Its name.
        output: Option<String>,
    },
    /// Three outputs: boxes, scores, labels.
    BoxesScoresLabels {
        /// Names of boxes, scores and labels.
        outputs: [Option<String>; 3],
    },
    /// Two outputs: boxes with their scores as a fifth number, and labels.
    ScoredBoxesLabels {
        /// Names of both.
        outputs: [Option<String>; 2],
    },
    /// Two outputs: boxes, and a number per class.
    BoxesLogits {
        /// Names of both.
        outputs: [Option<String>; 2],
        /// Whether the last class is none.
        last_is_background: bool,
    },
    /// FastestDet's one output `[1, 5 + classes, rows, columns]`: objectness, box, classes, with
    /// `center = (tanh(value) + cell) / cells` and `size = sigmoid(value)` of the frame.
    FastestDet {
        /// Its name.
        output: Option<String>,
    },
}

/// What the four numbers of a box are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum BoxForm {
    /// Left, top, right, bottom.
    Corners,
    /// Middle, and width and height.
    CenterSize,
}

/// The unit of a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum BoxUnit {
    /// Pixels of the frame that the model sees.
    FramePx,
    /// Shares of that frame.
    FrameFraction,
    /// Pixels of the image, whose size the model was given.
    ImagePx,
}

/// What turns the numbers of classes into scores.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Activation {
    /// Nothing: they are scores.
    None,
    /// The logistic function of each.
    Sigmoid,
    /// The softmax over all.
    Softmax,
}

/// Non-maximum suppression.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NmsContract {
    /// A box that overlaps a better one by more than this is left out.
    pub iou: f32,
    /// Whether boxes of other classes count, too.
    pub is_across_classes: bool,
    /// Only so many candidates of the highest scores go into it.
    pub max_candidates: u32,
}
