//! What `crack` promises about masks and untouched pixels, on real frames and on tiny ones.

use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{
    Outcome, folder, json, names, photo, png_bytes, raw_png, skipped, succeed, succeed_small,
};
use image::DynamicImage;

const KITTI: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../../shared/data/kitti/image_2"
);

fn kitti() -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(KITTI) else {
        skipped(&format!("{KITTI} is not there"));
        return Vec::new();
    };
    let paths = entries.map(|entry| entry.unwrap().path());
    paths
        .filter(|path| path.extension().is_some_and(|extension| extension == "png"))
        .collect()
}

/// Size, mode, masks and untouched pixels of a cracked PNG; how many pixels are influenced.
fn check_cracked(input: &Path, out: &Path) -> usize {
    let stem = input.file_stem().unwrap().to_str().unwrap();
    let (before, after) = (raw_png(input), raw_png(&out.join(format!("{stem}.png"))));
    let region = raw_png(&out.join(format!("{stem}.region.png")));
    let crack = raw_png(&out.join(format!("{stem}.crack.png")));
    assert_eq!(before.size, after.size, "size of {stem}");
    assert_eq!(before.mode, after.mode, "mode of {stem}");
    let mask_mode = (png::ColorType::Grayscale, png::BitDepth::Eight);
    for mask in [&region, &crack] {
        assert_eq!((mask.size, mask.mode), (before.size, mask_mode), "{stem}");
    }
    assert!(
        region.data.iter().all(|level| matches!(level, 0 | 255)),
        "the region of {stem} holds more than 0 and 255"
    );
    assert!(
        crack
            .data
            .iter()
            .zip(&region.data)
            .all(|(crack, region)| *crack == 0 || *region == 255),
        "{stem}: a crack lies outside the region"
    );
    let changed_outside = before
        .pixels()
        .zip(after.pixels())
        .zip(&region.data)
        .filter(|((before, after), region)| **region == 0 && before != after)
        .count();
    assert_eq!(
        changed_outside, 0,
        "{stem}: pixels changed outside the region"
    );
    let n_inside = region.data.iter().filter(|level| **level == 255).count();
    let fraction = json(&out.join(format!("{stem}.json")))["region_fraction"].as_f64();
    #[expect(clippy::cast_precision_loss, reason = "counts of pixels")]
    let expected = n_inside as f64 / region.data.len() as f64;
    assert!(
        fraction.is_some_and(|fraction| (fraction - expected).abs() < 1e-12),
        "{stem}: region_fraction {fraction:?}, counted {expected}"
    );
    n_inside
}

#[test]
fn real_frames_are_untouched_outside_the_region() {
    let inputs = kitti();
    if inputs.is_empty() {
        return;
    }
    let dir = folder();
    for focus in ["far", "short"] {
        let set = format!("camera.focus_distance_m={focus}");
        let paths = inputs.iter().map(|path| path.to_str().unwrap());
        let mut args = vec!["crack", "-o", focus, "--preset", "paper", "--set", &set];
        args.extend(paths);
        succeed(dir.path(), &args);
        for input in &inputs {
            let n_inside = check_cracked(input, &dir.path().join(focus));
            let size = raw_png(input).size;
            let n_pixels = size.0 as usize * size.1 as usize;
            match focus {
                "short" => assert_eq!(n_inside, n_pixels, "{input:?}: the whole frame"),
                _ => assert!(
                    n_inside > 0 && n_inside < n_pixels,
                    "{input:?}: {n_inside} of {n_pixels} pixels influenced"
                ),
            }
            let stem = input.file_stem().unwrap().to_str().unwrap();
            let after = raw_png(&dir.path().join(format!("{focus}/{stem}.png")));
            assert!(
                after.data != raw_png(input).data,
                "{input:?}: no crack seen"
            );
        }
    }
    assert_eq!(
        names(&dir.path().join("far")).len(),
        4 * inputs.len(),
        "four files per frame"
    );
}

#[test]
fn both_focus_modes_share_the_crack() {
    let dir = folder();
    crate::program::write_photo(&dir.path().join("a.png"));
    for focus in ["far", "short"] {
        let set = format!("camera.focus_distance_m={focus}");
        succeed_small(dir.path(), &["crack", "a.png", "-o", focus, "--set", &set]);
        check_cracked(&dir.path().join("a.png"), &dir.path().join(focus));
    }
    let read = |name: &str| fs::read(dir.path().join(name)).unwrap();
    assert!(
        read("far/a.png") != read("short/a.png"),
        "the images differ"
    );
    let networks = ["far", "short"].map(|focus| {
        let record = json(&dir.path().join(format!("{focus}/a.json")));
        record["network"].clone()
    });
    assert_eq!(networks[0], networks[1], "one crack, seen twice");
}

#[test]
fn images_of_one_pixel_width_or_height_work() {
    let dir = folder();
    for size in [(1, 1), (1, 2), (1, 150), (150, 1), (2, 2), (3, 200)] {
        let name = format!("{}x{}.png", size.0, size.1);
        let path = dir.path().join(&name);
        fs::write(&path, png_bytes(&photo(size))).unwrap();
        for focus in ["far", "short"] {
            let set = format!("camera.focus_distance_m={focus}");
            succeed_small(dir.path(), &["crack", &name, "-o", "o", "--set", &set]);
            check_cracked(&path, &dir.path().join("o"));
        }
    }
}

/// The paper's recipe, whose radius is 65 px, on frames that are far smaller: what it makes of them
/// has a bound.
#[test]
fn the_paper_s_recipe_on_tiny_images_stays_within_bounds() {
    let dir = folder();
    for size in [(1, 1), (1, 200), (20, 20)] {
        let name = format!("{}x{}.png", size.0, size.1);
        fs::write(dir.path().join(&name), png_bytes(&photo(size))).unwrap();
        let hit = [
            "--set",
            "impact.position=[0.45,0.19]",
            "--set",
            "impact.direction_deg=134",
        ];
        let args = [
            &["crack", &name, "-o", "o", "-q", "--preset", "paper"][..],
            &hit,
        ]
        .concat();
        succeed(dir.path(), &args);
        let record = json(&dir.path().join("o").join(name).with_extension("json"));
        let n_segments = record["network"]["summary"]["n_segments"].as_u64().unwrap();
        assert!(n_segments < 2_000_000, "{size:?}: {n_segments} segments");
    }
}

#[test]
fn no_masks_on_request() {
    let dir = folder();
    crate::program::write_photo(&dir.path().join("a.png"));
    let args = ["crack", "a.png", "-o", "o", "--set", "output.masks=false"];
    succeed_small(dir.path(), &args);
    assert_eq!(
        names(&dir.path().join("o")),
        ["a.json", "a.png"],
        "no masks"
    );
    succeed_small(dir.path(), &["crack", "a.png", "-o", "m"]);
    assert_eq!(
        names(&dir.path().join("m")),
        ["a.crack.png", "a.json", "a.png", "a.region.png"],
        "masks by default"
    );
    let read = |name: &str| fs::read(dir.path().join(name)).unwrap();
    assert!(read("o/a.png") == read("m/a.png"), "the image is the same");
}

fn names_force_and_threshold(outcome: &Outcome) -> bool {
    [
        "impact.force",
        "fracture.critical_stress",
        "fracture.safety_factor",
    ]
    .iter()
    .all(|key| outcome.stdout.contains(key))
}

#[test]
fn a_weak_hit_leaves_the_image_as_the_lens_shows_it() {
    let dir = folder();
    let input = dir.path().join("a.png");
    crate::program::write_photo(&input);
    for (focus, force) in [("far", "300"), ("short", "300"), ("far", "1e-9")] {
        let focus = format!("camera.focus_distance_m={focus}");
        let force = format!("impact.force={force}");
        let args = [
            "crack", "a.png", "-o", "o", "--preset", "paper", "--set", &focus, "--set", &force,
        ];
        let outcome = succeed(dir.path(), &args);
        assert!(names_force_and_threshold(&outcome), "{outcome:?}");
        let region = raw_png(&dir.path().join("o/a.region.png"));
        assert!(
            region.data.iter().all(|level| *level == 0),
            "{focus}: the region is empty"
        );
        let after = raw_png(&dir.path().join("o/a.png"));
        assert_eq!(
            raw_png(&input) == after,
            focus.ends_with("far"),
            "{focus}: only the lens may change the image"
        );
    }
    let outcome = succeed_small(dir.path(), &["crack", "a.png", "-o", "o"]);
    assert!(
        !names_force_and_threshold(&outcome),
        "a strong hit: {outcome:?}"
    );
}

/// The force is enough, but no crack comes of it: the hit points out of the frame, no particle
/// is in reach, or the stress falls below the threshold before it reaches one.
#[test]
fn an_empty_crack_is_not_blamed_on_the_force() {
    let dir = folder();
    crate::program::write_photo(&dir.path().join("a.png"));
    for sets in [
        ["impact.position=[1,1]", "impact.direction_deg=45"],
        ["fracture.particles=2", "fracture.neighbour_radius_px=1e-9"],
        ["impact.position=[0.5,0.5]", "impact.force=300.0001"],
    ] {
        let small = [
            "--set",
            "fracture.particles=300",
            "--set",
            sets[0],
            "--set",
            sets[1],
        ];
        let args = ["crack", "a.png", "-o", "o", "--preset", "paper"];
        let outcome = succeed(dir.path(), &[&args[..], &small].concat());
        let record = json(&dir.path().join("o/a.json"));
        assert_eq!(
            record["network"]["summary"]["n_segments"], 0,
            "{sets:?}: empty"
        );
        assert!(
            !outcome.stdout.contains("no impact.force exceeds"),
            "{sets:?}: the force exceeds 300: {outcome:?}"
        );
    }
}

#[test]
fn mud_that_is_less_than_half_of_what_was_asked_is_told() {
    let dir = folder();
    fs::write(
        dir.path().join("a.png"),
        png_bytes(&DynamicImage::new_rgb8(24, 16)),
    )
    .unwrap();
    let muddy = [
        "crack",
        "a.png",
        "-o",
        "o",
        "--preset",
        "muddy",
        "--severity",
        "5",
    ];
    let near = succeed(dir.path(), &muddy).stderr;
    assert!(!near.contains("mud"), "{near}");
    let far = [&muddy[..], &["--set", "glass.distance_m=3"]].concat();
    let far = succeed(dir.path(), &far).stderr;
    let said = " % of the frame, where mud.coverage_percent = 40: at most 200,000 splats";
    assert!(far.contains(said), "{far}");
}
