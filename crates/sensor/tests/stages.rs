//! The cover, the filters, the image processor and the way to the computer beside the closed forms of their laws.
#![expect(clippy::unwrap_used, reason = "a test may panic")]
#![expect(clippy::cast_possible_truncation, reason = "small numbers")]

use std::f64::consts::PI;

use starbreak_seed::Seed;
use starbreak_sensor::{
    Fault, Filters, Frames, Isp, Lamps, Light, Lines, Link, Moment, Pixels, Pulse, RawRows, Sensor,
    Spots,
};

const WORKS: Isp = Isp {
    black_level: 0.0,
    white_balance: 0.0,
    color_matrix: 0.0,
    unsharp: 0.0,
    tone: 0.0,
};

const SOUND: Link = Link {
    row_bits: 16,
    bit_error_rate: 0.0,
    jpeg_quality: 0,
};

fn after(sensor: &Sensor, light: &Light) -> Light {
    let mut light = light.clone();
    sensor.over(&mut light, Seed(1).into());
    light
}

/// A frame in which no two pixels are alike.
fn colorful(size: (usize, usize)) -> Light {
    let values = (0..size.0 * size.1 * 3).map(|k| ((k * 37 + 11) % 251) as f32 / 251.0);
    Light::new(size, 3, values.collect()).unwrap()
}

#[test]
fn a_spot_takes_the_light_of_its_grain_whatever_the_aperture() {
    for f_number in [1.6, 2.8, 5.6, 11.0] {
        let spots = Spots {
            count: 1,
            diameter_m: 100e-6,
            height_m: 0.5e-3,
            f_number,
            pitch_m: 3e-6,
        };
        let lost: f64 = (0..4000)
            .map(|k| {
                let away_px = (f64::from(k) + 0.5) / 4000.0 * spots.reach_px();
                2.0 * PI * away_px * spots.lost(away_px, 1.0) * spots.reach_px() / 4000.0
            })
            .sum();
        let grain_px2 = PI * (50.0_f64 / 3.0).powi(2);
        assert!(
            (lost / grain_px2 - 1.0).abs() < 1e-3,
            "{f_number}: {lost} of {grain_px2} px²"
        );
        // A disc of 0.5 mm/N: as deep as the grain's area over its own, at most all.
        let depth = (0.1 * f_number / 0.5).powi(2).min(1.0);
        assert!(
            (spots.lost(0.0, 1.0) - depth).abs() < 1e-12,
            "{f_number}: {}",
            spots.lost(0.0, 1.0)
        );
        assert!((spots.depth() - depth).abs() < 1e-12, "{f_number}");
        let width_px = (100.0 + 500.0 / f_number) / 3.0;
        assert!(
            (2.0 * spots.reach_px() - width_px).abs() < 1e-9,
            "{f_number}"
        );
        assert!(
            spots.lost(spots.reach_px() * 0.999, 1.0) > 0.0,
            "up to there"
        );
        assert!(spots.lost(spots.reach_px(), 1.0) <= 0.0, "and no further");
    }
}

#[test]
fn spots_are_as_dense_at_the_border_as_in_the_middle() {
    // Wide shadows on a small frame: as much light is lost at its border as in its middle.
    let mut lost = [0.0; 2];
    for number in 0..400 {
        let spots = Spots {
            count: 3,
            diameter_m: 60e-6,
            height_m: 0.4e-3,
            f_number: 4.0,
            pitch_m: 4e-6,
        };
        let sensor = Sensor::new(number, vec![(0.0, spots.into())]);
        let (width, height) = (60, 40);
        let light = Light::new((width, height), 1, vec![1.0; width * height]).unwrap();
        for (at, value) in after(&sensor, &light).values().iter().enumerate() {
            let (x, y) = (at % width, at / width);
            let is_middle = (20..40).contains(&x) && (13..27).contains(&y);
            let is_border = x < 5 || y < 5 || x >= width - 5 || y >= height - 5;
            let n = if is_middle { 280.0 } else { 900.0 };
            if is_middle || is_border {
                lost[usize::from(is_border)] += f64::from(1.0 - value) / n;
            }
        }
    }
    let ratio = lost[1] / lost[0];
    assert!(
        (ratio - 1.0).abs() < 0.06,
        "{ratio} times as much at the border"
    );
}

#[test]
fn spots_darken_where_they_reach() {
    let spots = Spots {
        count: 7,
        diameter_m: 60e-6,
        height_m: 0.4e-3,
        f_number: 8.0,
        pitch_m: 5e-6,
    };
    let sensor = Sensor::of(spots);
    let size = (200, 150);
    let light = Light::new(size, 3, vec![0.5; size.0 * size.1 * 3]).unwrap();
    let reached = sensor.reach(size, (3, 8), Seed(1).into());
    for (pixel, is_reached) in after(&sensor, &light).values().chunks_exact(3).zip(reached) {
        assert_eq!(pixel[0] < 0.5, is_reached, "where it is darker");
        assert!(pixel[0].to_bits() == pixel[2].to_bits(), "without a color");
    }
}

#[test]
fn without_filters_there_is_no_color() {
    let light = colorful((30, 20));
    let all = after(&Sensor::of(Filters { loss: 1.0 }), &light);
    for (pixel, before) in all
        .values()
        .chunks_exact(3)
        .zip(light.values().chunks_exact(3))
    {
        let gray = 0.2126 * before[0] + 0.7152 * before[1] + 0.0722 * before[2];
        for value in pixel {
            assert!((value - gray).abs() < 1e-6, "{value}, not {gray}");
        }
    }
    let half = after(&Sensor::of(Filters { loss: 0.5 }), &light);
    for ((half, all), before) in half.values().iter().zip(all.values()).zip(light.values()) {
        assert!(
            (half - 0.5 * (all + before)).abs() < 1e-6,
            "half of the way"
        );
    }
}

#[test]
fn raw_rows_show_what_each_pixel_saw() {
    let seen = colorful((30, 40));
    let photo = seen.values().chunks_exact(3);
    let photo: Vec<f32> = photo
        .flat_map(|raw| processed(raw, [0.0, 2.0, 1.7], MATRIX).map(|color| color as f32))
        .collect();
    let light = Light::new((30, 40), 3, photo).unwrap();
    for is_colored in [false, true] {
        let sensor = Sensor::of(RawRows {
            share: 0.25,
            is_colored,
        });
        let reached = sensor.reach((30, 40), (3, 8), Seed(1).into());
        let n_reached = reached.iter().filter(|it| **it).count();
        assert_eq!(n_reached, 10 * 30, "a quarter of the rows");
        let shown = after(&sensor, &light);
        let pixels = shown
            .values()
            .chunks_exact(3)
            .zip(light.values().chunks_exact(3));
        let pixels = pixels.zip(seen.values().chunks_exact(3));
        for ((at, ((pixel, before), raw)), is_raw) in pixels.enumerate().zip(reached) {
            let own = (at % 30) % 2 + (at / 30) % 2;
            let saw = processed(raw, [0.0, 2.0, 1.7], IDENTITY)[own];
            for (color, value) in pixel.iter().enumerate() {
                match (is_raw, is_colored && color != own) {
                    (false, _) => assert!(value.to_bits() == before[color].to_bits(), "as it was"),
                    (true, false) => assert!(
                        (f64::from(*value) - saw).abs() < 1e-5,
                        "{at}: {value}, not {saw}"
                    ),
                    (true, true) => assert!(value.abs() <= 0.0, "none of the others"),
                }
            }
        }
        // In all frames of a clip the same rows.
        let at = Moment {
            frame: Seed(9),
            ..Seed(1).into()
        };
        assert_eq!(
            sensor.reach((30, 40), (3, 8), at),
            sensor.reach((30, 40), (3, 8), Seed(1).into()),
            "fixed"
        );
    }
}

/// Gray images have no colors to change.
#[test]
fn faults_of_colors_reach_no_gray() {
    let of_colors: [Fault; 4] = [
        Filters { loss: 1.0 }.into(),
        RawRows {
            share: 1.0,
            is_colored: false,
        }
        .into(),
        Isp {
            white_balance: 1.0,
            ..WORKS
        }
        .into(),
        Isp {
            color_matrix: 1.0,
            ..WORKS
        }
        .into(),
    ];
    for fault in of_colors {
        let sensor = Sensor::new(0, vec![(0.0, fault)]);
        let reached = sensor.reach((5, 5), (1, 8), Seed(1).into());
        assert!(!reached.contains(&true), "{fault:?} reaches gray");
        assert!(
            sensor.reach((5, 5), (3, 8), Seed(1).into()).contains(&true),
            "{fault:?} reaches color"
        );
        let gray = Light::new((5, 5), 1, (0..25).map(|k| k as f32 / 25.0).collect()).unwrap();
        assert_eq!(after(&sensor, &gray), gray, "{fault:?} changes gray");
    }
}

/// Contrast of a wave of a period, px, in x or in both directions, after the sharpening is taken back.
fn left_of_wave(period: usize, amount: f64, is_diagonal: bool) -> f64 {
    // Its border mirrors all waves.
    let size = (49, 49);
    let wave = |x: usize, y: usize| {
        let turns = |at: usize| (2.0 * PI * at as f64 / period as f64).cos();
        if is_diagonal {
            turns(x) * turns(y)
        } else {
            turns(x)
        }
    };
    let places = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
    let values = places.clone().map(|(x, y)| (0.5 + 0.2 * wave(x, y)) as f32);
    let light = Light::new(size, 1, values.collect()).unwrap();
    let isp = Isp {
        unsharp: amount,
        ..WORKS
    };
    let shown = after(&Sensor::of(isp), &light);
    let (mut along, mut own) = (0.0, 0.0);
    for (value, (x, y)) in shown.values().iter().zip(places) {
        along += (f64::from(*value) - 0.5) * wave(x, y);
        own += 0.2 * wave(x, y) * wave(x, y);
    }
    along / own
}

#[test]
fn sharpening_that_is_taken_back_has_its_transfer_function() {
    for amount in [0.25, 1.0, 2.0, 5.0] {
        for period in [2, 3, 4, 8] {
            let smooth = (PI / period as f64).cos().powi(2);
            for (is_diagonal, smooth) in [(false, smooth), (true, smooth * smooth)] {
                let expected = 1.0 / (1.0 + amount * (1.0 - smooth));
                let found = left_of_wave(period, amount, is_diagonal);
                assert!(
                    (found / expected - 1.0).abs() < 1e-5,
                    "{amount}, {period} px: {found}, not {expected}"
                );
            }
        }
    }
}

/// What a processor makes of what pixels saw of all colors: M(G(raw + b)).
fn processed(raw: &[f32], [black, g_red, g_blue]: [f64; 3], matrix: [[f64; 3]; 3]) -> [f64; 3] {
    let gains = [g_red, 1.0, g_blue];
    let balanced: [f64; 3] = std::array::from_fn(|c| (f64::from(raw[c]) + black) * gains[c]);
    matrix.map(|row| (0..3).map(|c| row[c] * balanced[c]).sum())
}

const MATRIX: [[f64; 3]; 3] = [[1.7, -0.5, -0.2], [-0.25, 1.55, -0.3], [0.0, -0.6, 1.6]];
const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A photograph out of a processor that works, beside what one makes of the same raw colors that lacks stages.
#[test]
fn stages_that_are_left_out_are_those_of_a_processor_without_them() {
    let seen = colorful((16, 12));
    let photo = seen.values().chunks_exact(3);
    let photo: Vec<f32> = photo
        .flat_map(|raw| processed(raw, [0.0, 2.0, 1.7], MATRIX).map(|color| color as f32))
        .collect();
    let light = Light::new((16, 12), 3, photo).unwrap();
    let half =
        std::array::from_fn(|r| std::array::from_fn(|c| 0.5 * (MATRIX[r][c] + IDENTITY[r][c])));
    let cases = [
        ([0.0, 1.0, 0.0], [0.0, 1.0, 1.0], MATRIX),
        ([0.06, 0.0, 0.0], [0.06, 2.0, 1.7], MATRIX),
        ([0.0, 0.0, 1.0], [0.0, 2.0, 1.7], IDENTITY),
        ([0.02, 1.0, 1.0], [0.02, 1.0, 1.0], IDENTITY),
        ([0.02, 0.4, 0.5], [0.02, 1.6, 1.42], half),
    ];
    for ([black_level, white_balance, color_matrix], left, matrix) in cases {
        let isp = Isp {
            black_level,
            white_balance,
            color_matrix,
            ..WORKS
        };
        let shown = after(&Sensor::of(isp), &light);
        let pixels = shown
            .values()
            .chunks_exact(3)
            .zip(seen.values().chunks_exact(3));
        for (shown, raw) in pixels {
            let expected = processed(raw, left, matrix);
            for (found, expected) in shown.iter().zip(expected) {
                assert!(
                    (f64::from(*found) - expected).abs() < 1e-5,
                    "{isp:?}: {found}, not {expected}"
                );
            }
        }
        // Where colors are not interpolated, a pixel shows what it saw after gains and black level, and is gray.
        let raw = Sensor::of(isp).and(RawRows {
            share: 1.0,
            is_colored: false,
        });
        let shown = after(&raw, &light);
        let pixels = shown
            .values()
            .chunks_exact(3)
            .zip(seen.values().chunks_exact(3));
        for (at, (shown, raw)) in pixels.enumerate() {
            let own = (at % 16) % 2 + (at / 16) % 2;
            let expected = processed(raw, left, IDENTITY)[own];
            for found in shown {
                assert!(
                    (f64::from(*found) - expected).abs() < 1e-5,
                    "{found}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn an_led_is_seen_with_the_chance_of_its_duty_and_the_exposure() {
    for (duty, exposure_s, expected) in [
        (0.1, 1e-3, 0.19),
        (0.4, 4e-3, 0.76),
        (0.25, 10e-3, 1.0),
        (0.4, 15e-3, 1.0),
        (0.7, 36e-3, 1.0),
    ] {
        let lamps = Lamps {
            pulse: Pulse::Led {
                pulses_hz: 90.0,
                duty,
            },
            depth: 1.0,
            row_s: 29.6e-6,
            exposure_s,
        };
        assert!((lamps.seen() - expected).abs() < 1e-12, "{}", lamps.seen());
        // Exposures that begin anywhere in a second.
        let n = 90_000;
        let gains: Vec<f64> = (0..n)
            .map(|k| lamps.gain(0.0, f64::from(k) / f64::from(n), 0.3))
            .collect();
        let n_seen = gains.iter().filter(|gain| **gain > 1e-9).count();
        let share = n_seen as f64 / f64::from(n);
        assert!(
            (share - expected).abs() < 2e-3,
            "{duty}: {share}, not {expected}"
        );
        let mean = gains.iter().sum::<f64>() / f64::from(n);
        assert!((mean - 1.0).abs() < 1e-3, "{duty}: {mean} times the light");
        let darkest = gains.iter().copied().fold(f64::MAX, f64::min);
        assert!(
            (1.0 - darkest - lamps.band_depth()).abs() < 1e-3,
            "{duty}: {darkest}"
        );
    }
}

#[test]
fn defects_alone_change_what_they_change_in_a_whole_frame() {
    let (width, height) = (61, 47);
    let light = colorful((width, height));
    let sensor = Sensor::of(Pixels {
        dead_per_mpx: 9000.0,
        hot_per_mpx: 9000.0,
        stuck_per_mpx: 9000.0,
        hot_level: 0.3,
    })
    .and(Lines {
        rows: 2,
        columns: 1,
        level: 0.8,
    });
    for n_colors in [1, 3] {
        let values = light.values()[..width * height * n_colors].to_vec();
        let mut whole = Light::new((width, height), n_colors, values.clone()).unwrap();
        let mut sparse = values.clone();
        sensor.over(&mut whole, Seed(1).into());
        let of = |at: usize, color: usize| values[at * n_colors + color];
        let changes = sensor
            .changes_of_defects((width, height), n_colors, of)
            .unwrap();
        for (at, more) in changes {
            for (value, more) in sparse[at * n_colors..][..n_colors].iter_mut().zip(more) {
                *value += more;
            }
        }
        assert_eq!(whole.values(), sparse, "{n_colors} colors");
    }
    let noisy = sensor.and(Filters { loss: 0.5 });
    assert!(
        noisy.changes_of_defects((9, 9), 3, |_, _| 0.0).is_none(),
        "not alone"
    );
}

#[test]
fn faults_of_nothing_are_nothing() {
    let nothing: [Fault; 7] = [
        Spots {
            count: 0,
            diameter_m: 1e-4,
            height_m: 1e-3,
            f_number: 4.0,
            pitch_m: 3e-6,
        }
        .into(),
        Filters { loss: 0.0 }.into(),
        RawRows {
            share: 0.0,
            is_colored: true,
        }
        .into(),
        WORKS.into(),
        SOUND.into(),
        Frames {
            black: 0.0,
            white: 0.0,
            frozen: 0.0,
            dropped: 0.0,
            burst_frames: 9.0,
        }
        .into(),
        Lamps {
            pulse: Pulse::Led {
                pulses_hz: 90.0,
                duty: 0.5,
            },
            depth: 0.0,
            row_s: 1e-5,
            exposure_s: 1e-3,
        }
        .into(),
    ];
    let light = colorful((20, 14));
    for fault in nothing {
        assert!(fault.is_nothing(), "{fault:?}");
        let sensor = Sensor::new(0, vec![(0.0, fault)]);
        assert_eq!(after(&sensor, &light), light, "{fault:?}");
        assert!(!sensor.changes_light(), "{fault:?}");
        assert!(
            !sensor
                .reach((20, 14), (3, 8), Seed(1).into())
                .contains(&true),
            "{fault:?}"
        );
        assert!(sensor.faulty().faults().is_empty(), "{fault:?}");
    }
    // LEDs that are lit all the time, and those that are exposed for whole pulses, do not flicker.
    for (duty, exposure_s) in [(1.0, 1e-3), (0.5, 2.0 / 90.0)] {
        let pulse = Pulse::Led {
            pulses_hz: 90.0,
            duty,
        };
        let lamps = Lamps {
            pulse,
            depth: 1.0,
            row_s: 1e-5,
            exposure_s,
        };
        assert!(
            Fault::from(lamps).is_nothing(),
            "{duty}: {}",
            lamps.band_depth()
        );
    }
}
