//! A frame of which only touched runs of pixels exist, lane by lane.

use super::chunks::{CHUNK, Chunks};

/// [`CHUNK`] pixels of a row, all of one lane before those of the next.
pub(crate) type LaneRun<const L: usize> = [[f32; CHUNK]; L];

/// As [`Chunks`], for reading: the pixels of a lane lie side by side, so that the same is done to
/// several of them at once, and the runs lie in the order of rows.
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

    /// A further run of zeros, beyond the last one in the order of rows: its first pixel and row.
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

    /// The runs of some chunks.
    ///
    /// `finish` is called for each run by its number, in order, once the row below it is there and
    /// none after that: while it is at hand.
    pub(crate) fn of_chunks(chunks: &Chunks<L>, mut finish: impl FnMut(&mut Self, usize)) -> Self {
        let (width, height) = chunks.size();
        let mut runs = Self::with_room(width, height, chunks.n_runs());
        let mut n_finished = 0;
        for (x, y, pixels) in chunks.iter() {
            while runs
                .starts
                .get(n_finished)
                .is_some_and(|start| start.1 + 1 < y)
            {
                finish(&mut runs, n_finished);
                n_finished += 1;
            }
            for (lane, values) in runs.push((x, y)).iter_mut().enumerate() {
                *values = std::array::from_fn(|k| pixels[k][lane]);
            }
        }
        for k in n_finished..runs.n_runs() {
            finish(&mut runs, k);
        }
        runs
    }

    /// The k-th run that exists, with its first pixel and row.
    pub(crate) fn nth_mut(&mut self, k: usize) -> ((usize, usize), &mut LaneRun<L>) {
        (self.starts[k], &mut self.runs[k])
    }
}
