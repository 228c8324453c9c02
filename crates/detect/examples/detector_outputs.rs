//! What a model gives for images, before and after it is read: `OUT/<stem>.<place>.npy` for each
//! output, and `OUT/<stem>.json` with rows of class, corners and score.
//!
//! `detector_outputs MODEL OUT [--onnxruntime LIBRARY [--cuda]] IMAGE…`
#![expect(clippy::print_stdout, reason = "an example says what it does")]

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use starbreak_dataset::{ImageLimits, encode_array, read_image};
use starbreak_detect::{Backend, Detector, DetectorOptions, Device};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args: Vec<String> = std::env::args().skip(1).collect();
    let mut options = DetectorOptions::default();
    let is_cuda = args.iter().any(|arg| arg == "--cuda");
    args.retain(|arg| arg != "--cuda");
    if let Some(place) = args.iter().position(|arg| arg == "--onnxruntime") {
        let library = PathBuf::from(args.remove(place + 1));
        args.remove(place);
        let device = if is_cuda { Device::Cuda } else { Device::Cpu };
        options.backend = Backend::OnnxRuntime { library, device };
    }
    let [model, out, images @ ..] = args.as_slice() else {
        return Err("detector_outputs MODEL OUT [--onnxruntime LIBRARY [--cuda]] IMAGE…".into());
    };
    let (model, out) = (Path::new(model), Path::new(out));
    fs::create_dir_all(out)?;
    let detector = Detector::open(model, &options)?;
    println!("{}: {}", detector.contract().name, detector.reason());
    for image in images {
        let path = Path::new(image);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let pixels = read_image(path, &ImageLimits::default())?.pixels.to_rgb8();
        let outputs = detector.raw_outputs(image, &pixels)?;
        for (place, output) in outputs.iter().enumerate() {
            let bytes = encode_array(&output.shape, &output.values)?;
            fs::write(out.join(format!("{stem}.{place}.npy")), bytes)?;
        }
        let found = detector.detect(image, &pixels)?;
        let rows: Vec<serde_json::Value> = found
            .detections
            .iter()
            .map(|d| serde_json::json!([d.class, d.corners_px, d.score]))
            .collect();
        fs::write(
            out.join(format!("{stem}.json")),
            serde_json::to_string(&rows)?,
        )?;
    }
    Ok(())
}
