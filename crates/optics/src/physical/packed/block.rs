//! 32 whole numbers of a row of pixels in as few bits as they need.
//!
//! A block is two bytes of prediction and widths, five where a width is large, then the bits. What
//! is written of each number is its difference from a prediction, zigzag (0, −1, 1, −2, …), in four
//! groups of eight numbers of one width each.

use wide::{i32x4, u32x4};

use super::bytes::Bytes;
use crate::OpticsError;
use crate::maps::CHUNK;

/// Numbers of one block.
pub(super) type Block = [i32; CHUNK];

/// Numbers that share a width.
pub(super) const GROUP: usize = 8;
pub(super) const N_GROUPS: usize = CHUNK / GROUP;

/// Bits of a difference at most: numbers have [`MAX_BITS`], a gradient of three of them two more,
/// zigzag one.
const MAX_WIDTH: usize = 31;

/// Widths below this are small: four of them and a prediction take two bytes.
const SMALL: usize = 11;

/// What stands for larger ones.
const LARGE: usize = SMALL * SMALL * SMALL * SMALL;

/// Bits of a number with its sign.
pub(super) const MAX_BITS: u32 = 26;

/// Largest number of a block.
pub(super) const MOST: i32 = (1 << (MAX_BITS - 1)) - 1;

/// What a number is predicted from.
#[derive(Debug, Clone, Copy)]
enum From {
    /// Nothing.
    Zero,
    /// The number before it.
    Left,
    /// The number above it.
    Above,
    /// Left + above − above left.
    Gradient,
}

impl From {
    const ALL: [Self; 4] = [Self::Zero, Self::Left, Self::Above, Self::Gradient];

    fn differences(self, block: &Block, above: &Block) -> Block {
        let mut out = [0; CHUNK];
        for k in 0..CHUNK {
            let (left, corner) = if k == 0 {
                (0, 0)
            } else {
                (block[k - 1], above[k - 1])
            };
            out[k] = block[k]
                - match self {
                    Self::Zero => 0,
                    Self::Left => left,
                    Self::Above => above[k],
                    Self::Gradient => left + above[k] - corner,
                };
        }
        out
    }
}

/// Appends a block; `above` is the block of the row above, zeros where there is none.
pub(super) fn write_block(out: &mut Vec<u8>, block: &Block, above: &Block) {
    let coded = From::ALL.map(|from| {
        let zigzag = from.differences(block, above).map(zigzag);
        let widths: [usize; N_GROUPS] = std::array::from_fn(|g| {
            let any = zigzag[g * GROUP..][..GROUP].iter().fold(0, |or, z| or | z);
            (u32::BITS - any.leading_zeros()) as usize
        });
        (zigzag, widths)
    });
    let n_bits = |widths: &[usize; N_GROUPS]| widths.iter().sum::<usize>();
    let mut best = 0;
    for mode in 1..From::ALL.len() {
        if n_bits(&coded[mode].1) < n_bits(&coded[best].1) {
            best = mode;
        }
    }
    let (zigzag, widths) = &coded[best];
    write_head(out, best, *widths);
    for (g, width) in widths.iter().enumerate() {
        // Eight numbers of a width fill whole bytes.
        let (mut held, mut n_held) = (0_u64, 0);
        for value in &zigzag[g * GROUP..][..GROUP] {
            held |= u64::from(*value) << n_held;
            n_held += width;
            while n_held >= 8 {
                #[expect(clippy::cast_possible_truncation, reason = "the lowest byte")]
                out.push(held as u8);
                held >>= 8;
                n_held -= 8;
            }
        }
    }
}

/// Two bytes of prediction and widths where all widths are small, else five.
fn write_head(out: &mut Vec<u8>, mode: usize, widths: [usize; N_GROUPS]) {
    let is_small = widths.iter().all(|width| *width < SMALL);
    let code = if is_small {
        widths.iter().fold(0, |code, width| code * SMALL + width)
    } else {
        LARGE
    };
    #[expect(clippy::cast_possible_truncation, reason = "below 2^16")]
    let head = (code << 2 | mode) as u16;
    out.extend_from_slice(&head.to_le_bytes());
    if !is_small {
        let code = widths.iter().fold(0, |code, width| code << 5 | width);
        #[expect(clippy::cast_possible_truncation, reason = "20 bits")]
        let code = code as u32;
        out.extend_from_slice(&code.to_le_bytes()[..3]);
    }
}

#[inline(always)]
fn read_head(bytes: &mut Bytes<'_>) -> Result<(From, [usize; N_GROUPS]), OpticsError> {
    let head = usize::from(u16::from_le_bytes(bytes.take()?));
    let (from, code) = (From::ALL[head & 3], head >> 2);
    let mut widths = [0; N_GROUPS];
    if code < LARGE {
        let mut rest = code;
        for width in widths.iter_mut().rev() {
            *width = rest % SMALL;
            rest /= SMALL;
        }
    } else if code == LARGE {
        let [a, b, c] = bytes.take()?;
        let mut rest = u32::from_le_bytes([a, b, c, 0]) as usize;
        for width in widths.iter_mut().rev() {
            *width = rest & MAX_WIDTH;
            rest >>= 5;
        }
    } else {
        return Err(bytes.wrong("a block has no such widths"));
    }
    Ok((from, widths))
}

/// The differences of a block as they were written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coded {
    from: From,
    pub(super) zigzag: [u32; CHUNK],
}

impl Coded {
    pub(super) const NOTHING: Self = Self {
        from: From::Zero,
        zigzag: [0; CHUNK],
    };

    /// Whether differences are from the number before, and whether they are from the one above: all
    /// bits, or none.
    #[inline(always)]
    pub(super) fn masks(&self) -> (i32, i32) {
        let only_if = |is_so: bool| -i32::from(is_so);
        (
            only_if(matches!(self.from, From::Left | From::Gradient)),
            only_if(matches!(self.from, From::Above | From::Gradient)),
        )
    }
}

/// Whether numbers are no larger than the largest may be, from the bits that are set in any of
/// their magnitudes.
#[inline(always)]
pub(super) fn are_in_range<const N: usize>(any: [i32; N]) -> bool {
    let any = any.into_iter().fold(0, |any, bits| any | bits);
    any.cast_unsigned() <= MOST.unsigned_abs()
}

/// The steps of reading that are taken for many numbers at once; the numbers are the same whoever
/// takes them.
pub(super) trait Reader: Copy {
    /// Eight numbers of a width of at most [`HALF_WIDTH`], maybe of none, out of the bytes from
    /// `at`: nearly all groups are such, and no branch depends on the width.
    fn unpack_small(self, room: &[u8; ROOM], at: usize, width: usize, group: &mut [u32; GROUP]);

    /// The block itself, in place of the one above it; false where a number is too large.
    fn restore(self, coded: &Coded, block: &mut Block) -> bool;
}

/// Reads on any processor.
#[derive(Debug, Clone, Copy)]
pub(super) struct AnyProcessor;

impl Reader for AnyProcessor {
    #[inline(always)]
    fn unpack_small(self, room: &[u8; ROOM], at: usize, width: usize, group: &mut [u32; GROUP]) {
        #[expect(clippy::cast_possible_truncation, reason = "at most 15 bits")]
        let lowest = |bits: u64| (bits & ((1 << width) - 1)) as u32;
        let window = |at: usize| {
            let bytes = room[at.min(ROOM - size_of::<u64>())..].first_chunk();
            u64::from_le_bytes(bytes.copied().unwrap_or_default())
        };
        // The second half begins amid a byte where the width is odd.
        let mut halves = [window(at), window(at + width / 2) >> (width % 2 * 4)];
        let (low, high) = group.split_at_mut(GROUP / 2);
        for (low, high) in low.iter_mut().zip(high) {
            (*low, *high) = (lowest(halves[0]), lowest(halves[1]));
            halves = halves.map(|half| half >> width);
        }
    }

    #[inline(always)]
    fn restore(self, coded: &Coded, block: &mut Block) -> bool {
        // No branches, as no one can foretell them.
        let (is_summed, is_above) = coded.masks();
        let [is_summed, is_above] = [is_summed, is_above].map(i32x4::splat);
        let mut before = i32x4::ZERO;
        let mut any = i32x4::ZERO;
        let coded = coded.zigzag.as_chunks().0;
        for (values, coded) in block.as_chunks_mut().0.iter_mut().zip(coded) {
            let differences = unzigzag(u32x4::new(*coded));
            let sums = before + running_sums(differences);
            before = i32x4::splat(sums.to_array()[3]) & is_summed;
            let restored =
                is_summed.bitselect(sums, differences) + (i32x4::new(*values) & is_above);
            any |= restored.abs();
            *values = restored.to_array();
        }
        are_in_range(any.to_array())
    }
}

/// Of each number, the sum of those up to it.
#[inline(always)]
fn running_sums(numbers: i32x4) -> i32x4 {
    let [a, b, c, _] = numbers.to_array();
    let pairs = numbers + i32x4::new([0, a, b, c]);
    let [a, b, _, _] = pairs.to_array();
    pairs + i32x4::new([0, 0, a, b])
}

/// Reads what [`write_block`] wrote.
#[inline(always)]
pub(super) fn read_block(
    reader: impl Reader,
    bytes: &mut Bytes<'_>,
    coded: &mut Coded,
) -> Result<(), OpticsError> {
    let (from, widths) = read_head(bytes)?;
    let n_bytes = widths.iter().sum::<usize>();
    let rest = bytes.rest();
    if rest.len() < n_bytes {
        return Err(bytes.wrong("it ends in a block"));
    }
    coded.from = from;
    let groups = coded.zigzag.as_chunks_mut::<GROUP>().0.iter_mut();
    let mut at = 0;
    match rest.first_chunk() {
        Some(room) if widths.iter().all(|width| *width <= HALF_WIDTH) => {
            for (group, width) in groups.zip(widths) {
                reader.unpack_small(room, at, width, group);
                at += width;
            }
        }
        _ => {
            for (group, width) in groups.zip(widths) {
                unpack(&rest[at..], width, group);
                at += width;
            }
        }
    }
    bytes.skip(n_bytes);
    Ok(())
}

/// Up to this width four numbers lie in eight bytes, whatever bit they begin at.
pub(super) const HALF_WIDTH: usize = 15;

/// Bytes that are looked at where all widths are that small.
pub(super) const ROOM: usize = N_GROUPS * HALF_WIDTH + size_of::<u64>();

/// Eight numbers of a width out of the first bytes, as many as that.
#[inline(always)]
fn unpack(data: &[u8], width: usize, group: &mut [u32; GROUP]) {
    #[expect(clippy::cast_possible_truncation, reason = "at most 31 bits")]
    let lowest = |bits: u64| (bits & ((1 << width) - 1)) as u32;
    let mut padded = [0_u8; MAX_WIDTH + 8];
    padded[..width].copy_from_slice(&data[..width]);
    for (k, value) in group.iter_mut().enumerate() {
        let at = k * width;
        let window = padded[at / 8..].first_chunk().copied().unwrap_or_default();
        *value = lowest(u64::from_le_bytes(window) >> (at % 8));
    }
}

#[expect(clippy::cast_sign_loss, reason = "bits")]
fn zigzag(value: i32) -> u32 {
    ((value << 1) ^ (value >> 31)) as u32
}

#[inline(always)]
fn unzigzag(bits: u32x4) -> i32x4 {
    let halves: u32x4 = bits >> 1_u32;
    let odd = bits & u32x4::ONE;
    i32x4::new(halves.to_array().map(u32::cast_signed))
        ^ -i32x4::new(odd.to_array().map(u32::cast_signed))
}
