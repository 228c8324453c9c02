//! Boxes and how much they overlap.

use serde::{Deserialize, Serialize};

/// A box with its sides along the image, in pixels; the first pixel's center is at (0.5, 0.5).
///
/// Kept as corner and sides, the form of MS-COCO, so that its numbers pass through unrounded.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BoxPx {
    /// Left side.
    pub x: f64,
    /// Upper side.
    pub y: f64,
    /// From left to right.
    pub width: f64,
    /// From top to bottom.
    pub height: f64,
}

/// The farthest from 0 that a number of a box is believed, px.
const MOST_PX: f64 = 1e9;

impl BoxPx {
    /// The box between two corners.
    #[must_use]
    pub fn from_corners([x0, y0, x1, y1]: [f64; 4]) -> Self {
        Self {
            x: x0,
            y: y0,
            width: x1 - x0,
            height: y1 - y0,
        }
    }

    /// The box of MS-COCO's `x, y, width, height`.
    pub(crate) fn from_bbox([x, y, width, height]: [f64; 4]) -> Self {
        Self {
            x,
            y,
            width,
            height,
        }
    }

    /// `x0, y0, x1, y1`.
    #[must_use]
    pub fn corners(&self) -> [f64; 4] {
        [self.x, self.y, self.x + self.width, self.y + self.height]
    }

    /// Whether no side is negative and all its numbers lie within a thousand million pixels of 0: areas of
    /// wilder ones end in infinity, and overlaps in no number.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let numbers = [self.x, self.y, self.width, self.height];
        numbers.iter().all(|number| number.abs() <= MOST_PX)
            && self.width >= 0.0
            && self.height >= 0.0
    }

    /// Width times height, px².
    #[must_use]
    pub fn area_px2(&self) -> f64 {
        self.width * self.height
    }

    /// Area of what both cover, px²: 0 where they only touch or have no area.
    #[must_use]
    pub(crate) fn intersection_px2(&self, other: &Self) -> f64 {
        let [ax0, ay0, ax1, ay1] = self.corners();
        let [bx0, by0, bx1, by1] = other.corners();
        let width = ax1.min(bx1) - ax0.max(bx0);
        let height = ay1.min(by1) - ay0.max(by0);
        if width <= 0.0 || height <= 0.0 {
            return 0.0;
        }
        width * height
    }

    /// Intersection over union, 0 to 1, as `bbIou` of the COCO API has it: 0 for boxes without
    /// area, never NaN.
    #[must_use]
    pub fn iou(&self, other: &Self) -> f64 {
        let intersection = self.intersection_px2(other);
        if intersection <= 0.0 {
            return 0.0;
        }
        intersection / (self.area_px2() + other.area_px2() - intersection)
    }
}

#[cfg(test)]
mod tests {
    use super::BoxPx;

    #[test]
    fn halves_of_a_square_overlap_by_a_third() {
        let a = BoxPx::from_corners([0.0, 0.0, 10.0, 10.0]);
        let b = BoxPx::from_corners([5.0, 0.0, 15.0, 10.0]);
        assert!((a.iou(&b) - 1.0 / 3.0).abs() < 1e-15, "50 of 150");
        let flat = BoxPx::from_corners([0.0, 0.0, 0.0, 10.0]);
        assert!(flat.iou(&flat).abs() < 1e-15, "no area, no overlap");
    }
}
