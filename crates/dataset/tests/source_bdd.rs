//! BDD100K as a dataset.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use common::{contents, open, put, shared_data, subset, try_open};
use serde_json::{Value, json};

const INDEX: &str = "labels/det_20/det_val.json";

fn label(id: &str, category: &str) -> Value {
    json!({"id": id, "category": category, "box2d": {"x1": 1.5, "y1": 2, "x2": 3, "y2": 4}})
}

#[test]
fn official_fixtures_are_read_with_their_mapping() {
    let Some(path) = shared_data("bdd/testcases") else {
        return;
    };
    let dir = tempfile::tempdir().unwrap();
    for name in ["example_annotation", "example_ignore_annotation"] {
        let text = std::fs::read_to_string(path.join(format!("{name}.json"))).unwrap();
        put(dir.path(), &format!("labels/{name}.json"), &text);
        let frames: Value = serde_json::from_str(&text).unwrap();
        for frame in frames.as_array().unwrap() {
            let image = frame["name"].as_str().unwrap();
            put(dir.path(), &format!("images/{image}"), "");
        }
    }
    let found = contents(&open("bdd", dir.path()));
    assert_eq!(
        found.images,
        [
            "images/00091078-875c1f73-0000166.jpg",
            "images/00091078-875c1f73-0000167.jpg",
            "images/b1c81faa-3df17267-0000001.jpg",
        ],
        "images; the second has no labels at all"
    );
    assert_eq!(
        found.objects[..2],
        [
            "label 00109430 pedestrian Ignored 1068.051474568342 362.7665840944419 1108.7226195720182 466.2931350128905",
            "label 00109431 pedestrian Regular 68.051474568342 301.7665840944419 108.7226195720182 426.2931350128905",
        ],
        "an ignored class and an older name"
    );
    assert_eq!((found.bad, found.problems), (vec![], vec![]), "bad");
}

#[test]
fn classes_and_attributes_decide_the_kind() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "images/100k/val/a.jpg", "");
    let with = |mut label: Value, key: &str, value: Value| {
        label["attributes"] = json!({"occluded": true, key: value});
        label
    };
    let labels = json!([
        label("0", "car"),
        label("1", "motor"),
        label("2", "trailer"),
        label("3", "traffic light"),
        with(label("4", "van"), "crowd", json!(true)),
        with(label("5", "bike"), "ignored", json!(true)),
        with(label("6", "other vehicle"), "crowd", json!(true)),
        with(label("7", "person"), "crowd", json!(false)),
        {"id": 8, "category": "area/drivable", "poly2d": [{"vertices": [[1, 2]], "closed": true}]},
        {"id": "9", "category": "car", "box2d": null, "attributes": null},
        {"category": "car", "box2d": {"x1": 0, "y1": 0, "x2": 0, "y2": 0}},
    ]);
    let frames =
        json!({"frames": [{"name": "a.jpg", "labels": labels}], "config": {"categories": []}});
    put(dir.path(), INDEX, frames.to_string());
    let found = contents(&open("bdd", dir.path()));
    assert_eq!(
        found.objects,
        [
            "label 0 car Regular 1.5 2 3 4",
            "label 1 motorcycle Regular 1.5 2 3 4",
            "label 2 truck Ignored 1.5 2 3 4",
            "label 3 traffic light Regular 1.5 2 3 4",
            "label 4 car Crowd 1.5 2 3 4",
            "label 5 bicycle Ignored 1.5 2 3 4",
            "label 6 car Ignored 1.5 2 3 4",
            "label 7 pedestrian Regular 1.5 2 3 4",
            "label [10] car Regular 0 0 0 0",
        ],
        "objects"
    );
    assert_eq!(found.problems, [""; 0], "problems");
}

#[test]
fn bad_frames_and_labels_are_named_and_good_ones_stay() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "images/100k/val/a.jpg", "");
    put(dir.path(), "images/100k/val/b.jpg", "");
    let mut reversed = label("1", "car");
    reversed["box2d"]["x1"] = json!(9);
    let mut half = label("2", "car");
    half["box2d"].as_object_mut().unwrap().remove("y2");
    let mut nameless = label("3", "car");
    nameless["category"] = json!(null);
    let frames = json!([
        {"name": "a.jpg", "labels": [label("0", "car"), reversed, half, nameless, 7, label("0", "bus")]},
        {"name": "b.jpg", "labels": 3},
        {"name": "../a.jpg", "labels": []},
        {"name": "gone.jpg"},
        {"name": "a.jpg", "labels": null},
        {"labels": null},
        "a.jpg",
    ]);
    put(dir.path(), INDEX, frames.to_string());
    let source = open("bdd", dir.path());
    let found = contents(&source);
    assert_eq!(
        found.images,
        ["images/100k/val/a.jpg", "images/100k/val/b.jpg"],
        "images"
    );
    assert_eq!(found.objects, ["label 0 car Regular 1.5 2 3 4"], "objects");
    let at = |text: &str| format!("{INDEX}: {text}");
    assert_eq!(
        found.problems,
        [
            "frame a.jpg, label 1: the box2d [9.0, 2.0, 3.0, 4.0] px ends before it begins, or reaches beyond 1e9 px",
            "frame a.jpg, label [2]: missing field `y2`",
            "frame a.jpg, label 3: it has a box but no category",
            "frame a.jpg, label [4]: invalid type: integer `7`, expected a label",
            "frame a.jpg, label 0: the id occurs twice in its frame",
            "frame b.jpg: invalid type: integer `3`, expected a sequence",
        ]
        .map(at),
        "problems"
    );
    assert_eq!(
        found.bad,
        [
            r#"frame [2]: the name "../a.jpg" leads out with '..'; make it relative to the dataset"#,
            "frame [5]: missing field `name`",
            r#"frame [6]: invalid type: string "a.jpg", expected a frame"#,
            r#"frame [4]: the name "a.jpg" occurs twice"#,
            r#"image "images/100k/val/gone.jpg": there is no such file"#,
        ]
        .map(at),
        "bad"
    );
    let part: Value =
        serde_json::from_str(&subset(&source, INDEX, |n| !n.contains("gone"))).unwrap();
    assert_eq!(part, json!([frames[0], frames[1]]), "the first two frames");
}

#[test]
fn frames_of_videos_lie_in_a_folder_per_video() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "images/track/train/v1/1.jpg", "");
    put(dir.path(), "images/track/train/v2/1.jpg", "");
    let frames = json!([
        {"name": "1.jpg", "videoName": "v1", "labels": [label("0", "car")]},
        {"name": "1.jpg", "videoName": "v2", "labels": [label("0", "bus")]},
        {"name": "1.jpg", "videoName": "../v2"},
    ]);
    put(dir.path(), "labels/train/x.json", frames.to_string());
    let path = dir.path().join("labels/train/x.json");
    let found = contents(&open("bdd", &path));
    assert_eq!(
        found.images,
        ["images/track/train/v1/1.jpg", "images/track/train/v2/1.jpg"],
        "images"
    );
    assert_eq!(found.objects.len(), 2, "{:?}", found.objects);
    assert_eq!(found.bad.len(), 1, "{:?}", found.bad);
    assert_eq!(found.files, ["labels/train/x.json (index)"], "files");
}

#[test]
fn a_broken_index_is_one_clear_error() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "images/100k/val/a.jpg", "");
    for (text, said) in [
        ("", "the file has no content"),
        ("{}", "it has no list \"frames\""),
        ("{\"frames\": {}}", "it has no list \"frames\""),
        ("\"a\"", "expected a list or an object"),
        ("[{\"name\": \"a.jpg\"}", "the file ends too early"),
        (
            &format!(
                "[{{\"name\": \"a.jpg\", \"labels\": {}",
                "[".repeat(1_000_000)
            ),
            "more than 127 levels inside a record",
        ),
        ("[{\"name\": \"b.jpg\"}]", "none of its 1 images is there"),
    ] {
        put(dir.path(), INDEX, text);
        let error = try_open("bdd", dir.path()).unwrap_err().to_string();
        assert!(
            error.contains(said) && error.contains("det_val.json"),
            "{error}"
        );
    }
}

#[test]
fn an_index_with_bytes_that_are_no_text_is_refused_wherever_they_stand() {
    let dir = tempfile::tempdir().unwrap();
    put(dir.path(), "images/100k/val/a.jpg", "");
    let frames = b"{\"frames\": [{\"name\": \"a.jpg\"}], \"config\": {\"\xff\": 1}}";
    put(dir.path(), INDEX, frames);
    let error = try_open("bdd", dir.path()).unwrap_err().to_string();
    assert!(
        error.contains("from byte 44 on: it is not UTF-8 text"),
        "{error}"
    );
}
