//! The command as a user runs it: what it says, its exit codes, and what it leaves.
//!
//! One program for all of it, because linking one for each file took longer than compiling them.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod clip;
mod moved;
#[path = "../../../../crates/detect/tests/onnx_graph/mod.rs"]
mod onnx_graph;
mod program;

mod bad_command_line;
mod bad_images;
mod bad_output;
mod bad_recipe;
mod bag;
mod bench_optics;
mod bench_physics;
mod boxed_clip;
#[cfg(unix)]
mod costly_recipes;
mod crack_masks;
mod crack_modes;
mod demo;
mod detect;
mod detect_clip;
mod determinism;
mod divergence;
mod evaluate;
mod evaluate_kitti;
mod evaluate_report;
mod flags;
mod focus;
mod generate;
mod generate_damage;
#[cfg(unix)]
mod generate_faults;
mod generate_formats;
#[cfg(unix)]
mod generate_links;
mod generate_mixups;
mod generate_moved;
mod generate_moved_sets;
#[cfg(unix)]
mod interrupt;
mod network_file;
mod overlay;
mod overlay_bank;
mod patterns;
mod physics;
mod pipe;
mod replace;
mod several_images;
mod simulate;
mod simulate_output;
mod study;
mod study_photos;
mod study_shards;
mod surface;
mod sweep;
mod timeline;
mod timeline_clips;
mod timeline_inputs;
mod video;
#[cfg(unix)]
mod video_faults;
mod video_frames;
mod video_sources;
