use image::{ImageBuffer, Pixel, PixelWithColorType};
use png::{BitDepth, BlendOp, ColorType, DisposeOp};

use crate::ImageFormat;
use crate::encode::{check_size, png_error, samples_of, use_fast_compression};
use crate::error::DatasetError;

/// How an animation plays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AnimationParams {
    /// How long each frame but the last is shown, in ms. **Default** 40 (25 frames per second).
    pub delay_ms: u16,
    /// How long the last frame is shown, in ms. **Default** 1500.
    pub last_delay_ms: u16,
    /// How many times it plays, 0 for endlessly. **Default** 0.
    pub n_plays: u32,
}

impl Default for AnimationParams {
    fn default() -> Self {
        Self {
            delay_ms: 40,
            last_delay_ms: 1500,
            n_plays: 0,
        }
    }
}

/// The bytes of an animated PNG with these 8-bit frames, exact in every pixel.
///
/// After the first, only the rectangle that changes is stored. A viewer that knows no animation
/// shows the first frame.
///
/// # Errors
///
/// [`DatasetError::NoFrames`], [`DatasetError::FrameSize`] where a frame differs in size from the
/// first, [`DatasetError::ImageSize`] for frames without pixels.
///
/// # Limits
///
/// Holds the previous frame and all changed rectangles in memory until the end, because their
/// number stands at the beginning of the file.
///
/// # Example
///
/// ```
/// use image::{GrayImage, Luma};
/// use starbreak_dataset::{AnimationParams, encode_animation};
///
/// # fn main() -> Result<(), starbreak_dataset::DatasetError> {
/// let frames = (0..4).map(|level| GrayImage::from_pixel(8, 8, Luma([60 * level])));
/// let bytes = encode_animation(frames, &AnimationParams::default())?;
/// assert!(bytes.starts_with(b"\x89PNG"));
/// # Ok(())
/// # }
/// ```
pub fn encode_animation<P>(
    frames: impl IntoIterator<Item = ImageBuffer<P, Vec<u8>>>,
    params: &AnimationParams,
) -> Result<Vec<u8>, DatasetError>
where
    P: Pixel<Subpixel = u8> + PixelWithColorType,
{
    let mut frames = frames.into_iter();
    let first = frames.next().ok_or(DatasetError::NoFrames)?;
    let size_px = first.dimensions();
    check_size(ImageFormat::Png, size_px, i32::MAX.unsigned_abs())?;

    let mut changes = vec![Change::whole(&first)];
    let mut previous = first;
    for (idx, frame) in frames.enumerate() {
        if frame.dimensions() != size_px {
            return Err(DatasetError::FrameSize {
                frame_idx: idx + 1,
                width_px: frame.width(),
                height_px: frame.height(),
                expected_width_px: size_px.0,
                expected_height_px: size_px.1,
            });
        }
        changes.push(Change::between(&previous, &frame));
        previous = frame;
    }
    write_apng::<P>(size_px, &changes, params)
}

/// A rectangle of a frame with its samples.
struct Change {
    x_px: u32,
    y_px: u32,
    width_px: u32,
    height_px: u32,
    samples: Vec<u8>,
}

impl Change {
    fn whole<P: Pixel<Subpixel = u8>>(frame: &ImageBuffer<P, Vec<u8>>) -> Self {
        Self {
            x_px: 0,
            y_px: 0,
            width_px: frame.width(),
            height_px: frame.height(),
            samples: samples_of(frame).to_vec(),
        }
    }

    /// The smallest rectangle that holds all pixels in which `after` differs; at least one pixel.
    fn between<P: Pixel<Subpixel = u8>>(
        before: &ImageBuffer<P, Vec<u8>>,
        after: &ImageBuffer<P, Vec<u8>>,
    ) -> Self {
        let n_channels = usize::from(P::CHANNEL_COUNT);
        let n_row = after.width() as usize * n_channels;
        let rows = || {
            let before = samples_of(before).chunks_exact(n_row);
            before.zip(samples_of(after).chunks_exact(n_row))
        };

        let (mut x_px, mut y_px, mut x_end, mut y_end) = (u32::MAX, u32::MAX, 1, 1);
        for (y, (row_before, row_after)) in (0..).zip(rows()) {
            if row_before == row_after {
                continue;
            }
            let pixels = || {
                let before = row_before.chunks_exact(n_channels);
                (0..after.width()).zip(before.zip(row_after.chunks_exact(n_channels)))
            };
            let differs = |(x, (a, b)): (u32, (&[u8], &[u8]))| (a != b).then_some(x);
            x_px = x_px.min(pixels().find_map(differs).unwrap_or(0));
            x_end = x_end.max(pixels().rev().find_map(differs).unwrap_or(0) + 1);
            y_px = y_px.min(y);
            y_end = y + 1;
        }
        // Nothing has changed: the first pixel stands for the frame.
        if y_px == u32::MAX {
            (x_px, y_px) = (0, 0);
        }

        let columns = x_px as usize * n_channels..x_end as usize * n_channels;
        let samples = rows()
            .skip(y_px as usize)
            .take((y_end - y_px) as usize)
            .flat_map(|(_, row)| &row[columns.clone()])
            .copied()
            .collect();
        Self {
            x_px,
            y_px,
            width_px: x_end - x_px,
            height_px: y_end - y_px,
            samples,
        }
    }
}

fn write_apng<P: Pixel>(
    (width_px, height_px): (u32, u32),
    changes: &[Change],
    params: &AnimationParams,
) -> Result<Vec<u8>, DatasetError> {
    let n_frames = u32::try_from(changes.len()).map_err(|_| DatasetError::Encode {
        format: ImageFormat::Png,
        reason: "more than 2^32 frames".to_owned(),
    })?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width_px, height_px);
    encoder.set_color(match P::CHANNEL_COUNT {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    });
    encoder.set_depth(BitDepth::Eight);
    use_fast_compression(&mut encoder);
    encoder
        .set_animated(n_frames, params.n_plays)
        .map_err(png_error)?;
    encoder.set_blend_op(BlendOp::Source).map_err(png_error)?;
    encoder.set_dispose_op(DisposeOp::None).map_err(png_error)?;

    let mut writer = encoder.write_header().map_err(png_error)?;
    for (idx, change) in changes.iter().enumerate() {
        let delay_ms = if idx + 1 == changes.len() {
            params.last_delay_ms
        } else {
            params.delay_ms
        };
        // By way of the origin: the encoder checks each setter against the rectangle before.
        writer.set_frame_position(0, 0).map_err(png_error)?;
        writer
            .set_frame_dimension(change.width_px, change.height_px)
            .map_err(png_error)?;
        writer
            .set_frame_position(change.x_px, change.y_px)
            .map_err(png_error)?;
        writer.set_frame_delay(delay_ms, 1000).map_err(png_error)?;
        writer
            .write_image_data(&change.samples)
            .map_err(png_error)?;
    }
    writer.finish().map_err(png_error)?;
    Ok(bytes)
}
