//! What a generated set keeps and when it is finished.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::fs;

use serde_json::json;
use starbreak_dataset::{DatasetError, GeneratedSet, ItemRecord, SET_SCHEMA, blake3_hex};

/// Puts the files of an image without masks, and gives its line.
fn put(set: &GeneratedSet, name: &str) -> ItemRecord {
    let files = set.layout().files_of(name, 0);
    let image = name.as_bytes();
    let record = json!({
        "item": { "sample_index": 0 },
        "input": { "name": name, "blake3": "0" },
        "output": { "name": name, "blake3": blake3_hex(image) },
    });
    let record = record.to_string();
    let mut batch = set.batch();
    batch
        .stage(&set.layout().path(&files.image), image)
        .unwrap();
    batch
        .stage(&set.layout().path(&files.provenance), record.as_bytes())
        .unwrap();
    batch.commit().unwrap();
    ItemRecord {
        name: name.to_owned(),
        sample: 0,
        input_blake3: "0".to_owned(),
        image_blake3: blake3_hex(image),
        region_blake3: None,
        crack_blake3: None,
        provenance_blake3: blake3_hex(record.as_bytes()),
    }
}

#[test]
fn only_what_was_noted_as_it_is_counts_as_done() {
    let dir = tempfile::tempdir().unwrap();
    let identity = json!({ "schema": SET_SCHEMA, "samples": 1 });
    let set = GeneratedSet::begin(dir.path(), 1, &identity).unwrap();
    let line = put(&set, "a.png");
    assert_eq!(set.done("a.png", 0).unwrap(), None, "not noted yet");
    set.note_made(&line).unwrap();
    assert_eq!(set.done("a.png", 0).unwrap(), Some(line.clone()), "noted");
    drop(set);

    // As after a kill, and after the end.
    for is_finished in [false, true] {
        let set = GeneratedSet::begin(dir.path(), 1, &identity).unwrap();
        assert_eq!(
            set.done("a.png", 0).unwrap(),
            Some(line.clone()),
            "{is_finished}"
        );
        let mut items = std::iter::once(Ok(line.clone()));
        set.finish(&mut items, &[], 1, [0, 0]).unwrap();
        assert!(
            !dir.path().join("starbreak/made.jsonl").exists(),
            "{is_finished}: in the list"
        );
    }
    let record = dir.path().join("starbreak/provenance/a.json");
    let text = fs::read_to_string(&record).unwrap();
    fs::write(&record, text.replace("\"0\"", "\"1\"")).unwrap();
    let set = GeneratedSet::begin(dir.path(), 1, &identity).unwrap();
    assert_eq!(set.done("a.png", 0).unwrap(), None, "it says otherwise now");
}

#[test]
fn a_set_that_lost_an_image_is_not_finished() {
    let dir = tempfile::tempdir().unwrap();
    let identity = json!({ "schema": SET_SCHEMA, "samples": 1 });
    let set = GeneratedSet::begin(dir.path(), 1, &identity).unwrap();
    let line = put(&set, "a.png");
    for (n_taken, n_failed) in [(3, 1), (1, 1), (0, 0)] {
        let mut items = std::iter::once(Ok(line.clone()));
        let error = set
            .finish(&mut items, &[], n_taken, [n_failed, 0])
            .unwrap_err();
        assert!(
            matches!(error, DatasetError::LostItems { n_items: 1, .. }),
            "{error}"
        );
        assert!(
            !dir.path().join("starbreak/manifest.json").exists(),
            "{n_taken}"
        );
    }
    let mut items = std::iter::once(Ok(line));
    let manifest = set.finish(&mut items, &[], 3, [2, 0]).unwrap();
    assert_eq!((manifest.n_items, manifest.n_failed), (1, 2));
}
