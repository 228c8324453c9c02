//! The paper's visualization against its equations, computed here once more, slowly and plainly.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::{DynamicImage, ImageBuffer, Luma, LumaA, Rgb, RgbImage, Rgba};
use starbreak_glass::CrackNetwork;
use starbreak_optics::paper::{
    FarFocusBlur, Focus, Light, Normalization, PaperOptics, crack_energies, draw, render, render_at,
};
use starbreak_optics::{OpticsError, View};

const SIZE: (u32, u32) = (70, 50);

/// Four cracks: along x, along y, and both diagonals' directions.
fn network() -> CrackNetwork {
    CrackNetwork::from_json(
        r#"{"schema":"starbreak.crack-network/1","generator":{"name":"test","version":"1"},"model":"imported",
        "unit":"px","pane":{"width":70.0,"height":50.0},"impacts":[{"x":30.0,"y":20.0}],
        "nodes":{"x":[30.0,60.0,30.0,45.0,15.0],"y":[20.5,20.5,45.0,35.5,35.5]},
        "segments":{"from":[0,0,0,0],"to":[1,2,3,4],"kind":["radial","radial","radial","radial"],
        "arrival_us":[1.0,2.0,3.0,4.0]}}"#,
    )
    .unwrap()
}

/// The pane fills the frame.
fn view() -> View {
    View::stretched(&network().data().pane, SIZE)
}

/// A picture with detail everywhere.
fn picture() -> RgbImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let level =
            |k: u32| u8::try_from((x * 37 + y * 91 + k * 53 + (x * y) % 17 * 11) % 256).unwrap();
        Rgb([level(0), level(1), level(2)])
    })
}

fn optics(focus: Focus) -> PaperOptics {
    PaperOptics {
        focus,
        light: Light::Rgb([220.0, 180.0, 90.0]),
        ..PaperOptics::default()
    }
}

#[test]
fn the_energy_of_a_crack_is_the_mean_of_two_projections() {
    let plain = PaperOptics {
        normalization: Normalization::One,
        ..optics(Focus::Far)
    };
    let energies = crack_energies(&network(), &view(), &plain);
    let (a, t) = (plain.sun_azimuth_rad, plain.sun_zenith_rad);
    for (energy, [dx, dy]) in
        energies
            .iter()
            .zip([[30.0, 0.0], [0.0, 24.5], [15.0, 15.0], [-15.0, 15.0_f64]])
    {
        let length = dx.hypot(dy);
        let normal = [-dy / length, dx / length];
        let along = |angle: f64| (angle.cos() * normal[0] + angle.sin() * normal[1]).abs();
        let expected = f64::midpoint(along(a), along(t));
        assert!(
            (f64::from(*energy) - expected).abs() < 1e-6,
            "({dx}, {dy}): {energy} against {expected}"
        );
    }
    let sum: f32 = energies.iter().sum();
    let max = energies.iter().copied().fold(0.0, f32::max);
    for (normalization, divisor) in [
        (Normalization::Sum, sum),
        (Normalization::Max, max),
        (Normalization::Mean, sum / 4.0),
    ] {
        let normalized = crack_energies(
            &network(),
            &view(),
            &PaperOptics {
                normalization,
                ..plain
            },
        );
        for (energy, plain) in normalized.iter().zip(&energies) {
            assert!((energy * divisor - plain).abs() < 1e-6, "{normalization:?}");
        }
    }
}

/// The whole picture as real numbers: blended, blurred with reflected borders, by definition.
fn expected(image: &RgbImage, optics: &PaperOptics) -> Vec<[f64; 3]> {
    let drawn = draw(&network(), &view(), f64::INFINITY, optics);
    let (width, height) = (i64::from(SIZE.0), i64::from(SIZE.1));
    let at = |x: i64, y: i64| usize::try_from(y * width + x).unwrap();
    let Light::Rgb(light) = optics.light else {
        panic!("a light of known intensity")
    };
    let mut crack = vec![(0.0, 0.0); image.pixels().len()];
    for y in 0..SIZE.1 {
        for (x, covered, energy) in drawn.row(y as usize) {
            crack[(y * SIZE.0) as usize + x] = (f64::from(covered), f64::from(energy));
        }
    }
    let scene: Vec<[f64; 3]> = image.pixels().map(|pixel| pixel.0.map(f64::from)).collect();
    let blend = |scene: &[[f64; 3]]| -> Vec<[f64; 3]> {
        let pairs = scene.iter().zip(&crack);
        pairs
            .map(|(pixel, (m, e))| std::array::from_fn(|c| pixel[c] * (1.0 - m) + light[c] * e * m))
            .collect()
    };
    let reflect = |index: i64, n: i64| {
        let folded = index.rem_euclid(2 * (n - 1));
        folded.min(2 * (n - 1) - folded)
    };
    let radius = i64::from(optics.blur_kernel_px / 2);
    #[expect(clippy::cast_precision_loss, reason = "a kernel radius")]
    let weight = |k: i64| (-0.5 * (k as f64 / optics.blur_sigma_px).powi(2)).exp();
    let total: f64 = (-radius..=radius).map(weight).sum();
    let blur = |source: &[[f64; 3]]| -> Vec<[f64; 3]> {
        let mut out = vec![[0.0; 3]; source.len()];
        for y in 0..height {
            for x in 0..width {
                for j in -radius..=radius {
                    for i in -radius..=radius {
                        let from = source[at(reflect(x + i, width), reflect(y + j, height))];
                        let share = weight(i) * weight(j) / (total * total);
                        for c in 0..3 {
                            out[at(x, y)][c] += from[c] * share;
                        }
                    }
                }
            }
        }
        out
    };
    match optics.focus {
        Focus::Short => blend(&blur(&scene)),
        Focus::Far if optics.far_focus_blur == FarFocusBlur::Crack => {
            let veil: Vec<[f64; 3]> = crack.iter().map(|(m, e)| [*m, m * e, 0.0]).collect();
            let veil = blur(&veil);
            let pairs = scene.iter().zip(&veil);
            pairs
                .map(|(pixel, [m, e, _])| {
                    std::array::from_fn(|c| pixel[c] * (1.0 - m) + light[c] * e)
                })
                .collect()
        }
        Focus::Far => {
            let blurred = blur(&blend(&scene));
            let near = |x: i64, y: i64| {
                let rows = (y - radius).max(0)..=(y + radius).min(height - 1);
                rows.into_iter().any(|j| {
                    ((x - radius).max(0)..=(x + radius).min(width - 1))
                        .any(|i| crack[at(i, j)].0 > 0.0)
                })
            };
            let mut out = scene;
            for y in 0..height {
                for x in 0..width {
                    if near(x, y) {
                        out[at(x, y)] = blurred[at(x, y)];
                    }
                }
            }
            out
        }
    }
}

#[test]
fn both_focus_modes_are_their_definitions() {
    let modes = [
        (Focus::Far, FarFocusBlur::Crack),
        (Focus::Far, FarFocusBlur::CrackAndScene),
        (Focus::Short, FarFocusBlur::Crack),
    ];
    for (focus, far_focus_blur) in modes {
        for (blur_kernel_px, blur_sigma_px) in [(15, 2.6), (1, 2.6), (5, 0.9), (41, 9.0)] {
            let optics = PaperOptics {
                blur_kernel_px,
                blur_sigma_px,
                far_focus_blur,
                ..optics(focus)
            };
            let mut image = DynamicImage::ImageRgb8(picture());
            let masks = render(&mut image, &network(), &view(), &optics).unwrap();
            for ((pixel, expected), x) in image
                .to_rgb8()
                .pixels()
                .zip(expected(&picture(), &optics))
                .zip(0..)
            {
                for (level, expected) in pixel.0.iter().zip(expected) {
                    let off = (f64::from(*level) - expected).abs();
                    assert!(
                        off <= 0.51,
                        "{focus:?}, kernel {blur_kernel_px}, sample {x}: off by {off}"
                    );
                }
            }
            let outside = image
                .to_rgb8()
                .pixels()
                .zip(picture().pixels())
                .zip(masks.region.pixels())
                .all(|((after, before), region)| region.0[0] == 255 || after == before);
            assert!(outside, "{focus:?}: a pixel outside the region changed");
            let covered = masks
                .crack
                .pixels()
                .zip(masks.region.pixels())
                .all(|(crack, region)| crack.0[0] == 0 || region.0[0] == 255);
            assert!(covered, "{focus:?}: a crack outside the region");
        }
    }
}

#[test]
fn every_mode_is_rendered_alike_and_alpha_stays() {
    let optics = PaperOptics {
        light: Light::Rgb([160.0; 3]),
        ..optics(Focus::Far)
    };
    let gray = |x: u32, y: u32| u8::try_from((x * 37 + y * 91) % 256).unwrap();
    let run = |mut image: DynamicImage| {
        render(&mut image, &network(), &view(), &optics).unwrap();
        image
    };
    let l8 = run(DynamicImage::ImageLuma8(ImageBuffer::from_fn(
        SIZE.0,
        SIZE.1,
        |x, y| Luma([gray(x, y)]),
    )));
    let reference = l8.as_luma8().unwrap();
    let alpha = |x: u32, y: u32| u8::try_from((x + y) % 256).unwrap();
    let la8 = run(DynamicImage::ImageLumaA8(ImageBuffer::from_fn(
        SIZE.0,
        SIZE.1,
        |x, y| LumaA([gray(x, y), alpha(x, y)]),
    )));
    let rgba8 = run(DynamicImage::ImageRgba8(ImageBuffer::from_fn(
        SIZE.0,
        SIZE.1,
        |x, y| Rgba([gray(x, y), gray(x, y), gray(x, y), alpha(x, y)]),
    )));
    let l16 = run(DynamicImage::ImageLuma16(ImageBuffer::from_fn(
        SIZE.0,
        SIZE.1,
        |x, y| Luma([u16::from(gray(x, y)) * 257]),
    )));
    for (x, y, expected) in reference.enumerate_pixels() {
        let level = expected.0[0];
        assert_eq!(
            la8.as_luma_alpha8().unwrap().get_pixel(x, y).0,
            [level, alpha(x, y)],
            "grey and alpha"
        );
        assert_eq!(
            rgba8.as_rgba8().unwrap().get_pixel(x, y).0,
            [level, level, level, alpha(x, y)],
            "RGBA"
        );
        let fine = f64::from(l16.as_luma16().unwrap().get_pixel(x, y).0[0]) / 257.0;
        assert!(
            (fine - f64::from(level)).abs() <= 0.51,
            "16 bits: {fine} against {level}"
        );
    }
    let fine = l16
        .as_luma16()
        .unwrap()
        .pixels()
        .filter(|pixel| pixel.0[0] % 257 != 0)
        .count();
    assert!(fine > 100, "16-bit results use their low bits");
}

#[test]
fn the_mean_of_the_image_can_be_the_light() {
    let constant = RgbImage::from_pixel(SIZE.0, SIZE.1, Rgb([60, 90, 120]));
    let optics = PaperOptics {
        light: Light::ImageMean,
        normalization: Normalization::Max,
        ..optics(Focus::Short)
    };
    let mut image = DynamicImage::ImageRgb8(constant);
    render(&mut image, &network(), &view(), &optics).unwrap();
    let energies = crack_energies(&network(), &view(), &optics);
    // A pixel in the middle of the crack along x is covered in full.
    for (level, mean) in image
        .to_rgb8()
        .get_pixel(50, 20)
        .0
        .iter()
        .zip([60.0, 90.0, 120.0_f32])
    {
        assert!(
            (f32::from(*level) - mean * energies[0]).abs() <= 0.51,
            "{level} against {}",
            mean * energies[0]
        );
    }
}

#[test]
fn nothing_broken_changes_nothing_and_growth_ends_in_the_whole() {
    for focus in [Focus::Far, Focus::Short] {
        let mut image = DynamicImage::ImageRgb8(picture());
        let masks = render_at(&mut image, &network(), &view(), 0.0, &optics(focus)).unwrap();
        assert_eq!(
            image.to_rgb8() == picture(),
            focus == Focus::Far,
            "{focus:?}: before the impact only the lens changes the picture"
        );
        assert!(
            masks.region.pixels().all(|pixel| pixel.0[0] == 0),
            "{focus:?}: no region without a crack"
        );
        let (mut late, mut whole) = (
            DynamicImage::ImageRgb8(picture()),
            DynamicImage::ImageRgb8(picture()),
        );
        render_at(&mut late, &network(), &view(), 4.0, &optics(focus)).unwrap();
        render(&mut whole, &network(), &view(), &optics(focus)).unwrap();
        assert_eq!(late, whole, "{focus:?}: after the last arrival");
    }
}

#[test]
fn what_cannot_be_rendered_is_said() {
    let view_of = |width, height| View::stretched(&network().data().pane, (width, height));
    let mut float = DynamicImage::new_rgb32f(8, 8);
    assert!(
        matches!(
            render(&mut float, &network(), &view_of(8, 8), &optics(Focus::Far)),
            Err(OpticsError::ImageMode { .. })
        ),
        "float"
    );
    let mut empty = DynamicImage::new_rgb8(0, 4);
    assert!(
        matches!(
            render(&mut empty, &network(), &view_of(0, 4), &optics(Focus::Far)),
            Err(OpticsError::EmptyImage { .. })
        ),
        "empty"
    );
    let bad = [
        PaperOptics {
            line_width_px: 0.0,
            ..optics(Focus::Far)
        },
        PaperOptics {
            blur_sigma_px: f64::NAN,
            ..optics(Focus::Far)
        },
        PaperOptics {
            blur_kernel_px: 14,
            ..optics(Focus::Far)
        },
        PaperOptics {
            sun_azimuth_rad: f64::INFINITY,
            ..optics(Focus::Far)
        },
        PaperOptics {
            light: Light::Rgb([0.0, -1.0, 0.0]),
            ..optics(Focus::Far)
        },
    ];
    for optics in bad {
        let mut image = DynamicImage::ImageRgb8(picture());
        assert!(
            render(&mut image, &network(), &view(), &optics).is_err(),
            "{optics:?} was accepted"
        );
        assert_eq!(image.to_rgb8(), picture(), "and the image is as it was");
    }
}
