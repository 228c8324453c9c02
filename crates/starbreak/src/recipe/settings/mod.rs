//! The recipe as it is used: SI units, every value in range.

mod deposits;
mod faults;
mod lens_faults;
mod paper;
mod paper_optics;
mod physical;
mod physics;
mod ranges;

use rand_chacha::rand_core::Rng;
use starbreak_deposit::{Coat, Rain};
use starbreak_fracture::paper::{Direction, Position};
use starbreak_glass::MAX_IMPACTS;
use starbreak_optics::paper::PaperOptics;
use starbreak_optics::physical::PhysicalOptics;
use starbreak_seed::{Seed, Stream};
use toml::Table;

pub use paper::PaperSettings;
pub use physics::{Mount, PhysicsSettings, StoneSettings};

use super::error::{Place, RecipeError, short_number};
use super::tables::{
    Choice, CommonTables, DirectionEntry, FocalEntry, FormatWord, ModelWord, OpticsWord,
    OutputTable, PositionEntry, PositionWord, WholePaneTables, from_table,
};
use crate::CameraFaults;

/// Most memory of one picture, bytes, unless a recipe is given another limit: 4 GiB.
pub const DEFAULT_MAX_MEMORY_BYTES: u64 = 4 << 30;

/// Least limit of that, bytes, within which the least pane breaks.
pub const LEAST_MAX_MEMORY_BYTES: u64 = 64 << 20;

/// Everything that a run needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// How the glass breaks, by which model.
    pub fracture: FractureSettings,
    /// The camera behind the glass.
    pub camera: CameraSettings,
    /// How the crack looks, by which model.
    pub optics: OpticsSettings,
    /// Rain on the pane, where it is any.
    pub drops: Option<Rain>,
    /// Coats on the pane, outer ones first.
    pub coats: Vec<Coat>,
    /// What is wrong with the camera itself, where anything is.
    pub faults: Option<CameraFaults>,
    /// What is written.
    pub output: OutputSettings,
    /// Most memory of one picture, bytes; no part of the recipe's text.
    pub max_memory_bytes: u64,
}

impl Settings {
    /// Whether the camera moves what images show, so that their labels no longer fit.
    #[must_use]
    pub fn moves_labels(&self) -> bool {
        (self.faults.as_ref()).is_some_and(|faults| faults.lens.moves_labels())
    }
}

/// How the glass breaks.
#[derive(Debug, Clone, PartialEq)]
pub enum FractureSettings {
    /// By the paper's model, on a pane as large as the frame.
    Paper(PaperSettings),
    /// By the physics, on a pane of its own before the camera.
    Physics(Box<PhysicsSettings>),
    /// Not at all. Where nothing lies on it there is no pane either.
    None(Option<Mount>),
}

impl FractureSettings {
    /// How the pane stands before the camera; none where the paper's cracks lie in the frame
    /// itself.
    #[must_use]
    pub fn mount(&self) -> Option<Mount> {
        match self {
            Self::Paper(paper) => paper.mount,
            Self::Physics(physics) => Some(physics.mount),
            Self::None(mount) => *mount,
        }
    }

    /// Whether an impact is to be before a labeled object.
    #[must_use]
    pub fn is_aimed(&self) -> bool {
        match self {
            Self::Paper(paper) => paper.aimed.iter().any(|is_aimed| *is_aimed),
            Self::Physics(physics) => physics.stones.iter().any(|stone| stone.is_aimed),
            Self::None(_) => false,
        }
    }

    /// The same with the impacts that are to be before an object, of several stones the first, each
    /// before one of these, drawn by the seed: their middles, as fractions of the frame. Without any
    /// they are where random ones are.
    #[must_use]
    pub fn aimed_at(&self, objects: &[[f64; 2]], seed: Seed) -> Self {
        let drawn = |k: u64| {
            let bits = seed.stream(Stream::ImpactPosition, k).next_u64();
            let idx = bits.checked_rem(objects.len() as u64)?;
            let [x, y] = objects[usize::try_from(idx).ok()?];
            Some(Position::At { x, y })
        };
        let mut aimed = self.clone();
        match &mut aimed {
            Self::Paper(paper) => paper.aim(drawn),
            Self::Physics(physics) => physics.aim(drawn),
            Self::None(_) => {}
        }
        aimed
    }
}

/// How the crack looks.
#[derive(Debug, Clone, PartialEq)]
pub enum OpticsSettings {
    /// As in the paper: grey lines.
    Paper(PaperOptics),
    /// By the light that the glass mirrors, scatters and takes away.
    Physical(Box<PhysicalOptics>),
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
    /// JPEG quality, 1 to 100.
    pub quality: u8,
    /// Whether the region mask and the crack mask are written.
    pub masks: bool,
    /// Whether the maps of the physical optics are written.
    pub maps: bool,
    /// Whether the region mask tells how much of the scene's light comes through.
    pub classes: bool,
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

/// The settings of a recipe that is complete.
pub(super) fn of(place: &Place, recipe: &Table, choice: Choice) -> Result<Settings, RecipeError> {
    ranges::check(place, recipe, choice)?;
    let common: CommonTables = from_table(place, recipe)?;
    // The glass before the camera, and how it stands there.
    let (fracture, sheet) = match choice.fracture {
        ModelWord::Paper => {
            let sheet = match choice.optics {
                OpticsWord::Physical => Some(physical::mount(place, recipe)?),
                OpticsWord::Paper => None,
            };
            let mount = sheet.map(|sheet| sheet.mount);
            let paper = paper::settings(place, &from_table(place, recipe)?, mount)?;
            (FractureSettings::Paper(paper), sheet)
        }
        ModelWord::Physics => {
            let physics = physics::settings(place, &from_table(place, recipe)?)?;
            let sheet = physical::Sheet::of(&physics);
            (FractureSettings::Physics(Box::new(physics)), Some(sheet))
        }
        ModelWord::None => {
            let whole: WholePaneTables = from_table(place, recipe)?;
            let sheet = whole.glass.map(|glass| physical::Sheet::mounted(&glass));
            let mount = sheet.map(|sheet| sheet.mount);
            let sheet = sheet.unwrap_or(physical::Sheet::NONE);
            (FractureSettings::None(mount), Some(sheet))
        }
    };
    let (camera, optics) = match sheet {
        Some(sheet) if choice.optics == OpticsWord::Physical => {
            physical::settings(place, &from_table(place, recipe)?, sheet)?
        }
        _ => paper_optics::settings(place, &from_table(place, recipe)?)?,
    };
    let faults = CameraFaults {
        lens: lens_faults::settings(place, &from_table(place, recipe)?, &optics)?,
        sensor: faults::settings(place, &from_table(place, recipe)?)?,
    };
    let coats = deposits::coats(place, &from_table(place, recipe)?, &fracture, &optics)?;
    if common.output.maps && !coats.is_empty() {
        return Err(RecipeError::Type {
            place: place.clone(),
            key: "output.maps".to_owned(),
            what: "maps hold what cracks and drops do to light, not what mud, dust, film, frost, scratches and \
                   condensation do; leave it false, or those tables out"
                .to_owned(),
        });
    }
    Ok(Settings {
        coats,
        drops: deposits::drops(place, &from_table(place, recipe)?, &fracture, &optics)?,
        output: output(place, &common.output, &optics)?,
        fracture,
        camera,
        optics,
        // Lamps are brighter than white before the glass, too.
        faults: (!faults.is_empty() || faults.lens.headroom() > 1.0).then_some(faults),
        max_memory_bytes: DEFAULT_MAX_MEMORY_BYTES,
    })
}

fn out_of_range(place: &Place, key: &str, value: impl ToString, expected: &str) -> RecipeError {
    RecipeError::Range {
        place: place.clone(),
        key: key.to_owned(),
        value: short_number(value.to_string()),
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

/// Whether an impact is to be before a labeled object.
fn is_aimed(entry: PositionEntry) -> bool {
    entry == PositionEntry::Word(PositionWord::Object)
}

/// Share of either side of the frame that a random place lies in, around the middle.
const INNER_SHARE: f64 = 0.8;

fn position(entry: PositionEntry) -> Position {
    match entry {
        PositionEntry::Word(word) => Position::Random {
            share: match word {
                PositionWord::Random | PositionWord::Object => INNER_SHARE,
                PositionWord::Anywhere => 1.0,
            },
        },
        PositionEntry::Fractions([x, y]) => Position::At { x, y },
    }
}

fn direction(entry: DirectionEntry) -> Direction {
    match entry {
        DirectionEntry::Random(_) => Direction::Random,
        DirectionEntry::Degrees(degrees) => Direction::Angle {
            rad: degrees.to_radians(),
        },
    }
}

fn focal_length(given: FocalEntry) -> FocalLength {
    match given {
        FocalEntry::Auto(_) => FocalLength::Auto,
        FocalEntry::Px(f_px) => FocalLength::Px(f_px),
    }
}

fn output(
    place: &Place,
    given: &OutputTable,
    optics: &OpticsSettings,
) -> Result<OutputSettings, RecipeError> {
    let of_physical = [
        (given.maps, "output.maps", "maps"),
        (given.classes, "output.classes", "classes of light"),
    ];
    for (is_asked, key, what) in of_physical {
        if is_asked && matches!(optics, OpticsSettings::Paper(_)) {
            return Err(RecipeError::Type {
                place: place.clone(),
                key: key.to_owned(),
                what: format!(
                    "the paper's optics have no {what}; leave it false or set optics.model = \"physical\""
                ),
            });
        }
    }
    let format = match given.format {
        FormatWord::Same => OutputFormat::Same,
        FormatWord::Png => OutputFormat::Png,
        FormatWord::Jpeg => OutputFormat::Jpeg,
    };
    Ok(OutputSettings {
        format,
        quality: given.quality,
        masks: given.masks,
        maps: given.maps,
        classes: given.classes,
    })
}
