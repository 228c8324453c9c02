use std::borrow::Cow;

use starbreak_glass::{NetworkError, PaneError};

/// Why no crack network came out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FractureError {
    /// A parameter outside its range.
    #[error("{name} = {value}; expected {expected}")]
    Parameter {
        /// Name of the parameter, with its unit.
        name: &'static str,
        /// What was given.
        value: f64,
        /// What is possible.
        expected: Cow<'static, str>,
    },
    /// The pane has no area.
    #[error(transparent)]
    Pane(#[from] PaneError),
    /// An impact that misses the pane.
    #[error("impact at ({x}, {y}) misses the pane of {width} × {height}; move it inside")]
    ImpactOffPane {
        /// Its position, in the pane's unit.
        x: f64,
        /// Its position, in the pane's unit.
        y: f64,
        /// Width of the pane.
        width: f64,
        /// Height of the pane.
        height: f64,
    },
    /// The triangulation refused a point.
    #[error("triangulation of {n_nodes} nodes failed: {cause}")]
    Triangulation {
        /// How many nodes.
        n_nodes: usize,
        /// What the library says.
        cause: String,
    },
    /// A radius that spans so many particles that the work explodes.
    #[error(
        "a neighborhood of radius {radius} spans about {neighbors:.0} of the {particles} particles, which with {branches} \
         branches is more than {limit:.0} to look at from each; take fewer particles, or scale the radius with the mesh, \
         about {suggested:.1}"
    )]
    TooManyNeighbors {
        /// Expected number of neighbors.
        neighbors: f64,
        /// Number of branches.
        branches: u32,
        /// The bound.
        limit: f64,
        /// Radius of the neighborhood.
        radius: f64,
        /// Number of particles.
        particles: u32,
        /// A radius that gives the paper's number of neighbors.
        suggested: f64,
    },
    /// Too many crossings for a network that anybody could use.
    #[error(
        "more than {limit} cracks cross each other: a neighborhood of radius {radius} spans too many of the {particles} \
         particles; scale it with the mesh, about {suggested:.1}"
    )]
    TooManyCrossings {
        /// The bound.
        limit: usize,
        /// Radius of the neighbourhood.
        radius: f64,
        /// Number of particles.
        particles: u32,
        /// A radius that keeps the paper's number of neighbors.
        suggested: f64,
    },
    /// More cracks than a network of any use has.
    #[error("more than {limit} cracks cross each other; use fewer impacts or a smaller pane")]
    TooManyCracks {
        /// The bound.
        limit: usize,
    },
    /// A drawn line that leaves the pane.
    #[error("a line has a point at ({x}, {y}), off the pane of {width} × {height}; clip it")]
    TraceOffPane {
        /// The point, in the pane's unit.
        x: f64,
        /// The point, in the pane's unit.
        y: f64,
        /// Width of the pane.
        width: f64,
        /// Height of the pane.
        height: f64,
    },
    /// Drawn lines that meet more often than those of any crack.
    #[error("the lines meet more than {limit} times, or lie too close to tell; draw fewer lines")]
    TooManyContacts {
        /// The bound.
        limit: usize,
    },
    /// So many dice that nobody could see them.
    #[error(
        "a pane of {width_mm:.0} × {height_mm:.0} mm with its surfaces under {compression_mpa} MPa breaks into \
         {expected:.0} dice, more than {limit:.0}; make it smaller or lower the compression"
    )]
    TooManyDice {
        /// Expected number of dice.
        expected: f64,
        /// The bound.
        limit: f64,
        /// Width of the pane.
        width_mm: f64,
        /// Height of the pane.
        height_mm: f64,
        /// Compression of its surface.
        compression_mpa: f64,
    },
    /// The equations of a plate cannot be set up or factored.
    #[error("the plate's equations have no solution: {cause}")]
    Solver {
        /// What the library says.
        cause: String,
    },
    /// The solution of a plate does not satisfy its equations.
    #[error(
        "the plate's equations are solved to {residual:e} only, not to {limit:e}; use a less graded mesh"
    )]
    Residual {
        /// Residual, relative to the terms of the equations.
        residual: f64,
        /// The most that counts as solved.
        limit: f64,
    },
    /// The result does not keep the promises of a network; a fault of this library.
    #[error("the fracture model produced a faulty network (please report it): {0}")]
    Network(#[from] NetworkError),
}

impl FractureError {
    /// Each value is in its range, of which rows give the least and the most; not a number is in
    /// none. The last digits, which a change of unit may cost, do not count.
    ///
    /// # Errors
    /// [`FractureError::Parameter`] with what was given and what is possible.
    pub(crate) fn check_ranges(rows: &[(&'static str, f64, f64, f64)]) -> Result<(), Self> {
        for &(name, value, least, most) in rows {
            let slack = |bound: f64| 1e-12 * bound.abs();
            if !(least - slack(least)..=most + slack(most)).contains(&value) {
                return Err(Self::Parameter {
                    name,
                    value,
                    expected: format!("{least} to {most}").into(),
                });
            }
        }
        Ok(())
    }
}
