//! How often the intervals of the report do not hold the truth, and how often its tests find an effect where there is
//! none: on a made-up population, and on real detections with the roles of clean and cracked exchanged at random.
//!
//! ```sh
//! cargo run --release -p starbreak-eval --example calibration -- SAMPLES
//! cargo run --release -p starbreak-eval --example calibration -- SAMPLES LABELS STUDY
//! ```
//!
//! The first holds samples of a population against its full value. The second takes the detections of a study
//! (`starbreak study -o STUDY`) of the dataset LABELS (`coco:FOLDER`): in each sample the clean and the cracked
//! detections of an image change places or do not, at random, so that there is no effect whatever the detector and
//! the cracks are. Prints a row per number; ends with 1 if a rate is further above 5 % than it may be.
#![expect(clippy::print_stdout, reason = "a program for the terminal")]

#[path = "../tests/population/mod.rs"]
mod population;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

use population::Law;
use population::cells::{Sample, Wrong, sample, truth, wrong};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use starbreak_dataset::SourceSpec;
use starbreak_eval::failure::{ObjectPair, pair_objects};
use starbreak_eval::resampling::Plan;
use starbreak_eval::{
    CoverageOf, Detections, GroundTruth, ImageMatches, LabelSet, MatchRule, RegionMasks, Subset,
    match_images,
};
use statrs::distribution::{ContinuousCDF, Normal};

/// Least coverage of what is in the region.
const TAU: f64 = 0.05;

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let n_samples: u64 = args.first().map_or(Ok(200), |it| it.parse())?;
    let mut table = Table::default();
    match args.get(1).zip(args.get(2)) {
        None => of_population(n_samples, &mut table),
        Some((labels, study)) => of_study(n_samples, labels, Path::new(study), &mut table)?,
    }
    Ok(table.finish())
}

fn of_population(n_samples: u64, table: &mut Table) {
    for (n_images, effects) in [(96, &[0.0, 1.5, 4.0][..]), (300, &[0.0, 1.5])] {
        for effect in effects.iter().copied() {
            for (kind, n_seeds, drive) in [
                ("images", 1, 1),
                ("three seeds", 3, 1),
                ("drives of 4", 1, 4),
            ] {
                let law = Law {
                    effect,
                    n_seeds,
                    drive,
                };
                let truth = truth(law, 400_000);
                let found = wrong(n_samples, &truth, |number| sample(law, n_images, number));
                let about = format!("{n_images} images, effect {effect}, {kind}");
                table.add(&about, effect == 0.0, &found);
            }
        }
    }
}

/// A study's detections: clean, and by condition those behind the cracks, with the region masks.
fn of_study(
    n_samples: u64,
    labels: &str,
    study: &Path,
    table: &mut Table,
) -> Result<(), Box<dyn std::error::Error>> {
    let truth = GroundTruth::of_dataset(&SourceSpec::parse(labels.as_ref())?, None)?;
    for detector in folders(&study.join("detections"))? {
        let folder = study.join("detections").join(&detector);
        let clean = truth
            .read_detections(&folder.join("clean.json"))?
            .detections;
        let mut conditions: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for condition in folders(&study.join("sets"))? {
            let family = condition.split("-seed-").next().unwrap_or(&condition);
            let of_family = conditions.entry(family.to_owned()).or_default();
            of_family.push(condition.clone());
        }
        for (family, seeds) in conditions {
            for (kind, seeds) in [("1 seed", &seeds[..1]), ("all seeds", &seeds[..])] {
                for place in [Subset::InRegion { tau: TAU }, Subset::WholeImage] {
                    for is_clustered in [false, true] {
                        let whole = sides(&truth, &folder, study, &clean, seeds, &place)?;
                        // Of clean and cracked of one law the ratio is 1.
                        let none = |name| (name, if name == "rPC" { 1.0 } else { 0.0 });
                        let zero = whole.said().into_keys().map(none).collect();
                        let plan = plan(&truth.labels, is_clustered);
                        let found =
                            wrong(n_samples, &zero, |number| exchanged(&whole, &plan, number));
                        // Of sides alone and of rates no truth is known, and what is lost over coverage is not
                        // exchangeable.
                        let found = found
                            .into_iter()
                            .filter(|(name, _)| {
                                !name.ends_with(": clean")
                                    && !name.ends_with(": cracked")
                                    && !name.starts_with("slope")
                            })
                            .map(|(name, mut row)| {
                                if name.starts_with("failure rate") {
                                    row.n_intervals = 0;
                                }
                                (name, row)
                            })
                            .collect();
                        let units = if is_clustered {
                            "groups of 3"
                        } else {
                            "images"
                        };
                        let place = match place {
                            Subset::WholeImage => "whole images",
                            _ => "in region",
                        };
                        let about = format!("{detector}, {family}, {kind}, {place}, {units}");
                        table.add(&about, true, &found);
                    }
                }
            }
        }
    }
    Ok(())
}

/// Images, or three of them that follow each other as if they were of one drive.
fn plan(labels: &LabelSet, is_clustered: bool) -> Plan {
    let size = if is_clustered { 3 } else { 1 };
    let names: Vec<String> = (0..labels.images.len())
        .map(|k| (k / size).to_string())
        .collect();
    let names: Vec<Option<&str>> = names.iter().map(|name| Some(name.as_str())).collect();
    Plan::of_clusters(&names).with(400, 0, 0.95)
}

fn folders(path: &Path) -> std::io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(path)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names.sort();
    Ok(names)
}

/// What was found in one place, per seed clean and cracked, with the pairs of the region.
fn sides(
    truth: &GroundTruth,
    folder: &Path,
    study: &Path,
    clean: &Detections,
    seeds: &[String],
    place: &Subset,
) -> Result<Sample, Box<dyn std::error::Error>> {
    let labels = &truth.labels;
    let mut sample = Sample {
        clean: Vec::new(),
        cracked: Vec::new(),
        pairs: Vec::new(),
        n_categories: labels.categories.len(),
        plan: plan(labels, false),
        boxes: None,
    };
    for seed in seeds {
        let cracked = truth
            .read_detections(&folder.join(format!("{seed}.json")))?
            .detections;
        let masks = RegionMasks {
            folder: &study.join("sets").join(seed).join("starbreak/regions"),
            root: truth.root.as_deref(),
        };
        let coverages = masks.coverages(labels, &[clean, &cracked])?;
        let matched =
            |set: usize, detections: &Detections| -> Result<_, starbreak_eval::EvalError> {
                let of = CoverageOf {
                    objects: &coverages.objects,
                    detections: coverages.detections.get(set).map_or(&[], Vec::as_slice),
                };
                let values = place.values(labels, detections, of)?;
                let rule = |region| MatchRule {
                    iou_threshold: 0.5,
                    max_detections: 100,
                    region,
                };
                let here = match_images(labels, detections, &rule(Some(values.restriction())))?;
                Ok((here, match_images(labels, detections, &rule(None))?))
            };
        let (clean_here, clean_all) = matched(0, clean)?;
        let (cracked_here, cracked_all) = matched(1, &cracked)?;
        sample.clean.push(clean_here);
        sample.cracked.push(cracked_here);
        let covered = &coverages.objects;
        sample.pairs.extend(pair_objects(
            &clean_all,
            &cracked_all,
            labels,
            covered,
            0.3,
        )?);
    }
    Ok(sample)
}

/// The same with clean and cracked exchanged in random units, all seeds together.
fn exchanged(whole: &Sample, plan: &Plan, number: u64) -> Sample {
    let mut stream = ChaCha8Rng::seed_from_u64(number);
    let swaps: Vec<bool> = (0..plan.n_units())
        .map(|_| stream.next_u32() & 1 == 1)
        .collect();
    let is_swapped = |image: u32| {
        let unit = plan.unit_of_image().get(image as usize);
        unit.and_then(|unit| swaps.get(*unit as usize)) == Some(&true)
    };
    let mixed = |own: &[Vec<ImageMatches>], other: &[Vec<ImageMatches>]| {
        let sets = own.iter().zip(other);
        let mix = |(own, other): (&Vec<ImageMatches>, &Vec<ImageMatches>)| {
            let kept = own.iter().filter(|item| !is_swapped(item.image));
            let taken = other.iter().filter(|item| is_swapped(item.image));
            kept.chain(taken).cloned().collect()
        };
        sets.map(mix).collect()
    };
    let exchange = |pair: &ObjectPair| match is_swapped(pair.image) {
        true => ObjectPair {
            clean: pair.cracked,
            cracked: pair.clean,
            ..*pair
        },
        false => *pair,
    };
    Sample {
        clean: mixed(&whole.clean, &whole.cracked),
        cracked: mixed(&whole.cracked, &whole.clean),
        pairs: whole.pairs.iter().map(exchange).collect(),
        n_categories: whole.n_categories,
        plan: plan.clone().with(400, number, 0.95),
        boxes: None,
    }
}

/// How often an interval or a test is wrong.
struct Rate {
    about: String,
    n_wrong: u32,
    n: u32,
}

impl Rate {
    fn share(&self) -> f64 {
        f64::from(self.n_wrong) / f64::from(self.n)
    }
}

/// The rows, printed as they come.
#[derive(Default)]
struct Table {
    rows: Vec<Rate>,
    n_disagree: u32,
    n_both: u32,
}

impl Table {
    fn add(&mut self, about: &str, is_null: bool, found: &BTreeMap<&'static str, Wrong>) {
        let mut push = |kind, name, n_wrong, n| {
            let about = format!("{kind} of {about}: {name}");
            self.rows.push(Rate { about, n_wrong, n });
        };
        for (name, row) in found {
            let percent = |k: u32, n: u32| match n {
                0 => "     -".to_owned(),
                n => format!("{:5.1} ", 100.0 * f64::from(k) / f64::from(n)),
            };
            let n_tests = if is_null { row.n_tests } else { 0 };
            println!(
                "{about:62} | {name:30} | beside {}| p < .05 {}| disagree {}| n {}",
                percent(row.n_beside, row.n_intervals),
                percent(row.n_below, n_tests),
                percent(
                    row.n_disagree,
                    if is_null {
                        row.n_tests.min(row.n_intervals)
                    } else {
                        0
                    }
                ),
                row.n_intervals.max(row.n_tests)
            );
            if row.n_intervals > 0 {
                push("interval", name, row.n_beside, row.n_intervals);
            }
            if n_tests > 0 {
                push("test", name, row.n_below, n_tests);
                self.n_disagree += row.n_disagree;
                self.n_both += row.n_tests.min(row.n_intervals);
            }
        }
    }

    /// A rate may be 7 %, or as much as chance makes of 5 % in one row of 20 such tables.
    fn finish(&self) -> ExitCode {
        let z = Normal::standard().inverse_cdf(1.0 - 0.05 / (self.rows.len() as f64).max(1.0));
        let (mut n_off, mut least, mut most) = (0, f64::MAX, 0.0_f64);
        for rate in &self.rows {
            let share = rate.share();
            (least, most) = (least.min(share), most.max(share));
            let reach = (0.02_f64).max(z * (0.05 * 0.95 / f64::from(rate.n)).sqrt());
            if share > 0.05 + reach {
                n_off += 1;
                println!("OFF: {}: {:.1} %", rate.about, 100.0 * share);
            }
        }
        println!(
            "{} rates from {:.1} to {:.1} %, {n_off} too high; interval and test disagree in {:.1} % of {} samples without an effect",
            self.rows.len(),
            100.0 * least,
            100.0 * most,
            100.0 * f64::from(self.n_disagree) / f64::from(self.n_both.max(1)),
            self.n_both
        );
        ExitCode::from(u8::from(n_off > 0))
    }
}
