//! A set of pixels as rows of bits.

/// The places of the bits that are set, the lowest first.
#[inline(always)]
pub(crate) fn set_bits(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        lowest
    })
}

/// One bit per pixel, row by row, each row starting a new word.
#[derive(Debug, Clone)]
pub(crate) struct BitRows {
    words: Vec<u64>,
    words_per_row: usize,
    width: usize,
    height: usize,
}

impl BitRows {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let words_per_row = width.div_ceil(64);
        Self {
            words: vec![0; words_per_row * height],
            words_per_row,
            width,
            height,
        }
    }

    /// Every pixel of the frame.
    pub(crate) fn full(width: usize, height: usize) -> Self {
        let mut rows = Self::new(width, height);
        rows.words.fill(u64::MAX);
        rows.clear_beyond_width();
        rows
    }

    pub(crate) fn unset(&mut self, x: usize, y: usize) {
        self.words[y * self.words_per_row + x / 64] &= !(1 << (x % 64));
    }

    /// The pixels of a row in ascending order.
    pub(crate) fn ones(&self, y: usize) -> impl Iterator<Item = usize> + '_ {
        self.ones_within(y, 0, self.width)
    }

    /// The pixels of a row in columns `start..end`, in ascending order.
    pub(crate) fn ones_within(
        &self,
        y: usize,
        start: usize,
        end: usize,
    ) -> impl Iterator<Item = usize> + '_ {
        let words = &self.row(y)[start / 64..end.div_ceil(64)];
        let of_word = move |(k, &word): (usize, &u64)| {
            let base = (start / 64 + k) * 64;
            set_bits(word).map(move |bit| base + bit)
        };
        words
            .iter()
            .enumerate()
            .flat_map(of_word)
            .filter(move |x| (start..end).contains(x))
    }

    /// The runs `[start, end)` of neighboring pixels of a row, in ascending order.
    pub(crate) fn runs(&self, y: usize) -> Vec<(usize, usize)> {
        let mut runs: Vec<(usize, usize)> = Vec::new();
        for (k, &word) in self.row(y).iter().enumerate() {
            let (mut rest, mut base) = (word, k * 64);
            while rest != 0 {
                let zeros = rest.trailing_zeros() as usize;
                let ones = (rest >> zeros).trailing_ones() as usize;
                let start = base + zeros;
                match runs.last_mut() {
                    Some(last) if last.1 == start => last.1 = start + ones,
                    _ => runs.push((start, start + ones)),
                }
                base = start + ones;
                rest = rest
                    .checked_shr(u32::try_from(zeros + ones).unwrap_or(64))
                    .unwrap_or(0);
            }
        }
        runs
    }

    /// Every pixel within `radius` rows and `radius` columns of a pixel of this set (a square
    /// structuring element).
    pub(crate) fn dilated(&self, radius: usize) -> Self {
        self.dilated_along_rows(radius).dilated_across_rows(radius)
    }

    /// Every pixel within `radius` rows of a pixel of this set, in its own column.
    pub(crate) fn dilated_across_rows(&self, radius: usize) -> Self {
        let mut out = Self::new(self.width, self.height);
        let n = self.words_per_row;
        for y in 0..self.height {
            if self.row(y).iter().all(|word| *word == 0) {
                continue;
            }
            for other in y.saturating_sub(radius)..=(y + radius).min(self.height - 1) {
                for (to, from) in out.words[other * n..(other + 1) * n]
                    .iter_mut()
                    .zip(self.row(y))
                {
                    *to |= from;
                }
            }
        }
        out
    }

    fn dilated_along_rows(&self, radius: usize) -> Self {
        let mut out = Self::new(self.width, self.height);
        for y in 0..self.height {
            for (start, end) in self.runs(y) {
                out.set_run(
                    y,
                    start.saturating_sub(radius),
                    (end + radius).min(self.width),
                );
            }
        }
        out
    }

    /// Pixels `start..end` of a row, at least one.
    pub(crate) fn set_run(&mut self, y: usize, start: usize, end: usize) {
        let row = &mut self.words[y * self.words_per_row..(y + 1) * self.words_per_row];
        let (first, last) = (start / 64, (end - 1) / 64);
        for (k, word) in row.iter_mut().enumerate().take(last + 1).skip(first) {
            let low = start.saturating_sub(k * 64);
            let high = (end - k * 64).min(64);
            *word |= (u64::MAX >> (64 - (high - low))) << low;
        }
    }

    fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.words_per_row..(y + 1) * self.words_per_row]
    }

    fn clear_beyond_width(&mut self) {
        let used = self.width % 64;
        if used == 0 {
            return;
        }
        for y in 0..self.height {
            self.words[(y + 1) * self.words_per_row - 1] &= u64::MAX >> (64 - used);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dilation_is_the_square_neighborhood() {
        for (width, height) in [(1, 1), (63, 5), (64, 4), (65, 9), (200, 30)] {
            let mut set = BitRows::new(width, height);
            let chosen = [
                (0, 0),
                (width - 1, height - 1),
                (width / 2, height / 2),
                (width / 3, 0),
            ];
            for (x, y) in chosen {
                set.set_run(y, x, x + 1);
            }
            for radius in [0, 1, 7, 70] {
                let dilated = set.dilated(radius);
                for y in 0..height {
                    let expected: Vec<usize> = (0..width)
                        .filter(|&x| {
                            chosen.iter().any(|&(cx, cy)| {
                                cx.abs_diff(x) <= radius && cy.abs_diff(y) <= radius
                            })
                        })
                        .collect();
                    assert_eq!(
                        dilated.ones(y).collect::<Vec<_>>(),
                        expected,
                        "{width}×{height}, radius {radius}"
                    );
                    let from_runs: Vec<usize> = dilated
                        .runs(y)
                        .into_iter()
                        .flat_map(|(a, b)| a..b)
                        .collect();
                    assert_eq!(from_runs, expected, "runs hold the same pixels");
                }
            }
        }
    }

    #[test]
    fn full_ends_at_the_width() {
        let full = BitRows::full(70, 2);
        assert_eq!(full.runs(1), vec![(0, 70)], "no bit beyond the frame");
    }
}
