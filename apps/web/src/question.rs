//! What a page asks.

use serde::Deserialize;
use starbreak::{Assignment, DEFAULT_PRESET, Recipe};

use crate::Trouble;

/// Most memory of one picture, bytes: a page has 4 GiB, and the picture itself lies there, too.
const MAX_MEMORY_BYTES: u64 = 2 << 30;

/// One question; some come with bytes.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case", deny_unknown_fields)]
pub enum Question {
    /// What there is: presets, cameras, keys.
    Catalog,
    /// Puts the street that is built in before the camera.
    Street,
    /// Puts a picture before it: the bytes of a file.
    Picture {
        /// Its file name, which the seed is keyed by.
        name: String,
    },
    /// Breaks the glass and shows it.
    Break(Scene),
    /// The same glass when a share of the length of its cracks is there.
    Grown {
        /// The share, 0 to 1.
        share: f64,
    },
    /// The cracks that the frame shows: numbers of 32 bits, little-endian, seven for each piece: x₀, y₀, x₁, y₁ in px,
    /// its arrival in the unit of the network, the stress that drove it and its depth as a share of the ply; what is
    /// not known is NaN.
    Cracks,
    /// What can be taken away.
    File {
        /// `picture`, `clean`, `region`, `crack`, `network.json`, `network.svg` or `recipe`.
        what: crate::file::File,
    },
    /// Puts the glass over a frame of a camera, four bytes a pixel.
    Frame {
        /// Its width, px.
        width_px: u32,
        /// Its height, px.
        height_px: u32,
    },
}

/// A recipe as a page has it, with the seed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// A preset; the command's own where there is none.
    #[serde(default)]
    pub preset: Option<String>,
    /// 1 to 5.
    #[serde(default)]
    pub severity: Option<u8>,
    /// A named camera.
    #[serde(default)]
    pub camera: Option<String>,
    /// Single keys, as `--set` has them.
    #[serde(default)]
    pub set: Vec<String>,
    /// Where stones hit, in the place of the recipe's own.
    #[serde(default)]
    pub hits: Vec<Hit>,
    /// The seed of the command.
    #[serde(default)]
    pub seed: u64,
    /// Whether a coarse mesh will do, for a moment.
    #[serde(default)]
    pub is_draft: bool,
}

/// A stone that somebody threw.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hit {
    /// Where, as fractions of the frame.
    pub position: [f64; 2],
    /// Its direction in the plane of the pane, degrees from +x towards +y (down).
    #[serde(default)]
    pub azimuth_deg: Option<f64>,
    /// Its speed, m/s.
    #[serde(default)]
    pub speed_m_s: Option<f64>,
}

impl Scene {
    /// The recipe without hits and draft.
    fn base(&self) -> Result<Recipe, Trouble> {
        let preset = self.preset.as_deref().unwrap_or(DEFAULT_PRESET);
        let mut recipe = match self.severity {
            Some(severity) => Recipe::preset_at(preset, severity)?,
            None => Recipe::preset(preset)?,
        };
        let assignments = self.set.iter().map(|text| Assignment::parse(text));
        let assignments: Vec<Assignment> = assignments.collect::<Result<_, _>>()?;
        recipe.adjust(self.camera.as_deref(), &assignments)?;
        Ok(recipe)
    }

    /// What `--set` makes of a hit that is alone; of none or several nothing.
    ///
    /// # Errors
    /// [`Trouble::Recipe`].
    pub fn assignments(&self) -> Result<Vec<String>, Trouble> {
        Ok(match self.hits.as_slice() {
            [hit] => hit.assignments(&self.base()?),
            _ => Vec::new(),
        })
    }

    /// The recipe. A hit alone is what `--set` makes of it, so that the command can say it.
    ///
    /// # Errors
    /// [`Trouble::Recipe`].
    pub fn recipe(&self) -> Result<Recipe, Trouble> {
        let mut recipe = self.base()?;
        match self.hits.as_slice() {
            [] => {}
            [hit] => {
                for text in hit.assignments(&recipe) {
                    recipe.set(&text)?;
                }
            }
            many => {
                let is_end_set =
                    (self.set.iter()).any(|text| text.starts_with("fracture.until_reach_mm"));
                recipe = with_hits(&recipe, many, !is_end_set)?;
            }
        }
        if self.is_draft && recipe.to_json()["fracture"].get("mesh").is_some() {
            recipe.set("fracture.mesh=\"fast\"")?;
        }
        recipe.set_max_memory(MAX_MEMORY_BYTES);
        Ok(recipe)
    }
}

impl Hit {
    /// As `--set` has it: every stone of the recipe hits here, each of them once. Nothing where none breaks anything.
    fn assignments(&self, recipe: &Recipe) -> Vec<String> {
        let tables = recipe.to_json();
        let stone = &tables["impact"][0];
        if stone.is_null() {
            return Vec::new();
        }
        let has = |key: &str| stone.get(key).is_some();
        let [x, y] = self.position;
        let mut all = vec![format!("impact.position=[{x:?}, {y:?}]")];
        if has("count") && stone["count"] != 1 {
            all.push("impact.count=1".to_owned());
        }
        for (key, value) in self.values() {
            if has(key) {
                all.push(format!("impact.{key}={value:?}"));
            }
        }
        all
    }

    /// By key; the paper's model has a direction of its own, and no speed.
    fn values(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let both = [
            ("azimuth_deg", self.azimuth_deg),
            ("direction_deg", self.azimuth_deg),
            ("speed_m_s", self.speed_m_s),
        ];
        both.into_iter()
            .filter_map(|(key, value)| Some((key, value?)))
    }
}

/// The first stone of a recipe, once for each hit. Later ones come when the cracks of the first have ended: a
/// severity would stop everything before they do. A recipe without stones stays as it is.
fn with_hits(recipe: &Recipe, hits: &[Hit], run_to_end: bool) -> Result<Recipe, Trouble> {
    let mut tables = recipe.to_json();
    if run_to_end && let Some(reach) = tables["fracture"].get_mut("until_reach_mm") {
        *reach = "end".into();
    }
    let stone = tables["impact"][0].clone();
    if stone.is_null() {
        return Ok(recipe.clone());
    }
    let impacts = hits.iter().map(|hit| {
        let mut stone = stone.clone();
        stone["position"] = hit.position.as_slice().into();
        for (key, value) in hit.values() {
            if let Some(kept) = stone.get_mut(key) {
                *kept = value.into();
            }
        }
        if let Some(count) = stone.get_mut("count") {
            *count = 1.into();
        }
        stone
    });
    tables["impact"] = impacts.collect();
    Ok(Recipe::from_json("recipe", &tables)?)
}
