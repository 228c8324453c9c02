//! A frame of which only touched runs of pixels exist.

use super::layer::add_arrays;

/// Pixels in a run.
pub(crate) const CHUNK: usize = 32;

/// A frame of `L` lanes per pixel, kept in runs of [`CHUNK`] pixels of a row; a run that nothing
/// touched takes four bytes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chunks<const L: usize> {
    width: usize,
    height: usize,
    n_across: usize,
    /// Place of each run in `runs`, plus one; 0 where it does not exist.
    places: Vec<u32>,
    runs: Vec<[[f32; L]; CHUNK]>,
}

impl<const L: usize> Chunks<L> {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let n_across = width.div_ceil(CHUNK);
        Self {
            width,
            height,
            n_across,
            places: vec![0; n_across * height],
            // Room that is not used is not touched either.
            runs: Vec::with_capacity(n_across * height / 8),
        }
    }

    pub(crate) fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Number of runs that exist.
    pub(crate) fn n_runs(&self) -> usize {
        self.runs.len()
    }

    /// Adds to a row of pixels.
    #[inline(always)]
    pub(crate) fn add_row(&mut self, y: usize, start: usize, values: &[[f32; L]]) {
        let mut x = start;
        let mut rest = values;
        while !rest.is_empty() {
            let (across, at) = (x / CHUNK, x % CHUNK);
            let n = rest.len().min(CHUNK - at);
            let run = self.run_mut(across, y);
            for (cell, value) in run[at..at + n].iter_mut().zip(rest) {
                *cell = add_arrays(*cell, *value);
            }
            rest = &rest[n..];
            x += n;
        }
    }

    #[inline(always)]
    fn run_mut(&mut self, across: usize, y: usize) -> &mut [[f32; L]; CHUNK] {
        let place = &mut self.places[y * self.n_across + across];
        if *place == 0 {
            self.runs.push([[0.0; L]; CHUNK]);
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a frame has fewer than 2^32 runs"
            )]
            let n = self.runs.len() as u32;
            *place = n;
        }
        &mut self.runs[*place as usize - 1]
    }

    /// The runs that exist, row by row: first pixel, row, pixels. The last run of a row may
    /// reach beyond the frame.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, usize, &[[f32; L]; CHUNK])> {
        self.places
            .iter()
            .enumerate()
            .filter(|(_, place)| **place > 0)
            .map(|(k, place)| {
                (
                    k % self.n_across * CHUNK,
                    k / self.n_across,
                    &self.runs[*place as usize - 1],
                )
            })
    }

    /// The run that holds a pixel, if it exists.
    #[cfg(test)]
    pub(crate) fn run_at(&self, x: usize, y: usize) -> Option<&[[f32; L]; CHUNK]> {
        let place = self.places[y * self.n_across + x / CHUNK] as usize;
        (place > 0).then(|| &self.runs[place - 1])
    }
}
