//! Animations decode to the frames they were made of.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use std::io::Cursor;

use common::rgb;
use image::{GrayImage, ImageBuffer, Luma, Pixel, PixelWithColorType, Rgb, RgbImage};
use png::{BlendOp, DisposeOp, FrameControl};
use proptest::prelude::*;
use starbreak_dataset::{AnimationParams, DatasetError, encode_animation};

/// The frames as a viewer composes them, and how each is stored.
struct Played<P: Pixel> {
    frames: Vec<ImageBuffer<P, Vec<P::Subpixel>>>,
    places: Vec<FrameControl>,
    control: png::AnimationControl,
}

fn play<P>(bytes: &[u8]) -> Played<P>
where
    P: Pixel<Subpixel = u8>,
{
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let control = reader.info().animation_control.unwrap();
    let (w, h) = reader.info().size();
    let mut canvas = ImageBuffer::<P, Vec<u8>>::new(w, h);
    let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
    let (mut frames, mut places) = (Vec::new(), Vec::new());
    for _ in 0..control.num_frames {
        let info = reader.next_frame(&mut buffer).unwrap();
        let place = *reader.info().frame_control().unwrap();
        assert_eq!(
            (place.blend_op, place.dispose_op),
            (BlendOp::Source, DisposeOp::None),
            "plain"
        );
        assert_eq!(
            (place.width, place.height),
            (info.width, info.height),
            "as announced"
        );
        let pixels = buffer.chunks_exact(usize::from(P::CHANNEL_COUNT));
        for (n, pixel) in (0..place.width * place.height).zip(pixels) {
            let at = (
                place.x_offset + n % place.width,
                place.y_offset + n / place.width,
            );
            canvas.put_pixel(at.0, at.1, *P::from_slice(pixel));
        }
        frames.push(canvas.clone());
        places.push(place);
    }
    reader.finish().unwrap();
    Played {
        frames,
        places,
        control,
    }
}

fn assert_round_trip<P>(frames: &[ImageBuffer<P, Vec<u8>>])
where
    P: Pixel<Subpixel = u8> + PixelWithColorType + PartialEq,
{
    let bytes = encode_animation(frames.iter().cloned(), &AnimationParams::default()).unwrap();
    let Played {
        frames: played,
        control,
        ..
    } = play::<P>(&bytes);
    assert_eq!(
        control.num_frames as usize,
        frames.len(),
        "number of frames"
    );
    assert!(played == frames, "the frames differ");
}

#[test]
fn only_what_changes_is_stored() {
    let first = rgb(40, 30);
    let mut second = first.clone();
    second.put_pixel(7, 5, Rgb([1, 2, 3]));
    second.put_pixel(11, 9, Rgb([4, 5, 6]));
    let mut third = second.clone();
    third.put_pixel(39, 29, Rgb([7, 8, 9]));
    let frames = [first, second.clone(), second, third];
    let params = AnimationParams {
        delay_ms: 33,
        last_delay_ms: 2000,
        n_plays: 3,
    };
    let bytes = encode_animation(frames.clone(), &params).unwrap();

    let Played {
        frames: played,
        places: controls,
        control,
    } = play::<Rgb<u8>>(&bytes);
    assert!(played == frames, "the frames differ");
    assert_eq!(
        (control.num_frames, control.num_plays),
        (4, 3),
        "frames and plays"
    );
    let places: Vec<_> = controls
        .iter()
        .map(|c| (c.x_offset, c.y_offset, c.width, c.height))
        .collect();
    assert_eq!(
        places,
        [(0, 0, 40, 30), (7, 5, 5, 5), (0, 0, 1, 1), (39, 29, 1, 1)],
        "rectangles"
    );
    let delays: Vec<_> = controls
        .iter()
        .map(|c| (c.delay_num, c.delay_den))
        .collect();
    assert_eq!(
        delays,
        [(33, 1000), (33, 1000), (33, 1000), (2000, 1000)],
        "delays"
    );
}

#[test]
fn one_frame_and_alpha() {
    assert_round_trip(&[rgb(3, 2)]);
    let alpha = |level| ImageBuffer::from_pixel(5, 5, image::Rgba([level, 0, 9, 255 - level]));
    assert_round_trip(&[alpha(3), alpha(200), alpha(0)]);
    let gray = |level| ImageBuffer::from_pixel(5, 5, image::LumaA([level, 7]));
    assert_round_trip(&[gray(3), gray(4)]);
}

#[test]
fn refusals() {
    let params = AnimationParams::default();
    let none = encode_animation(std::iter::empty::<RgbImage>(), &params).unwrap_err();
    assert!(matches!(none, DatasetError::NoFrames), "{none}");
    let empty = encode_animation([RgbImage::new(0, 4)], &params).unwrap_err();
    assert!(matches!(empty, DatasetError::ImageSize { .. }), "{empty}");
    let sizes = [
        RgbImage::new(4, 4),
        RgbImage::new(4, 4),
        RgbImage::new(4, 5),
    ];
    let message = encode_animation(sizes, &params).unwrap_err().to_string();
    assert!(
        message.starts_with("animation frame 2 is 4 x 5 px, but frame 0 is 4 x 4 px"),
        "{message}"
    );
}

proptest! {
    // Found cases become named tests, not files.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_changes_play_back_exactly(
        size in (1..20u32, 1..20u32),
        changes in prop::collection::vec(prop::collection::vec((0..20u32, 0..20u32, any::<u8>()), 0..4), 1..8),
    ) {
        let (w, h) = size;
        let mut gray = GrayImage::new(w, h);
        let mut color = RgbImage::new(w, h);
        let (mut grays, mut colors) = (Vec::new(), Vec::new());
        for change in changes {
            for (x, y, value) in change {
                gray.put_pixel(x % w, y % h, Luma([value]));
                color.put_pixel(x % w, y % h, Rgb([value, value / 2, 0]));
            }
            grays.push(gray.clone());
            colors.push(color.clone());
        }
        assert_round_trip(&grays);
        assert_round_trip(&colors);
    }
}
