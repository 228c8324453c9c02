//! Two published facts of brittle fracture by bond-based peridynamics [Silling2000;
//! SillingAskari2005], which knows neither crack paths nor crack numbers: cracks are the bonds that
//! broke. An oracle for starbreak's fracture model, without any of its code.

pub mod body;
pub mod branching;
pub mod lattice;
pub mod material;
pub mod picture;
pub mod plate;
pub mod random;
pub mod star;
pub mod table;
