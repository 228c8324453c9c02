//! A study: detectors on clean and on cracked images, over a list of conditions.
//!
//! ```text
//! Source ──► generate, once per condition ──► cracked images and their regions
//!    │                                            │
//!    └──► detect, once per detector ──► clean     └──► detect, per detector and condition ──► cracked
//!                                          └────────┬────────┘
//!                                               evaluate ──► report
//! ```
//!
//! Each step goes on where an interrupted run was, and comes to the same. Shards of a study do their images in folders of
//! their own, on any number of machines, and are joined.

mod arm;
mod arm_log;
mod condition;
mod distances;
mod identity;
mod images;
mod numbers;
mod run;
mod set;
mod shards;

pub use arm_log::UnseenImage;
pub use condition::{Condition, Family, conditions, folder_name};
pub use run::{Step, StudyDetector, StudyEvent, StudyPlan, StudyRuns};
pub use shards::CLEAN_STEP;
