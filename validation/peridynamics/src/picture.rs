//! Damage as a picture.

use std::fs::File;
use std::io::{BufWriter, Error, Result};
use std::path::Path;

/// Writes a damage field, row by row, as a gray PNG of `zoom` pixels per node; black is whole.
///
/// # Errors
/// If the file cannot be written.
pub fn write_damage(path: &Path, damage: &[f64], n_x: usize, zoom: usize) -> Result<()> {
    let n_y = damage.len() / n_x;
    let mut pixels = Vec::with_capacity(damage.len() * zoom * zoom);
    for y in 0..n_y * zoom {
        for x in 0..n_x * zoom {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "in 0..=255"
            )]
            pixels.push((damage[y / zoom * n_x + x / zoom] * 255.0).clamp(0.0, 255.0) as u8);
        }
    }
    let size = |n: usize| u32::try_from(n * zoom).map_err(Error::other);
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, size(n_x)?, size(n_y)?);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(&pixels)?;
    Ok(())
}
