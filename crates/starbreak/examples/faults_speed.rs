//! How long each fault of the camera takes for a frame of the built-in street, on one thread: medians of 15, ms; and until
//! it is ready for the first, the median of 3. Taller frames show more of glass that leans, and more of what lies on it. Last,
//! frames of which the upper quarter is white, as skies often are: what is clipped is looked at more closely. Arguments name
//! some of them.
#![expect(clippy::print_stdout, reason = "an example says what it does")]

use std::error::Error;
use std::time::Instant;

use image::DynamicImage;
use image::imageops::{FilterType, resize};
use starbreak::{Chain, FAULTS, Recipe, Seed};
use starbreak_dataset::street_scene;

const N: u64 = 15;

/// That of the command.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "{:14} {:>18} {:>18} {:>18} {:>21}",
        "", "1242 x 375, ready", "1280 x 720, ready", "640 x 480, ready", "1242 x 375, white sky"
    );
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let is_wanted = |preset: &str| wanted.is_empty() || wanted.iter().any(|it| it == preset);
    let street = street_scene().image;
    let presets = FAULTS.iter().flat_map(|fault| fault.presets);
    for (preset, _) in presets.filter(|(preset, _)| is_wanted(preset)) {
        print!("{preset:14}");
        let settings = Recipe::preset(preset)?.settings()?;
        for (width, height, is_white) in [
            (1242, 375, false),
            (1280, 720, false),
            (640, 480, false),
            (1242, 375, true),
        ] {
            let mut ready = Vec::new();
            let mut chain = Chain::of(&settings, (width, height), Seed(1))?;
            for _ in 0..3 {
                let begin = Instant::now();
                chain = Chain::of(&settings, (width, height), Seed(1))?;
                ready.push(begin.elapsed().as_secs_f64() * 1e3);
            }
            ready.sort_by(f64::total_cmp);
            let lit = chain.under(None)?;
            let mut frame = resize(&street, width, height, FilterType::Triangle);
            if is_white {
                let samples: &mut [u8] = &mut frame;
                let n_white = samples.len() / 4;
                samples[..n_white].fill(255);
            }
            let mut times = Vec::new();
            for k in 0..N {
                let mut frame = DynamicImage::ImageRgb8(frame.clone());
                let begin = Instant::now();
                lit.over(&mut frame, Seed(k))?;
                times.push(begin.elapsed().as_secs_f64() * 1e3);
            }
            times.sort_by(f64::total_cmp);
            let median = times.get(times.len() / 2).copied().unwrap_or(0.0);
            let ready = ready.get(1).copied().unwrap_or(0.0);
            match is_white {
                false => print!(" {median:10.1} {ready:7.1}"),
                true => print!(" {median:21.1}"),
            }
        }
        println!();
    }
    Ok(())
}
