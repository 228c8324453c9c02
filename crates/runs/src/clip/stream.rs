//! Frames that another part of the runs reads and writes, behind glass as those of a clip.

use std::sync::Arc;

use image::GrayImage;
use serde_json::{Value, json};
use starbreak::{Chain, PaneLayer, Settings};
use starbreak_seed::Seed;

use super::light::ClipLight;
use super::pixels::Pixels;
use super::show::{Kept, Show, Shown};
use super::sink::Target;
use super::source::Frame;
use super::stage::{Masks, StageFacts};
use super::timeline::{GlassState, Timeline};
use super::{Growth, Light};
use crate::{Error, Patterns};

/// The glass in front of a camera, broken and whole.
#[derive(Debug)]
pub(crate) struct Pane {
    chain: Chain,
    /// Before the impact.
    bare: PaneLayer,
}

impl Pane {
    /// By a recipe's settings, for frames of this size; the same seed gives the same pane.
    pub(crate) fn of(settings: &Settings, size: (u32, u32), seed: Seed) -> Result<Self, Error> {
        let chain = Patterns::Fresh.for_clip(settings, size, seed)?;
        let bare = chain.before_impact()?;
        Ok(Self { chain, bare })
    }
}

/// What becomes of the frames of a camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StreamParams<'a> {
    pub(crate) settings: &'a Settings,
    /// Seed of the run and name of the camera, for what differs from frame to frame.
    pub(crate) seed: Seed,
    pub(crate) name: &'a str,
    /// When the glass is hit, in the time of the frames, s.
    pub(crate) impact_at_s: f64,
    pub(crate) growth: Growth,
    pub(crate) light: Light,
    /// What a frame lasts, s.
    pub(crate) frame_s: f64,
    pub(crate) with_masks: bool,
}

/// The frames of a camera, one after the other.
pub(crate) struct Stream<'a> {
    show: Show<'a>,
    kept: Kept<'a>,
}

/// A frame on its way in.
pub(crate) struct StreamFrame {
    /// Its place in the stream.
    pub(crate) idx: u64,
    /// Its time, s.
    pub(crate) time_s: f64,
    pub(crate) pixels: Pixels,
}

/// A frame behind the glass.
pub(crate) struct StreamShown {
    pub(crate) pixels: Pixels,
    /// Whether the pixels are those that came in.
    pub(crate) is_untouched: bool,
    facts: Arc<StageFacts>,
    pub(crate) region_fraction: f64,
    /// Whether the damage has begun by then, whatever the frame shows.
    pub(crate) has_begun: bool,
    pub(crate) is_growing: bool,
    /// What a line of a track says of it.
    pub(crate) line: Value,
}

impl<'a> Stream<'a> {
    /// Behind a pane; the first frame has this index.
    ///
    /// # Errors
    /// [`Error::Clip`] for growth that there is not.
    pub(crate) fn new(
        pane: &'a Pane,
        params: StreamParams<'a>,
        first_idx: u64,
    ) -> Result<Self, Error> {
        let chain = &pane.chain;
        let show = Show {
            timeline: Timeline::new(chain, params.impact_at_s, params.growth, params.frame_s)?,
            chain,
            bare: chain.layer_under(&pane.bare, None)?,
            bare_layer: &pane.bare,
            settings: params.settings,
            target: Target::Caller,
            seed: params.seed,
            name: params.name,
            masks: match params.with_masks {
                true => Masks::Pixels,
                false => Masks::No,
            },
        };
        let light = ClipLight::new(params.light, params.frame_s).starting_at(first_idx);
        let kept = show.kept(light)?;
        Ok(Self { show, kept })
    }

    /// The next frames behind the glass, in their order; how they are grouped makes no difference.
    pub(crate) fn batch(&mut self, frames: Vec<StreamFrame>) -> Result<Vec<StreamShown>, Error> {
        let frames = frames.into_iter().map(|frame| Frame {
            idx: frame.idx,
            time_s: frame.time_s,
            ticks: 0,
            pixels: frame.pixels,
            file: None,
        });
        let shown = self.show.batch(&mut self.kept, frames.collect())?;
        Ok(shown.into_iter().filter_map(StreamShown::of).collect())
    }
}

impl StreamShown {
    fn of(shown: Shown) -> Option<Self> {
        let Shown { ready, facts, line } = shown;
        let (pixels, is_untouched) = ready.into_pixels()?;
        Some(Self {
            pixels,
            is_untouched,
            facts,
            region_fraction: line.region_fraction,
            has_begun: line.has_begun,
            is_growing: line.state == GlassState::Growing,
            line: serde_json::to_value(line).unwrap_or(json!(null)),
        })
    }

    /// Affected pixels, if asked for.
    pub(crate) fn region(&self) -> Option<&GrayImage> {
        let [region, _] = self.facts.masks.as_ref()?;
        Some(region.upright())
    }
}
