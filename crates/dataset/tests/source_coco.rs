//! COCO as a dataset.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common;

use std::path::Path;

use common::{contents, open, put, shared_data, subset, try_open};
use serde_json::{Value, json};

const INDEX: &str = "annotations/instances_val.json";

/// An index with two images, of which the first has these annotations.
fn index(annotations: &Value) -> Value {
    json!({
        "info": {"year": 2017},
        "images": [
            {"id": 7, "file_name": "b.jpg", "width": 4, "height": 3},
            {"id": 3, "file_name": "a.jpg", "width": 4, "height": 3},
        ],
        "annotations": annotations,
        "categories": [{"id": 1, "name": "person"}, {"id": 90, "name": "toothbrush"}],
    })
}

fn annotation(id: Value, bbox: Value) -> Value {
    json!({"id": id, "image_id": 7, "category_id": 90, "bbox": bbox, "iscrowd": 0, "area": 1})
}

fn put_images(root: &Path, names: &[&str]) {
    for name in names {
        put(root, &format!("val/{name}"), "");
    }
}

#[test]
fn real_annotations_are_those_of_an_independent_reading() {
    let Some(path) = shared_data("coco96") else {
        return;
    };
    let source = open("coco", &path);
    let found = contents(&source);
    // The counts of the data's own description.
    assert_eq!(found.images.len(), 96, "images");
    assert_eq!(found.objects.len(), 710, "annotations");
    assert_eq!((found.bad.len(), found.problems.len()), (0, 0), "bad");
    assert_eq!(
        found.files,
        ["annotations/instances_val2017.json (index)"],
        "files"
    );
    // Every annotation, from the file as a whole.
    let text = std::fs::read(path.join("annotations/instances_val2017.json")).unwrap();
    let whole: Value = serde_json::from_slice(&text).unwrap();
    let name_of = |list: &str, id: &Value, key: &str| {
        let records = whole[list].as_array().unwrap();
        let record = records.iter().find(|r| r["id"] == *id).unwrap();
        record[key].as_str().unwrap().to_owned()
    };
    let mut expected: Vec<String> = Vec::new();
    for annotation in whole["annotations"].as_array().unwrap() {
        let [x, y, w, h] = [0, 1, 2, 3].map(|k| annotation["bbox"][k].as_f64().unwrap());
        let kind = match annotation["iscrowd"].as_u64().unwrap() {
            0 => "Regular",
            _ => "Crowd",
        };
        expected.push(format!(
            "{} annotation {} {} {kind} {x} {y} {} {}",
            name_of("images", &annotation["image_id"], "file_name"),
            annotation["id"],
            name_of("categories", &annotation["category_id"], "name"),
            x + w,
            y + h
        ));
    }
    let mut got: Vec<String> = Vec::new();
    for image in source.images().map(Result::unwrap) {
        let name = image.name.strip_prefix("val2017/").unwrap();
        for object in &image.objects {
            let [x0, y0, x1, y1] = object.box_px;
            let (record, category, kind) = (&object.record, &object.category, object.kind);
            got.push(format!(
                "{name} {record} {category} {kind:?} {x0} {y0} {x1} {y1}"
            ));
        }
    }
    expected.sort_unstable();
    got.sort_unstable();
    assert_eq!(got, expected, "annotations");
}

#[test]
fn a_part_of_real_annotations_keeps_every_value() {
    let Some(path) = shared_data("coco96") else {
        return;
    };
    let source = open("coco", &path);
    let name = "annotations/instances_val2017.json";
    let text = std::fs::read(path.join(name)).unwrap();
    let mut whole: Value = serde_json::from_slice(&text).unwrap();
    let all: Value = serde_json::from_str(&subset(&source, name, |_| true)).unwrap();
    assert_eq!(all, whole, "all");

    let is_kept = |name: &str| name.ends_with("9.jpg");
    let part: Value = serde_json::from_str(&subset(&source, name, is_kept)).unwrap();
    let images = whole["images"].as_array_mut().unwrap();
    images.retain(|image| is_kept(image["file_name"].as_str().unwrap()));
    let ids: Vec<Value> = images.iter().map(|image| image["id"].clone()).collect();
    let annotations = whole["annotations"].as_array_mut().unwrap();
    annotations.retain(|annotation| ids.contains(&annotation["image_id"]));
    assert!(!annotations.is_empty() && annotations.len() < 710, "a part");
    assert_eq!(part, whole, "a part");
}

#[test]
fn bad_annotations_are_named_and_good_ones_stay() {
    let dir = tempfile::tempdir().unwrap();
    put_images(dir.path(), &["a.jpg", "b.jpg"]);
    let good = annotation(json!(1), json!([1, 2, 3.5, 4]));
    let mut crowd = annotation(json!("x-2"), json!([0, 0, 0, 0]));
    crowd["iscrowd"] = json!(1);
    let mut of_nobody = annotation(json!(3), json!([1, 2, 3, 4]));
    of_nobody["image_id"] = json!(99);
    let mut of_no_class = annotation(json!(4), json!([1, 2, 3, 4]));
    of_no_class["category_id"] = json!(2);
    let mut odd_crowd = annotation(json!(5), json!([1, 2, 3, 4]));
    odd_crowd["iscrowd"] = json!("no");
    let without = |key: &str| {
        let mut record = annotation(json!(6), json!([1, 2, 3, 4]));
        record.as_object_mut().unwrap().remove(key);
        record
    };
    let records = json!([
        good,
        crowd,
        of_nobody,
        of_no_class,
        odd_crowd,
        without("id"),
        without("image_id"),
        without("category_id"),
        without("bbox"),
        annotation(json!(8), json!([1, 2, -3, 4])),
        annotation(json!(9), json!([1, 2, 3])),
        annotation(json!(10), json!([1, 2, "3", 4])),
        annotation(json!(11), json!([1e308, 2, 1e308, 4])),
        annotation(json!(1.5), json!([1, 2, 3, 4])),
        good,
        annotation(json!(12.0), json!([5, 6, 7, 8])),
        17,
    ]);
    let text = index(&records).to_string();
    // A number that no f64 holds cannot be made by the macro.
    let text = text.replace("[5,6,7,8]", "[5,6,7,8],\"score\":1e400");
    put(dir.path(), INDEX, &text);
    let found = contents(&open("coco", dir.path()));
    assert_eq!(found.images, ["val/a.jpg", "val/b.jpg"], "images");
    assert_eq!(
        found.objects,
        [
            "annotation 1 toothbrush Regular 1 2 4.5 6",
            "annotation x-2 toothbrush Crowd 0 0 0 0",
            "annotation 12 toothbrush Regular 5 6 12 14",
        ],
        "objects"
    );
    let at = |text: &str| format!("{INDEX}: {text}");
    let mut problems: Vec<String> = [
        "annotation 1: the id occurs twice",
        "annotation 4: its category 2 is not in the index",
        "annotation 5: iscrowd = \"no\" is neither 0 nor 1",
        "annotations[5]: it has no id",
        "annotation 6: it has no category_id",
        "annotation 6: it has no bbox",
        "annotation 8: the bbox [1.0, 2.0, -3.0, 4.0] px has a negative side, or reaches beyond 1e9 px",
        "annotations[10]: invalid length 3, expected an array of length 4",
        "annotations[11]: invalid type: string \"3\", expected f64",
        "annotations[13]: the id 1.5 is not a whole number",
    ]
    .map(at)
    .to_vec();
    let big = found
        .problems
        .iter()
        .position(|p| p.contains("annotation 11: the bbox"));
    let mut got = found.problems.clone();
    got.remove(big.unwrap());
    got.sort_unstable();
    problems.sort_unstable();
    assert_eq!(got, problems, "problems");
    assert_eq!(
        found.bad,
        [
            at("annotation 6: it has no image_id"),
            at("annotations[16]: invalid type: integer `17`, expected an annotation"),
            at("annotation 3: its image 99 is not in the index"),
        ],
        "bad"
    );
}

#[test]
fn names_that_lead_out_are_refused_and_so_are_second_images() {
    let dir = tempfile::tempdir().unwrap();
    put_images(
        dir.path(),
        &["a.jpg", "A.jpg", "b.jpg", "c.jpg", "sub/d.jpg"],
    );
    let names = [
        "a.jpg",
        "b.jpg",
        "/etc/x.jpg",
        "../x.jpg",
        "sub/../../x.jpg",
        "sub\\d.jpg",
        "a\0.jpg",
        "./b.jpg",
        "A.jpg",
        "gone.jpg",
        "a.tif",
        "",
        "sub//d.jpg",
    ];
    let image = |(id, name): (usize, &&str)| json!({"id": id, "file_name": name});
    let mut images: Vec<Value> = names.iter().enumerate().map(image).collect();
    images.push(json!({"id": 12, "file_name": "c.jpg"}));
    images.push(json!({"id": 50}));
    images.push(json!({"file_name": "c.jpg"}));
    let of =
        |id: usize| json!({"id": 100 + id, "image_id": id, "category_id": 1, "bbox": [0, 0, 1, 1]});
    let mut index = index(&(0..names.len()).map(of).collect());
    index["images"] = json!(images);
    put(dir.path(), INDEX, index.to_string());
    let source = open("coco", dir.path());
    let found = contents(&source);
    assert_eq!(found.images, ["val/A.jpg", "val/b.jpg"], "images");
    let said: Vec<&str> = found
        .bad
        .iter()
        .map(|bad| bad.strip_prefix(&format!("{INDEX}: ")).unwrap())
        .collect();
    let relative = "make it relative to the dataset";
    assert_eq!(
        said,
        [
            &format!(r#"image 2: the name "/etc/x.jpg" is absolute; {relative}"#),
            &format!(r#"image 3: the name "../x.jpg" leads out with '..'; {relative}"#),
            &format!(r#"image 4: the name "sub/../../x.jpg" leads out with '..'; {relative}"#),
            r#"image 5: the name "sub\\d.jpg" holds a backslash; write it with '/'"#,
            r#"image 6: the name "a\0.jpg" holds a NUL character"#,
            r#"image 10: "a.tif" is neither PNG nor JPEG by its name"#,
            r#"image 11: the name "" is empty"#,
            r#"image 12: the id occurs twice, again for "c.jpg""#,
            "images[14]: it has no file_name",
            "images[15]: missing field `id`",
            "image 12: the id occurs twice, so that its annotations may be another's",
            r#"image 7: the file_name "b.jpg" occurs twice"#,
            r#""val/a.jpg": the name differs from "val/A.jpg" only in case; rename one of them"#,
            r#"image "val/gone.jpg": there is no such file"#,
        ],
        "bad"
    );
    assert_eq!(
        found.objects,
        [
            "annotation 108 person Regular 0 0 1 1",
            "annotation 101 person Regular 0 0 1 1",
        ],
        "objects of the images that stay"
    );
    assert_eq!(
        found.files,
        [format!("{INDEX} (index)")],
        "a refused image is not one of the other files"
    );
    let part: Value = serde_json::from_str(&subset(&source, INDEX, |_| true)).unwrap();
    let ids: Vec<_> = part["images"]
        .as_array()
        .unwrap()
        .iter()
        .map(|i| i["id"].to_string())
        .collect();
    assert_eq!(ids, ["0", "1", "8", "9"], "no refused image is written");
}

#[test]
fn a_broken_index_is_one_clear_error() {
    let dir = tempfile::tempdir().unwrap();
    put_images(dir.path(), &["a.jpg"]);
    let whole = index(&json!([])).to_string();
    let deep = |open: &str| format!("{{\"images\": [], \"x\": {}", open.repeat(1_000_000));
    let twice = whole.replacen("{\"info\"", "{\"images\":[],\"info\"", 1);
    for (text, said) in [
        ("", "from byte 0 on: the file has no content"),
        ("not json", "from byte 0 on: expected a list or an object"),
        (
            "[]",
            "it is one list, as results are; ground truth is an object",
        ),
        ("3", "expected a list or an object"),
        ("{}", "it has no list \"images\""),
        ("{\"images\": 3}", "it has no list \"images\""),
        (
            r#"{"images": [], "annotations": []}"#,
            "it has no list \"categories\"",
        ),
        (&whole[..whole.len() / 2], "the file ends"),
        (&format!("{whole} x"), "there is more after the end"),
        (&deep("["), "more than 127 levels inside a record"),
        (&deep("{\"a\":"), "more than 127 levels inside a record"),
        (
            &format!("{{\"images\": [{}", "[".repeat(1_000_000)),
            "more than 127 levels inside a record",
        ),
        (
            &whole.replace("2017", "NaN"),
            "NaN and Infinity are no numbers",
        ),
        (&twice, "the list \"images\" occurs twice"),
    ] {
        put(dir.path(), INDEX, text);
        let error = try_open("coco", dir.path()).unwrap_err().to_string();
        let start: String = text.chars().take(60).collect();
        assert!(error.contains(said), "{start}: {error}");
        assert!(error.contains("instances_val.json"), "{error}");
        assert!(!error.contains(char::is_control), "{error:?}");
    }
    put(dir.path(), INDEX, whole.replace("a.jpg", "x.jpg"));
    let error = try_open("coco", dir.path()).unwrap_err().to_string();
    assert!(
        error.contains("none of its 2 images is there; looked in \"val\""),
        "{error}"
    );
}

#[test]
fn several_splits_and_both_conventions_of_folders_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let of = |name: &str, id: usize| {
        json!({
            "images": [{"id": 1, "file_name": name}],
            "annotations": [{"id": id, "image_id": 1, "category_id": 1, "bbox": [0, 0, 1, 1]}],
            "categories": [{"id": 1, "name": "person"}],
        })
        .to_string()
    };
    put(dir.path(), "images/train/1.jpg", "");
    put(dir.path(), "val/1.jpg", "");
    put(dir.path(), "exported/1.jpg", "");
    put(
        dir.path(),
        "annotations/instances_train.json",
        of("1.jpg", 1),
    );
    put(dir.path(), "annotations/instances_val.json", of("1.jpg", 1));
    // The same image again: with the same labels nothing is said, with others it is.
    put(
        dir.path(),
        "annotations/instances_val_again.json",
        of("val/1.jpg", 1),
    );
    put(
        dir.path(),
        "annotations/instances_val_other.json",
        of("val/1.jpg", 2),
    );
    put(dir.path(), "annotations/captions_val.json", "not even json");
    put(
        dir.path(),
        "exported/_annotations.coco.json",
        of("1.jpg", 5),
    );
    let found = contents(&open("coco", dir.path()));
    assert_eq!(
        found.images,
        ["exported/1.jpg", "images/train/1.jpg", "val/1.jpg"],
        "images"
    );
    assert_eq!(
        found.problems,
        [
            "annotations/instances_val.json: \"val/1.jpg\" has other labels in \
             \"annotations/instances_val_other.json\"; those here are taken"
        ],
        "problems"
    );
    assert_eq!(found.objects.len(), 3, "objects");
    assert_eq!(
        found.files[0], "annotations/captions_val.json",
        "not an index"
    );
    assert_eq!(found.files.len(), 6, "{:?}", found.files);

    let alone = contents(&open("coco", &dir.path().join(INDEX)));
    assert_eq!(alone.images, ["val/1.jpg"], "one index");
    assert_eq!(
        alone.files,
        [format!("{INDEX} (index)")],
        "and nothing else"
    );
}

#[test]
fn an_index_that_changed_is_not_written() {
    let dir = tempfile::tempdir().unwrap();
    put_images(dir.path(), &["a.jpg", "b.jpg"]);
    put(dir.path(), INDEX, index(&json!([])).to_string());
    let source = open("coco", dir.path());
    let mut other = index(&json!([]));
    other["images"].as_array_mut().unwrap().pop();
    put(dir.path(), INDEX, other.to_string());
    let file = source.files().next().unwrap().unwrap();
    let error = source
        .subset(&file, &mut |_| true, &mut Vec::new())
        .unwrap_err();
    assert!(error.to_string().contains("it changed since"), "{error}");
}

#[test]
fn values_are_written_with_their_own_characters() {
    let dir = tempfile::tempdir().unwrap();
    put_images(dir.path(), &["a.jpg", "b.jpg"]);
    let text = r#"{"x": 1.50, "annotations": [ {"id": 1, "image_id":3, "category_id": 1,"bbox":[0.10,0,1e0,1], "\u00e9": 0.1000 } ,
        {"id":2,"image_id":7,"category_id":1,"bbox":[0,0,1,1]}], "categories":[ {"id":1,"name":"a"}],
        "images":[{"id":3, "file_name":"a.jpg"},{"id":7,"file_name":"b.jpg"}]}"#;
    put(dir.path(), INDEX, text);
    let part = subset(&open("coco", dir.path()), INDEX, |name| name == "val/a.jpg");
    let expected = "{\"x\":1.50,\n\"annotations\":[\n{\"id\": 1, \"image_id\":3, \"category_id\": 1,\"bbox\":[0.10,0,1e0,1], \"\\u00e9\": 0.1000 }],\n\"categories\":[ {\"id\":1,\"name\":\"a\"}],\n\"images\":[\n{\"id\":3, \"file_name\":\"a.jpg\"}]}\n";
    assert_eq!(part, expected, "a part");
}
