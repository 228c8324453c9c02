//! Focus is the camera's: a frame without a crack is as sharp as one with it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{SMALL_MESH, folder, photo, png_bytes, raw_png, succeed};

/// Optics of which the scene is not as it was, and a hit that breaks the left of the frame or, by
/// its last two words, nothing.
fn looks() -> [Vec<&'static str>; 3] {
    let physical = [
        "--set",
        "fracture.mesh=fast",
        "--set",
        "impact.position=[0.15,0.3]",
    ];
    let paper = [
        &["--preset", "paper"][..],
        &SMALL_MESH,
        &["--set", "impact.position=[0.15,0.3]"],
    ];
    let (blur, glare) = (
        ["--set", "camera.focus_distance_m=0.05"],
        ["--set", "optics.veiling_glare=0.1"],
    );
    [
        [&physical[..], &blur].concat(),
        [&physical[..], &glare].concat(),
        [
            &paper.concat()[..],
            &["--set", "camera.focus_distance_m=short"],
        ]
        .concat(),
    ]
}

/// What breaks nothing.
fn weak(look: &[&'static str]) -> [&'static str; 2] {
    let is_paper = look.contains(&"paper");
    [
        "--set",
        if is_paper {
            "impact.force=1"
        } else {
            "impact.speed_m_s=1"
        },
    ]
}

/// The right quarter of a picture.
fn right_quarter(path: &Path) -> Vec<u8> {
    let png = raw_png(path);
    let (width, n) = (png.size.0 as usize, png.data.len());
    let row = n / png.size.1 as usize;
    let rows = png.data.chunks_exact(row);
    rows.flat_map(|row| row[row.len() / width * (width * 3 / 4)..].to_vec())
        .collect()
}

fn write_frames(dir: &Path) {
    let frame = png_bytes(&photo((320, 200)));
    for folder in ["frames", "kitti/image_2", "kitti/label_2"] {
        fs::create_dir_all(dir.join(folder)).unwrap();
    }
    fs::write(dir.join("a.png"), &frame).unwrap();
    for k in 0..4 {
        fs::write(dir.join(format!("frames/{k}.png")), &frame).unwrap();
    }
    fs::write(dir.join("kitti/image_2/000000.png"), &frame).unwrap();
    fs::write(dir.join("kitti/label_2/000000.txt"), "").unwrap();
}

#[test]
fn a_frame_without_a_crack_is_as_sharp_as_one_with_it() {
    let dir = folder();
    write_frames(dir.path());
    let at = |path: &str| dir.path().join(path);
    for (k, look) in looks().into_iter().enumerate() {
        let run = |args: &[&str], is_broken: bool| {
            let weak = weak(&look);
            let more: &[&str] = if is_broken { &[] } else { &weak };
            succeed(dir.path(), &[args, &look, more].concat());
        };
        let [broken, whole] = [true, false].map(|is_broken| {
            let out = |verb: &str| format!("{verb}{k}{is_broken}");
            run(&["crack", "a.png", "-o", &out("crack")], is_broken);
            run(
                &["generate", "kitti:kitti", "-o", &out("generate")],
                is_broken,
            );
            let over = if look.contains(&"paper") {
                "fracture.safety_factor=6"
            } else {
                "optics.region_threshold=0.5"
            };
            let sweep = ["sweep", "a.png", "-o", &out("sweep"), "--over", over];
            run(&sweep, is_broken);
            let clip = ["video", "frames", "--fps", "10", "--impact-at", "0.15"];
            run(&[&clip[..], &["-o", &out("video")]].concat(), is_broken);
            let mut pictures = vec![
                at(&out("crack")).join("a.png"),
                at(&out("generate")).join("image_2/000000.png"),
            ];
            pictures.push(swept(&at(&out("sweep"))));
            pictures.extend((0..4).map(|frame| at(&out("video")).join(format!("{frame}.png"))));
            pictures
        });
        let input = right_quarter(&at("a.png"));
        let seen = right_quarter(&broken[0]);
        assert!(
            apart(&seen, &input) > 10,
            "{look:?}: the scene is as it was"
        );
        assert!(
            raw_png(&broken[0]).data != raw_png(&whole[0]).data,
            "{look:?}: nothing is broken"
        );
        for picture in broken.iter().chain(&whole) {
            let apart = apart(&right_quarter(picture), &seen);
            // Glare comes from the whole frame, cracks and all.
            assert!(apart <= 2, "{look:?}: {picture:?} is off by {apart}");
        }
    }
}

/// The greatest difference of two pictures, codes.
fn apart(one: &[u8], other: &[u8]) -> u8 {
    assert_eq!(one.len(), other.len(), "size");
    let pairs = one.iter().zip(other);
    pairs.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

/// The one picture of a sweep, beside its masks and its sheet.
fn swept(folder: &Path) -> PathBuf {
    let names = crate::program::names(folder);
    let is_mask = |name: &str| name.ends_with(".region.png") || name.ends_with(".crack.png");
    let name = names
        .iter()
        .find(|name| name.starts_with("a.01-") && name.ends_with(".png") && !is_mask(name));
    folder.join(name.unwrap())
}
