//! Where the cracks of a set come from.

use serde_json::{Map, Value, json};
use starbreak_glass::{Model, Seed};

use crate::Error;
use crate::import::ImportedNetwork;
use crate::pipeline::{
    Baked, Details, RunContext, Simulated, Stopwatch, bake_network, network_view, simulate,
    use_network,
};

/// Where the cracks of a set come from.
#[derive(Debug)]
pub enum Patterns {
    /// Broken anew for each sample of each image.
    Fresh,
    /// One network for all images.
    Network(ImportedNetwork),
}

/// A crack for one sample of one image.
pub(super) struct ItemPattern {
    pub(super) baked: Baked,
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
        Ok(ItemPattern {
            baked,
            is_intact: simulated.network.n_segments() == 0,
            facts: Map::from_iter([("network".to_owned(), network_facts(&simulated))]),
        })
    }
}

/// What a record says of a network.
pub(crate) fn network_facts(simulated: &Simulated) -> Value {
    let data = simulated.network.data();
    let model = match simulated.details {
        Details::Imported(_) => Model::Imported,
        _ => data.model,
    };
    let mut facts = Map::from_iter([
        ("model".to_owned(), json!(model)),
        ("impacts".to_owned(), json!(data.impacts)),
        ("summary".to_owned(), json!(simulated.network.summary())),
    ]);
    facts.extend(simulated.details.to_json());
    Value::Object(facts)
}
