//! One crack over the values of one parameter, and what the physical optics write beside a
//! picture.

use std::fs;
use std::path::Path;

use crate::program::{all_refused, folder, json, names, raw_png, starbreak, succeed, write_photo};
use starbreak::optics::srgb::decode8;

/// A hit that breaks the glass within a small frame, off its middle.
const HIT: [&str; 8] = [
    "--set",
    "fracture.mesh=fast",
    "--set",
    "impact.position=[0.4,0.55]",
    "--set",
    "impact.speed_m_s=40",
    "--seed",
    "3",
];

fn with_hit<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [args, &HIT].concat()
}

#[test]
fn each_picture_of_a_sweep_is_the_one_that_crack_makes() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    for (key, values) in [
        ("camera.focus_distance_m", ["far", "0.5", "short"]),
        // The cracks themselves differ.
        ("impact.speed_m_s", ["30", "36", "45"]),
        // The same cracks would lie elsewhere in the frame.
        ("camera.f_px", ["90", "100", "120"]),
    ] {
        let out = dir.path().join(key);
        let over = format!("{key}={}", values.join(","));
        let args = ["sweep", "a.png", "-o", key, "--over", &over];
        // The swept key comes last, also after --set.
        succeed(dir.path(), &with_hit(&args));
        for (k, value) in (1..).zip(values) {
            let stem = format!("a.{k:02}-{value}");
            let set = format!("{key}={value}");
            let args = with_hit(&["crack", "a.png", "-o", "one"]);
            succeed(dir.path(), &[&args[..], &["--set", &set]].concat());
            for suffix in ["png", "region.png", "crack.png"] {
                let swept = fs::read(out.join(format!("{stem}.{suffix}"))).unwrap();
                let single = fs::read(dir.path().join(format!("one/a.{suffix}"))).unwrap();
                assert!(swept == single, "{stem}.{suffix} is another picture");
            }
            let (swept, single) = (
                json(&out.join(format!("{stem}.json"))),
                json(&dir.path().join("one/a.json")),
            );
            for member in ["recipe", "camera", "network", "optics", "item"] {
                assert_eq!(swept[member], single[member], "{stem}: {member}");
            }
        }
    }
}

#[test]
fn the_figures_of_a_sweep_are_those_of_the_lens() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    let args = [
        "sweep",
        "a.png",
        "-o",
        "o",
        "--over",
        "camera.f_number=1.4,2,[4]",
    ];
    let refused = starbreak(dir.path(), &with_hit(&args));
    assert_eq!(refused.code, Some(2), "a list is no number: {refused:?}");
    assert!(!dir.path().join("o").exists(), "nothing is begun");

    let args = [
        "sweep",
        "a.png",
        "-o",
        "o",
        "--json",
        "--over",
        "camera.focus_distance_m=far,0.1,short",
    ];
    let outcome = succeed(dir.path(), &with_hit(&args));
    let result: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
    let text = fs::read_to_string(dir.path().join("o/a.sweep.csv")).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(header[..2], ["camera.focus_distance_m", "image"], "{text}");
    // 3 mm at f/2.8; KITTI's field of view on 160 px; glass at 150 mm, scene at 20 m.
    let per_inverse_m = 0.003 / 2.8 * (721.5377 / 1242.0 * 160.0);
    for (k, (line, (focus_m, value))) in lines
        .zip([(20.0, "far"), (0.1, "0.1"), (0.15, "short")])
        .enumerate()
    {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), header.len(), "{line}");
        assert_eq!(fields[0], value, "{line}");
        let of = |name: &str| -> f64 {
            let at = header.iter().position(|known| *known == name).unwrap();
            fields[at].parse().unwrap()
        };
        for (name, distance_m) in [("glass_disc_px", 0.15), ("scene_disc_px", 20.0)] {
            let expected = per_inverse_m * f64::abs(1.0 / distance_m - 1.0 / focus_m);
            let found = of(name);
            assert!(
                (found - expected).abs() < 1e-9,
                "{name}: {found}, {expected}"
            );
        }
        assert!(of("contrast_mean") > 0.0, "{line}");
        assert!(dir.path().join("o").join(fields[1]).exists(), "{line}");
        assert_eq!(result["steps"][k]["value"], value, "{result}");
    }
    let sheet = raw_png(&dir.path().join("o/a.sweep.png"));
    // Three pictures of 160 x 100 px with two lines of text, and a title.
    assert!(
        sheet.size.0 >= 440 && sheet.size.1 >= 160,
        "{:?}",
        sheet.size
    );
    let is_there = |wanted: &[u8]| sheet.pixels().any(|pixel| pixel == wanted);
    assert!(
        is_there(&[255; 3]) && is_there(&[0; 3]),
        "paper and letters"
    );
}

/// Values of the papers' own optics: far and short, no lens.
#[test]
fn the_paper_can_be_swept_too_but_has_no_lens() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    let args = [
        "sweep",
        "a.png",
        "-o",
        "o",
        "--over",
        "camera.focus_distance_m=far, short",
    ];
    crate::program::succeed_small(dir.path(), &args);
    let text = fs::read_to_string(dir.path().join("o/a.sweep.csv")).unwrap();
    assert!(text.contains("\nfar,a.01-far.png,,,,"), "{text}");
    assert!(text.contains("\nshort,a.02-short.png,,,,"), "{text}");
}

#[test]
fn wrong_sweeps_are_refused() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    let over = |over| (vec!["sweep", "a.png", "-o", "o", "--over", over], "--over");
    all_refused(
        dir.path(),
        &[
            over("camera.f_number"),
            over("camera.f_number="),
            over("camera.f_number=2,,3"),
            over(""),
            (
                vec!["sweep", "a.png", "-o", "o", "--over", "camera.fnumber=2,3"],
                "did you mean `camera.f_number`?",
            ),
            (
                vec!["sweep", "a.png", "-o", "o", "--over", "camera.f_number=2,0"],
                "--set camera.f_number=0: camera.f_number = 0; expected",
            ),
            (vec!["sweep", "b.png", "-o", "o"], "b.png"),
            (vec!["sweep", "-o", "o"], "IMAGE"),
        ],
    );
}

/// A NumPy file of version 1.0: its shape, and its numbers.
fn array(path: &Path) -> (String, Vec<f32>) {
    let bytes = fs::read(path).unwrap();
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..10 + length]).into_owned();
    assert!(header.contains("'descr': '<f4'"), "{header}");
    let (_, shape) = header.split_once("'shape': ").unwrap();
    let numbers = bytes[10 + length..]
        .chunks_exact(4)
        .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()));
    (
        shape.split_once(')').unwrap().0.to_owned() + ")",
        numbers.collect(),
    )
}

/// I·(1 − attenuation) + added + elsewhere · I(at pixel + displacement), in linear light, is the
/// picture.
#[test]
fn the_maps_make_the_picture_again() {
    let dir = folder();
    // Even light, so that light from elsewhere in the frame is that of the pixel.
    let even = image::RgbImage::from_pixel(160, 100, image::Rgb([90, 120, 150]));
    fs::write(
        dir.path().join("a.png"),
        crate::program::png_bytes(&even.into()),
    )
    .unwrap();
    succeed(
        dir.path(),
        &with_hit(&["crack", "a.png", "-o", "o", "--maps"]),
    );
    let out = dir.path().join("o");
    assert_eq!(
        names(&out),
        [
            "a.added.npy",
            "a.attenuation.npy",
            "a.coverage.npy",
            "a.crack.png",
            "a.displacement.npy",
            "a.elsewhere.npy",
            "a.json",
            "a.png",
            "a.region.png",
        ],
        "files"
    );
    let map = |name: &str, shape: &str| {
        let (found, numbers) = array(&out.join(format!("a.{name}.npy")));
        assert_eq!(found, shape, "{name}");
        numbers
    };
    let attenuation = map("attenuation", "(100, 160)");
    let added = map("added", "(100, 160, 3)");
    let elsewhere = map("elsewhere", "(100, 160)");
    let displacement = map("displacement", "(100, 160, 2)");
    let coverage = map("coverage", "(100, 160)");
    assert_eq!(displacement.len(), 2 * 160 * 100, "two numbers each");
    let crack = raw_png(&out.join("a.crack.png"));
    for (share, code) in coverage.iter().zip(&crack.data) {
        let expected = f32::from(*code) / 255.0;
        assert!((share - expected).abs() < 1e-6, "{share}, {code}");
    }
    let picture = raw_png(&out.join("a.png"));
    let before = [90, 120, 150].map(decode8);
    let mut n_changed = 0;
    for (at, pixel) in picture.pixels().enumerate() {
        let mut of_all = 0.0;
        for c in 0..3 {
            let light = before[c] * (1.0 - attenuation[at] + elsewhere[at]) + added[3 * at + c];
            let shown = decode8(pixel[c]);
            let off = light.clamp(0.0, 1.0) - shown;
            // Half a code, and the attenuation of a color apart from the mean of the three.
            assert!(
                off.abs() < 0.06,
                "pixel {at}, color {c}: {light}, shown {shown}"
            );
            of_all += off / before[c] / 3.0;
        }
        // In the mean of the colors only the codes are left.
        assert!(of_all.abs() < 0.012, "pixel {at}: {of_all}");
        n_changed += usize::from(pixel != [90, 120, 150]);
    }
    assert!(n_changed > 100, "{n_changed} pixels changed");

    let refused = starbreak(
        dir.path(),
        &["crack", "a.png", "-o", "p", "--maps", "--preset", "paper"],
    );
    assert_eq!(
        refused.complaint("the paper's optics have no maps"),
        None,
        "no maps of the paper"
    );
}

#[test]
fn the_record_says_what_lens_and_light_did() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    succeed(dir.path(), &with_hit(&["crack", "a.png", "-o", "o"]));
    let record = json(&dir.path().join("o/a.json"));
    for member in ["f_px", "glass_disc_px", "scene_disc_px"] {
        assert!(record["camera"][member].is_number(), "{member}: {record}");
    }
    let environment = &record["optics"]["environment"];
    for (member, n) in [
        ("sky_horizon", 3),
        ("sky_zenith", 3),
        ("ground", 3),
        // Of its lower end and its upper one.
        ("cabin", 2),
        ("sun_irradiance", 3),
    ] {
        let light = environment[member].as_array().unwrap();
        assert_eq!(light.len(), n, "{member}: {record}");
    }
    for member in ["mean", "weber", "brighter", "darker", "rms_code"] {
        let figure = &record["optics"]["contrast"][member];
        assert!(figure.as_f64().unwrap() > 0.0, "{member}: {record}");
    }
    let given = ["--set", "optics.ground=[0.125, 0.25, 0.5]"];
    let args = with_hit(&["crack", "a.png", "-o", "g"]);
    succeed(dir.path(), &[&args[..], &given].concat());
    let record = json(&dir.path().join("g/a.json"));
    let ground = &record["optics"]["environment"]["ground"];
    assert_eq!(ground, &serde_json::json!([0.125, 0.25, 0.5]), "as given");
}

#[test]
fn a_camera_is_laid_over_the_models_that_the_flags_choose() {
    let dir = folder();
    let recipe = |args: &[&str]| succeed(dir.path(), &[&["recipe"], args].concat()).stdout;
    let physical = ["--preset", "paper", "--set", "optics.model=physical"];
    let with_camera = recipe(&[&physical[..], &["--camera", "adas-1080p"]].concat());
    assert_ne!(with_camera, recipe(&physical), "a camera changes the lens");
    let first = recipe(&[&["--camera", "adas-1080p"], &physical[..]].concat());
    assert_eq!(with_camera, first, "in any order");
    // An override of one of its keys wins.
    let f_number = ["--camera", "adas-1080p", "--set", "camera.f_number=11"];
    assert!(
        recipe(&f_number).contains("f_number = 11\n"),
        "--set is last"
    );
    all_refused(
        dir.path(),
        &[(
            vec!["recipe", "--camera", "adas"],
            "unknown camera `adas`; ",
        )],
    );
}

#[test]
fn the_papers_cracks_lie_where_they_lay_when_the_camera_looks_through_glass() {
    let dir = folder();
    write_photo(&dir.path().join("a.png"));
    crate::program::succeed_small(dir.path(), &["crack", "a.png", "-o", "paper"]);
    let paper = raw_png(&dir.path().join("paper/a.crack.png")).data;
    let (n_cracked, n_all) = (
        paper.iter().filter(|code| **code > 128).count(),
        paper.len(),
    );
    assert!(n_cracked > 100 && n_cracked < n_all / 4, "{n_cracked}");
    for glass in [
        "glass.rake_deg=60",
        "glass.rake_deg=0",
        "glass.rake_deg=-30",
    ] {
        let args = [
            "crack",
            "a.png",
            "-o",
            "o",
            "--set",
            "optics.model=physical",
        ];
        let sheet = ["--set", glass, "--set", "glass.distance_m=0.3"];
        let (preset, hit) = crate::program::SMALL.split_at(2);
        // The preset, the model, and then the glass that it brings along.
        let args = [preset, &args[..], hit, &sheet].concat();
        succeed(dir.path(), &args);
        let physical = raw_png(&dir.path().join("o/a.crack.png")).data;
        let n_both = paper
            .iter()
            .zip(&physical)
            .filter(|(paper, physical)| **paper > 128 && **physical > 0)
            .count();
        assert!(
            n_both * 100 > n_cracked * 95,
            "{glass}: {n_both} of {n_cracked}"
        );
    }
}
