//! Cars and vans as bent panels.
//!
//! What comes out is a vehicle in perspective: its side and its near end are
//! drawn flat, in metres, and then bent over a body whose length, width and
//! slope are known at every height. The ends are drawn in
//! `vehicle_front` and `vehicle_rear`.

use super::bodies::{Build, look_up};
use super::camera::{Point3, point3, shadow_of};
use super::paint::{Ink, Painter, Tint, rgb};
use super::shape::Shape;
use super::vehicle_front::paint_front;
use super::vehicle_rear::paint_rear;

/// A vehicle on the road.
pub(super) struct Vehicle {
    pub(super) build: &'static Build,
    /// Sideways position of its middle line.
    pub(super) right_m: f32,
    /// Distance of its near end.
    pub(super) near_m: f32,
    /// Whether its front is the near end.
    pub(super) oncoming: bool,
    pub(super) body: Tint,
    /// A colored band and a parcel mark along the side, for a delivery van.
    pub(super) band: Option<Tint>,
}

impl Vehicle {
    fn half_width_m(&self, up_m: f32) -> f32 {
        self.build.width_m / 2.0 * look_up(self.build.flank, up_m)
    }

    /// -1 when the camera sees the left flank, 1 when it sees the right one.
    fn seen_side(&self) -> f32 {
        if self.right_m > 0.0 { -1.0 } else { 1.0 }
    }

    /// Bends a drawing of the near end (share of the half width, height).
    pub(super) fn end(&self, [across, up_m]: [f32; 2]) -> Point3 {
        let table = if self.oncoming {
            self.build.front
        } else {
            self.build.rear
        };
        point3(
            self.right_m + across * self.half_width_m(up_m),
            up_m,
            self.near_m + look_up(table, up_m) + 0.16 * (across * across * across * across),
        )
    }

    /// An upright plane across the vehicle, `depth_m` behind its near end
    /// (share of the half width, height).
    pub(super) fn across(&self, depth_m: f32, [across, up_m]: [f32; 2]) -> Point3 {
        point3(
            self.right_m + across * self.build.width_m / 2.0,
            up_m,
            self.near_m + depth_m,
        )
    }

    /// Bends a drawing of the flank (distance from the rear end, height).
    fn flank(&self, [from_rear_m, up_m]: [f32; 2]) -> Point3 {
        let length_m = self.build.length_m;
        let from_near_m = if self.oncoming {
            length_m - from_rear_m
        } else {
            from_rear_m
        };
        let end_m = from_near_m.min(length_m - from_near_m);
        let close = (1.0 - end_m / 0.4).clamp(0.0, 1.0);
        let tuck = 0.07 * (close * close);
        point3(
            self.right_m + self.seen_side() * self.half_width_m(up_m) * (1.0 - tuck),
            up_m,
            self.near_m + from_near_m,
        )
    }

    /// Darkens the road below and beside the vehicle.
    pub(super) fn paint_shadow(&self, painter: &mut Painter) {
        painter.set_distance(self.near_m);
        let half_m = self.build.width_m / 2.0;
        let length_m = self.build.length_m;
        for (spread_m, opacity) in [
            (0.34, 0.05),
            (0.29, 0.06),
            (0.24, 0.07),
            (0.19, 0.08),
            (0.14, 0.09),
            (0.09, 0.10),
            (0.04, 0.11),
            (-0.02, 0.12),
            (-0.08, 0.14),
            (-0.14, 0.16),
        ] {
            let mut shape = Shape::default();
            for step in 0..=4_u8 {
                let up_m = self.build.belt_m * f32::from(step) / 4.0;
                let roof_up_m = self.build.belt_m
                    + (self.build.roof_m - self.build.belt_m) * f32::from(step) / 4.0;
                let inset = 0.12 * f32::from(step) / 4.0;
                for (height_m, half_m, start_m, end_m) in [
                    (up_m, half_m, 0.0, length_m),
                    (
                        roof_up_m,
                        half_m * (1.0 - inset),
                        length_m * inset,
                        length_m * (0.75 - inset),
                    ),
                ] {
                    let shadow = shadow_of(point3(self.right_m, height_m, self.near_m));
                    let (right_m, near_m) = (shadow.right_m, shadow.ahead_m);
                    shape = shape.and(Shape::round_rect(
                        right_m - half_m - spread_m,
                        near_m + start_m - spread_m,
                        right_m + half_m + spread_m,
                        near_m + end_m + spread_m,
                        0.3,
                    ));
                }
            }
            painter.fill(
                &shape,
                Ink::Flat(rgb(0x0010_1424).clear(opacity)),
                &|[x, z]| point3(x, 0.0, z),
            );
        }
    }

    /// Draws the vehicle itself.
    pub(super) fn paint(&self, painter: &mut Painter) {
        painter.set_distance(self.near_m);
        self.paint_underside(painter);
        if (self.right_m).abs() > 0.9 {
            self.paint_flank(painter);
        }
        if self.oncoming {
            paint_front(self, painter);
        } else {
            paint_rear(self, painter);
        }
    }

    fn paint_underside(&self, painter: &mut Painter) {
        let tire = Ink::Across(rgb(0x0034_3639), rgb(0x0014_1517));
        for (depth_m, side) in [(2.9, -1.0), (2.9, 1.0), (0.5, -1.0), (0.5, 1.0)] {
            let shape = Shape::round_rect(side * 0.97, 0.0, side * 0.72, 0.55, 0.05);
            painter.fill(&shape, tire, &|point| self.across(depth_m, point));
        }
        let shape = Shape::rect(-0.85, 0.17, 0.85, 0.4);
        painter.fill(&shape, Ink::Flat(rgb(0x0016_181C)), &|point| {
            self.across(0.35, point)
        });
    }

    fn paint_flank(&self, painter: &mut Painter) {
        let build = self.build;
        // The sun stands to the left: flanks that face left are lit.
        let body = self.body.lit(if self.right_m > 0.0 { 0.06 } else { -0.28 });
        let map = |point: [f32; 2]| self.flank(point);
        let mut outline: Vec<[f32; 3]> = Vec::new();
        for &[up_m, depth_m] in build.rear {
            outline.push([depth_m, up_m, 0.08]);
        }
        for &[up_m, depth_m] in build.front.iter().rev() {
            outline.push([build.length_m - depth_m, up_m, 0.08]);
        }
        let silhouette = Shape::soft(&outline).cut(0.2);
        painter.fill(
            &silhouette,
            Ink::Down3(body.lit(0.35), body, body.lit(-0.4)),
            &map,
        );
        let sill = Shape::rect(0.06, 0.2, build.length_m - 0.1, 0.36).cut(0.3);
        painter.fill(&sill, Ink::Flat(rgb(0x0023_262B)), &map);
        if let Some(band) = self.band {
            let stripe = Shape::polygon(&[
                [0.06, 0.78],
                [0.06, 1.02],
                [3.2, 1.02],
                [4.3, 0.86],
                [4.3, 0.78],
            ])
            .cut(0.3);
            painter.fill(&stripe, Ink::Flat(band.lit(-0.2)), &map);
            let mark = Shape::disc([1.0, 1.65], 0.34);
            painter.fill(&mark, Ink::Flat(band.lit(-0.2)), &map);
            let arrow = Shape::polygon(&[
                [0.8, 1.58],
                [1.02, 1.58],
                [1.02, 1.48],
                [1.22, 1.65],
                [1.02, 1.82],
                [1.02, 1.72],
                [0.8, 1.72],
            ]);
            painter.fill(&arrow, Ink::Flat(rgb(0x00F2_F4F6)), &map);
        }
        let crease = Shape::line(
            &[
                [0.15, build.belt_m - 0.14],
                [build.length_m - 0.5, build.belt_m - 0.2],
            ],
            0.03,
        )
        .cut(0.3);
        painter.fill(&crease, Ink::Flat(body.lit(0.4).clear(0.8)), &map);
        for &glass in build.side_glass {
            let pane = Shape::soft(glass).cut(0.3);
            painter.fill(&pane, Ink::Down(rgb(0x0070_8496), rgb(0x001B_242E)), &map);
        }
        for &door_m in build.doors_m {
            let gap = Shape::rect(door_m, 0.34, door_m + 0.02, build.belt_m);
            painter.fill(&gap, Ink::Flat(body.lit(-0.6).clear(0.8)), &map);
            let handle = Shape::round_rect(
                door_m + 0.08,
                build.belt_m - 0.13,
                door_m + 0.3,
                build.belt_m - 0.09,
                0.02,
            );
            painter.fill(&handle, Ink::Flat(body.lit(-0.45)), &map);
        }
        for (from_m, to_m, tint) in [
            (0.03, 0.28, rgb(0x00B8_1E22)),
            (
                build.length_m - 0.5,
                build.length_m - 0.08,
                rgb(0x00E6_EEF4),
            ),
        ] {
            let lamp = Shape::soft(&[
                [from_m, build.hood_m - 0.17, 0.03],
                [from_m, build.hood_m - 0.02, 0.03],
                [to_m, build.hood_m - 0.02, 0.03],
                [to_m, build.hood_m - 0.17, 0.03],
            ]);
            painter.fill(&lamp, Ink::Flat(tint), &map);
        }
        for axle_m in [build.rear_axle_m, build.front_axle_m] {
            self.paint_wheel(painter, axle_m);
        }
    }

    fn paint_wheel(&self, painter: &mut Painter, axle_m: f32) {
        let radius_m = self.build.wheel_radius_m;
        let hub = [axle_m, radius_m];
        // Wheels stand upright at the widest part of the flank.
        let map = |[from_rear_m, up_m]: [f32; 2]| {
            let foot = self.flank([from_rear_m, 0.6]);
            point3(foot.right_m, up_m, foot.ahead_m)
        };
        let arch = Shape::disc([axle_m, radius_m + 0.03], radius_m + 0.06);
        painter.fill(&arch, Ink::Flat(rgb(0x0012_1418)), &map);
        painter.fill(
            &Shape::disc(hub, radius_m),
            Ink::Down(rgb(0x0030_3236), rgb(0x001A_1B1E)),
            &map,
        );
        painter.fill(
            &Shape::disc(hub, radius_m * 0.70),
            Ink::Slant(rgb(0x00DD_E1E5), rgb(0x0084_8A92)),
            &map,
        );
        for spoke in 0..5_u8 {
            let angle_rad = f32::from(spoke) * std::f32::consts::TAU / 5.0 + 0.3;
            let reach = |angle_rad: f32, share: f32| {
                [
                    hub[0] + libm::cosf(angle_rad) * radius_m * share,
                    hub[1] + libm::sinf(angle_rad) * radius_m * share,
                ]
            };
            let hole = Shape::polygon(&[
                reach(angle_rad, 0.22),
                reach(angle_rad + 0.4, 0.6),
                reach(angle_rad, 0.64),
                reach(angle_rad - 0.4, 0.6),
            ]);
            painter.fill(&hole, Ink::Flat(rgb(0x002B_2E33)), &map);
        }
        painter.fill(
            &Shape::disc(hub, radius_m * 0.14),
            Ink::Flat(rgb(0x00B9_BEC4)),
            &map,
        );
    }
}
