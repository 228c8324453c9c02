//! `--network FILE`: a drawing or a network file in the place of a simulated network.

use std::fs;

use crate::program::{all_refused, folder, json, names, raw_png, succeed, write_photo};
use starbreak_dataset::sha256_hex;

/// A page that a network in px is stretched over, 160 × 100 px: one upright crack at x = 40.
const PX: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" width="80" height="100"><path d="M20 0V100" stroke="red"/></svg>"#;

/// A pane of 1000 × 600 mm with one level crack through its middle.
const MM: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" width="1000mm" height="600mm" viewBox="0 0 1000 600"><path class="edge" d="M0 300H1000" stroke="red"/><circle class="impact" cx="500" cy="300" r="9"/></svg>"#;

#[test]
fn a_drawing_in_px_is_stretched_over_the_frame() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    fs::write(dir.path().join("crack.svg"), PX).unwrap();
    for preset in ["paper", "windshield-star"] {
        let args = [
            "crack",
            "a.png",
            "-o",
            preset,
            "--preset",
            preset,
            "--network",
            "crack.svg",
        ];
        succeed(dir.path(), &args);
        let crack = raw_png(&dir.path().join(preset).join("a.crack.png"));
        let (width, height) = (160, 100);
        assert_eq!(
            crack.data.len(),
            width * height,
            "{preset}: one byte per pixel"
        );
        for (at, level) in crack.data.iter().enumerate() {
            // Half of the page's width, so x = 40 of 160 px.
            let off = (at % width).abs_diff(40);
            assert!(*level == 0 || off <= 4, "{preset}: {level} at pixel {at}");
            // The foot of the frame sees a raked pane nearly along its face, and a crack there is
            // narrower than what a code can say.
            let is_far = preset == "windshield-star" && at / width >= 85;
            assert!(
                *level > 0 || off > 0 || is_far,
                "{preset}: nothing at pixel {at}"
            );
        }
        let record = json(&dir.path().join(preset).join("a.json"));
        assert_eq!(record["network"]["model"], "imported", "{preset}");
        assert_eq!(record["network"]["file"]["name"], "crack.svg", "{preset}");
        assert_eq!(
            record["network"]["file"]["sha256"],
            sha256_hex(PX.as_bytes()),
            "{preset}"
        );
    }
}

#[test]
fn a_drawing_in_mm_lies_on_its_pane_before_the_camera() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    fs::write(dir.path().join("crack.svg"), MM).unwrap();
    // f 100 px at 0.48 m: 0.208 px per mm, so 160 px show 768 mm of 1000; the axis meets the pane
    // half way across and at 0.4 of its height, 60 mm above the crack: 12.5 px below the middle,
    // which is the middle of a row.
    let camera = [
        "camera.f_px=100",
        "glass.distance_m=0.48",
        "glass.rake_deg=0",
        "glass.axis_at=[0.5,0.4]",
    ];
    let mut args = vec!["crack", "a.png", "-o", "o", "--network", "crack.svg"];
    args.extend(camera.iter().flat_map(|set| ["--set", set]));
    succeed(dir.path(), &args);
    let crack = raw_png(&dir.path().join("o/a.crack.png"));
    for (at, level) in crack.data.iter().enumerate() {
        let off = (at / 160).abs_diff(62);
        assert!(*level == 0 || off <= 4, "{level} at pixel {at}");
        assert!(*level > 0 || off > 0, "nothing at pixel {at}");
    }
}

#[test]
fn simulate_converts_drawings_and_networks() {
    let dir = folder();
    fs::write(dir.path().join("crack.svg"), MM).unwrap();
    succeed(
        dir.path(),
        &[
            "simulate",
            "--network",
            "crack.svg",
            "-o",
            "a.json",
            "--svg",
            "a.svg",
        ],
    );
    let network = json(&dir.path().join("a.json"));
    assert_eq!(network["model"], "imported");
    assert_eq!(network["unit"], "mm");
    assert_eq!(network["pane"]["width"], 1000.0);
    assert_eq!(network["segments"]["kind"], serde_json::json!(["edge"]));
    assert_eq!(network["impacts"][0]["x"], 500.0);
    // Drawing and network are the same to the byte when they are converted again.
    succeed(
        dir.path(),
        &["simulate", "--network", "a.svg", "-o", "b.json"],
    );
    succeed(
        dir.path(),
        &["simulate", "--network", "a.json", "-o", "c.json"],
    );
    let read = |name: &str| fs::read_to_string(dir.path().join(name)).unwrap();
    assert_eq!(read("b.json"), read("a.json"), "from our own drawing");
    assert_eq!(read("c.json"), read("a.json"), "from our own network");
}

#[test]
fn a_network_of_ours_renders_the_same_from_its_file() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    // The paper's optics draw nothing by the seed; the physical ones place grains and chips by it.
    let common = [
        "--preset",
        "windshield-star",
        "--set",
        "optics.model=paper",
        "--seed",
        "5",
    ];
    let simulate = ["simulate", "--size", "160x100", "-o", "net.json"];
    succeed(dir.path(), &[&simulate[..], &common].concat());
    succeed(
        dir.path(),
        &[
            &["crack", "a.png", "-o", "o", "--network", "net.json"][..],
            &common,
        ]
        .concat(),
    );
    succeed(
        dir.path(),
        &[
            &[
                "crack",
                "a.png",
                "-o",
                "again",
                "--network",
                "net.json",
                "--seed",
                "9",
            ][..],
            &common[..4],
        ]
        .concat(),
    );
    let record = json(&dir.path().join("o/a.json"));
    assert_eq!(record["network"]["model"], "imported");
    assert_eq!(record["network"]["file"]["model"], "physics");
    let read = |name: &str| fs::read(dir.path().join(name)).unwrap();
    assert_eq!(read("o/a.png"), read("again/a.png"), "the seed has no say");
    assert!(
        raw_png(&dir.path().join("o/a.crack.png"))
            .data
            .iter()
            .any(|level| *level > 0),
        "a crack"
    );
}

#[test]
fn what_is_no_network_is_refused() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).unwrap();
    write("mm.svg", MM);
    write(
        "none.svg",
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\"/>",
    );
    write("broken.svg", "<svg");
    write("other.txt", "no network");
    write("empty.json", "");
    write("short.json", "{\"schema\":\"starbreak.crack-network/1\"}");
    fs::write(dir.path().join("latin.svg"), b"<svg>\xe9</svg>").unwrap();
    fs::create_dir(dir.path().join("o")).unwrap();
    write("o/a.json", "{}");
    let before = names(dir.path());
    let crack =
        |more: &[&'static str]| [&["crack", "a.png", "-o", "o", "--network"][..], more].concat();
    all_refused(
        dir.path(),
        &[
            (crack(&["missing.svg"]), "no such file"),
            (crack(&["o"]), "it is a folder"),
            (crack(&["empty.json"]), "is empty"),
            (crack(&["latin.svg"]), "not UTF-8"),
            (crack(&["other.txt"]), "neither an SVG"),
            (crack(&["none.svg"]), "has no cracks"),
            (crack(&["broken.svg"]), "not valid XML"),
            (crack(&["short.json"]), "not a crack network"),
            (crack(&["mm.svg", "--preset", "paper"]), "is in mm"),
            (crack(&["o/a.json"]), "would replace the network"),
            (
                vec!["simulate", "--network", "mm.svg", "-o", "mm.svg"],
                "would replace the network",
            ),
        ],
    );
    assert_eq!(names(dir.path()), before, "nothing is left behind");
}
