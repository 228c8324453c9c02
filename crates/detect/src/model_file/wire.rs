//! A walk over the bytes of an ONNX file before a parser gets them.
//!
//! The parser of rten 0.27 never ends on a number of more than ten bytes, follows lengths beyond the
//! end of the file, takes a file that is cut between two parts for a whole one, and goes as deep as
//! the file does. None of that gets past here.

/// Deepest message inside of messages: a graph in an operator takes four.
const MAX_DEPTH: u32 = 96;

/// The messages of ONNX that have messages or packed numbers inside, by the numbers of their
/// fields in `onnx.proto`.
#[derive(Debug, Clone, Copy)]
enum Message {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
    SparseTensor,
    ValueInfo,
    Type,
    TypeInside,
    Shape,
    Function,
    /// Numbers and texts only.
    Leaf,
}

/// What the bytes of a field are.
enum Inside {
    Message(Message),
    /// Numbers one after the other.
    Numbers,
    Bytes,
}

impl Message {
    fn inside(self, field: u64) -> Inside {
        let message = match (self, field) {
            (Self::Model, 7) | (Self::Attribute, 6 | 11) => Self::Graph,
            (Self::Model, 8 | 14)
            | (Self::Tensor, 13)
            | (Self::Shape, 1)
            | (Self::Function, 9)
            | (Self::Node, 9) => Self::Leaf,
            (Self::Model, 25) => Self::Function,
            (Self::Graph, 1) | (Self::Function, 7) => Self::Node,
            (Self::Graph, 5) | (Self::Attribute, 5 | 10) | (Self::SparseTensor, 1 | 2) => {
                Self::Tensor
            }
            (Self::Graph, 15) | (Self::Attribute, 22 | 23) => Self::SparseTensor,
            (Self::Graph, 11..=13) => Self::ValueInfo,
            (Self::Node, 5) => Self::Attribute,
            (Self::ValueInfo, 2) | (Self::Attribute, 14 | 15) => Self::Type,
            (Self::Type, 1 | 4 | 5 | 8 | 9) => Self::TypeInside,
            // A tensor has its shape there, a sequence or map its kind.
            (Self::TypeInside, 1) => Self::Type,
            (Self::TypeInside, 2) => Self::Shape,
            (Self::Tensor, 1 | 5 | 7 | 11) | (Self::Attribute, 8) | (Self::SparseTensor, 3) => {
                return Inside::Numbers;
            }
            _ => return Inside::Bytes,
        };
        Inside::Message(message)
    }
}

/// The bytes are messages inside of messages, whole to the last byte.
///
/// # Errors
///
/// What is wrong, for a message.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    walk(Message::Model, bytes, 0)
}

fn walk(message: Message, mut bytes: &[u8], depth: u32) -> Result<(), String> {
    if depth > MAX_DEPTH {
        return Err(format!(
            "its parts lie inside of each other more than {MAX_DEPTH} deep"
        ));
    }
    while !bytes.is_empty() {
        let tag = number(&mut bytes)?;
        let field = tag >> 3;
        if field == 0 {
            return Err("a part has the number 0".to_owned());
        }
        match tag & 7 {
            0 => {
                number(&mut bytes)?;
            }
            1 => {
                take(&mut bytes, 8)?;
            }
            5 => {
                take(&mut bytes, 4)?;
            }
            2 => {
                let length = number(&mut bytes)?;
                let part = take(&mut bytes, length)?;
                match message.inside(field) {
                    Inside::Message(inside) => walk(inside, part, depth + 1)?,
                    Inside::Numbers => {
                        let mut numbers = part;
                        while !numbers.is_empty() {
                            number(&mut numbers)?;
                        }
                    }
                    Inside::Bytes => {}
                }
            }
            other => return Err(format!("a part is of the unknown kind {other}")),
        }
    }
    Ok(())
}

fn take<'a>(bytes: &mut &'a [u8], length: u64) -> Result<&'a [u8], String> {
    let n_left = bytes.len();
    let split = usize::try_from(length)
        .ok()
        .and_then(|length| bytes.split_at_checked(length));
    match split {
        Some((part, rest)) => {
            *bytes = rest;
            Ok(part)
        }
        None => Err(format!(
            "it is cut short: a part of {length} bytes has only {n_left}"
        )),
    }
}

/// A number of 7 bits per byte.
fn number(bytes: &mut &[u8]) -> Result<u64, String> {
    let mut value = 0_u64;
    for place in 0..10 {
        let Some((&byte, rest)) = bytes.split_first() else {
            return Err("it is cut short within a number".to_owned());
        };
        *bytes = rest;
        if place == 9 && byte > 1 {
            break;
        }
        value |= u64::from(byte & 0x7f) << (7 * place);
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err("a number in it is longer than 64 bits".to_owned())
}

#[cfg(test)]
mod tests {
    use super::check;

    #[test]
    fn numbers_and_lengths_are_checked_at_every_depth() {
        // Model { graph: Graph { name: "a" } }, and a version of ten bytes.
        let name = [0x3a, 3, 0x12, 1, b'a'];
        let version = [&[0x08][..], &[0xff; 9], &[1]].concat();
        assert_eq!(check(&name), Ok(()), "a name");
        assert_eq!(check(&version), Ok(()), "the largest number");
        assert!(check(&[0xff; 4096]).is_err(), "no end of a number");
        assert!(check(&name[..4]).is_err(), "cut short");
        // Dimensions of weights, packed: eleven bytes without an end.
        let dims = [&[0x3a, 15, 0x2a, 13, 0x0a, 11][..], &[0xff; 11]].concat();
        assert!(check(&dims).is_err(), "no end of a packed number");
        // A length of 2^64 - 1 would lead backwards.
        let back = [&[0x12][..], &[0xff; 9], &[1, 0]].concat();
        assert!(check(&back).is_err(), "a length beyond the end");
    }

    #[test]
    fn messages_inside_of_each_other_have_an_end() {
        // From the inside out: a graph in an attribute of a node of a graph, and so on.
        let nested = |n_graphs: u32| {
            let mut bytes: Vec<u8> = Vec::new();
            for depth in 0..3 * n_graphs {
                let tag = [0x32, 0x2a, 0x0a].get(depth as usize % 3).copied();
                let mut outer = vec![tag.unwrap_or(0)];
                let mut length = bytes.len();
                while length >= 0x80 {
                    outer.push(u8::try_from(length & 0x7f).unwrap_or(0) | 0x80);
                    length >>= 7;
                }
                outer.push(u8::try_from(length).unwrap_or(0));
                outer.append(&mut bytes);
                bytes = outer;
            }
            // The outermost graph is that of the model.
            let mut model = vec![0x3a];
            let mut length = bytes.len();
            while length >= 0x80 {
                model.push(u8::try_from(length & 0x7f).unwrap_or(0) | 0x80);
                length >>= 7;
            }
            model.push(u8::try_from(length).unwrap_or(0));
            model.append(&mut bytes);
            model
        };
        assert_eq!(check(&nested(4)), Ok(()), "four deep");
        let refusal = check(&nested(60)).err().unwrap_or_default();
        assert!(refusal.contains("deep"), "{refusal}");
    }
}
