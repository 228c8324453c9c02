//! Running a model: numbers in, numbers out.

#[cfg(feature = "ort")]
mod onnx_runtime;
mod pure_rust;

#[cfg(feature = "ort")]
pub(super) use onnx_runtime::OnnxRuntime;
pub(super) use pure_rust::PureRust;

use std::fmt;

/// An input of a model.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct InputTensor {
    pub(super) name: String,
    pub(super) shape: Vec<usize>,
    pub(super) values: InputValues,
}

/// The numbers of an input.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum InputValues {
    F32(Vec<f32>),
    U8(Vec<u8>),
    /// Of an input of 64- or 32-bit integers.
    Whole(Vec<i32>),
}

/// An output of a model, whole numbers as floating point.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OutputTensor {
    pub(super) name: String,
    pub(super) shape: Vec<usize>,
    pub(super) values: Vec<f32>,
    /// Width and height of the frame that the model saw, px.
    pub(super) frame_px: [u32; 2],
}

/// Something that runs a model. Runs of several threads at once must not disturb each other, and the
/// bits of an output must not depend on them.
pub(super) trait Runtime: fmt::Debug + Send + Sync {
    /// The values of some outputs.
    fn run(&self, inputs: Vec<InputTensor>, outputs: &[String]) -> Result<Vec<RawOutput>, String>;
}

/// Shape and values of an output.
pub(super) type RawOutput = (Vec<usize>, Vec<f32>);
