//! Where the light that a crack shows comes from.

use std::f64::consts::FRAC_1_PI;

use super::SheetView;
use super::roughness::{MIRROR_ALPHA, NARROW_ALPHA, Sampled, Way};
use crate::environment::{HemisphereWeights, Horizon, smooth_step};
use crate::interface::fresnel::{reflectance, reflectance_of};
use crate::interface::gap::GapTable;
use crate::interface::ggx::Glint;
use crate::number::Number;
use crate::vector::{Vector, dot};

/// Lanes of a facet: shares of the light of the horizon, the zenith, the ground, the cabin as it
/// is straight down and straight up, of light that the sheet holds, and of another place of the
/// frame; the sun's; and that other place, weighted by its share, with how far it is from the middle.
/// [`WIDTH`] is for what the layer makes of it. Processors add four at once.
pub(crate) const LANES: usize = 12;
/// Lanes that are shares of coverage: all but the sun and the place.
pub(crate) const N_SHARES: usize = 7;
pub(crate) const HORIZON: usize = 0;
pub(crate) const ZENITH: usize = 1;
pub(crate) const GROUND: usize = 2;
pub(crate) const CABIN_LOW: usize = 3;
pub(crate) const CABIN_HIGH: usize = 4;
/// Light that both faces reflect totally: it comes from the rim of the pane, or from nowhere.
pub(crate) const HELD: usize = 5;
pub(crate) const FRAME: usize = 6;
/// Radiance over the sun's irradiance.
pub(crate) const SUN: usize = 7;
/// Square of how far that other place is from the middle of the frame, px², weighted by its share. Layers leave none.
pub(crate) const SQUARE: usize = 8;
/// Over how much of the frame about that other place, px, its light is averaged: where the blur
/// mixes two mirrors that show places far apart, the mean place is the middle of much, not a
/// picture of its own. No facet has one.
pub(crate) const WIDTH: usize = 9;
pub(crate) const FRAME_U: usize = 10;
pub(crate) const FRAME_V: usize = 11;

/// Angular radius of the sun, rad.
const SUN_RADIUS_RAD: f64 = 0.004_65;

/// What is the same for all cracks before one camera.
#[derive(Debug)]
pub(crate) struct LightFrom<'a> {
    pub(crate) sheet: &'a SheetView,
    pub(crate) horizon: Horizon,
    /// Way beyond the border on which the frame fades into the environment, px, above 0.
    pub(crate) fades_over_px: f64,
    /// Direction to the sun in the sheet's coordinates.
    pub(crate) sun: [f64; 3],
    pub(crate) gaps: &'a GapTable,
    /// What the outer face sees.
    pub(crate) outside: HemisphereWeights,
    /// How much of the cabin's light on the inner face is that of its upper end.
    pub(crate) inside_high: f64,
}

/// A surface within the glass, as one ray of sight meets it; in the sheet's coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mirror {
    /// Direction of sight before the glass.
    pub(crate) sight: [f64; 3],
    pub(crate) normal: [f64; 3],
    pub(crate) alpha: f64,
    pub(crate) gap_um: f64,
}

/// The face towards the camera along a direction of sight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Before<N = f64> {
    /// What it reflects.
    pub(super) reflects: N,
    /// How much of the cabin's light in it is that of the upper end.
    pub(super) cabin_high: N,
}

/// What a surface sends to the camera.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Sent {
    pub(crate) lanes: [f64; LANES],
    /// How much more each color is reflected than the mean of the three.
    pub(crate) tint: [f64; 3],
}

impl Sent {
    /// Adds what another surface sends, times a weight.
    pub(super) fn add(&mut self, other: &Self, weight: f64) {
        for (lane, more) in self.lanes.iter_mut().zip(other.lanes) {
            *lane += weight * more;
        }
        for (tint, more) in self.tint.iter_mut().zip(other.tint) {
            *tint += weight * more;
        }
    }

    pub(super) fn scaled(&self, by: f64) -> Self {
        Self {
            lanes: self.lanes.map(|lane| by * lane),
            tint: self.tint.map(|part| by * part),
        }
    }
}

impl LightFrom<'_> {
    /// What is seen in a surface; what passes through the surface is not among it.
    ///
    /// The shares sum to the reflectance. Rough surfaces reflect as facets that are distributed
    /// by GGX \[Walter2007\]; light that facets hide from each other leaves as from a white
    /// surface, half to either side. Light that the faces hold in the sheet comes from its rim.
    ///
    /// Other surfaces are not among it, see [`LightFrom::mirror_among`].
    pub(super) fn mirror(&self, mirror: &Mirror, sampled: Sampled) -> Sent {
        let sight = into_glass(mirror.sight, self.sheet.index);
        self.reflected(mirror, sight, (mirror.alpha, sampled))
    }

    /// The sun's light alone of what [`LightFrom::mirror`] finds.
    pub(super) fn sun_in(&self, mirror: &Mirror, sampled: Sampled) -> f64 {
        let sight = into_glass(mirror.sight, self.sheet.index);
        let Some((_, normal)) = towards(sight, mirror.normal) else {
            return 0.0;
        };
        let mut sun = 0.0;
        if mirror.alpha >= NARROW_ALPHA && self.sun[2] > 0.0 {
            self.each_way(mirror, (sight, normal), sampled, |way, share| {
                if matches!(way, Way::Evenly) {
                    sun += self.diffuse_sun(share);
                }
            });
        }
        let before = self.before(mirror.sight);
        sun + self.glint(mirror, &before, sight.map(|part| -part), normal)
    }

    /// What is seen in the back of a surface by way of the outer face, which reflects R of the
    /// light of sight. It takes the place of what that shows of the intact sheet: light of the
    /// cabin, and a little of what is behind the sheet. A surface across the sheet has hardly a
    /// ghost, for it shows the cabin once more.
    pub(crate) fn ghost(&self, mirror: &Mirror) -> Sent {
        let n = self.sheet.index;
        let [x, y, z] = into_glass(mirror.sight, n);
        // It is faint: but for the sun, a rough surface's is that of a smooth one.
        let mut sent = self.reflected(mirror, [x, y, -z], (0.0, Sampled::Whole));
        let before = self.before(mirror.sight);
        let face = before.reflects;
        sent.lanes = sent.lanes.map(|lane| face * lane);
        let all = sent.lanes[..N_SHARES].iter().sum::<f64>();
        let behind = face * (1.0 - face) / (1.0 + face);
        before.mirror_cabin(&mut sent.lanes, -all * (1.0 - behind));
        sent
    }

    /// What a ray of sight that runs along `sight` in the glass sees in a surface: the sun by its
    /// own roughness, all else by that of `alpha`.
    fn reflected(
        &self,
        mirror: &Mirror,
        sight: [f64; 3],
        (alpha, sampled): (f64, Sampled),
    ) -> Sent {
        let view = sight.map(|part| -part);
        let mut sent = Sent::default();
        let Some((facing, normal)) = towards(sight, mirror.normal) else {
            return sent;
        };
        let before = self.before(mirror.sight);
        let rgb = self.gaps.rgb(facing, mirror.gap_um);
        let mean = (rgb[0] + rgb[1] + rgb[2]) / 3.0;
        if alpha < MIRROR_ALPHA {
            let direction = reflected(sight, normal, facing);
            self.follow(&mut sent, &before, direction, mean);
        } else if alpha < NARROW_ALPHA {
            self.narrow(&mut sent, (mirror, &before), (sight, normal), mean);
        } else {
            self.each_way(mirror, (sight, normal), sampled, |way, share| match way {
                Way::Along(direction) => self.follow(&mut sent, &before, direction, share),
                Way::Evenly => self.diffuse(&mut sent, share),
            });
        }
        sent.lanes[SUN] += self.glint(mirror, &before, view, normal);
        sent.tint = rgb.map(|color| color - mean);
        sent
    }

    /// The sun in a surface: radiance over irradiance. T₂ is that over the transmittance that the
    /// image already has.
    fn glint(&self, mirror: &Mirror, before: &Before, view: [f64; 3], normal: [f64; 3]) -> f64 {
        let n = self.sheet.index;
        if self.sun[2] <= 0.0 {
            return 0.0;
        }
        let sun = into_glass(self.sun, n);
        // The sun's own width, in the glass, as a width of the lobe.
        let width = SUN_RADIUS_RAD / n;
        let enters = 1.0 - reflectance(self.sun[2], n);
        let leaves = 1.0 + before.reflects;
        let glint = Glint {
            normal,
            alpha: (mirror.alpha * mirror.alpha + width * width).sqrt(),
            n,
            cos_light: [self.sun[2], sun[2]],
            passes: enters * leaves,
        };
        glint.radiance(view, sun, |cos| self.gaps.mean(cos, mirror.gap_um))
    }

    /// What the face towards the camera does to light along a direction of sight.
    #[inline(always)]
    pub(super) fn before<N: Number>(&self, [x, y, z]: [N; 3]) -> Before<N> {
        Before {
            reflects: reflectance_of(z, self.sheet.index),
            cabin_high: self.cabin_high([x, y, z.less_from(0.0)]),
        }
    }

    /// Follows a share of sight from a surface on, against the way of light. The face towards the
    /// camera reflects R_s of it before it comes to the surface.
    pub(super) fn follow(&self, sent: &mut Sent, before: &Before, direction: Vector, share: f64) {
        before.mirror_cabin(&mut sent.lanes, share * before.reflects);
        self.leave(sent, before, direction, share * (1.0 - before.reflects));
    }

    /// Light on its way to the faces of a sheet without other walls: the face where it comes in
    /// passes (1 − R_e), and both throw what is left to and fro between them, and out.
    fn leave(&self, sent: &mut Sent, before: &Before, direction: Vector, share: f64) {
        let enters = self.face_reflects(direction);
        if enters >= 1.0 {
            sent.lanes[HELD] += share;
            return;
        }
        let through = (1.0 - enters) / (1.0 - enters * before.reflects);
        self.exit(sent, before, direction, share * through);
        let [x, y, z] = direction;
        self.exit(sent, before, [x, y, -z], share * (1.0 - through));
    }

    /// Whether the faces reflect a direction in the sheet totally.
    pub(super) fn is_held(&self, direction: Vector) -> bool {
        self.face_reflects(direction) >= 1.0
    }

    /// What a face reflects of light along a direction in the sheet.
    pub(super) fn face_reflects(&self, [_, _, z]: Vector) -> f64 {
        reflectance(z, 1.0 / self.sheet.index)
    }

    /// Adds what light from the air sends along a direction in the sheet, through whichever face it
    /// came. Light from outside is that of the environment over the sheet's transmittance at the
    /// angle of sight, which the image has already: the rest is what the image then has too much of
    /// the cabin, or too little.
    #[inline]
    pub(super) fn exit(&self, sent: &mut Sent, before: &Before, direction: Vector, share: f64) {
        let n = self.sheet.index;
        let [x, y, z] = direction;
        let cos = (1.0 - n * n * (x * x + y * y)).max(0.0).sqrt();
        let out = [n * x, n * y, cos.copysign(z)];
        if z <= 0.0 {
            return self.cabin(&mut sent.lanes, out, share);
        }
        let seen = share * (1.0 + before.reflects) / (1.0 - before.reflects);
        before.mirror_cabin(&mut sent.lanes, share - seen);
        self.seen(&mut sent.lanes, self.sheet.camera_from_sheet(out), seen);
    }

    /// Adds the cabin's light from a direction, in the sheet's coordinates.
    #[inline(always)]
    pub(super) fn cabin<N: Number>(&self, lanes: &mut [N; LANES], direction: [N; 3], share: N) {
        add_cabin(lanes, self.cabin_high(direction), share);
    }

    /// How much of the cabin's light from a direction is that of its upper end.
    #[inline(always)]
    fn cabin_high<N: Number>(&self, direction: [N; 3]) -> N {
        let sine = self
            .horizon
            .sine_of(self.sheet.camera_from_sheet(direction));
        (sine + sine.all(1.0)).times(0.5)
    }

    /// Adds the light of one direction, in camera coordinates: what the image shows there, and beyond its border what the
    /// border shows, which fades into the environment.
    #[inline(always)]
    pub(crate) fn seen<N: Number>(&self, lanes: &mut [N; LANES], direction: [N; 3], share: N) {
        let ([u, v], away_px) = self.sheet.nearest_in_frame(direction);
        let near = (away_px / share.all(self.fades_over_px)).less_from(1.0);
        let shown = share * smooth_step(near, [0.0, 1.0]);
        let (width, height) = self.sheet.view().size();
        let x = u - share.all(0.5 * f64::from(width));
        let y = v - share.all(0.5 * f64::from(height));
        add(lanes, FRAME, shown);
        add(lanes, FRAME_U, shown * u);
        add(lanes, FRAME_V, shown * v);
        add(lanes, SQUARE, shown * (x * x + y * y));
        let beyond = share - shown;
        if !beyond.is_above(0.0) {
            return;
        }
        let sine = self.horizon.sine_of(direction);
        let none = share.all(0.0);
        let [ground, sky] = [[beyond, none], [none, beyond]].map(|two| sine.below(none, two));
        add(lanes, GROUND, ground);
        add(lanes, HORIZON, sky * sine.less_from(1.0));
        add(lanes, ZENITH, sky * sine);
    }

    /// Adds light that comes evenly from both sides of the sheet, as a white surface sends it.
    pub(crate) fn diffuse(&self, sent: &mut Sent, share: f64) {
        let half = 0.5 * share;
        sent.lanes[CABIN_HIGH] += half * self.inside_high;
        sent.lanes[CABIN_LOW] += half * (1.0 - self.inside_high);
        sent.lanes[HORIZON] += half * self.outside.horizon;
        sent.lanes[ZENITH] += half * self.outside.zenith;
        sent.lanes[GROUND] += half * self.outside.ground;
        sent.lanes[SUN] += self.diffuse_sun(share);
    }

    /// The sun's light of such a share.
    fn diffuse_sun(&self, share: f64) -> f64 {
        0.5 * share * self.sun[2].max(0.0) * FRAC_1_PI
    }
}

impl<N: Number> Before<N> {
    /// Adds the cabin's light as the face towards the camera mirrors it.
    #[inline(always)]
    pub(super) fn mirror_cabin(&self, lanes: &mut [N; LANES], share: N) {
        add_cabin(lanes, self.cabin_high, share);
    }
}

/// Adds the cabin's light, so much of which is that of its upper end.
#[inline(always)]
fn add_cabin<N: Number>(lanes: &mut [N; LANES], part_high: N, share: N) {
    let high = part_high * share;
    add(lanes, CABIN_HIGH, high);
    add(lanes, CABIN_LOW, share - high);
}

/// Adds to one of the lanes.
#[inline(always)]
pub(super) fn add<N: Number>(lanes: &mut [N; LANES], lane: usize, share: N) {
    lanes[lane] = lanes[lane] + share;
}

/// The cosine at which sight meets a surface, and its normal on the side of sight; none along it.
fn towards(sight: Vector, normal: Vector) -> Option<(f64, Vector)> {
    let facing = dot(sight, normal);
    let normal = normal.map(|part| if facing > 0.0 { -part } else { part });
    (facing.abs() >= 1e-9).then_some((facing.abs(), normal))
}

/// A direction of the air on its way in the glass.
pub(crate) fn into_glass([x, y, z]: [f64; 3], n: f64) -> [f64; 3] {
    let (x, y) = (x / n, y / n);
    [x, y, (1.0 - x * x - y * y).sqrt().copysign(z)]
}

pub(super) fn reflected(sight: [f64; 3], normal: [f64; 3], cos: f64) -> [f64; 3] {
    std::array::from_fn(|k| sight[k] + 2.0 * cos * normal[k])
}
