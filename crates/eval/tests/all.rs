//! All tests of evaluation as one program, which is built and run sooner than one for each file.

mod calibration;
mod coco_reference;
mod common;
mod divergence_reference;
mod evaluation;
mod failure;
mod hostile_detections;
mod hostile_sizes;
mod kitti_reference;
mod label_audit;
#[path = "report/plausible.rs"]
mod plausible;
mod region_reference;
mod report;
mod report_browser;
mod resampling;
mod statistics;
mod timeline;
