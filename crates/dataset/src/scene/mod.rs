//! A street seen through a windshield camera, drawn in code.
//!
//! What comes out of [`street_scene`] is a picture of the size and geometry of
//! a rectified KITTI frame together with the box of every labelled object.
//! Nothing is loaded: the drawing is our own and the same on every call.

mod background;
mod bodies;
mod buildings;
mod camera;
mod cyclist;
mod facades;
mod layout;
mod paint;
mod people;
mod people_front;
mod random;
mod shape;
mod signs;
#[cfg(test)]
mod tests;
mod trees;
mod vehicle_end;
mod vehicle_front;
mod vehicle_rear;
mod vehicles;

use image::RgbImage;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use layout::{Thing, things};
use paint::Painter;

/// One labelled object of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// KITTI's name of the class, or `TrafficSign` and `TrafficLight`.
    pub category: &'static str,
    /// Left, top, right and bottom of everything drawn for the object, in
    /// pixels, clipped to the picture.
    pub bbox_xyxy_px: [f64; 4],
}

/// A drawn street and what is in it.
#[derive(Clone, Debug)]
pub struct StreetScene {
    /// The picture, 1242 pixels wide and 375 high.
    pub image: RgbImage,
    /// The labelled objects, the farthest first.
    pub objects: Vec<SceneObject>,
}

/// Seeds of everything that only looks random.
const BACKGROUND_SEED: u64 = 11;
const TREE_SEED: u64 = 23;
const GRAIN_SEED: u64 = 5;

/// Draws the street; the same picture and boxes on every call.
#[must_use]
pub fn street_scene() -> StreetScene {
    draw(None)
}

/// Draws the street without the object of the given rank, whose shadow stays.
fn draw(left_out: Option<usize>) -> StreetScene {
    let mut objects = Vec::new();
    // Only an empty picture size is refused, and ours is not empty.
    let Some(mut painter) = Painter::new(left_out) else {
        return StreetScene {
            image: RgbImage::new(camera::WIDTH_PX, camera::HEIGHT_PX),
            objects,
        };
    };
    let mut rng = ChaCha8Rng::seed_from_u64(BACKGROUND_SEED);
    background::paint_sky(&mut painter, &mut rng);
    background::paint_skyline(&mut painter, &mut rng);
    background::paint_ground(&mut painter, &mut rng);
    buildings::paint_house_shadows(&mut painter);
    buildings::paint_houses(&mut painter);

    let mut things = things();
    // Far things first, so that near ones cover them.
    things.sort_by(|a, b| b.distance_m().total_cmp(&a.distance_m()));
    for thing in &things {
        thing.paint_shadow(&mut painter);
    }
    let mut rng = ChaCha8Rng::seed_from_u64(TREE_SEED);
    for thing in &things {
        paint_thing(thing, &mut painter, &mut rng, &mut objects);
    }
    let mut image = painter.into_image();
    random::add_grain(&mut image, &mut ChaCha8Rng::seed_from_u64(GRAIN_SEED));
    StreetScene { image, objects }
}

fn paint_thing(
    thing: &Thing,
    painter: &mut Painter,
    rng: &mut ChaCha8Rng,
    objects: &mut Vec<SceneObject>,
) {
    thing.paint_support(painter, rng);
    let Some(category) = thing.category() else {
        return;
    };
    painter.begin_object();
    thing.paint(painter);
    if let Some(bbox_xyxy_px) = painter.end_object() {
        objects.push(SceneObject {
            category,
            bbox_xyxy_px,
        });
    }
}
