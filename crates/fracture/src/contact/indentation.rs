//! Indentation to force: Hertz's law, cut off where stone and glass crush.

use std::f64::consts::PI;

use starbreak_glass::Material;

use crate::params::StoneImpact;

/// Vickers hardness of soda-lime glass, Pa: no contact can press it harder. **Source**
/// \[LawnMarshall1979\].
const GLASS_HARDNESS_PA: f64 = 5.5e9;

/// Force as a function of the approach δ of stone and glass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Indentation {
    /// E*, Pa.
    modulus_pa: f64,
    /// Of the tip, m.
    tip_radius_m: f64,
    /// Of the stone: no contact is larger.
    stone_radius_m: f64,
    /// Highest pressure of the contact, Pa.
    limit_pa: f64,
    /// δ at which the highest pressure reaches the limit, m.
    crush_m: f64,
    /// Deepest δ and the law after it; `None` while δ grows.
    unloading: Option<Unloading>,
}

#[derive(Debug, Clone, Copy)]
struct Unloading {
    /// δ at which the stone leaves its dent, m.
    dent_m: f64,
    /// F = stiffness (δ − dent)^1.5.
    stiffness: f64,
}

impl Indentation {
    pub(super) fn new(stone: &StoneImpact, material: &Material) -> Self {
        let in_plane = |poisson_ratio: f64| 1.0 - poisson_ratio * poisson_ratio;
        let glass_pa = material.young_modulus_pa.value / in_plane(material.poisson_ratio.value);
        let stone_pa = stone.young_modulus_pa / in_plane(stone.poisson_ratio);
        let modulus_pa = 1.0 / (1.0 / glass_pa + 1.0 / stone_pa);
        let limit_pa = GLASS_HARDNESS_PA.min(stone.crushing_pa);
        // Hertz: p0 = (2 E*/π) √(δ/R).
        let slope = PI * limit_pa / (2.0 * modulus_pa);
        let crush_m = stone.tip_radius_m * (slope * slope);
        Self {
            modulus_pa,
            tip_radius_m: stone.tip_radius_m,
            stone_radius_m: stone.radius_m,
            limit_pa,
            crush_m,
            unloading: None,
        }
    }

    /// K of F = K δ^1.5.
    pub(super) fn stiffness(&self) -> f64 {
        4.0 / 3.0 * self.modulus_pa * self.tip_radius_m.sqrt()
    }

    /// δ at which the contact is as wide as the stone.
    fn widest_m(&self) -> f64 {
        (self.stone_radius_m * self.stone_radius_m / self.tip_radius_m).max(self.crush_m)
    }

    /// Force and its derivative.
    pub(super) fn force(&self, depth_m: f64) -> (f64, f64) {
        let hertz = |stiffness: f64, depth: f64| {
            let root = depth.max(0.0).sqrt();
            (stiffness * depth.max(0.0) * root, 1.5 * stiffness * root)
        };
        if let Some(unloading) = &self.unloading {
            return hertz(unloading.stiffness, depth_m - unloading.dent_m);
        }
        if depth_m <= self.crush_m {
            return hertz(self.stiffness(), depth_m);
        }
        let (at_crush, _) = hertz(self.stiffness(), self.crush_m);
        let slope = PI * self.tip_radius_m * self.limit_pa;
        let widest = self.widest_m();
        if depth_m < widest {
            (at_crush + slope * (depth_m - self.crush_m), slope)
        } else {
            (at_crush + slope * (widest - self.crush_m), 0.0)
        }
    }

    /// Work ∫F dδ from the first touch, J, on the way in.
    pub(super) fn work_j(&self, depth_m: f64) -> f64 {
        let hertz_depth = depth_m.min(self.crush_m).max(0.0);
        let elastic = 0.4 * self.stiffness() * hertz_depth * hertz_depth * hertz_depth.sqrt();
        if depth_m <= self.crush_m {
            return elastic;
        }
        let at_crush = self.stiffness() * self.crush_m * self.crush_m.sqrt();
        let slope = PI * self.tip_radius_m * self.limit_pa;
        let widest = self.widest_m();
        let linear = depth_m.min(widest) - self.crush_m;
        let flat = (depth_m - widest).max(0.0);
        elastic
            + at_crush * linear
            + 0.5 * slope * linear * linear
            + (at_crush + slope * (widest - self.crush_m)) * flat
    }

    /// Radius of the contact, m.
    pub(super) fn radius_m(&self, depth_m: f64) -> f64 {
        (self.tip_radius_m * depth_m)
            .sqrt()
            .min(self.stone_radius_m)
    }

    /// Radius within which the pressure is at its limit, m.
    pub(super) fn crushed_radius_m(&self, depth_m: f64) -> f64 {
        (self.tip_radius_m * (depth_m - self.crush_m).max(0.0))
            .sqrt()
            .min(self.stone_radius_m)
    }

    pub(super) fn is_crushed_at(&self, depth_m: f64) -> bool {
        depth_m > self.crush_m
    }

    /// From now on δ decreases from `deepest_m`: an elastic contact of the radius and force that
    /// are there, in a dent that stays. Returns the work that the dent keeps, J.
    pub(super) fn unload_from(&mut self, deepest_m: f64) -> f64 {
        let (force_n, _) = self.force(deepest_m);
        let radius_m = self.radius_m(deepest_m);
        let curvature_m = 4.0 / 3.0 * self.modulus_pa * (radius_m * radius_m * radius_m) / force_n;
        let rebound_m = radius_m * radius_m / curvature_m;
        let kept_j = self.work_j(deepest_m) - 0.4 * force_n * rebound_m;
        self.unloading = Some(Unloading {
            dent_m: deepest_m - rebound_m,
            stiffness: 4.0 / 3.0 * self.modulus_pa * curvature_m.sqrt(),
        });
        kept_j
    }

    /// Elastic energy that is still stored, J.
    pub(super) fn stored_j(&self, depth_m: f64) -> f64 {
        match &self.unloading {
            Some(unloading) => 0.4 * self.force(depth_m).0 * (depth_m - unloading.dent_m).max(0.0),
            None => self.work_j(depth_m),
        }
    }

    /// Whether stone and glass have parted.
    pub(super) fn is_open(&self, depth_m: f64) -> bool {
        depth_m <= self.unloading.map_or(0.0, |unloading| unloading.dent_m)
    }
}
