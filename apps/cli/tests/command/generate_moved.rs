//! `starbreak generate` with a lens that distorts: labels lie where the picture shows what they name.
#![expect(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "a test may panic, and compares numbers as they are written"
)]

use std::fs;
use std::path::Path;

use crate::moved::{
    BOXES, LENSES, SIZE, args, box_at, generate, painted, write, write_kitti, write_sets,
};
use crate::program::{folder, json, starbreak};
use serde_json::{Value, json};

/// The pixels that are white, in rows: of more than half of the light.
fn white(path: &Path) -> Vec<bool> {
    let image = image::open(path).unwrap().to_rgb8();
    image.pixels().map(|pixel| pixel.0[1] > 187).collect()
}

/// The box around white pixels.
fn box_around(white: &[bool]) -> [f64; 4] {
    let mut around = [f64::INFINITY, f64::INFINITY, 0.0, 0.0];
    for (at, _) in white.iter().enumerate().filter(|(_, is_white)| **is_white) {
        let [x, y] = [at % SIZE.0 as usize, at / SIZE.0 as usize]
            .map(|at| f64::from(u32::try_from(at).unwrap()));
        let [x0, y0, x1, y1] = around;
        around = [x0.min(x), y0.min(y), x1.max(x + 1.0), y1.max(y + 1.0)];
    }
    around
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace()
        .skip(1)
        .map(|field| field.parse().unwrap())
        .collect()
}

fn four(value: &Value) -> [f64; 4] {
    serde_json::from_value(value.clone()).unwrap()
}

#[test]
fn boxes_lie_where_pictures_show_what_they_name() {
    let dir = folder();
    let root = dir.path();
    write_sets(root, &BOXES);
    for (n, lens) in LENSES.into_iter().enumerate() {
        let out = |format: &str| format!("{format}-{n}");
        for format in ["kitti", "yolo", "coco", "bdd"] {
            generate(root, &format!("{format}:{format}"), &out(format), lens, &[]);
        }
        let coco = json(
            &root
                .join(out("coco"))
                .join("annotations/instances_val.json"),
        );
        let bdd = json(&root.join(out("bdd")).join("labels/det_20/det_val.json"));
        let mut farthest_px = 0.0;
        for k in 0..BOXES.len() {
            let kitti = root.join(out("kitti"));
            let expected = box_around(&white(&kitti.join(format!("image_2/{k:06}.png"))));
            let line = fs::read_to_string(kitti.join(format!("label_2/{k:06}.txt"))).unwrap();
            assert!(
                line.starts_with("Car 0.10 1 -1.57 ")
                    && line.ends_with(" 1.5 1.6 3.9 1 2 30 0.1\n"),
                "{line}"
            );
            let record = json(&kitti.join(format!("starbreak/provenance/image_2/{k:06}.json")));
            let rows =
                fs::read_to_string(root.join(out("yolo")).join(format!("labels/{k}.txt"))).unwrap();
            let rows: Vec<Vec<f64>> = rows.lines().map(numbers).collect();
            let (w, h) = (f64::from(SIZE.0), f64::from(SIZE.1));
            let [cx, cy, bw, bh] = rows[0][..] else {
                panic!("{rows:?}")
            };
            let xs = rows[1].iter().step_by(2).map(|x| x * w);
            let ys = rows[1].iter().skip(1).step_by(2).map(|y| y * h);
            let (least, most) = (|a: f64, b: f64| a.min(b), |a: f64, b: f64| a.max(b));
            let outline = [
                xs.clone().reduce(least).unwrap(),
                ys.clone().reduce(least).unwrap(),
                xs.reduce(most).unwrap(),
                ys.reduce(most).unwrap(),
            ];
            let [x, y, width, height] = four(&coco["annotations"][k]["bbox"]);
            assert_eq!(
                coco["annotations"][k]["area"],
                json!((width * height * 100.0).round() / 100.0)
            );
            let box2d = &bdd[k]["labels"][0]["box2d"];
            let found = [
                ("kitti", numbers(&line)[3..7].try_into().unwrap()),
                ("its record", four(&record["objects"][0]["box_px"])),
                (
                    "yolo",
                    [
                        (cx - 0.5 * bw) * w,
                        (cy - 0.5 * bh) * h,
                        (cx + 0.5 * bw) * w,
                        (cy + 0.5 * bh) * h,
                    ],
                ),
                ("yolo's outline", outline),
                ("coco", [x, y, x + width, y + height]),
                (
                    "bdd",
                    ["x1", "y1", "x2", "y2"].map(|key| box2d[key].as_f64().unwrap()),
                ),
            ];
            for (what, found) in found {
                let miss = (0..4)
                    .map(|k| (found[k] - expected[k]).abs())
                    .fold(0.0, f64::max);
                assert!(
                    miss <= 1.0,
                    "{what}, {lens:?}, box {k}: {found:?}, seen at {expected:?}"
                );
            }
            let moved = (0..4).map(|at| (expected[at] - BOXES[k][at]).abs());
            farthest_px = moved.fold(farthest_px, f64::max);
        }
        assert!(farthest_px > 3.0, "the lens moves what there is: {lens:?}");
    }
}

/// Whether a place lies in an outline, by the lines on its right.
fn is_in(outline: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let next = outline.iter().cycle().skip(1);
    let crosses = |(a, b): &(&[f64; 2], &[f64; 2])| {
        (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    outline.iter().zip(next).filter(crosses).count() % 2 == 1
}

fn overlap(found: impl Fn(usize) -> bool, expected: &[bool]) -> f64 {
    let count = |of: &dyn Fn(usize) -> bool| (0..expected.len()).filter(|at| of(*at)).count();
    let both = count(&|at| found(at) && expected[at]);
    let any = count(&|at| found(at) || expected[at]);
    f64::from(u32::try_from(both).unwrap()) / f64::from(u32::try_from(any).unwrap())
}

#[test]
fn outlines_masks_and_points_lie_where_pictures_show_them() {
    let dir = folder();
    let root = dir.path();
    // Not convex, and across a good part of the frame.
    let corners = [
        [30.0, 20.0],
        [290.0, 40.0],
        [200.0, 110.0],
        [280.0, 180.0],
        [60.0, 150.0],
        [110.0, 90.0],
    ];
    let image = painted(|x, y| is_in(&corners, [x, y]));
    write(root, "in/val/a.png", &image);
    let (w, h) = (SIZE.0 as usize, SIZE.1 as usize);
    write(root, "a.png", &image);
    let before = white(&root.join("a.png"));
    let mut counts = vec![0_u32];
    let mut is_inside = false;
    for at in 0..w * h {
        let now = before[(at % h) * w + at / h];
        if now != is_inside {
            counts.push(0);
            is_inside = now;
        }
        *counts.last_mut().unwrap() += 1;
    }
    let boxed = |id: u32, segmentation: Value| {
        json!({ "id": id, "image_id": 1, "category_id": 1, "iscrowd": u8::from(id == 2), "area": 5.0,
            "bbox": [30, 20, 260, 160], "segmentation": segmentation, "num_keypoints": 3,
            "keypoints": [110, 90, 2, 0, 0, 0, 318, 1, 1, 290, 40, 1] })
    };
    let index = json!({ "info": { "year": 2026 }, "images": [{ "id": 1, "file_name": "a.png" }],
        "annotations": [boxed(1, json!([corners.concat()])), boxed(2, json!({ "size": [h, w], "counts": counts }))],
        "categories": [{ "id": 1, "name": "car", "keypoints": ["a", "b", "c", "d"], "skeleton": [[1, 2]] }] });
    write(root, "in/annotations/instances_val.json", index.to_string());
    for (n, lens) in LENSES.into_iter().enumerate() {
        let out = format!("out{n}");
        generate(root, "coco:in", &out, lens, &[]);
        let expected = white(&root.join(&out).join("val/a.png"));
        let moved = json(&root.join(&out).join("annotations/instances_val.json"));
        assert_eq!(
            [&moved["info"], &moved["categories"]],
            [&index["info"], &index["categories"]],
            "as they were"
        );
        let n_white = f64::from(u32::try_from(expected.iter().filter(|it| **it).count()).unwrap());

        let outlines: Vec<Vec<f64>> =
            serde_json::from_value(moved["annotations"][0]["segmentation"].clone()).unwrap();
        assert_eq!(outlines.len(), 1, "{outlines:?}");
        let outline = outlines[0].as_chunks::<2>().0;
        let middle =
            |at: usize| [at % w, at / w].map(|at| f64::from(u32::try_from(at).unwrap()) + 0.5);
        let share = overlap(|at| is_in(outline, middle(at)), &expected);
        assert!(share > 0.97, "the outline, {lens:?}: {share}");

        let mask = &moved["annotations"][1]["segmentation"];
        assert_eq!(mask["size"], json!([h, w]));
        let counts: Vec<usize> = serde_json::from_value(mask["counts"].clone()).unwrap();
        let mut inside = Vec::new();
        for (k, count) in counts.iter().enumerate() {
            inside.resize(inside.len() + count, k % 2 == 1);
        }
        assert_eq!(inside.len(), w * h, "the runs fill the frame");
        let share = overlap(|at| inside[(at % w) * h + at / w], &expected);
        assert!(share > 0.97, "the mask, {lens:?}: {share}");

        for annotation in moved["annotations"].as_array().unwrap() {
            let area = annotation["area"].as_f64().unwrap();
            assert!(
                (area / n_white - 1.0).abs() < 0.03,
                "{area} px of {n_white}, {lens:?}"
            );
            let points: Vec<f64> = serde_json::from_value(annotation["keypoints"].clone()).unwrap();
            assert!(points[3..6] == [0.0; 3] && points[2] == 2.0, "{points:?}");
            // A corner of the outline is a corner of the moved one.
            let near = |a: &[f64], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 0.1;
            assert!(
                outline.iter().any(|at| near(&points[0..2], at)),
                "{points:?}"
            );
            let n_seen = points.chunks(3).filter(|point| point[2] > 0.0).count();
            assert_eq!(annotation["num_keypoints"], n_seen, "{points:?}");
        }
    }
    // The point beside the upper right corner leaves the frame with the pincushion alone.
    let seen = |out: &str| {
        json(&root.join(out).join("annotations/instances_val.json"))["annotations"][0]["num_keypoints"].clone()
    };
    assert_eq!([seen("out0"), seen("out1")], [json!(3), json!(2)]);
}

#[test]
fn what_leaves_the_frame_is_left_out_and_what_it_cuts_is_truncated() {
    let dir = folder();
    let root = dir.path();
    write_kitti(root);
    let lens = ["distortion.corner_percent=30"];
    let outcome = starbreak(root, &args("kitti:in", "out", &lens, &[]));
    assert!(
        outcome.code == Some(2) && outcome.stderr.contains("000000.txt:5"),
        "a bad row: {outcome:?}"
    );
    assert!(!root.join("out").exists(), "nothing is written");
    generate(root, "kitti:in", "out", &lens, &["--on-error", "skip"]);
    let text = fs::read_to_string(root.join("out/label_2/000000.txt")).unwrap();
    let [whole, cut, area] = text.lines().collect::<Vec<_>>()[..] else {
        panic!("three are left: {text}")
    };
    assert!(whole.starts_with("Car 0.50 0 1.2 "), "{whole}");
    assert!(
        area.starts_with("DontCare -1 -1 -10 ") && area.ends_with(" -10"),
        "{area}"
    );
    assert!(text.contains("30 0.1\r\n"), "ends of lines stay: {text:?}");
    // The right side at 312 of 320 is moved by 30 % of half the diagonal where that is a corner: k1 = 0.3/r².
    let corner2 = 160.0_f64.powi(2) + 100.0_f64.powi(2);
    let far = |x: f64, y: f64| 1.0 + 0.3 * (x * x + y * y) / corner2;
    let [left, right] = [70.0 * far(70.0, 0.0), 152.0 * far(152.0, 40.0)];
    let kept = (160.0 - left) / (right - left);
    let row = numbers(cut);
    assert!(
        (row[0] - (1.0 - 0.8 * kept)).abs() < 0.0051,
        "{cut}: {kept} is left"
    );
    assert!(
        (row[3] - 160.0 - left).abs() < 0.02 && (row[5] - 320.0).abs() < 1e-9,
        "{cut}"
    );
    let record = json(&root.join("out/starbreak/provenance/image_2/000000.json"));
    let objects = record["objects"].as_array().unwrap();
    assert_eq!(objects.len(), 3, "{record}");
    for (object, line) in objects.iter().zip(text.lines()) {
        assert_eq!(
            four(&object["box_px"]),
            numbers(line)[3..7],
            "the record says what the label says"
        );
        assert!(object["damage"]["region_share"].is_number(), "{object}");
    }
    assert_eq!(
        objects[2]["record"], "label_2/000000.txt:4",
        "the place in the source"
    );
}

#[test]
fn lines_of_bdd_move_by_their_vertices() {
    let dir = folder();
    let root = dir.path();
    let line = |vertices: Value| json!([{ "vertices": vertices, "types": "LLC", "closed": false }]);
    let frames = json!([{ "name": "a.png", "labels": [
        { "id": 1, "category": "lane", "poly2d": line(json!([[160, 100], [160, 20], [310, 195]])) },
        { "id": 2, "category": "lane", "poly2d": line(json!([[319, 1], [319, 2], [318, 3]])) },
        { "id": 3, "category": "car", "box2d": { "x1": 9, "y1": 8, "x2": 1, "y2": 2 } },
        { "id": "4", "category": "car", "box2d": { "x1": 308, "y1": 2, "x2": 318, "y2": 8 } },
        { "id": 5, "category": "car", "box3d": null, "box2d": { "x1": 100, "y1": 80, "x2": 220, "y2": 120, "score": 7 } },
    ] }]);
    write(root, "in/labels/det_val.json", frames.to_string());
    write(root, "in/images/val/a.png", painted(box_at(BOXES[0])));
    let lens = ["distortion.corner_percent=30"];
    generate(root, "bdd:in", "out", &lens, &["--on-error", "skip"]);
    let moved = json(&root.join("out/labels/det_val.json"));
    let labels = moved[0]["labels"].as_array().unwrap();
    let ids: Vec<&Value> = labels.iter().map(|label| &label["id"]).collect();
    assert_eq!(
        ids,
        [1, 5],
        "one is out of sight, one is wrong, one has left the frame"
    );
    let vertices: Vec<[f64; 2]> =
        serde_json::from_value(labels[0]["poly2d"][0]["vertices"].clone()).unwrap();
    assert_eq!(labels[0]["poly2d"][0]["types"], "LLC");
    assert_eq!(vertices[0], [160.0, 100.0], "the middle stays");
    assert!(
        vertices[1][1] < 18.0 && vertices[2][0] > 320.0,
        "not cut: {vertices:?}"
    );
    assert_eq!(
        labels[1]["box2d"]["score"], 7,
        "what is no place stays: {moved}"
    );
}
