//! Runs of pixels that have something in them: where they are, and a block for each of their lanes.

use super::block::{Block, Coded, MOST, read_block, write_block};
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
        out.push(mask);
        for (lane, block) in blocks.iter().enumerate() {
            if mask >> lane & 1 == 1 {
                write_block(out, block, above.get(across, *y, lane));
            }
        }
        above.set(across, *y, blocks);
    }
}

fn mask_of<const B: usize>(blocks: &[Block; B]) -> u8 {
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

/// Reads the number of runs, for which there are enough bytes.
pub(super) fn n_runs(
    bytes: &mut Bytes<'_>,
    (width, height): (usize, usize),
) -> Result<usize, OpticsError> {
    let n_runs = bytes.count(width.div_ceil(CHUNK) * height)?;
    if n_runs > bytes.rest().len() / MIN_RUN {
        return Err(bytes.wrong("it has more runs than bytes"));
    }
    Ok(n_runs)
}

/// Reads the runs that [`write_runs`] wrote behind their number, each given to `each` with a bit for
/// each lane that is not all zeros.
pub(super) fn read_runs<const B: usize>(
    bytes: &mut Bytes<'_>,
    size: (usize, usize),
    n_runs: usize,
    mut each: impl FnMut((usize, usize), &[Block; B], u8),
) -> Result<(), OpticsError> {
    let n_across = size.0.div_ceil(CHUNK);
    let n_places = n_across * size.1;
    let mut above = Above::<B>::new(n_across);
    let mut coded = [Coded::NOTHING; B];
    let mut next = 0;
    for _ in 0..n_runs {
        let place = next + bytes.count(n_places)?;
        if place >= n_places {
            return Err(bytes.wrong("a run lies beyond its frame"));
        }
        next = place + 1;
        let (across, y) = (place % n_across, place / n_across);
        let mask = bytes.byte()?;
        if mask == 0 || usize::from(mask) >> B != 0 {
            return Err(bytes.wrong("a run has no lanes or unknown ones"));
        }
        // Read over the blocks above, which are not wanted any more.
        let (blocks, are_above) = above.take(across, y);
        // All lanes before any is restored: bits that have just been taken apart one by one would
        // have to be waited for.
        for (lane, coded) in coded.iter_mut().enumerate() {
            if mask >> lane & 1 == 1 {
                read_block(bytes, coded)?;
            }
        }
        for (lane, (block, coded)) in blocks.iter_mut().zip(&coded).enumerate() {
            let is_present = mask >> lane & 1 == 1;
            if !(is_present && are_above) {
                *block = ZEROS;
            }
            if is_present && !coded.restore(block) {
                return Err(bytes.wrong("a number is too large"));
            }
        }
        each((across * CHUNK, y), blocks, mask);
    }
    Ok(())
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
