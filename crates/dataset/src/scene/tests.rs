//! Checks of size, repeatability and tight boxes.
//!
//! What comes out of a drawing with one object left out differs from the full
//! drawing exactly where that object is seen, so the boxes are held against
//! the pixels themselves.

use std::sync::LazyLock;

use super::{StreetScene, draw, street_scene};

/// Drawn once, because unoptimized builds need about a second for it.
static SCENE: LazyLock<StreetScene> = LazyLock::new(street_scene);

/// Two drawings of the same pixel differ when the object covers it; grain is
/// the same in both.
fn differs(a: &StreetScene, b: &StreetScene, x_px: u32, y_px: u32) -> bool {
    let (a, b) = (
        a.image.get_pixel(x_px, y_px).0,
        b.image.get_pixel(x_px, y_px).0,
    );
    a.iter().zip(b).any(|(&a, b)| a.abs_diff(b) > 3)
}

/// Left, top, right, bottom of all pixels that differ, and their count.
fn changed(a: &StreetScene, b: &StreetScene) -> ([f64; 4], f64) {
    let mut bounds = [f64::MAX, f64::MAX, f64::MIN, f64::MIN];
    let mut count = 0.0;
    for y_px in 0..a.image.height() {
        for x_px in 0..a.image.width() {
            if differs(a, b, x_px, y_px) {
                let (x, y) = (f64::from(x_px), f64::from(y_px));
                bounds = [
                    bounds[0].min(x),
                    bounds[1].min(y),
                    bounds[2].max(x + 1.0),
                    bounds[3].max(y + 1.0),
                ];
                count += 1.0;
            }
        }
    }
    (bounds, count)
}

#[test]
fn the_picture_has_the_size_of_a_kitti_frame() {
    assert_eq!(SCENE.image.dimensions(), (1242, 375), "width and height");
}

#[test]
fn two_drawings_are_equal() {
    let (first, second) = (&*SCENE, street_scene());
    assert!(
        first.image.as_raw() == second.image.as_raw(),
        "the bytes of both pictures"
    );
    assert_eq!(first.objects, second.objects, "the boxes of both drawings");
}

#[test]
fn the_street_holds_every_promised_class() {
    let scene = &*SCENE;
    let count = |category: &str| {
        scene
            .objects
            .iter()
            .filter(|object| object.category == category)
            .count()
    };
    assert!(count("Car") >= 3, "too few of Car");
    assert!(count("Van") + count("Truck") >= 1, "too few of Van");
    assert!(count("Pedestrian") >= 3, "too few of Pedestrian");
    assert!(count("Cyclist") >= 1, "too few of Cyclist");
    assert!(count("TrafficSign") >= 2, "too few of TrafficSign");
    assert!(count("TrafficLight") >= 1, "too few of TrafficLight");
}

#[test]
fn boxes_lie_inside_the_picture() {
    for object in &SCENE.objects {
        let [left, top, right, bottom] = object.bbox_xyxy_px;
        assert!(
            left >= 0.0 && top >= 0.0 && right <= 1242.0 && bottom <= 375.0,
            "{object:?}"
        );
        assert!(right - left >= 10.0 && bottom - top >= 10.0, "{object:?}");
    }
}

#[test]
fn boxes_are_tight_around_what_is_drawn() {
    let scene = &*SCENE;
    for (rank, object) in scene.objects.iter().enumerate() {
        let without = draw(Some(rank));
        assert_eq!(
            scene.objects, without.objects,
            "leaving an object out moves no box"
        );
        let (seen, count) = changed(scene, &without);
        for (side, (seen_px, box_px)) in seen.iter().zip(object.bbox_xyxy_px).enumerate() {
            assert!(
                (seen_px - box_px).abs() <= 2.0,
                "side {side} of {object:?}: seen {seen:?}"
            );
        }
        // Thin figures fill less of their box than cars and signs do.
        let [left, top, right, bottom] = object.bbox_xyxy_px;
        let share = count / ((right - left) * (bottom - top));
        let least = match object.category {
            "Pedestrian" => 0.30,
            "Cyclist" => 0.25,
            _ => 0.70,
        };
        assert!(share > least, "{object:?} covers {share:.2} of its box");
    }
}

#[test]
fn no_object_hides_most_of_another() {
    let scene = &*SCENE;
    for (rank, object) in scene.objects.iter().enumerate() {
        for nearer in &scene.objects[rank + 1..] {
            let [a, b] = [object.bbox_xyxy_px, nearer.bbox_xyxy_px];
            let width = (a[2].min(b[2]) - a[0].max(b[0])).max(0.0);
            let height = (a[3].min(b[3]) - a[1].max(b[1])).max(0.0);
            let share = width * height / ((a[2] - a[0]) * (a[3] - a[1]));
            assert!(share < 0.4, "{nearer:?} hides {share:.2} of {object:?}");
        }
    }
}
