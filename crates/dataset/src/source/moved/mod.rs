//! Labels of images whose lens moves what they show.
//!
//! Coordinates are px from the upper left corner of the upright frame, in which the first pixel ends at 1. What is
//! labeled beyond the frame before is cut off first, for no image shows it; then what is moved out of the frame.

mod mask;
mod outline;

use std::collections::BTreeMap;
use std::path::Path;

use super::index::IndexFile;
use super::name::path_below;
use super::record::LabeledObject;
use crate::error::DatasetError;
use crate::image_file::readable_size;

pub(super) use mask::Mask;
pub(super) use outline::area_px2;

/// Where frames of one size show what they would show if nothing were moved, and back, px.
pub trait PlaceMap {
    /// Where that is seen which is at a place; none where it is not seen at all. It may be beyond the frame.
    fn seen_at(&self, at: [f64; 2]) -> Option<[f64; 2]>;

    /// Where that is which is seen at a place; none where nothing is seen. It may be beyond the frame.
    fn shown_at(&self, at: [f64; 2]) -> Option<[f64; 2]>;
}

/// The map of frames of a width and height, px.
pub type Motion<'m> = dyn Fn((u32, u32)) -> Box<dyn PlaceMap> + Sync + 'm;

/// Longest step between points of a border that are moved, px: between them it is straight.
const STEP_PX: f64 = 8.0;

/// Steps along each side of a box, and at most across it where points of the inside are asked for.
const STEPS: [f64; 2] = [16.0, 256.0];

/// A frame of which what it shows is moved.
pub(super) struct MovedFrame {
    size_px: [u32; 2],
    size: [f64; 2],
    map: Box<dyn PlaceMap>,
}

/// A box that was moved and cut to the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MovedBox {
    /// `x0, y0, x1, y1`, px, to a hundredth.
    pub(super) corners_px: [f64; 4],
    /// Share of its area that is left.
    pub(super) kept: f64,
}

impl MovedFrame {
    /// That of a file, of which the header alone is read.
    ///
    /// # Errors
    /// As [`readable_size`].
    pub(super) fn of_file(path: &Path, motion: &Motion<'_>) -> Result<Self, DatasetError> {
        Ok(Self::of_size(readable_size(path)?, motion))
    }

    /// That of frames of a width and height, px.
    pub(super) fn of_size(size_px: (u32, u32), motion: &Motion<'_>) -> Self {
        let sides = [size_px.0, size_px.1];
        Self {
            size_px: sides,
            size: sides.map(f64::from),
            map: motion(size_px),
        }
    }

    /// Width and height, px.
    pub(super) fn size(&self) -> [f64; 2] {
        self.size
    }

    /// Width and height, px.
    pub(super) fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// The smallest box around what a box holds; none where nothing of it is left in the frame.
    pub(super) fn box_px(&self, corners_px: [f64; 4]) -> Option<MovedBox> {
        let [x0, y0, x1, y1] = self.cut(corners_px)?;
        let mut around = Around::default();
        let [across, down] = [x1 - x0, y1 - y0].map(|side| (side / STEP_PX).ceil().max(STEPS[0]));
        let mut has_unseen = false;
        for (from, to, n) in [
            ([x0, y0], [x1, y0], across),
            ([x0, y1], [x1, y1], across),
            ([x0, y0], [x0, y1], down),
            ([x1, y0], [x1, y1], down),
        ] {
            for at in steps(from, to, n) {
                match self.map.seen_at(at) {
                    Some(at) => around.add(at),
                    None => has_unseen = true,
                }
            }
        }
        // Where the lens sees a part of it alone, that may end within.
        if has_unseen {
            let [across, down] = [across, down].map(|n| n.min(STEPS[1]));
            for at in steps([x0, y0], [x0, y1], down) {
                let row = steps(at, [x1, at[1]], across);
                row.filter_map(|at| self.map.seen_at(at))
                    .for_each(|at| around.add(at));
            }
        }
        let area = |[x0, y0, x1, y1]: [f64; 4]| (x1 - x0) * (y1 - y0);
        let whole = around.corners?;
        let cut = self.cut(whole)?;
        let corners_px = cut.map(hundredth);
        let is_left = area(corners_px) > 0.0 || area([x0, y0, x1, y1]) <= 0.0;
        is_left.then(|| MovedBox {
            corners_px,
            kept: if area(whole) > 0.0 {
                area(cut) / area(whole)
            } else {
                1.0
            },
        })
    }

    /// An object with its box moved; none where nothing of it is left.
    pub(super) fn object(&self, object: &LabeledObject) -> Option<LabeledObject> {
        Some(LabeledObject {
            box_px: self.box_px(object.box_px)?.corners_px,
            ..object.clone()
        })
    }

    /// Where a point of the frame is seen; none where it is not, or was not in the frame before.
    pub(super) fn point(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        let seen = self.is_inside(at).then(|| self.map.seen_at(at))??;
        self.is_inside(seen).then(|| seen.map(hundredth))
    }

    /// Where a point is seen, be it in the frame or beyond; what the lens does not see is taken for the nearest that it
    /// sees on the way to it from the middle of the frame.
    pub(super) fn point_anywhere(&self, at: [f64; 2]) -> [f64; 2] {
        if let Some(seen) = self.map.seen_at(at) {
            return seen;
        }
        let middle = self.size.map(|side| 0.5 * side);
        let (mut near, mut far) = (0.0, 1.0);
        for _ in 0..40 {
            let half = 0.5 * (near + far);
            match self.map.seen_at(between(middle, at, half)) {
                Some(_) => near = half,
                None => far = half,
            }
        }
        self.map
            .seen_at(between(middle, at, near))
            .unwrap_or(middle)
    }

    /// The part of a box in the frame; none where there is none.
    fn cut(&self, [x0, y0, x1, y1]: [f64; 4]) -> Option<[f64; 4]> {
        let [width, height] = self.size;
        let cut = [x0.max(0.0), y0.max(0.0), x1.min(width), y1.min(height)];
        (cut[0] <= cut[2] && cut[1] <= cut[3]).then_some(cut)
    }

    fn is_inside(&self, at: [f64; 2]) -> bool {
        (0..2).all(|k| (0.0..=self.size[k]).contains(&at[k]))
    }
}

/// The frames of the images of an index, by their rows. What frames of one size need to know is found once.
pub(super) struct Frames<'m> {
    motion: &'m Motion<'m>,
    sizes: BTreeMap<usize, (u32, u32)>,
    of_sizes: BTreeMap<(u32, u32), MovedFrame>,
}

impl<'m> Frames<'m> {
    /// Those of the rows of an index below a root that are taken and whose images have a header.
    pub(super) fn of_index(
        index: &IndexFile,
        root: &Path,
        is_taken: &mut dyn FnMut(&str) -> bool,
        motion: &'m Motion<'m>,
    ) -> Self {
        let sized = index.kept_rows(is_taken).filter_map(|k| {
            let size_px = readable_size(&path_below(root, &index.rows[k].name)).ok()?;
            Some((k, size_px))
        });
        Self {
            motion,
            sizes: sized.collect(),
            of_sizes: BTreeMap::new(),
        }
    }

    /// Whether there is a frame of a row.
    pub(super) fn has(&self, row: usize) -> bool {
        self.sizes.contains_key(&row)
    }

    /// The frame of a row.
    pub(super) fn of_row(&mut self, row: usize) -> Option<&MovedFrame> {
        let size_px = *self.sizes.get(&row)?;
        let frame = self.of_sizes.entry(size_px);
        Some(frame.or_insert_with(|| MovedFrame::of_size(size_px, self.motion)))
    }
}

/// The smallest box around points.
#[derive(Default)]
struct Around {
    corners: Option<[f64; 4]>,
}

impl Around {
    fn add(&mut self, [x, y]: [f64; 2]) {
        let [x0, y0, x1, y1] = self.corners.unwrap_or([x, y, x, y]);
        self.corners = Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)]);
    }
}

/// The smallest box around points; none of no points.
pub(super) fn box_around(points: &[[f64; 2]]) -> Option<[f64; 4]> {
    let mut around = Around::default();
    points.iter().for_each(|at| around.add(*at));
    around.corners
}

/// Points on a straight way, both ends with them.
fn steps(from: [f64; 2], to: [f64; 2], n: f64) -> impl Iterator<Item = [f64; 2]> {
    let n = n.max(1.0);
    let next = |k: &f64| Some(k + 1.0);
    std::iter::successors(Some(0.0), next)
        .take_while(move |k| *k <= n)
        .map(move |k| between(from, to, k / n))
}

fn between(from: [f64; 2], to: [f64; 2], share: f64) -> [f64; 2] {
    [0, 1].map(|k| from[k] + share * (to[k] - from[k]))
}

/// To a hundredth of a px, as labels are written.
pub(super) fn hundredth(value: f64) -> f64 {
    // Not -0.
    (value * 100.0).round() / 100.0 + 0.0
}

#[cfg(test)]
mod tests;
