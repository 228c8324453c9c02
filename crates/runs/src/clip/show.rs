//! One frame after the other behind the glass, on many threads: what is kept from frame to frame, and what becomes of
//! each.

use std::sync::Arc;

use image::DynamicImage;
use rayon::prelude::*;
use starbreak::sensor::{FrameState, Frames, Moment, Sensor};
use starbreak::{CameraFaults, Chain, Lit, PaneLayer, Settings};
use starbreak_optics::environment::Environment;
use starbreak_seed::Seed;

use super::light::ClipLight;
use super::sink::{Ready, Target};
use super::source::Frame;
use super::stage::{Masks, StageFacts, Wanted};
use super::timeline::{GlassState, Timeline};
use super::track::{Arrival, TrackFrame};
use crate::Error;

/// Everything that a frame needs to know.
pub(super) struct Show<'a> {
    /// The damage in full.
    pub(super) chain: &'a Chain,
    /// The pane before the impact.
    pub(super) bare_layer: &'a PaneLayer,
    /// The same in the dark, for what no light changes: regions, and whether a frame stays as it is.
    pub(super) bare: Lit<'a>,
    /// Of the run, which says how frames are written.
    pub(super) settings: &'a Settings,
    pub(super) timeline: Timeline,
    pub(super) target: Target,
    /// Seed of the run and name of the clip, for what differs from frame to frame.
    pub(super) seed: Seed,
    pub(super) name: &'a str,
    pub(super) masks: Masks,
}

/// What is kept from batch to batch.
pub(super) struct Kept<'a> {
    light: ClipLight,
    /// The light in the first frame with a crack, by which regions are told: those of still
    /// frames are then the same.
    onset_light: Option<Environment>,
    still: Option<Arc<StageFacts>>,
    /// The full cracks under the last light.
    lit: Option<(Option<Environment>, Arc<Lit<'a>>)>,
    intact: Arc<StageFacts>,
    /// The last frame that arrived, where others may repeat it.
    last_good: Option<(DynamicImage, Plan<'a>)>,
}

/// One frame's glass, and what becomes of the frame.
#[derive(Clone)]
struct Plan<'a> {
    /// When the frame that is shown was taken.
    at: Moment,
    arrives: FrameState,
    /// Whether what is shown is black or white.
    is_blank: bool,
    state: GlassState,
    grown: f64,
    light: Option<Environment>,
    /// The light by which regions are told, as far as it was known then: the frames of a batch that come later do not
    /// count.
    onset_light: Option<Environment>,
    /// For still cracks.
    lit: Option<Arc<Lit<'a>>>,
}

/// A frame that has been shown.
pub(super) struct Shown {
    pub(super) ready: Ready,
    pub(super) facts: Arc<StageFacts>,
    pub(super) line: TrackFrame,
}

impl Kept<'_> {
    /// How many lights there were.
    pub(super) fn n_lights(&self) -> u64 {
        self.light.n_lights()
    }
}

impl<'a> Show<'a> {
    /// What is kept before the first frame.
    pub(super) fn kept(&self, light: ClipLight) -> Result<Kept<'a>, Error> {
        Ok(Kept {
            light,
            onset_light: None,
            still: None,
            lit: None,
            intact: StageFacts::intact(&self.bare, self.chain.size(), self.wanted())?,
            last_good: None,
        })
    }

    /// Shows the cracks in some frames, in parallel; the result does not depend on how many.
    pub(super) fn batch(
        &self,
        kept: &mut Kept<'a>,
        mut batch: Vec<Frame>,
    ) -> Result<Vec<Shown>, Error> {
        let own_light: Result<Vec<Option<Environment>>, Error> = batch
            .par_iter_mut()
            .map(|frame| match kept.light.wants(frame.idx) {
                true => frame.pixels.light(self.chain),
                false => Ok(None),
            })
            .collect();
        let mut plans = Vec::with_capacity(batch.len());
        for (frame, own) in batch.iter_mut().zip(own_light?) {
            plans.push(self.plan(kept, frame, own)?);
        }
        if kept.still.is_none()
            && !self.chain.ages()
            && plans.iter().any(|plan| plan.state == GlassState::Still)
        {
            let lit = self.still_under(kept, kept.onset_light)?;
            kept.still = Some(self.facts(self.chain.layer(), &lit, f64::INFINITY)?);
        }
        let kept = &*kept;
        batch
            .into_par_iter()
            .zip(plans)
            .with_max_len(1)
            .map(|(frame, plan)| self.one(kept, frame, &plan))
            .collect()
    }

    /// What is to be done with a frame, one after the other. One that does not arrive gets the pixels and the glass of
    /// the last that did.
    fn plan(
        &self,
        kept: &mut Kept<'a>,
        frame: &mut Frame,
        own_light: Option<Environment>,
    ) -> Result<Plan<'a>, Error> {
        let at = Moment {
            frame: self.seed.of_item(self.name, frame.idx),
            clip: self.seed.of_item(self.name, 0),
            frame_idx: frame.idx,
            // Clocks of what lies on the glass and of faults do not run backwards; the hit may come later.
            time_s: frame.time_s.max(0.0),
        };
        // The light goes on, whatever arrives.
        let light = kept.light.next(own_light);
        let arrives = self.sensor().map_or(FrameState::Good, |sensor| {
            sensor.at(at.time_s).frame_state(at)
        });
        if arrives.repeats()
            && let Some((pixels, plan)) = &kept.last_good
        {
            frame.pixels.show(pixels)?;
            return Ok(Plan {
                arrives,
                ..plan.clone()
            });
        }
        let is_first = kept.last_good.is_none();
        let (state, grown) = self.timeline.at(frame.time_s);
        let has_changed =
            state != GlassState::Intact || self.chain.ages() && !self.chain.is_broken();
        if has_changed && kept.onset_light.is_none() {
            kept.onset_light = light;
        }
        let is_still = state == GlassState::Still && !self.chain.ages();
        let lit = is_still.then(|| self.still_under(kept, light));
        let plan = Plan {
            at,
            arrives,
            is_blank: arrives.is_blank(),
            state,
            grown,
            light,
            onset_light: kept.onset_light,
            lit: lit.transpose()?,
        };
        // Before any good one the first frame is repeated, whatever it is.
        if (arrives == FrameState::Good || is_first) && self.may_repeat() {
            kept.last_good = Some((frame.pixels.copied()?, plan.clone()));
        }
        Ok(plan)
    }

    /// What is wrong with the camera itself, where anything is.
    fn faults(&self) -> Option<&CameraFaults> {
        self.chain.settings().faults.as_ref()
    }

    /// Whether anything lies on the glass, which it does from the beginning.
    fn has_deposit(&self) -> bool {
        let settings = self.chain.settings();
        !settings.coats.is_empty() || settings.drops.is_some()
    }

    fn sensor(&self) -> Option<&Sensor> {
        self.faults().map(|faults| &faults.sensor)
    }

    /// Whether a frame may repeat one before.
    fn may_repeat(&self) -> bool {
        let frames = self.sensor().and_then(|sensor| sensor.get::<Frames>());
        frames.is_some_and(|frames| frames.frozen + frames.dropped > 0.0)
    }

    /// Whether the glass is hit by a time; where none breaks, whether a fault has begun.
    fn has_begun(&self, time_s: f64) -> bool {
        match self.chain.is_broken() {
            true => self.timeline.at(time_s).0 != GlassState::Intact,
            false => {
                self.has_deposit()
                    || (self.faults()).is_some_and(|faults| !faults.at(time_s.max(0.0)).is_empty())
            }
        }
    }

    fn wanted(&self) -> Wanted {
        let settings = self.chain.settings();
        Wanted {
            masks: self.masks,
            faults: !settings.coats.is_empty() || settings.faults.is_some(),
            classes: settings.output.classes,
        }
    }

    /// The full cracks under a light.
    fn still_under(
        &self,
        kept: &mut Kept<'a>,
        light: Option<Environment>,
    ) -> Result<Arc<Lit<'a>>, Error> {
        if let Some((of, lit)) = &kept.lit
            && *of == light
        {
            return Ok(Arc::clone(lit));
        }
        let lit = Arc::new(self.chain.under(light.as_ref())?);
        kept.lit = Some((light, Arc::clone(&lit)));
        Ok(lit)
    }

    fn facts(
        &self,
        layer: &PaneLayer,
        lit: &Lit<'_>,
        grown: f64,
    ) -> Result<Arc<StageFacts>, Error> {
        let length_px = self.chain.crack_length_px(grown)?;
        StageFacts::of(layer, lit, length_px, self.wanted())
    }

    fn one(&self, kept: &Kept<'a>, mut frame: Frame, plan: &Plan<'a>) -> Result<Shown, Error> {
        let at = plan.at;
        if self.chain.ages() {
            return self.one_of_its_age(frame, plan);
        }
        match (plan.state, &plan.lit, &kept.still) {
            (GlassState::Still, Some(lit), Some(facts)) => {
                frame.pixels.put_behind(lit, at)?;
                self.shown(frame, plan, (Arc::clone(facts), lit), (false, None))
            }
            (GlassState::Growing, ..) => {
                let grown = self.chain.grown_at(plan.grown)?;
                let lit = self.chain.layer_under(&grown, plan.light.as_ref())?;
                frame.pixels.put_behind(&lit, at)?;
                let facts = if plan.light == kept.onset_light {
                    self.facts(&grown, &lit, plan.grown)?
                } else {
                    let lit = self.chain.layer_under(&grown, kept.onset_light.as_ref())?;
                    self.facts(&grown, &lit, plan.grown)?
                };
                self.shown(frame, plan, (facts, &lit), (false, None))
            }
            _ => {
                let is_untouched =
                    self.bare.changes_nothing(at.time_s) && at.frame_idx == frame.idx;
                let facts = Arc::clone(&kept.intact);
                if is_untouched {
                    return self.shown(frame, plan, (facts, &self.bare), (true, None));
                }
                // Coats and ghosts shine with the light around the camera.
                let bare = (self.chain).layer_under(self.bare_layer, plan.light.as_ref())?;
                frame.pixels.put_behind(&bare, at)?;
                self.shown(frame, plan, (facts, &bare), (false, None))
            }
        }
    }

    /// The same where what lies on the glass changes from frame to frame.
    fn one_of_its_age(&self, mut frame: Frame, plan: &Plan<'a>) -> Result<Shown, Error> {
        let growth = match plan.state {
            GlassState::Intact => None,
            GlassState::Growing => Some(plan.grown),
            GlassState::Still => Some(f64::INFINITY),
        };
        let chain = self.chain.later(plan.at.time_s, growth)?;
        let lit = chain.under(plan.light.as_ref())?;
        let is_untouched = lit.changes_nothing(plan.at.time_s) && plan.at.frame_idx == frame.idx;
        if !is_untouched {
            frame.pixels.put_behind(&lit, plan.at)?;
        }
        let length_px = match growth {
            Some(time) => self.chain.crack_length_px(time)?,
            None => Some(0.0),
        };
        let told = if plan.light == plan.onset_light {
            lit
        } else {
            chain.under(plan.onset_light.as_ref())?
        };
        let facts = StageFacts::of(chain.layer(), &told, length_px, self.wanted())?;
        self.shown(frame, plan, (facts, &told), (is_untouched, Some(&chain)))
    }

    /// A frame that is done, with its line of the track; the facts are those of the glass, behind which a camera may have
    /// faults.
    fn shown(
        &self,
        frame: Frame,
        plan: &Plan<'a>,
        (facts, lit): (Arc<StageFacts>, &Lit<'_>),
        (is_untouched, aged): (bool, Option<&Chain>),
    ) -> Result<Shown, Error> {
        let at = plan.at;
        // Of another frame, which may differ anywhere.
        let is_other = at.frame_idx != frame.idx;
        let seen = (frame.pixels.color(), at);
        let behind = facts.behind(lit, seen, (plan.is_blank, is_other))?;
        let facts = behind.unwrap_or(facts);
        let (frame_idx, time_s) = (frame.idx, frame.time_s);
        let own_masks = match &frame.file {
            Some(file) => facts.masks_as(&file.image)?,
            None => None,
        };
        let mut ready = self.target.prepare(frame, is_untouched, self.settings)?;
        ready.own_masks = own_masks;
        let arrival = self.sensor().and_then(|sensor| sensor.get::<Frames>());
        let line = TrackFrame {
            frame_idx,
            time_s,
            state: plan.state,
            has_begun: self.has_begun(time_s),
            growth: self.timeline.reached(plan.grown),
            crack_length_px: facts.crack_length_px,
            region_fraction: facts.region_fraction,
            on_glass: aged
                .map(|chain| chain.facts().clone())
                .filter(|facts| !facts.is_empty()),
            sun_azimuth_deg: aged.and_then(Chain::turning_sun_deg),
            arrival: arrival.map(|_| Arrival {
                state: plan.arrives.name(),
                shows_frame_idx: (!plan.is_blank).then_some(at.frame_idx),
            }),
            file: ready.file_name().map(str::to_owned),
        };
        Ok(Shown { ready, facts, line })
    }
}
