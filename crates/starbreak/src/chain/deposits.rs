//! What lies on the glass of a chain, and what becomes of it as time goes.

use std::sync::Arc;

use serde_json::{Map, Value, json};
use starbreak_deposit::Coat;
use starbreak_optics::screens::Screen;
use starbreak_seed::Seed;

use super::layer::{OnPane, deposit_of, screen_of_wiper, screens_of};
use super::origin::Origin;
use super::{Chain, PaneLayer, report};
use crate::{Error, OpticsSettings, Scene, Settings};

/// What a record says of drops.
pub(super) fn drops_fact(settings: &Settings, on_pane: Option<&OnPane>) -> Option<(String, Value)> {
    let (rain, on) = (settings.drops.as_ref()?, on_pane?);
    let drops = report::drops_to_json(rain, &on.deposit, &on.area);
    Some(("drops".to_owned(), drops))
}

/// What a record says of coats.
fn coat_facts(settings: &Settings, screens: &[Arc<Screen>]) -> Vec<(String, Value)> {
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
        let screens = screens_of(&self.settings, &self.settings.coats, self.size(), seed)?;
        self.screens = screens.into_iter().map(Arc::new).collect();
        self.coat_seed = Some(seed);
        let facts = coat_facts(&self.settings, &self.screens);
        self.facts.extend(facts);
        if let Some(rake_rad) = Scene::of(&self.settings, self.size()).lowered_rake_rad() {
            let rake_deg = (rake_rad.to_degrees() * 1e3).round() * 1e-3;
            let pane = json!({ "rake_deg": rake_deg });
            self.facts.insert("pane".to_owned(), pane);
        }
        Ok(self)
    }

    /// Shares of the frame that mud covers, and of the pane that it was to cover; none without mud.
    #[must_use]
    pub fn mud_covers(&self) -> Option<[f64; 2]> {
        let mut coats = self.settings.coats.iter().zip(&self.screens);
        coats.find_map(|(coat, screen)| match coat {
            Coat::Mud(mud) => Some([screen.mean_covered(), mud.coverage]),
            _ => None,
        })
    }

    /// Whether what lies on the glass, or the light on it, changes as time goes: rain falls, dew and frost come and go,
    /// the sun turns.
    #[must_use]
    pub fn ages(&self) -> bool {
        self.rains() || self.sun_turns() || self.settings.coats.iter().any(Coat::grows)
    }

    /// Whether the sun turns about the camera as time goes.
    fn sun_turns(&self) -> bool {
        match &self.settings.optics {
            OpticsSettings::Physical(optics) => optics.environment.sun_turns_rad_s != 0.0,
            OpticsSettings::Paper(_) => false,
        }
    }

    /// Where the sun is, degrees from the optical axis to the right, if it turns.
    #[must_use]
    pub fn turning_sun_deg(&self) -> Option<f64> {
        match &self.settings.optics {
            OpticsSettings::Physical(optics) if self.sun_turns() => {
                Some((optics.environment.sun_azimuth_rad.to_degrees() * 1e6).round() * 1e-6)
            }
            _ => None,
        }
    }

    /// Whether drops fall that can be made again at another time; those of a bank stay as they are.
    pub(super) fn rains(&self) -> bool {
        self.settings.drops.is_some() && self.on_pane.is_some()
    }

    /// How frames show the coats so many seconds later: those that grow anew, where they are not as they were last.
    fn screens_later(&self, settings: &Settings, after_s: f64) -> Result<Vec<Arc<Screen>>, Error> {
        let Some(seed) = self.coat_seed else {
            return Ok(Vec::new());
        };
        let growing = settings.coats.iter().filter(|coat| coat.grows());
        let grown: Vec<Coat> = growing.map(|coat| coat.later(after_s)).collect();
        let find = |new: &[Coat]| screens_of(settings, new, self.size(), seed);
        let mut grown = self.kept.coats(&grown, seed, find)?.into_iter();
        let coats = settings.coats.iter().zip(&self.screens);
        let each = coats.map(|(coat, screen)| {
            let grown = if coat.grows() { grown.next() } else { None };
            grown.unwrap_or_else(|| Arc::clone(screen))
        });
        Ok(each.collect())
    }

    /// What it is like so many seconds later, with the network as it is at a time in the unit of its arrivals; none is
    /// before the impact. Says of the damage only what lies on the glass.
    ///
    /// # Errors
    /// As for [`Chain::of`].
    pub fn later(&self, after_s: f64, growth: Option<f64>) -> Result<Self, Error> {
        let (mut settings, size) = (self.settings.clone(), self.size());
        if let OpticsSettings::Physical(optics) = &mut settings.optics {
            optics.environment = optics.environment.later(after_s);
        }
        let (rains, sun_turns) = (self.rains(), self.sun_turns());
        let seed = match &self.origin {
            Origin::Network(cracks) => cracks.seed,
            Origin::Photo(_) | Origin::Stored => self.coat_seed.unwrap_or(Seed(0)),
        };
        let on_pane = if rains {
            deposit_of(&settings, size, seed, (after_s, Some(&self.kept)))?.map(Arc::new)
        } else {
            self.on_pane.clone()
        };
        // Under a sun that turns each drop glints otherwise in each frame.
        let kept = Some(&*self.kept).filter(|_| !sun_turns);
        let on = on_pane.as_deref().map(|on| (on, kept));
        let layer = match (&self.origin, growth) {
            (_, None) => PaneLayer::whole(&settings, size, on)?,
            (Origin::Network(cracks), Some(time)) if rains || sun_turns || time.is_finite() => {
                let network = (&cracks.network, time);
                PaneLayer::of_network_under(&settings, network, size, on, cracks.seed)?
            }
            (Origin::Stored, Some(_)) if rains => PaneLayer::whole(&settings, size, on)?,
            // Nothing of it changes.
            _ => self.layer.clone(),
        };
        let mut screens = self.screens_later(&settings, after_s)?;
        let mut facts: Map<String, Value> = drops_fact(&settings, on_pane.as_deref())
            .into_iter()
            .chain(coat_facts(&settings, &screens))
            .collect();
        if let Some(wiper) = on_pane.as_deref().and_then(|on| on.wiper.as_ref())
            && let Some(screen) = screen_of_wiper(&settings, wiper, size)?
            && !screen.is_nothing()
        {
            let fact = report::wiper_to_json(&screen);
            facts.extend(fact.map(|fact| ("wiper".to_owned(), fact)));
            screens.push(Arc::new(screen));
        }
        Ok(Self {
            settings,
            layer,
            on_pane,
            screens,
            lens: self.lens.clone(),
            coat_seed: self.coat_seed,
            origin: Origin::Stored,
            facts,
            is_glass_intact: self.is_glass_intact,
            kept: Arc::default(),
        })
    }
}
