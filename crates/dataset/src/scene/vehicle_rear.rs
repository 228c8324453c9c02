//! The rear of a vehicle that drives ahead or is parked.
//!
//! What comes out is the drawing of tailgate, window, lights and bumper.

use super::paint::{Ink, Painter, rgb};
use super::shape::Shape;
use super::vehicle_end::End;
use super::vehicles::Vehicle;

/// Draws the rear of a vehicle that drives ahead or is parked.
pub(super) fn paint_rear(vehicle: &Vehicle, painter: &mut Painter) {
    let build = vehicle.build;
    let (belt_m, top_m, roof_m) = (build.belt_m, build.glass_top_m, build.roof_m);
    let body = vehicle.body;
    let mut end = End { vehicle, painter };
    end.mirrors(body, 2.3);
    // Roof fin, then the whole end in body color: lit above, dark below.
    end.fill(
        &Shape::polygon(&[
            [-0.03, roof_m - 0.02],
            [-0.012, roof_m + 0.07],
            [0.03, roof_m - 0.02],
        ]),
        Ink::Flat(body.lit(-0.5)),
    );
    end.fill(
        &Shape::soft(&[
            [-0.98, 0.26, 0.06],
            [-1.0, 0.6, 0.1],
            [-1.0, belt_m, 0.1],
            [-1.0, roof_m, 0.16],
            [1.0, roof_m, 0.16],
            [1.0, belt_m, 0.1],
            [1.0, 0.6, 0.1],
            [0.98, 0.26, 0.06],
        ]),
        Ink::Down3(body.lit(0.18), body, body.lit(-0.35)),
    );
    end.fill(
        &Shape::soft(&[
            [-0.8, roof_m - 0.035, 0.02],
            [0.8, roof_m - 0.035, 0.02],
            [0.88, top_m + 0.0, 0.03],
            [-0.88, top_m + 0.0, 0.03],
        ]),
        Ink::Across(body.lit(0.55), body.lit(0.2)),
    );
    // The corners turn away from the camera: lit on the left, dark on the right.
    let (low_m, high_m) = (0.27, belt_m);
    end.fill(
        &Shape::rect(-0.995, low_m, -0.80, high_m),
        Ink::Across(body.lit(0.5).clear(0.55), body.lit(0.3).clear(0.0)),
    );
    end.fill(
        &Shape::rect(0.74, low_m, 0.995, high_m),
        Ink::Across(body.lit(-0.6).clear(0.0), body.lit(-0.6).clear(0.6)),
    );
    end.fill(
        &Shape::rect(-0.93, belt_m - 0.035, 0.93, belt_m + 0.015),
        Ink::Flat(body.lit(-0.4).clear(0.8)),
    );
    // Rear window with head rests and a slanted reflection.
    let glass = Shape::soft(&[
        [-0.90, belt_m + 0.01, 0.06],
        [-0.89, top_m - 0.01, 0.09],
        [0.89, top_m - 0.01, 0.09],
        [0.90, belt_m + 0.01, 0.06],
    ]);
    end.fill(&glass, Ink::Down(rgb(0x0059_6B7C), rgb(0x001A_222B)));
    for seat in [-0.42, 0.42] {
        end.fill(
            &Shape::round_rect(seat - 0.14, belt_m + 0.05, seat + 0.14, belt_m + 0.20, 0.05),
            Ink::Flat(rgb(0x000E_1318).clear(0.75)),
        );
    }
    end.glint(-0.72, 0.34, 0.16);
    end.glint(-0.26, 0.10, 0.14);
    end.fill(
        &Shape::rect(-0.3, top_m - 0.035, 0.3, top_m - 0.012),
        Ink::Flat(rgb(0x00E0_2A2A)),
    );
    end.fill(
        &Shape::line(
            &[
                [0.0, belt_m + 0.02],
                [-0.05, belt_m + 0.06],
                [-0.5, belt_m + 0.10],
            ],
            0.018,
        ),
        Ink::Flat(rgb(0x000A_0C0E)),
    );
    // Tailgate: gap lines, pressed edge, chrome strip.
    let shade = body.lit(-0.55).clear(0.75);
    end.pair(
        &[
            [0.60, 0.57, 0.0],
            [0.62, 0.57, 0.0],
            [0.66, belt_m - 0.03, 0.0],
            [0.64, belt_m - 0.03, 0.0],
        ],
        Ink::Flat(shade),
    );
    end.fill(&Shape::rect(-0.99, 0.565, 0.99, 0.58), Ink::Flat(shade));
    end.fill(
        &Shape::rect(-0.62, belt_m - 0.075, 0.62, belt_m - 0.045),
        Ink::Flat(body.lit(0.45)),
    );
    end.fill(
        &Shape::rect(-0.62, belt_m - 0.21, 0.62, belt_m - 0.19),
        Ink::Flat(shade),
    );
    // The sky mirrors softly in the tailgate, on the side of the sun.
    let gleam = rgb(0x00FF_FFFF);
    end.fill(
        &Shape::ellipse([-0.30, belt_m - 0.20], 0.42, 0.15),
        Ink::Glow(gleam.clear(0.26), gleam.clear(0.0)),
    );
    // Tail lights in three parts.
    let (low_m, high_m) = (belt_m - 0.25, belt_m - 0.04);
    end.pair(
        &[
            [0.60, low_m + 0.05, 0.03],
            [0.64, high_m, 0.04],
            [1.0, high_m + 0.02, 0.06],
            [1.0, low_m, 0.06],
        ],
        Ink::Down(rgb(0x00E2_2B2B), rgb(0x008C_0D16)),
    );
    end.pair(
        &[
            [0.68, low_m + 0.085, 0.02],
            [0.70, high_m - 0.07, 0.02],
            [0.95, high_m - 0.065, 0.03],
            [0.95, low_m + 0.07, 0.03],
        ],
        Ink::Across(rgb(0x00FF_7A66), rgb(0x00FF_5B4C)),
    );
    end.pair(
        &[
            [0.64, low_m + 0.055, 0.01],
            [0.64, low_m + 0.08, 0.01],
            [0.80, low_m + 0.07, 0.01],
            [0.80, low_m + 0.04, 0.01],
        ],
        Ink::Flat(rgb(0x00F6_EFE4)),
    );
    end.fill(
        &Shape::disc([0.0, belt_m - 0.135], 0.04),
        Ink::Slant(rgb(0x00F4_F6F8), rgb(0x0090_98A0)),
    );
    end.plate(0.60);
    // Bumper with its dark lower part, reflectors and exhaust.
    end.fill(
        &Shape::rect(-0.98, 0.525, 0.98, 0.55),
        Ink::Across(body.lit(0.5).clear(0.8), body.lit(0.1).clear(0.8)),
    );
    end.fill(
        &Shape::soft(&[
            [-0.97, 0.25, 0.05],
            [-0.98, 0.40, 0.03],
            [-0.72, 0.44, 0.06],
            [0.72, 0.44, 0.06],
            [0.98, 0.40, 0.03],
            [0.97, 0.25, 0.05],
        ]),
        Ink::Down(rgb(0x0036_3A40), rgb(0x0018_1A1E)),
    );
    end.pair(
        &[
            [0.74, 0.36, 0.01],
            [0.74, 0.39, 0.01],
            [0.94, 0.385, 0.01],
            [0.94, 0.355, 0.01],
        ],
        Ink::Flat(rgb(0x00B4_2020)),
    );
    end.fill(
        &Shape::round_rect(0.46, 0.26, 0.62, 0.32, 0.03),
        Ink::Flat(rgb(0x00A9_AFB5)),
    );
    end.fill(
        &Shape::round_rect(0.48, 0.27, 0.60, 0.31, 0.02),
        Ink::Flat(rgb(0x0012_1416)),
    );
}
