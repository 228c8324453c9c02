//! The default: rten, in Rust.

use std::fmt;
use std::sync::{Arc, Mutex};

use rten::{
    Dimension, LoadErrorKind, Model, ModelOptions, RunOptions, ThreadPool, Value, ValueOrView,
};
use rten_tensor::{AsView as _, Layout as _, Tensor};
use starbreak_dataset::fence;

use super::{InputTensor, InputValues, RawOutput, Runtime};
use crate::model_file::{ModelFacts, one_line};

/// A model in rten.
pub(crate) struct PureRust {
    model: Model,
    /// Pools of one thread that no run has at the moment.
    idle: Mutex<Vec<Arc<ThreadPool>>>,
}

impl fmt::Debug for PureRust {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PureRust").finish_non_exhaustive()
    }
}

impl PureRust {
    /// The model in the bytes of a file, with the files of weights beside it, of which no value may
    /// become longer than so many bytes.
    pub(crate) fn load(
        bytes: Vec<u8>,
        external: Vec<(String, Vec<u8>)>,
        facts: &ModelFacts,
        max_tensor_bytes: u64,
    ) -> Result<Self, String> {
        if facts.has_operator("NonMaxSuppression") {
            return Err(
                "has the operator NonMaxSuppression, by which rten loses and gains boxes; run it with \
                 --runtime onnxruntime (docs/detectors.md), or export it without suppression"
                    .to_owned(),
            );
        }
        let load = || {
            let mut options = ModelOptions::with_all_ops();
            for (name, bytes) in external {
                options.external_data(&name, bytes);
            }
            options.load(bytes)
        };
        let loaded = fence(load);
        let model = match loaded {
            Some(Ok(model)) => model,
            Some(Err(error)) => {
                let text = one_line(&error.to_string());
                let way_out = match error.kind() {
                    LoadErrorKind::OperatorInvalid => {
                        "; ONNX Runtime knows all operators: --runtime onnxruntime (docs/detectors.md)"
                    }
                    LoadErrorKind::ExternalDataError => {
                        "; put the files of weights beside the model again, unchanged"
                    }
                    _ => "; export it again, or run it with --runtime onnxruntime",
                };
                return Err(format!("cannot be loaded: {text}{way_out}"));
            }
            None => {
                return Err(
                    "cannot be loaded: its graph breaks the runtime; run it with --runtime onnxruntime"
                        .to_owned(),
                );
            }
        };
        let sizes = facts
            .values
            .iter()
            .map(|name| (name, bytes_of(&model, name)));
        if let Some((name, n_bytes)) = sizes.into_iter().find(|(_, n)| *n > max_tensor_bytes) {
            return Err(format!(
                "asks for {n_bytes} bytes or more: the value {name:?}; at most {max_tensor_bytes} are allowed for one \
                 tensor; export it for smaller images or batches"
            ));
        }
        Ok(Self {
            model,
            idle: Mutex::new(Vec::new()),
        })
    }

    fn run_in(
        &self,
        pool: &Arc<ThreadPool>,
        inputs: Vec<InputTensor>,
        outputs: &[String],
    ) -> Result<Vec<RawOutput>, String> {
        let mut given: Vec<(rten::NodeId, ValueOrView<'_>)> = Vec::new();
        for input in inputs {
            let node = self.model.node_id(&input.name);
            let node = node.map_err(|error| one_line(&error.to_string()))?;
            let value = value_of(&input.shape, input.values)?;
            given.push((node, value.into()));
        }
        let mut wanted = Vec::new();
        for output in outputs {
            let node = self.model.node_id(output);
            wanted.push(node.map_err(|error| one_line(&error.to_string()))?);
        }
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(pool)));
        let values = self
            .model
            .run(given, &wanted, Some(options))
            .map_err(|error| format!("it cannot be run: {}", one_line(&error.to_string())))?;
        values.into_iter().map(raw_output).collect()
    }
}

impl Runtime for PureRust {
    fn run(&self, inputs: Vec<InputTensor>, outputs: &[String]) -> Result<Vec<RawOutput>, String> {
        // One thread per run: sums come in one order, and images are what is done side by side.
        let pool = self.idle.lock().ok().and_then(|mut idle| idle.pop());
        let pool = pool.unwrap_or_else(|| Arc::new(ThreadPool::with_num_threads(1)));
        let ran = fence(|| self.run_in(&pool, inputs, outputs));
        if let Ok(mut idle) = self.idle.lock() {
            idle.push(pool);
        }
        ran.unwrap_or_else(|| {
            Err("its graph breaks the runtime; run it with --runtime onnxruntime".to_owned())
        })
    }
}

/// How long a value becomes by what the runtime knows of its shape, in bytes; sides that it does not
/// know count as 1.
fn bytes_of(model: &Model, name: &str) -> u64 {
    let node = model.find_node(name).and_then(|node| model.node_info(node));
    let shape = node.and_then(|node| node.shape()).unwrap_or_default();
    let sides = shape.iter().filter_map(|side| match side {
        Dimension::Fixed(side) => u64::try_from(*side).ok(),
        Dimension::Symbolic(_) => None,
    });
    sides.fold(4, u64::saturating_mul)
}

fn value_of(shape: &[usize], values: InputValues) -> Result<Value, String> {
    let fits = |n: usize| {
        if shape.iter().product::<usize>() == n {
            Ok(())
        } else {
            Err(format!("{n} numbers do not fill an input {shape:?}"))
        }
    };
    Ok(match values {
        InputValues::F32(values) => {
            fits(values.len())?;
            Tensor::from_data(shape, values).into()
        }
        InputValues::U8(values) => {
            fits(values.len())?;
            Tensor::from_data(shape, values).into()
        }
        InputValues::Whole(values) => {
            fits(values.len())?;
            Tensor::from_data(shape, values).into()
        }
    })
}

fn raw_output(value: Value) -> Result<RawOutput, String> {
    #[expect(clippy::cast_precision_loss, reason = "labels are small whole numbers")]
    Ok(match value {
        Value::FloatTensor(tensor) => (tensor.shape().to_vec(), tensor.to_vec()),
        Value::Int32Tensor(tensor) => (
            tensor.shape().to_vec(),
            tensor.iter().map(|&value| value as f32).collect(),
        ),
        Value::Int8Tensor(tensor) => (
            tensor.shape().to_vec(),
            tensor.iter().map(|&value| f32::from(value)).collect(),
        ),
        Value::UInt8Tensor(tensor) => (
            tensor.shape().to_vec(),
            tensor.iter().map(|&value| f32::from(value)).collect(),
        ),
        _ => return Err("an output is a sequence, not a tensor".to_owned()),
    })
}
