//! Small ONNX graphs with the names and shapes of real detectors, built in memory.
#![allow(dead_code, reason = "each test file uses a part of it")]
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot build its graph has failed"
)]

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use rten_onnx::onnx::{
    AttributeProto, DataType, Dimension, GraphProto, ModelProto, NodeProto, OperatorSetIdProto,
    StringStringEntryProto, TensorProto, TensorShapeProto, TypeProto, TypeProtoTensor,
    ValueInfoProto,
};

/// A side: fixed, or open with a name.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Dim {
    Is(i64),
    Open(&'static str),
}

/// A number of an output.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    /// Where it stands.
    pub(crate) at: Vec<i64>,
    /// What it is, plus …
    pub(crate) value: f32,
    /// … so much …
    pub(crate) gain: f32,
    /// … of the number of the image input that stands here.
    pub(crate) pixel: Vec<i64>,
}

/// A number that does not depend on the image.
pub(crate) fn fixed(at: &[i64], value: f32) -> Entry {
    Entry {
        at: at.to_vec(),
        value,
        gain: 0.0,
        pixel: Vec::new(),
    }
}

/// A number of the image input.
pub(crate) fn seen(at: &[i64], pixel: &[i64]) -> Entry {
    Entry {
        at: at.to_vec(),
        value: 0.0,
        gain: 1.0,
        pixel: pixel.to_vec(),
    }
}

/// A graph that is being built.
#[derive(Default)]
pub(crate) struct Builder {
    graph: GraphProto,
    metadata: Vec<StringStringEntryProto>,
    /// What outputs see instead of the first input, and how many sides it has.
    seen: Option<(String, usize)>,
}

impl Builder {
    pub(crate) fn input(mut self, name: &str, element: DataType, dims: &[Dim]) -> Self {
        self.graph.input.push(value_info(name, element, dims));
        self
    }

    pub(crate) fn image(self, name: &str, dims: &[i64]) -> Self {
        let dims: Vec<Dim> = dims.iter().map(|&side| Dim::Is(side)).collect();
        self.input(name, DataType::FLOAT, &dims)
    }

    pub(crate) fn metadata(mut self, key: &str, value: &str) -> Self {
        self.metadata.push(StringStringEntryProto {
            key: Some(key.to_owned()),
            value: Some(value.to_owned()),
        });
        self
    }

    /// An output of zeros with some other numbers.
    pub(crate) fn output(self, name: &str, shape: &[i64], entries: &[Entry]) -> Self {
        let dims: Vec<Dim> = shape.iter().map(|&side| Dim::Is(side)).collect();
        self.output_as(name, &dims, shape, entries, DataType::FLOAT)
    }

    /// The same, declared with other sides or of whole numbers.
    pub(crate) fn output_as(
        mut self,
        name: &str,
        declared: &[Dim],
        shape: &[i64],
        entries: &[Entry],
        element: DataType,
    ) -> Self {
        let image = self.graph.input.first().unwrap();
        let first = (image.name.clone().unwrap(), rank_of(image));
        let (image_name, rank) = self.seen.clone().unwrap_or(first);
        let n = i64::try_from(entries.len()).unwrap();
        let part = |what: &str| format!("{name}/{what}");
        let flat = |rows: Vec<Vec<i64>>| rows.into_iter().flatten().collect::<Vec<i64>>();
        let pixels = entries.iter().map(|entry| match entry.pixel.len() {
            0 => vec![0; rank],
            _ => entry.pixel.clone(),
        });
        let sides = i64::try_from(shape.len()).unwrap();
        self.whole(&part("shape"), &[sides], shape);
        self.whole(
            &part("at"),
            &[n, sides],
            &flat(entries.iter().map(|e| e.at.clone()).collect()),
        );
        self.whole(
            &part("pixels"),
            &[n, i64::try_from(rank).unwrap()],
            &flat(pixels.collect()),
        );
        self.floats(&part("values"), &[n], entries.iter().map(|e| e.value));
        self.floats(&part("gains"), &[n], entries.iter().map(|e| e.gain));
        self.node("ConstantOfShape", &[&part("shape")], &part("zeros"));
        self.node("GatherND", &[&image_name, &part("pixels")], &part("seen"));
        self.node("Mul", &[&part("seen"), &part("gains")], &part("weighted"));
        self.node(
            "Add",
            &[&part("weighted"), &part("values")],
            &part("numbers"),
        );
        let inputs = [part("zeros"), part("at"), part("numbers")];
        let inputs = [inputs[0].as_str(), inputs[1].as_str(), inputs[2].as_str()];
        if element == DataType::FLOAT {
            self.node("ScatterND", &inputs, name);
        } else {
            self.node("ScatterND", &inputs, &part("floats"));
            self.node("Cast", &[&part("floats")], name);
            self.attribute_of_last("to", i64::from(element.0));
        }
        self.graph.output.push(value_info(name, element, declared));
        self
    }

    /// Lets further outputs see an input of whole numbers instead of the image.
    pub(crate) fn reading(mut self, input: &str, rank: usize) -> Self {
        let floats = format!("{input}/floats");
        self.node("Cast", &[input], &floats);
        self.attribute_of_last("to", i64::from(DataType::FLOAT.0));
        self.seen = Some((floats, rank));
        self
    }

    /// A node of its own, whose result is an output.
    pub(crate) fn operator(mut self, operator: &str, input: &str, output: &str) -> Self {
        self.node(operator, &[input], output);
        self
    }

    /// A node of its own with weights or several inputs.
    pub(crate) fn operation(mut self, operator: &str, inputs: &[&str], output: &str) -> Self {
        self.node(operator, inputs, output);
        self
    }

    /// Weights of a node.
    pub(crate) fn weights(mut self, name: &str, dims: &[i64], values: &[f32]) -> Self {
        self.floats(name, dims, values.iter().copied());
        self
    }

    /// Whole numbers that a node takes.
    pub(crate) fn whole_numbers(mut self, name: &str, dims: &[i64], values: &[i64]) -> Self {
        self.whole(name, dims, values);
        self
    }

    /// Declares what a node gives as an output.
    pub(crate) fn declare(mut self, name: &str, dims: &[i64]) -> Self {
        let dims: Vec<Dim> = dims.iter().map(|&side| Dim::Is(side)).collect();
        self.graph
            .output
            .push(value_info(name, DataType::FLOAT, &dims));
        self
    }

    fn node(&mut self, operator: &str, inputs: &[&str], output: &str) {
        self.graph.node.push(NodeProto {
            name: Some(format!("{operator} of {output}")),
            op_type: Some(operator.to_owned()),
            input: inputs.iter().map(|&name| name.to_owned()).collect(),
            output: vec![output.to_owned()],
            ..NodeProto::default()
        });
    }

    fn attribute_of_last(&mut self, name: &str, value: i64) {
        let attribute = AttributeProto {
            name: Some(name.to_owned()),
            i: Some(value),
            r#type: Some(rten_onnx::onnx::AttributeType(2)),
            ..AttributeProto::default()
        };
        self.graph
            .node
            .last_mut()
            .unwrap()
            .attribute
            .push(attribute);
    }

    fn whole(&mut self, name: &str, dims: &[i64], values: &[i64]) {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        self.initializer(name, dims, DataType::INT64, bytes.collect());
    }

    fn floats(&mut self, name: &str, dims: &[i64], values: impl Iterator<Item = f32>) {
        let bytes = values.flat_map(f32::to_le_bytes);
        self.initializer(name, dims, DataType::FLOAT, bytes.collect());
    }

    fn initializer(&mut self, name: &str, dims: &[i64], element: DataType, bytes: Vec<u8>) {
        self.graph.initializer.push(TensorProto {
            name: Some(name.to_owned()),
            dims: dims.to_vec(),
            data_type: Some(element),
            raw_data: Some(RefCell::new(bytes)),
            ..TensorProto::default()
        });
    }

    /// Changes the graph by hand.
    pub(crate) fn edit(mut self, change: impl FnOnce(&mut GraphProto)) -> Self {
        change(&mut self.graph);
        self
    }

    pub(crate) fn bytes(self) -> Vec<u8> {
        let model = ModelProto {
            ir_version: Some(8),
            graph: Some(self.graph),
            opset_import: vec![OperatorSetIdProto {
                domain: Some(String::new()),
                version: Some(13),
            }],
            metadata_props: self.metadata,
            ..ModelProto::default()
        };
        model.write_buf().unwrap()
    }

    /// Writes it into a folder.
    pub(crate) fn write(self, folder: &Path, name: &str) -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, self.bytes()).unwrap();
        path
    }
}

fn rank_of(value: &ValueInfoProto) -> usize {
    let tensor = value.r#type.as_ref().unwrap().tensor_type.as_ref().unwrap();
    tensor.shape.as_ref().unwrap().dim.len()
}

fn value_info(name: &str, element: DataType, dims: &[Dim]) -> ValueInfoProto {
    let dim = dims.iter().map(|dim| match dim {
        Dim::Is(side) => Dimension {
            dim_value: Some(*side),
            dim_param: None,
        },
        Dim::Open(name) => Dimension {
            dim_value: None,
            dim_param: Some((*name).to_owned()),
        },
    });
    ValueInfoProto {
        name: Some(name.to_owned()),
        r#type: Some(TypeProto {
            tensor_type: Some(TypeProtoTensor {
                elem_type: Some(element),
                shape: Some(TensorShapeProto { dim: dim.collect() }),
            }),
            ..TypeProto::default()
        }),
    }
}
