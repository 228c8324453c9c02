#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "a test may panic; px of a frame"
)]

use super::*;

type Place = fn(f64, f64) -> Option<[f64; 2]>;

/// Each pixel alone at exactly its place.
fn plain<const COLORS: usize>(
    light: &[f32],
    (width, height): (usize, usize),
    from: impl Fn(f64, f64) -> Option<[f64; 2]>,
) -> Vec<f32> {
    let at = |y, x| from(x as f64 + 0.5, y as f64 + 0.5);
    let of_pixel = |(y, x): (usize, usize)| {
        at(y, x).map_or([0.0; COLORS], |place| {
            let moved = [place[0] - x as f64 - 0.5, place[1] - y as f64 - 0.5]
                .map(|px| px.clamp(-4e6, 4e6));
            let shares = |k: usize| {
                let t = (moved[k] - moved[k].floor()) as f32;
                let (t2, t3) = (t * t, t * t * t);
                [
                    0.5 * (-t + 2.0 * t2 - t3),
                    0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
                    0.5 * (t + 4.0 * t2 - 3.0 * t3),
                    0.5 * (t3 - t2),
                ]
            };
            let first = |k: usize| (moved[k].floor() as isize).saturating_sub(1);
            let clamped = |at: usize, k: isize, n: usize| {
                let at = at.cast_signed().saturating_add(k);
                at.clamp(0, n.cast_signed() - 1).cast_unsigned()
            };
            std::array::from_fn(|color| {
                let mut sum = 0.0;
                for (i, across) in (0..).zip(shares(0)) {
                    for (j, down) in (0..).zip(shares(1)) {
                        let x = clamped(x, first(0).saturating_add(i), width);
                        let y = clamped(y, first(1).saturating_add(j), height);
                        sum += across * down * light[(y * width + x) * COLORS + color];
                    }
                }
                sum.max(0.0)
            })
        })
    };
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (y, x)))
        .flat_map(of_pixel)
        .collect()
}

/// Root of the mean square of what a frame is off by, where what it shows is not beside its border.
fn rms_miss(
    frame: &[f32],
    (width, height): (usize, usize),
    from: impl Fn(f64, f64) -> Option<[f64; 2]>,
    light_at: impl Fn(f64, f64) -> f64,
) -> f64 {
    let (mut n, mut sum) = (0.0, 0.0);
    for (at, light) in frame.iter().enumerate() {
        let [u, v] = from((at % width) as f64 + 0.5, (at / width) as f64 + 0.5).unwrap();
        if (4.0..width as f64 - 4.0).contains(&u) && (4.0..height as f64 - 4.0).contains(&v) {
            n += 1.0;
            sum += (f64::from(*light) - light_at(u, v)).powi(2);
        }
    }
    (sum / n).sqrt()
}

#[test]
fn frames_of_any_size_are_as_each_pixel_alone_where_columns_move_as_one() {
    let places: [Place; 10] = [
        |u, v| Some([u, v]),
        |u, v| Some([1.03 * u - 0.4, 0.95 * v + 0.7]),
        |u, v| Some([1.2 * u - 2.4, 0.8 * v - 3.7]),
        |u, v| Some([u + 40.3, v - 35.6]),
        |u, v| Some([v - 3.0, 1.2 * u]),
        |u, v| (u > 4.0).then_some([u - 0.3, v]),
        |u, v| Some([u + 1e12, v - 1e300]),
        |u, v| Some([f64::NAN, v + u]),
        |u, v| Some([u, f64::INFINITY * (v - 2.0)]),
        |u, v| Some([40.0 - 1.1 * u, v]),
    ];
    let sizes = (1..=19).flat_map(|width| (1..=11).map(move |height| (width, height)));
    for size in sizes.chain([(64, 40), (61, 33)]) {
        let (width, height) = size;
        let value = |k: usize| ((k * 7919 + 13) % 257) as f32 / 256.0;
        let light: Vec<f32> = (0..3 * width * height).map(value).collect();
        for (k, from) in places.iter().enumerate() {
            let resampling = Resampling::new(size, Beyond::Border, from);
            let three = resampling.over(&light, 3);
            for (after, alone) in three.iter().zip(plain::<3>(&light, size, from)) {
                assert!(
                    (after - alone).abs() < 5e-6,
                    "{k} of {size:?}: {after}, {alone}"
                );
            }
            let green: Vec<f32> = light.iter().skip(1).step_by(3).copied().collect();
            let gray = resampling.over(&green, 1);
            assert!(
                gray.iter()
                    .zip(three[1..].iter().step_by(3))
                    .all(|(a, b)| a.to_bits() == b.to_bits()),
                "{k} of {size:?}: gray is as green"
            );
        }
    }
}

#[test]
fn parabolas_stay_so_where_frames_are_sheared_and_turned() {
    let size = (90, 70);
    let light_at = |u: f64, v: f64| {
        let [x, y] = [u / 90.0, v / 70.0];
        1.0 + 0.3 * x - 0.2 * y + 0.5 * x * x - 0.4 * x * y + 0.3 * y * y
    };
    let frame: Vec<f32> = (0..size.0 * size.1)
        .map(|k| light_at((k % size.0) as f64 + 0.5, (k / size.0) as f64 + 0.5) as f32)
        .collect();
    let places: [Place; 4] = [
        |u, v| Some([u + 0.11 * v - 3.0, v]),
        |u, v| Some([u, v + 0.11 * u - 4.0]),
        |u, v| Some([0.98 * u + 0.12 * v - 3.3, 1.02 * v - 0.12 * u + 5.1]),
        // Mirrored.
        |u, v| Some([90.0 - 1.1 * u, 1.1 * v + 0.3 * u]),
    ];
    for (k, from) in places.iter().enumerate() {
        let after = Resampling::new(size, Beyond::Nothing, from).over(&frame, 1);
        let mut n = 0;
        for (at, after) in after.iter().enumerate() {
            let [u, v] = from((at % size.0) as f64 + 0.5, (at / size.0) as f64 + 0.5).unwrap();
            // The border has no parabola beyond it.
            if (3.0..87.0).contains(&u) && (3.0..67.0).contains(&v) {
                let miss = f64::from(*after) - light_at(u, v);
                assert!(miss.abs() < 2e-5, "place {k}, pixel {at}: {miss}");
                n += 1;
            }
            if !(0.0..=90.0).contains(&u) || !(0.0..=70.0).contains(&v) {
                assert!(*after <= 0.0, "place {k}, pixel {at}: {after} of nothing");
            }
        }
        assert!(n > 900, "place {k}: {n} pixels");
    }
}

#[test]
fn bent_frames_are_as_near_to_the_light_as_each_pixel_alone() {
    let size = (320, 240);
    let light_at = |u: f64, v: f64| 0.5 + 0.25 * (u / 2.2).sin() + 0.25 * (v / 2.7 + 0.1 * u).cos();
    let frame: Vec<f32> = (0..size.0 * size.1)
        .map(|k| light_at((k % size.0) as f64 + 0.5, (k / size.0) as f64 + 0.5) as f32)
        .collect();
    for corner in [-0.08, 0.03, 0.1] {
        let from = |u: f64, v: f64| {
            let [x, y] = [u - 160.0, v - 120.0];
            let gain = 1.0 + corner * (x * x + y * y) / 40_000.0;
            Some([160.0 + gain * x, 120.0 + gain * y])
        };
        let miss = |after: Vec<f32>| rms_miss(&after, size, from, light_at);
        // On straight lines between the corners of squares, too.
        let between_corners = |u: f64, v: f64| {
            let [left, top] = [u, v].map(|px| (px / 8.0).floor() * 8.0);
            let [s, t] = [(u - left) / 8.0, (v - top) / 8.0];
            let row = |v: f64| {
                let [a, b] = [left, left + 8.0].map(|u| from(u, v).unwrap());
                [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
            };
            let [a, b] = [row(top), row(top + 8.0)];
            Some([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])])
        };
        let alone = miss(plain::<1>(&frame, size, between_corners));
        let after = miss(Resampling::new(size, Beyond::Nothing, from).over(&frame, 1));
        assert!(
            after < 1.05 * alone && alone < 0.02,
            "{corner}: {after} and {alone}"
        );
    }
}

#[test]
fn lines_that_become_thinner_than_a_pixel_do_not_break_up() {
    let size = (160, 120);
    // A wave of 2.7 px, of which no pixel shows anything that sees 2 px or more.
    let line = |at: usize| 0.5 + 0.5 * (at as f32 * (std::f32::consts::TAU / 2.7)).cos();
    let across: Vec<f32> = (0..size.0 * size.1).map(|at| line(at % size.0)).collect();
    let down: Vec<f32> = (0..size.0 * size.1).map(|at| line(at / size.0)).collect();
    for scale in [2.0, 3.1, 6.0] {
        let from = |u: f64, v: f64| Some([80.0 + scale * (u - 80.0), 60.0 + scale * (v - 60.0)]);
        let resampling = Resampling::new(size, Beyond::Border, from);
        for frame in [&across, &down] {
            let white = resampling.over(&vec![1.0; frame.len()], 1);
            assert!(
                white.iter().all(|light| (light - 1.0).abs() < 1e-5),
                "white stays white"
            );
            let alone = plain::<1>(frame, size, from);
            let shown = resampling.over(frame, 1);
            let middle = |all: &[f32]| {
                let of_frame = |at: &usize| {
                    let [x, y] = [at % size.0, at / size.0];
                    let reach = |n: usize| (0.5 * n as f64 / scale) as usize - 2;
                    x.abs_diff(80) < reach(160) && y.abs_diff(60) < reach(120)
                };
                let all: Vec<f64> = (0..all.len())
                    .filter(of_frame)
                    .map(|at| all[at].into())
                    .collect();
                let mean = all.iter().sum::<f64>() / all.len() as f64;
                let square = all.iter().map(|light| (light - mean).powi(2)).sum::<f64>();
                ((square / all.len() as f64).sqrt(), mean)
            };
            let ((spread, mean), (dots, _)) = (middle(&shown), middle(&alone));
            assert!(
                spread < 0.2 * dots && dots > 0.15,
                "{scale}: {spread}, {dots}"
            );
            assert!((mean - 0.5).abs() < 0.03, "{scale}: {mean}");
        }
    }
}

/// Share of the pixels that are shown by squares.
fn straight(resampling: &Resampling) -> f64 {
    let n = resampling.is_straight.iter().filter(|is| **is).count();
    n as f64 / resampling.is_straight.len() as f64
}

#[test]
fn nothing_at_one_side_leaves_the_rest_as_it_is() {
    let size = (640, 480);
    let light: Vec<f32> = (0..size.0 * size.1)
        .map(|k| ((k * 7919) % 257) as f32 / 256.0)
        .collect();
    let sides: [Place; 2] = [
        |u, v| (u > 12.0).then_some([u - 0.3, v]),
        |u, v| (u < 628.0).then_some([u - 0.3, v]),
    ];
    for (k, from) in sides.iter().enumerate() {
        let resampling = Resampling::new(size, Beyond::Nothing, from);
        assert!(straight(&resampling) > 0.9, "side {k}");
        let alone = plain::<1>(&light, size, from);
        for (after, alone) in resampling.over(&light, 1).iter().zip(alone) {
            assert!((after - alone).abs() < 5e-6, "side {k}: {after}, {alone}");
        }
    }
}

#[test]
fn turned_frames_show_fine_waves_as_each_pixel_alone() {
    let size = (128, 96);
    let wave = |u: f64, v: f64| 0.5 + 0.4 * (std::f64::consts::TAU * 0.2 * (u + v)).cos();
    let frame: Vec<f32> = (0..size.0 * size.1)
        .map(|k| wave((k % size.0) as f64 + 0.5, (k / size.0) as f64 + 0.5) as f32)
        .collect();
    for degrees in [0.0_f64, 5.0, 10.0, 20.0, 45.0, 80.0, 135.0, 200.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let from = |u: f64, v: f64| {
            let [x, y] = [u - 64.3, v - 48.1];
            Some([64.0 + cos * x - sin * y, 48.0 + sin * x + cos * y])
        };
        let miss = |after: Vec<f32>| rms_miss(&after, size, from, wave);
        let alone = miss(plain::<1>(&frame, size, from));
        let after = miss(Resampling::new(size, Beyond::Border, from).over(&frame, 1));
        assert!(after < 1.6 * alone, "{degrees}: {after}, {alone}");
    }
}

#[test]
fn lines_beyond_the_border_are_in_their_own_rows() {
    let size = (40, 64);
    let frame: Vec<f32> = (0..size.0 * size.1)
        .map(|k| (1.0 + 0.05 * (k / size.0) as f64 + 0.01 * (k % size.0) as f64) as f32)
        .collect();
    let places: [Place; 3] = [
        |u, v| Some([u - 6.3, v - 0.19 * u + 4.0]),
        |u, v| Some([u + 7.1, v + 0.19 * u - 3.0]),
        |u, v| Some([0.97 * u - 4.9, 0.15 * u + 0.9 * v]),
    ];
    for (k, from) in places.iter().enumerate() {
        let alone = plain::<1>(&frame, size, from);
        let after = Resampling::new(size, Beyond::Border, from).over(&frame, 1);
        for (at, (after, alone)) in after.iter().zip(alone).enumerate() {
            assert!(
                (after - alone).abs() < 0.01,
                "place {k}, {at}: {after}, {alone}"
            );
        }
    }
}

#[test]
fn maps_that_fold_and_leap_show_light_where_there_is_some() {
    let columns = [0.0, 60.0, 50.0, 58.0, 61.0, 64.0, 67.0, 70.0, 73.0];
    let folds = |u: f64, v: f64| {
        let k = ((u / 8.0) as usize).min(7);
        let part = u / 8.0 - k as f64;
        Some([columns[k] + part * (columns[k + 1] - columns[k]), v])
    };
    let white = vec![1.0; 64 * 40];
    let maps: [&dyn Fn(f64, f64) -> Option<[f64; 2]>; 4] = [
        &folds,
        &|u, v| Some([u, if u < 32.0 { v } else { v - 1e30 }]),
        &|u, v| Some([u + 1e30, 2.0 * v]),
        &|u, v| Some([u + 1e300, v * v]),
    ];
    for (k, from) in maps.into_iter().enumerate() {
        let after = Resampling::new((64, 40), Beyond::Border, from).over(&white, 1);
        assert!(
            after.iter().all(|light| (light - 1.0).abs() < 1e-5),
            "map {k}"
        );
    }
    // What is no number is no light.
    let after = Resampling::new((64, 40), Beyond::Border, |u, v| Some([u + 0.3, v + 0.4]))
        .over(&vec![f32::NAN; 64 * 40], 1);
    assert!(after.iter().all(|light| *light <= 0.0));
}
