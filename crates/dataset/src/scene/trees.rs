//! Trees and hedges.
//!
//! What comes out is foliage as three layers of seeded tufts: dark inside and
//! away from the sun, middle green, and bright leaves toward the sun.

use std::f32::consts::TAU;

use rand_chacha::ChaCha8Rng;

use super::camera::{Board, pixels_per_metre, point3};
use super::paint::{Ink, Painter, Tint, rgb};
use super::random::between;
use super::shape::Shape;

/// One tree.
pub(super) struct Tree {
    pub(super) board: Board,
    /// Height of the lowest leaves.
    pub(super) trunk_m: f32,
    pub(super) crown_radius_m: f32,
    pub(super) leaf: Tint,
}

impl Tree {
    /// Darkens the ground where the crown's shadow falls.
    pub(super) fn paint_shadow(&self, painter: &mut Painter) {
        painter.set_distance(self.board.foot.ahead_m);
        let radius_m = self.crown_radius_m;
        for (share, opacity) in [(1.0, 0.18), (0.8, 0.2)] {
            let crown = Shape::ellipse(
                [0.0, self.trunk_m + radius_m],
                radius_m * share,
                radius_m * share,
            );
            painter.shadow(&crown, opacity, &|point| self.board.at(point));
        }
        let trunk = Shape::rect(-0.15, 0.0, 0.15, self.trunk_m + 0.3);
        painter.shadow(&trunk, 0.35, &|point| self.board.at(point));
    }

    /// Draws the tree.
    pub(super) fn paint(&self, painter: &mut Painter, rng: &mut ChaCha8Rng) {
        painter.set_distance(self.board.foot.ahead_m);
        let radius_m = self.crown_radius_m;
        let top_m = self.trunk_m + radius_m;
        let bark = Ink::Across(rgb(0x008A_6E54), rgb(0x0046_362C));
        let trunk = Shape::smooth(&[
            [-0.24, 0.0],
            [-0.13, 0.5],
            [-0.12, self.trunk_m],
            [-0.3, top_m],
            [0.3, top_m],
            [0.12, self.trunk_m],
            [0.14, 0.5],
            [0.24, 0.0],
        ]);
        painter.fill_board(&trunk, bark, &self.board);
        // Leaves of a pixel or two need not be drawn one by one.
        let thinning = if pixels_per_metre(self.board.foot.ahead_m) * radius_m < 45.0 {
            2
        } else {
            1
        };
        // Big dark tufts hold the crown together; over them, clumps from the
        // shaded lower right to the sunlit upper left.
        for _ in 0..14 {
            let angle_rad = between(rng, 0.0, TAU);
            let out = between(rng, 0.2, 0.62);
            let center = [
                out * libm::cosf(angle_rad) * radius_m,
                top_m + out * libm::sinf(angle_rad) * 0.9 * radius_m,
            ];
            self.paint_tuft(painter, rng, center, 0.36 * radius_m, -0.46);
        }
        for [across, up, size, light] in [
            [0.50, -0.38, 0.40, -0.30],
            [-0.08, -0.52, 0.38, -0.26],
            [-0.58, -0.30, 0.38, -0.12],
            [0.66, 0.10, 0.38, -0.18],
            [0.10, -0.05, 0.46, -0.06],
            [0.40, 0.52, 0.42, -0.04],
            [-0.66, 0.18, 0.40, 0.06],
            [-0.05, 0.66, 0.40, 0.10],
            [-0.34, 0.32, 0.44, 0.16],
        ] {
            let wobble = [between(rng, -0.12, 0.12), between(rng, -0.10, 0.10)];
            let middle = [
                (across + wobble[0]) * radius_m,
                top_m + (up + wobble[1]) * radius_m,
            ];
            for (count, share, spread, lift, extra) in [
                (4_u8, 0.55, 0.5, -0.05, -0.12),
                (7, 0.34, 0.75, 0.10, 0.05),
                (8, 0.20, 0.72, 0.28, 0.20),
            ] {
                for _ in 0..count.div_ceil(thinning) {
                    let angle_rad = between(rng, 0.0, TAU);
                    let out = between(rng, 0.0, 1.0).sqrt() * spread * size * radius_m;
                    let center = [
                        middle[0] + out * libm::cosf(angle_rad) - lift * size * radius_m,
                        middle[1] + out * libm::sinf(angle_rad) * 0.8 + lift * size * radius_m,
                    ];
                    let light = light + extra + between(rng, -0.05, 0.05);
                    self.paint_tuft(painter, rng, center, share * size * radius_m, light);
                }
            }
        }
    }

    fn paint_tuft(
        &self,
        painter: &mut Painter,
        rng: &mut ChaCha8Rng,
        center: [f32; 2],
        radius_m: f32,
        light: f32,
    ) {
        let size_m = radius_m * between(rng, 0.8, 1.25);
        // Sunlit leaves turn yellow, shaded ones blue.
        let tint = if light > 0.0 {
            self.leaf.mix(rgb(0x00DC_E878), light * 1.3)
        } else {
            self.leaf.lit(light)
        };
        painter.fill_board(&tuft(rng, center, size_m), Ink::Flat(tint), &self.board);
    }
}

/// A leafy blob with an uneven edge.
fn tuft(rng: &mut ChaCha8Rng, center: [f32; 2], radius: f32) -> Shape {
    let points: Vec<[f32; 2]> = (0..7_u8)
        .map(|corner| {
            let angle_rad = TAU * f32::from(corner) / 7.0;
            let reach = radius * between(rng, 0.75, 1.2);
            [
                center[0] + reach * libm::cosf(angle_rad),
                center[1] + reach * libm::sinf(angle_rad),
            ]
        })
        .collect();
    Shape::smooth(&points)
}

/// Draws a clipped hedge along the street.
pub(super) fn paint_hedge(
    painter: &mut Painter,
    rng: &mut ChaCha8Rng,
    right_m: f32,
    ahead_m: [f32; 2],
    height_m: f32,
) {
    painter.set_distance(ahead_m[0]);
    let leaf = rgb(0x0056_8A3A);
    let face = Shape::rect(ahead_m[0], 0.0, ahead_m[1], height_m);
    painter.fill(&face, Ink::Down(leaf.lit(-0.1), leaf.lit(-0.5)), &|[
        z,
        up,
    ]| {
        point3(right_m, up, z)
    });
    let mut from_far_m = ahead_m[1];
    while from_far_m > ahead_m[0] {
        for layer in 0..6_u8 {
            let up_m = height_m * (0.16 + 0.16 * f32::from(layer));
            let light = -0.45 + 0.13 * f32::from(layer) + between(rng, -0.08, 0.08);
            let center = [
                from_far_m + between(rng, -0.2, 0.2),
                up_m + between(rng, -0.06, 0.06),
            ];
            let tuft = tuft(rng, center, height_m * 0.17);
            painter.fill(&tuft, Ink::Flat(leaf.lit(light)), &|[z, up]| {
                point3(right_m, up, z)
            });
        }
        from_far_m -= 0.33;
    }
}
