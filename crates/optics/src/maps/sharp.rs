//! Facets in focus: coverage of the pixels themselves.

use super::placed::placed;
use super::raster::{Edge, cover_row};

/// Calls `row(y, x, shares)` for each row that the outlines of convex facets cover, with the part
/// of it from the first to the last covered pixel. Where facets overlap their shares are summed.
pub(crate) fn cover(
    outlines: &[[[f64; 2]; 4]],
    (width, height): (usize, usize),
    mut row: impl FnMut(usize, usize, &[f32]),
) {
    let waiting = placed(outlines.iter().copied(), 1.0, 0, (width, height));
    let mut waiting = waiting.iter().peekable();
    // The row after the last one of a facet, and its sides.
    let mut active: Vec<(usize, Vec<Edge>)> = Vec::new();
    let mut scratch = vec![0.0; width + 3];
    let mut areas = Vec::new();
    let mut shares = vec![0.0_f32; width];
    for y in 0..height {
        while let Some(placed) = waiting.next_if(|placed| placed.first <= y) {
            active.push((placed.last, placed.polygon.edges().collect()));
        }
        active.retain(|(last, _)| *last > y);
        let [mut first, mut end] = [width, 0];
        for (_, edges) in &active {
            areas.clear();
            let Some(x) = cover_row(edges, y, &mut scratch, &mut areas) else {
                continue;
            };
            for (share, area) in shares.iter_mut().skip(x).zip(&areas) {
                *share += area;
            }
            if x < width {
                first = first.min(x);
                end = end.max((x + areas.len()).min(width));
            }
        }
        if first < end {
            let covered = &mut shares[first..end];
            row(y, first, covered);
            covered.fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_areas_and_those_of_overlapping_facets_are_summed() {
        let one = [[1.25, 0.5], [4.75, 0.5], [4.75, 2.0], [1.25, 2.0]];
        let beyond = [[7.0, 1.0], [30.0, 1.0], [30.0, 30.0], [7.0, 30.0]];
        let mut rows = Vec::new();
        cover(&[one, beyond, one], (8, 3), |y, x, shares| {
            rows.push((y, x, shares.to_vec()));
        });
        let expected = [
            (0, 1, vec![0.75, 1.0, 1.0, 0.75]),
            (1, 1, vec![1.5, 2.0, 2.0, 1.5, 0.0, 0.0, 1.0]),
            (2, 7, vec![1.0]),
        ];
        assert_eq!(rows.len(), expected.len(), "{rows:?}");
        for ((y, x, shares), (y_expected, x_expected, of)) in rows.iter().zip(&expected) {
            assert_eq!((y, x), (y_expected, x_expected), "{rows:?}");
            let covered = shares.iter().zip(of.iter().chain(std::iter::repeat(&0.0)));
            for (share, expected) in covered {
                assert!((share - expected).abs() < 1e-6, "row {y}: {shares:?}");
            }
        }
    }
}
