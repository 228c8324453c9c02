//! What the optics made of the glass, before any light.

use std::f64::consts::FRAC_PI_2;

use image::GrayImage;
use starbreak_deposit::{Area, Cap, Coat, Deposit, Rain, Wiper};
use starbreak_glass::CrackNetwork;
use starbreak_optics::paper::draw;
use starbreak_optics::photo::{PhotoPattern, bake as bake_photo, draw as draw_photo};
use starbreak_optics::physical::{PackedPattern, Pattern, bake};
use starbreak_optics::screens::Screen;
use starbreak_optics::{Coverage, View};
use starbreak_seed::Seed;

use super::kept::Kept;
use crate::photo::PlacedPhoto;
use crate::{Error, OpticsSettings, Scene, Settings};

/// Broken glass before one camera as the optics baked it.
#[derive(Debug, Clone)]
pub enum PaneLayer {
    /// The paper's: lines of the frame.
    Paper(Coverage),
    /// The physical optics': shares of light.
    Baked(Pattern),
    /// The same out of a bank: unpacked as it is given light, for each image anew.
    Packed(PackedPattern),
    /// The physical optics' of a photograph: opacity and light.
    Photo {
        /// The photograph as the lens shows it.
        pattern: PhotoPattern,
        /// Brightness of the photograph's white, over that of a white sheet in the place of the glass.
        gain: f64,
    },
}

/// Most drops that land on a pane: some ten seconds of work.
const MOST_DROPS: f64 = 1e6;

/// The same until a frame of a clip, most of which fell for the frames before it.
const MOST_OF_CLIP: f64 = 1e8;

/// What lies on a pane, on which part of it, and how frames show that.
#[derive(Debug, Clone)]
pub(super) struct OnPane {
    pub(super) deposit: Deposit,
    pub(super) area: Area,
    view: View,
    /// The wiper, while it or the film that it leaves is seen.
    pub(super) wiper: Option<Wiper>,
}

/// What lies on a pane, with what is known of it from frames before.
pub(super) type OnPaneKept<'a> = (&'a OnPane, Option<&'a Kept>);

/// What lies on the pane of some settings, so many seconds after the beginning, with what is known from before; the seed
/// places it.
///
/// # Errors
/// [`Error::Optics`] for a camera that sees nothing, [`Error::TooManyDrops`].
pub(super) fn deposit_of(
    settings: &Settings,
    size_px: (u32, u32),
    seed: Seed,
    (after_s, kept): (f64, Option<&Kept>),
) -> Result<Option<OnPane>, Error> {
    let Some(rain) = &settings.drops else {
        return Ok(None);
    };
    let wiped = rain.later(after_s);
    let scene = Scene::of(settings, size_px);
    let view = scene.sheet()?;
    // Drops run down from above.
    let area = scene.seen_area(&view, 0.4);
    let on_pane = |rain: Rain, n_passes: u64| {
        let rain = match scene.lowered_rake_rad() {
            Some(rake_rad) => Rain {
                slope_rad: FRAC_PI_2 - rake_rad,
                ..rain
            },
            None => rain,
        };
        // Other drops come after each pass.
        let seed = match n_passes {
            0 => seed,
            n => seed.of_item("wiper", n),
        };
        // By the age alone: whether a frame is refused does not depend on those before it.
        let most = if kept.is_some() {
            MOST_OF_CLIP
        } else {
            MOST_DROPS
        };
        let n_drops = rain.n_landing(&area);
        if n_drops > most {
            let way_out = what_to_lower(&rain);
            return Err(Error::TooManyDrops {
                n_drops,
                most,
                way_out,
            });
        }
        Ok(match kept {
            Some(kept) => kept.rain(&rain, &area, seed),
            None => rain.on_pane(&area, seed),
        })
    };
    let mut deposit = on_pane(wiped.rain, wiped.n_passes)?;
    let wiper = wiped.wiper.map(|wiper| wiper.seen_from(axis_mm(&view)));
    if let Some((before, wiper)) = wiped.before.zip(wiper) {
        let before = on_pane(before, wiped.n_passes - 1)?.caps;
        let after = std::mem::take(&mut deposit.caps);
        let is_behind = |cap: &Cap| wiper.has_passed(cap.at_mm);
        deposit.caps = before.into_iter().filter(|cap| !is_behind(cap)).collect();
        deposit.caps.extend(after.into_iter().filter(is_behind));
    }
    Ok(Some(OnPane {
        deposit,
        area,
        view,
        wiper,
    }))
}

/// Where the optical axis meets a pane, mm.
fn axis_mm(view: &View) -> [f64; 2] {
    let (width, height) = view.size();
    let middle = [width, height].map(|side| 0.5 * f64::from(side));
    view.unproject(middle).unwrap_or_default()
}

/// What makes fewer drops land. A wiper helps frames of a clip alone that come after its first stroke.
fn what_to_lower(rain: &Rain) -> String {
    let (age_s, period_s) = (rain.age_s, rain.wiper_period_s);
    let others = "drops.rain_mm_h or glass.distance_m";
    if period_s <= 0.0 {
        format!("drops.age_s, {others}, or let drops.wiper_period_s wipe a clip's pane")
    } else if age_s > period_s {
        format!("drops.age_s ({age_s} s, though the pane is wiped every {period_s} s), {others}")
    } else {
        format!("drops.age_s, {others}, and for a clip drops.wiper_period_s")
    }
}

/// Some coats on the pane of some settings before frames of a size; the seed places them.
///
/// # Errors
/// [`Error::Optics`] for a camera that sees nothing.
pub(super) fn screens_of(
    settings: &Settings,
    coats: &[Coat],
    size_px: (u32, u32),
    seed: Seed,
) -> Result<Vec<Screen>, Error> {
    if coats.is_empty() {
        return Ok(Vec::new());
    }
    let scene = Scene::of(settings, size_px);
    let view = scene.sheet()?;
    let Some(optic) = scene.optic() else {
        return Ok(Vec::new());
    };
    let area = scene.seen_area(&view, 0.1);
    let finest_mm = scene.finest_mm(&view);
    let (width, axis_mm) = (f64::from(size_px.0), axis_mm(&view));
    // A dashboard hides where the pane ends.
    let last_px = (view.dashboard()).row_px(0.5 * width, size_px);
    let end_mm = view.unproject([0.5 * width, last_px]).unwrap_or(area.to_mm)[1];
    Ok((coats.iter())
        .map(|coat| {
            let coat = coat.seen_from(axis_mm, end_mm);
            let coating = coat.on_pane(&area, finest_mm, seed);
            Screen::of(&*coating, &view, &optic)
        })
        .collect())
}

/// How frames show a wiper before a camera that sees it.
///
/// # Errors
/// [`Error::Optics`] for a camera that sees nothing.
pub(super) fn screen_of_wiper(
    settings: &Settings,
    wiper: &Wiper,
    size_px: (u32, u32),
) -> Result<Option<Screen>, Error> {
    let scene = Scene::of(settings, size_px);
    let view = scene.sheet()?;
    if !wiper.may_be_on(&scene.seen_area(&view, 0.1)) {
        return Ok(None);
    }
    Ok((scene.optic()).map(|optic| Screen::of(wiper, &view, &optic)))
}

impl PaneLayer {
    /// Bakes a network as it is at a time, in the unit of its arrivals, for frames of a size, px. The
    /// seed places what it leaves open: grains of crushed glass.
    ///
    /// # Errors
    /// [`Error::NoMount`], [`Error::Optics`], [`Error::TooCostly`].
    pub fn of_network(
        settings: &Settings,
        (network, time): (&CrackNetwork, f64),
        size_px: (u32, u32),
        seed: Seed,
    ) -> Result<Self, Error> {
        let on_pane = deposit_of(settings, size_px, seed, (0.0, None))?;
        let network = (network, time);
        let on = on_pane.as_ref().map(|on| (on, None));
        Self::of_network_under(settings, network, size_px, on, seed)
    }

    /// The same with what lies on the pane.
    pub(super) fn of_network_under(
        settings: &Settings,
        (network, time): (&CrackNetwork, f64),
        size_px: (u32, u32),
        on_pane: Option<OnPaneKept<'_>>,
        seed: Seed,
    ) -> Result<Self, Error> {
        let view = Scene::of(settings, size_px).of_network(network)?;
        let drops = on_pane.map(|(on, _)| (on.deposit.caps.as_slice(), &on.view));
        settings.may_show(network, &view, drops)?;
        Self::baked(settings, (network, time), &view, on_pane, seed)
    }

    /// Glass that is not broken, with what lies on it.
    ///
    /// # Errors
    /// [`Error::Optics`] for a camera that sees nothing.
    pub(super) fn whole(
        settings: &Settings,
        size_px: (u32, u32),
        on_pane: Option<OnPaneKept<'_>>,
    ) -> Result<Self, Error> {
        let none = CrackNetwork::without_cracks(size_px.0, size_px.1);
        let scene = Scene::of(settings, size_px);
        let view = match &settings.optics {
            OpticsSettings::Paper(_) => scene.of_network(&none)?,
            OpticsSettings::Physical(_) => scene.sheet()?,
        };
        Self::baked(settings, (&none, f64::INFINITY), &view, on_pane, Seed(0))
    }

    fn baked(
        settings: &Settings,
        (network, time): (&CrackNetwork, f64),
        view: &View,
        on_pane: Option<OnPaneKept<'_>>,
        seed: Seed,
    ) -> Result<Self, Error> {
        let optics = match &settings.optics {
            OpticsSettings::Paper(optics) => {
                return Ok(Self::Paper(draw(network, view, time, optics)));
            }
            OpticsSettings::Physical(optics) => optics,
        };
        let pattern = bake(network, time, view, optics, seed)?;
        Ok(Self::Baked(match on_pane {
            Some((on, Some(kept))) => {
                pattern.behind_kept(&on.deposit, &on.view, optics, &kept.drops)?
            }
            Some((on, None)) => pattern.behind(&on.deposit, &on.view, optics)?,
            None => pattern,
        }))
    }

    /// Bakes a part of a photograph of broken glass for frames of a size, px.
    ///
    /// # Errors
    /// [`Error::Optics`], [`Error::TooCostly`], [`Error::DropsOnPhoto`].
    pub(super) fn of_photo(
        settings: &Settings,
        placed: &PlacedPhoto,
        size_px: (u32, u32),
    ) -> Result<Self, Error> {
        if settings.drops.is_some() {
            return Err(Error::DropsOnPhoto);
        }
        settings.may_show_photo(size_px)?;
        let photo = &placed.glass.photo;
        Ok(match &settings.optics {
            OpticsSettings::Paper(_) => Self::Paper(draw_photo(photo, &placed.placement, size_px)?),
            OpticsSettings::Physical(optics) => {
                let view = Scene::of(settings, size_px).sheet()?;
                Self::Photo {
                    pattern: bake_photo(photo, &placed.placement, &view, optics)?,
                    gain: placed.options.gain,
                }
            }
        })
    }

    /// Name of the stage that made it.
    pub(super) fn stage(&self) -> &'static str {
        match self {
            Self::Paper(_) => "draw",
            Self::Baked(_) | Self::Packed(_) | Self::Photo { .. } => "bake",
        }
    }

    /// Whether nothing of the damage is in the frame.
    #[must_use]
    pub fn is_intact(&self) -> bool {
        match self {
            Self::Paper(drawn) => drawn.is_empty(),
            Self::Baked(pattern) => pattern.is_intact(),
            Self::Packed(pattern) => pattern.is_intact(),
            Self::Photo { pattern, .. } => pattern.is_intact(),
        }
    }

    /// Width and height of the frame, px.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        match self {
            Self::Baked(pattern) => pattern.size(),
            Self::Packed(pattern) => pattern.size(),
            Self::Photo { pattern, .. } => pattern.size(),
            Self::Paper(drawn) => {
                let (width, height) = drawn.size();
                let side = |n| u32::try_from(n).unwrap_or(u32::MAX);
                (side(width), side(height))
            }
        }
    }

    /// Focal length of the camera, px; the paper's optics have none.
    pub(super) fn f_px(&self) -> Option<f64> {
        match self {
            Self::Paper(_) => None,
            Self::Baked(pattern) => Some(pattern.f_px()),
            Self::Packed(pattern) => Some(pattern.f_px()),
            Self::Photo { pattern, .. } => Some(pattern.f_px()),
        }
    }

    /// Coverage of the frame by cracks as they would be in focus, 255 = in full.
    ///
    /// # Errors
    /// [`Error::Optics`] for a packed pattern whose bytes are wrong.
    pub fn crack_mask(&self) -> Result<GrayImage, Error> {
        Ok(match self {
            Self::Paper(drawn) => drawn.to_mask(),
            Self::Baked(pattern) => pattern.coverage(),
            Self::Packed(pattern) => pattern.coverage()?,
            Self::Photo { pattern, .. } => pattern.coverage(),
        })
    }
}
