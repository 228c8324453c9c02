//! Cracks into pixels, by either optics model.

use image::DynamicImage;
use serde_json::{Value, json};
use starbreak_glass::{CrackNetwork, Seed};
use starbreak_optics::environment::{Environment, Rgb};
use starbreak_optics::paper::{composite, draw};
use starbreak_optics::physical::{OpticalMaps, PhysicalOptics, bake};
use starbreak_optics::{Contrast, Masks, View};

use super::{Cracked, Details, Simulated, Stopwatch, sheet_view, view, view_of_network};
use crate::{Error, OpticsSettings, Settings};

/// What the optics say of a picture beside the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpticsReport {
    /// How visible the crack is.
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

/// What an optics model leaves beside the image.
pub(super) struct Shown {
    pub(super) masks: Masks,
    pub(super) maps: Option<OpticalMaps>,
    pub(super) scene: Option<SceneReport>,
}

/// Shows cracks that were simulated for a frame of this size in an image, in place. The seed
/// places what the cracks leave open: grains of crushed glass, noise.
///
/// # Errors
/// [`Error::Optics`]; the image may then be half changed.
pub fn show_cracks(
    settings: &Settings,
    image: &mut DynamicImage,
    simulated: Simulated,
    seed: Seed,
) -> Result<Cracked, Error> {
    let Simulated {
        network,
        details,
        mut timings,
    } = simulated;
    let mut watch = Stopwatch::start();
    let before = image.clone();
    let size = (image.width(), image.height());
    let view = if matches!(details, Details::Imported(_)) {
        view_of_network(settings, &network, size)?
    } else {
        own_view(settings, size)?
    };
    let Shown { masks, maps, scene } = show(
        settings,
        image,
        (&network, f64::INFINITY),
        &view,
        seed,
        &mut watch,
    )?;
    let contrast = Contrast::of(&before, image, &masks.region)?;
    watch.lap("contrast");
    timings.append(watch.stop());
    Ok(Cracked {
        network,
        details,
        masks,
        maps,
        optics: OpticsReport { contrast, scene },
        timings,
    })
}

/// How a frame shows cracks that were simulated for it.
pub(crate) fn own_view(settings: &Settings, (width, height): (u32, u32)) -> Result<View, Error> {
    match &settings.optics {
        OpticsSettings::Paper(_) => view(settings, width, height),
        OpticsSettings::Physical(_) => sheet_view(settings, width, height),
    }
}

/// Shows cracks as they are at a time.
pub(super) fn show(
    settings: &Settings,
    image: &mut DynamicImage,
    (network, time): (&CrackNetwork, f64),
    view: &View,
    seed: Seed,
    watch: &mut Stopwatch,
) -> Result<Shown, Error> {
    match &settings.optics {
        OpticsSettings::Paper(optics) => {
            let drawn = draw(network, view, time, optics);
            watch.lap("draw");
            let masks = composite(image, &drawn, optics)?;
            watch.lap("render");
            Ok(Shown {
                masks,
                maps: None,
                scene: None,
            })
        }
        OpticsSettings::Physical(optics) => {
            let pattern = bake(network, time, view, optics, seed)?;
            watch.lap("bake");
            let environment = Environment::estimate(image, &optics.environment, pattern.f_px());
            let overlay = pattern.light(&environment, optics);
            watch.lap("light");
            overlay.apply(image, seed)?;
            watch.lap("render");
            let masks = Masks {
                region: overlay.region(),
                crack: pattern.coverage(),
            };
            watch.lap("masks");
            let maps = settings.output.maps.then(|| overlay.maps());
            Ok(Shown {
                masks,
                maps,
                scene: Some(scene(settings, optics, pattern.f_px(), environment)),
            })
        }
    }
}

fn scene(
    settings: &Settings,
    optics: &PhysicalOptics,
    f_px: f64,
    environment: Environment,
) -> SceneReport {
    let lens = &optics.lens;
    let disc = |distance_m| lens.circle_of_confusion_px(f_px, distance_m).abs();
    SceneReport {
        f_px,
        glass_disc_px: settings
            .fracture
            .mount()
            .map_or(0.0, |mount| disc(mount.distance_m)),
        scene_disc_px: disc(lens.scene_m),
        environment,
    }
}

impl OpticsReport {
    /// `{contrast: {…}, environment: {…}}`, the second by the physical optics.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let mut report = json!({ "contrast": contrast(&self.contrast) });
        if let Some(scene) = &self.scene {
            let light = &scene.environment;
            report["environment"] = json!({
                "sky_horizon": rgb(light.horizon_rgb),
                "sky_zenith": rgb(light.zenith_rgb),
                "ground": rgb(light.ground_rgb),
                "cabin": rgb(light.cabin_rgb),
                "sun_irradiance": rgb(light.sun_rgb),
            });
        }
        report
    }
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
