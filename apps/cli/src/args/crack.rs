//! `crack` as it is typed.

use std::path::PathBuf;

use clap::Args;

use super::overlay::OverlayArgs;

/// `starbreak crack`.
#[derive(Debug, Args)]
pub(crate) struct CrackArgs {
    /// PNG, JPEG, WebP or BMP files
    #[arg(required = true, value_name = "IMAGE")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Output folder; or for one image the name of the damaged one, .png, .jpg or .jpeg
    #[arg(short, long, value_name = "DIR|FILE")]
    pub(crate) output: PathBuf,
    /// Also write the maps of the optics as NumPy arrays of 32-bit floats: attenuation,
    /// added light, light from elsewhere in the frame and its displacement, coverage
    #[arg(long)]
    pub(crate) maps: bool,
    /// Use this crack network instead of simulating one: JSON, or an SVG drawing whose
    /// stroked shapes are cracks. A drawing in px is stretched over the frame, one in mm
    /// lies on the pane
    #[arg(long, value_name = "FILE")]
    pub(crate) network: Option<PathBuf>,
    /// Use this photo of broken glass instead of cracks: PNG or JPEG, cut out (alpha), or
    /// on black or white. The largest part that has the frame's shape fills the frame
    #[arg(long, value_name = "PHOTO", conflicts_with = "network")]
    pub(crate) overlay: Option<PathBuf>,
    /// Take a random part of the photo for each image, randomly flipped, by the seed
    #[arg(long, requires = "overlay")]
    pub(crate) overlay_random: bool,
    #[command(flatten)]
    pub(crate) overlay_args: OverlayArgs,
}
