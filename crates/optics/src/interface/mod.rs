//! One surface of glass: how much light it reflects, transmits and scatters, and where to.
//!
//! [`fresnel`] is a smooth face, [`gap`] the film of air in an open crack, [`ggx`] a rough face.
//! All are pure functions of directions and of the refractive index; lengths are in m unless the
//! name says otherwise.

pub mod fresnel;
pub mod gap;
pub mod ggx;

use crate::vector::{Vector, dot};

/// `a x + b y`.
fn combine(a: f64, x: Vector, b: f64, y: Vector) -> Vector {
    [0, 1, 2].map(|i| a * x[i] + b * y[i])
}

/// The unit vector along `v`, or another one if `v` has no direction.
fn unit_or(v: Vector, other: Vector) -> Vector {
    let length = dot(v, v).sqrt();
    match length > 0.0 && length.is_finite() {
        true => v.map(|x| x / length),
        false => other,
    }
}
