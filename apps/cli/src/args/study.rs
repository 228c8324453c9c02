//! `study` as it is typed.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::evaluate::ProtocolWord;
use super::generate::OnError;

/// `starbreak study`.
#[derive(Debug, Args)]
pub(crate) struct StudyArgs {
    /// The dataset with its labels: kitti:DIR, coco:DIR, bdd:DIR or yolo:DIR
    #[arg(value_name = "FORMAT:PATH")]
    pub(crate) source: OsString,
    /// Output folder: empty, new, or that of an earlier run of the same study, which goes on; models,
    /// presets, severities and seeds may be added to it
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// A detector as an ONNX file; repeatable
    #[arg(short, long, required = true, value_name = "FILE")]
    pub(crate) model: Vec<PathBuf>,
    /// What the detector of the same place takes and gives: a preset or a TOML file, or `auto` to
    /// find it out from its inputs and outputs; repeatable
    #[arg(long, value_name = "PRESET|FILE")]
    pub(crate) contract: Vec<String>,
    /// Presets to break the glass with, as families of cracks
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', conflicts_with_all = ["preset", "recipe"])]
    pub(crate) presets: Vec<String>,
    /// Recipes to break the glass with, as families of cracks; severities do not scale them
    #[arg(long, value_name = "FILE,…", value_delimiter = ',', conflicts_with_all = ["preset", "recipe"])]
    pub(crate) recipes: Vec<PathBuf>,
    /// Severities to scale each preset to
    #[arg(long, value_name = "N,…", value_delimiter = ',', conflicts_with = "severity",
        value_parser = clap::value_parser!(u8).range(1..=5))]
    pub(crate) severities: Vec<u8>,
    /// Seeds to draw the cracks with, each for all images
    #[arg(
        long,
        value_name = "N,…",
        value_delimiter = ',',
        conflicts_with = "seed"
    )]
    pub(crate) seeds: Vec<u64>,
    /// Only the first N images
    #[arg(long, value_name = "N")]
    pub(crate) limit: Option<u64>,
    /// Which class of a model is which category of the dataset, as for detect
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) label_map: Option<PathBuf>,
    /// Which images are of one clip, drive or scene, as for evaluate
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) clusters: Option<PathBuf>,
    /// By which rules; those of the dataset unless given
    #[arg(long, value_enum)]
    pub(crate) protocol: Option<ProtocolWord>,
    /// Draws of the bootstrap and of the permutation test, 20 to 1000000
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(20..=1_000_000))]
    pub(crate) replicates: u32,
    /// Score from which a detection counts as found, in rates of failure
    #[arg(long, value_name = "0..1", default_value_t = 0.3, value_parser = parse_share)]
    pub(crate) score_threshold: f64,
    /// Worst failures that the report shows of each detector and condition, 0 to 100; 6, or fewer so
    /// that all conditions together show 24, unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=100))]
    pub(crate) worst: Option<u32>,
    /// Whether the sets of images are compared, too: KL, JS and W1 of five features of their pixels
    #[arg(long, value_enum, default_value_t = DivergenceWord::On)]
    pub(crate) divergence: DivergenceWord,
    /// What to do about records of images that break the dataset's format: stop before anything is
    /// written, or leave these images out; labels must be good either way
    #[arg(long, value_enum, default_value_t = OnError::Stop)]
    pub(crate) on_error: OnError,
}

/// Whether sets of images are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DivergenceWord {
    /// They are
    On,
    /// They are not
    Off,
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share = text
        .parse()
        .ok()
        .filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}
