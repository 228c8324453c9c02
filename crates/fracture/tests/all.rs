//! All tests of fracture as one program, which is built and run sooner than one for each file.

mod dice;
mod hinges;
mod paper_reading;
mod physics_laws;
mod plate;
mod properties;
