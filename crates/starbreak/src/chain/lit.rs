//! Broken glass under one light, over frame after frame.

use image::{DynamicImage, GrayImage};
use starbreak_optics::paper::{Focus, PaperOptics, composite};
use starbreak_optics::physical::Overlay;
use starbreak_optics::{Before, Coverage, DamageReader};
use starbreak_seed::Seed;

use crate::{Error, Stopwatch};

/// A chain under one light: what it does to any frame of its size.
#[derive(Debug, Clone)]
pub enum Lit<'a> {
    /// The paper's optics, which know no light.
    Paper(&'a Coverage, &'a PaperOptics),
    /// What each pixel keeps, and what is added to it.
    Physical(Box<Overlay>),
}

impl Lit<'_> {
    /// Puts the glass over a frame, in place; the seed is that of the sensor's noise in it.
    ///
    /// # Errors
    /// [`Error::Optics`]; the image may then be half changed.
    pub fn over(&self, frame: &mut DynamicImage, seed: Seed) -> Result<(), Error> {
        match self {
            Self::Paper(coverage, optics) => {
                composite(frame, coverage, optics)?;
            }
            Self::Physical(overlay) => overlay.apply(frame, seed)?,
        }
        Ok(())
    }

    /// As [`Lit::over`]; returns 255 where the glass affects the frame, else 0.
    pub(super) fn over_region(
        &self,
        frame: &mut DynamicImage,
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<GrayImage, Error> {
        match self {
            Self::Paper(coverage, optics) => {
                let masks = composite(frame, coverage, optics)?;
                watch.lap("render");
                Ok(masks.region)
            }
            Self::Physical(overlay) => {
                overlay.apply(frame, seed)?;
                watch.lap("render");
                let region = overlay.region();
                watch.lap("region");
                Ok(region)
            }
        }
    }

    /// True if [`Lit::over`] would leave every frame as it is.
    #[must_use]
    pub fn changes_nothing(&self) -> bool {
        match self {
            Self::Paper(coverage, optics) => coverage.is_empty() && optics.focus == Focus::Far,
            Self::Physical(overlay) => overlay.changes_nothing(),
        }
    }

    /// 255 where the glass affects frames of the chain's width and height, px, else 0.
    ///
    /// # Errors
    /// [`Error::Optics`] where the paper's optics get another size.
    pub fn region(&self, (width, height): (u32, u32)) -> Result<GrayImage, Error> {
        match self {
            Self::Paper(coverage, optics) => {
                // What it may change does not depend on the image.
                let mut gray = DynamicImage::ImageLuma8(GrayImage::new(width, height));
                Ok(composite(&mut gray, coverage, optics)?.region)
            }
            Self::Physical(overlay) => Ok(overlay.region()),
        }
    }

    /// What an image shows before the glass is put over it.
    pub(super) fn before(&self, image: &DynamicImage) -> Before {
        match self {
            Self::Paper(..) => Before::whole(image.clone()),
            Self::Physical(overlay) => overlay.before(image),
        }
    }

    /// Who measures what the glass did to boxes of an image.
    pub(super) fn damage_reader<'b>(
        &'b self,
        images: (&'b Before, &'b DynamicImage),
        region: &'b GrayImage,
    ) -> DamageReader<'b> {
        match self {
            Self::Paper(_, optics) => DamageReader::of_paper(images, region, optics),
            Self::Physical(overlay) => DamageReader::of_overlay(images, region, overlay),
        }
    }
}
