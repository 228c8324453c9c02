//! Broken glass under one light, and the camera behind it, over frame after frame.

use image::{ColorType, DynamicImage, GrayImage};
use starbreak_optics::paper::{Focus, PaperOptics, composite};
use starbreak_optics::physical::{OpticalMaps, Overlay};
use starbreak_optics::{Before, Coverage, DamageReader};
use starbreak_sensor::Moment;

use super::sense::Behind;
use crate::{Error, Stopwatch};

/// Codes of a region that tells how much of an image's light comes through, with the share below which it is each:
/// transparent, semi-transparent and opaque, the classes of \[Yogamani2019\].
pub const CLASSES: [(u8, f32); 3] = [(85, f32::INFINITY), (170, 0.6), (255, 0.1)];

/// A chain under one light: what it does to any frame of its size.
#[derive(Debug, Clone)]
pub struct Lit<'a> {
    pub(super) glass: Glass<'a>,
    /// What light meets behind it.
    pub(super) behind: Behind<'a>,
}

/// The glass under a light.
#[derive(Debug, Clone)]
pub(super) enum Glass<'a> {
    /// The paper's optics, which know no light.
    Paper(&'a Coverage, &'a PaperOptics),
    /// What each pixel keeps, and what is added to it.
    Physical(Box<Overlay>),
}

/// Where a frame is affected: 255, else 0.
pub(super) struct Regions {
    /// By the glass.
    glass: GrayImage,
    /// By glass and camera, where that has a fault.
    all: Option<GrayImage>,
}

impl Regions {
    /// By anything.
    pub(super) fn all(&self) -> &GrayImage {
        self.all.as_ref().unwrap_or(&self.glass)
    }

    /// By anything.
    pub(super) fn into_all(self) -> GrayImage {
        self.all.unwrap_or(self.glass)
    }
}

impl Lit<'_> {
    /// What the chain makes of a frame, in place: first the glass, then the camera. A [`Seed`](crate::Seed) alone is a
    /// picture by itself; it is that of the noise.
    ///
    /// # Errors
    /// [`Error::Optics`]; the image may then be half changed.
    pub fn over(&self, frame: &mut DynamicImage, at: impl Into<Moment>) -> Result<(), Error> {
        let at = at.into();
        self.glass_over(frame, at)?;
        self.camera_over(frame, at)
    }

    /// The glass over codes of light.
    fn glass_over(&self, frame: &mut DynamicImage, at: Moment) -> Result<(), Error> {
        match &self.glass {
            Glass::Paper(coverage, optics) => {
                composite(frame, coverage, optics)?;
            }
            Glass::Physical(overlay) if self.glass_in_light().is_none() => {
                overlay.apply(frame, at.frame)?;
            }
            Glass::Physical(overlay) => overlay.check_size(frame)?,
        }
        Ok(())
    }

    /// What comes behind the glass, with that where it meets light brighter than white.
    fn camera_over(&self, frame: &mut DynamicImage, at: Moment) -> Result<(), Error> {
        self.behind.over(frame, self.glass_in_light(), at)
    }

    /// The glass, where lamps are brighter than any code when they meet it.
    fn glass_in_light(&self) -> Option<&Overlay> {
        match &self.glass {
            Glass::Physical(overlay) if self.behind.has_headroom() => {
                Some(&**overlay).filter(|overlay| !overlay.changes_nothing())
            }
            _ => None,
        }
    }

    /// As [`Lit::over`]; returns where the frame is affected.
    pub(super) fn over_region(
        &self,
        frame: &mut DynamicImage,
        at: Moment,
        watch: &mut Stopwatch,
    ) -> Result<Regions, Error> {
        let glass = match &self.glass {
            Glass::Paper(coverage, optics) => {
                let masks = composite(frame, coverage, optics)?;
                watch.lap("render");
                masks.region
            }
            Glass::Physical(overlay) => {
                self.glass_over(frame, at)?;
                watch.lap("render");
                let region = overlay.region();
                watch.lap("region");
                region
            }
        };
        let mut all = None;
        if !self.behind.is_nothing() {
            self.camera_over(frame, at)?;
            let mut behind = glass.clone();
            self.behind.add_region(&mut behind, frame.color(), at);
            watch.lap("camera");
            all = Some(behind);
        }
        Ok(Regions { glass, all })
    }

    /// True if [`Lit::over`] would leave every frame as it is at a time of a clip, s.
    #[must_use]
    pub fn changes_nothing(&self, time_s: f64) -> bool {
        self.behind.is_nothing_at(time_s)
            && match &self.glass {
                Glass::Paper(coverage, optics) => coverage.is_empty() && optics.focus == Focus::Far,
                Glass::Physical(overlay) => overlay.changes_nothing(),
            }
    }

    /// 255 where the glass affects frames of its width and height, px, else 0.
    ///
    /// # Errors
    /// [`Error::Optics`] where the paper's optics get another size.
    pub fn glass_region(&self, (width, height): (u32, u32)) -> Result<GrayImage, Error> {
        Ok(match &self.glass {
            Glass::Paper(coverage, optics) => {
                // What it may change does not depend on the image.
                let mut gray = DynamicImage::ImageLuma8(GrayImage::new(width, height));
                composite(&mut gray, coverage, optics)?.region
            }
            Glass::Physical(overlay) => overlay.region(),
        })
    }

    /// Adds 255 where dew and the camera's faults affect a frame of these colors.
    pub fn add_faults(&self, region: &mut GrayImage, color: ColorType, at: Moment) {
        self.behind.add_region(region, color, at);
    }

    /// Tells in a region how much of an image's light comes through: [`CLASSES`] where it is not 0.
    pub fn classify(&self, region: &mut GrayImage) {
        let mut passing = match &self.glass {
            Glass::Physical(overlay) => overlay.passing(),
            Glass::Paper(..) => vec![1.0; region.len()],
        };
        self.behind.let_through(&mut passing);
        for (code, passes) in region.iter_mut().zip(passing) {
            if *code > 0 {
                let class = CLASSES.iter().rfind(|(_, below)| passes < *below);
                *code = class.map_or(CLASSES[0].0, |(class, _)| *class);
            }
        }
    }

    /// What an image shows before the glass is put over it.
    pub(super) fn before(&self, image: &DynamicImage) -> Before {
        match &self.glass {
            Glass::Physical(overlay) if self.behind.is_nothing() => overlay.before(image),
            _ => Before::whole(image.clone()),
        }
    }

    /// Who measures what the glass did to boxes of an image.
    pub(super) fn damage_reader<'b>(
        &'b self,
        images: (&'b Before, &'b DynamicImage),
        regions: &'b Regions,
    ) -> DamageReader<'b> {
        match &self.glass {
            Glass::Paper(_, optics) => {
                DamageReader::of_paper(images, [regions.all(), &regions.glass], optics)
            }
            Glass::Physical(overlay) => DamageReader::of_overlay(images, regions.all(), overlay),
        }
    }

    /// What the physical optics did to the light of each pixel.
    pub(super) fn maps(&self) -> Option<OpticalMaps> {
        match &self.glass {
            Glass::Physical(overlay) => Some(overlay.maps()),
            Glass::Paper(..) => None,
        }
    }
}
