//! What the cracks look like at a stage of their growth, and what a frame then becomes.

use std::sync::Arc;

use image::metadata::Orientation;
use image::{DynamicImage, GrayImage};
use starbreak_dataset::{ImageFile, encode_mask, encode_mask_as};
use starbreak_glass::{CrackNetwork, LengthUnit};
use starbreak_optics::environment::Environment;
use starbreak_optics::paper::{Focus, PaperOptics, composite, draw};
use starbreak_optics::physical::{Overlay, Pattern, PhysicalOptics, bake};
use starbreak_optics::{Coverage, Masks, View};
use starbreak_seed::Seed;

use crate::{Error, OpticsSettings};

/// Cracks before a camera.
pub(super) struct Pane<'a> {
    pub(super) network: &'a CrackNetwork,
    pub(super) view: &'a View,
    pub(super) optics: &'a OpticsSettings,
    pub(super) seed: Seed,
}

/// Cracks as far as they have grown, drawn, without light.
pub(super) enum Drawn<'a> {
    Paper(Coverage, &'a PaperOptics),
    Physical(Pattern, &'a PhysicalOptics),
}

/// The same, ready to be put over frames.
pub(super) enum Lit<'a> {
    Paper(&'a Coverage, &'a PaperOptics),
    Physical(Box<Overlay>),
}

/// What a stage of the growth says of its frames.
#[derive(Debug)]
pub(super) struct StageFacts {
    /// Share of the frame that the cracks influence.
    pub(super) region_fraction: f64,
    /// Length of the cracks inside the frame, px.
    pub(super) crack_length_px: f64,
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

impl<'a> Pane<'a> {
    pub(super) fn draw(&self, grown: f64) -> Result<Drawn<'a>, Error> {
        Ok(match self.optics {
            OpticsSettings::Paper(optics) => {
                Drawn::Paper(draw(self.network, self.view, grown, optics), optics)
            }
            OpticsSettings::Physical(optics) => Drawn::Physical(
                bake(self.network, grown, self.view, optics, self.seed)?,
                optics,
            ),
        })
    }

    /// The pane before the impact.
    pub(super) fn draw_nothing(&self) -> Result<Drawn<'a>, Error> {
        let (width, height) = self.view.size();
        let none = CrackNetwork::without_cracks(width, height);
        Ok(match self.optics {
            OpticsSettings::Paper(optics) => {
                Drawn::Paper(draw(&none, self.view, f64::INFINITY, optics), optics)
            }
            OpticsSettings::Physical(optics) => Drawn::Physical(
                bake(&none, f64::INFINITY, self.view, optics, self.seed)?,
                optics,
            ),
        })
    }

    /// The light that an image tells of; the paper's optics do not ask.
    pub(super) fn light_of(&self, image: &DynamicImage, f_px: Option<f64>) -> Option<Environment> {
        match (self.optics, f_px) {
            (OpticsSettings::Physical(optics), Some(f_px)) => {
                Some(Environment::estimate(image, &optics.environment, f_px))
            }
            _ => None,
        }
    }

    /// Length of what is in the frame, px.
    pub(super) fn crack_length_px(&self, grown: f64) -> f64 {
        // Networks in px lie over the frame, also where the optics see glass that is raked.
        let data = self.network.data();
        let stretched =
            (data.unit == LengthUnit::Px).then(|| View::stretched(&data.pane, self.view.size()));
        let view = stretched.as_ref().unwrap_or(self.view);
        self.network
            .grown_at(grown)
            .filter_map(|(_, ends)| view.visible(ends, 0.0))
            .map(|[u0, v0, u1, v1]| libm::hypot(u1 - u0, v1 - v0))
            .sum::<f64>()
            // An empty sum is -0.
            .abs()
    }
}

impl<'a> Drawn<'a> {
    pub(super) fn f_px(&self) -> Option<f64> {
        match self {
            Self::Paper(..) => None,
            Self::Physical(pattern, _) => Some(pattern.f_px()),
        }
    }

    /// Under a light, which the physical optics need.
    pub(super) fn light(&self, light: Option<&Environment>) -> Lit<'_> {
        match (self, light) {
            (Self::Paper(coverage, optics), _) => Lit::Paper(coverage, optics),
            (Self::Physical(pattern, optics), light) => {
                Lit::Physical(Box::new(pattern.light(light.unwrap_or(&DARK), optics)))
            }
        }
    }

    fn crack_mask(&self) -> GrayImage {
        match self {
            Self::Paper(coverage, _) => coverage.to_mask(),
            Self::Physical(pattern, _) => pattern.coverage(),
        }
    }
}

/// No light at all.
const DARK: Environment = Environment {
    horizon_rgb: [0.0; 3],
    zenith_rgb: [0.0; 3],
    ground_rgb: [0.0; 3],
    cabin_low_rgb: [0.0; 3],
    cabin_high_rgb: [0.0; 3],
    sun_rgb: [0.0; 3],
};

impl Lit<'_> {
    /// Puts the cracks over a frame; the seed is that of the sensor's noise in it.
    pub(super) fn over(&self, frame: &mut DynamicImage, seed: Seed) -> Result<(), Error> {
        match self {
            Self::Paper(coverage, optics) => {
                composite(frame, coverage, optics)?;
            }
            Self::Physical(overlay) => overlay.apply(frame, seed)?,
        }
        Ok(())
    }

    /// Whether frames stay as they are.
    pub(super) fn changes_nothing(&self) -> bool {
        match self {
            Self::Paper(coverage, optics) => coverage.is_empty() && optics.focus == Focus::Far,
            Self::Physical(overlay) => overlay.changes_nothing(),
        }
    }

    fn region(&self, (width, height): (u32, u32)) -> Result<GrayImage, Error> {
        Ok(match self {
            Self::Paper(coverage, optics) => {
                // What it may change does not depend on the image.
                let mut gray = DynamicImage::ImageLuma8(GrayImage::new(width, height));
                let Masks { region, .. } = composite(&mut gray, coverage, optics)?;
                region
            }
            Self::Physical(overlay) => overlay.region(),
        })
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
        drawn: &Drawn<'_>,
        lit: &Lit<'_>,
        size: (u32, u32),
        crack_length_px: f64,
        with_masks: bool,
    ) -> Result<Arc<Self>, Error> {
        let region = lit.region(size)?;
        let masks = if with_masks {
            Some([
                StageMask::of(region.clone())?,
                StageMask::of(drawn.crack_mask())?,
            ])
        } else {
            None
        };
        Ok(Arc::new(Self {
            region_fraction: crate::pipeline::region_fraction(&region),
            crack_length_px,
            masks,
        }))
    }

    pub(super) fn intact(
        (width, height): (u32, u32),
        with_masks: bool,
    ) -> Result<Arc<Self>, Error> {
        let masks = if with_masks {
            let black = || StageMask::of(GrayImage::new(width, height));
            Some([black()?, black()?])
        } else {
            None
        };
        Ok(Arc::new(Self {
            region_fraction: 0.0,
            crack_length_px: 0.0,
            masks,
        }))
    }
}
