//! Masks and figures of all frames at one stage of the growth.

use std::sync::Arc;

use image::GrayImage;
use image::metadata::Orientation;
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
    pub(super) masks: Option<[StageMask; 2]>,
}

/// A mask of a stage.
#[derive(Debug)]
pub(super) struct StageMask {
    upright: GrayImage,
    /// As PNG, for all frames that are stored upright.
    png: Vec<u8>,
}

impl StageMask {
    fn of(upright: GrayImage) -> Result<Self, Error> {
        let png = encode_mask(&upright)?;
        Ok(Self { upright, png })
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

    pub(super) fn of(
        layer: &PaneLayer,
        lit: &Lit<'_>,
        crack_length_px: Option<f64>,
        with_masks: bool,
    ) -> Result<Arc<Self>, Error> {
        let region = lit.region(layer.size())?;
        let masks = if with_masks {
            Some([
                StageMask::of(region.clone())?,
                StageMask::of(layer.crack_mask()?)?,
            ])
        } else {
            None
        };
        Ok(Arc::new(Self {
            region_fraction: region_fraction(&region),
            crack_length_px,
            masks,
        }))
    }

    /// Before the glass breaks: what the sensor does is there already.
    pub(super) fn intact(
        bare: &Lit<'_>,
        (width, height): (u32, u32),
        with_masks: bool,
    ) -> Result<Arc<Self>, Error> {
        let region = bare.sensor_region((width, height));
        let region_fraction = region_fraction(&region);
        let masks = if with_masks {
            Some([
                StageMask::of(region)?,
                StageMask::of(GrayImage::new(width, height))?,
            ])
        } else {
            None
        };
        Ok(Arc::new(Self {
            region_fraction,
            crack_length_px: Some(0.0),
            masks,
        }))
    }
}
