//! `detect` as it is typed.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::runtime::RuntimeArgs;
use super::video::FfmpegArgs;

/// `starbreak detect`.
#[derive(Debug, Args)]
pub(crate) struct DetectArgs {
    /// The dataset: kitti:DIR, coco:DIR, bdd:DIR, yolo:DIR, folder:DIR or list:FILE; or a clip:
    /// clip:FILE, or clip:DIR with PNG or JPEG frames in the order of their names
    #[arg(value_name = "FORMAT:PATH", required_unless_present = "list_contracts")]
    pub(crate) source: Option<OsString>,
    /// The detector, an ONNX file
    #[arg(
        short,
        long,
        value_name = "FILE.onnx",
        required_unless_present = "list_contracts"
    )]
    pub(crate) model: Option<PathBuf>,
    /// Output file or folder of the detections
    #[arg(
        short,
        long,
        value_name = "OUT",
        required_unless_present = "list_contracts"
    )]
    pub(crate) output: Option<PathBuf>,
    /// Contract of the model, what it takes and returns: a preset or a TOML file [default: the
    /// preset that fits its inputs and outputs]
    #[arg(long, value_name = "PRESET|FILE")]
    pub(crate) contract: Option<String>,
    /// List the presets of --contract instead
    #[arg(long, exclusive = true)]
    pub(crate) list_contracts: bool,
    /// Drop detections with a lower score [default: the contract's threshold]
    #[arg(long, value_name = "0..1", value_parser = parse_score)]
    pub(crate) score_threshold: Option<f32>,
    /// Format of the detections: MS-COCO results, KITTI (OUT/data/NNNNNN.txt) or BDD100K
    #[arg(long, value_enum, default_value_t = ResultFormat::Coco)]
    pub(crate) format: ResultFormat,
    /// Map classes of the model to categories of the dataset: a TOML file with schema = 1 and
    /// [map] "class" = "category"; all others by equal names
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) label_map: Option<PathBuf>,
    /// Only the first N images
    #[arg(long, value_name = "N")]
    pub(crate) limit: Option<usize>,
    #[command(flatten)]
    pub(crate) runtime: RuntimeArgs,
    /// Write the clip with the boxes of scores from 0.3 on, too (clip:FILE only)
    #[arg(long, value_name = "FILE")]
    pub(crate) video: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reader: FfmpegArgs,
}

/// Form of detections.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ResultFormat {
    /// Results of MS-COCO: one JSON list
    Coco,
    /// Results of KITTI: a folder with one text per image
    Kitti,
    /// Frames of Scalabel, as BDD100K has them: one JSON list
    Bdd,
}

fn parse_score(text: &str) -> Result<f32, String> {
    let score: f32 = text
        .parse()
        .map_err(|_| "expected a number from 0 to 1".to_owned())?;
    if (0.0..=1.0).contains(&score) {
        Ok(score)
    } else {
        Err("expected a number from 0 to 1".to_owned())
    }
}
