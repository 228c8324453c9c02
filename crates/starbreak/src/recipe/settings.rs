//! The recipe as it is used: SI units, every value in range.

use starbreak_dataset::JpegQuality;
use starbreak_fracture::paper::{
    Direction, Neighborhood, PaperImpact, PaperParams, Position, Rule,
};
use starbreak_glass::Pane;
use starbreak_optics::paper::{FarFocusBlur, Focus, Light, Normalization, PaperOptics};

use super::error::{Place, RecipeError};
use super::tables::{
    DirectionEntry, FarFocusBlurWord, FocusEntry, FocusWord, FormatWord, ImpactTable, LightEntry,
    NeighborhoodWord, NormalizationWord, PositionEntry, RecipeTables, RuleWord,
};

/// Most impacts on one pane.
const MAX_IMPACTS: usize = 1000;

/// Everything that a run needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Parameters of the fracture model.
    pub fracture: PaperParams,
    /// Parameters of the optics.
    pub optics: PaperOptics,
    /// What is written.
    pub output: OutputSettings,
    /// Impacts on a pane of one by one.
    unit_impacts: Vec<PaperImpact>,
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

impl Settings {
    /// The impacts on a given pane.
    #[must_use]
    pub fn impacts_on(&self, pane: &Pane) -> Vec<PaperImpact> {
        let on_pane = |impact: &PaperImpact| match impact.position {
            Position::Random => *impact,
            Position::At { x, y } => PaperImpact {
                position: Position::At {
                    x: x * pane.width,
                    y: y * pane.height,
                },
                ..*impact
            },
        };
        self.unit_impacts.iter().map(on_pane).collect()
    }
}

pub(super) fn from_tables(place: &Place, tables: &RecipeTables) -> Result<Settings, RecipeError> {
    if tables.impact.is_empty() || tables.impact.len() > MAX_IMPACTS {
        return Err(RecipeError::Range {
            place: place.clone(),
            key: "number of [[impact]] tables".to_owned(),
            value: tables.impact.len().to_string(),
            expected: format!("1 to {MAX_IMPACTS}"),
        });
    }
    let unit_impacts = tables
        .impact
        .iter()
        .enumerate()
        .map(|(k, impact)| unit_impact(place, k, impact));
    let unit_impacts = unit_impacts.collect::<Result<Vec<_>, _>>()?;
    let given = &tables.fracture;
    let fracture = PaperParams {
        particles: given.particles,
        neighbor_radius: given.neighbour_radius_px,
        neighborhood: match given.neighbourhood {
            NeighborhoodWord::Radius => Neighborhood::Radius,
            NeighborhoodWord::MeshEdges => Neighborhood::MeshEdges,
        },
        critical_stress: given.critical_stress,
        safety_factor: given.safety_factor,
        rule: match given.rule {
            RuleWord::Algorithm1 => Rule::Algorithm1,
            RuleWord::Caption => Rule::Caption,
            RuleWord::Literal => Rule::Literal,
        },
        branches: given.branches,
        two_sided: given.two_sided,
        snap_to_mesh: given.snap_to_mesh,
    };
    fracture
        .check()
        .map_err(|error| RecipeError::of_fracture(place, "fracture", error))?;
    for (key, degrees) in [
        ("sun_azimuth_deg", tables.optics.sun_azimuth_deg),
        ("sun_elevation_deg", tables.optics.sun_elevation_deg),
    ] {
        // Checked before it becomes a zenith angle, so that the message repeats what was given.
        if !degrees.is_finite() {
            return Err(RecipeError::Range {
                place: place.clone(),
                key: format!("optics.{key}"),
                value: degrees.to_string(),
                expected: "a finite angle".to_owned(),
            });
        }
    }
    let optics = optics(tables);
    optics
        .check()
        .map_err(|error| RecipeError::of_optics(place, error))?;
    let quality = JpegQuality::new(tables.output.quality).map_err(|_| RecipeError::Range {
        place: place.clone(),
        key: "output.quality".to_owned(),
        value: tables.output.quality.to_string(),
        expected: "1 to 100".to_owned(),
    })?;
    let format = match tables.output.format {
        FormatWord::Same => OutputFormat::Same,
        FormatWord::Png => OutputFormat::Png,
        FormatWord::Jpeg => OutputFormat::Jpeg,
    };
    let output = OutputSettings {
        format,
        quality,
        masks: tables.output.masks,
    };
    Ok(Settings {
        fracture,
        optics,
        output,
        unit_impacts,
    })
}

fn unit_impact(place: &Place, k: usize, impact: &ImpactTable) -> Result<PaperImpact, RecipeError> {
    let position = match impact.position {
        PositionEntry::Random(_) => Position::Random,
        PositionEntry::Fractions([x, y]) => {
            if !((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y)) {
                return Err(RecipeError::Range {
                    place: place.clone(),
                    key: format!("impact.{k}.position"),
                    value: format!("[{x}, {y}]"),
                    expected: "fractions of the frame, 0 to 1".to_owned(),
                });
            }
            Position::At { x, y }
        }
    };
    let direction = match impact.direction_deg {
        DirectionEntry::Random(_) => Direction::Random,
        DirectionEntry::Degrees(degrees) => Direction::Angle {
            rad: degrees.to_radians(),
        },
    };
    let resolved = PaperImpact {
        position,
        force: impact.force,
        direction,
    };
    let unit_pane = Pane {
        width: 1.0,
        height: 1.0,
        thickness_mm: None,
        kind: None,
    };
    resolved
        .check(&unit_pane)
        .map_err(|error| RecipeError::of_fracture(place, &format!("impact.{k}"), error))?;
    Ok(resolved)
}

fn optics(tables: &RecipeTables) -> PaperOptics {
    let given = &tables.optics;
    PaperOptics {
        focus: match tables.camera.focus_distance_m {
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
