//! What runs beside a tip and takes from its energy, and what lies ahead of it.

use std::f64::consts::PI;

use super::law::Gaps;
use super::tracer::{Tip, TipState, Tracing};
use super::web::Web;

/// How fast a lead over a neighbor frees a tip from it, and holds the neighbor back: the stress in a
/// strip of width s fades like exp(−π d/s) from its end.
pub(crate) const COMPETITION: f64 = PI;

/// Lead over the distance that makes no difference yet.
const EQUAL_LEAD: f64 = 0.1;

/// Distances to the nearest tips on both sides, as they count for the energy that a tip gets.
///
/// Two cracks under an angle φ that are as long as each other are an arc chord·(φ/2)/sin(φ/2) apart.
/// A tip that leads takes from the one behind: its gap counts for more, the other's for less, by
/// exp(±C·lead/gap). Equal cracks side by side are therefore unstable, as arrays of cracks are
/// \[NematNasser1978\]; few go far.
pub(super) fn gaps_beside(web: &Web, tips: &[Tip], own_idx: usize, tracing: &Tracing) -> Gaps {
    let own = &tips[own_idx];
    let [tx, ty] = own.direction;
    let mut gaps = Gaps::NONE;
    for (idx, other) in tips.iter().enumerate() {
        if idx == own_idx || other.state == TipState::Forked {
            continue;
        }
        let is_sibling = own.fork_node.is_some() && own.fork_node == other.fork_node;
        let (dx, dy) = (other.at_m[0] - own.at_m[0], other.at_m[1] - own.at_m[1]);
        let chord = libm::hypot(dx, dy);
        let cos = (tx * other.direction[0] + ty * other.direction[1]).clamp(-1.0, 1.0);
        if chord <= 0.0 || cos < -0.5 {
            continue;
        }
        let half_angle = 0.5 * libm::acos(cos);
        let (sin, cos) = libm::sincos(half_angle);
        let (bx, by) = (tx + other.direction[0], ty + other.direction[1]);
        let size = libm::hypot(bx, by);
        let lag = (dx * bx + dy * by) / size;
        // Of one that is ahead the flank beside us counts.
        let apart = (dx * by - dy * bx).abs() / size - lag.max(0.0) * sin / cos;
        let arc = if sin > 1e-6 {
            apart * half_angle / sin
        } else {
            apart
        };
        // The two branches of a fork share their energy already, until they are apart.
        if arc <= 0.0 || is_sibling && arc < tracing.law.thickness_m {
            continue;
        }
        let lead = -lag / arc;
        let beyond = (lead.abs() - EQUAL_LEAD).max(0.0).copysign(lead);
        let counts = arc * libm::exp((tracing.competition * beyond).clamp(-20.0, 20.0));
        let gap = if tx * dy - ty * dx > 0.0 {
            &mut gaps.left_m
        } else {
            &mut gaps.right_m
        };
        *gap = gap.min(counts);
    }
    if tracing.rim_shields {
        // The flaw that a crack grew out of is not drawn: the tip lies deeper by its length. On a
        // round rim there is no glass beside the flaw's mouth.
        let flaw_m = (own.length_m - own.along_m).max(0.0);
        let deeper = [own.at_m[0] + tx * flaw_m, own.at_m[1] + ty * flaw_m];
        let from = if web.outline.depth_m(deeper) > 0.0 {
            deeper
        } else {
            own.at_m
        };
        for (gap, normal) in [
            (&mut gaps.left_m, [-ty, tx]),
            (&mut gaps.right_m, [ty, -tx]),
        ] {
            *gap = gap.min(2.0 * way_to_rim(web, from, normal));
        }
    }
    gaps
}

/// What the nearness of the rim ahead adds to K: √(tan φ/φ), φ = πL/2W with W = L + ligament
/// \[TadaParisIrwin2000\].
pub(super) fn finite_width(length_m: f64, ligament_m: f64) -> f64 {
    let angle = 0.5 * PI * length_m / (length_m + ligament_m.max(1e-6));
    (libm::tan(angle) / angle)
        .sqrt()
        .clamp(1.0, MAX_FINITE_WIDTH)
}

/// At this the ligament breaks in any case.
const MAX_FINITE_WIDTH: f64 = 50.0;

/// Distance to the rim along a direction, m.
pub(super) fn way_to_rim(web: &Web, from: [f64; 2], direction: [f64; 2]) -> f64 {
    let [width, height] = web.outline.size_m();
    let far = 2.0 * (width + height);
    let to = [from[0] + direction[0] * far, from[1] + direction[1] * far];
    web.outline.exit(from, to).unwrap_or(1.0) * far
}
