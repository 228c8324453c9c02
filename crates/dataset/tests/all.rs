//! All tests of images, sets and files as one program, which is built and run sooner than one for each file.

mod animation;
mod bank_file;
mod common;
mod encode;
mod fuzz_decode;
mod generated;
mod image_size;
mod output_batch;
mod paths;
mod read_formats;
mod read_refusals;
mod real_files;
mod replacing;
mod source_bdd;
mod source_coco;
mod source_folder;
mod source_kitti;
mod source_yolo;
