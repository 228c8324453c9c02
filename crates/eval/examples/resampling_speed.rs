//! Time of 1000 bootstrap replicates and 1000 permutations of AP per category, clean and cracked,
//! on a set of the size of MS-COCO's validation set: 5000 images, 80 categories, 36 000 objects,
//! 500 000 detections each.
//!
//! `cargo run --release -p starbreak-eval --example resampling_speed`; wall-clock seconds and those
//! of all threads together (from `/proc/self/stat`, where there is one).
#![expect(clippy::print_stdout, reason = "a program for the terminal")]

use std::time::Instant;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use starbreak_eval::resampling::{Plan, bootstrap, paired_average_precision, rank_by_category};
use starbreak_eval::{ImageMatches, MatchedDetection, MatchedObject, Outcome};

const N_IMAGES: u32 = 5000;
const N_CATEGORIES: u32 = 80;
const N_OBJECTS: u32 = 36_000;
const N_DETECTIONS: u32 = 500_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let clean = matches(1, 0.7);
    let cracked = matches(2, 0.5);
    let plan = Plan::of_images(N_IMAGES);
    let (wall, cpu) = (Instant::now(), cpu_s());
    let (a, b) = (
        rank_by_category(&clean, N_CATEGORIES as usize),
        rank_by_category(&cracked, N_CATEGORIES as usize),
    );
    report("sort once", wall, cpu);
    let (wall, cpu) = (Instant::now(), cpu_s());
    let replicates = bootstrap(&plan, |weights| {
        a.iter()
            .zip(&b)
            .flat_map(|(a, b)| {
                let pair = a
                    .average_precision(weights)
                    .zip(b.average_precision(weights));
                [
                    pair.map(|it| it.0),
                    pair.map(|it| it.1),
                    pair.map(|it| it.1 - it.0),
                ]
            })
            .collect()
    })?;
    report("1000 bootstrap replicates", wall, cpu);
    println!(
        "values of the first category: {:?}",
        replicates.whole.get(..3)
    );
    let (wall, cpu) = (Instant::now(), cpu_s());
    let paired = paired_average_precision(&[&clean], &[&cracked], N_CATEGORIES as usize, &plan)?;
    report(
        "all of paired_average_precision, with 1000 permutations",
        wall,
        cpu,
    );
    println!("mean difference: {:?}", paired.mean.difference);
    Ok(())
}

fn report(what: &str, wall: Instant, cpu: Option<f64>) {
    let wall = wall.elapsed().as_secs_f64();
    match cpu.zip(cpu_s()) {
        Some((before, after)) => println!("{what}: {wall:.2} s, CPU {:.2} s", after - before),
        None => println!("{what}: {wall:.2} s"),
    }
}

/// Seconds of all threads so far.
fn cpu_s() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let rest = stat.rsplit_once(')')?.1;
    let fields: Vec<&str> = rest.split_whitespace().collect();
    let ticks = |place: usize| fields.get(place)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// Matches as a detector gives them: each object found with a chance, the rest of the detections
/// false, with lower scores.
fn matches(seed: u64, found: f64) -> Vec<ImageMatches> {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    let n_cells = (N_IMAGES * N_CATEGORIES) as usize;
    let mut cells: Vec<(Vec<MatchedDetection>, Vec<MatchedObject>)> =
        vec![Default::default(); n_cells];
    let mut places = ChaCha8Rng::seed_from_u64(0);
    let mut n_detections = 0;
    for object in 0..N_OBJECTS {
        let cell = &mut cells[places.next_u32() as usize % n_cells];
        let is_found = unit(&mut stream) < found;
        if is_found {
            cell.0.push(MatchedDetection {
                detection: n_detections,
                score: unit(&mut stream).sqrt(),
                outcome: Outcome::TruePositive { object, iou: 0.8 },
            });
        }
        cell.1.push(MatchedObject {
            object,
            is_ignored: false,
            detection: is_found.then_some(n_detections),
        });
        n_detections += u32::from(is_found);
    }
    for detection in n_detections..N_DETECTIONS {
        let cell = &mut cells[stream.next_u32() as usize % n_cells];
        cell.0.push(MatchedDetection {
            detection,
            score: unit(&mut stream).powi(4),
            outcome: Outcome::FalsePositive,
        });
    }
    cells
        .into_iter()
        .zip(0..)
        .filter(|(cell, _)| !cell.0.is_empty() || !cell.1.is_empty())
        .map(|((mut detections, objects), cell)| {
            detections.sort_by(|a, b| b.score.total_cmp(&a.score));
            ImageMatches {
                image: cell / N_CATEGORIES,
                category: cell % N_CATEGORIES,
                detections,
                objects,
            }
        })
        .collect()
}

fn unit(stream: &mut ChaCha8Rng) -> f64 {
    f64::from(stream.next_u32()) / 4_294_967_296.0
}
