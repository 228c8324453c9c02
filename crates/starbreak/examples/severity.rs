//! How much of the frame each preset takes at each severity.
//!
//! `cargo run --release -p starbreak --example severity [SEEDS] [PRESET ...]` writes a table: of the
//! embedded street, for every preset and severity, the share of the frame in the region of the
//! cracks, over the seeds from 1 to SEEDS (32).

#![expect(clippy::print_stdout, reason = "a report is what this is for")]

use std::error::Error;

use image::DynamicImage;
use image::imageops::FilterType;
use rayon::prelude::*;
use starbreak::{Chain, PRESETS, Recipe, Seed, Stopwatch};
use starbreak_dataset::street_scene;

/// Severities of a preset.
pub(crate) const SEVERITIES: [u8; 5] = [1, 2, 3, 4, 5];

/// Shares of the frame at severities 1 to 5, of one seed.
pub(crate) type Shares = [f64; 5];

/// The shares of a preset over seeds from 1 on, in a street of this width, px, with
/// some keys set.
pub(crate) fn shares_of(
    preset: &str,
    n_seeds: u64,
    (width_px, set): (u32, &[&str]),
) -> Result<Vec<Shares>, String> {
    let scene = DynamicImage::ImageRgb8(street_scene().image);
    let scene = scene.resize(width_px, u32::MAX, FilterType::Triangle);
    (1..=n_seeds)
        .into_par_iter()
        .map(|seed| {
            let mut shares = [0.0; 5];
            for (share, severity) in shares.iter_mut().zip(SEVERITIES) {
                *share =
                    share_of((preset, severity, set), &scene, Seed(seed)).map_err(|error| {
                        format!("{preset}, severity {severity}, seed {seed}: {error}")
                    })?;
            }
            Ok(shares)
        })
        .collect()
}

fn share_of(
    (preset, severity, set): (&str, u8, &[&str]),
    scene: &DynamicImage,
    seed: Seed,
) -> Result<f64, Box<dyn Error>> {
    let mut recipe = Recipe::preset_at(preset, severity)?;
    for assignment in set {
        recipe.set(assignment)?;
    }
    let chain = Chain::of(&recipe.settings()?, (scene.width(), scene.height()), seed)?;
    let mut watch = Stopwatch::start();
    let shown = chain.over_and_report(&mut scene.clone(), seed, &[], &mut watch)?;
    let region = &shown.region;
    let n_hit = region.iter().filter(|code| **code > 0).count();
    #[expect(clippy::cast_precision_loss, reason = "counts of pixels")]
    Ok(n_hit as f64 / region.len() as f64)
}

/// The middle of some numbers.
pub(crate) fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    let n = of.len();
    0.5 * (of[(n - 1) / 2] + of[n / 2])
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let n_seeds = args.next().map_or(Ok(32), |text| text.parse())?;
    let asked: Vec<String> = args.collect();
    println!("| preset | 1 | 2 | 3 | 4 | 5 | least step | least at 1 | seeds that fall |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for (preset, _) in PRESETS {
        if !asked.is_empty() && !asked.iter().any(|name| name == preset) {
            continue;
        }
        let shares = shares_of(preset, n_seeds, (1242, &[]))?;
        let at = |k: usize| shares.iter().map(|of| of[k]).collect::<Vec<f64>>();
        let medians: Vec<f64> = (0..5).map(|k| median(at(k))).collect();
        let step = medians
            .windows(2)
            .filter(|pair| pair[0] < 0.6)
            .map(|pair| pair[1] / pair[0])
            .fold(f64::INFINITY, f64::min);
        let least = at(0).into_iter().fold(f64::INFINITY, f64::min);
        let falls = shares
            .iter()
            .filter(|of| of.windows(2).any(|pair| pair[1] < pair[0]))
            .count();
        let each: Vec<String> = medians
            .iter()
            .map(|share| format!("{:.2} %", 100.0 * share))
            .collect();
        println!(
            "| `{preset}` | {} | {step:.2} | {:.3} % | {falls} |",
            each.join(" | "),
            100.0 * least
        );
    }
    Ok(())
}
