//! Cracks as facets of the frame.

use starbreak_glass::CrackNetwork;

use super::SheetView;
use super::lines::{CrackSurface, lines};
use super::lobe::{FRAME, FRAME_U, FRAME_V, LANES, LightFrom, Mirror, N_SHARES, Sent};
use crate::interface::fresnel::reflectance;
use crate::maps::Facet;
use crate::physical::SurfaceParams;
use crate::vector::{cross, unit};

/// Longest piece of a line, px, that one facet stands for.
const LONGEST_PX: f64 = 48.0;

/// Most pieces of one line.
const MOST_PIECES: f64 = 4096.0;

/// A cone begins on the face at this part of its lower radius at least.
const LEAST_CONE: f64 = 0.15;

/// Colors weaker than this are none.
const LEAST_TINT: f64 = 0.004;

/// Facets of a crack network, and of what tints them.
#[derive(Debug, Default)]
pub(crate) struct Facets {
    pub(crate) light: Vec<Facet<LANES>>,
    /// Share, and by how much more than the mean each color is reflected.
    pub(crate) tint: Vec<Facet<4>>,
    /// Where surfaces themselves lie in the frame, without their ghosts.
    pub(crate) outlines: Vec<[[f64; 2]; 4]>,
}

/// The facets of all cracks of a network as far as they have grown, within `reach_px` of the
/// frame.
pub(crate) fn crack_facets(
    from: &LightFrom<'_>,
    network: &CrackNetwork,
    time: f64,
    surface: &SurfaceParams,
    reach_px: f64,
    facets: &mut Facets,
) {
    for line in lines(from.sheet, network, time, surface) {
        let [a, b] = line.ends;
        let Some([u0, v0, u1, v1]) = from
            .sheet
            .view()
            .visible([a[0], a[1], b[0], b[1]], reach_px)
        else {
            continue;
        };
        let (Some(a), Some(b)) = (
            from.sheet.view().unproject([u0, v0]),
            from.sheet.view().unproject([u1, v1]),
        ) else {
            continue;
        };
        let length_px = ((u1 - u0) * (u1 - u0) + (v1 - v0) * (v1 - v0)).sqrt();
        let n = (length_px / LONGEST_PX).ceil().clamp(1.0, MOST_PIECES);
        let mut k = 0.0;
        while k < n {
            let at = |t: f64| std::array::from_fn(|axis| a[axis] + (b[axis] - a[axis]) * t / n);
            add_piece(from, at(k), at(k + 1.0), &line.surface, facets);
            k += 1.0;
        }
    }
}

/// The facet of a straight piece of crack from `a` to `b`, mm on the sheet.
fn add_piece(
    from: &LightFrom<'_>,
    a: [f64; 2],
    b: [f64; 2],
    surface: &CrackSurface,
    facets: &mut Facets,
) -> Option<()> {
    let sheet = from.sheet;
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
    if length <= 0.0 {
        return None;
    }
    let along = along.map(|part| part / length);
    // From the outer face, which was hit, to the crack's depth.
    let outer = sheet.thickness_mm;
    let inner = outer * (1.0 - surface.depth_fraction);
    let lean = (outer - inner) * surface.lean.abs();
    let ends = match surface.cone_about {
        // The trace of a cone is its lower edge; it comes from a smaller circle on the face.
        Some(middle) => {
            let raised = |p: [f64; 2]| {
                let (x, y) = (p[0] - middle[0], p[1] - middle[1]);
                let radius = (x * x + y * y).sqrt();
                let part = (1.0 - lean / radius.max(1e-9)).max(LEAST_CONE);
                [middle[0] + part * x, middle[1] + part * y]
            };
            [raised(a), raised(b), b, a]
        }
        // That of any other crack is on the face that was hit. With y down the left of a walk
        // along +x is −y.
        None => {
            let lean = lean.copysign(surface.lean);
            let leaned = |p: [f64; 2]| [p[0] + lean * along[1], p[1] - lean * along[0]];
            [a, b, leaned(b), leaned(a)]
        }
    };
    let strip = Strip::new(sheet, ends, [outer, inner])?;
    let between = |p: [f64; 2], q: [f64; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    let (upper, lower) = (between(ends[0], ends[1]), between(ends[2], ends[3]));
    let entry = sheet.entry(between(upper, lower), 0.5 * (outer + inner), [0.0; 2])?;
    let sight = sheet.sight(entry, [0.0; 2])?;
    // Into the glass from the outer face, leaning.
    let down = [lower[0] - upper[0], lower[1] - upper[1], inner - outer];
    let mirror = Mirror {
        sight,
        normal: unit(cross([along[0], along[1], 0.0], down)),
        alpha: surface.alpha,
        gap_um: surface.gap_um,
    };
    let sent = from.mirror(&mirror);
    facets.outlines.push(strip.corners);
    strip.add(facets, &sent);
    add_tint(facets, strip.corners, strip.radius_px, sent.tint, 1.0);
    // Once more beyond the trace, by light that the outer face reflects onto the crack's back.
    let mut ghost = from.ghost(&mirror);
    if ghost.lanes.iter().any(|lane| lane.abs() > LEAST_GHOST)
        && let Some(behind) = Strip::new(sheet, ends, [outer, 2.0 * outer - inner])
    {
        // Where a crack leans over its own ghost, only what it lets through is seen of that.
        let hidden = (strip.width_px / behind.width_px).clamp(0.0, 1.0);
        let passes = 1.0 - hidden * sent.lanes[..N_SHARES].iter().sum::<f64>();
        ghost.lanes = ghost.lanes.map(|lane| passes * lane);
        behind.add(facets, &ghost);
    }
    // And by light that both faces reflect, which is much in a steep sheet only.
    let twice = reflectance(sight[2], sheet.index) * reflectance(sight[2], sheet.index);
    if twice > LEAST_TWICE
        && let Some(beyond) = Strip::new(sheet, ends, [3.0 * outer, 2.0 * outer + inner])
    {
        let lanes = sent.lanes.map(|lane| twice * lane);
        beyond.add(facets, &Sent { lanes, ..sent });
    }
    Some(())
}

/// Lanes of a ghost that are weaker are none.
const LEAST_GHOST: f64 = 2e-3;

/// Light that both faces reflect is none below this share.
const LEAST_TWICE: f64 = 0.02;

/// Where one face of a straight piece of crack appears in the frame.
struct Strip {
    corners: [[f64; 2]; 4],
    /// Across the outer trace, of length 1.
    normal_px: [f64; 2],
    /// From the outer trace along that normal, from the middle of the pupil.
    width_px: f64,
    radius_px: f64,
}

impl Strip {
    /// The strip between a trace (the first two `ends`) and the crack's edge (the other two), mm
    /// on the sheet, at their depths, mm.
    fn new(sheet: &SheetView, ends: [[f64; 2]; 4], depths: [f64; 2]) -> Option<Self> {
        let [outer, inner] = depths;
        let chief = [0.0, 0.0];
        let mut corners = [
            sheet.project(ends[0], outer, chief)?,
            sheet.project(ends[1], outer, chief)?,
            sheet.project(ends[2], inner, chief)?,
            sheet.project(ends[3], inner, chief)?,
        ];
        let [du, dv] = [corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]];
        let length_px = (du * du + dv * dv).sqrt();
        if length_px <= 1e-9 {
            return None;
        }
        let normal_px = [-dv / length_px, du / length_px];
        let between = |p: [f64; 2], q: [f64; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let (trace, edge) = (between(ends[0], ends[1]), between(ends[2], ends[3]));

        // Both from two opposite points of the pupil across the crack.
        let across = |point: [f64; 2], depth: f64, side: f64| {
            let pupil = normal_px.map(|part| side * part * sheet.pupil_mm());
            let [u, v] = sheet.project(point, depth, pupil)?;
            Some(u * normal_px[0] + v * normal_px[1])
        };
        let (outer_plus, outer_minus) = (across(trace, outer, 1.0)?, across(trace, outer, -1.0)?);
        let (inner_plus, inner_minus) = (across(edge, inner, 1.0)?, across(edge, inner, -1.0)?);
        let outer_radius = 0.5 * (outer_minus - outer_plus);
        let inner_radius = 0.5 * (inner_minus - inner_plus);
        let width = 0.5 * (inner_plus + inner_minus - outer_plus - outer_minus);
        let spread = inner_radius - outer_radius;
        let seen = mean_width(width, spread);
        if width.abs() < spread.abs() {
            // Parts of the pupil see the one face of the crack, others the other.
            for k in 0..2 {
                let mid = between(corners[k], corners[3 - k]);
                for (corner, side) in [(k, -0.5), (3 - k, 0.5)] {
                    corners[corner] = [
                        mid[0] + side * seen * normal_px[0],
                        mid[1] + side * seen * normal_px[1],
                    ];
                }
            }
        }
        Some(Self {
            corners,
            normal_px,
            width_px: width,
            radius_px: 0.5 * (outer_radius + inner_radius),
        })
    }

    fn add(&self, facets: &mut Facets, sent: &Sent) {
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let lanes = sent.lanes.map(|lane| lane as f32);
        // A mirrored place moves along with the crack and against it across.
        let [nx, ny] = self.normal_px;
        let share = sent.lanes[FRAME];
        #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
        let lean = [
            [1.0 - 2.0 * nx * nx, -2.0 * nx * ny],
            [-2.0 * nx * ny, 1.0 - 2.0 * ny * ny],
        ]
        .map(|row: [f64; 2]| row.map(|part| (share * part) as f32));
        debug_assert_eq!(
            (FRAME_U, FRAME_V),
            (LANES - 2, LANES - 1),
            "the lanes that lean"
        );
        facets.light.push(Facet {
            corners: self.corners,
            lanes,
            lean,
            radius_px: self.radius_px,
        });
    }
}

/// Adds a tint where there is one.
pub(super) fn add_tint(
    facets: &mut Facets,
    corners: [[f64; 2]; 4],
    radius_px: f64,
    tint: [f64; 3],
    share: f64,
) {
    if tint.iter().all(|part| part.abs() < LEAST_TINT) {
        return;
    }
    #[expect(clippy::cast_possible_truncation, reason = "shares as f32")]
    let lanes = [share, share * tint[0], share * tint[1], share * tint[2]].map(|lane| lane as f32);
    facets.tint.push(Facet {
        corners,
        lanes,
        lean: [[0.0; 2]; 2],
        radius_px,
    });
}

/// Mean over a round pupil of |w + s a|, a across the pupil from −1 to 1: the width at which a
/// crack is seen whose width is `width` from the middle of the pupil and changes by `spread`
/// towards its rim.
///
/// With u = w/s: |w| (2 F(u) − 1) + s 4/(3π) (1 − u²)^{3/2}, F the share of the disc below u.
fn mean_width(width: f64, spread: f64) -> f64 {
    let (width, spread) = (width.abs(), spread.abs());
    if width >= spread {
        return width;
    }
    let u = width / spread;
    let root = (1.0 - u * u).sqrt();
    let below = 0.5 + (u * root + libm::asin(u)) / std::f64::consts::PI;
    width * (2.0 * below - 1.0) + spread * 4.0 / (3.0 * std::f64::consts::PI) * root * root * root
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_width_is_the_integral_over_the_pupil() {
        for (width, spread) in [
            (0.0, 1.0),
            (0.3, 1.0),
            (-0.7, 1.0),
            (0.99, -1.0),
            (2.0, 1.0),
        ] {
            let n = 20_000;
            let (mut sum, mut weight) = (0.0, 0.0);
            for k in 0..n {
                let a = (f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0;
                let chord = (1.0 - a * a).sqrt();
                sum += chord * (width + spread * a).abs();
                weight += chord;
            }
            let expected = sum / weight;
            let found = mean_width(width, spread);
            assert!(
                (found - expected).abs() < 1e-4,
                "{width}, {spread}: {found}, not {expected}"
            );
        }
    }
}
