//! A baked pattern as bytes.
//!
//! Shares of light are whole numbers of 2⁻¹⁴, the sun's radiance per irradiance has ten bits of
//! fraction, the place that a mirror shows is in 1/256 px from the pixel itself. In linear light
//! of at most 1, with the darkest step of an 8-bit code being 3.0·10⁻⁴ of it, the five shares are
//! off by at most half a code of black together, the sun by 0.06 codes of white, and the place by
//! half a code of the steepest edge that an image can have, times its share.

use super::block::Block;
use super::bytes::{Bytes, write_count};
use super::runs::{from_steps, read_runs, steps, write_runs};
use super::{MAX_PIXELS, MAX_SIDE_PX};
use crate::OpticsError;
use crate::maps::{CHUNK, Chunks};
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

/// Steps of a place in a pixel.
const PLACE_STEPS: f32 = 256.0;

/// Bits of a single that the sun's lane does without, of 23.
const SUN_CUT: u32 = 13;

/// The least of the sun's lane that is kept, 2⁻²⁴: no sun makes it visible.
const SUN_LEAST: u32 = (127 - 24) << 23;

/// Lanes of the tint that are kept: red, green and blue.
const TINT: usize = 3;

impl Pattern {
    /// The pattern as bytes, a twentieth or so of its size in memory.
    ///
    /// A picture made from [`Pattern::from_packed`] of them differs from one made from this
    /// pattern by at most one code of 8 bits, in few pixels; so for pictures that are to be equal,
    /// all are made from the packed form. Packing what was unpacked gives the same bytes.
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
        let mask = self.coverage();
        write_mask(&mut out, &mask);
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
        let mask = read_chunks::<1, 1>(&mut bytes, (width, height), mask_pixels)?;
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

fn sun_steps(value: f32) -> i32 {
    if value.is_nan() || value < f32::from_bits(SUN_LEAST) {
        return 0;
    }
    let rounded = (value.to_bits() + (1 << (SUN_CUT - 1))) >> SUN_CUT;
    #[expect(clippy::cast_possible_wrap, reason = "19 bits")]
    let steps = (rounded - (SUN_LEAST >> SUN_CUT)) as i32 + 1;
    steps
}

fn sun_from_steps(steps: i32) -> f32 {
    let Some(steps) = u32::try_from(steps).ok().and_then(|s| s.checked_sub(1)) else {
        return 0.0;
    };
    let value =
        f32::from_bits((steps.min(0x3ffff) + (SUN_LEAST >> SUN_CUT)).min(0x3fbff) << SUN_CUT);
    value
}

/// Middle of a pixel, px.
#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
fn middle(at: usize) -> f32 {
    at as f32 + 0.5
}

fn light_blocks((x, y): (usize, usize), run: &[[f32; LANES]; CHUNK]) -> [Block; LANES] {
    let mut blocks = [[0; CHUNK]; LANES];
    for (k, lanes) in run.iter().enumerate() {
        for lane in 0..N_SHARES {
            blocks[lane][k] = steps(lanes[lane], SHARE_STEPS);
        }
        blocks[SUN][k] = sun_steps(lanes[SUN]);
        let has_place = from_steps(blocks[FRAME][k], SHARE_STEPS) > LEAST_ELSEWHERE;
        for (lane, own) in [(FRAME_U, middle(x + k)), (FRAME_V, middle(y))] {
            blocks[lane][k] = if has_place {
                steps(lanes[lane] / lanes[FRAME] - own, PLACE_STEPS)
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

fn light_pixels((x, y): (usize, usize), blocks: &[Block; LANES], run: &mut [[f32; LANES]; CHUNK]) {
    for (k, lanes) in run.iter_mut().enumerate() {
        for lane in 0..N_SHARES {
            lanes[lane] = from_steps(blocks[lane][k], SHARE_STEPS);
        }
        lanes[SUN] = sun_from_steps(blocks[SUN][k]);
        if lanes[FRAME] > LEAST_ELSEWHERE {
            for (lane, own) in [(FRAME_U, middle(x + k)), (FRAME_V, middle(y))] {
                lanes[lane] = (own + from_steps(blocks[lane][k], PLACE_STEPS)) * lanes[FRAME];
            }
        }
    }
}

fn tint_blocks(_: (usize, usize), run: &[[f32; 4]; CHUNK]) -> [Block; TINT] {
    std::array::from_fn(|c| std::array::from_fn(|k| steps(run[k][c + 1], SHARE_STEPS)))
}

fn tint_pixels(_: (usize, usize), blocks: &[Block; TINT], run: &mut [[f32; 4]; CHUNK]) {
    for (k, lanes) in run.iter_mut().enumerate() {
        for c in 0..TINT {
            lanes[c + 1] = from_steps(blocks[c][k], SHARE_STEPS);
        }
    }
}

fn mask_pixels(_: (usize, usize), blocks: &[Block; 1], run: &mut [[f32; 1]; CHUNK]) {
    for (lanes, code) in run.iter_mut().zip(&blocks[0]) {
        lanes[0] = from_steps(*code, 1.0);
    }
}

/// Writes the runs that have anything in them.
fn write_chunks<const L: usize, const B: usize>(
    out: &mut Vec<u8>,
    chunks: &Chunks<L>,
    blocks: impl Fn((usize, usize), &[[f32; L]; CHUNK]) -> [Block; B],
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
            runs.push(((across * CHUNK, y), [block]));
        }
    }
    write_runs(out, width, &runs);
}

/// Reads what [`write_chunks`] wrote.
fn read_chunks<const B: usize, const L: usize>(
    bytes: &mut Bytes<'_>,
    size: (usize, usize),
    pixels: impl Fn((usize, usize), &[Block; B], &mut [[f32; L]; CHUNK]),
) -> Result<Chunks<L>, OpticsError> {
    let mut chunks = Chunks::empty(size.0, size.1);
    read_runs(bytes, size, |at, blocks| {
        pixels(at, blocks, chunks.run_at_mut(at));
    })?;
    Ok(chunks)
}
