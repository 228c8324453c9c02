//! The light around the camera from images whose light is known.

use std::f64::consts::PI;

use image::{DynamicImage, ImageBuffer, Luma, LumaA, Rgb as RgbPixel, Rgba};
use starbreak_optics::environment::{
    Dashboard, Environment, EnvironmentParams, HemisphereWeights, Horizon, Rgb,
};
use starbreak_optics::srgb::{decode8, encode16};

const WIDTH: u32 = 1242;
const HEIGHT: u32 = 375;
const F_PX: f64 = 721.5377;

/// Horizon over zenith of the clear sky.
const CLEAR: f64 = 5.946;

/// A scene as the camera of these tests sees it, 16 bits, from the light at (x, y, sine of the
/// elevation).
fn scene(horizon_row: f64, light: impl Fn(u32, u32, f64) -> Rgb) -> DynamicImage {
    let horizon = Horizon::at_row(horizon_row, HEIGHT, F_PX);
    DynamicImage::ImageRgb16(ImageBuffer::from_fn(WIDTH, HEIGHT, |x, y| {
        let sin = horizon.sin_elevation([
            f64::from(x) + 0.5 - f64::from(WIDTH) / 2.0,
            f64::from(y) + 0.5 - f64::from(HEIGHT) / 2.0,
            F_PX,
        ]);
        RgbPixel(light(x, y, sin).map(encode16))
    }))
}

/// A sky over a ground.
fn sky_and_ground(sky: [Rgb; 2], ground: Rgb) -> impl Fn(u32, u32, f64) -> Rgb {
    let [horizon_rgb, zenith_rgb] = sky;
    let environment = Environment {
        horizon_rgb,
        zenith_rgb,
        ground_rgb: ground,
        cabin_low_rgb: [0.0; 3],
        cabin_high_rgb: [0.0; 3],
        sun_rgb: [0.0; 3],
    };
    move |_, _, sin| environment.radiance(sin)
}

fn scaled(rgb: Rgb, factor: f64) -> Rgb {
    #[expect(clippy::cast_possible_truncation, reason = "light to try")]
    rgb.map(|channel| (f64::from(channel) * factor) as f32)
}

fn overcast(zenith: Rgb) -> [Rgb; 2] {
    [scaled(zenith, 1.0 / 3.0), zenith]
}

fn clear(zenith: Rgb) -> [Rgb; 2] {
    [scaled(zenith, CLEAR), zenith]
}

/// Irradiance on the ground over π of a sky.
fn white(sky: [Rgb; 2]) -> Rgb {
    std::array::from_fn(|k| (sky[0][k] + 2.0 * sky[1][k]) / 3.0)
}

fn luminance([red, green, blue]: Rgb) -> f64 {
    0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
}

fn assert_within(found: Rgb, expected: Rgb, share: f64, what: &str) {
    for (one, other) in found.into_iter().zip(expected) {
        let off = f64::from((one - other).abs());
        assert!(
            off <= share * f64::from(other.abs()) + 1e-9,
            "{what}: {found:?}, expected {expected:?}"
        );
    }
}

fn channels(light: &Environment) -> impl Iterator<Item = f32> {
    [
        light.horizon_rgb,
        light.zenith_rgb,
        light.ground_rgb,
        light.cabin_low_rgb,
        light.cabin_high_rgb,
        light.sun_rgb,
    ]
    .into_iter()
    .flatten()
}

fn params() -> EnvironmentParams {
    EnvironmentParams::default()
}

fn estimate(image: &DynamicImage) -> Environment {
    Environment::estimate(image, &params(), F_PX)
}

#[test]
fn an_overcast_sky_is_recovered_at_any_pitch() {
    let sky = overcast([0.75, 0.77, 0.8]);
    let ground = [0.05, 0.06, 0.055];
    for horizon_row in [0.2, 0.35, 0.5, 0.65, 0.9] {
        let image = scene(horizon_row, sky_and_ground(sky, ground));
        let light = Environment::estimate(
            &image,
            &EnvironmentParams {
                horizon_row,
                ..params()
            },
            F_PX,
        );
        assert_within(
            light.horizon_rgb,
            sky[0],
            0.05,
            &format!("{horizon_row}: horizon"),
        );
        assert_within(
            light.zenith_rgb,
            sky[1],
            0.05,
            &format!("{horizon_row}: zenith"),
        );
        assert_within(
            light.ground_rgb,
            ground,
            1e-3,
            &format!("{horizon_row}: ground"),
        );
        assert_within(
            light.cabin_low_rgb,
            scaled(ground, 0.08),
            1e-3,
            &format!("{horizon_row}: cabin, low"),
        );
        assert_within(
            light.cabin_high_rgb,
            scaled(ground, 0.1),
            1e-3,
            &format!("{horizon_row}: cabin, high"),
        );
    }
}

#[test]
fn a_clear_sky_is_recovered() {
    let sky = clear([0.03, 0.07, 0.13]);
    let light = estimate(&scene(0.5, sky_and_ground(sky, [0.1; 3])));
    assert_within(light.horizon_rgb, sky[0], 0.05, "horizon");
    assert_within(light.zenith_rgb, sky[1], 0.05, "zenith");
}

#[test]
fn trees_and_lamps_before_the_sky_do_not_change_it() {
    let sky = overcast([0.75, 0.77, 0.8]);
    let plain = sky_and_ground(sky, [0.05; 3]);
    let image = scene(0.5, |x, y, sin| {
        if x % 100 < 55 {
            [0.01, 0.03, 0.01]
        } else if x % 100 > 95 {
            [1.0; 3]
        } else {
            plain(x, y, sin)
        }
    });
    let light = estimate(&image);
    assert_within(light.horizon_rgb, sky[0], 0.05, "horizon");
    assert_within(light.zenith_rgb, sky[1], 0.05, "zenith");
}

#[test]
fn the_hood_of_the_car_is_not_the_ground() {
    let plain = sky_and_ground(overcast([0.8; 3]), [0.12, 0.11, 0.1]);
    let image = scene(0.5, |x, y, sin| {
        if y > HEIGHT - HEIGHT / 6 {
            [0.005; 3]
        } else {
            plain(x, y, sin)
        }
    });
    assert_within(
        estimate(&image).ground_rgb,
        [0.12, 0.11, 0.1],
        1e-3,
        "ground",
    );
}

#[test]
fn the_sun_of_a_clear_day_is_what_the_sky_leaves_over() {
    let sky = clear([0.03, 0.07, 0.13]);
    let sky_irradiance = PI * luminance(white(sky));
    for (ratio, elevation) in [(1.0, 60_f64), (3.0, 45.0), (6.0, 20.0)] {
        let sun = ratio * sky_irradiance;
        // A road of albedo 0.1 under both; all is grey, and hence its luminance.
        let road = 0.1 * (sky_irradiance + sun * elevation.to_radians().sin()) / PI;
        let image = scene(0.5, sky_and_ground(sky, scaled([1.0; 3], road)));
        let light = Environment::estimate(
            &image,
            &EnvironmentParams {
                sun_elevation_rad: elevation.to_radians(),
                ..params()
            },
            F_PX,
        );
        let found = luminance(light.sun_rgb);
        assert!(
            (found / sun - 1.0).abs() < 0.05,
            "{ratio} at {elevation}°: {found}, expected {sun}"
        );
        assert!(
            light.sun_rgb[0] > light.sun_rgb[2],
            "sunlight is warm: {:?}",
            light.sun_rgb
        );
    }
}

#[test]
fn half_the_road_in_shade_leaves_the_sun_as_it_is() {
    let sky = clear([0.03, 0.07, 0.13]);
    let sky_irradiance = PI * luminance(white(sky));
    let sun = 3.0 * sky_irradiance;
    let lit = 0.1 * (sky_irradiance + sun * 45_f64.to_radians().sin()) / PI;
    let shade = 0.1 * sky_irradiance / PI;
    let plain = sky_and_ground(sky, scaled([1.0; 3], lit));
    let image = scene(0.5, |x, y, sin| {
        if sin < 0.0 && x % 100 < 60 {
            scaled([1.0; 3], shade)
        } else {
            plain(x, y, sin)
        }
    });
    let light = estimate(&image);
    let found = luminance(light.sun_rgb);
    assert!((found / sun - 1.0).abs() < 0.05, "{found}, expected {sun}");
    assert_within(light.ground_rgb, scaled([1.0; 3], shade), 1e-3, "ground");
}

#[test]
fn an_overcast_day_has_no_sun() {
    let sky = overcast([0.75, 0.77, 0.8]);
    for road in [0.02, 0.0609, 0.3, 0.9] {
        let light = estimate(&scene(0.5, sky_and_ground(sky, [road; 3])));
        let sun = luminance(light.sun_rgb);
        assert!(sun < 1e-6, "over a ground of {road}: {sun}");
    }
}

#[test]
fn a_night_with_lamps_has_no_sun() {
    let image = scene(0.5, |x, y, sin| {
        if x.is_multiple_of(40) && y.is_multiple_of(40) {
            [1.0, 0.9, 0.6]
        } else if sin > 0.0 {
            [0.002, 0.003, 0.006]
        } else {
            [0.06, 0.05, 0.03]
        }
    });
    let light = estimate(&image);
    assert!(luminance(light.sun_rgb) < 1e-9, "{:?}", light.sun_rgb);
    for channel in channels(&light) {
        assert!((0.0..0.1).contains(&channel), "{light:?}");
    }
}

#[test]
fn the_sun_is_bounded_by_the_sky_and_gone_below_the_horizon() {
    let sky = clear([0.03, 0.07, 0.13]);
    let image = scene(0.5, sky_and_ground(sky, [0.9; 3]));
    for degrees in [-90_f64, -10.0, -0.001, 0.0, 0.001, 1.0, 30.0, 90.0] {
        let light = Environment::estimate(
            &image,
            &EnvironmentParams {
                sun_elevation_rad: degrees.to_radians(),
                ..params()
            },
            F_PX,
        );
        let sun = luminance(light.sun_rgb);
        let up = HemisphereWeights::facing(1.0).mean_radiance(&light);
        let most = 10.0 * PI * luminance(up);
        assert!(sun <= most * 1.0001, "{sun} at {degrees}°, most {most}");
        assert_eq!(sun > 0.0, degrees > 0.0, "{sun} at {degrees}°");
    }
}

#[test]
fn a_ground_too_bright_for_a_road_does_not_raise_the_sun() {
    let image = scene(0.5, sky_and_ground(clear([0.03, 0.07, 0.13]), [0.9; 3]));
    let light = Environment::estimate(
        &image,
        &EnvironmentParams {
            sun_elevation_rad: PI / 2.0,
            horizon_rgb: Some([1.0; 3]),
            zenith_rgb: Some([1.0; 3]),
            ..params()
        },
        F_PX,
    );
    // A white sheet shows 3 at most, of which the sky makes 1.
    let sun = luminance(light.sun_rgb);
    assert!((sun - 2.0 * PI).abs() < 1e-3, "{sun}");
}

#[test]
fn a_sky_clipped_to_white_is_taken_as_1_and_keeps_what_color_is_left() {
    // White but for a blue corner: a clear sky that is overexposed.
    let image = scene(0.5, |x, y, sin| {
        if sin < 0.0 {
            [0.09; 3]
        } else if x > 1000 && y < 80 {
            [0.3, 0.6, 1.0]
        } else {
            [1.0; 3]
        }
    });
    let light = estimate(&image);
    assert!(
        light.zenith_rgb[1] < 0.3 * light.horizon_rgb[1],
        "a clear sky: {light:?}"
    );
    assert!(
        light.zenith_rgb[2] > 2.0 * light.zenith_rgb[0],
        "a blue zenith: {light:?}"
    );
    assert!(luminance(light.sun_rgb) > 1.0, "a sun: {light:?}");
    // White all over: overcast.
    let white = estimate(&scene(
        0.5,
        |_, _, sin| {
            if sin < 0.0 { [0.09; 3] } else { [1.0; 3] }
        },
    ));
    assert_within(
        white.horizon_rgb,
        scaled(white.zenith_rgb, 1.0 / 3.0),
        1e-5,
        "overcast",
    );
}

#[test]
fn a_constant_image_gives_its_light_for_the_ground_and_for_the_sky_that_it_shows() {
    let code = 150;
    let image = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(640, 480, RgbPixel([code; 3])));
    let light = estimate(&image);
    let expected = [decode8(code); 3];
    assert_within(light.ground_rgb, expected, 1e-6, "ground");
    // The upper third spans rows 0 to 160, and 240 is the horizon.
    let (top, third) = (240.0 / F_PX, 80.0 / F_PX);
    let sin = |v: f64| v / (1.0 + v * v).sqrt();
    let high = light.radiance(sin(top))[0];
    let low = light.radiance(sin(third) * 0.8)[0];
    assert!(
        low < expected[0] && expected[0] < high,
        "{low} to {high} spans {expected:?}"
    );
}

#[test]
fn every_mode_gives_the_same_light() {
    let color = [120_u8, 130, 140];
    let grey = 90_u8;
    let wide = |code: u8| u16::from(code) * 257;
    let [r, g, b] = color;
    let of_color = [
        DynamicImage::ImageRgb8(ImageBuffer::from_pixel(64, 48, RgbPixel(color))),
        DynamicImage::ImageRgba8(ImageBuffer::from_pixel(64, 48, Rgba([r, g, b, 7]))),
        DynamicImage::ImageRgb16(ImageBuffer::from_pixel(64, 48, RgbPixel(color.map(wide)))),
        DynamicImage::ImageRgba16(ImageBuffer::from_pixel(
            64,
            48,
            Rgba([wide(r), wide(g), wide(b), 7]),
        )),
    ];
    let of_grey = [
        DynamicImage::ImageRgb8(ImageBuffer::from_pixel(64, 48, RgbPixel([grey; 3]))),
        DynamicImage::ImageLuma8(ImageBuffer::from_pixel(64, 48, Luma([grey]))),
        DynamicImage::ImageLumaA8(ImageBuffer::from_pixel(64, 48, LumaA([grey, 7]))),
        DynamicImage::ImageLuma16(ImageBuffer::from_pixel(64, 48, Luma([wide(grey)]))),
        DynamicImage::ImageLumaA16(ImageBuffer::from_pixel(64, 48, LumaA([wide(grey), 7]))),
    ];
    for images in [&of_color[..], &of_grey[..]] {
        let first = estimate(&images[0]);
        for image in images {
            let light = estimate(image);
            for (found, expected) in channels(&light).zip(channels(&first)) {
                assert!(
                    (found - expected).abs() <= 1e-5 * expected,
                    "{:?}: {light:?}, expected {first:?}",
                    image.color()
                );
            }
        }
    }
    let sun = estimate(&of_grey[1]).sun_rgb;
    assert_within(sun, [sun[0]; 3], 1e-6, "grey light in a grey image");
}

#[test]
fn a_black_image_has_no_light() {
    for size in [(1, 1), (2, 1), (1, 2), (3, 3), (640, 480)] {
        let light = estimate(&DynamicImage::new_rgb8(size.0, size.1));
        for channel in channels(&light) {
            assert!(channel.abs() < f32::EPSILON, "{size:?}: {light:?}");
        }
    }
}

#[test]
fn any_image_at_any_pitch_gives_finite_light_that_is_not_negative() {
    for size in [(1, 1), (1, 9), (9, 1), (2, 2), (7, 5), (300, 200)] {
        for pixel in [
            [255_u8; 3],
            [255, 0, 0],
            [0, 0, 255],
            [1, 1, 1],
            [3, 200, 90],
        ] {
            let image =
                DynamicImage::ImageRgb8(ImageBuffer::from_pixel(size.0, size.1, RgbPixel(pixel)));
            for horizon_row in [-100.0, -0.1, 0.0, 0.01, 0.5, 0.99, 1.0, 1.1, 100.0] {
                for f_px in [0.0, 1.0, 300.0, 1e6, f64::NAN] {
                    let params = EnvironmentParams {
                        horizon_row,
                        ..params()
                    };
                    let light = Environment::estimate(&image, &params, f_px);
                    for channel in channels(&light) {
                        // A sky that the frame does not show is at most 12.9 times the ground.
                        assert!(
                            (0.0..150.0).contains(&channel),
                            "{pixel:?}, {size:?}, {horizon_row}, {f_px}: {light:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_frame_without_sky_gets_the_overcast_sky_that_lights_its_ground() {
    let road = [0.06, 0.06, 0.05];
    let image = scene(-0.2, |_, _, _| road);
    let light = Environment::estimate(
        &image,
        &EnvironmentParams {
            horizon_row: -0.2,
            ..params()
        },
        F_PX,
    );
    let up = HemisphereWeights::facing(1.0).mean_radiance(&light);
    assert_within(scaled(up, 0.1), road, 1e-3, "albedo 0.1 under that sky");
    assert!(luminance(light.sun_rgb) < 1e-9, "{:?}", light.sun_rgb);
}

#[test]
fn a_frame_without_ground_gets_the_road_that_its_sky_lights() {
    let sky = overcast([0.75, 0.77, 0.8]);
    let image = scene(1.3, sky_and_ground(sky, [0.0; 3]));
    let light = Environment::estimate(
        &image,
        &EnvironmentParams {
            horizon_row: 1.3,
            ..params()
        },
        F_PX,
    );
    assert_within(light.ground_rgb, scaled(white(sky), 0.1), 0.05, "ground");
    assert!(luminance(light.sun_rgb) < 1e-6, "{:?}", light.sun_rgb);
}

#[test]
fn what_is_given_is_taken_as_it_is() {
    let image = scene(0.5, sky_and_ground(clear([0.03, 0.07, 0.13]), [0.2; 3]));
    let given = EnvironmentParams {
        sun_irradiance: Some(4.5),
        horizon_rgb: Some([1.0, 2.0, 3.0]),
        zenith_rgb: Some([4.0, 5.0, 6.0]),
        ground_rgb: Some([0.7, 0.8, 0.9]),
        cabin_rgb: Some([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]),
        ..params()
    };
    let light = Environment::estimate(&image, &given, F_PX);
    assert_eq!(Some(light.horizon_rgb), given.horizon_rgb);
    assert_eq!(Some(light.zenith_rgb), given.zenith_rgb);
    assert_eq!(Some(light.ground_rgb), given.ground_rgb);
    assert_eq!(
        Some([light.cabin_low_rgb, light.cabin_high_rgb]),
        given.cabin_rgb
    );
    let sun = luminance(light.sun_rgb);
    assert!((sun - 4.5).abs() < 1e-5, "luminance {sun}");
    // One by one they leave the rest as it was.
    let free = estimate(&image);
    let only_cabin = EnvironmentParams {
        cabin_rgb: given.cabin_rgb,
        ..params()
    };
    let light = Environment::estimate(&image, &only_cabin, F_PX);
    assert_eq!(
        light,
        Environment {
            cabin_low_rgb: [0.1, 0.2, 0.3],
            cabin_high_rgb: [0.4, 0.5, 0.6],
            ..free
        }
    );
    let only_zenith = EnvironmentParams {
        zenith_rgb: given.zenith_rgb,
        ..params()
    };
    let light = Environment::estimate(&image, &only_zenith, F_PX);
    assert_within(light.horizon_rgb, free.horizon_rgb, 0.0, "horizon");
    assert_within(light.ground_rgb, free.ground_rgb, 0.0, "ground");
    let given_ground = EnvironmentParams {
        ground_rgb: Some([0.0; 3]),
        ..params()
    };
    let light = Environment::estimate(&image, &given_ground, F_PX);
    assert!(
        luminance(light.sun_rgb) < 1e-9,
        "a black ground has no sun on it"
    );
}

#[test]
fn the_sampling_does_not_depend_on_the_images_size() {
    let sky = clear([0.03, 0.07, 0.13]);
    let image = scene(0.5, sky_and_ground(sky, [0.12; 3]));
    let light = estimate(&image);
    let small = image.resize_exact(WIDTH / 3, HEIGHT / 3, image::imageops::FilterType::Triangle);
    let found = Environment::estimate(&small, &params(), F_PX / 3.0);
    for (found, expected) in channels(&found).zip(channels(&light)) {
        assert!(
            (found - expected).abs() <= 0.02 * expected,
            "{found}, expected {expected}"
        );
    }
}

/// Run with `cargo test --release -p starbreak-optics --test all -- environment --ignored --nocapture`.
#[test]
#[ignore = "prints times"]
#[expect(clippy::print_stderr, reason = "times must be seen")]
fn times() {
    let wide = scene(0.5, sky_and_ground(clear([0.03, 0.07, 0.13]), [0.12; 3]));
    for (name, image) in [
        ("RGB8", DynamicImage::ImageRgb8(wide.to_rgb8())),
        ("RGB16", wide),
    ] {
        let mut best = f64::INFINITY;
        for _ in 0..200 {
            let start = std::time::Instant::now();
            std::hint::black_box(estimate(std::hint::black_box(&image)));
            best = best.min(start.elapsed().as_secs_f64());
        }
        eprintln!("{name}: {:.1} µs for {WIDTH} × {HEIGHT}", best * 1e6);
    }
}

/// The ground is that above a dashboard.
#[test]
fn the_ground_ends_at_a_dashboard() {
    let image = DynamicImage::ImageRgb8(image::RgbImage::from_fn(200, 100, |_, y| {
        image::Rgb(match y {
            0..50 => [230, 230, 230],
            50..70 => [120, 110, 100],
            _ => [8, 8, 8],
        })
    }));
    let with = |rows: &[f64]| {
        let params = EnvironmentParams {
            dashboard: Dashboard::below(rows).unwrap_or_else(|error| panic!("{error}")),
            ..EnvironmentParams::default()
        };
        Environment::estimate(&image, &params, 150.0)
    };
    let road = decode8(120);
    assert!((with(&[0.72, 0.7]).ground_rgb[0] - road).abs() < 1e-6);
    assert!(
        with(&[]).ground_rgb[0] < 0.1 * road,
        "else it is the dashboard's"
    );
}
