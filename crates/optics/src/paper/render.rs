//! Far focus and short focus over any 8-bit or 16-bit image.

use image::DynamicImage;
use starbreak_glass::CrackNetwork;

use super::canvas::blend_and_blur;
use super::params::PaperOptics;
use super::shading::crack_energies;
use crate::coverage::{Coverage, Line, gray_image};
use crate::{Masks, OpticsError, View};

/// Renders the full-grown network over the image, in place. See [`render_at`].
///
/// # Errors
/// As for [`render_at`].
pub fn render(
    image: &mut DynamicImage,
    network: &CrackNetwork,
    view: &View,
    optics: &PaperOptics,
) -> Result<Masks, OpticsError> {
    render_at(image, network, view, f64::INFINITY, optics)
}

/// Renders the network as far as it has grown at `time` (in the unit of its arrival column) over
/// the image, in place: [`draw`], then [`composite`].
///
/// # Errors
/// As for [`composite`].
pub fn render_at(
    image: &mut DynamicImage,
    network: &CrackNetwork,
    view: &View,
    time: f64,
    optics: &PaperOptics,
) -> Result<Masks, OpticsError> {
    optics.check()?;
    let drawn = draw(network, view, time, optics);
    composite(image, &drawn, optics)
}

/// The cracks as far as they have grown at `time`, drawn over the frame of the view: coverage M,
/// and E(L_r)/S of each pixel as its weight.
#[must_use]
pub fn draw(network: &CrackNetwork, view: &View, time: f64, optics: &PaperOptics) -> Coverage {
    let (width, height) = view.size();
    let energies = crack_energies(network, view, optics);
    let margin = optics.reach_px();
    let lines = network.grown_at(time).filter_map(|(idx, ends)| {
        Some(Line {
            ends: view.visible(ends, margin)?,
            weight: energies[idx],
        })
    });
    Coverage::of_lines(width, height, optics.line_width_px, lines)
}

/// Blends drawn cracks into the image, in place.
///
/// Far focus: the crack is blurred over the sharp scene, I·(1 − G∗M) + G∗(M·I_c); with
/// [`CrackAndScene`](super::FarFocusBlur::CrackAndScene) the two are blurred together, G∗(I·(1 − M) + M·I_c). Either
/// way only where a crack pixel lies within half the kernel; all else stays as it is, to the
/// byte. Short focus: (G∗I)·(1 − M) + M·I_c over the whole frame. Where nothing is broken the
/// image stays as it is, but for that blur, which is the camera's. Alpha is never changed.
///
/// # Errors
/// [`OpticsError`] for a parameter out of range, an image without pixels or of another size than
/// the drawing, or one whose samples are floating point.
///
/// # Limits
/// Code values are mixed as the paper mixes them, without regard to the gamma of the image.
pub fn composite(
    image: &mut DynamicImage,
    drawn: &Coverage,
    optics: &PaperOptics,
) -> Result<Masks, OpticsError> {
    optics.check()?;
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        return Err(OpticsError::EmptyImage { width, height });
    }
    let size = (width as usize, height as usize);
    if drawn.size() != size {
        let (drawn_width, drawn_height) = drawn.size();
        return Err(OpticsError::SizeMismatch {
            width,
            height,
            drawn_width,
            drawn_height,
        });
    }
    let region = match image {
        DynamicImage::ImageLuma8(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [1, 0], drawn, optics)
        }
        DynamicImage::ImageLumaA8(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [1, 1], drawn, optics)
        }
        DynamicImage::ImageRgb8(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [3, 0], drawn, optics)
        }
        DynamicImage::ImageRgba8(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [3, 1], drawn, optics)
        }
        DynamicImage::ImageLuma16(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [1, 0], drawn, optics)
        }
        DynamicImage::ImageLumaA16(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [1, 1], drawn, optics)
        }
        DynamicImage::ImageRgb16(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [3, 0], drawn, optics)
        }
        DynamicImage::ImageRgba16(buffer) => {
            blend_and_blur(buffer.as_mut(), size, [3, 1], drawn, optics)
        }
        other => {
            return Err(OpticsError::ImageMode {
                mode: format!("{:?}", other.color()),
            });
        }
    };
    let mut pixels = vec![0; size.0 * size.1];
    for y in 0..size.1 {
        for (start, end) in region.runs(y) {
            pixels[y * size.0 + start..y * size.0 + end].fill(255);
        }
    }
    Ok(Masks {
        region: gray_image(size.0, size.1, pixels),
        crack: drawn.to_mask(),
    })
}
