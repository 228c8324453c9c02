//! All tests of runs as one program, which is built and run sooner than one for each file.

mod bag;
mod bag_cameras;
mod bag_file;
mod bag_refusals;
mod bank;
