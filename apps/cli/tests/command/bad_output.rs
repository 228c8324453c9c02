//! Places that cannot or must not be written to: one line, code 2, nothing left behind.

use std::fs;
use std::path::Path;

use crate::program::{
    QUICK_BENCH, SMALL, SmallDisk, all_refused, folder, names, skipped, snapshot, starbreak,
    starbreak_small, write_photo,
};

/// Every verb that writes, onto this folder.
fn writers(to: &str) -> Vec<(Vec<String>, String)> {
    let below = |name: &str| format!("{to}/{name}");
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
    vec![
        (
            words(&["crack", "a.png", "--preset", "paper", "-o", to]),
            below("a.png"),
        ),
        (
            words(&["demo", "--preset", "paper", "-o", to]),
            to.to_owned(),
        ),
        (
            words(&["simulate", "--preset", "paper", "-o", &below("n.json")]),
            below("n.json"),
        ),
        (
            words(&["simulate", "--preset", "paper", "--svg", &below("n.svg")]),
            below("n.svg"),
        ),
        (
            words(&[
                "simulate",
                "--preset",
                "paper",
                "--frames",
                "2",
                "--frames-to",
                to,
            ]),
            to.to_owned(),
        ),
        (words(&["man", "-o", to]), to.to_owned()),
        (
            words(&[&QUICK_BENCH[..], &["-o", to]].concat()),
            to.to_owned(),
        ),
    ]
}

fn all_writers_refused(dir: &Path, to: &str) {
    let cases = writers(to);
    let cases: Vec<_> = cases
        .iter()
        .map(|(args, named)| (args.iter().map(String::as_str).collect(), named.as_str()))
        .collect();
    all_refused(dir, &cases);
}

#[test]
fn a_path_below_a_file_is_refused() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    fs::write(dir.path().join("file"), "here first").unwrap();
    all_writers_refused(dir.path(), "file");
    all_writers_refused(dir.path(), "file/deeper");
}

#[cfg(unix)]
#[test]
fn devices_and_proc_are_refused() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    all_writers_refused(dir.path(), "/dev/null/x");
    if Path::new("/proc/self").exists() {
        all_writers_refused(dir.path(), "/proc/starbreak-test");
    }
    all_refused(
        dir.path(),
        &[
            (
                vec!["simulate", "--preset", "paper", "-o", "/dev/null"],
                "/dev/null",
            ),
            (vec!["simulate", "--preset", "paper", "-o", "."], "\".\""),
            (vec!["simulate", "--preset", "paper", "-o", "new/"], "new/"),
        ],
    );
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    let closed = dir.path().join("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(closed.join("probe"), "").is_ok() {
        skipped("read-only folders: permissions do not bind this user (root)");
        return;
    }
    all_writers_refused(dir.path(), "closed");
    all_writers_refused(dir.path(), "closed/deeper");
}

#[test]
fn a_full_disk_stays_empty() {
    let dir = folder();
    fs::write(
        dir.path().join("a.png"),
        crate::program::png_bytes(&crate::program::photo((640, 400))),
    )
    .unwrap();
    let Some(disk) = SmallDisk::mount("64k") else {
        skipped("full disk: `mount -t tmpfs` is not allowed here");
        return;
    };
    let root = disk.root();
    for to in [root.clone(), format!("{root}/new/folder")] {
        for (args, named) in &writers(&to)[..3] {
            let outcome = starbreak(dir.path(), args);
            let complaint = outcome.complaint(named);
            assert_eq!(complaint, None, "starbreak {args:?} onto a full disk");
            assert!(
                outcome.stderr.contains("no space left"),
                "{args:?}: {outcome:?}"
            );
            assert_eq!(
                names(Path::new(&root)),
                Vec::<String>::new(),
                "after {args:?}"
            );
        }
    }
}

/// `starbreak simulate > network.json` on a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_a_failure() {
    let dir = folder();
    for args in [
        &["simulate", "--preset", "paper"][..],
        &["recipe"],
        &["completions", "bash"],
    ] {
        let full = fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let outcome: crate::program::Outcome = crate::program::command(dir.path(), args)
            .stdout(full)
            .stderr(std::process::Stdio::piped())
            .output()
            .unwrap()
            .into();
        assert_eq!(outcome.code, Some(2), "starbreak {args:?}: {outcome:?}");
    }
}

#[test]
fn the_input_is_never_replaced() {
    let dir = folder();
    let sub = dir.path().join("sub");
    fs::create_dir(&sub).unwrap();
    write_photo(&dir.path().join("a.png"));
    let absolute = dir.path().to_str().unwrap();
    let out = |out| (vec!["crack", "a.png", "-o", out], "a.png");
    let cases = [out("."), out("./"), out("sub/.."), out(absolute)];
    all_refused(dir.path(), &cases);

    // An input that is named like one of its own by-products.
    fs::rename(dir.path().join("a.png"), dir.path().join("a.json")).unwrap();
    let case = (vec!["crack", "a.json", "-o", "."], "a.json");
    all_refused(dir.path(), &[case]);
}

#[cfg(unix)]
#[test]
fn the_input_is_never_replaced_through_a_link() {
    use std::os::unix::fs::symlink;
    let dir = folder();
    let at = |name: &str| dir.path().join(name);
    for name in ["real", "hard", "soft"] {
        fs::create_dir(at(name)).unwrap();
    }
    write_photo(&at("real/a.png"));
    symlink("real", at("link")).unwrap();
    fs::hard_link(at("real/a.png"), at("hard/a.png")).unwrap();
    symlink("../real/a.png", at("soft/a.png")).unwrap();
    let cases: Vec<_> = ["link", "link/../real", "hard", "soft"]
        .iter()
        .map(|out| (vec!["crack", "real/a.png", "-o", *out], "real/a.png"))
        .collect();
    all_refused(dir.path(), &cases);
    all_refused(
        dir.path(),
        &[(vec!["crack", "link/a.png", "-o", "real"], "link/a.png")],
    );
}

/// The mask of the first image must not fall on the second image.
#[test]
fn the_input_of_another_image_is_never_replaced() {
    let dir = folder();
    fs::create_dir(dir.path().join("out")).unwrap();
    write_photo(&dir.path().join("a.png"));
    let victim = dir.path().join("out").join("a.region.png");
    write_photo(&victim);
    let before = fs::read(&victim).unwrap();
    let outcome = starbreak_small(
        dir.path(),
        &["crack", "a.png", "out/a.region.png", "-o", "out"],
    );
    assert!(
        fs::read(&victim).unwrap() == before,
        "an input was replaced: {outcome:?}"
    );
    assert_ne!(outcome.code, Some(0), "{outcome:?}");
}

#[test]
fn the_recipe_is_never_replaced() {
    let dir = folder();
    fs::write(
        dir.path().join("mine.toml"),
        "schema = 1 # found by hand\n[fracture]\nmodel = \"paper\"\nparticles = 300\n",
    )
    .unwrap();
    let recipe = ["--recipe", "mine.toml"];
    let to = |to: [&'static str; 2]| [&["simulate"][..], &to, &recipe].concat();
    all_refused(
        dir.path(),
        &[
            (to(["-o", "mine.toml"]), "mine.toml"),
            (to(["--svg", "./mine.toml"]), "mine.toml"),
        ],
    );
}

#[test]
fn two_outputs_in_one_place_are_refused() {
    let dir = folder();
    let args = [&["simulate", "-o", "x", "--svg", "./x"][..], &SMALL].concat();
    all_refused(dir.path(), &[(args, "x")]);
    assert!(snapshot(dir.path()).is_empty(), "nothing was written");
}
