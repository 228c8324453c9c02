//! What the lens does wrong: a frame of linear light before the faults, and after them.
//!
//! A photograph has been through a lens that works; each fault is what is added to that. Light meets
//! them in this order: geometry ([`Distortion`], [`Fringes`]), blur ([`Defocus`], [`Shake`]), stray light
//! ([`Ghosts`], [`Star`], [`Glare`]), and [`Shading`].

mod bright;
mod clipped;
mod defocus;
mod distortion;
mod fringes;
mod ghosts;
mod glare;
mod lamps;
mod of_frames;
mod resample;
mod shading;
mod shake;
mod star;

use std::borrow::Cow;
use std::ops::Range;

use crate::lens::Lens;

pub use defocus::Defocus;
pub use distortion::{Distortion, Projection};
pub use fringes::Fringes;
pub use ghosts::{Ghost, Ghosts, LensFace};
pub use glare::Glare;
pub use lamps::Lamp;
pub use of_frames::LensOfFrames;
pub use shading::Shading;
pub use shake::Shake;
pub use star::Star;

/// The camera whose lens it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optic {
    /// Focal length, px.
    pub f_px: f64,
    /// The lens that works.
    pub lens: Lens,
    /// Width and height of the frames, px. The optical axis meets their middle.
    pub size: (usize, usize),
}

impl Optic {
    /// Where the optical axis meets the frame, px.
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    fn middle(&self) -> [f64; 2] {
        [0.5 * self.size.0 as f64, 0.5 * self.size.1 as f64]
    }

    /// From there to a corner of the frame, px.
    fn half_diagonal_px(&self) -> f64 {
        let [x, y] = self.middle();
        libm::hypot(x, y)
    }
}

/// A fault of the lens.
#[derive(Debug, Clone, PartialEq)]
pub enum LensFault {
    /// Lines that bend.
    Distortion(Distortion),
    /// Colors that are not of one size.
    Fringes(Fringes),
    /// A sensor out of the focal plane.
    Defocus(Defocus),
    /// A camera that turns while it exposes.
    Shake(Shake),
    /// Light that two faces mirror.
    Ghosts(Ghosts),
    /// Light that the aperture diffracts.
    Star(Star),
    /// Light that the lens scatters.
    Glare(Glare),
    /// Corners that get less light.
    Shading(Shading),
}

macro_rules! each {
    ($($kind:ident),*) => {
        impl LensFault {
            /// Whether it changes nothing, whatever the image.
            #[must_use]
            pub fn is_nothing(&self) -> bool {
                match self {
                    $(Self::$kind(fault) => fault.is_nothing(),)*
                }
            }
        }
        $(
            impl From<$kind> for LensFault {
                fn from(fault: $kind) -> Self {
                    Self::$kind(fault)
                }
            }
        )*
    };
}

each!(
    Distortion, Fringes, Defocus, Shake, Ghosts, Star, Glare, Shading
);

/// Where the frames of a camera show what they would show without distortion, and back, px.
#[derive(Debug, Clone)]
pub struct MovedPlaces(Vec<distortion::OfFrames>);

impl MovedPlaces {
    /// Where that is seen which is at a place without distortion; none where it is not seen at all. It may be beyond the
    /// frame.
    #[must_use]
    pub fn seen_at(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        self.0.iter().try_fold(at, |at, fault| fault.seen_at(at))
    }

    /// Where that is without distortion which is seen at a place; none where nothing is seen. It may be beyond the frame,
    /// of which an image knows nothing.
    #[must_use]
    pub fn shown_at(&self, at: [f64; 2]) -> Option<[f64; 2]> {
        self.0
            .iter()
            .rev()
            .try_fold(at, |at, fault| fault.shown_at(at))
    }
}

/// A lens with its faults. Without any, or with all of them at nothing, a frame stays as it is, to the last bit.
///
/// # Example
/// ```
/// use starbreak_optics::lens::Lens;
/// use starbreak_optics::lens_faults::{LensFaults, Optic, Shading};
/// use starbreak_seed::Seed;
///
/// let mut lens = LensFaults::default();
/// lens.push(0.0, Shading { corner_loss: 0.5 });
/// let optic = Optic { f_px: 50.0, lens: Lens::default(), size: (40, 30) };
/// let mut light = vec![1.0; 40 * 30];
/// lens.for_frames(&optic).over(&mut light, 1, None, (0.0, Seed(1)));
/// assert!(light[0] < 0.52, "half of the light is lost in a corner");
/// assert!(light[15 * 40 + 20] > 0.99, "and none in the middle");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LensFaults {
    headroom: f64,
    faults: Vec<(f64, LensFault)>,
}

impl Default for LensFaults {
    /// None, and nothing brighter than white.
    fn default() -> Self {
        Self {
            headroom: 1.0,
            faults: Vec::new(),
        }
    }
}

impl LensFaults {
    /// None, with how many times as bright as white what is clipped in an image may have been, 1 or more.
    #[must_use]
    pub fn with_headroom(headroom: f64) -> Self {
        Self {
            headroom,
            ..Self::default()
        }
    }

    /// How many times as bright as white what is clipped in an image may have been.
    #[must_use]
    pub fn headroom(&self) -> f64 {
        self.headroom
    }

    /// Adds a fault, with the time of a clip at which it begins, s; it comes after those that are there.
    pub fn push(&mut self, onset_s: f64, fault: impl Into<LensFault>) {
        let fault = fault.into();
        if !fault.is_nothing() {
            self.faults.push((onset_s, fault));
        }
    }

    /// The faults, each with the time of a clip at which it begins, s.
    #[must_use]
    pub fn faults(&self) -> &[(f64, LensFault)] {
        &self.faults
    }

    /// With the faults alone that have begun at a time, s.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Cow<'_, Self> {
        if self.faults.iter().all(|(onset_s, _)| *onset_s <= time_s) {
            return Cow::Borrowed(self);
        }
        let mut now = self.clone();
        now.faults.retain(|(onset_s, _)| *onset_s <= time_s);
        Cow::Owned(now)
    }

    /// Whether anything of a frame of so many colors changes, 1 or 3.
    #[must_use]
    pub fn changes(&self, n_colors: usize) -> bool {
        let mut faults = self.faults.iter();
        faults.any(|(_, fault)| n_colors == 3 || !matches!(fault, LensFault::Fringes(_)))
    }

    /// Whether what an image shows is moved so that labels no longer fit.
    #[must_use]
    pub fn moves_labels(&self) -> bool {
        let mut faults = self.faults.iter();
        faults.any(|(_, fault)| matches!(fault, LensFault::Distortion(_)))
    }

    /// Where frames of one camera show what they would show without distortion; none where nothing is moved.
    #[must_use]
    pub fn moved_places(&self, optic: &Optic) -> Option<MovedPlaces> {
        let moves = |(_, fault): &(f64, LensFault)| match fault {
            LensFault::Distortion(it) => Some(it.for_frames(optic)),
            _ => None,
        };
        let all: Vec<_> = self.faults.iter().filter_map(moves).collect();
        (!all.is_empty()).then_some(MovedPlaces(all))
    }

    /// Makes what is clipped in a frame of linear light of a width, px, of 1 or 3 colors, as bright as it may
    /// have been, before anything spreads it: small lamps by the headroom, in their middle, and larger ones less, for a camera
    /// that saw a sky so bright would have exposed less. A lamp that is nearly white stays so, and a red one red. Returns
    /// the pixels that it makes brighter, in their order: those of a row that are side by side together.
    pub fn unclip(&self, light: &mut [f32], n_colors: usize, width: usize) -> Vec<Range<usize>> {
        if self.headroom > 1.0 && !light.is_empty() {
            return clipped::unclip(light, n_colors, width, self.headroom);
        }
        Vec::new()
    }

    /// For the frames of one camera: what all of them share is found once.
    #[must_use]
    pub fn for_frames(&self, optic: &Optic) -> LensOfFrames {
        LensOfFrames::new(self.clone(), *optic)
    }

    /// Share of the light of every pixel that is spread over the frame.
    #[must_use]
    pub fn scattered(&self, optic: &Optic) -> f64 {
        let kept = (self.faults.iter()).fold(1.0, |kept, (_, fault)| match fault {
            LensFault::Glare(it) => kept * (1.0 - it.scattered(optic)),
            _ => kept,
        });
        1.0 - kept
    }
}
