//! Where the light that a crack shows comes from.

use std::f64::consts::FRAC_1_PI;

use super::SheetView;
use crate::environment::{HemisphereWeights, Horizon};
use crate::interface::fresnel::reflectance;
use crate::interface::gap::GapTable;
use crate::interface::ggx::{distribution, g1, sample_visible_normal};
use crate::vector::{cross, dot, unit};

/// Lanes of a facet: shares of the light of the horizon, the zenith, the ground, the cabin and
/// another place of the frame; the sun's; and that other place, weighted by its share.
pub(crate) const LANES: usize = 8;
/// Lanes that are shares of coverage: all but the sun and the place.
pub(crate) const N_SHARES: usize = 5;
pub(crate) const HORIZON: usize = 0;
pub(crate) const ZENITH: usize = 1;
pub(crate) const GROUND: usize = 2;
pub(crate) const CABIN: usize = 3;
pub(crate) const FRAME: usize = 4;
/// Radiance over the sun's irradiance.
pub(crate) const SUN: usize = 5;
pub(crate) const FRAME_U: usize = 6;
pub(crate) const FRAME_V: usize = 7;

/// Angular radius of the sun, rad.
const SUN_RADIUS_RAD: f64 = 0.004_65;

/// Below this α a surface is a mirror.
const MIRROR_ALPHA: f64 = 2e-3;

/// Below this α its facets differ too little in their reflectance to ask each.
const NARROW_ALPHA: f64 = 0.05;

/// Directions that a nearly smooth and a rough surface are sampled by.
const N_SAMPLES: [u32; 2] = [4, 40];

/// What is the same for all cracks before one camera.
#[derive(Debug)]
pub(crate) struct LightFrom<'a> {
    pub(crate) sheet: &'a SheetView,
    pub(crate) horizon: Horizon,
    /// Direction to the sun in the sheet's coordinates.
    pub(crate) sun: [f64; 3],
    pub(crate) gaps: &'a GapTable,
    /// What the outer face sees.
    pub(crate) outside: HemisphereWeights,
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

/// What a surface sends to the camera.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Sent {
    pub(crate) lanes: [f64; LANES],
    /// How much more each color is reflected than the mean of the three.
    pub(crate) tint: [f64; 3],
}

impl LightFrom<'_> {
    /// What is seen in a surface; what passes through the surface is not among it.
    ///
    /// The shares sum to the reflectance. Rough surfaces reflect as facets that are distributed
    /// by GGX \[Walter2007\]; light that facets hide from each other, and light that the faces
    /// hold in the sheet, leaves it as from a white surface, half to either side. Nothing is lost.
    pub(crate) fn mirror(&self, mirror: &Mirror) -> Sent {
        self.reflected(mirror, into_glass(mirror.sight, self.sheet.index))
    }

    /// What is seen in the back of a surface by way of the outer face, which reflects R of the
    /// light of sight. It takes the place of as much light of the cabin, so that all shares sum
    /// to 0: a surface across the sheet has no ghost, for it shows the cabin once more.
    pub(crate) fn ghost(&self, mirror: &Mirror) -> Sent {
        let n = self.sheet.index;
        let [x, y, z] = into_glass(mirror.sight, n);
        let mut sent = self.reflected(mirror, [x, y, -z]);
        let face = reflectance(mirror.sight[2], n);
        sent.lanes = sent.lanes.map(|lane| face * lane);
        sent.lanes[CABIN] -= sent.lanes[..N_SHARES].iter().sum::<f64>();
        sent
    }

    /// What a ray of sight that runs along `sight` in the glass sees in a surface.
    fn reflected(&self, mirror: &Mirror, sight: [f64; 3]) -> Sent {
        let facing = dot(sight, mirror.normal);
        let normal = mirror
            .normal
            .map(|part| if facing > 0.0 { -part } else { part });
        let view = sight.map(|part| -part);
        let mut sent = Sent::default();
        if facing.abs() < 1e-9 {
            return sent;
        }
        let rgb = self.gaps.rgb(facing.abs(), mirror.gap_um);
        let mean = (rgb[0] + rgb[1] + rgb[2]) / 3.0;
        if mirror.alpha < MIRROR_ALPHA {
            let direction = reflected(sight, normal, facing.abs());
            self.leave(&mut sent, mirror.sight, direction, mean);
        } else {
            let n_samples = N_SAMPLES[usize::from(mirror.alpha >= NARROW_ALPHA)];
            let share = 1.0 / f64::from(n_samples);
            let frame = Frame::about(normal);
            let local = frame.local(view);
            for k in 0..n_samples {
                let facet = frame.world(sample_visible_normal(local, mirror.alpha, point(k)));
                let cos_h = dot(view, facet);
                // Facets of a nearly smooth surface reflect as the whole does.
                let r = if mirror.alpha < NARROW_ALPHA {
                    mean
                } else {
                    self.mean_reflectance(cos_h.abs(), mirror.gap_um)
                };
                let direction = reflected(sight, facet, cos_h);
                let cos_o = dot(direction, normal);
                let seen = if cos_o > 0.0 {
                    g1(cos_o, mirror.alpha)
                } else {
                    0.0
                };
                self.leave(&mut sent, mirror.sight, direction, share * r * seen);
                self.diffuse(&mut sent, share * r * (1.0 - seen));
            }
        }
        sent.lanes[SUN] += self.glint(mirror, view, normal);
        sent.tint = rgb.map(|color| color - mean);
        sent
    }

    /// Reflectance of a gap, the mean of the three colors.
    fn mean_reflectance(&self, cos_in_glass: f64, gap_um: f64) -> f64 {
        self.gaps.rgb(cos_in_glass, gap_um).iter().sum::<f64>() / 3.0
    }

    /// The sun in a surface: radiance over irradiance.
    ///
    /// L/E = T₁ T₂ (cos θ / cos θ′)/n² F D G₁ G₁ / (4 |v·n|), with T₂ over the transmittance that
    /// the image already has.
    fn glint(&self, mirror: &Mirror, view: [f64; 3], normal: [f64; 3]) -> f64 {
        let n = self.sheet.index;
        if self.sun[2] <= 0.0 {
            return 0.0;
        }
        let sun = into_glass(self.sun, n);
        let (cos_v, cos_s) = (dot(view, normal), dot(sun, normal));
        if cos_v <= 1e-6 || cos_s <= 0.0 {
            return 0.0;
        }
        let half = unit(std::array::from_fn(|k| view[k] + sun[k]));
        let (cos_h, cos_vh) = (dot(half, normal), dot(half, view));
        // The sun's own width, in the glass, as a width of the lobe.
        let width = SUN_RADIUS_RAD / n;
        let alpha = (mirror.alpha * mirror.alpha + width * width).sqrt();
        let fresnel = self.mean_reflectance(cos_vh.abs(), mirror.gap_um);
        let enters = 1.0 - reflectance(self.sun[2], n);
        let leaves = 1.0 + reflectance(mirror.sight[2], n);
        enters * leaves * self.sun[2] / sun[2] / (n * n)
            * fresnel
            * distribution(cos_h, alpha)
            * g1(cos_v, alpha)
            * g1(cos_s, alpha)
            / (4.0 * cos_v)
    }

    /// Follows light out of the sheet, against its way.
    fn leave(&self, sent: &mut Sent, sight: [f64; 3], direction: [f64; 3], share: f64) {
        let n = self.sheet.index;
        let [x, y, z] = direction;
        let sine2 = n * n * (x * x + y * y);
        if sine2 >= 1.0 {
            // Held by the faces, until another crack turns it; hardly towards the sun.
            let sun = sent.lanes[SUN];
            self.diffuse(sent, share);
            sent.lanes[SUN] = sun;
        } else if z <= 0.0 {
            sent.lanes[CABIN] += share;
        } else {
            let out = [n * x, n * y, (1.0 - sine2).sqrt()];
            // Through both faces, over the transmittance at the angle of sight that the image has
            // already: above 1 where the light meets the outer face more steeply. The rest is the
            // cabin's, of which the image then has too much.
            let (enters, leaves) = (reflectance(out[2], n), reflectance(sight[2], n));
            let passes = (1.0 - enters) * (1.0 + leaves) / (1.0 - enters * leaves);
            sent.lanes[CABIN] += share * (1.0 - passes);
            self.seen(sent, self.sheet.camera_from_sheet(out), share * passes);
        }
    }

    /// Adds the light of one direction, in camera coordinates.
    pub(crate) fn seen(&self, sent: &mut Sent, direction: [f64; 3], share: f64) {
        if let Some([u, v]) = self.sheet.in_frame(direction) {
            sent.lanes[FRAME] += share;
            sent.lanes[FRAME_U] += share * u;
            sent.lanes[FRAME_V] += share * v;
            return;
        }
        let sine = self.horizon.sin_elevation(direction);
        if sine < 0.0 {
            sent.lanes[GROUND] += share;
        } else {
            sent.lanes[HORIZON] += share * (1.0 - sine);
            sent.lanes[ZENITH] += share * sine;
        }
    }

    /// Adds light that comes evenly from both sides of the sheet, as a white surface sends it.
    pub(crate) fn diffuse(&self, sent: &mut Sent, share: f64) {
        let half = 0.5 * share;
        sent.lanes[CABIN] += half;
        sent.lanes[HORIZON] += half * self.outside.horizon;
        sent.lanes[ZENITH] += half * self.outside.zenith;
        sent.lanes[GROUND] += half * self.outside.ground;
        sent.lanes[SUN] += half * self.sun[2].max(0.0) * FRAC_1_PI;
    }
}

/// A direction of the air on its way in the glass.
pub(crate) fn into_glass([x, y, z]: [f64; 3], n: f64) -> [f64; 3] {
    let (x, y) = (x / n, y / n);
    [x, y, (1.0 - x * x - y * y).sqrt().copysign(z)]
}

fn reflected(sight: [f64; 3], normal: [f64; 3], cos: f64) -> [f64; 3] {
    std::array::from_fn(|k| sight[k] + 2.0 * cos * normal[k])
}

/// The k-th of evenly spread points in the unit square: the two-dimensional golden ratio
/// \[Roberts2018\].
fn point(k: u32) -> [f64; 2] {
    let k = f64::from(k) + 0.5;
    [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (k * step).fract())
}

/// Axes in which a normal is z.
struct Frame([[f64; 3]; 3]);

impl Frame {
    fn about(normal: [f64; 3]) -> Self {
        let aside = if normal[0].abs() < 0.7 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        };
        let x = unit(cross(aside, normal));
        Self([x, cross(normal, x), normal])
    }

    fn local(&self, v: [f64; 3]) -> [f64; 3] {
        self.0.map(|axis| dot(axis, v))
    }

    fn world(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| (0..3).map(|axis| v[axis] * self.0[axis][k]).sum())
    }
}
