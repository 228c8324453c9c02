//! The Hertzian cone where it shows in the plane of the pane.

use std::f64::consts::PI;

use starbreak_glass::SegmentKind;
use starbreak_seed::{Stream, normal, uniform};

use super::impact::{Breaking, Hit};
use crate::contact::ConeOutcome;
use crate::tips::{Piece, TERMINAL_SPEED_M_S, unit};

/// A cone leans by 68° from the normal of the pane: 22° to its surface \[FrankLawn1967\].
const CONE_TILT_RAD: f64 = 68.0 * PI / 180.0;

/// Standard deviation of the waves of a cone's radius around it, over their order and the radius. FIT: in photographs
/// bullseyes are round to a tenth.
const UNROUND: f64 = 0.09;

/// How far a cone's base is from under the contact where the stone comes in at 45°, over its radius, on the way of the
/// stone. FIT: pits lie off the middle of bullseyes, some by a third.
const OBLIQUE: f64 = 0.3;

/// How much wider than on average the gap of a cone is where it is widest: what came loose also turned. Above 1 it is
/// shut on the other side. FIT: photographs of bullseyes show a part of their rim.
const TURNED: [f64; 2] = [0.8, 2.2];

impl Breaking<'_> {
    /// The Hertzian cone where it shows: as a circle or an arc on the far face.
    pub(super) fn cone(&mut self, hit: &Hit<'_>) {
        let h = self.pane.thickness_m;
        let ring = (hit.cone.ring_radius_m, 0.05 * h);
        let circles = match hit.cone.outcome {
            ConeOutcome::None => return,
            ConeOutcome::Ring => vec![ring],
            ConeOutcome::Partial {
                depth_m,
                base_radius_m,
            } => vec![ring, (base_radius_m, depth_m)],
            ConeOutcome::Through {
                bottom_radius_m, ..
            } => vec![ring, (bottom_radius_m, h)],
        };
        for circle in circles {
            self.circle(hit, circle);
        }
    }

    /// A circle or an arc of a cone's trace, of a radius and a depth, m.
    pub(super) fn circle(&mut self, hit: &Hit<'_>, (radius_m, depth_m): (f64, f64)) {
        let h = self.pane.thickness_m;
        let mut rng = self.seed.stream(Stream::StoneFlaws, (2 << 32) | hit.k);
        let oblique = OBLIQUE * libm::tan(hit.stone.obliquity_rad.min(PI / 4.0));
        // Low harmonics of the radius; the first moves the whole.
        let harmonics: Vec<[f64; 3]> = (2_u8..6)
            .map(|n| {
                let n = f64::from(n);
                [
                    n,
                    UNROUND / n * normal(&mut rng),
                    2.0 * PI * uniform(&mut rng),
                ]
            })
            .chain([[1.0, oblique, -hit.stone.azimuth_rad]])
            .collect();
        let turned = TURNED[0] + (TURNED[1] - TURNED[0]) * uniform(&mut rng);
        let widest_rad = 2.0 * PI * uniform(&mut rng);
        let n_steps = 96_u32;
        let arc = hit.cone.arc_rad;
        let is_closed = arc > 2.0 * PI - 1e-9;
        let center = hit.stone.position_m;
        let angle_at =
            |k: u32| hit.cone.arc_center_rad + arc * (f64::from(k) / f64::from(n_steps) - 0.5);
        let radius_at = |k: u32| {
            let wave = |[n, size, phase]: &[f64; 3]| size * libm::cos(n * angle_at(k) + phase);
            radius_m * (1.0 + harmonics.iter().map(wave).sum::<f64>())
        };
        let opens = |k: u32| {
            let cos = libm::cos(angle_at(k) - widest_rad);
            ((1.0 + turned * cos) / (1.0 + turned)).max(0.0)
        };
        // The wall comes from a round contact, whatever its trace is.
        let top_m = radius_m - depth_m * libm::tan(CONE_TILT_RAD);
        let lean_rad = |k: u32| libm::atan2(radius_at(k) - top_m, depth_m);
        let place = |k: u32| {
            let [cos, sin] = unit(angle_at(k));
            let radius = radius_at(k);
            [center[0] + radius * cos, center[1] + radius * sin]
        };
        // It opens as the force peaks, over its depth at the speed of a running crack.
        let time_s = hit.start_s + hit.peak_s;
        let end_s = time_s + radius_m / TERMINAL_SPEED_M_S;
        let crack = self.web.new_crack(None);
        let intensity = 1.2 * hit.law.toughness_pa_sqrt_m;
        let mut nodes: Vec<Option<u32>> = Vec::new();
        for k in 0..=n_steps {
            let node = if is_closed && k == n_steps {
                nodes[0]
            } else {
                let point = place(k);
                (self.pane.outline.depth_m(point) > 0.0).then(|| self.web.add_node(point))
            };
            nodes.push(node);
        }
        for (k, pair) in (0..).zip(nodes.windows(2)) {
            let (Some(a), Some(b)) = (pair[0], pair[1]) else {
                continue;
            };
            self.web.add_piece(Piece {
                a,
                b,
                crack,
                kind: SegmentKind::Cone,
                time_s: [time_s, end_s],
                along_m: [0.0, depth_m],
                stress_pa: hit.law.toughness_pa_sqrt_m / (PI * h).sqrt(),
                intensity_pa_sqrt_m: intensity,
                effective_m: h * opens(k),
                tilt_rad: [lean_rad(k), lean_rad(k + 1)],
            });
        }
    }
}
