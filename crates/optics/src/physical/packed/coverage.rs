//! Drawn cracks as bytes.
//!
//! Coverage is in the codes of its mask, 1/255, the weight in 1/256: in an 8-bit image, under light
//! as bright as white, each is off by half a code at most, and less where it is blurred.

use super::block::{AnyProcessor, Block};
use super::bytes::{Bytes, write_count};
use super::runs::{BlockRun, RunReader, from_steps, steps, write_runs};
use super::{MAX_PIXELS, MAX_SIDE_PX};
use crate::maps::CHUNK;
use crate::{Coverage, OpticsError};

/// First byte; another one is another version.
const VERSION: u8 = 1;

/// What errors call it.
const WHAT: &str = "coverage";

/// Steps of coverage in 1: the codes of a mask.
const COVER_STEPS: f32 = 255.0;

const FULL: i32 = 255;

/// Steps of the weight in 1.
const WEIGHT_STEPS: f32 = 256.0;

/// Blocks of a run: coverage and weight.
const COVERED: usize = 0;
const WEIGHT: usize = 1;

impl Coverage {
    /// The drawing as bytes.
    ///
    /// A picture made from [`Coverage::from_packed`] of them differs from one made from this
    /// drawing by at most one code of 8 bits, in few pixels; so for pictures that are to be equal,
    /// all are made from the packed form. Packing what was unpacked gives the same bytes.
    #[must_use]
    pub fn to_packed(&self) -> Vec<u8> {
        let (width, height) = self.size();
        let mut out = vec![VERSION];
        write_count(&mut out, width);
        write_count(&mut out, height);
        let mut runs: Vec<((usize, usize), [Block; 2])> = Vec::new();
        for y in 0..height {
            for (x, covered, weight) in self.row(y) {
                let at = (x / CHUNK * CHUNK, y);
                let k = x % CHUNK;
                let weight = steps(weight, WEIGHT_STEPS);
                if runs.last().is_none_or(|(last, _)| *last != at) {
                    runs.push((at, [[0; CHUNK]; 2]));
                }
                if let Some((_, blocks)) = runs.last_mut() {
                    blocks[COVERED][k] = steps(covered, COVER_STEPS).max(1);
                    // Not read where nothing is covered; as its neighbor it takes no bits.
                    blocks[WEIGHT][k..].fill(weight);
                }
            }
        }
        write_runs(&mut out, width, &runs);
        out
    }

    /// The drawing in the bytes of [`Coverage::to_packed`].
    ///
    /// # Errors
    /// [`OpticsError::Packed`] naming the byte at which they are wrong.
    ///
    /// # Limits
    /// In memory it is as large as the least rectangle with all that is drawn, 8 bytes per pixel,
    /// whose frame has 2²⁷ pixels at most.
    pub fn from_packed(bytes: &[u8]) -> Result<Self, OpticsError> {
        let mut bytes = Bytes::new(WHAT, bytes);
        if bytes.byte()? != VERSION {
            return Err(bytes.wrong("it is of another version"));
        }
        let width = bytes.count(MAX_SIDE_PX)?;
        let height = bytes.count(MAX_SIDE_PX)?;
        if width * height > MAX_PIXELS {
            return Err(bytes.wrong("its frame is too large"));
        }
        let mut reader = RunReader::<2>::new(bytes, (width, height))?;
        let mut runs = Vec::with_capacity(reader.n_left());
        while let Some(BlockRun { at, blocks, .. }) = reader.next(AnyProcessor)? {
            let pixels: [(f32, f32); CHUNK] = std::array::from_fn(|k| {
                let covered = blocks[COVERED][k].clamp(0, FULL);
                let weight = from_steps(blocks[WEIGHT][k], WEIGHT_STEPS);
                let weight = if covered > 0 { weight } else { 0.0 };
                (from_steps(covered, COVER_STEPS), weight)
            });
            runs.push((at.0, at.1, pixels));
        }
        Ok(Self::of_runs((width, height), &runs))
    }
}
