//! A person on a bicycle.
//!
//! What comes out is a rider in profile with the bicycle, drawn in metres on
//! an upright board whose origin is the ground point below the pedals; the
//! board may be turned so that the ride goes into or out of the picture.

use std::f32::consts::TAU;

use super::camera::{Board, point3};
use super::paint::{Ink, Painter, rgb};
use super::people::swing;
use super::shape::Shape;

const WHEEL_RADIUS_M: f32 = 0.345;
const REAR_HUB: [f32; 2] = [-0.52, WHEEL_RADIUS_M];
const FRONT_HUB: [f32; 2] = [0.55, WHEEL_RADIUS_M];
const CRANK: [f32; 2] = [-0.06, 0.29];
const SADDLE: [f32; 2] = [-0.22, 0.93];
const HEAD_TUBE: [f32; 2] = [0.38, 0.86];
const GRIP: [f32; 2] = [0.42, 1.06];
const HIP: [f32; 2] = [-0.20, 1.02];
const SHOULDER: [f32; 2] = [0.10, 1.50];

/// Darkens the ground below and behind the rider.
pub(super) fn paint_cyclist_shadow(painter: &mut Painter, board: &Board) {
    painter.set_distance(board.foot.ahead_m);
    let figure = Shape::disc(REAR_HUB, WHEEL_RADIUS_M)
        .and(Shape::disc(FRONT_HUB, WHEEL_RADIUS_M))
        .and(Shape::limb(CRANK, SADDLE, 0.12, 0.12))
        .and(Shape::limb(HIP, SHOULDER, 0.16, 0.17))
        .and(Shape::limb(SHOULDER, GRIP, 0.05, 0.05))
        .and(Shape::disc([0.18, 1.72], 0.13));
    painter.shadow(&figure, 0.40, &|point| board.at(point));
    for hub in [REAR_HUB, FRONT_HUB] {
        let touch = board.at([hub[0], 0.0]);
        let blob = Shape::ellipse([touch.right_m, touch.ahead_m], 0.3, 0.16);
        painter.fill(&blob, Ink::Flat(rgb(0x0010_1424).clear(0.25)), &|[x, z]| {
            point3(x, 0.0, z)
        });
    }
}

/// Draws the rider and the bicycle.
pub(super) fn paint_cyclist(painter: &mut Painter, board: &Board) {
    painter.set_distance(board.foot.ahead_m);
    let mut fill = |shape: &Shape, ink: Ink| painter.fill_board(shape, ink, board);
    let skin = rgb(0x00D9_A27C);
    let shirt = rgb(0x00F0_A21E);
    let shorts = rgb(0x0027_2E44);
    let frame = rgb(0x0015_8C8C);
    let far_foot = [CRANK[0] - 0.10, CRANK[1] + 0.13];
    let near_foot = [CRANK[0] + 0.10, CRANK[1] - 0.13];
    // Far leg and far arm first: the bicycle hides part of them.
    let far_knee = [0.20, 0.86];
    fill(
        &Shape::limb(far_knee, far_foot, 0.06, 0.042),
        Ink::Flat(skin.lit(-0.35)),
    );
    fill(
        &Shape::limb(HIP, far_knee, 0.10, 0.07),
        Ink::Flat(shorts.lit(-0.3)),
    );
    fill(
        &Shape::limb(
            [far_foot[0] - 0.05, far_foot[1] - 0.03],
            [far_foot[0] + 0.15, far_foot[1] - 0.03],
            0.045,
            0.035,
        ),
        Ink::Flat(rgb(0x0060_6468)),
    );
    let far_elbow = [0.29, 1.27];
    fill(
        &Shape::limb(far_elbow, [GRIP[0] + 0.03, GRIP[1] + 0.01], 0.042, 0.034),
        Ink::Flat(skin.lit(-0.35)),
    );
    fill(
        &Shape::limb(
            [SHOULDER[0] + 0.04, SHOULDER[1] - 0.05],
            far_elbow,
            0.06,
            0.048,
        ),
        Ink::Flat(shirt.lit(-0.4)),
    );
    for hub in [REAR_HUB, FRONT_HUB] {
        for spoke in 0..10_u8 {
            let angle_rad = TAU * f32::from(spoke) / 10.0 + 0.2;
            let rim = [
                hub[0] + 0.32 * libm::cosf(angle_rad),
                hub[1] + 0.32 * libm::sinf(angle_rad),
            ];
            fill(
                &Shape::line(&[hub, rim], 0.007),
                Ink::Flat(rgb(0x00C9_CED3).clear(0.8)),
            );
        }
        fill(
            &Shape::ring(hub, WHEEL_RADIUS_M, WHEEL_RADIUS_M - 0.035),
            Ink::Flat(rgb(0x0020_2226)),
        );
        fill(
            &Shape::ring(hub, WHEEL_RADIUS_M - 0.035, WHEEL_RADIUS_M - 0.05),
            Ink::Flat(rgb(0x00B4_BAC0)),
        );
        fill(&Shape::disc(hub, 0.03), Ink::Flat(rgb(0x0060_666C)));
    }
    // Mudguard, luggage rack with a lamp, frame, fork and bars.
    fill(
        &Shape::line(
            &[[-0.86, 0.52], [-0.76, 0.66], [-0.60, 0.73], [-0.42, 0.72]],
            0.022,
        ),
        Ink::Flat(rgb(0x0030_343A)),
    );
    fill(
        &Shape::line(&[[-0.78, 0.76], [-0.30, 0.78]], 0.025),
        Ink::Flat(rgb(0x0030_343A)),
    );
    fill(
        &Shape::line(&[[-0.72, 0.76], REAR_HUB], 0.016),
        Ink::Flat(rgb(0x0030_343A)),
    );
    fill(
        &Shape::round_rect(-0.83, 0.70, -0.77, 0.78, 0.02),
        Ink::Flat(rgb(0x00E0_2424)),
    );
    let seat_top = [-0.20, 0.80];
    for pair in [[REAR_HUB, CRANK], [REAR_HUB, seat_top]] {
        fill(&Shape::line(&pair, 0.025), Ink::Flat(frame.lit(-0.15)));
    }
    for pair in [
        [CRANK, seat_top],
        [CRANK, [0.40, 0.74]],
        [[-0.19, 0.76], HEAD_TUBE],
    ] {
        fill(&Shape::line(&pair, 0.042), Ink::Flat(frame));
    }
    fill(
        &Shape::line(&[HEAD_TUBE, [0.43, 0.70], FRONT_HUB], 0.035),
        Ink::Flat(frame.lit(-0.1)),
    );
    fill(
        &Shape::line(&[seat_top, SADDLE], 0.028),
        Ink::Flat(rgb(0x0080_868C)),
    );
    fill(
        &Shape::line(&[HEAD_TUBE, [0.36, 1.02], GRIP], 0.03),
        Ink::Flat(rgb(0x0030_343A)),
    );
    fill(
        &Shape::disc([0.47, 0.93], 0.045),
        Ink::Glow(rgb(0x00FF_FFFF), rgb(0x00D8_D2B0)),
    );
    fill(
        &Shape::smooth(&[
            [-0.38, 0.96],
            [-0.30, 0.99],
            [-0.08, 0.96],
            [-0.10, 0.93],
            [-0.28, 0.91],
        ]),
        Ink::Flat(rgb(0x0022_1E1C)),
    );
    fill(&Shape::ring(CRANK, 0.09, 0.06), Ink::Flat(rgb(0x0050_565C)));
    fill(
        &Shape::line(&[far_foot, near_foot], 0.025),
        Ink::Flat(rgb(0x0050_565C)),
    );
    // Near leg: thigh in shorts, bare shin, shoe.
    let near_knee = [0.17, 0.72];
    fill(
        &Shape::limb(
            near_knee,
            [near_foot[0] - 0.03, near_foot[1] + 0.07],
            0.066,
            0.045,
        ),
        Ink::Across(skin.lit(0.1), skin.lit(-0.2)),
    );
    fill(
        &Shape::limb(HIP, near_knee, 0.115, 0.075),
        Ink::Slant(shorts.lit(0.18), shorts),
    );
    fill(
        &Shape::limb(
            [near_foot[0] - 0.08, near_foot[1] + 0.02],
            [near_foot[0] + 0.13, near_foot[1] + 0.005],
            0.048,
            0.036,
        ),
        Ink::Flat(rgb(0x00F2_F2F0)),
    );
    // Torso leaning forward, head with helmet, near arm.
    let torso = Shape::smooth(&[
        [0.04, 1.57],
        [0.15, 1.54],
        [0.18, 1.42],
        [0.10, 1.24],
        [0.0, 1.06],
        [-0.10, 0.93],
        [-0.30, 0.95],
        [-0.31, 1.08],
        [-0.22, 1.28],
        [-0.10, 1.47],
    ]);
    fill(&torso, Ink::Across(shirt.lit(0.18), shirt.lit(-0.25)));
    fill(
        &Shape::line(&[[-0.29, 1.10], [-0.02, 1.03]], 0.025),
        Ink::Flat(rgb(0x00F4_F1E4)),
    );
    fill(
        &Shape::limb([0.10, 1.50], [0.15, 1.63], 0.07, 0.06),
        Ink::Flat(skin.lit(-0.25)),
    );
    let head = Shape::smooth(&[
        [0.16, 1.80],
        [0.25, 1.77],
        [0.275, 1.71],
        [0.295, 1.675],
        [0.27, 1.655],
        [0.255, 1.60],
        [0.19, 1.58],
        [0.12, 1.62],
        [0.08, 1.70],
        [0.10, 1.77],
    ]);
    fill(&head, Ink::Across(skin.lit(0.1), skin.lit(-0.15)));
    fill(
        &Shape::disc([0.243, 1.708], 0.010),
        Ink::Flat(rgb(0x0022_1C1A)),
    );
    fill(
        &Shape::line(&[[0.155, 1.72], [0.20, 1.60]], 0.014),
        Ink::Flat(rgb(0x0028_2C32)),
    );
    let hair = Shape::smooth(&[
        [0.05, 1.76],
        [0.06, 1.66],
        [0.10, 1.62],
        [0.135, 1.66],
        [0.15, 1.76],
    ]);
    fill(&hair, Ink::Flat(rgb(0x006A_4226)));
    let helmet = Shape::smooth(&[
        [0.29, 1.745],
        [0.27, 1.82],
        [0.18, 1.87],
        [0.08, 1.845],
        [0.02, 1.77],
        [0.03, 1.72],
        [0.15, 1.755],
    ]);
    fill(&helmet, Ink::Down(rgb(0x00F4_F6F8), rgb(0x00A9_B4C2)));
    for vent in 0..3_u8 {
        let across = 0.08 + 0.06 * f32::from(vent);
        fill(
            &Shape::line(&[[across, 1.79], [across + 0.03, 1.83]], 0.018),
            Ink::Flat(rgb(0x003A_4250)),
        );
    }
    let elbow = swing(SHOULDER, 0.29, 0.42);
    fill(&Shape::limb(elbow, GRIP, 0.046, 0.036), Ink::Flat(skin));
    fill(
        &Shape::limb(
            [SHOULDER[0] - 0.02, SHOULDER[1] - 0.06],
            elbow,
            0.072,
            0.054,
        ),
        Ink::Flat(shirt.lit(-0.08)),
    );
    fill(&Shape::disc(GRIP, 0.04), Ink::Flat(skin.lit(-0.05)));
}
