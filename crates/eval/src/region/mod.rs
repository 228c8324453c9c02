//! Evaluation inside of the region of an image: `region-ap/1`.

mod coverage;
mod mask;
mod subset;

pub use coverage::{Coverages, RegionMasks};
pub use mask::RegionMask;
pub use subset::{CoverageOf, Size, Subset, SubsetValues};
