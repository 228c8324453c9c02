//! A chain over frames in memory that belongs to somebody else, one after the other.

use std::sync::Arc;

use image::DynamicImage;
use starbreak_optics::environment::Environment;
use starbreak_optics::physical::{Gathered, Overlay};
use starbreak_optics::{FrameMut, OpticsError};
use starbreak_sensor::Moment;

use super::lit::{Glass, Lit};
use super::{Chain, PaneLayer};
use crate::{Error, OpticsSettings};

/// Memory that is used again from frame to frame, with a frame for what cannot work on one where it lies.
#[derive(Debug, Clone, Default)]
pub struct KeptFrame {
    image: DynamicImage,
    gathered: Gathered,
}

impl Lit<'_> {
    /// As [`Lit::over`], over a frame where that lies: the same codes, in any order of colors and with the same
    /// alpha; padding is never written.
    ///
    /// Glass by the physical optics that is sharp to the lens and has no glare works on the frame itself. For everything
    /// else, coats, faults of the camera, a blurred scene and the paper's optics, the frame is copied to `kept` and back.
    ///
    /// # Errors
    /// [`Error::Optics`]; the frame may then be half changed.
    pub fn over_frame(
        &self,
        frame: &mut FrameMut<'_>,
        kept: &mut KeptFrame,
        at: impl Into<Moment>,
    ) -> Result<(), Error> {
        let at = at.into();
        if let Some(overlay) = self.overlay_alone() {
            return Ok(overlay.apply_to(frame, at.frame, &mut kept.gathered)?);
        }
        frame.copy_to(&mut kept.image);
        self.over(&mut kept.image, at)?;
        Ok(frame.copy_from(&mut kept.image)?)
    }

    /// The overlay of the glass, where that is all and leaves alone what it does not touch.
    fn overlay_alone(&self) -> Option<&Overlay> {
        match &self.glass {
            Glass::Physical(overlay) if self.behind.is_nothing() => {
                Some(&**overlay).filter(|overlay| overlay.is_local())
            }
            _ => None,
        }
    }

    /// Its overlay, for the memory of it.
    fn into_overlay(self) -> Option<Box<Overlay>> {
        match self.glass {
            Glass::Physical(overlay) => Some(overlay),
            Glass::Paper(..) => None,
        }
    }
}

impl Chain {
    /// As [`Chain::light_of`], from a frame in somebody else's memory.
    #[must_use]
    pub fn light_of_frame(&self, frame: &FrameMut<'_>) -> Option<Environment> {
        match (&self.settings.optics, self.layer.f_px()) {
            (OpticsSettings::Physical(optics), Some(f_px)) => {
                Some(Environment::estimate_of(frame, &optics.environment, f_px))
            }
            _ => None,
        }
    }

    /// As [`Chain::light_of`], from a frame of a width and height, px, of which a few pixels are asked for by column and
    /// row: their codes of red, green and blue, 8 bits each.
    #[must_use]
    pub fn light_by(
        &self,
        size: (u32, u32),
        codes: &dyn Fn(u32, u32) -> [u8; 3],
    ) -> Option<Environment> {
        match (&self.settings.optics, self.layer.f_px()) {
            (OpticsSettings::Physical(optics), Some(f_px)) => {
                let params = &optics.environment;
                Some(Environment::estimate_by(size, codes, params, f_px))
            }
            _ => None,
        }
    }

    /// The glass under a light, in the memory of an overlay of the same glass.
    fn under_in(
        &self,
        memory: Option<Box<Overlay>>,
        light: Option<&Environment>,
    ) -> Result<Lit<'_>, Error> {
        match (memory, light, &self.layer, &self.settings.optics) {
            (Some(same), Some(light), ..) if same.environment() == light => {
                Ok(self.with_camera(Glass::Physical(same), *light))
            }
            (
                Some(memory),
                Some(light),
                PaneLayer::Baked(pattern),
                OpticsSettings::Physical(optics),
            ) => {
                let overlay = pattern.light_in(*memory, light, optics);
                Ok(self.with_camera(Glass::Physical(Box::new(overlay)), *light))
            }
            _ => self.under(light),
        }
    }
}

/// A chain that is put over frame after frame, and the memory that it uses again for each: one for each thread.
///
/// Frames are changed where they lie. Once it has seen a frame, no memory of the size of a frame is taken for glass by the
/// physical optics, sharp to the lens and without glare. Of a pattern out of a bank and of a photograph, what each new light
/// makes of the glass takes memory, some bytes for each affected pixel; [`Live::set_environment`] keeps one light. What
/// works on the light of a whole frame (coats, faults of lens and sensor, a blurred scene) takes memory for that light.
///
/// # Example
/// ```
/// use std::sync::Arc;
/// use starbreak::optics::{Channels, FrameMut};
/// use starbreak::{Chain, Live, Recipe, Seed};
///
/// let settings = Recipe::preset("windshield-star")?.settings()?;
/// let chain = Arc::new(Chain::of(&settings, (320, 200), Seed(7))?);
/// let mut live = Live::of(chain);
/// let mut bgra = vec![128; 320 * 200 * 4];
/// let mut frame = FrameMut::of_bytes(&mut bgra, (320, 200), Channels::Bgra)?;
/// live.over(&mut frame, Seed(7))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Live {
    chain: Arc<Chain>,
    environment: Option<Environment>,
    overlay: Option<Box<Overlay>>,
    kept: KeptFrame,
}

impl Live {
    /// A chain over frames, each under its own light.
    #[must_use]
    pub fn of(chain: Arc<Chain>) -> Self {
        Self {
            chain,
            environment: None,
            overlay: None,
            kept: KeptFrame::default(),
        }
    }

    /// Refuses a frame of another size than the chain's, px.
    ///
    /// # Errors
    /// [`Error::Optics`] with both sizes.
    pub fn check_size(&self, (width, height): (u32, u32)) -> Result<(), Error> {
        let (own_width, own_height) = self.chain.size();
        if (width, height) == (own_width, own_height) {
            return Ok(());
        }
        Err(OpticsError::SizeMismatch {
            width,
            height,
            drawn_width: own_width as usize,
            drawn_height: own_height as usize,
        }
        .into())
    }

    /// Puts all further frames under one light, or each under its own again. The paper's optics know no light.
    pub fn set_environment(&mut self, environment: Option<Environment>) {
        self.environment = environment;
    }

    /// Puts the chain over a frame, where that lies: the codes of [`Chain::over`]. A [`Seed`](crate::Seed) alone is a
    /// picture by itself; it is that of the sensor's noise.
    ///
    /// # Errors
    /// [`Error::Optics`] for a frame of another size; the frame may then be half changed.
    pub fn over(&mut self, frame: &mut FrameMut<'_>, at: impl Into<Moment>) -> Result<(), Error> {
        let light = match self.environment {
            Some(light) => Some(light),
            None => self.chain.light_of_frame(frame),
        };
        let lit = self.chain.under_in(self.overlay.take(), light.as_ref())?;
        let done = lit.over_frame(frame, &mut self.kept, at);
        self.overlay = lit.into_overlay();
        done
    }
}
