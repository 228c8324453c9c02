//! `patterns` as it is typed.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

use super::overlay::OverlayArgs;
use super::parse_size;

/// `starbreak patterns`.
#[derive(Debug, Args)]
pub(crate) struct PatternsArgs {
    /// Number of patterns; pattern k is the same in a bank of any number
    #[arg(short, long = "number", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000), required_unless_present_any = ["info", "check", "images_of"])]
    pub(crate) n: Option<u32>,
    /// Output folder: patterns.bank, statistics.csv, statistics.svg and statistics.png
    #[arg(short, long, value_name = "DIR", required_unless_present_any = ["info", "check"])]
    pub(crate) output: Option<PathBuf>,
    /// Frame size to bake for, px; repeatable. The cracks are simulated for the first size;
    /// images of other sizes take longer, since their patterns are baked anew
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1242x375", value_parser = parse_size)]
    pub(crate) size: Vec<(u32, u32)>,
    /// Bake for the most frequent frame sizes of a dataset instead (FORMAT:PATH as in
    /// `generate`)
    #[arg(long, value_name = "FORMAT:PATH", conflicts_with_all = ["size", "overlays", "info", "check"])]
    pub(crate) sizes_of: Option<OsString>,
    /// Maximum number of these sizes; each adds to the size of the bank
    #[arg(long, value_name = "N", default_value = "8", requires = "sizes_of", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) most_sizes: u16,
    /// Fill the bank with photos of broken glass instead: each PNG and JPEG file below a
    /// folder once, and for each pattern a random part of a random photo, in overlays.bank
    /// and overlays.csv; for `generate --overlays`, with any recipe
    #[arg(long, value_name = "DIR", conflicts_with_all = ["preset", "recipe", "severity", "camera", "set", "info", "check"])]
    pub(crate) overlays: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overlay: OverlayArgs,
    /// Write the patterns of a bank as PNG files to the output folder instead: on black as the
    /// paper's optics draw them, or their crack masks; -n for the first N only
    #[arg(long, value_name = "BANK", conflicts_with_all = ["overlays", "size", "sizes_of", "most_sizes", "seed", "info", "check", "preset", "recipe", "severity", "camera", "set"])]
    pub(crate) images_of: Option<PathBuf>,
    /// Print what a bank was made from, and its size, instead
    #[arg(long, value_name = "BANK", conflicts_with_all = ["n", "output", "check"])]
    pub(crate) info: Option<PathBuf>,
    /// Read a whole bank and verify its checksums instead
    #[arg(long, value_name = "BANK", conflicts_with_all = ["n", "output"])]
    pub(crate) check: Option<PathBuf>,
}
