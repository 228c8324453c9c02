//! What surfaces show by their roughness.

use std::sync::LazyLock;

use super::lobe::{Before, LightFrom, Mirror, Sent, reflected};
use crate::interface::fresnel::refract;
use crate::interface::ggx::{VisibleNormals, g1, on_disc};
use crate::vector::{Vector, cross, dot, unit};

/// Below this α a surface is a mirror.
pub(super) const MIRROR_ALPHA: f64 = 2e-3;

/// Below this α its facets differ too little in their reflectance to ask each.
pub(super) const NARROW_ALPHA: f64 = 0.05;

/// Slopes, over α, of the facets that stand for a nearly smooth surface: quantiles of GGX, 1/8 to
/// 7/8, a quarter of a turn apart.
const NARROW_SLOPES: [[f64; 2]; 4] = [
    [0.377_964_473_009_227, 0.0],
    [0.0, 0.774_596_669_241_483],
    [-1.290_994_448_735_806, 0.0],
    [0.0, -2.645_751_311_064_591],
];

/// Directions that rough and very rough surfaces are sampled by, and those of one cell among others
/// of the same surface.
const N_SAMPLES: [usize; 2] = [40, 96];
const N_SAMPLES_OF_CELL: usize = 16;

/// The points of the unit disc by which they are sampled: of the near face, and of the far one. Any that follow each
/// other are spread evenly.
static SAMPLES: LazyLock<Vec<[[f64; 2]; 2]>> =
    LazyLock::new(|| (0..96).map(|k| points(k).map(on_disc)).collect());

/// From this α on they are very rough.
pub(super) const WIDE_ALPHA: f64 = 0.15;

/// By which of its directions a rough surface is sampled.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sampled {
    /// By all.
    Whole,
    /// By those of the k-th of three places that are looked at together.
    Third(usize),
    /// By those of one cell among others, or of the k-th of three places of such a cell.
    Cell(usize),
}

impl Sampled {
    fn of(self, alpha: f64) -> &'static [[[f64; 2]; 2]] {
        let n = N_SAMPLES[usize::from(alpha >= WIDE_ALPHA)];
        let n_third = n.div_ceil(3);
        let (first, n) = match self {
            Self::Whole => (0, n),
            Self::Third(k) => (k * n_third, n_third),
            Self::Cell(k) => (k * N_SAMPLES_OF_CELL, N_SAMPLES_OF_CELL),
        };
        &SAMPLES[first..first + n]
    }
}

/// Where light goes on to from a facet: along a direction in the sheet, or evenly to both sides.
pub(super) enum Way {
    Along(Vector),
    Evenly,
}

impl LightFrom<'_> {
    /// What a nearly smooth surface shows of a share of sight: its facets reflect as the whole does,
    /// and hide nothing from each other.
    pub(super) fn narrow(
        &self,
        sent: &mut Sent,
        (mirror, before): (&Mirror, &Before),
        (sight, normal): (Vector, Vector),
        share: f64,
    ) {
        let Frame([x, y, _]) = Frame::about(normal);
        for [p, q] in NARROW_SLOPES {
            let (p, q) = (mirror.alpha * p, mirror.alpha * q);
            let facet = unit(std::array::from_fn(|k| normal[k] + p * x[k] + q * y[k]));
            let direction = reflected(sight, facet, -dot(sight, facet));
            self.follow(sent, before, direction, 0.25 * share);
        }
    }

    /// Calls with each way on from a rough surface, and with which share of sight goes it: its
    /// facets are drawn as sight sees them \[Heitz2018\], 96 at most.
    #[inline]
    pub(super) fn each_way(
        &self,
        mirror: &Mirror,
        (sight, normal): (Vector, Vector),
        sampled: Sampled,
        mut each: impl FnMut(Way, f64),
    ) {
        let samples = sampled.of(mirror.alpha);
        #[expect(clippy::cast_precision_loss, reason = "few")]
        let share = 1.0 / samples.len() as f64;
        let frame = Frame::about(normal);
        let view = sight.map(|part| -part);
        let visible = VisibleNormals::of(frame.local(view), mirror.alpha);
        for &[near, far] in samples {
            let facet = frame.world(visible.at(near));
            let cos_h = dot(view, facet);
            let r = self.gaps.mean(cos_h.abs(), mirror.gap_um);
            let direction = reflected(sight, facet, cos_h);
            let cos_o = dot(direction, normal);
            let seen = if cos_o > 0.0 {
                g1(cos_o, mirror.alpha)
            } else {
                0.0
            };
            each(Way::Along(direction), share * r * seen);
            each(Way::Evenly, share * r * (1.0 - seen));
            if r >= 1.0 {
                continue;
            }
            let passes = share * (1.0 - r);
            let across = Across {
                sight,
                facet,
                frame: &frame,
            };
            match across.refracted(mirror.alpha, self.sheet.index, far) {
                Some((onward, seen)) => {
                    each(Way::Along(onward), passes * seen);
                    each(Way::Evenly, passes * (1.0 - seen));
                }
                None => each(Way::Evenly, passes),
            }
        }
    }
}

/// The k-th of evenly spread points in the unit square, twice: the two-dimensional golden ratio
/// \[Roberts2018\], and Halton's points of bases 2 and 3 \[Halton1960\].
fn points(k: u32) -> [[f64; 2]; 2] {
    let at = f64::from(k) + 0.5;
    [
        [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (at * step).fract()),
        [2, 3].map(|base| radical_inverse(k + 1, base)),
    ]
}

/// The digits of a number in a base, behind the point in the opposite order.
fn radical_inverse(mut k: u32, base: u32) -> f64 {
    let (mut inverse, mut digit) = (0.0, 1.0);
    while k > 0 {
        digit /= f64::from(base);
        inverse += digit * f64::from(k % base);
        k /= base;
    }
    inverse
}

/// Light that crosses the gap of a rough crack, by one facet of either face.
struct Across<'a> {
    /// Direction of sight in the glass, and the facet that it meets.
    sight: Vector,
    facet: Vector,
    /// About the crack's normal on the side of sight.
    frame: &'a Frame,
}

impl Across<'_> {
    /// The direction beyond the gap, by a facet drawn from those of the far face that the gap
    /// sees, and how much of it is hidden by others on neither face.
    fn refracted(&self, alpha: f64, n: f64, disc: [f64; 2]) -> Option<(Vector, f64)> {
        let in_air = refract(self.sight, self.facet, n)?;
        let local = self.frame.local(in_air.map(|part| -part));
        if local[2] <= 0.0 {
            return None;
        }
        let far = self.frame.world(VisibleNormals::of(local, alpha).at(disc));
        let onward = refract(in_air, far, 1.0 / n)?;
        let cos = -self.frame.local(onward)[2];
        (cos > 0.0).then(|| (onward, g1(local[2], alpha) * g1(cos, alpha)))
    }
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
