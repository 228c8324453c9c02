//! Surface compression and thickness to the number of dice.

/// Compression of the surface below which a crack does not divide the pane, Pa: where the energy
/// law reaches zero.
pub const ONSET_PA: f64 = 48.2e6;

/// Compression up to which the laws are used, Pa; tests reach 166 MPa.
const HIGHEST_PA: f64 = 250e6;
/// Thicknesses for which the laws are used, m; tests cover 4 to 12 mm.
const THICKNESS_M: [f64; 2] = [3e-3, 19e-3];
/// Area of the 50 mm × 50 mm that fragments are counted in, m².
const WINDOW_M2: f64 = 2.5e-3;

/// Fragments per 50 mm × 50 mm by the energy that tempering stores: U = (1 − ν)σ²/5E =
/// 2.2 σ² J/m³ (σ in MPa) against U = 5120 + 149.5 N. May be negative below [`ONSET_PA`].
///
/// FIT to the 29 tests tabulated in \[Pourmoghaddam2018\], R² 0.986; thickness has no part in it.
#[must_use]
pub fn count_law_energy(surface_compression_pa: f64) -> f64 {
    let mpa = surface_compression_pa * 1e-6;
    (2.2 * mpa * mpa - 5120.0) / 149.5
}

/// Fragments per 50 mm × 50 mm by regression: 4.02e-3 σ^2.36 t^-0.476 (σ in MPa, t in mm).
///
/// FIT to 79 tests with t 6 to 12 mm and σ 93 to 166 MPa \[Pourmoghaddam2018\], rms 10 %.
#[must_use]
pub fn count_law_empirical(surface_compression_pa: f64, thickness_m: f64) -> f64 {
    let (mpa, mm) = (surface_compression_pa * 1e-6, thickness_m * 1e3);
    4.02e-3 * libm::pow(mpa, 2.36) * libm::pow(mm, -0.476)
}

/// Fragments per 50 mm × 50 mm: the geometric mean of both laws, which differ by up to 1.5.
/// `None` below [`ONSET_PA`]: the pane cracks, but does not go to pieces.
///
/// # Limits
/// Above 250 MPa, below 3 mm and above 19 mm the nearest value is used. Chemical tempering, with
/// its thin skin under high compression, follows other laws.
#[must_use]
pub fn fragments_per_50_mm(surface_compression_pa: f64, thickness_m: f64) -> Option<f64> {
    if surface_compression_pa <= ONSET_PA {
        return None;
    }
    let compression = surface_compression_pa.min(HIGHEST_PA);
    let thickness = thickness_m.clamp(THICKNESS_M[0], THICKNESS_M[1]);
    let energy = count_law_energy(compression).max(0.0);
    let mean = (energy * count_law_empirical(compression, thickness)).sqrt();
    (mean > 0.0).then_some(mean)
}

/// Fragments per m²; see [`fragments_per_50_mm`].
#[must_use]
pub fn fragment_density_per_m2(surface_compression_pa: f64, thickness_m: f64) -> Option<f64> {
    fragments_per_50_mm(surface_compression_pa, thickness_m).map(|count| count / WINDOW_M2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_laws_give_their_published_points() {
        // The design's figures: 40 at 71 MPa, 113 at 100 MPa, onset 48 MPa; 103 at 112 MPa, 8 mm.
        for (pa, count) in [(71e6, 40.0), (100e6, 113.0), (48.2e6, 0.0), (112e6, 151.0)] {
            assert!((count_law_energy(pa) - count).abs() < 1.0, "{pa}");
        }
        assert!(
            (count_law_empirical(112e6, 8e-3) - 103.0).abs() < 1.5,
            "8 mm"
        );
    }

    #[test]
    fn safety_glass_gives_the_count_of_the_standard() {
        // EN 12150: at least 40 for 4 to 12 mm.
        for pa in [90e6, 100e6, 130e6, 166e6] {
            for mm in [4.0, 6.0, 8.0, 12.0] {
                let count = fragments_per_50_mm(pa, mm * 1e-3).unwrap_or_default();
                assert!(count >= 40.0, "{count} at {pa} Pa, {mm} mm");
            }
        }
    }

    #[test]
    fn nothing_dices_below_the_onset_and_more_compression_gives_more() {
        assert!(fragments_per_50_mm(48e6, 6e-3).is_none(), "below");
        let counts: Vec<f64> = (49..260)
            .filter_map(|mpa| fragments_per_50_mm(f64::from(mpa) * 1e6, 6e-3))
            .collect();
        assert_eq!(counts.len(), 211, "all above");
        assert!(counts.windows(2).all(|w| w[0] <= w[1]), "monotone");
    }
}
