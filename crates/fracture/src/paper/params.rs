//! Parameters of the paper's fracture model.

use starbreak_glass::Pane;

use crate::FractureError;

/// What is positive is at least this.
const LEAST: f64 = 1e-12;

/// And at most this.
const MOST: f64 = 1e12;

/// Which nodes count as neighbors of a node (section 3.1 and Algorithm 1 differ).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Neighborhood {
    /// All nodes within the radius, as Algorithm 1 and the paper's implementation say.
    Radius,
    /// The nodes within the radius that share a mesh edge, as the text of section 3.1 says.
    MeshEdges,
}

/// How the next node is chosen among the neighbors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Highest stress of all (Algorithm 1).
    Algorithm1,
    /// Highest stress on the side of the splitting plane that carries more of it, the plane
    /// taken along the direction of travel (caption of figure 3).
    Caption,
    /// Eqs. 3 to 5 to the letter: the sum q1 of positive stress against the sum q2 of negative
    /// stress, then the highest stress on the greater side. Mostly steps backward and dies.
    Literal,
}

/// Where an impact is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Position {
    /// Uniform over the middle of the pane, from the seed.
    Random {
        /// Share of either side of the pane, 0 to 1.
        share: f64,
    },
    /// At this point, in the pane's unit.
    At {
        /// From the left.
        x: f64,
        /// From the top.
        y: f64,
    },
}

/// Direction of the impact vector in the plane of the pane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Direction {
    /// Uniform over the circle, from the seed.
    Random,
    /// This angle, from +x towards +y (down), radians.
    Angle {
        /// The angle, rad.
        rad: f64,
    },
}

/// One impact of the paper's model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperImpact {
    /// Where. **Default**: random.
    pub position: Position,
    /// Impact force F, in the paper's own unit, > 0. **Default**: 500. **Source**: section 4.2.
    pub force: f64,
    /// Direction of the impact vector n. **Default**: random.
    pub direction: Direction,
}

impl Default for PaperImpact {
    fn default() -> Self {
        Self {
            position: Position::Random { share: 1.0 },
            force: 500.0,
            direction: Direction::Random,
        }
    }
}

/// Parameters of the paper's fracture model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperParams {
    /// Number N of particles, 1 to 10 million. **Default**: 10⁴. **Source**: section 4.2.
    pub particles: u32,
    /// Radius R of the neighborhood, in the pane's unit (px), > 0. **Default**: 65. **Source**:
    /// the paper's implementation; the text gives none.
    pub neighbor_radius: f64,
    /// Which nodes are neighbors. **Default**: [`Neighborhood::Radius`].
    pub neighborhood: Neighborhood,
    /// Critical stress `σ_C`, in the unit of F, > 0. **Default**: 300. **Source**: section 4.2.
    pub critical_stress: f64,
    /// Safety factor S, > 0: stress breaks a node above `σ_C`/S (eq. 2). **Default**: 1.
    pub safety_factor: f64,
    /// Choice of the next node. **Default**: [`Rule::Algorithm1`].
    pub rule: Rule,
    /// Number K of branches that leave a node, 1 to 64, each with its own direction.
    /// **Default**: 1.
    pub branches: u32,
    /// Whether the first ring takes |cos θ|, so that the fan opens both ways. **Default**: no.
    pub two_sided: bool,
    /// Whether a hop walks along mesh edges instead of jumping. **Default**: no.
    pub snap_to_mesh: bool,
}

impl Default for PaperParams {
    fn default() -> Self {
        Self {
            particles: 10_000,
            neighbor_radius: 65.0,
            neighborhood: Neighborhood::Radius,
            critical_stress: 300.0,
            safety_factor: 1.0,
            rule: Rule::Algorithm1,
            branches: 1,
            two_sided: false,
            snap_to_mesh: false,
        }
    }
}

impl PaperParams {
    /// Most particles: node ids and the triangulation stay within 32 bits and a few GB.
    pub const MAX_PARTICLES: u32 = 10_000_000;
    /// Most neighbors of a particle on average, times branches, times two for a two-sided fan;
    /// the paper has 285.
    pub const MAX_NEIGHBORS: f64 = 20_000.0;
    /// Most of them by themselves. The paper's 10⁴ particles may all be neighbors, as on a frame
    /// smaller than its radius, but with many more of them cracks cross each other everywhere.
    pub const MAX_CROWD: f64 = 12_000.0;
    /// Most of the first over all particles: some ten seconds. Of 10⁷ particles it leaves 400 each.
    pub const MAX_PAIRS: f64 = 4e9;
    /// Most branches per node.
    pub const MAX_BRANCHES: u32 = 64;

    /// The stress T = `σ_C`/S above which a node breaks (eq. 2).
    #[must_use]
    pub fn threshold(&self) -> f64 {
        self.critical_stress / self.safety_factor
    }

    /// Whether anything depends on the edges of the mesh; else only its nodes matter.
    #[must_use]
    pub fn walks_along_edges(&self) -> bool {
        self.neighborhood == Neighborhood::MeshEdges || self.snap_to_mesh
    }

    /// The radius that keeps the number of neighbors of the paper's N = 10⁴ and R = 65 for
    /// another number of particles: R = 65·√(10⁴/N), in px.
    #[must_use]
    pub fn mesh_scaled_radius(particles: u32) -> f64 {
        65.0 * (1e4 / f64::from(particles.max(1))).sqrt()
    }

    /// The radius that has the paper's number of neighbors (285 on average, for N = 10⁴ and
    /// R = 65 on 1242 × 375) with this number of particles on this pane.
    #[must_use]
    pub fn customary_radius(&self, pane: &Pane) -> f64 {
        let per_neighbor = pane.width * pane.height / f64::from(self.particles.max(1));
        (285.0 * per_neighbor / std::f64::consts::PI).sqrt()
    }

    /// The number of particles that the radius spans on average, far from the rim.
    #[must_use]
    pub fn expected_neighbors(&self, pane: &Pane) -> f64 {
        let area = std::f64::consts::PI * self.neighbor_radius * self.neighbor_radius;
        f64::from(self.particles) * (area / (pane.width * pane.height)).min(1.0)
    }

    /// The radius does not span so many particles that the work explodes.
    pub(crate) fn check_neighbors(&self, pane: &Pane) -> Result<(), FractureError> {
        let neighbors = self.expected_neighbors(pane);
        let work = neighbors * f64::from(self.branches) * if self.two_sided { 2.0 } else { 1.0 };
        let limit = if neighbors > Self::MAX_CROWD {
            Self::MAX_CROWD
        } else {
            (Self::MAX_PAIRS / f64::from(self.particles)).min(Self::MAX_NEIGHBORS)
        };
        if self.neighborhood == Neighborhood::MeshEdges || work <= limit {
            return Ok(());
        }
        Err(FractureError::TooManyNeighbors {
            neighbors,
            branches: self.branches,
            limit,
            radius: self.neighbor_radius,
            particles: self.particles,
            suggested: self.customary_radius(pane),
        })
    }

    /// Every parameter is in its range.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), FractureError> {
        FractureError::check_ranges(&[
            ("neighbor_radius", self.neighbor_radius, LEAST, MOST),
            ("critical_stress", self.critical_stress, LEAST, MOST),
            ("safety_factor", self.safety_factor, LEAST, MOST),
            (
                "critical_stress / safety_factor",
                self.threshold(),
                LEAST,
                MOST,
            ),
            (
                "particles",
                self.particles.into(),
                1.0,
                Self::MAX_PARTICLES.into(),
            ),
            (
                "branches",
                self.branches.into(),
                1.0,
                Self::MAX_BRANCHES.into(),
            ),
        ])
    }
}

impl PaperImpact {
    /// The impact hits the pane with a force that is a force.
    ///
    /// # Errors
    /// [`FractureError`] naming what is out of range.
    pub fn check(&self, pane: &Pane) -> Result<(), FractureError> {
        FractureError::check_ranges(&[("force", self.force, LEAST, MOST)])?;
        if let Direction::Angle { rad } = self.direction
            && !rad.is_finite()
        {
            return Err(FractureError::Parameter {
                name: "direction",
                value: rad,
                expected: "a finite angle".into(),
            });
        }
        if let Position::At { x, y } = self.position
            && !pane.contains(x, y)
        {
            return Err(FractureError::ImpactOffPane {
                x,
                y,
                width: pane.width,
                height: pane.height,
            });
        }
        Ok(())
    }
}
