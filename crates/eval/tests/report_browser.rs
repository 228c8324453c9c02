//! The report in a browser: it renders, is dark in the dark and light on paper.
#![expect(clippy::print_stderr, reason = "a skipped test must be seen")]
#![expect(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "a test, over small made-up numbers"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use image::DynamicImage;
use starbreak_dataset::{ImageLimits, read_image};
use starbreak_eval::report::html;

use crate::plausible;

/// Where Chromium is, if it is.
fn chromium() -> Option<PathBuf> {
    let named = std::env::var_os("STARBREAK_TEST_CHROMIUM").map(PathBuf::from);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let found = || {
        std::env::split_paths(&path)
            .flat_map(|folder| names.map(|name| folder.join(name)))
            .find(|program| program.is_file())
    };
    named.or_else(found)
}

/// Runs Chromium without a window and gives what it prints.
fn browse(program: &Path, profile: &Path, page: &Path, options: &[&str]) -> String {
    let output = Command::new(program)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--no-first-run",
            "--host-resolver-rules=MAP * ~NOTFOUND",
        ])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(options)
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{program:?} {options:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn it_renders_in_light_in_the_dark_narrow_and_on_paper() {
    let Some(program) = chromium() else {
        eprintln!(
            "SKIPPED: the report in a browser: there is no chromium; install it, or name it by STARBREAK_TEST_CHROMIUM"
        );
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let profile = folder.path().join("profile");
    let page = folder.path().join("report.html");
    fs::write(&page, html(&plausible::study(&[3])).unwrap()).unwrap();

    let text = browse(&program, &profile, &page, &["--dump-dom"]);
    assert!(
        text.contains("A study with made-up numbers"),
        "the page is there"
    );
    // The page's own script has run: its hash is the one that its policy allows.
    assert!(
        text.contains("<button type=\"button\">Detector"),
        "tables can be sorted"
    );

    let shot = |name: &str, size: &str, more: &[&str]| -> DynamicImage {
        let file = folder.path().join(name);
        let mut options = vec![format!("--window-size={size}")];
        options.push(format!("--screenshot={}", file.display()));
        options.extend(more.iter().map(|one| (*one).to_owned()));
        let options: Vec<&str> = options.iter().map(String::as_str).collect();
        browse(&program, &profile, &page, &options);
        read_image(&file, &ImageLimits::default()).unwrap().pixels
    };
    let light = shot("light.png", "1000,1400", &[]);
    let dark_options = [
        "--force-dark-mode",
        "--blink-settings=preferredColorScheme=0",
    ];
    let dark = shot("dark.png", "1000,1400", &dark_options);
    let narrow = shot("narrow.png", "500,1400", &[]);
    assert_eq!(corner(&light), [255, 255, 255], "white paper");
    assert_eq!(corner(&dark), [20, 23, 26], "dark paper in the dark");
    for (name, image) in [("light", &light), ("dark", &dark), ("narrow", &narrow)] {
        let share = share_of_ink(image);
        assert!(
            (0.01..0.5).contains(&share),
            "{name}: {share} of the picture is ink"
        );
    }

    let file = folder.path().join("report.pdf");
    let print = format!("--print-to-pdf={}", file.display());
    browse(
        &program,
        &profile,
        &page,
        &[&print, "--no-pdf-header-footer"],
    );
    let pdf = fs::read(&file).unwrap();
    assert!(
        pdf.starts_with(b"%PDF") && pdf.len() > 50_000,
        "{} bytes of PDF",
        pdf.len()
    );
}

fn corner(image: &DynamicImage) -> [u8; 3] {
    image.to_rgb8().get_pixel(3, 3).0
}

/// Share of pixels that differ from the corner by much.
fn share_of_ink(image: &DynamicImage) -> f64 {
    let image = image.to_rgb8();
    let paper = image.get_pixel(3, 3).0;
    let is_ink = |pixel: &&image::Rgb<u8>| {
        let pairs = pixel.0.iter().zip(paper);
        pairs.map(|(a, b)| u32::from(a.abs_diff(b))).sum::<u32>() > 120
    };
    image.pixels().filter(is_ink).count() as f64 / f64::from(image.width() * image.height())
}
