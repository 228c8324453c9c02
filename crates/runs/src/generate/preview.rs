//! What a run would do, from a few images made in memory.

use image::DynamicImage;
use starbreak_dataset::{FileRole, GeneratedSet, file_len};

use super::Plan;
use super::survey::{is_state, is_stray};
use crate::Error;

/// A few images of a plan, and what all of them would take.
#[derive(Debug)]
pub struct Preview {
    /// The images that were made.
    pub images: Vec<PreviewImage>,
    /// Images that could not be made, each with its reason.
    pub failures: Vec<(String, Error)>,
    /// Bytes of the source's images that are taken.
    pub n_input_bytes: u64,
    /// Bytes that all images with their masks and records would take, from the ratio of those made.
    pub n_output_bytes: u64,
    /// Labels and other files that would be carried over, and their bytes.
    pub n_files: u64,
    /// Bytes of these.
    pub n_file_bytes: u64,
    /// Seconds that all images would take on one thread, from those made.
    pub seconds_on_one_thread: f64,
}

/// One image of a preview.
#[derive(Debug)]
pub struct PreviewImage {
    /// Its name in the source.
    pub name: String,
    /// What it would show.
    pub pixels: DynamicImage,
    /// Share of the frame in the region.
    pub region_fraction: f64,
}

/// Makes up to `n` images, evenly spread over those of the plan, and writes nothing.
///
/// # Errors
/// [`Error::Dataset`] for a folder in which the plan could not be carried out, for labels that cannot be moved, and where a file of the
/// source cannot be asked for its length.
pub fn preview(plan: &Plan<'_>, n: u64) -> Result<Preview, Error> {
    plan.source.refuse_output_at(&plan.context.out)?;
    plan.check_movable()?;
    GeneratedSet::may_begin(&plan.context.out, &plan.identity())?;
    let total = plan.survey.n_selected;
    let wanted = n.min(total);
    let mut preview = Preview {
        images: Vec::new(),
        failures: Vec::new(),
        n_input_bytes: 0,
        n_output_bytes: 0,
        n_files: 0,
        n_file_bytes: 0,
        seconds_on_one_thread: 0.0,
    };
    let (mut read, mut written, mut spent_ms) = (0_u64, 0_u64, 0.0);
    let layout = starbreak_dataset::SetLayout::new(&plan.context.out, plan.options.n_samples);
    for (idx, image) in (0..).zip(plan.survey.selected(plan.source)) {
        let n_bytes = file_len(&image.path).unwrap_or(0);
        preview.n_input_bytes += n_bytes;
        if (idx + 1) * wanted / total.max(1) == idx * wanted / total.max(1) {
            continue;
        }
        match plan.make(&image, 0, &layout.files_of(&image.name, 0)) {
            Ok(made) => {
                read += n_bytes;
                written += made.n_bytes();
                spent_ms += made.timings.total_ms();
                preview.images.push(PreviewImage {
                    name: image.name,
                    pixels: made.pixels,
                    region_fraction: made.region_fraction,
                });
            }
            Err(error) => preview.failures.push((image.name, error)),
        }
    }
    let n_samples = u64::from(plan.options.n_samples);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_precision_loss,
        clippy::cast_sign_loss,
        reason = "an estimate of bytes and seconds"
    )]
    {
        let ratio = written as f64 / read.max(1) as f64;
        preview.n_output_bytes =
            (preview.n_input_bytes as f64 * ratio * n_samples as f64).round() as u64;
        preview.seconds_on_one_thread =
            spent_ms * 1e-3 / preview.images.len().max(1) as f64 * (total * n_samples) as f64;
    }
    let files = plan.source.files().filter_map(Result::ok);
    for file in files.filter(|file| !is_state(&file.name) && !is_stray(file)) {
        let is_carried = match &file.role {
            FileRole::LabelOf(image) => {
                plan.survey.is_selected(image) || !plan.options.selection.is_partial()
            }
            FileRole::Index => true,
            FileRole::Other => plan.options.other_files.is_some(),
        };
        if is_carried {
            preview.n_files += n_samples;
            preview.n_file_bytes += n_samples * file_len(&file.path)?;
        }
    }
    Ok(preview)
}
