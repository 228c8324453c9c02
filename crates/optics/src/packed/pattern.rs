//! A baked pattern as bytes.
//!
//! Shares of light are whole numbers of 2⁻¹⁴; the sun's radiance per irradiance is, too, of 2⁻¹⁶
//! up to 2⁻⁸, and has eight bits of fraction beyond; the place that a mirror shows is in 1/128 px
//! from the pixel itself. In linear light of at most 1, with the darkest step of an 8-bit code
//! being 3.0·10⁻⁴ of it, the five shares are off by at most half a code of black together; a sun
//! of irradiance 8 by a fifth of a code; and the place by one code of the steepest edge that an
//! image can have, times its share.
//!
//! # Limits
//! Where the renderer chooses by a threshold (the width over which a mirror's picture is averaged)
//! a pixel just at it may be shown the other way; see the bank's test of rendered pictures.

use super::block::Block;
use super::bytes::{Bytes, write_count};
use super::runs::{from_steps, n_runs, read_runs, steps, write_runs};
use super::{MAX_PIXELS, MAX_SIDE_PX};
use crate::OpticsError;
use crate::maps::{CHUNK, LaneRun, LaneRuns};
use crate::physical::{LEAST_ELSEWHERE, Outline, Pattern, PatternLayer};
use crate::surface::{FRAME, FRAME_U, FRAME_V, LANES, N_SHARES, SUN};

/// First byte; another one is another version.
const VERSION: u8 = 1;

/// What errors call it.
const WHAT: &str = "pattern";

/// Layers that a pattern may have.
const MAX_LAYERS: usize = 16;

/// Steps of a share of light in 1.
const SHARE_STEPS: f32 = 16_384.0;

/// Fewest steps of a share of the frame that the renderer takes from elsewhere: 5·10⁻⁴ is 8.2.
const FIRST_ELSEWHERE: i32 = 9;

/// Steps of a place in a pixel.
const PLACE_STEPS: f32 = 128.0;

/// Steps of the sun's lane in 1 where it is small, and up to how many it is.
const SUN_STEPS: f32 = 65_536.0;
const SUN_SMALL: i32 = 256;

/// Steps of a place at most: 8192 px, far beyond any frame, of which the border then counts.
const FARTHEST: i32 = 1 << 20;

/// Bits of a single that the sun's lane does without beyond that, of 23.
const SUN_CUT: u32 = 15;

/// Those that are left, of the least that is not small.
const SUN_FIRST: u32 = (127 - 8) << (23 - SUN_CUT);

/// Most steps of the sun's lane: 2³¹, which is white under any sun.
const SUN_MOST: u32 = 39 << (23 - SUN_CUT);

/// Lanes of the tint that are kept: red, green and blue.
const TINT: usize = 3;

impl Pattern {
    /// The pattern as bytes, a twentieth or so of its size in memory.
    ///
    /// A picture made from [`Pattern::from_packed`] of them differs from one made from this
    /// pattern by at most one code of 8 bits, in few pixels; so for pictures that are to be equal,
    /// all are made from the packed form. Packing what was unpacked gives the same bytes, in frames of up
    /// to 8192 px per side.
    #[must_use]
    pub fn to_packed(&self) -> Vec<u8> {
        let (width, height) = self.size();
        let mut out = vec![VERSION];
        write_count(&mut out, width as usize);
        write_count(&mut out, height as usize);
        out.extend_from_slice(&self.f_px().to_le_bytes());
        write_count(&mut out, self.layers().len());
        for layer in self.layers() {
            out.extend_from_slice(&layer.blur_px.to_le_bytes());
            write_chunks(&mut out, &layer.light, light_blocks);
            write_chunks(&mut out, &layer.tint, tint_blocks);
        }
        match self.outline() {
            Outline::Corners(_) => write_mask(&mut out, &self.coverage()),
            Outline::Codes(codes) => write_chunks(&mut out, codes, |_, run| {
                [run[0].map(|code| steps(code, 1.0))]
            }),
        }
        out
    }

    /// The pattern in the bytes of [`Pattern::to_packed`].
    ///
    /// # Errors
    /// [`OpticsError::Packed`] naming the byte at which they are wrong.
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
        let f_px = f64::from_le_bytes(bytes.take()?);
        if !(f_px.is_finite() && f_px > 0.0) {
            return Err(bytes.wrong("its focal length is no length"));
        }
        let n_layers = bytes.count(MAX_LAYERS)?;
        let mut layers = Vec::with_capacity(n_layers);
        for _ in 0..n_layers {
            let blur_px = f32::from_le_bytes(bytes.take()?);
            if !blur_px.is_finite() {
                return Err(bytes.wrong("its blur is not finite"));
            }
            layers.push(PatternLayer {
                blur_px,
                light: read_chunks::<LANES, LANES>(&mut bytes, (width, height), light_pixels)?,
                tint: read_chunks::<TINT, 4>(&mut bytes, (width, height), tint_pixels)?,
            });
        }
        let mask = read_chunks::<1, 1>(
            &mut bytes,
            (width, height),
            |(x, _), ([codes], _), [run]| {
                for ((lane, code), _) in run.iter_mut().zip(codes).zip(x..width) {
                    *lane = from_steps((*code).clamp(0, 255), 1.0);
                }
            },
        )?;
        bytes.end()?;
        Ok(Self::from_parts(
            (side(width), side(height)),
            f_px,
            layers,
            Outline::Codes(mask),
        ))
    }
}

#[expect(clippy::cast_possible_truncation, reason = "at most MAX_SIDE_PX")]
fn side(px: usize) -> u32 {
    px as u32
}

/// The sun's lane as steps; less than nothing is nothing, as for the one who reads it.
fn sun_steps(value: f32) -> i32 {
    let small = steps(value.max(0.0), SUN_STEPS);
    if small < SUN_SMALL {
        return small;
    }
    let kept = (value.to_bits() + (1 << (SUN_CUT - 1))) >> SUN_CUT;
    let beyond = kept.saturating_sub(SUN_FIRST).min(SUN_MOST);
    SUN_SMALL + i32::try_from(beyond).unwrap_or(0)
}

fn sun_from_steps(steps: i32) -> f32 {
    let beyond = (steps - SUN_SMALL).clamp(0, SUN_MOST.cast_signed());
    let large = f32::from_bits((beyond.cast_unsigned() + SUN_FIRST) << SUN_CUT);
    let small = from_steps(steps.max(0), SUN_STEPS);
    if steps < SUN_SMALL { small } else { large }
}

/// Middle of a pixel, px.
#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
fn middle(at: usize) -> f32 {
    at as f32 + 0.5
}

fn light_blocks((x, y): (usize, usize), run: &LaneRun<LANES>) -> [Block; LANES] {
    let mut blocks = [[0; CHUNK]; LANES];
    for k in 0..CHUNK {
        let lanes = run.map(|lane| lane[k]);
        for lane in 0..N_SHARES {
            blocks[lane][k] = steps(lanes[lane], SHARE_STEPS);
        }
        if lanes[FRAME] > LEAST_ELSEWHERE {
            // Stays on that side, on which the renderer looks elsewhere.
            blocks[FRAME][k] = blocks[FRAME][k].max(FIRST_ELSEWHERE);
        }
        blocks[SUN][k] = sun_steps(lanes[SUN]);
        let has_place = from_steps(blocks[FRAME][k], SHARE_STEPS) > LEAST_ELSEWHERE;
        for (lane, own) in [(FRAME_U, middle(x + k)), (FRAME_V, middle(y))] {
            blocks[lane][k] = if has_place {
                steps(lanes[lane] / lanes[FRAME] - own, PLACE_STEPS).clamp(-FARTHEST, FARTHEST)
            } else if k > 0 {
                // Not read; as its neighbor it takes no bits.
                blocks[lane][k - 1]
            } else {
                0
            };
        }
    }
    blocks
}

/// Of the runs of zeros those lanes that have a bit in `present`.
fn light_pixels(
    (x, y): (usize, usize),
    (blocks, present): (&[Block; LANES], u8),
    run: &mut LaneRun<LANES>,
) {
    let is_present = |lane: usize| present >> lane & 1 == 1;
    for lane in (0..N_SHARES).filter(|lane| is_present(*lane)) {
        run[lane] = blocks[lane].map(|steps| from_steps(steps, SHARE_STEPS));
    }
    if is_present(SUN) {
        run[SUN] = blocks[SUN].map(sun_from_steps);
    }
    if !is_present(FRAME) {
        return;
    }
    let shares = run[FRAME];
    for (k, share) in shares.into_iter().enumerate() {
        if share > LEAST_ELSEWHERE {
            for (lane, own) in [(FRAME_U, middle(x + k)), (FRAME_V, middle(y))] {
                let steps = blocks[lane][k].clamp(-FARTHEST, FARTHEST);
                run[lane][k] = (own + from_steps(steps, PLACE_STEPS)) * share;
            }
        }
    }
}

fn tint_blocks(_: (usize, usize), run: &LaneRun<4>) -> [Block; TINT] {
    std::array::from_fn(|c| run[c + 1].map(|color| steps(color, SHARE_STEPS)))
}

fn tint_pixels(_: (usize, usize), (blocks, _): (&[Block; TINT], u8), run: &mut LaneRun<4>) {
    for (lane, block) in run[1..].iter_mut().zip(blocks) {
        *lane = block.map(|steps| from_steps(steps, SHARE_STEPS));
    }
}

/// Writes the runs that have anything in them.
fn write_chunks<const L: usize, const B: usize>(
    out: &mut Vec<u8>,
    chunks: &LaneRuns<L>,
    blocks: impl Fn((usize, usize), &LaneRun<L>) -> [Block; B],
) {
    let runs = chunks
        .iter()
        .map(|(x, y, run)| ((x, y), blocks((x, y), run)))
        .collect::<Vec<_>>();
    write_runs(out, chunks.size().0, &runs);
}

/// Writes the codes of a mask in the same way.
fn write_mask(out: &mut Vec<u8>, mask: &image::GrayImage) {
    let (width, height) = (mask.width() as usize, mask.height() as usize);
    let mut runs = Vec::new();
    for (y, row) in mask.as_raw().chunks(width.max(1)).enumerate().take(height) {
        for (across, codes) in row.chunks(CHUNK).enumerate() {
            let mut block = [0; CHUNK];
            for (to, code) in block.iter_mut().zip(codes) {
                *to = i32::from(*code);
            }
            if block.iter().any(|code| *code > 0) {
                runs.push(((across * CHUNK, y), [block]));
            }
        }
    }
    write_runs(out, width, &runs);
}

/// Reads what [`write_chunks`] wrote.
fn read_chunks<const B: usize, const L: usize>(
    bytes: &mut Bytes<'_>,
    size: (usize, usize),
    pixels: impl Fn((usize, usize), (&[Block; B], u8), &mut LaneRun<L>),
) -> Result<LaneRuns<L>, OpticsError> {
    let n_runs = n_runs(bytes, size)?;
    let mut chunks = LaneRuns::with_room(size.0, size.1, n_runs);
    read_runs(bytes, size, n_runs, |at, blocks, present| {
        pixels(at, (blocks, present), chunks.push(at));
    })?;
    Ok(chunks)
}
