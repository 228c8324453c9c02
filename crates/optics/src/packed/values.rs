//! The lanes of a baked pattern as whole numbers.
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
use super::runs::{BlockRun, from_steps, steps};
use crate::maps::{CHUNK, LaneRun};
use crate::physical::LEAST_ELSEWHERE;
use crate::surface::{FRAME, FRAME_U, FRAME_V, LANES, N_SHARES, SUN};

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
pub(super) const TINT: usize = 3;

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

/// The light of a run, in place of zeros.
pub(super) fn light_pixels(of: &BlockRun<'_, LANES>, run: &mut LaneRun<LANES>) {
    let BlockRun {
        at: (x, y),
        blocks,
        present,
    } = *of;
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

pub(super) fn tint_blocks(_: (usize, usize), run: &LaneRun<4>) -> [Block; TINT] {
    std::array::from_fn(|c| run[c + 1].map(|color| steps(color, SHARE_STEPS)))
}

/// The tint of a run.
pub(super) fn tint_pixels(of: &BlockRun<'_, TINT>, run: &mut LaneRun<4>) {
    for (lane, block) in run[1..].iter_mut().zip(of.blocks) {
        *lane = block.map(|steps| from_steps(steps, SHARE_STEPS));
    }
}
