//! People on foot.
//!
//! What comes out is a figure of 1.75 m, drawn in metres on an upright board
//! with its feet at the board's origin: limbs from joint angles, clothes and
//! hair as smooth outlines over them.

use super::camera::{Board, Point3, point3};
use super::paint::{Ink, Painter, Tint, rgb};
use super::shape::Shape;

/// What a figure wears.
#[derive(Clone, Copy)]
pub(super) struct Clothes {
    pub(super) top: Tint,
    pub(super) legs: Tint,
    pub(super) shoes: Tint,
    pub(super) skin: Tint,
    pub(super) hair: Tint,
    /// Bag color: a backpack in profile, a shoulder bag from the front.
    pub(super) bag: Tint,
    /// Long hair and a dress in place of trousers.
    pub(super) dress: bool,
}

/// How a figure is seen.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum View {
    /// Walking, seen from the side.
    Profile,
    /// Walking toward the camera.
    Front,
}

/// One person on foot.
pub(super) struct Person {
    pub(super) board: Board,
    pub(super) height_m: f32,
    pub(super) view: View,
    pub(super) clothes: Clothes,
}

/// The end of a bone that hangs from a joint, swung forward by an angle.
pub(super) fn swing(joint: [f32; 2], length_m: f32, forward_rad: f32) -> [f32; 2] {
    [
        joint[0] + length_m * libm::sinf(forward_rad),
        joint[1] - length_m * libm::cosf(forward_rad),
    ]
}

/// A limb is round: a little brighter toward the sun on its left.
pub(super) fn rounded(tint: Tint, shade: f32) -> Ink {
    Ink::Across(tint.lit(shade + 0.06), tint.lit(shade - 0.08))
}

/// Bare stature that the drawing is made for.
const DRAWN_HEIGHT_M: f32 = 1.75;

impl Person {
    fn place(&self, [across, up]: [f32; 2]) -> Point3 {
        let scale = self.height_m / DRAWN_HEIGHT_M;
        self.board.at([across * scale, up * scale])
    }

    /// Darkens the ground below and behind the person.
    pub(super) fn paint_shadow(&self, painter: &mut Painter) {
        painter.set_distance(self.board.foot.ahead_m);
        let stride = if self.view == View::Profile {
            0.28
        } else {
            0.1
        };
        let figure = Shape::limb([-stride, 0.03], [0.0, 0.9], 0.07, 0.11)
            .and(Shape::limb([stride, 0.03], [0.0, 0.9], 0.07, 0.11))
            .and(Shape::limb([0.0, 0.9], [0.0, 1.4], 0.17, 0.19))
            .and(Shape::disc([0.0, 1.62], 0.12));
        painter.shadow(&figure, 0.42, &|point| self.place(point));
        let foot = self.board.foot;
        for (radius_m, opacity) in [(0.42, 0.14), (0.3, 0.2)] {
            let blob = Shape::ellipse(
                [foot.right_m + 0.05, foot.ahead_m],
                radius_m,
                radius_m * 0.6,
            );
            painter.fill(
                &blob,
                Ink::Flat(rgb(0x0010_1424).clear(opacity)),
                &|[x, z]| point3(x, 0.0, z),
            );
        }
    }

    /// Draws the person.
    pub(super) fn paint(&self, painter: &mut Painter) {
        painter.set_distance(self.board.foot.ahead_m);
        match self.view {
            View::Profile => self.paint_profile(painter),
            View::Front => self.paint_front(painter),
        }
    }

    /// Fills an outline drawn for a figure of 1.75 m.
    pub(super) fn fill(&self, painter: &mut Painter, shape: &Shape, ink: Ink) {
        painter.fill(shape, ink, &|point| self.place(point));
    }

    /// The sun stands to the left: clothes darken toward the right.
    pub(super) fn cloth(&self, tint: Tint) -> Ink {
        let (left, right) = (tint.lit(0.16), tint.lit(-0.28));
        Ink::Across(left, right)
    }

    fn leg(&self, painter: &mut Painter, thigh_rad: f32, shin_rad: f32, shade: f32) {
        let clothes = self.clothes;
        let hip = [0.0, 0.92];
        let knee = swing(hip, 0.43, thigh_rad);
        let ankle = swing(knee, 0.42, shin_rad);
        let toe_rad = shin_rad + 1.45;
        let toe = swing(ankle, 0.20, toe_rad);
        let heel = swing(ankle, 0.06, shin_rad - 0.5);
        self.fill(
            painter,
            &Shape::limb(heel, toe, 0.055, 0.038),
            rounded(clothes.shoes, shade),
        );
        let bare = if clothes.dress {
            clothes.skin
        } else {
            clothes.legs
        };
        self.fill(
            painter,
            &Shape::limb(knee, ankle, 0.072, 0.048),
            rounded(bare, shade),
        );
        self.fill(
            painter,
            &Shape::limb(hip, knee, 0.10, 0.073),
            rounded(bare, shade),
        );
    }

    fn arm(&self, painter: &mut Painter, upper_rad: f32, lower_rad: f32, shade: f32) {
        let shoulder = [-0.01, 1.40];
        let elbow = swing(shoulder, 0.28, upper_rad);
        let wrist = swing(elbow, 0.25, lower_rad);
        let hand = swing(wrist, 0.06, lower_rad);
        self.fill(
            painter,
            &Shape::limb(wrist, hand, 0.035, 0.035),
            rounded(self.clothes.skin, shade),
        );
        self.fill(
            painter,
            &Shape::limb(elbow, wrist, 0.05, 0.038),
            rounded(self.clothes.top, shade),
        );
        self.fill(
            painter,
            &Shape::limb(shoulder, elbow, 0.066, 0.05),
            rounded(self.clothes.top, shade),
        );
    }

    fn paint_profile(&self, painter: &mut Painter) {
        let clothes = self.clothes;
        self.arm(painter, 0.55, 0.95, -0.35);
        self.leg(painter, -0.42, -0.72, -0.3);
        self.leg(painter, 0.46, 0.20, 0.0);
        if clothes.dress {
            let skirt = Shape::smooth(&[
                [-0.12, 1.02],
                [0.12, 1.02],
                [0.19, 0.75],
                [0.26, 0.52],
                [0.0, 0.49],
                [-0.24, 0.54],
                [-0.19, 0.78],
            ]);
            self.fill(painter, &skirt, self.cloth(clothes.top));
        } else {
            let pack = Shape::smooth(&[
                [-0.12, 1.42],
                [-0.26, 1.38],
                [-0.31, 1.18],
                [-0.28, 0.99],
                [-0.12, 0.98],
            ]);
            self.fill(
                painter,
                &pack,
                Ink::Down(clothes.bag.lit(0.12), clothes.bag.lit(-0.35)),
            );
        }
        let torso = Shape::smooth(&[
            [-0.03, 1.50],
            [0.07, 1.47],
            [0.135, 1.34],
            [0.14, 1.12],
            [0.13, 0.88],
            [0.0, 0.86],
            [-0.13, 0.88],
            [-0.125, 1.12],
            [-0.14, 1.34],
            [-0.11, 1.46],
        ]);
        self.fill(painter, &torso, self.cloth(clothes.top));
        // Neck, head with nose, ear and hair.
        self.fill(
            painter,
            &Shape::limb([0.01, 1.46], [0.02, 1.55], 0.05, 0.05),
            Ink::Flat(clothes.skin.lit(-0.25)),
        );
        let head = Shape::smooth(&[
            [0.02, 1.74],
            [0.10, 1.70],
            [0.118, 1.645],
            [0.14, 1.61],
            [0.115, 1.59],
            [0.10, 1.53],
            [0.04, 1.515],
            [-0.04, 1.56],
            [-0.075, 1.65],
            [-0.05, 1.72],
        ]);
        self.fill(painter, &head, self.cloth(clothes.skin));
        let hair = if clothes.dress {
            Shape::smooth(&[
                [0.10, 1.70],
                [0.06, 1.75],
                [-0.03, 1.76],
                [-0.10, 1.70],
                [-0.12, 1.56],
                [-0.13, 1.38],
                [-0.04, 1.36],
                [-0.03, 1.54],
                [0.0, 1.64],
                [0.05, 1.69],
            ])
        } else {
            Shape::smooth(&[
                [0.115, 1.69],
                [0.07, 1.75],
                [-0.02, 1.765],
                [-0.09, 1.71],
                [-0.09, 1.60],
                [-0.05, 1.57],
                [-0.02, 1.63],
                [0.02, 1.68],
            ])
        };
        self.fill(
            painter,
            &hair,
            Ink::Down(clothes.hair.lit(0.15), clothes.hair),
        );
        self.fill(
            painter,
            &Shape::ellipse([-0.005, 1.625], 0.017, 0.026),
            Ink::Flat(clothes.skin.lit(-0.22)),
        );
        self.fill(
            painter,
            &Shape::disc([0.088, 1.648], 0.010),
            Ink::Flat(rgb(0x0020_1A18)),
        );
        if !clothes.dress {
            self.fill(
                painter,
                &Shape::line(&[[0.06, 1.46], [0.07, 1.28], [-0.05, 1.08]], 0.035),
                Ink::Flat(clothes.bag.lit(-0.3)),
            );
        }
        self.arm(painter, -0.42, -0.05, -0.06);
    }
}
