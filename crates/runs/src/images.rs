//! Image files in, damaged image files out.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use image::GrayImage;
use rayon::prelude::*;
use serde_json::json;
use starbreak::{Chain, OutputFormat, Settings, Shown, Stopwatch, Timings};
use starbreak_dataset::{
    Encoding, FileSet, ImageFile, ImageFormat, ImageLimits, JpegQuality, OutputBatch, Provenance,
    encode_array, encode_image, encode_mask, listed_files, read_image, refuse_inside_set,
    same_file,
};
use starbreak_optics::physical::OpticalMaps;

use crate::provenance::{Sample, WrittenFile};
use crate::{Error, PROVENANCE_SCHEMA, Patterns, RunContext};

/// Names of the maps of the optics in their files' names.
const MAPS: [&str; 5] = [
    "attenuation",
    "added",
    "elsewhere",
    "displacement",
    "coverage",
];

/// One image to damage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageJob {
    /// The image file.
    pub input: PathBuf,
    /// Its file name, which its seed is keyed by.
    pub name: String,
    /// What its outputs are named by: as a rule its file name without the extension.
    pub stem: String,
    /// The name of the damaged image, where it is not to be the stem with the extension of its format.
    pub image_name: Option<String>,
}

impl ImageJob {
    /// Names of all files that the image may become, whatever its format turns out to be.
    #[must_use]
    pub fn possible_outputs(&self) -> Vec<String> {
        let of_stem = |suffix: &str| format!("{}.{suffix}", self.stem);
        let mut names = match &self.image_name {
            Some(name) => vec![name.clone()],
            None => vec![of_stem("png"), of_stem("jpg")],
        };
        names.extend(["region.png", "crack.png", "json"].map(of_stem));
        names.extend(MAPS.map(|map| of_stem(&format!("{map}.npy"))));
        if self.image_name.is_none() && !names.contains(&self.name) {
            names.push(self.name.clone());
        }
        names
    }
}

/// What was written for one image.
#[derive(Debug, Clone)]
pub struct Written {
    /// The damaged image.
    pub image: PathBuf,
    /// The region mask, if asked for.
    pub region: Option<PathBuf>,
    /// The crack mask, if asked for.
    pub crack: Option<PathBuf>,
    /// The maps of the optics, if asked for: NumPy arrays.
    pub maps: Vec<PathBuf>,
    /// The provenance.
    pub provenance: PathBuf,
    /// What the damage is made from.
    pub chain: Chain,
    /// What it did to the image.
    pub shown: Shown,
    /// Wall-clock time per stage, reading and writing included.
    pub timings: Timings,
}

/// An image that was not damaged.
#[derive(Debug)]
pub struct Failure {
    /// The image file.
    pub input: PathBuf,
    /// Why.
    pub error: Error,
}

/// How a job ended; `None` where the run was interrupted before it began.
pub type JobResult = Option<Result<Written, Failure>>;

/// The jobs for a list of image files, in its order. `image_name` names the damaged image of one, and by its stem
/// the other outputs.
///
/// # Errors
/// [`Error::OutputCollision`] where two images could write the same file,
/// [`Error::OutputIsInput`] where one could replace another's input, [`Error::NoFileName`],
/// [`Error::Dataset`] for a folder in a generated set.
pub fn plan_images(
    inputs: &[PathBuf],
    out: &Path,
    image_name: Option<&str>,
) -> Result<Vec<ImageJob>, Error> {
    refuse_inside_set(out)?;
    let known = FileSet::of(inputs);
    let mut writer_of: BTreeMap<String, &PathBuf> = BTreeMap::new();
    let mut jobs = Vec::with_capacity(inputs.len());
    for input in inputs {
        let part =
            |part: Option<&std::ffi::OsStr>| part.map(|name| name.to_string_lossy().into_owned());
        let (Some(name), Some(stem)) = (part(input.file_name()), part(input.file_stem())) else {
            return Err(Error::NoFileName {
                input: input.clone(),
            });
        };
        let job = ImageJob {
            input: input.clone(),
            name,
            stem: image_name.map_or(stem, |name| {
                part(Path::new(name).file_stem()).unwrap_or_default()
            }),
            image_name: image_name.map(str::to_owned),
        };
        for output in job.possible_outputs() {
            // Letters of either case are one name on some file systems.
            if let Some(first) = writer_of.insert(output.to_lowercase(), input)
                && first != input
            {
                return Err(Error::OutputCollision {
                    first: first.clone(),
                    second: input.clone(),
                    name: output,
                });
            }
            let output = out.join(output);
            if let Some(input) = known.find(&output) {
                return Err(Error::OutputIsInput { input, output });
            }
        }
        if jobs.contains(&job) {
            return Err(Error::OutputCollision {
                first: input.clone(),
                second: input.clone(),
                name: job.stem,
            });
        }
        jobs.push(job);
    }
    Ok(jobs)
}

/// Damages many images, in parallel over images; results in the order of the jobs.
///
/// `done` is called after each image, in any order. Once `stop` is set no further image begins.
/// The bytes written do not depend on the number of threads.
pub fn damage_files(
    jobs: &[ImageJob],
    context: &RunContext,
    patterns: &Patterns,
    stop: &AtomicBool,
    done: impl Fn(&ImageJob, &Result<Written, Failure>) + Sync,
) -> Vec<JobResult> {
    jobs.par_iter()
        .with_max_len(1)
        .map(|job| {
            if stop.load(Ordering::Relaxed) {
                return None;
            }
            let result = damage_file(job, context, patterns).map_err(|error| Failure {
                input: job.input.clone(),
                error,
            });
            done(job, &result);
            Some(result)
        })
        .collect()
}

/// Damages one image file: the image, its masks and its provenance appear together or not at all.
///
/// # Errors
/// [`Error`] naming the file; nothing is written then.
pub fn damage_file(
    job: &ImageJob,
    context: &RunContext,
    patterns: &Patterns,
) -> Result<Written, Error> {
    let mut watch = Stopwatch::start();
    let mut file = read_image(&job.input, &ImageLimits::default())?;
    watch.lap("read");
    let mut batch = OutputBatch::new().replacing(context.replaces);
    let chain = chain_for(job, &file, context, patterns, &mut watch)?;
    let written = stage_shown(job, &mut file, chain, watch, context, &mut batch)?;
    batch.commit()?;
    Ok(written)
}

/// The damage of one image.
///
/// # Errors
/// [`Error::OfImage`] naming the file.
pub fn chain_for(
    job: &ImageJob,
    file: &ImageFile,
    context: &RunContext,
    patterns: &Patterns,
    watch: &mut Stopwatch,
) -> Result<Chain, Error> {
    let seed = context.seed.of_item(&job.name, 0);
    let size = (file.pixels.width(), file.pixels.height());
    let damaged = patterns.for_frame(&context.settings, (size, None), seed, watch);
    Ok(damaged
        .map_err(|error| Error::of_image(&job.input, error))?
        .chain)
}

/// Where the files of one image go.
struct Paths {
    image: PathBuf,
    region: PathBuf,
    crack: PathBuf,
    maps: [PathBuf; 5],
    provenance: PathBuf,
}

impl Paths {
    /// None of them may be the image that is read.
    fn of(job: &ImageJob, out: &Path, format: ImageFormat) -> Result<Self, Error> {
        let beside = |suffix: &str| out.join(format!("{}.{suffix}", job.stem));
        let paths = Self {
            image: match &job.image_name {
                Some(name) => out.join(name),
                None => beside(&extension(&job.input, format)),
            },
            region: beside("region.png"),
            crack: beside("crack.png"),
            maps: MAPS.map(|map| beside(&format!("{map}.npy"))),
            provenance: beside("json"),
        };
        let outputs = [&paths.image, &paths.region, &paths.crack, &paths.provenance];
        for output in outputs.into_iter().chain(&paths.maps) {
            if same_file(&job.input, output) {
                return Err(Error::OutputIsInput {
                    input: job.input.clone(),
                    output: output.clone(),
                });
            }
        }
        Ok(paths)
    }
}

/// Shows damage in the image that it was made for, in place, and stages its files in a batch, which the
/// caller commits.
///
/// # Errors
/// [`Error`] naming the file.
pub fn stage_shown(
    job: &ImageJob,
    file: &mut ImageFile,
    chain: Chain,
    mut watch: Stopwatch,
    context: &RunContext,
    batch: &mut OutputBatch,
) -> Result<Written, Error> {
    let RunContext { out, settings, .. } = context;
    let encoding = encoding(settings, file)?;
    let paths = Paths::of(job, out, encoding.format())?;
    let seed = context.seed.of_item(&job.name, 0);
    let of_image = |error| Error::of_image(&job.input, error);
    let shown = chain
        .over_and_report(&mut file.pixels, seed, &[], &mut watch)
        .map_err(|error| of_image(error.into()))?;
    let crack = chain.crack_mask_of(&shown)?;
    watch.lap("masks");

    let bytes = encode_image(&file.pixels, &encoding, file.icc_profile.as_deref())
        .map_err(|error| of_image(error.into()))?;
    let record = listed_files(&paths.provenance, PROVENANCE_SCHEMA, Some(&job.name));
    batch.take_over(record);
    let mut stage = |path: &Path, bytes: &[u8]| -> Result<WrittenFile, Error> {
        batch.stage(path, bytes)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(WrittenFile::of(&name, bytes))
    };
    let mut files = vec![("output", stage(&paths.image, &bytes)?)];
    if settings.output.masks {
        files.push((
            "region",
            stage(&paths.region, &encode_mask(&shown.region)?)?,
        ));
        files.push(("crack", stage(&paths.crack, &encode_mask(&crack)?)?));
    }
    let mut maps = Vec::new();
    if let Some(of_optics) = &shown.maps {
        let arrays = encode_maps(of_optics, &crack)?;
        for (path, array) in paths.maps.iter().zip(arrays) {
            maps.push(stage(path, &array)?);
        }
    }
    let n_maps = maps.len();
    watch.lap("write");
    let timings = watch.stop();

    let sample = Sample {
        name: &job.name,
        sample_idx: 0,
        seed,
        size: (file.pixels.width(), file.pixels.height()),
        input_blake3: &file.blake3,
        files,
        facts: chain.facts(),
        shown: &shown,
    };
    let mut record = context.record(sample, Some(&context.recipe));
    record.insert("timings_ms".to_owned(), timings.to_json());
    if !maps.is_empty() {
        record.insert("maps".to_owned(), json!(maps));
    }
    let provenance = Provenance::new(record.into())?;
    batch.stage(&paths.provenance, &provenance.to_bytes())?;
    Ok(Written {
        image: paths.image,
        region: settings.output.masks.then_some(paths.region),
        crack: settings.output.masks.then_some(paths.crack),
        maps: paths.maps.into_iter().take(n_maps).collect(),
        provenance: paths.provenance,
        chain,
        shown,
        timings,
    })
}

/// What each of [`MAPS`] is as a file: row by row, then by color or coordinate.
fn encode_maps(maps: &OpticalMaps, crack: &GrayImage) -> Result<[Vec<u8>; 5], Error> {
    let (width, height) = (maps.width as usize, maps.height as usize);
    let coverage: Vec<f32> = crack
        .as_raw()
        .iter()
        .map(|code| f32::from(*code) / 255.0)
        .collect();
    let array = |channels: &[usize], values: &[f32]| {
        encode_array(&[&[height, width], channels].concat(), values)
    };
    Ok([
        array(&[], &maps.attenuation)?,
        array(&[3], maps.added.as_flattened())?,
        array(&[], &maps.elsewhere)?,
        array(&[2], maps.displacement.as_flattened())?,
        array(&[], &coverage)?,
    ])
}

/// How the damaged image is stored.
pub(crate) fn encoding(settings: &Settings, file: &ImageFile) -> Result<Encoding, Error> {
    Ok(match (settings.output.format, file.format) {
        (OutputFormat::Jpeg, _) | (OutputFormat::Same, ImageFormat::Jpeg) => Encoding::Jpeg {
            quality: JpegQuality::new(settings.output.quality)?,
        },
        _ => Encoding::Png,
    })
}

/// The input's own extension if it fits the format, else the usual one.
pub(crate) fn extension(input: &Path, format: ImageFormat) -> String {
    let own = input
        .extension()
        .map(|own| own.to_string_lossy().into_owned())
        .unwrap_or_default();
    let (usual, known): (&str, &[&str]) = match format {
        ImageFormat::Jpeg => ("jpg", &["jpg", "jpeg", "jpe", "jfif"]),
        _ => ("png", &["png"]),
    };
    if known.contains(&own.to_lowercase().as_str()) {
        own
    } else {
        usual.to_owned()
    }
}
