//! A crack that is ready to be put over frames of one size, wherever it comes from.

use image::{DynamicImage, GrayImage};
use serde_json::{Map, Value, json};
use starbreak_glass::CrackNetwork;
use starbreak_optics::{Before, Damage, DamageReader};
use starbreak_seed::Seed;

use super::{
    Baked, OpticsReport, Shown, Simulated, Stopwatch, bake_network, network_view, region_fraction,
};
use crate::bank::PatternBank;
use crate::overlay::PlacedPhoto;
use crate::{Error, OpticsSettings, Settings};

/// A crack that is ready to be put over frames of one size.
#[derive(Debug, Clone)]
pub struct ReadyCrack {
    /// What the optics show.
    pub baked: Baked,
    /// Its network; one out of a bank stays there, and a photograph has none.
    pub network: Option<CrackNetwork>,
    /// The crack mask as a PNG file, where it is at hand.
    pub crack_mask_png: Option<Vec<u8>>,
    /// What a record says of it, by key.
    pub facts: Map<String, Value>,
    /// Whether nothing is broken.
    pub is_intact: bool,
}

/// What a crack did to a frame.
#[derive(Debug, Clone)]
pub struct FrameReport {
    /// 255 where the crack influences the image, else 0.
    pub region: GrayImage,
    /// Share of the frame in the region.
    pub region_fraction: f64,
    /// What the optics say about the picture.
    pub optics: OpticsReport,
    /// The damage in each box that was asked for; none in one without a pixel of the frame.
    pub damage: Vec<Option<Damage>>,
}

impl ReadyCrack {
    /// Cracks that were simulated for a frame of this size, or read from a file. The seed places
    /// what they leave open: grains of crushed glass.
    ///
    /// # Errors
    /// [`Error::Optics`] for a camera that sees nothing, [`Error::NoMount`].
    pub fn of_simulated(
        settings: &Settings,
        simulated: Simulated,
        size: (u32, u32),
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<Self, Error> {
        let Simulated {
            network,
            details,
            timings,
        } = simulated;
        watch.append(timings);
        let view = network_view(settings, &network, &details, size)?;
        let baked = bake_network(settings, (&network, f64::INFINITY), &view, seed)?;
        watch.lap(baked.stage());
        let (key, facts) = details.facts_of(&network);
        Ok(Self {
            baked,
            crack_mask_png: None,
            is_intact: network.n_segments() == 0,
            facts: Map::from_iter([(key.to_owned(), facts)]),
            network: Some(network),
        })
    }

    /// A photograph of broken glass.
    pub(crate) fn of_photo(
        settings: &Settings,
        placed: &PlacedPhoto,
        size: (u32, u32),
        watch: &mut Stopwatch,
    ) -> Result<Self, Error> {
        let baked = placed.bake(settings, size)?;
        watch.lap(baked.stage());
        Ok(Self {
            is_intact: baked.is_intact(),
            baked,
            network: None,
            crack_mask_png: None,
            facts: Map::from_iter([("overlay".to_owned(), placed.facts())]),
        })
    }

    /// A pattern of a bank, by its number.
    ///
    /// # Errors
    /// As for [`PatternBank::pattern`].
    pub fn of_bank(
        bank: &PatternBank,
        idx: usize,
        size: (u32, u32),
        watch: &mut Stopwatch,
    ) -> Result<Self, Error> {
        let pattern = bank.pattern(idx, size)?;
        watch.lap(if pattern.was_baked_anew {
            "bake"
        } else {
            "unpack"
        });
        let facts = &pattern.facts;
        let facts = Map::from_iter([
            (
                "pattern".to_owned(),
                json!({ "bank_sha256": bank.sha256(), "idx": pattern.idx }),
            ),
            (
                "network".to_owned(),
                json!({
                    "model": facts.model,
                    "damage_class": facts.damage_class,
                    "summary": facts.summary,
                }),
            ),
        ]);
        Ok(Self {
            is_intact: pattern.facts.summary.n_segments == 0,
            baked: pattern.baked,
            network: None,
            crack_mask_png: Some(pattern.crack_mask_png),
            facts,
        })
    }

    /// Puts the crack over an image, in place, and says nothing of it: the fastest way. The seed
    /// is that of the sensor's noise.
    ///
    /// # Errors
    /// [`Error::Optics`]; the image may then be half changed.
    pub fn over(
        &self,
        settings: &Settings,
        image: &mut DynamicImage,
        seed: Seed,
    ) -> Result<(), Error> {
        let mut watch = Stopwatch::start();
        self.baked.over(settings, image, seed, &mut watch)?;
        Ok(())
    }

    /// Puts the crack over an image, in place, and says what that did to it and to boxes in it,
    /// `[x₀, y₀, x₁, y₁]` in px; the pixels are those of [`ReadyCrack::over`].
    ///
    /// # Errors
    /// [`Error::Optics`]; the image may then be half changed.
    pub fn over_and_report(
        &self,
        settings: &Settings,
        image: &mut DynamicImage,
        seed: Seed,
        boxes_px: &[[f64; 4]],
    ) -> Result<FrameReport, Error> {
        let mut watch = Stopwatch::start();
        let (before, shown) = self.baked.over_keeping(settings, image, seed, &mut watch)?;
        let contrast = before.contrast(image, &shown.region)?;
        let damage = match damage_reader((&before, image), &shown, settings) {
            Some(reader) => boxes_px.iter().map(|at| reader.in_box(*at)).collect(),
            None => Vec::new(),
        };
        Ok(FrameReport {
            region_fraction: region_fraction(&shown.region),
            region: shown.region,
            optics: OpticsReport {
                contrast,
                scene: shown.scene,
            },
            damage,
        })
    }
}

/// Who measures what a crack did to boxes of an image.
pub(crate) fn damage_reader<'a>(
    images: (&'a Before, &'a DynamicImage),
    shown: &'a Shown,
    settings: &Settings,
) -> Option<DamageReader<'a>> {
    let region = &shown.region;
    match (&shown.overlay, &settings.optics) {
        (Some(overlay), _) => Some(DamageReader::of_overlay(images, region, overlay)),
        (None, OpticsSettings::Paper(optics)) => {
            Some(DamageReader::of_paper(images, region, optics))
        }
        // The physical optics leave an overlay.
        (None, OpticsSettings::Physical(_)) => None,
    }
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
