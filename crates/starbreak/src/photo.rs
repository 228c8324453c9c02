//! Photographs of broken glass in the place of simulated cracks.
//!
//! The paper's arm of real overlays: 65 photographs, expanded to 10 000 by random shifts, flips
//! and crops, and composited by the same optics as simulated cracks. Here a photograph and a
//! [`Placement`] stand for each of the 10 000, so that a few numbers make any of them again.

use std::sync::Arc;

use serde_json::{Value, json};
use starbreak_optics::photo::{Photo, PhotoParams, Placement, PlacementRange, check_gain};
use starbreak_seed::Seed;

use crate::Error;

/// A photograph of broken glass, and which file.
#[derive(Debug, Clone, PartialEq)]
pub struct GlassPhoto {
    /// The photograph.
    pub photo: Photo,
    /// Name of the file, without its folder; in a set its path inside the set.
    pub name: String,
    /// BLAKE3 of the bytes of the file, hexadecimal.
    pub blake3: String,
}

/// How photographs of broken glass are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverlayOptions {
    /// How they are read.
    pub params: PhotoParams,
    /// Light of their white over what a white sheet in the place of the glass would show, 0 to
    /// 1000; the paper's optics have their own light. **Default**: 1.
    pub gain: f64,
    /// What a random part is drawn from; none takes the largest part, in the middle, as it is.
    /// **Default**: none.
    pub random: Option<PlacementRange>,
}

impl Default for OverlayOptions {
    fn default() -> Self {
        Self {
            params: PhotoParams::default(),
            gain: 1.0,
            random: None,
        }
    }
}

/// A photograph of broken glass with the part of it that fills a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedPhoto {
    /// The photograph.
    pub glass: Arc<GlassPhoto>,
    /// The part.
    pub placement: Placement,
    /// How it is used; the placement stands for what is random.
    pub options: OverlayOptions,
}

impl OverlayOptions {
    /// Every option is in its range.
    ///
    /// # Errors
    /// [`Error::Optics`] naming the first that is not.
    pub fn check(&self) -> Result<(), Error> {
        self.params.check()?;
        if let Some(range) = &self.random {
            range.check()?;
        }
        Ok(check_gain(self.gain)?)
    }
}

impl GlassPhoto {
    /// The part of it that fills a frame of this size: by the seed if it is to be random.
    ///
    /// # Errors
    /// [`Error::Optics`] for a range that makes no sense.
    pub fn place(
        self: &Arc<Self>,
        frame: (u32, u32),
        options: &OverlayOptions,
        seed: Seed,
    ) -> Result<PlacedPhoto, Error> {
        let size = self.photo.size();
        let placement = match &options.random {
            Some(range) => Placement::random(size, frame, range, seed)?,
            None => Placement::cover(size, frame),
        };
        Ok(PlacedPhoto {
            glass: Arc::clone(self),
            placement,
            options: *options,
        })
    }
}

impl PlacedPhoto {
    /// What a record says of it: file, background, gain, and the part, from which it can be made
    /// again.
    #[must_use]
    pub fn facts(&self) -> Value {
        let place = &self.placement;
        json!({
            "name": self.glass.name,
            "blake3": self.glass.blake3,
            "background": self.glass.photo.background().name(),
            "size_px": self.glass.photo.size(),
            "floor": self.options.params.floor,
            "gain": self.options.gain,
            "placement": {
                "left_px": place.left_px,
                "top_px": place.top_px,
                "width_px": place.width_px,
                "height_px": place.height_px,
                "flip_horizontal": place.flip_horizontal,
                "flip_vertical": place.flip_vertical,
            },
        })
    }
}
