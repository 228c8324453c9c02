//! A dataset in, its cracked twin out: which images, with which cracks, as which files.
//!
//! ```text
//! Source ──► survey ──► run ──► one item: crack, put over, damage, files
//!                        │         └─► carried labels and files
//!                        └──► lists and manifest           verify, regenerate, merge
//! ```
//!
//! What comes out is a function of the source, the recipe, the seed and the bank alone: never of
//! threads, order, shards or restarts.

mod carry;
mod damage;
mod identity;
mod item;
mod moved;
mod preview;
mod regenerate;
mod run;
mod single;
mod survey;
mod verify;

pub use identity::{generate_flags, set_seed_and_recipe};

pub use preview::{Preview, PreviewImage, preview};
pub use regenerate::{RegenerateReport, regenerate};
pub use run::{Event, GenerateReport, ItemFailure, generate};
pub use single::{CrackedFiles, crack_file};
pub use survey::{Shard, Survey, survey};
pub use verify::{VerifyReport, verify};

use starbreak::{OutputFormat, OutputSettings};
use starbreak_dataset::{Carry, Source};

use crate::RunContext;
use crate::{Error, Patterns};

/// How a set is made from its source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GenerateOptions {
    /// Samples of each image, each with a pattern of its own; 1 or more.
    pub n_samples: u32,
    /// Which images.
    pub selection: Selection,
    /// What becomes of files that are neither images nor labels; none leaves them out.
    pub other_files: Option<Carry>,
    /// The run stops when more images than this have failed; none never stops it.
    pub max_failures: Option<u64>,
}

impl Default for GenerateOptions {
    fn default() -> Self {
        Self {
            n_samples: 1,
            selection: Selection::default(),
            other_files: Some(Carry::Copy),
            max_failures: None,
        }
    }
}

/// Which images of a source are taken.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Selection {
    /// The first so many.
    pub limit: Option<u64>,
    /// So many at random, by the seed.
    pub sample: Option<u64>,
    /// Of those, the ones of one shard.
    pub shard: Option<Shard>,
}

impl Selection {
    /// Whether labels of images are to be left out.
    fn is_partial(&self) -> bool {
        self.limit.is_some() || self.sample.is_some()
    }
}

/// A source with all that is done to it.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The dataset.
    pub source: &'a Source,
    /// Recipe, seed and output folder.
    pub context: &'a RunContext,
    /// Where the cracks come from.
    pub patterns: &'a Patterns,
    /// How the set is made.
    pub options: &'a GenerateOptions,
    /// Which images there are.
    pub survey: &'a Survey,
}

/// Refuses what images of a set do not have: a set keeps the names of its source, so an image keeps
/// its format, and maps would outweigh all else.
///
/// # Errors
/// [`Error::SetOutput`] naming the key and what to set.
pub fn refuse_outputs(output: &OutputSettings) -> Result<(), Error> {
    if output.format != OutputFormat::Same {
        return Err(Error::SetOutput {
            why: "generate keeps the names and formats of the dataset; set output.format = \"same\"",
        });
    }
    if output.maps {
        return Err(Error::SetOutput {
            why: "generate writes no maps, which take some 30 bytes per px; set output.maps = false, and crack single \
                  images for their maps",
        });
    }
    Ok(())
}
