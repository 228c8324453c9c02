//! Windows and shops on the facades of houses.
//!
//! What comes out is the detail of a facade, drawn in (metres along it from
//! its near end, height); far houses get less of it than near ones.

use super::buildings::House;
use super::camera::{PRINCIPAL_POINT_PX, point3, project};
use super::paint::{Ink, Painter, Tint, rgb};
use super::shape::Shape;

const WINDOW_PITCH_M: f32 = 2.4;
/// Houses beyond this are a few pixels wide: their windows stay plain.
const DETAIL_LIMIT_M: f32 = 32.0;

impl House {
    /// Whether a stretch of the facade falls near the picture at all.
    fn is_seen(&self, along_m: f32, up_m: f32) -> bool {
        let [x_px, y_px] = project(point3(self.facade_m, up_m, self.start_m + along_m));
        let [width_px, _] = PRINCIPAL_POINT_PX.map(|middle_px| middle_px * 2.0);
        x_px > -250.0 && x_px < width_px + 250.0 && y_px > -20.0
    }

    /// Draws a row of windows over a sill height.
    pub(super) fn paint_windows(&self, painter: &mut Painter, sill_m: f32, light: f32) {
        let length_m = self.end_m - self.start_m;
        let mut along_m = 0.8;
        let mut odd = false;
        while along_m + 1.2 < length_m {
            if self.is_seen(along_m + 0.6, sill_m) {
                self.paint_window(painter, [along_m, sill_m], light, odd);
            }
            odd = !odd;
            along_m += WINDOW_PITCH_M;
        }
    }

    fn paint_window(&self, painter: &mut Painter, [a, s]: [f32; 2], light: f32, curtain: bool) {
        let trim = rgb(0x00F3_EEE4).lit(light);
        self.fill(
            painter,
            &Shape::rect(a - 0.13, s - 0.08, a + 1.33, s + 1.72),
            Ink::Flat(trim),
        );
        self.fill(
            painter,
            &Shape::rect(a, s, a + 1.2, s + 1.6),
            Ink::Down(rgb(0x0086_A2BA).lit(light), rgb(0x002E_3B4A)),
        );
        if self.start_m > DETAIL_LIMIT_M {
            return;
        }
        if curtain {
            self.fill(
                painter,
                &Shape::polygon(&[[a, s], [a, s + 1.6], [a + 0.5, s + 1.6], [a + 0.28, s]]),
                Ink::Flat(rgb(0x00E6_E2D8).lit(light - 0.1).clear(0.75)),
            );
            self.fill(
                painter,
                &Shape::polygon(&[
                    [a + 1.2, s],
                    [a + 1.2, s + 1.6],
                    [a + 0.8, s + 1.6],
                    [a + 0.95, s],
                ]),
                Ink::Flat(rgb(0x00E6_E2D8).lit(light - 0.1).clear(0.75)),
            );
        } else {
            self.fill(
                painter,
                &Shape::polygon(&[
                    [a + 0.1, s],
                    [a + 0.7, s + 1.6],
                    [a + 1.0, s + 1.6],
                    [a + 0.4, s],
                ]),
                Ink::Flat(rgb(0x00D8_E8F6).clear(0.28)),
            );
        }
        // Shade of the lintel and of the near jamb, then sash bars and sill.
        self.fill(
            painter,
            &Shape::rect(a, s + 1.42, a + 1.2, s + 1.6),
            Ink::Flat(rgb(0x0014_1A26).clear(0.5)),
        );
        self.fill(
            painter,
            &Shape::rect(a, s, a + 0.1, s + 1.6),
            Ink::Flat(rgb(0x0014_1A26).clear(0.45)),
        );
        self.fill(
            painter,
            &Shape::rect(a + 0.56, s, a + 0.64, s + 1.6),
            Ink::Flat(trim),
        );
        self.fill(
            painter,
            &Shape::rect(a, s + 1.0, a + 1.2, s + 1.07),
            Ink::Flat(trim),
        );
        self.fill_out(
            painter,
            &Shape::rect(a - 0.18, s - 0.14, a + 1.38, s - 0.02),
            Ink::Flat(trim.lit(0.2)),
            0.14,
        );
    }

    /// Draws the shop on the ground floor.
    pub(super) fn paint_shop(&self, painter: &mut Painter, awning: Tint, light: f32) {
        let length_m = self.end_m - self.start_m;
        let frame = awning.lit(-0.45);
        self.fill(
            painter,
            &Shape::rect(0.4, 0.0, length_m - 0.4, 3.3),
            Ink::Flat(frame),
        );
        self.fill(
            painter,
            &Shape::rect(0.4, 2.75, length_m - 0.4, 3.3),
            Ink::Down(awning.lit(light), awning.lit(light - 0.2)),
        );
        let mut along_m = 0.7;
        let mut pane = 0_u8;
        while along_m + 1.9 < length_m {
            let door = pane % 3 == 1;
            let low_m = if door { 0.1 } else { 0.7 };
            let width_m = if door { 1.1 } else { 2.1 };
            if self.is_seen(along_m + 1.0, low_m) {
                self.fill(
                    painter,
                    &Shape::rect(along_m, low_m, along_m + width_m, 2.6),
                    Ink::Down(rgb(0x0050_6474), rgb(0x0026_303A)),
                );
                if !door && self.start_m < DETAIL_LIMIT_M {
                    self.paint_goods(painter, along_m, pane);
                }
                if self.start_m < DETAIL_LIMIT_M {
                    self.fill(
                        painter,
                        &Shape::polygon(&[
                            [along_m + 0.1, low_m],
                            [along_m + 0.5, 2.6],
                            [along_m + 0.9, 2.6],
                            [along_m + 0.5, low_m],
                        ]),
                        Ink::Flat(rgb(0x00E4_F0FA).clear(0.25)),
                    );
                }
            }
            along_m += width_m + 0.25;
            pane += 1;
        }
        self.paint_awning(painter, awning.lit(light));
    }

    /// Potted plants, vases and parcels behind a shop window.
    fn paint_goods(&self, painter: &mut Painter, from_m: f32, pane: u8) {
        let shelf = Shape::rect(from_m, 0.7, from_m + 2.1, 0.8);
        self.fill(painter, &shelf, Ink::Flat(rgb(0x00B8_9470)));
        for item in 0..4_u8 {
            let kind = (item * 3 + pane) % 4;
            let tint = [
                rgb(0x00D8_8A5A),
                rgb(0x0086_B4B0),
                rgb(0x00E4_DCC8),
                rgb(0x00D9_A548),
            ][usize::from((item + pane) % 4)]
            .lit(-0.12);
            let middle_m = from_m + 0.3 + 0.5 * f32::from(item);
            if kind.is_multiple_of(2) {
                let pot = Shape::polygon(&[
                    [middle_m - 0.10, 0.8],
                    [middle_m - 0.14, 1.02],
                    [middle_m + 0.14, 1.02],
                    [middle_m + 0.10, 0.8],
                ]);
                self.fill(painter, &pot, Ink::Flat(tint));
                for (across_m, up_m, radius_m) in
                    [(-0.09, 1.14, 0.12), (0.10, 1.16, 0.12), (0.0, 1.28, 0.14)]
                {
                    self.fill(
                        painter,
                        &Shape::disc([middle_m + across_m, up_m], radius_m),
                        Ink::Slant(rgb(0x008C_BE5C), rgb(0x003A_6A3A)),
                    );
                }
            } else if kind == 1 {
                let vase = Shape::smooth(&[
                    [middle_m - 0.09, 0.8],
                    [middle_m - 0.16, 1.0],
                    [middle_m - 0.05, 1.22],
                    [middle_m - 0.07, 1.34],
                    [middle_m + 0.07, 1.34],
                    [middle_m + 0.05, 1.22],
                    [middle_m + 0.16, 1.0],
                    [middle_m + 0.09, 0.8],
                ]);
                self.fill(painter, &vase, Ink::Across(tint.lit(0.3), tint.lit(-0.3)));
            } else {
                for (half_m, low_m, high_m, light) in
                    [(0.19, 0.8, 1.06, 0.0), (0.14, 1.06, 1.26, 0.15)]
                {
                    self.fill(
                        painter,
                        &Shape::rect(middle_m - half_m, low_m, middle_m + half_m, high_m),
                        Ink::Flat(tint.lit(light)),
                    );
                }
            }
        }
    }

    /// A striped cloth that slopes out over the sidewalk.
    fn paint_awning(&self, painter: &mut Painter, tint: Tint) {
        let length_m = self.end_m - self.start_m - 1.0;
        let stripes = if self.start_m > DETAIL_LIMIT_M {
            8_u8
        } else {
            16
        };
        let pitch_m = length_m / f32::from(stripes);
        let shade = Shape::rect(0.5, 2.0, 0.5 + length_m, 2.8);
        self.fill(painter, &shade, Ink::Flat(rgb(0x0010_1420).clear(0.4)));
        for stripe in 0..stripes {
            let from_m = 0.5 + pitch_m * f32::from(stripe);
            let cloth = if stripe % 2 == 0 {
                tint
            } else {
                rgb(0x00F4_EFE4).lit(-0.02)
            };
            let slope = Shape::rect(from_m, 0.0, from_m + pitch_m, 1.0);
            painter.fill(
                &slope,
                Ink::Down(cloth.lit(0.12), cloth.lit(-0.06)),
                &|[along, out]| {
                    point3(
                        self.facade_m - self.side * out * 1.2,
                        3.05 - 0.65 * out,
                        self.start_m + along,
                    )
                },
            );
            let flap = Shape::soft(&[
                [from_m, 2.42, 0.0],
                [from_m + pitch_m, 2.42, 0.0],
                [from_m + pitch_m, 2.16, 0.14],
                [from_m, 2.16, 0.14],
            ]);
            self.fill_out(painter, &flap, Ink::Flat(cloth.lit(-0.18)), 1.2);
        }
    }
}
