//! `generate`, `verify` and `merge` as they are typed.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use starbreak_runs::generate::Shard;

use super::overlay::OverlayArgs;

/// `starbreak generate`.
#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// The dataset: kitti:DIR, coco:DIR, bdd:DIR, yolo:DIR, folder:DIR or list:FILE
    #[arg(value_name = "FORMAT:PATH")]
    pub(crate) source: OsString,
    /// Output folder: new, empty, or that of an earlier run of the same command, which is
    /// resumed
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Samples per image, each with its own crack, in trees sample_0, sample_1, …
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) samples: u32,
    /// Take cracks from a bank made by `starbreak patterns`, with the bank's recipe; only
    /// output.…, coats and faults of the camera can then be set
    #[arg(long, value_name = "DIR", conflicts_with_all = ["preset", "recipe", "severity", "camera"])]
    pub(crate) bank: Option<PathBuf>,
    /// Use one crack network (JSON or SVG) for all images instead of a new one for each
    #[arg(long, value_name = "FILE", conflicts_with = "bank")]
    pub(crate) network: Option<PathBuf>,
    /// Use photos of broken glass instead of cracks: for each sample a random part of a random
    /// PNG or JPEG file below a folder, or a part from a bank made by `starbreak patterns
    /// --overlays`
    #[arg(long, value_name = "DIR", conflicts_with_all = ["network", "bank"])]
    pub(crate) overlays: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// Only the first N images
    #[arg(long, value_name = "N", conflicts_with = "sample")]
    pub(crate) limit: Option<u64>,
    /// Only N images, chosen at random by the seed
    #[arg(long, value_name = "N")]
    pub(crate) sample: Option<u64>,
    /// Only the i-th of n shards, e.g. 2/8; `starbreak merge` merges them
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    /// What to do with records that break the format of the dataset: stop before anything is
    /// written, or skip them and list them in starbreak/skipped.jsonl
    #[arg(long, value_enum, default_value_t = OnError::Stop)]
    pub(crate) on_error: OnError,
    /// What to do with files that are neither images nor labels
    #[arg(long, value_enum, default_value_t = OtherFiles::Copy)]
    pub(crate) other_files: OtherFiles,
    /// Stop at the first image that fails
    #[arg(long, conflicts_with = "max_failures")]
    pub(crate) fail_fast: bool,
    /// Stop after more than N images have failed
    #[arg(long, value_name = "N")]
    pub(crate) max_failures: Option<u64>,
    /// Write only DIR.preview.png with 12 of the images, and print what would be done and the
    /// space and time it needs
    #[arg(long)]
    pub(crate) dry_run: bool,
}

/// `starbreak verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Finished folder of `generate` or `merge`
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// Regenerate N images (or `all`) and compare them with the set; needs --source
    #[arg(long, value_name = "N|all", value_parser = parse_how_many, requires = "source")]
    pub(crate) regenerate: Option<HowMany>,
    /// The dataset it was made from, as for generate
    #[arg(long, value_name = "FORMAT:PATH")]
    pub(crate) source: Option<OsString>,
    /// The bank it was made with, if any
    #[arg(long, value_name = "DIR", requires = "regenerate")]
    pub(crate) bank: Option<PathBuf>,
    /// The network it was made with, if any
    #[arg(
        long,
        value_name = "FILE",
        requires = "regenerate",
        conflicts_with = "bank"
    )]
    pub(crate) network: Option<PathBuf>,
    /// The photos of broken glass it was made with, if any, and their flags as for generate
    #[arg(
        long,
        value_name = "DIR",
        requires = "regenerate",
        conflicts_with_all = ["network", "bank"]
    )]
    pub(crate) overlays: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
}

/// `starbreak merge`.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Finished folders of all shards
    #[arg(required = true, value_name = "DIR")]
    pub(crate) parts: Vec<PathBuf>,
    /// Output folder; files are hard-linked from the shards where the file system allows it
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// What to do with bad records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OnError {
    /// Write nothing
    Stop,
    /// Skip them
    Skip,
}

/// What to do with files that are neither images nor labels
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OtherFiles {
    /// Copy them
    Copy,
    /// Hard-link them, which takes no space; copied where the file system has no links
    HardLink,
    /// Leave them out
    Skip,
}

/// A number, or all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HowMany {
    All,
    Only(u64),
}

fn parse_how_many(text: &str) -> Result<HowMany, String> {
    match text {
        "all" => Ok(HowMany::All),
        _ => text
            .parse()
            .map(HowMany::Only)
            .map_err(|_| "expected a number or `all`".to_owned()),
    }
}

pub(crate) fn parse_shard(text: &str) -> Result<Shard, String> {
    let wrong = || "expected I/N with 1 <= I <= N, e.g. 2/8".to_owned();
    let (number, of) = text.split_once('/').ok_or_else(wrong)?;
    let number: u32 = number.trim().parse().map_err(|_| wrong())?;
    let of: u32 = of.trim().parse().map_err(|_| wrong())?;
    if number < 1 || number > of {
        return Err(wrong());
    }
    Ok(Shard { number, of })
}
