//! Settings of the paper's optics.

use starbreak_optics::paper::{FarFocusBlur, Focus, Light, Normalization, PaperOptics};

use super::super::error::{Place, RecipeError};
use super::super::tables::{
    FarFocusBlurWord, FocusEntry, FocusWord, LightEntry, NormalizationWord, PaperOpticsTables,
};
use super::{CameraSettings, OpticsSettings, focal_length};

pub(super) fn settings(
    place: &Place,
    recipe: &PaperOpticsTables,
) -> Result<(CameraSettings, OpticsSettings), RecipeError> {
    let camera = CameraSettings {
        f_px: focal_length(recipe.camera.f_px),
    };
    let optics = parameters(recipe);
    optics
        .check()
        .map_err(|error| RecipeError::of_model(place, "optics", error))?;
    Ok((camera, OpticsSettings::Paper(optics)))
}

fn parameters(recipe: &PaperOpticsTables) -> PaperOptics {
    let given = &recipe.optics;
    PaperOptics {
        focus: match recipe.camera.focus_distance_m {
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
