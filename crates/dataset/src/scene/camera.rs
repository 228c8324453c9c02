//! The pinhole camera of the drawn scene: metres in, pixels out.
//!
//! What comes out is where a point of the street falls in the picture, and
//! where the shadow of that point falls on the ground.

/// Picture width in pixels, the width of a rectified KITTI frame.
pub(super) const WIDTH_PX: u32 = 1242;
/// Picture height in pixels, the height of a rectified KITTI frame.
pub(super) const HEIGHT_PX: u32 = 375;

const FOCAL_LENGTH_PX: f32 = 721.5;
/// Where the optical axis meets the picture; its second value is the horizon.
pub(super) const PRINCIPAL_POINT_PX: [f32; 2] = [609.6, 172.9];
const CAMERA_HEIGHT_M: f32 = 1.65;
/// Points nearer than this are pushed out to it, so that no division blows up.
const NEAR_LIMIT_M: f32 = 1.0;

/// How far the shadow of a point one metre up moves to the right on the ground.
const SHADOW_RIGHT_PER_M: f32 = 0.90;
/// How far the same shadow moves away from the camera.
const SHADOW_AWAY_PER_M: f32 = 0.80;

/// A point of the street: metres to the right of the camera, metres above the
/// ground, metres in front of the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point3 {
    pub(super) right_m: f32,
    pub(super) up_m: f32,
    pub(super) ahead_m: f32,
}

/// A street point from its three distances, in the order right, up, ahead.
pub(super) const fn point3(right_m: f32, up_m: f32, ahead_m: f32) -> Point3 {
    Point3 {
        right_m,
        up_m,
        ahead_m,
    }
}

/// Where a street point falls in the picture, in pixels.
pub(super) fn project(point: Point3) -> [f32; 2] {
    let scale_px_per_m = pixels_per_metre(point.ahead_m);
    [
        PRINCIPAL_POINT_PX[0] + scale_px_per_m * point.right_m,
        PRINCIPAL_POINT_PX[1] + scale_px_per_m * (CAMERA_HEIGHT_M - point.up_m),
    ]
}

/// How many pixels one metre across spans at a distance.
pub(super) fn pixels_per_metre(ahead_m: f32) -> f32 {
    FOCAL_LENGTH_PX / ahead_m.max(NEAR_LIMIT_M)
}

/// The ground point that the sun hides behind a street point.
///
/// The sun stands high, behind the camera and to its left.
pub(super) fn shadow_of(point: Point3) -> Point3 {
    point3(
        point.right_m + SHADOW_RIGHT_PER_M * point.up_m,
        0.0,
        point.ahead_m + SHADOW_AWAY_PER_M * point.up_m,
    )
}

/// A flat upright drawing board in the street, on which people, bicycles and
/// signs are drawn in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Board {
    /// The street point of the board's origin.
    pub(super) foot: Point3,
    /// Rotation of the board about the vertical, 0 when it faces the camera.
    pub(super) yaw_rad: f32,
    /// 1, or -1 to mirror the drawing.
    pub(super) mirror: f32,
}

impl Board {
    /// A board that faces the camera, standing at a ground point.
    pub(super) const fn facing(right_m: f32, ahead_m: f32) -> Self {
        Self {
            foot: point3(right_m, 0.0, ahead_m),
            yaw_rad: 0.0,
            mirror: 1.0,
        }
    }

    /// The street point of a point on the board (metres across, metres up).
    pub(super) fn at(&self, [across_m, up_m]: [f32; 2]) -> Point3 {
        let across_m = across_m * self.mirror;
        point3(
            self.foot.right_m + across_m * libm::cosf(self.yaw_rad),
            self.foot.up_m + up_m,
            self.foot.ahead_m + across_m * libm::sinf(self.yaw_rad),
        )
    }
}
