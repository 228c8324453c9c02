//! Where the damage of a run comes from.

use serde_json::{Value, json};
use starbreak::import::ImportedNetwork;
use starbreak::{Chain, Settings, Simulated, Stopwatch, simulate};
use starbreak_dataset::{LabeledObject, ObjectKind};
use starbreak_seed::Seed;

use crate::Error;
use crate::bank::{OverlayBank, PatternBank};
use crate::overlay::OverlaySet;

/// Where the damage of a run comes from.
#[derive(Debug)]
pub enum Patterns {
    /// Broken anew for each sample of each image.
    Fresh,
    /// One network for all images.
    Network(Box<ImportedNetwork>),
    /// Out of a bank of photographs of broken glass, a part drawn for each sample by its seed.
    OverlayBank(Box<OverlayBank>),
    /// Photographs of broken glass: for each sample a random one, and a random part of it.
    Overlays(OverlaySet),
    /// Out of a bank, a pattern drawn for each sample of each image by its seed.
    Bank(Box<PatternBank>),
}

/// The damage of one frame.
#[derive(Debug)]
pub(crate) struct Damaged {
    pub(crate) chain: Chain,
    /// The crack mask as a PNG file, where it is at hand.
    pub(crate) crack_mask_png: Option<Vec<u8>>,
}

impl Damaged {
    /// The pattern of a bank that the item with this seed gets.
    pub(crate) fn of_bank(
        bank: &PatternBank,
        settings: &Settings,
        (size, seed): ((u32, u32), Seed),
        watch: &mut Stopwatch,
    ) -> Result<Self, Error> {
        let pattern = bank.pattern(bank.idx_for(seed), size, watch)?;
        Ok(Self {
            chain: pattern.chain.followed_by(settings).coated(seed)?,
            crack_mask_png: Some(pattern.crack_mask_png),
        })
    }
}

impl Patterns {
    /// All that the damage depends on beside recipe and seed.
    pub(crate) fn identity(&self) -> Value {
        match self {
            Self::Fresh => json!("fresh"),
            Self::Network(imported) => json!({ "network_sha256": imported.sha256 }),
            Self::OverlayBank(bank) => json!({ "bank_sha256": bank.sha256() }),
            Self::Overlays(set) => json!({ "overlays": set.facts() }),
            Self::Bank(bank) => json!({ "bank_sha256": bank.sha256() }),
        }
    }

    /// Whether the damage is a network; photographs have none.
    pub(crate) fn has_networks(&self) -> bool {
        match self {
            Self::Fresh | Self::Network(_) | Self::Bank(_) => true,
            Self::Overlays(_) | Self::OverlayBank(_) => false,
        }
    }

    /// The damage of a frame, with its objects if it is one of a dataset.
    pub(crate) fn for_frame(
        &self,
        settings: &Settings,
        (size, objects): ((u32, u32), Option<&[LabeledObject]>),
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<Damaged, Error> {
        let chain = match self {
            Self::Fresh => {
                let simulated = match objects {
                    Some(objects) if settings.fracture.is_aimed() => {
                        let aimed = Settings {
                            fracture: settings.fracture.aimed_at(&middles(objects, size), seed),
                            ..settings.clone()
                        };
                        simulate(&aimed, size, seed)?
                    }
                    _ => simulate(settings, size, seed)?,
                };
                Chain::of_simulated(settings, simulated, size, seed, watch)?
            }
            Self::Network(imported) => {
                Chain::of_simulated(settings, Simulated::from(&**imported), size, seed, watch)?
            }
            Self::Overlays(set) => {
                Chain::of_photo(settings, set.draw(size, seed)?, size, watch)?.coated(seed)?
            }
            Self::OverlayBank(bank) => {
                let idx = bank.idx_for(seed);
                let placed = bank.pattern(idx, size)?;
                let mut chain = Chain::of_photo(settings, placed, size, watch)?.coated(seed)?;
                let pattern = json!({ "bank_sha256": bank.sha256(), "idx": idx });
                chain.add_fact("pattern", pattern);
                chain
            }
            Self::Bank(bank) => return Damaged::of_bank(bank, settings, (size, seed), watch),
        };
        Ok(Damaged {
            chain,
            crack_mask_png: None,
        })
    }

    /// The damage of all frames of a clip; what comes out of a bank brings its network, so that it can
    /// grow.
    pub(crate) fn for_clip(
        &self,
        settings: &Settings,
        size: (u32, u32),
        seed: Seed,
    ) -> Result<Chain, Error> {
        let mut watch = Stopwatch::start();
        let chain = self
            .for_frame(settings, (size, None), seed, &mut watch)?
            .chain;
        let Self::Bank(bank) = self else {
            return Ok(chain);
        };
        let idx = bank.idx_for(seed);
        Ok(chain.with_network(bank.network(idx)?, bank.header().seed_of(idx))?)
    }
}

/// Centers of the objects that are to be found, each clipped to the frame, as fractions of it.
fn middles(objects: &[LabeledObject], (width, height): (u32, u32)) -> Vec<[f64; 2]> {
    let size = [f64::from(width), f64::from(height)];
    let regular = objects
        .iter()
        .filter(|object| object.kind == ObjectKind::Regular);
    let middle = |object: &LabeledObject| {
        let [x0, y0, x1, y1] = object.box_px;
        let shown = [[x0, x1], [y0, y1]];
        let is_in = (0..2).all(|k| shown[k][1] > 0.0 && shown[k][0] < size[k]);
        let of = |k: usize| {
            shown[k]
                .map(|at| at.clamp(0.0, size[k]))
                .iter()
                .sum::<f64>()
        };
        is_in.then(|| [0, 1].map(|k| 0.5 * of(k) / size[k]))
    };
    regular.filter_map(middle).collect()
}
