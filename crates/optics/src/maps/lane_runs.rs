//! A frame of which only touched runs of pixels exist, lane by lane.

/// Pixels in a run.
pub(crate) const CHUNK: usize = 32;

/// [`CHUNK`] pixels of a row, all of one lane before those of the next, so that the same is done to
/// several of them at once.
pub(crate) type LaneRun<const L: usize> = [[f32; CHUNK]; L];

/// A frame of `L` lanes per pixel, kept in runs of pixels in the order of rows; a run that nothing
/// touched takes four bytes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LaneRuns<const L: usize> {
    width: usize,
    height: usize,
    n_across: usize,
    /// Place of each run in `runs`, plus one; 0 where it does not exist.
    places: Vec<u32>,
    /// First pixel and row of each run.
    starts: Vec<(usize, usize)>,
    runs: Vec<LaneRun<L>>,
}

impl<const L: usize> LaneRuns<L> {
    /// An empty frame with room for so many runs.
    pub(crate) fn with_room(width: usize, height: usize, n_runs: usize) -> Self {
        let n_across = width.div_ceil(CHUNK);
        Self {
            width,
            height,
            n_across,
            places: vec![0; n_across * height],
            starts: Vec::with_capacity(n_runs),
            runs: Vec::with_capacity(n_runs),
        }
    }

    /// A further run of zeros, beyond the last one in the order of rows, at its first pixel and row.
    pub(crate) fn push(&mut self, (x, y): (usize, usize)) -> &mut LaneRun<L> {
        let run = self.runs.push_mut([[0.0; CHUNK]; L]);
        self.starts.push((x, y));
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a frame has fewer than 2^32 runs"
        )]
        let n = self.starts.len() as u32;
        self.places[y * self.n_across + x / CHUNK] = n;
        run
    }

    pub(crate) fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Number of runs that exist.
    pub(crate) fn n_runs(&self) -> usize {
        self.runs.len()
    }

    /// The runs that exist, row by row: first pixel, row, lanes. The last run of a row may reach
    /// beyond the frame.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, usize, &LaneRun<L>)> {
        let starts = self.starts.iter().copied();
        starts.zip(&self.runs).map(|((x, y), run)| (x, y, run))
    }

    /// The run that holds a pixel of the frame, if it exists.
    pub(crate) fn run_at(&self, x: usize, y: usize) -> Option<&LaneRun<L>> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let place = self.places[y * self.n_across + x / CHUNK] as usize;
        (place > 0).then(|| &self.runs[place - 1])
    }

    /// Adds to a row of pixels. Runs may come to be in any order, until [`LaneRuns::sort`].
    #[inline(always)]
    pub(super) fn add_row(&mut self, y: usize, start: usize, values: &[[f32; L]]) {
        let mut x = start;
        let mut rest = values;
        while !rest.is_empty() {
            let at = x % CHUNK;
            let n = rest.len().min(CHUNK - at);
            let run = match self.places[y * self.n_across + x / CHUNK] {
                0 => self.push((x - at, y)),
                place => &mut self.runs[place as usize - 1],
            };
            for (lane, sums) in run.iter_mut().enumerate() {
                for (sum, value) in sums[at..at + n].iter_mut().zip(rest) {
                    *sum += value[lane];
                }
            }
            rest = &rest[n..];
            x += n;
        }
    }

    /// Puts the runs in the order of rows, where they are.
    pub(super) fn sort(&mut self) {
        let mut next = 0;
        for at in 0..self.places.len() {
            let Some(from) = (self.places[at] as usize).checked_sub(1) else {
                continue;
            };
            if from != next {
                self.runs.swap(from, next);
                self.starts.swap(from, next);
                let (x, y) = self.starts[from];
                self.places[y * self.n_across + x / CHUNK] = self.places[at];
            }
            next += 1;
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a frame has fewer than 2^32 runs"
            )]
            let place = next as u32;
            self.places[at] = place;
        }
    }

    /// Of each pixel this share, by its column and row; without runs of which nothing is left.
    pub(crate) fn times(&self, share: impl Fn([usize; 2]) -> f32) -> Self {
        let mut kept = Self::with_room(self.width, self.height, self.n_runs());
        for (x, y, run) in self.iter() {
            let shares: [f32; CHUNK] = std::array::from_fn(|k| share([x + k, y]));
            if shares.iter().all(|share| *share <= 0.0) {
                continue;
            }
            for (to, from) in kept.push((x, y)).iter_mut().zip(run) {
                for ((to, from), share) in to.iter_mut().zip(from).zip(shares) {
                    *to = share * from;
                }
            }
        }
        kept
    }

    /// Whether no run exists.
    pub(crate) fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// The k-th run that exists, with its first pixel and row.
    pub(crate) fn nth_mut(&mut self, k: usize) -> ((usize, usize), &mut LaneRun<L>) {
        (self.starts[k], &mut self.runs[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_come_into_the_order_of_rows_with_their_pixels() {
        let (width, height) = (4 * CHUNK, 3);
        let mut frame = LaneRuns::<2>::with_room(width, height, 0);
        let mut touched = [(2, 2), (0, 1), (3, 0), (1, 2), (0, 0), (3, 2)];
        for (number, (across, y)) in (1_u8..).zip(touched) {
            frame.add_row(y, across * CHUNK + 5, &[[f32::from(number), 0.5]; 3]);
            frame.add_row(y, across * CHUNK + 7, &[[0.0, 1.0]; 2]);
        }

        frame.sort();

        let of = |(x, y): (usize, usize)| touched.iter().position(|at| *at == (x / CHUNK, y));
        for (x, y, run) in frame.iter() {
            let number = of((x, y)).map_or(0.0, |at| at as f32 + 1.0);
            let mut expected = [[0.0; CHUNK]; 2];
            expected[0][5..8].fill(number);
            expected[1][5..9].copy_from_slice(&[0.5, 0.5, 1.5, 1.0]);
            assert_eq!(*run, expected, "run at {x}, {y}");
            assert_eq!(frame.run_at(x, y), Some(run), "found at {x}, {y}");
        }
        let order: Vec<_> = frame.iter().map(|(x, y, _)| (x / CHUNK, y)).collect();
        touched.sort_by_key(|(across, y)| (*y, *across));
        assert_eq!(order, touched, "row by row");
    }
}
