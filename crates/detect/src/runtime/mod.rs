//! Running a model: numbers in, numbers out.

#[cfg(feature = "ort")]
mod onnx_runtime;
mod pure_rust;

#[cfg(feature = "ort")]
pub(crate) use onnx_runtime::OnnxRuntime;
pub(crate) use pure_rust::PureRust;

use std::fmt;
use std::path::PathBuf;

/// What runs a model.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Backend {
    /// Code that is compiled in, for the processor.
    #[default]
    PureRust,
    /// ONNX Runtime: faster, for all operators, and for NVIDIA's GPUs.
    OnnxRuntime {
        /// Its library, such as `onnxruntime/capi/libonnxruntime.so.1.31.1` of the Python package.
        library: PathBuf,
        /// Where it runs.
        device: Device,
    },
}

/// Where ONNX Runtime runs a model.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Device {
    /// On the processor.
    #[default]
    Cpu,
    /// On an NVIDIA GPU.
    Cuda,
}

/// An input of a model.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct InputTensor {
    pub(crate) name: String,
    pub(crate) shape: Vec<usize>,
    pub(crate) values: InputValues,
}

/// The numbers of an input.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum InputValues {
    F32(Vec<f32>),
    U8(Vec<u8>),
    /// Of an input of 64- or 32-bit integers.
    Whole(Vec<i32>),
}

/// An output of a model, whole numbers as floating point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OutputTensor {
    pub(crate) name: String,
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Vec<f32>,
    /// Width and height of the frame that the model saw, px.
    pub(crate) frame_px: [u32; 2],
}

/// Something that runs a model. Runs of several threads at once must not disturb each other, and the
/// bits of an output must not depend on them.
pub(crate) trait Runtime: fmt::Debug + Send + Sync {
    /// The values of some outputs.
    fn run(&self, inputs: Vec<InputTensor>, outputs: &[String]) -> Result<Vec<RawOutput>, String>;
}

/// Shape and values of an output.
pub(crate) type RawOutput = (Vec<usize>, Vec<f32>);
