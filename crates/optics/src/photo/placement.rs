//! Which part of a photograph fills the frame.

use starbreak_seed::{Seed, Stream, uniform};

use crate::OpticsError;

/// The part of a photograph that fills the frame, and how it is turned over.
///
/// The rectangle is in px of the photograph from its top left corner; what of it lies beyond the
/// photograph is unbroken glass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Left side of the rectangle, px of the photograph.
    pub left_px: f64,
    /// Upper side, px of the photograph.
    pub top_px: f64,
    /// Width, px of the photograph, more than 0.
    pub width_px: f64,
    /// Height, px of the photograph, more than 0.
    pub height_px: f64,
    /// Left and right are exchanged.
    pub flip_horizontal: bool,
    /// Above and below are exchanged.
    pub flip_vertical: bool,
}

/// What [`Placement::random`] draws from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacementRange {
    /// Least side of the part over that of the largest part of the frame's shape, 0.05 to 1: 1
    /// takes the largest always. **Default**: 0.6. FIT: of a square photograph in a frame of
    /// KITTI's shape it is a magnification of 1 to 1.7.
    pub min_scale: f64,
    /// How far the part may reach beyond the photograph, over its own side, 0 to 1: there the
    /// glass is unbroken. **Default**: 0.1. FIT.
    pub max_shift: f64,
}

impl Default for PlacementRange {
    fn default() -> Self {
        Self {
            min_scale: 0.6,
            max_shift: 0.1,
        }
    }
}

impl PlacementRange {
    /// Every parameter is in its range.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), OpticsError> {
        OpticsError::check_ranges(&[
            ("overlay_min_scale", self.min_scale, 0.05, 1.0),
            ("overlay_max_shift", self.max_shift, 0.0, 1.0),
        ])
    }
}

/// Largest coordinate of a placement, px: beyond any photograph.
const FARTHEST_PX: f64 = 1e6;

impl Placement {
    /// The largest part of the frame's shape, in the middle of the photograph.
    #[must_use]
    pub fn cover(photo: (u32, u32), frame: (u32, u32)) -> Self {
        let ([photo_width, photo_height], [width, height]) = (sides(photo), sides(frame));
        let px_per_px = (photo_width / width).min(photo_height / height);
        let (width_px, height_px) = (width * px_per_px, height * px_per_px);
        Self {
            left_px: 0.5 * (photo_width - width_px),
            top_px: 0.5 * (photo_height - height_px),
            width_px,
            height_px,
            flip_horizontal: false,
            flip_vertical: false,
        }
    }

    /// A random part of the frame's shape, and random flips: the scale is uniform from
    /// `min_scale` to 1, the place uniform over all where the part reaches beyond the photograph
    /// by no more than `max_shift` of its side, each flip as likely as not. All from the stream
    /// [`Stream::OverlayPlacement`] of the seed.
    ///
    /// # Errors
    /// As for [`PlacementRange::check`].
    ///
    /// # Limits
    /// A part of a photograph may show little of the crack in it, or none.
    pub fn random(
        photo: (u32, u32),
        frame: (u32, u32),
        range: &PlacementRange,
        seed: Seed,
    ) -> Result<Self, OpticsError> {
        range.check()?;
        let mut rng = seed.stream(Stream::OverlayPlacement, 0);
        let largest = Self::cover(photo, frame);
        let scale = range.min_scale + (1.0 - range.min_scale) * uniform(&mut rng);
        let (width_px, height_px) = (largest.width_px * scale, largest.height_px * scale);
        let [photo_width, photo_height] = sides(photo);
        let mut place = |photo_px: f64, part_px: f64| {
            let beyond = range.max_shift * part_px;
            -beyond + (photo_px - part_px + 2.0 * beyond) * uniform(&mut rng)
        };
        let (left_px, top_px) = (place(photo_width, width_px), place(photo_height, height_px));
        Ok(Self {
            left_px,
            top_px,
            width_px,
            height_px,
            flip_horizontal: uniform(&mut rng) < 0.5,
            flip_vertical: uniform(&mut rng) < 0.5,
        })
    }

    /// Every measure is a length that a photograph may have.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] naming the first that is not.
    pub fn check(&self) -> Result<(), OpticsError> {
        OpticsError::check_ranges(&[
            ("overlay left_px", self.left_px, -FARTHEST_PX, FARTHEST_PX),
            ("overlay top_px", self.top_px, -FARTHEST_PX, FARTHEST_PX),
            ("overlay width_px", self.width_px, 1e-3, FARTHEST_PX),
            ("overlay height_px", self.height_px, 1e-3, FARTHEST_PX),
        ])
    }
}

/// Width and height, at least 1.
fn sides((width, height): (u32, u32)) -> [f64; 2] {
    [width, height].map(|side| f64::from(side.max(1)))
}
