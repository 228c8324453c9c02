//! Samples on disk: the one library of starbreak that touches files and image codecs.
//!
//! It is: lazy readers of datasets ([`Source`]), a strict reader for PNG and JPEG, an encoder for
//! images, masks, arrays and animations, an all-or-nothing writer for the files of one sample,
//! generated sets ([`GeneratedSet`]), banks of records ([`BankFile`]), [`video`], and the opaque
//! provenance record.
//! It is not: a place for pixel arithmetic or recipes; every value passes through it
//! unchanged, and nothing in it depends on time, threads or the platform.
//!
//! # Example
//!
//! ```
//! use image::{DynamicImage, RgbImage};
//! use starbreak_dataset::{Encoding, ImageLimits, OutputBatch, encode_image, read_image};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let dir = tempfile::tempdir()?;
//! let path = dir.path().join("cracked").join("000000.png");
//! let pixels = DynamicImage::ImageRgb8(RgbImage::from_pixel(4, 3, image::Rgb([9, 80, 200])));
//!
//! let mut batch = OutputBatch::new();
//! batch.stage(&path, &encode_image(&pixels, &Encoding::Png, None)?)?;
//! batch.commit()?;
//!
//! assert_eq!(read_image(&path, &ImageLimits::default())?.pixels, pixels);
//! # Ok(())
//! # }
//! ```
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod batch_lock;
mod error;
mod fence;
mod formats;
mod image_file;
mod line_log;
mod ordinary_file;

mod animation;
mod array;
mod bank_file;
mod encode;

mod generated;
mod set_layout;

mod json_records;

mod known_folders;
mod output_batch;
mod paths;
mod provenance;
mod replacing;

mod source;
mod street;
mod text_file;

pub mod video;

pub use animation::{AnimationParams, encode_animation};
pub use array::{DecodedArray, decode_array, encode_array, encode_array_f64};
pub use bank_file::{BankFile, BankRecord, BankWriter, WrittenBank};
pub use encode::{
    Encoding, JpegQuality, encode_image, encode_image_as, encode_mask, encode_mask_as, encode_png,
};
pub use error::{BankFault, DatasetError};
pub use fence::{fence, silence_fenced_panics};
pub use formats::{ImageFormat, SourceFormat};
pub use generated::{
    CarriedFile, Carry, Finding, GeneratedSet, ItemRecord, MAX_ITEM_BYTES, Manifest, MergeReport,
    SET_SCHEMA, SetChecker, compare_identity, file_len, merge_sets, set_identity,
};
pub use image_file::{ImageFile, ImageLimits, decode_image, image_size, read_image, readable_size};
pub use json_records::{JsonLists, JsonRecord, RecordFault, read_json_records};
pub use line_log::{LineBytes, LineLog};
pub use ordinary_file::{open_file, read_bytes};
pub use output_batch::OutputBatch;
pub use paths::{FileSet, file_in, files_in, is_inside, same_file};
pub use provenance::{Provenance, blake3_file, blake3_hex, sha256_file, sha256_hex};
pub use replacing::listed_files;
pub use set_layout::{STATE_FOLDER, SampleFiles, SetLayout, refuse_inside_set, set_around};
pub use source::{
    BadRecord, CocoAnnotation, CocoCategory, CocoImage, CocoObject, FileRole, FrameSize,
    IndexFiles, KittiRow, LabeledObject, Motion, ObjectKind, PlaceMap, ScalabelFrame,
    ScalabelLabel, ScalabelObject, Source, SourceFile, SourceImage, SourceSpec, WholeId,
    read_coco_records, read_scalabel_frames, sound_bbox,
};
pub use street::{SceneObject, StreetScene, street_scene};
pub use text_file::{TextFile, read_text};
