//! The light of a packed layer, row by row, as its pixels ask for their neighbors.

use super::runs::RunReader;
use super::values::light_pixels;
use crate::OpticsError;
use crate::maps::{CHUNK, LaneRun};
use crate::physical::BakedRun;
use crate::surface::LANES;

/// A row of a layer's light and the row below it; no more of the layer is in memory.
pub(super) struct LightRows<'a> {
    reader: RunReader<'a, LANES>,
    row: Row,
    below: Row,
}

/// The runs of a row that exist.
#[derive(Default)]
struct Row {
    y: usize,
    /// First pixel of each.
    xs: Vec<usize>,
    runs: Vec<LaneRun<LANES>>,
}

impl<'a> LightRows<'a> {
    pub(super) fn new(reader: RunReader<'a, LANES>) -> Self {
        Self {
            reader,
            row: Row::default(),
            below: Row::default(),
        }
    }

    /// Number of runs that have not been read yet.
    pub(super) fn n_left(&self) -> usize {
        self.reader.n_left()
    }

    /// Goes on to the next row that has a run; false where there is none.
    pub(super) fn advance(&mut self) -> Result<bool, OpticsError> {
        std::mem::swap(&mut self.row, &mut self.below);
        if self.row.xs.is_empty() {
            self.row.read(&mut self.reader)?;
        }
        let below = self.row.y + 1;
        self.below.xs.clear();
        self.below.runs.clear();
        if self.reader.at().is_some_and(|(_, y)| y == below) {
            self.below.read(&mut self.reader)?;
        }
        Ok(!self.row.xs.is_empty())
    }

    /// The runs of the row, as yet without a tint.
    pub(super) fn runs(&self) -> impl Iterator<Item = BakedRun<'_>> {
        let mut next_below = 0;
        let runs = self.row.xs.iter().zip(&self.row.runs).enumerate();
        runs.map(move |(k, (&x, lanes))| {
            while self
                .below
                .xs
                .get(next_below)
                .is_some_and(|below| *below < x)
            {
                next_below += 1;
            }
            BakedRun {
                at: (x, self.row.y),
                lanes,
                tint: None,
                right: self.row.run_at(k + 1, x + CHUNK),
                below: self.below.run_at(next_below, x),
            }
        })
    }
}

impl Row {
    /// Reads the runs of the row that comes next; none after the last one.
    fn read(&mut self, reader: &mut RunReader<'_, LANES>) -> Result<(), OpticsError> {
        self.xs.clear();
        self.runs.clear();
        let y = reader.at().map(|(_, y)| y);
        while let Some(run) = reader.next()? {
            self.xs.push(run.at.0);
            self.y = run.at.1;
            light_pixels(&run, self.runs.push_mut([[0.0; CHUNK]; LANES]));
            if reader.at().map(|(_, y)| y) != y {
                break;
            }
        }
        Ok(())
    }

    /// The k-th run, if it is the one that begins at `x`.
    fn run_at(&self, k: usize, x: usize) -> Option<&LaneRun<LANES>> {
        (self.xs.get(k) == Some(&x)).then(|| &self.runs[k])
    }
}
