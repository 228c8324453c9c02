//! Traffic signs and a traffic light.
//!
//! What comes out is a sign face drawn in metres about its own middle, with
//! its letters as strokes; posts are drawn apart, so that the box of a sign is
//! the box of its face.

use std::f32::consts::TAU;

use super::camera::Board;
use super::paint::{Ink, Painter, rgb};
use super::shape::Shape;

/// Draws the post of a sign and the post's shadow on the ground.
pub(super) fn paint_post(painter: &mut Painter, board: &Board, top_m: f32, radius_m: f32) {
    painter.set_distance(board.foot.ahead_m);
    let post = Shape::rect(-radius_m, 0.0, radius_m, top_m);
    painter.shadow(&post, 0.36, &|point| board.at(point));
    painter.fill_board(
        &post,
        Ink::Across(rgb(0x00D4_D8DB), rgb(0x006C_737A)),
        board,
    );
}

/// Throws the shadow of a round sign face on the ground.
pub(super) fn paint_face_shadow(
    painter: &mut Painter,
    board: &Board,
    middle_m: f32,
    radius_m: f32,
) {
    let disc = Shape::disc([0.0, middle_m], radius_m);
    painter.shadow(&disc, 0.32, &|point| board.at(point));
}

fn raised(board: &Board, middle_m: f32) -> Board {
    let mut face = *board;
    face.foot.up_m += middle_m;
    face
}

fn corners(count: u8, radius_m: f32, turn_rad: f32) -> Vec<[f32; 3]> {
    (0..count)
        .map(|corner| {
            let angle_rad = turn_rad + TAU * f32::from(corner) / f32::from(count);
            [
                radius_m * libm::cosf(angle_rad),
                radius_m * libm::sinf(angle_rad),
                radius_m * 0.06,
            ]
        })
        .collect()
}

/// Draws a STOP sign.
pub(super) fn paint_stop_sign(painter: &mut Painter, board: &Board, middle_m: f32) {
    let face = raised(board, middle_m);
    let octagon = |radius_m: f32| Shape::soft(&corners(8, radius_m, TAU / 16.0));
    painter.fill_board(&octagon(0.455), Ink::Flat(rgb(0x008E_949A)), &face);
    painter.fill_board(&octagon(0.445), Ink::Flat(rgb(0x00F6_F5F2)), &face);
    painter.fill_board(
        &octagon(0.405),
        Ink::Slant(rgb(0x00D6_2027), rgb(0x00A8_0F1B)),
        &face,
    );
    let white = Ink::Flat(rgb(0x00FB_FAF6));
    let (high, low, middle) = (0.115, -0.115, 0.0);
    let letters = [
        // S
        vec![
            [-0.188, 0.075],
            [-0.203, 0.105],
            [-0.235, high],
            [-0.268, 0.10],
            [-0.278, 0.06],
            [-0.262, 0.022],
            [-0.215, -0.012],
            [-0.192, -0.045],
            [-0.196, -0.085],
            [-0.225, low],
            [-0.262, -0.11],
            [-0.283, -0.075],
        ],
        // T
        vec![[-0.145, high], [-0.015, high]],
        vec![[-0.08, high], [-0.08, low]],
        // O
        vec![
            [0.075, high],
            [0.108, 0.095],
            [0.122, 0.04],
            [0.122, -0.04],
            [0.108, -0.095],
            [0.075, low],
            [0.042, -0.095],
            [0.028, -0.04],
            [0.028, 0.04],
            [0.042, 0.095],
            [0.075, high],
        ],
        // P
        vec![
            [0.185, low],
            [0.185, high],
            [0.24, high],
            [0.27, 0.09],
            [0.278, 0.055],
            [0.268, 0.02],
            [0.24, middle],
            [0.185, middle],
        ],
    ];
    for letter in &letters {
        painter.fill_board(&Shape::line(letter, 0.046), white, &face);
    }
}

/// Draws a speed limit sign that reads 30.
pub(super) fn paint_speed_sign(painter: &mut Painter, board: &Board, middle_m: f32) {
    let face = raised(board, middle_m);
    painter.fill_board(
        &Shape::disc([0.0, 0.0], 0.36),
        Ink::Flat(rgb(0x00C8_CCD0)),
        &face,
    );
    painter.fill_board(
        &Shape::disc([0.0, 0.0], 0.345),
        Ink::Slant(rgb(0x00DC_222A), rgb(0x00B0_121E)),
        &face,
    );
    painter.fill_board(
        &Shape::disc([0.0, 0.0], 0.255),
        Ink::Slant(rgb(0x00FF_FFFF), rgb(0x00E4_E4E0)),
        &face,
    );
    let black = Ink::Flat(rgb(0x0014_1518));
    let three = [
        [-0.165, 0.085],
        [-0.135, 0.125],
        [-0.09, 0.13],
        [-0.05, 0.105],
        [-0.045, 0.055],
        [-0.07, 0.015],
        [-0.105, 0.005],
        [-0.06, -0.005],
        [-0.035, -0.045],
        [-0.04, -0.095],
        [-0.08, -0.13],
        [-0.13, -0.125],
        [-0.165, -0.085],
    ];
    painter.fill_board(&Shape::line(&three, 0.05), black, &face);
    let zero = [
        [0.10, 0.13],
        [0.14, 0.11],
        [0.165, 0.05],
        [0.165, -0.05],
        [0.14, -0.11],
        [0.10, -0.13],
        [0.06, -0.11],
        [0.035, -0.05],
        [0.035, 0.05],
        [0.06, 0.11],
        [0.10, 0.13],
    ];
    painter.fill_board(&Shape::line(&zero, 0.05), black, &face);
}

/// Draws the mast and the arm that carry a traffic light over the road.
pub(super) fn paint_light_mast(painter: &mut Painter, board: &Board, arm_m: f32, height_m: f32) {
    paint_post(painter, board, height_m + 0.25, 0.075);
    let arm = Shape::polygon(&[
        [0.0, height_m + 0.06],
        [0.0, height_m - 0.06],
        [-arm_m - 0.2, height_m + 0.10],
        [-arm_m - 0.2, height_m + 0.16],
    ]);
    painter.fill_board(&arm, Ink::Down(rgb(0x00D0_D5D9), rgb(0x0070_777E)), board);
    let hanger = Shape::rect(
        -arm_m - 0.05,
        height_m - 0.2,
        -arm_m + 0.05,
        height_m + 0.14,
    );
    painter.fill_board(&hanger, Ink::Flat(rgb(0x0070_777E)), board);
}

/// Draws a traffic light whose lowest lamp is on; the board's origin is below
/// the lamps.
pub(super) fn paint_traffic_light(painter: &mut Painter, board: &Board, middle_m: f32) {
    let face = raised(board, middle_m);
    painter.fill_board(
        &Shape::round_rect(-0.30, -0.62, 0.30, 0.62, 0.10),
        Ink::Flat(rgb(0x00F2_F4F4)),
        &face,
    );
    painter.fill_board(
        &Shape::round_rect(-0.27, -0.59, 0.27, 0.59, 0.08),
        Ink::Across(rgb(0x002E_3338), rgb(0x0012_1518)),
        &face,
    );
    let lamps = [
        (0.36, rgb(0x006A_1A1C), rgb(0x0040_0E10)),
        (0.0, rgb(0x006B_5114), rgb(0x0042_300A)),
        (-0.36, rgb(0x00D8_FFE6), rgb(0x0012_C064)),
    ];
    for (up_m, inner, outer) in lamps {
        painter.fill_board(
            &Shape::disc([0.0, up_m], 0.165),
            Ink::Flat(rgb(0x0008_0A0C)),
            &face,
        );
        painter.fill_board(
            &Shape::disc([0.0, up_m], 0.14),
            Ink::Glow(inner, outer),
            &face,
        );
        let visor = Shape::smooth(&[
            [-0.17, up_m + 0.02],
            [-0.13, up_m + 0.14],
            [0.0, up_m + 0.19],
            [0.13, up_m + 0.14],
            [0.17, up_m + 0.02],
            [0.11, up_m + 0.10],
            [0.0, up_m + 0.14],
            [-0.11, up_m + 0.10],
        ]);
        painter.fill_board(&visor, Ink::Flat(rgb(0x0005_0607)), &face);
    }
}
