//! Where the cracks of a set come from.

use serde_json::json;
use starbreak_dataset::{LabeledObject, ObjectKind};
use starbreak_seed::Seed;

use crate::bank::{OverlayBank, PatternBank};
use crate::import::ImportedNetwork;
use crate::overlay::OverlaySet;
use crate::pipeline::{ReadyCrack, RunContext, Stopwatch, simulate, use_network};
use crate::{Error, Settings};

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
    /// The crack for a frame with these objects.
    pub(super) fn for_item(
        &self,
        context: &RunContext,
        (size, objects): ((u32, u32), &[LabeledObject]),
        seed: Seed,
        watch: &mut Stopwatch,
    ) -> Result<ReadyCrack, Error> {
        let settings = &context.settings;
        let simulated = match self {
            Self::Fresh if settings.fracture.is_aimed() => {
                let aimed = Settings {
                    fracture: settings.fracture.aimed_at(&middles(objects, size), seed),
                    ..settings.clone()
                };
                simulate(&aimed, size.0, size.1, seed)?
            }
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

/// Middles of the objects that are to be found, of what the frame shows of them, as fractions of it.
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
