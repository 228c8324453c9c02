//! Coats before a camera: how much light goes straight on, and where the rest goes.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use starbreak_deposit::{
    Area, Coat, Coating, Condensation, Dust, Film, Fog, Frost, Heating, Mud, Passage, Scratches,
};
use starbreak_optics::environment::{Environment, EnvironmentParams, Horizon};
use starbreak_optics::lens::Lens;
use starbreak_optics::lens_faults::Optic;
use starbreak_optics::screens::Screen;
use starbreak_optics::{Camera, View};
use starbreak_seed::Seed;

const SIZE: (u32, u32) = (600, 400);

const OPTIC: Optic = Optic {
    f_px: 300.0,
    lens: Lens {
        focal_length_m: 4e-3,
        f_number: 2.0,
        focus_m: 20.0,
        scene_m: 20.0,
        blades: 0,
        blade_angle_rad: 0.0,
    },
    size: (600, 400),
};

const AREA: Area = Area::rectangle([-200.0; 2], [200.0; 2]);

fn view(rake_rad: f64) -> View {
    let camera = Camera {
        f_px: 300.0,
        distance_m: 0.1,
        rake_rad,
        axis_at_mm: [0.0; 2],
    };
    View::through(&camera, SIZE).unwrap()
}

/// As bright all around, without a sun.
fn even(light: f32) -> Environment {
    Environment {
        horizon_rgb: [light; 3],
        zenith_rgb: [light; 3],
        ground_rgb: [light; 3],
        cabin_low_rgb: [light; 3],
        cabin_high_rgb: [light; 3],
        sun_rgb: [0.0; 3],
    }
}

fn of(coat: &Coat) -> Screen {
    let coating = coat.on_pane(&AREA, 0.3, Seed(1));
    Screen::of(&*coating, &view(0.0), &OPTIC)
}

fn over(screen: &Screen, light: &mut [f32], n_colors: usize, around: &Environment) {
    screen
        .under(around, &EnvironmentParams::default())
        .over(light, n_colors);
}

fn screen(covered: f64, contrast: f64) -> Screen {
    let mut dew = Condensation {
        growth_m_s: 1e-9,
        age_s: 1.0,
        clears_from_s: f64::INFINITY,
        clears_m_s: 0.0,
        nuclei_per_m2: 4e8,
        contact_rad: 60.0_f64.to_radians(),
    };
    // As old as it is where this much is covered.
    while dew.drops(1.0).covered < covered {
        dew.age_s *= 1.002;
    }
    of(&Coat::Fog(Fog {
        mean: dew,
        unevenness: contrast,
        scale_mm: 60.0,
        heated_by: Heating::Pane,
    }))
}

/// Coats that absorb nothing.
fn clear_coats() -> Vec<Coat> {
    vec![
        Coat::Mud(Mud {
            coverage: 0.2,
            splat_mm: 5.0,
            thickness_mm: 0.1,
            absorbs_per_mm: [0.0; 3],
            scatters_per_mm: 12.0,
        }),
        Coat::Dust(Dust {
            coverage: 0.1,
            albedo: 1.0,
            unevenness: 0.5,
            scale_mm: 50.0,
        }),
        Coat::Film(Film {
            ripple_m: 6e-6,
            scale_mm: 8.0,
            haze: 0.1,
        }),
        Coat::Frost(Frost {
            age_s: 900.0,
            melts_from_s: f64::INFINITY,
            melts_mm_s: 0.0,
            heated_by: Heating::Pane,
            front_mm_s: 0.03,
            nuclei_per_mm2: 1e-3,
            rime: 0.3,
        }),
        Coat::Scratches(Scratches {
            haze: 0.08,
            wiped: 0.5,
            pivot_mm: [-150.0, 300.0],
        }),
    ]
}

/// A furnace: where all is as bright, a coat that absorbs nothing is not seen.
#[test]
fn a_furnace_hides_every_coat() {
    for coat in clear_coats() {
        let screen = of(&coat);
        for n_colors in [1, 3] {
            let mut light = vec![0.4; 600 * 400 * n_colors];
            over(&screen, &mut light, n_colors, &even(0.4));
            let worst = light.iter().map(|it| (it - 0.4).abs()).fold(0.0, f32::max);
            assert!(worst < 2e-4, "{coat:?}: {worst}");
        }
    }
}

/// Light of one pixel, by its distance from there.
fn beyond(light: &[f32], at: (usize, usize), px: f64) -> f64 {
    let mut sum = 0.0;
    for (k, value) in light.iter().enumerate() {
        let (x, y) = (
            (k % 600) as f64 - at.0 as f64,
            (k / 600) as f64 - at.1 as f64,
        );
        if x.hypot(y) > px {
            sum += f64::from(*value);
        }
    }
    sum
}

/// A beam through a scratched pane, as a hazemeter measures it: the share beyond 2.5 degrees.
#[test]
fn a_beam_is_turned_by_more_than_two_and_a_half_degrees_as_much_as_the_haze_says() {
    // A long lens, so that 2.5 degrees are many px, and thirty are in the frame.
    for wiped in [0.0, 1.0] {
        let coat = Coat::Scratches(Scratches {
            haze: 0.04,
            wiped,
            pivot_mm: [-150.0, 300.0],
        });
        let coating = coat.on_pane(&AREA, 0.3, Seed(1));
        let optic = Optic {
            f_px: 900.0,
            ..OPTIC
        };
        let screen = Screen::of(&*coating, &view(0.0), &optic);
        // Streaks are on cells: in the mean of places of the beam.
        let mut mean = 0.0;
        for k in 0..16 {
            let at = (281 + 11 * (k % 4), 184 + 9 * (k / 4));
            let mut light = vec![0.0_f32; 600 * 400];
            light[at.1 * 600 + at.0] = 1e4;
            over(&screen, &mut light, 1, &even(0.0));
            let all = beyond(&light, at, -1.0) / 1e4;
            assert!((0.99..1.001).contains(&all), "{all}");
            // What leaves the frame is haze, too.
            let haze = 1.0 - all + beyond(&light, at, 900.0 * 2.5_f64.to_radians().tan()) / 1e4;
            assert!((haze - 0.04).abs() < 0.004, "{haze} at {at:?}");
            mean += haze / 16.0;
        }
        assert!(
            (mean - 0.04).abs() < 0.001,
            "{mean} of sand and wipers {wiped}"
        );
    }
}

#[test]
fn a_lamp_behind_wiped_glass_has_a_streak_that_points_at_the_wipers_pivot() {
    let pivot_mm = [-150.0, 300.0];
    let coat = Coat::Scratches(Scratches {
        haze: 0.08,
        wiped: 1.0,
        pivot_mm,
    });
    let mut light = vec![0.0_f32; 600 * 400];
    light[150 * 600 + 350] = 1e4;
    over(&of(&coat), &mut light, 1, &even(0.0));
    // Moments of what is far from the lamp.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (k, value) in light.iter().enumerate() {
        let (x, y) = ((k % 600) as f64 - 350.0, (k / 600) as f64 - 150.0);
        let away = x.hypot(y);
        if (20.0..120.0).contains(&away) {
            let value = f64::from(*value) / (away * away);
            (xx, xy, yy) = (xx + value * x * x, xy + value * x * y, yy + value * y * y);
        }
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    // The pivot in the frame: 3 px per mm from its middle.
    let [x, y] = [
        300.0 + 3.0 * pivot_mm[0] - 350.0,
        200.0 + 3.0 * pivot_mm[1] - 150.0,
    ];
    let off = (angle - y.atan2(x)).to_degrees().rem_euclid(180.0);
    assert!(off.min(180.0 - off) < 2.0, "{off} degrees");
    let long = 0.5 * (xx + yy) + (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
    assert!(long / (xx + yy) > 0.95, "a line: {}", long / (xx + yy));
}

/// On a pane that leans: the streak of a lamp is across the picture of the groove, which follows from two of its places.
#[test]
fn a_streak_is_across_the_picture_of_its_groove_on_a_raked_pane() {
    let pivot_mm = [-120.0, 90.0];
    let view = view(0.8);
    let scratches = Scratches {
        haze: 0.08,
        wiped: 1.0,
        pivot_mm,
    };
    let coating = Coat::Scratches(scratches).on_pane(&AREA, 0.3, Seed(1));
    let screen = Screen::of(&*coating, &view, &OPTIC);
    let lamp = [350.5, 150.5];
    let mut light = vec![0.0_f32; 600 * 400];
    light[150 * 600 + 350] = 1e4;
    over(&screen, &mut light, 1, &even(0.0));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (k, value) in light.iter().enumerate() {
        let (x, y) = (
            (k % 600) as f64 + 0.5 - lamp[0],
            (k / 600) as f64 + 0.5 - lamp[1],
        );
        let away = x.hypot(y);
        if (8.0..40.0).contains(&away) {
            let value = f64::from(*value) / (away * away);
            (xx, xy, yy) = (xx + value * x * x, xy + value * x * y, yy + value * y * y);
        }
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    // A step along the circle about the pivot.
    let at = view.unproject(lamp).unwrap();
    let from_pivot = [at[0] - pivot_mm[0], at[1] - pivot_mm[1]];
    let step = [at[0] - 1e-3 * from_pivot[1], at[1] + 1e-3 * from_pivot[0]];
    let [a, b] = [at, step].map(|at| view.project(at).unwrap());
    let groove = (b[1] - a[1]).atan2(b[0] - a[0]);
    let off = (angle - groove - 0.5 * std::f64::consts::PI)
        .to_degrees()
        .rem_euclid(180.0);
    assert!(off.min(180.0 - off) < 3.0, "{off} degrees");
}

/// A prism that turns all light by one angle moves a picture by f times that.
struct Prism([f64; 2]);

impl Coating for Prism {
    fn passage(&self, _: [f64; 2]) -> Passage {
        Passage {
            turned_rad: self.0,
            ..Passage::CLEAN
        }
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [0.0; 2]
    }
}

#[test]
fn a_prism_moves_the_picture_by_its_angle() {
    let prism = Prism([4.0 / 300.0, -2.5 / 300.0]);
    let screen = Screen::of(&prism, &view(0.0), &OPTIC);
    let ramp = |x: usize, y: usize| 0.2 + 1e-3 * x as f32 + 5e-4 * y as f32;
    let mut light: Vec<f32> = (0..600 * 400).map(|k| ramp(k % 600, k / 600)).collect();
    over(&screen, &mut light, 1, &even(0.0));
    for (x, y) in [(100, 100), (300, 200), (500, 300)] {
        let found = light[y * 600 + x] - ramp(x, y);
        let expected = 4.0 * 1e-3 - 2.5 * 5e-4;
        assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
    }
    assert!(screen.reaches(0.01).iter().all(|it| *it), "all is moved");
}

/// The sun beside the frame on dusty glass: a veil, brighter towards the sun; over the whole sphere it is what the grains
/// send on.
#[test]
fn dust_in_the_sun_veils_the_picture_towards_it() {
    let coat = Coat::Dust(Dust {
        coverage: 0.1,
        albedo: 0.9,
        unevenness: 0.0,
        scale_mm: 50.0,
    });
    let screen = of(&coat);
    let sun = Environment {
        sun_rgb: [10.0; 3],
        ..even(0.0)
    };
    let params = EnvironmentParams {
        sun_azimuth_rad: 1.0,
        sun_elevation_rad: 0.2,
        ..EnvironmentParams::default()
    };
    let mut light = vec![0.0_f32; 600 * 400];
    screen.under(&sun, &params).over(&mut light, 1);
    let [left, right] = [100, 500].map(|x| light[200 * 600 + x]);
    assert!(right > 1.5 * left && left > 0.0, "{left} and {right}");
    // c ω 0.8 E p(θ), p by its own formula, in the mean of a part of the frame.
    let towards = Horizon::level().sun(1.0, 0.2);
    let g = (-0.35_f64 * 0.35).exp();
    let (mut found, mut expected) = (0.0, 0.0);
    for (x, y) in (350..550).flat_map(|x| (100..300).map(move |y| (x, y))) {
        let at = [x as f64 + 0.5 - 300.0, y as f64 + 0.5 - 200.0, 300.0_f64];
        let length = at.iter().map(|it| it * it).sum::<f64>().sqrt();
        let cos = (0..3).map(|k| at[k] * towards[k]).sum::<f64>() / length;
        let p =
            (1.0 - g * g) / (4.0 * std::f64::consts::PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5));
        expected += 0.1 * 0.9 * 0.8 * 10.0 * p;
        found += f64::from(light[y * 600 + x]);
    }
    let ratio = found / expected;
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    // From behind the camera the sun does not reach the outer face.
    let behind = EnvironmentParams {
        sun_azimuth_rad: 3.0,
        ..params
    };
    let mut light = vec![0.0_f32; 600 * 400];
    screen.under(&sun, &behind).over(&mut light, 1);
    assert!(light.iter().all(|it| *it <= 0.0), "no light");
}

#[test]
fn an_even_scene_stays_even() {
    for n_colors in [1, 3] {
        let mut light = vec![0.4; 600 * 400 * n_colors];
        over(&screen(0.3, 0.6), &mut light, n_colors, &even(0.4));
        let worst = light.iter().map(|it| (it - 0.4).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-4, "{worst}");
    }
}

#[test]
fn light_goes_straight_on_diffracted_and_refracted_by_shares() {
    for covered in [0.05, 0.15, 0.3, 0.45, 0.54] {
        let screen = screen(covered, 0.0);
        let [narrow, wide] = screen.halos_px();
        // (n − 1) sin θ/2, and 0.42 λ/D.
        assert!(
            (wide / (300.0 * 0.333 * 0.5 * 0.866) - 1.0).abs() < 0.01,
            "{wide}"
        );
        let mut light = vec![0.0_f32; 600 * 400];
        let at = 200 * 600 + 300;
        light[at] = 1e4;
        over(&screen, &mut light, 1, &even(0.0));
        let sum: f64 = light.iter().map(|it| f64::from(*it)).sum();
        assert!((sum / 1e4 - 1.0).abs() < 0.01, "{sum}");
        // What is not in the lamp's own pixel is in its halos; those give that pixel little.
        let c = covered;
        let halos = c / (std::f64::consts::TAU * wide * wide) + c * (1.0 - c) * of_middle(narrow);
        let direct = f64::from(light[at]) / 1e4 - halos;
        assert!(
            (direct - (1.0 - c) * (1.0 - c)).abs() < 0.01,
            "{c}: {direct}, not {}",
            (1.0 - c) * (1.0 - c)
        );
        // The second moment of what is far is that of what is refracted.
        let (mut far, mut moment) = (0.0, 0.0);
        for (k, value) in light.iter().enumerate() {
            let (x, y) = ((k % 600) as f64 - 300.0, (k / 600) as f64 - 200.0);
            if x.hypot(y) > 6.0 * narrow {
                far += f64::from(*value);
                moment += f64::from(*value) * x * x;
            }
        }
        let (far, sigma) = (far / 1e4, (moment / far).sqrt());
        assert!((far - c).abs() < 0.05, "{c}: {far} far away");
        assert!((sigma / wide - 1.0).abs() < 0.15, "{sigma}, not {wide}");
    }
}

/// Share of a Gaussian in its middle pixel.
fn of_middle(sigma: f64) -> f64 {
    let edge = libm::erf(0.5 / (sigma * std::f64::consts::SQRT_2));
    edge * edge
}

#[test]
fn it_reaches_where_it_is() {
    let none = screen(0.0, 0.0);
    assert!(none.reaches(0.01).iter().all(|it| !it), "no dew");
    let all = screen(0.3, 0.0);
    assert!(all.reaches(0.01).iter().all(|it| *it), "all over");
    assert!(
        (all.mean_covered() - 0.3).abs() < 0.01,
        "{}",
        all.mean_covered()
    );
}

/// Frames whose last cells are cut off by their border, with a lamp there.
#[test]
fn no_streak_makes_light_at_the_border() {
    let size = (601, 402);
    let optic = Optic {
        size: (601, 402),
        ..OPTIC
    };
    let camera = Camera {
        f_px: 300.0,
        distance_m: 0.1,
        rake_rad: 0.0,
        axis_at_mm: [0.0; 2],
    };
    let scratches = Coat::Scratches(Scratches {
        haze: 0.2,
        wiped: 1.0,
        pivot_mm: [-150.0, 300.0],
    });
    let coating = scratches.on_pane(&AREA, 0.3, Seed(1));
    let screen = Screen::of(&*coating, &View::through(&camera, size).unwrap(), &optic);
    for at in [(600, 200), (300, 401), (600, 401), (300, 200)] {
        let mut light = vec![0.0_f32; 601 * 402];
        light[at.1 * 601 + at.0] = 1e4;
        over(&screen, &mut light, 1, &even(0.0));
        let all = light.iter().map(|it| f64::from(*it)).sum::<f64>() / 1e4;
        // Streaks that point out of the frame leave it.
        assert!((0.1..1.001).contains(&all), "{all} of a lamp at {at:?}");
    }
}

/// A disc through which nothing goes.
struct Disc;

impl Coating for Disc {
    fn passage(&self, [x, y]: [f64; 2]) -> Passage {
        match libm::hypot(x, y) < 20.0 {
            true => Passage {
                direct: [0.0; 3],
                ..Passage::CLEAN
            },
            false => Passage::CLEAN,
        }
    }

    fn turns_by_rad(&self) -> [f64; 2] {
        [0.0; 2]
    }
}

#[test]
fn what_a_coat_reaches_is_what_it_changes_pixel_by_pixel() {
    let screen = Screen::of(&Disc, &view(0.0), &OPTIC);
    let mut light = vec![1.0_f32; 600 * 400 * 3];
    over(&screen, &mut light, 3, &even(0.0));
    let (reached, mut n_reached) = (screen.reaches(0.01), 0);
    for (k, (pixel, is_reached)) in light.chunks_exact(3).zip(&reached).enumerate() {
        let lost = 1.0 - pixel[0];
        if (lost - 0.01).abs() > 1e-4 {
            assert_eq!(
                *is_reached,
                lost > 0.01,
                "column {}, row {}: {lost} is lost",
                k % 600,
                k / 600
            );
        }
        n_reached += u32::from(*is_reached);
    }
    assert!((10_000..100_000).contains(&n_reached), "{n_reached} pixels");
    for (pixel, passes) in light.chunks_exact(3).zip(screen.passing()) {
        assert!(
            (pixel[0] - passes).abs() < 1e-5,
            "{} passes, {passes}",
            pixel[0]
        );
    }
}
