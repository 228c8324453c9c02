//! The light that the physical optics takes from photos: `light PHOTO...`.
//!
//! Radiance in red, green and blue of the sky at the horizon, of the zenith and of the ground;
//! then, in green: irradiance of the sun, a white sheet under the sky alone, and the sky 60° up
//! over the ground. The camera is level with the field of view of KITTI's.
#![expect(clippy::print_stdout, reason = "a report is what this is for")]

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use starbreak::optics::environment::{Environment, EnvironmentParams, HemisphereWeights, Rgb};
use starbreak_dataset::{ImageLimits, read_image};

/// Focal length over width: 721.5 px for the 1242 px of KITTI.
const F_OVER_WIDTH: f64 = 721.5377 / 1242.0;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "{:>12} {:14} {:14} {:14}  sun  white  60°/gr        µs",
        "", "sky at 0°", "zenith", "ground"
    );
    let params = EnvironmentParams::default();
    for path in std::env::args_os().skip(1) {
        let path = Path::new(&path);
        let image = read_image(path, &ImageLimits::default())?.pixels;
        let f_px = f64::from(image.width()) * F_OVER_WIDTH;
        let light = Environment::estimate(&image, &params, f_px);
        let mut best = f64::INFINITY;
        for _ in 0..50 {
            let start = Instant::now();
            std::hint::black_box(Environment::estimate(&image, &params, f_px));
            best = best.min(start.elapsed().as_secs_f64() * 1e6);
        }
        let white = HemisphereWeights::facing(1.0).mean_radiance(&light);
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let sky = green(light.radiance(0.866));
        println!(
            "{name:>12.12} {} {} {} {:5.2} {:6.2} {:6.2} {best:9.1}",
            show(light.horizon_rgb),
            show(light.zenith_rgb),
            show(light.ground_rgb),
            green(light.sun_rgb),
            green(white),
            sky / green(light.ground_rgb),
        );
    }
    Ok(())
}

fn green(rgb: Rgb) -> f32 {
    rgb[1]
}

fn show([red, green, blue]: Rgb) -> String {
    format!("{red:4.2} {green:4.2} {blue:4.2}")
}
