//! The other backend: ONNX Runtime, loaded at run time from a path.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use ort::environment::Environment;
use ort::ep::CUDA;
use ort::logging::LogLevel;
use ort::session::{Session, SessionInputValue};
use ort::value::{DynValue, Tensor};

use super::{Device, InputTensor, InputValues, RawOutput, Runtime};
use crate::model_file::{ModelFacts, TensorType, one_line};

/// The library of this process: there can be only one.
static LOADED: Mutex<Option<(PathBuf, Environment)>> = Mutex::new(None);

/// A model in ONNX Runtime.
pub(crate) struct OnnxRuntime {
    environment: Environment,
    model: PathBuf,
    device: Device,
    /// Inputs that want 64-bit integers.
    wide: Vec<String>,
    /// Sessions that no run has at the moment: one alone must not be run by two threads.
    idle: Mutex<Vec<Session>>,
}

impl fmt::Debug for OnnxRuntime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OnnxRuntime")
            .field("model", &self.model)
            .field("device", &self.device)
            .finish_non_exhaustive()
    }
}

impl OnnxRuntime {
    /// The model in a file, run by the library at a path.
    pub(crate) fn load(
        library: &Path,
        device: Device,
        model: &Path,
        facts: &ModelFacts,
    ) -> Result<Self, String> {
        let halves = facts
            .inputs
            .iter()
            .find(|input| input.element == TensorType::F16);
        if let Some(input) = halves {
            return Err(format!(
                "takes 16-bit floating point ({input}), which is not given to ONNX Runtime; export it with 32 bits \
                 (half=False), or run it with --runtime rten"
            ));
        }
        let runtime = Self {
            environment: environment(library)?,
            model: model.to_owned(),
            device,
            wide: facts
                .inputs
                .iter()
                .filter(|input| input.element == TensorType::I64)
                .map(|input| input.name.clone())
                .collect(),
            idle: Mutex::new(Vec::new()),
        };
        let session = runtime.session()?;
        if let Ok(mut idle) = runtime.idle.lock() {
            idle.push(session);
        }
        Ok(runtime)
    }

    fn session(&self) -> Result<Session, String> {
        let build = || -> Result<Session, ort::Error> {
            let mut builder = Session::builder(&self.environment)?
                .with_log_level(LogLevel::Fatal)?
                // Images are what is done side by side, and sums come in one order.
                .with_intra_threads(1)?
                .with_deterministic_compute(true)?;
            if self.device == Device::Cuda {
                builder = builder
                    .with_execution_providers([CUDA::default().build().error_on_failure()])?;
            }
            builder.commit_from_file(&self.model)
        };
        build().map_err(|error| {
            format!(
                "cannot be loaded by ONNX Runtime: {}",
                one_line(&error.to_string())
            )
        })
    }

    fn run_in(
        &self,
        session: &mut Session,
        inputs: Vec<InputTensor>,
        outputs: &[String],
    ) -> Result<Vec<RawOutput>, String> {
        let wrong = |error: ort::Error| one_line(&error.to_string());
        let mut given: Vec<(String, SessionInputValue<'_>)> = Vec::new();
        for input in inputs {
            let is_wide = self.wide.contains(&input.name);
            let value = value_of(input.shape, input.values, is_wide).map_err(wrong)?;
            given.push((input.name, value.into()));
        }
        let values = session.run(given).map_err(wrong)?;
        outputs
            .iter()
            .map(|name| {
                let value = values
                    .get(name.as_str())
                    .ok_or_else(|| format!("it gave no output {name:?}"))?;
                raw_output(name, value)
            })
            .collect()
    }
}

impl Runtime for OnnxRuntime {
    fn run(&self, inputs: Vec<InputTensor>, outputs: &[String]) -> Result<Vec<RawOutput>, String> {
        let session = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let mut session = match session {
            Some(session) => session,
            None => self.session()?,
        };
        let found = self.run_in(&mut session, inputs, outputs);
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(session);
        }
        found
    }
}

/// What the library at a path is. `ort` does not give its version; the text of its build has the commit.
pub(super) fn name(library: &Path) -> Result<String, String> {
    environment(library)?;
    let build = ort::info();
    let commit = (build.split(", ")).find_map(|part| part.strip_prefix("git-commit-id="));
    Ok(match commit {
        Some(commit) => format!("ONNX Runtime of commit {commit}"),
        None => format!("ONNX Runtime ({})", one_line(build)),
    })
}

/// The environment of the library at a path.
fn environment(library: &Path) -> Result<Environment, String> {
    let wrong = |cause: String| {
        format!(
            "{library:?} is no library of ONNX Runtime that can be loaded ({}); give the path of \
             libonnxruntime.so.* (Linux), libonnxruntime.*.dylib (macOS) or onnxruntime.dll (Windows) in the folder \
             onnxruntime/capi of the Python package",
            one_line(&cause)
        )
    };
    let mut loaded = LOADED
        .lock()
        .map_err(|_| wrong("an earlier attempt to load it failed".to_owned()))?;
    if let Some((path, environment)) = loaded.as_ref() {
        if path == library {
            return Ok(environment.clone());
        }
        return Err(format!(
            "this process has already loaded {path:?}, and cannot load {library:?}, too; take the same, or a process of \
             its own"
        ));
    }
    let environment = ort::init_from(library)
        .map_err(|error| wrong(error.to_string()))?
        .with_telemetry(false)
        .build()
        .map_err(|error| wrong(error.to_string()))?;
    *loaded = Some((library.to_owned(), environment.clone()));
    Ok(environment)
}

fn value_of(shape: Vec<usize>, values: InputValues, is_wide: bool) -> Result<DynValue, ort::Error> {
    Ok(match values {
        InputValues::F32(values) => Tensor::from_array((shape, values))?.into_dyn(),
        InputValues::U8(values) => Tensor::from_array((shape, values))?.into_dyn(),
        InputValues::Whole(values) if is_wide => {
            let values: Vec<i64> = values.into_iter().map(i64::from).collect();
            Tensor::from_array((shape, values))?.into_dyn()
        }
        InputValues::Whole(values) => Tensor::from_array((shape, values))?.into_dyn(),
    })
}

#[expect(clippy::cast_precision_loss, reason = "labels are small whole numbers")]
fn raw_output(name: &str, value: &DynValue) -> Result<RawOutput, String> {
    let sides = |shape: &[i64]| {
        shape
            .iter()
            .map(|&side| usize::try_from(side).unwrap_or(0))
            .collect()
    };
    if let Ok((shape, values)) = value.try_extract_tensor::<f32>() {
        return Ok((sides(shape), values.to_vec()));
    }
    if let Ok((shape, values)) = value.try_extract_tensor::<i64>() {
        return Ok((sides(shape), values.iter().map(|&v| v as f32).collect()));
    }
    if let Ok((shape, values)) = value.try_extract_tensor::<i32>() {
        return Ok((sides(shape), values.iter().map(|&v| v as f32).collect()));
    }
    Err(format!(
        "the output {name:?} is no tensor of 32-bit floating point or of integers; export it with 32 bits"
    ))
}
