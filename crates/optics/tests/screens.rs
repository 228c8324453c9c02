//! Dew before a camera: how much light goes straight on, and where the rest goes.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use starbreak_deposit::{Area, Condensation, Field};
use starbreak_optics::screens::Screen;
use starbreak_optics::{Camera, View};
use starbreak_seed::Seed;

const SIZE: (u32, u32) = (600, 400);

fn screen(covered: f64, contrast: f64) -> Screen {
    let camera = Camera {
        f_px: 300.0,
        distance_m: 0.1,
        rake_rad: 0.0,
        axis_at_mm: [0.0; 2],
    };
    let view = View::through(&camera, SIZE).unwrap();
    let area = Area {
        from_mm: [-200.0; 2],
        to_mm: [200.0; 2],
    };
    let field = Field::over(&area, 60.0, contrast, Seed(1));
    let mut dew = Condensation {
        growth_m_s: 1e-9,
        age_s: 1.0,
        nuclei_per_m2: 4e8,
        contact_rad: 60.0_f64.to_radians(),
    };
    // As old as it is where this much is covered.
    while dew.drops(1.0).covered < covered {
        dew.age_s *= 1.002;
    }
    Screen::of(&dew, &field, &view, 300.0)
}

#[test]
fn an_even_scene_stays_even() {
    for n_colors in [1, 3] {
        let mut light = vec![0.4; 600 * 400 * n_colors];
        screen(0.3, 0.6).over(&mut light, n_colors);
        let worst = light.iter().map(|it| (it - 0.4).abs()).fold(0.0, f32::max);
        assert!(worst < 1e-4, "{worst}");
    }
}

#[test]
fn light_goes_straight_on_diffracted_and_refracted_by_shares() {
    for covered in [0.05, 0.15, 0.3, 0.45, 0.54] {
        let screen = screen(covered, 0.0);
        let [wide, narrow] = screen.halos_px();
        // (n − 1) sin θ/2, and 0.42 λ/D.
        assert!(
            (wide / (300.0 * 0.333 * 0.5 * 0.866) - 1.0).abs() < 0.01,
            "{wide}"
        );
        let mut light = vec![0.0_f32; 600 * 400];
        let at = 200 * 600 + 300;
        light[at] = 1e4;
        screen.over(&mut light, 1);
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
