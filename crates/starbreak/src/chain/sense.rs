//! What a sensor with a fault makes of an image.

use image::{DynamicImage, GrayImage, ImageBuffer, Pixel};
use starbreak_optics::OpticsError;
use starbreak_optics::srgb::{decode8, decode16, encode8, encode16};
use starbreak_sensor::{Light, Moment, Sensor};

use crate::Error;

/// A sample of an image.
trait Code: Copy + PartialEq {
    fn light(self) -> f32;
    fn of_light(light: f32) -> Self;
}

impl Code for u8 {
    fn light(self) -> f32 {
        decode8(self)
    }

    fn of_light(light: f32) -> Self {
        encode8(light)
    }
}

impl Code for u16 {
    fn light(self) -> f32 {
        decode16(self)
    }

    fn of_light(light: f32) -> Self {
        encode16(light)
    }
}

/// Puts an image before a sensor, in place. Samples whose light does not change keep their codes; alpha stays.
///
/// # Errors
/// [`Error::Optics`] for an image of 32-bit samples.
pub(super) fn sense(sensor: &Sensor, image: &mut DynamicImage, at: Moment) -> Result<(), Error> {
    match image {
        DynamicImage::ImageLuma8(image) => samples(sensor, image, at),
        DynamicImage::ImageLumaA8(image) => samples(sensor, image, at),
        DynamicImage::ImageRgb8(image) => samples(sensor, image, at),
        DynamicImage::ImageRgba8(image) => samples(sensor, image, at),
        DynamicImage::ImageLuma16(image) => samples(sensor, image, at),
        DynamicImage::ImageLumaA16(image) => samples(sensor, image, at),
        DynamicImage::ImageRgb16(image) => samples(sensor, image, at),
        DynamicImage::ImageRgba16(image) => samples(sensor, image, at),
        other => Err(OpticsError::ImageMode {
            mode: format!("{:?}", other.color()),
        }
        .into()),
    }
}

fn samples<P>(
    sensor: &Sensor,
    image: &mut ImageBuffer<P, Vec<P::Subpixel>>,
    at: Moment,
) -> Result<(), Error>
where
    P: Pixel,
    P::Subpixel: Code,
{
    let n_channels = usize::from(P::CHANNEL_COUNT);
    let n_colors = if n_channels < 3 { 1 } else { 3 };
    let size = (image.width() as usize, image.height() as usize);
    let codes: &mut [P::Subpixel] = image;
    let pixels = codes.chunks_exact(n_channels);
    let values = pixels.flat_map(|pixel| &pixel[..n_colors]);
    let values = values.map(|code| code.light()).collect();
    let Ok(mut light) = Light::new(size, n_colors, values) else {
        // An image without pixels.
        return Ok(());
    };
    sensor.over(&mut light, at);
    let pixels = codes.chunks_exact_mut(n_channels);
    let values = pixels.flat_map(|pixel| &mut pixel[..n_colors]);
    for (code, after) in values.zip(light.values()) {
        if code.light().to_bits() != after.to_bits() {
            *code = P::Subpixel::of_light(*after);
        }
    }
    Ok(())
}

/// 255 where a sensor reaches a frame, added to a region.
pub(super) fn add_region(sensor: &Sensor, region: &mut GrayImage) {
    let size = (region.width() as usize, region.height() as usize);
    for (code, is_reached) in region.iter_mut().zip(sensor.reach(size)) {
        if is_reached {
            *code = 255;
        }
    }
}
