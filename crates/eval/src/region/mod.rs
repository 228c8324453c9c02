//! Evaluation inside of the region of an image: `region-ap/1`.

mod coverage;
mod mask;
mod precision;
mod subset;

pub use coverage::{Coverages, RegionMasks};
pub use mask::RegionMask;
pub use precision::{MIN_OBJECTS, SubsetAp, SubsetParams, subset_curves, subset_precision};
pub use subset::{CoverageOf, Size, Subset, SubsetValues};
