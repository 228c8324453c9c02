//! Flags of `starbreak evaluate`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};
use starbreak_eval::Protocol;

/// Flags of `starbreak evaluate`.
#[derive(Debug, ClapArgs)]
pub(crate) struct EvaluateArgs {
    /// Labeled dataset: kitti:DIR, coco:DIR, bdd:DIR or yolo:DIR
    #[arg(value_name = "SOURCE", required_unless_present = "ground_truth")]
    pub(crate) source: Option<OsString>,
    /// Labels alone instead: instances_*.json of MS-COCO, a folder label_2 of KITTI, or frames
    /// of BDD100K, as --protocol says [default: coco]
    #[arg(long, value_name = "FILE|DIR", conflicts_with = "source")]
    pub(crate) ground_truth: Option<PathBuf>,
    /// Detections in the clean images: MS-COCO results (JSON), Scalabel frames (JSON), or a
    /// folder of KITTI results
    #[arg(long, value_name = "PATH")]
    pub(crate) clean: PathBuf,
    /// Detections in the damaged images
    #[arg(long, alias = "cracked", value_name = "PATH")]
    pub(crate) damaged: Option<PathBuf>,
    /// Folder of region masks as written by `generate`: OUT/starbreak/regions
    #[arg(long, value_name = "DIR")]
    pub(crate) regions: Option<PathBuf>,
    /// The damaged set written by `generate`: gives region masks, damage of each object,
    /// recipe, and pictures of the worst failures
    #[arg(long, alias = "cracked-set", value_name = "OUT")]
    pub(crate) damaged_set: Option<PathBuf>,
    /// Name of the detector in the report [default: that of the file of clean detections]
    #[arg(long, value_name = "NAME")]
    pub(crate) detector: Option<String>,
    /// Name of the condition in the report [default: cracked]
    #[arg(long, value_name = "NAME")]
    pub(crate) condition: Option<String>,
    /// Replicates of the bootstrap and of the permutation test, 20 to 1000000
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(20..=1_000_000))]
    pub(crate) replicates: u32,
    /// Minimum score of a detection that counts as found, in failure rates
    #[arg(long, value_name = "0..1", default_value_t = 0.3)]
    pub(crate) score_threshold: f64,
    /// Number of worst failures shown in the report, 0 to 100
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(0..=100))]
    pub(crate) worst: u32,
    /// Minimum share of a box that the region must cover for the box to be inside, 0 to 1, 0
    /// for touching [default: 0.05, with 0 and 0.2 beside it]
    #[arg(long, value_name = "X,…", value_delimiter = ',')]
    pub(crate) tau: Vec<f64>,
    /// Groups of dependent images (clips, drives, scenes), which intervals and tests draw as
    /// one: a CSV file of lines image,cluster, or the folder `mapping` of KITTI's development
    /// kit
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) clusters: Option<PathBuf>,
    /// Evaluation protocol [default: that of the dataset]
    #[arg(long, value_enum)]
    pub(crate) protocol: Option<ProtocolWord>,
    /// IoU thresholds, 0 to 1 [default: 0.5 to 0.95 in ten steps]
    #[arg(long, value_name = "X,…", value_delimiter = ',')]
    pub(crate) iou_thresholds: Vec<f64>,
    /// Maximum detections per category and image, ascending [default: 1,10,100]
    #[arg(long, value_name = "N,…", value_delimiter = ',')]
    pub(crate) max_dets: Vec<u32>,
    /// Area range, px², instead of all, small, medium and large; repeatable
    #[arg(long, value_name = "NAME=MIN,MAX", value_parser = parse_range)]
    pub(crate) area_range: Vec<(String, [f64; 2])>,
    /// Match detections with objects of any category
    #[arg(long)]
    pub(crate) class_agnostic: bool,
    /// Count a detection that matches the object with id 0 as a false positive, as pycocotools
    /// does
    #[arg(long)]
    pub(crate) gt_id_zero_quirk: bool,
    /// Folder for the curves: precision, recall and scores as NumPy arrays of 64-bit floats
    /// [threshold, recall, category, area, number of detections]
    #[arg(long, value_name = "DIR")]
    pub(crate) curves: Option<PathBuf>,
    /// Output folder for report.html, evaluation.json, numbers.csv, table.tex and
    /// failures.jsonl, with intervals and tests
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
}

/// A protocol, as typed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProtocolWord {
    /// MS-COCO: mean over IoU thresholds from 0.5 to 0.95, 101 recalls
    Coco,
    /// KITTI 2-D object detection: 11 and 40 recalls, three difficulties
    Kitti,
    /// BDD100K: as MS-COCO, with boxes that include their last pixels
    Bdd,
}

impl From<ProtocolWord> for Protocol {
    fn from(word: ProtocolWord) -> Self {
        match word {
            ProtocolWord::Coco => Self::Coco,
            ProtocolWord::Kitti => Self::Kitti,
            ProtocolWord::Bdd => Self::Bdd,
        }
    }
}

fn parse_range(text: &str) -> Result<(String, [f64; 2]), String> {
    let parsed = text.split_once('=').and_then(|(name, ends)| {
        let (least, most) = ends.split_once(',')?;
        Some((name.to_owned(), [least.parse().ok()?, most.parse().ok()?]))
    });
    parsed.ok_or_else(|| format!("{text:?} is no range; expected NAME=MIN,MAX"))
}
