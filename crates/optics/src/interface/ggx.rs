//! A rough face: microfacets with the GGX distribution of slopes \[Walter2007\].
//!
//! Local directions have z along the mean normal of the face and are of unit length.

use std::f64::consts::PI;

use super::fresnel::reflectance;
use super::{Vector, combine, dot, unit};

/// Density of microfacet normals per solid angle, sr⁻¹, at an angle of cosine `cos_h` from the
/// mean normal: D = α²/(π (cos² θ_h (α² − 1) + 1)²) \[Walter2007, eq. 33\]; 0 behind the face.
///
/// `alpha` is the roughness, above 0; ∫ D cos θ_h dω = 1.
#[must_use]
pub fn distribution(cos_h: f64, alpha: f64) -> f64 {
    if cos_h <= 0.0 {
        return 0.0;
    }
    let a2 = alpha * alpha;
    let cos2 = (cos_h * cos_h).min(1.0);
    // The slope as 1 − cos², so that a small α keeps its digits.
    let spread = cos2 * a2 + (1.0 - cos2);
    a2 / (PI * spread * spread)
}

/// Share of the microfacets that a direction sees unmasked (Smith): 2/(1 + √(1 + α² tan² θ))
/// \[Walter2007, eq. 34\]. The sign of `cos` does not matter.
#[must_use]
pub fn g1(cos: f64, alpha: f64) -> f64 {
    let cos2 = (cos * cos).min(1.0);
    let tan2 = (1.0 - cos2) / cos2.max(1e-300);
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}

/// f |cos θ_o|, sr⁻¹: radiance that leaves a rough face of glass towards `wi`, over radiance times
/// solid angle that comes from `wo` \[Walter2007, eq. 20 and 21\].
///
/// Both directions point away from the face, z > 0 into air and z < 0 into the glass, which has
/// index `n`. On one side of the face it reflects F D G₁ G₁/(4 |cos θ_i|); from side to side it
/// transmits |i·h| |o·h| (1 − F) D G₁ G₁/(|cos θ_i| (i·h + η o·h)²), with η the index on the side
/// of `wo` over that of `wi`. This is radiance itself: seen from air, the inside of glass is
/// dimmer by 1/η², so that power over power is η² times the integral.
#[must_use]
pub fn rough_dielectric(wi: Vector, wo: Vector, alpha: f64, n: f64) -> f64 {
    let (cos_i, cos_o) = (wi[2], wo[2]);
    if cos_i * cos_o == 0.0 {
        return 0.0;
    }
    let eta = if cos_i > 0.0 { n } else { 1.0 / n };
    let reflects = cos_i * cos_o > 0.0;
    let Some(h) = unit(combine(1.0, wi, if reflects { 1.0 } else { eta }, wo)) else {
        return 0.0;
    };
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

/// A microfacet normal drawn from those that `v` sees, with density
/// G₁(v) max(0, v·h) D(h)/cos θ_v \[Heitz2018\].
///
/// `v` has z > 0; `u` are two numbers uniform in [0, 1).
#[must_use]
pub fn sample_visible_normal(v: Vector, alpha: f64, u: [f64; 2]) -> Vector {
    VisibleNormals::of(v, alpha).at(on_disc(u))
}

/// A point of the unit disc by two numbers uniform in [0, 1): uniform over it.
pub(crate) fn on_disc([radius2, turn]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = libm::sincos(2.0 * PI * turn);
    [cos, sin].map(|part| radius2.sqrt() * part)
}

/// The microfacet normals that one direction sees: all of [`sample_visible_normal`] that depends
/// on the direction alone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VisibleNormals {
    alpha: f64,
    view: Vector,
    across: [Vector; 2],
}

impl VisibleNormals {
    pub(crate) fn of(v: Vector, alpha: f64) -> Self {
        // Stretched, the slopes are those of a hemisphere.
        let view = unit([alpha * v[0], alpha * v[1], v[2]]).unwrap_or([0.0, 0.0, 1.0]);
        let t1 = unit([-view[1], view[0], 0.0]).unwrap_or([1.0, 0.0, 0.0]);
        let t2 = [
            view[1] * t1[2] - view[2] * t1[1],
            view[2] * t1[0] - view[0] * t1[2],
            view[0] * t1[1] - view[1] * t1[0],
        ];
        Self {
            alpha,
            view,
            across: [t1, t2],
        }
    }

    /// The normal at a point of the unit disc.
    pub(crate) fn at(&self, [p1, y]: [f64; 2]) -> Vector {
        // A point of the hemisphere's projection: the half disc that is seen in full, and the
        // other one seen at a slant.
        let seen = 0.5 * (1.0 + self.view[2]);
        let p2 = (1.0 - seen) * (1.0 - p1 * p1).max(0.0).sqrt() + seen * y;
        let p3 = (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
        let [t1, t2] = self.across;
        let h = combine(1.0, combine(p1, t1, p2, t2), p3, self.view);
        let facet = [self.alpha * h[0], self.alpha * h[1], h[2].max(0.0)];
        unit(facet).unwrap_or([0.0, 0.0, 1.0])
    }
}

/// A crack's rough surface in a plate, lit by a far small light and seen through the faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glint {
    /// Normal of the plate's faces, on either side, of unit length.
    pub face_normal: Vector,
    /// Normal of the crack, on either side, of unit length.
    pub crack_normal: Vector,
    /// GGX roughness of the crack, above 0.
    pub alpha: f64,
    /// Refractive index of the glass.
    pub n: f64,
}

impl Glint {
    /// Radiance in air towards the camera over the irradiance in air on a plane that faces the
    /// light, sr⁻¹.
    ///
    /// `to_camera` and `to_light` are directions inside the glass, from the crack, of unit length.
    /// The light enters through one face, is reflected once, and leaves through a face:
    ///
    /// L/E = T₁ T₂ (cos θ_s/cos θ_s′)/n² · F D G₁ G₁/(4 |v′·n_c|),
    ///
    /// T₁ and T₂ of the faces, θ_s and θ_s′ of the light on the face outside and inside, v′ towards
    /// the camera, n_c the crack's normal; F is 1 beyond the critical angle. 0 if the two lie on
    /// different sides of the crack, or if either cannot pass the face.
    ///
    /// One reflection: further paths between crack and faces add light, a tenth at α = 0.1 on the
    /// peak, half and more off the peak and from α = 0.2 on.
    #[must_use]
    pub fn radiance(&self, to_camera: Vector, to_light: Vector) -> f64 {
        let (cos_v, cos_l) = (
            dot(to_camera, self.crack_normal),
            dot(to_light, self.crack_normal),
        );
        let face_cos = dot(to_light, self.face_normal).abs();
        if cos_v * cos_l <= 0.0 || face_cos <= 0.0 {
            return 0.0;
        }
        let through = |cos: f64| 1.0 - reflectance(cos, 1.0 / self.n);
        let passed = through(face_cos) * through(dot(to_camera, self.face_normal));
        let n2 = self.n * self.n;
        let cos2_outside = 1.0 - n2 * (1.0 - face_cos * face_cos);
        let Some(h) = unit(combine(1.0, to_camera, 1.0, to_light)) else {
            return 0.0;
        };
        if passed <= 0.0 || cos2_outside <= 0.0 {
            return 0.0;
        }
        let crack = reflectance(dot(to_light, h), 1.0 / self.n)
            * distribution(dot(h, self.crack_normal).abs(), self.alpha)
            * g1(cos_v, self.alpha)
            * g1(cos_l, self.alpha)
            / (4.0 * cos_v.abs());
        passed * (cos2_outside.sqrt() / face_cos) / n2 * crack
    }
}
