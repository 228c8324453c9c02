//! Running a model: numbers in, numbers out.

#[cfg(not(target_family = "wasm"))]
mod onnx_runtime;
mod pure_rust;

#[cfg(not(target_family = "wasm"))]
pub(crate) use onnx_runtime::OnnxRuntime;
pub(crate) use pure_rust::PureRust;

use std::fmt;
#[cfg(not(target_family = "wasm"))]
use std::path::PathBuf;

use crate::DetectError;

/// What runs a model.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Backend {
    /// rten, which is compiled in, for the processor.
    #[default]
    PureRust,
    /// ONNX Runtime: faster, for all operators, and for NVIDIA's GPUs; not in a browser.
    #[cfg(not(target_family = "wasm"))]
    OnnxRuntime {
        /// Its library, such as `onnxruntime/capi/libonnxruntime.so.1.31.1` of the Python package.
        library: PathBuf,
        /// Where it runs.
        device: Device,
    },
}

impl Backend {
    /// What it is, for a record: `rten`, or `ONNX Runtime of commit 6af1a93`, with
    /// ` on a GPU` where it runs there. Loads its library.
    ///
    /// # Errors
    ///
    /// [`DetectError::Runtime`] where the library cannot be loaded, or another one is loaded already: there is one
    /// for a process.
    pub fn name(&self) -> Result<String, DetectError> {
        match self {
            Self::PureRust => Ok("rten".to_owned()),
            #[cfg(not(target_family = "wasm"))]
            Self::OnnxRuntime { library, device } => {
                let name = onnx_runtime::name(library).map_err(DetectError::Runtime)?;
                Ok(match device {
                    Device::Cpu => name,
                    Device::Cuda => format!("{name} on a GPU"),
                })
            }
        }
    }
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
