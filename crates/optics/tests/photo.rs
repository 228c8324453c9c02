//! A photograph of broken glass over a scene, against closed forms.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::{DynamicImage, GrayImage, ImageBuffer, Luma, Rgb, RgbImage, Rgba, RgbaImage};
use starbreak_glass::Pane;
use starbreak_optics::environment::Environment;
use starbreak_optics::lens::Lens;
use starbreak_optics::paper::{Focus, Light, PaperOptics, composite};
use starbreak_optics::photo::{
    Background, Photo, PhotoParams, PhotoPattern, Placement, PlacementRange, bake, draw,
};
use starbreak_optics::physical::{Glass, Overlay, PhysicalOptics};
use starbreak_optics::{Camera, OpticsError, View};
use starbreak_seed::Seed;

const SIZE: (u32, u32) = (150, 110);

const F_PX: f64 = 120.0;

fn view(distance_m: f64, rake_deg: f64) -> View {
    let camera = Camera {
        f_px: F_PX,
        distance_m,
        rake_rad: rake_deg.to_radians(),
        axis_at_mm: [700.0, 400.0],
    };
    View::through(&camera, SIZE).unwrap()
}

/// Everything in focus, glass and scene.
fn sharp() -> PhysicalOptics {
    with_lens(Lens {
        f_number: 128.0,
        focus_m: 0.2,
        scene_m: 0.2,
        ..Lens::default()
    })
}

/// The scene in focus, the glass out of it by a disc of this radius, px, on a pane at 0.2 m.
fn far_focus(radius_px: f64) -> PhysicalOptics {
    let aperture_m = 2.0 * radius_px / F_PX / (1.0 / 0.2 - 1.0 / 20.0);
    with_lens(Lens {
        focal_length_m: 8.0 * aperture_m,
        f_number: 8.0,
        ..Lens::default()
    })
}

fn with_lens(lens: Lens) -> PhysicalOptics {
    PhysicalOptics {
        lens,
        // So thin that the disc is that of the lens formula.
        glass: Glass {
            thickness_mm: 0.05,
            interlayer_mm: 0.0,
            inner_ply_mm: 0.0,
            ..Glass::default()
        },
        ..PhysicalOptics::default()
    }
}

fn light(level: f32) -> Environment {
    Environment {
        horizon_rgb: [level; 3],
        zenith_rgb: [level; 3],
        ground_rgb: [level; 3],
        cabin_low_rgb: [0.0; 3],
        cabin_high_rgb: [0.0; 3],
        sun_rgb: [5.0; 3],
    }
}

/// Linear light of a code over the greatest code \[IEC61966\].
fn decoded(code: f64) -> f64 {
    if code <= 0.040_45 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}

fn encoded(light: f64) -> f64 {
    if light <= 0.040_45 / 12.92 {
        light * 12.92
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    }
}

/// Rays of every brightness from the middle, in color, the border free of them.
fn star(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let (u, v) = (
            f64::from(x) + 0.5 - f64::from(width) * 0.5,
            f64::from(y) + 0.5 - f64::from(height) * 0.5,
        );
        let inside = u.abs() < f64::from(width) * 0.45 && v.abs() < f64::from(height) * 0.45;
        let ray = (v.atan2(u) * 7.0).sin().abs() > 0.93 && inside;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a code"
        )]
        let level = |part: f64| (255.0 * part * (0.3 + 0.7 * (v.atan2(u) * 3.0).cos().abs())) as u8;
        if ray {
            Rgb([level(1.0), level(0.8), level(0.55)])
        } else {
            Rgb([0; 3])
        }
    })
}

fn photo(pixels: impl Into<DynamicImage>) -> Photo {
    Photo::new(pixels.into(), &PhotoParams::default()).unwrap()
}

fn exact(background: Background) -> PhotoParams {
    PhotoParams {
        background: Some(background),
        floor: 0.0,
    }
}

/// Laid over the whole frame.
fn whole(photo: &Photo, optics: &PhysicalOptics, rake_deg: f64) -> PhotoPattern {
    let placement = Placement::cover(photo.size(), SIZE);
    bake(photo, &placement, &view(0.2, rake_deg), optics).unwrap()
}

fn overlay(photo: &Photo, optics: &PhysicalOptics, environment: &Environment) -> Overlay {
    whole(photo, optics, 0.0)
        .light(environment, 1.0, optics)
        .unwrap()
}

/// A picture with detail everywhere.
fn picture() -> DynamicImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let level =
            |k: u32| u8::try_from((x * 37 + y * 91 + k * 53 + (x * y) % 17 * 11) % 256).unwrap();
        Rgb([level(0), level(1), level(2)])
    })
    .into()
}

#[test]
fn glass_lit_like_an_even_scene_is_not_seen() {
    let star = star(300, 220);
    let cut_out = RgbaImage::from_fn(300, 220, |x, y| {
        Rgba([255, 255, 255, star.get_pixel(x, y).0[1]])
    });
    for photo in [photo(star.clone()), photo(cut_out)] {
        for radius_px in [0.4, 3.0, 17.0] {
            for rake_deg in [-40.0, 0.0, 60.0] {
                let optics = far_focus(radius_px);
                for code in [2000_u16, 30_000, 65_535] {
                    #[expect(clippy::cast_possible_truncation, reason = "light as f32")]
                    let level = decoded(f64::from(code) / 65535.0) as f32;
                    let pattern = whole(&photo, &optics, rake_deg);
                    let overlay = pattern.light(&light(level), 1.0, &optics).unwrap();
                    let mut image: DynamicImage =
                        ImageBuffer::from_pixel(SIZE.0, SIZE.1, Rgb([code; 3])).into();
                    overlay.apply(&mut image, Seed(0)).unwrap();
                    let most = image
                        .to_rgb16()
                        .iter()
                        .map(|&found| found.abs_diff(code))
                        .max();
                    assert!(
                        most.unwrap() <= 64,
                        "off by {most:?} of 65535 at {code}, {radius_px} px, {rake_deg}°"
                    );
                    let region = overlay.region();
                    assert!(
                        region.iter().filter(|level| **level > 0).count() > 500,
                        "it is there all the same"
                    );
                }
            }
        }
    }
}

#[test]
fn a_disc_takes_away_as_much_as_the_glass_does() {
    let mut spot = GrayImage::from_pixel(SIZE.0, SIZE.1, Luma([0]));
    for (x, y, code) in [(75, 55, 255), (76, 55, 180), (70, 50, 90)] {
        spot.put_pixel(x, y, Luma([code]));
    }
    let photo = Photo::new(spot.into(), &exact(Background::Black)).unwrap();
    let sum = |radius_px: f64| -> f64 {
        let optics = far_focus(radius_px);
        let maps = overlay(&photo, &optics, &light(0.7)).maps();
        let lost: f64 = maps.attenuation.iter().copied().map(f64::from).sum();
        let sent: f64 = maps.added.iter().map(|rgb| f64::from(rgb[1])).sum();
        assert!(
            (sent / lost / 0.7 - 1.0).abs() < 1e-3,
            "light follows opacity: {sent} of {lost}"
        );
        lost
    };
    let expected = 1.0 + decoded(180.0 / 255.0) + decoded(90.0 / 255.0);
    for (radius_px, tolerance) in [(0.01, 1e-5), (1.0, 1e-4), (5.3, 1e-3), (9.0, 5e-3)] {
        let found = sum(radius_px);
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "{found}, not {expected}, at {radius_px} px"
        );
    }
}

#[test]
fn the_disc_follows_the_distance_of_the_glass_row_by_row() {
    let (rake_deg, radius_px) = (60.0_f64, 4.0);
    let optics = far_focus(radius_px);
    let (sin, cos) = rake_deg.to_radians().sin_cos();
    for y in [25_u32, 55, 85] {
        let mut spot = GrayImage::from_pixel(SIZE.0, SIZE.1, Luma([0]));
        spot.put_pixel(75, y, Luma([255]));
        let photo = Photo::new(spot.into(), &exact(Background::Black)).unwrap();
        let pattern = whole(&photo, &optics, rake_deg);
        let maps = pattern.light(&light(1.0), 1.0, &optics).unwrap().maps();
        let (mut sum, mut square) = (0.0, 0.0);
        for (k, lost) in (0_u32..).zip(&maps.attenuation) {
            let dx = f64::from(k % SIZE.0) - 75.0;
            sum += f64::from(*lost);
            square += f64::from(*lost) * dx * dx;
        }
        // z = d cos ρ/(cos ρ − v sin ρ); ⟨x²⟩ = R²/4, and 1/12 of the pixel.
        let v = (f64::from(y) + 0.5 - f64::from(SIZE.1) * 0.5) / F_PX;
        let z = 0.2 * cos / (cos - v * sin);
        let disc = optics.lens.circle_of_confusion_px(F_PX, z) * 0.5;
        let expected = disc * disc / 4.0 + 1.0 / 12.0;
        let found = square / sum;
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "row {y}: ⟨x²⟩ = {found}, not {expected}"
        );
    }
}

#[test]
fn where_there_is_no_glass_no_byte_changes() {
    let half = RgbaImage::from_fn(SIZE.0, SIZE.1, |x, _| {
        Rgba([200, 250, 90, if x < 75 { 140 } else { 0 }])
    });
    let optics = sharp();
    let overlay = overlay(&photo(half), &optics, &light(0.4));
    let (before, mut after) = (picture(), picture());
    overlay.apply(&mut after, Seed(0)).unwrap();
    let (before, after) = (before.to_rgb8(), after.to_rgb8());
    let mut n_changed = 0;
    for (x, y, pixel) in after.enumerate_pixels() {
        if x >= 75 {
            assert_eq!(before.get_pixel(x, y), pixel, "pixel ({x}, {y})");
            assert_eq!(overlay.region().get_pixel(x, y).0, [0], "region");
        } else {
            n_changed += u32::from(before.get_pixel(x, y) != pixel);
        }
    }
    assert!(n_changed > 8000, "the other half changes: {n_changed}");
}

#[test]
fn each_background_gives_its_own_closed_form() {
    let gray = |x: u32, y: u32| u8::try_from((x * 13 + y * 29) % 256).unwrap();
    let black = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| Luma([gray(x, y)]));
    let alpha = RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| Rgba([210, 160, 90, gray(x, y)]));
    let own = [210.0, 160.0, 90.0].map(|code: f64| decoded(code / 255.0));
    let white = f64::from(0.35_f32);
    type Form<'a> = &'a dyn Fn(f64, f64, usize) -> f64;
    let forms: [(DynamicImage, Background, Form<'_>); 3] = [
        (black.clone().into(), Background::Black, &|scene, p, _| {
            scene * (1.0 - decoded(p)) + white * decoded(p)
        }),
        (black.into(), Background::White, &|scene, p, _| {
            scene * decoded(p)
        }),
        (alpha.into(), Background::Alpha, &|scene, p, c| {
            scene * (1.0 - p) + white * p * own[c]
        }),
    ];
    for (pixels, background, form) in forms {
        // The border of this picture is no background: it is taken as it is where its median is
        // not near one.
        let mut pixels = pixels;
        frame_with(&mut pixels, background);
        let photo = Photo::new(pixels, &exact(background)).unwrap();
        let optics = sharp();
        let overlay = overlay(&photo, &optics, &light(0.35));
        let mut image = picture();
        overlay.apply(&mut image, Seed(0)).unwrap();
        let (before, after) = (picture().to_rgb8(), image.to_rgb8());
        for (x, y, pixel) in after.enumerate_pixels() {
            if x == 0 || y == 0 || x + 1 == SIZE.0 || y + 1 == SIZE.1 {
                continue;
            }
            let p = f64::from(gray(x, y)) / 255.0;
            for (c, &found) in pixel.0.iter().enumerate() {
                let scene = decoded(f64::from(before.get_pixel(x, y).0[c]) / 255.0);
                let expected = 255.0 * encoded(form(scene, p, c).min(1.0));
                assert!(
                    (f64::from(found) - expected).abs() < 0.6,
                    "{background:?} at ({x}, {y}), {c}: {found}, not {expected}"
                );
            }
        }
    }
}

/// A border of the very background.
fn frame_with(pixels: &mut DynamicImage, background: Background) {
    let level = if background == Background::White {
        255
    } else {
        0
    };
    if let DynamicImage::ImageLuma8(image) = pixels {
        let (width, height) = image.dimensions();
        for (x, y, pixel) in image.enumerate_pixels_mut() {
            if x == 0 || y == 0 || x + 1 == width || y + 1 == height {
                *pixel = Luma([level]);
            }
        }
    }
}

#[test]
fn a_mirrored_placement_gives_the_mirror_image() {
    let photo = photo(star(321, 200));
    let optics = far_focus(6.0);
    let base = Placement {
        left_px: 13.7,
        top_px: -9.0,
        width_px: 201.3,
        height_px: 147.0,
        flip_horizontal: false,
        flip_vertical: false,
    };
    let maps = |placement: Placement| {
        let pattern = bake(&photo, &placement, &view(0.2, 0.0), &optics).unwrap();
        let coverage = pattern.coverage();
        (pattern.light(&light(0.5), 1.0, &optics).unwrap(), coverage)
    };
    let (plain, plain_mask) = maps(base);
    for (flip_horizontal, flip_vertical) in [(true, false), (false, true), (true, true)] {
        let (flipped, mask) = maps(Placement {
            flip_horizontal,
            flip_vertical,
            ..base
        });
        let (a, b) = (plain.maps(), flipped.maps());
        let mut worst = 0.0_f32;
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let from = (
                    if flip_horizontal { SIZE.0 - 1 - x } else { x },
                    if flip_vertical { SIZE.1 - 1 - y } else { y },
                );
                let at = |(x, y): (u32, u32)| (y * SIZE.0 + x) as usize;
                worst = worst.max((a.attenuation[at(from)] - b.attenuation[at((x, y))]).abs());
                assert_eq!(
                    plain_mask.get_pixel(from.0, from.1),
                    mask.get_pixel(x, y),
                    "the crack mask is the mirror image, to the bit"
                );
            }
        }
        // The discs are summed from left to right.
        assert!(worst < 1e-5, "{worst}");
    }
}

#[test]
fn shrinking_takes_the_mean_light_and_enlarging_lies_between() {
    // 3 × 3 px of the photo per px of the frame.
    let (width, height) = (SIZE.0 * 3, SIZE.1 * 3);
    let code = |x: u32, y: u32| u8::try_from((x * 71 + y * 113 + x * y) % 256).unwrap();
    let large = RgbaImage::from_fn(width, height, |x, y| Rgba([255, 255, 255, code(x, y)]));
    let optics = sharp();
    let maps = overlay(&photo(large), &optics, &light(1.0)).maps();
    for (x, y) in [(0, 0), (149, 109), (10, 77), (80, 3)] {
        let sum: u32 = (0..9)
            .map(|k| u32::from(code(3 * x + k % 3, 3 * y + k / 3)))
            .sum();
        let found = maps.attenuation[(y * SIZE.0 + x) as usize];
        let expected = f64::from(sum) / 9.0 / 255.0;
        assert!(
            (f64::from(found) - expected).abs() < 1e-5,
            "({x}, {y}): {found}, not {expected}"
        );
    }
    // Two pixels over the frame: a straight line between their middles.
    let small = RgbaImage::from_fn(2, 1, |x, _| Rgba([255, 255, 255, [0, 255][x as usize]]));
    let small = photo(small);
    let placement = Placement {
        left_px: 0.0,
        top_px: 0.0,
        width_px: 2.0,
        height_px: 1.0,
        flip_horizontal: false,
        flip_vertical: false,
    };
    let pattern = bake(&small, &placement, &view(0.2, 0.0), &optics).unwrap();
    let maps = pattern.light(&light(1.0), 1.0, &optics).unwrap().maps();
    for x in 0..SIZE.0 {
        let at = (f64::from(x) + 0.5) * 2.0 / f64::from(SIZE.0);
        let mut expected = (at - 0.5).clamp(0.0, 1.0);
        if at > 1.5 {
            // Beyond the photo there is no glass.
            expected = 2.5 - at;
        }
        // Nor below it: the row's middle lies half a row under that of the photo.
        expected *= 1.0 - 0.5 / f64::from(SIZE.1);
        let found = f64::from(maps.attenuation[(55 * SIZE.0 + x) as usize]);
        assert!(
            (found - expected).abs() < 1e-4,
            "{x}: {found}, not {expected}"
        );
    }
}

#[test]
fn the_papers_optics_show_the_photographs_own_grey() {
    let star = star(SIZE.0, SIZE.1);
    let gray = image::imageops::grayscale(&star);
    let inverse = GrayImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        Luma([255 - gray.get_pixel(x, y).0[0]])
    });
    let alpha = RgbaImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        let code = gray.get_pixel(x, y).0[0];
        Rgba([code, code, code, if code > 0 { 255 } else { 0 }])
    });
    let optics = PaperOptics {
        focus: Focus::Far,
        blur_kernel_px: 1,
        light: Light::Rgb([255.0; 3]),
        ..PaperOptics::default()
    };
    for (pixels, background, scene) in [
        (DynamicImage::from(gray.clone()), Background::Black, 0_u8),
        (inverse.into(), Background::White, 255),
        (alpha.into(), Background::Alpha, 0),
    ] {
        let expected = if background == Background::White {
            pixels.to_luma8()
        } else {
            gray.clone()
        };
        let photo = Photo::new(pixels, &exact(background)).unwrap();
        let drawn = draw(&photo, &Placement::cover(SIZE, SIZE), SIZE).unwrap();
        let mut image = GrayImage::from_pixel(SIZE.0, SIZE.1, Luma([scene])).into();
        let masks = composite(&mut image, &drawn, &optics).unwrap();
        for (x, y, pixel) in image.to_luma8().enumerate_pixels() {
            let expected = expected.get_pixel(x, y).0[0];
            assert!(
                pixel.0[0].abs_diff(expected) <= 1,
                "{background:?} at ({x}, {y}): {pixel:?}, not {expected}"
            );
            let is_glass = gray.get_pixel(x, y).0[0] > 0;
            assert_eq!(masks.region.get_pixel(x, y).0[0] > 0, is_glass, "region");
        }
    }
}

#[test]
fn backgrounds_are_recognized_and_their_noise_is_not_glass() {
    let noisy = |level: i32, sign: i32| {
        let star = star(200, 150);
        RgbImage::from_fn(200, 150, |x, y| {
            let noise = i32::try_from((x * 7919 + y * 104_729) % 7).unwrap() - 3;
            let pixel = star.get_pixel(x, y).0;
            pixel
                .map(|code| {
                    u8::try_from((level + sign * i32::from(code) + noise).clamp(0, 255)).unwrap()
                })
                .into()
        })
    };
    for (pixels, background) in [
        (noisy(6, 1), Background::Black),
        (noisy(20, 1), Background::Black),
        (noisy(250, -1), Background::White),
        (noisy(230, -1), Background::White),
    ] {
        let photo = photo(pixels);
        assert_eq!(photo.background(), background, "recognized");
        let coverage = whole(&photo, &sharp(), 0.0).coverage();
        for (x, y) in [(0, 0), (149, 0), (3, 109), (149, 109)] {
            assert_eq!(coverage.get_pixel(x, y).0, [0], "noise at ({x}, {y})");
        }
        assert!(coverage.iter().any(|code| *code > 200), "and glass is");
    }
    let cut_out = RgbaImage::from_fn(20, 20, |x, _| {
        Rgba([128, 128, 128, if x > 9 { 255 } else { 0 }])
    });
    assert_eq!(photo(cut_out).background(), Background::Alpha, "alpha");
}

#[test]
fn sixteen_bits_and_grey_read_like_eight_bits_and_color() {
    let gray = image::imageops::grayscale(&star(120, 90));
    let images = [
        DynamicImage::from(gray.clone()),
        DynamicImage::from(gray.clone()).to_rgb8().into(),
        DynamicImage::from(gray.clone()).to_luma16().into(),
        DynamicImage::from(gray.clone()).to_rgba16().into(),
        DynamicImage::from(gray).to_luma_alpha8().into(),
    ];
    let optics = far_focus(2.0);
    let maps = images.map(|image| overlay(&photo(image), &optics, &light(0.6)).maps());
    for other in &maps[1..] {
        assert!(
            maps[0]
                .attenuation
                .iter()
                .zip(&other.attenuation)
                .all(|(a, b)| (a - b).abs() < 1e-4),
            "the same opacity"
        );
    }
}

#[test]
fn what_is_no_photograph_of_glass_is_refused() {
    let params = PhotoParams::default();
    let refused = |image: DynamicImage| Photo::new(image, &params).unwrap_err();
    assert_eq!(
        refused(RgbaImage::from_pixel(8, 8, Rgba([255, 255, 255, 0])).into()),
        OpticsError::NoGlass {
            background: "alpha"
        },
        "transparent all over"
    );
    assert_eq!(
        refused(RgbImage::new(30, 30).into()),
        OpticsError::NoGlass {
            background: "black"
        },
        "black all over"
    );
    assert_eq!(
        refused(GrayImage::from_pixel(1, 1, Luma([255])).into()),
        OpticsError::NoGlass {
            background: "white"
        },
        "one white pixel"
    );
    assert_eq!(
        refused(GrayImage::from_pixel(9, 9, Luma([120])).into()),
        OpticsError::PhotoBackground {
            darkest: 120,
            brightest: 120
        },
        "grey"
    );
    assert_eq!(
        refused(RgbImage::new(0, 4).into()),
        OpticsError::EmptyImage {
            width: 0,
            height: 4
        },
        "empty"
    );
    assert!(
        matches!(
            refused(DynamicImage::new_rgb32f(4, 4)),
            OpticsError::ImageMode { .. }
        ),
        "floating point"
    );
    let star = photo(star(60, 40));
    let optics = sharp();
    let cover = Placement::cover(star.size(), SIZE);
    let parameter = |error: OpticsError| matches!(error, OpticsError::Parameter { .. });
    for placement in [
        Placement {
            width_px: 0.0,
            ..cover
        },
        Placement {
            height_px: f64::NAN,
            ..cover
        },
        Placement {
            left_px: f64::INFINITY,
            ..cover
        },
    ] {
        assert!(
            parameter(bake(&star, &placement, &view(0.2, 0.0), &optics).unwrap_err()),
            "{placement:?}"
        );
        assert!(
            parameter(draw(&star, &placement, SIZE).unwrap_err()),
            "{placement:?}"
        );
    }
    let pattern = bake(&star, &cover, &view(0.2, 0.0), &optics).unwrap();
    for gain in [-1.0, f64::NAN, 1e4] {
        assert!(
            parameter(pattern.light(&light(0.5), gain, &optics).unwrap_err()),
            "gain {gain}"
        );
    }
    let stretched = View::stretched(&Pane::from_frame_px(SIZE.0, SIZE.1), SIZE);
    assert_eq!(
        bake(&star, &cover, &stretched, &optics).unwrap_err(),
        OpticsError::NoCamera,
        "without a camera"
    );
    // A placement far beyond the photo shows nothing, and says so by an empty mask.
    let beyond = Placement {
        left_px: 1e5,
        ..cover
    };
    let pattern = bake(&star, &beyond, &view(0.2, 0.0), &optics).unwrap();
    assert!(pattern.coverage().iter().all(|code| *code == 0), "no glass");
}

#[test]
fn random_placements_keep_the_frames_shape_and_their_ranges() {
    let (photo, frame) = ((900, 700), (1242, 375));
    let range = PlacementRange {
        min_scale: 0.5,
        max_shift: 0.2,
    };
    let largest = Placement::cover(photo, frame);
    let mut flips = [0; 2];
    let mut scales = Vec::new();
    let mut most_beyond = 0.0_f64;
    for seed in 0..2000 {
        let place = Placement::random(photo, frame, &range, Seed(seed)).unwrap();
        assert_eq!(
            place,
            Placement::random(photo, frame, &range, Seed(seed)).unwrap(),
            "a seed is a placement"
        );
        assert!(
            (place.width_px / place.height_px - 1242.0 / 375.0).abs() < 1e-9,
            "the frame's shape"
        );
        let scale = place.width_px / largest.width_px;
        assert!((0.5..=1.0).contains(&scale), "scale {scale}");
        scales.push(scale);
        for (start, length, side) in [
            (place.left_px, place.width_px, 900.0),
            (place.top_px, place.height_px, 700.0),
        ] {
            let beyond = (-start).max(start + length - side) / length;
            assert!(beyond <= 0.2 + 1e-9, "beyond by {beyond}");
            most_beyond = most_beyond.max(beyond);
        }
        flips[0] += u32::from(place.flip_horizontal);
        flips[1] += u32::from(place.flip_vertical);
    }
    let mean = scales.iter().sum::<f64>() / 2000.0;
    assert!((mean - 0.75).abs() < 0.01, "mean scale {mean}");
    assert!(most_beyond > 0.15, "shifts use their range: {most_beyond}");
    for flips in flips {
        assert!((900..1100).contains(&flips), "{flips} flips of 2000");
    }
    assert!(
        matches!(
            Placement::random(
                photo,
                frame,
                &PlacementRange {
                    min_scale: 0.0,
                    ..range
                },
                Seed(0)
            ),
            Err(OpticsError::Parameter { .. })
        ),
        "a range of its own"
    );
}

#[test]
fn a_photograph_shrunk_beforehand_shows_the_same() {
    let star = star(SIZE.0 * 6, SIZE.1 * 6);
    let cut_out = RgbaImage::from_fn(SIZE.0 * 6, SIZE.1 * 6, |x, y| {
        let [r, g, b] = star.get_pixel(x, y).0;
        Rgba([r / 2 + 90, g, b, r])
    });
    let mut white = star.clone();
    image::imageops::invert(&mut white);
    let optics = far_focus(1.5);
    for pixels in [DynamicImage::from(star), white.into(), cut_out.into()] {
        let photo = photo(pixels);
        let small = photo.clone().shrunk_to(SIZE.0 * 3);
        assert_eq!(small.size(), (SIZE.0 * 3, SIZE.1 * 3), "half as large");
        assert_eq!(small.background(), photo.background(), "on the same ground");
        let (a, b) = (
            overlay(&photo, &optics, &light(0.5)).maps(),
            overlay(&small, &optics, &light(0.5)).maps(),
        );
        for (a, b) in a.added.iter().flatten().zip(b.added.iter().flatten()) {
            assert!((a - b).abs() < 2e-4, "added: {a} and {b}");
        }
        for (a, b) in a.attenuation.iter().zip(&b.attenuation) {
            assert!((a - b).abs() < 2e-4, "attenuation: {a} and {b}");
        }
        assert_eq!(small.clone().shrunk_to(5000), small, "it is small enough");
    }
}
