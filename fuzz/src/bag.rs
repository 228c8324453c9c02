use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use image::DynamicImage;
use starbreak::{Recipe, Seed};
use starbreak_dataset::{ImageFile, ImageFormat, ImageLimits, JpegQuality};
use starbreak_runs::RunContext;
use starbreak_runs::bag::{Bag, BagReport, BagRequest, CameraKind, CameraMessage, ImpactAt};
use starbreak_runs::clip::{Growth, Light};

use crate::Vocabulary;

/// Words of records and of messages, and values that sit on an edge.
pub(crate) const VOCABULARY: Vocabulary = &[
    "\u{1}\u{0}\u{0}\u{0}\u{0}\u{0}\u{0}\u{0}",
    "\u{0}\u{0}\u{0}\u{0}",
    "\u{0}\u{0}\u{0}\u{1}",
    "\u{7f}\u{7f}\u{7f}\u{7f}",
    "\u{5}",
    "\u{6}",
    "\u{9}",
    "\u{c}",
    "\u{f}",
    "lz4",
    "zstd",
    "cdr",
    "rgb8\u{0}",
    "bgra8\u{0}",
    "mono8\u{0}",
    "bayer_rggb8\u{0}",
    "jpeg\u{0}",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
];

/// A recipe that breaks nothing.
const NO_GLASS: &str = "schema = 1\n[fracture]\nmodel = \"none\"\n";

/// Small limits, so that a header does not take the time of many inputs.
const LIMITS: ImageLimits = ImageLimits {
    max_side_px: 2000,
    max_pixels: 400_000,
    max_file_bytes: 1 << 20,
};

/// A message of a camera is refused with one printable line, or keeps all before its data when it is written with its
/// own pixels, and reads as the same again. The first byte says of which kind it is.
///
/// # Panics
/// If the input is a finding.
pub fn message(bytes: &[u8]) {
    let Some((kind, bytes)) = bytes.split_first() else {
        return;
    };
    let kind = match kind % 2 {
        0 => CameraKind::Raw,
        _ => CameraKind::Compressed,
    };
    let message = match CameraMessage::read(kind, bytes) {
        Ok(message) => message,
        Err(fault) => return is_one_line(&fault.to_string()),
    };
    let mut raw = bytes.to_vec();
    let frame = message.frame(&mut raw);
    assert_eq!(frame.is_some(), kind == CameraKind::Raw, "a frame in it");
    if let Some(mut frame) = frame {
        let mut image = DynamicImage::default();
        frame.copy_to(&mut image);
        let copied = frame.copy_from(&mut image);
        assert!(copied.is_ok(), "its own pixels: {copied:?}");
    }
    assert_eq!(raw, bytes, "a raw image with its own pixels");
    let file = match message.file(bytes, &LIMITS) {
        Ok(Some(file)) => file,
        Ok(None) => return assert_eq!(kind, CameraKind::Raw, "no file in it"),
        Err(fault) => return is_one_line(&fault.to_string()),
    };
    let Ok(quality) = JpegQuality::new(95) else {
        return;
    };
    let written = match message.with_file(bytes, &file, quality) {
        Ok(written) => written,
        Err(fault) => return is_one_line(&fault.to_string()),
    };
    match CameraMessage::read(kind, &written) {
        Ok(again) => {
            assert_eq!(again.stamp_ns(), message.stamp_ns(), "the stamp");
            match again.file(&written, &LIMITS) {
                Ok(Some(read)) if file.format == ImageFormat::Jpeg => {
                    let size = |file: &ImageFile| (file.pixels.width(), file.pixels.height());
                    assert_eq!(size(&read), size(&file), "the size");
                }
                Ok(Some(read)) => assert_eq!(read.pixels, file.pixels, "written and read again"),
                Ok(None) => panic!("a compressed image that is none when it is read again"),
                Err(fault) => panic!("does not read what it wrote: {fault}"),
            }
        }
        Err(fault) => panic!("does not read what it wrote: {fault}"),
    }
}

/// A file is refused with one printable line, or written as a bag that is read again without damage and written as the
/// same bytes, but for its record of what was done.
///
/// # Panics
/// If the input is a finding, or the folder of temporary files cannot be written.
pub fn bag(bytes: &[u8]) {
    let dir = match tempfile::tempdir() {
        Ok(dir) => dir,
        Err(error) => panic!("no folder: {error}"),
    };
    let [first, second, third] = ["a.mcap", "b.mcap", "c.mcap"].map(|name| dir.path().join(name));
    if let Err(error) = fs::write(&first, bytes) {
        panic!("cannot write: {error}");
    }
    let n_messages = match through(&first, &second) {
        Err(message) => return is_one_line(&message),
        Ok(report) => report.n_messages,
    };
    match through(&second, &third) {
        Ok(again) => {
            assert_eq!(
                again.n_messages, n_messages,
                "messages, written and read again"
            );
            assert_eq!(again.damage, None, "what is written is whole");
        }
        Err(message) => panic!("does not read what it wrote: {message}"),
    }
}

/// A bag through glass that nothing hits.
fn through(input: &Path, output: &Path) -> Result<BagReport, String> {
    let context = Recipe::parse("fuzz", NO_GLASS)
        .map_err(starbreak_runs::Error::from)
        .and_then(|recipe| RunContext::new(&recipe, Seed(0), output));
    let bag = context.and_then(|context| {
        Bag::open(BagRequest {
            input: input.to_owned(),
            output: output.to_owned(),
            cameras: Vec::new(),
            all: Some(context),
            impact_at: ImpactAt::AfterFirst(0.0),
            growth: Growth::Whole,
            light: Light::Follow,
            added: Vec::new(),
            replaces: false,
        })
    });
    match bag.and_then(|bag| bag.run(&AtomicBool::new(false), || ())) {
        Ok(Some(report)) => Ok(report),
        Ok(None) => panic!("nobody stopped it"),
        Err(error) => Err(error.to_string()),
    }
}

fn is_one_line(message: &str) {
    assert!(
        !message.contains(char::is_control),
        "a message that is not one printable line: {message:?}"
    );
}
