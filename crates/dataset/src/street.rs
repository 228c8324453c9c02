//! A street seen through a windshield camera, and what is in it.

use image::RgbImage;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// One labeled object of the street.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObject {
    /// KITTI's name of the class, or `TrafficSign` and `TrafficLight`.
    pub category: &'static str,
    /// Left, top, right and bottom of everything drawn for the object, px, clipped to the picture.
    pub bbox_xyxy_px: [f64; 4],
}

/// A drawn street and what is in it.
#[derive(Clone, Debug)]
pub struct StreetScene {
    /// The picture, 1242 pixels wide and 375 high.
    pub image: RgbImage,
    /// The labeled objects, the farthest first.
    pub objects: Vec<SceneObject>,
}

/// The street without grain, which does not compress, as lossless WebP. Our own drawing: a program in the history of
/// this repository (`crates/dataset/src/scene`) made it and the boxes.
static PICTURE: &[u8] = include_bytes!("../data/street.webp");

/// Classes and boxes of [`PICTURE`], the farthest first.
const OBJECTS: [(&str, [f64; 4]); 11] = [
    (
        "Car",
        [
            459.7708435058594,
            179.27151489257812,
            535.6220092773438,
            228.2985382080078,
        ],
    ),
    (
        "TrafficLight",
        [
            647.4786987304688,
            40.5047607421875,
            669.1237182617188,
            85.23774719238281,
        ],
    ),
    (
        "TrafficSign",
        [
            795.0036010742188,
            126.54908752441406,
            826.4872436523438,
            158.03273010253906,
        ],
    ),
    (
        "Pedestrian",
        [
            226.15670776367188,
            167.86077880859375,
            255.52386474609375,
            247.95431518554688,
        ],
    ),
    (
        "Van",
        [
            260.74102783203125,
            142.0087890625,
            416.6296081542969,
            249.704833984375,
        ],
    ),
    (
        "Pedestrian",
        [
            914.6484375,
            169.27980041503906,
            946.9774780273438,
            257.451416015625,
        ],
    ),
    (
        "Car",
        [
            697.9605102539062,
            179.6339874267578,
            822.8612670898438,
            259.7959899902344,
        ],
    ),
    (
        "TrafficSign",
        [
            926.5714111328125,
            79.23046875,
            991.1019897460938,
            143.76100158691406,
        ],
    ),
    (
        "Car",
        [
            552.6791381835938,
            179.9390106201172,
            689.3439331054688,
            294.37701416015625,
        ],
    ),
    (
        "Pedestrian",
        [
            1033.131591796875,
            159.30348205566406,
            1122.7230224609375,
            305.67474365234375,
        ],
    ),
    (
        "Cyclist",
        [
            60.4676513671875,
            154.53993225097656,
            232.17807006835938,
            314.25811767578125,
        ],
    ),
];

/// Seed, and standard deviation in codes, of the grain.
const GRAIN_SEED: u64 = 5;
const GRAIN_SIGMA: f32 = 2.0;

/// Standard deviation of the sum of four bytes: √(4 (256² − 1)/12).
const BYTE_SUM_SIGMA: f32 = 147.8;

/// A drawn street of the size and geometry of a rectified KITTI frame, with the grain of a sensor,
/// and the box of every labeled object; the same on every call.
///
/// # Example
/// ```
/// let street = starbreak_dataset::street_scene();
/// assert_eq!(street.image.dimensions(), (1242, 375));
/// ```
#[must_use]
pub fn street_scene() -> StreetScene {
    let picture = image::load_from_memory(PICTURE);
    // The picture is part of the program, and a test reads it.
    let mut image = picture.map_or_else(|_| RgbImage::default(), |picture| picture.to_rgb8());
    add_grain(&mut image, &mut ChaCha8Rng::seed_from_u64(GRAIN_SEED));
    let objects = OBJECTS.map(|(category, bbox_xyxy_px)| SceneObject {
        category,
        bbox_xyxy_px,
    });
    StreetScene {
        image,
        objects: objects.into(),
    }
}

/// Adds grain to every pixel, mostly in brightness and a little in color.
fn add_grain(image: &mut RgbImage, rng: &mut ChaCha8Rng) {
    for pixel in image.pixels_mut() {
        // The sum of four bytes is close to a bell curve and cheap.
        let bytes = rng.next_u32().to_le_bytes().map(f32::from);
        let brightness = (bytes.iter().sum::<f32>() - 510.0) / BYTE_SUM_SIGMA * GRAIN_SIGMA;
        for (value, tilt) in pixel.0.iter_mut().zip(bytes) {
            let sum = f32::from(*value) + brightness + (tilt - 127.5) / 160.0;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped to a code"
            )]
            let code = (sum + 0.5).clamp(0.0, 255.0) as u8;
            *value = code;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_is_the_one_that_all_numbers_are_of() {
        let street = street_scene();
        assert_eq!(street.image.dimensions(), (1242, 375), "a frame of KITTI");
        let digest = crate::sha256_hex(street.image.as_raw());
        assert_eq!(
            digest, "083607639e2a2c6dbddbf34d4c9a9a99375f49cffd328f2e451a952152efd267",
            "grain included"
        );
    }

    #[test]
    fn boxes_lie_in_the_picture_and_hide_little_of_each_other() {
        let objects = street_scene().objects;
        for (rank, object) in objects.iter().enumerate() {
            let [left, top, right, bottom] = object.bbox_xyxy_px;
            assert!(
                left >= 0.0 && top >= 0.0 && right <= 1242.0 && bottom <= 375.0,
                "{object:?}"
            );
            assert!(right - left >= 10.0 && bottom - top >= 10.0, "{object:?}");
            for nearer in &objects[rank + 1..] {
                let [a, b] = [object.bbox_xyxy_px, nearer.bbox_xyxy_px];
                let width = (a[2].min(b[2]) - a[0].max(b[0])).max(0.0);
                let height = (a[3].min(b[3]) - a[1].max(b[1])).max(0.0);
                let share = width * height / ((a[2] - a[0]) * (a[3] - a[1]));
                assert!(share < 0.4, "{nearer:?} hides {share:.2} of {object:?}");
            }
        }
    }

    #[test]
    fn the_street_holds_every_promised_class() {
        let objects = street_scene().objects;
        let least = [
            ("Car", 3),
            ("Van", 1),
            ("Pedestrian", 3),
            ("Cyclist", 1),
            ("TrafficSign", 2),
            ("TrafficLight", 1),
        ];
        for (category, n) in least {
            let found = objects.iter().filter(|object| object.category == category);
            assert!(found.count() >= n, "too few of {category}");
        }
    }
}
