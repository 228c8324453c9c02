//! How a contract's input meets that of a model.

use crate::contract::{Contract, Layout, Resize};
use crate::model_file::{ModelFacts, TensorFacts, TensorType};
use crate::pixels::{ImageTensor, Placement};
use crate::runtime::{InputTensor, InputValues};

/// How a contract's input meets that of a model.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct InputPlan {
    image: String,
    image_type: ImageType,
    /// Width and height of the frame that the model sees, px; 0 where each image has its own.
    pub(crate) frame_px: [u32; 2],
    image_size: Option<SizePlan>,
    mask: Option<MaskPlan>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ImageType {
    F32,
    U8,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct SizePlan {
    name: String,
    width_first: bool,
    is_float: bool,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct MaskPlan {
    name: String,
    /// Rows and columns where the model fixes them.
    fixed: Option<[usize; 2]>,
    is_float: bool,
}

impl InputPlan {
    pub(crate) fn new(contract: &Contract, facts: &ModelFacts) -> Result<Self, String> {
        let input = &contract.input;
        let image = match &input.image {
            // The only input is meant, whatever it is called.
            Some(name) => facts
                .input(name)
                .or_else(|| facts.inputs.first().filter(|_| facts.inputs.len() == 1)),
            None => facts.inputs.first(),
        };
        let Some(image) = image else {
            return Err(format!(
                "has no input {:?}, which the contract {:?} fills: it {facts}; choose another contract, or name the \
                 input in its input.image_input",
                input.image.as_deref().unwrap_or("?"),
                contract.name
            ));
        };
        let image_type = match image.element {
            TensorType::F32 | TensorType::F16 | TensorType::F64 => ImageType::F32,
            TensorType::U8 => ImageType::U8,
            other => {
                return Err(format!(
                    "takes images as {other:?} ({image}); export it with 32-bit floating point"
                ));
            }
        };
        let is_plain = (input.divisor - 1.0).abs() < f32::EPSILON
            && input.mean.iter().all(|mean| mean.abs() < f32::EPSILON)
            && input.std.iter().all(|std| (std - 1.0).abs() < f32::EPSILON);
        if image_type == ImageType::U8 && !is_plain {
            return Err(format!(
                "takes bytes ({image}), but the contract {:?} scales them; set divisor = 1, mean = [0, 0, 0], std = \
                 [1, 1, 1] in its table [input]",
                contract.name
            ));
        }
        let frame_px = frame(contract, image)?;
        let image_size = match &input.image_size {
            None => None,
            Some(size) => Some(match facts.input(&size.name) {
                Some(tensor) => SizePlan {
                    name: size.name.clone(),
                    width_first: size.width_first,
                    is_float: is_float(tensor),
                },
                None => {
                    return Err(format!(
                        "has no input {:?} for the size of the image: it {facts}; choose another contract",
                        size.name
                    ));
                }
            }),
        };
        // A model that does not need its mask may have lost it on export.
        let mask = input.mask.as_ref().and_then(|name| {
            let tensor = facts.input(name)?;
            let side = |place| usize::try_from(tensor.side(place)?).ok();
            Some(MaskPlan {
                name: name.clone(),
                fixed: side(1).and_then(|rows| Some([rows, side(2)?])),
                is_float: is_float(tensor),
            })
        });
        let plan = Self {
            image: image.name.clone(),
            image_type,
            frame_px,
            image_size,
            mask,
        };
        if let Some(other) = facts.inputs.iter().find(|tensor| !plan.fills(&tensor.name)) {
            return Err(format!(
                "takes {other}, too, which the contract {:?} does not fill; choose another contract",
                contract.name
            ));
        }
        Ok(plan)
    }

    fn fills(&self, name: &str) -> bool {
        let size = self.image_size.as_ref().map(|size| size.name.as_str());
        let mask = self.mask.as_ref().map(|mask| mask.name.as_str());
        name == self.image || Some(name) == size || Some(name) == mask
    }

    /// The inputs of one image.
    pub(crate) fn inputs(
        &self,
        image: ImageTensor,
        (width, height): (u32, u32),
        placement: &Placement,
    ) -> Result<Vec<InputTensor>, String> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "bytes as they came from the image"
        )]
        let values = match self.image_type {
            ImageType::F32 => InputValues::F32(image.values),
            ImageType::U8 => InputValues::U8(image.values.iter().map(|&v| v as u8).collect()),
        };
        let mut inputs = vec![InputTensor {
            name: self.image.clone(),
            shape: image.shape,
            values,
        }];
        if let Some(size) = &self.image_size {
            let sides = if size.width_first {
                [width, height]
            } else {
                [height, width]
            };
            let sides = sides.map(|side| i32::try_from(side).unwrap_or(i32::MAX));
            inputs.push(InputTensor {
                name: size.name.clone(),
                shape: vec![1, 2],
                values: whole(sides.to_vec(), size.is_float),
            });
        }
        if let Some(mask) = &self.mask {
            let [rows, columns] = mask.fixed.unwrap_or([
                placement.frame_height_px as usize,
                placement.frame_width_px as usize,
            ]);
            inputs.push(InputTensor {
                name: mask.name.clone(),
                shape: vec![1, rows, columns],
                values: whole(vec![1; rows * columns], mask.is_float),
            });
        }
        Ok(inputs)
    }
}

fn is_float(tensor: &TensorFacts) -> bool {
    matches!(
        tensor.element,
        TensorType::F32 | TensorType::F16 | TensorType::F64
    )
}

#[expect(clippy::cast_precision_loss, reason = "sides of images and ones")]
fn whole(values: Vec<i32>, as_float: bool) -> InputValues {
    if as_float {
        InputValues::F32(values.into_iter().map(|value| value as f32).collect())
    } else {
        InputValues::Whole(values)
    }
}

/// Width and height of the frame, px, by the model and, where it leaves them open, the contract.
fn frame(contract: &Contract, image: &TensorFacts) -> Result<[u32; 2], String> {
    let input = &contract.input;
    let (rank, channel, row, column) = match input.layout {
        Layout::Nchw => (4, 1, 2, 3),
        Layout::Nhwc => (4, 3, 1, 2),
        Layout::Chw => (3, 0, 1, 2),
    };
    if image.rank().is_some_and(|found| found != rank) {
        return Err(format!(
            "takes {image}, but the contract {:?} gives {rank} sides; choose another contract, or set its input.layout",
            contract.name
        ));
    }
    if rank == 4 && image.side(0).is_some_and(|batch| batch != 1) {
        return Err(format!(
            "takes several images at once, {image}; export it with a batch of 1"
        ));
    }
    if image.side(channel).is_some_and(|channels| channels != 3) {
        return Err(format!(
            "takes {image}, which is not three channels in layout {:?}; set the contract's input.layout",
            input.layout
        ));
    }
    let side = |place| image.side(place).and_then(|side| u32::try_from(side).ok());
    let fixed = (side(column), side(row));
    match (input.resize, fixed) {
        (Resize::Keep | Resize::ShortestSide { .. }, (None, None)) => Ok([0, 0]),
        (Resize::Keep | Resize::ShortestSide { .. }, _) => Err(format!(
            "takes images of one size, {image}, but the contract {:?} gives each its own; export it with open height \
             and width, or set the contract's input.resize to \"stretch\" or \"letterbox\" as it was trained",
            contract.name
        )),
        (_, (Some(width), Some(height))) => Ok([width, height]),
        (_, (width, height)) => match input.size_px {
            Some([w, h]) => Ok([width.unwrap_or(w), height.unwrap_or(h)]),
            None => Err(format!(
                "leaves the size of images open, {image}; set input.size_px = [width, height] in the contract {:?}",
                contract.name
            )),
        },
    }
}
