//! Links and pipes in the folders that `starbreak generate` and `verify` read: what is read is known by its
//! real path, and for a pipe nothing waits.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::program::{
    Outcome, SMALL, command, folder, names, skipped, snapshot, starbreak, write_photo,
};

/// The command, which a link must not keep from ending.
fn generate(dir: &Path, source: &str, out: &str, more: &[&str]) -> Outcome {
    let args = [
        &["generate", source, "-o", out, "--max-failures", "9"],
        more,
        &SMALL,
    ]
    .concat();
    starbreak(dir, &args)
}

fn write_photos(folder: &Path, n: usize) {
    fs::create_dir_all(folder).unwrap();
    for k in 0..n {
        write_photo(&folder.join(format!("{k:06}.png")));
    }
}

fn write_kitti(root: &Path, images: &Path, n: usize) {
    write_photos(images, n);
    fs::create_dir_all(root.join("label_2")).unwrap();
    for k in 0..n {
        let label = "Car 0 0 0 1 1 20 20 1 1 1 1 1 1 1\n";
        fs::write(root.join(format!("label_2/{k:06}.txt")), label).unwrap();
    }
    symlink(fs::canonicalize(images).unwrap(), root.join("image_2")).unwrap();
}

#[test]
fn a_link_out_of_a_plain_folder_is_a_bad_record_unless_it_is_to_be_followed() {
    let dir = folder();
    write_photos(&dir.path().join("elsewhere"), 2);
    write_photos(&dir.path().join("in/inner"), 1);
    symlink("..", dir.path().join("in/up")).unwrap();
    symlink("inner", dir.path().join("in/same")).unwrap();
    symlink("nowhere.png", dir.path().join("in/dangling.png")).unwrap();
    symlink("../elsewhere/000001.png", dir.path().join("in/linked.png")).unwrap();

    let stopped = generate(dir.path(), "folder:in", "out", &[]);
    assert_eq!(stopped.code, Some(2), "{stopped:?}");
    for word in [
        "3 bad records",
        "\"up\"",
        "\"linked.png\"",
        "--follow-links",
    ] {
        let word = word.trim_matches('"');
        assert!(stopped.stderr.contains(word), "{word}: {stopped:?}");
    }
    assert!(!dir.path().join("out").exists(), "nothing is written");

    let skipped = generate(dir.path(), "folder:in", "out", &["--on-error", "skip"]);
    assert_eq!(skipped.code, Some(0), "{skipped:?}");
    let images: Vec<String> = names(&dir.path().join("out"))
        .into_iter()
        .filter(|name| name.ends_with(".png") && !name.starts_with("starbreak"))
        .collect();
    assert_eq!(
        images,
        ["inner/000000.png", "same/000000.png"],
        "what is inside"
    );
}

#[test]
fn links_are_followed_on_demand_and_never_into_the_output() {
    let dir = folder();
    write_photos(&dir.path().join("elsewhere"), 2);
    write_photos(&dir.path().join("in"), 1);
    symlink("../elsewhere/000001.png", dir.path().join("in/linked.png")).unwrap();
    symlink("../elsewhere", dir.path().join("in/folder")).unwrap();
    symlink(".", dir.path().join("in/self")).unwrap();
    let more = ["--on-error", "skip", "--follow-links"];
    let outcome = generate(dir.path(), "folder:in", "out", &more);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    for name in ["000000.png", "linked.png", "folder/000000.png"] {
        let path = dir.path().join("out").join(name);
        assert!(
            path.is_file() && !path.is_symlink(),
            "{name}: a file of its own"
        );
    }

    // All that lies beside the source is read: the output would be, too.
    symlink("..", dir.path().join("in/up")).unwrap();
    for out in ["out2", "out", "elsewhere/out"] {
        let outcome = generate(dir.path(), "folder:in", out, &more);
        assert_eq!(outcome.code, Some(2), "{out}: {outcome:?}");
        assert!(outcome.stderr.contains("lie in each other"), "{outcome:?}");
    }
    assert!(!dir.path().join("out2").exists(), "nothing is written");
}

#[test]
fn a_single_image_that_lies_in_the_output_is_seen() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 2);
    let outcome = generate(dir.path(), "folder:in", "out", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    write_photos(&dir.path().join("in2"), 1);
    symlink("../out/000001.png", dir.path().join("in2/a.png")).unwrap();
    let outcome = generate(dir.path(), "folder:in2", "out", &["--follow-links"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.contains("lie in each other"), "{outcome:?}");
}

#[test]
fn image_folders_that_are_links_are_read_and_keep_the_output_out_of_them() {
    let dir = folder();
    let root = dir.path().join("kitti");
    let shots = dir.path().join("shots");
    fs::create_dir(&root).unwrap();
    write_kitti(&root, &shots, 2);
    let outcome = generate(dir.path(), "kitti:kitti", "out", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(dir.path().join("out/image_2/000001.png").is_file());

    for out in ["shots/cracked", "shots"] {
        let outcome = generate(dir.path(), "kitti:kitti", out, &[]);
        assert_eq!(outcome.code, Some(2), "{out}: {outcome:?}");
        assert!(outcome.stderr.contains("lie in each other"), "{outcome:?}");
    }
    assert_eq!(names(&shots).len(), 2, "nothing is written");
}

#[test]
fn an_index_that_leads_into_the_output_is_refused() {
    let dir = folder();
    let root = dir.path().join("coco");
    fs::create_dir_all(root.join("annotations")).unwrap();
    write_photos(&dir.path().join("shots/val2017"), 1);
    symlink("../shots/val2017", root.join("val2017")).unwrap();
    let index = serde_json::json!({
        "images": [{ "id": 1, "file_name": "000000.png", "width": 160, "height": 100 }],
        "annotations": [],
        "categories": [{ "id": 1, "name": "car" }],
    });
    let index_path = root.join("annotations/instances_val2017.json");
    fs::write(index_path, index.to_string()).unwrap();
    let index = "coco:coco/annotations/instances_val2017.json";
    for (source, out) in [
        ("coco:coco", "shots"),
        ("coco:coco", "shots/val2017/out"),
        (index, "shots"),
        (index, "shots/val2017/out"),
    ] {
        let outcome = generate(dir.path(), source, out, &[]);
        assert_eq!(outcome.code, Some(2), "{source} {out}: {outcome:?}");
        assert!(outcome.stderr.contains("lie in each other"), "{outcome:?}");
    }
    let outcome = generate(dir.path(), "coco:coco", "out", &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn a_pipe_in_the_place_of_a_file_of_a_set_is_named_and_not_waited_for() {
    let dir = folder();
    write_photos(&dir.path().join("in"), 2);
    let made = generate(dir.path(), "folder:in", "out", &[]);
    assert_eq!(made.code, Some(0), "{made:?}");
    let whole = snapshot(&dir.path().join("out"));
    let files = whole.iter().filter(|(_, bytes)| bytes.is_some());
    // The lock is no part of the set.
    let names: Vec<_> = files
        .map(|(path, _)| path.clone())
        .filter(|path| path != Path::new("starbreak/lock"))
        .collect();
    assert!(names.len() > 8, "{names:?}");
    for name in names {
        let path = dir.path().join("out").join(&name);
        let bytes = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        let is_pipe = Command::new("mkfifo").arg(&path).status();
        if !is_pipe.is_ok_and(|status| status.success()) {
            return skipped("there is no mkfifo");
        }
        for verb in [
            &["verify", "out"][..],
            &["verify", "out", "--regenerate", "1"],
        ] {
            let mut child = command(dir.path(), verb)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            let ended = (0..1200).find_map(|_| {
                std::thread::sleep(Duration::from_millis(50));
                child.try_wait().unwrap()
            });
            let _ = child.kill();
            let ended = ended.unwrap_or_else(|| panic!("{verb:?} waits for {name:?}"));
            assert!(!ended.success(), "{verb:?}, {name:?}");
        }
        fs::remove_file(&path).unwrap();
        fs::write(&path, bytes).unwrap();
    }
}
