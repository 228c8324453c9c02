//! The lanes of a baked pattern as whole numbers.
//!
//! Shares of light are whole numbers of 2⁻¹⁴; the sun's radiance per irradiance is, too, of 2⁻¹⁶
//! up to 2⁻⁸, and has eight bits of fraction beyond; the place that a mirror shows is in 1/128 px
//! from the pixel itself; the width over which it is averaged is in 1/32 px up to 8 px, beyond
//! which the renderer asks for its power of two alone; a tint is in 2⁻¹¹. In linear light of at
//! most 1, with the darkest step of an 8-bit code being 3.0·10⁻⁴ of it, the seven shares are off by
//! at most two thirds of a code of black together; a sun of irradiance 8 by a fifth of a code; the place by
//! one code of the steepest edge that an image can have, times its share; the width by half a code
//! of such an edge; a tint by a fifteenth of a code of the light that it tints.

use wide::{f32x8, i32x8};

use super::block::Block;
use super::runs::{BlockRun, from_steps, steps};
use crate::maps::{CHUNK, LaneRun};
use crate::physical::{FINE_WIDTHS, LEAST_ELSEWHERE, exponent_up};
use crate::surface::{FRAME, FRAME_U, FRAME_V, LANES, N_SHARES, SUN, WIDTH};

/// Steps of a share of light in 1.
const SHARE_STEPS: f32 = 16_384.0;

/// The same, as a number of them.
const ALL_SHARES: i32 = 16_384;

/// Steps of a width in a pixel, and how many there are up to the one from which the coarse scene is
/// all that is shown.
const WIDTH_STEPS: f32 = 32.0;
const WIDTH_FINE: i32 = 256;

/// Exponent of that width as the bits of a single have it.
const WIDTH_FIRST: i32 = 127 + 3;

/// Steps of a tint in 1.
const TINT_STEPS: f32 = 2_048.0;

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

#[inline(always)]
fn sun_from_steps(steps: i32) -> f32 {
    let beyond = (steps - SUN_SMALL).clamp(0, SUN_MOST.cast_signed());
    let large = f32::from_bits((beyond.cast_unsigned() + SUN_FIRST) << SUN_CUT);
    let small = from_steps(steps.max(0), SUN_STEPS);
    if steps < SUN_SMALL { small } else { large }
}

/// A width as steps: none where it is too little to be one, and beyond [`WIDTH_FINE`] the
/// logarithm of the next power of two.
fn width_steps(width: f32) -> i32 {
    if width <= FINE_WIDTHS[1] {
        let fine = steps(width, WIDTH_STEPS);
        let is_any = from_steps(fine, WIDTH_STEPS) > FINE_WIDTHS[0];
        return if is_any { fine } else { 0 };
    }
    #[expect(clippy::cast_possible_wrap, reason = "an exponent")]
    let exponent = exponent_up(width) as i32;
    WIDTH_FINE + exponent - WIDTH_FIRST
}

#[inline(always)]
fn width_from_steps(steps: i32) -> f32 {
    let beyond = (steps - WIDTH_FINE).clamp(0, 64) + WIDTH_FIRST;
    let large = f32::from_bits(beyond.cast_unsigned() << (f32::MANTISSA_DIGITS - 1));
    let small = from_steps(steps.max(0), WIDTH_STEPS);
    if steps <= WIDTH_FINE { small } else { large }
}

/// Middle of a pixel, px.
#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
fn middle(at: usize) -> f32 {
    at as f32 + 0.5
}

pub(super) fn light_blocks((x, y): (usize, usize), run: &LaneRun<LANES>) -> [Block; LANES] {
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
        // No more than all, rounded or not: the greatest gives way.
        let sum: i32 = blocks[..N_SHARES].iter().map(|block| block[k]).sum();
        let greatest = (0..N_SHARES).max_by_key(|lane| blocks[*lane][k]);
        blocks[greatest.unwrap_or(0)][k] -= (sum - ALL_SHARES).max(0);
        blocks[SUN][k] = sun_steps(lanes[SUN]);
        let has_place = from_steps(blocks[FRAME][k], SHARE_STEPS) > LEAST_ELSEWHERE;
        for (lane, own) in [(FRAME_U, middle(x + k)), (FRAME_V, middle(y))] {
            blocks[lane][k] = if has_place {
                steps(lanes[lane] - own, PLACE_STEPS).clamp(-FARTHEST, FARTHEST)
            } else if k > 0 {
                // Not read; as its neighbor it takes no bits.
                blocks[lane][k - 1]
            } else {
                0
            };
        }
        blocks[WIDTH][k] = if has_place {
            width_steps(lanes[WIDTH])
        } else {
            0
        };
    }
    blocks
}

/// The light of a run. Shares and light of the sun that are not present stay as they are, and so do
/// place and width where the frame has no share.
#[inline(always)]
pub(super) fn light_pixels(of: &BlockRun<'_, LANES>, run: &mut LaneRun<LANES>) {
    let BlockRun {
        at: (x, y),
        blocks,
        present,
    } = *of;
    let is_present = |lane: usize| present >> lane & 1 == 1;
    for lane in 0..N_SHARES {
        if is_present(lane) {
            all_from_steps(&mut run[lane], &blocks[lane], SHARE_STEPS);
        }
    }
    if is_present(SUN) {
        for (value, steps) in run[SUN].iter_mut().zip(&blocks[SUN]) {
            *value = sun_from_steps(*steps);
        }
    }
    if !is_present(FRAME) {
        // Not read.
        return;
    }
    for (lane, first, step) in [(FRAME_U, middle(x), 1.0), (FRAME_V, middle(y), 0.0)] {
        for (k, (value, steps)) in run[lane].iter_mut().zip(&blocks[lane]).enumerate() {
            #[expect(clippy::cast_precision_loss, reason = "px of a run")]
            let own = first + step * k as f32;
            *value = own + from_steps(*steps, PLACE_STEPS);
        }
    }
    for (value, steps) in run[WIDTH].iter_mut().zip(&blocks[WIDTH]) {
        *value = width_from_steps(*steps);
    }
}

/// [`from_steps`] of a lane, eight at a time; of a power of two, whose inverse is exact.
#[inline(always)]
fn all_from_steps(values: &mut [f32; CHUNK], block: &Block, per_one: f32) {
    let values = values.as_chunks_mut().0;
    for (values, steps) in values.iter_mut().zip(block.as_chunks().0) {
        *values = (f32x8::from_i32x8(i32x8::new(*steps)) * (1.0 / per_one)).to_array();
    }
}

pub(super) fn tint_blocks(_: (usize, usize), run: &LaneRun<3>) -> [Block; 3] {
    run.map(|lane| lane.map(|color| steps(color, TINT_STEPS)))
}

/// The tint of a run.
#[inline(always)]
pub(super) fn tint_pixels(of: &BlockRun<'_, 3>, run: &mut LaneRun<3>) {
    for (lane, block) in run.iter_mut().zip(of.blocks) {
        all_from_steps(lane, block, TINT_STEPS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_width_keeps_what_the_renderer_asks_of_it() {
        // Which level of coarser scenes it takes: twice the width, in cells of 16 px.
        let level = |width: f32| (2.0 * width / 16.0).max(1.0).log2().ceil();
        for k in 0..4000_u16 {
            let width = 1.5 * 1.003_f32.powi(i32::from(k));
            let steps = width_steps(width);
            let read = width_from_steps(steps);
            assert_eq!(width_steps(read), steps, "{width}: packed twice");
            if width <= FINE_WIDTHS[0] + 0.5 / WIDTH_STEPS {
                assert_eq!(
                    steps, 0,
                    "{width}: the pixel itself, but for a fraction of a step"
                );
            } else if width <= FINE_WIDTHS[1] {
                assert!((read - width).abs() <= 0.5 / WIDTH_STEPS, "{width}: {read}");
            } else {
                assert!(read >= FINE_WIDTHS[1], "{width}: {read} is not coarse");
            }
            if width < 1e6 {
                assert!((level(read) - level(width)).abs() < 0.5, "{width}: {read}");
            }
        }
        assert_eq!(width_steps(0.0), 0, "none");
    }

    #[test]
    fn shares_that_are_rounded_up_come_to_no_more_than_all() {
        let mut run = [[0.0; CHUNK]; LANES];
        for lane in run.iter_mut().take(N_SHARES - 1) {
            *lane = [3276.5 / SHARE_STEPS; CHUNK];
        }
        run[N_SHARES - 1] = [3278.0 / SHARE_STEPS; CHUNK];
        let blocks = light_blocks((0, 0), &run);
        let sum: i32 = blocks[..N_SHARES].iter().map(|block| block[0]).sum();
        assert_eq!(sum, ALL_SHARES, "all that there is");
    }
}
