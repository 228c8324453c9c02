//! Where an image lies in the frame that a model sees.

use crate::contract::{Resize, Rounding};

/// How an image lies in the frame that a model sees, px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Width of the frame.
    pub frame_width_px: u32,
    /// Height of the frame.
    pub frame_height_px: u32,
    /// Width of the image in it.
    pub width_px: u32,
    /// Height of the image in it.
    pub height_px: u32,
    /// Columns left of the image.
    pub left_px: u32,
    /// Rows above the image.
    pub top_px: u32,
    /// Pixels of the frame per pixel of the image, along x and y: what the reference divides boxes
    /// by, which need not be the exact quotient of the sides.
    pub gain: [f64; 2],
    /// What the reference takes off boxes first, px.
    pub offset_px: [f64; 2],
}

/// The placement of an image of a size; `frame` is the model's where it is fixed.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "sides of at most 65536 px: sizes come from images and checked contracts"
)]
pub(crate) fn place(resize: Resize, [width, height]: [u32; 2], frame: [u32; 2]) -> Placement {
    let (w, h) = (f64::from(width), f64::from(height));
    let [frame_width, frame_height] = frame;
    let (fw, fh) = (f64::from(frame_width), f64::from(frame_height));
    match resize {
        Resize::Keep => Placement {
            frame_width_px: width,
            frame_height_px: height,
            width_px: width,
            height_px: height,
            left_px: 0,
            top_px: 0,
            gain: [1.0, 1.0],
            offset_px: [0.0, 0.0],
        },
        Resize::Stretch => Placement {
            frame_width_px: frame_width,
            frame_height_px: frame_height,
            width_px: frame_width,
            height_px: frame_height,
            left_px: 0,
            top_px: 0,
            gain: [fw / w, fh / h],
            offset_px: [0.0, 0.0],
        },
        Resize::Letterbox {
            is_centered,
            rounding,
        } => {
            let gain = (fw / w).min(fh / h);
            let scaled = |side: f64, most: u32| {
                let side = match rounding {
                    Rounding::HalfToEven => (side * gain).round_ties_even(),
                    Rounding::Down => (side * gain).floor(),
                };
                (side as u32).clamp(1, most)
            };
            let (new_w, new_h) = (scaled(w, frame_width), scaled(h, frame_height));
            // Python's `round(d - 0.1)`, of half the space that is left.
            let before = |most: u32, side: u32| {
                if is_centered {
                    (f64::from(most - side) / 2.0 - 0.1).round_ties_even()
                } else {
                    0.0
                }
            };
            let (left, top) = (before(frame_width, new_w), before(frame_height, new_h));
            Placement {
                frame_width_px: frame_width,
                frame_height_px: frame_height,
                width_px: new_w,
                height_px: new_h,
                left_px: left as u32,
                top_px: top as u32,
                gain: [gain, gain],
                offset_px: [left, top],
            }
        }
        Resize::ShortestSide {
            min_side_px,
            max_side_px,
            pad_multiple_px,
        } => {
            let short = f64::from(min_side_px) / w.min(h);
            let long = f64::from(max_side_px) / w.max(h);
            let gain = short.min(long);
            let scaled = |side: f64| ((side * gain + 0.5) as u32).max(1);
            let (new_w, new_h) = (scaled(w), scaled(h));
            let padded = |side: u32| side.div_ceil(pad_multiple_px.max(1)) * pad_multiple_px.max(1);
            Placement {
                frame_width_px: padded(new_w),
                frame_height_px: padded(new_h),
                width_px: new_w,
                height_px: new_h,
                left_px: 0,
                top_px: 0,
                gain: [f64::from(new_w) / w, f64::from(new_h) / h],
                offset_px: [0.0, 0.0],
            }
        }
    }
}

impl Placement {
    /// A point of the frame as a point of the image, px.
    #[must_use]
    pub fn to_image(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            (x - self.offset_px[0]) / self.gain[0],
            (y - self.offset_px[1]) / self.gain[1],
        ]
    }
}
