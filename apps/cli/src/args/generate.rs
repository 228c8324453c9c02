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
    /// Output folder: empty, new, or that of an earlier run of the same command, which goes on
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Samples of each image, each with a crack of its own, in trees sample_0, sample_1, …
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) samples: u32,
    /// A bank that `starbreak patterns` has made: each image gets one of its cracks, and its
    /// recipe; of the recipe only output.… can be set then
    #[arg(long, value_name = "DIR", conflicts_with_all = ["preset", "recipe", "severity", "camera"])]
    pub(crate) bank: Option<PathBuf>,
    /// One crack network (JSON or SVG) for all images instead of a new one for each
    #[arg(long, value_name = "FILE", conflicts_with = "bank")]
    pub(crate) network: Option<PathBuf>,
    /// Photos of broken glass instead of cracks: for each sample a random part of a random one of
    /// the PNG and JPEG files below a folder, or a part out of a bank that `starbreak patterns
    /// --overlays` has made
    #[arg(long, value_name = "DIR", conflicts_with_all = ["network", "bank"])]
    pub(crate) overlays: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// Only the first N images
    #[arg(long, value_name = "N", conflicts_with = "sample")]
    pub(crate) limit: Option<u64>,
    /// Only N images, drawn at random by the seed
    #[arg(long, value_name = "N")]
    pub(crate) sample: Option<u64>,
    /// Only the i-th of n shards, e.g. 2/8; `starbreak merge` joins them
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub(crate) shard: Option<Shard>,
    /// What to do about records of the dataset that break its format: stop before anything is
    /// written, or leave them out and list them in starbreak/skipped.jsonl
    #[arg(long, value_enum, default_value_t = OnError::Stop)]
    pub(crate) on_error: OnError,
    /// What becomes of files that are neither images nor labels
    #[arg(long, value_enum, default_value_t = OtherFiles::Copy)]
    pub(crate) other_files: OtherFiles,
    /// Stop at the first image that cannot be made
    #[arg(long, conflicts_with = "max_failures")]
    pub(crate) fail_fast: bool,
    /// Stop once more than N images could not be made
    #[arg(long, value_name = "N")]
    pub(crate) max_failures: Option<u64>,
    /// Write nothing but DIR.preview.png with 12 of the images; say what would be done, and the
    /// space and time it needs
    #[arg(long)]
    pub(crate) dry_run: bool,
}

/// `starbreak verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// A folder that `generate` or `merge` has finished
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// Make N images of it again (or `all`), and compare them with the set; needs --source
    #[arg(long, value_name = "N|all", value_parser = parse_how_many, requires = "source")]
    pub(crate) regenerate: Option<HowMany>,
    /// The dataset that it was made from, as for generate
    #[arg(long, value_name = "FORMAT:PATH")]
    pub(crate) source: Option<OsString>,
    /// The bank that it was made with, if it was
    #[arg(long, value_name = "DIR", requires = "regenerate")]
    pub(crate) bank: Option<PathBuf>,
    /// The network that it was made with, if it was
    #[arg(
        long,
        value_name = "FILE",
        requires = "regenerate",
        conflicts_with = "bank"
    )]
    pub(crate) network: Option<PathBuf>,
    /// The photos of broken glass that it was made with, if it was, and their flags as for generate
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
    /// The finished folders of all shards
    #[arg(required = true, value_name = "DIR")]
    pub(crate) parts: Vec<PathBuf>,
    /// Output folder; files become further names of those of the shards where the disk allows it
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

/// What to do about bad records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OnError {
    /// Write nothing
    Stop,
    /// Leave them out
    Skip,
}

/// What becomes of files that are neither images nor labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OtherFiles {
    /// They are copied
    Copy,
    /// They get a second name, which takes no space; copied where the disk gives none
    HardLink,
    /// They are left out
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

fn parse_shard(text: &str) -> Result<Shard, String> {
    let wrong = || "expected I/N with 1 <= I <= N, e.g. 2/8".to_owned();
    let (number, of) = text.split_once('/').ok_or_else(wrong)?;
    let number: u32 = number.trim().parse().map_err(|_| wrong())?;
    let of: u32 = of.trim().parse().map_err(|_| wrong())?;
    if number < 1 || number > of {
        return Err(wrong());
    }
    Ok(Shard { number, of })
}
