//! Exact area coverage of polygons, one row of cells at a time.

/// Most corners of a polygon: a quadrilateral, each side of the window adding at most one.
pub(crate) const MAX_CORNERS: usize = 8;

/// A polygon of up to [`MAX_CORNERS`] corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Polygon {
    corners: [[f64; 2]; MAX_CORNERS],
    n: usize,
}

impl Polygon {
    pub(crate) fn new(corners: &[[f64; 2]]) -> Self {
        let mut polygon = Self {
            corners: [[0.0; 2]; MAX_CORNERS],
            n: 0,
        };
        for &corner in corners {
            polygon.push(corner);
        }
        polygon
    }

    fn push(&mut self, corner: [f64; 2]) {
        if self.n < MAX_CORNERS {
            self.corners[self.n] = corner;
            self.n += 1;
        }
    }

    pub(crate) fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.n]
    }

    /// Least and greatest value of a coordinate.
    pub(crate) fn span(&self, axis: usize) -> [f64; 2] {
        let values = self.corners().iter().map(|corner| corner[axis]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        })
    }

    /// The part within `0 ≤ x ≤ width`; convex polygons only.
    pub(crate) fn within(&self, width: f64) -> Self {
        let [low, high] = self.span(0);
        let mut clipped = *self;
        if low < 0.0 {
            clipped = clipped.half(|x| x);
        }
        if high > width {
            clipped = clipped.half(|x| width - x);
        }
        clipped
    }

    /// The part where a linear function of x is not negative.
    fn half(&self, inside: impl Fn(f64) -> f64) -> Self {
        let mut part = Self::new(&[]);
        let corners = self.corners();
        for (k, &[x0, y0]) in corners.iter().enumerate() {
            let [x1, y1] = corners[(k + 1) % corners.len()];
            let (a, b) = (inside(x0), inside(x1));
            if a >= 0.0 {
                part.push([x0, y0]);
            }
            if (a >= 0.0) != (b >= 0.0) {
                let t = a / (a - b);
                part.push([x0 + t * (x1 - x0), y0 + t * (y1 - y0)]);
            }
        }
        part
    }

    /// The sides that are not level.
    pub(crate) fn edges(&self) -> impl Iterator<Item = Edge> {
        let corners = self.corners();
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).filter_map(|(a, b)| {
            let (direction, [x, top], end) = if a[1] <= b[1] {
                (1.0, *a, b)
            } else {
                (-1.0, *b, a)
            };
            (top < end[1]).then(|| Edge {
                direction,
                x,
                top,
                bottom: end[1],
                slope: (end[0] - x) / (end[1] - top),
            })
        })
    }
}

/// A side of a polygon, from its upper end on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Edge {
    /// 1 if the walk around the polygon goes down it, −1 if up.
    direction: f64,
    x: f64,
    top: f64,
    bottom: f64,
    slope: f64,
}

/// Appends to `areas` the exact common areas of a simple polygon of these edges with the cells of a row, from the first
/// that it covers to the last; gives the first, if there is any. `scratch` holds zeros, at least two more than the row has
/// cells, and does so again afterwards.
///
/// Signed areas under the edges, summed along the row, as in font rendering.
pub(crate) fn cover_row(
    edges: &[Edge],
    row: usize,
    scratch: &mut [f32],
    areas: &mut Vec<f32>,
) -> Option<usize> {
    #[expect(clippy::cast_precision_loss, reason = "row numbers")]
    let top = row as f64;
    let (mut first, mut last) = (usize::MAX, 0);
    for edge in edges {
        if edge.bottom > top
            && edge.top < top + 1.0
            && let Some([low, high]) = edge.add_to(top, scratch)
        {
            first = first.min(low);
            last = last.max(high);
        }
    }
    if first > last {
        return None;
    }
    let mut sum = 0.0_f32;
    areas.extend(scratch[first..=last].iter_mut().map(|step| {
        sum += std::mem::take(step);
        sum.abs().min(1.0)
    }));
    Some(first)
}

impl Edge {
    /// Adds the signed area right of the part of the edge in the row below `top`; first and last
    /// cell that it wrote to.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "cells of a row, and areas as f32"
    )]
    fn add_to(&self, top: f64, steps: &mut [f32]) -> Option<[usize; 2]> {
        let (y0, y1) = (self.top.max(top), self.bottom.min(top + 1.0));
        if y1 <= y0 {
            return None;
        }
        let most = (steps.len() - 2) as f64;
        let (xa, xb) = (
            (self.x + (y0 - self.top) * self.slope).clamp(0.0, most),
            (self.x + (y1 - self.top) * self.slope).clamp(0.0, most),
        );
        let (left, right) = if xa <= xb { (xa, xb) } else { (xb, xa) };
        let height = self.direction * (y1 - y0);
        // Neither is negative: to cut off is to round down.
        let cell = left as u32 as usize;
        let end = right as u32 as usize;
        let end = end + usize::from(right > end as f64);
        if end <= cell + 1 {
            let mean = 0.5 * (left + right) - cell as f64;
            steps[cell] += (height * (1.0 - mean)) as f32;
            steps[cell + 1] += (height * mean) as f32;
            return Some([cell, cell + 1]);
        }
        // Area right of the edge within each cell it crosses: a triangle, trapezia, a triangle.
        let per_cell = 1.0 / (right - left);
        let (mut before, mut own_before) = (0.0, 0.0);
        let mut x = cell as f64;
        for step in &mut steps[cell..=end] {
            x += 1.0;
            let covered = area_up_to(x, left, right, per_cell);
            let own = covered - before;
            *step += (height * (own - own_before)) as f32;
            (before, own_before) = (covered, own);
        }
        Some([cell, end])
    }
}

/// ∫ of the share of the row left of which the edge lies, up to x: 0 before `left`, a parabola,
/// then a line of slope 1.
fn area_up_to(x: f64, left: f64, right: f64, per_cell: f64) -> f64 {
    if x <= left {
        0.0
    } else if x <= right {
        0.5 * (x - left) * (x - left) * per_cell
    } else {
        0.5 * (right - left) + x - right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(polygon: &Polygon, width: usize, height: usize) -> Vec<f32> {
        let mut scratch = vec![0.0; width + 2];
        let mut cells = vec![0.0; width * height];
        let edges: Vec<Edge> = polygon.edges().collect();
        for y in 0..height {
            let mut areas = Vec::new();
            if let Some(first) = cover_row(&edges, y, &mut scratch, &mut areas) {
                let row = &mut cells[y * width..(y + 1) * width];
                for (cell, area) in row.iter_mut().skip(first).zip(areas) {
                    *cell += area;
                }
            }
            assert!(
                scratch.iter().all(|step| step.abs() <= 0.0),
                "the scratch row is left clean"
            );
        }
        cells
    }

    /// Area of a polygon by the shoelace formula.
    fn area(corners: &[[f64; 2]]) -> f64 {
        let n = corners.len();
        (0..n)
            .map(|k| {
                let ([x0, y0], [x1, y1]) = (corners[k], corners[(k + 1) % n]);
                0.5 * (x0 * y1 - x1 * y0)
            })
            .sum::<f64>()
            .abs()
    }

    #[test]
    fn every_cell_has_its_exact_common_area() {
        let shapes: [&[[f64; 2]]; 5] = [
            &[[1.25, 0.5], [4.75, 0.5], [4.75, 2.0], [1.25, 2.0]],
            &[[0.3, 0.2], [9.1, 3.3], [8.2, 7.9], [1.1, 5.0]],
            &[[2.0, 1.0], [8.5, 1.2], [8.5, 1.3], [2.0, 1.1]],
            &[[5.0, 0.1], [5.2, 8.9], [5.1, 8.9], [4.9, 0.1]],
            &[[0.0, 0.0], [10.0, 9.0], [10.0, 9.4], [0.0, 0.4]],
        ];
        for corners in shapes {
            let cells = cells(&Polygon::new(corners), 10, 10);
            let sum: f64 = cells.iter().map(|cell| f64::from(*cell)).sum();
            assert!((sum - area(corners)).abs() < 1e-4, "{corners:?}: {sum}");
            // Against points on a fine grid.
            let n = 40;
            for (k, cell) in cells.iter().enumerate() {
                let (x, y) = ((k % 10) as f64, (k / 10) as f64);
                let mut hits = 0;
                for j in 0..n * n {
                    let px = x + (f64::from(j % n) + 0.5) / f64::from(n);
                    let py = y + (f64::from(j / n) + 0.5) / f64::from(n);
                    let inside = (0..corners.len()).all(|k| {
                        let ([x0, y0], [x1, y1]) = (corners[k], corners[(k + 1) % corners.len()]);
                        (x1 - x0) * (py - y0) - (y1 - y0) * (px - x0) >= 0.0
                    });
                    hits += i32::from(inside);
                }
                let expected = f64::from(hits) / f64::from(n * n);
                assert!(
                    (f64::from(*cell) - expected).abs() < 0.02,
                    "{corners:?}, cell ({x}, {y}): {cell}, not {expected}"
                );
            }
        }
    }

    #[test]
    fn what_lies_beyond_the_window_is_cut_off() {
        let wide = Polygon::new(&[[-5.0, 1.0], [25.0, 1.0], [25.0, 2.0], [-5.0, 2.0]]);
        let sum: f32 = cells(&wide.within(10.0), 10, 4).iter().sum();
        assert!((sum - 10.0).abs() < 1e-4, "{sum}");
        let slanted = Polygon::new(&[[-2.0, 0.0], [12.0, 7.0], [12.0, 9.0], [-2.0, 2.0]]);
        let sum: f32 = cells(&slanted.within(10.0), 10, 10).iter().sum();
        assert!((sum - 20.0).abs() < 1e-3, "{sum}");
    }
}
