//! The physics of one surface against closed forms, and against numbers of Mitsuba 3.9.1.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::PI;
use std::path::Path;

use proptest::prelude::*;
use rand_chacha::rand_core::Rng;
use serde_json::Value;
use starbreak_optics::interface::fresnel::{
    reflect, reflectance, refract, slab_reflectance, slab_transmittance,
};
use starbreak_optics::interface::gap::{GapTable, gap_reflectance};
use starbreak_optics::interface::ggx::{Glint, distribution, g1, sample_visible_normal};
use starbreak_seed::{Seed, Stream};

const N: f64 = 1.52;

/// A table of reference numbers.
fn reference(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn cos_deg(degrees: f64) -> f64 {
    degrees.to_radians().cos()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

fn add(a: f64, x: [f64; 3], b: f64, y: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a * x[i] + b * y[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn polar(theta_deg: f64, phi_deg: f64) -> [f64; 3] {
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    let (sp, cp) = phi_deg.to_radians().sin_cos();
    [sin * cp, sin * sp, cos]
}

fn uniform(rng: &mut impl Rng) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "53 bits")]
    let x = (rng.next_u64() >> 11) as f64;
    x * 2_f64.powi(-53)
}

// Fresnel

#[test]
fn fresnel_is_the_sine_and_tangent_law() {
    // R_s = sin²(i−t)/sin²(i+t), R_p = tan²(i−t)/tan²(i+t): another form of the same equations.
    for eta in [N, 1.0 / N, 1.33, 2.0] {
        for degree in 1..90 {
            let i = f64::from(degree).to_radians();
            let sin_t = i.sin() / eta;
            let expected = if sin_t >= 1.0 {
                1.0
            } else {
                let t = sin_t.asin();
                let s = (i - t).sin() / (i + t).sin();
                let p = (i - t).tan() / (i + t).tan();
                (s * s + p * p) / 2.0
            };
            let got = reflectance(i.cos(), eta);
            assert!(
                (got - expected).abs() < 1e-12,
                "{degree}° with index {eta}: {got}, expected {expected}"
            );
        }
    }
}

#[test]
fn fresnel_and_slab_are_the_reference_numbers() {
    let numbers = reference("crack_optics_numbers.json");
    let check = |table: &str, tolerance: f64, f: &dyn Fn(f64) -> f64| {
        for (degrees, expected) in numbers[table].as_object().unwrap() {
            let got = f(cos_deg(degrees.parse().unwrap()));
            let expected = expected.as_f64().unwrap();
            assert!(
                (got - expected).abs() < tolerance,
                "{table} at {degrees}°: {got}, expected {expected}"
            );
        }
    };
    check("fresnel_air_to_glass", 5.1e-5, &|cos| reflectance(cos, N));
    // From R of four digits.
    check("slab_T=(1-R)/(1+R)", 1.6e-4, &|cos| {
        slab_transmittance(cos, N)
    });
    let critical = numbers["critical_angle_deg"].as_f64().unwrap();
    for (beside, total) in [(-1e-6, false), (1e-6, true)] {
        let r = reflectance(cos_deg(critical + beside), 1.0 / N);
        assert_eq!(r >= 1.0, total, "{beside}° from the critical angle R = {r}");
    }
}

#[test]
fn a_clean_perpendicular_crack_mirrors_every_ray_that_came_through_a_face() {
    let mut least = f64::INFINITY;
    for theta in 0..90 {
        for phi in (0..360).step_by(5) {
            let outside = polar(f64::from(theta), f64::from(phi));
            let inside = refract(outside, [0.0, 0.0, 1.0], 1.0 / N).unwrap();
            least = least.min(inside[0].abs().acos().to_degrees());
            assert!(
                reflectance(inside[0], 1.0 / N) >= 1.0,
                "{theta}°, {phi}°: not totally reflected"
            );
        }
    }
    assert!((least - 48.86).abs() < 0.02, "the steepest is {least}°");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn snell_holds_and_the_way_back_is_the_way(
        theta in 0.0..89.9_f64, phi in 0.0..360.0_f64, tilt in 0.0..180.0_f64, n in 1.01..2.0_f64,
    ) {
        let normal = polar(tilt, 20.0);
        let d = polar(theta, phi);
        prop_assume!(dot(d, normal).abs() > 1e-6);
        let inside = refract(d, normal, 1.0 / n).unwrap();
        prop_assert!((dot(inside, inside) - 1.0).abs() < 1e-12, "of unit length");
        let sine = |v: [f64; 3]| { let c = cross(v, normal); dot(c, c).sqrt() };
        prop_assert!((sine(d) - n * sine(inside)).abs() < 1e-9, "Snell's law");
        prop_assert!(dot(cross(d, normal), inside).abs() < 1e-9, "in the plane of incidence");
        prop_assert!(dot(d, normal) * dot(inside, normal) > 0.0, "it goes on, not back");
        let out = refract(inside, normal, n).unwrap();
        prop_assert!(out.iter().zip(d).all(|(a, b)| (a - b).abs() < 1e-7), "and out again");
        let mirrored = reflect(d, normal);
        prop_assert!((dot(mirrored, normal) + dot(d, normal)).abs() < 1e-12, "mirrored");
        prop_assert!((sine(mirrored) - sine(d)).abs() < 1e-9, "at the same angle");
        let there = reflectance(dot(d, normal), n);
        let back = reflectance(dot(inside, normal), 1.0 / n);
        prop_assert!((there - back).abs() < 1e-7, "R is the same from both sides");
        let c = dot(d, normal);
        prop_assert!((slab_transmittance(c, n) + slab_reflectance(c, n) - 1.0).abs() < 1e-12, "T + R");
    }
}

#[test]
fn beyond_the_critical_angle_nothing_is_refracted() {
    let z = [0.0, 0.0, 1.0];
    assert!(refract(polar(41.2, 0.0), z, N).is_none(), "above 41.14°");
    let last = refract(polar(41.1, 0.0), z, N).unwrap();
    assert!(last[2] > 0.0 && last[2] < 0.05, "below it, at a graze");
}

// Air gap

/// A complex number, for the textbook's form of the film.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn times(self, o: Self) -> Self {
        Self(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
    fn plus(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
    fn scaled(self, k: f64) -> Self {
        Self(k * self.0, k * self.1)
    }
    fn over(self, o: Self) -> Self {
        self.times(Self(o.0, -o.1)).scaled(1.0 / o.square())
    }
    fn square(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
}

/// Reflected and transmitted power by the amplitudes of one face and the phase of one crossing,
/// complex where the light in the film is evanescent: r (1 − e²)/(1 − r² e²) and
/// t t′ e/(1 − r² e²).
fn film(cos: f64, gap_m: f64, wavelength_m: f64, n: f64) -> [f64; 2] {
    let one = Complex(1.0, 0.0);
    let cos2_air = 1.0 - n * n * (1.0 - cos * cos);
    let cos_air = if cos2_air >= 0.0 {
        Complex(cos2_air.sqrt(), 0.0)
    } else {
        Complex(0.0, (-cos2_air).sqrt())
    };
    let beta = cos_air.scaled(2.0 * PI * gap_m / wavelength_m);
    let crossing = Complex(
        (-beta.1).exp() * beta.0.cos(),
        (-beta.1).exp() * beta.0.sin(),
    );
    let twice = crossing.times(crossing);
    let mut out = [0.0; 2];
    for across in [true, false] {
        // (A − B)/(A + B), 2 n cos/(A + B) in, 2 cos_air/(A + B) out.
        let (a, b) = if across {
            (Complex(n * cos, 0.0), cos_air)
        } else {
            (Complex(cos, 0.0), cos_air.scaled(n))
        };
        let sum = a.plus(b);
        let r = a.plus(b.scaled(-1.0)).over(sum);
        let inwards = Complex(2.0 * n * cos, 0.0).over(sum);
        let outwards = cos_air.scaled(2.0).over(sum);
        let below = one.plus(r.times(r).times(twice).scaled(-1.0));
        let reflected = r.times(one.plus(twice.scaled(-1.0))).over(below);
        let passed = inwards.times(outwards).times(crossing).over(below);
        out[0] += 0.5 * reflected.square();
        out[1] += 0.5 * passed.square();
    }
    out
}

#[test]
fn gap_reflects_what_it_does_not_transmit_in_both_regimes() {
    let (mut below, mut above) = (0, 0);
    for i in 0..900 {
        let cos = cos_deg(0.1 * f64::from(i) + 0.05);
        for nm in [1.0, 20.0, 80.0, 137.5, 300.0, 550.0, 1000.0, 3000.0] {
            let got = gap_reflectance(cos, 1e-9 * nm, 550e-9, N);
            let [r, t] = film(cos, 1e-9 * nm, 550e-9, N);
            assert!((r - got).abs() < 1e-6, "R at {nm} nm: {got}, textbook {r}");
            assert!(
                (got + t - 1.0).abs() < 1e-6,
                "R + T at {nm} nm: {got} + {t}"
            );
            if t > 1e-3 {
                *(if i < 411 { &mut below } else { &mut above }) += 1;
            }
        }
    }
    assert!(
        below > 3000 && above > 500,
        "both regimes let light through"
    );
}

#[test]
fn gap_of_the_reference_numbers() {
    let numbers = reference("crack_optics_numbers.json");
    for (nm, expected) in numbers["gap_R_normal_incidence_550nm"].as_object().unwrap() {
        let got = gap_reflectance(1.0, 1e-9 * nm.parse::<f64>().unwrap(), 550e-9, N);
        let expected = expected.as_f64().unwrap();
        assert!((got - expected).abs() < 1e-4, "{nm} nm: {got}, {expected}");
    }
    for (angle, row) in numbers["gap_R_FTIR_550nm"].as_object().unwrap() {
        let cos = cos_deg(angle.parse().unwrap());
        for (nm, expected) in row.as_object().unwrap() {
            let got = gap_reflectance(cos, 1e-9 * nm.parse::<f64>().unwrap(), 550e-9, N);
            let expected = expected.as_f64().unwrap();
            assert!(
                (got - expected).abs() < 5.1e-4,
                "{angle}°, {nm} nm: {got}, {expected}"
            );
        }
    }
    for (angle, pair) in numbers["gap_nm_for_R>=0.5_and_0.99"].as_object().unwrap() {
        let cos = cos_deg(angle.parse().unwrap());
        for (level, nm) in [0.5, 0.99].iter().zip(pair.as_array().unwrap()) {
            let nm = nm.as_f64().unwrap();
            let at = |nm: f64| gap_reflectance(cos, 1e-9 * nm, 550e-9, N);
            assert!(
                at(nm - 0.6) < *level && at(nm + 0.6) >= *level,
                "{angle}°: R reaches {level} at {nm} nm"
            );
        }
    }
}

#[test]
fn gap_limits_are_no_crack_and_two_faces() {
    let table = GapTable::new(N);
    for degrees in [0.0, 10.0, 25.0, 35.0, 40.0, 41.0, 41.3, 48.9, 70.0, 89.0] {
        let cos = cos_deg(degrees);
        for gap_um in [0.0, 1e-9] {
            let rgb = table.rgb(cos, gap_um);
            assert!(
                rgb.iter().all(|&r| r < 1e-6),
                "{degrees}°: no gap, but {rgb:?}"
            );
        }
        let sin_t = degrees.to_radians().sin() * N;
        let mean = if sin_t >= 1.0 {
            1.0
        } else {
            // Sine and tangent law of either polarization, then 2R/(1 + R).
            let (i, t) = (
                degrees.max(1e-4).to_radians(),
                sin_t.asin().max(1e-4f64.to_radians() * N),
            );
            let s = ((t - i).sin() / (t + i).sin()).powi(2);
            let p = ((t - i).tan() / (t + i).tan()).powi(2);
            s / (1.0 + s) + p / (1.0 + p)
        };
        let rgb = table.rgb(cos, 1000.0);
        assert!(
            rgb.iter().all(|r| (r - mean).abs() < 1e-6),
            "{degrees}°: wide gap {rgb:?}, two faces {mean}"
        );
    }
}

// Rough face

#[test]
fn the_facets_cover_the_face_once() {
    for alpha in [0.01, 0.05, 0.2, 0.5, 1.0] {
        // ∫ D cos dω = 2π ∫ D(cos) cos d(cos), over t = tan² θ/α² / (1 + …) so that it is smooth.
        let steps = 20_000;
        let mut sum = 0.0;
        for i in 0..steps {
            let u = (f64::from(i) + 0.5) / f64::from(steps);
            let tan2 = alpha * alpha * u / (1.0 - u);
            let cos2 = 1.0 / (1.0 + tan2);
            // d(cos²)/du = −cos⁴ α²/(1 − u)².
            let weight = cos2 * cos2 * alpha * alpha / (1.0 - u).powi(2);
            sum += PI * distribution(cos2.sqrt(), alpha) * weight / f64::from(steps);
        }
        assert!((sum - 1.0).abs() < 1e-9, "α = {alpha}: {sum}");
        // What is seen of the facets is the face: ∫ G₁ max(0, v·h) D dω = cos θ_v.
        for angle in [10.0, 50.0, 80.0] {
            let v = polar(angle, 0.0);
            let (rings, sectors) = (2000, 720);
            let mut seen = 0.0;
            for i in 0..rings {
                // 1 − u = (1 − w)²: smooth down to grazing facets.
                let w = (f64::from(i) + 0.5) / f64::from(rings);
                let u = 1.0 - (1.0 - w) * (1.0 - w);
                let cos2 = 1.0 / (1.0 + alpha * alpha * u / (1.0 - u));
                let theta = cos2.sqrt().acos().to_degrees();
                let weight = cos2.powf(1.5) * alpha * alpha / (1.0 - w).powi(3);
                for k in 0..sectors {
                    let h = polar(theta, (f64::from(k) + 0.5) * 360.0 / f64::from(sectors));
                    seen += dot(v, h).max(0.0) * distribution(h[2], alpha) * weight;
                }
            }
            seen *= g1(v[2], alpha) * 2.0 * PI / (f64::from(rings) * f64::from(sectors));
            assert!(
                (seen / v[2] - 1.0).abs() < 5e-4,
                "α = {alpha}, {angle}°: {seen} of {}",
                v[2]
            );
        }
    }
}

#[test]
fn visible_normals_are_drawn_with_their_density() {
    let mut rng = Seed(11).stream(Stream::CrackRelief, 0);
    let n = 200_000;
    for (alpha, angle) in [
        (0.05, 60.0),
        (0.3, 0.0),
        (0.3, 50.0),
        (0.3, 85.0),
        (0.8, 70.0),
    ] {
        let v = polar(angle, 30.0);
        // Cells of w by azimuth, (1 − w)² = α²/(α² + tan² θ): D cos dω = 2 (1 − w) dw dφ/2π.
        let (rings, sectors) = (6_usize, 8_usize);
        let mut counts = vec![0_u32; rings * sectors];
        for _ in 0..n {
            let h = sample_visible_normal(v, alpha, [uniform(&mut rng), uniform(&mut rng)]);
            assert!(dot(h, v) >= 0.0 && h[2] >= 0.0, "the facet is seen");
            let tan2 = (1.0 - h[2] * h[2]) / (h[2] * h[2]);
            let w = 1.0 - (alpha * alpha / (alpha * alpha + tan2)).sqrt();
            let phi = h[1].atan2(h[0]).rem_euclid(2.0 * PI) / (2.0 * PI);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "small"
            )]
            #[expect(clippy::cast_precision_loss, reason = "small")]
            let cell = ((w * rings as f64) as usize).min(rings - 1) * sectors
                + ((phi * sectors as f64) as usize).min(sectors - 1);
            counts[cell] += 1;
        }
        // Expected counts by the midpoint rule inside each cell.
        let fine = 40_usize;
        let mut chi2 = 0.0;
        let mut cells = 0;
        for (cell, &count) in counts.iter().enumerate() {
            let (ring, sector) = (cell / sectors, cell % sectors);
            let mut share = 0.0;
            for a in 0..fine {
                for b in 0..fine {
                    #[expect(clippy::cast_precision_loss, reason = "small")]
                    let (w, phi) = (
                        (ring as f64 + (a as f64 + 0.5) / fine as f64) / rings as f64,
                        (sector as f64 + (b as f64 + 0.5) / fine as f64) / sectors as f64,
                    );
                    let tan2 = alpha * alpha * (1.0 / ((1.0 - w) * (1.0 - w)) - 1.0);
                    let cos = (1.0 / (1.0 + tan2)).sqrt();
                    let h = polar(cos.acos().to_degrees(), 360.0 * phi);
                    let seen = g1(v[2], alpha) * dot(v, h).max(0.0) / (v[2] * cos);
                    share += 2.0 * (1.0 - w) * seen;
                }
            }
            #[expect(clippy::cast_precision_loss, reason = "small")]
            let expected = f64::from(n) * share / (fine * fine * rings * sectors) as f64;
            if expected > 20.0 {
                chi2 += (f64::from(count) - expected).powi(2) / expected;
                cells += 1;
            }
        }
        // Mean cells − 1, standard deviation √(2 cells); 1 % for the midpoint rule.
        let limit = f64::from(cells) + 5.0 * (2.0 * f64::from(cells)).sqrt();
        assert!(
            chi2 < limit,
            "α = {alpha}, {angle}°: χ² = {chi2} of {cells}"
        );
    }
}

/// f |cos θ_o|, sr⁻¹: radiance that leaves a rough face of glass towards `wi`, over radiance times
/// solid angle that comes from `wo` \[Walter2007, eq. 20 and 21\].
///
/// Both directions point away from the face, z > 0 into air and z < 0 into the glass, which has
/// index `n`. On one side of the face it reflects F D G₁ G₁/(4 |cos θ_i|); from side to side it
/// transmits |i·h| |o·h| (1 − F) D G₁ G₁/(|cos θ_i| (i·h + η o·h)²), with η the index on the side
/// of `wo` over that of `wi`. This is radiance itself: seen from air, the inside of glass is
/// dimmer by 1/η², so that power over power is η² times the integral.
fn rough_dielectric(wi: [f64; 3], wo: [f64; 3], alpha: f64, n: f64) -> f64 {
    let (cos_i, cos_o) = (wi[2], wo[2]);
    if cos_i * cos_o == 0.0 {
        return 0.0;
    }
    let eta = if cos_i > 0.0 { n } else { 1.0 / n };
    let reflects = cos_i * cos_o > 0.0;
    let h = unit(add(1.0, wi, if reflects { 1.0 } else { eta }, wo));
    let h = h.map(|x| x * h[2].signum());
    let (i_h, o_h) = (dot(wi, h), dot(wo, h));
    // Facets that are seen from behind their mean side do not count.
    if i_h * cos_i <= 0.0 || o_h * cos_o <= 0.0 {
        return 0.0;
    }
    let facets = distribution(h[2], alpha) * g1(cos_i, alpha) * g1(cos_o, alpha);
    let f = reflectance(i_h, eta);
    if reflects {
        f * facets / (4.0 * cos_i.abs())
    } else {
        let bend = i_h + eta * o_h;
        (i_h * o_h).abs() * (1.0 - f) * facets / (cos_i.abs() * bend * bend)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_rough_face_is_reciprocal(
        t1 in 0.0..180.0_f64, p1 in 0.0..360.0_f64, t2 in 0.0..180.0_f64, p2 in 0.0..360.0_f64,
        alpha in 0.05..0.8_f64,
    ) {
        // f(i, o)/n_i² = f(o, i)/n_o², with f cos as the value.
        let (i, o) = (polar(t1, p1), polar(t2, p2));
        prop_assume!(i[2].abs() > 1e-3 && o[2].abs() > 1e-3);
        let there = rough_dielectric(i, o, alpha, N) / o[2].abs();
        let back = rough_dielectric(o, i, alpha, N) / i[2].abs();
        // Radiance over index squared is what goes both ways.
        let scale = match (i[2] > 0.0, o[2] > 0.0) {
            (true, false) => N * N,
            (false, true) => 1.0 / (N * N),
            _ => 1.0,
        };
        // Near total reflection what passes is the root of a difference: of 1e-10 half the digits are not known.
        let least = 1e-9 * (there * scale + back) + 1e-9;
        prop_assert!((there * scale - back).abs() <= least, "{there} {back}");
    }
}

#[test]
fn a_rough_face_has_the_values_of_mitsuba() {
    // Written by validation/mitsuba/bsdf.py.
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../validation/mitsuba/bsdf.json"
    ));
    let rows: Vec<Value> = serde_json::from_str(&text.unwrap()).unwrap();
    assert_eq!(rows.len(), 120, "all rows are there");
    let mut sides = [0; 4];
    for row in &rows {
        let vector = |key: &str| [0, 1, 2].map(|k| row[key][k].as_f64().unwrap());
        let (wi, wo) = (unit(vector("wi")), unit(vector("wo")));
        let got = rough_dielectric(wi, wo, row["alpha"].as_f64().unwrap(), N);
        let expected = row["value"].as_f64().unwrap();
        assert!((got / expected - 1.0).abs() < 1e-4, "{row}: {got}");
        sides[usize::from(wi[2] > 0.0) + 2 * usize::from(wo[2] > 0.0)] += 1;
    }
    assert!(sides.iter().all(|&n| n > 10), "all four ways: {sides:?}");
}

#[test]
fn a_rough_face_keeps_what_mitsuba_keeps() {
    let numbers = reference("mitsuba_bsdf.json");
    let mut rng = Seed(3).stream(Stream::CrackRelief, 1);
    let mut rows = 0;
    for (name, expected) in numbers["single_scatter_albedo"].as_object().unwrap() {
        let mut parts = name[1..].split('_');
        let alpha: f64 = parts.next().unwrap().parse().unwrap();
        let in_air = parts.next().unwrap() == "air";
        let angle: f64 = parts.next().unwrap().parse().unwrap();
        let eta = if in_air { N } else { 1.0 / N };
        let v = polar(angle, 0.0);
        let n = 20_000;
        let mut sum = 0.0;
        for _ in 0..n {
            let h = sample_visible_normal(v, alpha, [uniform(&mut rng), uniform(&mut rng)]);
            let f = reflectance(dot(v, h), eta);
            let to_v = v.map(|x| -x);
            let up = reflect(to_v, h);
            if up[2] > 0.0 {
                sum += f * g1(up[2], alpha);
            }
            if let Some(down) = refract(to_v, h, 1.0 / eta)
                && down[2] < 0.0
            {
                sum += (1.0 - f) * g1(down[2], alpha);
            }
        }
        let got = sum / f64::from(n);
        let expected = expected.as_f64().unwrap();
        // Mitsuba's are means of 4000 samples: 0.4 at most in deviation.
        assert!(
            (got - expected).abs() < 0.025 && (alpha > 0.1 || (got - expected).abs() < 0.015),
            "{name}: {got}, Mitsuba {expected}"
        );
        rows += 1;
    }
    assert_eq!(rows, 40, "all rows are read");
}

#[test]
fn a_rough_face_scatters_what_its_facets_do() {
    // ∫ f cos dω over both sides, by the value function, is the albedo by drawn facets.
    let mut rng = Seed(5).stream(Stream::CrackRelief, 2);
    let alpha = 0.3;
    for (v, eta) in [(polar(50.0, 0.0), N), (polar(150.0, 0.0), 1.0 / N)] {
        let side = v[2].signum();
        let local = [v[0], v[1], v[2].abs()];
        let (n, mut drawn) = (100_000, 0.0);
        for _ in 0..n {
            let h = sample_visible_normal(local, alpha, [uniform(&mut rng), uniform(&mut rng)]);
            let f = reflectance(dot(local, h), eta);
            let up = reflect(local.map(|x| -x), h);
            drawn += f * if up[2] > 0.0 { g1(up[2], alpha) } else { 0.0 };
            if let Some(down) = refract(local.map(|x| -x), h, 1.0 / eta)
                && down[2] < 0.0
            {
                drawn += (1.0 - f) * g1(down[2], alpha);
            }
        }
        drawn /= f64::from(n);
        let (steps, mut sum) = (800, 0.0);
        for a in 0..steps {
            let z = -1.0 + 2.0 * (f64::from(a) + 0.5) / f64::from(steps);
            for b in 0..steps {
                let phi = 360.0 * (f64::from(b) + 0.5) / f64::from(steps);
                let o = polar(z.acos().to_degrees(), phi);
                // Power: transmitted radiance over index squared times the index squared.
                let scale = if z * side > 0.0 { 1.0 } else { eta * eta };
                sum += scale * rough_dielectric(v, o, alpha, N);
            }
        }
        sum *= 4.0 * PI / f64::from(steps * steps);
        assert!((sum - drawn).abs() < 5e-3, "value {sum}, drawn {drawn}");
    }
}

/// A crack's rough surface in a plate: both normals may be on either side.
#[derive(Clone, Copy)]
struct PlateGlint {
    face_normal: [f64; 3],
    crack_normal: [f64; 3],
    alpha: f64,
    n: f64,
}

impl PlateGlint {
    /// The glint of light that comes from outside, through smooth faces of a crack that is wide open.
    fn radiance(&self, view: [f64; 3], light: [f64; 3]) -> f64 {
        let inside = dot(light, self.face_normal).abs();
        let cos2_outside = 1.0 - self.n * self.n * (1.0 - inside * inside);
        if cos2_outside <= 0.0 {
            return 0.0;
        }
        let through = |cos: f64| 1.0 - reflectance(cos, 1.0 / self.n);
        let side = dot(view, self.crack_normal).signum();
        let glint = Glint {
            normal: self.crack_normal.map(|part| side * part),
            alpha: self.alpha,
            n: self.n,
            cos_light: [cos2_outside.sqrt(), inside],
            passes: through(inside) * through(dot(view, self.face_normal)),
        };
        glint.radiance(view, light, |cos| reflectance(cos, 1.0 / self.n))
    }
}

/// Mean of the glint over a disc of the sun around `sun` (outside, towards it), times its solid
/// angle: radiance for a sun of radiance 1.
fn glint_of_disc(glint: &PlateGlint, view: [f64; 3], sun: [f64; 3], radius_deg: f64) -> f64 {
    let tangent = unit(cross(sun, [0.3, 0.1, 0.9]));
    let (rings, sectors) = (40, 100);
    let edge = cos_deg(radius_deg);
    let mut sum = 0.0;
    for i in 0..rings {
        let z = 1.0 - (f64::from(i) + 0.5) / f64::from(rings) * (1.0 - edge);
        for k in 0..sectors {
            let phi = 2.0 * PI * (f64::from(k) + 0.5) / f64::from(sectors);
            let beside = add(phi.cos(), tangent, phi.sin(), cross(sun, tangent));
            let towards = add(z, sun, (1.0 - z * z).sqrt(), beside);
            // As the reference does: only light that comes through the far face.
            if dot(towards, glint.face_normal) > 0.0 {
                let inside = refract(towards, glint.face_normal, 1.0 / glint.n).unwrap();
                sum += glint.radiance(view, inside);
            }
        }
    }
    sum / f64::from(rings * sectors) * 2.0 * PI * (1.0 - edge)
}

#[test]
fn glints_are_those_of_the_reference() {
    let numbers = reference("mitsuba_bsdf.json");
    // A plate at 60°, its crack in the slope, seen along z; the sun 3° wide, off the mirrored
    // direction in the plane or beside it.
    let (sin, cos) = 60_f64.to_radians().sin_cos();
    let (face, crack, forward) = ([0.0, sin, cos], [0.0, cos, -sin], [0.0, 0.0, 1.0]);
    let mirrored = reflect(forward, crack);
    let beside = [1.0, 0.0, 0.0];
    let above = cross(beside, mirrored);
    let view = refract(forward, face, 1.0 / N).unwrap().map(|x| -x);
    let rows = numbers["rough_crack_glint"].as_array().unwrap();
    assert_eq!(rows.len(), 18, "all rows are there");
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        let off = number("off_deg").to_radians();
        let axis = if row["axis"] == "lateral" {
            beside
        } else {
            above
        };
        let sun = add(off.cos(), mirrored, off.sin(), axis);
        let glint = PlateGlint {
            face_normal: face,
            crack_normal: crack,
            alpha: number("alpha"),
            n: N,
        };
        let got = glint_of_disc(&glint, view, sun, 3.0);
        // 4000 drawn points and five digits in the reference.
        assert!(
            (got / number("closed_form") - 1.0).abs() < 0.02 + 5e-6 / number("closed_form"),
            "{row}: {got}"
        );
        if number("off_deg") < 1.0 && number("alpha") < 0.11 {
            assert!((got / number("mitsuba") - 1.0).abs() < 0.1, "{row}: {got}");
        }
    }
}

#[test]
fn a_glint_needs_both_directions_on_one_side_of_the_crack_and_outside_the_glass() {
    let glint = PlateGlint {
        face_normal: [0.0, 0.0, 1.0],
        crack_normal: [1.0, 0.0, 0.0],
        alpha: 0.2,
        n: N,
    };
    let view = polar(150.0, 0.0);
    let lit = glint.radiance(view, polar(30.0, 0.0));
    assert!(lit > 0.0, "the mirrored light is seen");
    let turned = PlateGlint {
        face_normal: [0.0, 0.0, -1.0],
        crack_normal: [-1.0, 0.0, 0.0],
        ..glint
    };
    let same = turned.radiance(view, polar(30.0, 0.0));
    assert!((same / lit - 1.0).abs() < 1e-12, "normals on either side");
    for (direction, why) in [
        (polar(30.0, 180.0), "behind the crack"),
        (polar(45.0, 0.0), "not from outside"),
        (polar(90.0, 0.0), "along the plate"),
    ] {
        let l = glint.radiance(view, direction);
        assert!(l.abs() < 1e-300, "{why}: {l}");
    }
}

#[test]
fn a_glint_on_the_peak_is_the_closed_form() {
    // D(0) = 1/(π α²), F = 1 (total reflection), G₁² of the incidence: by hand.
    let (alpha, inside) = (0.05, 30.0);
    let glint = PlateGlint {
        face_normal: [0.0, 0.0, 1.0],
        crack_normal: [1.0, 0.0, 0.0],
        alpha,
        n: N,
    };
    let got = glint.radiance(polar(180.0 - inside, 0.0), polar(inside, 0.0));
    let outside = (N * inside.to_radians().sin()).asin();
    let t = 1.0 - reflectance(outside.cos(), N);
    let tan2 = 1.0 / inside.to_radians().tan().powi(2);
    let mask = 2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt());
    let expected = t * t * outside.cos() / cos_deg(inside) / (N * N) * mask * mask
        / (PI * alpha * alpha * 4.0 * inside.to_radians().sin());
    assert!(
        (got / expected - 1.0).abs() < 1e-9,
        "{got}, by hand {expected}"
    );
}
