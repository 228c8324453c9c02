//! What an ONNX file says of itself, before it is run.

mod growth;
mod limits;
mod names;
mod wire;

use std::collections::BTreeSet;

use rten_onnx::onnx::{DataLocation, DataType, GraphProto, ModelProto, ValueInfoProto};
use starbreak_dataset::fence;

pub use limits::ModelLimits;
pub use names::{ModelFacts, Side, TensorFacts, TensorType};

use crate::DetectError;

impl ModelFacts {
    /// What the bytes of an ONNX file say of it; `name` serves only for messages.
    ///
    /// # Errors
    ///
    /// [`DetectError::Model`] where they are no ONNX model, are cut short, or ask for more memory than
    /// the limits allow.
    pub fn of_bytes(name: &str, bytes: &[u8], limits: &ModelLimits) -> Result<Self, DetectError> {
        read_facts(name, bytes, limits)
    }
}

/// What an ONNX file says of itself.
///
/// # Errors
///
/// [`DetectError::Model`] where the bytes are no ONNX model, are cut short, or ask for more memory
/// than the limits allow.
pub(crate) fn read_facts(
    name: &str,
    bytes: &[u8],
    limits: &ModelLimits,
) -> Result<ModelFacts, DetectError> {
    let wrong = |reason: String| DetectError::Model {
        model: name.to_owned(),
        reason,
    };
    if bytes.is_empty() {
        return Err(wrong("is empty; give an ONNX file".to_owned()));
    }
    let not_onnx = |cause: String| {
        let seems = seems_to_be(bytes).map_or_else(String::new, |what| format!(": {what}"));
        wrong(format!(
            "is no whole ONNX model ({cause}){seems}; export it again, or copy it again as a binary file"
        ))
    };
    wire::check(bytes).map_err(not_onnx)?;
    // The parser is another's: should it ever panic, that is a refusal like any other.
    let parsed = fence(|| ModelProto::parse_buf(bytes));
    let model = match parsed {
        Some(Ok(model)) => model,
        Some(Err(error)) => return Err(not_onnx(one_line(&error.to_string()))),
        None => return Err(not_onnx("its structure breaks the parser".to_owned())),
    };
    let Some(graph) = &model.graph else {
        return Err(not_onnx("there is no graph in it".to_owned()));
    };
    if graph.node.is_empty() || graph.output.is_empty() {
        return Err(not_onnx("its graph computes nothing".to_owned()));
    }
    limits::check(name, &model, graph, limits)?;
    let initializers: BTreeSet<&str> = graph
        .initializer
        .iter()
        .filter_map(|tensor| tensor.name.as_deref())
        .collect();
    let is_given = |value: &&ValueInfoProto| {
        let name = value.name.as_deref().unwrap_or_default();
        !initializers.contains(name)
    };
    let (mut operators, mut external_files) = (BTreeSet::new(), BTreeSet::new());
    walk(graph, &mut operators, &mut external_files);
    let metadata = model
        .metadata_props
        .iter()
        .filter_map(|entry| Some((entry.key.clone()?, entry.value.clone().unwrap_or_default())))
        .collect();
    Ok(ModelFacts {
        inputs: graph
            .input
            .iter()
            .filter(is_given)
            .map(tensor_facts)
            .collect(),
        outputs: graph.output.iter().map(tensor_facts).collect(),
        operators: operators.into_iter().collect(),
        values: graph
            .node
            .iter()
            .flat_map(|node| node.output.iter())
            .filter(|name| !name.is_empty())
            .cloned()
            .collect(),
        external_files: external_files.into_iter().collect(),
        metadata,
        producer: model.producer_name.clone().unwrap_or_default(),
    })
}

/// Operators and files of weights, also of graphs inside of operators.
fn walk(graph: &GraphProto, operators: &mut BTreeSet<String>, files: &mut BTreeSet<String>) {
    for tensor in &graph.initializer {
        if tensor.data_location != Some(DataLocation::EXTERNAL) {
            continue;
        }
        let location = tensor
            .external_data
            .iter()
            .find(|entry| entry.key.as_deref() == Some("location"))
            .and_then(|entry| entry.value.clone());
        files.insert(location.unwrap_or_default());
    }
    for node in &graph.node {
        operators.insert(node.op_type.clone().unwrap_or_default());
        for attribute in &node.attribute {
            if let Some(inside) = &attribute.g {
                walk(inside, operators, files);
            }
        }
    }
}

fn tensor_facts(value: &ValueInfoProto) -> TensorFacts {
    let tensor = value
        .r#type
        .as_ref()
        .and_then(|kind| kind.tensor_type.as_ref());
    let sides = tensor
        .and_then(|tensor| tensor.shape.as_ref())
        .map(|shape| {
            shape
                .dim
                .iter()
                .map(|dim| match (dim.dim_value, &dim.dim_param) {
                    (Some(side), _) => match u64::try_from(side) {
                        Ok(side) if side > 0 => Side::Fixed(side),
                        _ => Side::Open("?".to_owned()),
                    },
                    (None, Some(name)) => Side::Open(name.clone()),
                    (None, None) => Side::Open("?".to_owned()),
                })
                .collect()
        });
    let element = tensor.and_then(|tensor| tensor.elem_type);
    TensorFacts {
        name: value.name.clone().unwrap_or_default(),
        sides,
        element: match element {
            Some(DataType::FLOAT) => TensorType::F32,
            Some(DataType::FLOAT16) => TensorType::F16,
            Some(DataType::DOUBLE) => TensorType::F64,
            Some(DataType::INT64) => TensorType::I64,
            Some(DataType::INT32) => TensorType::I32,
            Some(DataType::UINT8) => TensorType::U8,
            Some(DataType::BOOL) => TensorType::Bool,
            _ => TensorType::Other,
        },
    }
}

/// What a file is that is no ONNX model, by its first bytes.
fn seems_to_be(bytes: &[u8]) -> Option<&'static str> {
    let head = bytes.get(..bytes.len().min(512)).unwrap_or_default();
    let known: [(&[u8], &str); 6] = [
        (
            b"PK\x03\x04",
            "it is a ZIP archive, such as the weights .pt of PyTorch; export them to ONNX",
        ),
        (
            b"\x80\x02",
            "it is a Python pickle; export the model to ONNX",
        ),
        (b"\x89HDF", "it is an HDF5 file; export the model to ONNX"),
        (
            b"version https://git-lfs",
            "it is a pointer of Git LFS; fetch the file itself with git lfs pull",
        ),
        (b"<", "it is a web page or XML; fetch the file itself"),
        (b"\x1f\x8b", "it is gzip; unpack it"),
    ];
    let found = known.iter().find(|(start, _)| head.starts_with(start));
    if let Some((_, what)) = found {
        return Some(what);
    }
    let is_text = head
        .iter()
        .all(|byte| matches!(byte, b'\t' | b'\n' | b'\r' | 0x20..=0x7e));
    is_text.then_some("it is text")
}

/// A message of another's on one line, shortened.
pub(crate) fn one_line(text: &str) -> String {
    let line: Vec<&str> = text.split_whitespace().collect();
    line.join(" ").chars().take(300).collect()
}
