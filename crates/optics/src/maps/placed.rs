//! Where facets lie among the cells of a frame.

use super::layer::Facet;
use super::raster::Polygon;

/// A facet in cells: the rows from `first` to before `last`.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    pub(super) polygon: Polygon,
    pub(super) first: usize,
    pub(super) last: usize,
    pub(super) facet: usize,
}

/// The facets that reach the grid, by the rows in which they begin.
#[expect(clippy::cast_precision_loss, reason = "cells of a grid")]
pub(super) fn placed(
    outlines: impl ExactSizeIterator<Item = [[f64; 2]; 4]>,
    scale: f64,
    margin: usize,
    (columns, rows): (usize, usize),
) -> Vec<Placed> {
    let mut all: Vec<Placed> = Vec::with_capacity(outlines.len());
    for (k, corners) in outlines.enumerate() {
        let corners =
            corners.map(|corner| corner.map(|coordinate| coordinate * scale + margin as f64));
        let polygon = Polygon::new(&corners).within(columns as f64);
        let [top, bottom] = polygon.span(1);
        if !(top < rows as f64 && bottom > 0.0) {
            continue;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "rows of the grid"
        )]
        let (first, last) = (
            top.max(0.0) as usize,
            bottom.min(rows as f64).ceil() as usize,
        );
        all.push(Placed {
            polygon,
            first,
            last,
            facet: k,
        });
    }
    // Facets of one row keep their order.
    let mut order: Vec<(usize, usize)> = all.iter().map(|placed| placed.first).zip(0..).collect();
    order.sort_unstable();
    order.into_iter().map(|(_, k)| all[k]).collect()
}

/// From which column to before which some facets may cover cells.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "columns of a grid"
)]
pub(super) fn columns_of<const L: usize>(
    facets: &[&Facet<L>],
    scale: f64,
    (margin, columns): (usize, usize),
) -> [usize; 2] {
    let places = facets.iter().flat_map(|facet| facet.corners);
    let [low, high] = places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [x, _]| {
        [low.min(x), high.max(x)]
    });
    // Coverage is shared with cells beside.
    let column = |x: f64, by: f64| (x * scale + margin as f64 + by).max(0.0) as usize;
    let end = column(high, 4.0).min(columns);
    [column(low, -2.0).min(end), end]
}
