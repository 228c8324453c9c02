//! A clip without an end, whose frames come one by one and go on at once.

use image::DynamicImage;
use starbreak::optics::FrameMut;
use starbreak::sensor::{FrameState, Frames, Moment, Sensor};
use starbreak::{Chain, KeptFrame, Lit, PaneLayer};
use starbreak_dataset::video::Fraction;
use starbreak_optics::environment::Environment;
use starbreak_seed::Seed;

use super::light::ClipLight;
use super::timeline::{GlassState, Timeline};
use super::{ClipError, Growth, Light};
use crate::{Error, Patterns, RunContext};

/// What is to become of frames that come one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct LiveRequest {
    /// What the seeds of the frames are keyed by, as by the name of a clip's file.
    pub name: String,
    /// Width and height of the frames, px.
    pub size_px: (u32, u32),
    /// Frames per second, by which a frame's number says its time.
    pub rate: Fraction,
    /// When the glass is hit, s after the first frame; 0 for a crack that is there all along.
    pub impact_at_s: f64,
    /// Whether the growth of the cracks is shown.
    pub growth: Growth,
    /// Which light the crack is under.
    pub light: Light,
}

/// Damage that is ready for frames that come one by one.
///
/// The same damage as [`Clip::run`](super::Clip::run) gives a clip of this name: of the same frames it makes the same
/// codes. Nothing is measured and no track is kept.
#[derive(Debug)]
pub struct LiveClip {
    request: LiveRequest,
    chain: Chain,
    bare_layer: PaneLayer,
    timeline: Timeline,
    /// What a frame lasts, s.
    frame_s: f64,
    /// Of the run.
    seed: Seed,
}

impl LiveClip {
    /// Breaks the glass.
    ///
    /// # Errors
    /// [`Error::Clip`] for a request that makes no sense, [`Error::Chain`] where the glass cannot be broken or shown.
    pub fn open(
        request: LiveRequest,
        context: &RunContext,
        patterns: &Patterns,
    ) -> Result<Self, Error> {
        request.growth.check()?;
        let impact_at_s = request.impact_at_s;
        if !(impact_at_s >= 0.0 && impact_at_s.is_finite()) {
            return Err(ClipError::LiveImpactTime { impact_at_s }.into());
        }
        let seed = context.seed.of_item(&request.name, 0);
        let chain = patterns.for_clip(&context.settings, request.size_px, seed)?;
        let frame_s = 1.0 / request.rate.value();
        Ok(Self {
            bare_layer: chain.before_impact()?,
            timeline: Timeline::new(&chain, impact_at_s, request.growth, frame_s)?,
            frame_s,
            seed: context.seed,
            chain,
            request,
        })
    }

    /// The damage.
    #[must_use]
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// When a frame begins, s after the first.
    #[must_use]
    pub fn time_s(&self, frame_idx: u64) -> f64 {
        let ticks = i64::try_from(frame_idx).unwrap_or(i64::MAX);
        self.request.rate.inverse().seconds(ticks)
    }

    /// From the first frame on.
    ///
    /// # Errors
    /// [`Error::Chain`] for a packed pattern whose bytes are wrong.
    pub fn frames(&self) -> Result<LiveFrames<'_>, Error> {
        Ok(LiveFrames {
            clip: self,
            bare: self.chain.layer_under(&self.bare_layer, None)?,
            light: ClipLight::new(self.request.light, self.frame_s),
            still: None,
            kept: KeptFrame::default(),
            last_good: None,
            next_idx: 0,
        })
    }

    fn sensor(&self) -> Option<&Sensor> {
        let faults = self.chain.settings().faults.as_ref();
        faults.map(|faults| &faults.sensor)
    }

    /// Whether a frame may repeat one before.
    fn may_repeat(&self) -> bool {
        let frames = self.sensor().and_then(|sensor| sensor.get::<Frames>());
        frames.is_some_and(|frames| frames.frozen + frames.dropped > 0.0)
    }
}

/// Frames of a [`LiveClip`], one after the other; some may be left out.
#[derive(Debug)]
pub struct LiveFrames<'a> {
    clip: &'a LiveClip,
    /// The pane before the impact in the dark, which tells whether a frame stays as it is.
    bare: Lit<'a>,
    light: ClipLight,
    /// The full cracks under the last light.
    still: Option<(Option<Environment>, Lit<'a>)>,
    kept: KeptFrame,
    /// The last frame that arrived, where others may repeat it.
    last_good: Option<(DynamicImage, Now)>,
    next_idx: u64,
}

/// The glass of a frame, and its light.
#[derive(Debug, Clone, Copy)]
struct Now {
    at: Moment,
    state: GlassState,
    grown: f64,
    light: Option<Environment>,
}

impl LiveFrames<'_> {
    /// Puts the damage over the next frame, where that lies, by its number from 0; later ones follow, of which some may be
    /// left out. The light follows what is seen up to this frame, with the times of those left out.
    ///
    /// Gives what the glass is like then, whatever frame is shown. Memory of a frame is taken once for what [`Lit::over_frame`] keeps; while cracks grow
    /// they are baked for each frame.
    ///
    /// # Errors
    /// [`Error::Chain`] for a frame of another size, [`Error::Clip`] for one before the last; the frame may then be half
    /// changed.
    pub fn over(&mut self, frame: &mut FrameMut<'_>, frame_idx: u64) -> Result<GlassState, Error> {
        let clip = self.clip;
        if frame_idx < self.next_idx {
            let next_idx = self.next_idx;
            return Err(ClipError::FrameBefore {
                frame_idx,
                next_idx,
            }
            .into());
        }
        let is_first = self.last_good.is_none();
        #[expect(clippy::cast_precision_loss, reason = "a count of frames")]
        let elapsed_s = (frame_idx - self.next_idx + 1) as f64 * clip.frame_s;
        self.next_idx = frame_idx + 1;
        let (name, time_s) = (&clip.request.name, clip.time_s(frame_idx));
        let at = Moment {
            frame: clip.seed.of_item(name, frame_idx),
            clip: clip.seed.of_item(name, 0),
            frame_idx,
            time_s,
        };
        let own = match self.light.wants_more() {
            true => clip.chain.light_of_frame(frame),
            false => None,
        };
        // The light goes on, whatever arrives.
        let light = self.light.next_in(own, elapsed_s);
        let arrives = clip
            .sensor()
            .map_or(FrameState::Good, |sensor| sensor.at(time_s).frame_state(at));
        let (state, grown) = clip.timeline.at(time_s);
        if arrives.repeats()
            && let Some((pixels, now)) = &mut self.last_good
        {
            let now = *now;
            frame.copy_from(pixels).map_err(starbreak::Error::from)?;
            self.put(frame, now)?;
            return Ok(state);
        }
        let now = Now {
            at,
            state,
            grown,
            light,
        };
        // Before any good one the first frame is repeated, whatever it is.
        if (arrives == FrameState::Good || is_first) && clip.may_repeat() {
            let (mut pixels, _) = self
                .last_good
                .take()
                .unwrap_or((DynamicImage::default(), now));
            frame.copy_to(&mut pixels);
            self.last_good = Some((pixels, now));
        }
        self.put(frame, now)?;
        Ok(state)
    }

    fn put(&mut self, frame: &mut FrameMut<'_>, now: Now) -> Result<(), Error> {
        let (chain, light, kept) = (&self.clip.chain, now.light.as_ref(), &mut self.kept);
        if chain.ages() {
            let growth = match now.state {
                GlassState::Intact => None,
                GlassState::Growing => Some(now.grown),
                GlassState::Still => Some(f64::INFINITY),
            };
            let aged = chain.later(now.at.time_s, growth)?;
            aged.under(light)?.over_frame(frame, kept, now.at)?;
            return Ok(());
        }
        match now.state {
            GlassState::Still => {
                let is_same = |(of, _): &(Option<Environment>, Lit<'_>)| *of == now.light;
                if !self.still.as_ref().is_some_and(is_same) {
                    self.still = Some((now.light, chain.under(light)?));
                }
                if let Some((_, lit)) = &self.still {
                    lit.over_frame(frame, kept, now.at)?;
                }
            }
            GlassState::Growing => {
                let grown = chain.grown_at(now.grown)?;
                let lit = chain.layer_under(&grown, light)?;
                lit.over_frame(frame, kept, now.at)?;
            }
            GlassState::Intact if self.bare.changes_nothing(now.at.time_s) => {}
            GlassState::Intact => {
                // Coats and ghosts shine with the light around the camera.
                let bare = chain.layer_under(&self.clip.bare_layer, light)?;
                bare.over_frame(frame, kept, now.at)?;
            }
        }
        Ok(())
    }

    /// How many lights there were.
    #[must_use]
    pub fn n_lights(&self) -> u64 {
        self.light.n_lights()
    }
}
