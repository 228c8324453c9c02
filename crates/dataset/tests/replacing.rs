//! Which files an output takes the place of.
#![expect(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;
use starbreak_dataset::{DatasetError, FileSet, OutputBatch, blake3_hex, listed_files};
use tempfile::TempDir;

fn at(dir: &TempDir, name: &str) -> PathBuf {
    dir.path().join(name)
}

fn write(batch: OutputBatch, path: &Path, bytes: &[u8]) -> Result<(), DatasetError> {
    let mut batch = batch;
    batch.stage(path, bytes)?;
    batch.commit()
}

fn record(schema: &str, input: &str, seed: u64) -> Vec<u8> {
    let record = json!({ "schema": schema, "input": { "name": input }, "seed": seed });
    record.to_string().into_bytes()
}

#[test]
fn a_file_of_others_stays_and_its_way_out_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let theirs = [
        ("a.png", b"picture".to_vec()),
        ("list.json", b"[]".to_vec()),
        ("other.json", record("theirs/1", "a.png", 1)),
        (
            "network.json",
            record("starbreak.crack-network/1", "a.png", 1),
        ),
        ("b.json", record("starbreak.provenance/2", "b.png", 1)),
    ];
    let own = record("starbreak.provenance/2", "a.png", 2);
    for (name, bytes) in theirs {
        let path = at(&dir, name);
        fs::write(&path, &bytes).unwrap();
        let error = write(OutputBatch::new(), &path, &own).unwrap_err();
        assert!(
            matches!(error, DatasetError::Taken { .. }),
            "{name}: {error}"
        );
        assert!(error.to_string().contains("--replace"), "{error}");
        // Of records of ours that is said once the output is known.
        let is_ours = name == "network.json" || name == "b.json";
        let early = OutputBatch::new().may_write(&path);
        assert_eq!(early.is_ok(), is_ours, "{name}: before the work");
        assert!(
            OutputBatch::new().reserve(&path).is_err(),
            "{name}: for another program"
        );
        assert_eq!(fs::read(&path).unwrap(), bytes, "{name}: as it was");
        write(OutputBatch::new().replacing(true), &path, &own).unwrap();
        assert_eq!(fs::read(&path).unwrap(), own, "{name}: replaced on demand");
    }
}

#[cfg(unix)]
#[test]
fn a_link_of_others_stays() {
    let dir = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("nowhere", at(&dir, "link")).unwrap();
    let error = write(OutputBatch::new(), &at(&dir, "link"), b"x").unwrap_err();
    assert!(matches!(error, DatasetError::Taken { .. }), "{error}");
}

#[test]
fn the_same_bytes_and_a_record_for_the_same_purpose_are_ours() {
    let dir = tempfile::tempdir().unwrap();
    let path = at(&dir, "a.json");
    for seed in [1, 2, 2] {
        let bytes = record("starbreak.provenance/2", "a.png", seed);
        write(OutputBatch::new(), &path, &bytes).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes, "seed {seed}");
    }
    write(
        OutputBatch::new(),
        &path,
        &record("starbreak.provenance/3", "a.png", 2),
    )
    .unwrap();
}

#[test]
fn an_input_stays_whatever_is_allowed() {
    let dir = tempfile::tempdir().unwrap();
    let path = at(&dir, "a.png");
    fs::write(&path, b"photo").unwrap();
    fs::hard_link(&path, at(&dir, "again.png")).unwrap();
    for name in ["a.png", "again.png", "./a.png"] {
        let batch = OutputBatch::new().replacing(true);
        let batch = batch.never_over(FileSet::of(std::slice::from_ref(&path)));
        let error = write(batch, &at(&dir, name), b"photo").unwrap_err();
        assert!(
            matches!(error, DatasetError::OutputIsInput { .. }),
            "{name}: {error}"
        );
    }
}

#[test]
fn what_a_list_has_is_replaced_or_removed_unless_it_was_altered_since() {
    let dir = tempfile::tempdir().unwrap();
    let list = at(&dir, "written.json");
    let run = |files: &[(&str, &str)]| -> Result<(), DatasetError> {
        let mut batch = OutputBatch::new().with_list(&list, "test");
        for (name, text) in files {
            batch.stage(&at(&dir, name), text.as_bytes())?;
        }
        batch.commit()
    };
    run(&[
        ("1.png", "a"),
        ("2.png", "a"),
        ("sub/3.png", "a"),
        ("4.png", "a"),
    ])
    .unwrap();
    fs::write(at(&dir, "4.png"), "altered").unwrap();
    fs::write(at(&dir, "5.png"), "theirs").unwrap();
    run(&[("1.png", "b")]).unwrap();
    let is_there = |name: &&str| at(&dir, name).exists();
    let left: Vec<&str> = ["1.png", "2.png", "sub/3.png", "4.png", "5.png"]
        .into_iter()
        .filter(is_there)
        .collect();
    assert_eq!(
        left,
        ["1.png", "4.png", "5.png"],
        "replaced, altered, of others"
    );
    for name in ["4.png", "5.png"] {
        assert!(run(&[("1.png", "c"), (name, "c")]).is_err(), "{name}");
    }
    assert_eq!(
        fs::read(at(&dir, "1.png")).unwrap(),
        b"b",
        "nothing half done"
    );
    let other = OutputBatch::new().with_list(&list, "another");
    assert!(
        write(other, &at(&dir, "1.png"), b"d").is_err(),
        "the list of another verb"
    );
}

#[test]
fn a_record_lists_what_it_says_that_was_written_and_no_inputs() {
    let dir = tempfile::tempdir().unwrap();
    let path = at(&dir, "a.json");
    let file = |name: &str| json!({ "name": name, "blake3": blake3_hex(name.as_bytes()) });
    let record = json!({
        "schema": "starbreak.provenance/2",
        "input": file("a.png"),
        "overlay": file("glass.png"),
        "output": file("a.jpg"),
        "region": file("../b.png"),
        "maps": [file("a.added.npy"), { "name": "no hash" }],
    });
    fs::write(&path, record.to_string()).unwrap();
    let names = |schema: &str, input: &str| -> Vec<String> {
        let files = listed_files(&path, schema, Some(input));
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let mut names: Vec<String> = files.iter().map(|(path, _)| name(path)).collect();
        names.sort_unstable();
        names
    };
    let listed = names("starbreak.provenance/2", "a.png");
    assert_eq!(listed, ["a.added.npy", "a.jpg"], "files in its folder");
    assert!(
        names("starbreak.provenance/2", "b.png").is_empty(),
        "of another input"
    );
    assert!(
        names("starbreak.track/1", "a.png").is_empty(),
        "of another kind"
    );
}

#[test]
fn a_generated_set_is_no_place_for_other_files() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(at(&dir, "starbreak")).unwrap();
    fs::write(at(&dir, "starbreak/run.json"), "{}").unwrap();
    for name in ["a.json", "deep/er/a.json"] {
        let batch = OutputBatch::new().replacing(true);
        let error = write(batch, &at(&dir, name), b"x").unwrap_err();
        assert!(
            matches!(error, DatasetError::InsideSet { .. }),
            "{name}: {error}"
        );
    }
}
