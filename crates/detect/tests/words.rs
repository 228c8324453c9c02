//! Contracts and label maps as people write them: what is wrong is named with the way out.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot read its text has failed"
)]

use std::time::{Duration, Instant};

use starbreak_detect::{ClassNames, Contract, LabelMap, LabelRules, preset_names};

#[track_caller]
fn assert_says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{text:?} does not say {part:?}");
    }
    assert!(!text.contains('\n'), "one line: {text:?}");
}

fn refusal(text: &str) -> String {
    Contract::parse("mine.toml", text).unwrap_err().to_string()
}

#[test]
fn every_preset_is_read_and_names_its_classes() {
    for name in preset_names() {
        let contract = Contract::preset(name).unwrap();
        let n = contract.classes.names.len();
        assert!(n == 80 || n == 91, "{name} lists {n} classes");
        assert_eq!(
            contract.classes.names.iter().flatten().count(),
            80,
            "{name}"
        );
    }
    assert_eq!(
        ClassNames::coco_number("toothbrush"),
        Some(90),
        "COCO's numbers have gaps"
    );
    assert_eq!(ClassNames::coco_number("crack"), None, "no class of COCO");
}

#[test]
fn a_contract_begins_as_a_preset_and_says_what_differs() {
    let text =
        "schema = 1\npreset = \"yolov8\"\n[classes]\nnames = [\"car\", \"-\"]\n[nms]\niou = 0.45\n";
    let contract = Contract::parse("mine.toml", text).unwrap();
    let preset = Contract::preset("yolov8").unwrap();
    assert_eq!(contract.input, preset.input, "what is not said stays");
    assert_eq!(
        contract.classes.names,
        [Some("car".to_owned()), None],
        "its own classes"
    );
    let nms = contract.nms.unwrap();
    assert!((nms.iou - 0.45).abs() < 1e-6, "{nms:?}");
    assert_eq!(
        Some(nms.max_candidates),
        preset.nms.map(|nms| nms.max_candidates),
        "laid over"
    );
}

#[test]
fn what_is_wrong_in_a_contract_is_named_with_its_key_and_the_nearest_word() {
    let with = |more: &str| refusal(&format!("schema = 1\npreset = \"yolox\"\n{more}"));
    assert_says(
        &with("[input]\ncolour = \"bgr\""),
        &["mine.toml", "input.colour", "\"color\""],
    );
    assert_says(
        &with("[input]\nresize = \"leterbox\""),
        &["input.resize", "\"letterbox\""],
    );
    assert_says(&with("[inputs]\ncolor = 1"), &["inputs", "\"input\""]);
    assert_says(&with("[nms]\niou = 1.5"), &["nms.iou", "1.5", "0 to 1"]);
    assert_says(&with("[nms]\niou = nan"), &["nms.iou", "NaN"]);
    assert_says(
        &with("[input]\nstd = [1, 2]"),
        &["input.std", "three numbers"],
    );
    assert_says(
        &with("[input]\nstd = [0, 1, 1]"),
        &["input.std", "0 is not in"],
    );
    assert_says(
        &with("[classes]\nlist = \"coco80\""),
        &["classes.list", "coco-80"],
    );
    assert_says(&with("[classes]\nnames = []"), &["classes.names", "empty"]);
    assert_says(
        &refusal("schema = 1\npreset = \"yolov9\""),
        &["yolov8", "no preset"],
    );
    assert_says(
        &refusal("preset = \"yolov8\"\nschema = 2"),
        &["schema", "2"],
    );
    assert_says(&refusal("schema = 1"), &["input", "missing", "preset"]);
    assert_says(&refusal("schema = \n"), &["line 1", "no TOML"]);
}

#[test]
fn classes_meet_categories_by_name_and_the_choice_for_kitti_and_bdd() {
    let classes = ClassNames::new(
        "a test",
        ["person", "traffic light", "bicycle", "train", "-"],
    );
    let kitti = ["Car", "Pedestrian", "Cyclist", "Tram"];
    let rules = LabelRules::of_dataset("kitti").unwrap();
    let map = LabelMap::new(&classes, &kitti, &rules).unwrap();
    let places: Vec<Option<u32>> = (0..5).map(|class| map.category(class)).collect();
    assert_eq!(
        places,
        [Some(1), None, None, Some(3), None],
        "person and train"
    );
    assert_eq!(
        map.unmapped_classes(),
        ["traffic light", "bicycle"],
        "said out loud"
    );
    assert_eq!(
        map.unmapped_categories(),
        ["Car", "Cyclist"],
        "said out loud"
    );
    let bdd = ["pedestrian", "rider", "Traffic_Light", "bicycle"];
    let rules = LabelRules::of_dataset("bdd").unwrap();
    let map = LabelMap::new(&classes, &bdd, &rules).unwrap();
    let places: Vec<Option<u32>> = (0..4).map(|class| map.category(class)).collect();
    assert_eq!(
        places,
        [Some(0), Some(2), Some(3), None],
        "spaces and case do not matter"
    );
}

#[test]
fn a_label_map_of_ones_own_must_name_what_there_is() {
    let classes = ClassNames::new("a test", ["truck", "bus"]);
    let dataset = ["Car", "Truck"];
    let map = |text: &str| {
        let rules = LabelRules::parse("map.toml", &format!("schema = 1\n{text}"))?;
        LabelMap::new(&classes, &dataset, &rules)
    };
    let read = map("[map]\nbus = \"Car\"\ntruck = \"-\"").unwrap();
    assert_eq!(
        [read.category(0), read.category(1)],
        [None, Some(0)],
        "dropped, and renamed"
    );
    let error = |text: &str| map(text).unwrap_err().to_string();
    assert_says(
        &error("[map]\ntruk = \"Car\""),
        &["map.toml", "\"truk\"", "\"truck\""],
    );
    assert_says(
        &error("[map]\nbus = \"Cars\""),
        &["no category \"Cars\"", "\"Car\""],
    );
    assert_says(&error("[maps]\nbus = \"Car\""), &["\"maps\"", "\"map\""]);
    assert_says(&error("[map]\nbus = 3"), &["quotes"]);
    assert_says(
        &error("[map]\nbus = \"-\"\ntruck = \"-\""),
        &["no class of the model", "--label-map"],
    );
}

#[test]
fn classes_find_their_categories_in_little_time() {
    let names: Vec<String> = (0..20_000).map(|k| format!("Some class {k}")).collect();
    let classes = ClassNames::new("a test", names.iter().map(String::as_str));
    let lower: Vec<String> = names.iter().rev().map(|name| name.to_lowercase()).collect();
    let categories: Vec<&str> = lower.iter().map(String::as_str).collect();
    let started = Instant::now();
    let map = LabelMap::new(&classes, &categories, &LabelRules::none()).unwrap();
    assert_eq!(map.category(0), Some(19_999), "the first is the last");
    assert!(map.unmapped_categories().is_empty(), "all are reached");
    let took = started.elapsed();
    assert!(took < Duration::from_secs(5), "{took:?}");
}
