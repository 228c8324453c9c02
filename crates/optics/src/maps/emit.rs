//! Rows of cells to rows of pixels, whichever of the two is smaller.

use super::lane_runs::{CHUNK, LaneRuns};
use super::layer::{add_arrays, add_scaled};

/// Shares below this are none; it is far below a step of an 8-bit image.
const LEAST_SHARE: f32 = 2e-5;

/// Turns rows of cells into rows of pixels.
pub(super) struct Emitter<const L: usize> {
    level: i32,
    margin: usize,
    n_shares: usize,
    /// The present row of cells, of fine cells the sum of the rows of a pixel so far, and the part
    /// of it that is set where cells are no pixels.
    row: Vec<[f32; L]>,
    span: [usize; 2],
    /// Coarse cells: the three rows before, and a blend of rows.
    earlier: [Earlier<L>; 3],
    blended: Vec<[f32; L]>,
    pixels: Vec<[f32; L]>,
}

impl<const L: usize> Emitter<L> {
    pub(super) fn new(level: i32, margin: usize, columns: usize, n_shares: usize) -> Self {
        Self {
            level,
            margin,
            n_shares,
            row: vec![[0.0; L]; columns],
            span: [0, 0],
            earlier: [0; 3].map(|_| Earlier {
                cells: vec![[0.0; L]; if level < 0 { columns } else { 0 }],
                span: [0, 0],
            }),
            blended: Vec::new(),
            pixels: Vec::new(),
        }
    }

    #[inline(always)]
    pub(super) fn begin_row(&mut self) {
        if self.level < 0 {
            self.clear();
        }
    }

    #[inline(always)]
    fn clear(&mut self) {
        let [first, last] = std::mem::take(&mut self.span);
        self.row[first..last].fill([0.0; L]);
    }

    /// Takes the cells of a run of a row.
    #[inline(always)]
    pub(super) fn take_run(
        &mut self,
        row: usize,
        [first, last]: [usize; 2],
        cells: impl Iterator<Item = [f32; L]>,
        frame: &mut LaneRuns<L>,
    ) {
        let to = &mut self.row[first..last];
        if self.level > 0 {
            for (sum, cell) in to.iter_mut().zip(cells) {
                *sum = add_arrays(*sum, cell);
            }
        } else {
            for (to, cell) in to.iter_mut().zip(cells) {
                *to = cell;
            }
        }
        if self.level == 0 {
            self.equal(row, [first, last], frame);
        } else {
            self.span = union(self.span, [first, last]);
        }
    }

    /// Takes a row of which all runs have been.
    #[inline(always)]
    pub(super) fn end_row(&mut self, row: usize, frame: &mut LaneRuns<L>) {
        match self.level {
            0 => {}
            1.. => self.fine(row, frame),
            _ => self.coarse(row, frame),
        }
    }

    #[inline(always)]
    fn equal(&mut self, row: usize, [first, last]: [usize; 2], frame: &mut LaneRuns<L>) {
        let (width, height) = frame.size();
        let Some(y) = row.checked_sub(self.margin).filter(|y| *y < height) else {
            return;
        };
        let (start, end) = (
            first.saturating_sub(self.margin),
            last.saturating_sub(self.margin).min(width),
        );
        if start < end {
            let values = &self.row[start + self.margin..end + self.margin];
            hand_on(frame, y, start, values, self.n_shares);
        }
    }

    #[inline(always)]
    fn fine(&mut self, row: usize, frame: &mut LaneRuns<L>) {
        let per_px = 1_usize << self.level;
        let [first, last] = self.span;
        if !(row + 1).is_multiple_of(per_px) || first >= last {
            return;
        }
        let (width, height) = frame.size();
        let start = (first / per_px).saturating_sub(self.margin / per_px);
        let end = last
            .div_ceil(per_px)
            .saturating_sub(self.margin / per_px)
            .min(width);
        if let Some(y) = (row / per_px).checked_sub(self.margin / per_px)
            && y < height
            && start < end
        {
            #[expect(clippy::cast_precision_loss, reason = "4 or 16")]
            let share = 1.0 / (per_px * per_px) as f32;
            self.pixels.clear();
            for x in start..end {
                let mut sum = [0.0; L];
                for cell in &self.row[self.margin + x * per_px..][..per_px] {
                    sum = add_scaled(sum, share, *cell);
                }
                self.pixels.push(sum);
            }
            hand_on(frame, y, start, &self.pixels, self.n_shares);
        }
        self.clear();
    }

    #[inline(always)]
    fn coarse(&mut self, row: usize, frame: &mut LaneRuns<L>) {
        let (width, height) = frame.size();
        let per_cell = 1_usize << -self.level;
        let spans = self.earlier.iter().map(|earlier| earlier.span);
        let [first, last] = spans.fold(self.span, union);
        if first < last {
            // Pixels whose centres lie between the centres of the rows `row − 2` and `row − 1`.
            let half = per_cell / 2;
            let above = (self.margin + 2) * per_cell;
            let begin = row * per_cell + half;
            let rows = begin.max(above)..(begin + per_cell).min(above + height);
            for y in rows.map(|at| at - above) {
                let k = y + above - begin;
                #[expect(clippy::cast_precision_loss, reason = "a part of a cell")]
                let t = (k as f32 + 0.5) / per_cell as f32;
                self.coarse_line([first, last], t, y, width, frame);
            }
        }
        let [one, two, three] = &mut self.earlier;
        std::mem::swap(one, two);
        std::mem::swap(two, three);
        std::mem::swap(&mut self.row, &mut three.cells);
        std::mem::swap(&mut self.span, &mut three.span);
    }

    /// One row of pixels between the second and the third of four rows of cells, `t` of the way.
    #[inline(always)]
    fn coarse_line(
        &mut self,
        [first, last]: [usize; 2],
        t: f32,
        y: usize,
        width: usize,
        frame: &mut LaneRuns<L>,
    ) {
        let per_cell = 1_usize << -self.level;
        let half = per_cell / 2;
        let down = cubic(t);
        // Two cells of nothing on either side, which the curves reach into.
        self.blended.clear();
        self.blended.resize(last - first + 6, [0.0; L]);
        for (column, to) in (first..last).zip(&mut self.blended[3..]) {
            let [one, two, three] = &self.earlier;
            let cells = [&one.cells, &two.cells, &three.cells, &self.row].map(|row| &row[column]);
            *to = weighted(cells, down);
        }
        // Pixels between the centres of the cells `first − 2` and `last + 1`.
        let place =
            |column: usize| (column * per_cell + half).saturating_sub(self.margin * per_cell);
        let start = place(first.saturating_sub(2));
        let end = place(last + 1).min(width);
        if start >= end {
            return;
        }
        self.pixels.clear();
        for x in start..end {
            let at = x + self.margin * per_cell - half;
            #[expect(clippy::cast_precision_loss, reason = "a part of a cell")]
            let s = ((at % per_cell) as f32 + 0.5) / per_cell as f32;
            // The cell to the left of the pixel, and the first of the four, in `blended`.
            let left = (at / per_cell + 3).saturating_sub(first + 1);
            let pixel = match self.blended.get(left..left + 4) {
                Some([a, b, c, d]) => weighted([a, b, c, d], cubic(s)),
                _ => [0.0; L],
            };
            self.pixels.push(pixel);
        }
        hand_on(frame, y, start, &self.pixels, self.n_shares);
    }
}

/// A row of cells, of which a part is set.
struct Earlier<const L: usize> {
    cells: Vec<[f32; L]>,
    span: [usize; 2],
}

/// Weights of four cells for a place between the middle two, `t` of the way \[Keys1981\]: curves
/// through the cells, right to the second order.
fn cubic(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        -0.5 * t + t2 - 0.5 * t3,
        1.0 - 2.5 * t2 + 1.5 * t3,
        0.5 * t + 2.0 * t2 - 1.5 * t3,
        -0.5 * t2 + 0.5 * t3,
    ]
}

#[inline(always)]
fn weighted<const L: usize>([a, b, c, d]: [&[f32; L]; 4], w: [f32; 4]) -> [f32; L] {
    let (a, b, c, d) = (*a, *b, *c, *d);
    let mut sum = a;
    let mut l = 0;
    while l < L {
        sum[l] = w[0] * a[l] + w[1] * b[l] + w[2] * c[l] + w[3] * d[l];
        l += 1;
    }
    sum
}

/// The least span that holds two, of which those with nothing in them do not count.
fn union(a: [usize; 2], b: [usize; 2]) -> [usize; 2] {
    match (a[0] < a[1], b[0] < b[1]) {
        (true, true) => [a[0].min(b[0]), a[1].max(b[1])],
        (true, false) => a,
        _ => b,
    }
}

/// Adds a row of pixels to the frame, without the runs in which there is nothing.
#[inline(always)]
fn hand_on<const L: usize>(
    frame: &mut LaneRuns<L>,
    y: usize,
    start: usize,
    values: &[[f32; L]],
    n_shares: usize,
) {
    let mut at = 0;
    while at < values.len() {
        let x = start + at;
        let n = (CHUNK - x % CHUNK).min(values.len() - at);
        let part = &values[at..at + n];
        let is_something = part.iter().any(|pixel| {
            pixel[..n_shares]
                .iter()
                .map(|share| share.abs())
                .sum::<f32>()
                > LEAST_SHARE
        });
        if is_something {
            frame.add_row(y, x, part);
        }
        at += n;
    }
}
