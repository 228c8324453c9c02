//! Masks and figures of all frames at one stage of the growth.

use std::sync::Arc;

use image::metadata::Orientation;
use image::{ColorType, GrayImage};
use starbreak::sensor::Moment;
use starbreak::{Lit, PaneLayer, region_fraction};
use starbreak_dataset::{ImageFile, encode_mask, encode_mask_as};

use crate::Error;

/// Masks and figures of all frames at one stage of the growth.
#[derive(Debug)]
pub(super) struct StageFacts {
    /// Share of the frame that the damage affects.
    pub(super) region_fraction: f64,
    /// Length of the cracks inside the frame, px; none where a photograph is shown.
    pub(super) crack_length_px: Option<f64>,
    /// Region and crack mask, if asked for.
    pub(super) masks: Option<[Arc<StageMask>; 2]>,
    /// Where the glass affects the frame, if a camera's faults come on top.
    glass_region: Option<GrayImage>,
    wanted: Wanted,
}

/// What is asked of a stage.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// Whether masks are, and as what.
    pub(super) masks: Masks,
    /// Whether coats or a camera's faults come on top of the glass.
    pub(super) faults: bool,
    /// Whether regions tell how much light comes through.
    pub(super) classes: bool,
}

impl Wanted {
    fn with_masks(self) -> bool {
        self.masks != Masks::No
    }
}

/// Whether masks of frames are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Masks {
    /// They are not.
    No,
    /// As pixels.
    Pixels,
    /// As PNG files.
    Files,
}

/// A mask of a stage.
#[derive(Debug)]
pub(super) struct StageMask {
    upright: GrayImage,
    /// As PNG, for all frames that are stored upright; empty where no files are asked for.
    png: Vec<u8>,
}

impl StageMask {
    fn of(upright: GrayImage, masks: Masks) -> Result<Arc<Self>, Error> {
        let png = match masks {
            Masks::Files => encode_mask(&upright)?,
            Masks::No | Masks::Pixels => Vec::new(),
        };
        Ok(Arc::new(Self { upright, png }))
    }

    pub(super) fn upright(&self) -> &GrayImage {
        &self.upright
    }

    pub(super) fn png(&self) -> &[u8] {
        &self.png
    }
}

impl StageFacts {
    /// The masks of a frame whose file does not store its pixels upright, laid as they lie there.
    pub(super) fn masks_as(&self, file: &ImageFile) -> Result<Option<[Vec<u8>; 2]>, Error> {
        match &self.masks {
            Some([region, crack]) if file.orientation != Orientation::NoTransforms => Ok(Some([
                encode_mask_as(&region.upright, file)?,
                encode_mask_as(&crack.upright, file)?,
            ])),
            _ => Ok(None),
        }
    }

    /// Under the glass alone. Of a chain with a faulty sensor, [`StageFacts::behind`] says the rest.
    pub(super) fn of(
        layer: &PaneLayer,
        lit: &Lit<'_>,
        crack_length_px: Option<f64>,
        wanted: Wanted,
    ) -> Result<Arc<Self>, Error> {
        let region = lit.glass_region(layer.size())?;
        let crack = wanted
            .with_masks()
            .then(|| layer.crack_mask())
            .transpose()?;
        Self::new((lit, region), crack_length_px, crack, wanted)
    }

    /// Before the glass breaks, where something may lie on it.
    pub(super) fn intact(
        lit: &Lit<'_>,
        (width, height): (u32, u32),
        wanted: Wanted,
    ) -> Result<Arc<Self>, Error> {
        let region = lit.glass_region((width, height))?;
        let crack = wanted.with_masks().then(|| GrayImage::new(width, height));
        Self::new((lit, region), Some(0.0), crack, wanted)
    }

    /// With masks where there is that of the cracks.
    fn new(
        (lit, mut region): (&Lit<'_>, GrayImage),
        crack_length_px: Option<f64>,
        crack: Option<GrayImage>,
        wanted: Wanted,
    ) -> Result<Arc<Self>, Error> {
        if wanted.classes && !wanted.faults {
            lit.classify(&mut region);
        }
        let masks = match crack {
            Some(crack) => Some([
                StageMask::of(region.clone(), wanted.masks)?,
                StageMask::of(crack, wanted.masks)?,
            ]),
            None => None,
        };
        Ok(Arc::new(Self {
            region_fraction: region_fraction(&region),
            crack_length_px,
            masks,
            glass_region: wanted.faults.then_some(region),
            wanted,
        }))
    }

    /// The same behind a sensor with faults, in a frame that `lit` was put over; of a frame that is blank no crack is
    /// left, and where another frame is shown all of it is affected.
    pub(super) fn behind(
        &self,
        lit: &Lit<'_>,
        (color, at): (ColorType, Moment),
        (is_blank, is_other): (bool, bool),
    ) -> Result<Option<Arc<Self>>, Error> {
        let Some(mut region) = self.glass_region.clone() else {
            return Ok(None);
        };
        match is_other {
            true => region.as_flat_samples_mut().as_mut_slice().fill(255),
            false => lit.add_faults(&mut region, color, at),
        }
        if self.wanted.classes && !is_blank {
            lit.classify(&mut region);
        }
        let masks = match &self.masks {
            Some([_, crack]) => {
                let crack = match is_blank {
                    true => {
                        let none = GrayImage::new(region.width(), region.height());
                        StageMask::of(none, self.wanted.masks)?
                    }
                    false => Arc::clone(crack),
                };
                Some([StageMask::of(region.clone(), self.wanted.masks)?, crack])
            }
            None => None,
        };
        Ok(Some(Arc::new(Self {
            region_fraction: region_fraction(&region),
            crack_length_px: self.crack_length_px,
            masks,
            glass_region: None,
            wanted: self.wanted,
        })))
    }
}
