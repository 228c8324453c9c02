//! The chain: all that light meets between the world and the pixels, ready for frame after frame.
//!
//! [`Chain::of`] breaks the glass before a camera and bakes what the optics make of it;
//! [`Chain::over`] puts that over any image of its size. Networks from files, photographs of glass
//! and patterns out of a bank become chains, too.

mod deposits;
mod kept;
mod layer;
mod lit;
mod live;
mod origin;
mod report;
mod sense;

use std::sync::Arc;

use image::{DynamicImage, GrayImage};
use serde_json::{Map, Value};
use starbreak_glass::CrackNetwork;
use starbreak_optics::environment::Environment;
use starbreak_optics::lens_faults::LensOfFrames;
use starbreak_optics::screens::Screen;
use starbreak_seed::Seed;
use starbreak_sensor::Moment;

use crate::photo::PlacedPhoto;
use crate::{
    Arrivals, CameraFaults, Details, Error, OpticsSettings, Scene, Settings, Simulated, Stopwatch,
    simulate,
};

use deposits::drops_fact;
use kept::Kept;
pub use layer::PaneLayer;
use layer::{OnPane, deposit_of};
use lit::Glass;
pub use lit::{CLASSES, Lit};
pub use live::{KeptFrame, Live};
use origin::{Cracks, Origin};
pub use report::{
    OpticsReport, SceneReport, Shown, damage_to_json, environment_to_json, region_fraction,
};
use sense::Behind;

/// Broken glass before one camera, ready to be put over any image of its size.
///
/// # Example
/// ```
/// use image::{DynamicImage, RgbImage};
/// use starbreak::{Chain, Recipe, Seed};
///
/// let settings = Recipe::preset("windshield-star")?.settings()?;
/// let chain = Chain::of(&settings, (320, 200), Seed(7))?;
/// for code in [60, 128] {
///     let mut frame = DynamicImage::ImageRgb8(RgbImage::from_pixel(320, 200, image::Rgb([code; 3])));
///     chain.over(&mut frame, Seed(7))?;
/// }
/// assert!(!chain.is_intact());
/// # Ok::<(), starbreak::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Chain {
    settings: Settings,
    layer: PaneLayer,
    /// What lies on the pane, where that is known.
    on_pane: Option<Arc<OnPane>>,
    /// Coats on the glass, in the order of the settings, and what places them.
    screens: Vec<Arc<Screen>>,
    /// The faulty lens before such frames, if the optics know one.
    lens: Option<Arc<LensOfFrames>>,
    coat_seed: Option<Seed>,
    origin: Origin,
    facts: Map<String, Value>,
    /// Whether the glass is whole and clean: no crack in the network, nothing of a photograph in the frame, no drop.
    is_glass_intact: bool,
    kept: Arc<Kept>,
}

/// No light at all.
const DARK: Environment = Environment {
    horizon_rgb: [0.0; 3],
    zenith_rgb: [0.0; 3],
    ground_rgb: [0.0; 3],
    cabin_low_rgb: [0.0; 3],
    cabin_high_rgb: [0.0; 3],
    sun_rgb: [0.0; 3],
};

impl Chain {
    /// Breaks the glass before frames of a width and height, px, and bakes it. Everything random is
    /// drawn from the seed.
    ///
    /// # Errors
    /// As for [`simulate`](fn@simulate) and [`Chain::of_simulated`].
    pub fn of(settings: &Settings, size_px: (u32, u32), seed: Seed) -> Result<Self, Error> {
        let simulated = simulate(settings, size_px, seed)?;
        Self::of_simulated(settings, simulated, size_px, seed, &mut Stopwatch::start())
    }

    /// Bakes a network that was simulated for frames of this size, or read from a file. The seed
    /// places what it leaves open: grains of crushed glass.
    ///
    /// # Errors
    /// [`Error::NoMount`], [`Error::Optics`] for a camera that sees nothing, [`Error::TooCostly`].
    pub fn of_simulated(
        settings: &Settings,
        simulated: Simulated,
        size_px: (u32, u32),
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<Self, Error> {
        let Simulated {
            network,
            details,
            timings,
        } = simulated;
        watch.append(timings);
        let on_pane = deposit_of(settings, size_px, seed, (0.0, None))?;
        let whole = (&network, f64::INFINITY);
        let on = on_pane.as_ref().map(|on| (on, None));
        let layer = PaneLayer::of_network_under(settings, whole, size_px, on, seed)?;
        watch.lap(layer.stage());
        let mut facts = match details {
            Details::None => Map::new(),
            _ => Map::from_iter([("network".to_owned(), details.facts_of(&network))]),
        };
        facts.extend(drops_fact(settings, on_pane.as_ref()));
        let is_glass_intact = network.n_segments() == 0 && layer.is_intact();
        let chain = Self {
            on_pane: on_pane.map(Arc::new),
            origin: match details {
                Details::None => Origin::Stored,
                details => Origin::Network(Box::new(Cracks {
                    network,
                    details: Some(details),
                    seed,
                })),
            },
            ..Self::of_layer(settings, layer, facts, is_glass_intact)
        };
        let chain = chain.coated(seed)?;
        if !chain.screens.is_empty() {
            watch.lap("coats");
        }
        Ok(chain)
    }

    /// Bakes a part of a photograph of broken glass for frames of this size.
    ///
    /// # Errors
    /// [`Error::Optics`], [`Error::TooCostly`].
    pub fn of_photo(
        settings: &Settings,
        placed: PlacedPhoto,
        size_px: (u32, u32),
        watch: &mut Stopwatch,
    ) -> Result<Self, Error> {
        let layer = PaneLayer::of_photo(settings, &placed, size_px)?;
        watch.lap(layer.stage());
        let facts = Map::from_iter([("overlay".to_owned(), placed.facts())]);
        let is_glass_intact = layer.is_intact();
        let chain = Self::of_layer(settings, layer, facts, is_glass_intact);
        Ok(Self {
            origin: Origin::Photo(Box::new(placed)),
            ..chain
        })
    }

    /// What was baked before and kept elsewhere, as in a bank: with what a record says of it, by key,
    /// and whether nothing is broken.
    #[must_use]
    pub fn of_layer(
        settings: &Settings,
        layer: PaneLayer,
        facts: Map<String, Value>,
        is_glass_intact: bool,
    ) -> Self {
        let chain = Self {
            settings: settings.clone(),
            layer,
            on_pane: None,
            screens: Vec::new(),
            lens: None,
            coat_seed: None,
            origin: Origin::Stored,
            facts,
            is_glass_intact,
            kept: Arc::default(),
        };
        chain.with_faults()
    }

    /// The same glass with the coats, the camera's faults and the output of other settings, as for a bank that was made
    /// without; [`Chain::coated`] makes the coats.
    #[must_use]
    pub fn followed_by(mut self, settings: &Settings) -> Self {
        self.settings.coats.clone_from(&settings.coats);
        self.settings.faults.clone_from(&settings.faults);
        self.settings.output = settings.output;
        self.facts.remove("faults");
        self.with_faults()
    }

    /// With the faulty lens before such frames, and what a record says of the camera's faults.
    fn with_faults(mut self) -> Self {
        self.lens = None;
        if let Some(faults) = &self.settings.faults {
            let optic = Scene::of(&self.settings, self.size()).optic();
            self.lens = (optic.as_ref()).map(|optic| Arc::new(faults.lens.for_frames(optic)));
            let facts = report::faults_to_json(faults, optic.as_ref(), self.size());
            self.facts.insert("faults".to_owned(), facts);
        }
        self
    }

    /// Gives a stored layer its network, so that it can grow, and the seed that placed what the network
    /// leaves open, and what lies on the pane.
    ///
    /// # Errors
    /// [`Error::Optics`] for a camera that sees nothing, [`Error::TooManyDrops`].
    pub fn with_network(self, network: CrackNetwork, seed: Seed) -> Result<Self, Error> {
        let on_pane = deposit_of(&self.settings, self.size(), seed, (0.0, None))?;
        let cracks = Cracks {
            network,
            details: None,
            seed,
        };
        Ok(Self {
            origin: Origin::Network(Box::new(cracks)),
            on_pane: on_pane.map(Arc::new),
            ..self
        })
    }

    /// The same network as it is at a time, in the unit of its arrivals. A photograph, and a stored layer
    /// without its network, is the same at all times.
    ///
    /// # Errors
    /// [`Error::NoMount`], [`Error::Optics`], [`Error::TooCostly`].
    pub fn grown_at(&self, time: f64) -> Result<PaneLayer, Error> {
        match &self.origin {
            Origin::Network(cracks) => {
                let network = (&cracks.network, time);
                let on_pane = self.on_pane.as_deref().map(|on| (on, Some(&*self.kept)));
                PaneLayer::of_network_under(
                    &self.settings,
                    network,
                    self.size(),
                    on_pane,
                    cracks.seed,
                )
            }
            Origin::Photo(_) | Origin::Stored => Ok(self.layer.clone()),
        }
    }

    /// Whether the damage can be shown as it comes about. A photograph, and a stored layer without its
    /// network, is there at once.
    #[must_use]
    pub fn can_grow(&self) -> bool {
        matches!(self.origin, Origin::Network(_))
    }

    /// When the damage comes about; none where nothing says it.
    #[must_use]
    pub fn arrivals(&self) -> Option<Arrivals> {
        self.network().and_then(Arrivals::of)
    }

    /// Length of the cracks that the frame shows at a time, in the unit of their arrivals, px; none
    /// where no network says it.
    ///
    /// # Errors
    /// [`Error::NoMount`], [`Error::Optics`] for a camera that sees nothing.
    pub fn crack_length_px(&self, time: f64) -> Result<Option<f64>, Error> {
        let scene = Scene::of(&self.settings, self.size());
        let network = self.network();
        network
            .map(|network| scene.crack_length_px(network, time))
            .transpose()
    }

    /// The glass before it breaks: what the lens does to the frame remains.
    ///
    /// # Errors
    /// [`Error::Optics`] for a camera that sees nothing.
    pub fn before_impact(&self) -> Result<PaneLayer, Error> {
        let on_pane = self.on_pane.as_deref().map(|on| (on, Some(&*self.kept)));
        PaneLayer::whole(&self.settings, self.size(), on_pane)
    }

    /// Camera, optics and output.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Width and height of the frames, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        self.layer.size()
    }

    /// Whether nothing is damaged: the glass is whole, and the camera has no fault.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        let is_clean = self.screens.iter().all(|screen| screen.is_nothing());
        let faults = self.settings.faults.as_ref();
        self.is_glass_intact && is_clean && faults.is_none_or(CameraFaults::is_empty)
    }

    /// Whether the glass is broken, as far as that is known: what a bank kept of it may be cracks or drops.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        let has_cracks = self
            .network()
            .is_some_and(|network| network.n_segments() > 0);
        has_cracks || !self.is_glass_intact && (self.photo().is_some() || !self.rains())
    }

    /// What a record says of the damage, by key.
    #[must_use]
    pub fn facts(&self) -> &Map<String, Value> {
        &self.facts
    }

    /// Adds to what a record says of the damage.
    pub fn add_fact(&mut self, key: &str, value: Value) {
        self.facts.insert(key.to_owned(), value);
    }

    /// The cracks; a photograph has none, and those of a bank stay there.
    #[must_use]
    pub fn network(&self) -> Option<&CrackNetwork> {
        self.origin.network()
    }

    /// What the model of fracture says of the cracks, where there is a network.
    #[must_use]
    pub fn details(&self) -> Option<&Details> {
        self.origin.details()
    }

    /// The photograph, if it is one.
    #[must_use]
    pub fn photo(&self) -> Option<&PlacedPhoto> {
        self.origin.photo()
    }

    /// What the optics baked.
    #[must_use]
    pub fn layer(&self) -> &PaneLayer {
        &self.layer
    }

    /// The crack mask of a picture that this chain was put over: none of a frame that is blank.
    ///
    /// # Errors
    /// As for [`Chain::crack_mask`].
    pub fn crack_mask_of(&self, shown: &Shown) -> Result<GrayImage, Error> {
        match shown.arrival {
            Some(state) if state.is_blank() => {
                let (width, height) = self.size();
                Ok(GrayImage::new(width, height))
            }
            _ => self.crack_mask(),
        }
    }

    /// Coverage of the frame by cracks as they would be in focus, 255 = in full; where the lens moves them.
    ///
    /// # Errors
    /// [`Error::Optics`] for a packed pattern whose bytes are wrong.
    pub fn crack_mask(&self) -> Result<GrayImage, Error> {
        let mask = self.layer.crack_mask()?;
        Ok(match &self.lens {
            Some(lens) => lens.moved_mask(mask),
            None => mask,
        })
    }

    /// The light around the camera that an image tells of; the paper's optics do not ask.
    #[must_use]
    pub fn light_of(&self, image: &DynamicImage) -> Option<Environment> {
        match (&self.settings.optics, self.layer.f_px()) {
            (OpticsSettings::Physical(optics), Some(f_px)) => {
                Some(Environment::estimate(image, &optics.environment, f_px))
            }
            _ => None,
        }
    }

    /// The glass under a light, which the physical optics need; without one it is dark around the camera.
    ///
    /// # Errors
    /// As for [`Chain::layer_under`].
    pub fn under(&self, light: Option<&Environment>) -> Result<Lit<'_>, Error> {
        self.layer_under(&self.layer, light)
    }

    /// A layer of this chain at another time under a light.
    ///
    /// # Errors
    /// [`Error::OtherOptics`] for a layer that was baked for another model than that of the settings,
    /// [`Error::Optics`] for a packed pattern whose bytes are wrong.
    pub fn layer_under<'a>(
        &'a self,
        layer: &'a PaneLayer,
        light: Option<&Environment>,
    ) -> Result<Lit<'a>, Error> {
        let light = light.unwrap_or(&DARK);
        let overlay = match (layer, &self.settings.optics) {
            (PaneLayer::Paper(drawn), OpticsSettings::Paper(optics)) => {
                return Ok(self.with_camera(Glass::Paper(drawn, optics), *light));
            }
            (PaneLayer::Baked(pattern), OpticsSettings::Physical(optics)) => {
                pattern.light(light, optics)
            }
            (PaneLayer::Packed(pattern), OpticsSettings::Physical(optics)) => {
                pattern.light(light, optics)?
            }
            (PaneLayer::Photo { pattern, gain }, OpticsSettings::Physical(optics)) => {
                pattern.light(light, *gain, optics)?
            }
            _ => return Err(Error::OtherOptics),
        };
        Ok(self.with_camera(Glass::Physical(Box::new(overlay)), *light))
    }

    fn with_camera<'a>(&'a self, glass: Glass<'a>, light: Environment) -> Lit<'a> {
        Lit {
            glass,
            behind: Behind::of(&self.settings, &self.screens, self.lens.as_deref(), light),
        }
    }

    /// Puts the glass over an image, in place, under the light of the image, then the faults of the camera, and says
    /// nothing of it: the fastest way. A seed alone is a picture by itself; it is that of the sensor's noise.
    ///
    /// The pixels are a function of image, settings and seeds alone.
    ///
    /// # Errors
    /// [`Error::Optics`] for an image of another size; the image may then be half changed. As for
    /// [`Chain::layer_under`].
    pub fn over(&self, image: &mut DynamicImage, at: impl Into<Moment>) -> Result<(), Error> {
        self.under(self.light_of(image).as_ref())?.over(image, at)
    }
}
