//! Real photographs, where the shared data are at hand.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]
#![expect(clippy::print_stderr, reason = "times and skipped tests must be seen")]

use crate::common;

use std::path::PathBuf;
use std::time::Instant;

use common::{psnr_db, shared_data};
use image::DynamicImage;
use starbreak_dataset::{
    Encoding, ImageFormat, ImageLimits, JpegQuality, decode_image, encode_image, read_image,
};

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let Some(folder) = shared_data(folder) else {
        return Vec::new();
    };
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == extension))
        .collect();
    files.sort();
    files
}

/// The median time of nine runs, in ms, and the last result.
fn timed<T>(run: impl Fn() -> T) -> (f64, T) {
    let mut times = [0.0; 9];
    for time in &mut times {
        let start = Instant::now();
        let _ = run();
        *time = start.elapsed().as_secs_f64() * 1e3;
    }
    times.sort_by(f64::total_cmp);
    (times[4], run())
}

#[test]
fn kitti_pngs() {
    for path in files("kitti/image_2", "png") {
        let (read_ms, file) = timed(|| read_image(&path, &ImageLimits::default()).unwrap());
        assert_eq!(file.format, ImageFormat::Png, "{path:?}");
        assert!(
            matches!(file.pixels, DynamicImage::ImageRgb8(_)),
            "{path:?}"
        );
        let (encode_ms, bytes) =
            timed(|| encode_image(&file.pixels, &Encoding::Png, None).unwrap());
        let again = decode_image("again", &bytes, &ImageLimits::default()).unwrap();
        assert!(again.pixels == file.pixels, "{path:?} is exact");

        let jpeg = Encoding::Jpeg {
            quality: JpegQuality::new(92).unwrap(),
        };
        let (jpeg_ms, jpeg_bytes) = timed(|| encode_image(&file.pixels, &jpeg, None).unwrap());
        let (decode_ms, lossy) =
            timed(|| decode_image("lossy", &jpeg_bytes, &ImageLimits::default()).unwrap());
        let psnr = psnr_db(lossy.pixels.as_bytes(), file.pixels.as_bytes());
        assert!(psnr > 34.0, "{path:?}: {psnr:.1} dB");
        eprintln!(
            "{}x{}: PNG read {read_ms:.2} ms, encode {encode_ms:.2} ms ({} of {} bytes); JPEG 92 encode \
             {jpeg_ms:.2} ms, decode {decode_ms:.2} ms, {} bytes, {psnr:.1} dB, {}",
            file.pixels.width(),
            file.pixels.height(),
            bytes.len(),
            std::fs::metadata(&path).unwrap().len(),
            jpeg_bytes.len(),
            &starbreak_dataset::sha256_hex(&jpeg_bytes)[..12],
        );
    }
}

#[test]
fn bdd_jpegs_whole_and_cut() {
    for path in files("bdd", "jpg") {
        let bytes = std::fs::read(&path).unwrap();
        let (decode_ms, file) =
            timed(|| decode_image("x", &bytes, &ImageLimits::default()).unwrap());
        eprintln!(
            "{}x{}: JPEG decode {decode_ms:.2} ms",
            file.pixels.width(),
            file.pixels.height()
        );
        for end in [bytes.len() / 2, bytes.len() - 2, bytes.len() - 1] {
            let cut = decode_image("x", &bytes[..end], &ImageLimits::default());
            assert!(cut.is_err(), "{path:?} cut after {end} bytes");
        }
    }
}
