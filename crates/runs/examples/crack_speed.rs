//! One pattern of a bank over one image, again and again: the call that the Python package wraps.
//!
//! `crack_speed BANK WIDTH HEIGHT RGB N`: RGB is a file of raw pixels. Prints the median time of a call,
//! which copies the image and breaks the copy, in ms.
#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::path::Path;
use std::time::Instant;

use image::{DynamicImage, RgbImage};
use starbreak::Seed;
use starbreak::Stopwatch;
use starbreak_runs::bank::PatternBank;

/// That of the command.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [bank, width, height, rgb, n] = args.as_slice() else {
        return Err("expected BANK WIDTH HEIGHT RGB N".into());
    };
    let size = (width.parse()?, height.parse()?);
    let pixels = RgbImage::from_raw(size.0, size.1, std::fs::read(rgb)?);
    let image = DynamicImage::ImageRgb8(pixels.ok_or("RGB is too short")?);
    let bank = PatternBank::open(Path::new(bank))?;
    let pattern = bank.pattern(0, size, &mut Stopwatch::start())?;
    let mut times_ms = Vec::new();
    for _ in 0..n.parse::<usize>()? {
        let started = Instant::now();
        let mut cracked = image.clone();
        pattern.chain.over(&mut cracked, Seed(1))?;
        times_ms.push(started.elapsed().as_secs_f64() * 1e3);
    }
    times_ms.sort_by(f64::total_cmp);
    let median_ms = times_ms.get(times_ms.len() / 2);
    println!("{}", median_ms.ok_or("no call")?);
    Ok(())
}
