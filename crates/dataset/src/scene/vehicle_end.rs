//! What the front and the rear of a vehicle have in common.
//!
//! What comes out is a surface to draw on in (share of the half width, height
//! in metres), bent over the body by [`Vehicle::end`], and the parts that both
//! ends carry: plate, mirrors and reflections.

use super::paint::{Ink, Painter, Tint, rgb};
use super::shape::Shape;
use super::vehicles::Vehicle;

/// A drawing surface over the near end of a vehicle.
pub(super) struct End<'a> {
    pub(super) vehicle: &'a Vehicle,
    pub(super) painter: &'a mut Painter,
}

impl End<'_> {
    /// Fills an outline bent over the end.
    pub(super) fn fill(&mut self, shape: &Shape, ink: Ink) {
        let vehicle = self.vehicle;
        self.painter
            .fill(&shape.cut(0.12), ink, &|point| vehicle.end(point));
    }

    /// The same outline on both sides of the middle line.
    pub(super) fn pair(&mut self, corners: &[[f32; 3]], ink: Ink) {
        for side in [-1.0, 1.0] {
            let mirrored: Vec<[f32; 3]> =
                corners.iter().map(|c| [c[0] * side, c[1], c[2]]).collect();
            self.fill(&Shape::soft(&mirrored), ink);
        }
    }

    /// Draws a licence plate above a height.
    pub(super) fn plate(&mut self, bottom_m: f32) {
        let top_m = bottom_m + 0.115;
        self.fill(
            &Shape::round_rect(-0.30, bottom_m - 0.012, 0.30, top_m + 0.012, 0.02),
            Ink::Flat(rgb(0x0022_2427)),
        );
        self.fill(
            &Shape::rect(-0.28, bottom_m, 0.28, top_m),
            Ink::Flat(rgb(0x00F4_F4EE)),
        );
        self.fill(
            &Shape::rect(-0.28, bottom_m, -0.235, top_m),
            Ink::Flat(rgb(0x0024_4BA8)),
        );
        // Letters too small to be read: bars of a letter's width.
        for (from, width) in [
            (-0.20, 0.05),
            (-0.13, 0.05),
            (-0.04, 0.05),
            (0.03, 0.05),
            (0.10, 0.04),
            (0.16, 0.05),
            (0.225, 0.03),
        ] {
            self.fill(
                &Shape::rect(from, bottom_m + 0.03, from + width, top_m - 0.028),
                Ink::Flat(rgb(0x002A_2C30).clear(0.9)),
            );
        }
    }

    /// Draws both outside mirrors, so far behind the end.
    pub(super) fn mirrors(&mut self, body: Tint, depth_m: f32) {
        let belt_m = self.vehicle.build.belt_m;
        let vehicle = self.vehicle;
        for side in [-1.0, 1.0] {
            let shape = Shape::soft(&[
                [side * 0.93, belt_m, 0.03],
                [side * 0.97, belt_m + 0.14, 0.05],
                [side * 1.15, belt_m + 0.15, 0.05],
                [side * 1.17, belt_m + 0.02, 0.05],
            ]);
            self.painter.fill(
                &shape,
                Ink::Down(body.lit(0.15), body.lit(-0.5)),
                &|point| vehicle.across(depth_m, point),
            );
        }
    }

    /// A sky reflection that slants over a window.
    pub(super) fn glint(&mut self, from: f32, width: f32, lean: f32) {
        let (low_m, high_m) = (
            self.vehicle.build.belt_m + 0.04,
            self.vehicle.build.glass_top_m - 0.03,
        );
        let shape = Shape::polygon(&[
            [from, low_m],
            [from + lean, high_m],
            [from + lean + width, high_m],
            [from + width, low_m],
        ]);
        self.fill(
            &shape,
            Ink::Down(rgb(0x00EA_F4FF).clear(0.34), rgb(0x00EA_F4FF).clear(0.05)),
        );
    }
}
