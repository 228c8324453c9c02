//! Nodes in space with their bonds, and one explicit step in time.

use crate::lattice::Lattice;
use crate::material::{LatticeSums, Material};
use crate::random::Random;

/// Bonds, each once, by their first node: those of node `i` are `first[i]..first[i + 1]`.
#[derive(Clone, Debug, Default)]
pub struct Bonds {
    /// Where the bonds of each node start; one more at the end.
    pub first: Vec<usize>,
    /// The other node.
    pub other: Vec<u32>,
    /// 1/length at rest, 1/m.
    pub inverse_length_per_m: Vec<f64>,
    /// Force per stretch, N; 0 when broken.
    pub stiffness_n: Vec<f64>,
    /// Stretch at which it breaks; infinite for never.
    pub critical: Vec<f64>,
}

/// A brace against transverse shear, over two neighboring columns of the two sheets.
#[derive(Clone, Debug)]
pub struct Brace {
    /// Nodes: upper i, upper j, lower i, lower j.
    pub node: [usize; 4],
    /// Force per difference of the two diagonals, N/m; 0 when broken.
    pub stiffness_n_m: f64,
    /// The bonds i-j of the upper and the lower sheet; the brace goes when both are broken.
    pub bond: [usize; 2],
}

/// A spring.
#[derive(Clone, Copy, Debug)]
pub struct Tie {
    /// Its ends.
    pub node: [usize; 2],
    /// Length at rest, m.
    pub length_m: f64,
    /// Force per length, N/m.
    pub stiffness_n_m: f64,
}

/// Energies of a body, J.
#[derive(Clone, Copy, Debug, Default)]
pub struct Energy {
    /// In the motion.
    pub kinetic_j: f64,
    /// In bonds, braces and ties.
    pub elastic_j: f64,
}

/// Nodes with their state, one array per component.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// Positions at rest, m.
    pub rest_m: [Vec<f64>; 3],
    /// Positions, m.
    pub position_m: [Vec<f64>; 3],
    /// Velocities, m/s.
    pub velocity_m_s: [Vec<f64>; 3],
    /// Forces of the last step, N.
    pub force_n: [Vec<f64>; 3],
    /// Forces from outside, constant, N.
    pub load_n: [Vec<f64>; 3],
    /// Mass of a node, kg.
    pub mass_kg: f64,
    /// 1/mass; 0 for a node whose velocity is prescribed.
    pub inverse_mass_per_kg: Vec<f64>,
    /// Bonds within the sheets.
    pub bonds: Bonds,
    /// Bonds of each node at rest.
    pub n_bonds: Vec<u32>,
    /// Broken ones among them.
    pub n_broken: Vec<u32>,
    /// Braces between sheets.
    pub braces: Vec<Brace>,
    /// Springs between sheets.
    pub ties: Vec<Tie>,
}

impl Body {
    /// Adds a sheet of a thickness at height `z_m`; returns its first node.
    ///
    /// The force of a bond under a stretch s is c s V² with the micromodulus c = 9E/(πtδ³) of plane
    /// stress, and it breaks at s₀ = √(4πG₀/(9Eδ)) [HaBobaru2010]. Both come from integrals over the
    /// horizon; here each is multiplied by integral over sum ([`LatticeSums`]), so that the lattice
    /// has the modulus and the fracture energy asked for.
    pub fn add_sheet(
        &mut self,
        lattice: &Lattice,
        z_m: f64,
        thickness_m: f64,
        horizon_m: f64,
        material: &Material,
    ) -> usize {
        let base = self.n_bonds.len();
        let n = lattice.len();
        let area_m2 = lattice.spacing_m * lattice.spacing_m;
        self.mass_kg = material.density_kg_m3 * area_m2 * thickness_m;
        for (axis, values) in [&lattice.x_m, &lattice.y_m, &vec![z_m; n]]
            .into_iter()
            .enumerate()
        {
            self.rest_m[axis].extend_from_slice(values);
            self.position_m[axis].extend_from_slice(values);
            for state in [&mut self.velocity_m_s, &mut self.force_n, &mut self.load_n] {
                state[axis].resize(base + n, 0.0);
            }
        }
        self.inverse_mass_per_kg
            .resize(base + n, 1.0 / self.mass_kg);
        self.n_bonds.resize(base + n, 0);
        self.n_broken.resize(base + n, 0);

        let pairs: Vec<_> = lattice.pairs(horizon_m).collect();
        let sums = LatticeSums::new(lattice, &pairs, horizon_m);
        let micromodulus = 9.0 * material.young_pa
            / (std::f64::consts::PI * thickness_m * horizon_m * horizon_m * horizon_m)
            / sums.elastic;
        let volume_m3 = area_m2 * thickness_m;
        let critical =
            material.critical_stretch(horizon_m) * libm::sqrt(sums.elastic / sums.fracture);
        let mut counts = vec![0_usize; n];
        for (i, j) in pairs {
            let length_m = lattice.distance_m(i, j);
            counts[i] += 1;
            self.n_bonds[base + i] += 1;
            self.n_bonds[base + j] += 1;
            #[expect(clippy::cast_possible_truncation, reason = "far fewer than 2^32 nodes")]
            self.bonds.other.push((base + j) as u32);
            self.bonds.inverse_length_per_m.push(1.0 / length_m);
            self.bonds
                .stiffness_n
                .push(micromodulus * volume_m3 * volume_m3);
            self.bonds.critical.push(critical);
        }
        if self.bonds.first.is_empty() {
            self.bonds.first.push(0);
        }
        let mut end = self.bonds.first[base];
        for count in counts {
            end += count;
            self.bonds.first.push(end);
        }
        base
    }

    /// Number of nodes.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.n_bonds.len()
    }

    /// Whether there is no node.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Scatters the strength of the bonds: normal, with the given relative deviation.
    pub fn scatter_strength(&mut self, deviation: f64, random: &mut Random) {
        for critical in &mut self.bonds.critical {
            *critical *= (1.0 + deviation * random.normal()).max(0.1);
        }
    }

    /// Breaks the bonds for which `cuts` says so (nodes i and j).
    pub fn cut(&mut self, cuts: impl Fn(usize, usize) -> bool) {
        for i in 0..self.len() {
            for bond in self.bonds.first[i]..self.bonds.first[i + 1] {
                let j = self.bonds.other[bond] as usize;
                if self.bonds.stiffness_n[bond] > 0.0 && cuts(i, j) {
                    self.bonds.stiffness_n[bond] = 0.0;
                    self.n_broken[i] += 1;
                    self.n_broken[j] += 1;
                }
            }
        }
    }

    /// Lets bonds that touch a node for which `keeps` says so never break.
    pub fn protect(&mut self, keeps: impl Fn(usize) -> bool) {
        for i in 0..self.len() {
            for bond in self.bonds.first[i]..self.bonds.first[i + 1] {
                if keeps(i) || keeps(self.bonds.other[bond] as usize) {
                    self.bonds.critical[bond] = f64::INFINITY;
                }
            }
        }
    }

    /// Broken bonds of a node over all its bonds: the damage [SillingAskari2005].
    #[must_use]
    pub fn damage(&self, node: usize) -> f64 {
        f64::from(self.n_broken[node]) / f64::from(self.n_bonds[node].max(1))
    }

    /// One step of velocity Verlet in its leapfrog form: `velocity_m_s` is that of half a step
    /// before `position_m`.
    pub fn step(&mut self, step_s: f64) {
        self.update_forces();
        for axis in 0..3 {
            let nodes = self.velocity_m_s[axis]
                .iter_mut()
                .zip(&mut self.position_m[axis])
                .zip(&self.force_n[axis])
                .zip(&self.inverse_mass_per_kg);
            for (((velocity, position), force), inverse) in nodes {
                *velocity += step_s * force * inverse;
                *position += step_s * *velocity;
            }
        }
    }

    /// Sums the forces at the present positions; breaks what is stretched too far.
    pub fn update_forces(&mut self) {
        for axis in 0..3 {
            self.force_n[axis].copy_from_slice(&self.load_n[axis]);
        }
        self.add_bond_forces();
        self.add_brace_forces();
        self.add_tie_forces();
    }

    /// f = c s V² along the present direction of the bond [SillingAskari2005].
    fn add_bond_forces(&mut self) {
        let [x, y, z] = &self.position_m;
        let [force_x, force_y, force_z] = &mut self.force_n;
        let bonds = &mut self.bonds;
        for i in 0..self.n_bonds.len() {
            let (start, end) = (bonds.first[i], bonds.first[i + 1]);
            let (at_x, at_y, at_z) = (x[i], y[i], z[i]);
            let (mut sum_x, mut sum_y, mut sum_z) = (0.0, 0.0, 0.0);
            let row = bonds.other[start..end]
                .iter()
                .zip(&bonds.inverse_length_per_m[start..end])
                .zip(&bonds.critical[start..end])
                .zip(&mut bonds.stiffness_n[start..end]);
            for (((other, inverse_length), critical), stiffness) in row {
                if *stiffness <= 0.0 {
                    continue;
                }
                let j = *other as usize;
                let (dx, dy, dz) = (x[j] - at_x, y[j] - at_y, z[j] - at_z);
                let now = (dx * dx + dy * dy + dz * dz).sqrt();
                let stretch = now * inverse_length - 1.0;
                if stretch > *critical {
                    *stiffness = 0.0;
                    self.n_broken[i] += 1;
                    self.n_broken[j] += 1;
                    continue;
                }
                let pull = *stiffness * stretch / now;
                sum_x += pull * dx;
                sum_y += pull * dy;
                sum_z += pull * dz;
                force_x[j] -= pull * dx;
                force_y[j] -= pull * dy;
                force_z[j] -= pull * dz;
            }
            force_x[i] += sum_x;
            force_y[i] += sum_y;
            force_z[i] += sum_z;
        }
    }

    /// Energy ½k(l₁ − l₂)² of the two diagonals of each brace: nothing under stretch of the sheets
    /// and nothing under pure bending, where both diagonals are equal; only shear counts.
    fn add_brace_forces(&mut self) {
        for at in 0..self.braces.len() {
            let [upper_bond, lower_bond] = self.braces[at].bond;
            let bonds = &self.bonds.stiffness_n;
            if bonds[upper_bond] <= 0.0 && bonds[lower_bond] <= 0.0 {
                self.braces[at].stiffness_n_m = 0.0;
            }
            let Brace {
                node,
                stiffness_n_m,
                ..
            } = self.braces[at];
            if stiffness_n_m <= 0.0 {
                continue;
            }
            let [upper_i, upper_j, lower_i, lower_j] = node;
            let (falling, falling_m) = self.unit(upper_i, lower_j);
            let (rising, rising_m) = self.unit(lower_i, upper_j);
            let force_n = stiffness_n_m * (falling_m - rising_m);
            for axis in 0..3 {
                let force = &mut self.force_n[axis];
                force[upper_i] += force_n * falling[axis];
                force[lower_j] -= force_n * falling[axis];
                force[lower_i] -= force_n * rising[axis];
                force[upper_j] += force_n * rising[axis];
            }
        }
    }

    fn add_tie_forces(&mut self) {
        for at in 0..self.ties.len() {
            let Tie {
                node: [i, j],
                length_m,
                stiffness_n_m,
            } = self.ties[at];
            let (along, now_m) = self.unit(i, j);
            let force_n = stiffness_n_m * (now_m - length_m);
            for (force, along) in self.force_n.iter_mut().zip(along) {
                force[i] += force_n * along;
                force[j] -= force_n * along;
            }
        }
    }

    /// Unit vector from one node to another, and their distance, m.
    fn unit(&self, i: usize, j: usize) -> ([f64; 3], f64) {
        let [x, y, z] = &self.position_m;
        let (dx, dy, dz) = (x[j] - x[i], y[j] - y[i], z[j] - z[i]);
        let length = (dx * dx + dy * dy + dz * dz).sqrt();
        ([dx / length, dy / length, dz / length], length)
    }

    /// Energy per node, J: half of each bond goes to each end, a quarter of each brace.
    #[must_use]
    pub fn elastic_of_nodes_j(&self) -> Vec<f64> {
        let mut energy = vec![0.0; self.len()];
        for i in 0..self.len() {
            for bond in self.bonds.first[i]..self.bonds.first[i + 1] {
                let j = self.bonds.other[bond] as usize;
                let length = 1.0 / self.bonds.inverse_length_per_m[bond];
                let stretch = (self.unit(i, j).1 - length) / length;
                // ½ c s² ξ V²
                let half = 0.25 * self.bonds.stiffness_n[bond] * stretch * stretch * length;
                energy[i] += half;
                energy[j] += half;
            }
        }
        for Brace {
            node,
            stiffness_n_m,
            ..
        } in &self.braces
        {
            let [upper_i, upper_j, lower_i, lower_j] = *node;
            let skew_m = self.unit(upper_i, lower_j).1 - self.unit(lower_i, upper_j).1;
            for i in *node {
                energy[i] += 0.125 * stiffness_n_m * skew_m * skew_m;
            }
        }
        for Tie {
            node,
            length_m,
            stiffness_n_m,
        } in &self.ties
        {
            let longer_m = self.unit(node[0], node[1]).1 - length_m;
            for i in *node {
                energy[i] += 0.25 * stiffness_n_m * longer_m * longer_m;
            }
        }
        energy
    }

    /// Energies now; the velocity is taken half a step on, where the position is.
    #[must_use]
    pub fn energy(&mut self, step_s: f64) -> Energy {
        self.update_forces();
        let mut kinetic_j = 0.0;
        for axis in 0..3 {
            for i in 0..self.len() {
                let inverse = self.inverse_mass_per_kg[i];
                let velocity =
                    self.velocity_m_s[axis][i] + 0.5 * step_s * self.force_n[axis][i] * inverse;
                kinetic_j += 0.5 * self.mass_kg * velocity * velocity;
            }
        }
        Energy {
            kinetic_j,
            elastic_j: self.elastic_of_nodes_j().iter().sum(),
        }
    }
}
