//! The discrete Kirchhoff triangle: a thin-plate element of nine degrees of freedom.
#![expect(
    clippy::needless_range_loop,
    reason = "indices of tensors and unknowns, as in the equations"
)]

/// Unknowns of a triangle: w and its two derivatives along the axes of the node's frame, for each
/// corner.
pub(super) const N_LOCAL: usize = 9;

/// Entries of the lower triangle of a 9 × 9 matrix, row by row.
pub(super) const N_PACKED: usize = N_LOCAL * (N_LOCAL + 1) / 2;

/// A symmetric matrix between `[κ_xx, κ_yy, 2κ_xy]` and their conjugates.
pub(super) type Rigidity = [[f64; 3]; 3];

/// Axes along which the derivatives of a node are taken: two perpendicular unit vectors.
pub(super) type Frame = [[f64; 2]; 2];

/// The axes of the pane.
pub(super) const AXES: Frame = [[1.0, 0.0], [0.0, 1.0]];

/// The second derivatives of w, as linear functions of the unknowns of one triangle.
#[derive(Debug, Clone)]
pub(super) struct Element {
    /// Rows w_xx, w_yy, 2 w_xy at the middle of the edge opposite to each corner.
    pub(super) mid_edge: [[[f64; N_LOCAL]; 3]; 3],
    pub(super) area_m2: f64,
}

impl Element {
    /// The element of Batoz \[Batoz1980\]: the gradient of w is quadratic; at mid-edges its
    /// tangential part is that of the cubic through the edge's ends, and its normal part is the
    /// mean of theirs: ∇w = (3/2)(w_j − w_i)/l s + (½ I − ¾ s sᵀ)(∇w_i + ∇w_j).
    pub(super) fn new(corners: &[[f64; 2]; 3], frames: &[Frame; 3]) -> Self {
        let [a, b, c] = corners;
        let double = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        // Gradients of the barycentric coordinates.
        let slope = [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            [
                (corners[i][1] - corners[j][1]) / double,
                (corners[j][0] - corners[i][0]) / double,
            ]
        });
        // The gradient of w at the corners, then at the mid-edges opposite to them.
        let mut gradient = [[[0.0; N_LOCAL]; 2]; 6];
        for k in 0..3 {
            for axis in 0..2 {
                for derivative in 0..2 {
                    gradient[k][axis][3 * k + 1 + derivative] = frames[k][derivative][axis];
                }
            }
        }
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let edge = [0, 1].map(|axis| corners[j][axis] - corners[i][axis]);
            let length = libm::hypot(edge[0], edge[1]);
            let s = edge.map(|e| e / length);
            for dof in 0..N_LOCAL {
                let sum = [0, 1].map(|axis| gradient[i][axis][dof] + gradient[j][axis][dof]);
                let along = 0.75 * (s[0] * sum[0] + s[1] * sum[1]);
                for axis in 0..2 {
                    gradient[3 + k][axis][dof] = 0.5 * sum[axis] - along * s[axis];
                }
            }
            for axis in 0..2 {
                gradient[3 + k][axis][3 * j] += 1.5 * s[axis] / length;
                gradient[3 + k][axis][3 * i] -= 1.5 * s[axis] / length;
            }
        }
        let mid_edge = [0, 1, 2].map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let mut l = [0.0; 3];
            l[i] = 0.5;
            l[j] = 0.5;
            let mut rows = [[0.0; N_LOCAL]; 3];
            for (node, [gx, gy]) in gradient.iter().enumerate() {
                let d = shape_gradient(node, &l, &slope);
                for dof in 0..N_LOCAL {
                    rows[0][dof] += d[0] * gx[dof];
                    rows[1][dof] += d[1] * gy[dof];
                    rows[2][dof] += d[1] * gx[dof] + d[0] * gy[dof];
                }
            }
            rows
        });
        Self {
            mid_edge,
            area_m2: 0.5 * double,
        }
    }

    /// ∫ Bᵀ D B, packed. The second derivatives are linear, so that three mid-edges integrate it
    /// exactly.
    pub(super) fn stiffness(&self, rigidity: &Rigidity) -> [f64; N_PACKED] {
        let mut packed = [0.0; N_PACKED];
        let weight = self.area_m2 / 3.0;
        for b in &self.mid_edge {
            let mut moment = [[0.0; N_LOCAL]; 3];
            for row in 0..3 {
                for dof in 0..N_LOCAL {
                    moment[row][dof] = weight
                        * (rigidity[row][0] * b[0][dof]
                            + rigidity[row][1] * b[1][dof]
                            + rigidity[row][2] * b[2][dof]);
                }
            }
            let mut at = 0;
            for i in 0..N_LOCAL {
                for j in 0..=i {
                    packed[at] +=
                        b[0][i] * moment[0][j] + b[1][i] * moment[1][j] + b[2][i] * moment[2][j];
                    at += 1;
                }
            }
        }
        packed
    }

    /// ∫ Bᵀ D B u: the forces and moments that hold the triangle bent.
    pub(super) fn forces(&self, rigidity: &Rigidity, unknowns: &[f64; N_LOCAL]) -> [f64; N_LOCAL] {
        let mut forces = [0.0; N_LOCAL];
        for (rows, curvature) in self.mid_edge.iter().zip(self.curvatures(unknowns)) {
            let moment = moments(rigidity, &curvature);
            for dof in 0..N_LOCAL {
                let part: f64 = (0..3).map(|row| rows[row][dof] * moment[row]).sum();
                forces[dof] += self.area_m2 / 3.0 * part;
            }
        }
        forces
    }

    /// w_xx, w_yy, 2 w_xy at each mid-edge.
    pub(super) fn curvatures(&self, unknowns: &[f64; N_LOCAL]) -> [[f64; 3]; 3] {
        self.mid_edge
            .map(|rows| rows.map(|row| row.iter().zip(unknowns).map(|(b, u)| b * u).sum()))
    }
}

/// Gradient of the quadratic shape function of a corner (0..3) or mid-edge (3..6).
fn shape_gradient(node: usize, l: &[f64; 3], slope: &[[f64; 2]; 3]) -> [f64; 2] {
    if node < 3 {
        slope[node].map(|s| (4.0 * l[node] - 1.0) * s)
    } else {
        let (i, j) = ((node + 1) % 3, (node + 2) % 3);
        [0, 1].map(|axis| 4.0 * (l[i] * slope[j][axis] + l[j] * slope[i][axis]))
    }
}

/// Rigidity of an isotropic plate, D (1 ν 0; ν 1 0; 0 0 (1−ν)/2).
pub(super) fn isotropic(rigidity: f64, poisson_ratio: f64) -> Rigidity {
    let (d, nu) = (rigidity, poisson_ratio);
    [
        [d, nu * d, 0.0],
        [nu * d, d, 0.0],
        [0.0, 0.0, 0.5 * (1.0 - nu) * d],
    ]
}

/// D κ.
pub(super) fn moments(rigidity: &Rigidity, curvature: &[f64; 3]) -> [f64; 3] {
    rigidity.map(|row| row[0] * curvature[0] + row[1] * curvature[1] + row[2] * curvature[2])
}

/// w at barycentric coordinates `l` as a linear function of the unknowns: the cubic of Bazeley
/// and others \[Bazeley1965\], which keeps force and moment of a load.
pub(super) fn deflection(
    corners: &[[f64; 2]; 3],
    frames: &[Frame; 3],
    l: &[f64; 3],
) -> [f64; N_LOCAL] {
    let bubble = 0.5 * l[0] * l[1] * l[2];
    let mut row = [0.0; N_LOCAL];
    for i in 0..3 {
        row[3 * i] = l[i];
        let mut lever = [0.0; 2];
        for j in [(i + 1) % 3, (i + 2) % 3] {
            row[3 * i] += l[i] * l[j] * (l[i] - l[j]);
            let part = l[i] * l[i] * l[j] + bubble;
            for axis in 0..2 {
                lever[axis] += part * (corners[j][axis] - corners[i][axis]);
            }
        }
        for derivative in 0..2 {
            let axis = frames[i][derivative];
            row[3 * i + 1 + derivative] = axis[0] * lever[0] + axis[1] * lever[1];
        }
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A patch of irregular triangles around one inner node.
    const CORNERS: [[[f64; 2]; 3]; 3] = [
        [[0.0, 0.0], [2.0, 0.1], [0.7, 0.4]],
        [[2.0, 0.1], [1.1, 1.9], [0.7, 0.4]],
        [[1.1, 1.9], [0.0, 0.0], [0.7, 0.4]],
    ];

    #[test]
    fn constant_curvature_is_exact_and_in_balance() {
        let (xx, yy, xy) = (0.3, -1.7, 0.9);
        let (sin, cos) = libm::sincos(0.4);
        for frame in [AXES, [[cos, sin], [-sin, cos]]] {
            // Forces at the inner node, which come last in each triangle.
            let mut inner = [0.0; 3];
            for corners in &CORNERS {
                let mut unknowns = [0.0; N_LOCAL];
                for (k, [x, y]) in corners.iter().enumerate() {
                    let gradient = [0.5 + xx * x + xy * y, -0.2 + yy * y + xy * x];
                    unknowns[3 * k] =
                        0.5 * (xx * x * x + yy * y * y) + xy * x * y + 0.5 * x - 0.2 * y;
                    for d in 0..2 {
                        unknowns[3 * k + 1 + d] =
                            frame[d][0] * gradient[0] + frame[d][1] * gradient[1];
                    }
                }
                let element = Element::new(corners, &[frame; 3]);
                for curvature in element.curvatures(&unknowns) {
                    for (got, want) in curvature.iter().zip([xx, yy, 2.0 * xy]) {
                        assert!((got - want).abs() < 1e-10, "{got} {want}");
                    }
                }
                let packed = element.stiffness(&isotropic(1.0, 0.3));
                for i in 6..N_LOCAL {
                    for j in 0..N_LOCAL {
                        let (high, low) = (i.max(j), i.min(j));
                        inner[i - 6] += packed[high * (high + 1) / 2 + low] * unknowns[j];
                    }
                }
            }
            assert!(inner.iter().all(|f| f.abs() < 1e-10), "{inner:?}");
        }
    }

    #[test]
    fn a_force_keeps_its_moment() {
        let l = [0.2, 0.5, 0.3];
        let row = deflection(&CORNERS[0], &[AXES; 3], &l);
        for axis in 0..2 {
            let place: f64 = (0..3).map(|i| l[i] * CORNERS[0][i][axis]).sum();
            let moment: f64 = (0..3)
                .map(|i| row[3 * i] * CORNERS[0][i][axis] + row[3 * i + 1 + axis])
                .sum();
            assert!((moment - place).abs() < 1e-12, "{moment} {place}");
        }
    }
}
