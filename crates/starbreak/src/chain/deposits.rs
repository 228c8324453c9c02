//! What lies on the glass of a chain, and what becomes of it as time goes.

use std::sync::Arc;

use serde_json::Value;
use starbreak_deposit::Coat;
use starbreak_optics::screens::Screen;
use starbreak_seed::Seed;

use super::layer::{OnPane, deposit_of, screens_of};
use super::origin::Origin;
use super::{Chain, PaneLayer, report};
use crate::{Error, Settings};

/// What a record says of drops.
pub(super) fn drops_fact(settings: &Settings, on_pane: Option<&OnPane>) -> Option<(String, Value)> {
    let (rain, on) = (settings.drops.as_ref()?, on_pane?);
    let drops = report::drops_to_json(rain, &on.deposit, &on.area);
    Some(("drops".to_owned(), drops))
}

/// What a record says of coats.
fn coat_facts(settings: &Settings, screens: &[Screen]) -> Vec<(String, Value)> {
    let coats = settings.coats.iter().zip(screens);
    coats
        .map(|(coat, screen)| report::coat_to_json(coat, screen))
        .map(|(table, fact)| (table.to_owned(), fact))
        .collect()
}

impl Chain {
    /// With the coats of its settings; the seed places them.
    ///
    /// # Errors
    /// [`Error::Optics`] for a camera that sees nothing.
    pub fn coated(mut self, seed: Seed) -> Result<Self, Error> {
        self.screens = screens_of(&self.settings, self.size(), seed, 0.0)?;
        self.coat_seed = Some(seed);
        let facts = coat_facts(&self.settings, &self.screens);
        self.facts.extend(facts);
        Ok(self)
    }

    /// Whether what lies on the glass changes as time goes: rain falls, dew and frost grow.
    #[must_use]
    pub fn ages(&self) -> bool {
        let rains = self.settings.drops.is_some() && self.on_pane.is_some();
        rains || self.settings.coats.iter().any(Coat::grows)
    }

    /// What it is like so many seconds later, with the network as it is at a time in the unit of its arrivals; none is
    /// before the impact. Says of the damage only what lies on the glass.
    ///
    /// # Errors
    /// As for [`Chain::of`].
    pub fn later(&self, after_s: f64, growth: Option<f64>) -> Result<Self, Error> {
        let (settings, size) = (&self.settings, self.size());
        let (layer, on_pane) = match &self.origin {
            Origin::Network(cracks) => {
                let on_pane = deposit_of(settings, size, cracks.seed, after_s)?;
                let on = on_pane.as_ref();
                let layer = match growth {
                    Some(time) => {
                        let network = (&cracks.network, time);
                        PaneLayer::of_network_under(settings, network, size, on, cracks.seed)?
                    }
                    None => PaneLayer::whole(settings, size, on)?,
                };
                (layer, on_pane.map(Arc::new))
            }
            // Glass that is whole.
            Origin::Stored if self.on_pane.is_some() => {
                let on_pane =
                    deposit_of(settings, size, self.coat_seed.unwrap_or(Seed(0)), after_s)?;
                let layer = PaneLayer::whole(settings, size, on_pane.as_ref())?;
                (layer, on_pane.map(Arc::new))
            }
            Origin::Photo(_) | Origin::Stored => (self.layer.clone(), self.on_pane.clone()),
        };
        let screens = match self.coat_seed {
            Some(seed) => screens_of(settings, size, seed, after_s)?,
            None => Vec::new(),
        };
        let facts = drops_fact(settings, on_pane.as_deref())
            .into_iter()
            .chain(coat_facts(settings, &screens))
            .collect();
        Ok(Self {
            settings: settings.clone(),
            layer,
            on_pane,
            screens,
            coat_seed: self.coat_seed,
            origin: Origin::Stored,
            facts,
            is_glass_intact: self.is_glass_intact,
        })
    }
}
