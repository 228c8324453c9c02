//! The pictures of presets and damage classes in the documentation.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::Failure;
use crate::command::{cargo, run as run_command};
use crate::metadata::Metadata;
use crate::test::ffmpeg;

/// Where they are written.
const FOLDER: &str = "docs/figures/gallery";

/// The animated one.
const ANIMATION: &str = "breaking.webp";

/// What it shows after the default preset has grown, each for [`N_FRAMES_OF_STILL`].
const PRESETS: [&str; 9] = [
    "windshield-star",
    "windshield-combination",
    "windshield-long-crack",
    "windshield-gravel",
    "windshield-hail",
    "tempered-cover",
    "lens-cover-star",
    "lens-cover-shattered",
    "paper",
];

const FRAMES_PER_S: usize = 12;
const N_FRAMES_OF_GROWTH: usize = 42;
const N_FRAMES_OF_STILL: usize = 14;

/// `cargo xtask gallery`: runs the example `gallery` of the crate `starbreak`, then the command for
/// the animation.
///
/// # Errors
/// If they cannot be built, or fail, or there is no ffmpeg.
pub fn run(root: &Path) -> Result<(), Failure> {
    let build = ["run", "--release", "--locked", "--package", "starbreak"];
    let what = ["--example", "gallery", "--", FOLDER];
    run_command(cargo(root, &[&build[..], &what].concat()))?;
    animate(root)
}

/// The default preset growing over the street, then the other presets over it.
fn animate(root: &Path) -> Result<(), Failure> {
    let target = Metadata::of_workspace(root)?.target_directory;
    let folder = target.join("gallery");
    let _ = fs::remove_dir_all(&folder);
    let clean = folder.join("clean");
    let shown = folder.join("shown");
    for made in [&clean, &shown] {
        fs::create_dir_all(made).map_err(|cause| Failure::of_file(made, &cause))?;
    }
    let text = |path: &Path| path.to_string_lossy().into_owned();

    starbreak(root, &["demo", "-o", &text(&folder.join("demo"))])?;
    let street = folder.join("demo/scene.png");
    for frame in 0..N_FRAMES_OF_GROWTH {
        copy(&street, &clean.join(format!("{frame:03}.png")))?;
    }
    let growth = ["--fps", &FRAMES_PER_S.to_string(), "--impact-at", "0.5"];
    let growth = [&growth[..], &["--grow", "--growth-time", "1.5"]].concat();
    let from_to = [&text(&clean), "-o", &text(&shown), "--seed", "3"];
    starbreak(root, &[&["video"], &from_to[..], &growth].concat())?;
    for (place, preset) in PRESETS.into_iter().enumerate() {
        let still = folder.join(preset);
        let what = ["--preset", preset, "--severity", "4", "--seed", "1"];
        let from_to = ["crack", &text(&street), "-o", &text(&still)];
        starbreak(root, &[&from_to[..], &what].concat())?;
        let first = N_FRAMES_OF_GROWTH + place * N_FRAMES_OF_STILL;
        for frame in first..first + N_FRAMES_OF_STILL {
            copy(
                &still.join("scene.png"),
                &shown.join(format!("{frame:03}.png")),
            )?;
        }
    }

    let mut encode = Command::new(ffmpeg(root)?);
    encode.current_dir(root);
    encode.args(["-y", "-loglevel", "error", "-framerate"]);
    encode.arg(FRAMES_PER_S.to_string()).arg("-i");
    encode.arg(shown.join("%03d.png"));
    encode.args(["-vf", "scale=1000:-2:flags=lanczos", "-c:v", "libwebp_anim"]);
    encode.args(["-quality", "80", "-loop", "0"]);
    encode.arg(Path::new(FOLDER).join(ANIMATION));
    run_command(encode)
}

/// Runs the command.
fn starbreak(root: &Path, args: &[&str]) -> Result<(), Failure> {
    let build = ["run", "--release", "--locked", "--quiet", "--package"];
    let what = ["starbreak-cli", "--"];
    run_command(cargo(root, &[&build[..], &what, args].concat()))
}

fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    fs::copy(from, to).map_err(|cause| Failure::of_file(from, &cause))?;
    Ok(())
}
