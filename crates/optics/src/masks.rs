//! What a render tells an evaluation about its pixels.

use image::GrayImage;

/// Where a render changed the image, and where the cracks are.
#[derive(Debug, Clone, PartialEq)]
pub struct Masks {
    /// 255 where the crack influences the image, 0 elsewhere: in the `paper` tier every pixel
    /// that may differ from the input, in the `physical` tier every pixel that it influences by
    /// at least the threshold.
    pub region: GrayImage,
    /// Coverage by cracks as they would be in focus, 255 = in full.
    pub crack: GrayImage,
}
