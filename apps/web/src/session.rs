//! One picture, the glass before it, and what a page may ask of them.

use image::{DynamicImage, RgbaImage};
use serde_json::{Map, Value, json};
use starbreak::optics::environment::Environment;
use starbreak::{
    Chain, DEFAULT_PRESET, FAULTS, OpticsSettings, Recipe, Seed, Shown, Simulated, Stopwatch,
    cameras, json_schema, presets, simulate,
};
use starbreak_dataset::{ImageLimits, decode_image, encode_mask, encode_png, street_scene};
use starbreak_web_desk::{Answer, Answers};

use crate::file::File;
use crate::{Question, Scene, Trouble};

/// Name of the street, as `demo` has it.
const STREET: &str = "scene.png";

/// Keys of a camera that say what is sharp, and nothing of where a line of sight goes.
const LENS_KEYS: [&str; 3] = ["f_number", "blades", "blade_angle_deg"];

/// Likewise, unless a pixel pitch makes the focal length in px of them.
const FOCUS_KEYS: [&str; 3] = ["focal_length_mm", "focus_distance_m", "scene_distance_m"];

/// Frames of a camera after which its light is estimated anew.
const FRAMES_PER_LIGHT: u32 = 25;

/// A picture before the camera.
#[derive(Debug, Clone)]
struct Picture {
    name: String,
    pixels: DynamicImage,
    icc_profile: Option<Vec<u8>>,
}

/// Glass that broke, with all that breaking it depends on.
#[derive(Debug, Clone)]
struct Broken {
    key: Value,
    simulated: Simulated,
}

/// The glass before the picture.
#[derive(Debug)]
struct Glass {
    recipe: Recipe,
    seed: Seed,
    chain: Chain,
    shown: Shown,
    damaged: DynamicImage,
}

/// The light of a camera's frames.
#[derive(Debug, Clone, Copy)]
struct CameraLight {
    light: Option<Environment>,
    n_frames: u32,
}

/// What a page works with.
///
/// # Example
/// ```
/// use starbreak_web::Session;
///
/// let mut session = Session::default();
/// session.answer(r#"{"ask": "street"}"#, &[])?;
/// let broken = session.answer(r#"{"ask": "break", "preset": "paper", "seed": 7}"#, &[])?;
/// assert_eq!(broken.bytes.len(), 1242 * 375 * 4);
/// # Ok::<(), starbreak_web::Trouble>(())
/// ```
#[derive(Debug, Default)]
pub struct Session {
    picture: Option<Picture>,
    broken: Option<Broken>,
    glass: Option<Glass>,
    camera_light: Option<CameraLight>,
}

impl Answers for Session {
    fn answer(&mut self, words: &str, bytes: Vec<u8>) -> Result<Answer, String> {
        Self::answer(self, words, &bytes).map_err(|trouble| trouble.to_string())
    }
}

impl Session {
    /// The answer to a question in JSON, which may come with bytes. What was before stays where it cannot be
    /// answered.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn answer(&mut self, words: &str, bytes: &[u8]) -> Result<Answer, Trouble> {
        match serde_json::from_str(words)? {
            Question::Catalog => catalog(),
            Question::Street => {
                let street = DynamicImage::ImageRgb8(street_scene().image);
                Ok(self.put(STREET.to_owned(), street, None))
            }
            Question::Picture { name } => {
                let file = decode_image(&name, bytes, &ImageLimits::default())?;
                Ok(self.put(name, file.pixels, file.icc_profile))
            }
            Question::Break(scene) => self.shatter(&scene),
            Question::Grown { share } => self.grown(share),
            Question::Cracks => self.cracks(),
            Question::File { what } => self.file(what),
            Question::Frame {
                width_px,
                height_px,
            } => self.frame((width_px, height_px), bytes),
        }
    }

    /// Puts a picture before the camera.
    fn put(&mut self, name: String, pixels: DynamicImage, icc_profile: Option<Vec<u8>>) -> Answer {
        let answer = Answer {
            words: json!({ "name": name, "width_px": pixels.width(), "height_px": pixels.height() }),
            bytes: pixels.to_rgba8().into_raw(),
        };
        (self.broken, self.glass, self.camera_light) = (None, None, None);
        self.picture = Some(Picture {
            name,
            pixels,
            icc_profile,
        });
        answer
    }

    /// Breaks the glass and shows it. Glass that breaks as before is not broken again.
    fn shatter(&mut self, scene: &Scene) -> Result<Answer, Trouble> {
        let picture = self.picture.as_ref().ok_or(Trouble::Missing("picture"))?;
        let recipe = scene.recipe()?;
        let settings = recipe.settings().map_err(Trouble::Recipe)?;
        let size_px = (picture.pixels.width(), picture.pixels.height());
        let seed = Seed(scene.seed).of_item(&picture.name, 0);
        let key = breaking_of(&recipe, seed);
        let broken = match self.broken.take().filter(|broken| broken.key == key) {
            Some(broken) => broken,
            None => Broken {
                simulated: simulate(&settings, size_px, seed)?,
                key,
            },
        };
        let mut watch = Stopwatch::start();
        let simulated = self.broken.insert(broken).simulated.clone();
        let chain = Chain::of_simulated(&settings, simulated, size_px, seed, &mut watch)?;
        let mut damaged = picture.pixels.clone();
        let shown = chain.over_and_report(&mut damaged, seed, &[], &mut watch)?;
        let answer = Answer {
            words: json!({
                "region_share": shown.region_fraction,
                "optics": shown.optics.to_json(),
                "glass_disc_px": shown.optics.scene.map(|scene| scene.glass_disc_px),
                "scene_disc_px": shown.optics.scene.map(|scene| scene.scene_disc_px),
                "damage": chain.facts().get("network"),
                "faults": faults_of(chain.facts()),
                "last_arrival": chain.arrivals().map(|times| times.last),
                "unit": chain.arrivals().map(|times| times.unit),
                "recipe": recipe.to_json(),
                "assignments": scene.assignments()?,
            }),
            bytes: damaged.to_rgba8().into_raw(),
        };
        self.camera_light = None;
        self.glass = Some(Glass {
            recipe,
            seed,
            chain,
            shown,
            damaged,
        });
        Ok(answer)
    }

    fn glass(&self) -> Result<(&Picture, &Glass), Trouble> {
        let picture = self.picture.as_ref().ok_or(Trouble::Missing("picture"))?;
        let glass = self
            .glass
            .as_ref()
            .ok_or(Trouble::Missing("broken glass"))?;
        Ok((picture, glass))
    }

    /// The glass when a share of the length of its cracks is there.
    fn grown(&self, share: f64) -> Result<Answer, Trouble> {
        let (picture, Glass { chain, seed, .. }) = self.glass()?;
        let unit = chain
            .arrivals()
            .ok_or(Trouble::Missing("time of arrival"))?
            .unit;
        let time = (chain.network()).map_or(0.0, |network| network.time_of_length(share));
        let layer = match time > 0.0 {
            true => chain.grown_at(time)?,
            false => chain.before_impact()?,
        };
        let mut shown = picture.pixels.clone();
        let light = chain.light_of(&shown);
        let lit = chain.layer_under(&layer, light.as_ref())?;
        lit.over(&mut shown, *seed)?;
        Ok(Answer {
            words: json!({ "time": time, "unit": unit, "length_px": chain.crack_length_px(time)? }),
            bytes: shown.to_rgba8().into_raw(),
        })
    }

    /// The pieces of cracks that the frame shows.
    fn cracks(&self) -> Result<Answer, Trouble> {
        let (_, Glass { chain, .. }) = self.glass()?;
        let network = chain.network().ok_or(Trouble::Missing("network"))?;
        let scene = starbreak::Scene::of(chain.settings(), chain.size());
        let view = match chain.settings().optics {
            OpticsSettings::Paper(_) => scene.pane()?,
            OpticsSettings::Physical(_) => scene.of_network(network)?,
        };
        let segments = &network.data().segments;
        let stress = segments
            .stress_mpa
            .as_ref()
            .or(segments.stress_paper_units.as_ref());
        let columns = [
            segments.arrival(),
            stress.map(Vec::as_slice),
            segments.depth_fraction.as_deref(),
        ];
        let mut bytes = Vec::new();
        let mut n_pieces = 0_u32;
        for (idx, ends) in network.grown_at(f64::INFINITY) {
            let Some(seen) = view.visible(ends, 1.0) else {
                continue;
            };
            n_pieces += 1;
            let values = columns.map(|column| column.and_then(|column| column.get(idx)).copied());
            for value in seen
                .into_iter()
                .chain(values.map(|value| value.unwrap_or(f64::NAN)))
            {
                #[expect(clippy::cast_possible_truncation, reason = "for lines on a screen")]
                bytes.extend((value as f32).to_le_bytes());
            }
        }
        Ok(Answer {
            words: json!({ "n_pieces": n_pieces }),
            bytes,
        })
    }

    /// A file to take away, with the bytes that the command would write.
    fn file(&self, what: File) -> Result<Answer, Trouble> {
        let (picture, glass) = self.glass()?;
        let network = || glass.chain.network().ok_or(Trouble::Missing("network"));
        let png_of = |pixels| encode_png(pixels, picture.icc_profile.as_deref());
        let bytes = match what {
            File::Picture => png_of(&glass.damaged)?,
            File::Clean => png_of(&picture.pixels)?,
            File::Region => encode_mask(&glass.shown.region)?,
            File::Crack => encode_mask(&glass.chain.crack_mask()?)?,
            File::Network => network()?.to_json().into_bytes(),
            File::Drawing => network()?.to_svg().into_bytes(),
            File::Recipe => glass.recipe.to_commented_toml().into_bytes(),
        };
        let stem = picture
            .name
            .rsplit_once('.')
            .map_or(&*picture.name, |(stem, _)| stem);
        Ok(Answer {
            words: json!({ "name": format!("{stem}{}", what.suffix()), "media_type": what.media_type() }),
            bytes,
        })
    }

    /// The glass over a frame of a camera.
    fn frame(
        &mut self,
        (width_px, height_px): (u32, u32),
        bytes: &[u8],
    ) -> Result<Answer, Trouble> {
        let glass = self
            .glass
            .as_ref()
            .ok_or(Trouble::Missing("broken glass"))?;
        let frame = RgbaImage::from_raw(width_px, height_px, bytes.to_vec());
        let mut frame = DynamicImage::ImageRgba8(frame.ok_or(Trouble::Frame {
            n_bytes: bytes.len(),
            width_px,
            height_px,
        })?);
        let idx = self.camera_light.map_or(0, |known| known.n_frames);
        let light = match self.camera_light {
            Some(known) if !idx.is_multiple_of(FRAMES_PER_LIGHT) => known.light,
            _ => glass.chain.light_of(&frame),
        };
        self.camera_light = Some(CameraLight {
            light,
            n_frames: idx.wrapping_add(1),
        });
        let lit = glass.chain.under(light.as_ref())?;
        // Noise is that of each frame.
        lit.over(&mut frame, glass.seed.of_item("frame", u64::from(idx)))?;
        Ok(Answer {
            words: Value::Null,
            bytes: frame.into_rgba8().into_raw(),
        })
    }
}

/// Presets, cameras, and the keys of recipes.
fn catalog() -> Result<Answer, Trouble> {
    let named = |(name, about): (&str, &str)| json!({ "name": name, "about": about });
    let cameras = cameras()?;
    let cameras = cameras.iter().map(|(name, about)| named((name, about)));
    let mut faults = Map::new();
    for fault in FAULTS {
        if let Some((preset, _)) = fault.presets.first() {
            let tables = Recipe::preset(preset)?.to_json();
            faults.insert(fault.table.to_owned(), tables[fault.table].clone());
        }
    }
    Ok(Answer {
        words: json!({
            "faults": faults,
            "version": env!("CARGO_PKG_VERSION"),
            "default_preset": DEFAULT_PRESET,
            "presets": presets().map(named).collect::<Vec<_>>(),
            "cameras": cameras.collect::<Vec<_>>(),
            "schema": json_schema(),
        }),
        bytes: Vec::new(),
    })
}

/// What is told of each fault, and of what lies on the glass, by table.
fn faults_of(facts: &Map<String, Value>) -> Map<String, Value> {
    let on_glass = FAULTS.iter().filter(|fault| fault.needs_pane());
    let on_glass = on_glass
        .filter_map(|fault| Some((fault.table.to_owned(), facts.get(fault.table)?.clone())));
    let faults = facts.get("faults").and_then(Value::as_object);
    on_glass
        .chain(faults.cloned().unwrap_or_default())
        .collect()
}

/// All that breaking the glass depends on: the recipe without what is done with light, and the seed.
fn breaking_of(recipe: &Recipe, seed: Seed) -> Value {
    let mut tables = recipe.to_json();
    if let Some(tables) = tables.as_object_mut() {
        tables.remove("optics");
        tables.remove("output");
        let faults = FAULTS.iter().filter(|fault| !fault.is_on_pane());
        let faults = faults.map(|fault| fault.table);
        faults.chain(["lens", "sensor"]).for_each(|table| {
            tables.remove(table);
        });
    }
    if let Some(camera) = tables["camera"].as_object_mut() {
        let has_pitch = camera.get("pixel_pitch_um").is_some_and(Value::is_number);
        let is_lens =
            |key: &str| LENS_KEYS.contains(&key) || (!has_pitch && FOCUS_KEYS.contains(&key));
        camera.retain(|key, _| !is_lens(key));
    }
    json!([tables, seed.0])
}
