//! Finding the triangle at a point.

use super::PlateMesh;
use super::particles::to_u32;
use super::plate_mesh::NONE;

/// A point this little outside a triangle (in barycentric coordinates) still counts as in it: the
/// rounding of 1e-16 of a coordinate in m is that much of a small triangle.
const SLACK: f64 = 1e-10;

/// How far outside a border edge a point is still found, as a fraction of the edge: the sagitta
/// between a disc's rim and its chord.
const BORDER: f64 = 0.12;

impl PlateMesh {
    /// Barycentric coordinates of a point in a triangle.
    #[must_use]
    pub fn barycentric(&self, triangle: u32, [x, y]: [f64; 2]) -> [f64; 3] {
        let [a, b, c] = self.corners_m(triangle);
        let double = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let whole = double(a, b, c);
        let p = [x, y];
        [
            double(p, b, c) / whole,
            double(p, c, a) / whole,
            double(p, a, b) / whole,
        ]
    }

    /// The triangle at a point with the barycentric coordinates there, all in 0 to 1; `None` off
    /// the mesh. A point just outside a curved rim belongs to the triangle behind it.
    ///
    /// The search walks from `hint` straight to the point and leaves there what it found, so that
    /// the next point nearby costs next to nothing.
    pub fn locate(&self, point: [f64; 2], hint: &mut u32) -> Option<(u32, [f64; 3])> {
        if !(point[0].is_finite() && point[1].is_finite()) {
            return None;
        }
        let n = to_u32(self.triangles().len());
        let mut target = point;
        let mut at = (*hint).min(n - 1);
        let mut projections = 0;
        // On a Delaunay mesh no such walk visits a triangle twice; the bound guards rounding and
        // the edges that cracks force.
        for _ in 0..n + 16 {
            let lambda = self.barycentric(at, target);
            let neighbors = &self.neighbors[at as usize];
            let mut order = [0, 1, 2];
            order.sort_by(|&i, &j| lambda[i].total_cmp(&lambda[j]));
            if lambda[order[0]] >= -SLACK {
                *hint = at;
                return Some((at, clamped(lambda)));
            }
            let next = order
                .into_iter()
                .filter(|&k| lambda[k] < -SLACK)
                .map(|k| neighbors[k])
                .find(|&t| t != NONE);
            if let Some(next) = next {
                at = next;
                continue;
            }
            // Outside: go on towards the foot on the border edge, if it is near.
            let corners = self.corners_m(at);
            let (a, b) = (corners[(order[0] + 1) % 3], corners[(order[0] + 2) % 3]);
            let edge = [b[0] - a[0], b[1] - a[1]];
            let squared = edge[0] * edge[0] + edge[1] * edge[1];
            let offset = [target[0] - a[0], target[1] - a[1]];
            let across = (edge[0] * offset[1] - edge[1] * offset[0]) / squared;
            projections += 1;
            if across.abs() > BORDER || projections > 8 {
                *hint = at;
                return None;
            }
            target = [target[0] + across * edge[1], target[1] - across * edge[0]];
        }
        self.locate_by_search(point, hint)
    }

    fn locate_by_search(&self, point: [f64; 2], hint: &mut u32) -> Option<(u32, [f64; 3])> {
        let best = (0..to_u32(self.triangles().len()))
            .map(|t| (t, self.barycentric(t, point)))
            .map(|(t, l)| (t, l, l[0].min(l[1]).min(l[2])))
            .max_by(|a, b| a.2.total_cmp(&b.2).then(b.0.cmp(&a.0)))?;
        (best.2 >= -BORDER).then(|| {
            *hint = best.0;
            (best.0, clamped(best.1))
        })
    }
}

/// Barycentric coordinates of the nearest place within the triangle, or nearly so.
fn clamped(lambda: [f64; 3]) -> [f64; 3] {
    let positive = lambda.map(|l| l.max(0.0));
    let sum = positive[0] + positive[1] + positive[2];
    positive.map(|l| l / sum)
}
