//! What becomes of light in a drop of water.

use super::lobe::{Before, HELD, LANES, LightFrom, add};
use crate::interface::fresnel::{reflectance_at, reflectance_of};
use crate::number::Number;
use crate::vector::dot;

/// Refractive index of water in visible light.
const WATER: f64 = 1.333;

/// Times that light is followed within a drop, and the least share of it that is; what is left then is lost.
const MOST_BOUNCES: u32 = 5;
const LEAST_SHARE: f64 = 1e-3;

/// What light meets in drops of a contact angle, whatever their size.
#[derive(Clone, Copy)]
pub(super) struct Water<'a> {
    pub(super) from: &'a LightFrom<'a>,
    /// Sine and cosine of the contact angle: radius of a drop, and how far its footprint is from the middle of its sphere,
    /// of the radius of that.
    sphere: [f64; 2],
}

/// A direction of sight before the glass, and what is the same for all light that is seen along it.
#[derive(Clone, Copy)]
pub(super) struct Sight<N = f64> {
    /// Its parts in the plane of the pane.
    pub(super) along: [N; 2],
    /// The face towards the camera.
    pub(super) before: Before<N>,
    /// What passes from glass to water.
    pub(super) passes: N,
}

impl Sight {
    /// The same of all of several rays, but for the direction of each.
    #[inline(always)]
    pub(super) fn of_all<N: Number>(&self, along: [N; 2]) -> Sight<N> {
        let all = |value: f64| along[0].all(value);
        Sight {
            along,
            before: Before {
                reflects: all(self.before.reflects),
                cabin_high: all(self.before.cabin_high),
            },
            passes: all(self.passes),
        }
    }
}

impl<'a> Water<'a> {
    pub(super) fn of(contact_rad: f64, from: &'a LightFrom<'a>) -> Self {
        let (sin, cos) = libm::sincos(contact_rad);
        let sphere = [sin, cos];
        Self { from, sphere }
    }

    /// Along a direction before the glass.
    #[inline(always)]
    pub(super) fn sight<N: Number>(&self, [x, y, z]: [N; 3]) -> Sight<N> {
        let n = self.from.sheet.index;
        let sine2 = (z * z).less_from(1.0) / z.all(n * n);
        let in_glass = sine2.less_from(1.0).sqrt();
        Sight {
            along: [x, y],
            before: self.from.before([x, y, z]),
            passes: self.passes(in_glass),
        }
    }

    /// What passes from glass to water.
    #[inline(always)]
    fn passes<N: Number>(&self, in_glass: N) -> N {
        reflectance_of(in_glass, WATER / self.from.sheet.index).less_from(1.0)
    }

    /// A place of the outer face in a round drop, of its radius from its middle, from the middle of its sphere, of the
    /// radius of that.
    #[inline(always)]
    pub(super) fn in_round<N: Number>(&self, [x, y]: [N; 2]) -> [N; 3] {
        let [wide, face] = self.sphere;
        [x.times(wide), y.times(wide), x.all(face)]
    }

    /// The same in an uneven drop, by what is a place of a round one.
    #[inline(always)]
    pub(super) fn in_uneven<N: Number>(&self, level: N, slope: [N; 2]) -> [N; 3] {
        let [wide, face] = self.sphere;
        // To a sphere of the same radius whose surface is as high above the place, and as steep: along its normal, from the
        // middle of it.
        let [x, y] = slope.map(|part| part.times(wide));
        let square = level.times(wide * wide).less_from(1.0);
        let z = square.at_least(0.0).sqrt();
        let by = z.all(1.0) / (x * x + y * y + z * z).sqrt();
        let high = (z - z.all(face)).at_least(0.0);
        [by * x, by * y, by * z - high]
    }

    /// What is seen through a drop from such a place, as a share of what bare glass would show there; the shares sum to 1.
    #[inline(always)]
    pub(super) fn seen<N: Number>(&self, mut at: [N; 3], sight: &Sight<N>) -> [N; LANES] {
        // The face cuts off what is before this.
        let face = at[2];
        let (none, one) = (face.all(0.0), face.all(1.0));
        let [x, y] = sight.along.map(|part| part.times(1.0 / WATER));
        let mut ray = [x, y, ((x * x).less_from(1.0) - y * y).sqrt()];
        let mut share = one;
        let mut lanes = [none; LANES];
        for _ in 0..MOST_BOUNCES {
            // To the sphere, or before that to the glass.
            let along = dot(at, ray);
            let square = along * along - dot(at, at) + one;
            let to_sphere = square.at_least(0.0).sqrt() - along;
            let to_glass = (face - at[2]) / ray[2];
            let nearer = to_glass.below(to_sphere, [share, none]);
            let enters = ray[2].below(none, [nearer, none]);
            if enters.is_above(0.0) {
                self.enters_cabin(&mut lanes, sight, ray, enters);
                share = share - enters;
                if !share.is_above(0.0) {
                    return lanes;
                }
            }
            at = [0, 1, 2].map(|k| at[k] + to_sphere * ray[k]);
            let cos = dot(ray, at).at_least(0.0).at_most(1.0);
            let square = (cos * cos).less_from(1.0).times(WATER * WATER);
            let square = square.less_from(1.0);
            let cos_out = square.at_least(0.0).sqrt();
            let mirrored = reflectance_at([cos, cos_out], 1.0 / WATER);
            let mirrored = none.below(square, [mirrored, one]);
            let beside = cos_out - cos.times(WATER);
            let leaves = [
                ray[0].times(WATER) + beside * at[0],
                ray[1].times(WATER) + beside * at[1],
                ray[2].times(WATER) + beside * at[2],
            ];
            self.leaves(&mut lanes, sight, leaves, share * mirrored.less_from(1.0));
            share = share * mirrored;
            let lost = share.below(share.all(LEAST_SHARE), [share, none]);
            add(&mut lanes, HELD, lost);
            share = share - lost;
            if !share.is_above(0.0) {
                return lanes;
            }
            let twice = cos.times(2.0);
            ray = [0, 1, 2].map(|k| ray[k] - twice * at[k]);
        }
        add(&mut lanes, HELD, share);
        lanes
    }

    /// Light from outside, seen along a direction in the air. Bare glass has taken its outer face's share of what an image
    /// shows, and given the cabin's light for it.
    #[inline(always)]
    fn leaves<N: Number>(
        &self,
        lanes: &mut [N; LANES],
        sight: &Sight<N>,
        direction: [N; 3],
        share: N,
    ) {
        let none = share.all(0.0);
        let ahead = none.below(direction[2], [share, none]);
        // The rest through the glass beside the drop.
        let beside = share - ahead;
        if beside.is_above(0.0) {
            self.from.cabin(lanes, direction, beside);
        }
        if ahead.is_above(0.0) {
            let seen = ahead * (sight.before.reflects + share.all(1.0)) * sight.passes;
            let direction = self.from.sheet.camera_from_sheet(direction);
            self.from.seen(lanes, direction, seen);
            sight.before.mirror_cabin(lanes, ahead - seen);
        }
    }

    /// Light that comes through the glass, seen along a direction in the water.
    #[inline(always)]
    fn enters_cabin<N: Number>(
        &self,
        lanes: &mut [N; LANES],
        sight: &Sight<N>,
        [x, y, _]: [N; 3],
        share: N,
    ) {
        let [x, y] = [x, y].map(|part| part.times(WATER));
        let (square, none) = (x * x + y * y, share.all(0.0));
        let passes = square.below(share.all(1.0), [share, none]);
        // The inner face holds the rest.
        add(lanes, HELD, share - passes);
        let z = square.less_from(1.0).at_least(0.0).sqrt();
        let face = reflectance_of(z, self.from.sheet.index);
        let again = passes * face * face.less_from(1.0);
        let outward = z.less_from(0.0);
        self.from.cabin(lanes, [x, y, outward], passes - again);
        self.leaves(lanes, sight, [x, y, z], again);
    }
}
