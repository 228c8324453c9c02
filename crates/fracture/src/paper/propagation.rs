//! Stress handed from node to node (eqs. 2 to 5, Algorithm 1).

use crate::FractureError;
use crate::mesh::{MeshEdges, PaneMesh, Particles};

use super::params::{Neighborhood, PaperParams, Rule};

/// One impact with everything random already drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResolvedImpact {
    /// The node that is hit.
    pub node: u32,
    /// Impact force F.
    pub force: f64,
    /// Unit vector n of the impact in the plane of the pane.
    pub direction: [f64; 2],
}

/// One step of a crack from node to node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hop {
    /// Node it left.
    pub from: u32,
    /// Node it reached.
    pub to: u32,
    /// Number of hops from the impact to `to`: the discrete time of its arrival in δt.
    pub step: u32,
    /// Stress handed on to `to` (eq. 3).
    pub stress: f64,
}

/// Why cracks stopped, counted over all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// The best neighbor gets less than the threshold.
    BelowThreshold,
    /// The best neighbor is broken already.
    MetCrack,
    /// There is no neighbor at all.
    NoNeighbor,
}

/// How the propagation came to rest.
///
/// The paper runs "until σ(t) ≃ σ(t−1)". Since every node breaks at most once, the propagation
/// always ends; then no node is left to hand stress on and σ no longer changes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ConvergenceReport {
    /// Largest stress that one front added to one node at each step δt, the first entry for the
    /// impact's own ring.
    pub max_stress_change: Vec<f64>,
    /// Nodes that handed stress on, the impacts included.
    pub n_fronts: usize,
    /// Cracks that ended because no neighbor was stressed above the threshold.
    pub stopped_below_threshold: usize,
    /// Cracks that ended at a node that was broken already.
    pub stopped_at_crack: usize,
    /// Cracks that ended where the radius holds no other node.
    pub stopped_without_neighbor: usize,
    /// Fronts that still had stress to hand on when the propagation ended.
    pub fronts_left: usize,
    /// Impacts whose force does not exceed the threshold (eq. 2): they break nothing.
    pub impacts_without_fracture: usize,
}

impl ConvergenceReport {
    /// Steps until rest.
    #[must_use]
    pub fn n_steps(&self) -> usize {
        self.max_stress_change.len()
    }

    /// Whether σ has come to rest: no front is left to hand stress on, so σ(t) = σ(t−1).
    #[must_use]
    pub fn converged(&self) -> bool {
        self.fronts_left == 0
    }

    fn record_change(&mut self, step: u32, change: f64) {
        let step = step as usize;
        if self.max_stress_change.len() <= step {
            self.max_stress_change.resize(step + 1, 0.0);
        }
        self.max_stress_change[step] = self.max_stress_change[step].max(change);
    }

    fn record_stop(&mut self, reason: StopReason) {
        match reason {
            StopReason::BelowThreshold => self.stopped_below_threshold += 1,
            StopReason::MetCrack => self.stopped_at_crack += 1,
            StopReason::NoNeighbor => self.stopped_without_neighbor += 1,
        }
    }
}

/// What the propagation leaves behind.
#[derive(Debug, Clone, PartialEq)]
pub struct Propagation {
    /// The cracks, in the order in which they were made.
    pub hops: Vec<Hop>,
    /// Stress σ accumulated at each node.
    pub stress: Vec<f64>,
    /// Step at which each node was first reached by stress; `u32::MAX` for never.
    pub first_step: Vec<u32>,
    /// Whether each node broke.
    pub visited: Vec<bool>,
    /// How it came to rest.
    pub convergence: ConvergenceReport,
}

impl Propagation {
    /// The stressed nodes in ascending order: σ > T, or broken (figure 3b).
    #[must_use]
    pub fn stressed_nodes(&self, threshold: f64) -> Vec<u32> {
        (0_u32..)
            .zip(self.stress.iter().zip(&self.visited))
            .filter(|(_, (stress, visited))| **stress > threshold || **visited)
            .map(|(node, _)| node)
            .collect()
    }
}

/// A node that is about to hand its stress on.
#[derive(Clone, Copy)]
struct Front {
    node: u32,
    stress: f64,
    direction: [f64; 2],
    step: u32,
}

/// A neighbor, the way to it, and what it gets: `s = f·cos θ` (eq. 3).
#[derive(Clone, Copy)]
struct Candidate {
    node: u32,
    stress: f64,
    way: [f64; 2],
}

/// Hands the stress of every impact on, one impact after the other over the same nodes.
///
/// # Errors
/// As for [`PaneMesh::edges`], if stress passes along these.
pub fn propagate(
    mesh: &PaneMesh,
    impacts: &[ResolvedImpact],
    params: &PaperParams,
) -> Result<Propagation, FractureError> {
    let n = mesh.particles().len();
    let state = Propagation {
        hops: Vec::new(),
        stress: vec![0.0; n],
        first_step: vec![u32::MAX; n],
        visited: vec![false; n],
        convergence: ConvergenceReport::default(),
    };
    let edges = match params.neighborhood {
        Neighborhood::Radius => None,
        Neighborhood::MeshEdges => Some(mesh.edges()?),
    };
    let mut run = Run {
        particles: mesh.particles(),
        edges,
        params,
        state,
        fronts: Vec::new(),
        candidates: Vec::new(),
    };
    for impact in impacts {
        run.strike(impact);
    }
    run.state.convergence.fronts_left = run.fronts.len();
    Ok(run.state)
}

/// A propagation on its way.
struct Run<'a> {
    particles: &'a Particles,
    /// What neighbors must share one of, besides being near.
    edges: Option<&'a MeshEdges>,
    params: &'a PaperParams,
    state: Propagation,
    fronts: Vec<Front>,
    /// Neighbors of the front at hand.
    candidates: Vec<Candidate>,
}

impl Run<'_> {
    /// One impact and all that follows from it.
    fn strike(&mut self, impact: &ResolvedImpact) {
        if impact.force <= self.params.threshold() {
            self.state.convergence.impacts_without_fracture += 1;
            return;
        }
        let center = impact.node as usize;
        self.state.stress[center] += impact.force;
        self.state.first_step[center] = 0;
        self.state.visited[center] = true;
        let ResolvedImpact {
            node,
            force,
            direction,
        } = *impact;
        self.first_ring(Front {
            node,
            stress: force,
            direction,
            step: 0,
        });
        // Last in, first out: one crack runs to its end before the next, as the paper recurses.
        while let Some(front) = self.fronts.pop() {
            self.advance(front);
        }
    }

    /// The neighbors of the impact: each one stressed above the threshold starts a crack of its
    /// own.
    fn first_ring(&mut self, front: Front) {
        self.gather(front);
        for candidate in &mut self.candidates {
            // Behind the impact no stress arrives, unless the fan opens both ways.
            let stress = candidate.stress;
            candidate.stress = if self.params.two_sided {
                stress.abs()
            } else {
                stress.max(0.0)
            };
        }
        self.hand_on(front.step);
        if self.candidates.is_empty() {
            self.state.convergence.record_stop(StopReason::NoNeighbor);
        }
        for k in 0..self.candidates.len() {
            let candidate = self.candidates[k];
            if candidate.stress > self.params.threshold()
                && !self.state.visited[candidate.node as usize]
            {
                self.break_node(front, candidate);
            }
        }
    }

    /// One front: every neighbor is stressed, the best `branches` of them break.
    fn advance(&mut self, front: Front) {
        self.gather(front);
        self.hand_on(front.step);
        choose_side(self.params.rule, front.direction, &mut self.candidates);
        let mut advanced = false;
        let mut reason = StopReason::NoNeighbor;
        for _ in 0..self.params.branches {
            let Some(best) = highest(&self.candidates) else {
                break;
            };
            let candidate = self.candidates[best];
            if candidate.stress <= self.params.threshold() {
                reason = StopReason::BelowThreshold;
                break;
            }
            if self.state.visited[candidate.node as usize] {
                reason = StopReason::MetCrack;
            } else {
                self.break_node(front, candidate);
                advanced = true;
            }
            if self.params.branches > 1 {
                self.candidates.remove(best);
            }
        }
        if !advanced {
            self.state.convergence.record_stop(reason);
        }
    }

    /// All neighbors of a front with the stress they get, in ascending order of nodes.
    fn gather(&mut self, front: Front) {
        self.candidates.clear();
        let Front {
            node,
            stress,
            direction: [vx, vy],
            ..
        } = front;
        let radius = self.params.neighbor_radius;
        let mut visit = |other: u32, dx: f64, dy: f64, distance2: f64| {
            let cos_theta = (vx * dx + vy * dy) / distance2.sqrt();
            self.candidates.push(Candidate {
                node: other,
                stress: stress * cos_theta,
                way: [dx, dy],
            });
        };
        let Some(edges) = self.edges else {
            self.particles.for_each_within(node, radius, visit);
            return;
        };
        let [x, y] = self.particles.position(node);
        for (other, [other_x, other_y]) in edges.neighbors(node) {
            let (dx, dy) = (other_x - x, other_y - y);
            let distance2 = dx * dx + dy * dy;
            if distance2 <= radius * radius {
                visit(other, dx, dy, distance2);
            }
        }
        self.candidates
            .sort_unstable_by_key(|candidate| candidate.node);
    }

    /// Adds stress to every neighbor, whether the crack goes there or not.
    fn hand_on(&mut self, step: u32) {
        let mut change = 0.0_f64;
        for &Candidate { node, stress, .. } in &self.candidates {
            let node = node as usize;
            self.state.stress[node] += stress;
            self.state.first_step[node] = self.state.first_step[node].min(step + 1);
            change = change.max(stress.abs());
        }
        self.state.convergence.n_fronts += 1;
        self.state.convergence.record_change(step, change);
    }

    fn break_node(&mut self, front: Front, candidate: Candidate) {
        let Candidate {
            node,
            stress,
            way: [dx, dy],
        } = candidate;
        self.state.visited[node as usize] = true;
        let step = front.step + 1;
        self.state.hops.push(Hop {
            from: front.node,
            to: node,
            step,
            stress,
        });
        let length = (dx * dx + dy * dy).sqrt();
        self.fronts.push(Front {
            node,
            stress,
            direction: [dx / length, dy / length],
            step,
        });
    }
}

/// Place of the highest stress; of equals, the lower node (candidates come in ascending order).
fn highest(candidates: &[Candidate]) -> Option<usize> {
    let mut best: Option<usize> = None;
    for (k, candidate) in candidates.iter().enumerate() {
        if best.is_none_or(|best| candidate.stress > candidates[best].stress) {
            best = Some(k);
        }
    }
    best
}

/// Leaves only the candidates that the rule lets compete, with the stress by which they do.
fn choose_side(rule: Rule, [vx, vy]: [f64; 2], candidates: &mut Vec<Candidate>) {
    match rule {
        Rule::Algorithm1 => {}
        Rule::Caption => {
            // The splitting plane contains the direction of travel; a node on it is on both sides.
            let side = |candidate: &Candidate| vx * candidate.way[1] - vy * candidate.way[0];
            let (mut q1, mut q2) = (0.0, 0.0);
            for candidate in candidates.iter() {
                let positive = candidate.stress.max(0.0);
                if side(candidate) >= 0.0 {
                    q1 += positive;
                }
                if side(candidate) <= 0.0 {
                    q2 += positive;
                }
            }
            candidates.retain(|candidate| {
                if q1 >= q2 {
                    side(candidate) >= 0.0
                } else {
                    side(candidate) <= 0.0
                }
            });
        }
        Rule::Literal => {
            let q1: f64 = candidates
                .iter()
                .map(|candidate| candidate.stress.max(0.0))
                .sum();
            let q2: f64 = candidates
                .iter()
                .map(|candidate| candidate.stress.min(0.0))
                .sum();
            if q2.abs() > q1.abs() {
                candidates.retain(|candidate| candidate.stress < 0.0);
                for candidate in candidates.iter_mut() {
                    candidate.stress = -candidate.stress;
                }
            }
        }
    }
}
