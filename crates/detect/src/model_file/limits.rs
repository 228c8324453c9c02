//! How much memory a model may ask for, before any of it is taken.

use rten_onnx::onnx::{
    DataType, GraphProto, ModelProto, NodeProto, TensorProto, TensorShapeProto, TypeProtoTensor,
    ValueInfoProto,
};

use super::growth::Shapes;
use crate::DetectError;

/// How much memory a model may ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModelLimits {
    /// Longest file, with the weights beside it, bytes. **Default** 4 GiB.
    pub max_file_bytes: u64,
    /// Largest tensor that the file declares or builds out of constants, bytes. **Default** 4 GiB.
    pub max_tensor_bytes: u64,
    /// Most graphs inside of each other. **Default** 16.
    pub max_depth: u32,
}

impl Default for ModelLimits {
    fn default() -> Self {
        Self {
            max_file_bytes: 4 << 30,
            max_tensor_bytes: 4 << 30,
            max_depth: 16,
        }
    }
}

/// Nothing that is declared is beyond the limits.
pub(super) fn check(
    name: &str,
    model: &ModelProto,
    graph: &GraphProto,
    limits: &ModelLimits,
) -> Result<(), DetectError> {
    let check = Check { name, limits };
    if model.opset_import.is_empty() {
        return Err(check.wrong("names no version of its operators; export it again".to_owned()));
    }
    check.graph(graph, 0)
}

struct Check<'a> {
    name: &'a str,
    limits: &'a ModelLimits,
}

impl Check<'_> {
    fn wrong(&self, reason: String) -> DetectError {
        DetectError::Model {
            model: self.name.to_owned(),
            reason,
        }
    }

    fn graph(&self, graph: &GraphProto, depth: u32) -> Result<(), DetectError> {
        if depth > self.limits.max_depth {
            return Err(self.wrong(format!(
                "has graphs inside of each other, more than {} deep",
                self.limits.max_depth
            )));
        }
        let mut shapes = Shapes::default();
        for tensor in &graph.initializer {
            let name = tensor.name.as_deref().unwrap_or_default();
            self.tensor("its weights", name, tensor)?;
            shapes.constant(name, tensor);
        }
        for value in graph
            .input
            .iter()
            .chain(&graph.output)
            .chain(&graph.value_info)
        {
            self.declared(value)?;
        }
        for value in &graph.input {
            let name = value.name.as_deref().unwrap_or_default();
            if let Some(shape) = shape_of(value) {
                let sides: Vec<_> = shape.dim.iter().map(|dim| dim.dim_value).collect();
                shapes.declared(name, &sides);
            }
        }
        for node in &graph.node {
            for attribute in &node.attribute {
                if let Some(tensor) = &attribute.t {
                    let name = node.output.first().map_or("", String::as_str);
                    self.tensor("a constant", name, tensor)?;
                    if node.op_type.as_deref() == Some("Constant") {
                        shapes.constant(name, tensor);
                    }
                }
                if let Some(inside) = &attribute.g {
                    self.graph(inside, depth + 1)?;
                }
            }
            self.grown(node, &mut shapes)?;
        }
        Ok(())
    }

    /// A tensor whose sides are written down.
    fn tensor(&self, what: &str, name: &str, tensor: &TensorProto) -> Result<(), DetectError> {
        if tensor.dims.iter().any(|&side| side < 0) {
            return Err(self.wrong(format!(
                "declares {what} {name:?} with a negative side {:?}; export it again",
                tensor.dims
            )));
        }
        let of_type = bytes_of(tensor.data_type);
        self.size(what, name, tensor.dims.iter().copied(), of_type)
    }

    fn declared(&self, value: &ValueInfoProto) -> Result<(), DetectError> {
        let Some(shape) = shape_of(value) else {
            return Ok(());
        };
        let sides = shape.dim.iter().filter_map(|dim| dim.dim_value);
        let sides = sides.filter(|&side| side > 0);
        let name = value.name.as_deref().unwrap_or_default();
        let kind = tensor_of(value).and_then(|tensor| tensor.elem_type);
        self.size("the value", name, sides, bytes_of(kind))
    }

    /// What an operator gives, as far as it is known.
    fn grown<'a>(&self, node: &'a NodeProto, shapes: &mut Shapes<'a>) -> Result<(), DetectError> {
        let Some(sides) = shapes.compute(node) else {
            return Ok(());
        };
        let operator = node.op_type.as_deref().unwrap_or_default();
        let name = node.output.first().map_or("", String::as_str);
        let sides = sides
            .iter()
            .map(|side| i64::try_from(*side).unwrap_or(i64::MAX));
        self.size(&format!("{operator} makes"), name, sides, 4)
    }

    fn size(
        &self,
        what: &str,
        name: &str,
        sides: impl Iterator<Item = i64> + Clone,
        n_element_bytes: u64,
    ) -> Result<(), DetectError> {
        let n_bytes = sides.clone().try_fold(n_element_bytes, |product, side| {
            product.checked_mul(u64::try_from(side).ok()?)
        });
        if n_bytes.is_some_and(|n_bytes| n_bytes <= self.limits.max_tensor_bytes) {
            return Ok(());
        }
        let sides: Vec<String> = sides.map(|side| side.to_string()).collect();
        #[expect(clippy::cast_precision_loss, reason = "three digits of it")]
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let size = n_bytes.map_or_else(
            || "more than any memory".to_owned(),
            |n_bytes| format!("{:.1} GiB", gib(n_bytes)),
        );
        Err(self.wrong(format!(
            "asks for {size}: {what} {name:?} of {}; at most {:.1} GiB is allowed for one tensor; export it for smaller images or batches",
            sides.join(" x "),
            gib(self.limits.max_tensor_bytes),
        )))
    }
}

fn tensor_of(value: &ValueInfoProto) -> Option<&TypeProtoTensor> {
    value.r#type.as_ref()?.tensor_type.as_ref()
}

fn shape_of(value: &ValueInfoProto) -> Option<&TensorShapeProto> {
    tensor_of(value)?.shape.as_ref()
}

fn bytes_of(kind: Option<DataType>) -> u64 {
    match kind {
        Some(DataType::INT64 | DataType::DOUBLE) => 8,
        Some(DataType::FLOAT16) => 2,
        Some(DataType::UINT8 | DataType::INT8 | DataType::BOOL) => 1,
        _ => 4,
    }
}
