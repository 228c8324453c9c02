//! Brightness of each crack: E(L_r) and its normalization.

use starbreak_glass::CrackNetwork;

use super::params::{Normalization, PaperOptics};

/// E(L_r) of every segment over its normalizer: what I_c is of the light's intensity.
///
/// E_i = (|ω_α·n_i| + |ω_θ·n_i|)/2, with n_i the unit normal of segment i in the image plane,
/// ω_α = (cos α, sin α) and ω_θ = (cos θ, sin θ), y down; then I_c = I·E_i/S.
#[must_use]
pub fn crack_energies(
    network: &CrackNetwork,
    [scale_x, scale_y]: [f64; 2],
    optics: &PaperOptics,
) -> Vec<f32> {
    let (sin_a, cos_a) = libm::sincos(optics.sun_azimuth_rad);
    let (sin_t, cos_t) = libm::sincos(optics.sun_zenith_rad);
    let energies: Vec<f64> = (0..network.n_segments())
        .map(|idx| {
            let [x0, y0, x1, y1] = network.ends(idx);
            let (dx, dy) = ((x1 - x0) * scale_x, (y1 - y0) * scale_y);
            let length = (dx * dx + dy * dy).sqrt();
            let (nx, ny) = (-dy / length, dx / length);
            f64::midpoint(
                (cos_a * nx + sin_a * ny).abs(),
                (cos_t * nx + sin_t * ny).abs(),
            )
        })
        .collect();
    #[expect(clippy::cast_precision_loss, reason = "a count")]
    let normalizer = match optics.normalization {
        Normalization::Sum => energies.iter().sum(),
        Normalization::Max => energies.iter().copied().fold(0.0, f64::max),
        Normalization::Mean => energies.iter().sum::<f64>() / energies.len().max(1) as f64,
        Normalization::One => 1.0,
    };
    #[expect(clippy::cast_possible_truncation, reason = "a ratio as f32")]
    let ratio = |energy: f64| {
        if normalizer > 0.0 {
            (energy / normalizer) as f32
        } else {
            0.0
        }
    };
    energies.into_iter().map(ratio).collect()
}
