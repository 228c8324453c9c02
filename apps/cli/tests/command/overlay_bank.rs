//! `patterns --overlays DIR`: banks of random parts of photographs of broken glass.

use std::fs;
use std::path::Path;

use crate::program::{
    all_refused, folder, jpeg_bytes, names, photo, png_bytes, snapshot, starbreak, succeed,
    write_photo,
};
use image::{GrayImage, Luma};
use serde_json::Value;

/// White rays on black, by a number of them.
fn write_star(path: &Path, (width, height): (u32, u32), n_rays: f64) {
    let star = GrayImage::from_fn(width, height, |x, y| {
        let (u, v) = (
            f64::from(x) - f64::from(width) * 0.5,
            f64::from(y) - f64::from(height) * 0.5,
        );
        let is_ray = (v.atan2(u) * n_rays * 0.5).sin().abs() > 0.9;
        let inside = u.abs() < f64::from(width) * 0.45 && v.abs() < f64::from(height) * 0.45;
        Luma([if is_ray && inside { 230 } else { 2 }])
    });
    let is_png = path.extension().is_some_and(|extension| extension == "png");
    let bytes = if is_png {
        png_bytes(&star.into())
    } else {
        jpeg_bytes(&star.into())
    };
    fs::write(path, bytes).unwrap();
}

/// Three photographs in `photos`.
fn write_photos(dir: &Path) {
    fs::create_dir(dir.join("photos")).unwrap();
    write_star(&dir.join("photos/a.png"), (300, 220), 10.0);
    write_star(&dir.join("photos/b, wide.jpg"), (400, 150), 7.0);
    write_star(&dir.join("photos/c.png"), (120, 200), 16.0);
}

fn make(dir: &Path, n: &str, output: &str, more: &[&str]) {
    let args = ["patterns", "--overlays", "photos", "-n", n, "-o", output];
    let size = ["--size", "160x100"];
    succeed(dir, &[&args[..], &size, more].concat());
}

fn rows(dir: &Path) -> Vec<String> {
    let csv = fs::read_to_string(dir.join("overlays.csv")).unwrap();
    csv.lines().skip(1).map(str::to_owned).collect()
}

#[test]
fn a_bank_holds_each_photo_once_and_begins_like_a_longer_one() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    write_photos(dir.path());
    make(dir.path(), "300", "long", &["--threads", "2"]);
    make(dir.path(), "300", "again", &["--threads", "1"]);
    make(dir.path(), "40", "short", &[]);
    make(dir.path(), "300", "other", &["--seed", "1"]);
    assert_eq!(names(&at("long")), ["overlays.bank", "overlays.csv"]);
    assert_eq!(snapshot(&at("long")), snapshot(&at("again")), "threads");
    let (long, short) = (rows(&at("long")), rows(&at("short")));
    assert_eq!((long.len(), short.len()), (300, 40), "a row for each");
    assert_eq!(short, long[..40], "pattern k is the same");
    assert_ne!(rows(&at("other")), long, "another seed");
    for name in ["a.png", "b, wide.jpg", "c.png"] {
        let n = long.iter().filter(|row| row.contains(name)).count();
        assert!((70..130).contains(&n), "{name}: {n} of 300");
    }
    let n_bytes = |name: &str| fs::metadata(at(name)).unwrap().len();
    let photos: u64 = ["a.png", "b, wide.jpg", "c.png"]
        .map(|name| n_bytes(&format!("photos/{name}")))
        .iter()
        .sum();
    let bank = n_bytes("long/overlays.bank");
    assert!(
        bank < photos + 300 * 200,
        "{bank} bytes for photos of {photos} bytes"
    );

    let info = starbreak(dir.path(), &["patterns", "--info", "long", "--json"]);
    let info: Value = serde_json::from_str(&info.stdout).unwrap();
    assert_eq!(info["kind"], "overlays");
    assert_eq!(info["n_patterns"], 300);
    assert_eq!(info["header"]["min_scale"], 0.6);
}

#[test]
fn a_set_takes_its_parts_out_of_the_bank_and_is_made_again_from_it() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    write_photos(dir.path());
    make(dir.path(), "50", "bank", &["--overlay-gain", "1.5"]);
    fs::create_dir(at("scenes")).unwrap();
    for k in 0..5 {
        write_photo(&at(&format!("scenes/{k}.png")));
    }
    // Of another size than the bank's.
    fs::write(at("scenes/z.png"), png_bytes(&photo((90, 120)))).unwrap();
    let rows = rows(&at("bank"));
    for preset in ["paper", "windshield-star"] {
        let args = [
            "generate",
            "folder:scenes",
            "-o",
            preset,
            "--preset",
            preset,
        ];
        succeed(dir.path(), &[&args[..], &["--overlays", "bank"]].concat());
        let mut n_checked = 0;
        for (path, bytes) in snapshot(&at(preset)) {
            let Some(record) = bytes.and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok())
            else {
                continue;
            };
            let Some(idx) = record["pattern"]["idx"].as_u64() else {
                continue;
            };
            let overlay = &record["overlay"];
            assert_eq!(overlay["gain"], 1.5, "{path:?}");
            let row = &rows[usize::try_from(idx).unwrap()];
            assert!(
                row.ends_with(&format!("\"{}\"", overlay["name"].as_str().unwrap())),
                "{path:?}: {row}"
            );
            let left = overlay["placement"]["left_px"].as_f64().unwrap();
            let is_of_the_bank = row.starts_with(&format!("{idx},{left:.2},"));
            let is_other_size = record["camera"]["width_px"] != 160;
            assert_ne!(is_of_the_bank, is_other_size, "{path:?}: {left} in {row}");
            n_checked += 1;
        }
        assert_eq!(n_checked, 6, "{preset}: a record for each image");
        let again = ["verify", preset, "--regenerate", "all", "--source"];
        let source = ["folder:scenes", "--overlays", "bank"];
        succeed(dir.path(), &[&again[..], &source].concat());
    }
}

#[test]
fn what_is_no_bank_of_photos_is_refused() {
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    write_photos(dir.path());
    write_photo(&at("a.png"));
    fs::write(at("list.txt"), "a.png\n").unwrap();
    make(dir.path(), "5", "bank", &[]);
    let mut bytes = fs::read(at("bank/overlays.bank")).unwrap();
    for (name, at_byte) in [("torn", bytes.len() / 2), ("odd", 60)] {
        fs::create_dir(at(name)).unwrap();
        bytes[at_byte] ^= 0x20;
        fs::write(at(name).join("overlays.bank"), &bytes).unwrap();
        bytes[at_byte] ^= 0x20;
    }
    fs::create_dir(at("cut")).unwrap();
    fs::write(at("cut/overlays.bank"), &bytes[..bytes.len() - 9]).unwrap();
    fs::create_dir(at("none")).unwrap();
    let generate = |more: &[&'static str]| {
        [
            &["generate", "list:list.txt", "-o", "o", "--overlays"][..],
            more,
        ]
        .concat()
    };
    let patterns = |more: &[&'static str]| [&["patterns", "-n", "3", "-o", "o"][..], more].concat();
    all_refused(
        dir.path(),
        &[
            (generate(&["torn"]), "overlays.bank"),
            (generate(&["odd"]), "overlays.bank"),
            (generate(&["cut"]), "overlays.bank"),
            (generate(&["bank", "--overlay-gain", "2"]), "--overlay-gain"),
            (generate(&["bank", "--bank", "bank"]), "--bank"),
            (patterns(&["--overlays", "none"]), "no photographs"),
            (
                patterns(&["--overlays", "photos", "--preset", "paper"]),
                "--preset",
            ),
            (
                patterns(&["--overlays", "photos", "--size", "9x9", "--size", "8x8"]),
                "one --size",
            ),
            (
                patterns(&["--overlays", "photos", "--overlay-min-scale", "2"]),
                "0.05 to 1",
            ),
            (patterns(&["--overlay-gain", "2"]), "--overlay-gain"),
            (
                vec!["patterns", "-n", "5", "-o", "bank", "--overlays", "photos"],
                "--replace",
            ),
        ],
    );
}

#[test]
fn a_set_does_not_go_among_its_photographs() {
    let dir = folder();
    write_photos(dir.path());
    fs::create_dir(dir.path().join("scenes")).unwrap();
    write_photo(&dir.path().join("scenes/0.png"));
    let args = [
        "generate",
        "folder:scenes",
        "-o",
        "photos/out",
        "--overlays",
        "photos",
    ];
    all_refused(dir.path(), &[(args.to_vec(), "lie in each other")]);
}
