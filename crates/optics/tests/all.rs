//! All tests of optics as one program, which is built and run sooner than one for each file.

mod camera;
mod drops;
mod drops_mitsuba;
mod environment;
mod furnace;
mod interface;
mod lens_faults;
mod mitsuba_chain;
mod paper_render;
mod photo;
mod screens;
mod stray_light;
