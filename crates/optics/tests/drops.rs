//! Drops on the outer face: what they show against angles by hand, and that they neither make nor lose light.
#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a test may panic"
)]

use image::{DynamicImage, ImageBuffer, Rgb};
use starbreak_deposit::{Area, Cap, Deposit, Outline, Rain};
use starbreak_glass::CrackNetwork;
use starbreak_optics::environment::{Environment, EnvironmentParams};
use starbreak_optics::lens::Lens;
use starbreak_optics::physical::{Glass, KeptDrops, PhysicalOptics, bake};
use starbreak_optics::srgb::{decode16, encode16};
use starbreak_optics::{Camera, View};
use starbreak_seed::{Seed, Stream, uniform};

const WATER: f64 = 1.333;

fn light(scene: f32, cabin: f32) -> Environment {
    Environment {
        horizon_rgb: [scene; 3],
        zenith_rgb: [scene; 3],
        ground_rgb: [scene; 3],
        cabin_low_rgb: [cabin; 3],
        cabin_high_rgb: [cabin; 3],
        sun_rgb: [0.0; 3],
    }
}

/// A camera before a thin pane, focused on it.
struct Close {
    size: (u32, u32),
    f_px: f64,
    distance_m: f64,
    rake_deg: f64,
    rim_reflectance: f64,
    /// Radius of the disc that a point of the pane becomes, px; the scene is sharp.
    blur_px: f64,
}

impl Close {
    /// An image, as the light of each pixel, behind drops; the environment begins at its border.
    fn behind(
        &self,
        caps: Vec<Cap>,
        environment: &Environment,
        scene: impl Fn(f64, f64) -> [f64; 3],
    ) -> Vec<[f64; 3]> {
        // The light comes later.
        let known = EnvironmentParams {
            horizon_rgb: Some([0.0; 3]),
            zenith_rgb: Some([0.0; 3]),
            ground_rgb: Some([0.0; 3]),
            ..EnvironmentParams::default()
        };
        self.behind_within(known, caps, environment, scene)
    }

    /// The same where that is known of the environment.
    fn behind_within(
        &self,
        known: EnvironmentParams,
        caps: Vec<Cap>,
        environment: &Environment,
        scene: impl Fn(f64, f64) -> [f64; 3],
    ) -> Vec<[f64; 3]> {
        let (width, height) = self.size;
        let (view, optics) = self.set_up(known);
        let none = CrackNetwork::without_cracks(width, height);
        let pattern = bake(&none, f64::INFINITY, &view, &optics, Seed(1)).unwrap();
        let pattern = pattern.behind(&Deposit { caps }, &view, &optics).unwrap();
        assert!(!pattern.is_intact(), "drops are in the frame");
        let mut image = DynamicImage::ImageRgb16(ImageBuffer::from_fn(width, height, |x, y| {
            let light = scene(f64::from(x) + 0.5, f64::from(y) + 0.5);
            Rgb(light.map(|value| encode16(value as f32)))
        }));
        pattern
            .light(environment, &optics)
            .apply(&mut image, Seed(1))
            .unwrap();
        let codes = image.into_rgb16();
        codes
            .pixels()
            .map(|pixel| pixel.0.map(|code| f64::from(decode16(code))))
            .collect()
    }

    /// The camera, with its lens and the pane.
    fn set_up(&self, known: EnvironmentParams) -> (View, PhysicalOptics) {
        let camera = Camera {
            f_px: self.f_px,
            distance_m: self.distance_m,
            rake_rad: self.rake_deg.to_radians(),
            axis_at_mm: [0.0; 2],
        };
        // On the pane, or so far beyond it that the pupil's image on it is its disc.
        let (focus_m, focal_length_m, pupil_m) = match self.blur_px {
            px if px > 0.0 => {
                let pupil_m = 2.0 * px * self.distance_m / self.f_px;
                (1e6, f64::max(4e-3, 2.0 * pupil_m), pupil_m)
            }
            _ => (self.distance_m, 1e-3, 1e-5),
        };
        let optics = PhysicalOptics {
            lens: Lens {
                focal_length_m,
                f_number: focal_length_m / pupil_m,
                focus_m,
                scene_m: focus_m,
                ..Lens::default()
            },
            glass: Glass {
                thickness_mm: 0.1,
                interlayer_mm: 0.0,
                inner_ply_mm: 0.0,
                rim_reflectance: self.rim_reflectance,
                rim_way_mm: 0.0,
                ..Glass::default()
            },
            environment: known,
            ..PhysicalOptics::default()
        };
        (View::through(&camera, self.size).unwrap(), optics)
    }
}

fn cap(radius_mm: f64, degrees: f64) -> Cap {
    Cap {
        at_mm: [0.0; 2],
        radius_mm,
        contact_rad: degrees.to_radians(),
        outline: Outline::default(),
    }
}

#[test]
fn a_frame_shows_the_middle_of_what_a_wider_one_shows() {
    // Uneven drops anywhere before a camera, half of them where a pane that leans passes above the pupil, before it and behind
    // it: from so near nothing changes evenly, and outlines, as far beyond a drop as the frame is, mean nothing any more.
    let outlines = uneven(35.0, 8);
    let mut n_seen = 0;
    for trial in 0..1000 {
        let mut rng = Seed(trial).stream(Stream::Rain, 0);
        let [a, b, c, d, e, f, g] = [(); 7].map(|()| uniform(&mut rng));
        let rake_rad = (75.0 * a).to_radians();
        let camera = Camera {
            f_px: 100.0 * 10.0_f64.powf(b),
            distance_m: 0.02 * 25.0_f64.powf(c),
            rake_rad,
            axis_at_mm: [0.0; 2],
        };
        let distance_mm = camera.distance_m * 1e3;
        let radius_mm = 0.3 * 20.0_f64.powf(d);
        let down_mm = match trial % 2 {
            0 => (e - 0.5) * distance_mm,
            _ => (e - 0.5) * radius_mm - distance_mm / rake_rad.sin(),
        };
        let cap = Cap {
            at_mm: [(f - 0.5) * distance_mm, down_mm],
            outline: outlines[(8.0 * g) as usize],
            ..cap(radius_mm, 35.0)
        };
        let seen_in = |(width, height): (u32, u32)| {
            let view = View::through(&camera, (width, height)).unwrap();
            let optics = PhysicalOptics {
                glass: Glass {
                    thickness_mm: 5.0,
                    ..Glass::default()
                },
                ..PhysicalOptics::default()
            };
            let none = CrackNetwork::without_cracks(width, height);
            let pattern = bake(&none, f64::INFINITY, &view, &optics, Seed(1)).unwrap();
            let caps = vec![cap];
            let pattern = pattern.behind(&Deposit { caps }, &view, &optics).unwrap();
            let mut image = DynamicImage::ImageRgb16(ImageBuffer::from_pixel(
                width,
                height,
                Rgb([encode16(0.5); 3]),
            ));
            let light = light(0.5, 0.0);
            let lit = pattern.light(&light, &optics);
            lit.apply(&mut image, Seed(1)).unwrap();
            (image.into_rgb16(), !pattern.is_intact())
        };
        let ((narrow, is_seen), (wide, _)) = (seen_in((80, 60)), seen_in((240, 180)));
        n_seen += usize::from(is_seen);
        let mut sum = 0.0;
        for (x, y, pixel) in narrow.enumerate_pixels() {
            let [one, other] = [pixel, wide.get_pixel(x + 80, y + 60)];
            sum += (f64::from(one.0[1]) - f64::from(other.0[1])).abs() / 257.0;
        }
        let mean = sum / f64::from(narrow.width() * narrow.height());
        assert!(mean < 0.2, "{mean} codes: {camera:?}, {cap:?}");
    }
    assert!(n_seen > 100, "{n_seen} are in the frame");
}

/// The outlines of some drops of rain that are farthest from round.
fn uneven(degrees: f64, n: usize) -> Vec<Outline> {
    let rain = Rain {
        contact_rad: degrees.to_radians(),
        ..Rain::default()
    };
    let area = Area::rectangle([0.0; 2], [200.0; 2]);
    let mut outlines: Vec<Outline> = (rain.on_pane(&area, Seed(3)).caps.iter())
        .map(|cap| cap.outline)
        .collect();
    outlines.sort_by(|a, b| b.reach().total_cmp(&a.reach()));
    assert!(
        outlines[n].reach() > 1.1,
        "{degrees}: they are hardly uneven"
    );
    outlines.truncate(n);
    outlines
}

/// Where a ray along a pixel goes through an uneven drop on the axis, as the tangent of its angle to the axis right and down,
/// by looking for the surface along it and by differences of its height; none near where it is reflected totally, or
/// at the rim.
fn seen_through(cap: &Cap, distance_mm: f64, at_mm: [f64; 2]) -> Option<[f64; 2]> {
    let sphere_mm = cap.sphere_mm();
    let height_mm = |at_mm: [f64; 2]| {
        let level = cap
            .outline
            .round_place(at_mm.map(|part| part / cap.radius_mm))
            .level;
        let sine = cap.contact_rad.sin();
        sphere_mm * ((1.0 - sine * sine * level).sqrt() - cap.contact_rad.cos())
    };
    let length = (at_mm[0] * at_mm[0] + at_mm[1] * at_mm[1] + distance_mm * distance_mm).sqrt();
    let along = at_mm.map(|part| part / length / WATER);
    let forward = (1.0 - along[0] * along[0] - along[1] * along[1]).sqrt();
    let reached = |t: f64| [0, 1].map(|k| at_mm[k] + t * along[k]);
    let is_within = |t: f64| height_mm(reached(t)) > t * forward;
    if !is_within(0.0) {
        return None;
    }
    let (mut low, mut high) = (0.0, 3.0 * cap.radius_mm);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match is_within(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    let at = reached(low);
    if height_mm(at) < 0.1 * cap.height_mm() {
        return None;
    }
    let step = 1e-5;
    let rises = [0, 1].map(|k| {
        let [mut to, mut from] = [at, at];
        to[k] += step;
        from[k] -= step;
        (height_mm(to) - height_mm(from)) / (2.0 * step)
    });
    let by = 1.0 / (1.0 + rises[0] * rises[0] + rises[1] * rises[1]).sqrt();
    let (normal, ahead) = (rises.map(|rise| -by * rise), by);
    let cos = along[0] * normal[0] + along[1] * normal[1] + forward * ahead;
    let sine_square = WATER * WATER * (1.0 - cos * cos);
    if sine_square > 0.9 {
        return None;
    }
    let more = (1.0 - sine_square).sqrt() - WATER * cos;
    let out = [0, 1].map(|k| WATER * along[k] + more * normal[k]);
    Some(out.map(|part| part / (WATER * forward + more * ahead)))
}

/// The tangent of the angle to the axis at which a drop on the axis shows the world, at a distance from its middle, mm, by
/// angles in the plane; none near where it reflects totally.
fn seen_tan(cap: &Cap, distance_mm: f64, at_mm: f64) -> Option<f64> {
    let contact = cap.contact_rad;
    let sphere = cap.radius_mm / contact.sin();
    let in_air = (at_mm / distance_mm).atan();
    let in_water = (in_air.sin() / WATER).asin();
    // The law of sines in the triangle of the ray's beginning, the center of the sphere and where the ray meets it.
    let depth = sphere * contact.cos();
    let from_center = at_mm.hypot(depth);
    let polar = at_mm.atan2(depth);
    let incident = (from_center / sphere * (polar - in_water).sin()).asin();
    let normal = in_water + incident;
    let sine = WATER * incident.sin();
    // Where it is nearly reflected totally, a pixel shows much.
    (sine < 0.95).then(|| (normal - sine.asin()).tan())
}

/// Near a pane, with a wide view.
const NEAR: Close = Close {
    size: (800, 600),
    f_px: 240.0,
    distance_m: 0.02,
    rake_deg: 0.0,
    rim_reflectance: 0.0,
    blur_px: 0.0,
};

/// Light of a place in such a frame that says where it is from.
fn light_of_place(x: f64, y: f64) -> [f64; 3] {
    [0.1 + 0.8 * x / 800.0, 0.1 + 0.8 * y / 600.0, 0.5]
}

/// Where light is from: what is mirrored inside is lost, and the colors keep their ratio.
fn place_of_light([red, green, blue]: [f64; 3]) -> [f64; 2] {
    [(red, 800.0), (green, 600.0)].map(|(color, side)| (color / blue * 0.5 - 0.1) / 0.8 * side)
}

#[test]
fn a_drop_shows_the_scene_where_angles_say() {
    let mut n = 0;
    for degrees in [30.0, 45.0, 60.0, 75.0, 90.0] {
        let cap = cap(2.0, degrees);
        let shown = NEAR.behind(vec![cap], &light(0.0, 0.0), light_of_place);
        for to in [-0.75_f64, -0.5, -0.3, 0.3, 0.5, 0.75] {
            let x = (400.0 + 240.0 * to * 2.0 / 20.0).floor();
            let at_mm = (x + 0.5 - 400.0).abs() * 20.0 / 240.0;
            let Some(tan) = seen_tan(&cap, 20.0, at_mm) else {
                continue;
            };
            let expected = 400.0 + 240.0 * tan * to.signum();
            // Towards the axis and beyond it.
            if !(60.0..740.0).contains(&expected) {
                continue;
            }
            let [found, _] = place_of_light(shown[300 * 800 + x as usize]);
            // A pixel is a twentieth of the drop wide.
            assert!(
                (found - expected).abs() < 4.0,
                "{degrees} degrees at {to}: {found}, not {expected}"
            );
            n += 1;
        }
    }
    assert!(n > 20, "{n} places of 30 are asked");
}

#[test]
fn an_uneven_drop_shows_the_scene_where_rays_through_its_surface_go() {
    let (mut n, mut squares, mut of_round) = (0.0, 0.0, 0.0);
    for outline in uneven(50.0, 6) {
        let cap = Cap {
            outline,
            ..cap(2.0, 50.0)
        };
        let shown = NEAR.behind(vec![cap], &light(0.0, 0.0), light_of_place);
        for (x, y) in (-30..30).flat_map(|y| (-30..30).map(move |x| (x, y))) {
            let at_mm = [x, y].map(|px| (f64::from(px) + 0.5) * 20.0 / 240.0);
            let round = Cap {
                outline: Outline::default(),
                ..cap
            };
            let [Some(tan), Some(round)] = [&cap, &round].map(|cap| seen_through(cap, 20.0, at_mm))
            else {
                continue;
            };
            let expected = [400.0 + 240.0 * tan[0], 300.0 + 240.0 * tan[1]];
            if !(60.0..740.0).contains(&expected[0]) || !(60.0..540.0).contains(&expected[1]) {
                continue;
            }
            let found = place_of_light(shown[((300 + y) * 800 + 400 + x) as usize]);
            let off = [0, 1].map(|k| found[k] - expected[k]);
            let other = [0, 1].map(|k| 240.0 * (round[k] - tan[k]));
            squares += off[0] * off[0] + off[1] * off[1];
            of_round += other[0] * other[0] + other[1] * other[1];
            n += 1.0;
        }
    }
    let [off_px, round_px] = [squares, of_round].map(|sum| f64::sqrt(sum / n));
    assert!(n > 3000.0, "{n} places");
    assert!(off_px < 1.0, "{off_px} px, round drops {round_px}");
    assert!(round_px > 20.0, "{round_px}");
}

#[test]
fn the_rim_is_dark_from_where_it_reflects_totally() {
    // So far that rays are along the axis.
    let camera = Close {
        size: (900, 60),
        f_px: 200_000.0,
        distance_m: 1.0,
        rake_deg: 0.0,
        rim_reflectance: 0.0,
        blur_px: 0.0,
    };
    for degrees in [55.0_f64, 60.0, 75.0, 89.0] {
        let shown = camera.behind(vec![cap(2.0, degrees)], &light(1.0, 0.0), |_, _| [1.0; 3]);
        let row: Vec<f64> = shown[30 * 900 + 450..31 * 900]
            .iter()
            .map(|pixel| pixel[0])
            .collect();
        let expected = 400.0 / (WATER * degrees.to_radians().sin());
        let dark = row.iter().position(|light| *light < 0.35).unwrap() as f64 + 0.5;
        assert!(
            (dark / expected - 1.0).abs() < 0.01,
            "{degrees}: {dark}, not {expected}"
        );
        assert!(
            row[..300 * 9 / 10].iter().all(|light| *light > 0.8),
            "{degrees}: bright within"
        );
        assert!(
            row[410..].iter().all(|light| *light > 0.99),
            "{degrees}: bright beside it"
        );
    }
    let shown = camera.behind(vec![cap(2.0, 40.0)], &light(1.0, 0.0), |_, _| [1.0; 3]);
    let row = &shown[30 * 900 + 450..31 * 900];
    let darkest = row.iter().map(|pixel| pixel[0]).fold(1.0, f64::min);
    assert!(darkest > 0.7, "a flat drop has no rim: {darkest}");
}

#[test]
fn a_drop_loses_what_its_faces_reflect_and_not_what_bare_glass_has_lost() {
    // Sight along the normal: water to air 2.0 %, where glass to air has taken 4.3 %.
    let camera = Close {
        size: (900, 60),
        f_px: 200_000.0,
        distance_m: 1.0,
        rake_deg: 0.0,
        rim_reflectance: 0.0,
        blur_px: 0.0,
    };
    let shown = camera.behind(vec![cap(2.0, 40.0)], &light(0.5, 0.0), |_, _| [0.5; 3]);
    let of_face = |n: f64| ((n - 1.0) / (n + 1.0)).powi(2);
    let expected = 0.5 * (1.0 - of_face(WATER)) / (1.0 - of_face(1.52));
    let found = shown[30 * 900 + 450][0];
    assert!((found - expected).abs() < 0.003, "{found}, not {expected}");
}

#[test]
fn drops_neither_make_nor_lose_light() {
    for (rake_deg, degrees) in [(0.0, 50.0), (60.0, 50.0), (-40.0, 100.0), (60.0, 20.0)] {
        let camera = Close {
            size: (300, 200),
            f_px: 200.0,
            distance_m: 0.02,
            rake_deg,
            rim_reflectance: 1.0,
            blur_px: 0.0,
        };
        let uneven = match degrees < 80.0 {
            true => uneven(degrees, 40),
            false => vec![Outline::default(); 40],
        };
        let caps = (0..40).zip(uneven).map(|(k, outline)| {
            let [x, y] = [f64::from(k % 8), f64::from(k / 8)].map(|place| 3.1 * (place - 3.0));
            Cap {
                at_mm: [x, y],
                radius_mm: 0.3 + 0.03 * f64::from(k),
                contact_rad: f64::to_radians(degrees),
                outline,
            }
        });
        let shown = camera.behind(caps.collect(), &light(0.5, 0.5), |_, _| [0.5; 3]);
        let worst = shown
            .iter()
            .flatten()
            .map(|light| (light - 0.5).abs())
            .fold(0.0, f64::max);
        assert!(worst < 2e-3, "rake {rake_deg}, contact {degrees}: {worst}");
    }
}

/// Before a narrow view nearly all of a drop shows the light beside it, so that the sum of what it adds says how much of
/// the frame it covers.
#[test]
fn a_drop_covers_its_footprint_however_few_pixels_that_has() {
    let added_per_footprint = |radius_px: f64, blur_px: f64, outline: Outline| {
        let side = 2 * (1.3 * radius_px + blur_px + 4.0).ceil() as u32;
        let camera = Close {
            size: (side, side),
            f_px: 500.0 * radius_px,
            distance_m: 1.0,
            rake_deg: 0.0,
            rim_reflectance: 0.0,
            blur_px,
        };
        let cap = Cap {
            outline,
            ..cap(2.0, 40.0)
        };
        let shown = camera.behind(vec![cap], &light(1.0, 0.0), |_, _| [0.2; 3]);
        let added: f64 = shown.iter().map(|light| light[0] - 0.2).sum();
        added / (std::f64::consts::PI * radius_px * radius_px)
    };
    let round = Outline::default();
    let expected = added_per_footprint(40.0, 0.0, round);
    let sizes = [(0.5, 0.0), (2.0, 0.0), (2.9, 0.0), (0.3, 0.6), (1.0, 0.7)];
    let blurred = [(0.4, 1.2), (1.4, 1.05), (0.8, 2.5), (1.4, 3.9), (2.0, 6.0)];
    for (radius_px, blur_px) in sizes.into_iter().chain(blurred) {
        let found = added_per_footprint(radius_px, blur_px, round);
        assert!(
            (found / expected - 1.0).abs() < 0.04,
            "radius {radius_px} px, blur {blur_px} px: {found}, not {expected}"
        );
    }
    // A flat one, whose edge is not dark, has the area of its circle.
    for outline in uneven(40.0, 6) {
        for (radius_px, blur_px) in [(20.0, 0.0), (4.0, 0.0), (6.0, 5.0), (1.0, 0.5)] {
            let found = added_per_footprint(radius_px, blur_px, outline);
            assert!(
                (found / expected - 1.0).abs() < 0.04,
                "{outline:?}, radius {radius_px} px, blur {blur_px} px: {found}, not {expected}"
            );
        }
    }
}

/// The edge from which on light is reflected totally takes its share of a drop of any size, wherever its cells lie.
#[test]
fn small_drops_are_as_dark_as_large_ones() {
    let lost = |degrees: f64, radius_px: f64, blur_px: f64, offset_px: [f64; 2]| {
        let side = 2 * (radius_px + blur_px + 5.0).ceil() as u32;
        let f_px = 500.0 * radius_px;
        let camera = Close {
            size: (side, side),
            f_px,
            distance_m: 1.0,
            rake_deg: 0.0,
            rim_reflectance: 0.0,
            blur_px,
        };
        let caps = vec![Cap {
            at_mm: offset_px.map(|px| px * 1000.0 / f_px),
            ..cap(2.0, degrees)
        }];
        let shown = camera.behind(caps, &light(0.8, 0.0), |_, _| [0.8; 3]);
        let lost: f64 = shown.iter().map(|light| 0.8 - light[0]).sum();
        lost / (std::f64::consts::PI * radius_px * radius_px)
    };
    for degrees in [50.0, 60.0, 75.0, 90.0] {
        let expected = lost(degrees, 60.0, 0.0, [0.0; 2]);
        for (radius_px, blur_px) in [
            (0.5, 2.5),
            (1.0, 2.5),
            (1.3, 1.5),
            (2.0, 2.5),
            (5.0, 2.5),
            (1.0, 0.0),
            (2.5, 0.0),
        ] {
            let offsets =
                (0..64).map(|k| [f64::from(k % 8), f64::from(k / 8)].map(|k| 0.125 * k + 0.03));
            let found = offsets
                .map(|at| lost(degrees, radius_px, blur_px, at))
                .sum::<f64>()
                / 64.0;
            let off = found - expected;
            assert!(
                off.abs() < 0.045,
                "contact {degrees}°, radius {radius_px} px, blur {blur_px} px: {found}, not {expected}"
            );
        }
    }
}

/// A drop on the axis shows the frame in its middle and the environment around that, with an edge where that is known, and
/// without one where it is estimated: as much of each as the way says by which the place that is seen lies beyond the border.
#[test]
fn the_border_of_the_frame_fades_in_a_drop() {
    let camera = Close {
        size: (160, 160),
        f_px: 400.0,
        distance_m: 0.02,
        rake_deg: 0.0,
        rim_reflectance: 0.0,
        blur_px: 0.0,
    };
    let drop = cap(3.0, 60.0);
    let (environment, scene) = (light(1.0, 0.0), |_: f64, _: f64| [0.2; 3]);
    let row = |shown: Vec<[f64; 3]>| -> Vec<f64> {
        // Where light is not reflected totally, up to 52 px from the middle.
        let row = &shown[80 * 160..81 * 160][30..130];
        row.iter().map(|light| light[0]).collect()
    };
    let hard = row(camera.behind(vec![drop], &environment, scene));
    let estimated = EnvironmentParams::default();
    let soft = row(camera.behind_within(estimated, vec![drop], &environment, scene));
    let largest_step = |row: &[f64]| {
        let steps = row.windows(2).map(|two| (two[1] - two[0]).abs());
        steps.fold(0.0, f64::max)
    };
    let [edge, none] = [&hard, &soft].map(|row| largest_step(row));
    assert!(edge > 0.4, "the border is an edge: {edge}");
    assert!(none < 0.15, "it is none: {none}");
    for (x, (hard, soft)) in hard.iter().zip(&soft).enumerate() {
        let tangent = seen_through(&drop, 20.0, [(x as f64 + 30.5 - 80.0) * 0.05, 0.0]);
        let beyond = (tangent.unwrap()[0].abs() - 0.2).max(0.0);
        let near = (1.0 - beyond / 0.5).max(0.0);
        let frame = near * near * (3.0 - 2.0 * near);
        // What it shows of all light: near 1 where the environment alone is seen.
        let all = if beyond > 0.02 { *hard } else { 0.96 };
        let expected = all * (0.2 * frame + 1.0 - frame);
        assert!(
            (soft - expected).abs() < 0.03,
            "{x}: {soft}, not {expected}"
        );
    }
}

/// A drop just beside the frame is seen as far as its blur reaches, also through a pane that is thicker than it is far
/// away, which makes it appear nearer to the middle than it is.
#[test]
fn a_drop_beside_the_frame_reaches_into_it() {
    let camera = |size, thickness_mm: f64| {
        let camera = Camera {
            f_px: 300.0,
            distance_m: 0.002,
            rake_rad: 0.0,
            axis_at_mm: [0.0; 2],
        };
        let optics = PhysicalOptics {
            lens: Lens {
                focal_length_m: 4e-3,
                f_number: 4e-3 / 1e-4,
                focus_m: 1e6,
                scene_m: 1e6,
                ..Lens::default()
            },
            glass: Glass {
                thickness_mm,
                interlayer_mm: 0.0,
                inner_ply_mm: 0.0,
                ..Glass::default()
            },
            ..PhysicalOptics::default()
        };
        (View::through(&camera, size).unwrap(), optics)
    };
    let (view, optics) = camera((400, 300), 5.0);
    let none = CrackNetwork::without_cracks(400, 300);
    let is_seen = |x_mm: f64| {
        let caps = vec![Cap {
            at_mm: [x_mm, 0.0],
            ..cap(0.2, 50.0)
        }];
        let pattern = bake(&none, f64::INFINITY, &view, &optics, Seed(1)).unwrap();
        !pattern
            .behind(&Deposit { caps }, &view, &optics)
            .unwrap()
            .is_intact()
    };
    let last = (0..500)
        .map(|k| 0.02 * f64::from(k))
        .filter(|x| is_seen(*x))
        .fold(0.0, f64::max);
    // The side of the frame looks at an angle of tan 2/3. A ray of that which enters at the rim of the pupil comes to
    // 0.05 mm + 2 mm · 2/3 + 5 mm · tan asin(sin/1.52) = 3.34 mm from the axis; and the drop has 0.2 mm.
    let sin = (2.0_f64 / 3.0).atan().sin() / 1.52;
    let expected = 0.05 + 2.0 * 2.0 / 3.0 + 5.0 * sin / (1.0 - sin * sin).sqrt() + 0.2;
    assert!(
        (-0.05..0.2).contains(&(last - expected)),
        "{last} mm, not {expected}"
    );
}

#[test]
fn a_drop_out_of_focus_is_the_sharp_one_spread_by_the_disc() {
    let camera = |blur_px: f64| Close {
        size: (400, 300),
        f_px: 240.0,
        distance_m: 0.02,
        rake_deg: 0.0,
        rim_reflectance: 0.0,
        blur_px,
    };
    // Of which a drop shows some fields.
    let scene = |x: f64, y: f64| {
        let is_light = ((x / 50.0).floor() + (y / 50.0).floor()) as i32 % 2 == 0;
        [if is_light { 0.8 } else { 0.1 }; 3]
    };
    for (radius_mm, blur_px) in [(1.0, 12.0), (2.5, 12.0), (0.5, 12.0), (2.0, 4.0)] {
        let caps = || vec![cap(radius_mm, 60.0)];
        let sharp = camera(0.0).behind(caps(), &light(0.4, 0.1), scene);
        let found = camera(blur_px).behind(caps(), &light(0.4, 0.1), scene);
        let radius_px = radius_mm * 12.0;
        let is_drop = |x: f64, y: f64| (x - 200.0).hypot(y - 150.0) < radius_px;
        let (mut square, mut worst, mut n) = (0.0, 0.0_f64, 0.0);
        for (x, y) in (150..250).flat_map(|x| (100..200).map(move |y| (x, y))) {
            let (mut sum, mut all, mut shown) = (0.0, 0.0, 0.0);
            let reach = blur_px.ceil() as i32;
            for (dx, dy) in (-reach..=reach).flat_map(|dx| (-reach..=reach).map(move |dy| (dx, dy)))
            {
                if f64::from(dx).hypot(f64::from(dy)) <= blur_px {
                    let at = [x + dx, y + dy];
                    all += 1.0;
                    if is_drop(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5) {
                        shown += 1.0;
                        sum += sharp[(at[1] * 400 + at[0]) as usize][0];
                    }
                }
            }
            if shown > 0.0 {
                let own = scene(f64::from(x) + 0.5, f64::from(y) + 0.5)[0];
                let expected = (sum + (all - shown) * own) / all;
                let off = (found[(y * 400 + x) as usize][0] - expected).abs();
                square += off * off;
                worst = worst.max(off);
                n += 1.0;
            }
        }
        let rms = f64::sqrt(square / n);
        assert!(
            rms < 0.07 && worst < 0.3,
            "radius {radius_mm} mm, blur {blur_px} px: {rms}, {worst}"
        );
    }
}

/// Beside the camera, nearly in the plane in which it looks at nothing, a drop and its blur are as large as they are far from
/// the frame: none of it may come there.
#[test]
fn drops_beside_the_camera_are_not_seen() {
    let camera = Camera {
        f_px: 2000.0,
        distance_m: 0.15,
        rake_rad: 50.0_f64.to_radians(),
        axis_at_mm: [0.0; 2],
    };
    let optics = PhysicalOptics::default();
    let size = (2560, 1440);
    let view = View::through(&camera, size).unwrap();
    // Where z = d + y sin ρ is 0.
    let plane_mm = -150.0 / camera.rake_rad.sin();
    let places = (0..200).map(|k| [f64::from(k % 20) * 30.0 - 290.0, f64::from(k / 20) * 0.2]);
    let caps: Vec<Cap> = (places.zip(uneven(50.0, 200)))
        .map(|([x, y], outline)| Cap {
            at_mm: [x, plane_mm + y],
            outline,
            ..cap(1.5, 50.0)
        })
        .collect();
    let none = CrackNetwork::without_cracks(size.0, size.1);
    let pattern = bake(&none, f64::INFINITY, &view, &optics, Seed(1)).unwrap();
    let pattern = pattern.behind(&Deposit { caps }, &view, &optics).unwrap();
    assert!(pattern.is_intact(), "nothing of them is in the frame");
}

#[test]
fn drops_that_are_kept_are_seen_as_before() {
    // Sharp ones of so many cells that there is no room for the last; and blurred ones.
    for (blur_px, radius_mm, others) in [(0.0, 47.0, 0), (7.0, 4.0, 300)] {
        let close = Close {
            size: (400, 400),
            f_px: 400.0,
            distance_m: 0.15,
            rake_deg: 30.0,
            rim_reflectance: 0.5,
            blur_px,
        };
        let (view, optics) = close.set_up(EnvironmentParams::default());
        let kept = KeptDrops::default();
        let at = |[x, y]: [f64; 2], radius_mm| Cap {
            at_mm: [x, y],
            radius_mm,
            contact_rad: 0.7,
            outline: Outline::default(),
        };
        let large: Vec<Cap> = (0..4)
            .map(|k| at([[-50.0, 50.0][k % 2], [-50.0, 50.0][k / 2]], radius_mm))
            .collect();
        // Some of them too small to be seen in parts.
        let small: Vec<Cap> = (0..others)
            .map(|k| {
                at(
                    [
                        f64::from(k % 20) * 6.0 - 60.0,
                        f64::from(k / 20) * 6.0 - 20.0,
                    ],
                    0.05 * f64::from(k % 9),
                )
            })
            .collect();
        let all = [large.clone(), small.clone()].concat();
        let mut fewer = all.clone();
        fewer.drain(1..3);
        let mut another = all.clone();
        another[0].contact_rad = 0.5;
        let back: Vec<Cap> = all.iter().rev().copied().collect();
        for (what, caps) in [
            ("all", &all),
            ("all again", &all),
            ("fewer", &fewer),
            ("more", &all),
            ("another in a place", &another),
            ("another order", &back),
            ("small ones", &small),
        ] {
            let deposit = Deposit { caps: caps.clone() };
            let images = [None, Some(&kept)].map(|kept| {
                let none = CrackNetwork::without_cracks(400, 400);
                let pattern = bake(&none, f64::INFINITY, &view, &optics, Seed(1)).unwrap();
                let pattern = match kept {
                    Some(kept) => pattern.behind_kept(&deposit, &view, &optics, kept),
                    None => pattern.behind(&deposit, &view, &optics),
                };
                let mut image = DynamicImage::ImageRgb16(ImageBuffer::from_fn(400, 400, |x, y| {
                    Rgb([x, y, 7 * x % 250].map(|value| 150 * value as u16))
                }));
                let overlay = pattern.unwrap().light(&light(0.4, 0.1), &optics);
                overlay.apply(&mut image, Seed(1)).unwrap();
                image
            });
            assert!(images[0] == images[1], "{what}, blurred by {blur_px} px");
        }
    }
}
