//! Where a drop is seen.

use std::f64::consts::FRAC_1_SQRT_2;

use starbreak_deposit::Cap;

use super::SheetView;
use super::drops::{Drop, LEAST_DROP_PX};
use crate::maps::cells_per_px;
use crate::number::Number;
use crate::vector::Vector;

/// Directions around a drop by which its outline is known.
const AROUND: [[f64; 2]; 16] = {
    let [a, b, c] = [
        0.923_879_532_511_286_7,
        FRAC_1_SQRT_2,
        0.382_683_432_365_089_8,
    ];
    let quarter = [[1.0, 0.0], [a, c], [b, b], [c, a]];
    let mut around = [[0.0; 2]; 16];
    let mut k = 0;
    while k < 4 {
        let [x, y] = quarter[k];
        around[k] = [x, y];
        around[k + 4] = [-y, x];
        around[k + 8] = [-x, -y];
        around[k + 12] = [y, -x];
        k += 1;
    }
    around
};

/// Where a drop is seen, about its middle.
pub(super) struct SeenAt {
    /// Where the ray of sight to its middle enters the pane.
    pub(super) enters_mm: [f64; 2],
    pub(super) at_px: [f64; 2],
    /// Signed radius of its blur, and how many cells are drawn to a px.
    pub(super) blur_px: f64,
    pub(super) cells_per_px: f64,
    /// Direction of sight before the glass.
    pub(super) sight: Vector,
    /// Change of the place on the outer face, of the drop's radius, and of the direction, per px along x and along y.
    pub(super) places_per_px: [[f64; 2]; 2],
    pub(super) turns_per_px: [[f64; 2]; 2],
}

impl SeenAt {
    /// None of one that is farther from the frame than so many px and some of its own radii, or too small to be seen.
    pub(super) fn of(cap: &Cap, sheet: &SheetView, reach_px: f64) -> Option<Self> {
        let [[px_per_mm, _], _] = sheet.view().jacobian(cap.at_mm)?;
        let radius_px = px_per_mm * cap.radius_mm;
        if radius_px < LEAST_DROP_PX {
            return None;
        }
        let enters_mm = sheet.entry(cap.at_mm, sheet.outer_mm(), [0.0; 2])?;
        let at_px = sheet.appears(enters_mm, [0.0; 2])?;
        let (width, height) = sheet.view().size();
        let far_px = reach_px + 4.0 * radius_px;
        let is_far = |px: f64, side: u32| !(-far_px..f64::from(side) + far_px).contains(&px);
        if is_far(at_px[0], width) || is_far(at_px[1], height) {
            return None;
        }
        let behind = |right_px: f64, down_px: f64| {
            let px = [at_px[0] + right_px, at_px[1] + down_px];
            sheet.behind(px, sheet.outer_mm())
        };
        let (mut places_per_px, mut turns_per_px) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
        for (axis, [right, down]) in [[0.5, 0.0], [0.0, 0.5]].into_iter().enumerate() {
            let [from, to] = [behind(-right, -down)?, behind(right, down)?];
            for k in 0..2 {
                places_per_px[axis][k] = (to.0[k] - from.0[k]) / cap.radius_mm;
                turns_per_px[axis][k] = to.1[k] - from.1[k];
            }
        }
        let blur_px = sheet.blur_radius_px(cap.at_mm, sheet.outer_mm())?;
        Some(Self {
            enters_mm,
            at_px,
            blur_px,
            cells_per_px: cells_per_px(blur_px),
            sight: behind(0.0, 0.0)?.1,
            places_per_px,
            turns_per_px,
        })
    }
}

/// What a drop reaches to.
pub(super) struct Extent {
    /// How far from its middle, of its radius, by the change of the place about its middle alone.
    pub(super) reach: f64,
    /// The same in px, and from where to where across and down.
    pub(super) widest_px: f64,
    pub(super) spans_px: [[f64; 2]; 2],
}

impl Extent {
    /// Of so many times its radius.
    pub(super) fn of(drop: &Drop<'_>, seen: &SeenAt, times: f64) -> Self {
        let mut extent = Self {
            reach: 0.0,
            widest_px: 0.0,
            spans_px: [[f64::INFINITY, f64::NEG_INFINITY]; 2],
        };
        let radius_mm = times * drop.cap.radius_mm;
        for [cos, sin] in AROUND {
            let [x, y] = drop.cap.at_mm;
            let Some(at) = drop.appears([x + radius_mm * cos, y + radius_mm * sin]) else {
                // Some of it lies beside the camera: it may be everywhere.
                return Self {
                    reach: f64::INFINITY,
                    widest_px: f64::INFINITY,
                    spans_px: [[f64::NEG_INFINITY, f64::INFINITY]; 2],
                };
            };
            let px = [0, 1].map(|k| at[k] - seen.at_px[k]);
            let place = straight(&seen.places_per_px, px);
            let [away, px] = [place, px].map(|[x, y]| x * x + y * y);
            extent.reach = extent.reach.max(away);
            extent.widest_px = extent.widest_px.max(px);
            for (span, at) in extent.spans_px.iter_mut().zip(at) {
                *span = [span[0].min(at), span[1].max(at)];
            }
        }
        extent.reach = extent.reach.sqrt();
        extent.widest_px = extent.widest_px.sqrt();
        extent
    }
}

/// What is some steps away, by the change per step along x and along y.
#[inline(always)]
pub(super) fn straight<N: Number>([[a, b], [c, d]]: &[[f64; 2]; 2], [x, y]: [N; 2]) -> [N; 2] {
    // A call of `map` may keep what is in it from being inlined, here and elsewhere among rays.
    [x.times(*a) + y.times(*c), x.times(*b) + y.times(*d)]
}

/// Steps to the rim of a drop along its shorter side, by the change of the place, of its radius, per step.
pub(super) fn least_radius([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    // The inverse of the larger singular value.
    let (sum, determinant) = (a * a + b * b + c * c + d * d, a * d - b * c);
    let root = (sum * sum - 4.0 * determinant * determinant)
        .max(0.0)
        .sqrt();
    1.0 / (0.5 * (sum + root)).sqrt()
}
