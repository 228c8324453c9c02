//! A plane stress state at a point of a surface.

/// Plane stress, Pa; tension is positive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlaneStress {
    /// σ_xx.
    pub xx_pa: f64,
    /// σ_yy.
    pub yy_pa: f64,
    /// σ_xy.
    pub xy_pa: f64,
}

impl PlaneStress {
    /// Normal stress on a cut whose unit normal is `n`: n·σ·n.
    #[must_use]
    pub fn normal_pa(&self, [nx, ny]: [f64; 2]) -> f64 {
        nx * nx * self.xx_pa + 2.0 * nx * ny * self.xy_pa + ny * ny * self.yy_pa
    }

    /// Principal stresses σ_I ≥ σ_II and the unit direction of σ_I (its sign is arbitrary).
    #[must_use]
    pub fn principal(&self) -> (f64, f64, [f64; 2]) {
        let mean = 0.5 * (self.xx_pa + self.yy_pa);
        let half = 0.5 * (self.xx_pa - self.yy_pa);
        let radius = libm::hypot(half, self.xy_pa);
        let (sin, cos) = libm::sincos(0.5 * libm::atan2(self.xy_pa, half));
        (mean + radius, mean - radius, [cos, sin])
    }

    /// `self + other * factor`.
    #[must_use]
    pub fn plus(&self, other: &Self, factor: f64) -> Self {
        Self {
            xx_pa: self.xx_pa + factor * other.xx_pa,
            yy_pa: self.yy_pa + factor * other.yy_pa,
            xy_pa: self.xy_pa + factor * other.xy_pa,
        }
    }
}

/// Whatever knows the stress that a crack tip runs through.
pub trait StressField {
    /// The stress at a point of the pane, m; `None` off the pane. `hint` is handed from one call
    /// to the next on a path and makes them fast; start with 0.
    fn stress_at(&self, point_m: [f64; 2], hint: &mut u32) -> Option<PlaneStress>;
}
