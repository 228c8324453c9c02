//! A rough face: microfacets with the GGX distribution of slopes \[Walter2007\].
//!
//! Local directions have z along the mean normal of the face and are of unit length.

use std::f64::consts::PI;

use super::{combine, unit_or};
use crate::vector::{Vector, dot, unit};

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
        let view = unit_or([alpha * v[0], alpha * v[1], v[2]], [0.0, 0.0, 1.0]);
        let t1 = unit_or([-view[1], view[0], 0.0], [1.0, 0.0, 0.0]);
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
        unit_or(facet, [0.0, 0.0, 1.0])
    }
}

/// A rough surface in a sheet of glass, lit by a far small light through one face and seen through
/// a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glint {
    /// Normal of the surface, on the side of the camera, of unit length.
    pub normal: Vector,
    /// GGX roughness of the surface, above 0.
    pub alpha: f64,
    /// Refractive index of the glass.
    pub n: f64,
    /// Cosines of the light on the face through which it comes, outside and inside.
    pub cos_light: [f64; 2],
    /// What both faces let through, T₁ T₂.
    pub passes: f64,
}

impl Glint {
    /// Radiance in air towards the camera over the irradiance in air on a plane that faces the
    /// light, sr⁻¹.
    ///
    /// `view` and `light` are directions inside the glass, from the surface to the camera and to the
    /// light, of unit length; `reflectance` is F of the surface at a cosine of incidence. The light is
    /// reflected once:
    ///
    /// L/E = T₁ T₂ (cos θ_s/cos θ_s′)/n² · F D G₁ G₁/(4 v·n),
    ///
    /// θ_s and θ_s′ of the light on the face outside and inside. 0 if either lies behind the surface.
    ///
    /// Further paths between surface and faces add light, a tenth at α = 0.1 on the peak, half and
    /// more off the peak and from α = 0.2 on.
    #[must_use]
    pub fn radiance(
        &self,
        view: Vector,
        light: Vector,
        reflectance: impl FnOnce(f64) -> f64,
    ) -> f64 {
        let (cos_v, cos_l) = (dot(view, self.normal), dot(light, self.normal));
        if cos_v <= 1e-6 || cos_l <= 0.0 {
            return 0.0;
        }
        let half = unit(std::array::from_fn(|k| view[k] + light[k]));
        let (cos_h, cos_vh) = (dot(half, self.normal), dot(half, view));
        let [outside, inside] = self.cos_light;
        self.passes * outside / inside / (self.n * self.n)
            * reflectance(cos_vh.abs())
            * distribution(cos_h, self.alpha)
            * g1(cos_v, self.alpha)
            * g1(cos_l, self.alpha)
            / (4.0 * cos_v)
    }
}
