//! Decode and encode alone: the floor that `starbreak generate` is measured against.
//!
//! `recode N_THREADS FORMAT:PATH OUT` reads each image of a dataset, encodes it in its format
//! with the quality of the default recipe, and writes it, with the codecs and threads of `generate`.
#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::ffi::OsStr;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;
use starbreak::Recipe;
use starbreak_dataset::{
    Encoding, ImageFormat, ImageLimits, JpegQuality, OutputBatch, Source, SourceSpec,
    encode_image_as, read_image,
};
use starbreak_runs::with_threads;

/// That of the command.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [n_threads, source, out] = args.as_slice() else {
        return Err("expected N_THREADS FORMAT:PATH OUT".into());
    };
    let source = Source::open(&SourceSpec::parse(OsStr::new(source))?)?;
    let quality = Recipe::preset("windshield-star")?
        .settings()?
        .output
        .quality;
    let started = Instant::now();
    let n_images = with_threads(n_threads.parse()?, || {
        let images = source.images().filter_map(Result::ok);
        images
            .par_bridge()
            .map(|image| -> Result<u64, starbreak_runs::Error> {
                let file = read_image(&image.path, &ImageLimits::default())?;
                let encoding = match file.format {
                    ImageFormat::Jpeg => Encoding::Jpeg {
                        quality: JpegQuality::new(quality)?,
                    },
                    _ => Encoding::Png,
                };
                let mut batch = OutputBatch::new_unsynced().replacing(true);
                let bytes = encode_image_as(&file, &encoding)?;
                batch.stage(&Path::new(out).join(&image.name), &bytes)?;
                batch.commit()?;
                Ok(1)
            })
            .sum::<Result<u64, _>>()
    })??;
    println!(
        "{n_images} images in {:.3} s",
        started.elapsed().as_secs_f64()
    );
    Ok(())
}
