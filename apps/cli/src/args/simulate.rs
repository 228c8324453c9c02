//! `simulate` as it is typed.

use std::path::PathBuf;

use clap::Args;

use super::parse_size;

/// `starbreak simulate`.
#[derive(Debug, Args)]
pub(crate) struct SimulateArgs {
    /// Network file (JSON) [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// SVG drawing of the network
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Convert this crack network (JSON or SVG) instead of simulating one
    #[arg(long, value_name = "FILE")]
    pub(crate) network: Option<PathBuf>,
    /// Frame size, px
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1242x375", value_parser = parse_size)]
    pub(crate) size: (u32, u32),
    /// Number of growth frames, from the impact to the last arrival
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) frames: Option<u32>,
    /// Where to write the frames: a name that ends in .png for one animated PNG, else a
    /// folder [default: NAME-frames beside the network file]
    #[arg(long, value_name = "PATH", requires = "frames")]
    pub(crate) frames_to: Option<PathBuf>,
    /// Add the wall-clock time of each stage to the network file
    #[arg(long)]
    pub(crate) timings: bool,
}

impl SimulateArgs {
    /// How many growth frames were asked for, and where they go.
    pub(crate) fn growth_frames(&self) -> Option<(u32, PathBuf)> {
        let to = || match (&self.frames_to, self.output.as_deref()) {
            (Some(to), _) => to.clone(),
            (None, None) => PathBuf::from("network-frames"),
            (None, Some(network)) => {
                let stem = network.file_stem().unwrap_or("network".as_ref());
                network.with_file_name(format!("{}-frames", stem.to_string_lossy()))
            }
        };
        self.frames.map(|n_frames| (n_frames, to()))
    }
}
