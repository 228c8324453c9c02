//! A smooth face between two clear media.

use super::{Vector, combine, dot};
use crate::number::Number;

/// Share of unpolarized light that a smooth face reflects, 0 to 1 (Fresnel).
///
/// `cos_i` is the cosine of incidence, `eta` the refractive index behind the face over that in
/// front of it: 1.52 from air into glass, 1/1.52 from glass into air. With
/// cos θ_t = √(1 − (1 − cos² θ_i)/η²):
///
/// r_s = (cos θ_i − η cos θ_t)/(cos θ_i + η cos θ_t),
/// r_p = (η cos θ_i − cos θ_t)/(η cos θ_i + cos θ_t), R = (r_s² + r_p²)/2; 1 beyond the critical
/// angle. The sign of `cos_i` does not matter.
///
/// # Example
/// ```
/// use starbreak_optics::interface::fresnel::reflectance;
/// let straight_on = ((1.52_f64 - 1.0) / (1.52 + 1.0)).powi(2);
/// assert!((reflectance(1.0, 1.52) - straight_on).abs() < 1e-15);
/// assert_eq!(reflectance(0.5, 1.0 / 1.52), 1.0, "totally reflected at 60° inside the glass");
/// ```
#[must_use]
pub fn reflectance(cos_i: f64, eta: f64) -> f64 {
    reflectance_of(cos_i.abs().min(1.0), eta)
}

/// The same of one cosine from 0 to 1 or several.
#[inline(always)]
pub(crate) fn reflectance_of<N: Number>(cos_i: N, eta: f64) -> N {
    let [none, all] = [0.0, 1.0].map(|value| cos_i.all(value));
    let sine2_t = (cos_i * cos_i).less_from(1.0) / cos_i.all(eta * eta);
    let cos2_t = sine2_t.less_from(1.0);
    let mirrored = reflectance_at([cos_i, cos2_t.at_least(0.0).sqrt()], eta);
    none.below(cos2_t, [mirrored, all])
}

/// The same of the cosines on both sides of the face, where it does not reflect totally.
#[inline(always)]
pub(crate) fn reflectance_at<N: Number>([cos_i, cos_t]: [N; 2], eta: f64) -> N {
    let [i, t] = [cos_i, cos_t].map(|cos| cos.times(eta));
    let s = (cos_i - t) / (cos_i + t);
    let p = (i - cos_t) / (i + cos_t);
    (s * s + p * p).times(0.5)
}

/// The direction in which light that travels along `direction` goes on after a mirror:
/// d − 2 (d·n) n.
///
/// `normal` is of unit length, on either side.
#[must_use]
pub fn reflect(direction: Vector, normal: Vector) -> Vector {
    combine(1.0, direction, -2.0 * dot(direction, normal), normal)
}

/// The direction in which light that travels along `direction` goes on behind a face, of unit
/// length; `None` if it is totally reflected (Snell).
///
/// `direction` and `normal` are of unit length, the normal on either side; `eta` is the index in
/// front of the face over that behind it: 1/1.52 into glass, 1.52 out of it. With c = |d·n|, n
/// turned along d: η d + (√(1 − η² (1 − c²)) − η c) n.
#[must_use]
pub fn refract(direction: Vector, normal: Vector, eta: f64) -> Option<Vector> {
    let along = dot(direction, normal);
    let c = along.abs();
    let cos2_t = 1.0 - eta * eta * (1.0 - c * c);
    (cos2_t >= 0.0).then(|| {
        let beside = cos2_t.sqrt() - eta * c;
        combine(eta, direction, along.signum() * beside, normal)
    })
}

/// Share of unpolarized light that a clear plate in air lets through, over all its internal
/// reflections: (1 − R)/(1 + R), with R of [`reflectance`] at one face.
///
/// `cos_i` is the cosine of incidence in air, `n` the index of the plate. The light is taken as
/// unpolarized at every reflection, as renderers do; each polarization on its own would pass
/// 1.8 % more at 60°, less than that below.
#[must_use]
pub fn slab_transmittance(cos_i: f64, n: f64) -> f64 {
    let r = reflectance(cos_i, n);
    (1.0 - r) / (1.0 + r)
}

/// Share of unpolarized light that a clear plate in air reflects: 2R/(1 + R), the rest of
/// [`slab_transmittance`].
#[must_use]
pub fn slab_reflectance(cos_i: f64, n: f64) -> f64 {
    let r = reflectance(cos_i, n);
    2.0 * r / (1.0 + r)
}
