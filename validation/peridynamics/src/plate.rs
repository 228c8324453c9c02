//! A thin plate struck by a ball: two sheets that bend together.

use crate::body::{Body, Brace, Tie};
use crate::lattice::{Lattice, as_f64};
use crate::material::Material;
use crate::random::Random;

/// Acrylic glass of the experiments (values of handbooks; the experiments name none of their own).
pub const PMMA: Material = Material {
    young_pa: 4.5e9,
    density_kg_m3: 1190.0,
    fracture_energy_j_m2: 500.0,
};

/// Window glass.
pub const GLASS: Material = Material {
    young_pa: 70e9,
    density_kg_m3: 2500.0,
    fracture_energy_j_m2: 8.0,
};

/// The plate, m thick.
pub const THICKNESS_M: f64 = 1e-3;
/// Node spacing, m. The horizon must be well below the plate's thickness: at 0.4 mm the cracks of
/// fast impacts are as wide as their distance, and the count saturates.
pub const SPACING_M: f64 = 0.16e-3;
/// Horizon in spacings.
const HORIZON: f64 = 3.0;
/// Nodes along an edge: a square of 30 mm.
const N: usize = 190;
/// Jitter of the nodes, spacings.
const JITTER: f64 = 0.35;
/// Relative deviation of the strength of a bond.
const STRENGTH_DEVIATION: f64 = 0.1;
/// Step over the time that a bar wave takes over a node spacing; 1 is the bound of stability
/// √(2ρ/ΣcV) [SillingAskari2005] for the bonds alone.
const COURANT: f64 = 0.7;
/// Radius of the ball: the projectiles of [Vandenberghe2013] are 4 mm wide.
const BALL_RADIUS_M: f64 = 2e-3;

/// A bilayer plate: two sheets of half the thickness at ±h/(2√3), which gives the stretching
/// stiffness Eh and the bending stiffness 2·E(h/2)/(1−ν²)·(h/(2√3))² = Eh³/(12(1−ν²)) exactly.
#[derive(Clone, Debug)]
pub struct Plate {
    /// Nodes of one sheet.
    pub lattice: Lattice,
    /// Both sheets: first the upper, then the lower.
    pub body: Body,
    /// Step, s.
    pub step_s: f64,
}

impl Plate {
    /// A free plate of `n_x` × `n_y` columns.
    #[must_use]
    pub fn new(
        n_x: usize,
        n_y: usize,
        jitter: f64,
        thickness_m: f64,
        material: &Material,
        random: &mut Random,
    ) -> Self {
        let lattice = Lattice::new(n_x, n_y, SPACING_M, jitter, random);
        let mut body = Body::default();
        let height_m = thickness_m / (2.0 * libm::sqrt(3.0));
        let horizon_m = HORIZON * SPACING_M;
        let upper = body.add_sheet(&lattice, height_m, 0.5 * thickness_m, horizon_m, material);
        let lower = body.add_sheet(&lattice, -height_m, 0.5 * thickness_m, horizon_m, material);
        join_sheets(&mut body, &lattice, upper, lower, thickness_m, material);
        let step_s = COURANT * SPACING_M / material.bar_speed_m_s();
        Self {
            lattice,
            body,
            step_s,
        }
    }

    /// Damage of the nodes of the lower sheet, that of the face away from the ball.
    #[must_use]
    pub fn damage(&self) -> Vec<f64> {
        let n = self.lattice.len();
        (n..2 * n).map(|i| self.body.damage(i)).collect()
    }

    /// Damage of the nodes of the upper sheet.
    #[must_use]
    pub fn damage_above(&self) -> Vec<f64> {
        (0..self.lattice.len())
            .map(|i| self.body.damage(i))
            .collect()
    }
}

/// An impact in the middle of a square plate.
#[derive(Clone, Copy, Debug)]
pub struct Impact {
    /// What the plate is made of.
    pub material: Material,
    /// Speed of the ball, m/s; it keeps it.
    pub speed_m_s: f64,
    /// Seed of jitter and strength.
    pub seed: u64,
}

impl Impact {
    /// End of the run, s: when the flexural wave, of radius 2.2·(D/ρh)^¼·√t, comes to the edge.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        // √(D/ρh) = c·h/√(12(1 − ν²)) with ν = 1/3.
        let spread_m2_s = self.material.bar_speed_m_s() * THICKNESS_M / libm::sqrt(32.0 / 3.0);
        let way = half_edge_m() / 2.2;
        way * way / spread_m2_s
    }
}

/// Runs an impact to its end.
///
/// The ball is rigid and presses on the nodes of the upper sheet that it meets, by a penalty as stiff
/// as the plate across its thickness. Its contact grows from a point; a flat punch of constant speed
/// would shear a plug out along its edge.
#[must_use]
pub fn strike(impact: &Impact) -> Plate {
    let mut random = Random::new(impact.seed);
    let mut plate = Plate::new(N, N, JITTER, THICKNESS_M, &impact.material, &mut random);
    plate.body.scatter_strength(STRENGTH_DEVIATION, &mut random);
    let top_m = plate.body.rest_m[2][0];
    let stiffness_n_m = impact.material.young_pa * SPACING_M * SPACING_M / (2.0 * top_m);
    // Nodes below the ball, with the height of its surface above its lowest point.
    let below: Vec<(usize, f64)> = (0..plate.lattice.len())
        .filter_map(|i| {
            let (x, y) = (plate.lattice.x_m[i], plate.lattice.y_m[i]);
            let rise_m2 = BALL_RADIUS_M * BALL_RADIUS_M - x * x - y * y;
            (rise_m2 > 0.0).then(|| (i, BALL_RADIUS_M - libm::sqrt(rise_m2)))
        })
        .collect();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "thousands"
    )]
    let n_steps = (impact.duration_s() / plate.step_s) as usize;
    for step in 0..n_steps {
        let lowest_m = top_m - impact.speed_m_s * as_f64(step) * plate.step_s;
        let body = &mut plate.body;
        for &(i, height_m) in &below {
            let overlap_m = (body.position_m[2][i] - lowest_m - height_m).max(0.0);
            body.load_n[2][i] = -stiffness_n_m * overlap_m;
        }
        body.step(plate.step_s);
    }
    plate
}

/// Half the edge of the struck plate, m.
#[must_use]
pub fn half_edge_m() -> f64 {
    0.5 * SPACING_M * as_f64(N)
}

/// Joins two equal sheets to a plate of thickness `h`: vertical ties that keep them apart, and
/// braces whose shear stiffness is that of a plate, 5/6·G·h [Reissner1945], with G = 3E/8.
///
/// Under a shear γ the diagonals of a brace of length a in the sheet differ by 2aγd/l; with a
/// stiffness proportional to l²/d² of each brace the sum over all is set to the energy ½·5/6·G·h·γ².
fn join_sheets(
    body: &mut Body,
    lattice: &Lattice,
    upper: usize,
    lower: usize,
    thickness_m: f64,
    material: &Material,
) {
    let gap_m = body.rest_m[2][upper] - body.rest_m[2][lower];
    let area_m2 = lattice.spacing_m * lattice.spacing_m;
    for i in 0..lattice.len() {
        body.ties.push(Tie {
            node: [upper + i, lower + i],
            length_m: gap_m,
            stiffness_n_m: material.young_pa * area_m2 / gap_m,
        });
    }
    let mut squares_m2 = 0.0;
    let mut per_length = Vec::new();
    for i in 0..lattice.len() {
        let column = i % lattice.n_x;
        let right = (column + 1 < lattice.n_x).then_some(i + 1);
        let below_left = (column > 0).then_some(i + lattice.n_x - 1);
        let below_right = (column + 1 < lattice.n_x).then_some(i + lattice.n_x + 1);
        let neighbors = [right, below_left, Some(i + lattice.n_x), below_right];
        for j in neighbors
            .into_iter()
            .flatten()
            .filter(|&j| j < lattice.len())
        {
            let (Some(upper_bond), Some(lower_bond)) = (
                find_bond(body, upper + i, upper + j),
                find_bond(body, lower + i, lower + j),
            ) else {
                continue;
            };
            let length_m = lattice.distance_m(i, j);
            squares_m2 += length_m * length_m;
            per_length.push(length_m * length_m + gap_m * gap_m);
            body.braces.push(Brace {
                node: [upper + i, upper + j, lower + i, lower + j],
                stiffness_n_m: 0.0,
                bond: [upper_bond, lower_bond],
            });
        }
    }
    // ½K(l q/2d)² per brace with q = 2aγd/l gives ½K a²γ²; half of Σa² lies along either axis.
    let shear_pa = 0.375 * material.young_pa;
    let sum_n_m = 5.0 / 6.0 * shear_pa * thickness_m * area_m2 * as_f64(lattice.len());
    let per_m2 = sum_n_m / (0.5 * squares_m2);
    for (brace, l2_m2) in body.braces.iter_mut().zip(per_length) {
        brace.stiffness_n_m = per_m2 * l2_m2 / (4.0 * gap_m * gap_m);
    }
}

/// The bond between two nodes, the lower one first.
fn find_bond(body: &Body, i: usize, j: usize) -> Option<usize> {
    (body.bonds.first[i]..body.bonds.first[i + 1])
        .find(|&bond| body.bonds.other[bond] as usize == j)
}
