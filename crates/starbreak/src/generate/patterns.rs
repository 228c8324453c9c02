//! Where the cracks of a set come from.

use serde_json::json;
use starbreak_glass::Seed;

use crate::Error;
use crate::bank::{OverlayBank, PatternBank};
use crate::import::ImportedNetwork;
use crate::overlay::OverlaySet;
use crate::pipeline::{ReadyCrack, RunContext, Stopwatch, simulate, use_network};

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

impl Patterns {
    /// The crack for a frame.
    pub(super) fn for_item(
        &self,
        context: &RunContext,
        size: (u32, u32),
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<ReadyCrack, Error> {
        let settings = &context.settings;
        let simulated = match self {
            Self::Fresh => simulate(settings, size.0, size.1, seed)?,
            Self::Network(imported) => use_network(imported),
            Self::Overlays(set) => {
                return ReadyCrack::of_photo(settings, &set.draw(size, seed)?, size, watch);
            }
            Self::OverlayBank(bank) => {
                let idx = bank.idx_for(seed);
                let placed = bank.pattern(idx, size)?;
                let mut crack = ReadyCrack::of_photo(settings, &placed, size, watch)?;
                let pattern = json!({ "bank_sha256": bank.sha256(), "idx": idx });
                crack.facts.insert("pattern".to_owned(), pattern);
                return Ok(crack);
            }
            Self::Bank(bank) => return ReadyCrack::of_bank(bank, bank.idx_for(seed), size, watch),
        };
        ReadyCrack::of_simulated(settings, simulated, size, seed, watch)
    }
}
