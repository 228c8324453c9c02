//! Runs of pixels that have something in them: where they are, and a block for each of their lanes.

use super::block::{Block, Coded, MOST, Reader, read_block, write_block};
use super::bytes::{Bytes, write_count};
use crate::OpticsError;
use crate::maps::CHUNK;

/// A number as steps.
#[expect(clippy::cast_possible_truncation, reason = "clamped")]
pub(super) fn steps(value: f32, per_one: f32) -> i32 {
    #[expect(clippy::cast_precision_loss, reason = "25 bits, for a clamp")]
    let most = MOST as f32 * 0.5;
    (value * per_one).round().clamp(-most, most) as i32
}

/// Steps as a number.
#[expect(clippy::cast_precision_loss, reason = "clamped when written")]
pub(super) fn from_steps(steps: i32, per_one: f32) -> f32 {
    steps as f32 / per_one
}

/// Appends runs, each with the place of its first pixel, in the order of rows.
pub(super) fn write_runs<const B: usize>(
    out: &mut Vec<u8>,
    width: usize,
    runs: &[((usize, usize), [Block; B])],
) {
    let n_across = width.div_ceil(CHUNK);
    let present: Vec<_> = runs
        .iter()
        .map(|(at, blocks)| (at, blocks, mask_of(blocks)))
        .filter(|(_, _, mask)| *mask != 0)
        .collect();
    write_count(out, present.len());
    let mut above = Above::<B>::new(n_across);
    let mut next = 0;
    for ((x, y), blocks, mask) in present {
        let across = x / CHUNK;
        let place = y * n_across + across;
        write_count(out, place - next);
        next = place + 1;
        write_count(out, mask);
        for (lane, block) in blocks.iter().enumerate() {
            if mask >> lane & 1 == 1 {
                write_block(out, block, above.get(across, *y, lane));
            }
        }
        above.set(across, *y, blocks);
    }
}

fn mask_of<const B: usize>(blocks: &[Block; B]) -> usize {
    let mut mask = 0;
    for (lane, block) in blocks.iter().enumerate() {
        if block.iter().any(|value| *value != 0) {
            mask |= 1 << lane;
        }
    }
    mask
}

/// Bytes of a run at least: its place, its lanes, and one block without a difference.
const MIN_RUN: usize = 4;

/// Reads what [`write_runs`] wrote, run by run.
pub(super) struct RunReader<'a, const B: usize> {
    bytes: Bytes<'a>,
    n_across: usize,
    n_places: usize,
    /// Place of the run that comes next, if there is one.
    place: Option<usize>,
    /// Runs from that one on.
    n_left: usize,
    above: Above<B>,
    coded: [Coded; B],
}

/// A run as it was read.
pub(super) struct BlockRun<'a, const B: usize> {
    /// Its first pixel and row.
    pub(super) at: (usize, usize),
    pub(super) blocks: &'a [Block; B],
    /// A bit for each lane that is not all zeros.
    pub(super) present: usize,
}

impl<'a, const B: usize> RunReader<'a, B> {
    pub(super) fn new(
        mut bytes: Bytes<'a>,
        (width, height): (usize, usize),
    ) -> Result<Self, OpticsError> {
        let n_across = width.div_ceil(CHUNK);
        let n_places = n_across * height;
        let n_left = bytes.count(n_places)?;
        if n_left > bytes.rest().len() / MIN_RUN {
            return Err(bytes.wrong("it has more runs than bytes"));
        }
        let mut reader = Self {
            bytes,
            n_across,
            n_places,
            place: None,
            n_left,
            above: Above::new(n_across),
            coded: [Coded::NOTHING; B],
        };
        reader.find_next(0)?;
        Ok(reader)
    }

    /// Number of runs that have not been read yet, for which there are enough bytes.
    pub(super) fn n_left(&self) -> usize {
        self.n_left
    }

    /// First pixel and row of the run that comes next.
    pub(super) fn at(&self) -> Option<(usize, usize)> {
        let place = self.place?;
        Some((place % self.n_across * CHUNK, place / self.n_across))
    }

    /// The run that comes next; after the last one there is nothing more in the bytes.
    #[inline(always)]
    pub(super) fn next(
        &mut self,
        reader: impl Reader,
    ) -> Result<Option<BlockRun<'_, B>>, OpticsError> {
        let (Some(place), Some(at)) = (self.place, self.at()) else {
            return self.bytes.end().map(|()| None);
        };
        let present = self.bytes.count((1 << B) - 1)?;
        if present == 0 {
            return Err(self.bytes.wrong("a run has no lanes"));
        }
        // All lanes before any is restored: bits that have just been taken apart one by one would
        // have to be waited for.
        for (lane, coded) in self.coded.iter_mut().enumerate() {
            if present >> lane & 1 == 1 {
                read_block(reader, &mut self.bytes, coded)?;
            }
        }
        self.n_left -= 1;
        self.find_next(place + 1)?;
        // Read over the blocks above, which are not wanted any more.
        let (blocks, are_above) = self.above.take(at.0 / CHUNK, at.1);
        for (lane, (block, coded)) in blocks.iter_mut().zip(&self.coded).enumerate() {
            let is_present = present >> lane & 1 == 1;
            if !(is_present && are_above) {
                *block = ZEROS;
            }
            if is_present && !reader.restore(coded, block) {
                return Err(self.bytes.wrong("a number is too large"));
            }
        }
        Ok(Some(BlockRun {
            at,
            blocks,
            present,
        }))
    }

    /// Finds the place of the next run, which is `first` at least.
    #[inline(always)]
    fn find_next(&mut self, first: usize) -> Result<(), OpticsError> {
        self.place = None;
        if self.n_left > 0 {
            let place = first + self.bytes.count(self.n_places)?;
            if place >= self.n_places {
                return Err(self.bytes.wrong("a run lies beyond its frame"));
            }
            self.place = Some(place);
        }
        Ok(())
    }
}

/// The latest blocks of each column of runs.
struct Above<const B: usize> {
    rows: Vec<usize>,
    blocks: Vec<[Block; B]>,
}

static ZEROS: Block = [0; CHUNK];

impl<const B: usize> Above<B> {
    fn new(n_across: usize) -> Self {
        Self {
            rows: vec![usize::MAX; n_across],
            blocks: vec![[[0; CHUNK]; B]; n_across],
        }
    }

    /// Whether the latest blocks of a column are of the row above `y`.
    fn are_above(&self, across: usize, y: usize) -> bool {
        self.rows[across].wrapping_add(1) == y && y > 0
    }

    /// The latest blocks of a column, which are to become those of row `y`, and whether they are
    /// of the row above it.
    #[inline(always)]
    fn take(&mut self, across: usize, y: usize) -> (&mut [Block; B], bool) {
        let are_above = self.are_above(across, y);
        self.rows[across] = y;
        (&mut self.blocks[across], are_above)
    }

    /// The block in the row above `y`, zeros where there is none.
    fn get(&self, across: usize, y: usize, lane: usize) -> &Block {
        if self.are_above(across, y) {
            &self.blocks[across][lane]
        } else {
            &ZEROS
        }
    }

    fn set(&mut self, across: usize, y: usize, blocks: &[Block; B]) {
        self.rows[across] = y;
        self.blocks[across] = *blocks;
    }
}
