//! People who walk toward the camera.
//!
//! What comes out is the front view of a figure; the side view and what both
//! share are in `people`.

use super::paint::{Ink, Painter, rgb};
use super::people::{Person, rounded};
use super::shape::Shape;

impl Person {
    /// Draws the person from the front.
    pub(super) fn paint_front(&self, painter: &mut Painter) {
        let clothes = self.clothes;
        let trousers = if clothes.dress {
            clothes.skin
        } else {
            clothes.legs
        };
        for (side, lift_m, shade) in [(1.0, 0.07, -0.22), (-1.0, 0.0, 0.05)] {
            let (hip, knee, ankle) = (
                [side * 0.085, 0.90],
                [side * 0.10, 0.49 + lift_m * 0.4],
                [side * 0.095, 0.10 + lift_m],
            );
            self.fill(
                painter,
                &Shape::limb(
                    [ankle[0], 0.045 + lift_m],
                    [ankle[0] + side * 0.025, 0.035 + lift_m * 0.6],
                    0.05,
                    0.05,
                ),
                rounded(clothes.shoes, shade),
            );
            self.fill(
                painter,
                &Shape::limb(knee, ankle, 0.07, 0.05),
                rounded(trousers, shade),
            );
            self.fill(
                painter,
                &Shape::limb(hip, knee, 0.098, 0.07),
                rounded(trousers, shade),
            );
        }
        if clothes.dress {
            let hair = Shape::smooth(&[
                [0.0, 1.76],
                [0.11, 1.70],
                [0.135, 1.55],
                [0.13, 1.38],
                [0.0, 1.36],
                [-0.13, 1.38],
                [-0.135, 1.55],
                [-0.11, 1.70],
            ]);
            self.fill(
                painter,
                &hair,
                Ink::Down(clothes.hair.lit(0.2), clothes.hair.lit(-0.2)),
            );
        }
        for (side, shade) in [(1.0, -0.25), (-1.0, 0.08)] {
            let (shoulder, elbow, wrist) = (
                [side * 0.185, 1.38],
                [side * 0.255, 1.12],
                [side * 0.25, 0.88],
            );
            self.fill(
                painter,
                &Shape::limb(wrist, [wrist[0], 0.82], 0.038, 0.036),
                rounded(clothes.skin, shade),
            );
            self.fill(
                painter,
                &Shape::limb(elbow, wrist, 0.05, 0.04),
                rounded(clothes.top, shade),
            );
            self.fill(
                painter,
                &Shape::limb(shoulder, elbow, 0.066, 0.05),
                rounded(clothes.top, shade),
            );
        }
        self.fill(
            painter,
            &Shape::limb([0.0, 1.43], [0.0, 1.55], 0.052, 0.05),
            Ink::Flat(clothes.skin.lit(-0.22)),
        );
        let torso = if clothes.dress {
            Shape::smooth(&[
                [-0.07, 1.475],
                [0.07, 1.475],
                [0.19, 1.42],
                [0.175, 1.25],
                [0.14, 1.08],
                [0.20, 0.85],
                [0.27, 0.52],
                [0.0, 0.49],
                [-0.27, 0.52],
                [-0.20, 0.85],
                [-0.14, 1.08],
                [-0.175, 1.25],
                [-0.19, 1.42],
            ])
        } else {
            Shape::smooth(&[
                [-0.07, 1.48],
                [0.07, 1.48],
                [0.20, 1.43],
                [0.205, 1.25],
                [0.18, 1.02],
                [0.185, 0.84],
                [0.0, 0.82],
                [-0.185, 0.84],
                [-0.18, 1.02],
                [-0.205, 1.25],
                [-0.20, 1.43],
            ])
        };
        self.fill(painter, &torso, self.cloth(clothes.top));
        if clothes.dress {
            self.fill(
                painter,
                &Shape::soft(&[
                    [-0.145, 1.10, 0.01],
                    [0.145, 1.10, 0.01],
                    [0.142, 1.06, 0.01],
                    [-0.142, 1.06, 0.01],
                ]),
                Ink::Flat(clothes.bag.lit(-0.2)),
            );
        } else {
            // Open jacket over a light shirt.
            self.fill(
                painter,
                &Shape::polygon(&[[-0.055, 1.47], [0.055, 1.47], [0.035, 0.86], [-0.03, 0.86]]),
                Ink::Flat(rgb(0x00EE_EDE6)),
            );
        }
        self.fill(
            painter,
            &Shape::line(&[[-0.13, 1.46], [0.22, 0.92]], 0.03),
            Ink::Flat(clothes.bag.lit(-0.25)),
        );
        self.fill(
            painter,
            &Shape::round_rect(0.15, 0.72, 0.35, 0.95, 0.05),
            Ink::Slant(clothes.bag.lit(0.1), clothes.bag.lit(-0.3)),
        );
        let head = Shape::smooth(&[
            [0.0, 1.75],
            [0.075, 1.72],
            [0.09, 1.64],
            [0.065, 1.55],
            [0.0, 1.515],
            [-0.065, 1.55],
            [-0.09, 1.64],
            [-0.075, 1.72],
        ]);
        self.fill(painter, &head, self.cloth(clothes.skin));
        let fringe = Shape::smooth(&[
            [-0.095, 1.63],
            [-0.10, 1.71],
            [-0.04, 1.765],
            [0.04, 1.765],
            [0.10, 1.71],
            [0.095, 1.63],
            [0.07, 1.69],
            [-0.02, 1.70],
            [-0.075, 1.68],
        ]);
        self.fill(
            painter,
            &fringe,
            Ink::Down(clothes.hair.lit(0.18), clothes.hair),
        );
        for side in [-1.0, 1.0] {
            self.fill(
                painter,
                &Shape::disc([side * 0.035, 1.642], 0.010),
                Ink::Flat(rgb(0x0022_1C1A)),
            );
        }
        self.fill(
            painter,
            &Shape::line(&[[-0.025, 1.567], [0.025, 1.567]], 0.012),
            Ink::Flat(rgb(0x0096_4A44)),
        );
    }
}
