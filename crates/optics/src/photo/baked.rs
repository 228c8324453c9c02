//! A placed photograph, ready for either optics.

use image::GrayImage;

use super::background::Background;
use super::picture::Photo;
use super::placement::Placement;
use super::raster::{Glass, Raster};
use crate::coverage::LEAST;
use crate::environment::{Dashboard, Environment, HemisphereWeights, luminance};
use crate::maps::Pupil;
use crate::physical::{Beyond, Overlay, PhysicalOptics, defocus_rows};
use crate::srgb::encode16;
use crate::surface::SheetView;
use crate::{Coverage, OpticsError, View};

/// A pane out of focus by a smaller radius, px, is sharp.
const SHARP_PX: f64 = 0.05;

/// Radii, px, within this ratio are one.
const RADIUS_RATIO: f64 = 1.005;

/// Largest reach of a pupil over its radius: the corner of a triangle of the disc's area.
const MOST_REACH: f64 = 1.56;

/// Pixels beyond the reach of a disc that a coarse spread of it may read.
const SPARE_PX: usize = 20;

/// The photograph as the paper's optics take it: coverage M, and brightness over the light.
///
/// The paper mixes code values, so these are as any program for pictures has them, after the
/// photograph was shrunk in linear light. With p the codes of the photograph over the greatest
/// code and Y that of its luminance: with alpha M = α and the brightness is Y of what is opaque;
/// on black M = max p and M · brightness = Y; on white M = 1 − min p and M · brightness = Y −
/// min p. Light 255 then shows the photograph's own grey.
///
/// # Errors
/// As for [`Placement::check`].
///
/// # Limits
/// The paper's cracks have the color of its light: that of the photograph is lost.
pub fn draw(
    photo: &Photo,
    placement: &Placement,
    (width, height): (u32, u32),
) -> Result<Coverage, OpticsError> {
    placement.check()?;
    let size = (width as usize, height as usize);
    let raster = Raster::new(photo, placement, size, 0);
    let background = raster.background();
    let mut pixels = Vec::new();
    for (x, y) in (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y))) {
        let (covered, brightness) = shade(raster.glass(x, y), background);
        if covered >= LEAST {
            pixels.push((x, y, [(covered.min(1.0), brightness)]));
        }
    }
    Ok(Coverage::of_runs(size, &pixels))
}

/// Coverage and brightness of a pixel.
fn shade(glass: Glass, background: Background) -> (f32, f32) {
    if most(glass.opacity) <= 0.0 {
        return (0.0, 0.0);
    }
    let code = |light: f32| f32::from(encode16(light)) / 65535.0;
    let (covered, sent) = match background {
        Background::Alpha => {
            let covered = glass.opacity[0];
            let own = glass.light.map(|light| light / covered.max(1e-9));
            return (covered, code(luminance(own)));
        }
        Background::Black => (code(most(glass.light)), code(luminance(glass.light))),
        Background::White => {
            let clear = glass.opacity.map(|opacity| 1.0 - opacity);
            let least = code(1.0 - most(glass.opacity));
            (1.0 - least, code(luminance(clear)) - least)
        }
    };
    (covered, (sent / covered.max(1e-9)).clamp(0.0, 1.0))
}

fn most([red, green, blue]: [f32; 3]) -> f32 {
    red.max(green).max(blue)
}

/// A photograph over the frame of one camera, ready for any image of the camera's size.
#[derive(Debug, Clone)]
pub struct PhotoPattern {
    size: (u32, u32),
    f_px: f64,
    /// What a plane in the place of the glass is lit by.
    outside: HemisphereWeights,
    /// As the lens shows it, and how far the frame begins within.
    spread: Raster,
    margin: usize,
    coverage: GrayImage,
    dashboard: Dashboard,
}

/// Bakes a placed photograph: opacity and light are spread by the disc that the lens makes of a
/// point of the glass, midway through the sheet.
///
/// The photograph is laid over the frame as it is, whatever the rake of the pane; only the disc
/// follows the distance of the glass, row by row. What it takes away and what it sends are spread
/// alike, so that over even light of its own brightness nothing changes. Rows whose lines of
/// sight miss the pane show none.
///
/// # Errors
/// [`OpticsError::Parameter`] for a parameter out of range, [`OpticsError::NoCamera`] for a view
/// of a stretched pane.
pub fn bake(
    photo: &Photo,
    placement: &Placement,
    view: &View,
    optics: &PhysicalOptics,
) -> Result<PhotoPattern, OpticsError> {
    optics.check()?;
    placement.check()?;
    let (width, height) = view.size();
    let sheet = SheetView::new(view, &optics.lens, &optics.glass)?;
    let horizon = optics.environment.horizon(height, sheet.f_px());
    let outward = sheet.camera_from_sheet([0.0, 0.0, 1.0]);
    let size = (width as usize, height as usize);
    let in_frame = (0..height).filter_map(|y| radius_px(&sheet, f64::from(y)));
    let most_px = in_frame.map(f64::abs).fold(0.0, f64::max);
    let margin = margin_px(most_px, size);
    let sharp = Raster::new(photo, placement, size, margin);
    let coverage = GrayImage::from_fn(width, height, |x, y| {
        let at = [x, y].map(|k| k as usize);
        let glass = sharp.glass(at[0] + margin, at[1] + margin);
        let share = view.dashboard().glass_in(at, (width, height), 1);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share as a code"
        )]
        let code = (share * most(glass.opacity).clamp(0.0, 1.0) * 255.0).round() as u8;
        image::Luma([code])
    });
    #[expect(clippy::cast_precision_loss, reason = "px of a frame")]
    let radii_px: Vec<Option<f64>> = (0..sharp.height)
        .map(|row| radius_px(&sheet, row as f64 - margin as f64))
        .map(|radius| radius.map(|radius| radius.clamp(-most_px, most_px)))
        .collect();
    Ok(PhotoPattern {
        size: (width, height),
        f_px: sheet.f_px(),
        outside: HemisphereWeights::facing(horizon.sin_elevation(outward)),
        spread: spread(sharp, &radii_px, Pupil::of(&optics.lens)),
        margin,
        coverage,
        dashboard: *view.dashboard(),
    })
}

/// Share of a frame of this size, px, that a placed photograph covers, 0 to 1: the mean of
/// [`PhotoPattern::coverage`], but for the rounding to codes.
///
/// # Errors
/// [`OpticsError::Parameter`] for a placement out of range.
pub fn covered_share(
    photo: &Photo,
    placement: &Placement,
    (width, height): (u32, u32),
) -> Result<f64, OpticsError> {
    placement.check()?;
    let size = (width as usize, height as usize);
    let raster = Raster::new(photo, placement, size, 0);
    let rows = (0..size.1).map(|y| {
        let opacities = (0..size.0).map(|x| f64::from(most(raster.glass(x, y).opacity)));
        opacities
            .map(|opacity| opacity.clamp(0.0, 1.0))
            .sum::<f64>()
    });
    Ok(rows.sum::<f64>() / (f64::from(width) * f64::from(height)).max(1.0))
}

/// Signed radius of the disc of the glass in the middle of a row of the frame, px; none where the
/// row misses the pane.
fn radius_px(sheet: &SheetView, row: f64) -> Option<f64> {
    let middle = 0.5 * f64::from(sheet.view().size().0);
    let point = sheet.view().unproject([middle, row + 0.5])?;
    let radius = sheet.blur_radius_px(point, 0.5 * sheet.outer_mm())?;
    // In steps, so that rows share their discs.
    let step = libm::log(RADIUS_RATIO);
    let steps = (libm::log(radius.abs().max(1e-3)) / step).round();
    Some(libm::exp(steps * step).copysign(radius))
}

/// How far beyond the frame glass still reaches into it, but never further than the frame is
/// large: of larger discs the outermost part is missing.
fn margin_px(radius_px: f64, (width, height): (usize, usize)) -> usize {
    if radius_px < SHARP_PX {
        return 0;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "px; more than fits is cut off"
    )]
    let reach = (radius_px * MOST_REACH).ceil() as usize;
    reach.min(width.max(height)) + SPARE_PX
}

fn spread(sharp: Raster, radii_px: &[Option<f64>], pupil: Pupil) -> Raster {
    let size = (sharp.width, sharp.height);
    fn blur<const L: usize>(
        lanes: &mut Vec<[f32; L]>,
        size: (usize, usize),
        radii_px: &[Option<f64>],
        pupil: Pupil,
    ) {
        for (row, radius) in lanes.chunks_exact_mut(size.0.max(1)).zip(radii_px) {
            if radius.is_none() {
                row.fill([0.0; L]);
            }
        }
        let radii_px: Vec<f64> = radii_px
            .iter()
            .map(|radius| radius.unwrap_or(0.0))
            .collect();
        if radii_px.iter().any(|radius| radius.abs() >= SHARP_PX) {
            let blurred = defocus_rows::<L>(
                lanes.as_flattened(),
                size,
                pupil,
                &radii_px,
                Beyond::Nothing,
            );
            *lanes = blurred.as_chunks::<L>().0.to_vec();
        }
    }
    sharp.mapped(
        |lanes| blur(lanes, size, radii_px, pupil),
        |lanes| blur(lanes, size, radii_px, pupil),
    )
}

/// A gain of [`PhotoPattern::light`] is in its range.
///
/// # Errors
/// [`OpticsError::Parameter`].
pub fn check_gain(gain: f64) -> Result<(), OpticsError> {
    OpticsError::check_ranges(&[("overlay_gain", gain, 0.0, 1000.0)])
}

impl PhotoPattern {
    /// Width and height of the frame, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Focal length of the camera, px.
    #[must_use]
    pub fn f_px(&self) -> f64 {
        self.f_px
    }

    /// Whether no glass is in the frame.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        self.coverage.iter().all(|code| *code == 0)
    }

    /// The photograph under the light of an environment, ready to be put over images.
    ///
    /// A photograph knows no absolute light. Its white is taken to be what a white, matte sheet
    /// in the place of the glass would show, lit from outside by sky and ground without the sun,
    /// times `gain` (1 unless there is a reason; 0 to 1000): glass that is lit like its scene.
    /// Over an even scene, of that light, it is then not seen.
    ///
    /// # Errors
    /// [`OpticsError::Parameter`] for a gain out of range.
    pub fn light(
        &self,
        environment: &Environment,
        gain: f64,
        optics: &PhysicalOptics,
    ) -> Result<Overlay, OpticsError> {
        check_gain(gain)?;
        #[expect(clippy::cast_possible_truncation, reason = "light is single precision")]
        let gain = gain as f32;
        let white = self
            .outside
            .mean_radiance(environment)
            .map(|light| light * gain);
        Ok(Overlay::of_pixels(
            (self.size, self.f_px),
            environment,
            optics,
            |x, y| {
                let glass = self.spread.glass(x + self.margin, y + self.margin);
                let share = self.dashboard.glass_in([x, y], self.size, 1);
                let keep = (glass.opacity).map(|opacity| (1.0 - share * opacity).clamp(0.0, 1.0));
                let add = std::array::from_fn(|c| share * (white[c] * glass.light[c]).max(0.0));
                (keep, add)
            },
        ))
    }

    /// The greatest opacity of each pixel's colors as if the glass were in focus, 255 = opaque.
    #[must_use]
    pub fn coverage(&self) -> GrayImage {
        self.coverage.clone()
    }
}
