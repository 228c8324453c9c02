//! The front of a vehicle that comes toward the camera.
//!
//! What comes out is the drawing of hood, windshield, lights and grille.

use super::paint::{Ink, Painter, rgb};
use super::shape::Shape;
use super::vehicle_end::End;
use super::vehicles::Vehicle;

/// Draws the front of a vehicle that comes toward the camera.
pub(super) fn paint_front(vehicle: &Vehicle, painter: &mut Painter) {
    let build = vehicle.build;
    let (belt_m, top_m, roof_m, hood_m) =
        (build.belt_m, build.glass_top_m, build.roof_m, build.hood_m);
    let body = vehicle.body;
    let mut end = End { vehicle, painter };
    end.fill(
        &Shape::soft(&[
            [-0.97, 0.24, 0.06],
            [-1.0, 0.5, 0.1],
            [-1.0, hood_m, 0.06],
            [-1.0, roof_m, 0.16],
            [1.0, roof_m, 0.16],
            [1.0, hood_m, 0.06],
            [1.0, 0.5, 0.1],
            [0.97, 0.24, 0.06],
        ]),
        Ink::Down3(body.lit(0.25), body.lit(0.05), body.lit(-0.25)),
    );
    // Hood: brighter, because it faces the sky.
    end.fill(
        &Shape::soft(&[
            [-0.88, hood_m - 0.02, 0.04],
            [-0.84, belt_m, 0.02],
            [0.84, belt_m, 0.02],
            [0.88, hood_m - 0.02, 0.04],
        ]),
        Ink::Down(body.lit(0.12), body.lit(0.42)),
    );
    for side in [-0.45, 0.45] {
        end.fill(
            &Shape::rect(side - 0.012, hood_m, side + 0.012, belt_m - 0.02),
            Ink::Flat(body.lit(-0.3).clear(0.5)),
        );
    }
    let glass = Shape::soft(&[
        [-0.93, belt_m + 0.01, 0.06],
        [-0.92, top_m, 0.09],
        [0.92, top_m, 0.09],
        [0.93, belt_m + 0.01, 0.06],
    ]);
    end.fill(
        &glass,
        Ink::Down3(rgb(0x0093_ABC0), rgb(0x003D_4C5A), rgb(0x001C_252E)),
    );
    // Driver and passenger seat behind the glass.
    end.fill(
        &Shape::round_rect(0.30, belt_m + 0.04, 0.62, belt_m + 0.24, 0.1),
        Ink::Flat(rgb(0x0010_161D).clear(0.7)),
    );
    end.fill(
        &Shape::ellipse([0.46, belt_m + 0.23], 0.11, 0.09),
        Ink::Flat(rgb(0x00A8_7C62).clear(0.75)),
    );
    end.fill(
        &Shape::round_rect(-0.60, belt_m + 0.04, -0.32, belt_m + 0.22, 0.1),
        Ink::Flat(rgb(0x0010_161D).clear(0.6)),
    );
    end.glint(-0.8, 0.3, 0.2);
    end.fill(
        &Shape::rect(-0.09, top_m - 0.07, 0.09, top_m - 0.03),
        Ink::Flat(rgb(0x0012_161A)),
    );
    // Head lights, grille, badge.
    end.pair(
        &[
            [0.54, hood_m - 0.15, 0.03],
            [0.56, hood_m - 0.04, 0.04],
            [0.98, hood_m, 0.04],
            [1.0, hood_m - 0.17, 0.06],
        ],
        Ink::Flat(rgb(0x0028_2D33)),
    );
    end.pair(
        &[
            [0.58, hood_m - 0.135, 0.03],
            [0.60, hood_m - 0.05, 0.03],
            [0.95, hood_m - 0.02, 0.03],
            [0.96, hood_m - 0.15, 0.05],
        ],
        Ink::Down(rgb(0x00FF_FFFF), rgb(0x00C2_D2DE)),
    );
    end.fill(
        &Shape::soft(&[
            [-0.50, hood_m - 0.19, 0.03],
            [-0.50, hood_m - 0.06, 0.03],
            [0.50, hood_m - 0.06, 0.03],
            [0.50, hood_m - 0.19, 0.03],
        ]),
        Ink::Flat(rgb(0x0017_1A1E)),
    );
    for bar in 0..3_u8 {
        let up_m = hood_m - 0.165 + 0.04 * f32::from(bar);
        end.fill(
            &Shape::rect(-0.46, up_m, 0.46, up_m + 0.012),
            Ink::Flat(rgb(0x0098_A0A8)),
        );
    }
    end.fill(
        &Shape::disc([0.0, hood_m - 0.115], 0.055),
        Ink::Slant(rgb(0x00FF_FFFF), rgb(0x0090_98A0)),
    );
    // Bumper: intake, fog lights, plate.
    end.fill(
        &Shape::soft(&[
            [-0.72, 0.26, 0.04],
            [-0.66, 0.40, 0.04],
            [0.66, 0.40, 0.04],
            [0.72, 0.26, 0.04],
        ]),
        Ink::Down(rgb(0x001B_1E22), rgb(0x002C_3036)),
    );
    end.pair(
        &[
            [0.76, 0.32, 0.03],
            [0.76, 0.40, 0.03],
            [0.92, 0.40, 0.03],
            [0.92, 0.32, 0.03],
        ],
        Ink::Flat(rgb(0x0023_262B)),
    );
    end.pair(
        &[
            [0.79, 0.335, 0.02],
            [0.79, 0.385, 0.02],
            [0.89, 0.385, 0.02],
            [0.89, 0.335, 0.02],
        ],
        Ink::Flat(rgb(0x00EF_EBD8)),
    );
    end.plate(0.42);
    if let Some(band) = vehicle.band {
        end.fill(&Shape::rect(-0.98, 0.80, 0.98, 0.90), Ink::Flat(band));
    }
    end.mirrors(body, 1.25);
}
