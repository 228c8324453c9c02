//! Where in a row there is anything.

use std::ops::Range;

/// Shorter gaps are not worth a run of their own.
const SHORT_GAP: usize = 16;

/// Runs of a row, in ascending order, outside of which all is 0; short gaps are taken along.
pub(crate) fn lit_runs<const L: usize>(row: &[[f32; L]]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (at, lanes) in row.iter().enumerate() {
        if lanes.iter().any(|lane| lane.abs() > 0.0) {
            match runs.last_mut() {
                Some(run) if at < run.end + SHORT_GAP => run.end = at + 1,
                _ => runs.push(at..at + 1),
            }
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_is_lit_lies_in_a_run_and_long_gaps_in_none() {
        let mut row = vec![[0.0_f32; 2]; 100];
        for at in [0, 3, 40, 41, 60, 99] {
            row[at][at % 2] = -1.0;
        }
        assert_eq!(lit_runs(&row), [0..4, 40..42, 60..61, 99..100], "runs");
        row[50][0] = 1e-30;
        assert_eq!(lit_runs(&row), [0..4, 40..61, 99..100], "short gaps");
        assert_eq!(lit_runs(&[[0.0_f32; 3]; 9]), [], "nothing");
    }
}
