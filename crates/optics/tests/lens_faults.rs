//! Faults of the lens against closed forms, and against OpenCV's projection.
#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    reason = "a test may panic, and compares whole numbers"
)]

use std::f64::consts::{PI, TAU};

use starbreak_optics::lens::Lens;
use starbreak_optics::lens_faults::{
    Defocus, Distortion, Fringes, Glare, LensFault, LensFaults, Optic, Projection, Shading, Shake,
};
use starbreak_seed::Seed;

/// KITTI's camera with f = 4 mm, f/2.
fn kitti() -> Optic {
    optic((1242, 375))
}

fn optic(size: (usize, usize)) -> Optic {
    Optic {
        f_px: 721.5377,
        lens: Lens::default(),
        size,
    }
}

fn only(fault: impl Into<LensFault>) -> LensFaults {
    let mut lens = LensFaults::default();
    lens.push(0.0, fault);
    lens
}

/// A frame of gray light, by the middles of its pixels, after a fault.
fn gray(optic: &Optic, lens: &LensFaults, light: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    colors::<1>(optic, lens, |x, y| [light(x, y)])
}

fn colors<const N: usize>(
    optic: &Optic,
    lens: &LensFaults,
    light: impl Fn(f64, f64) -> [f64; N],
) -> Vec<f64> {
    let (width, height) = optic.size;
    let mut values = Vec::new();
    for y in 0..height {
        for x in 0..width {
            values.extend(light(x as f64 + 0.5, y as f64 + 0.5).map(|value| value as f32));
        }
    }
    lens.for_frames(optic)
        .over(&mut values, N, None, (0.0, Seed(1)));
    values.into_iter().map(f64::from).collect()
}

/// How much of a sine of a frequency, per px along x, is left in the middle of a frame.
fn left_of_sine(optic: &Optic, lens: &LensFaults, frequency: f64) -> f64 {
    let (width, height) = optic.size;
    let after = gray(optic, lens, |x, _| 0.5 + 0.4 * (TAU * frequency * x).cos());
    let row = &after[height / 2 * width..][..width];
    // Whole periods about the middle.
    let n = ((width as f64 / 2.0 * frequency).floor() / frequency).round() as usize;
    let (mut re, mut im) = (0.0, 0.0);
    for (x, value) in row.iter().enumerate().skip((width - n) / 2).take(n) {
        let phase = TAU * frequency * (x as f64 + 0.5);
        re += value * phase.cos();
        im += value * phase.sin();
    }
    2.0 * re.hypot(im) / n as f64 / 0.4
}

/// The frequency at which half of a sine is left, per px.
fn mtf50(optic: &Optic, lens: &LensFaults, about: f64) -> f64 {
    let (mut low, mut high) = (0.6 * about, 1.4 * about);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if left_of_sine(optic, lens, middle) > 0.5 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[test]
fn corners_lose_light_by_the_fourth_power_of_the_cosine() {
    let optic = optic((401, 301));
    let corner = 200.5_f64.hypot(150.5);
    for degrees in [20.0_f64, 30.0, 40.0, 50.0] {
        // An exit pupil so far away that the corner is seen at this angle.
        let pupil_px = corner / degrees.to_radians().tan();
        let corner_loss = 1.0 - degrees.to_radians().cos().powi(4);
        let after = gray(&optic, &only(Shading { corner_loss }), |_, _| 1.0);
        for (x, y) in [(0, 0), (400, 300), (200, 150), (310, 40), (20, 150)] {
            let r = (x as f64 - 200.0).hypot(y as f64 - 150.0);
            let expected = (r / pupil_px).atan().cos().powi(4);
            let found = after[y * 401 + x];
            assert!(
                (found - expected).abs() < 1e-5,
                "{degrees} at {x}, {y}: {found}, not {expected}"
            );
        }
    }
}

#[test]
fn half_of_a_sine_is_left_where_the_disc_says() {
    let optic = optic((800, 101));
    for disc_px in [4.0, 8.0, 16.0, 40.0] {
        // c = Δ/(N p), p = f/f_px.
        let sensor_shift_m = disc_px * 2.0 * 4e-3 / 721.5377;
        let fault = Defocus { sensor_shift_m };
        assert!((fault.disc_px(&optic) - disc_px).abs() < 1e-9);
        // 2 J₁(πcf)/(πcf) = ½ at πcf = 2.2154.
        let expected = 2.215_1 / PI / disc_px;
        let found = mtf50(&optic, &only(fault), expected);
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "{disc_px}: {found}, not {expected}"
        );
    }
}

#[test]
fn half_of_a_sine_is_left_where_the_path_says() {
    let optic = optic((800, 101));
    for length_px in [4.0, 8.0, 16.0, 32.0] {
        let fault = Shake {
            rate_rad_s: length_px / 721.5377 / 0.02,
            direction_rad: 0.0,
            frequency_hz: 0.0,
            exposure_s: 0.02,
        };
        assert!((fault.longest_px(&optic) - length_px).abs() < 1e-9);
        // sin(πLf)/(πLf) = ½ at πLf = 1.8955.
        let expected = 1.895_5 / PI / length_px;
        let found = mtf50(&optic, &only(fault), expected);
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "{length_px}: {found}, not {expected}"
        );
    }
}

#[test]
fn a_camera_that_trembles_dwells_at_the_ends_of_its_path() {
    let optic = optic((200, 60));
    // One period in an exposure, with an amplitude of 10 px.
    let fault = Shake {
        rate_rad_s: 10.0 * TAU * 50.0 / 721.5377,
        direction_rad: 0.0,
        frequency_hz: 50.0,
        exposure_s: 0.02,
    };
    assert!((fault.longest_px(&optic) - 20.0).abs() < 1e-9);
    let point = |x: f64, y: f64| f64::from(u8::from(x.floor() == 100.0 && y.floor() == 30.0));
    let after = gray(&optic, &only(fault), point);
    let row = &after[30 * 200..][..200];
    assert!(
        (row.iter().sum::<f64>() - 1.0).abs() < 1e-5,
        "no light is lost"
    );
    let (first, last) = (
        row.iter().position(|it| *it > 1e-6),
        row.iter().rposition(|it| *it > 1e-6),
    );
    assert_eq!((first, last), (Some(90), Some(110)), "10 px to either side");
    // The share beyond ±9 px of an arcsine law is 1 − 2/π asin(0.9).
    let ends: f64 = [90, 91, 109, 110].iter().map(|x| row[*x]).sum();
    let expected = 1.0 - 2.0 / PI * 0.85_f64.asin();
    assert!((ends - expected).abs() < 0.03, "{ends}, not {expected}");
}

/// A black disc of a diameter before a white scene, and what its middle shows.
fn of_patch(optic: &Optic, lens: &LensFaults, diameter: f64) -> f64 {
    let (width, height) = optic.size;
    let middle = [width as f64 / 2.0, height as f64 / 2.0];
    let after = gray(optic, lens, |x, y| {
        let r = (x - middle[0]).hypot(y - middle[1]);
        f64::from(u8::from(r > 0.5 * diameter))
    });
    after[height / 2 * width + width / 2]
}

#[test]
fn a_black_patch_shows_the_veil() {
    for optic in [
        kitti(),
        optic((640, 480)),
        Optic {
            f_px: 1500.0,
            ..optic((1280, 720))
        },
    ] {
        for veil in [0.01, 0.04, 0.16] {
            let lens = only(Glare { veil });
            let patch = 0.1 * optic.size.1 as f64;
            let found = of_patch(&optic, &lens, patch);
            assert!(
                (found - veil).abs() < 0.001,
                "{:?}: {found}, not {veil}",
                optic.size
            );
            let even = gray(&optic, &lens, |_, _| 0.5);
            let worst = even.iter().map(|it| (it - 0.5).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-4, "an even scene stays even: {worst}");
        }
    }
}

#[test]
fn a_veil_makes_and_loses_no_light() {
    let optic = optic((400, 300));
    let lens = only(Glare { veil: 0.1 });
    let after = gray(&optic, &lens, |x, y| {
        f64::from(u8::from(x.floor() == 150.0 && y.floor() == 120.0)) * 1000.0
    });
    let sum: f64 = after.iter().sum();
    assert!((sum / 1000.0 - 1.0).abs() < 0.01, "{sum}");
    // It falls with about the square of the distance, from a few px to a third of the frame.
    let at = |r: usize| after[120 * 400 + 150 + r];
    for r in [12, 24, 48] {
        let slope = (at(r) / at(2 * r)).log2();
        assert!((1.2..3.2).contains(&slope), "from {r} px: r^-{slope}");
    }
}

/// Where an edge from dark to bright crosses the middle of its step, px.
fn edge_of(row: impl Iterator<Item = f64>) -> f64 {
    let row: Vec<f64> = row.collect();
    let at = row
        .windows(2)
        .position(|two| two[0] < 0.5 && two[1] >= 0.5)
        .unwrap();
    at as f64 + 0.5 + (0.5 - row[at]) / (row[at + 1] - row[at])
}

#[test]
fn red_and_blue_are_as_far_apart_as_is_said() {
    let optic = optic((1001, 41));
    for lateral_px in [0.5, 2.0, 8.0] {
        let lens = only(Fringes {
            lateral_px,
            axial_m: 0.0,
        });
        for edge_px in [990.0, 900.0] {
            // An edge as an image has it, over some pixels.
            let step = |x: f64| 0.5 + 0.5 * libm::erf((x - edge_px) / 4.0);
            let after = colors::<3>(&optic, &lens, |x, _| [step(x); 3]);
            let row = &after[20 * 3 * 1001..][..3 * 1001];
            let place = |c: usize| edge_of(row.iter().skip(c).step_by(3).copied());
            let share = (edge_px - 500.5) / 500.5_f64.hypot(20.5);
            let expected = lateral_px * share.powi(3);
            let found = place(0) - place(2);
            assert!(
                (found - expected).abs() < 0.02,
                "{lateral_px} at {edge_px}: {found}, not {expected}"
            );
            assert!((place(1) - edge_px).abs() < 0.02, "green stays");
            let last = &after[3 * 1000..3 * 1001];
            assert!(
                last.iter().all(|it| *it > 0.99),
                "the border goes on: {last:?}"
            );
        }
    }
}

#[test]
fn colors_that_are_sharp_elsewhere_are_blurred_alone() {
    let optic = optic((300, 101));
    // Discs of 6 px of red and blue.
    let axial_m = 6.0 * 2.0 * 4e-3 / 721.5377;
    let lens = only(Fringes {
        lateral_px: 0.0,
        axial_m,
    });
    let after = colors::<3>(&optic, &lens, |x, y| {
        [f64::from(u8::from(x.floor() == 150.0 && y.floor() == 50.0)); 3]
    });
    let middle = &after[(50 * 300 + 150) * 3..][..3];
    assert!((middle[1] - 1.0).abs() < 1e-6, "green is as it was");
    for color in [0, 2] {
        let expected = 1.0 / (PI * 9.0);
        assert!((middle[color] / expected - 1.0).abs() < 0.1, "{middle:?}");
    }
}

/// Places of a frame of KITTI, px, and where OpenCV's projectPoints and fisheye.projectPoints of these coefficients put
/// them (`validation/lens_opencv.py`); its pixels count from their middles.
const OPENCV: &str = include_str!("data/opencv_projection.txt");

#[test]
fn places_are_moved_as_opencv_moves_them() {
    let mut n = 0;
    for line in OPENCV.lines().filter(|line| !line.starts_with('#')) {
        let mut words = line.split_whitespace();
        let projection = match words.next().unwrap() {
            "brown" => Projection::Brown,
            _ => Projection::Fisheye,
        };
        let numbers: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        let [k1, k2, k3, k4, p1, p2, x, y, u, v] = numbers[..] else {
            panic!("{line}")
        };
        let fault = Distortion {
            projection,
            k: [k1, k2, k3, k4],
            p: [p1, p2],
            ..Distortion::NONE
        };
        let found = fault.moved([x, y], &kitti());
        let miss = (found[0] - u).hypot(found[1] - v);
        assert!(miss < 1e-3, "{line}: {found:?}");
        n += 1;
    }
    assert_eq!(n, 60, "all are read");
}

#[test]
fn a_picture_is_moved_as_its_points() {
    let optic = optic((640, 480));
    let brown = |k1| Distortion {
        k: [k1, 0.02, 0.0, 0.0],
        p: [0.002, -0.003],
        ..Distortion::NONE
    };
    let fisheye = Distortion {
        projection: Projection::Fisheye,
        k: [0.05, -0.01, 0.0, 0.0],
        ..Distortion::NONE
    };
    // It turns round beyond the frame.
    let turns = Distortion {
        k: [0.5, -0.8, 0.0, 0.0],
        ..Distortion::NONE
    };
    let all = gray(&optic, &only(turns), |_, _| 1.0);
    assert!(
        all.iter().all(|light| *light > 0.99),
        "places exist for all pixels"
    );
    let corner = Distortion {
        corner: 0.08,
        shift_px: [3.25, -7.5],
        ..Distortion::NONE
    };
    for fault in [brown(-0.25), brown(0.2), fisheye, corner] {
        for [x, y] in [[320.5, 240.5], [200.25, 120.0], [480.0, 350.75]] {
            let blob =
                |u: f64, v: f64| (-((u - x).powi(2) + (v - y).powi(2)) / (2.0 * 2.5 * 2.5)).exp();
            let after = gray(&optic, &only(fault), blob);
            let (mut sum, mut u, mut v) = (0.0, 0.0, 0.0);
            for (at, value) in after.iter().enumerate() {
                sum += value;
                u += value * ((at % 640) as f64 + 0.5);
                v += value * ((at / 640) as f64 + 0.5);
            }
            let expected = fault.moved([x, y], &optic);
            let miss = (u / sum - expected[0]).hypot(v / sum - expected[1]);
            // A blob is some pixels wide, over which the scale changes.
            assert!(miss < 0.05, "{fault:?} at {x}, {y}: {miss} px");
        }
    }
}

#[test]
fn a_corner_moves_as_far_as_is_said_and_masks_with_it() {
    let optic = kitti();
    let half_diagonal = 621.0_f64.hypot(187.5);
    let fault = Distortion {
        corner: 0.04,
        ..Distortion::NONE
    };
    let [x, y] = fault.moved([1242.0, 375.0], &optic);
    let moved = (x - 1242.0).hypot(y - 375.0);
    assert!((moved - 0.04 * half_diagonal).abs() < 1e-9, "{moved}");
    let lens = only(fault);
    assert!(lens.moves_labels());
    let places = lens.moved_places(&optic).unwrap();
    assert_eq!(
        places.seen_at([1242.0, 375.0]),
        Some([x, y]),
        "the same place"
    );
    // A mask moves as the picture does.
    let mut mask = image::GrayImage::new(1242, 375);
    mask.put_pixel(1000, 300, image::Luma([255]));
    let mask = lens.for_frames(&optic).moved_mask(mask);
    let to = fault.moved([1000.5, 300.5], &optic);
    let brightest = mask
        .enumerate_pixels()
        .max_by_key(|(_, _, code)| code.0[0])
        .unwrap();
    let miss = (f64::from(brightest.0) + 0.5 - to[0]).hypot(f64::from(brightest.1) + 0.5 - to[1]);
    assert!(miss < 1.0, "{miss} px");
    // A barrel shrinks the picture: around it is nothing.
    let barrel = only(Distortion {
        corner: -0.1,
        ..Distortion::NONE
    });
    let after = gray(&optic, &barrel, |_, _| 1.0);
    assert!(after[0].abs() < 1e-9, "black in the corner");
    assert!(
        (after[187 * 1242 + 621] - 1.0).abs() < 1e-6,
        "white in the middle"
    );
}

#[test]
fn what_no_frame_shows_has_no_place() {
    let optic = optic((640, 480));
    // It turns round at 82 % of the way to a corner: r² = 1/(3·0.5).
    let lens = only(Distortion {
        corner: -0.5,
        ..Distortion::NONE
    });
    let places = lens.moved_places(&optic).unwrap();
    let out = |share: f64| [320.0 + 320.0 * share, 240.0 + 240.0 * share];
    assert!(places.seen_at(out(0.81)).is_some(), "before the turn");
    assert_eq!(places.seen_at(out(0.83)), None, "behind it");
    for share in [-0.8, -0.3, 0.0, 0.1, 0.5, 0.7] {
        let at = out(share);
        let back = places
            .seen_at(at)
            .and_then(|at| places.shown_at(at))
            .unwrap();
        let miss = (back[0] - at[0]).hypot(back[1] - at[1]);
        assert!(miss < 1e-4, "there and back: {miss} px");
    }
    let blurs = only(Shading { corner_loss: 0.5 });
    assert!(blurs.moved_places(&optic).is_none(), "nothing moves");
}

#[test]
fn faults_of_nothing_are_none() {
    let mut lens = LensFaults::default();
    lens.push(0.0, Shading { corner_loss: 0.0 });
    lens.push(0.0, Glare { veil: 0.0 });
    lens.push(
        0.0,
        Defocus {
            sensor_shift_m: -0.0,
        },
    );
    lens.push(
        0.0,
        Fringes {
            lateral_px: 0.0,
            axial_m: 0.0,
        },
    );
    lens.push(0.0, Distortion::NONE);
    let still = Shake {
        rate_rad_s: 0.0,
        direction_rad: 1.0,
        frequency_hz: 9.0,
        exposure_s: 1.0,
    };
    lens.push(0.0, still);
    assert!(lens.faults().is_empty());
}

#[test]
fn clipped_lamps_are_as_bright_as_the_headroom_says() {
    let optic = optic((200, 200));
    let is_lamp = |px: f64| (100.0..102.0).contains(&px);
    let lamp = |x: f64, y: f64| f64::from(u8::from(is_lamp(x) && is_lamp(y)));
    let of = |headroom: f64| {
        let mut lens = LensFaults::with_headroom(headroom);
        lens.push(0.0, Glare { veil: 0.05 });
        let mut light: Vec<f32> = (0..40_000)
            .map(|k| lamp(f64::from(k % 200), f64::from(k / 200)) as f32)
            .collect();
        lens.unclip(&mut light, 1, 200);
        lens.for_frames(&optic)
            .over(&mut light, 1, None, (0.0, Seed(1)));
        f64::from(light[100 * 200 + 120])
    };
    assert!((of(50.0) / of(1.0) - 50.0).abs() < 0.01, "its glow, too");
}

#[test]
fn a_lamp_keeps_its_color() {
    let lens = LensFaults::with_headroom(40.0);
    let mut light = vec![0.0_f32; 60 * 60 * 3];
    let at = |k: usize| 3 * (60 * (10 + 20 * k) + 10 + 20 * k);
    for (k, color) in [[1.0, 0.05, 0.03], [1.0, 0.99, 0.97], [0.9; 3]]
        .iter()
        .enumerate()
    {
        for to in [0, 3, 180, 183] {
            light[at(k) + to..][..3].copy_from_slice(color);
        }
    }
    lens.unclip(&mut light, 3, 60);
    let red = &light[at(0)..][..3];
    assert!(
        (1.5..2.5).contains(&red[0]) && red[1] < 0.06 && red[2] < 0.04,
        "a signal: {red:?}"
    );
    let white = &light[at(1)..][..3];
    assert!(
        white[2] > 0.7 * white[0],
        "one that is nearly white: {white:?}"
    );
    assert_eq!(light[at(2)..][..3], [0.9; 3], "what is not clipped stays");
}

/// A frame with a disc of light 1, as large as an area in px, in darkness.
fn disc(area_px: f64) -> Vec<f32> {
    let radius = (area_px / PI).sqrt();
    let away = |k: u32| (f64::from(k % 400) - 200.0).hypot(f64::from(k / 400) - 150.0);
    let light = (0..120_000).map(|k| f32::from(u8::from(away(k) <= radius)));
    light.collect()
}

#[test]
fn what_is_clipped_is_the_brighter_the_smaller_it_is() {
    let lens = LensFaults::with_headroom(300.0);
    let brightest = |area_px: f64| {
        let mut light = disc(area_px);
        lens.unclip(&mut light, 1, 400);
        light.iter().fold(0.0_f32, |most, value| most.max(*value))
    };
    assert!(
        brightest(12.0) > 250.0,
        "a ten-thousandth of the frame is a lamp"
    );
    assert!(brightest(1.0) < 120.0, "a pixel may be a glint");
    let areas = [12.0, 100.0, 1e3, 1e4, 3e4, 5e4];
    for (small, large) in areas.iter().zip(&areas[1..]) {
        let (one, other) = (brightest(*small), brightest(*large));
        assert!(
            other - 1.0 < 0.7 * (one - 1.0),
            "{one} of {small} px, {other} of {large}"
        );
        assert!(other > 1.0, "{other}: brighter than white");
    }
    assert!(
        brightest(3e4) < 2.5,
        "a sky is but a little brighter than white"
    );
}

/// Clouds, snow and what compression makes of them have clipped pixels among others that nearly are.
#[test]
fn what_is_clipped_amid_light_is_no_lamp() {
    let lens = LensFaults::with_headroom(300.0);
    let brightest = |around: f32| {
        let mut light: Vec<f32> = disc(12.0).iter().map(|it| it.max(around)).collect();
        let brighter = lens.unclip(&mut light, 1, 400);
        let most = light.iter().fold(0.0_f32, |most, value| most.max(*value));
        let brighter: Vec<usize> = brighter.into_iter().flatten().collect();
        let above: Vec<usize> = (0..light.len()).filter(|at| light[*at] > 1.0).collect();
        assert_eq!(brighter, above, "these and no others, around {around}");
        most
    };
    let [night, dusk, sky] = [0.02, 0.25, 0.6].map(brightest);
    assert!(night > 250.0, "{night}");
    assert!((100.0..220.0).contains(&dusk), "{dusk}");
    assert!((sky - 1.0).abs() < 1e-6, "{sky}");
}

/// A gap between branches before a bright sky, which is a region of its own, is no lamp.
#[test]
fn what_is_clipped_beside_what_is_nearly_clipped_is_no_lamp() {
    let lens = LensFaults::with_headroom(300.0);
    let brightest = |sky: f32| {
        let mut light = disc(12.0);
        for (light, branches) in light.iter_mut().zip(disc(PI * 8.0 * 8.0)) {
            *light = if branches > 0.0 { light.max(0.02) } else { sky };
        }
        lens.unclip(&mut light, 1, 400);
        light.iter().fold(0.0_f32, |most, value| most.max(*value))
    };
    let [sky, night] = [0.95, 0.02].map(brightest);
    assert!(sky < 2.0, "hardly brighter than white: {sky}");
    assert!(night > 250.0, "{night}");
}

#[test]
fn a_lamp_is_brightest_in_its_middle_and_has_no_holes() {
    let lens = LensFaults::with_headroom(300.0);
    let mut light = disc(900.0);
    let middle = 150 * 400 + 200;
    // What compression leaves: a pixel of it is not clipped.
    light[middle + 5] = 0.93;
    lens.unclip(&mut light, 1, 400);
    assert!(
        light[middle] > 2.0 * light[middle + 14],
        "more than near its rim"
    );
    assert!(
        light[middle + 14] > light[middle + 16],
        "and there more than at it"
    );
    assert!(light[middle + 5] > 0.3 * light[middle + 4], "no hole");
    assert!(light[middle + 16] >= 1.0, "the rim is no darker");
}
