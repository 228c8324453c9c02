//! What becomes of alpha: a lens that distorts moves it with what it cuts out.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::sync::Arc;

use image::{DynamicImage, ImageBuffer, Luma, LumaA, Rgba};
use starbreak::optics::srgb::decode16;
use starbreak::optics::{Channels, FrameMut};
use starbreak::{Chain, Live, Recipe, Seed};

const SIZE: (u32, u32) = (121, 86);

/// The last channel of images that have alpha.
pub(crate) fn alpha_of(image: &DynamicImage) -> Vec<u16> {
    match image {
        DynamicImage::ImageLumaA8(image) => image.pixels().map(|p| p[1].into()).collect(),
        DynamicImage::ImageRgba8(image) => image.pixels().map(|p| p[3].into()).collect(),
        DynamicImage::ImageLumaA16(image) => image.pixels().map(|p| p[1]).collect(),
        DynamicImage::ImageRgba16(image) => image.pixels().map(|p| p[3]).collect(),
        _ => Vec::new(),
    }
}

/// A white disc that is cut out of black, near a corner, in all modes that have alpha.
fn cut_outs() -> [DynamicImage; 4] {
    let is_disc = |x: u32, y: u32| x.abs_diff(90).pow(2) + y.abs_diff(62).pow(2) < 500;
    let (width, height) = SIZE;
    let of_8 = |x, y| if is_disc(x, y) { u8::MAX } else { 0 };
    let of_16 = |x, y| if is_disc(x, y) { u16::MAX } else { 0 };
    [
        ImageBuffer::from_fn(width, height, |x, y| LumaA([of_8(x, y); 2])).into(),
        ImageBuffer::from_fn(width, height, |x, y| Rgba([of_8(x, y); 4])).into(),
        ImageBuffer::from_fn(width, height, |x, y| LumaA([of_16(x, y); 2])).into(),
        ImageBuffer::from_fn(width, height, |x, y| Rgba([of_16(x, y); 4])).into(),
    ]
}

fn chain(set: &str) -> Chain {
    let mut recipe = Recipe::preset("distortion").unwrap();
    recipe.set("distortion.corner_percent=0").unwrap();
    recipe.set(set).unwrap();
    Chain::of(&recipe.settings().unwrap(), SIZE, Seed(1)).unwrap()
}

#[test]
fn a_cut_out_fits_what_a_distorted_frame_shows_in_all_modes() {
    for set in [
        "distortion.corner_percent=16",
        "distortion.corner_percent=-16",
        "distortion.shift_px=[3.5, -2.25]",
    ] {
        let chain = chain(set);
        for image in cut_outs() {
            let mut after = image.clone();
            chain.over(&mut after, Seed(1)).unwrap();
            let mode = image.color();
            assert_eq!(after.color(), mode, "{set}");
            let most = if mode.bits_per_pixel() > 32 || mode == image::ColorType::La16 {
                65_535.0
            } else {
                255.0
            };
            assert!(alpha_of(&after) != alpha_of(&image), "{set}, {mode:?}");
            // The light of white is 1, as is the share of what is opaque.
            let light = after.to_luma16();
            for (alpha, Luma([code])) in alpha_of(&after).into_iter().zip(light.pixels()) {
                let (alpha, light) = (f32::from(alpha) / most, decode16(*code));
                assert!(
                    (alpha - light).abs() < 0.006,
                    "{set}, {mode:?}: {alpha} of {light}"
                );
            }
        }
    }
}

#[test]
fn a_whole_frame_is_transparent_where_a_distorted_one_shows_nothing() {
    let mut image: DynamicImage =
        ImageBuffer::from_pixel(SIZE.0, SIZE.1, Rgba([90_u8, 80, 70, 255])).into();
    chain("distortion.shift_px=[5.0, 0.0]")
        .over(&mut image, Seed(1))
        .unwrap();
    for (x, _, pixel) in image.to_rgba8().enumerate_pixels() {
        let expected = if x < 5 { [0; 4] } else { [90, 80, 70, 255] };
        assert_eq!(pixel.0, expected, "column {x}");
    }
}

#[test]
fn a_frame_in_memory_gets_the_alpha_of_the_image() {
    let chain = Arc::new(chain("distortion.corner_percent=16"));
    let [_, image, ..] = cut_outs();
    let mut bytes = image.to_rgba8().into_raw();
    let mut after = image;
    chain.over(&mut after, Seed(1)).unwrap();
    let mut frame = FrameMut::of_bytes(&mut bytes, SIZE, Channels::Bgra).unwrap();
    Live::of(chain).over(&mut frame, Seed(1)).unwrap();
    assert!(bytes == after.to_rgba8().into_raw());
}
