//! The cracks that there are: nodes and straight pieces, and what a running tip would hit.

use starbreak_glass::SegmentKind;

use crate::mesh::{Outline, to_u32};

/// A straight piece of crack between two nodes, with what was true when its tip passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// Start node.
    pub(crate) a: u32,
    /// End node.
    pub(crate) b: u32,
    /// Number of the crack it is a part of.
    pub(crate) crack: u32,
    /// What it is.
    pub(crate) kind: SegmentKind,
    /// When the tip left `a` and reached `b`, s.
    pub(crate) time_s: [f64; 2],
    /// Distance of `a` and `b` from where the crack began, m.
    pub(crate) along_m: [f64; 2],
    /// Stress across the crack, Pa.
    pub(crate) stress_pa: f64,
    /// Stress intensity K, Pa √m.
    pub(crate) intensity_pa_sqrt_m: f64,
    /// Length that counts for K, m.
    pub(crate) effective_m: f64,
    /// Angle between the crack's surface and the normal of the pane at `a` and `b`, rad.
    pub(crate) tilt_rad: [f64; 2],
}

/// A piece in the way of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    pub(crate) piece: u32,
    /// Fraction of the step.
    pub(crate) at: f64,
    pub(crate) point_m: [f64; 2],
}

/// Cells along the longer side of the grid.
const CELLS: usize = 512;

/// No further entry in a cell.
const END: u32 = u32::MAX;

/// Nodes and pieces over a uniform grid.
pub(crate) struct Web {
    pub(crate) outline: Outline,
    pub(crate) nodes: Vec<[f64; 2]>,
    pub(crate) pieces: Vec<Piece>,
    /// Of each crack the one that it grew out of.
    parents: Vec<Option<u32>>,
    cell_m: f64,
    columns: usize,
    rows: usize,
    head: Vec<u32>,
    /// (piece, next entry)
    entries: Vec<(u32, u32)>,
}

/// What is left of a piece that was cut, when it is shorter, m, is nothing: no drawing shows it.
const SHORTEST_CUT_M: f64 = 1e-6;

impl Web {
    pub(crate) fn new(outline: Outline) -> Self {
        let [width, height] = outline.size_m();
        #[expect(clippy::cast_precision_loss, reason = "a small count")]
        let cell_m = width.max(height) / CELLS as f64;
        let cells = |side: f64| cell_index(side / cell_m, CELLS) + 1;
        let (columns, rows) = (cells(width), cells(height));
        Self {
            outline,
            nodes: Vec::new(),
            pieces: Vec::new(),
            parents: Vec::new(),
            cell_m,
            columns,
            rows,
            head: vec![END; columns * rows],
            entries: Vec::new(),
        }
    }

    /// A number for one more crack, which grows out of an older one or begins by itself.
    pub(crate) fn new_crack(&mut self, parent: Option<u32>) -> u32 {
        self.parents.push(parent);
        to_u32(self.parents.len() - 1)
    }

    /// The crack that one grew out of.
    pub(crate) fn parent(&self, crack: u32) -> Option<u32> {
        self.parents[crack as usize]
    }

    /// Of each crack, whether such a piece is a part of it, or of one that it grew out of.
    pub(crate) fn grown_from(&self, is_root: impl Fn(&Piece) -> bool) -> Vec<bool> {
        let mut is_grown = vec![false; self.parents.len()];
        for piece in &self.pieces {
            is_grown[piece.crack as usize] |= is_root(piece);
        }
        for (crack, parent) in self.parents.iter().enumerate() {
            is_grown[crack] |= parent.is_some_and(|parent| is_grown[parent as usize]);
        }
        is_grown
    }

    /// How many cracks there are.
    pub(crate) fn n_cracks(&self) -> u32 {
        to_u32(self.parents.len())
    }

    pub(crate) fn add_node(&mut self, point_m: [f64; 2]) -> u32 {
        self.nodes.push(point_m);
        to_u32(self.nodes.len() - 1)
    }

    pub(crate) fn add_piece(&mut self, piece: Piece) -> u32 {
        let id = to_u32(self.pieces.len());
        self.pieces.push(piece);
        self.enter(id);
        id
    }

    fn enter(&mut self, id: u32) {
        let Piece { a, b, .. } = self.pieces[id as usize];
        let (from, to) = (self.nodes[a as usize], self.nodes[b as usize]);
        let (columns, rows) = self.cells_of(from, to);
        for row in rows.0..=rows.1 {
            for column in columns.0..=columns.1 {
                let head = &mut self.head[row * self.columns + column];
                self.entries.push((id, *head));
                *head = to_u32(self.entries.len() - 1);
            }
        }
    }

    /// Ranges of columns and rows of the cells of a box.
    fn cells_of(&self, from: [f64; 2], to: [f64; 2]) -> ((usize, usize), (usize, usize)) {
        let column = |x: f64| cell_index(x / self.cell_m, self.columns);
        let row = |y: f64| cell_index(y / self.cell_m, self.rows);
        (
            (column(from[0].min(to[0])), column(from[0].max(to[0]))),
            (row(from[1].min(to[1])), row(from[1].max(to[1]))),
        )
    }

    /// Takes back everything after a moment: pieces that had not begun, or hardly, and of those that
    /// had the part that was still ahead.
    pub(crate) fn cut(&mut self, time_s: f64) {
        let nodes = &self.nodes;
        self.pieces.retain(|piece| {
            let [from_s, to_s] = piece.time_s;
            let [a, b] = [piece.a, piece.b].map(|node| nodes[node as usize]);
            let length_m = libm::hypot(b[0] - a[0], b[1] - a[1]);
            to_s <= time_s || (time_s - from_s) * length_m > SHORTEST_CUT_M * (to_s - from_s)
        });
        for k in 0..self.pieces.len() {
            let piece = self.pieces[k];
            let [from_s, to_s] = piece.time_s;
            // Pieces of one crack may all come at once, as those of a cone do.
            if to_s <= time_s || piece.kind == SegmentKind::Cone {
                continue;
            }
            let part = (time_s - from_s) / (to_s - from_s);
            let [a, b] = [piece.a, piece.b].map(|node| self.nodes[node as usize]);
            let b = self.add_node([0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * part));
            let middle = |[from, to]: [f64; 2]| [from, from + (to - from) * part];
            self.pieces[k] = Piece {
                b,
                time_s: [from_s, time_s],
                along_m: middle(piece.along_m),
                tilt_rad: middle(piece.tilt_rad),
                ..piece
            };
        }
    }

    /// The pieces that count as chains of points, m: each crack, or half of a crack that began in
    /// its middle, from where it began.
    pub(crate) fn chains(&self, counts: impl Fn(&Piece) -> bool) -> Vec<Vec<[f64; 2]>> {
        let mut order: Vec<&Piece> = self.pieces.iter().filter(|piece| counts(piece)).collect();
        order.sort_by(|a, b| {
            let along = a.along_m[0].total_cmp(&b.along_m[0]);
            a.crack.cmp(&b.crack).then(along)
        });
        // Chains with the node where each ends, those of the present crack last.
        let mut chains: Vec<(u32, Vec<[f64; 2]>)> = Vec::new();
        let mut first = 0;
        let mut crack = None;
        for piece in order {
            if crack != Some(piece.crack) {
                crack = Some(piece.crack);
                first = chains.len();
            }
            let to = self.nodes[piece.b as usize];
            match chains[first..].iter_mut().find(|(end, _)| *end == piece.a) {
                Some((end, chain)) => {
                    *end = piece.b;
                    chain.push(to);
                }
                None => chains.push((piece.b, vec![self.nodes[piece.a as usize], to])),
            }
        }
        chains.into_iter().map(|(_, chain)| chain).collect()
    }

    /// The first piece that a step meets, of those that `counts` and do not start or end at
    /// node `own`.
    pub(crate) fn first_hit(
        &self,
        from: [f64; 2],
        to: [f64; 2],
        own: u32,
        counts: impl Fn(&Piece) -> bool,
    ) -> Option<Hit> {
        let (columns, rows) = self.cells_of(from, to);
        let mut best: Option<Hit> = None;
        for row in rows.0..=rows.1 {
            for column in columns.0..=columns.1 {
                let mut entry = self.head[row * self.columns + column];
                while entry != END {
                    let (id, next) = self.entries[entry as usize];
                    entry = next;
                    let piece = &self.pieces[id as usize];
                    if piece.a == own || piece.b == own || !counts(piece) {
                        continue;
                    }
                    let (p, q) = (self.nodes[piece.a as usize], self.nodes[piece.b as usize]);
                    let Some(at) = crossing(from, to, p, q) else {
                        continue;
                    };
                    // Equal hits go to the lower piece, whatever the order of the cells.
                    let is_first =
                        best.is_none_or(|hit| at < hit.at || (at <= hit.at && id < hit.piece));
                    if is_first {
                        best = Some(Hit {
                            piece: id,
                            at,
                            point_m: [
                                from[0] + (to[0] - from[0]) * at,
                                from[1] + (to[1] - from[1]) * at,
                            ],
                        });
                    }
                }
            }
        }
        best
    }

    /// A node of `piece` at `point`, which lies on it: one of its ends if that is nearer than
    /// `tolerance_m`, else a new one that divides it.
    pub(crate) fn node_on(&mut self, piece: u32, point_m: [f64; 2], tolerance_m: f64) -> u32 {
        let old = self.pieces[piece as usize];
        let (p, q) = (self.nodes[old.a as usize], self.nodes[old.b as usize]);
        for (node, end) in [(old.a, p), (old.b, q)] {
            if libm::hypot(end[0] - point_m[0], end[1] - point_m[1]) <= tolerance_m {
                return node;
            }
        }
        let total = libm::hypot(q[0] - p[0], q[1] - p[1]);
        let t = (libm::hypot(point_m[0] - p[0], point_m[1] - p[1]) / total).clamp(0.0, 1.0);
        let middle = |[from, to]: [f64; 2]| from + (to - from) * t;
        let node = self.add_node(point_m);
        let (time, along) = (middle(old.time_s), middle(old.along_m));
        let tilt = middle(old.tilt_rad);
        self.pieces[piece as usize] = Piece {
            b: node,
            time_s: [old.time_s[0], time],
            along_m: [old.along_m[0], along],
            tilt_rad: [old.tilt_rad[0], tilt],
            ..old
        };
        self.add_piece(Piece {
            a: node,
            time_s: [time, old.time_s[1]],
            along_m: [along, old.along_m[1]],
            tilt_rad: [tilt, old.tilt_rad[1]],
            ..old
        });
        node
    }
}

/// `value` as an index below `count`.
fn cell_index(value: f64, count: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` clamps, which is meant"
    )]
    let index = value as usize;
    index.min(count.saturating_sub(1))
}

/// Fraction of `from → to` at which it meets `p → q`.
fn crossing(from: [f64; 2], to: [f64; 2], p: [f64; 2], q: [f64; 2]) -> Option<f64> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let (ex, ey) = (q[0] - p[0], q[1] - p[1]);
    let determinant = dx * ey - dy * ex;
    let (fx, fy) = (p[0] - from[0], p[1] - from[1]);
    let at = (fx * ey - fy * ex) / determinant;
    let along = (fx * dy - fy * dx) / determinant;
    // A hair of tolerance, so that nothing slips through at a node.
    let hair = 1e-9;
    let meets = (-hair..=1.0 + hair).contains(&at) && (-hair..=1.0 + hair).contains(&along);
    meets.then_some(at.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(a: u32, b: u32) -> Piece {
        Piece {
            a,
            b,
            crack: 0,
            kind: SegmentKind::Radial,
            time_s: [0.0, 1.0],
            along_m: [0.0, 1.0],
            stress_pa: 0.0,
            intensity_pa_sqrt_m: 0.0,
            effective_m: 0.0,
            tilt_rad: [0.0; 2],
        }
    }

    #[test]
    fn a_crack_is_a_chain_from_where_it_began() {
        let mut web = Web::new(Outline::Rectangle {
            width_m: 1.0,
            height_m: 1.0,
        });
        let nodes: Vec<u32> = [0.5, 0.6, 0.8, 0.4, 0.1]
            .into_iter()
            .map(|x| web.add_node([x, 0.5]))
            .collect();
        // Both halves of a crack from the middle; the longest piece is then divided.
        for (from, to, along) in [(0, 1, 0.0), (1, 2, 0.1), (0, 3, 0.0), (3, 4, 0.1)] {
            let mut piece = piece(nodes[from], nodes[to]);
            piece.along_m = [along, 2.0 * along + 0.1];
            web.add_piece(piece);
        }
        let mut other = piece(nodes[2], nodes[4]);
        other.crack = 1;
        web.add_piece(other);
        web.node_on(1, [0.7, 0.5], 1e-6);
        let xs = |chain: &Vec<[f64; 2]>| chain.iter().map(|p| p[0]).collect::<Vec<_>>();
        let chains: Vec<_> = web
            .chains(|piece| piece.crack == 0)
            .iter()
            .map(xs)
            .collect();
        assert_eq!(
            chains,
            [vec![0.5, 0.6, 0.7, 0.8], vec![0.5, 0.4, 0.1]],
            "in the order of the way"
        );
        assert_eq!(web.chains(|_| true).len(), 3, "the other crack is its own");
    }

    #[test]
    fn a_step_meets_the_first_piece_and_divides_it() {
        let mut web = Web::new(Outline::Rectangle {
            width_m: 1.0,
            height_m: 0.5,
        });
        for x in [0.3, 0.2, 0.4] {
            let a = web.add_node([x, 0.0]);
            let b = web.add_node([x, 0.4]);
            web.add_piece(piece(a, b));
        }
        let hit = web.first_hit([0.1, 0.1], [0.9, 0.1], END, |_| true);
        assert_eq!(hit.map(|hit| hit.piece), Some(1), "the nearest one");
        let Some(hit) = hit else { return };
        let node = web.node_on(hit.piece, hit.point_m, 1e-6);
        assert_eq!(web.pieces.len(), 4, "it is in two now");
        assert!(
            (web.pieces[3].time_s[0] - 0.25).abs() < 1e-12,
            "its times are shared by length"
        );
        assert_eq!(
            web.node_on(3, hit.point_m, 1e-6),
            node,
            "a node that is there is taken"
        );
        assert!(
            web.first_hit([0.1, 0.45], [0.9, 0.45], END, |_| true)
                .is_none(),
            "nothing is in the way"
        );
    }
}
