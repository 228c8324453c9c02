//! What a sheet is made of, and what a lattice makes of it.

use crate::lattice::{Lattice, as_f64};

/// Material of a sheet. Bond-based peridynamics in plane stress has ν = 1/3, always.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    /// Young's modulus, Pa.
    pub young_pa: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Energy to make a crack, per area of crack, J/m².
    pub fracture_energy_j_m2: f64,
}

impl Material {
    /// Speed of a thin bar's longitudinal wave, √(E/ρ), m/s.
    #[must_use]
    pub fn bar_speed_m_s(&self) -> f64 {
        libm::sqrt(self.young_pa / self.density_kg_m3)
    }

    /// Stretch at which a bond breaks, s₀ = √(4πG₀/(9Eδ)), plane stress [HaBobaru2010].
    #[must_use]
    pub fn critical_stretch(&self, horizon_m: f64) -> f64 {
        let energy = 4.0 * std::f64::consts::PI * self.fracture_energy_j_m2;
        libm::sqrt(energy / (9.0 * self.young_pa * horizon_m))
    }
}

/// How the sums over the bonds of a lattice compare with the integrals over the horizon.
#[derive(Clone, Copy, Debug)]
pub struct LatticeSums {
    /// Energy of a uniaxial stretch with ν = 1/3: sum over integral.
    pub elastic: f64,
    /// Energy of the bonds across a straight crack: sum over integral.
    pub fracture: f64,
}

impl LatticeSums {
    /// From all bonds whose ends are at least a horizon away from the edges, mean of x and y.
    ///
    /// Elastic: ¼cΣ s²ξ over the neighbors, s = (x² − y²/3)/ξ², against ½E. Fracture: of the bonds
    /// of an area, the part |y|/(its height) crosses a line along x, so a length of crack takes
    /// Σ ½cs₀²ξ|y| over the bonds per area, against G₀. Both go to 1 with a large horizon.
    #[must_use]
    pub fn new(lattice: &Lattice, pairs: &[(usize, usize)], horizon_m: f64) -> Self {
        let spacing_m = lattice.spacing_m;
        let inner =
            |n: usize, at_m: f64| at_m.abs() < 0.5 * as_f64(n) * spacing_m - horizon_m - spacing_m;
        let is_inner =
            |i: usize| inner(lattice.n_x, lattice.x_m[i]) && inner(lattice.n_y, lattice.y_m[i]);
        let n_inner = (0..lattice.len()).filter(|&i| is_inner(i)).count();
        let (mut elastic, mut fracture) = (0.0, 0.0);
        for &(i, j) in pairs {
            // Half of a bond belongs to each end.
            let share = 0.5 * (f64::from(u8::from(is_inner(i))) + f64::from(u8::from(is_inner(j))));
            let length = lattice.distance_m(i, j) / spacing_m;
            let x = (lattice.x_m[j] - lattice.x_m[i]) / spacing_m;
            let y = (lattice.y_m[j] - lattice.y_m[i]) / spacing_m;
            for (along, across) in [(x, y), (y, x)] {
                let stretch = (along * along - across * across / 3.0) / (length * length);
                elastic += share * stretch * stretch * length;
                fracture += 0.5 * share * length * across.abs();
            }
        }
        if n_inner == 0 {
            return Self {
                elastic: 1.0,
                fracture: 1.0,
            };
        }
        // Each bond once, both axes: ½·9/(πδ³)/2 over ½, and ½·9/(πδ³)·4π/(9δ).
        let horizon = horizon_m / spacing_m;
        let cube = horizon * horizon * horizon;
        Self {
            elastic: elastic / as_f64(n_inner) * 4.5 / (std::f64::consts::PI * cube),
            fracture: fracture / as_f64(n_inner) * 2.0 / (cube * horizon),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn sums_go_to_the_integrals() {
        let lattice = Lattice::new(81, 81, 1.0, 0.0, &mut Random::new(0));
        let pairs: Vec<_> = lattice.pairs(20.0).collect();
        let sums = LatticeSums::new(&lattice, &pairs, 20.0);
        assert!((sums.elastic - 1.0).abs() < 0.01, "{sums:?}");
        assert!((sums.fracture - 1.0).abs() < 0.01, "{sums:?}");
    }

    #[test]
    fn sums_of_a_regular_lattice() {
        // By hand for a horizon of one spacing: four neighbors at distance 1, s = 1, 1, −1/3, −1/3,
        // so Σs²ξ = 20/9; across a line goes one bond per spacing, so Σξ|y| = 1.
        let lattice = Lattice::new(9, 9, 1.0, 0.0, &mut Random::new(0));
        let pairs: Vec<_> = lattice.pairs(1.0).collect();
        let sums = LatticeSums::new(&lattice, &pairs, 1.0);
        assert!(
            (sums.elastic - 10.0 / std::f64::consts::PI).abs() < 1e-12,
            "{sums:?}"
        );
        assert!((sums.fracture - 2.0).abs() < 1e-12, "{sums:?}");
    }
}
