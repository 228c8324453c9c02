//! What stands where in the street.
//!
//! What comes out is the list of things to draw, each with its distance, its
//! class name if it is labelled, and the calls that draw it.

use rand_chacha::ChaCha8Rng;

use super::bodies::{HATCHBACK, SEDAN, VAN};
use super::camera::Board;
use super::cyclist::{paint_cyclist, paint_cyclist_shadow};
use super::paint::{Painter, rgb};
use super::people::{Clothes, Person, View};
use super::signs::{
    paint_face_shadow, paint_light_mast, paint_post, paint_speed_sign, paint_stop_sign,
    paint_traffic_light,
};
use super::trees::{Tree, paint_hedge};
use super::vehicles::Vehicle;

/// Something that stands in the street.
pub(super) enum Thing {
    /// A car or van and its class name.
    Vehicle(&'static str, Vehicle),
    Person(Person),
    Cyclist(Board),
    StopSign(Board),
    SpeedSign(Board),
    /// The board of the mast; the light hangs at the end of its arm.
    TrafficLight(Board),
    Tree(Tree),
    /// Sideways position, near and far end, height.
    Hedge(f32, [f32; 2], f32),
}

const STOP_MIDDLE_M: f32 = 2.45;
const SPEED_MIDDLE_M: f32 = 2.35;
const LIGHT_MIDDLE_M: f32 = 4.7;
const LIGHT_ARM_M: f32 = 3.4;

impl Thing {
    /// How far in front of the camera the thing stands.
    pub(super) fn distance_m(&self) -> f32 {
        match self {
            Self::Vehicle(_, vehicle) => vehicle.near_m,
            Self::Person(person) => person.board.foot.ahead_m,
            Self::Cyclist(board)
            | Self::StopSign(board)
            | Self::SpeedSign(board)
            | Self::TrafficLight(board) => board.foot.ahead_m,
            Self::Tree(tree) => tree.board.foot.ahead_m,
            // A hedge is long: it counts as behind all on its sidewalk.
            Self::Hedge(_, ahead_m, _) => ahead_m[0] + 3.5,
        }
    }

    /// The class name of a labelled thing.
    pub(super) fn category(&self) -> Option<&'static str> {
        match self {
            Self::Vehicle(category, _) => Some(category),
            Self::Person(_) => Some("Pedestrian"),
            Self::Cyclist(_) => Some("Cyclist"),
            Self::StopSign(_) | Self::SpeedSign(_) => Some("TrafficSign"),
            Self::TrafficLight(_) => Some("TrafficLight"),
            Self::Tree(_) | Self::Hedge(..) => None,
        }
    }

    /// Draws the thing's shadow on the ground.
    pub(super) fn paint_shadow(&self, painter: &mut Painter) {
        painter.set_distance(self.distance_m());
        match self {
            Self::Vehicle(_, vehicle) => vehicle.paint_shadow(painter),
            Self::Person(person) => person.paint_shadow(painter),
            Self::Cyclist(board) => paint_cyclist_shadow(painter, board),
            Self::StopSign(board) => paint_face_shadow(painter, board, STOP_MIDDLE_M, 0.44),
            Self::SpeedSign(board) => paint_face_shadow(painter, board, SPEED_MIDDLE_M, 0.35),
            Self::Tree(tree) => tree.paint_shadow(painter),
            Self::TrafficLight(_) | Self::Hedge(..) => {}
        }
    }

    /// Draws what is not part of the labelled object: posts, trees, hedges.
    pub(super) fn paint_support(&self, painter: &mut Painter, rng: &mut ChaCha8Rng) {
        match self {
            Self::StopSign(board) => paint_post(painter, board, STOP_MIDDLE_M, 0.038),
            Self::SpeedSign(board) => paint_post(painter, board, SPEED_MIDDLE_M, 0.038),
            Self::TrafficLight(board) => {
                paint_light_mast(painter, board, LIGHT_ARM_M, LIGHT_MIDDLE_M + 0.75)
            }
            Self::Tree(tree) => tree.paint(painter, rng),
            Self::Hedge(right_m, ahead_m, height_m) => {
                paint_hedge(painter, rng, *right_m, *ahead_m, *height_m)
            }
            Self::Vehicle(..) | Self::Person(_) | Self::Cyclist(_) => {}
        }
    }

    /// Draws the labelled object itself.
    pub(super) fn paint(&self, painter: &mut Painter) {
        painter.set_distance(self.distance_m());
        match self {
            Self::Vehicle(_, vehicle) => vehicle.paint(painter),
            Self::Person(person) => person.paint(painter),
            Self::Cyclist(board) => paint_cyclist(painter, board),
            Self::StopSign(board) => paint_stop_sign(painter, board, STOP_MIDDLE_M),
            Self::SpeedSign(board) => paint_speed_sign(painter, board, SPEED_MIDDLE_M),
            Self::TrafficLight(board) => {
                let mut hung = *board;
                hung.foot.right_m -= LIGHT_ARM_M;
                paint_traffic_light(painter, &hung, LIGHT_MIDDLE_M);
            }
            Self::Tree(_) | Self::Hedge(..) => {}
        }
    }
}

fn tree(right_m: f32, ahead_m: f32, trunk_m: f32, crown_radius_m: f32, leaf_hex: u32) -> Thing {
    Thing::Tree(Tree {
        board: Board::facing(right_m, ahead_m),
        trunk_m,
        crown_radius_m,
        leaf: rgb(leaf_hex),
    })
}

fn car(right_m: f32, near_m: f32, oncoming: bool, body_hex: u32) -> Vehicle {
    Vehicle {
        build: &HATCHBACK,
        right_m,
        near_m,
        oncoming,
        body: rgb(body_hex),
        band: None,
    }
}

fn person(
    right_m: f32,
    ahead_m: f32,
    height_m: f32,
    view: View,
    mirror: f32,
    clothes: Clothes,
) -> Thing {
    Thing::Person(Person {
        board: Board {
            mirror,
            ..Board::facing(right_m, ahead_m)
        },
        height_m,
        view,
        clothes,
    })
}

/// Everything in the street, in no particular order.
pub(super) fn things() -> Vec<Thing> {
    let woman = Clothes {
        top: rgb(0x00E2_4E6C),
        legs: rgb(0x00E0_B090),
        shoes: rgb(0x00F2_EEE8),
        skin: rgb(0x00E6_B796),
        hair: rgb(0x0058_3220),
        bag: rgb(0x0034_3C58),
        dress: true,
    };
    let man = Clothes {
        top: rgb(0x0036_7CC8),
        legs: rgb(0x0038_4054),
        shoes: rgb(0x00E8_E4DC),
        skin: rgb(0x009C_6B4A),
        hair: rgb(0x0020_1814),
        bag: rgb(0x00E6_8A2A),
        dress: false,
    };
    let elder = Clothes {
        top: rgb(0x003E_8C62),
        legs: rgb(0x0054_4A44),
        shoes: rgb(0x0030_2824),
        skin: rgb(0x00E8_BE9E),
        hair: rgb(0x00B8_B4AE),
        bag: rgb(0x0084_5634),
        dress: false,
    };
    let sedan = |vehicle: Vehicle| Vehicle {
        build: &SEDAN,
        ..vehicle
    };
    vec![
        Thing::Vehicle("Car", car(0.15, 9.3, false, 0x00C8_202C)),
        Thing::Vehicle("Car", sedan(car(-3.5, 21.0, true, 0x002F_62B4))),
        Thing::Vehicle("Car", sedan(car(3.05, 13.2, false, 0x0026_8C86))),
        Thing::Vehicle(
            "Van",
            Vehicle {
                build: &VAN,
                band: Some(rgb(0x00F0_8A1C)),
                ..car(-6.35, 15.0, true, 0x00F2_F4F6)
            },
        ),
        person(5.75, 8.9, 1.80, View::Profile, -1.0, man),
        person(6.3, 14.2, 1.70, View::Front, 1.0, woman),
        person(-8.2, 16.0, 1.74, View::Front, 1.0, elder),
        Thing::Cyclist(Board {
            yaw_rad: 0.35,
            ..Board::facing(-5.5, 8.6)
        }),
        Thing::StopSign(Board::facing(4.55, 9.4)),
        Thing::SpeedSign(Board::facing(4.6, 16.5)),
        Thing::TrafficLight(Board::facing(4.75, 20.0)),
        tree(-9.3, 26.0, 2.6, 1.9, 0x0064_9A3C),
        tree(-8.9, 36.0, 2.5, 1.8, 0x0070_A046),
        tree(-9.0, 47.0, 2.5, 1.9, 0x005E_9444),
        tree(-9.0, 60.0, 2.5, 1.9, 0x006A_9A48),
        tree(-17.0, 24.0, 2.4, 3.0, 0x0052_8838),
        tree(-14.5, 17.5, 2.2, 2.3, 0x006C_A440),
        tree(6.6, 24.0, 2.7, 1.8, 0x0068_9C3E),
        tree(6.4, 33.0, 2.6, 1.8, 0x005C_9240),
        tree(6.4, 43.0, 2.6, 1.9, 0x006C_A04A),
        tree(6.4, 56.0, 2.6, 1.9, 0x0060_9446),
        tree(-9.0, 128.0, 1.2, 3.6, 0x0058_8A44),
        tree(-2.5, 150.0, 0.8, 4.0, 0x0050_8244),
        tree(4.2, 142.0, 0.9, 3.4, 0x0058_8A44),
        tree(9.0, 126.0, 1.2, 4.0, 0x0052_8444),
        Thing::Hedge(-11.2, [13.5, 27.0], 1.1),
    ]
}
