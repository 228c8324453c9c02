//! Raw frames of a noisy sensor behind an even light, for programs that measure sensors: 16-bit numbers, little-endian,
//! frame after frame, on the standard output.
//!
//! `raw_frames LEVEL SEED N`: light of LEVEL, 1 at the full well, in N frames of 640 x 480 px. See `validation/emva.py`.

use std::error::Error;
use std::io::Write as _;

use starbreak_seed::Seed;
use starbreak_sensor::{Light, Noise, Sensor};

/// What is measured.
const NOISE: Noise = Noise {
    white_e: 10_000.0,
    read_e: 12.0,
    row_e: 0.0,
    prnu: 0.012,
    dsnu_e: 6.0,
    dark_e_s: 400.0,
    doubling_k: 7.0,
    temperature_c: 39.0,
    exposure_s: 0.02,
};
/// Digital numbers per electron, and that of no light.
const GAIN: f32 = 0.5;
const BLACK: f32 = 200.0;
const SIZE: (usize, usize) = (640, 480);

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [level, seed, n] = args.as_slice() else {
        return Err("raw_frames LEVEL SEED N".into());
    };
    let (level, seed, n): (f32, u64, u64) = (level.parse()?, seed.parse()?, n.parse()?);
    let sensor = Sensor::of(NOISE);
    let mut out = std::io::stdout().lock();
    for k in 0..n {
        let mut light = Light::new(SIZE, 1, vec![level; SIZE.0 * SIZE.1])?;
        sensor.over(&mut light, Seed(seed + k).into());
        let mut bytes = Vec::new();
        for value in light.values() {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a digital number"
            )]
            let number = (value * 10_000.0 * GAIN + BLACK + 0.5).clamp(0.0, 65_535.0) as u16;
            bytes.extend(number.to_le_bytes());
        }
        out.write_all(&bytes)?;
    }
    Ok(())
}
