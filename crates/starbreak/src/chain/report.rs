//! What a chain says of what it did to an image.

use image::{DynamicImage, GrayImage};
use serde_json::{Map, Value, json};
use starbreak_deposit::{Area, Coat, Deposit, Rain};
use starbreak_optics::environment::{Environment, Rgb};
use starbreak_optics::lens_faults::{LensFault, Optic};
use starbreak_optics::physical::OpticalMaps;
use starbreak_optics::screens::Screen;
use starbreak_optics::{Contrast, Damage};
use starbreak_seed::Seed;
use starbreak_sensor::{Fault, FrameState, Frames, Pulse, Sensor};

use super::Chain;
use crate::{CameraFaults, Error, Scene, Stopwatch};

/// What the glass did to an image.
#[derive(Debug, Clone)]
pub struct Shown {
    /// 255 where the glass affects the image, else 0; with [`CLASSES`](crate::CLASSES) where these are asked for.
    pub region: GrayImage,
    /// Share of the frame in the region.
    pub region_fraction: f64,
    /// What the optics say about the picture.
    pub optics: OpticsReport,
    /// The damage in each box that was asked for; none in one without a pixel of the frame.
    pub damage: Vec<Option<Damage>>,
    /// What became of the frame, where frames may not arrive; a picture by itself is good or blank.
    pub arrival: Option<FrameState>,
    /// What the physical optics did to the light of each pixel, if the settings want maps.
    pub maps: Option<OpticalMaps>,
}

/// What the optics say of a picture beside the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpticsReport {
    /// How visible the damage is.
    pub contrast: Contrast,
    /// Lens and light of the physical optics; the paper's have neither.
    pub scene: Option<SceneReport>,
}

/// Lens and light of one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneReport {
    /// Focal length of the camera, px.
    pub f_px: f64,
    /// Diameter of the disc that a point of the glass becomes on the optical axis, px.
    pub glass_disc_px: f64,
    /// Diameter of the disc that a point of the scene becomes, px.
    pub scene_disc_px: f64,
    /// The light around the camera, as given or estimated from the image.
    pub environment: Environment,
}

impl Chain {
    /// Puts the glass over an image as [`Chain::over`] does, and says what that did to it and to boxes
    /// in it, `[x₀, y₀, x₁, y₁]` in px.
    ///
    /// # Errors
    /// As for [`Chain::over`].
    pub fn over_and_report(
        &self,
        image: &mut DynamicImage,
        seed: Seed,
        boxes_px: &[[f64; 4]],
        watch: &mut Stopwatch,
    ) -> Result<Shown, Error> {
        let light = self.light_of(image);
        self.over_and_report_under(light, image, seed, boxes_px, watch)
    }

    /// The same under a light that is given, which the physical optics need.
    ///
    /// # Errors
    /// As for [`Chain::over`].
    pub fn over_and_report_under(
        &self,
        light: Option<Environment>,
        image: &mut DynamicImage,
        seed: Seed,
        boxes_px: &[[f64; 4]],
        watch: &mut Stopwatch,
    ) -> Result<Shown, Error> {
        let lit = self.under(light.as_ref())?;
        if light.is_some() {
            watch.lap("light");
        }
        let before = lit.before(image);
        watch.lap("copy");
        let regions = lit.over_region(image, seed.into(), watch)?;
        let contrast = before.contrast(image, regions.all())?;
        watch.lap("contrast");
        let reader = lit.damage_reader((&before, image), &regions);
        let damage = boxes_px.iter().map(|at| reader.in_box(*at)).collect();
        if !boxes_px.is_empty() {
            watch.lap("damage");
        }
        let maps = (self.settings.output.maps).then(|| lit.maps()).flatten();
        let mut region = regions.into_all();
        let faults = self.settings.faults.as_ref();
        let frames = faults.and_then(|faults| faults.sensor.get::<Frames>());
        let arrival = frames.map(|frames| frames.of_picture(seed));
        // A frame that is blank is opaque.
        if self.settings.output.classes && !arrival.is_some_and(FrameState::is_blank) {
            lit.classify(&mut region);
        }
        Ok(Shown {
            arrival,
            region_fraction: region_fraction(&region),
            optics: OpticsReport {
                contrast,
                scene: self.scene_report(light),
            },
            region,
            damage,
            maps,
        })
    }

    /// Lens and light of a picture, by the physical optics.
    fn scene_report(&self, light: Option<Environment>) -> Option<SceneReport> {
        let (environment, f_px) = (light?, self.layer.f_px()?);
        let [glass_disc_px, scene_disc_px] = Scene::of(&self.settings, self.size()).discs_px(f_px);
        Some(SceneReport {
            f_px,
            glass_disc_px,
            scene_disc_px,
            environment,
        })
    }
}

impl OpticsReport {
    /// `{contrast: {…}, environment: {…}}`, the second by the physical optics.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let mut report = json!({ "contrast": contrast(&self.contrast) });
        if let Some(scene) = &self.scene {
            report["environment"] = environment_to_json(&scene.environment);
        }
        report
    }
}

/// A light as a record has it: `{sky_horizon, sky_zenith, ground, cabin, sun_irradiance}`, linear, 1 is white.
#[must_use]
pub fn environment_to_json(light: &Environment) -> Value {
    json!({
        "sky_horizon": rgb(light.horizon_rgb),
        "sky_zenith": rgb(light.zenith_rgb),
        "ground": rgb(light.ground_rgb),
        "cabin": [rgb(light.cabin_low_rgb), rgb(light.cabin_high_rgb)],
        "sun_irradiance": rgb(light.sun_rgb),
    })
}

fn contrast(contrast: &Contrast) -> Value {
    json!({
        "mean": contrast.mean,
        "weber": contrast.weber,
        "brighter": contrast.brighter,
        "darker": contrast.darker,
        "rms_code": contrast.rms_code,
    })
}

/// Light without the digits that single precision does not have.
fn rgb(rgb: Rgb) -> [f64; 3] {
    rgb.map(|channel| {
        channel
            .to_string()
            .parse()
            .unwrap_or_else(|_| channel.into())
    })
}

/// What a record says of a camera's faults, each in the unit of its law; `size` is the frame's, px.
pub(super) fn faults_to_json(
    faults: &CameraFaults,
    optic: Option<&Optic>,
    size: (u32, u32),
) -> Value {
    let mut facts = Map::new();
    let mut add = |onset_s: f64, (table, mut fact): (&str, Value)| {
        if onset_s > 0.0 {
            fact["onset_s"] = json!(onset_s);
        }
        facts.insert(table.to_owned(), fact);
    };
    for (onset_s, fault) in faults.lens.faults() {
        if let Some(optic) = optic {
            add(*onset_s, fact_of_lens(fault, optic));
        }
    }
    if faults.lens.headroom() > 1.0 {
        add(0.0, ("lens", json!({ "headroom": faults.lens.headroom() })));
    }
    let sensor = &faults.sensor;
    for (onset_s, fault) in sensor.faults() {
        let size = (size.0 as usize, size.1 as usize);
        add(*onset_s, fact_of(fault, sensor, size));
    }
    Value::Object(facts)
}

/// What a record says of drops on a pane.
pub(super) fn drops_to_json(rain: &Rain, deposit: &Deposit, area: &Area) -> Value {
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    json!({
        "n_drops": deposit.caps.len(),
        "coverage": rounded(deposit.coverage(&area.shown())),
        "runs_from_mm": Some(rain.runs_from_mm()).filter(|mm| mm.is_finite()).map(rounded),
    })
}

/// What a record says of a wiper in view.
pub(super) fn wiper_to_json(screen: &Screen) -> Option<Value> {
    let coverage = (screen.mean_covered() * 1e6).round() / 1e6;
    (coverage > 0.0).then(|| json!({ "coverage": coverage }))
}

/// The table of a coat on the glass, and what a record says of it.
pub(super) fn coat_to_json(coat: &Coat, screen: &Screen) -> (&'static str, Value) {
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    let mut fact = json!({
        "coverage": rounded(screen.mean_covered()),
        "direct": rounded(screen.mean_direct()),
    });
    let [narrow_px, wide_px] = screen.halos_px().map(rounded);
    match coat {
        Coat::Scratches(it) => fact["haze"] = json!(it.haze),
        Coat::Dust(it) => fact["cleanliness_level"] = json!(it.level_um().round()),
        Coat::Film(it) => fact["turns_by_rms_rad"] = json!(rounded(it.turns_by_rms_rad())),
        Coat::Fog(_) => {
            fact["refracted_px"] = json!(wide_px);
            fact["diffracted_px"] = json!(narrow_px);
        }
        Coat::Mud(_) | Coat::Frost(_) => {}
    }
    (coat_table(coat), fact)
}

/// The table of a recipe that puts a coat on the glass.
fn coat_table(coat: &Coat) -> &'static str {
    match coat {
        Coat::Scratches(_) => "scratches",
        Coat::Mud(_) => "mud",
        Coat::Dust(_) => "dust",
        Coat::Film(_) => "film",
        Coat::Frost(_) => "frost",
        Coat::Fog(_) => "condensation",
    }
}

/// The table of a fault of the lens, and how large it is.
fn fact_of_lens(fault: &LensFault, optic: &Optic) -> (&'static str, Value) {
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    match fault {
        LensFault::Distortion(it) => {
            let [width, height] = [optic.size.0, optic.size.1].map(to_px);
            let [x, y] = it.moved([width, height], optic);
            let corner = [x - width, y - height].map(rounded);
            ("distortion", json!({ "corner_moves_px": corner }))
        }
        LensFault::Fringes(it) => {
            let fact =
                json!({ "lateral_px": it.corner_px(optic), "axial_um": rounded(it.axial_m * 1e6) });
            ("fringes", fact)
        }
        LensFault::Defocus(it) => {
            let disc_px = rounded(it.disc_px(optic).abs());
            ("defocus", json!({ "disc_px": disc_px }))
        }
        LensFault::Shake(it) => {
            let path_px = rounded(it.longest_px(optic));
            ("shake", json!({ "longest_path_px": path_px }))
        }
        LensFault::Ghosts(it) => {
            let n_ghosts = it.of_lens(optic.lens.f_number).len();
            (
                "ghosts",
                json!({ "n_ghosts": n_ghosts, "reflectance": it.reflectance }),
            )
        }
        LensFault::Star(it) => {
            // Of green light, farther than 10 px.
            let beyond = rounded(it.beyond(10.0, optic)[1]);
            (
                "star",
                json!({ "blades": it.blades, "beyond_10_px": beyond }),
            )
        }
        LensFault::Glare(it) => {
            let scattered = rounded(it.scattered(optic));
            (
                "glare",
                json!({ "veil": rounded(it.shown(optic)), "scattered": scattered }),
            )
        }
        LensFault::Shading(it) => ("shading", json!({ "corner_loss": it.corner_loss })),
    }
}

#[expect(clippy::cast_precision_loss, reason = "px of a frame")]
fn to_px(n: usize) -> f64 {
    n as f64
}

/// The table of a fault, and how large it is.
fn fact_of(fault: &Fault, sensor: &Sensor, size: (usize, usize)) -> (&'static str, Value) {
    match fault {
        Fault::Exposure(it) => ("exposure", json!({ "ev": it.ev })),
        Fault::Lamps(it) => {
            let rows = 1.0 / (it.pulses_hz() * it.row_s);
            let mut fact = json!({ "depth": it.band_depth(), "rows_per_band": rows });
            if let Pulse::Led { .. } = it.pulse {
                fact["seen"] = json!(it.seen());
            }
            ("banding", fact)
        }
        Fault::Spots(it) => {
            let fact = json!({
                "count": it.count,
                "diameter_px": 2.0 * it.reach_px(),
                "depth": it.depth(),
            });
            ("spots", fact)
        }
        Fault::Filters(it) => ("cfa", json!({ "loss": it.loss })),
        Fault::Noise(it) => {
            let fact = json!({ "snr_18": it.snr_18(), "dark_e": it.dark_e() });
            ("noise", fact)
        }
        Fault::Pixels(_) => {
            let alone = Sensor::new(sensor.number, vec![(0.0, *fault)]);
            ("pixels", json!({ "n_defects": alone.defects(size).len() }))
        }
        Fault::Lines(it) => {
            let [rows, columns] = it.of_sensor(size, Seed(sensor.number));
            ("lines", json!({ "rows": rows, "columns": columns }))
        }
        Fault::RawRows(it) => ("mosaic", json!({ "share": it.share })),
        Fault::Isp(it) => {
            let fact = json!({
                "black_level_percent": (it.black_level * 1e6).round() / 1e4,
                "white_balance": it.white_balance,
                "color_matrix": it.color_matrix,
                "unsharp": it.unsharp,
                "tone": it.tone,
            });
            ("isp", fact)
        }
        Fault::Link(it) => {
            let fact = json!({
                "bit_error_rate": it.bit_error_rate,
                "jpeg_quality": it.jpeg_quality,
                "row_bits": it.row_bits,
            });
            ("link", fact)
        }
        Fault::Frames(it) => {
            let fact = json!({
                "black": it.black,
                "white": it.white,
                "frozen": it.frozen,
                "dropped": it.dropped,
                "burst_frames": it.burst_frames,
            });
            ("frames", fact)
        }
    }
}

/// Share of a mask that is not black.
#[must_use]
pub fn region_fraction(region: &GrayImage) -> f64 {
    let codes = region.as_raw();
    // In blocks whose count fits a byte, so that many are counted at once.
    let n_in_block = |block: &[u8]| block.iter().fold(0_u8, |n, code| n + u8::from(*code > 0));
    let n_affected: u64 = codes
        .chunks(255)
        .map(|block| u64::from(n_in_block(block)))
        .sum();
    #[expect(clippy::cast_precision_loss, reason = "counts of pixels")]
    let fraction = n_affected as f64 / codes.len().max(1) as f64;
    fraction
}

/// The damage of a box as a record has it: `{region_share, displacement_px, blur_radius_px,
/// contrast_lost}`, to six decimals, which is more than is known.
#[must_use]
pub fn damage_to_json(damage: &Damage) -> Value {
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    json!({
        "region_share": rounded(damage.region_share),
        "displacement_px": rounded(damage.displacement_px),
        "blur_radius_px": rounded(damage.blur_radius_px),
        "contrast_lost": damage.contrast_lost.map(rounded),
    })
}
