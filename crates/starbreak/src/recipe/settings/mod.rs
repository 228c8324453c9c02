//! The recipe as it is used: SI units, every value in range.

mod paper;
mod physics;

use starbreak_dataset::JpegQuality;
use starbreak_fracture::paper::{Direction, Position};
use starbreak_optics::paper::{FarFocusBlur, Focus, Light, Normalization, PaperOptics};

pub use paper::PaperSettings;
pub use physics::{Mount, PhysicsSettings, StoneSettings};

use super::error::{Place, RecipeError};
use super::tables::{
    CameraTable, DirectionEntry, FarFocusBlurWord, FocalEntry, FocusEntry, FocusWord, FormatWord,
    LightEntry, NormalizationWord, OpticsTable, OutputTable, PaperRecipe, PhysicsRecipe,
    PositionEntry,
};

/// Most impacts on one pane.
const MAX_IMPACTS: usize = 1000;

/// Everything that a run needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// How the glass breaks, by which model.
    pub fracture: FractureSettings,
    /// The camera behind the glass.
    pub camera: CameraSettings,
    /// Parameters of the optics.
    pub optics: PaperOptics,
    /// What is written.
    pub output: OutputSettings,
}

/// How the glass breaks.
#[derive(Debug, Clone, PartialEq)]
pub enum FractureSettings {
    /// By the paper's model, on a pane as large as the frame.
    Paper(PaperSettings),
    /// By the physics, on a pane of its own before the camera.
    Physics(Box<PhysicsSettings>),
}

/// The camera behind the glass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSettings {
    /// Its focal length.
    pub f_px: FocalLength,
}

/// Focal length of the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FocalLength {
    /// That of KITTI's field of view.
    Auto,
    /// This one, px.
    Px(f64),
}

impl FocalLength {
    /// The focal length on a frame of this width, px.
    ///
    /// **Source** of [`FocalLength::Auto`]: KITTI's left color camera, 721.5377 px at 1242 px
    /// \[Geiger2012\].
    #[must_use]
    pub fn of_frame(self, width_px: u32) -> f64 {
        match self {
            // At least the least that a camera may have, on a frame of one pixel.
            Self::Auto => (721.5377 / 1242.0 * f64::from(width_px)).max(1.0),
            Self::Px(f_px) => f_px,
        }
    }
}

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutputSettings {
    /// Format of cracked images.
    pub format: OutputFormat,
    /// JPEG quality.
    pub quality: JpegQuality,
    /// Whether the region mask and the crack mask are written.
    pub masks: bool,
}

/// Format of cracked images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputFormat {
    /// That of the input.
    Same,
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
}

pub(super) fn of_paper(place: &Place, recipe: &PaperRecipe) -> Result<Settings, RecipeError> {
    Ok(Settings {
        fracture: FractureSettings::Paper(paper::settings(place, recipe)?),
        camera: camera(place, &recipe.camera)?,
        optics: optics(place, &recipe.camera, &recipe.optics)?,
        output: output(place, &recipe.output)?,
    })
}

pub(super) fn of_physics(place: &Place, recipe: &PhysicsRecipe) -> Result<Settings, RecipeError> {
    Ok(Settings {
        fracture: FractureSettings::Physics(Box::new(physics::settings(place, recipe)?)),
        camera: camera(place, &recipe.camera)?,
        optics: optics(place, &recipe.camera, &recipe.optics)?,
        output: output(place, &recipe.output)?,
    })
}

fn out_of_range(place: &Place, key: &str, value: impl ToString, expected: &str) -> RecipeError {
    RecipeError::Range {
        place: place.clone(),
        key: key.to_owned(),
        value: value.to_string(),
        expected: expected.to_owned(),
    }
}

/// The hits, each converted with its number.
fn impacts<T, S>(
    place: &Place,
    given: &[T],
    convert: impl Fn(usize, &T) -> Result<S, RecipeError>,
) -> Result<Vec<S>, RecipeError> {
    if given.is_empty() || given.len() > MAX_IMPACTS {
        let expected = format!("1 to {MAX_IMPACTS}");
        let key = "number of [[impact]] tables";
        return Err(out_of_range(place, key, given.len(), &expected));
    }
    let each = given
        .iter()
        .enumerate()
        .map(|(k, impact)| convert(k, impact));
    each.collect()
}

fn position(place: &Place, k: usize, entry: PositionEntry) -> Result<Position, RecipeError> {
    match entry {
        PositionEntry::Random(_) => Ok(Position::Random),
        PositionEntry::Fractions([x, y]) => {
            let key = format!("impact.{k}.position");
            fractions(place, &key, [x, y], "the frame")?;
            Ok(Position::At { x, y })
        }
    }
}

fn fractions(place: &Place, key: &str, [x, y]: [f64; 2], of: &str) -> Result<(), RecipeError> {
    if (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) {
        return Ok(());
    }
    let expected = format!("fractions of {of}, 0 to 1");
    Err(out_of_range(place, key, format!("[{x}, {y}]"), &expected))
}

fn direction(entry: DirectionEntry) -> Direction {
    match entry {
        DirectionEntry::Random(_) => Direction::Random,
        DirectionEntry::Degrees(degrees) => Direction::Angle {
            rad: degrees.to_radians(),
        },
    }
}

fn camera(place: &Place, given: &CameraTable) -> Result<CameraSettings, RecipeError> {
    let f_px = match given.f_px {
        FocalEntry::Auto(_) => FocalLength::Auto,
        FocalEntry::Px(f_px) if f_px > 0.0 && f_px <= 1e6 => FocalLength::Px(f_px),
        FocalEntry::Px(f_px) => {
            let expected = "\"auto\", or above 0 and up to 1000000 px";
            return Err(out_of_range(place, "camera.f_px", f_px, expected));
        }
    };
    Ok(CameraSettings { f_px })
}

fn output(place: &Place, given: &OutputTable) -> Result<OutputSettings, RecipeError> {
    let quality = JpegQuality::new(given.quality)
        .map_err(|_| out_of_range(place, "output.quality", given.quality, "1 to 100"))?;
    let format = match given.format {
        FormatWord::Same => OutputFormat::Same,
        FormatWord::Png => OutputFormat::Png,
        FormatWord::Jpeg => OutputFormat::Jpeg,
    };
    Ok(OutputSettings {
        format,
        quality,
        masks: given.masks,
    })
}

fn optics(
    place: &Place,
    camera: &CameraTable,
    given: &OpticsTable,
) -> Result<PaperOptics, RecipeError> {
    for (key, degrees) in [
        ("optics.sun_azimuth_deg", given.sun_azimuth_deg),
        ("optics.sun_elevation_deg", given.sun_elevation_deg),
    ] {
        // Checked before it becomes a zenith angle, so that the message repeats what was given.
        if !degrees.is_finite() {
            return Err(out_of_range(place, key, degrees, "a finite angle"));
        }
    }
    let optics = paper_optics(camera, given);
    optics
        .check()
        .map_err(|error| RecipeError::of_optics(place, error))?;
    Ok(optics)
}

fn paper_optics(camera: &CameraTable, given: &OpticsTable) -> PaperOptics {
    PaperOptics {
        focus: match camera.focus_distance_m {
            FocusEntry::Word(FocusWord::Far) => Focus::Far,
            FocusEntry::Word(FocusWord::Short) => Focus::Short,
        },
        far_focus_blur: match given.far_focus_blur {
            FarFocusBlurWord::Crack => FarFocusBlur::Crack,
            FarFocusBlurWord::CrackAndScene => FarFocusBlur::CrackAndScene,
        },
        sun_azimuth_rad: given.sun_azimuth_deg.to_radians(),
        sun_zenith_rad: (90.0 - given.sun_elevation_deg).to_radians(),
        light: match given.light_intensity {
            LightEntry::Rgb(levels) => Light::Rgb(levels),
            LightEntry::ImageMean(_) => Light::ImageMean,
        },
        normalization: match given.normalization {
            NormalizationWord::Sum => Normalization::Sum,
            NormalizationWord::Max => Normalization::Max,
            NormalizationWord::Mean => Normalization::Mean,
            NormalizationWord::One => Normalization::One,
        },
        line_width_px: given.line_width_px,
        blur_kernel_px: given.blur_kernel_px,
        blur_sigma_px: given.blur_sigma_px,
    }
}
