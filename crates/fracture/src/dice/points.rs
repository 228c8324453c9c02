//! Where dice have their middles: points that keep their distance.

use rand_chacha::rand_core::Rng;
use starbreak_seed::uniform;

use super::radial_map::RadialMap;
use crate::mesh::Outline;

/// Least distance of two points, in distances of a hexagonal lattice of their density. A random
/// packing of discs reaches 0.77. FIT within the 0.55 to 0.75 of \[Pourmoghaddam2018\].
const HARD_CORE: f64 = 0.58;
/// Least distance from the rim, in the same measure.
const RIM: f64 = 0.24;
/// Darts per point after which the pane counts as full.
const DARTS: usize = 400;

/// Middles of dice: in the even plane, and on the pane.
pub(super) struct Middles {
    pub(super) even: Vec<[f64; 2]>,
    pub(super) on_pane: Vec<[f64; 2]>,
}

/// Draws `n` points in the pane, evenly in the even plane, none closer than the hard core: a
/// sequence of darts that each count only where there is room.
pub(super) fn draw(
    outline: &Outline,
    map: &RadialMap,
    n: usize,
    spacing_m: f64,
    rng: &mut impl Rng,
) -> Middles {
    let core = HARD_CORE * spacing_m;
    let reach = map.reach_m();
    let [width, height] = outline.size_m().map(|side| side + 2.0 * reach);
    let mut grid = Grid::new([width, height], reach, core);
    let mut middles = Middles {
        even: Vec::with_capacity(n),
        on_pane: Vec::with_capacity(n),
    };
    for _ in 0..n.saturating_mul(DARTS) {
        if middles.even.len() >= n {
            break;
        }
        let even = [uniform(rng) * width - reach, uniform(rng) * height - reach];
        if !grid.has_room(even, &middles.even) {
            continue;
        }
        let on_pane = map.to_pane(even);
        let room = RIM * spacing_m * map.shrink(on_pane);
        // A pane thinner than two such distances keeps its middle.
        let room = room.min(0.2 * outline.size_m()[0].min(outline.size_m()[1]));
        if outline.depth_m(on_pane) >= room {
            grid.insert(even, middles.even.len());
            middles.even.push(even);
            middles.on_pane.push(on_pane);
        }
    }
    middles
}

/// Points by square; a square is so small that it holds at most one.
struct Grid {
    squares: Vec<u32>,
    n_columns: usize,
    n_rows: usize,
    side: f64,
    origin: f64,
    core: f64,
}

const EMPTY: u32 = u32::MAX;

impl Grid {
    fn new(size: [f64; 2], origin: f64, core: f64) -> Self {
        let side = core / 1.5;
        let [n_columns, n_rows] = size.map(|length| to_index(length / side) + 1);
        Self {
            squares: vec![EMPTY; n_columns * n_rows],
            n_columns,
            n_rows,
            side,
            origin,
            core,
        }
    }

    fn square(&self, point: [f64; 2]) -> (usize, usize) {
        let [column, row] = point.map(|at| to_index((at + self.origin) / self.side));
        (column.min(self.n_columns - 1), row.min(self.n_rows - 1))
    }

    /// Whether a point has room beside others.
    fn has_room(&self, point: [f64; 2], points: &[[f64; 2]]) -> bool {
        let (column, row) = self.square(point);
        for y in row.saturating_sub(2)..(row + 3).min(self.n_rows) {
            for x in column.saturating_sub(2)..(column + 3).min(self.n_columns) {
                let other = self.squares[y * self.n_columns + x];
                if other != EMPTY {
                    let [ox, oy] = points[other as usize];
                    let (dx, dy) = (ox - point[0], oy - point[1]);
                    if dx * dx + dy * dy < self.core * self.core {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Adds the next point, which has room.
    fn insert(&mut self, point: [f64; 2], idx: usize) {
        let (column, row) = self.square(point);
        self.squares[row * self.n_columns + column] = crate::mesh::to_u32(idx);
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`as` saturates; squares are clamped"
)]
fn to_index(value: f64) -> usize {
    value as usize
}
