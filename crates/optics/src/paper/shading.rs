//! Brightness of each crack: E(L_r) and its normalization.

use starbreak_glass::CrackNetwork;

use super::params::{Normalization, PaperOptics};
use crate::View;

/// E(L_r) of every segment over its normalizer: what I_c is of the light's intensity.
///
/// E_i = (|ω_α·n_i| + |ω_θ·n_i|)/2, with n_i the unit normal of segment i in the image plane,
/// ω_α = (cos α, sin α) and ω_θ = (cos θ, sin θ), y down; then I_c = I·E_i/S. Segments that the
/// view does not show have 0 and do not count in S.
#[must_use]
pub fn crack_energies(network: &CrackNetwork, view: &View, optics: &PaperOptics) -> Vec<f32> {
    let (sin_a, cos_a) = libm::sincos(optics.sun_azimuth_rad);
    let (sin_t, cos_t) = libm::sincos(optics.sun_zenith_rad);
    let margin = optics.reach_px();
    let energy = |idx: usize| -> Option<f64> {
        let [dx, dy] = view.direction(network.ends(idx), margin)?;
        let length = (dx * dx + dy * dy).sqrt();
        let (nx, ny) = (-dy / length, dx / length);
        (length > 0.0).then(|| {
            f64::midpoint(
                (cos_a * nx + sin_a * ny).abs(),
                (cos_t * nx + sin_t * ny).abs(),
            )
        })
    };
    let energies: Vec<Option<f64>> = (0..network.n_segments()).map(energy).collect();
    let seen = || energies.iter().copied().flatten();
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let normalizer = match optics.normalization {
        Normalization::Sum => seen().sum(),
        Normalization::Max => seen().fold(0.0, f64::max),
        Normalization::Mean => seen().sum::<f64>() / seen().count().max(1) as f64,
        Normalization::One => 1.0,
    };
    #[expect(clippy::cast_possible_truncation, reason = "a ratio as f32")]
    let ratio = |energy: Option<f64>| match energy {
        Some(energy) if normalizer > 0.0 => (energy / normalizer) as f32,
        _ => 0.0,
    };
    energies.into_iter().map(ratio).collect()
}
