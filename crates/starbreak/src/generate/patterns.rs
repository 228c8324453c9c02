//! Where the cracks of a set come from.

use serde_json::{Map, Value, json};
use starbreak_glass::Seed;

use crate::Error;
use crate::bank::{OverlayBank, PatternBank};
use crate::import::ImportedNetwork;
use crate::overlay::{OverlaySet, PlacedPhoto};
use crate::pipeline::{
    Baked, RunContext, Stopwatch, bake_network, network_view, simulate, use_network,
};

/// Where the cracks of a set come from.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one of them in a run, and it is handed on by reference"
)]
pub enum Patterns {
    /// Broken anew for each sample of each image.
    Fresh,
    /// One network for all images.
    Network(ImportedNetwork),
    /// Out of a bank of photographs of broken glass, a part drawn for each sample by its seed.
    OverlayBank(OverlayBank),
    /// Photographs of broken glass: for each sample a random one, and a random part of it.
    Overlays(OverlaySet),
    /// Out of a bank, a pattern drawn for each sample of each image by its seed.
    Bank(PatternBank),
}

/// A crack for one sample of one image.
pub(super) struct ItemPattern {
    pub(super) baked: Baked,
    /// The crack mask as a PNG file, where it is at hand.
    pub(super) crack_mask_png: Option<Vec<u8>>,
    /// What its record says of it, by key.
    pub(super) facts: Map<String, Value>,
    /// Whether nothing is broken.
    pub(super) is_intact: bool,
}

impl Patterns {
    /// The crack for a frame.
    pub(super) fn for_item(
        &self,
        context: &RunContext,
        size: (u32, u32),
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<ItemPattern, Error> {
        let simulated = match self {
            Self::Fresh => simulate(&context.settings, size.0, size.1, seed)?,
            Self::Network(imported) => use_network(imported),
            Self::Overlays(set) => {
                return of_photo(context, &set.draw(size, seed)?, size, watch);
            }
            Self::OverlayBank(bank) => {
                let idx = bank.idx_for(seed);
                let mut item = of_photo(context, &bank.pattern(idx, size)?, size, watch)?;
                let pattern = json!({ "bank_sha256": bank.sha256(), "idx": idx });
                item.facts.insert("pattern".to_owned(), pattern);
                return Ok(item);
            }
            Self::Bank(bank) => return of_bank(bank, size, seed, watch),
        };
        watch.append(simulated.timings.clone());
        let view = network_view(
            &context.settings,
            &simulated.network,
            &simulated.details,
            size,
        )?;
        let network = (&simulated.network, f64::INFINITY);
        let baked = bake_network(&context.settings, network, &view, seed)?;
        watch.lap(baked.stage());
        let (key, facts) = simulated.details.facts_of(&simulated.network);
        Ok(ItemPattern {
            baked,
            crack_mask_png: None,
            is_intact: simulated.network.n_segments() == 0,
            facts: Map::from_iter([(key.to_owned(), facts)]),
        })
    }
}

fn of_photo(
    context: &RunContext,
    placed: &PlacedPhoto,
    size: (u32, u32),
    watch: &mut Stopwatch,
) -> Result<ItemPattern, Error> {
    let baked = placed.bake(&context.settings, size)?;
    watch.lap(baked.stage());
    Ok(ItemPattern {
        is_intact: baked.is_intact(),
        baked,
        crack_mask_png: None,
        facts: Map::from_iter([("overlay".to_owned(), placed.facts())]),
    })
}

fn of_bank(
    bank: &PatternBank,
    size: (u32, u32),
    seed: Seed,
    watch: &mut Stopwatch,
) -> Result<ItemPattern, Error> {
    let pattern = bank.pattern(bank.idx_for(seed), size)?;
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
    Ok(ItemPattern {
        is_intact: pattern.facts.summary.n_segments == 0,
        baked: pattern.baked,
        crack_mask_png: Some(pattern.crack_mask_png),
        facts,
    })
}
