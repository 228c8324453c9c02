//! Numbers in a row of bytes, read with care.

use std::ops::Range;

use crate::OpticsError;

/// Appends a whole number in 7-bit groups, the least first.
pub(super) fn write_count(out: &mut Vec<u8>, mut value: usize) {
    while value >= 0x80 {
        #[expect(clippy::cast_possible_truncation, reason = "seven bits")]
        out.push((value & 0x7f) as u8 | 0x80);
        value >>= 7;
    }
    #[expect(clippy::cast_possible_truncation, reason = "seven bits")]
    out.push(value as u8);
}

/// Reads from the front of some bytes; knows where it is.
pub(super) struct Bytes<'a> {
    what: &'static str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(what: &'static str, bytes: &'a [u8]) -> Self {
        Self { what, bytes, at: 0 }
    }

    /// A part of some bytes, which errors count from the first of all.
    pub(super) fn of_part(what: &'static str, bytes: &'a [u8], part: &Range<usize>) -> Self {
        Self {
            what,
            bytes: bytes.get(..part.end).unwrap_or_default(),
            at: part.start,
        }
    }

    /// The error that what is here is wrong.
    pub(super) fn wrong(&self, why: &'static str) -> OpticsError {
        OpticsError::Packed {
            what: self.what,
            at: self.at.min(self.bytes.len()),
            why,
        }
    }

    /// What has not been read yet.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// Number of bytes that have been read.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// Where the part lies that is written behind its length, and what follows comes next.
    pub(super) fn part(&mut self) -> Result<Range<usize>, OpticsError> {
        let n = self.count(self.bytes.len())?;
        if n > self.rest().len() {
            return Err(self.wrong("it ends in a part"));
        }
        let from = self.at;
        self.skip(n);
        Ok(from..self.at)
    }

    pub(super) fn skip(&mut self, n: usize) {
        self.at += n;
    }

    pub(super) fn take<const N: usize>(&mut self) -> Result<[u8; N], OpticsError> {
        let taken = self
            .rest()
            .first_chunk::<N>()
            .copied()
            .ok_or_else(|| self.wrong("it ends here"))?;
        self.at += N;
        Ok(taken)
    }

    pub(super) fn byte(&mut self) -> Result<u8, OpticsError> {
        self.take::<1>().map(|[byte]| byte)
    }

    /// A number of [`write_count`], at most `limit`.
    #[inline(always)]
    pub(super) fn count(&mut self, limit: usize) -> Result<usize, OpticsError> {
        let mut value = 0_usize;
        for shift in (0..).step_by(7) {
            let byte = usize::from(self.byte()?);
            if shift > 28 {
                return Err(self.wrong("a number is too large"));
            }
            value |= (byte & 0x7f) << shift;
            if byte < 0x80 {
                break;
            }
        }
        if value > limit {
            return Err(self.wrong("a number is too large"));
        }
        Ok(value)
    }

    /// Nothing may be left.
    pub(super) fn end(&self) -> Result<(), OpticsError> {
        match self.rest() {
            [] => Ok(()),
            _ => Err(self.wrong("bytes are left over")),
        }
    }
}
