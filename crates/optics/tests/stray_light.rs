//! Ghosts against an exact trace of the same lens, and stars against what edges diffract.
#![expect(clippy::cast_possible_truncation, reason = "px of a frame")]

use std::f64::consts::TAU;

use starbreak_optics::lens::Lens;
use starbreak_optics::lens_faults::{
    Distortion, Ghosts, Glare, Lamp, LensFace, LensFaults, Optic, Star,
};
use starbreak_seed::Seed;

/// A double Gauss lens of US patent 2,673,491, as by `validation/ghosts.py`.
const RADIUS: [f64; 11] = [
    29.475, 84.83, 19.275, 40.77, 12.75, 0.0, -14.495, 40.77, -20.385, 437.065, -39.73,
];
const GAP: [f64; 11] = [
    3.76, 0.12, 4.025, 3.275, 5.705, 4.5, 1.18, 6.065, 0.19, 3.22, 0.0,
];
const INDEX: [f64; 11] = [
    1.67, 1.0, 1.67, 1.699, 1.0, 1.0, 1.603, 1.658, 1.0, 1.717, 1.0,
];

/// Pairs of faces, the place of their ghost over the lamp's, and its radius at f/20 in focal lengths, by
/// `validation/ghosts.py`: rays that meet spheres and are bent in full.
const TRACED: [(usize, usize, f64, f64); 45] = [
    (0, 1, -1.9975, 0.18659),
    (0, 2, 1.1493, 0.02110),
    (0, 3, -1.2896, 0.13380),
    (0, 4, 1.1416, 0.05474),
    (0, 6, -0.9963, 0.00495),
    (0, 7, -0.2078, 0.10108),
    (0, 8, -1.0244, 0.04149),
    (0, 9, -2.8168, 0.07293),
    (0, 10, -1.0729, 0.04633),
    (1, 2, 0.4399, 0.03985),
    (1, 3, 1.5686, 0.03232),
    (1, 4, 0.3400, 0.03601),
    (1, 6, -0.4419, 0.04259),
    (1, 7, 0.2395, 0.02442),
    (1, 8, -0.4043, 0.03579),
    (1, 9, 1.2877, 0.00012),
    (1, 10, -0.4285, 0.03436),
    (2, 3, -1.9220, 0.20073),
    (2, 4, 0.9110, 0.02335),
    (2, 6, -0.9062, 0.01278),
    (2, 7, -0.0703, 0.08610),
    (2, 8, -1.0055, 0.02281),
    (2, 9, -2.4744, 0.07056),
    (2, 10, -1.0707, 0.02913),
    (3, 4, 0.3714, 0.04757),
    (3, 6, -0.5184, 0.05600),
    (3, 7, 0.2333, 0.03523),
    (3, 8, -0.4407, 0.04731),
    (3, 9, 2.0491, 0.01620),
    (3, 10, -0.4601, 0.04563),
    (4, 6, -0.8968, 0.04377),
    (4, 7, 0.1066, 0.08373),
    (4, 8, -1.1955, 0.00163),
    (4, 9, -2.5295, 0.08249),
    (4, 10, -1.2981, 0.01138),
    (6, 7, 2.7156, 0.17177),
    (6, 8, 1.0591, 0.03805),
    (6, 9, 2.8336, 0.07511),
    (6, 10, 1.1139, 0.04348),
    (7, 8, -1.2437, 0.11748),
    (7, 9, -0.7045, 0.07930),
    (7, 10, -1.4681, 0.09689),
    (8, 9, 2.0942, 0.06895),
    (8, 10, 1.0872, 0.00828),
    (9, 10, -0.1278, 0.06244),
];

fn double_gauss(reflectance: f64) -> Ghosts {
    let faces = (0..11).map(|k| LensFace {
        radius: RADIUS[k],
        gap: GAP[k],
        index: INDEX[k],
    });
    Ghosts {
        reflectance,
        faces: faces.collect(),
    }
}

fn optic() -> Optic {
    Optic {
        f_px: 900.0,
        lens: Lens {
            f_number: 2.0,
            ..Lens::default()
        },
        size: (901, 901),
    }
}

#[test]
fn ghosts_are_where_an_exact_trace_has_them_and_as_large() {
    let ghosts = double_gauss(0.01).of_lens(20.0);
    assert_eq!(ghosts.len(), TRACED.len());
    let mut n_narrow = 0;
    for (ghost, (i, j, at, radius)) in ghosts.iter().zip(TRACED) {
        assert!(
            (ghost.at - at).abs() < 0.004 + 0.004 * at.abs(),
            "{i} and {j}: at {}, not {at}",
            ghost.at
        );
        // A pupil wider than the front is cut by it.
        let found = ghost.radius.abs();
        if ghost.share < 1.68 {
            n_narrow += 1;
            assert!(
                (found / radius - 1.0).abs() < 0.02 || (found - radius).abs() < 1e-4,
                "{i} and {j}: {found}, not {radius}"
            );
        } else {
            assert!(found < radius, "{i} and {j}: {found}, beyond {radius}");
        }
    }
    assert!(n_narrow > 30, "{n_narrow}");
}

fn with(fault: impl Into<starbreak_optics::lens_faults::LensFault>) -> LensFaults {
    let mut lens = LensFaults::with_headroom(1.0);
    lens.push(0.0, fault);
    lens
}

/// A dark frame with one lamp, red, green and blue alike.
fn lamp(at: (usize, usize), light: f32) -> Vec<f32> {
    let mut frame = vec![0.0_f32; 901 * 901 * 3];
    frame[(at.1 * 901 + at.0) * 3..][..3].fill(light);
    frame
}

/// Σ R² of all pairs of the light of the pupil that passes, in green.
#[test]
fn ghosts_hold_what_two_faces_mirror() {
    let lens = with(double_gauss(0.02));
    // On the axis all ghosts are in the frame, but for the widest of them.
    let mut frame = lamp((450, 450), 1e6);
    lens.for_frames(&optic())
        .over(&mut frame, 3, None, (0.0, Seed(1)));
    frame[(450 * 901 + 450) * 3..][..3].fill(0.0);
    let green: f64 = frame
        .iter()
        .skip(1)
        .step_by(3)
        .map(|it| f64::from(*it))
        .sum();
    let ghosts = double_gauss(0.02).of_lens(2.0);
    // What of a disc is within the frame.
    let expected: f64 = ghosts
        .iter()
        .map(|it| {
            let radius = it.radius.abs() * 900.0;
            let inside = (0..400)
                .flat_map(|x| {
                    (0..400).map(move |y| [x, y].map(|k| (f64::from(k) + 0.5) / 200.0 - 1.0))
                })
                .filter(|[x, y]| x.hypot(*y) < 1.0)
                .map(|[x, y]| {
                    f64::from(u8::from(
                        (x * radius).abs() < 450.5 && (y * radius).abs() < 450.5,
                    ))
                })
                .collect::<Vec<_>>();
            let share = inside.iter().sum::<f64>() / inside.len() as f64;
            1e6 * 0.02 * 0.02 * it.share * share
        })
        .sum();
    assert!(
        (green / expected - 1.0).abs() < 0.03,
        "{green}, not {expected}"
    );
}

#[test]
fn ghosts_of_the_sun_beside_the_frame_lie_on_the_line_through_the_middle() {
    let lens = with(double_gauss(0.01));
    let direction = [0.45, -0.3, 1.0_f64];
    let length = direction.iter().map(|it| it * it).sum::<f64>().sqrt();
    let sun = Lamp::of_sun(direction.map(|it| it / length), [1.0; 3], &optic());
    let mut frame = vec![0.0_f32; 901 * 901 * 3];
    lens.for_frames(&optic())
        .over(&mut frame, 3, sun, (0.0, Seed(1)));
    let (mut along, mut all) = ([0.0; 2], 0.0);
    for (k, pixel) in frame.chunks_exact(3).enumerate() {
        let at = [(k % 901) as f64 - 450.0, (k / 901) as f64 - 450.0];
        let light = f64::from(pixel[1]);
        // Across the line to the sun there is as much on both sides.
        along[0] += light * (at[0] * 0.3 + at[1] * 0.45);
        along[1] += light * (at[0] * 0.45 - at[1] * 0.3).abs();
        all += light;
    }
    assert!(all > 0.0, "there are ghosts");
    assert!(along[0].abs() < 0.03 * along[1], "{along:?}");
    let behind = Lamp::of_sun([0.0, 0.0, -1.0], [1.0; 3], &optic());
    assert!(behind.is_none(), "behind the camera");
}

/// A dark frame of 400 × 300 px behind glare, with a sun, and with light in one pixel.
fn glare(sun: Option<Lamp>, pixel: Option<(usize, f32)>) -> Vec<f32> {
    let optic = Optic {
        f_px: 100.0,
        size: (400, 300),
        ..optic()
    };
    let mut lens = LensFaults::default();
    lens.push(0.0, Glare { veil: 0.02 });
    let mut frame = vec![0.0; 400 * 300];
    if let Some((at, light)) = pixel {
        frame[at] = light;
    }
    lens.for_frames(&optic)
        .over(&mut frame, 1, sun, (0.0, Seed(1)));
    frame
}

fn sun_at(at_px: [f64; 2]) -> Option<Lamp> {
    Some(Lamp {
        at_px,
        light: [1e4; 3],
        radius_px: 0.5,
    })
}

#[test]
fn the_sun_is_scattered_as_a_lamp_of_its_light_is() {
    let by_sun = glare(sun_at([230.5, 140.5]), None);
    let by_lamp = glare(None, Some((140 * 400 + 230, 1e4)));
    let in_ring = |frame: &[f32], [from, to]: [f64; 2]| -> f64 {
        let pixels = frame.iter().enumerate().filter(|(k, _)| {
            let (x, y) = ((k % 400) as f64, (k / 400) as f64);
            (from..to).contains(&(x - 230.0).hypot(y - 140.0))
        });
        pixels.map(|(_, light)| f64::from(*light)).sum()
    };
    // The lamp itself stays where it is.
    for ring in [
        [3.0, 6.0],
        [6.0, 12.0],
        [12.0, 24.0],
        [24.0, 48.0],
        [48.0, 96.0],
    ] {
        let [sun, lamp] = [&by_sun, &by_lamp].map(|frame| in_ring(frame, ring));
        assert!(
            (sun / lamp - 1.0).abs() < 0.02,
            "{ring:?} px: {sun} and {lamp}"
        );
    }
}

#[test]
fn a_sun_beside_the_frame_veils_the_side_towards_it_until_a_hood_shades_the_lens() {
    // Half a diagonal is 250 px.
    let beside = glare(sun_at([440.0, 150.0]), None);
    let [near, far] = [380, 20].map(|x| beside[150 * 400 + x]);
    assert!(near > 1e-3 && far < 1e-3 * near, "{near} and {far}");
    let shaded = glare(sun_at([200.0 + 375.0, 150.0]), None);
    assert!(shaded.iter().all(|light| *light <= 0.0), "in the shade");
    let none = glare(None, None);
    assert!(none.iter().all(|light| *light <= 0.0), "without a sun");
}

#[test]
fn a_lens_that_bends_lines_moves_the_sun_as_what_an_image_shows() {
    let mut lens = LensFaults::default();
    lens.push(
        0.0,
        Distortion {
            corner: 0.12,
            ..Distortion::NONE
        },
    );
    let optic = Optic {
        f_px: 300.0,
        size: (400, 300),
        ..optic()
    };
    let moved = lens
        .moved_places(&optic)
        .and_then(|moved| moved.seen_at([330.0, 60.0]));
    lens.push(0.0, Glare { veil: 0.02 });
    let mut frame = vec![0.0; 400 * 300];
    lens.for_frames(&optic)
        .over(&mut frame, 1, sun_at([330.0, 60.0]), (0.0, Seed(1)));
    let brightest = (0..frame.len()).max_by(|a, b| frame[*a].total_cmp(&frame[*b]));
    let (Some([u, v]), Some(at)) = (moved, brightest) else {
        panic!("a sun in the frame is seen");
    };
    let (x, y) = ((at % 400) as f64 + 0.5, (at / 400) as f64 + 0.5);
    assert!(u > 335.0, "it moves outwards, to {u}");
    assert!((x - u).hypot(y - v) < 1.0, "at {x}, {y}, not {u}, {v}");
}

/// Light in rings about the middle.
fn beyond(frame: &[f32], color: usize, px: f64) -> f64 {
    frame
        .chunks_exact(3)
        .enumerate()
        .filter(|(k, _)| ((k % 901) as f64 - 450.0).hypot((k / 901) as f64 - 450.0) > px)
        .map(|(_, pixel)| f64::from(pixel[color]))
        .sum()
}

#[test]
fn a_star_has_the_spikes_and_the_light_of_its_edges() {
    for (blades, n_spikes) in [(4, 4), (5, 10), (6, 6), (7, 14), (8, 8)] {
        let star = Star {
            blades,
            angle_rad: 0.2,
        };
        let mut frame = lamp((450, 450), 1000.0);
        with(star)
            .for_frames(&optic())
            .over(&mut frame, 3, None, (0.0, Seed(1)));
        for color in 0..3 {
            let all = beyond(&frame, color, -1.0);
            assert!(
                (all - 1000.0).abs() < 0.1,
                "no light is made or lost: {all}"
            );
            for px in [5.0, 20.0, 80.0] {
                // In the mean over a pixel, since light lies in whole ones. What is beyond where spikes end is in them.
                let (mut found, mut expected) = (0.0, 0.0);
                for k in -5..=5 {
                    let px = px + 0.1 * f64::from(k);
                    found += beyond(&frame, color, px) / 1000.0;
                    expected +=
                        star.beyond(px, &optic())[color] - star.beyond(400.0, &optic())[color];
                }
                assert!(
                    (found / expected - 1.0).abs() < 0.04,
                    "{blades}: {found}, not {expected} beyond {px}"
                );
            }
        }
        // Peaks along a circle of 60 px.
        let around: Vec<f64> = (0..720)
            .map(|k| {
                let (sin, cos) = (TAU * f64::from(k) / 720.0).sin_cos();
                let sum: f64 = (50..70)
                    .map(|r| {
                        let at = [450.5 + f64::from(r) * cos, 450.5 + f64::from(r) * sin];
                        f64::from(frame[(at[1] as usize * 901 + at[0] as usize) * 3 + 1])
                    })
                    .sum();
                sum
            })
            .collect();
        let half = 0.3 * around.iter().copied().fold(0.0, f64::max);
        let n = (0..720)
            .filter(|k| around[*k] > half && around[(k + 719) % 720] <= half)
            .count();
        assert_eq!(n, n_spikes, "{blades} blades");
    }
}

#[test]
fn nothing_brighter_than_white_has_no_star_and_no_ghost() {
    let mut frame: Vec<f32> = (0..901 * 901 * 3).map(|k| (k % 97) as f32 / 97.0).collect();
    let before = frame.clone();
    let star = Star {
        blades: 6,
        angle_rad: 0.0,
    };
    for lens in [with(star), with(double_gauss(0.04))] {
        lens.for_frames(&optic())
            .over(&mut frame, 3, None, (0.0, Seed(1)));
        assert!(frame == before, "as it was");
    }
    let none = Star { blades: 0, ..star };
    assert!(with(none).faults().is_empty());
    assert!(with(double_gauss(0.0)).faults().is_empty());
}

/// A disc of the diameter by the aperture's perimeter and area: 2 λ/(π² D θ), as of Airy's pattern far out.
#[test]
fn many_blades_spread_as_much_as_a_round_aperture() {
    let star = Star {
        blades: 24,
        angle_rad: 0.0,
    };
    let found = star.beyond(10.0, &optic())[1];
    let diameter_m = optic().lens.aperture_m();
    let theta = 10.0 / 900.0;
    let airy = 2.0 * 0.55e-6 / (std::f64::consts::PI.powi(2) * diameter_m * theta);
    assert!((found / airy - 1.0).abs() < 0.02, "{found}, not {airy}");
    let of = |f_number: f64| {
        let mut optic = optic();
        optic.lens.f_number = f_number;
        star.beyond(10.0, &optic)[1]
    };
    assert!(
        (of(4.0) / of(2.0) - 2.0).abs() < 1e-9,
        "half the aperture, twice the light"
    );
}
