//! The named sets of parameters, and how severity scales them.

use toml::{Table, Value};

use super::error::{Place, RecipeError};
use super::faults::{FAULTS, SCENARIOS};
use super::known_keys;
use super::parse_table;
use super::tables::{Choice, KindWord, ModelWord, OpticsWord};

/// Names of the presets, with what each is for.
pub const PRESETS: [(&str, &str); 11] = [
    (
        "windshield-star",
        "a sharp stone on a laminated windscreen: straight legs out of one point",
    ),
    (
        "windshield-bullseye",
        "a round stone on a laminated windscreen: a cone",
    ),
    (
        "windshield-combination",
        "a heavy stone on a laminated windscreen: cone and legs",
    ),
    (
        "windshield-long-crack",
        "a star that cold and the frame drive on into a long crack",
    ),
    (
        "windshield-spiderweb",
        "a heavy, blunt body on a laminated windscreen: both plies, a web of radial cracks and chords",
    ),
    (
        "windshield-gravel",
        "a season of stones on a laminated windscreen: pits, small stars and cones",
    ),
    (
        "windshield-hail",
        "hail on a laminated windscreen: stars and webs",
    ),
    (
        "tempered-cover",
        "a tempered cover before a camera: the whole pane goes to dice",
    ),
    (
        "lens-cover-star",
        "a small annealed disc right before the lens",
    ),
    (
        "lens-cover-shattered",
        "an annealed cover in shards, of which some have fallen out",
    ),
    (
        "paper",
        "the model of \"Fractured Glass, Failing Cameras\": stress propagation and grey cracks",
    ),
];

/// The preset of a command without flags.
pub const DEFAULT_PRESET: &str = "windshield-spiderweb";

/// The preset that recipes are filled in from, without what makes it a scenario of its own: a long
/// crack, and a reach at which all stops.
const BASE_PRESET: &str = "windshield-star";

/// The severities of a preset; its own is 3.
const SEVERITIES: std::ops::RangeInclusive<u8> = 1..=5;

/// Keys of `[glass]` that only some kinds have.
pub(super) const KEYS_OF_KINDS: [&str; 4] = [
    "interlayer_thickness_mm",
    "interlayer_modulus_mpa",
    "inner_thickness_mm",
    "surface_compression_mpa",
];

/// What fills in the tables that a recipe of these models leaves out: those of the preset with
/// this fracture model, shown as by the preset with these optics.
pub(super) fn base(choice: Choice) -> Result<Table, RecipeError> {
    let breaks = match choice.fracture {
        ModelWord::Physics | ModelWord::None => BASE_PRESET,
        ModelWord::Paper => "paper",
    };
    let shows = match choice.optics {
        OpticsWord::Physical => BASE_PRESET,
        OpticsWord::Paper => "paper",
    };
    let mut table = Preset::named(breaks)?.table;
    table.remove("long_crack");
    if let Some(Value::Table(fracture)) = table.get_mut("fracture")
        && choice.fracture == ModelWord::Physics
    {
        fracture.insert("until_reach_mm".to_owned(), "end".into());
    }
    for (name, of) in [("camera", shows), ("optics", shows), ("glass", BASE_PRESET)] {
        table.insert(name.to_owned(), table_of(of, name)?.into());
    }
    known_keys::retain(&mut table, choice);
    if choice.fracture == ModelWord::None {
        table.remove("glass");
        let whole = Table::from_iter([("model".to_owned(), choice.fracture.name().into())]);
        table.insert("fracture".to_owned(), whole.into());
    }
    Ok(table)
}

/// A preset, and what severity makes of it.
pub(super) struct Preset {
    pub(super) table: Table,
    severity: Table,
}

impl Preset {
    /// A preset, or a fault of a scenario alone, by the scenario's name and the fault's table with a dot between.
    pub(super) fn named(name: &str) -> Result<Self, RecipeError> {
        let Some((scenario, table)) = name.split_once('.') else {
            return Self::whole(name);
        };
        let known = SCENARIOS.iter().find(|it| it.preset.0 == scenario);
        match known {
            Some(it) if it.faults.contains(&table) => Ok(Self::whole(scenario)?
                .without(|fault| it.faults.contains(&fault) && fault != table)),
            Some(it) => Err(RecipeError::unknown_part(name, it)),
            None => Err(RecipeError::unknown_preset(name)),
        }
    }

    /// Without some tables, and a pane on which then nothing lies.
    fn without(mut self, is_out: impl Fn(&str) -> bool) -> Self {
        self.table.retain(|table, _| !is_out(table));
        self.severity
            .retain(|key, _| !key.split('.').next().is_some_and(&is_out));
        let mut faults = FAULTS.iter().filter(|fault| fault.needs_pane());
        if !faults.any(|fault| self.table.contains_key(fault.table)) {
            self.table.remove("glass");
        }
        self
    }

    fn whole(name: &str) -> Result<Self, RecipeError> {
        let text = match name {
            "windshield-star" => include_str!("../../presets/windshield-star.toml"),
            "windshield-bullseye" => include_str!("../../presets/windshield-bullseye.toml"),
            "windshield-combination" => include_str!("../../presets/windshield-combination.toml"),
            "windshield-long-crack" => include_str!("../../presets/windshield-long-crack.toml"),
            "windshield-spiderweb" => include_str!("../../presets/windshield-spiderweb.toml"),
            "windshield-gravel" => include_str!("../../presets/windshield-gravel.toml"),
            "windshield-hail" => include_str!("../../presets/windshield-hail.toml"),
            "tempered-cover" => include_str!("../../presets/tempered-cover.toml"),
            "lens-cover-star" => include_str!("../../presets/lens-cover-star.toml"),
            "lens-cover-shattered" => {
                include_str!("../../presets/lens-cover-shattered.toml")
            }
            "paper" => include_str!("../../presets/paper.toml"),
            "muddy" => include_str!("../../presets/muddy.toml"),
            "dusty" => include_str!("../../presets/dusty.toml"),
            "greasy" => include_str!("../../presets/greasy.toml"),
            "frosted" => include_str!("../../presets/frosted.toml"),
            "scratched" => include_str!("../../presets/scratched.toml"),
            "rain" => include_str!("../../presets/rain.toml"),
            "fogged" => include_str!("../../presets/fogged.toml"),
            "distortion" => include_str!("../../presets/distortion.toml"),
            "fringes" => include_str!("../../presets/fringes.toml"),
            "defocus" => include_str!("../../presets/defocus.toml"),
            "shake" => include_str!("../../presets/shake.toml"),
            "ghosts" => include_str!("../../presets/ghosts.toml"),
            "star-burst" => include_str!("../../presets/star-burst.toml"),
            "glare" => include_str!("../../presets/glare.toml"),
            "shading" => include_str!("../../presets/shading.toml"),
            "overexposed" => include_str!("../../presets/overexposed.toml"),
            "underexposed" => include_str!("../../presets/underexposed.toml"),
            "banding" => include_str!("../../presets/banding.toml"),
            "noise" => include_str!("../../presets/noise.toml"),
            "pixels" => include_str!("../../presets/pixels.toml"),
            "lines" => include_str!("../../presets/lines.toml"),
            "led-banding" => include_str!("../../presets/led-banding.toml"),
            "spots" => include_str!("../../presets/spots.toml"),
            "no-filters" => include_str!("../../presets/no-filters.toml"),
            "no-demosaicing" => include_str!("../../presets/no-demosaicing.toml"),
            "no-sharpening" => include_str!("../../presets/no-sharpening.toml"),
            "no-white-balance" => include_str!("../../presets/no-white-balance.toml"),
            "no-color-matrix" => include_str!("../../presets/no-color-matrix.toml"),
            "no-black-level" => include_str!("../../presets/no-black-level.toml"),
            "no-tone-curve" => include_str!("../../presets/no-tone-curve.toml"),
            "bit-errors" => include_str!("../../presets/bit-errors.toml"),
            "compression" => include_str!("../../presets/compression.toml"),
            "row-alias" => include_str!("../../presets/row-alias.toml"),
            "blank-frames" => include_str!("../../presets/blank-frames.toml"),
            "rainy-drive" => include_str!("../../presets/rainy-drive.toml"),
            "winter-morning" => include_str!("../../presets/winter-morning.toml"),
            "night-drive" => include_str!("../../presets/night-drive.toml"),
            "car-wash" => include_str!("../../presets/car-wash.toml"),
            "desert-track" => include_str!("../../presets/desert-track.toml"),
            _ => return Err(RecipeError::unknown_preset(name)),
        };
        let mut table = parse_table(&Place::preset(name), text)?;
        let severity = match table.remove("severity") {
            Some(Value::Table(severity)) => severity,
            _ => Table::new(),
        };
        Ok(Self { table, severity })
    }

    /// What this severity sets: keys and values.
    pub(super) fn at(&self, severity: u8) -> Result<Vec<(&str, Value)>, RecipeError> {
        if !SEVERITIES.contains(&severity) {
            return Err(RecipeError::Severity {
                found: severity.into(),
            });
        }
        let mut values = Vec::new();
        for (key, five) in &self.severity {
            if let Some(value) = five.get(usize::from(severity - 1)) {
                values.push((key.as_str(), value.clone()));
            }
        }
        Ok(values)
    }
}

/// The `[glass]` table that fills in what a recipe leaves out of a pane of this kind: that of the
/// preset that has one.
pub(super) fn glass_of(kind: KindWord) -> Result<Table, RecipeError> {
    let preset = match kind {
        KindWord::Annealed | KindWord::Laminated => BASE_PRESET,
        KindWord::Tempered => "tempered-cover",
        KindWord::Cover => "lens-cover-star",
    };
    let mut glass = table_of(preset, "glass")?;
    if kind == KindWord::Annealed {
        for key in KEYS_OF_KINDS {
            glass.remove(key);
        }
    }
    Ok(glass)
}

/// The pane of a recipe under which nothing breaks, where something lies on it.
pub(super) fn whole_pane() -> Result<Table, RecipeError> {
    let mut glass = table_of(BASE_PRESET, "glass")?;
    glass.retain(|key, _| ["thickness_mm", "distance_m", "rake_deg"].contains(&key));
    Ok(glass)
}

/// What fills in a table that a recipe may leave out as a whole; none for other tables.
pub(super) fn optional(name: &str) -> Result<Option<Table>, RecipeError> {
    let fault = FAULTS.iter().find(|fault| fault.table == name);
    let preset = match (name, fault.and_then(|fault| fault.presets.first())) {
        ("long_crack", _) => "windshield-long-crack",
        ("lens", _) => {
            return Ok(Some(Table::from_iter([(
                "headroom".to_owned(),
                1.0.into(),
            )])));
        }
        ("sensor", _) => return Ok(Some(Table::from_iter([("number".to_owned(), 0.into())]))),
        // Of several faults in a table those are on that it names.
        ("distortion" | "fringes" | "defocus" | "isp" | "link" | "frames", _) => {
            let works = parse_table(
                &Place::preset("working"),
                include_str!("../../presets/working.toml"),
            )?;
            return Ok(works.get(name).and_then(Value::as_table).cloned());
        }
        (_, Some((preset, _))) => preset,
        (_, None) => return Ok(None),
    };
    table_of(preset, name).map(Some)
}

fn table_of(preset: &str, name: &str) -> Result<Table, RecipeError> {
    match Preset::named(preset)?.table.remove(name) {
        Some(Value::Table(table)) => Ok(table),
        _ => Ok(Table::new()),
    }
}
