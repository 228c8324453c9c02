//! Each verb shows and takes the flags that it uses, and shells complete them.

use crate::program::{all_refused, folder, starbreak, succeed, write_photo};

#[test]
fn help_shows_what_a_verb_uses() {
    let dir = folder();
    let help = |verb: &str| succeed(dir.path(), &["help", verb]).stdout;
    for (verb, shown, hidden) in [
        (
            "crack",
            &["--preset", "--seed", "--max-memory"][..],
            &["--follow-links"][..],
        ),
        (
            "evaluate",
            &["--seed", "--replace", "--json"],
            &["--preset", "--set", "--max-memory"],
        ),
        (
            "completions",
            &["--quiet"],
            &["--json", "--threads", "--seed", "--preset"],
        ),
        (
            "verify",
            &["--threads", "--max-memory"],
            &["--severity", "--replace"],
        ),
        ("simulate", &["--camera", "--seed"], &["--threads"]),
    ] {
        let help = help(verb);
        let has =
            |flag: &str| help.contains(&format!("{flag} ")) || help.contains(&format!("{flag}\n"));
        for flag in shown {
            assert!(has(flag), "{verb} {flag}: {help}");
        }
        for flag in hidden {
            assert!(!has(flag), "{verb} {flag}: {help}");
        }
    }
}

#[test]
fn a_recipe_for_a_verb_without_glass_is_refused_and_other_flags_do_no_harm() {
    let dir = folder();
    let at = dir.path();
    all_refused(
        at,
        &[
            (
                vec!["man", "-o", "m", "--preset", "paper"],
                "`man` breaks no glass, so it has no use for --preset",
            ),
            (
                vec!["completions", "bash", "--set", "camera.f_px=1"],
                "no use for --set",
            ),
            (
                vec!["verify", ".", "--preset", "paper"],
                "verify takes recipe and seed from the set",
            ),
        ],
    );
    // Scripts may give them to every verb; those of all verbs are heard before a verb, too.
    succeed(
        at,
        &[
            "--seed",
            "3",
            "simulate",
            "-o",
            "a.json",
            "--preset",
            "paper",
            "--threads",
            "2",
        ],
    );
    succeed(
        at,
        &[
            "simulate", "-o", "b.json", "--preset", "paper", "--seed", "3",
        ],
    );
    let read = |name: &str| std::fs::read(at.join(name)).unwrap();
    assert_eq!(read("a.json"), read("b.json"), "the seed");
}

#[test]
fn shells_complete_names_and_keys_and_messages_stay_short() {
    let dir = folder();
    let script = succeed(dir.path(), &["completions", "bash"]).stdout;
    for word in [
        "windshield-bullseye",
        "adas-1080p",
        "impact.speed_m_s=",
        "camera.f_number=",
    ] {
        assert!(script.contains(word), "{word}");
    }
    let outcome = starbreak(dir.path(), &["demo", "--set"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert!(outcome.stderr.len() < 200, "{outcome:?}");
    // A few values are named.
    all_refused(
        dir.path(),
        &[(
            vec!["bench", "--model", "x"],
            "possible values: paper, physics, optics",
        )],
    );
}

#[test]
fn one_image_may_be_named() {
    let dir = folder();
    let at = dir.path();
    write_photo(&at.join("photo.png"));
    let with_paper =
        |args: &[&'static str]| -> Vec<&'static str> { [args, &["--preset", "paper"]].concat() };
    succeed(
        at,
        &with_paper(&["crack", "photo.png", "-o", "out/cracked.jpg"]),
    );
    succeed(
        at,
        &with_paper(&["crack", "photo.png", "-o", "cracked.PNG"]),
    );
    for name in [
        "out/cracked.jpg",
        "out/cracked.region.png",
        "out/cracked.json",
        "cracked.PNG",
        "cracked.crack.png",
    ] {
        assert!(at.join(name).is_file(), "{name}");
    }
    let begin = std::fs::read(at.join("out/cracked.jpg")).unwrap();
    assert_eq!(begin[..2], [0xff, 0xd8], "a JPEG");
    // A JPEG becomes a PNG beside it, and the list of another run stays.
    std::fs::write(at.join("failures.jsonl"), "{}\n").unwrap();
    std::fs::copy(at.join("out/cracked.jpg"), at.join("a.jpg")).unwrap();
    succeed(at, &with_paper(&["crack", "a.jpg", "-o", "a.png"]));
    assert!(at.join("failures.jsonl").is_file(), "of another run");
    // The same pixels as in a folder.
    succeed(at, &with_paper(&["crack", "photo.png", "-o", "folder"]));
    let same = [at.join("folder/photo.png"), at.join("cracked.PNG")]
        .map(|path| std::fs::read(path).unwrap());
    assert_eq!(same[0], same[1], "the seed is that of the input's name");
    all_refused(
        at,
        &[
            (
                with_paper(&["crack", "photo.png", "cracked.PNG", "-o", "x.png"]),
                "names one image, but there are 2",
            ),
            (
                with_paper(&["crack", "photo.png", "-o", "photo.png"]),
                "would replace the input",
            ),
            (
                with_paper(&[
                    "crack",
                    "photo.png",
                    "-o",
                    "x.jpg",
                    "--set",
                    "output.format=\"png\"",
                ]),
                "not in the format that output.format asks for",
            ),
        ],
    );
}
