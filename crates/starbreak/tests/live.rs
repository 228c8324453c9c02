//! Chains over frames where these lie: the codes of images, in any order of colors, and nothing beside them.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::sync::Arc;

use image::{DynamicImage, RgbImage};
use starbreak::optics::{Channels, FrameMut, OpticsError};
use starbreak::{Assignment, Chain, Error, Live, Recipe, Seed};

const SIZE: (u32, u32) = (130, 70);

/// Bytes between the rows of a frame, which are nobody's.
const PADDING: usize = 7;

/// A street of sorts: bright above, dark below, nowhere flat.
fn picture(shift: u32) -> RgbImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let code = |step: u32| {
            let above = if y < 30 { 150 } else { 40 };
            u8::try_from(above + (x * step + y * 5 + shift) % 97).unwrap()
        };
        image::Rgb([code(3), code(7), code(2)])
    })
}

/// What works where pixels lie, and what needs a frame as a whole.
fn chains() -> Vec<(&'static str, Chain)> {
    [
        ("windshield-star", &["fracture.mesh=fast"][..]),
        (
            "windshield-star",
            &["fracture.mesh=fast", "optics.noise_shot=0.001"],
        ),
        (
            "windshield-star",
            &["fracture.mesh=fast", "optics.veiling_glare=0.1"],
        ),
        (
            "windshield-star",
            &["fracture.mesh=fast", "camera.focus_distance_m=short"],
        ),
        (
            "paper",
            &["fracture.particles=300", "fracture.neighbour_radius_px=20"],
        ),
        ("rain", &[]),
        ("frosted", &[]),
        ("glare", &[]),
        ("noise", &[]),
    ]
    .into_iter()
    .map(|(preset, set)| {
        let mut recipe = Recipe::preset(preset).unwrap();
        let set: Vec<_> = set
            .iter()
            .map(|text| Assignment::parse(text).unwrap())
            .collect();
        recipe.adjust(None, &set).unwrap();
        let chain = Chain::of(&recipe.settings().unwrap(), SIZE, Seed(5)).unwrap();
        (preset, chain)
    })
    .collect()
}

/// The bytes of a picture in an order of colors, with alpha 9, rows padded by 200.
fn bytes_of(picture: &RgbImage, channels: Channels) -> Vec<u8> {
    let mut bytes = Vec::new();
    for row in picture.rows() {
        for pixel in row {
            let [r, g, b] = pixel.0;
            match channels {
                Channels::Gray => bytes.push(g),
                Channels::Rgb => bytes.extend([r, g, b]),
                Channels::Bgr => bytes.extend([b, g, r]),
                Channels::Rgba => bytes.extend([r, g, b, 9]),
                Channels::Bgra => bytes.extend([b, g, r, 9]),
            }
        }
        bytes.extend([200; PADDING]);
    }
    bytes
}

fn frame_of(bytes: &mut [u8], channels: Channels) -> FrameMut<'_> {
    let n = SIZE.0 as usize * channels.n_samples() + PADDING;
    FrameMut::of_rows(bytes.chunks_exact_mut(n).collect(), SIZE.0, channels).unwrap()
}

#[test]
fn a_frame_gets_the_codes_of_the_image() {
    for (preset, chain) in chains() {
        let chain = Arc::new(chain);
        for channels in Channels::ALL {
            let mut live = Live::of(Arc::clone(&chain));
            for (shift, seed) in [(0, 3), (20, 4), (20, 4)] {
                let before = picture(shift);
                let mut image = match channels {
                    Channels::Gray => {
                        let green = before.pixels().map(|pixel| pixel.0[1]).collect();
                        image::GrayImage::from_raw(SIZE.0, SIZE.1, green)
                            .unwrap()
                            .into()
                    }
                    _ => DynamicImage::from(before.clone()),
                };
                chain.over(&mut image, Seed(seed)).unwrap();
                let expected = bytes_of(&image.to_rgb8(), channels);
                let mut bytes = bytes_of(&before, channels);
                let mut frame = frame_of(&mut bytes, channels);
                live.over(&mut frame, Seed(seed)).unwrap();
                let off = bytes.iter().zip(&expected).filter(|(a, b)| a != b).count();
                assert_eq!(off, 0, "{preset}, {channels:?}, frame {shift}");
                assert_ne!(bytes, bytes_of(&before, channels), "{preset}: it shows");
            }
        }
    }
}

#[test]
fn one_light_is_kept_for_all_frames() {
    let (_, chain) = chains().swap_remove(0);
    let chain = Arc::new(chain);
    let light = chain.light_of(&picture(0).into()).unwrap();
    let mut live = Live::of(Arc::clone(&chain));
    live.set_environment(Some(light));
    for shift in [0, 60] {
        let mut expected = DynamicImage::from(picture(shift));
        let lit = chain.under(Some(&light)).unwrap();
        lit.over(&mut expected, Seed(1)).unwrap();
        let mut bytes = bytes_of(&picture(shift), Channels::Bgr);
        live.over(&mut frame_of(&mut bytes, Channels::Bgr), Seed(1))
            .unwrap();
        let expected = bytes_of(&expected.to_rgb8(), Channels::Bgr);
        assert!(bytes == expected, "frame {shift}");
    }
    live.set_environment(None);
    let mut own = bytes_of(&picture(60), Channels::Bgr);
    live.over(&mut frame_of(&mut own, Channels::Bgr), Seed(1))
        .unwrap();
    let mut expected = DynamicImage::from(picture(60));
    chain.over(&mut expected, Seed(1)).unwrap();
    let expected = bytes_of(&expected.to_rgb8(), Channels::Bgr);
    assert!(own == expected, "its own light again");
}

#[test]
fn a_frame_of_another_size_is_refused_and_stays() {
    for (preset, chain) in chains() {
        let mut live = Live::of(Arc::new(chain));
        let mut bytes = vec![90; 60 * 50 * 3];
        let mut frame = FrameMut::of_bytes(&mut bytes, (60, 50), Channels::Rgb).unwrap();
        let refused = live.over(&mut frame, Seed(1));
        let of_size = |error: &Error| {
            matches!(
                error,
                Error::Optics(OpticsError::SizeMismatch { width: 60, .. })
            )
        };
        assert!(
            refused.as_ref().is_err_and(of_size),
            "{preset}: {refused:?}"
        );
        assert!(bytes.iter().all(|code| *code == 90), "{preset}: it stays");
        let mut good = bytes_of(&picture(0), Channels::Rgb);
        live.over(&mut frame_of(&mut good, Channels::Rgb), Seed(1))
            .unwrap();
    }
}
