//! A walk over the fields of a message in CDR, which changes none of them.
//!
//! Plain CDR (XCDR version 1, as ROS 2 writes it): 4 bytes of header, then the fields, each number at a multiple of its
//! own size from the end of that header \[OMG2020, 7.4\].

use std::ops::Range;

use crate::bag_error::MessageFault;

/// Bytes of the header.
const HEADER: usize = 4;

/// Identifiers of encapsulations that are not plain CDR, with their names.
const OTHERS: [(u16, &str); 10] = [
    (0x0002, "PL_CDR_BE, a parameter list"),
    (0x0003, "PL_CDR_LE, a parameter list"),
    (0x0004, "XML"),
    (0x0006, "CDR2_BE"),
    (0x0007, "CDR2_LE"),
    (0x0008, "D_CDR2_BE, a delimited record"),
    (0x0009, "D_CDR2_LE, a delimited record"),
    (0x000a, "PL_CDR2_BE, a parameter list"),
    (0x000b, "PL_CDR2_LE, a parameter list"),
    (0x0100, "a vendor's own"),
];

/// The order of bytes in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Big,
    Little,
}

impl Order {
    /// Of a message, by its header.
    pub(super) fn of(message: &[u8]) -> Result<Self, MessageFault> {
        let Some([high, low, _, _]) = message.first_chunk() else {
            return Err(MessageFault::NoHeader {
                n_bytes: message.len(),
            });
        };
        match u16::from_be_bytes([*high, *low]) {
            0x0000 => Ok(Self::Big),
            0x0001 => Ok(Self::Little),
            id => Err(MessageFault::Encapsulation {
                id,
                name: OTHERS
                    .iter()
                    .find(|(known, _)| *known == id)
                    .map_or("not known", |(_, name)| name),
            }),
        }
    }

    pub(super) fn bytes(self, number: u32) -> [u8; 4] {
        match self {
            Self::Big => number.to_be_bytes(),
            Self::Little => number.to_le_bytes(),
        }
    }
}

/// A place in a message, from field to field.
#[derive(Debug)]
pub(super) struct Walk<'a> {
    message: &'a [u8],
    order: Order,
    /// From the beginning of the message.
    at: usize,
}

impl<'a> Walk<'a> {
    /// At the first field.
    pub(super) fn of(message: &'a [u8]) -> Result<Self, MessageFault> {
        Ok(Self {
            message,
            order: Order::of(message)?,
            at: HEADER,
        })
    }

    pub(super) fn order(&self) -> Order {
        self.order
    }

    pub(super) fn u8(&mut self, field: &'static str) -> Result<u8, MessageFault> {
        let [byte] = self.take(field)?;
        Ok(byte)
    }

    pub(super) fn u32(&mut self, field: &'static str) -> Result<u32, MessageFault> {
        self.at = self.at.next_multiple_of(4);
        let bytes = self.take(field)?;
        Ok(match self.order {
            Order::Big => u32::from_be_bytes(bytes),
            Order::Little => u32::from_le_bytes(bytes),
        })
    }

    /// Where the bytes of a sequence lie in the message.
    pub(super) fn sequence(&mut self, field: &'static str) -> Result<Range<usize>, MessageFault> {
        let n_bytes = self.u32(field)?;
        let n_left = self.n_left();
        let length = usize::try_from(n_bytes).unwrap_or(usize::MAX);
        if length > n_left {
            return Err(MessageFault::Long {
                field,
                n_bytes,
                n_left,
            });
        }
        let from = self.at;
        self.at += length;
        Ok(from..self.at)
    }

    /// Where the bytes of a text lie in the message, without the zero at its end. A text of no bytes at all, as some
    /// write the empty one, is empty.
    pub(super) fn text(&mut self, field: &'static str) -> Result<Range<usize>, MessageFault> {
        let Range { start, end } = self.sequence(field)?;
        match self.message.get(start..end).and_then(<[u8]>::split_last) {
            None => Ok(start..end),
            Some((0, _)) => Ok(start..end - 1),
            Some(_) => Err(MessageFault::NotText { field }),
        }
    }

    /// Bytes from here to the end.
    pub(super) fn n_left(&self) -> usize {
        self.message.len().saturating_sub(self.at)
    }

    fn take<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], MessageFault> {
        let rest = self.message.get(self.at..).unwrap_or_default();
        let Some(bytes) = rest.first_chunk() else {
            return Err(MessageFault::Short {
                field,
                n_left: rest.len(),
            });
        };
        self.at += N;
        Ok(*bytes)
    }
}

/// A message in little-endian CDR, as it is written.
#[derive(Debug)]
pub(super) struct Written(Vec<u8>);

impl Written {
    pub(super) fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    pub(super) fn u8(&mut self, byte: u8) {
        self.0.push(byte);
    }

    pub(super) fn u32(&mut self, number: u32) {
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        self.0.extend_from_slice(&number.to_le_bytes());
    }

    pub(super) fn sequence(&mut self, bytes: &[u8]) -> Result<(), MessageFault> {
        self.u32(length_of(bytes)?);
        self.0.extend_from_slice(bytes);
        Ok(())
    }

    pub(super) fn text(&mut self, text: &[u8]) -> Result<(), MessageFault> {
        self.sequence(&[text, &[0]].concat())
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

/// The length of a sequence as CDR counts it.
pub(super) fn length_of(bytes: &[u8]) -> Result<u32, MessageFault> {
    u32::try_from(bytes.len()).map_err(|_| MessageFault::TooLong {
        n_bytes: bytes.len(),
    })
}
