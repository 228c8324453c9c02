//! The whole model: impacts in, crack network out.

use starbreak_glass::{
    CrackNetwork, Generator, Impact, LengthUnit, Model, NETWORK_SCHEMA, NetworkData, Pane,
    SegmentKind,
};
use starbreak_seed::{Seed, Stream, uniform};

use super::params::{Direction, PaperImpact, PaperParams, Position};
use super::propagation::{ConvergenceReport, Propagation, ResolvedImpact, propagate};
use super::spanning_tree::euclidean_spanning_tree;
use crate::FractureError;
use crate::arrangement::{Stroke, arrange};
use crate::growth::grow;
use crate::lattice::Lattice;
use crate::mesh::{PaneMesh, mesh_pane};

/// A part of the work, reported when it is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Particles, and their triangulation where cracks walk along its edges.
    Mesh,
    /// Stress from node to node.
    Propagation,
    /// Minimum spanning tree of the stressed nodes.
    SpanningTree,
    /// Crossings turned into nodes, arrival order, invariants.
    Network,
}

/// What an impact leaves behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Fracture {
    /// The cracks.
    pub network: CrackNetwork,
    /// How the propagation came to rest.
    pub convergence: ConvergenceReport,
    /// Number of nodes of the mesh.
    pub n_mesh_nodes: usize,
    /// Number of triangles of the mesh.
    pub n_triangles: usize,
    /// Number of nodes that the spanning tree joined.
    pub n_stressed_nodes: usize,
}

impl Fracture {
    /// Whether anything broke. Nothing does when no force exceeds `σ_C`/S (eq. 2).
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.network.n_segments() == 0
    }
}

/// Breaks a pane by the paper's model. `done` is called at the end of every [`Stage`].
///
/// The result is a function of the arguments alone, to the last bit.
///
/// # Units
/// The pane's unit is the network's: px for a pane made by [`Pane::from_frame_px`].
///
/// # Errors
/// [`FractureError`] for parameters out of range, an impact off the pane, or a radius that
/// spans so many particles that the cracks could not be told apart.
///
/// # Limits
/// No material, no length scale, no time scale; see docs/theory/paper-fracture.md.
pub fn simulate(
    pane: &Pane,
    impacts: &[PaperImpact],
    params: &PaperParams,
    seed: Seed,
    mut done: impl FnMut(Stage),
) -> Result<Fracture, FractureError> {
    pane.check()?;
    params.check()?;
    params.check_neighbors(pane)?;
    for impact in impacts {
        impact.check(pane)?;
    }
    let hits: Vec<Impact> = (0_u64..)
        .zip(impacts)
        .map(|(k, impact)| draw_impact(pane, impact, seed, k))
        .collect();
    let places: Vec<[f64; 2]> = hits.iter().map(|hit| [hit.x, hit.y]).collect();
    let mesh = mesh_pane(pane, params.particles, &places, seed);
    if params.walks_along_edges() {
        // Now, so that this stage takes the time.
        mesh.edges()?;
    }
    done(Stage::Mesh);

    let resolved: Vec<ResolvedImpact> = hits
        .iter()
        .zip(impacts)
        .enumerate()
        .map(|(k, (hit, impact))| {
            let (sin, cos) = libm::sincos(hit.direction_deg.unwrap_or(0.0).to_radians());
            ResolvedImpact {
                node: mesh.particles().fixed_node(k),
                force: impact.force,
                direction: [cos, sin],
            }
        })
        .collect();
    let propagation = propagate(&mesh, &resolved, params)?;
    done(Stage::Propagation);

    let stressed = propagation.stressed_nodes(params.threshold());
    let mut strokes = propagated_strokes(&mesh, &propagation, params)?;
    strokes.extend(tree_strokes(&mesh, &propagation, &stressed, params)?);
    done(Stage::SpanningTree);

    let position = |node: u32| mesh.particles().position(node);
    let arranged = arrange(pane, mesh.particles().len(), position, strokes).map_err(|limit| {
        FractureError::TooManyCrossings {
            limit,
            radius: params.neighbor_radius,
            particles: params.particles,
            suggested: params.customary_radius(pane),
        }
    })?;
    let (nodes, segments) = grow(arranged, &places);
    let network = CrackNetwork::from_planar(NetworkData {
        schema: NETWORK_SCHEMA.to_owned(),
        generator: Generator {
            name: "starbreak".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        },
        model: Model::Paper,
        seed: Some(seed),
        unit: LengthUnit::Px,
        pane: *pane,
        damage_class: None,
        impacts: hits,
        nodes,
        segments,
        fallen: Vec::new(),
        summary: None,
    })?;
    done(Stage::Network);
    Ok(Fracture {
        network,
        convergence: propagation.convergence,
        n_mesh_nodes: mesh.particles().len(),
        n_triangles: mesh.n_triangles(),
        n_stressed_nodes: stressed.len(),
    })
}

/// Draws what is random in the `k`-th impact, each from a stream of its own.
fn draw_impact(pane: &Pane, impact: &PaperImpact, seed: Seed, k: u64) -> Impact {
    let lattice = Lattice::of_pane(pane);
    let (x, y) = match impact.position {
        Position::Random { share } => {
            let mut rng = seed.stream(Stream::ImpactPosition, k);
            let mut along = |side: f64| (0.5 * (1.0 - share) + share * uniform(&mut rng)) * side;
            let (x, y) = (along(pane.width), along(pane.height));
            (
                lattice.round_inside(x, pane.width),
                lattice.round_inside(y, pane.height),
            )
        }
        Position::At { x, y } => (lattice.round(x), lattice.round(y)),
    };
    let direction_deg = match impact.direction {
        Direction::Random => uniform(&mut seed.stream(Stream::ImpactDirection, k)) * 360.0,
        Direction::Angle { rad } => rad.to_degrees(),
    };
    Impact {
        x: x.clamp(0.0, pane.width),
        y: y.clamp(0.0, pane.height),
        force: Some(impact.force),
        direction_deg: Some(direction_deg),
        ..Impact::default()
    }
}

/// The propagated edges, each from one step to the next.
fn propagated_strokes(
    mesh: &PaneMesh,
    propagation: &Propagation,
    params: &PaperParams,
) -> Result<Vec<Stroke>, FractureError> {
    let mut strokes = Vec::with_capacity(propagation.hops.len());
    for hop in &propagation.hops {
        let end = f64::from(hop.step);
        let stroke = Stroke {
            a: hop.from,
            b: hop.to,
            kind: SegmentKind::Propagated,
            arrival: [end - 1.0, end],
            stress: [hop.stress, hop.stress],
            is_suspect: true,
            source: 0,
        };
        if params.snap_to_mesh {
            walk(mesh, stroke, &mut strokes)?;
        } else {
            strokes.push(stroke);
        }
    }
    Ok(strokes)
}

/// Replaces a jump by the mesh edges of a greedy walk, its step shared among them by length.
fn walk(mesh: &PaneMesh, jump: Stroke, strokes: &mut Vec<Stroke>) -> Result<(), FractureError> {
    let edges = mesh.edges()?;
    let first = strokes.len();
    let mut lengths = vec![0.0];
    let mut at = jump.a;
    while at != jump.b {
        let next = edges.next_towards(at, jump.b);
        let ([x, y], [next_x, next_y]) = (
            mesh.particles().position(at),
            mesh.particles().position(next),
        );
        let (dx, dy) = (next_x - x, next_y - y);
        lengths.push(lengths[lengths.len() - 1] + (dx * dx + dy * dy).sqrt());
        strokes.push(Stroke {
            a: at,
            b: next,
            ..jump
        });
        at = next;
    }
    let total = lengths[lengths.len() - 1];
    for (k, stroke) in strokes[first..].iter_mut().enumerate() {
        let at =
            |k: usize| jump.arrival[0] + (jump.arrival[1] - jump.arrival[0]) * (lengths[k] / total);
        stroke.arrival = [at(k), at(k + 1)];
    }
    Ok(())
}

/// The spanning tree of the stressed nodes; edges longer than the neighborhood are left out,
/// so that it joins only what stress could pass between. Each grows from the node that was
/// stressed first.
fn tree_strokes(
    mesh: &PaneMesh,
    propagation: &Propagation,
    stressed: &[u32],
    params: &PaperParams,
) -> Result<Vec<Stroke>, FractureError> {
    let points: Vec<[f64; 2]> = stressed
        .iter()
        .map(|&node| mesh.particles().position(node))
        .collect();
    let tree = euclidean_spanning_tree(&points)?;
    let strokes = tree
        .into_iter()
        .filter(|edge| edge.length <= params.neighbor_radius)
        .map(|edge| {
            let (a, b) = (stressed[edge.a as usize], stressed[edge.b as usize]);
            let time = |node: u32| f64::from(propagation.first_step[node as usize]);
            let stress = |node: u32| propagation.stress[node as usize];
            Stroke {
                a,
                b,
                kind: SegmentKind::Mst,
                arrival: [time(a).max(time(b)); 2],
                stress: [stress(a), stress(b)],
                is_suspect: true,
                source: 0,
            }
        });
    Ok(strokes.collect())
}
