//! What the physical optics may not do to light: lose it, make it, or take away what is not there.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use image::{DynamicImage, ImageBuffer, Rgb};
use starbreak_glass::CrackNetwork;
use starbreak_optics::environment::{Environment, EnvironmentParams};
use starbreak_optics::lens::Lens;
use starbreak_optics::physical::{Glass, Overlay, PhysicalOptics, SurfaceParams, bake};
use starbreak_optics::{Camera, View};
use starbreak_seed::Seed;

const SIZE: (u32, u32) = (160, 100);

/// Legs of every zone about a crushed hit, thin enough to be colored.
fn network() -> CrackNetwork {
    CrackNetwork::from_json(
        r#"{"schema":"starbreak.crack-network/1","generator":{"name":"test","version":"1"},"model":"imported",
        "unit":"mm","pane":{"width":1400.0,"height":800.0},
        "impacts":[{"x":700.0,"y":400.0,"crushed_radius_mm":1.5}],
        "nodes":{"x":[700.0,712.0,695.0,708.0,688.0],"y":[400.0,398.0,391.0,409.0,404.0]},
        "segments":{"from":[0,0,0,0,1,2],"to":[1,2,3,4,3,4],
        "kind":["radial","radial","cone","radial","ring","ring"],
        "opening_um":[0.2,10.0,0.3,0.05,0.5,3.0],"depth_fraction":[0.9,0.7,1.0,0.8,1.0,0.5],
        "tilt_deg":[3.0,-8.0,60.0,0.0,50.0,20.0]}}"#,
    )
    .unwrap()
}

fn overlay(rake_deg: f64, optics: &PhysicalOptics, environment: &Environment) -> Overlay {
    let camera = Camera {
        f_px: 120.0,
        distance_m: 0.03,
        rake_rad: rake_deg.to_radians(),
        axis_at_mm: [700.0, 400.0],
    };
    let view = View::through(&camera, SIZE).unwrap();
    let pattern = bake(&network(), f64::INFINITY, &view, optics, Seed(3)).unwrap();
    assert!(!pattern.is_intact(), "nothing to be seen");
    pattern.light(environment, optics)
}

fn optics(f_number: f64, fragment_wedge_deg: f64) -> PhysicalOptics {
    PhysicalOptics {
        lens: Lens {
            f_number,
            ..Lens::default()
        },
        surface: SurfaceParams {
            fragment_wedge_deg,
            film: 8.0,
            chip: 5.0,
            ..SurfaceParams::default()
        },
        // What the faces hold comes from the rim: one that returns it all, at no distance.
        glass: Glass {
            rim_reflectance: 1.0,
            rim_way_mm: 0.0,
            ..Glass::default()
        },
        environment: EnvironmentParams {
            // What is beyond the border is known; the light comes later.
            horizon_rgb: Some([0.0; 3]),
            zenith_rgb: Some([0.0; 3]),
            ground_rgb: Some([0.0; 3]),
            ..EnvironmentParams::default()
        },
        ..PhysicalOptics::default()
    }
}

fn light(sky: f32, ground: f32, cabin: f32, sun: f32) -> Environment {
    Environment {
        horizon_rgb: [sky; 3],
        zenith_rgb: [sky; 3],
        ground_rgb: [ground; 3],
        cabin_low_rgb: [cabin; 3],
        cabin_high_rgb: [cabin; 3],
        sun_rgb: [sun; 3],
    }
}

fn constant(code: u16) -> DynamicImage {
    ImageBuffer::from_pixel(SIZE.0, SIZE.1, Rgb([code; 3])).into()
}

/// Linear light of a code of 16 bits \[IEC61966\].
fn decoded(code: u16) -> f64 {
    let code = f64::from(code) / 65535.0;
    if code <= 0.040_45 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}

#[test]
fn a_crack_in_even_light_is_not_seen() {
    for code in [2000_u16, 20_000, 47_000, 65_535] {
        #[expect(clippy::cast_possible_truncation, reason = "light as f32")]
        let even = decoded(code) as f32;
        for (f_number, wedge_deg) in [(0.5, 0.0), (2.0, 0.0), (22.0, 0.0), (128.0, 4.0)] {
            for rake_deg in [-60.0, 0.0, 60.0] {
                let optics = optics(f_number, wedge_deg);
                let overlay = overlay(rake_deg, &optics, &light(even, even, even, 0.0));
                let mut image = constant(code);
                overlay.apply(&mut image, Seed(3)).unwrap();
                let most = image
                    .to_rgb16()
                    .as_raw()
                    .iter()
                    .map(|&found| found.abs_diff(code))
                    .max();
                // A quarter of a step of an 8-bit image.
                assert!(
                    most.unwrap() <= 64,
                    "off by {most:?} of 65535 at {code}, f/{f_number}, {rake_deg}°"
                );
            }
        }
    }
}

#[test]
fn the_maps_make_the_image_of_fragments_and_cracks() {
    let optics = optics(8.0, 5.0);
    let overlay = overlay(20.0, &optics, &light(0.6, 0.1, 0.02, 0.0));
    let maps = overlay.maps();
    let code = 40_000;
    let mut image = constant(code);
    overlay.apply(&mut image, Seed(3)).unwrap();
    let light = decoded(code);
    let out = image.to_rgb16();
    assert!(
        maps.elsewhere.iter().filter(|share| **share > 0.5).count() > 1000,
        "no fragments"
    );
    for (k, pixel) in out.pixels().enumerate() {
        let added = maps.added[k].iter().copied().map(f64::from).sum::<f64>() / 3.0;
        let kept = 1.0 - f64::from(maps.attenuation[k]) + f64::from(maps.elsewhere[k]);
        let expected = light * kept + added;
        let found = pixel.0.iter().map(|&code| decoded(code)).sum::<f64>() / 3.0;
        assert!(
            (found - expected).abs() < 2e-3,
            "pixel {k}: {found}, not {expected}"
        );
    }
}

#[test]
fn beside_a_glint_no_light_is_taken_away() {
    for f_number in [0.95, 2.0, 8.0, 22.0, 128.0] {
        let optics = optics(f_number, 0.0);
        let overlay = overlay(30.0, &optics, &light(0.0, 0.0, 0.0, 1e5));
        let maps = overlay.maps();
        let added = maps.added.iter().flatten().copied();
        let (least, most) = added.fold((0.0_f32, 0.0_f32), |(least, most), light| {
            (least.min(light), most.max(light))
        });
        assert!(most > 1.0, "no glint at f/{f_number}");
        assert!(least >= 0.0, "{least} beside {most} at f/{f_number}");
    }
}

#[test]
fn light_is_moved_as_far_as_the_maps_say() {
    // Where two layers move light the maps hold the mean of two vectors, which is shorter.
    for (wedge_deg, slack) in [(0.0, 1e-4), (5.0, 0.1)] {
        let optics = optics(8.0, wedge_deg);
        let overlay = overlay(20.0, &optics, &light(0.6, 0.1, 0.02, 0.0));
        let maps = overlay.maps();
        for (xs, ys) in [
            ([0, SIZE.0], [0, SIZE.1]),
            ([70, 95], [40, 61]),
            ([3, 4], [5, 6]),
        ] {
            let (mut light, mut moved) = (0.0, 0.0);
            for y in ys[0]..ys[1] {
                for x in xs[0]..xs[1] {
                    let at = (y * SIZE.0 + x) as usize;
                    let share = f64::from(maps.elsewhere[at]);
                    let [u, v] = maps.displacement[at].map(f64::from);
                    light += 1.0 - f64::from(maps.attenuation[at]) + share;
                    moved += share * u.hypot(v);
                }
            }
            let expected = moved / light;
            let found = overlay.mean_displacement_px(xs, ys);
            assert!(
                found >= expected * 0.9999 && found <= (1.0 + slack) * expected + 1e-9,
                "{xs:?} {ys:?}: {found} px, not {expected}"
            );
        }
        let at_the_hit = overlay.mean_displacement_px([70, 95], [40, 61]);
        assert!(at_the_hit > 0.1, "mirrors move the scene: {at_the_hit} px");
    }
}
