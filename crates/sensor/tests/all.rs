//! All tests of sensors as one program, which is built and run sooner than one for each file.

mod laws;
mod link;
mod stages;
