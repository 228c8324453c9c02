//! What a model file says of itself, as plain values.

use std::fmt;

/// What a model file says of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelFacts {
    /// What it takes.
    pub inputs: Vec<TensorFacts>,
    /// What it gives.
    pub outputs: Vec<TensorFacts>,
    /// The operators in it, in order.
    pub operators: Vec<String>,
    /// Names of the values that its operators compute, in the order of the file.
    pub values: Vec<String>,
    /// Files of weights beside it, in order.
    pub external_files: Vec<String>,
    /// What its maker wrote into it.
    pub metadata: Vec<(String, String)>,
    /// The program that wrote it.
    pub producer: String,
}

/// An input or output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TensorFacts {
    /// Its name.
    pub name: String,
    /// Its sides, where they are said.
    pub sides: Option<Vec<Side>>,
    /// What it consists of.
    pub element: TensorType,
}

/// A side of a tensor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Side {
    /// So long.
    Fixed(u64),
    /// Known only when it runs; its name.
    Open(String),
}

/// What a tensor consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TensorType {
    /// 32-bit floating point.
    F32,
    /// 16-bit floating point.
    F16,
    /// 64-bit floating point.
    F64,
    /// 64-bit integers.
    I64,
    /// 32-bit integers.
    I32,
    /// Bytes.
    U8,
    /// Truth values.
    Bool,
    /// Something else.
    Other,
}

impl ModelFacts {
    /// An input by its name.
    #[must_use]
    pub fn input(&self, name: &str) -> Option<&TensorFacts> {
        self.inputs.iter().find(|tensor| tensor.name == name)
    }

    /// An output by its name.
    #[must_use]
    pub fn output(&self, name: &str) -> Option<&TensorFacts> {
        self.outputs.iter().find(|tensor| tensor.name == name)
    }

    /// Whether an operator is in it.
    #[must_use]
    pub(crate) fn has_operator(&self, name: &str) -> bool {
        self.operators.iter().any(|known| known == name)
    }

    /// What its maker wrote under a key.
    #[must_use]
    pub fn entry(&self, key: &str) -> Option<&str> {
        let found = self.metadata.iter().find(|(known, _)| known == key);
        found.map(|(_, value)| value.as_str())
    }
}

impl TensorFacts {
    /// The length of a side, where it is said.
    #[must_use]
    pub fn side(&self, place: usize) -> Option<u64> {
        match self.sides.as_ref()?.get(place)? {
            Side::Fixed(length) => Some(*length),
            Side::Open(_) => None,
        }
    }

    /// How many sides it has, where that is said.
    #[must_use]
    pub fn rank(&self) -> Option<usize> {
        self.sides.as_ref().map(Vec::len)
    }
}

impl fmt::Display for TensorFacts {
    /// Writes `images [1, 3, 640, 640]`, with the names of open sides; control characters in names
    /// are escaped.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(sides) = &self.sides else {
            return write!(f, "{} of unknown shape", self.name.escape_debug());
        };
        let sides: Vec<String> = sides
            .iter()
            .map(|side| match side {
                Side::Fixed(length) => length.to_string(),
                Side::Open(name) => name.escape_debug().to_string(),
            })
            .collect();
        write!(f, "{} [{}]", self.name.escape_debug(), sides.join(", "))
    }
}

impl fmt::Display for ModelFacts {
    /// Writes inputs and outputs on one line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |tensors: &[TensorFacts]| {
            let texts: Vec<String> = tensors.iter().map(TensorFacts::to_string).collect();
            texts.join(", ")
        };
        write!(
            f,
            "takes {}; gives {}",
            list(&self.inputs),
            list(&self.outputs)
        )
    }
}
