//! `starbreak generate`: layout, labels, records, selections, shards, and going on.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::program::{
    SMALL, all_refused, folder, json, names, snapshot, starbreak, succeed, write_photo,
};
use serde_json::Value;

/// A KITTI-like set of `n` small frames with a label each.
fn write_kitti(root: &Path, n: usize) {
    for sub in ["image_2", "label_2", "calib", "ImageSets"] {
        fs::create_dir_all(root.join(sub)).unwrap();
    }
    for k in 0..n {
        write_photo(&root.join(format!("image_2/{k:06}.png")));
        let label = format!(
            "Car 0.00 0 -1.58 {}.00 30.00 90.00 70.00 1.65 1.67 3.64 -0.65 1.71 46.70 -1.59\n\
             DontCare -1 -1 -10 1.00 1.00 9.00 9.00 -1 -1 -1 -1000 -1000 -1000 -10\n",
            20 + k % 5
        );
        fs::write(root.join(format!("label_2/{k:06}.txt")), label).unwrap();
        fs::write(root.join(format!("calib/{k:06}.txt")), "P0: 1 2 3\n").unwrap();
    }
    fs::write(root.join("ImageSets/val.txt"), "000000\n000001\n").unwrap();
}

/// `generate` of `kitti:in` with the small crack and more arguments.
fn generate(dir: &Path, out: &str, more: &[&str]) -> crate::program::Outcome {
    let args = [&["generate", "kitti:in", "-o", out], more, &SMALL].concat();
    succeed(dir, &args)
}

fn lines(path: &Path) -> Vec<Value> {
    let text = fs::read_to_string(path).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[test]
fn a_set_keeps_layout_names_and_labels_of_its_source() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 4);
    generate(dir.path(), "out", &[]);
    let (source, set) = (
        snapshot(&dir.path().join("in")),
        snapshot(&dir.path().join("out")),
    );
    for (path, content) in &source {
        let made = set
            .get(path)
            .unwrap_or_else(|| panic!("{path:?} is missing"));
        if path.starts_with("image_2") && content.is_some() {
            assert_ne!(made, content, "{path:?} is cracked");
        } else {
            assert_eq!(made, content, "{path:?} is carried over byte for byte");
        }
    }
    for sub in ["regions", "cracks"] {
        for k in 0..4 {
            let mask = dir
                .path()
                .join(format!("out/starbreak/{sub}/image_2/{k:06}.png"));
            let mask = crate::program::raw_png(&mask);
            assert_eq!(mask.size, (160, 100), "as large as its image");
            assert!(
                mask.data.iter().any(|code| *code > 0),
                "{sub}: something is broken"
            );
        }
    }
    let known: Vec<_> = set
        .keys()
        .filter(|path| !path.starts_with("starbreak"))
        .collect();
    assert_eq!(
        known.len(),
        source.len(),
        "nothing else beside them: {known:?}"
    );
}

#[test]
fn records_and_lists_hold_the_hashes_of_all_files() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 3);
    generate(dir.path(), "out", &["--seed", "5"]);
    let out = dir.path().join("out");
    let items = lines(&out.join("starbreak/items.jsonl"));
    assert_eq!(items.len(), 3, "one line for each image");
    for item in &items {
        let name = item["name"].as_str().unwrap();
        let stem = name.trim_end_matches(".png");
        let hash = |path: String| starbreak_dataset::blake3_hex(&fs::read(path).unwrap());
        let root = out.display();
        assert_eq!(
            item["image_blake3"],
            hash(format!("{root}/{name}")),
            "{name}"
        );
        assert_eq!(
            item["region_blake3"],
            hash(format!("{root}/starbreak/regions/{name}")),
            "{name}"
        );
        assert_eq!(
            item["crack_blake3"],
            hash(format!("{root}/starbreak/cracks/{name}")),
            "{name}"
        );
        let record = out.join(format!("starbreak/provenance/{stem}.json"));
        assert_eq!(
            item["provenance_blake3"],
            hash(record.display().to_string()),
            "{name}"
        );
        let record = json(&record);
        assert_eq!(record["input"]["blake3"], item["input_blake3"], "{name}");
        assert_eq!(record["output"]["blake3"], item["image_blake3"], "{name}");
        assert_eq!(record["seed"], 5, "{name}");
        let objects = record["objects"].as_array().unwrap();
        assert_eq!(objects.len(), 2, "{name}: both labels");
        assert_eq!(objects[0]["category"], "Car", "{name}");
        assert_eq!(
            objects[0]["record"],
            format!("label_2/{}.txt:1", &stem[8..]),
            "{name}"
        );
        assert_eq!(objects[1]["kind"], "ignored", "{name}");
        let share = objects[0]["damage"]["region_share"].as_f64().unwrap();
        assert!((0.0..=1.0).contains(&share), "{name}: {share}");
    }
    let manifest = json(&out.join("starbreak/manifest.json"));
    assert_eq!(manifest["n_items"], 3, "{manifest}");
    assert_eq!(
        manifest["n_files"], 7,
        "three labels, three calibrations, one split"
    );
}

/// The region share in a record is that of the mask, counted here.
#[test]
fn damage_is_what_the_masks_say() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 3);
    generate(dir.path(), "out", &[]);
    for k in 0..3 {
        let record = json(
            &dir.path()
                .join(format!("out/starbreak/provenance/image_2/{k:06}.json")),
        );
        let region = crate::program::raw_png(
            &dir.path()
                .join(format!("out/starbreak/regions/image_2/{k:06}.png")),
        );
        let object = &record["objects"][0];
        let corner = |c: usize| object["box_px"][c].as_f64().unwrap();
        let (mut n, mut n_region) = (0.0, 0.0);
        for y in 0..100_u32 {
            for x in 0..160_u32 {
                let (cx, cy) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                if cx >= corner(0) && cx < corner(2) && cy >= corner(1) && cy < corner(3) {
                    n += 1.0;
                    n_region += f64::from(u8::from(region.data[(y * 160 + x) as usize] > 0));
                }
            }
        }
        let found = object["damage"]["region_share"].as_f64().unwrap();
        assert!(
            (found - n_region / n).abs() < 1e-6,
            "{k}: {found}, not {}",
            n_region / n
        );
        let whole: f64 = region
            .data
            .iter()
            .map(|code| f64::from(u8::from(*code > 0)))
            .sum();
        let fraction = record["region_fraction"].as_f64().unwrap();
        assert!((fraction - whole / 16000.0).abs() < 1e-9, "{k}");
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 6);
    generate(dir.path(), "one", &["--threads", "1"]);
    generate(dir.path(), "three", &["--threads", "3"]);
    assert!(
        snapshot(&dir.path().join("one")) == snapshot(&dir.path().join("three")),
        "the sets differ"
    );
}

#[test]
fn several_samples_are_whole_trees_with_cracks_of_their_own() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 2);
    generate(dir.path(), "out", &["--samples", "3"]);
    generate(dir.path(), "single", &[]);
    let read = |path: &str| fs::read(dir.path().join(path)).unwrap();
    let images: Vec<_> = (0..3)
        .map(|k| read(&format!("out/sample_{k}/image_2/000001.png")))
        .collect();
    assert!(
        images[0] != images[1] && images[1] != images[2],
        "each has its own crack"
    );
    assert_eq!(
        images[0],
        read("single/image_2/000001.png"),
        "the first is the one of a set of one"
    );
    for k in 0..3 {
        assert_eq!(
            read(&format!("out/sample_{k}/label_2/000001.txt")),
            read("in/label_2/000001.txt")
        );
        assert!(
            dir.path()
                .join(format!(
                    "out/starbreak/regions/sample_{k}/image_2/000000.png"
                ))
                .is_file()
        );
    }
    succeed(dir.path(), &["verify", "out"]);
}

#[test]
fn a_selection_takes_its_images_with_their_labels() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 9);
    generate(dir.path(), "limit", &["--limit", "4"]);
    let of = |out: &str, sub: &str| names(&dir.path().join(out).join(sub));
    let first: Vec<_> = (0..4).map(|k| format!("{k:06}.png")).collect();
    assert_eq!(of("limit", "image_2"), first);
    assert_eq!(of("limit", "label_2").len(), 4, "labels of these only");

    generate(dir.path(), "sample", &["--sample", "4", "--seed", "1"]);
    generate(dir.path(), "again", &["--sample", "4", "--seed", "1"]);
    generate(dir.path(), "other", &["--sample", "4", "--seed", "2"]);
    assert_eq!(of("sample", "image_2").len(), 4);
    assert_eq!(of("sample", "image_2"), of("again", "image_2"));
    assert_ne!(
        of("sample", "image_2"),
        of("other", "image_2"),
        "by the seed"
    );
    let one = of("sample", "image_2")[0].clone();
    generate(dir.path(), "all", &["--seed", "1"]);
    let read = |out: &str| fs::read(dir.path().join(out).join("image_2").join(&one)).unwrap();
    assert_eq!(
        read("sample"),
        read("all"),
        "the crack depends on the image alone"
    );
}

#[test]
fn merged_shards_are_the_set_of_one_run() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 11);
    generate(dir.path(), "whole", &[]);
    let parts: Vec<String> = (1..=3).map(|k| format!("part{k}")).collect();
    for (k, part) in (1..).zip(&parts) {
        generate(dir.path(), part, &["--shard", &format!("{k}/3")]);
    }
    let sizes: Vec<_> = parts
        .iter()
        .map(|part| names(&dir.path().join(part).join("image_2")).len())
        .collect();
    assert_eq!(
        sizes.iter().sum::<usize>(),
        11,
        "each image once: {sizes:?}"
    );
    let mut merge = vec!["merge", "-o", "merged"];
    // In any order.
    merge.extend(parts.iter().rev().map(String::as_str));
    succeed(dir.path(), &merge);
    assert!(
        snapshot(&dir.path().join("merged")) == snapshot(&dir.path().join("whole")),
        "the merged set differs from the whole one"
    );
    succeed(dir.path(), &["verify", "merged"]);

    generate(dir.path(), "alien", &["--shard", "2/3", "--seed", "9"]);
    all_refused(
        dir.path(),
        &[
            (
                vec!["merge", "-o", "m2", "part1", "part2"],
                "number 3 of 3 is missing",
            ),
            (
                vec!["merge", "-o", "m2", "part1", "part2", "part2"],
                "there twice",
            ),
            (vec!["merge", "-o", "m2", "part1", "alien", "part3"], "seed"),
            (
                vec!["merge", "-o", "m2", "part1", "whole", "part3"],
                "not a shard",
            ),
            (
                vec!["merge", "-o", "part1/x", "part1", "part2", "part3"],
                "lie in each other",
            ),
        ],
    );
}

#[test]
fn a_shard_that_was_altered_is_not_merged() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 6);
    generate(dir.path(), "whole", &[]);
    let shard = |k: u32| {
        generate(
            dir.path(),
            &format!("p{k}"),
            &["--shard", &format!("{k}/2")],
        )
    };
    for k in 1..=2 {
        shard(k);
    }
    let merge = ["merge", "-o", "merged", "p1", "p2"];
    for folder in ["image_2", "starbreak/provenance/image_2", "label_2"] {
        let folder = dir.path().join("p2").join(folder);
        let file = folder.join(&names(&folder)[0]);
        let mut bytes = fs::read(&file).unwrap();
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        // A file of its own: the merged set may have another name of it.
        fs::remove_file(&file).unwrap();
        fs::write(&file, bytes).unwrap();
        let refused = starbreak(dir.path(), &merge);
        let complaint = refused.complaint("is not what the lists of its shard say");
        assert_eq!(complaint, None, "{folder:?}");
        let begun = dir.path().join("merged").exists();
        assert!(!begun, "refused before anything is written: {folder:?}");
        shard(2);
    }
    succeed(dir.path(), &merge);
    assert!(
        snapshot(&dir.path().join("merged")) == snapshot(&dir.path().join("whole")),
        "mended, in the same folder"
    );
    // A list that was cut at the end of a line.
    for list in ["items.jsonl", "files.jsonl"] {
        let path = dir.path().join("p2/starbreak").join(list);
        let whole = fs::read_to_string(&path).unwrap();
        fs::write(&path, &whole[..=whole.find('\n').unwrap()]).unwrap();
        let merge = ["merge", "-o", "m2", "p1", "p2"].to_vec();
        all_refused(
            dir.path(),
            &[(merge, "not the one that the manifest means")],
        );
        fs::write(&path, whole).unwrap();
    }
}

#[test]
fn a_set_that_is_gone_on_with_is_not_finished_until_it_is() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 3);
    generate(dir.path(), "out", &[]);
    let manifest = dir.path().join("out/starbreak/manifest.json");
    let finished = fs::read(&manifest).unwrap();
    let image = dir.path().join("in/image_2/000001.png");
    let photo = fs::read(&image).unwrap();
    fs::write(&image, &photo[..photo.len() / 2]).unwrap();
    let again = [
        &["generate", "kitti:in", "-o", "out", "--fail-fast"][..],
        &SMALL,
    ]
    .concat();
    assert_eq!(starbreak(dir.path(), &again).code, Some(1), "it fails");
    assert!(!manifest.exists(), "begun again");
    fs::write(&image, photo).unwrap();
    generate(dir.path(), "out", &[]);
    assert_eq!(fs::read(&manifest).unwrap(), finished, "and finished again");
}

#[test]
fn two_recipes_never_mix_in_one_folder() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 2);
    write_kitti(&dir.path().join("other"), 3);
    generate(dir.path(), "out", &[]);
    let with = |more: &[&'static str]| -> Vec<&str> {
        [&["generate", "kitti:in", "-o", "out"], more, &SMALL].concat()
    };
    let other = [&["generate", "kitti:other", "-o", "out"], &SMALL[..]].concat();
    all_refused(
        dir.path(),
        &[
            (with(&["--seed", "1"]), "seed is 0, here it is 1"),
            (with(&["--set", "output.quality=80"]), "recipe"),
            (with(&["--samples", "2"]), "samples"),
            (with(&["--limit", "1"]), "selection.limit"),
            (other, "names_sha256"),
        ],
    );
    fs::create_dir(dir.path().join("full")).unwrap();
    fs::write(dir.path().join("full/mine.txt"), "mine").unwrap();
    let full = [&["generate", "kitti:in", "-o", "full"], &SMALL[..]].concat();
    all_refused(dir.path(), &[(full, "it is not empty")]);
}

#[test]
fn a_finished_set_is_left_as_it_is_and_a_changed_image_is_made_again() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 3);
    generate(dir.path(), "out", &[]);
    let before = snapshot(&dir.path().join("out"));
    let outcome = generate(dir.path(), "out", &["--json"]);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(
        (&result["n_made"], &result["n_done_before"]),
        (&0.into(), &3.into()),
        "{result}"
    );
    assert!(
        before == snapshot(&dir.path().join("out")),
        "nothing changes"
    );

    let changed = crate::program::png_bytes(&crate::program::photo((120, 90)));
    fs::write(dir.path().join("in/image_2/000001.png"), changed).unwrap();
    let outcome = generate(dir.path(), "out", &["--json"]);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(result["n_made"], 1, "{result}");
    generate(dir.path(), "fresh", &[]);
    assert!(
        snapshot(&dir.path().join("fresh")) == snapshot(&dir.path().join("out")),
        "as if it had been so from the start"
    );
}

#[test]
fn hard_links_and_left_out_files_are_as_asked() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 2);
    generate(dir.path(), "link", &["--other-files", "hard-link"]);
    generate(dir.path(), "skip", &["--other-files", "skip"]);
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        let inode = |path: &str| fs::metadata(dir.path().join(path)).unwrap().ino();
        assert_eq!(
            inode("link/calib/000000.txt"),
            inode("in/calib/000000.txt"),
            "one file"
        );
        assert_ne!(
            inode("link/label_2/000000.txt"),
            inode("in/label_2/000000.txt"),
            "labels are copies"
        );
    }
    assert!(!dir.path().join("skip/calib").exists(), "left out");
    assert_eq!(
        names(&dir.path().join("skip/label_2")).len(),
        2,
        "labels are not"
    );
}

#[test]
fn a_dry_run_writes_a_sheet_and_nothing_else() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 15);
    let outcome = generate(dir.path(), "out", &["--dry-run", "--json"]);
    let result: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(result["n_images"], 15, "{result}");
    assert_eq!(result["n_objects"], 30, "{result}");
    assert!(result["output_bytes"].as_u64().unwrap() > 0, "{result}");
    assert!(!dir.path().join("out").exists(), "nothing is generated");
    let sheet = crate::program::raw_png(&dir.path().join("out.preview.png"));
    assert!(sheet.size.0 > 640, "{:?}", sheet.size);
    let mut left = names(dir.path());
    left.retain(|name| !name.starts_with("in"));
    assert_eq!(left, ["out.preview.png"]);
}

#[test]
fn verify_finds_every_kind_of_damage() {
    let dir = folder();
    write_kitti(&dir.path().join("in"), 3);
    generate(dir.path(), "out", &[]);
    let good = snapshot(&dir.path().join("out"));
    succeed(
        dir.path(),
        &[
            "verify",
            "out",
            "--regenerate",
            "all",
            "--source",
            "kitti:in",
        ],
    );
    let restore = || {
        fs::remove_dir_all(dir.path().join("out")).unwrap();
        let mut files: BTreeMap<_, _> = BTreeMap::new();
        for (path, content) in &good {
            let path = dir.path().join("out").join(path);
            match content {
                None => fs::create_dir_all(path).unwrap(),
                Some(content) => {
                    files.insert(path, content);
                }
            }
        }
        for (path, content) in files {
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, content).unwrap();
        }
    };
    for (path, what) in [
        ("image_2/000001.png", "other bytes"),
        ("label_2/000002.txt", "other bytes"),
        ("starbreak/regions/image_2/000000.png", "other bytes"),
        ("starbreak/provenance/image_2/000000.json", "other bytes"),
        ("starbreak/recipe.toml", "not the one that"),
        (
            "starbreak/items.jsonl",
            "not the one that the manifest means",
        ),
        ("starbreak/run.json", "not the one that the manifest means"),
    ] {
        let file = dir.path().join("out").join(path);
        let mut bytes = fs::read(&file).unwrap();
        let last = bytes.len() - 2;
        bytes[last] ^= 1;
        fs::write(&file, bytes).unwrap();
        let outcome = starbreak(dir.path(), &["verify", "out"]);
        let is_found = outcome.stdout.contains(path) && outcome.stdout.contains(what);
        // A broken identity may also be refused as a whole.
        assert!(
            (outcome.code == Some(1) && is_found)
                || (path.ends_with("run.json") && outcome.code == Some(2)),
            "{path}: {outcome:?}"
        );
        fs::remove_file(&file).unwrap();
        let outcome = starbreak(dir.path(), &["verify", "out"]);
        assert_ne!(outcome.code, Some(0), "{path} is missing: {outcome:?}");
        restore();
    }
    let manifest = dir.path().join("out/starbreak/manifest.json");
    let text = fs::read_to_string(&manifest).unwrap();
    for (was, is) in [
        ("\"n_items\": 3", "\"n_items\": 4"),
        ("\"n_files\": 7", "\"n_files\": 6"),
        ("\"n_skipped\": 0", "\"n_skipped\": 1"),
        ("starbreak.dataset/", "starbreak.dataset/1"),
    ] {
        assert!(text.contains(was), "{was} in {text}");
        fs::write(&manifest, text.replace(was, is)).unwrap();
        let outcome = starbreak(dir.path(), &["verify", "out"]);
        assert_eq!(outcome.code, Some(1), "{is}: {outcome:?}");
        assert!(
            outcome.stdout.contains("manifest.json"),
            "{is}: {outcome:?}"
        );
    }
    restore();
    let run = dir.path().join("out/starbreak/run.json");
    let text = fs::read_to_string(&run).unwrap();
    fs::write(
        &run,
        text.replace("starbreak.dataset/2", "starbreak.dataset/1"),
    )
    .unwrap();
    all_refused(
        dir.path(),
        &[(vec!["verify", "out"], "is of another version")],
    );
    restore();
    fs::write(dir.path().join("out/image_2/stranger.png"), "x").unwrap();
    let outcome = starbreak(dir.path(), &["verify", "out"]);
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(
        outcome.stdout.contains("stranger.png") && outcome.stdout.contains("does not belong"),
        "{outcome:?}"
    );
    restore();
    fs::remove_file(dir.path().join("out/starbreak/manifest.json")).unwrap();
    all_refused(dir.path(), &[(vec!["verify", "out"], "not finished")]);
    restore();
    // Another source of the same names does not come out the same.
    fs::remove_dir_all(dir.path().join("in")).unwrap();
    write_kitti(&dir.path().join("in"), 3);
    let other = crate::program::png_bytes(&crate::program::photo((100, 90)));
    fs::write(dir.path().join("in/image_2/000002.png"), other).unwrap();
    let outcome = starbreak(
        dir.path(),
        &[
            "verify",
            "out",
            "--regenerate",
            "all",
            "--source",
            "kitti:in",
        ],
    );
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(
        outcome.stdout.contains("000002.png") && outcome.stdout.contains("pixels differ"),
        "{outcome:?}"
    );
}

#[test]
fn images_that_lie_on_their_side_stay_so() {
    let dir = folder();
    fs::create_dir(dir.path().join("in")).unwrap();
    // A JPEG that is to be turned by a quarter: SOI, then EXIF with orientation 6.
    let upright = crate::program::jpeg_bytes(&crate::program::photo((96, 64)));
    let mut exif =
        b"\xff\xe1\x00\x22Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"
            .to_vec();
    let mut turned = upright[..2].to_vec();
    turned.append(&mut exif);
    turned.extend(&upright[2..]);
    fs::write(dir.path().join("in/a.jpg"), turned).unwrap();
    let args = [&["generate", "folder:in", "-o", "out"], &SMALL[..]].concat();
    succeed(dir.path(), &args);
    for path in ["out/a.jpg", "out/starbreak/regions/a.png"] {
        let file = starbreak_dataset::read_image(
            &dir.path().join(path),
            &starbreak_dataset::ImageLimits::default(),
        )
        .unwrap();
        let size = (file.pixels.width(), file.pixels.height());
        assert_eq!(
            size,
            (64, 96),
            "{path}: upright when read with its orientation"
        );
        assert_ne!(
            file.orientation,
            image::metadata::Orientation::NoTransforms,
            "{path}: and stored as the source is"
        );
    }
    // The right way up: nearly the picture of the source, but for the crack.
    let upright = |path: &str| {
        let limits = starbreak_dataset::ImageLimits::default();
        let file = starbreak_dataset::read_image(&dir.path().join(path), &limits).unwrap();
        file.pixels.to_luma8()
    };
    let (source, made) = (upright("in/a.jpg"), upright("out/a.jpg"));
    let pairs = source.as_raw().iter().zip(made.as_raw());
    let n_far = pairs.filter(|(a, b)| a.abs_diff(**b) > 40).count();
    assert!(
        n_far < source.as_raw().len() / 4,
        "{n_far} of {} px are other ones",
        source.as_raw().len()
    );
}

#[test]
fn a_hit_before_an_object_is_in_the_middle_of_what_the_frame_shows_of_one() {
    let dir = folder();
    let root = dir.path().join("in");
    write_kitti(&root, 3);
    // One object half beyond the frame of 160 x 100, none, one among what is not to be found.
    let ignored = "DontCare -1 -1 -10 1.00 1.00 9.00 9.00 -1 -1 -1 -1000 -1000 -1000 -10\n";
    let car =
        |edges: &str| format!("Car 0.00 0 -1.58 {edges} 1.65 1.67 3.64 -0.65 1.71 46.70 -1.59\n");
    fs::write(
        root.join("label_2/000000.txt"),
        car("120.00 -20.00 200.00 60.00"),
    )
    .unwrap();
    fs::write(root.join("label_2/000001.txt"), ignored).unwrap();
    let both = format!("{ignored}{}", car("20.00 30.00 60.00 70.00"));
    fs::write(root.join("label_2/000002.txt"), both).unwrap();
    let set = |dir: &Path, out: &str, more: &[&str]| {
        let preset = [
            "--preset",
            "windshield-bullseye",
            "--set",
            "impact.count=1",
            "--set",
            "fracture.mesh=fast",
        ];
        let args = [&["generate", "kitti:in", "-o", out], &preset[..], more].concat();
        succeed(dir, &args);
    };
    set(dir.path(), "at", &["--set", "impact.position=object"]);
    let fixed = [
        ("000000", "[0.875,0.3]"),
        ("000001", "random"),
        ("000002", "[0.25,0.5]"),
    ];
    for (image, position) in fixed {
        let key = format!("impact.position={position}");
        set(dir.path(), image, &["--set", &key]);
        let of = |out: &str| fs::read(dir.path().join(format!("{out}/image_2/{image}.png")));
        assert!(
            of("at").unwrap() == of(image).unwrap(),
            "{image}: {position}"
        );
    }
    let clean = fs::read(root.join("image_2/000000.png")).unwrap();
    assert!(clean != fs::read(dir.path().join("at/image_2/000000.png")).unwrap());

    // Of several stones the first.
    let four = ["--set", "impact.position=object", "--set", "impact.count=4"];
    set(dir.path(), "four", &four);
    let hits = |out: &str| {
        let record = format!("{out}/starbreak/provenance/image_2/000002.json");
        json(&dir.path().join(record))["network"]["impacts"].clone()
    };
    let (one, four) = (hits("at"), hits("four"));
    let place = |hit: &Value| [hit["x"].as_f64().unwrap(), hit["y"].as_f64().unwrap()];
    assert_eq!(
        place(&four[0]).map(f64::to_bits),
        place(&one[0]).map(f64::to_bits)
    );
    assert_ne!(
        place(&four[1]).map(f64::to_bits),
        place(&one[0]).map(f64::to_bits)
    );

    let mut cases = Vec::new();
    for verb in [
        &["crack", "in/image_2/000000.png"][..],
        &["patterns", "-n", "1"],
    ] {
        let args = [verb, &["-o", "refused", "--set", "impact.position=object"]].concat();
        cases.push((args, "needs labels"));
    }
    all_refused(dir.path(), &cases);
}
