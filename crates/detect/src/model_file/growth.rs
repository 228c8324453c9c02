//! How long the sides of values become, as far as the file says it.
//!
//! Operators that make much out of little are followed, and those that hand a shape on. It is what
//! the loading of a model may compute, and what a run computes for a frame of [`USUAL_SIDE_PX`]
//! where the file leaves the sides open; the runtime knows more of the other operators.

use std::collections::BTreeMap;

use rten_onnx::onnx::{AttributeProto, DataType, NodeProto, TensorProto};

/// The side of a frame that stands for one that the file leaves open, px.
const USUAL_SIDE_PX: u64 = 640;

/// Sides of values, and constants that may be shapes.
#[derive(Default)]
pub(super) struct Shapes<'a> {
    sides: BTreeMap<&'a str, Vec<u64>>,
    constants: BTreeMap<&'a str, &'a TensorProto>,
}

impl<'a> Shapes<'a> {
    /// A tensor that is in the file.
    pub(super) fn constant(&mut self, name: &'a str, tensor: &'a TensorProto) {
        self.sides.insert(name, whole_sides(&tensor.dims));
        self.constants.insert(name, tensor);
    }

    /// A value whose sides are declared; open ones are those of a usual frame, and of one image.
    pub(super) fn declared(&mut self, name: &'a str, sides: &[Option<i64>]) {
        let side = |(place, side): (usize, &Option<i64>)| match side {
            Some(side) if *side > 0 => side.unsigned_abs(),
            _ if place < 2 => 1,
            _ => USUAL_SIDE_PX,
        };
        let sides = sides.iter().enumerate().map(side).collect();
        self.sides.insert(name, sides);
    }

    /// The sides of what an operator gives, where they are known.
    pub(super) fn compute(&mut self, node: &'a NodeProto) -> Option<&[u64]> {
        let sides = self.sides_of(node)?;
        let name = node.output.first()?.as_str();
        self.sides.insert(name, sides);
        self.sides.get(name).map(Vec::as_slice)
    }

    fn sides_of(&self, node: &NodeProto) -> Option<Vec<u64>> {
        let first = self.sides(node, 0);
        match node.op_type.as_deref()? {
            "ConstantOfShape" => self.numbers(node, 0).map(|sides| whole_sides(&sides)),
            "Expand" => {
                let to = whole_sides(&self.numbers(node, 1)?);
                Some(broadcast(first.unwrap_or_default(), &to))
            }
            "Tile" => {
                let times = whole_sides(&self.numbers(node, 1)?);
                let ones = vec![1; times.len()];
                let sides = first.filter(|sides| sides.len() == times.len());
                let sides = sides.unwrap_or(&ones).iter().zip(&times);
                Some(
                    sides
                        .map(|(side, times)| side.saturating_mul(*times))
                        .collect(),
                )
            }
            "Pad" => {
                let pads = match attribute(node, "pads") {
                    Some(pads) => pads.ints.clone(),
                    None => self.numbers(node, 1)?,
                };
                let (before, after) = pads.split_at(pads.len() / 2);
                let each = first?.iter().zip(before.iter().zip(after));
                let padded = each.map(|(side, (a, b))| {
                    let side = i64::try_from(*side).unwrap_or(i64::MAX);
                    let sum = side.saturating_add(*a).saturating_add(*b);
                    u64::try_from(sum).unwrap_or(0)
                });
                Some(padded.collect())
            }
            "Resize" | "Upsample" => {
                if let Some(sides) = self.numbers(node, 3) {
                    return Some(whole_sides(&sides));
                }
                let scales = self.floats(node, 2).or_else(|| self.floats(node, 1))?;
                let sides = first?.iter().zip(scales);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    clippy::cast_precision_loss,
                    reason = "a bound of a size"
                )]
                let scaled = sides.map(|(side, scale)| (*side as f64 * f64::from(scale)) as u64);
                Some(scaled.collect())
            }
            "Concat" => {
                let axis = attribute(node, "axis")?.i?;
                let mut sides = first?.to_vec();
                let axis = match usize::try_from(axis) {
                    Ok(axis) => axis,
                    Err(_) => sides
                        .len()
                        .checked_sub(usize::try_from(axis.unsigned_abs()).ok()?)?,
                };
                let parts = (0..node.input.len()).filter_map(|at| self.sides(node, at)?.get(axis));
                *sides.get_mut(axis)? = parts.fold(0, |sum: u64, side| sum.saturating_add(*side));
                Some(sides)
            }
            "MatMul" => {
                let (a, b) = (first?, self.sides(node, 1)?);
                let ([.., row, _], [.., column]) = (a, b) else {
                    return None;
                };
                Some(vec![*row, *column])
            }
            "Identity" | "Cast" | "Relu" | "LeakyRelu" | "Sigmoid" | "Tanh" | "Clip" | "Exp"
            | "Log" | "Neg" | "Abs" | "Sqrt" | "Floor" | "Ceil" | "Softmax" | "Not" => {
                first.map(<[u64]>::to_vec)
            }
            "Add" | "Sub" | "Mul" | "Div" | "Pow" | "Mod" | "Min" | "Max" | "Mean" | "Sum"
            | "Equal" | "Greater" | "GreaterOrEqual" | "Less" | "LessOrEqual" | "And" | "Or"
            | "Xor" | "Where" => {
                let known = (0..node.input.len()).filter_map(|at| self.sides(node, at));
                known.map(<[u64]>::to_vec).reduce(|a, b| broadcast(&a, &b))
            }
            _ => None,
        }
    }

    fn sides(&self, node: &NodeProto, place: usize) -> Option<&[u64]> {
        let sides = self.sides.get(node.input.get(place)?.as_str())?;
        Some(sides)
    }

    /// The whole numbers of an input that is a constant.
    fn numbers(&self, node: &NodeProto, place: usize) -> Option<Vec<i64>> {
        let stored = |tensor: &TensorProto| tensor.int64_data.clone();
        self.constant_of(node, place, DataType::INT64, stored, i64::from_le_bytes)
    }

    /// The numbers of an input that is a constant.
    fn floats(&self, node: &NodeProto, place: usize) -> Option<Vec<f32>> {
        let stored = |tensor: &TensorProto| tensor.float_data.clone();
        self.constant_of(node, place, DataType::FLOAT, stored, f32::from_le_bytes)
    }

    /// The values of an input that is a constant of this type, from their list or from raw bytes.
    fn constant_of<T, const N: usize>(
        &self,
        node: &NodeProto,
        place: usize,
        data_type: DataType,
        stored: impl Fn(&TensorProto) -> Vec<T>,
        of_bytes: fn([u8; N]) -> T,
    ) -> Option<Vec<T>> {
        let tensor = self.constants.get(node.input.get(place)?.as_str())?;
        if tensor.data_type != Some(data_type) {
            return None;
        }
        let stored = stored(tensor);
        if !stored.is_empty() {
            return Some(stored);
        }
        let raw = tensor.raw_data.as_ref()?.try_borrow().ok()?;
        let (values, _) = raw.as_chunks::<N>();
        Some(values.iter().map(|bytes| of_bytes(*bytes)).collect())
    }
}

fn attribute<'a>(node: &'a NodeProto, name: &str) -> Option<&'a AttributeProto> {
    let mut attributes = node.attribute.iter();
    attributes.find(|attribute| attribute.name.as_deref() == Some(name))
}

/// Sides that are none count as 1.
fn whole_sides(sides: &[i64]) -> Vec<u64> {
    let side = |side: &i64| u64::try_from(*side).unwrap_or(1).max(1);
    sides.iter().map(side).collect()
}

/// The longer side of each pair, from the last on.
fn broadcast(a: &[u64], b: &[u64]) -> Vec<u64> {
    let (long, short) = if a.len() < b.len() { (b, a) } else { (a, b) };
    let mut sides = long.to_vec();
    for (side, other) in sides.iter_mut().rev().zip(short.iter().rev()) {
        *side = (*side).max(*other);
    }
    sides
}
