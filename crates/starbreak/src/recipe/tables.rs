//! The recipe as it is written: its keys, their types and what each means. The one definition
//! that the parser, the JSON Schema and the printed comments come from.

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use toml::Table;

pub(super) use super::deposit_tables::DepositTables;
use super::error::{Place, RecipeError, printable};
pub(super) use super::fault_tables::{
    BandingTable, CfaTable, ExposureTable, FaultTables, FramesTable, IspTable, LinesTable,
    LinkTable, MosaicTable, NoiseTable, PixelsTable, RawWord, SpotsTable,
};
pub(super) use super::lens_tables::{
    DefocusTable, DistortionTable, FringesTable, GhostsTable, GlareTable, LensTables,
    ProjectionWord, ShadingTable, ShakeTable, StarTable,
};
pub(super) use super::paper_tables::{
    FarFocusBlurWord, FocusEntry, FocusWord, LightEntry, NeighborhoodWord, NormalizationWord,
    PaperFractureTables, PaperImpactTable, PaperOpticsTables, RuleWord,
};
pub(super) use super::physical_tables::{
    AutoRgb, CabinEntry, DistanceEntry, DistanceWord, GlassMountTables, MountTable,
    PhysicalCameraTable, PhysicalOpticsTable, PhysicalOpticsTables, SceneEntry,
};
pub(super) use super::physics_tables::{
    DicingWord, GlassTable, GrowthWord, KindWord, LongCrackTable, MeshWord, OriginWord,
    PhysicsFractureTable, PhysicsFractureTables, ReachEntry, StoneTable, StoneWord, SupportWord,
};
use crate::plain_words::in_plain_words;

/// A choice of models: one that breaks the glass, one that shows it. It decides which keys a
/// recipe has; any of the one goes with any of the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Choice {
    pub(super) fracture: ModelWord,
    pub(super) optics: OpticsWord,
}

impl Choice {
    /// All of them, the default one first.
    pub(super) const ALL: [Self; 6] = [
        Self::new(ModelWord::Physics, OpticsWord::Physical),
        Self::new(ModelWord::Physics, OpticsWord::Paper),
        Self::new(ModelWord::Paper, OpticsWord::Physical),
        Self::new(ModelWord::Paper, OpticsWord::Paper),
        Self::new(ModelWord::None, OpticsWord::Physical),
        Self::new(ModelWord::None, OpticsWord::Paper),
    ];

    pub(super) const fn new(fracture: ModelWord, optics: OpticsWord) -> Self {
        Self { fracture, optics }
    }
}

/// What every recipe has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct CommonTables {
    /// Version of the recipe format.
    pub(super) schema: i64,
    /// What is written.
    pub(super) output: OutputTable,
}

/// The fracture models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum ModelWord {
    /// Contact, plate stress and crack tips, in SI units.
    Physics,
    /// As in "Fractured Glass, Failing Cameras".
    Paper,
    /// Nothing breaks.
    None,
}

impl ModelWord {
    pub(super) const ALL: [Self; 3] = [Self::Physics, Self::Paper, Self::None];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Physics => "physics",
            Self::Paper => "paper",
            Self::None => "none",
        }
    }
}

/// What a recipe has under which nothing breaks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct WholeTables {
    /// How the glass breaks.
    pub(super) fracture: WholeTable,
}

/// The pane of such a recipe, which the physical optics see.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(super) struct WholePaneTables {
    /// The pane, and how it stands before the camera. Without this table there is none.
    #[schemars(with = "MountTable")]
    pub(super) glass: Option<MountTable>,
}

/// How the glass breaks: not at all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WholeTable {
    /// Fracture model: "physics", "paper", or "none" where the glass is whole.
    pub(super) model: ModelWord,
}

/// The optics models.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum OpticsWord {
    /// Mirrors, glints and crushed glass through a real lens, in linear light.
    Physical,
    /// As in "Fractured Glass, Failing Cameras".
    Paper,
}

impl OpticsWord {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Physical => "physical",
            Self::Paper => "paper",
        }
    }

    pub(super) const fn other(self) -> Self {
        match self {
            Self::Physical => Self::Paper,
            Self::Paper => Self::Physical,
        }
    }
}

/// Focal length of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected \"auto\" or a focal length in px")]
pub(super) enum FocalEntry {
    /// In px.
    Px(f64),
    /// That of KITTI's field of view.
    Auto(AutoWord),
}

/// `"auto"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum AutoWord {
    /// From the width of the frame.
    Auto,
}

/// `"random"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RandomWord {
    /// Drawn from the seed.
    Random,
}

/// Where a random place may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum PositionWord {
    /// In the inner 80 % of width and height.
    Random,
    /// Anywhere in the frame.
    Anywhere,
    /// Before a labeled object of the image, of several stones the first; as random where there
    /// is none.
    Object,
}

/// A place in the frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected \"random\", \"anywhere\", \"object\" or [x, y] as fractions of the frame"
)]
pub(super) enum PositionEntry {
    /// Fractions of width and height, 0 to 1.
    Fractions([f64; 2]),
    /// Drawn from the seed.
    Word(PositionWord),
}

/// A direction in the plane of the glass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected \"random\" or an angle in degrees")]
pub(super) enum DirectionEntry {
    /// An angle.
    Degrees(f64),
    /// Drawn from the seed.
    Random(RandomWord),
}

/// What is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct OutputTable {
    /// Format of cracked images: "same" as the input, "png" or "jpeg". JPEG re-encodes every
    /// pixel; with "png" all pixels that the crack does not touch are those of the input as this
    /// program decodes it (decoders of JPEG differ by a few levels), unless the scene is out of focus.
    pub(super) format: FormatWord,
    /// JPEG quality, 1 to 100.
    #[schemars(range(min = 1, max = 100))]
    pub(super) quality: u8,
    /// Whether the region mask and the crack mask are written.
    pub(super) masks: bool,
    /// Whether the maps of what the glass does to the light are written as NumPy arrays:
    /// attenuation, added light, displacement, coverage. The physical optics only.
    pub(super) maps: bool,
    /// Whether the region mask says how much of the scene's light comes through: 85 most of it
    /// (transparent), 170 less than 60 percent (semi-transparent), 255 less than 10 (opaque). Otherwise
    /// it is 255 wherever anything changes. The physical optics only.
    pub(super) classes: bool,
}

/// Format of cracked images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum FormatWord {
    /// That of the input.
    Same,
    /// Lossless.
    Png,
    /// Lossy.
    Jpeg,
}

/// The tables of a recipe, each key of the right type.
pub(super) fn from_table<T: DeserializeOwned>(
    place: &Place,
    table: &Table,
) -> Result<T, RecipeError> {
    serde_path_to_error::deserialize(toml::Value::Table(table.clone())).map_err(|error| {
        RecipeError::Type {
            place: place.clone(),
            key: error.path().to_string().replace('[', ".").replace(']', ""),
            what: printable(&in_plain_words(error.inner().message())),
        }
    })
}
