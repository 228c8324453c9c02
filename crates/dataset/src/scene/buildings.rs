//! Houses along the street.
//!
//! What comes out is a row of facades in perspective with windows, shops,
//! awnings, roofs and the gable that faces the camera.

use super::camera::{point3, shadow_of};
use super::paint::{Ink, Painter, rgb};
use super::shape::Shape;

/// One house; its facade runs along the street.
pub(super) struct House {
    /// -1 on the left of the street, 1 on the right.
    pub(super) side: f32,
    pub(super) facade_m: f32,
    pub(super) start_m: f32,
    pub(super) end_m: f32,
    pub(super) eave_m: f32,
    pub(super) wall_hex: u32,
    pub(super) roof_hex: u32,
    /// Awning color of a shop on the ground floor.
    pub(super) shop_hex: Option<u32>,
}

const fn house(
    side: f32,
    start_m: f32,
    end_m: f32,
    eave_m: f32,
    wall_hex: u32,
    roof_hex: u32,
    shop_hex: Option<u32>,
) -> House {
    let facade_m = if side < 0.0 { -10.6 } else { 9.9 };
    House {
        side,
        facade_m,
        start_m,
        end_m,
        eave_m,
        wall_hex,
        roof_hex,
        shop_hex,
    }
}

/// Sorted from far to near on each side, so that nearer houses cover others.
const HOUSES: [House; 13] = [
    house(-1.0, 108.0, 150.0, 9.0, 0x00C9_B8A2, 0x0080_5A4C, None),
    house(-1.0, 84.0, 106.0, 11.0, 0x00B9_AFA6, 0x0062_5650, None),
    house(
        -1.0,
        66.0,
        82.0,
        8.2,
        0x00C7_8F6C,
        0x006A_4A40,
        Some(0x002B_6E8C),
    ),
    house(
        -1.0,
        50.0,
        66.0,
        10.0,
        0x00D9_CDB4,
        0x0076_4F42,
        Some(0x00A8_3A32),
    ),
    house(-1.0, 40.0, 50.0, 7.6, 0x00AE_6F56, 0x0058_4A48, None),
    house(
        -1.0,
        29.0,
        40.0,
        6.3,
        0x00EA_D9B2,
        0x0096_5240,
        Some(0x0034_7A54),
    ),
    house(1.0, 110.0, 150.0, 10.0, 0x00CF_C0AC, 0x0078_5A4E, None),
    house(1.0, 86.0, 108.0, 8.6, 0x00D5_B79A, 0x006C_5048, None),
    house(1.0, 66.0, 84.0, 11.0, 0x00B8_7B60, 0x0060_4C48, None),
    house(
        1.0,
        48.0,
        64.0,
        8.4,
        0x00E3_D6BC,
        0x0088_5444,
        Some(0x002E_5F9A),
    ),
    house(
        1.0,
        34.0,
        48.0,
        10.4,
        0x00C4_9A7C,
        0x0060_4A46,
        Some(0x0086_3048),
    ),
    house(
        1.0,
        21.0,
        34.0,
        8.0,
        0x00BF_6F54,
        0x005C_4644,
        Some(0x00E0_B23C),
    ),
    house(
        1.0,
        6.0,
        21.0,
        11.5,
        0x00EE_DFC0,
        0x0070_4C44,
        Some(0x00C2_3A34),
    ),
];

const FLOOR_M: f32 = 3.1;
const GROUND_FLOOR_M: f32 = 3.5;
const GABLE_DEPTH_M: f32 = 7.0;
const RIDGE_RISE_M: f32 = 2.3;

/// Draws all houses.
pub(super) fn paint_houses(painter: &mut Painter) {
    for house in &HOUSES {
        house.paint(painter);
    }
}

/// Throws the shade of the houses on the left over the ground.
pub(super) fn paint_house_shadows(painter: &mut Painter) {
    for house in HOUSES.iter().filter(|house| house.side < 0.0) {
        painter.set_distance(house.start_m);
        let [near, far] = [house.start_m, house.end_m]
            .map(|ahead_m| shadow_of(point3(house.facade_m, house.eave_m, ahead_m)));
        let shade = Shape::polygon(&[
            [house.facade_m, house.start_m],
            [near.right_m, near.ahead_m],
            [far.right_m, far.ahead_m],
            [house.facade_m, house.end_m],
        ]);
        painter.fill(
            &shade,
            Ink::Flat(rgb(0x0018_2038).clear(0.34)),
            &|[x, z]| point3(x, 0.0, z),
        );
    }
}

impl House {
    /// Draws on the facade: (metres along it from its near end, height).
    pub(super) fn fill(&self, painter: &mut Painter, shape: &Shape, ink: Ink) {
        self.fill_out(painter, shape, ink, 0.0);
    }

    /// Draws on a plane in front of the facade by `out_m`.
    pub(super) fn fill_out(&self, painter: &mut Painter, shape: &Shape, ink: Ink, out_m: f32) {
        painter.fill(shape, ink, &|[along, up]| {
            point3(self.facade_m - self.side * out_m, up, self.start_m + along)
        });
    }

    fn paint(&self, painter: &mut Painter) {
        painter.set_distance((self.start_m + self.end_m) / 2.0);
        let length_m = self.end_m - self.start_m;
        // The sun stands on the left: facades on the right are lit.
        let light = if self.side > 0.0 { 0.08 } else { -0.26 };
        let wall = rgb(self.wall_hex).lit(light);
        let roof = rgb(self.roof_hex).lit(light);
        let slope = Shape::polygon(&[[0.0, 0.0], [length_m, 0.0], [length_m, 1.0], [0.0, 1.0]]);
        painter.fill(&slope, Ink::Down(roof.lit(0.16), roof), &|[along, rise]| {
            point3(
                self.facade_m + self.side * (rise * GABLE_DEPTH_M / 2.0 - 0.3),
                self.eave_m + rise * RIDGE_RISE_M,
                self.start_m + along,
            )
        });
        self.fill(
            painter,
            &Shape::rect(0.0, 0.0, length_m, self.eave_m),
            Ink::Down(wall.lit(0.10), wall.lit(-0.10)),
        );
        self.fill(
            painter,
            &Shape::rect(0.0, 0.0, length_m, 0.5),
            Ink::Flat(wall.lit(-0.3)),
        );
        let mut floor_m = GROUND_FLOOR_M;
        while floor_m + 2.4 < self.eave_m {
            self.fill(
                painter,
                &Shape::rect(0.0, floor_m, length_m, floor_m + 0.16),
                Ink::Flat(wall.lit(0.3)),
            );
            self.paint_windows(painter, floor_m + 0.85, light);
            floor_m += FLOOR_M;
        }
        self.fill(
            painter,
            &Shape::rect(0.0, self.eave_m - 0.9, length_m, self.eave_m - 0.3),
            Ink::Down(wall.lit(-0.4), wall),
        );
        self.fill_out(
            painter,
            &Shape::rect(-0.2, self.eave_m - 0.3, length_m, self.eave_m),
            Ink::Flat(rgb(0x00E8_E2D6).lit(light)),
            0.3,
        );
        match self.shop_hex {
            Some(hex) => self.paint_shop(painter, rgb(hex), light),
            None => self.paint_windows(painter, 1.0, light),
        }
        self.paint_gable(painter);
    }

    /// The end wall that faces the camera, with its two windows.
    fn paint_gable(&self, painter: &mut Painter) {
        let wall = rgb(self.wall_hex).lit(0.02);
        let map =
            |[inward, up]: [f32; 2]| point3(self.facade_m + self.side * inward, up, self.start_m);
        let half_m = GABLE_DEPTH_M / 2.0;
        let outline = Shape::polygon(&[
            [0.0, 0.0],
            [0.0, self.eave_m],
            [half_m, self.eave_m + RIDGE_RISE_M],
            [GABLE_DEPTH_M, self.eave_m],
            [GABLE_DEPTH_M, 0.0],
        ]);
        painter.fill(&outline, Ink::Down(wall.lit(0.18), wall.lit(-0.08)), &map);
        let verge = Shape::line(
            &[
                [-0.35, self.eave_m - 0.18],
                [half_m, self.eave_m + RIDGE_RISE_M + 0.06],
                [GABLE_DEPTH_M + 0.35, self.eave_m - 0.18],
            ],
            0.26,
        );
        painter.fill(&verge, Ink::Flat(rgb(self.roof_hex).lit(0.1)), &map);
        if self.side > 0.0 {
            return;
        }
        for (from_m, sill_m) in [(1.1, 4.0), (4.5, 4.0), (1.1, 1.1), (4.5, 1.1)] {
            painter.fill(
                &Shape::rect(from_m - 0.12, sill_m - 0.1, from_m + 1.32, sill_m + 1.6),
                Ink::Flat(rgb(0x00FA_F6EC)),
                &map,
            );
            painter.fill(
                &Shape::rect(from_m, sill_m, from_m + 1.2, sill_m + 1.48),
                Ink::Down(rgb(0x009C_BCD6), rgb(0x003C_4C5E)),
                &map,
            );
            painter.fill(
                &Shape::rect(from_m + 0.56, sill_m, from_m + 0.64, sill_m + 1.48),
                Ink::Flat(rgb(0x00FA_F6EC)),
                &map,
            );
            for shutter_m in [from_m - 0.62, from_m + 1.34] {
                painter.fill(
                    &Shape::rect(shutter_m, sill_m - 0.05, shutter_m + 0.48, sill_m + 1.55),
                    Ink::Across(rgb(0x004E_7F6A), rgb(0x003C_6654)),
                    &map,
                );
            }
        }
    }
}
