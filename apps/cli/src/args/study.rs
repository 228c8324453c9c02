//! `study` as it is typed.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use starbreak::{FAULTS, PRESETS, SCENARIOS};
use starbreak_runs::generate::Shard;

use super::evaluate::ProtocolWord;
use super::generate::{OnError, parse_shard};
use super::overlay::OverlayArgs;
use super::runtime::RuntimeArgs;

/// `starbreak study`.
#[derive(Debug, Args)]
pub(crate) struct StudyArgs {
    /// The dataset with its labels: kitti:DIR, coco:DIR, bdd:DIR or yolo:DIR
    #[arg(value_name = "FORMAT:PATH")]
    pub(crate) source: OsString,
    /// Output folder: new, empty, or that of an earlier run of the same study, which is
    /// resumed; models, presets, severities and seeds may be added
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Detector as an ONNX file; repeatable
    #[arg(short, long, required = true, value_name = "FILE")]
    pub(crate) model: Vec<PathBuf>,
    /// Contract of the detector at the same place: a preset, a TOML file, or `auto` to find it
    /// from its inputs and outputs; repeatable
    #[arg(long, value_name = "PRESET|FILE")]
    pub(crate) contract: Vec<String>,
    #[command(flatten)]
    pub(crate) runtime: RuntimeArgs,
    /// Presets to damage the images with
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', conflicts_with_all = ["preset", "recipe"])]
    pub(crate) presets: Vec<String>,
    /// All presets of a suite: `camera` is what lies on the glass and the faults of lens, sensor and link, `glass`
    /// broken glass; the others are a scenario with several faults at once, and each of these alone with the values that
    /// it has there, as the preset `rainy-drive.drops`
    #[arg(long, value_enum, value_name = "NAME", conflicts_with_all = ["preset", "recipe", "presets"])]
    pub(crate) suite: Option<SuiteWord>,
    /// Recipes to damage the images with; severities do not scale them
    #[arg(long, value_name = "FILE,…", value_delimiter = ',', conflicts_with_all = ["preset", "recipe"])]
    pub(crate) recipes: Vec<PathBuf>,
    /// Photos of broken glass, too, as one more condition: for each image a random part of a
    /// random PNG or JPEG file below a folder, or of a bank made by `starbreak patterns
    /// --overlays`. They are lit by the optics of the first preset or recipe
    #[arg(long, value_name = "DIR")]
    pub(crate) overlays: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// Severities of each preset
    #[arg(long, value_name = "N,…", value_delimiter = ',', conflicts_with = "severity",
        value_parser = clap::value_parser!(u8).range(1..=5))]
    pub(crate) severities: Vec<u8>,
    /// Seeds of the cracks, each for all images
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
    /// Map classes of a model to categories of the dataset, as for detect
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) label_map: Option<PathBuf>,
    /// Groups of dependent images, as for evaluate
    #[arg(long, value_name = "FILE|DIR")]
    pub(crate) clusters: Option<PathBuf>,
    /// Evaluation protocol [default: that of the dataset]
    #[arg(long, value_enum)]
    pub(crate) protocol: Option<ProtocolWord>,
    /// Replicates of the bootstrap and of the permutation test, 20 to 1000000
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(20..=1_000_000))]
    pub(crate) replicates: u32,
    /// Minimum score of a detection that counts as found, in failure rates
    #[arg(long, value_name = "0..1", default_value_t = 0.3, value_parser = parse_share)]
    pub(crate) score_threshold: f64,
    /// Number of worst failures shown per detector and condition, 0 to 100 [default: 6, or
    /// fewer so that all conditions together show 24]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=100))]
    pub(crate) worst: Option<u32>,
    /// Whether to compare the sets of images, too: KL, JS and W1 of five features of their
    /// pixels [default: on; off with --no-store]
    #[arg(long, value_enum)]
    pub(crate) divergence: Option<DivergenceWord>,
    /// Remove the damaged images of each condition once all detectors have looked at them: the
    /// disk holds one condition at a time. Masks, records with hashes, and detections stay; the
    /// report shows no pictures
    #[arg(long)]
    pub(crate) no_store: bool,
    /// Only the images of the i-th of n shards, e.g. 2/8, in a folder of its own and without a
    /// report; --join joins them
    #[arg(long, value_name = "I/N", value_parser = parse_shard, conflicts_with_all = ["join", "dry_run"])]
    pub(crate) shard: Option<Shard>,
    /// Of a shard only one step, as --dry-run names them: `clean`, or a condition. Steps of one shard may run side by
    /// side
    #[arg(long, value_name = "NAME", requires = "shard")]
    pub(crate) step: Option<String>,
    /// Join the finished folders of all shards, made by the same command with --shard, and report; repeatable
    #[arg(long, value_name = "DIR", conflicts_with = "dry_run")]
    pub(crate) join: Vec<PathBuf>,
    /// Check everything and name the steps, and write nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// What to do with records that break the format of the dataset: stop before anything is
    /// written, or leave these images out; labels must be good either way
    #[arg(long, value_enum, default_value_t = OnError::Stop)]
    pub(crate) on_error: OnError,
}

/// Presets that belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SuiteWord {
    /// What lies on the glass, and the faults of lens, sensor and link; without distortion, which moves what labels name
    Camera,
    /// Broken glass
    Glass,
    /// Rain, a fogged pane, a wet film and glare
    Rain,
    /// Frost, a fogged pane and road salt
    Winter,
    /// Few photons, a long exposure, glare, and a worn, greasy pane
    Night,
    /// Running water, drops and foam
    CarWash,
    /// Dust, scratches, shake and too much light
    Desert,
}

impl SuiteWord {
    /// Its presets.
    pub(crate) fn presets(self) -> Vec<String> {
        let names = |named: &[(&str, &str)]| -> Vec<String> {
            named.iter().map(|(name, _)| (*name).to_owned()).collect()
        };
        match self {
            Self::Camera => FAULTS
                .iter()
                .filter(|fault| !fault.moves_labels())
                .flat_map(|fault| names(fault.presets))
                .collect(),
            Self::Glass => names(&PRESETS),
            Self::Rain => of_scenario("rain"),
            Self::Winter => of_scenario("winter"),
            Self::Night => of_scenario("night"),
            Self::CarWash => of_scenario("car-wash"),
            Self::Desert => of_scenario("desert"),
        }
    }
}

/// Presets of a suite's scenario: each of its faults alone, then all of them together.
fn of_scenario(suite: &str) -> Vec<String> {
    SCENARIOS
        .iter()
        .filter(|scenario| scenario.suite == suite)
        .flat_map(|scenario| scenario.alone().chain([scenario.preset.0.to_owned()]))
        .collect()
}

/// Whether sets of images are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DivergenceWord {
    /// Compare them
    On,
    /// Do not compare them
    Off,
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share = text
        .parse()
        .ok()
        .filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}
