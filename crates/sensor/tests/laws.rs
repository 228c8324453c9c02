//! The faults of a sensor beside the closed forms of their laws.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use starbreak_seed::Seed;
use starbreak_sensor::{
    Exposure, Lamps, Light, Lines, Moment, Noise, Pixels, Pulse, Sensor, demosaic,
};

const SILENT: Noise = Noise {
    white_e: 1000.0,
    read_e: 0.0,
    row_e: 0.0,
    prnu: 0.0,
    dsnu_e: 0.0,
    dark_e_s: 0.0,
    doubling_k: 7.0,
    temperature_c: 25.0,
    exposure_s: 0.01,
};

fn flat(size: (usize, usize), n_colors: usize, value: f32) -> Light {
    Light::new(size, n_colors, vec![value; size.0 * size.1 * n_colors]).unwrap()
}

/// A gray frame behind a sensor: gray has no mosaic, so its values are those of the pixels.
fn seen(sensor: &Sensor, light: &Light, frame: u64) -> Vec<f64> {
    let mut light = light.clone();
    sensor.over(&mut light, Seed(frame).into());
    light
        .values()
        .iter()
        .map(|value| f64::from(*value))
        .collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn variance(values: &[f64]) -> f64 {
    let middle = mean(values);
    let squares = values.iter().map(|it| (it - middle) * (it - middle));
    squares.sum::<f64>() / (values.len() - 1) as f64
}

fn of_noise(noise: Noise) -> Sensor {
    Sensor::of(noise)
}

#[test]
fn variance_is_that_of_counting_and_reading() {
    // EMVA 1288: variance over mean is a line; its slope is the gain, its foot what the dark has.
    let noise = Noise {
        read_e: 5.0,
        dark_e_s: 2000.0,
        ..SILENT
    };
    assert!((noise.dark_e() - 20.0).abs() < 1e-12, "{}", noise.dark_e());
    let sensor = of_noise(noise);
    for value in [0.004_f32, 0.02, 0.1, 0.4] {
        let values = seen(&sensor, &flat((400, 300), 1, value), 3);
        let expected = (f64::from(value) * 1000.0 + 20.0 + 25.0) / 1e6;
        let found = variance(&values);
        assert!(
            (found / expected - 1.0).abs() < 0.02,
            "{value}: {found}, not {expected}"
        );
        let middle = mean(&values);
        let error = (expected / 120_000.0).sqrt();
        assert!(
            (middle - f64::from(value)).abs() < 4.0 * error,
            "{value}: {middle}"
        );
    }
}

#[test]
fn dark_current_doubles() {
    let warm = Noise {
        dark_e_s: 10.0,
        temperature_c: 39.0,
        ..SILENT
    };
    assert!((warm.dark_e() - 0.4).abs() < 1e-12, "{}", warm.dark_e());
}

#[test]
fn the_signal_over_noise_of_a_gray_is_what_was_asked() {
    for (white_e, snr) in [
        (8900.0, 40.0),
        (2270.0, 20.0),
        (600.0, 10.0),
        (178.0, 5.0),
        (62.0, 2.5),
    ] {
        let noise = Noise {
            white_e,
            read_e: 3.0,
            ..SILENT
        };
        assert!(
            (noise.snr_18() / snr - 1.0).abs() < 0.02,
            "{}",
            noise.snr_18()
        );
        let values = seen(&of_noise(noise), &flat((300, 300), 1, 0.18), 1);
        let found = mean(&values) / variance(&values).sqrt();
        assert!((found / snr - 1.0).abs() < 0.02, "{white_e}: {found}");
    }
}

#[test]
fn rows_have_a_noise_of_their_own() {
    let sensor = of_noise(Noise {
        row_e: 8.0,
        ..SILENT
    });
    let values = seen(&sensor, &flat((200, 2000), 1, 0.25), 9);
    let rows: Vec<f64> = values.chunks_exact(200).map(mean).collect();
    // Of a row's mean the photons leave 250/200.
    let expected = (64.0 + 250.0 / 200.0) / 1e6;
    let found = variance(&rows);
    assert!(
        (found / expected - 1.0).abs() < 0.1,
        "{found}, not {expected}"
    );
}

#[test]
fn what_is_fixed_stays_and_what_is_not_does_not() {
    let noise = Noise {
        white_e: 1e9,
        prnu: 0.02,
        dsnu_e: 4e6,
        ..SILENT
    };
    let fixed = |value: f32, frame: u64| seen(&of_noise(noise), &flat((300, 200), 1, value), frame);
    let [dark, bright] = [fixed(0.1, 1), fixed(0.5, 1)];
    let again = fixed(0.5, 2);
    let differ: Vec<f64> = bright.iter().zip(&again).map(|(a, b)| a - b).collect();
    assert!(variance(&differ) < 1e-8, "in every frame the same");
    for (values, level) in [(&dark, 0.1), (&bright, 0.5)] {
        let expected = (0.02_f64 * level).powi(2) + 0.004_f64.powi(2);
        let found = variance(values);
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "{found}, not {expected}"
        );
    }
    let other = Sensor::new(1, vec![(0.0, noise.into())]);
    assert_ne!(
        seen(&other, &flat((300, 200), 1, 0.5), 1),
        bright,
        "another sensor"
    );
    let moving = of_noise(SILENT);
    let gray = flat((30, 20), 1, 0.5);
    assert_ne!(seen(&moving, &gray, 1), seen(&moving, &gray, 2), "photons");
    assert_eq!(
        seen(&moving, &gray, 1),
        seen(&moving, &gray, 1),
        "a seed repeats"
    );
}

#[test]
fn dark_current_takes_room_in_the_full_well() {
    let sensor = of_noise(Noise {
        dark_e_s: 10_000.0,
        ..SILENT
    });
    // A tenth of the well is full of it, and the black level takes it away.
    let values = seen(&sensor, &flat((60, 40), 1, 1.0), 1);
    let most = values.iter().copied().fold(f64::MIN, f64::max);
    assert!((most - 0.9).abs() < 1e-6, "{most} is left");
}

#[test]
fn a_full_well_holds_no_more() {
    let values = seen(&of_noise(SILENT), &flat((100, 100), 1, 1.0), 4);
    assert!(
        values.iter().all(|value| *value <= 1.0),
        "nothing above white"
    );
}

#[test]
fn exposure_is_a_factor_and_the_noise_of_fewer_photons_comes_with_it() {
    let exposure = Exposure {
        ev: -3.0,
        white_e: 2000.0,
        read_e: 3.0,
    };
    let sensor = Sensor::of(exposure);
    // The photograph with its own noise, as the sensor would have taken it.
    let own = of_noise(Noise {
        white_e: 2000.0,
        read_e: 3.0,
        ..SILENT
    });
    let photo = seen(&own, &flat((500, 400), 1, 0.5), 7);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a frame is single precision"
    )]
    let photo: Vec<f32> = photo.iter().map(|value| *value as f32).collect();
    let darker = seen(&sensor, &Light::new((500, 400), 1, photo).unwrap(), 8);
    let [signal, noise] = [0.5 / 8.0, (0.5 / 8.0 * 2000.0 + 9.0_f64).sqrt() / 2000.0];
    assert!(
        (mean(&darker) / signal - 1.0).abs() < 2e-3,
        "{}",
        mean(&darker)
    );
    let found = variance(&darker).sqrt();
    assert!((found / noise - 1.0).abs() < 0.01, "{found}, not {noise}");

    let brighter = Sensor::of(Exposure {
        ev: 1.5,
        ..exposure
    });
    let values = seen(&brighter, &flat((10, 10), 1, 0.2), 1);
    let expected = 0.2 * 2.0_f64.powf(1.5);
    assert!(
        (values[0] - expected).abs() < 1e-6,
        "{} of {expected}",
        values[0]
    );
}

/// Power of a frequency, in periods per row, of the rows' means.
fn power(rows: &[f64], frequency: f64) -> f64 {
    let middle = mean(rows);
    let parts = rows.iter().zip(0..).map(|(value, y)| {
        let angle = std::f64::consts::TAU * frequency * f64::from(y);
        [
            (value - middle) * angle.cos(),
            (value - middle) * angle.sin(),
        ]
    });
    let [re, im] = parts.fold([0.0; 2], |[a, b], [re, im]| [a + re, b + im]);
    re.hypot(im) * 2.0 / rows.len() as f64
}

#[test]
fn bands_have_the_frequency_and_depth_of_the_lamps() {
    let lamps = Lamps {
        pulse: Pulse::Mains { mains_hz: 50.0 },
        depth: 0.4,
        row_s: 29.6e-6,
        exposure_s: 4e-3,
    };
    let x = std::f64::consts::PI * 0.4;
    let expected = 0.4 * x.sin() / x;
    assert!(
        (lamps.band_depth() - expected).abs() < 1e-12,
        "{}",
        lamps.band_depth()
    );
    let sensor = Sensor::of(lamps);
    // Ten periods of 1/(2 · 50 Hz · 29.6 µs) = 337.8 rows.
    let n_rows = 3378;
    let values = seen(&sensor, &flat((4, n_rows), 1, 0.5), 2);
    let rows: Vec<f64> = values.chunks_exact(4).map(|row| row[0] / 0.5).collect();
    let bins: Vec<f64> = (1..100)
        .map(|bin| power(&rows, f64::from(bin) / n_rows as f64))
        .collect();
    let most = (1..).zip(&bins).max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    assert_eq!(most.0, 10, "the line of 2f");
    assert!(
        (most.1 / expected - 1.0).abs() < 5e-3,
        "{} for {expected}",
        most.1
    );
    // Exposed for whole pulses a row sees all of them.
    let whole = Lamps {
        exposure_s: 0.02,
        ..lamps
    };
    assert!(whole.band_depth().abs() < 1e-12, "{}", whole.band_depth());
}

#[test]
fn bands_wander_from_frame_to_frame_as_the_mains_do() {
    let lamps = Lamps {
        pulse: Pulse::Mains { mains_hz: 60.0 },
        depth: 0.3,
        row_s: 20e-6,
        exposure_s: 1e-3,
    };
    let sensor = Sensor::of(lamps);
    let rows = |time_s: f64| {
        let mut light = flat((1, 900), 1, 0.5);
        let at = Moment {
            time_s,
            ..Seed(5).into()
        };
        sensor.over(&mut light, at);
        light.values().to_vec()
    };
    // At 25 frames/s 120 pulses per s are 4.8 per frame: after five frames all is as before.
    let [first, second, sixth] = [rows(0.0), rows(0.04), rows(0.2)];
    assert_ne!(first, second, "they wander");
    let apart = first.iter().zip(&sixth).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f32::max) < 1e-5, "and come again");
    // The second is the first, 0.04 s · (4.8 pulses) later: 0.8 of a pulse of 416.7 rows.
    let moved = (0..500).map(|y| (second[y] - first[y + 333]).abs());
    assert!(moved.fold(0.0, f32::max) < 3e-3, "by 0.8 of a band");
}

#[test]
fn defects_are_as_many_as_asked_and_keep_their_places() {
    let pixels = Pixels {
        dead_per_mpx: 300.0,
        hot_per_mpx: 200.0,
        stuck_per_mpx: 100.0,
        hot_level: 0.3,
    };
    let n = 4_000_000;
    let all = pixels.of_sensor(n, Seed(2));
    // 600 per million; the standard deviation of the count is its root.
    let expected = 2400.0_f64;
    let found = all.len() as f64;
    assert!((found - expected).abs() < 4.0 * expected.sqrt(), "{found}");
    assert_eq!(all, pixels.of_sensor(n, Seed(2)), "of this sensor");
    assert_ne!(all, pixels.of_sensor(n, Seed(3)), "of another");
    let right = all.iter().filter(|(place, _)| place % 1000 >= 500).count() as f64;
    assert!(
        (right - found / 2.0).abs() < 4.0 * (found / 4.0).sqrt(),
        "{right} of {found} on the right"
    );
    let none = Pixels {
        dead_per_mpx: 1e6,
        hot_per_mpx: 0.0,
        stuck_per_mpx: 0.0,
        ..pixels
    };
    assert_eq!(none.of_sensor(1000, Seed(1)).len(), 1000, "all of them");
}

#[test]
fn a_defect_reaches_five_by_five_pixels_and_not_one_more() {
    // A gray wall on which one pixel in 400 is stuck. Of 5 x 5 px 13 are made of the middle one.
    let sensor = Sensor::of(Pixels {
        dead_per_mpx: 0.0,
        hot_per_mpx: 0.0,
        stuck_per_mpx: 2500.0,
        hot_level: 0.0,
    });
    let size = (120, 100);
    let mut light = flat(size, 3, 0.4);
    sensor.over(&mut light, Seed(1).into());
    let reached = sensor.reach(size, (3, 8), Seed(1).into());
    let places = sensor.defects(size);
    assert!(places.len() > 10, "{} defects", places.len());
    let mut n_changed = 0;
    for (at, pixel) in light.values().chunks_exact(3).enumerate() {
        let (x, y) = (at % size.0, at / size.0);
        let is_near = places
            .iter()
            .any(|(place, _)| (place % size.0).abs_diff(x) + (place / size.0).abs_diff(y) <= 2);
        let is_changed = pixel.iter().any(|value| (value - 0.4).abs() > 0.0);
        assert!(is_near || !is_changed, "({x}, {y}) is changed");
        assert_eq!(is_near, reached[at], "({x}, {y}) is reached");
        n_changed += usize::from(is_changed);
    }
    assert!(
        n_changed > 10 * places.len(),
        "{n_changed} pixels are changed"
    );
}

#[test]
fn lines_are_where_the_sensor_has_them() {
    let lines = Lines {
        rows: 3,
        columns: 2,
        level: 1.0,
    };
    let sensor = Sensor::new(6, vec![(0.0, lines.into())]);
    let (width, height) = (64, 48);
    let values = seen(&sensor, &flat((width, height), 1, 0.2), 1);
    let n_bright = values.iter().filter(|value| **value > 0.9).count();
    assert_eq!(
        n_bright,
        3 * width + 2 * height - 6,
        "three rows, two columns"
    );
    // Gray has no colors that are made of others.
    let reached = sensor.reach((width, height), (1, 8), Seed(1).into());
    assert_eq!(
        reached.iter().filter(|it| **it).count(),
        n_bright,
        "no more"
    );
}

#[test]
fn faults_of_magnitude_nothing_change_no_bit() {
    let nothing = [
        of_noise(Noise {
            white_e: f64::INFINITY,
            read_e: 3.0,
            ..SILENT
        }),
        Sensor::of(Exposure {
            ev: 0.0,
            white_e: 5000.0,
            read_e: 3.0,
        })
        .and(Lamps {
            pulse: Pulse::Mains { mains_hz: 50.0 },
            depth: 0.0,
            row_s: 1e-5,
            exposure_s: 1e-3,
        })
        .and(Pixels {
            dead_per_mpx: 0.0,
            hot_per_mpx: 0.0,
            stuck_per_mpx: 0.0,
            hot_level: 1.0,
        })
        .and(Lines {
            rows: 0,
            columns: 0,
            level: 1.0,
        }),
    ];
    for n_colors in [1, 3] {
        let values = (0..64 * 48 * n_colors).map(|k| (k % 997) as f32 / 996.0);
        let light = Light::new((64, 48), n_colors, values.collect()).unwrap();
        for sensor in &nothing {
            let mut after = light.clone();
            sensor.over(&mut after, Seed(1).into());
            assert_eq!(after, light, "{n_colors} colors");
            let reached = sensor.reach((64, 48), (n_colors, 8), Seed(1).into());
            assert!(!reached.contains(&true), "none is reached");
        }
    }
}

#[test]
fn colors_are_those_of_malvar_he_and_cutler() {
    // colour_demosaicing 0.2.7, demosaicing_CFA_Bayer_Malvar2004(…, "RGGB") of 7 rows of 8 px, whose value is ((37k +
    // 11) mod 64)/64; two px from the border, beyond which that program breaks the pattern.
    let mosaic: Vec<f32> = (0..56)
        .map(|k| ((k * 37 + 11) % 64) as f32 / 64.0)
        .collect();
    let found = demosaic(&mosaic, (8, 7));
    let inner = (2..5).flat_map(|y| (2..6).map(move |x| y * 8 + x));
    for (at, expected) in inner.zip(REFERENCE) {
        for (found, expected) in found[at].iter().zip(expected) {
            assert!(
                (f64::from(*found) - expected).abs() < 1e-6,
                "{at}: {found}, not {expected}"
            );
        }
    }
}

/// See above.
const REFERENCE: [[f64; 3]; 12] = [
    [0.5781250, 0.3281250, 0.5781250],
    [0.5937500, 0.1562500, 0.4062500],
    [0.7343750, 0.2343750, 0.7343750],
    [0.8125000, 0.3125000, 0.8125000],
    [0.5781250, 0.2031250, 0.7656250],
    [0.9687500, 0.4062500, 0.7812500],
    [0.8593750, 0.3593750, 0.8593750],
    [1.0625000, 0.6875000, 0.9375000],
    [0.8281250, 0.4531250, 0.7656250],
    [0.9062500, 0.4062500, 0.4062500],
    [0.9843750, 0.7343750, 0.8593750],
    [0.5625000, 0.5625000, 0.5625000],
];

#[test]
fn noise_in_color_is_that_of_the_filters() {
    let noise = Noise {
        read_e: 4.0,
        ..SILENT
    };
    let (width, height) = (400, 300);
    let mut light = flat((width, height), 3, 0.3);
    of_noise(noise).over(&mut light, Seed(3).into());
    // At the pixels of a color nothing is interpolated: light u/g there, and its number times g.
    for (color, g, [x0, y0]) in [(0, 2.0, [0, 0]), (1, 1.0, [1, 0]), (2, 1.7, [1, 1])] {
        let places = (y0..height)
            .step_by(2)
            .flat_map(|y| (x0..width).step_by(2).map(move |x| (x, y)));
        let values: Vec<f64> = places
            .map(|(x, y)| f64::from(light.values()[(y * width + x) * 3 + color]))
            .collect();
        let expected = g * g * (0.3 / g * 1000.0 + 16.0) / 1e6;
        let found = variance(&values);
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "{color}: {found}, not {expected}"
        );
    }
}

#[test]
fn defects_show_where_a_frame_is_overexposed() {
    let sensor = Sensor::of(Exposure {
        ev: 3.0,
        white_e: 1e6,
        read_e: 0.0,
    })
    .and(Pixels {
        dead_per_mpx: 1e6,
        hot_per_mpx: 0.0,
        stuck_per_mpx: 0.0,
        hot_level: 0.0,
    });
    for n_colors in [1, 3] {
        let mut light = flat((20, 20), n_colors, 0.7);
        sensor.over(&mut light, Seed(1).into());
        let most = light.values().iter().copied().fold(f32::MIN, f32::max);
        assert!(most < 1e-5, "all are dead, and one shows {most}");
    }
}
