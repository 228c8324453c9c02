//! Cracks into pixels, by either optics model.

use image::{DynamicImage, GrayImage};
use serde_json::{Value, json};
use starbreak_glass::CrackNetwork;
use starbreak_optics::environment::{Environment, Rgb};
use starbreak_optics::paper::{composite, draw};
use starbreak_optics::photo::PhotoPattern;
use starbreak_optics::physical::{Overlay, PackedPattern, Pattern, PhysicalOptics, bake};
use starbreak_optics::{Before, Contrast, Coverage, Masks, View};
use starbreak_seed::Seed;

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

/// A crack before one camera, ready to be put over any image of the camera's size.
#[derive(Debug, Clone)]
pub enum Baked {
    /// The paper's: lines of the frame.
    Paper(Coverage),
    /// The physical optics': shares of light.
    Physical(Pattern),
    /// The same out of a bank: unpacked as it is given light, for each image anew.
    Packed(PackedPattern),
    /// The physical optics' of a photograph: opacity and light.
    Photo {
        /// The photograph as the lens shows it.
        pattern: PhotoPattern,
        /// Light of its white over what a white sheet in the place of the glass would show.
        gain: f64,
    },
}

/// What an optics model leaves beside the image.
#[derive(Debug, Clone)]
pub struct Shown {
    /// 255 where the crack influences the image, else 0.
    pub region: GrayImage,
    /// What was done to the light of each pixel; the paper's optics know no light.
    pub overlay: Option<Overlay>,
    /// Lens and light; the paper's optics have neither.
    pub scene: Option<SceneReport>,
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
    let size = (image.width(), image.height());
    let baked = if let Details::Photo(placed) = &details {
        placed.bake(settings, size)?
    } else {
        let view = network_view(settings, &network, &details, size)?;
        bake_network(settings, (&network, f64::INFINITY), &view, seed)?
    };
    watch.lap(baked.stage());
    let (before, shown) = baked.over_keeping(settings, image, seed, &mut watch)?;
    let Shown {
        region,
        overlay,
        scene,
    } = shown;
    let masks = Masks {
        region,
        crack: baked.crack_mask()?,
    };
    watch.lap("masks");
    let maps = overlay
        .filter(|_| settings.output.maps)
        .map(|overlay| overlay.maps());
    let contrast = before.contrast(image, &masks.region)?;
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

/// How a frame shows cracks, simulated for it or imported.
pub(crate) fn network_view(
    settings: &Settings,
    network: &CrackNetwork,
    details: &Details,
    size: (u32, u32),
) -> Result<View, Error> {
    if matches!(details, Details::Imported(_)) {
        view_of_network(settings, network, size)
    } else {
        own_view(settings, size)
    }
}

/// How a frame shows cracks that were simulated for it.
pub(crate) fn own_view(settings: &Settings, (width, height): (u32, u32)) -> Result<View, Error> {
    match &settings.optics {
        OpticsSettings::Paper(_) => view(settings, width, height),
        OpticsSettings::Physical(_) => sheet_view(settings, width, height),
    }
}

/// Bakes cracks as they are at a time.
///
/// # Errors
/// [`Error::Optics`], [`Error::TooCostly`].
pub fn bake_network(
    settings: &Settings,
    (network, time): (&CrackNetwork, f64),
    view: &View,
    seed: Seed,
) -> Result<Baked, Error> {
    settings.may_show(network, view)?;
    Ok(match &settings.optics {
        OpticsSettings::Paper(optics) => Baked::Paper(draw(network, view, time, optics)),
        OpticsSettings::Physical(optics) => {
            Baked::Physical(bake(network, time, view, optics, seed)?)
        }
    })
}

impl Baked {
    /// Name of the stage that made it.
    #[must_use]
    pub fn stage(&self) -> &'static str {
        match self {
            Self::Paper(_) => "draw",
            Self::Physical(_) | Self::Packed(_) | Self::Photo { .. } => "bake",
        }
    }

    /// Whether nothing of a crack is in the frame.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        match self {
            Self::Paper(drawn) => drawn.is_empty(),
            Self::Physical(pattern) => pattern.is_intact(),
            Self::Packed(pattern) => pattern.is_intact(),
            Self::Photo { pattern, .. } => pattern.is_intact(),
        }
    }

    /// Width and height of the frame, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        match self {
            Self::Physical(pattern) => pattern.size(),
            Self::Packed(pattern) => pattern.size(),
            Self::Photo { pattern, .. } => pattern.size(),
            Self::Paper(drawn) => {
                let (width, height) = drawn.size();
                let side = |n| u32::try_from(n).unwrap_or(u32::MAX);
                (side(width), side(height))
            }
        }
    }

    /// Coverage of the frame by cracks as they would be in focus, 255 = in full.
    ///
    /// # Errors
    /// [`Error::Optics`] for a packed pattern whose bytes are wrong.
    pub fn crack_mask(&self) -> Result<GrayImage, Error> {
        Ok(match self {
            Self::Paper(drawn) => drawn.to_mask(),
            Self::Physical(pattern) => pattern.coverage(),
            Self::Packed(pattern) => pattern.coverage()?,
            Self::Photo { pattern, .. } => pattern.coverage(),
        })
    }

    /// Puts the crack over an image, in place, under the light of the image. The seed is that
    /// of the sensor's noise.
    ///
    /// # Errors
    /// [`Error::Optics`]; the image may then be half changed.
    pub fn over(
        &self,
        settings: &Settings,
        image: &mut DynamicImage,
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<Shown, Error> {
        let ((), shown) = self.over_after(settings, image, seed, watch, |_, _, _| ())?;
        Ok(shown)
    }

    /// As [`Baked::over`], with what the image showed before.
    ///
    /// # Errors
    /// As for [`Baked::over`].
    pub fn over_keeping(
        &self,
        settings: &Settings,
        image: &mut DynamicImage,
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<(Before, Shown), Error> {
        self.over_after(settings, image, seed, watch, |image, overlay, watch| {
            let before = match overlay {
                Some(overlay) => overlay.before(image),
                None => Before::whole(image.clone()),
            };
            watch.lap("copy");
            before
        })
    }

    /// As [`Baked::over`], with what `look` made of the image just before, and of what is going to
    /// be done to its light; the paper's optics know none.
    fn over_after<T>(
        &self,
        settings: &Settings,
        image: &mut DynamicImage,
        seed: Seed,
        watch: &mut Stopwatch,
        look: impl FnOnce(&DynamicImage, Option<&Overlay>, &mut Stopwatch) -> T,
    ) -> Result<(T, Shown), Error> {
        let estimate = |image: &DynamicImage, optics: &PhysicalOptics, f_px| {
            Environment::estimate(image, &optics.environment, f_px)
        };
        let (overlay, optics, f_px) = match (self, &settings.optics) {
            (Self::Paper(drawn), OpticsSettings::Paper(optics)) => {
                let seen = look(image, None, watch);
                let masks = composite(image, drawn, optics)?;
                watch.lap("render");
                let shown = Shown {
                    region: masks.region,
                    overlay: None,
                    scene: None,
                };
                return Ok((seen, shown));
            }
            (Self::Physical(pattern), OpticsSettings::Physical(optics)) => {
                let f_px = pattern.f_px();
                let overlay = pattern.light(&estimate(image, optics, f_px), optics);
                (overlay, optics, f_px)
            }
            (Self::Packed(pattern), OpticsSettings::Physical(optics)) => {
                let f_px = pattern.f_px();
                let overlay = pattern.light(&estimate(image, optics, f_px), optics)?;
                (overlay, optics, f_px)
            }
            (Self::Photo { pattern, gain }, OpticsSettings::Physical(optics)) => {
                let f_px = pattern.f_px();
                let overlay = pattern.light(&estimate(image, optics, f_px), *gain, optics)?;
                (overlay, optics, f_px)
            }
            _ => return Err(Error::OtherOptics),
        };
        watch.lap("light");
        let seen = look(image, Some(&overlay), watch);
        overlay.apply(image, seed)?;
        watch.lap("render");
        Ok((seen, shown_by(settings, optics, overlay, f_px, watch)))
    }
}

/// What the physical optics leave beside the image.
fn shown_by(
    settings: &Settings,
    optics: &PhysicalOptics,
    overlay: Overlay,
    f_px: f64,
    watch: &mut Stopwatch,
) -> Shown {
    let region = overlay.region();
    watch.lap("region");
    let scene = scene(settings, optics, f_px, *overlay.environment());
    Shown {
        region,
        overlay: Some(overlay),
        scene: Some(scene),
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
                "cabin": [rgb(light.cabin_low_rgb), rgb(light.cabin_high_rgb)],
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
