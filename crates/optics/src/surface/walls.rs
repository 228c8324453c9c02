//! Walls of cracks in the glass, and which of them a ray meets first.
//!
//! Where cracks meet, one hides a part of the other, and light that one reflects goes on to the
//! next: at the hub of a star, at forks, between the dice of a tempered pane.

use crate::vector::{Vector, cross, dot, unit};

/// One wall: a quadrilateral in the sheet's coordinates, mm, two corners on its upper edge, two on
/// the lower one in the opposite order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wall {
    pub(super) corners: [Vector; 4],
    /// Of length 1.
    pub(super) normal: Vector,
    /// It lies between two planes across that: their middle from the first corner on, and half
    /// their distance.
    middle_mm: f64,
    half_mm: f64,
    /// The way of the walk, of length 1, and between which places on it the wall lies.
    ahead: Vector,
    reach_mm: [f64; 2],
    pub(super) gap_um: f64,
    /// Number of the crack that it is a part of, and its own place along that crack.
    pub(super) crack: u32,
    pub(super) along: u32,
}

/// Walls of one crack this far apart along it do not see each other: it is nearly straight.
const NEIGHBORS: u32 = 6;

/// A ray meets nothing nearer than this, mm.
const NEAREST_MM: f64 = 1e-6;

/// Most cells of the grid along one side.
const MOST_CELLS: f64 = 512.0;

impl Wall {
    pub(super) fn new(corners: [Vector; 4], gap_um: f64, crack: u32, along: u32) -> Option<Self> {
        let middle = |a: Vector, b: Vector| -> Vector { std::array::from_fn(|k| a[k] + b[k]) };
        let ahead = difference(
            middle(corners[1], corners[2]),
            middle(corners[0], corners[3]),
        );
        let down = difference(
            middle(corners[2], corners[3]),
            middle(corners[0], corners[1]),
        );
        let normal = cross(ahead, down);
        if dot(normal, normal) <= 0.0 {
            return None;
        }
        let normal = unit(normal);
        let off = corners.map(|corner| dot(normal, difference(corner, corners[0])));
        let (low, high) = (
            off.into_iter().fold(0.0, f64::min),
            off.into_iter().fold(0.0, f64::max),
        );
        let ahead = unit(ahead);
        let places = corners.map(|corner| dot(ahead, difference(corner, corners[0])));
        Some(Self {
            corners,
            normal,
            ahead,
            reach_mm: [
                places.into_iter().fold(0.0, f64::min),
                places.into_iter().fold(0.0, f64::max),
            ],
            middle_mm: 0.5 * (low + high),
            half_mm: 0.5 * (high - low) + NEAREST_MM,
            gap_um,
            crack,
            along,
        })
    }

    /// How far along a ray of at most `most_mm` the wall is, if the ray meets it.
    fn meets(&self, from: Vector, direction: Vector, most_mm: f64) -> Option<f64> {
        let [a, b, c, d] = self.corners;
        let to = difference(from, a);
        let start = dot(self.normal, to) - self.middle_mm;
        let nears = dot(self.normal, direction);
        let end = start + most_mm * nears;
        if start.min(end) > self.half_mm || start.max(end) < -self.half_mm {
            return None;
        }
        // Where it is between the two planes, along the wall.
        let ways = [-self.half_mm, self.half_mm].map(|plane| (plane - start) / nears);
        let at = ways.map(|way| dot(self.ahead, to) + way * dot(self.ahead, direction));
        let [low, high] = self.reach_mm;
        if at[0].min(at[1]) > high + NEAREST_MM || at[0].max(at[1]) < low - NEAREST_MM {
            return None;
        }
        meets_triangle([a, b, c], from, direction)
            .or_else(|| meets_triangle([a, c, d], from, direction))
    }

    /// Least and greatest x and y.
    fn bounds(&self) -> [[f64; 2]; 2] {
        std::array::from_fn(|axis| {
            let values = self.corners.iter().map(|corner| corner[axis]);
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            })
        })
    }

    /// Its crack and its place along that.
    pub(super) fn own(&self) -> (u32, u32) {
        (self.crack, self.along)
    }

    fn is_neighbor(&self, own: Option<(u32, u32)>) -> bool {
        own.is_some_and(|(crack, along)| {
            crack == self.crack && self.along.abs_diff(along) < NEIGHBORS
        })
    }
}

/// \[MoellerTrumbore1997\]
fn meets_triangle([a, b, c]: [Vector; 3], from: Vector, direction: Vector) -> Option<f64> {
    let (ab, ac) = (difference(b, a), difference(c, a));
    let p = cross(direction, ac);
    let determinant = dot(ab, p);
    if determinant == 0.0 {
        return None;
    }
    // A hair of tolerance, so that nothing slips through where walls meet.
    let (size, hair) = (determinant.abs(), 1e-9 * determinant.abs());
    let to = difference(from, a);
    let u = dot(to, p) * determinant.signum();
    if u < -hair || u > size + hair {
        return None;
    }
    let q = cross(to, ab);
    let v = dot(direction, q) * determinant.signum();
    if v < -hair || u + v > size + hair {
        return None;
    }
    let way = dot(ac, q) / determinant;
    (way > NEAREST_MM).then_some(way)
}

fn difference(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| a[k] - b[k])
}

/// What a ray meets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met<'a> {
    pub(super) wall: &'a Wall,
    pub(super) way_mm: f64,
}

/// All walls of a pane, in a uniform grid over its plane.
#[derive(Debug, Default)]
pub(super) struct Walls {
    walls: Vec<Wall>,
    /// Least and greatest x and y of each.
    bounds: Vec<[[f64; 2]; 2]>,
    low: [f64; 2],
    cell_mm: f64,
    n: [usize; 2],
    /// First place in `members` of each cell, and one after the last.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Walls {
    /// `reach_mm` is about how far light gets in the sheet between its faces.
    pub(super) fn new(walls: Vec<Wall>, reach_mm: f64) -> Self {
        let of_each: Vec<_> = walls.iter().map(Wall::bounds).collect();
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for wall in &of_each {
            for (bound, of) in bounds.iter_mut().zip(wall) {
                *bound = [bound[0].min(of[0]), bound[1].max(of[1])];
            }
        }
        let extent = bounds.map(|[low, high]| (high - low).max(0.0));
        let cell_mm = reach_mm.max(extent[0].max(extent[1]) / MOST_CELLS);
        let mut grid = Self {
            walls,
            bounds: of_each,
            low: bounds.map(|[low, _]| low),
            cell_mm,
            n: extent.map(|side| index(side / cell_mm) + 1),
            starts: Vec::new(),
            members: Vec::new(),
        };
        if grid.walls.is_empty() {
            return grid;
        }
        let mut starts = vec![0_u32; grid.n[0] * grid.n[1] + 1];
        for bounds in &grid.bounds {
            grid.each_cell(*bounds, |cell| starts[cell + 1] += 1);
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        let mut members = vec![0; starts.last().map_or(0, |n| *n as usize)];
        for (k, bounds) in (0_u32..).zip(&grid.bounds) {
            grid.each_cell(*bounds, |cell| {
                members[next[cell] as usize] = k;
                next[cell] += 1;
            });
        }
        (grid.starts, grid.members) = (starts, members);
        grid
    }

    pub(super) fn get(&self, k: usize) -> &Wall {
        &self.walls[k]
    }

    /// The walls of other cracks within a distance of a wall.
    pub(super) fn near(&self, k: usize, reach_mm: f64) -> Vec<u32> {
        let own = self.walls[k].own();
        let around = self.bounds[k].map(|[low, high]| [low - reach_mm, high + reach_mm]);
        let mut near = Vec::new();
        self.each_cell(around, |cell| {
            near.extend(self.members_of(cell).iter().copied().filter(|&other| {
                overlap(&self.bounds[other as usize], &around)
                    && !self.walls[other as usize].is_neighbor(Some(own))
            }));
        });
        // One may lie in several cells.
        near.sort_unstable();
        near.dedup();
        near
    }

    /// The first of some walls on a ray of at most `most_mm`.
    pub(super) fn first_of(
        &self,
        some: &[u32],
        from: Vector,
        direction: Vector,
        most_mm: f64,
    ) -> Option<Met<'_>> {
        let mut first: Option<Met<'_>> = None;
        self.each_of(some, (from, direction, most_mm), None, |met| {
            if first.is_none_or(|first| met.way_mm < first.way_mm) {
                first = Some(met);
            }
        });
        first
    }

    /// The first wall on a ray of at most `most_mm`, besides that which it leaves: from cell to cell
    /// along the ray \[AmanatidesWoo1987\].
    pub(super) fn first(
        &self,
        from: Vector,
        direction: Vector,
        most_mm: f64,
        own: Option<(u32, u32)>,
    ) -> Option<Met<'_>> {
        if self.walls.is_empty() {
            return None;
        }
        let mut first: Option<Met<'_>> = None;
        let ray = (from, direction, most_mm);
        let mut cell = [0, 1].map(|k| ((from[k] - self.low[k]) / self.cell_mm).floor());
        let per_cell = [0, 1].map(|k| self.cell_mm / direction[k].abs().max(1e-12));
        let mut next = [0, 1].map(|k| {
            let edge = if direction[k] > 0.0 {
                cell[k] + 1.0
            } else {
                cell[k]
            };
            let way = (self.low[k] + edge * self.cell_mm - from[k]).abs();
            way / direction[k].abs().max(1e-12)
        });
        loop {
            if let Some(cell) = self.cell_at(cell) {
                self.each_of(self.members_of(cell), ray, own, |met| {
                    if first.is_none_or(|first| met.way_mm < first.way_mm) {
                        first = Some(met);
                    }
                });
            }
            let axis = usize::from(next[1] < next[0]);
            let way = next[axis];
            if way > most_mm || first.is_some_and(|first| first.way_mm <= way) {
                return first;
            }
            cell[axis] += 1.0_f64.copysign(direction[axis]);
            next[axis] += per_cell[axis];
        }
    }

    fn cell_at(&self, [column, row]: [f64; 2]) -> Option<usize> {
        let is_within = |at: f64, n: usize| at >= 0.0 && index(at) < n;
        (is_within(column, self.n[0]) && is_within(row, self.n[1]))
            .then(|| index(row) * self.n[0] + index(column))
    }

    /// Share of the light of sight that reaches a place in the sheet past some walls before it.
    pub(super) fn passes(
        &self,
        some: &[u32],
        at: Vector,
        inside: Vector,
        reflectance: impl Fn(f64, f64) -> f64,
    ) -> f64 {
        let back = inside.map(|part| -part);
        let mut passes = 1.0;
        self.each_of(some, (at, back, at[2] / inside[2]), None, |met| {
            let cos = dot(back, met.wall.normal).abs();
            passes *= 1.0 - reflectance(cos, met.wall.gap_um);
        });
        passes
    }

    /// Those of some walls that a ray meets.
    fn each_of<'a>(
        &'a self,
        some: &[u32],
        ray: (Vector, Vector, f64),
        own: Option<(u32, u32)>,
        mut each: impl FnMut(Met<'a>),
    ) {
        let (from, direction, most_mm) = ray;
        let swept = swept(ray);
        for &k in some {
            if !overlap(&self.bounds[k as usize], &swept) {
                continue;
            }
            let wall = &self.walls[k as usize];
            if wall.is_neighbor(own) {
                continue;
            }
            if let Some(way_mm) = wall.meets(from, direction, most_mm)
                && way_mm <= most_mm
            {
                each(Met { wall, way_mm });
            }
        }
    }

    fn members_of(&self, cell: usize) -> &[u32] {
        &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// The cells that a box may touch.
    fn each_cell(&self, bounds: [[f64; 2]; 2], mut each: impl FnMut(usize)) {
        let [columns, rows] = [0, 1].map(|axis| {
            let [low, high] = bounds[axis].map(|at| (at - self.low[axis]) / self.cell_mm);
            if high < 0.0 {
                return 0..0;
            }
            index(low)..(index(high) + 1).min(self.n[axis])
        });
        for row in rows {
            for column in columns.clone() {
                each(row * self.n[0] + column);
            }
        }
    }
}

/// The box over which a ray runs: from where, in which direction, how far.
fn swept((from, direction, most_mm): (Vector, Vector, f64)) -> [[f64; 2]; 2] {
    [0, 1].map(|axis| {
        let end = from[axis] + most_mm * direction[axis];
        [from[axis].min(end), from[axis].max(end)]
    })
}

/// Whether two boxes have a point in common.
fn overlap(a: &[[f64; 2]; 2], b: &[[f64; 2]; 2]) -> bool {
    a[0][0] <= b[0][1] && a[0][1] >= b[0][0] && a[1][0] <= b[1][1] && a[1][1] >= b[1][0]
}

/// The cell of a coordinate; those before the first are the first.
fn index(value: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` clamps, which is meant"
    )]
    let index = value as u32 as usize;
    index
}
