//! Stone and pane to the force between them, and to the ring and cone crack under it.

mod cone;
mod indentation;
mod load;

pub use cone::{ConeOutcome, HertzianCrack, auerbach_constant_n_m, hertzian_crack};
pub use load::{ContactLoad, contact_load};
