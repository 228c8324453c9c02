//! `divergence` as it is typed.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `starbreak divergence`.
#[derive(Debug, Args)]
pub(crate) struct DivergenceArgs {
    /// Two or more sets: kitti:DIR, coco:DIR, bdd:DIR, yolo:DIR, folder:DIR or list:FILE, with a
    /// name before it if wanted (clean=folder:DIR); or networks:DIR, the crack networks (JSON) of a
    /// folder
    #[arg(value_name = "SET", required_unless_present_any = ["histograms", "features", "experiment"])]
    pub(crate) sets: Vec<OsString>,
    /// Folder for divergence.json, divergence.csv and divergence.svg
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,
    /// Measures of given histograms instead: JSON, a list of {p, q, alpha}, or an object with one under
    /// hist
    #[arg(long, value_name = "FILE", conflicts_with_all = ["sets", "features", "experiment", "output"])]
    pub(crate) histograms: Option<PathBuf>,
    /// Fréchet distance and KID of feature vectors made elsewhere: NumPy files of n × d floats
    #[arg(long, num_args = 2, value_names = ["A.npy", "B.npy"], conflicts_with_all = ["sets", "experiment", "output"])]
    pub(crate) features: Option<Vec<PathBuf>>,
    /// Counts added to each bin
    #[arg(long, value_name = "X", default_value_t = 0.5)]
    pub(crate) alpha: f64,
    /// Bootstrap replicates behind the intervals; 0 for none
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    pub(crate) bootstrap: u32,
    /// Random relabelings behind the p-values; 0 for none
    #[arg(long, value_name = "N", default_value_t = 999, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    pub(crate) permutations: u32,
    /// Random split-halves behind the floors; 0 for none
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    pub(crate) splits: u32,
    /// Only the first N images of each set
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) limit: Option<u32>,
    /// Shorter side of the image that gradients and spectra are taken of, px; 0 for its own size
    #[arg(long, value_name = "PX", default_value_t = 256, value_parser = clap::value_parser!(u32).range(0..=8192))]
    pub(crate) side: u32,
    /// What shows through where an image is transparent
    #[arg(long, value_name = "COLOR", default_value = "black", value_parser = ["black", "gray", "white"])]
    pub(crate) background: String,
    /// Compare the activations of a layer of this ONNX detector, too: Fréchet distance, KID
    #[arg(long, value_name = "FILE.onnx", conflicts_with_all = ["histograms", "features"])]
    pub(crate) model: Option<PathBuf>,
    /// Name of the value in the model whose channel means are the features; the widest of its
    /// coarsest maps unless given
    #[arg(long, value_name = "NAME", requires = "model")]
    pub(crate) layer: Option<String>,
    #[command(flatten)]
    pub(crate) experiment: ExperimentArgs,
}

/// The paper's experiment.
#[derive(Debug, Args)]
pub(crate) struct ExperimentArgs {
    /// The paper's distributions and its control, of those sets that are given below
    #[arg(long, value_enum, value_name = "NAME", conflicts_with = "sets")]
    pub(crate) experiment: Option<ExperimentWord>,
    /// Sim: simulated crack patterns on black
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) simulated: Option<OsString>,
    /// RO: real crack patterns collected online, on black or cut out
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) real_overlays: Option<OsString>,
    /// Clean KITTI images
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) kitti: Option<OsString>,
    /// Clean BDD100K images, a second driving set that the paper has not
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) bdd: Option<OsString>,
    /// Cats, the control
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) cats: Option<OsString>,
    /// Sim x KITTI: simulated patterns over KITTI
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) simulated_kitti: Option<OsString>,
    /// RO x KITTI: real patterns over KITTI
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) overlays_kitti: Option<OsString>,
    /// Clean RC: the road through whole glass
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) road_clean: Option<OsString>,
    /// Broken RC: the road through broken glass
    #[arg(long, value_name = "SET", requires = "experiment")]
    pub(crate) road_broken: Option<OsString>,
}

/// Which experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExperimentWord {
    /// The figure of K-L divergences of the paper
    Paper,
}
