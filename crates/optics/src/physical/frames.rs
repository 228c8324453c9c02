//! An overlay over frames in memory that belongs to somebody else.

use image::DynamicImage;
use starbreak_seed::Seed;

use super::noise::Noise;
use super::overlay::{Overlay, OverlayLayer};
use super::samples::Sample as _;
use crate::maps::CHUNK;
use crate::{Channels, FrameMut, OpticsError};

/// Memory that [`Overlay::apply_to`] uses again from frame to frame.
#[derive(Debug, Clone, Default)]
pub struct Gathered {
    /// Light of affected pixels from elsewhere in the frame.
    rgb: Vec<[[f32; CHUNK]; 3]>,
    gray: Vec<[[f32; CHUNK]; 1]>,
}

impl Overlay {
    /// Puts the crack over a frame where that lies: the same codes as [`Overlay::apply`], in any order of colors. Alpha and
    /// padding are never written.
    ///
    /// Only pixels that the crack touches are read and written, and no frame is copied, unless the scene is out of focus or
    /// `veiling_glare` spreads light over the frame: then one is made and copied back.
    ///
    /// # Errors
    /// [`OpticsError::SizeMismatch`] for a frame of another size than the overlay.
    pub fn apply_to(
        &self,
        frame: &mut FrameMut<'_>,
        seed: Seed,
        memory: &mut Gathered,
    ) -> Result<(), OpticsError> {
        self.check_size_of(frame.size())?;
        if !self.is_local() {
            let mut image = DynamicImage::default();
            frame.copy_to(&mut image);
            self.apply(&mut image, seed)?;
            return frame.copy_from(&mut image);
        }
        let noise = self.noise(seed);
        for layer in &self.layers {
            match frame.channels() {
                Channels::Gray => layer.over_frame(frame, noise.as_ref(), &mut memory.gray),
                _ => layer.over_frame(frame, noise.as_ref(), &mut memory.rgb),
            }
        }
        Ok(())
    }

    /// Whether [`Overlay::apply_to`] changes pixels where they lie, without a frame of its own.
    #[must_use]
    pub fn is_local(&self) -> bool {
        self.changes_runs_alone()
    }
}

impl OverlayLayer {
    fn over_frame<const COLORS: usize>(
        &self,
        frame: &mut FrameMut<'_>,
        noise: Option<&Noise>,
        elsewhere: &mut Vec<[[f32; CHUNK]; COLORS]>,
    ) {
        let (width, height) = frame.size();
        let size = (width as usize, height as usize);
        // All of it before anything is changed: a place may lie anywhere in the frame.
        let light = |x: usize, y: usize| {
            let rgb = frame.rgb_at(x, y);
            std::array::from_fn(|c| rgb[c].light())
        };
        self.gather(size, light, elsewhere);
        pulp::Arch::new().dispatch(OverFrame {
            layer: self,
            frame,
            elsewhere,
            noise,
        });
    }
}

/// All runs of a layer over a frame, compiled once more for processors with AVX2, as far as it is inlined. No result
/// depends on it: nothing is fused.
struct OverFrame<'a, 'f, const COLORS: usize> {
    layer: &'a OverlayLayer,
    frame: &'a mut FrameMut<'f>,
    elsewhere: &'a [[[f32; CHUNK]; COLORS]],
    noise: Option<&'a Noise>,
}

impl<const COLORS: usize> pulp::WithSimd for OverFrame<'_, '_, COLORS> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: pulp::Simd>(self, _: V) {
        let width = self.frame.size().0 as usize;
        let mut codes = [[0_u8; COLORS]; CHUNK];
        for run in &self.layer.runs {
            let codes = &mut codes[..CHUNK.min(width - run.x)];
            self.frame.read((run.x, run.y), codes);
            let keep = self.layer.keep(run);
            let other = run.elsewhere.map(|place| &self.elsewhere[place]);
            let pixels = codes.as_flattened_mut();
            match self.noise {
                None => run.over::<u8, COLORS, 0>(pixels, keep, other),
                Some(noise) => {
                    run.over_with_noise::<u8, COLORS, 0>(pixels, (keep, other), noise, width);
                }
            }
            self.frame.write((run.x, run.y), codes);
        }
    }
}
