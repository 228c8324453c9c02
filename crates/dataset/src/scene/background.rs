//! Sky, far skyline, road and sidewalks.
//!
//! What comes out is the empty street: everything that reaches the horizon
//! and on which the houses, trees and road users stand.

use rand_chacha::ChaCha8Rng;

use super::camera::{PRINCIPAL_POINT_PX, point3};
use super::paint::{Ink, Painter, Tint, rgb};
use super::random::between;
use super::shape::Shape;

/// Where the road's own edges lie, in metres to the right of the camera.
const LEFT_KERB_M: f32 = -7.6;
const RIGHT_KERB_M: f32 = 4.15;
/// The line between the two directions of travel.
const CENTER_LINE_M: f32 = -1.85;
/// Edges of the parking bays.
const LEFT_BAY_M: f32 = -5.25;
const RIGHT_BAY_M: f32 = 1.85;
/// The ground is drawn from below the picture to where it melts into haze.
const NEAREST_M: f32 = 4.6;
const FARTHEST_M: f32 = 260.0;
const KERB_HEIGHT_M: f32 = 0.12;

/// Clouds as (middle in pixels, size in pixels).
const CLOUDS_PX: [[f32; 3]; 6] = [
    [470.0, 52.0, 62.0],
    [735.0, 84.0, 46.0],
    [250.0, 22.0, 50.0],
    [600.0, 118.0, 32.0],
    [880.0, 24.0, 52.0],
    [388.0, 106.0, 28.0],
];

/// Draws the sky with its clouds.
pub(super) fn paint_sky(painter: &mut Painter, rng: &mut ChaCha8Rng) {
    painter.set_distance(0.0);
    let sky = Shape::rect(0.0, 0.0, 1242.0, 190.0);
    painter.fill_px(
        &sky,
        Ink::Down3(rgb(0x0048_8FD6), rgb(0x0091_C3EC), rgb(0x00EC_F1F0)),
    );
    let sun = Shape::disc([200.0, -40.0], 420.0);
    painter.fill_px(
        &sun,
        Ink::Glow(rgb(0x00FF_F6DC).clear(0.55), rgb(0x00FF_F6DC).clear(0.0)),
    );
    for [x_px, y_px, size_px] in CLOUDS_PX {
        // Gray undersides first, then sunlit puffs that lean to the sun.
        for (count, drop, tint) in [
            (7_u8, 0.16, rgb(0x00B4_C8DC).clear(0.55)),
            (11, 0.0, rgb(0x00FF_FFFF).clear(0.70)),
            (7, -0.14, rgb(0x00FF_FDF6).clear(0.80)),
        ] {
            for puff in 0..count {
                // Evenly spread with a wobble, so that no puff stands alone.
                let along =
                    (f32::from(puff) + between(rng, 0.1, 0.9)) / f32::from(count) * 2.0 - 1.0;
                let bulge = 1.0 - along * along;
                let radius_px = size_px * (0.20 + 0.30 * bulge * between(rng, 0.6, 1.0));
                let center_px = [
                    x_px + along * size_px * 1.45,
                    y_px + size_px * (drop - 0.30 * bulge * between(rng, 0.0, 1.0)),
                ];
                let puff = Shape::ellipse(center_px, radius_px * 1.25, radius_px * 0.85);
                painter.fill_px(&puff, Ink::Glow(tint, tint.clear(0.0)));
            }
        }
    }
}

/// Draws the far end of the street: hills, roofs and tree tops in the haze.
pub(super) fn paint_skyline(painter: &mut Painter, rng: &mut ChaCha8Rng) {
    painter.set_distance(0.0);
    let horizon_px = PRINCIPAL_POINT_PX[1] + 3.0;
    for (height_px, tint, step_px) in [
        (30.0, rgb(0x00B4_CADB), 64.0),
        (17.0, rgb(0x009D_B7BC), 26.0),
        (11.0, rgb(0x0086_A591), 15.0),
    ] {
        let mut outline = vec![[-80.0, horizon_px + 20.0]];
        let mut x_px = -80.0;
        while x_px < 1340.0 {
            outline.push([x_px, horizon_px - height_px * between(rng, 0.55, 1.0)]);
            x_px += step_px * between(rng, 0.7, 1.3);
        }
        outline.push([1340.0, horizon_px + 20.0]);
        painter.fill_px(&Shape::smooth(&outline), Ink::Down(tint, tint.lit(0.35)));
    }
}

/// Fills a strip of ground between two lines and two distances.
fn strip(painter: &mut Painter, across_m: [f32; 2], ahead_m: [f32; 2], ink: Ink) {
    let shape = Shape::rect(across_m[0], ahead_m[0], across_m[1], ahead_m[1]);
    painter.fill(&shape, ink, &|[x, z]| point3(x, 0.0, z));
}

/// Draws the road, its markings, kerbs and sidewalks.
pub(super) fn paint_ground(painter: &mut Painter, rng: &mut ChaCha8Rng) {
    painter.set_distance(0.0);
    let all = [NEAREST_M, FARTHEST_M];
    // Houses hide the ground on the right: grass is needed on the left only.
    strip(
        painter,
        [-130.0, -10.5],
        all,
        Ink::Down(rgb(0x00B4_C6A6), rgb(0x0067_8F49)),
    );
    for (from_m, to_m) in [(-10.6, LEFT_KERB_M), (RIGHT_KERB_M, 9.9)] {
        strip(
            painter,
            [from_m, to_m],
            all,
            Ink::Down(rgb(0x00D2_D3D0), rgb(0x00A9_A59C)),
        );
        paint_slabs(painter, [from_m, to_m]);
    }
    strip(
        painter,
        [LEFT_KERB_M, RIGHT_KERB_M],
        all,
        Ink::Down3(rgb(0x00B9_BEC2), rgb(0x0074_787E), rgb(0x005B_5F65)),
    );
    paint_asphalt(painter, rng);
    for (edge_m, toward_m) in [(LEFT_KERB_M, -1.0), (RIGHT_KERB_M, 1.0)] {
        // A kerb is a lit top and a face that drops to the gutter.
        strip(
            painter,
            [edge_m - toward_m * 0.30, edge_m],
            all,
            Ink::Down(rgb(0x00A4_A9AD), rgb(0x004C_5056)),
        );
        let face = Shape::rect(0.0, NEAREST_M, KERB_HEIGHT_M, FARTHEST_M);
        painter.fill(
            &face,
            Ink::Down(rgb(0x00BC_BEBE), rgb(0x0090_908C).lit(0.1 * toward_m)),
            &|[up, z]| point3(edge_m, up, z),
        );
        let top = Shape::rect(edge_m, NEAREST_M, edge_m + toward_m * 0.2, FARTHEST_M);
        painter.fill(
            &top,
            Ink::Down(rgb(0x00DA_DAD6), rgb(0x00C9_C6BE)),
            &|[x, z]| point3(x, KERB_HEIGHT_M, z),
        );
    }
    paint_markings(painter);
}

fn paint_slabs(painter: &mut Painter, [from_m, to_m]: [f32; 2]) {
    let joint = rgb(0x0062_5E56).clear(0.55);
    let mut ahead_m = 5.0;
    while ahead_m < 34.0 {
        strip(
            painter,
            [from_m, to_m],
            [ahead_m, ahead_m + 0.025],
            Ink::Flat(joint),
        );
        ahead_m += 0.9;
    }
    for share in [0.25, 0.5, 0.75] {
        let at_m = from_m + (to_m - from_m) * share;
        strip(
            painter,
            [at_m, at_m + 0.02],
            [NEAREST_M, 40.0],
            Ink::Down(joint.clear(0.1), joint),
        );
    }
}

fn paint_asphalt(painter: &mut Painter, rng: &mut ChaCha8Rng) {
    // Wheel tracks are polished darker; bays are paved a little lighter.
    for [from_m, to_m] in [[LEFT_KERB_M, LEFT_BAY_M], [RIGHT_BAY_M, RIGHT_KERB_M]] {
        strip(
            painter,
            [from_m, to_m],
            [NEAREST_M, 120.0],
            Ink::Flat(rgb(0x00B0_A79C).clear(0.20)),
        );
    }
    for track_m in [-4.35, -2.75, -0.75, 0.75] {
        for spread_m in [0.16, 0.30] {
            strip(
                painter,
                [track_m - spread_m, track_m + spread_m],
                [NEAREST_M, 90.0],
                Ink::Flat(rgb(0x0028_2C33).clear(0.09)),
            );
        }
    }
    // A manhole with its bars.
    for (radius_m, tint) in [(0.36, rgb(0x0078_7C80)), (0.31, rgb(0x0044_474C))] {
        painter.fill(
            &Shape::disc([-2.9, 7.9], radius_m),
            Ink::Flat(tint),
            &|[x, z]| point3(x, 0.0, z),
        );
    }
    for bar in 0..5_u8 {
        let across_m = -3.1 + 0.1 * f32::from(bar);
        strip(
            painter,
            [across_m, across_m + 0.03],
            [7.72, 8.08],
            Ink::Flat(rgb(0x0074_787C).clear(0.8)),
        );
    }
    // Grit: nearer stones are seen larger.
    for _ in 0..900 {
        let (x_m, z_m) = (
            between(rng, LEFT_KERB_M, RIGHT_KERB_M),
            between(rng, 5.6, 17.0),
        );
        let tint = if between(rng, 0.0, 1.0) < 0.5 {
            rgb(0x00C9_CBCD)
        } else {
            rgb(0x001E_2126)
        };
        let size_m = between(rng, 0.01, 0.026);
        let stone = Shape::rect(x_m, z_m, x_m + size_m, z_m + size_m * 3.0);
        painter.fill(&stone, Ink::Flat(tint.clear(0.32)), &|[x, z]| {
            point3(x, 0.0, z)
        });
    }
}

fn paint_markings(painter: &mut Painter) {
    let white = |opacity: f32| -> Tint { rgb(0x00F4_F3EC).clear(opacity) };
    let mut ahead_m = 6.2_f32;
    while ahead_m < 120.0 {
        let opacity = (0.95 - ahead_m / 150.0).max(0.2);
        strip(
            painter,
            [CENTER_LINE_M - 0.07, CENTER_LINE_M + 0.07],
            [ahead_m, ahead_m + 3.0],
            Ink::Flat(white(opacity)),
        );
        ahead_m += 6.0;
    }
    for edge_m in [LEFT_BAY_M, RIGHT_BAY_M] {
        strip(
            painter,
            [edge_m - 0.06, edge_m + 0.06],
            [NEAREST_M, 95.0],
            Ink::Down(white(0.35), white(0.85)),
        );
    }
    // Bay dividers on both sides.
    for step in 0..9_u8 {
        let ahead_m = 5.6 + 6.0 * f32::from(step);
        for [from_m, to_m] in [
            [LEFT_KERB_M + 0.35, LEFT_BAY_M],
            [RIGHT_BAY_M, RIGHT_KERB_M - 0.35],
        ] {
            strip(
                painter,
                [from_m, to_m],
                [ahead_m, ahead_m + 0.13],
                Ink::Flat(white(0.75)),
            );
        }
    }
    // A crosswalk farther on.
    for bar in 0..10_u8 {
        let across_m = LEFT_KERB_M + 0.45 + 1.14 * f32::from(bar);
        strip(
            painter,
            [across_m, across_m + 0.55],
            [29.0, 33.0],
            Ink::Flat(white(0.8)),
        );
    }
}
