//! What the physics needs to know of pane, hit and load. SI units; every field with its range.

use starbreak_glass::Material;

use crate::FractureError;
use crate::mesh::{MeshResolution, Outline};

/// Largest angle, rad: several thousand turns, which still have a direction.
const MOST_RAD: f64 = 2e4;

/// A pane of glass and how it is held.
#[derive(Debug, Clone, PartialEq)]
pub struct GlassPane {
    /// Its rim.
    pub outline: Outline,
    /// Thickness of the sheet that is hit (of laminates: of the outer ply), m, 0.1 mm to 30 mm.
    pub thickness_m: f64,
    /// How it was made.
    pub build: GlassBuild,
    /// How its rim is held.
    pub support: Support,
    /// What it is made of.
    pub material: Material,
}

/// How a pane was made, which decides how it breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GlassBuild {
    /// One sheet, free of residual stress.
    Annealed,
    /// Two plies with a polymer between them: an elastic foundation under the outer ply.
    Laminated {
        /// Thickness of the interlayer, m.
        interlayer_thickness_m: f64,
        /// Young's modulus of the interlayer at the temperature and over the time of the hit, Pa:
        /// 30 MPa (0.1 s) to 1 GPa (µs).
        interlayer_modulus_pa: f64,
        /// Thickness of the inner ply, m.
        inner_thickness_m: f64,
    },
    /// One sheet with its surfaces in compression and its core in tension.
    Tempered {
        /// Compression of the surface σ_s > 0, Pa; the core is in tension of half of it.
        surface_compression_pa: f64,
    },
}

/// How the rim of a pane is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Support {
    /// In a gasket: it cannot move, but turn.
    SimplySupported,
    /// In a stiff ring: it can neither move nor turn.
    Clamped,
}

/// A hit by a stone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoneImpact {
    /// Where, m from the pane's top left corner.
    pub position_m: [f64; 2],
    /// Speed, m/s, 0.01 to 1000.
    pub speed_m_s: f64,
    /// Angle between the path and the normal of the pane, rad, 0 to 85°.
    pub obliquity_rad: f64,
    /// Direction of the path in the plane of the pane, rad from +x towards +y.
    pub azimuth_rad: f64,
    /// Radius of the sphere of the stone's mass, m, 0.05 mm to 0.2 m.
    pub radius_m: f64,
    /// Radius of curvature where it touches, m, up to `radius_m`: small for a sharp stone.
    pub tip_radius_m: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Young's modulus, Pa.
    pub young_modulus_pa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Pressure at which it crushes, Pa.
    pub crushing_pa: f64,
}

impl StoneImpact {
    /// A pebble of granite that hits head-on: 2650 kg/m³, 50 GPa, 0.25. It crushes at 3 GPa: FIT,
    /// between ten times its uniaxial strength of about 200 MPa and the hardness of its grains.
    #[must_use]
    pub fn granite(position_m: [f64; 2], speed_m_s: f64, radius_m: f64) -> Self {
        Self {
            position_m,
            speed_m_s,
            obliquity_rad: 0.0,
            azimuth_rad: 0.0,
            radius_m,
            tip_radius_m: radius_m,
            density_kg_m3: 2650.0,
            young_modulus_pa: 50e9,
            poisson_ratio: 0.25,
            crushing_pa: 3e9,
        }
    }

    /// A hailstone that hits head-on: 917 kg/m³, 9.3 GPa, 0.33 \[Schulson1999\]. It crushes at
    /// 50 MPa, FIT: some times the strength of ice under impact, 5 to 30 MPa \[Tippmann2013\], as
    /// under any small load.
    #[must_use]
    pub fn ice(position_m: [f64; 2], speed_m_s: f64, radius_m: f64) -> Self {
        Self {
            density_kg_m3: 917.0,
            young_modulus_pa: 9.3e9,
            poisson_ratio: 0.33,
            crushing_pa: 50e6,
            ..Self::granite(position_m, speed_m_s, radius_m)
        }
    }

    /// A head or the form that tests put in its place, an aluminium sphere under a skin of PVC
    /// \[UNR127\]: 1910 kg/m³ (4.5 kg in a sphere of 165 mm), 20 MPa, 0.45; it does not crush. The
    /// stiffness is a FIT.
    #[must_use]
    pub fn head(position_m: [f64; 2], speed_m_s: f64, radius_m: f64) -> Self {
        Self {
            density_kg_m3: 1910.0,
            young_modulus_pa: 20e6,
            poisson_ratio: 0.45,
            crushing_pa: 1e9,
            ..Self::granite(position_m, speed_m_s, radius_m)
        }
    }

    /// Mass (4/3)π R³ ρ, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        let r = self.radius_m;
        4.0 / 3.0 * std::f64::consts::PI * (r * r * r) * self.density_kg_m3
    }

    /// Speed along the normal of the pane, m/s.
    #[must_use]
    pub fn normal_speed_m_s(&self) -> f64 {
        self.speed_m_s * libm::cos(self.obliquity_rad)
    }

    /// Kinetic energy ½mV², J.
    #[must_use]
    pub fn kinetic_energy_j(&self) -> f64 {
        0.5 * self.mass_kg() * self.speed_m_s * self.speed_m_s
    }
}

/// Stress in the plane of the pane that is there without a hit, and what may crack under it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MembraneLoad {
    /// Temperature of the warm spot over that of the rest, K (negative: a cold spot), -300 to 300.
    pub temperature_difference_k: f64,
    /// Centre of the warm spot, as fractions of width and height.
    pub spot: [f64; 2],
    /// Standard deviation of the spot, as a fraction of the shorter side, > 0.
    pub spot_size: f64,
    /// Uniform tension from the frame along its direction, Pa.
    pub frame_tension_pa: f64,
    /// Direction of that tension, rad from +x towards +y.
    pub frame_direction_rad: f64,
}

/// Where a long crack begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LongCrackOrigin {
    /// At the most stressed place of the rim.
    Rim,
    /// At the tip of the longest crack of the first hit (a "floater", where it reaches no rim),
    /// before any further hit.
    Impact,
    /// At the tips of all cracks of each hit, before the next one.
    Legs,
}

/// How fast a long crack grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LongCrackGrowth {
    /// At the speed of a running crack.
    Sudden,
    /// By stress corrosion under repeated load.
    Slow {
        /// Time between two loads, s.
        period_s: f64,
    },
}

/// A crack under [`MembraneLoad`], after the hits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LongCrack {
    /// The load.
    pub load: MembraneLoad,
    /// Where it begins.
    pub origin: LongCrackOrigin,
    /// Length of the flaw that it begins at, m.
    pub flaw_m: f64,
    /// How fast it grows.
    pub growth: LongCrackGrowth,
}

/// How tempered glass goes to pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dicing {
    /// Cells around a hard-core point process with the count that σ_s and thickness give.
    Cells,
    /// Cracks that branch under the core's tension.
    Cascade,
}

/// Parameters of the model itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicsParams {
    /// How fine the mesh is. **Default** [`MeshResolution::Default`].
    pub mesh: MeshResolution,
    /// How often the stress is solved anew as cracks grow, 1 to 6. **Default** 6.
    pub epochs: u32,
    /// How tempered glass goes to pieces. **Default** [`Dicing::Cells`].
    pub dicing: Dicing,
    /// Prefactor C of the radial count n = C (V/c)^½ (E h/Γ)^¼. **Default** 4.1.
    /// **Source** \[Vandenberghe2013\]; FIT to its two PMMA points.
    pub radial_count_factor: f64,
    /// Characteristic tensile strength of the surface under a hit, Pa. **Default** 100 MPa.
    pub strength_pa: f64,
    /// Weibull modulus of that strength. **Default** 7.
    pub weibull_modulus: f64,
    /// Everything stops at the moment at which a crack gets this far from the first hit, m.
    /// **Default** none: nothing is stopped.
    pub until_reach_m: Option<f64>,
    /// How many pieces fall out after the first hit, before the others: first those that do not touch the rim, the
    /// largest first, then those of which the rim holds the smallest part. **Default** 0.
    pub n_fallen: u32,
}

impl Default for PhysicsParams {
    fn default() -> Self {
        Self {
            mesh: MeshResolution::Default,
            epochs: 6,
            dicing: Dicing::Cells,
            radial_count_factor: 4.1,
            strength_pa: 100e6,
            weibull_modulus: 7.0,
            until_reach_m: None,
            n_fallen: 0,
        }
    }
}

impl GlassPane {
    /// Every measure is in its range.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), FractureError> {
        let [width_m, height_m] = self.outline.size_m();
        FractureError::check_ranges(&[
            ("width_m", width_m, 2e-3, 10.0),
            ("height_m", height_m, 2e-3, 10.0),
            ("thickness_m", self.thickness_m, 1e-4, 0.03),
        ])?;
        match self.build {
            GlassBuild::Annealed => Ok(()),
            GlassBuild::Laminated {
                interlayer_thickness_m,
                interlayer_modulus_pa,
                inner_thickness_m,
            } => FractureError::check_ranges(&[
                ("inner_thickness_m", inner_thickness_m, 1e-4, 0.03),
                ("interlayer_thickness_m", interlayer_thickness_m, 5e-5, 0.02),
                ("interlayer_modulus_pa", interlayer_modulus_pa, 1e5, 1e10),
            ]),
            GlassBuild::Tempered {
                surface_compression_pa: compression_pa,
            } => {
                FractureError::check_ranges(&[("surface_compression_pa", compression_pa, 1e5, 1e9)])
            }
        }
    }
}

impl StoneImpact {
    /// Every measure is in its range.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), FractureError> {
        FractureError::check_ranges(&[
            ("speed_m_s", self.speed_m_s, 0.01, 1000.0),
            ("radius_m", self.radius_m, 5e-5, 0.2),
            ("tip_radius_m", self.tip_radius_m, 1e-5, self.radius_m),
            (
                "obliquity_rad",
                self.obliquity_rad,
                0.0,
                85_f64.to_radians(),
            ),
            ("azimuth_rad", self.azimuth_rad, -MOST_RAD, MOST_RAD),
        ])
    }
}

impl LongCrack {
    /// Every measure is in its range.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), FractureError> {
        let load = &self.load;
        let [x, y] = load.spot;
        let direction_rad = load.frame_direction_rad;
        FractureError::check_ranges(&[
            (
                "temperature_difference_k",
                load.temperature_difference_k,
                -300.0,
                300.0,
            ),
            ("spot", x, 0.0, 1.0),
            ("spot", y, 0.0, 1.0),
            ("spot_size", load.spot_size, 0.05, 5.0),
            ("frame_tension_pa", load.frame_tension_pa, 0.0, 1e8),
            ("frame_direction_rad", direction_rad, -MOST_RAD, MOST_RAD),
            ("flaw_m", self.flaw_m, 1e-5, 0.1),
        ])?;
        match self.growth {
            LongCrackGrowth::Sudden => Ok(()),
            LongCrackGrowth::Slow { period_s } => {
                FractureError::check_ranges(&[("period_s", period_s, 1e-3, 1e6)])
            }
        }
    }
}

impl PhysicsParams {
    /// Every parameter is in its range.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), FractureError> {
        FractureError::check_ranges(&[
            ("epochs", f64::from(self.epochs), 1.0, 6.0),
            ("radial_count_factor", self.radial_count_factor, 0.1, 100.0),
            ("strength_pa", self.strength_pa, 1e6, 1e10),
            ("weibull_modulus", self.weibull_modulus, 1.0, 100.0),
            (
                "until_reach_m",
                self.until_reach_m.unwrap_or(1.0),
                1e-4,
                20.0,
            ),
        ])
    }
}
