//! What a lens makes of frames.

use image::GrayImage;
use starbreak_seed::Seed;

use super::lamps::{Lamp, lamps_of};
use super::resample::Resampling;
use super::{LensFault, LensFaults, Optic};

/// A lens with its faults before the frames of one camera.
#[derive(Debug, Clone)]
pub struct LensOfFrames {
    lens: LensFaults,
    optic: Optic,
    /// Where each fault takes the pixels of a frame from: of all colors, or of red and of blue.
    resamplings: Vec<Vec<Resampling>>,
}

impl LensOfFrames {
    pub(super) fn new(lens: LensFaults, optic: Optic) -> Self {
        let of_fault = |(_, fault): &(f64, LensFault)| match fault {
            LensFault::Distortion(it) => vec![it.resampling(&optic)],
            LensFault::Fringes(it) => it.resamplings(&optic),
            _ => Vec::new(),
        };
        Self {
            resamplings: lens.faults().iter().map(of_fault).collect(),
            lens,
            optic,
        }
    }

    /// The camera.
    #[must_use]
    pub fn optic(&self) -> &Optic {
        &self.optic
    }

    /// What the faults that have begun at a time of a clip, s, make of a frame of linear light, in rows from the top with one
    /// value per pixel or three side by side, in place. What differs from frame to frame is drawn from the seed.
    /// The sun, which may stand beside the frame, is one more lamp for ghosts and glare.
    pub fn over(
        &self,
        light: &mut Vec<f32>,
        n_colors: usize,
        sun: Option<Lamp>,
        (time_s, frame): (f64, Seed),
    ) {
        if light.is_empty() {
            return;
        }
        let optic = &self.optic;
        let begun = || {
            let all = self.lens.faults().iter().zip(&self.resamplings);
            all.filter(|((onset_s, _), _)| *onset_s <= time_s)
                .map(|((_, fault), resamplings)| (fault, resamplings))
        };
        // Before a blur makes lamps large and dim.
        let has_ghosts = begun().any(|(fault, _)| matches!(fault, LensFault::Ghosts(_)));
        let mut lamps = match has_ghosts {
            true => lamps_of(light, n_colors, optic.size),
            false => Vec::new(),
        };
        let sun = sun.and_then(|sun| self.as_seen(sun, time_s));
        lamps.extend(sun);
        for (fault, resamplings) in begun() {
            match fault {
                LensFault::Distortion(_) => move_light(light, n_colors, resamplings),
                LensFault::Fringes(it) => it.over(light, n_colors, (optic, resamplings)),
                LensFault::Defocus(it) => it.over(light, n_colors, optic),
                LensFault::Shake(it) => it.over(light, n_colors, optic, frame),
                LensFault::Ghosts(it) => it.over(light, n_colors, optic, &lamps),
                LensFault::Star(it) => it.over(light, n_colors, optic),
                LensFault::Glare(it) => it.over(light, n_colors, (optic, sun.as_ref())),
                LensFault::Shading(it) => it.over(light, n_colors, optic),
            }
        }
    }

    /// A lamp where a lens that bends lines shows it; none where it does not.
    fn as_seen(&self, lamp: Lamp, time_s: f64) -> Option<Lamp> {
        let at_px = match self.lens.at(time_s).moved_places(&self.optic) {
            Some(moved) => moved.seen_at(lamp.at_px)?,
            None => lamp.at_px,
        };
        Some(Lamp { at_px, ..lamp })
    }

    /// Moves a value of each pixel of a frame, in rows from the top, as what an image shows at a time, s, is; 0 where nothing is
    /// shown. Beside an edge values may come out a little higher than any was.
    pub fn move_values(&self, values: &mut Vec<f32>, time_s: f64) {
        for ((onset_s, fault), resamplings) in self.lens.faults().iter().zip(&self.resamplings) {
            if *onset_s <= time_s && matches!(fault, LensFault::Distortion(_)) {
                move_light(values, 1, resamplings);
            }
        }
    }

    /// A mask of the frame, moved as what an image shows is when all faults have begun.
    #[must_use]
    pub fn moved_mask(&self, mut mask: GrayImage) -> GrayImage {
        if self.lens.moves_labels() {
            let mut values: Vec<f32> = mask.iter().map(|code| f32::from(*code)).collect();
            self.move_values(&mut values, f64::INFINITY);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a code"
            )]
            for (code, value) in mask.iter_mut().zip(values) {
                *code = (value + 0.5).min(255.0) as u8;
            }
        }
        mask
    }
}

fn move_light(light: &mut Vec<f32>, n_colors: usize, resamplings: &[Resampling]) {
    for resampling in resamplings {
        *light = resampling.over(light, n_colors);
    }
}
