//! Sets with something white at known places, and lenses that move it.

use std::fs;
use std::path::Path;

use image::{DynamicImage, Rgb, RgbImage};
use serde_json::{Value, json};

use crate::program::{Outcome, png_bytes, succeed};

pub(crate) const SIZE: (u32, u32) = (320, 200);

/// Strong lenses: a barrel, a pincushion, a fisheye, and a shift with tangential terms.
pub(crate) const LENSES: [&[&str]; 4] = [
    &["distortion.corner_percent=-16"],
    &["distortion.corner_percent=16"],
    &[
        "distortion.corner_percent=0",
        "distortion.projection=\"fisheye\"",
    ],
    &[
        "distortion.corner_percent=-8",
        "distortion.p1=0.02",
        "distortion.p2=-0.01",
        "distortion.shift_px=[6.5, -4.25]",
    ],
];

/// Boxes about the frame, which all lenses leave in it.
pub(crate) const BOXES: [[f64; 4]; 4] = [
    [40.0, 30.0, 90.0, 70.0],
    [130.0, 60.0, 190.0, 150.0],
    [30.0, 130.0, 290.0, 180.0],
    [60.0, 120.0, 68.0, 170.0],
];

pub(crate) fn args<'a>(
    source: &'a str,
    out: &'a str,
    lens: &[&'a str],
    more: &[&'a str],
) -> Vec<&'a str> {
    let sets = lens.iter().flat_map(|set| ["--set", set]);
    let start = ["generate", source, "-o", out, "--preset", "distortion"];
    start
        .into_iter()
        .chain(sets)
        .chain(more.iter().copied())
        .collect()
}

pub(crate) fn generate(
    dir: &Path,
    source: &str,
    out: &str,
    lens: &[&str],
    more: &[&str],
) -> Outcome {
    succeed(dir, &args(source, out, lens, more))
}

pub(crate) fn write(root: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = root.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// A gray picture, white where something is.
pub(crate) fn painted(is_there: impl Fn(f64, f64) -> bool) -> Vec<u8> {
    let image = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        match is_there(f64::from(x) + 0.5, f64::from(y) + 0.5) {
            true => Rgb([250; 3]),
            false => Rgb([60; 3]),
        }
    });
    png_bytes(&DynamicImage::ImageRgb8(image))
}

pub(crate) fn box_at([x0, y0, x1, y1]: [f64; 4]) -> impl Fn(f64, f64) -> bool {
    move |x, y| (x0..x1).contains(&x) && (y0..y1).contains(&y)
}

/// One picture per box with its label, in each format; `more` members for a record of COCO and of Scalabel.
pub(crate) fn write_sets(root: &Path, boxes: &[[f64; 4]]) {
    let mut coco =
        json!({ "images": [], "annotations": [], "categories": [{ "id": 1, "name": "car" }] });
    let mut frames = Vec::new();
    for (k, corners) in boxes.iter().enumerate() {
        let image = painted(box_at(*corners));
        let [x0, y0, x1, y1] = *corners;
        write(root, &format!("kitti/image_2/{k:06}.png"), &image);
        let label = format!("Car 0.10 1 -1.57 {x0} {y0:.2} {x1} {y1} 1.5 1.6 3.9 1 2 30 0.1\n");
        write(root, &format!("kitti/label_2/{k:06}.txt"), label);
        write(root, &format!("yolo/images/{k}.png"), &image);
        let (w, h) = (f64::from(SIZE.0), f64::from(SIZE.1));
        let [cx, cy, bw, bh] = [
            0.5 * (x0 + x1) / w,
            0.5 * (y0 + y1) / h,
            (x1 - x0) / w,
            (y1 - y0) / h,
        ];
        // The same again as an outline.
        let [l, t, r, b] = [x0 / w, y0 / h, x1 / w, y1 / h];
        write(
            root,
            &format!("yolo/labels/{k}.txt"),
            format!("0 {cx} {cy} {bw} {bh}\n1 {l} {t} {r} {t} {r} {b} {l} {b}\n"),
        );
        let name = format!("{k}.png");
        write(root, &format!("coco/val/{name}"), &image);
        let id = k + 1;
        let members = [
            (
                "images",
                json!({ "id": id, "file_name": name, "width": SIZE.0, "height": SIZE.1 }),
            ),
            (
                "annotations",
                json!({ "id": id, "image_id": id, "category_id": 1, "bbox": [x0, y0, x1 - x0, y1 - y0],
                    "area": 1.0, "iscrowd": 0, "note": "mine" }),
            ),
        ];
        for (list, record) in members {
            coco[list].as_array_mut().unwrap().push(record);
        }
        write(root, &format!("bdd/images/100k/val/{name}"), &image);
        frames.push(json!({ "name": name, "timestamp": 7, "labels": [{ "id": "a", "category": "car",
            "attributes": { "occluded": false }, "box2d": { "x1": x0, "y1": y0, "x2": x1, "y2": y1 } }] }));
    }
    write(root, "yolo/data.yaml", "train: images\nnames: [car, bus]\n");
    write(
        root,
        "coco/annotations/instances_val.json",
        coco.to_string(),
    );
    write(
        root,
        "bdd/labels/det_20/det_val.json",
        Value::from(frames).to_string(),
    );
}

/// Labels of KITTI: one that stays, one that the frame cuts, one that leaves it, an area, and a line that is none.
pub(crate) fn write_kitti(root: &Path) {
    let rest = "1.5 1.6 3.9 1 2 30 0.1";
    let label = format!(
        "Car 0.50 0 1.2 140 80 180 120 {rest}\nCar 0.20 0 1.2 230 60 312 140 {rest}\r\nVan 0 0 0 308 2 318 8 {rest}\n\
         DontCare -1 -1 -10 235 60 310 140 -1 -1 -1 -1000 -1000 -1000 -10\nCar 1 2 3\n"
    );
    for k in 0..6 {
        write(
            root,
            &format!("in/image_2/{k:06}.png"),
            painted(box_at([230.0, 60.0, 312.0, 140.0])),
        );
        write(root, &format!("in/label_2/{k:06}.txt"), &label);
    }
}
