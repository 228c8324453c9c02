//! Rows of cells to rows of pixels, whichever of the two is smaller.

use super::chunks::{CHUNK, Chunks};

/// Shares below this are none; it is far below a step of an 8-bit image.
const LEAST_SHARE: f32 = 2e-5;

/// Turns rows of cells into rows of pixels.
pub(super) struct Emitter<const L: usize> {
    level: i32,
    margin: usize,
    n_shares: usize,
    /// The present row of cells, and the part of it that is set.
    pub(super) row: Vec<[f32; L]>,
    pub(super) span: [usize; 2],
    /// Coarse cells: the row before. Fine cells: the sum of the rows of a pixel so far.
    other: Vec<[f32; L]>,
    other_span: [usize; 2],
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
            other: vec![[0.0; L]; columns],
            other_span: [0, 0],
            pixels: Vec::new(),
        }
    }

    pub(super) fn begin_row(&mut self) {
        let [first, last] = self.span;
        self.row[first..last].fill([0.0; L]);
        self.span = [0, 0];
    }

    pub(super) fn end_row(&mut self, row: usize, frame: &mut Chunks<L>) {
        match self.level {
            0 => self.equal(row, frame),
            1.. => self.fine(row, frame),
            _ => self.coarse(row, frame),
        }
    }

    fn equal(&mut self, row: usize, frame: &mut Chunks<L>) {
        let (width, height) = frame.size();
        let Some(y) = row.checked_sub(self.margin).filter(|y| *y < height) else {
            return;
        };
        let [first, last] = self.span;
        let (start, end) = (
            first.saturating_sub(self.margin),
            last.saturating_sub(self.margin).min(width),
        );
        if start < end {
            let values = &self.row[start + self.margin..end + self.margin];
            hand_on(frame, y, start, values, self.n_shares);
        }
    }

    fn fine(&mut self, row: usize, frame: &mut Chunks<L>) {
        let per_px = 1_usize << self.level;
        let [first, last] = self.span;
        if first < last {
            for (sum, value) in self.other[first..last]
                .iter_mut()
                .zip(&self.row[first..last])
            {
                for (sum, value) in sum.iter_mut().zip(value) {
                    *sum += value;
                }
            }
            let [low, high] = self.other_span;
            self.other_span = if low < high {
                [low.min(first), high.max(last)]
            } else {
                [first, last]
            };
        }
        if !(row + 1).is_multiple_of(per_px) {
            return;
        }
        let [first, last] = std::mem::take(&mut self.other_span);
        if first >= last {
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
                for cell in &self.other[self.margin + x * per_px..][..per_px] {
                    for (sum, value) in sum.iter_mut().zip(cell) {
                        *sum += share * value;
                    }
                }
                self.pixels.push(sum);
            }
            hand_on(frame, y, start, &self.pixels, self.n_shares);
        }
        self.other[first..last].fill([0.0; L]);
    }

    fn coarse(&mut self, row: usize, frame: &mut Chunks<L>) {
        let (width, height) = frame.size();
        let per_cell = 1_usize << -self.level;
        let [first, last] = [
            least(self.span, self.other_span),
            self.span[1].max(self.other_span[1]),
        ];
        if first < last {
            // Pixels whose centres lie between the centres of the rows `row − 1` and `row`.
            let half = per_cell / 2;
            let begin = (row * per_cell + half).checked_sub(self.margin * per_cell + per_cell);
            let (y_first, skip) = match begin {
                Some(y) => (y, 0),
                None => (
                    0,
                    (self.margin * per_cell + per_cell) - (row * per_cell + half),
                ),
            };
            for k in skip..per_cell {
                let y = y_first + k - skip;
                if y >= height {
                    break;
                }
                #[expect(clippy::cast_precision_loss, reason = "1 to 8")]
                let t = (k as f32 + 0.5) / per_cell as f32;
                self.coarse_line([first, last], t, y, width, frame);
            }
        }
        std::mem::swap(&mut self.row, &mut self.other);
        std::mem::swap(&mut self.span, &mut self.other_span);
    }

    /// One row of pixels between two rows of cells, `t` of the way from the one before.
    fn coarse_line(
        &mut self,
        [first, last]: [usize; 2],
        t: f32,
        y: usize,
        width: usize,
        frame: &mut Chunks<L>,
    ) {
        let per_cell = 1_usize << -self.level;
        let half = per_cell / 2;
        let zero = [0.0; L];
        let blend = |column: usize| -> [f32; L] {
            let before = self.other.get(column).unwrap_or(&zero);
            let now = self.row.get(column).unwrap_or(&zero);
            std::array::from_fn(|l| before[l] + t * (now[l] - before[l]))
        };
        // Pixels between the centres of the cells `first − 1` and `last`.
        let place =
            |column: usize| (column * per_cell + half).saturating_sub(self.margin * per_cell);
        let start = place(first.saturating_sub(1));
        let end = place(last).min(width);
        if start >= end {
            return;
        }
        self.pixels.clear();
        let mut x = start;
        let shifted = |x: usize| x + self.margin * per_cell - half;
        let mut left = shifted(x) / per_cell;
        let (mut a, mut b) = (blend(left), blend(left + 1));
        while x < end {
            let at = shifted(x);
            if at / per_cell != left {
                left = at / per_cell;
                a = b;
                b = blend(left + 1);
            }
            #[expect(clippy::cast_precision_loss, reason = "below 8")]
            let s = ((at % per_cell) as f32 + 0.5) / per_cell as f32;
            self.pixels
                .push(std::array::from_fn(|l| a[l] + s * (b[l] - a[l])));
            x += 1;
        }
        hand_on(frame, y, start, &self.pixels, self.n_shares);
    }
}

/// The lower start of two spans, of which those with nothing in them do not count.
fn least(a: [usize; 2], b: [usize; 2]) -> usize {
    match (a[0] < a[1], b[0] < b[1]) {
        (true, true) => a[0].min(b[0]),
        (true, false) => a[0],
        _ => b[0],
    }
}

/// Adds a row of pixels to the frame, without the runs in which there is nothing.
fn hand_on<const L: usize>(
    frame: &mut Chunks<L>,
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
