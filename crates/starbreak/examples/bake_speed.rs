//! How long it takes to bake presets' cracks before their cameras, on one thread, ms: the median over 13 breaks of the least of 5.
//! Arguments name presets.
#![expect(clippy::print_stdout, reason = "an example says what it does")]

use std::error::Error;
use std::time::Instant;

use starbreak::{PaneLayer, Recipe, Seed, simulate};

const BREAKS: u64 = 13;

/// That of the command.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Result<(), Box<dyn Error>> {
    println!("{:24} {:>12} {:>12}", "", "1242 x 375", "1920 x 1080");
    for preset in std::env::args().skip(1) {
        print!("{preset:24}");
        for size in [(1242, 375), (1920, 1080)] {
            let settings = Recipe::preset(&preset)?.settings()?;
            let mut times = Vec::new();
            for k in 0..BREAKS {
                let seed = Seed(k);
                let network = simulate(&settings, size, seed)?.network;
                let mut least = f64::INFINITY;
                for _ in 0..5 {
                    let begin = Instant::now();
                    PaneLayer::of_network(&settings, (&network, f64::INFINITY), size, seed)?;
                    least = least.min(begin.elapsed().as_secs_f64() * 1e3);
                }
                times.push(least);
            }
            times.sort_by(f64::total_cmp);
            print!(
                " {:12.2}",
                times.get(times.len() / 2).copied().unwrap_or(0.0)
            );
        }
        println!();
    }
    Ok(())
}
