//! Tempered pane to dice: how many, where, and the cracks between them.

mod cascade;
mod cells;
mod count;
mod graph;
mod points;
mod radial_map;
mod tracks;
mod wander;

pub use cascade::dice_cascade;
pub use cells::dice_cells;
pub use count::{
    ONSET_PA, count_law_empirical, count_law_energy, fragment_density_per_m2, fragments_per_50_mm,
};
pub use graph::{Diced, FRONT_SPEED_M_S};
