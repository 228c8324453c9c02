//! `bench` as it is typed.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// `starbreak bench`.
#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// Output folder
    #[arg(short, long, value_name = "DIR", default_value = "starbreak-bench")]
    pub(crate) output: PathBuf,
    /// Numbers of particles [default: 1000,10000,100000,1000000]
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(crate) particles: Option<Vec<u32>>,
    /// Runs per number of particles [default: 100], per pane and per frame [default: 10],
    /// each with its own impact point and direction
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) runs: Option<u32>,
    /// Keep the recipe's neighborhood radius instead of scaling it with the mesh
    #[arg(long)]
    pub(crate) fixed_radius: bool,
    /// Measure only this model [default: all]
    #[arg(long, value_enum)]
    pub(crate) model: Option<BenchModel>,
}

/// A model to measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BenchModel {
    /// The paper's, over the number of particles
    Paper,
    /// The physics, over kinds of panes
    Physics,
    /// The physical optics, over frames and discs
    Optics,
}
